//! What a gap looks like that no effect explains: with what it goes, when it begins or how it repeats, whether it is there off contact,
//! and in which specimens.
//!
//! Each description is a shape (or two) in each test whose part that no refit absorbs is fitted to the residual, as an effect's signature
//! is, in all tests or in one. Told is the one that lowers chi^2 most, less twice the logarithm of the number of descriptions of its
//! kind, and less the logarithm of the number of points for each free size.

mod trials;

use crate::inference::fit::Fit;
use crate::noise::Observation;
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trials::{Part, Shapes, Trial, parts, trials};

/// Largest mean square of a specimen's own residual over the median of all that passes as the others'.
const OUTSTANDING: f64 = 3.0;
/// Score of what is left off contact that noise passes in one of a thousand cases.
const OFF_CONTACT: f64 = 3.3;
/// A shape that takes less of a gap is no description of it, and told as such.
const MOSTLY: f64 = 0.5;
/// A shape is absorbed by a refit where less of it than one minus this is left.
const ABSORBED: f64 = 1.0 - 1e-6;
/// Shapes of length 1 whose difference is shorter than about the root of this are one.
const SAME: f64 = 1e-8;

/// With what the gap goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "with")]
pub enum Course {
    /// It grows with the time since the test began.
    Clock,
    /// It goes as if the clock of the force ran at another rate.
    ClockRate,
    /// It is there from this time on (s).
    Step {
        /// Its beginning (s).
        from_s: f64,
    },
    /// It repeats.
    Period {
        /// Its period (s).
        period_s: f64,
    },
    /// It swings after the ends of the ramps, and dies away.
    Ringing {
        /// Its period (s).
        period_s: f64,
    },
    /// It goes with the depth.
    Depth,
    /// It goes with the rate.
    Rate,
    /// It goes with the force.
    Force,
    /// It is there while there is contact, of one size.
    Contact,
    /// It is there at first touch and fades with the depth.
    Touch,
}

/// A description of what is left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Leftover {
    /// With what it goes.
    pub course: Course,
    /// Test that it is seen in; none: in all alike.
    pub test: Option<String>,
    /// Part of the gap (chi^2 beyond what noise gives) that this description takes.
    pub part: f64,
    /// Whether it is there off contact, too: then it is the machine's or the sensor's. None where too little was measured there to tell.
    pub off_contact: Option<bool>,
    /// Specimens that differ from the others far more than these among themselves.
    pub specimens: Vec<String>,
}

/// The best description of what a fit leaves; none where nothing is left.
pub fn leftover(observations: &[Observation], fit: &Fit) -> Option<Leftover> {
    let points = fit.gap_mn.len() as f64;
    let excess = fit.linear.residual.norm_squared() - points;
    if excess <= 0.0 {
        return None;
    }
    let parts = parts(observations, fit);
    // In all tests, and in each of several alone.
    let wheres = if parts.len() > 1 { 1 + parts.len() } else { 1 };
    let mut best: Option<Best> = None;
    for Trial { course, shapes, kind } in trials(&parts) {
        let alone = seen(fit, &parts, &*shapes);
        let mut consider = |test: Option<usize>, of: &[&DVector<f64>]| {
            let gained = gain(fit, of);
            let value = gained - 2.0 * ((kind * wheres) as f64).ln() - of.len() as f64 * points.ln();
            if value > best.as_ref().map_or(0.0, |b| b.value) {
                best = Some(Best { value, gained, course, test });
            }
        };
        consider(None, &alone.iter().flatten().collect::<Vec<_>>());
        if wheres > 1 {
            let each = alone.iter().enumerate();
            each.for_each(|(test, own)| consider(Some(test), &own.iter().collect::<Vec<_>>()));
        }
    }
    best.map(|best| Leftover {
        course: best.course,
        test: best.test.map(|t| observations[t].name().to_owned()),
        part: (best.gained / excess).min(1.0),
        off_contact: off_contact(&parts, fit),
        specimens: observations.iter().flat_map(outstanding).collect(),
    })
}

/// The best description so far.
struct Best {
    value: f64,
    gained: f64,
    course: Course,
    test: Option<usize>,
}

