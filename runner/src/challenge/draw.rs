//! Which case it is: cause, size, material, specimens, drawn at random.

use super::cause::Cause;
use super::ground::Ground;
use super::noise::Noise;
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
    /// Specimens and noise.
    pub noise: Noise,
}

/// Shares of the kinds.
const SHARES: [(Kind, f64); 5] =
    [(Kind::Null, 0.25), (Kind::Single, 0.4), (Kind::Pair, 0.1), (Kind::Outside, 0.15), (Kind::Weak, 0.1)];

/// Draws `cases` cases of these kinds, or of all where none is given.
pub fn draw(seed: u64, cases: usize, wanted: &[Kind], ground: Ground) -> Vec<Drawn> {
    let mut random = Random::new(seed);
    let mut shuffle: Vec<Kind> = kinds(cases, wanted);
    for i in (1..shuffle.len()).rev() {
        shuffle.swap(i, random.below(i + 1));
    }
    shuffle.into_iter().map(|kind| one(kind, ground, &mut random)).collect()
}

/// Another case of the same kind, in place of one that cannot be simulated; `attempt` counts from 1.
pub fn again(case: &Drawn, attempt: u64, ground: Ground) -> Drawn {
    one(case.kind, ground, &mut Random::new(case.noise.seed.wrapping_add(attempt)))
}

/// A case, then others of its kind in place of it: every `stride`-th.
pub fn and_others(case: &Drawn, stride: u64, ground: Ground) -> impl Iterator<Item = Drawn> + use<> {
    let case = case.clone();
    std::iter::once(case.clone()).chain((1..).map(move |k| again(&case, k * stride, ground)))
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

fn one(kind: Kind, ground: Ground, random: &mut Random) -> Drawn {
    let material = ground.material(random);
    let causes = ground.causes(kind, &material, random);
    let id = format!("{:08x}", random.bits());
    let noise = ground.noise(&material, random);
    Drawn { id, kind, causes, material, noise }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_cases_and_all_kinds() {
        for ground in [Ground::Near, Ground::Wide] {
            let cases = draw(7, 100, &[], ground);
            assert_eq!(cases, draw(7, 100, &[], ground));
            assert_ne!(cases, draw(8, 100, &[], ground));
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
            }
        }
    }

    /// Public seeds are kept: a name comes after everything that was drawn before it.
    #[test]
    fn the_near_ground_gives_the_cases_that_it_gave() {
        let mut ids: Vec<String> = draw(2028, 20, &[], Ground::Near).into_iter().map(|c| c.id).collect();
        ids.sort();
        let given = [
            "18e2a310 2f201c61 316b43f0 393cbbcd 3dc58417 541f3af1 647122f7 713797e6 7a4d4477 ad2ea0dd",
            "ba4bc402 c64085d6 cdd24c01 d0851d83 d71366c7 dd12ebc9 df8f35b2 e4a4af3d eafcb655 f2eec3bb",
        ];
        assert_eq!(ids.join(" "), given.join(" "));
    }

    #[test]
    fn only_the_wanted_kinds_are_drawn() {
        let cases = draw(7, 20, &[Kind::Pair, Kind::Null], Ground::Near);
        let count = |kind| cases.iter().filter(|c| c.kind == kind).count();
        // Their shares are 25 to 10.
        assert_eq!([Kind::Null, Kind::Pair].map(count), [14, 6]);
        assert!(draw(7, 5, &[Kind::Weak], Ground::Wide).iter().all(|c| c.kind == Kind::Weak));
    }
}
