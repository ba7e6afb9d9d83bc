//! The contact term: attraction between residues by a published scale, and its strength.

use anyhow::{Result, bail};
use protomer_body::residue_contacts::ContactScale;
use protomer_kernel::setting::Choices;
use protomer_mc::BodyType;
use protomer_mc::energy::ContactPotential;
use serde::{Deserialize, Serialize};

/// A contact term as it is stated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactTerm {
    /// The scale.
    pub scale: ContactScale,
    /// Factor of the published attraction.
    pub strength: f64,
    /// Core that keeps residues of different bodies apart.
    #[serde(default)]
    pub core: ContactCore,
}

protomer_kernel::choices! {
    /// Cores that keep residues of different bodies apart.
    pub enum ContactCore, default Surface {
        /// The solvent-excluded surfaces.
        Surface = "surface",
        /// The beads of the published force field, for comparison with programs that have no surfaces.
        Beads = "beads",
    }
}

impl ContactTerm {
    /// The potential at a temperature (K).
    ///
    /// # Errors
    /// For a strength out of range.
    pub fn potential(&self, temperature_kelvin: f64) -> Result<ContactPotential> {
        Ok(match self.core {
            ContactCore::Surface => {
                ContactPotential::new(self.scale, self.strength, temperature_kelvin)?
            }
            ContactCore::Beads => {
                ContactPotential::with_cores(self.scale, self.strength, temperature_kelvin)?
            }
        })
    }

    /// Refuses a body without residues.
    ///
    /// # Errors
    /// Names the body.
    pub fn require_beads(&self, kind: &BodyType) -> Result<()> {
        if kind.beads.is_empty() {
            bail!(
                "body '{}' has no amino acids, so the contact term '{}' does not know it; ingest it \
                 from a PDB or mmCIF file, or use --contacts none",
                kind.name,
                self.scale.name()
            );
        }
        Ok(())
    }

    /// Description of the contact term in one line.
    ///
    /// ```
    /// use protomer_body::residue_contacts::ContactScale;
    /// use protomer_protein_verbs::stability::contacts::{ContactCore, ContactTerm};
    /// let term = ContactTerm {
    ///     scale: ContactScale::Calvados3,
    ///     strength: 0.75,
    ///     core: ContactCore::Surface,
    /// };
    /// assert_eq!(term.describe(), "contacts calvados3 × 0.75");
    /// ```
    pub fn describe(&self) -> String {
        let core = match self.core {
            ContactCore::Surface => "",
            ContactCore::Beads => ", with the cores of the beads",
        };
        format!("contacts {} × {}{core}", self.scale.name(), self.strength)
    }
}
