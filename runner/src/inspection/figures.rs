//! The figures of the inspection's page.

use super::result::*;
use crate::data::Phase;
use crate::report::plot::{Axis, Chart, Mark, Shapes, palette};

const WIDE: (f64, f64) = (1000.0, 300.0);
const HALF: (f64, f64) = (490.0, 340.0);

/// Colour behind a phase.
pub(super) fn colour(phase: Phase) -> &'static str {
    match phase {
        Phase::Approach => palette::INK,
        Phase::Ramp => palette::VERMILION,
        Phase::HoldEarly => palette::PURPLE,
        Phase::HoldMiddle => palette::SKY,
        Phase::HoldLate => palette::BLUE,
        Phase::Unload => palette::GREEN,
        Phase::Recovery => palette::GREY,
    }
}

/// When the phases of a cycle begin and end (s).
fn phases(c: &CycleInspection) -> Vec<(Phase, f64, f64)> {
    let hold = |part: f64| c.times.ramp_end_s + part * c.hold_s;
    let surface = c.times.surface_s.unwrap_or(c.times.end_s);
    let all = [
        (Phase::Approach, c.times.start_s, c.times.ramp_start_s),
        (Phase::Ramp, c.times.ramp_start_s, c.times.ramp_end_s),
        (Phase::HoldEarly, c.times.ramp_end_s, hold(0.01)),
        (Phase::HoldMiddle, hold(0.01), hold(0.1)),
        (Phase::HoldLate, hold(0.1), c.times.hold_end_s),
        (Phase::Unload, c.times.hold_end_s, surface),
        (Phase::Recovery, surface, c.times.end_s),
    ];
    all.into_iter().filter(|p| p.2 > p.1).collect()
}

fn shaded(mut chart: Chart, bands: &[(Phase, f64, f64)], (low, high): (f64, f64)) -> Chart {
    for &(phase, from, to) in bands {
        chart = chart.with(None, colour(phase), Mark::Band(vec![high; 2]), &[from, to], &[low; 2]);
    }
    chart
}

/// Range of some values with a little air.
fn range<'a>(values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |r, &v| (r.0.min(v), r.1.max(v)));
    let air = 0.05 * (high - low).max(1e-9);
    (low - air, high + air)
}

/// Points of the curve within some time (s), times counted from an origin; on a log axis only later ones.
struct Part {
    time_s: Vec<f64>,
    displacement_mm: Vec<f64>,
    force_mn: Vec<f64>,
    quartiles_mn: Option<(Vec<f64>, Vec<f64>)>,
}

fn part(curve: &PhaseCurve, from_s: f64, to_s: f64, origin_s: f64) -> Part {
    let keep: Vec<usize> =
        (0..curve.time_s.len()).filter(|&i| (from_s..=to_s).contains(&curve.time_s[i])).collect();
    let pick = |v: &[f64]| -> Vec<f64> { keep.iter().map(|&i| v[i]).collect() };
    Part {
        time_s: keep.iter().map(|&i| curve.time_s[i] - origin_s).collect(),
        displacement_mm: pick(&curve.displacement_mm),
        force_mn: pick(&curve.force_mn),
        quartiles_mn: curve.quartiles_mn.as_ref().map(|q| keep.iter().map(|&i| q[i]).unzip()),
    }
}

fn banded(chart: Chart, part: &Part, colour: &'static str) -> Chart {
    match &part.quartiles_mn {
        Some((low, high)) => chart.with(None, colour, Mark::Band(high.clone()), &part.time_s, low),
        None => chart,
    }
}

/// Displacement and force of the whole test, phases behind them.
pub(super) fn whole(test: &TestInspection) -> Vec<Shapes> {
    let curve = &test.curve;
    let bands: Vec<_> = test.cycles.iter().flat_map(phases).collect();
    let draw = |title: &str, label: &str, values: &[f64], height: f64| {
        let limits = range(values.iter());
        let axis = Axis::linear(label).with_range(limits.0, limits.1);
        let chart = Chart::new(title, Axis::linear("time (s)"), axis, (WIDE.0, height));
        Shapes::of(
            &shaded(chart, &bands, limits)
                .with(None, palette::INK, Mark::Line, &curve.time_s, values)
                .told(label),
        )
    };
    vec![
        draw("Displacement and its phases", "displacement (mm)", &curve.displacement_mm, 210.0),
        draw("Force", "force (mN)", &curve.force_mn, WIDE.1),
    ]
}

