//! Where cases are drawn from: materials, sizes of causes, noise.

use super::cause::Cause;
use super::draw::Kind;
use super::noise::{Family, Noise};
use super::{near, wide};
use crate::data::random::Random;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How far cases lie from Table 1, and from what the diagnosis assumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// Materials within 30 % of Table 1, ten specimens with white noise, effects about their plausible size.
    Near,
    /// Moduli, times and permeability up to ten times Table 1's either way, three to twelve specimens, noise of five families, all
    /// effects of the catalogue from a third of their plausible size to ten times it, computed by an independent solver.
    #[default]
    Wide,
}

/// Largest factor between a parameter and Table 1's.
const OFF: [f64; 2] = [1.3, 10.0];
/// Sizes of effects that nobody can see, in plausible scales.
const WEAK: (f64, f64) = (0.005, 0.02);
/// Time of the paper's ramps (s).
const RAMP_S: f64 = 1.0;

impl Ground {
    fn pick<T: Copy>(self, of: [T; 2]) -> T {
        match self {
            Self::Near => of[0],
            Self::Wide => of[1],
        }
    }

    /// What an identification fits, drawn evenly in the logarithm about Table 1's values; its names are the FMU's (SI).
    pub(super) fn material(self, random: &mut Random) -> BTreeMap<String, f64> {
        let mut material = table_1();
        let off = self.pick(OFF);
        if self == Self::Near {
            material.values_mut().for_each(|v| *v *= off.powf(2.0 * random.uniform() - 1.0));
            return material;
        }
        let mut away = |value: f64| value * off.powf(2.0 * random.uniform() - 1.0);
        let own = Shear::of(&material);
        let drawn = Shear { moduli: own.moduli.map(&mut away), times: own.times.map(&mut away) };
        let permeability = away(material["material.permeability"]);
        let alpha = [(); 3].map(|()| -random.between(1.5, 20.0));
        drawn.write(alpha, &mut material);
        material.insert("material.permeability".to_owned(), permeability);
        // As nearly incompressible as Table 1's.
        let lambda_star = 1e5 * (drawn.instantaneous() / own.instantaneous()).max(1.0);
        material.insert("material.lambda_star".to_owned(), lambda_star);
        material
    }

    /// Causes of a kind of case, for a material.
    pub(super) fn causes(
        self,
        kind: Kind,
        material: &BTreeMap<String, f64>,
        random: &mut Random,
    ) -> Vec<Cause> {
        let stress = self.stress(material);
        let inside = |which: usize, sizes: (f64, f64), random: &mut Random| match self {
            Self::Near => Cause::Engine(near::inside(which, sizes, random)),
            Self::Wide => Cause::Maker(wide::inside(which, sizes, stress, random)),
        };
        let all = self.pick([near::INSIDE, wide::INSIDE]);
        let sizes = self.pick([near::SIZES, wide::SIZES]);
        match kind {
            Kind::Null => vec![],
            Kind::Single => vec![inside(random.below(all), sizes, random)],
            Kind::Weak => vec![inside(random.below(all), WEAK, random)],
            Kind::Pair => {
                let first = random.below(all);
                let second = (first + 1 + random.below(all - 1)) % all;
                vec![inside(first, sizes, random), inside(second, sizes, random)]
            }
            Kind::Outside => vec![match self {
                Self::Near => Cause::Engine(near::outside(random)),
                Self::Wide => wide::outside(stress, random),
            }],
        }
    }

    /// How much stiffer than Table 1's a material is in these tests; stresses and forces, and what belongs to them, grow with it.
    fn stress(self, material: &BTreeMap<String, f64>) -> f64 {
        if self == Self::Near {
            return 1.0;
        }
        Shear::of(material).seen() / Shear::of(&table_1()).seen()
    }

    /// Specimens and noise.
    pub(super) fn noise(self, material: &BTreeMap<String, f64>, random: &mut Random) -> Noise {
        let same_specimens = random.uniform() < 0.5;
        let height_scatter = 0.06 + 0.1 * random.uniform();
        let shape_scatter = if random.uniform() < 0.5 { 0.01 } else { 0.0 };
        let seed = random.bits();
        if self == Self::Near {
            let (specimens, white_n, family) = (10, 0.07e-3, Family::White);
            return Noise { specimens, same_specimens, height_scatter, shape_scatter, white_n, family, seed };
        }
        // Of a peak of 11 mN with Table 1.
        let white_n = 11e-3 * self.stress(material) * random.between(2e-3, 2e-2);
        let family = match random.below(5) {
            0 => Family::White,
            1 => Family::WanderingZero {
                deviation_n: white_n * random.between(0.5, 2.0),
                time_s: random.between(20.0, 200.0),
            },
            2 => Family::Quantised { step_n: white_n * random.between(0.5, 3.0) },
            3 => Family::JitteredClock { deviation_s: random.between(1e-3, 5e-3) },
            _ => Family::Outliers {
                share: random.between(1e-3, 1e-2),
                size_n: white_n * random.between(10.0, 30.0),
            },
        };
        let specimens = 3 + random.below(10);
        Noise { specimens, same_specimens, height_scatter, shape_scatter, white_n, family, seed }
    }
}

