//! The posterior sample in the report: its numbers, `posterior.csv`, and the corner plot.

use super::plot::{escape, palette, pretty};
use crate::inference::posterior::{Method, Posterior};
use crate::inference::wording::significant;
use maud::{Markup, PreEscaped, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// What is known of all values together: draws from the posterior, in the units that stand beside them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PosteriorReport {
    /// How the draws were made.
    pub method: Method,
    /// Shape of the tail of the importance weights; absent where too few draws had a weight.
    pub pareto_k_hat: Option<f64>,
    /// Independent draws that these are worth.
    pub effective_draws: f64,
    /// Trajectories of NUTS that failed.
    pub divergent: usize,
    /// The same in words.
    pub summary: String,
    /// The values.
    pub values: Vec<PosteriorRow>,
    /// Draws of equal weight, a value for each of `values`.
    pub draws: Vec<Vec<f64>>,
}

/// One value's share of the posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PosteriorRow {
    /// Full name.
    pub name: String,
    /// Short symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Median.
    pub median: f64,
    /// 2.5 % quantile.
    pub lower: f64,
    /// 97.5 % quantile.
    pub upper: f64,
}

impl From<&Posterior> for PosteriorReport {
    fn from(posterior: &Posterior) -> Self {
        let row = |(j, term): (usize, &crate::inference::FitParameter)| {
            let at = |p: f64| term.unit.from_si(posterior.quantile(j, p));
            let (name, symbol, unit) = (term.name.clone(), term.symbol.clone(), term.unit.name.clone());
            PosteriorRow { name, symbol, unit, median: at(0.5), lower: at(0.025), upper: at(0.975) }
        };
        let shown = |draw: &Vec<f64>| {
            draw.iter().zip(&posterior.terms).map(|(value, term)| term.unit.from_si(*value)).collect()
        };
        let s = &posterior.sample;
        Self {
            method: s.method,
            pareto_k_hat: s.k_hat.is_finite().then_some(s.k_hat),
            effective_draws: s.effective,
            divergent: s.divergent,
            summary: posterior.in_words(),
            values: posterior.terms.iter().enumerate().map(row).collect(),
            draws: posterior.draws.iter().map(shown).collect(),
        }
    }
}

