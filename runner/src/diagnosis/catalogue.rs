//! The effects that are asked about, in the form that screening uses.

use super::effect::{Action, Effect, Place, Scope, Sign};
use crate::pool::Wiring;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How a parameter follows the magnitude.
#[derive(Debug, Clone, Copy)]
enum Course {
    /// `null + m (probe - null)`.
    Linear { null: f64, probe: f64 },
    /// `value * ratio^m`, from whatever value it has.
    Times { ratio: f64 },
    /// This value wherever m is not 0.
    Fixed { value: f64 },
}

impl Course {
    fn at(self, value: f64, m: f64) -> f64 {
        match self {
            Self::Linear { null, probe } => null + m * (probe - null),
            Self::Times { ratio } => value * ratio.powf(m),
            Self::Fixed { value } => value,
        }
    }
}

/// Sets each parameter by its course.
fn action(courses: &'static [(&'static str, Course)]) -> Action {
    Arc::new(move |values: &mut BTreeMap<String, f64>, m| {
        for (name, course) in courses {
            let before = values.get(*name).copied().unwrap_or(0.0);
            values.insert((*name).to_owned(), course.at(before, m));
        }
    })
}

/// One entry, before it is known whether the FMU has its parameters.
struct Entry {
    name: &'static str,
    title: &'static str,
    place: Place,
    sign: Sign,
    scope: Scope,
    scale: (f64, &'static str),
    largest: f64,
    mimics: &'static str,
    reveals: &'static str,
    courses: &'static [(&'static str, Course)],
}

const MODULI: &[(&str, Course)] = &[
    ("material.equilibrium.mu", Course::Times { ratio: 1.2 }),
    ("material.branch[1].mu", Course::Times { ratio: 1.2 }),
    ("material.branch[1].eta", Course::Times { ratio: 1.2 }),
    ("material.branch[2].mu", Course::Times { ratio: 1.2 }),
    ("material.branch[2].eta", Course::Times { ratio: 1.2 }),
    ("material.lambda_star", Course::Times { ratio: 1.2 }),
];

const ENTRIES: &[Entry] = &[
    Entry {
        name: "third_branch",
        title: "slow third branch",
        place: Place::Specimen,
        sign: Sign::Positive,
        scope: Scope::Shared,
        scale: (60.0, "Pa"),
        largest: 20.0,
        mimics: "load-cell drift, drying",
        reveals: "a longer hold: it comes to rest, drift does not",
        courses: &[
            ("material.branch[3].mu", Course::Linear { null: 0.0, probe: -40.0 }),
            ("material.branch[3].alpha", Course::Fixed { value: -3.0 }),
            ("material.branch[3].eta", Course::Linear { null: 1e-3, probe: 9000.0 }),
        ],
    },
    Entry {
        name: "lambda_star",
        title: "compressible skeleton",
        place: Place::Specimen,
        sign: Sign::Positive,
        scope: Scope::Shared,
        scale: (0.02, "times lambda*"),
        largest: 1.8,
        mimics: "a viscous branch with the time of consolidation",
        reveals: "punches of two radii: consolidation takes the square of the radius",
        courses: &[("material.lambda_star", Course::Times { ratio: 0.02 })],
    },
    Entry {
        name: "amplitude",
        title: "amplitude of the specimens between protocols",
        place: Place::Specimen,
        sign: Sign::Either,
        scope: Scope::BetweenTests,
        scale: (20.0, "%"),
        largest: 5.0,
        mimics: "nothing that depends on the rate",
        reveals: "both protocols on the same specimens, in alternating order",
        courses: MODULI,
    },
    Entry {
        name: "slip",
        title: "frictionless punch",
        place: Place::Contact,
        sign: Sign::Switch,
        scope: Scope::Shared,
        scale: (1.0, ""),
        largest: 1.0,
        mimics: "all moduli together",
        reveals: "a roughened or glued punch",
        courses: &[("boundary.bonded_punch", Course::Fixed { value: 0.0 })],
    },
    Entry {
        name: "drained_punch",
        title: "drained punch face",
        place: Place::Contact,
        sign: Sign::Switch,
        scope: Scope::Shared,
        scale: (1.0, ""),
        largest: 1.0,
        mimics: "a higher permeability",
        reveals: "a porous punch beside a solid one",
        courses: &[("boundary.drained_punch", Course::Fixed { value: 1.0 })],
    },
    Entry {
        name: "drainage",
        title: "sealed bottom and side",
        place: Place::Contact,
        sign: Sign::Switch,
        scope: Scope::Shared,
        scale: (1.0, ""),
        largest: 1.0,
        mimics: "a lower permeability",
        reveals: "a porous support beside a sealed one",
        courses: &[
            ("boundary.drained_bottom", Course::Fixed { value: 0.0 }),
            ("boundary.drained_side", Course::Fixed { value: 0.0 }),
        ],
    },
    Entry {
        name: "specimen_size",
        title: "finite specimen size",
        place: Place::Specimen,
        sign: Sign::Either,
        scope: Scope::Shared,
        scale: (2.0, "times radius and height"),
        largest: 1.0,
        mimics: "all moduli together",
        reveals: "two punch radii on the same specimen",
        courses: &[
            ("geometry.sample_radius", Course::Times { ratio: 2.0 }),
            ("geometry.sample_height", Course::Times { ratio: 2.0 }),
        ],
    },
    Entry {
        name: "backward_euler",
        title: "time steps of the simulation",
        place: Place::Numerics,
        sign: Sign::Switch,
        scope: Scope::Shared,
        scale: (1.0, ""),
        largest: 1.0,
        mimics: "relaxation times a little longer",
        reveals: "nothing in the data: a finer tolerance of the simulation",
        courses: &[("solver.time_scheme", Course::Fixed { value: 2.0 })],
    },
];

/// All effects that an FMU can compute, and the names of those that it cannot.
pub fn effects(wiring: &Wiring) -> (Vec<Effect>, Vec<String>) {
    let (mut known, mut unknown) = (Vec::new(), Vec::new());
    for entry in ENTRIES {
        match entry.courses.iter().all(|(name, _)| wiring.parameters.contains_key(*name)) {
            true => known.push(entry.effect()),
            false => unknown.push(entry.title.to_owned()),
        }
    }
    (known, unknown)
}

impl Entry {
    fn effect(&self) -> Effect {
        Effect {
            name: self.name.to_owned(),
            title: self.title.to_owned(),
            place: self.place,
            sign: self.sign,
            scope: self.scope,
            scale: self.scale.0,
            unit: self.scale.1.to_owned(),
            largest: self.largest,
            mimics: self.mimics.to_owned(),
            reveals: self.reveals.to_owned(),
            differentiable: true,
            parameters: self.courses.iter().map(|(name, _)| (*name).to_owned()).collect(),
            action: action(self.courses),
        }
    }
}
