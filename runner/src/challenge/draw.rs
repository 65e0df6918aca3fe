//! Which case it is: cause, size, material, specimens, drawn at random.

use super::cause::Cause;
use crate::data::random::Random;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What kind of case was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Nothing is missing.
    Null,
    /// One effect of the catalogue.
    Single,
    /// Two of them.
    Pair,
    /// A cause outside the catalogue.
    Outside,
    /// An effect of the catalogue that is too weak to see.
    Weak,
}

/// A case before it is simulated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drawn {
    /// Name of its folder: says nothing about what is in it.
    pub id: String,
    /// Kind.
    pub kind: Kind,
    /// Causes.
    pub causes: Vec<Cause>,
    /// Material (SI).
    pub material: BTreeMap<String, f64>,
    /// Whether both tests are made on the same specimens.
    pub same_specimens: bool,
    /// Relative deviation of the specimens' heights (-).
    pub height_scatter: f64,
    /// Relative deviation of the specimens' late forces (-).
    pub shape_scatter: f64,
    /// Seed of the noise.
    pub noise_seed: u64,
}

/// Shares of the kinds.
const SHARES: [(Kind, f64); 5] =
    [(Kind::Null, 0.25), (Kind::Single, 0.4), (Kind::Pair, 0.1), (Kind::Outside, 0.15), (Kind::Weak, 0.1)];
/// Parameters lie up to this part away from Table 1.
const OFF: f64 = 0.3;
/// Sizes of effects in plausible scales, drawn evenly in the logarithm.
const SIZES: (f64, f64) = (0.7, 4.0);
/// Of those that nobody can see.
const WEAK: (f64, f64) = (0.005, 0.02);

/// Draws `cases` cases of these kinds, or of all where none is given.
pub fn draw(seed: u64, cases: usize, wanted: &[Kind]) -> Vec<Drawn> {
    let mut random = Random::new(seed);
    let mut shuffle: Vec<Kind> = kinds(cases, wanted);
    for i in (1..shuffle.len()).rev() {
        shuffle.swap(i, below(&mut random, i + 1));
    }
    shuffle.into_iter().map(|kind| one(kind, &mut random)).collect()
}

/// Another case of the same kind, in place of one that cannot be simulated; `attempt` counts from 1.
pub fn again(case: &Drawn, attempt: u64) -> Drawn {
    one(case.kind, &mut Random::new(case.noise_seed.wrapping_add(attempt)))
}

/// As many of each kind as its share among the wanted ones says, the rest of the first of them.
fn kinds(cases: usize, wanted: &[Kind]) -> Vec<Kind> {
    let shares = || SHARES.iter().filter(|(kind, _)| wanted.is_empty() || wanted.contains(kind));
    let all: f64 = shares().map(|(_, share)| share).sum();
    let mut kinds = Vec::new();
    for (kind, share) in shares().skip(1) {
        kinds.extend(std::iter::repeat_n(*kind, (share / all * cases as f64).round() as usize));
    }
    kinds.truncate(cases);
    kinds.resize(cases, shares().next().map_or(Kind::Null, |(kind, _)| *kind));
    kinds
}

fn one(kind: Kind, random: &mut Random) -> Drawn {
    // What an identification fits, from Table 1's values.
    let varied = poropunch::variables::identifiable().filter(|(_, i)| i.free);
    let mut material: BTreeMap<String, f64> =
        varied.map(|(v, _)| (v.name.to_owned(), v.start_number())).collect();
    material.values_mut().for_each(|v| *v *= (1.0 + OFF).powf(2.0 * random.uniform() - 1.0));
    let causes = match kind {
        Kind::Null => vec![],
        Kind::Single => vec![inside(below(random, INSIDE), SIZES, random)],
        Kind::Weak => vec![inside(below(random, INSIDE), WEAK, random)],
        Kind::Outside => vec![outside(random)],
        Kind::Pair => {
            let first = below(random, INSIDE);
            let second = (first + 1 + below(random, INSIDE - 1)) % INSIDE;
            vec![inside(first, SIZES, random), inside(second, SIZES, random)]
        }
    };
    let bits = |random: &mut Random| (random.uniform() * f64::from(u32::MAX)) as u64;
    Drawn {
        id: format!("{:08x}", bits(random)),
        kind,
        causes,
        material,
        same_specimens: random.uniform() < 0.5,
        height_scatter: 0.06 + 0.1 * random.uniform(),
        shape_scatter: if random.uniform() < 0.5 { 0.01 } else { 0.0 },
        noise_seed: bits(random),
    }
}