/// What no refit absorbs of the shapes in each test, each of length 1; what a refit absorbs is left out.
fn seen(fit: &Fit, parts: &[Part<'_>], shapes: &Shapes) -> Vec<Vec<DVector<f64>>> {
    let mut before = 0;
    let mut seen_in = |part: &Part<'_>| {
        let whole = |shape: Vec<f64>| {
            let mut all_mn = DVector::zeros(fit.gap_mn.len());
            all_mn.rows_mut(before, part.len()).copy_from_slice(&shape);
            let signature = fit.linear.signature(&fit.covariance, &all_mn);
            (signature.absorbed() < ABSORBED).then(|| signature.s.normalize())
        };
        let own = shapes(part).into_iter().filter_map(whole).collect();
        before += part.len();
        own
    };
    parts.iter().map(&mut seen_in).collect()
}

/// Fall of chi^2 by shapes (of length 1) of free sizes, beyond what a refit absorbs.
fn gain(fit: &Fit, shapes: &[&DVector<f64>]) -> f64 {
    if shapes.is_empty() {
        return 0.0;
    }
    let among = DMatrix::from_fn(shapes.len(), shapes.len(), |i, j| shapes[i].dot(shapes[j]));
    let along = DVector::from_fn(shapes.len(), |i, _| shapes[i].dot(&fit.linear.residual));
    let own = among.symmetric_eigen();
    let gained = |(k, length): (usize, &f64)| match *length > SAME {
        true => own.eigenvectors.column(k).dot(&along).powi(2) / length,
        // Shapes that are nearly one gain as one.
        false => 0.0,
    };
    own.eigenvalues.iter().enumerate().map(gained).sum()
}

