//! The plot that `simulate` writes.

use crate::pool::ForceCurve;
use crate::report::plot::{Axis, Chart, Mark, palette};

/// Force against time, with its solid and fluid parts where they were recorded.
pub fn force_plot(name: &str, curve: &ForceCurve) -> String {
    let milli = |values: &[f64]| values.iter().map(|v| v * 1e3).collect::<Vec<f64>>();
    let mut chart = Chart::new(
        &format!("{name}: force on the punch"),
        Axis::linear("time (s)"),
        Axis::linear("force (mN)"),
        (760.0, 420.0),
    );
    for (output, label, colour) in
        [("force_fluid", "fluid", palette::SKY), ("force_solid", "solid", palette::GREEN)]
    {
        if let Some(values) = curve.output(output) {
            chart = chart.with(Some(label), colour, Mark::Line, &curve.time_s, &milli(values));
        }
    }
    let force = milli(curve.force_n());
    chart.with(Some("total"), palette::INK, Mark::Line, &curve.time_s, &force).to_svg()
}