fn below(random: &mut Random, n: usize) -> usize {
    ((random.uniform() * n as f64) as usize).min(n - 1)
}

/// Number of effects in [`inside`].
const INSIDE: usize = 10;

/// An effect of the catalogue, of a size between these (in plausible scales).
fn inside(which: usize, sizes: (f64, f64), random: &mut Random) -> Cause {
    let size = sizes.0 * (sizes.1 / sizes.0).powf(random.uniform());
    let signed = if random.uniform() < 0.5 { -size } else { size };
    let spread = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.uniform());
    match which {
        0 => Cause::SaturatingDrift { rate: 2e-6 * signed, time_s: spread(random, 150.0, 600.0) },
        1 => Cause::TwoPoleLag { time_s: 0.05 * size },
        // The tests start 0.1 mm above the surface: a higher one must not reach the punch.
        2 => Cause::ShiftedSurface { height: 2e-5 * signed },
        3 => Cause::Batch { log_factor: 0.15 * signed },
        4 => {
            let mu = -40.0 * size;
            Cause::SlowBranch { mu, eta: 60.0 * size * spread(random, 150.0, 600.0) }
        }
        5 => Cause::Flow { inverse_stress: 5e-3 * size },
        6 => {
            let loss = if sizes.1 < 1.0 { 0.3 * size } else { 0.15 + 0.3 * random.uniform() };
            Cause::Damage { loss, strain: spread(random, 0.1, 0.4) }
        }
        7 => Cause::Ageing { rate: 2e-4 * signed },
        8 => Cause::Frame { per_newton: 3e-3 * size },
        _ => Cause::SoftSkeleton { lambda: 1e5 * (0.02_f64).powf(0.5 * size.min(2.5)) },
    }
}

/// A cause outside the catalogue.
fn outside(random: &mut Random) -> Cause {
    let size = 0.7 + 2.3 * random.uniform();
    match below(random, 5) {
        0 => Cause::Overshoot { length: 2e-5 * size, frequency: 2.0 + 3.0 * random.uniform(), decay_s: 0.3 },
        1 => Cause::WarmingFrame { length: 3e-5 * size, time_s: 5.0 + 30.0 * random.uniform() },
        2 => Cause::Meniscus { force: 2e-4 * size },
        3 => Cause::Hum { force: 1e-4 * size, period_s: 3.0 + 20.0 * random.uniform() },
        _ => Cause::GainStep { part: 0.03 * size, from_s: 3.0 + 10.0 * random.uniform(), to_s: 40.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_cases_and_all_kinds() {
        let cases = draw(7, 100, &[]);
        assert_eq!(cases, draw(7, 100, &[]));
        assert_ne!(cases, draw(8, 100, &[]));
        let count = |kind| cases.iter().filter(|c| c.kind == kind).count();
        let counts = [Kind::Null, Kind::Single, Kind::Pair, Kind::Outside, Kind::Weak].map(count);
        assert_eq!(counts, [25, 40, 10, 15, 10]);
        let ids: std::collections::BTreeSet<&String> = cases.iter().map(|c| &c.id).collect();
        assert_eq!(ids.len(), 100);
        for case in &cases {
            let inside = case.causes.iter().filter(|c| c.effect().is_some()).count();
            let expected = match case.kind {
                Kind::Null | Kind::Outside => 0,
                Kind::Single | Kind::Weak => 1,
                Kind::Pair => 2,
            };
            assert_eq!(inside, expected, "{case:?}");
            assert_eq!(case.material.len(), 9);
        }
    }

    #[test]
    fn only_the_wanted_kinds_are_drawn() {
        let cases = draw(7, 20, &[Kind::Pair, Kind::Null]);
        let count = |kind| cases.iter().filter(|c| c.kind == kind).count();
        // Their shares are 25 to 10.
        assert_eq!([Kind::Null, Kind::Pair].map(count), [14, 6]);
        assert!(draw(7, 5, &[Kind::Weak]).iter().all(|c| c.kind == Kind::Weak));
    }

    #[test]
    fn at_least_four_kinds_of_causes_are_outside() {
        let mut random = Random::new(1);
        let forms: std::collections::BTreeSet<String> =
            (0..100).map(|_| format!("{:?}", outside(&mut random)).chars().take(6).collect()).collect();
        assert!(forms.len() >= 4, "{forms:?}");
    }
}