/// What was read: the force of every specimen; those that are odd, and samples that stand alone, marked.
pub(super) fn as_read(test: &TestInspection) -> Option<Shapes> {
    let curve = &test.curve;
    if curve.specimens_mn.is_empty() && curve.outliers.is_empty() {
        return None;
    }
    let limits = range(
        curve.specimens_mn.iter().flatten().chain(&curve.force_mn).chain(curve.outliers.iter().map(|o| &o.1)),
    );
    let axis = Axis::linear("force (mN)").with_range(limits.0, limits.1);
    let mut chart = Chart::new("As read: every specimen", Axis::linear("time (s)"), axis, WIDE);
    for (k, specimen) in curve.specimens_mn.iter().enumerate() {
        let name = test.specimens.get(k).cloned().unwrap_or_else(|| format!("{}", k + 1));
        let is_odd = test.odd_specimens.iter().any(|odd| odd.name == name);
        let (label, colour) =
            if is_odd { (Some(name.as_str()), palette::VERMILION) } else { (None, palette::GREY) };
        chart = chart.with(label, colour, Mark::Line, &curve.time_s, specimen).told(&name);
    }
    chart = chart.with(None, palette::INK, Mark::Line, &curve.time_s, &curve.force_mn).told("median");
    let (time_s, force_mn): (Vec<f64>, Vec<f64>) = curve.outliers.iter().copied().unzip();
    if !time_s.is_empty() {
        chart = chart.with(Some("outliers"), palette::VERMILION, Mark::Points, &time_s, &force_mn);
    }
    Some(Shapes::of(&chart))
}

fn force_axis((low, high): (f64, f64)) -> Axis {
    Axis::linear("force (mN)").with_range(low, high)
}

/// Loading of the first cycle, phases behind it.
pub(super) fn loading(test: &TestInspection) -> Option<String> {
    let c = test.cycles.first()?;
    let ramp = c.times.ramp_end_s - c.times.ramp_start_s;
    let (from, to) =
        ((c.times.ramp_start_s - 0.25 * ramp).max(c.times.start_s), c.times.ramp_end_s + 0.75 * ramp);
    let part = part(&test.curve, from, to, c.times.ramp_start_s);
    let quartiles = part.quartiles_mn.iter().flat_map(|(a, b)| a.iter().chain(b));
    let limits = range(part.force_mn.iter().chain(quartiles));
    let axis = Axis::linear("time since the surface was passed (s)")
        .with_range(from - c.times.ramp_start_s, to - c.times.ramp_start_s);
    let mut chart = Chart::new("Loading of cycle 1", axis, force_axis(limits), HALF);
    let bands: Vec<_> = phases(c)
        .into_iter()
        .map(|(p, a, b)| (p, a.max(from) - c.times.ramp_start_s, b.min(to) - c.times.ramp_start_s))
        .filter(|b| b.2 > b.1)
        .collect();
    chart = banded(shaded(chart, &bands, limits), &part, palette::INK);
    Some(
        chart
            .with_reference(0.0)
            .with(None, palette::INK, Mark::Points, &part.time_s, &part.force_mn)
            .to_svg(),
    )
}

/// Holds of all cycles over each other, in logarithmic time, thirds behind them.
pub(super) fn holds(test: &TestInspection) -> Option<String> {
    let first = test.cycles.first()?;
    let parts: Vec<Part> = test
        .cycles
        .iter()
        .map(|c| {
            part(&test.curve, c.times.ramp_end_s + 1e-4 * c.hold_s, c.times.hold_end_s, c.times.ramp_end_s)
        })
        .collect();
    let quartiles = parts.first()?.quartiles_mn.iter().flat_map(|(a, b)| a.iter().chain(b));
    let limits = range(parts.iter().flat_map(|p| &p.force_mn).chain(quartiles));
    let start = parts.iter().filter_map(|p| p.time_s.first()).copied().fold(f64::INFINITY, f64::min);
    // A hold between two samples has no curve.
    if start >= first.hold_s {
        return None;
    }
    let axis = Axis::log("time since the end of the ramp (s)").with_range(start, first.hold_s);
    let chart = Chart::new("Holds of all cycles", axis, force_axis(limits), HALF);
    let bands: Vec<_> = phases(first)
        .into_iter()
        .filter(|b| b.1 >= first.times.ramp_end_s && b.2 <= first.times.hold_end_s)
        .map(|(p, a, b)| (p, (a - first.times.ramp_end_s).max(start), b - first.times.ramp_end_s))
        .filter(|b| b.2 > b.1)
        .collect();
    let chart = banded(shaded(chart, &bands, limits), parts.first()?, palette::INK);
    Some(overlaid(chart, &parts, |p| (&p.time_s, &p.force_mn)).to_svg())
}

