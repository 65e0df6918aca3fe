//! The figures of the page: the paper's Fig. 6 A-C and Fig. 7, residuals, starts.

use super::fit_report::*;
use super::plot::{Axis, Chart, Mark, Shapes, palette};

const WIDE: (f64, f64) = (1000.0, 330.0);
const HALF: (f64, f64) = (490.0, 340.0);

/// Fig. 6 A: absolute force against time, measured (spread, points) and model (line).
pub(super) fn absolute_force(report: &FitReport) -> Shapes {
    let chart = Chart::new(
        "A  Force against time",
        Axis::linear("time since contact (s)"),
        Axis::linear("force (mN)"),
        WIDE,
    );
    Shapes::of(&forces(report, chart, f64::NEG_INFINITY, f64::INFINITY))
}

/// Fig. 6 B: the loading peak.
pub(super) fn loading_peak(report: &FitReport) -> String {
    let last = report.measurements.iter().map(|m| Phases::of(m).peak).fold(0.0, f64::max);
    let chart = Chart::new(
        "B  Loading and peak",
        Axis::linear("time since contact (s)").with_range(0.0, 2.2 * last.max(1e-9)),
        Axis::linear("force (mN)"),
        HALF,
    );
    forces(report, chart, -0.02 * last, 2.2 * last).to_svg()
}

fn forces(report: &FitReport, mut chart: Chart, from: f64, to: f64) -> Chart {
    for (i, m) in report.measurements.iter().enumerate() {
        let colour = palette::measurement(i);
        let phases = Phases::of(m);
        let keep: Vec<usize> = (0..m.curve.time_s.len())
            .filter(|&k| (from..=to).contains(&(m.curve.time_s[k] - phases.contact)))
            .collect();
        let pick = |v: &[f64]| -> Vec<f64> { keep.iter().map(|&k| v[k]).collect() };
        let time: Vec<f64> = keep.iter().map(|&k| m.curve.time_s[k] - phases.contact).collect();
        let (measured, model) = (pick(&m.curve.measured_mn), pick(&m.curve.model_mn));
        if let Some(spread) = &m.curve.spread_mn {
            let spread = pick(spread);
            let edge =
                |sign: f64| measured.iter().zip(&spread).map(|(f, s)| f + sign * s).collect::<Vec<_>>();
            chart = chart.with(None, colour, Mark::Band(edge(1.0)), &time, &edge(-1.0));
        }
        for specimen in &m.curve.specimens {
            chart = chart.with(None, colour, Mark::Thin, &time, &pick(&specimen.force_mn));
        }
        chart = chart
            .with(None, colour, Mark::Points, &time, &measured)
            .told(&format!("{} measured", m.curve.name))
            .with(Some(&m.curve.name), colour, Mark::Line, &time, &model)
            .told(&format!("{} model", m.curve.name));
    }
    chart
}

/// Fig. 6 C: relaxation curves, each divided by its own peak.
pub(super) fn normalised_relaxation(report: &FitReport) -> String {
    let mut chart = Chart::new(
        "C  Relaxation, normalised",
        Axis::log("time since peak (s)"),
        Axis::linear("force / peak force (-)").with_range(0.0, 1.08),
        HALF,
    );
    for (i, m) in report.measurements.iter().enumerate() {
        let peak = Phases::of(m).peak_index;
        let start = m.curve.time_s[peak];
        // A log axis that began at the first microsecond would show nothing but the plateau.
        let first = m.curve.time_s.iter().position(|t| t - start >= 1e-3).unwrap_or(peak);
        let time: Vec<f64> = m.curve.time_s[first..].iter().map(|t| t - start).collect();
        let colour = palette::measurement(i);
        let over =
            |f: &[f64], peak_force: f64| -> Vec<f64> { f[first..].iter().map(|v| v / peak_force).collect() };
        chart = chart
            .with(None, colour, Mark::Points, &time, &over(&m.curve.measured_mn, m.peak_mn.measured))
            .told(&format!("{} measured", m.curve.name))
            .with(Some(&m.curve.name), colour, Mark::Line, &time, &over(&m.curve.model_mn, m.peak_mn.model))
            .told(&format!("{} model", m.curve.name));
    }
    chart.to_svg()
}