/// The draws, one per line: `posterior.csv`.
pub fn posterior_csv(posterior: &PosteriorReport) -> String {
    let unit = |unit: &str| if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    let names: Vec<String> =
        posterior.values.iter().map(|v| format!("{}{}", v.symbol, unit(&v.unit))).collect();
    let mut out = names.join(",") + "\n";
    for draw in &posterior.draws {
        let cells: Vec<String> = draw.iter().map(|v| format!("{v:.6e}")).collect();
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// The section of the page.
pub(super) fn section(posterior: &PosteriorReport) -> Markup {
    html! {
        h2 { "Posterior" }
        p { (posterior.summary) "." }
        (PreEscaped(corner(posterior)))
        p.caption {
            "Each dot is a draw; on the diagonal the distribution of one value, above it its median and the range of 95 % of the draws. \
             Axes are logarithmic, of the size where a value is negative. All draws stand in posterior.csv."
        }
    }
}

const CELL: f64 = 78.0;
const GAP: f64 = 6.0;
const TOP: f64 = 34.0;
const BINS: usize = 16;
/// Draws that are drawn: more only blacken the page.
const DOTS: usize = 200;

/// Every pair of values, and the histogram of each.
pub fn corner(posterior: &PosteriorReport) -> String {
    let n = posterior.values.len();
    let size = n as f64 * (CELL + GAP) + GAP;
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {h}" style="max-width:100%" role="img" font-family="Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif" font-size="10"><title>posterior: every pair of values</title>"#,
        h = size + TOP
    );
    let columns: Vec<Vec<f64>> = (0..n).map(|j| unit_range(posterior, j)).collect();
    let place = |k: usize| GAP + k as f64 * (CELL + GAP);
    for (i, value) in posterior.values.iter().enumerate() {
        let (x, y) = (place(i), place(i) + TOP);
        let label = escape(&pretty(&value.symbol));
        let range = format!(
            "{} [{}, {}]",
            significant(value.median, 3),
            significant(value.lower, 2),
            significant(value.upper, 2)
        );
        let _ = write!(
            svg,
            r#"<text x="{x}" y="{}" fill="{}" font-weight="bold">{label} <tspan font-weight="normal" fill="{}">{}</tspan></text><text x="{x}" y="{}" fill="{}" font-size="9">{}</text>"#,
            y - 16.0,
            palette::INK,
            palette::GREY,
            escape(&pretty(&value.unit)),
            y - 5.0,
            palette::GREY,
            escape(&pretty(&range)),
        );
        frame(&mut svg, x, y);
        histogram(&mut svg, &columns[i], x, y);
        for (j, other) in columns.iter().enumerate().take(i) {
            let x = place(j);
            frame(&mut svg, x, y);
            let step = (other.len() / DOTS).max(1);
            for (a, b) in other.iter().zip(&columns[i]).step_by(step) {
                let (cx, cy) = (x + a * CELL, y + (1.0 - b) * CELL);
                let _ = write!(
                    svg,
                    r#"<circle cx="{cx:.1}" cy="{cy:.1}" r="1" fill="{}" fill-opacity="0.5"/>"#,
                    palette::BLUE
                );
            }
        }
    }
    svg.push_str("</svg>");
    svg
}

/// The draws of a value between its smallest (0) and largest (1), on a logarithmic scale where they have one sign.
fn unit_range(posterior: &PosteriorReport, j: usize) -> Vec<f64> {
    let values: Vec<f64> = posterior.draws.iter().map(|d| d[j]).collect();
    let of_one_sign = values.iter().all(|v| *v > 0.0) || values.iter().all(|v| *v < 0.0);
    let scaled: Vec<f64> = values.iter().map(|v| if of_one_sign { v.abs().ln() } else { *v }).collect();
    let low = scaled.iter().copied().fold(f64::INFINITY, f64::min);
    let high = scaled.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    scaled.iter().map(|v| if high > low { (v - low) / (high - low) } else { 0.5 }).collect()
}

fn frame(svg: &mut String, x: f64, y: f64) {
    let _ = write!(
        svg,
        r#"<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="none" stroke="{}"/>"#,
        palette::FAINT
    );
}

fn histogram(svg: &mut String, values: &[f64], x: f64, y: f64) {
    let mut counts = [0usize; BINS];
    values.iter().for_each(|v| counts[((v * BINS as f64) as usize).min(BINS - 1)] += 1);
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let width = CELL / BINS as f64;
    for (k, count) in counts.iter().enumerate() {
        let height = 0.95 * CELL * *count as f64 / most;
        let _ = write!(
            svg,
            r#"<rect x="{:.1}" y="{:.1}" width="{width:.1}" height="{height:.1}" fill="{}"/>"#,
            x + k as f64 * width,
            y + CELL - height,
            palette::SKY
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> PosteriorReport {
        let row = |name: &str, unit: &str, median: f64| PosteriorRow {
            name: name.into(),
            symbol: name.into(),
            unit: unit.into(),
            median,
            lower: 0.5 * median,
            upper: 2.0 * median,
        };
        PosteriorReport {
            method: Method::Importance,
            pareto_k_hat: Some(0.2),
            effective_draws: 80.0,
            divergent: 0,
            summary: "100 draws".into(),
            values: vec![row("G_1", "Pa", 100.0), row("alpha_1", "", -3.0)],
            draws: (0..100).map(|i| vec![100.0 + f64::from(i), -3.0 - 0.01 * f64::from(i)]).collect(),
        }
    }

    #[test]
    fn the_table_names_values_with_their_units() {
        let text = posterior_csv(&report());
        assert!(text.starts_with("G_1 [Pa],alpha_1\n1.000000e2,-3.000000e0\n"), "{}", &text[..60]);
        assert_eq!(text.lines().count(), 101);
    }

    #[test]
    fn the_corner_plot_has_a_histogram_for_each_value_and_dots_for_each_pair() {
        let svg = corner(&report());
        assert_eq!(svg.matches("<circle").count(), 100);
        assert_eq!(svg.matches("<rect").count(), 3 + 2 * BINS);
        assert!(!svg.contains("NaN") && svg.ends_with("</svg>"));
    }
}
