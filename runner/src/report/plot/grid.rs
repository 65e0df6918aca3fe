//! Small multiples of rectangles: the correlation heat map and the interval bars of the parameter table.

use super::scale::{Scale, ScaleKind};
use super::{escape, palette, pretty};
use std::fmt::Write;

const CELL: f64 = 46.0;
const MARGIN: f64 = 52.0;

/// Matrix of correlations in [-1, 1] with their values in the cells; lower triangle.
pub fn heat_map(symbols: &[String], matrix: &[Vec<f64>]) -> String {
    let n = symbols.len() as f64;
    let (width, height) = (MARGIN + n * CELL + 4.0, n * CELL + 34.0);
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" class="cells" font-family="Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif" font-size="12"><title>correlation of the parameters</title>"#
    );
    for (i, symbol) in symbols.iter().enumerate() {
        let label = escape(&pretty(symbol));
        let at = (i as f64 + 0.5) * CELL;
        let _ = write!(
            svg,
            r#"<text x="{}" y="{}" text-anchor="end" fill="{ink}">{label}</text><text x="{}" y="{}" text-anchor="middle" fill="{ink}">{label}</text>"#,
            MARGIN - 8.0,
            at + 4.0,
            MARGIN + at,
            n * CELL + 18.0,
            ink = palette::INK
        );
        for (j, &value) in matrix[i].iter().enumerate().take(i + 1) {
            let text = if i == j { String::new() } else { short(value) };
            let ink = if value.abs() > 0.6 && i != j { "white" } else { palette::INK };
            let _ = write!(
                svg,
                r#"<rect x="{x}" y="{y}" width="{s}" height="{s}" rx="3" fill="{fill}"/><text x="{tx}" y="{ty}" text-anchor="middle" font-size="11" fill="{ink}">{text}</text>"#,
                x = MARGIN + j as f64 * CELL + 1.0,
                y = i as f64 * CELL + 1.0,
                s = CELL - 2.0,
                fill = if i == j { palette::FAINT.to_owned() } else { diverging(value) },
                tx = MARGIN + (j as f64 + 0.5) * CELL,
                ty = at + 4.0,
            );
        }
    }
    svg.push_str("</svg>");
    svg
}

/// `−1.000` where rounding to two digits would hide that it is not quite 1, two digits elsewhere.
fn short(value: f64) -> String {
    let digits = if value.abs() > 0.985 { 3 } else { 2 };
    let text = format!("{value:.digits$}");
    if text == "-0.00" { "0.00".to_owned() } else { text.replace('-', "−") }
}

/// White at 0, blue at -1, vermilion at 1.
fn diverging(value: f64) -> String {
    let end = if value < 0.0 { [0x00, 0x72, 0xb2] } else { [0xd5, 0x5e, 0x00] };
    let t = value.abs().min(1.0);
    let mix = |c: i32| (255.0 + t * (f64::from(c) - 255.0)).round() as i32;
    format!("rgb({},{},{})", mix(end[0]), mix(end[1]), mix(end[2]))
}

/// Interval (bar) and value (tick) within the bounds (track), by magnitude on a log scale where the sign is
/// fixed. An open end of the interval is drawn up to the bound, paler.
pub fn interval_bar(value: f64, interval: (f64, f64), bounds: (f64, f64), determined: bool) -> String {
    let log = bounds.0 * bounds.1 > 0.0;
    let (kind, flip) = if log { (ScaleKind::Log, bounds.1 < 0.0) } else { (ScaleKind::Linear, false) };
    let magnitude = |v: f64| if flip { -v } else { v };
    let order = |(a, b): (f64, f64)| {
        let (a, b) = (magnitude(a), magnitude(b));
        (a.min(b), a.max(b))
    };
    let scale = Scale::new(kind, order(bounds), (2.0, 158.0));
    let (low, high) = order(interval);
    let (a, b) = (scale.place_clamped(low), scale.place_clamped(high));
    let colour = if determined { palette::BLUE } else { palette::VERMILION };
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 160 16" width="160" height="16" role="img" class="bar"><title>interval within the bounds</title><rect x="2" y="7" width="156" height="2" fill="#d5d9de"/><rect x="{a:.1}" y="5" width="{w:.1}" height="6" rx="3" fill="{colour}" fill-opacity="0.45"/><rect x="{v:.1}" y="2" width="2.4" height="12" fill="{colour}"/></svg>"##,
        w = (b - a).max(2.0),
        v = scale.place_clamped(magnitude(value)) - 1.2,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_map_shows_the_lower_triangle_with_enough_digits() {
        let symbols = ["mu_1".to_owned(), "alpha_1".to_owned()];
        let svg = heat_map(&symbols, &[vec![1.0, -0.99996], vec![-0.99996, 1.0]]);
        assert_eq!(svg.matches("<rect").count(), 3);
        assert!(svg.contains("−1.000") && svg.contains("μ₁"));
        assert_eq!(diverging(0.0), "rgb(255,255,255)");
    }

    #[test]
    fn bars_of_negative_parameters_grow_with_magnitude() {
        let svg = interval_bar(-10.0, (-100.0, -1.0), (-1000.0, -1.0), true);
        // ln 10 / ln 1000 of the track.
        assert!(svg.contains(&format!(r#"<rect x="{:.1}" y="2""#, 2.0 + 156.0 / 3.0 - 1.2)), "{svg}");
    }
}