/// Fig. 7: the model's force with its solid and fluid parts, where it has them.
pub(super) fn solid_and_fluid(report: &FitReport) -> Vec<String> {
    let draw = |m: &MeasurementResult| {
        let (solid, fluid) = (m.curve.model_solid_mn.as_ref()?, m.curve.model_fluid_mn.as_ref()?);
        let contact = Phases::of(m).contact;
        let keep: Vec<usize> =
            (0..m.curve.time_s.len()).filter(|&k| m.curve.time_s[k] > contact + 1e-9).collect();
        let pick = |v: &[f64]| -> Vec<f64> { keep.iter().map(|&k| v[k]).collect() };
        let time: Vec<f64> = keep.iter().map(|&k| m.curve.time_s[k] - contact).collect();
        let chart = Chart::new(
            &format!("{}: force and its parts", m.curve.name),
            Axis::log("time since contact (s)"),
            Axis::linear("force (mN)"),
            HALF,
        );
        let chart = chart
            .with(None, palette::GREY, Mark::Points, &time, &pick(&m.curve.measured_mn))
            .told("measured")
            .with(Some("fluid"), palette::SKY, Mark::Line, &time, &pick(fluid))
            .with(Some("solid"), palette::GREEN, Mark::Line, &time, &pick(solid))
            .with(Some("total"), palette::INK, Mark::Line, &time, &pick(&m.curve.model_mn));
        Some(chart.to_svg())
    };
    report.measurements.iter().filter_map(draw).collect()
}

/// Residuals in units of sigma (mN where sigma is unknown) against time.
pub(super) fn residuals(report: &FitReport) -> Vec<String> {
    let draw = |(i, m): (usize, &MeasurementResult)| {
        let contact = Phases::of(m).contact;
        let keep: Vec<usize> =
            (0..m.curve.time_s.len()).filter(|&k| m.curve.time_s[k] > contact + 1e-9).collect();
        let time: Vec<f64> = keep.iter().map(|&k| m.curve.time_s[k] - contact).collect();
        let known = !m.curve.sigma_mn.is_empty();
        let one = |&k: &usize| {
            let difference = m.curve.measured_mn[k] - m.curve.model_mn[k];
            if known { difference / m.curve.sigma_mn[k] } else { difference }
        };
        let values: Vec<f64> = keep.iter().map(one).collect();
        let label = if known { "measured - model (sigma)" } else { "measured - model (mN)" };
        let reach = values.iter().fold(if known { 3.0 } else { 1e-3 }, |a: f64, v| a.max(1.1 * v.abs()));
        let role = if m.curve.role == Role::Fit { "fit" } else { "validation" };
        let mut chart = Chart::new(
            &format!("{} ({role})", m.curve.name),
            Axis::log("time since contact (s)"),
            Axis::linear(label).with_range(-reach, reach),
            (490.0, 250.0),
        );
        if known {
            let n = time.len();
            chart = chart.with(None, palette::GREY, Mark::Band(vec![2.0; n]), &time, &vec![-2.0; n]);
        }
        chart
            .with_reference(0.0)
            .with(None, palette::measurement(i), Mark::Points, &time, &values)
            .told("difference")
            .to_svg()
    };
    report.measurements.iter().enumerate().map(draw).collect()
}

