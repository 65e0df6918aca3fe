//! Whether the description of a gap that nothing explains is right about the cause behind it.

use super::cause::{Cause, Flaw};
use super::key::Solution;
use crate::diagnosis::leftover::{Course, Leftover};
use poropunch_maker::Effect;

/// A time or a period is right within this factor.
const NEAR: f64 = 1.25;
/// A record shows no shorter period than this (s): sampling folds it to a longer one.
const FOLDED_S: f64 = 0.2;
/// A longer one is a course of the clock in tests of some 100 s (s).
const SLOW_S: f64 = 50.0;
/// Name of the specimen that is a bad one.
const BAD: &str = "s01";

/// Whether what is told of a case with causes outside the catalogue is right about one of them; none where there is nothing to compare. To
/// tell nothing is wrong.
pub fn of(solution: &Solution, left: Option<&Leftover>) -> Option<bool> {
    let Some(left) = left else { return Some(false) };
    let each = solution.drawn.causes.iter().filter_map(|cause| is_right(cause, left));
    each.reduce(|any, one| any || one)
}

/// Whether a description is right about a cause outside the catalogue; none where the cause is none of the wide ground's.
fn is_right(cause: &Cause, left: &Leftover) -> Option<bool> {
    let Cause::Maker(effect) = cause else {
        let Cause::Specimen(Flaw::BadSpecimen { .. }) = cause else { return None };
        return Some(left.specimens.iter().any(|name| name.ends_with(BAD)));
    };
    let near = |a: f64, b: f64| (a / b).ln().abs() < NEAR.ln();
    let step_at = |time_s: f64| matches!(left.course, Course::Step { from_s } if near(from_s, time_s));
    let period_near = |period_s: f64| match left.course {
        Course::Period { period_s: p } | Course::Ringing { period_s: p } => near(p, period_s),
        _ => false,
    };
    let is_periodic = matches!(left.course, Course::Period { .. });
    let goes_with = |courses: &[Course]| courses.contains(&left.course);
    Some(match *effect {
        // A force that is there whatever the specimen does.
        Effect::Wave { period_s, .. } => {
            let course = match period_s {
                p if p < FOLDED_S => is_periodic,
                p if p > SLOW_S => is_periodic || goes_with(&[Course::Clock]),
                p => period_near(p),
            };
            course && left.off_contact != Some(false)
        }
        Effect::Overshoot { frequency, .. } => period_near(1.0 / frequency),
        Effect::WarmingFrame { .. } => goes_with(&[Course::Clock]),
        Effect::Clock { .. } => goes_with(&[Course::ClockRate, Course::Clock, Course::Rate]),
        Effect::GripStep { time_s, .. } | Effect::Bubble { time_s, .. } => step_at(time_s),
        Effect::Gain { from_s, to_s, .. } => step_at(from_s) || step_at(to_s) || goes_with(&[Course::Force]),
        Effect::Clip { .. } => goes_with(&[Course::Force, Course::Depth]),
        Effect::Meniscus { .. } | Effect::Tilt { .. } => {
            goes_with(&[Course::Contact, Course::Touch, Course::Depth])
        }
        Effect::Backlash { .. } => goes_with(&[Course::Rate, Course::Depth]),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(course: Course, off_contact: Option<bool>) -> Leftover {
        Leftover { course, test: None, part: 0.9, off_contact, specimens: vec![] }
    }

    #[test]
    fn a_step_has_to_be_where_it_was() {
        let cause = Cause::Maker(Effect::GripStep { length: 1e-5, time_s: 20.0 });
        let of = |from_s| is_right(&cause, &left(Course::Step { from_s }, None));
        assert_eq!([of(22.0), of(30.0)], [Some(true), Some(false)]);
        assert_eq!(is_right(&cause, &left(Course::Clock, None)), Some(false));
    }

    #[test]
    fn a_wave_is_the_machine_s() {
        let cause = Cause::Maker(Effect::Wave { force: 1e-4, period_s: 7.0, phase: 0.0 });
        let of = |off_contact| is_right(&cause, &left(Course::Period { period_s: 7.5 }, off_contact));
        assert_eq!([of(None), of(Some(true)), of(Some(false))], [Some(true), Some(true), Some(false)]);
    }

    #[test]
    fn an_overshoot_rings() {
        let cause = Cause::Maker(Effect::Overshoot { length: 1e-5, frequency: 4.0, decay_s: 0.3 });
        let of = |period_s| is_right(&cause, &left(Course::Ringing { period_s }, None));
        assert_eq!([of(0.27), of(0.4)], [Some(true), Some(false)]);
    }

    #[test]
    fn a_bad_specimen_has_a_name() {
        let cause = Cause::Specimen(Flaw::BadSpecimen { loss: 0.1, time_s: 5.0 });
        let mut found = left(Course::Force, None);
        assert_eq!(is_right(&cause, &found), Some(false));
        found.specimens.push("P1 s01".to_owned());
        assert_eq!(is_right(&cause, &found), Some(true));
    }
}
