//! A number per residue, to colour by.

use protomer_body::chemistry::LARGEST_HYDROPATHY;
use protomer_body::{Body, Residue};

protomer_kernel::choices! {
    /// Property of residues.
    pub enum ResidueValues {
        /// The net charge of the residue at the pH of the body, e.
        Charge = "charge",
        /// The hydropathy index; zero where it has none.
        Hydropathy = "hydropathy",
    }
}

impl ResidueValues {
    /// The value of each residue of a body.
    pub fn evaluate(self, body: &Body) -> Vec<f64> {
        let value = |residue: &Residue| match self {
            Self::Charge => residue.charge_e,
            Self::Hydropathy => residue.hydropathy.unwrap_or(0.0),
        };
        body.residues.iter().map(value).collect()
    }

    /// The value at the ends of a colour scale.
    pub(super) fn limit(self) -> f64 {
        match self {
            Self::Charge => 1.0,
            Self::Hydropathy => LARGEST_HYDROPATHY,
        }
    }
}
