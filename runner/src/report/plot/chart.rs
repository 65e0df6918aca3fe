//! Curves, points and bands over two axes, labelled directly.

use super::scale::{Scale, ScaleKind};
use super::{escape, palette, pretty};
use std::fmt::Write;

/// An axis: what, in which unit, on what scale.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    /// Quantity and unit, e.g. `force (mN)`.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: ScaleKind,
    /// Range; from the data if `None`.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis over the range of the data.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), ..Self::default() }
    }

    /// A logarithmic axis over the range of the data.
    pub fn log(label: &str) -> Self {
        Self { label: label.to_owned(), scale: ScaleKind::Log, range: None }
    }

    /// The same axis with a fixed range.
    #[must_use]
    pub fn with_range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }
}

/// How a series is drawn.
#[derive(Debug, Clone)]
pub enum Mark {
    /// A line.
    Line,
    /// A thin, pale line, one of many.
    Thin,
    /// A dashed line.
    Dashed,
    /// Open circles.
    Points,
    /// The area up to these upper values.
    Band(Vec<f64>),
}

/// One set of values.
#[derive(Debug, Clone)]
pub struct Series {
    /// Written at the end of the curve; none for series that the caption explains.
    pub label: Option<String>,
    /// What a reader who points at it is told; the label where there is none.
    pub told: Option<String>,
    /// Colour, e.g. from [`palette`].
    pub colour: &'static str,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates (lower ones, for a band).
    pub y: Vec<f64>,
    /// How it is drawn.
    pub mark: Mark,
}

/// A figure with one pair of axes.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Width and height in pixels.
    pub size: (f64, f64),
    /// What is drawn, from back to front.
    pub series: Vec<Series>,
    /// Horizontal reference lines.
    pub reference: Vec<f64>,
}

const LEFT: f64 = 58.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 46.0;

impl Chart {
    /// An empty chart.
    pub fn new(title: &str, x: Axis, y: Axis, size: (f64, f64)) -> Self {
        Self { title: title.to_owned(), x, y, size, series: vec![], reference: vec![] }
    }

    /// Adds a series.
    #[must_use]
    pub fn with(
        mut self,
        label: Option<&str>,
        colour: &'static str,
        mark: Mark,
        x: &[f64],
        y: &[f64],
    ) -> Self {
        let label = label.map(str::to_owned);
        self.series.push(Series { label, told: None, colour, x: x.to_vec(), y: y.to_vec(), mark });
        self
    }

    /// Tells a reader who points at the last series what it is.
    #[must_use]
    pub fn told(mut self, text: &str) -> Self {
        if let Some(series) = self.series.last_mut() {
            series.told = Some(text.to_owned());
        }
        self
    }

    /// Adds a horizontal reference line.
    #[must_use]
    pub fn with_reference(mut self, y: f64) -> Self {
        self.reference.push(y);
        self
    }

