//! The flag of verbs that want a potential.

use clap::ValueEnum;
use protomer_field::PotentialModel;

/// How a potential is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PotentialName {
    /// The linearised Poisson-Boltzmann equation.
    PoissonBoltzmann,
    /// The sum of the atoms' Debye-Hückel potentials in a uniform solvent: quicker, and blind to
    /// the dielectric boundary.
    DebyeHueckel,
}

impl PotentialName {
    pub(super) fn model(self) -> PotentialModel {
        match self {
            Self::PoissonBoltzmann => PotentialModel::PoissonBoltzmann,
            Self::DebyeHueckel => PotentialModel::DebyeHueckel,
        }
    }
}