/// Rise of chi^2 against each profiled value, and the rise at which the interval ends.
pub(super) fn profiles(report: &FitReport) -> Vec<String> {
    let draw = |p: &ProfileRow| {
        let (x, y): (Vec<f64>, Vec<f64>) = p.points.iter().map(|[value, rise]| (*value, *rise)).unzip();
        let unit = if p.unit.is_empty() { String::new() } else { format!(" ({})", p.unit) };
        // Negative parameters by their size: a logarithm has no sign.
        let sign = if p.value < 0.0 { "-" } else { "" };
        let axis = Axis::log(&format!("{sign}{}{unit}", p.symbol));
        let sizes: Vec<f64> = x.iter().map(|v| v.abs()).collect();
        let chart =
            Chart::new(&p.symbol, axis, Axis::linear("rise of chi^2"), HALF).with_reference(p.threshold);
        let of_one_sign = x.iter().all(|v| *v != 0.0 && v.signum() == x[0].signum());
        let chart = if of_one_sign {
            chart
        } else {
            Chart { x: Axis::linear(&format!("{}{unit}", p.symbol)), ..chart }
        };
        let x = if of_one_sign { sizes } else { x };
        chart
            .with(None, palette::BLUE, Mark::Line, &x, &y)
            .with(None, palette::BLUE, Mark::Points, &x, &y)
            .told("rise")
            .to_svg()
    };
    report.profiles.iter().map(draw).collect()
}

/// chi^2 of all starts in ascending order, before and after refinement; none for a single start.
pub(super) fn waterfall(report: &FitReport) -> Option<String> {
    let mut ended: Vec<(f64, f64)> =
        report.given.starts.iter().filter_map(|s| Some((s.chi_square?, s.chi_square_start?))).collect();
    if ended.len() < 2 {
        return None;
    }
    ended.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rank: Vec<f64> = (1..=ended.len()).map(|i| i as f64).collect();
    let (end, start): (Vec<f64>, Vec<f64>) = ended.into_iter().unzip();
    let chart = Chart::new(
        "Starts, best first",
        Axis::linear("rank of the start").with_range(0.5, rank.len() as f64 + 0.5),
        Axis::log("chi^2"),
        HALF,
    );
    let chart = chart
        .with(Some("start"), palette::GREY, Mark::Points, &rank, &start)
        .with(None, palette::BLUE, Mark::Line, &rank, &end)
        .with(Some("end"), palette::BLUE, Mark::Points, &rank, &end);
    Some(chart.to_svg())
}

/// chi^2 against the iteration of the best start.
pub(super) fn convergence(report: &FitReport) -> Option<String> {
    let (number, chi_square): (Vec<f64>, Vec<f64>) =
        report.iterations.iter().map(|r| (r.iteration as f64, r.chi_square)).unzip();
    (number.len() > 1).then(|| {
        let chart =
            Chart::new("Convergence of the best start", Axis::linear("iteration"), Axis::log("chi^2"), HALF);
        chart
            .with(None, palette::BLUE, Mark::Line, &number, &chi_square)
            .with(None, palette::BLUE, Mark::Points, &number, &chi_square)
            .to_svg()
    })
}

/// Where contact and peak lie in a measurement.
struct Phases {
    /// Time at which the depth crosses zero (s).
    contact: f64,
    /// Time from contact to the largest depth (s).
    peak: f64,
    /// Index of the first point at the largest depth.
    peak_index: usize,
}

impl Phases {
    fn of(m: &MeasurementResult) -> Self {
        let (t, d) = (&m.curve.time_s, &m.curve.displacement_mm);
        let touch = d.iter().position(|&d| d > 0.0).unwrap_or(0);
        let contact = match touch {
            0 => t[0],
            k => t[k - 1] - d[k - 1] * (t[k] - t[k - 1]) / (d[k] - d[k - 1]),
        };
        // The depth's maximum, not the force's: noise must not shift the normalised curves.
        let deepest = d.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let peak_index = d.iter().position(|&d| d >= deepest - 1e-9 * deepest.abs()).unwrap_or(0);
        Self { contact, peak: t[peak_index] - contact, peak_index }
    }
}
