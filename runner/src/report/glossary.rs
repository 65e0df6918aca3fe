//! The words of the pages, and what the symbols mean.

use maud::{Markup, html};
use poropunch::variables;

const TERMS: [(&str, &str); 12] = [
    (
        "χ²",
        "Sum of squared differences between measured and model, each in units of the noise, correlations of the noise \
            taken out. Per degree of freedom (points minus fitted values) it is about 1 where the model meets the data to \
            their noise, larger where it misses them, far below 1 where the noise is overestimated.",
    ),
    (
        "whitened",
        "Divided by the noise with its correlations taken out, so that what is left of pure noise is independent with \
                  standard deviation 1.",
    ),
    (
        "95 % interval",
        "Values that the data and the prior range allow: in 95 of 100 repetitions such an interval holds the true \
                       value, if the model is right.",
    ),
    ("open", "The interval reaches the bound: the data set no limit on that side."),
    ("profile", "The best χ² for each given value of one parameter, everything else fitted again."),
    (
        "G",
        "Shear modulus at small strain (Pa): G = μ α / 2 of each Ogden term. G∞ is what remains after full relaxation, G₀ \
           the sum of all: the modulus of an instantaneous load.",
    ),
    (
        "μ, α",
        "Modulus (Pa) and exponent (-) of an Ogden term. Their product gives G; α alone is how fast the stiffness changes \
              with strain.",
    ),
    ("η, τ", "Viscosity (Pa s) of a viscous branch and its relaxation time (s), τ = η / G."),
    (
        "K₀, kᶠ",
        "Intrinsic permeability (mm²) and hydraulic conductivity (m/s): how easily water flows through the solid.",
    ),
    (
        "evidence",
        "Twice the natural logarithm of how much more probable the data are under one model than under another, the \
                  price of its free parameters included. 6 is strong, 10 very strong.",
    ),
    (
        "score",
        "How many standard deviations of the noise a pattern in the residuals has; 3 is rare by chance alone.",
    ),
    (
        "specimen",
        "One piece of material that was tested. The force is the median of the specimens; their scatter is an error \
                  that a whole curve shares.",
    ),
];

/// The glossary, folded.
pub fn glossary() -> Markup {
    html! {
        h2 id="glossary" { "Glossary" }
        details {
            summary { "χ², whitened, evidence, G, α, …" }
            dl { @for (term, meaning) in TERMS { dt { (term) } dd { (meaning) } } }
        }
    }
}

/// What a parameter of poropunch's own model is; empty for others.
pub fn meaning(name: &str) -> &'static str {
    variables::by_name(name).map_or("", |(_, v)| v.description)
}