/// Loadings of all cycles over each other, against displacement.
pub(super) fn loadings(test: &TestInspection) -> Option<String> {
    let parts: Vec<Part> = test
        .cycles
        .iter()
        .map(|c| part(&test.curve, c.times.start_s, c.times.ramp_end_s + 1e-6 * c.hold_s, 0.0))
        .collect();
    let lowest = parts.first()?.displacement_mm.first().copied().unwrap_or(0.0);
    let axis =
        Axis::linear("displacement (mm)").with_range(lowest.min(0.0), test.cycles.first()?.depth_mm * 1.02);
    let chart =
        Chart::new("Loadings of all cycles", axis, Axis::linear("force (mN)"), HALF).with_reference(0.0);
    Some(overlaid(chart, &parts, |p| (&p.displacement_mm, &p.force_mn)).to_svg())
}

/// The first cycle in ink, the last in vermilion, those between pale: order shows without a legend of six colours.
fn overlaid<'a>(
    mut chart: Chart,
    parts: &'a [Part],
    xy: impl Fn(&'a Part) -> (&'a Vec<f64>, &'a Vec<f64>),
) -> Chart {
    let last = parts.len() - 1;
    // Those between lie behind.
    let order = (1..last).chain([last, 0]).filter(|&k| k <= last);
    let mut drawn = Vec::new();
    for k in order {
        if drawn.contains(&k) {
            continue;
        }
        drawn.push(k);
        let colour = if k == 0 {
            palette::INK
        } else if k == last {
            palette::VERMILION
        } else {
            palette::SKY
        };
        let label = (k == 0 || k == last).then(|| (k + 1).to_string());
        let (x, y) = xy(&parts[k]);
        chart = chart.with(label.as_deref(), colour, Mark::Line, x, y);
    }
    chart
}

/// Autocorrelation of the force off contact, with what noise of independent samples gives and the fitted noise.
pub(super) fn autocorrelation(test: &TestInspection) -> Option<String> {
    let bins = &test.noise.autocorrelation;
    if bins.len() < 3 {
        return None;
    }
    let lags: Vec<f64> = bins.iter().map(|b| b.lag_s).collect();
    let chance: Vec<f64> = bins.iter().map(|b| 2.0 / (b.pairs as f64).sqrt()).collect();
    let values: Vec<f64> = bins.iter().map(|b| b.correlation).collect();
    let reach = values.iter().chain(&chance).fold(0.1, |a: f64, v| a.max(1.1 * v.abs())).min(1.0);
    let low: Vec<f64> = chance.iter().map(|c| -c).collect();
    let mut chart = Chart::new(
        "Autocorrelation off contact",
        Axis::log("lag (s)"),
        Axis::linear("correlation (-)").with_range(-reach, reach),
        HALF,
    )
    .with_reference(0.0)
    .with(None, palette::GREY, Mark::Band(chance), &lags, &low);
    let n = &test.noise;
    if let (Some(white), Some(amplitude), Some(time)) =
        (n.white_mn, n.correlated.correlated_mn, n.correlated.correlation_time_s)
    {
        let share = amplitude.value.powi(2) / (amplitude.value.powi(2) + white.value.powi(2));
        let model: Vec<f64> = lags.iter().map(|lag| share * (-lag / time.value).exp()).collect();
        chart = chart.with(Some("fitted"), palette::VERMILION, Mark::Line, &lags, &model);
    }
    Some(chart.with(None, palette::BLUE, Mark::Points, &lags, &values).to_svg())
}

/// Peaks and ends of hold of all tests against the cycle; none for single cycles.
pub(super) fn by_cycle(inspection: &Inspection) -> Vec<String> {
    let most = inspection.tests.iter().map(|t| t.cycles.len()).max().unwrap_or(0);
    if most < 2 {
        return vec![];
    }
    type Read = fn(&CycleInspection) -> crate::data::Quartiles;
    let draw = |title: &str, read: Read| {
        let axis = Axis::linear("cycle").with_range(0.8, most as f64 + 0.2);
        let mut chart = Chart::new(title, axis, Axis::linear("force (mN)"), HALF);
        for (i, test) in inspection.tests.iter().enumerate() {
            let colour = crate::report::plot::palette::measurement(i);
            let x: Vec<f64> = test.cycles.iter().map(|c| c.times.number as f64).collect();
            let pick = |f: fn(crate::data::Quartiles) -> f64| {
                test.cycles.iter().map(|c| f(read(c))).collect::<Vec<f64>>()
            };
            let median = pick(|q| q.median);
            if test.specimens.len() > 1 {
                chart = chart.with(None, colour, Mark::Band(pick(|q| q.q75)), &x, &pick(|q| q.q25));
            }
            chart = chart.with(None, colour, Mark::Line, &x, &median).with(
                Some(&test.name),
                colour,
                Mark::Points,
                &x,
                &median,
            );
        }
        chart.to_svg()
    };
    vec![
        draw("Peak force by cycle", |c| c.peak_mn),
        draw("Force at the end of the hold by cycle", |c| c.hold_end_mn),
    ]
}
