//! The groups of columns, from cheap to expensive.

protomer_kernel::choices! {
    /// A group of columns.
    pub enum Measure {
        /// Standard binding free energy by the contacts alone, at 150 mM salt.
        Affinity = "affinity",
        /// Energy of the model by terms.
        Energy = "energy",
        /// Buried area.
        Area = "area",
        /// Shape complementarity.
        Shape = "shape",
        /// Contacts of residues, hydrogen bonds and salt bridges across the interface.
        Contacts = "contacts",
        /// Net charges of the two bodies.
        Charge = "charge",
        /// Residues that lack atoms or have low confidence, breaks of chains, clashes.
        Quality = "quality",
        /// Chance that a contact of a crystal is one of a biological assembly.
        Real = "real",
        /// Confidences that a predictor wrote next to the structure: AlphaFold 3, Boltz, ColabFold.
        Confidence = "confidence",
        /// Slope of the association constant with salt, by the Poisson-Boltzmann equation.
        Slope = "slope",
        /// Dissociation constants: calibrated, with the effect of the salt, and integrated over the poses nearby.
        Kd = "kd",
        /// Share that is bound at each salt and at the concentration, and the salt at which half is.
        HalfSalt = "half-salt",
        /// B22 of each body with copies of itself, and whether it attracts or repels them.
        B22 = "b22",
        /// The exchange of charge that would strengthen the complex most, by the Poisson-Boltzmann equation.
        Exchange = "exchange",
    }
}

impl Measure {
    /// The groups that take at most seconds for each complex.
    pub const CHEAP: [Self; 7] = [
        Self::Affinity,
        Self::Energy,
        Self::Area,
        Self::Shape,
        Self::Contacts,
        Self::Charge,
        Self::Quality,
    ];

    /// Whether the group needs the Poisson-Boltzmann equation or the integration.
    pub fn is_solved(self) -> bool {
        matches!(
            self,
            Self::Slope | Self::Kd | Self::HalfSalt | Self::Exchange
        )
    }
}