/// Table 1's values of what an identification fits, by the FMU's names (SI).
fn table_1() -> BTreeMap<String, f64> {
    let varied = poropunch::variables::identifiable().filter(|(_, i)| i.free);
    varied.map(|(v, _)| (v.name.to_owned(), v.start_number())).collect()
}

/// Largest factor, at least 1, between a modulus, relaxation time or permeability and Table 1's.
pub(super) fn factor_off_table_1(material: &BTreeMap<String, f64>) -> f64 {
    let values = |of: &BTreeMap<String, f64>| {
        let shear = Shear::of(of);
        shear.moduli.into_iter().chain(shear.times).chain([of["material.permeability"]]).collect::<Vec<_>>()
    };
    let factors = values(material).into_iter().zip(values(&table_1())).map(|(a, b)| (a / b).max(b / a));
    factors.fold(1.0, f64::max)
}

/// Shear moduli (Pa) of equilibrium and two branches, and the branches' times (s).
#[derive(Debug, Clone, Copy)]
struct Shear {
    moduli: [f64; 3],
    times: [f64; 2],
}

/// Names of the three springs.
const SPRINGS: [&str; 3] = ["material.equilibrium", "material.branch[1]", "material.branch[2]"];

impl Shear {
    fn of(material: &BTreeMap<String, f64>) -> Self {
        let value = |spring: usize, leaf: &str| material[&format!("{}.{leaf}", SPRINGS[spring])];
        let moduli = [0, 1, 2].map(|k| 0.5 * value(k, "mu") * value(k, "alpha"));
        Self { moduli, times: [1, 2].map(|k| value(k, "eta") / moduli[k]) }
    }

    fn write(&self, alpha: [f64; 3], material: &mut BTreeMap<String, f64>) {
        for (k, spring) in SPRINGS.iter().enumerate() {
            material.insert(format!("{spring}.mu"), 2.0 * self.moduli[k] / alpha[k]);
            material.insert(format!("{spring}.alpha"), alpha[k]);
            if k > 0 {
                material.insert(format!("{spring}.eta"), self.moduli[k] * self.times[k - 1]);
            }
        }
    }

    fn instantaneous(&self) -> f64 {
        self.moduli.iter().sum()
    }

    /// What of the moduli the ramp does not relax at once (Pa).
    fn seen(&self) -> f64 {
        let part = |tau: f64| tau / (tau + RAMP_S);
        self.moduli[0] + self.moduli[1] * part(self.times[0]) + self.moduli[2] * part(self.times[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Names in the catalogue of a ground's single effects, and forms of its causes outside.
    fn drawn(ground: Ground, kind: Kind) -> BTreeSet<String> {
        let mut random = Random::new(1);
        let mut all = BTreeSet::new();
        for _ in 0..600 {
            let material = ground.material(&mut random);
            for cause in ground.causes(kind, &material, &mut random) {
                let form = serde_json::to_value(&cause).unwrap()["form"].as_str().unwrap().to_owned();
                all.insert(cause.effect().map_or(form, str::to_owned));
            }
        }
        all
    }

    #[test]
    fn a_softer_branch_is_as_far_off_as_a_stiffer_one() {
        let softer = |factor: f64| {
            let mut material = table_1();
            let branch = material.get_mut("material.branch[1].mu").unwrap();
            *branch *= factor;
            // Its time is eta / G.
            *material.get_mut("material.branch[1].eta").unwrap() *= factor;
            factor_off_table_1(&material)
        };
        approx::assert_relative_eq!(softer(8.0), 8.0, max_relative = 1e-12);
        approx::assert_relative_eq!(softer(0.125), 8.0, max_relative = 1e-12);
        approx::assert_relative_eq!(softer(1.0), 1.0, max_relative = 1e-12);
    }

    #[test]
    fn the_wide_ground_has_every_effect_of_the_catalogue_and_fourteen_others() {
        let catalogue: BTreeSet<String> =
            poropunch::effect::CATALOGUE.iter().map(|e| e.name.to_owned()).collect();
        for kind in [Kind::Single, Kind::Pair, Kind::Weak] {
            assert_eq!(drawn(Ground::Wide, kind), catalogue);
            assert!(drawn(Ground::Near, kind).is_subset(&catalogue));
        }
        // Three of the fourteen are waves.
        assert_eq!(drawn(Ground::Wide, Kind::Outside).len(), wide::OUTSIDE - 2);
        assert_eq!(drawn(Ground::Near, Kind::Outside).len(), near::OUTSIDE);
    }

    #[test]
    fn materials_reach_ten_times_table_1_either_way() {
        let mut random = Random::new(2);
        let all: Vec<Shear> = (0..400).map(|_| Shear::of(&Ground::Wide.material(&mut random))).collect();
        let table_1 = Shear { moduli: [234.4, 2821.5, 239.1], times: [0.0179, 19.57] };
        let check = |of: &dyn Fn(&Shear) -> f64| {
            let ratios: Vec<f64> = all.iter().map(|s| of(s) / of(&table_1)).collect();
            let (low, high) =
                (ratios.iter().copied().fold(9.0, f64::min), ratios.iter().copied().fold(0.0, f64::max));
            assert!((0.0999..0.12).contains(&low) && (8.3..10.01).contains(&high), "{low} {high}");
        };
        (0..3).for_each(|k| check(&|s| s.moduli[k]));
        (0..2).for_each(|k| check(&|s| s.times[k]));
    }
}