/// Whether the mean of what is left where there is no force is more than noise; none where the gap, of its mean size, would not show there either.
fn off_contact(parts: &[Part<'_>], fit: &Fit) -> Option<bool> {
    let mut before = 0;
    let usual_mn = (fit.gap_mn.norm_squared() / fit.gap_mn.len() as f64).sqrt();
    let (mut largest, mut visible) = (0.0_f64, 0.0_f64);
    for part in parts {
        let points: Vec<usize> = (0..part.len()).filter(|&i| !part.is_in_contact(i)).collect();
        if points.len() > 2 {
            let mut shape = DVector::zeros(fit.gap_mn.len());
            points.iter().for_each(|&i| shape[before + i] = 1.0);
            let signature = fit.linear.signature(&fit.covariance, &shape);
            largest = largest.max(signature.score(&fit.linear.residual).abs());
            visible = visible.max(signature.strength() * usual_mn);
        }
        before += part.len();
    }
    match largest > OFF_CONTACT {
        true => Some(true),
        false => (visible > OFF_CONTACT).then_some(false),
    }
}

/// Specimens whose curve differs from the common one far more than the others'.
fn outstanding(o: &Observation) -> Vec<String> {
    let m = &o.measurement;
    let own = |(k, factor): (usize, &f64)| {
        let difference = |(s, f): (&f64, &f64)| (s - factor * f).powi(2);
        m.specimens_n[k].iter().zip(&m.force_n).map(difference).sum::<f64>()
    };
    let squares: Vec<f64> = o.factors.iter().enumerate().map(own).collect();
    if squares.len() < 3 {
        return vec![];
    }
    let usual = crate::data::measurement::median(&mut squares.clone());
    let far = squares.iter().zip(&m.specimen_names).filter(|(square, _)| **square > OUTSTANDING * usual);
    far.map(|(_, name)| format!("{} {name}", o.name())).collect()
}

impl Leftover {
    /// In a sentence.
    pub fn in_words(&self) -> String {
        let what = match self.course {
            Course::Clock => "grows with the time since the test began".to_owned(),
            Course::ClockRate => "is as if the clock of the force ran at another rate".to_owned(),
            Course::Step { from_s } => format!("is there from {} s on", rounded(from_s)),
            Course::Period { period_s } => format!("repeats with a period of {} s", rounded(period_s)),
            Course::Ringing { period_s } => {
                format!("swings after the ramp's end with a period of {} s", rounded(period_s))
            }
            Course::Depth => "goes with the depth".to_owned(),
            Course::Rate => "goes with the rate".to_owned(),
            Course::Force => "goes with the force".to_owned(),
            Course::Contact => "is there while there is contact, of one size".to_owned(),
            Course::Touch => "is there at first touch and fades with the depth".to_owned(),
        };
        let test = self.test.as_ref().map(|t| format!(", in {t}")).unwrap_or_default();
        let place = match self.off_contact {
            Some(true) => "; it is there off contact, too: look at machine and sensor",
            Some(false) => "; there is nothing off contact: look at specimen and contact",
            None => "; too little was measured off contact to tell the machine from the specimen",
        };
        let specimens = match &self.specimens[..] {
            [] => String::new(),
            some => format!(
                "; {} far from the others",
                crate::inference::wording::list(&some.iter().map(String::as_str).collect::<Vec<_>>())
            ),
        };
        let percent = format!("{:.0} % of the gap", 100.0 * self.part);
        let told = match self.part >= MOSTLY {
            true => format!("What is left {what}{test} ({percent})"),
            false => {
                format!("What is left has no simple shape: the best of those tried, {percent}, {what}{test}")
            }
        };
        format!("{told}{place}{specimens}.")
    }
}

fn rounded(value: f64) -> String {
    crate::inference::wording::significant(value, 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Measurement;
    use crate::data::random::Random;
    use crate::fit::{Prior, Solution};
    use crate::inference::fit::{End, linearised};
    use crate::noise::Covariance;

    /// A ramp of 1 s and a hold of 99 s of `5 + 3 exp(-t / 20)` mN with white noise of 0.05 mN and something added (mN), fitted by the two heights.
    fn fitted(added_mn: &dyn Fn(f64) -> f64) -> (Vec<Observation>, Fit) {
        let mut random = Random::new(3);
        let ramp = (0..50).map(|i| 0.02 * f64::from(i));
        let time_s: Vec<f64> = ramp.chain((0..200).map(|i| 1.0 + 0.5 * f64::from(i))).collect();
        let depth = |t: f64| t.min(1.0);
        let shapes = |t: f64| [depth(t), depth(t) * (-(t - 1.0).max(0.0) / 20.0).exp()];
        let model = |t: f64| 5.0 * shapes(t)[0] + 3.0 * shapes(t)[1];
        let measured: Vec<f64> =
            time_s.iter().map(|&t| model(t) + added_mn(t) + 0.05 * random.normal()).collect();
        let m = Measurement {
            name: "P".into(),
            displacement_m: time_s.iter().map(|&t| depth(t) * 1e-3).collect(),
            force_n: measured.iter().map(|f| f * 1e-3).collect(),
            time_s: time_s.clone(),
            ..Measurement::default()
        };
        let observation = Observation::new(&m, None).unwrap();
        let n = time_s.len();
        let jacobian_mn = DMatrix::from_fn(n, 2, |i, j| shapes(time_s[i])[j]);
        let covariance = Covariance::new(DVector::from_element(n, 0.05), vec![]);
        let y = DVector::from_vec(measured);
        let x = (jacobian_mn.tr_mul(&jacobian_mn)).try_inverse().unwrap() * jacobian_mn.tr_mul(&y);
        let gap_mn = &y - &jacobian_mn * &x;
        let prior = Prior { mean: vec![0.0; 2], deviation: vec![1e3; 2] };
        let linear = linearised(&jacobian_mn, &gap_mn, &covariance, &prior, x.as_slice());
        let solution =
            Solution::at_once(x.as_slice().to_vec(), gap_mn.as_slice().to_vec(), jacobian_mn.clone());
        let fit = Fit {
            solution,
            linear,
            gap_mn,
            jacobian_mn,
            parameters: 2,
            prior,
            covariance,
            end: End::Minimum,
        };
        (vec![observation], fit)
    }

    fn found(added_mn: &dyn Fn(f64) -> f64) -> Leftover {
        let (observations, fit) = fitted(added_mn);
        leftover(&observations, &fit).unwrap()
    }

    #[test]
    fn a_step_has_its_time() {
        let l = found(&|t| if t > 40.0 { 0.3 } else { 0.0 });
        assert!(matches!(l.course, Course::Step { from_s } if (from_s - 40.0).abs() < 3.0), "{l:?}");
        assert!(l.part > 0.8, "{l:?}");
    }

    #[test]
    fn a_hum_has_its_period() {
        let l = found(&|t| 0.2 * (std::f64::consts::TAU * t / 7.0).sin());
        assert!(
            matches!(l.course, Course::Period { period_s } if (period_s / 7.0 - 1.0).abs() < 0.1),
            "{l:?}"
        );
    }

    #[test]
    fn a_drive_that_rings_is_told() {
        let l = found(&|t| {
            let since = (t - 1.0).max(0.0);
            2.0 * (-since / 8.0).exp() * (std::f64::consts::TAU * since / 6.0).sin()
        });
        assert!(
            matches!(l.course, Course::Ringing { period_s } if (period_s / 6.0 - 1.0).abs() < 0.1),
            "{l:?}"
        );
    }

    /// The relaxation of `fitted`, 20 % faster.
    #[test]
    fn a_clock_that_runs_fast_is_told() {
        let relaxing = |t: f64| 3.0 * t.min(1.0) * (-(t - 1.0).max(0.0) / 20.0).exp();
        let l = found(&|t| relaxing(1.2 * t) - relaxing(t));
        assert_eq!(l.course, Course::ClockRate, "{l:?}");
    }

    #[test]
    fn a_drift_goes_with_the_clock() {
        let l = found(&|t| 0.01 * t);
        assert_eq!(l.course, Course::Clock, "{l:?}");
    }

    #[test]
    fn a_lost_length_relaxes_as_the_specimen_does() {
        let since = |t: f64| t - 40.0;
        let l = found(&|t| if t < 40.0 { 0.0 } else { 0.2 * (5.0 + 3.0 * (-since(t) / 20.0).exp()) });
        assert!(matches!(l.course, Course::Step { from_s } if (from_s - 40.0).abs() < 0.5), "{l:?}");
        assert!(l.part > 0.95, "{l:?}");
    }

    #[test]
    fn a_wave_may_be_longer_than_the_test() {
        let l = found(&|t| 0.5 * (std::f64::consts::TAU * t / 150.0 + 1.0).sin());
        assert!(matches!(l.course, Course::Period { period_s } if period_s > 100.0), "{l:?}");
    }

    #[test]
    fn a_tilted_punch_is_seen_at_first_touch() {
        let l = found(&|t| if t < 1.0 { -8.0 * t * (-t / 0.1).exp() } else { 0.0 });
        assert_eq!(l.course, Course::Touch, "{l:?}");
    }

    #[test]
    fn what_is_seen_in_one_test_alone_is_told_of_that_test() {
        let (mut observations, mut fit) = fitted(&|t| if t > 40.0 { 0.3 } else { 0.0 });
        let (others, second) = fitted(&|_| 0.0);
        let n = fit.gap_mn.len();
        let both = fit.gap_mn.iter().chain(second.gap_mn.iter()).copied();
        fit.gap_mn = DVector::from_iterator(2 * n, both);
        fit.jacobian_mn = DMatrix::from_fn(2 * n, 4, |i, j| {
            let (half, column) = (j / 2, j % 2);
            let own = if half == 0 { &fit.jacobian_mn } else { &second.jacobian_mn };
            if i / n == half { own[(i % n, column)] } else { 0.0 }
        });
        fit.covariance = Covariance::new(DVector::from_element(2 * n, 0.05), vec![]);
        fit.prior = Prior { mean: vec![0.0; 4], deviation: vec![1e3; 4] };
        fit.linear = linearised(&fit.jacobian_mn, &fit.gap_mn, &fit.covariance, &fit.prior, &[0.0; 4]);
        observations.extend(others);
        observations[1].measurement.name = "Q".into();
        let l = leftover(&observations, &fit).unwrap();
        assert_eq!(l.test.as_deref(), Some("P"), "{l:?}");
        assert!(matches!(l.course, Course::Step { from_s } if (from_s - 40.0).abs() < 3.0), "{l:?}");
    }

    #[test]
    fn a_shape_that_takes_little_of_the_gap_is_no_description() {
        let told = |part: f64| {
            let course = Course::Step { from_s: 53.1 };
            Leftover { course, test: None, part, off_contact: None, specimens: vec![] }.in_words()
        };
        assert!(
            told(0.9).starts_with("What is left is there from 53.1 s on (90 % of the gap);"),
            "{}",
            told(0.9)
        );
        let little = "What is left has no simple shape: the best of those tried, 20 % of the gap, is there from 53.1 s on;";
        assert!(told(0.2).starts_with(little), "{}", told(0.2));
    }

    /// A refit with a free drift absorbs the clock's shape, all of it.
    #[test]
    fn a_shape_that_a_refit_absorbs_is_no_description() {
        let (observations, mut fit) = fitted(&|t| if t > 40.0 { 0.3 } else { 0.0 });
        let drift = DVector::from_vec(observations[0].measurement.time_s.clone());
        fit.jacobian_mn = fit.jacobian_mn.insert_column(2, 0.0);
        fit.jacobian_mn.set_column(2, &drift);
        fit.prior = Prior { mean: vec![0.0; 3], deviation: vec![1e3; 3] };
        fit.linear = linearised(&fit.jacobian_mn, &fit.gap_mn, &fit.covariance, &fit.prior, &[0.0; 3]);
        let l = leftover(&observations, &fit).unwrap();
        assert!(matches!(l.course, Course::Step { .. }), "{l:?}");
    }

    #[test]
    fn noise_has_no_description() {
        let (observations, fit) = fitted(&|_| 0.0);
        assert_eq!(leftover(&observations, &fit), None);
    }
}
