//! The scalars of a material that results are differentiated by.

/// Parameters that do not belong to a branch.
const COMMON: usize = 6;
/// Parameters of one branch.
const PER_BRANCH: usize = 3;

/// One Ogden spring of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spring {
    /// Of the equilibrium response.
    Equilibrium,
    /// Of a viscous branch, counted from 0.
    Branch(usize),
}

/// One scalar of [`crate::parameters::MaterialParameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaterialParameter {
    /// n0S [-].
    SolidFraction,
    /// lambda* (Pa).
    LambdaStar,
    /// mu_FR (Pa s).
    FluidViscosity,
    /// K0 (m^2).
    Permeability,
    /// mu of a spring (Pa).
    Mu(Spring),
    /// alpha of a spring [-].
    Alpha(Spring),
    /// eta of a branch (Pa s).
    Eta(usize),
}

impl MaterialParameter {
    /// Number of parameters of a material with so many branches.
    pub const fn count(branches: usize) -> usize {
        COMMON + PER_BRANCH * branches
    }

    /// Place in every list of derivatives.
    pub const fn index(self) -> usize {
        use MaterialParameter::{Alpha, Eta, FluidViscosity, LambdaStar, Mu, Permeability, SolidFraction};
        match self {
            SolidFraction => 0,
            LambdaStar => 1,
            FluidViscosity => 2,
            Permeability => 3,
            Mu(Spring::Equilibrium) => 4,
            Alpha(Spring::Equilibrium) => 5,
            Mu(Spring::Branch(branch)) => COMMON + PER_BRANCH * branch,
            Alpha(Spring::Branch(branch)) => COMMON + PER_BRANCH * branch + 1,
            Eta(branch) => COMMON + PER_BRANCH * branch + 2,
        }
    }

    /// All parameters of a material with so many branches, in the order of their indices.
    pub fn all(branches: usize) -> impl Iterator<Item = Self> {
        use MaterialParameter::{Alpha, Eta, FluidViscosity, LambdaStar, Mu, Permeability, SolidFraction};
        let spring = |spring| [Mu(spring), Alpha(spring)];
        [SolidFraction, LambdaStar, FluidViscosity, Permeability]
            .into_iter()
            .chain(spring(Spring::Equilibrium))
            .chain((0..branches).flat_map(move |b| spring(Spring::Branch(b)).into_iter().chain([Eta(b)])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_follow_the_order() {
        let all: Vec<_> = MaterialParameter::all(3).collect();
        assert_eq!(all.len(), MaterialParameter::count(3));
        for (index, parameter) in all.into_iter().enumerate() {
            assert_eq!(parameter.index(), index);
        }
    }
}