    /// The figure as an `<svg>` element, complete in itself.
    pub fn to_svg(&self) -> String {
        let (width, height) = self.size;
        let longest = self.series.iter().filter_map(|s| s.label.as_ref()).map(|l| pretty(l).chars().count());
        let right = 14.0 + 6.6 * longest.max().unwrap_or(0) as f64;
        let x_range = self.x.range.unwrap_or_else(|| self.extent(true));
        let y_range = self.y.range.unwrap_or_else(|| padded(self.y.scale, self.extent(false)));
        let x = Scale::new(self.x.scale, x_range, (LEFT, width - right));
        let y = Scale::new(self.y.scale, y_range, (height - BOTTOM, TOP));
        let frame = Frame { left: LEFT, right: width - right, top: TOP, bottom: height - BOTTOM };

        let mut svg = String::new();
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" class="chart" data-x="{}" data-y="{}" font-family="Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif" font-size="12"><title>{2}</title><text class="title" x="{LEFT}" y="18" font-weight="600" font-size="13" fill="{ink}">{2}</text>"#,
            x.told(),
            y.told(),
            escape(&pretty(&self.title)),
            ink = palette::INK,
        );
        svg.push_str(r#"<g class="axes">"#);
        self.draw_axes(&mut svg, &x, &y, &frame);
        svg.push_str(r#"</g><g class="plot">"#);
        for series in &self.series {
            let told = series.told.as_ref().or(series.label.as_ref());
            let told = told.map(|t| format!(r#" data-told="{}""#, escape(&pretty(t)))).unwrap_or_default();
            let _ = write!(svg, "<g{told}>");
            draw_series(&mut svg, series, &x, &y);
            svg.push_str("</g>");
        }
        svg.push_str("</g>");
        self.draw_labels(&mut svg, &x, &y, &frame);
        svg.push_str("</svg>");
        svg
    }

    fn extent(&self, horizontal: bool) -> (f64, f64) {
        let (axis, mut low, mut high) =
            (if horizontal { &self.x } else { &self.y }, f64::INFINITY, f64::NEG_INFINITY);
        for series in &self.series {
            let upper: &[f64] = if let Mark::Band(upper) = &series.mark { upper } else { &[] };
            let values =
                if horizontal { series.x.iter().chain([].iter()) } else { series.y.iter().chain(upper) };
            for &v in values.filter(|v| v.is_finite() && (axis.scale == ScaleKind::Linear || **v > 0.0)) {
                (low, high) = (low.min(v), high.max(v));
            }
        }
        match (low < high, axis.scale) {
            (true, _) => (low, high),
            (false, ScaleKind::Log) if low.is_finite() => (0.5 * low, 2.0 * low),
            (false, _) if low.is_finite() => (low - 1.0, low + 1.0),
            (false, _) => (0.1, 1.0),
        }
    }

    fn draw_axes(&self, svg: &mut String, x: &Scale, y: &Scale, f: &Frame) {
        let (grey, faint, ink) = (palette::GREY, palette::FAINT, palette::INK);
        for (value, label) in y.ticks() {
            let Some(at) = y.place(value) else { continue };
            if let Some(label) = label {
                let _ = write!(
                    svg,
                    r#"<line x1="{}" x2="{}" y1="{at:.1}" y2="{at:.1}" stroke="{faint}"/><text x="{}" y="{:.1}" text-anchor="end" fill="{grey}">{label}</text>"#,
                    f.left,
                    f.right,
                    f.left - 7.0,
                    at + 4.0
                );
            }
        }
        for (value, label) in x.ticks() {
            let Some(at) = x.place(value) else { continue };
            let length = if label.is_some() { 5.0 } else { 3.0 };
            let _ = write!(
                svg,
                r#"<line x1="{at:.1}" x2="{at:.1}" y1="{}" y2="{}" stroke="{grey}"/>"#,
                f.bottom,
                f.bottom + length
            );
            if let Some(label) = label {
                let _ = write!(
                    svg,
                    r#"<text x="{at:.1}" y="{}" text-anchor="middle" fill="{grey}">{label}</text>"#,
                    f.bottom + 18.0
                );
            }
        }
        for &value in &self.reference {
            if let Some(at) = y.place(value) {
                let _ = write!(
                    svg,
                    r#"<line x1="{}" x2="{}" y1="{at:.1}" y2="{at:.1}" stroke="{grey}"/>"#,
                    f.left, f.right
                );
            }
        }
        let _ = write!(
            svg,
            r#"<line x1="{l}" x2="{r}" y1="{b}" y2="{b}" stroke="{grey}"/><text x="{mx}" y="{xy}" text-anchor="middle" fill="{ink}">{xl}</text><text transform="translate(14 {my}) rotate(-90)" text-anchor="middle" fill="{ink}">{yl}</text>"#,
            l = f.left,
            r = f.right,
            b = f.bottom,
            mx = 0.5 * (f.left + f.right),
            xy = f.bottom + 37.0,
            my = 0.5 * (f.top + f.bottom),
            xl = escape(&pretty(&self.x.label)),
            yl = escape(&pretty(&self.y.label)),
        );
    }

    /// Labels at the right end of their curves, moved apart where they would overlap.
    fn draw_labels(&self, svg: &mut String, x: &Scale, y: &Scale, f: &Frame) {
        let mut labels: Vec<(f64, &str, &str)> = vec![];
        for series in &self.series {
            let Some(label) = &series.label else { continue };
            let last =
                series.x.iter().zip(&series.y).rev().find(|(a, b)| x.place(**a).is_some() && b.is_finite());
            if let Some((_, value)) = last {
                labels.push((y.place_clamped(*value), label, series.colour));
            }
        }
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 1..labels.len() {
            labels[i].0 = labels[i].0.max(labels[i - 1].0 + 14.0);
        }
        let overflow = labels.last().map_or(0.0, |l| (l.0 - f.bottom).max(0.0));
        for (at, label, colour) in labels {
            let _ = write!(
                svg,
                r#"<text x="{:.1}" y="{:.1}" fill="{colour}" font-weight="600">{}</text>"#,
                f.right + 6.0,
                at + 4.0 - overflow,
                escape(&pretty(label))
            );
        }
    }
}

/// A figure over the whole width of a page, and for a narrow one, where its letters would become too small.
#[derive(Debug, Clone)]
pub struct Shapes {
    /// As it was asked for.
    pub wide: String,
    /// Half as wide.
    pub narrow: String,
}

impl Shapes {
    /// Both shapes of a chart.
    pub fn of(chart: &Chart) -> Self {
        const NARROW: (f64, f64) = (490.0, 340.0);
        Self { wide: chart.to_svg(), narrow: Chart { size: NARROW, ..chart.clone() }.to_svg() }
    }
}

struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// A little air above and below.
fn padded(kind: ScaleKind, (low, high): (f64, f64)) -> (f64, f64) {
    match kind {
        ScaleKind::Linear => (low - 0.04 * (high - low), high + 0.06 * (high - low)),
        ScaleKind::Log => (low / (high / low).powf(0.06), high * (high / low).powf(0.06)),
    }
}

fn draw_series(svg: &mut String, series: &Series, x: &Scale, y: &Scale) {
    let colour = series.colour;
    let place = |values: &[f64]| -> Vec<(f64, f64)> {
        let points = series.x.iter().zip(values).filter(|(_, v)| v.is_finite());
        points.filter_map(|(&a, &b)| Some((x.place(a)?, y.place_clamped(b)))).collect()
    };
    let path = |points: &[(f64, f64)]| {
        points.iter().map(|(a, b)| format!("{a:.2},{b:.2}")).collect::<Vec<_>>().join(" ")
    };
    let points = place(&series.y);
    let _ = match &series.mark {
        Mark::Thin => write!(
            svg,
            r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-opacity="0.3" stroke-width="0.8"/>"#,
            path(&points)
        ),
        Mark::Line | Mark::Dashed => {
            let dash = if matches!(series.mark, Mark::Dashed) { r#" stroke-dasharray="5 4""# } else { "" };
            write!(
                svg,
                r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.8" stroke-linejoin="round"{dash}/>"#,
                path(&points)
            )
        }
        Mark::Points => {
            let _ = write!(svg, r#"<g fill="white" stroke="{colour}" stroke-width="1.1">"#);
            let radius = if points.len() > 120 { 1.8 } else { 2.3 };
            for (a, b) in points {
                let _ = write!(svg, r#"<circle cx="{a:.2}" cy="{b:.2}" r="{radius}"/>"#);
            }
            write!(svg, "</g>")
        }
        Mark::Band(upper) => {
            let mut outline = points;
            outline.extend(place(upper).into_iter().rev());
            write!(svg, r#"<polygon points="{}" fill="{colour}" fill-opacity="0.14"/>"#, path(&outline))
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_its_series_labels_and_units() {
        let x = [0.1, 1.0, 10.0];
        let svg = Chart::new("A < B", Axis::log("time (s)"), Axis::linear("force (mN)"), (400.0, 300.0))
            .with(None, palette::BLUE, Mark::Band(vec![2.0, 3.0, 4.0]), &x, &[0.0, 1.0, 2.0])
            .with(Some("G_inf"), palette::BLUE, Mark::Line, &x, &[1.0, 2.0, f64::NAN])
            .with(Some("P2"), palette::VERMILION, Mark::Points, &x, &[1.0, 2.0, 3.0])
            .to_svg();
        for part in ["A &lt; B", "force (mN)", ">G∞<", "<polygon", "<polyline"] {
            assert!(svg.contains(part), "{part} missing in {svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn an_empty_chart_is_still_a_picture() {
        let svg = Chart::new("", Axis::log("t"), Axis::linear("F"), (100.0, 100.0)).to_svg();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>") && !svg.contains("NaN"));
    }
}
