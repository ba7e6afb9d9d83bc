//! Named models: what acts between bodies, as one choice.
//!
//! | name | charges | attraction between residues | hard core |
//! |---|---|---|---|
//! | `natural-1` | those of the bodies, with the response of the solvent | Calvados 3, times 1.9 | native |
//! | `solution-1` | the same | Calvados 3, times 0.75 | native |
//! | `solution-2` | the same, for bodies titrated with bound anions | Calvados 3, times 0.6 | native |
//! | `thesis` | those of the bodies | none | the surface |
//!
//! Each strength is one number that was fitted: that of `natural-1` to the affinities of complexes, whose surfaces are made for each
//! other, and that of `solution-1` to the second virial coefficients of lysozyme at pH 4.5, where any surface meets any other. No one
//! strength serves both. `solution-2` has two numbers, the strength and the binding constant of anions, fitted to
//! lysozyme at pH 7 and 4.5. A model never changes under its name; a better one gets the next number.

use super::contacts::{ContactCore, ContactTerm};
use super::effective::SoluteModel;
use super::terms::FurtherTerms;
use protomer_body::chemistry::StructureTitration;
use protomer_body::residue_contacts::ContactScale;
use protomer_body::{ANION_BINDING_SETTING, Body, BodySettings, HardCore};
use protomer_kernel::setting::Choices;
use std::sync::Arc;

/// Name of terms that are no model's.
pub const OWN_TERMS: &str = "own terms";

protomer_kernel::choices! {
    /// A named model.
    ///
    /// ```
    /// use protomer_body::HardCore;
    /// use protomer_kernel::setting::Choices;
    /// use protomer_protein_verbs::stability::model::Model;
    /// let names: Vec<&str> = Model::ALL.iter().map(|model| model.name()).collect();
    /// assert_eq!(names, ["natural-1", "solution-1", "solution-2", "thesis"]);
    /// assert_eq!((Model::Thesis.core(), Model::Thesis.contacts()), (HardCore::Surface, None));
    /// ```
    pub enum Model {
        /// For complexes with native contacts: --interaction response --contacts calvados3 --contact-strength 1.9, for
        /// bodies with native cores.
        Natural1 = "natural-1",
        /// For proteins in solution, whose surfaces meet anywhere: natural-1 with --contact-strength
        /// 0.75.
        Solution1 = "solution-1",
        /// For proteins in solution whose positive groups bind anions: natural-1 with --contact-strength 0.6
        /// and structure files with --protonation structure --anion-binding 12.
        Solution2 = "solution-2",
        /// Model of the thesis: --interaction bare --contacts none, for bodies with hard surfaces.
        Thesis = "thesis",
    }
}

impl Model {
    /// Attraction between residues.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::model::Model;
    /// let strength = |model: Model| model.contacts().map(|term| term.strength);
    /// assert_eq!((strength(Model::Natural1), strength(Model::Solution1)), (Some(1.9), Some(0.75)));
    /// ```
    pub fn contacts(self) -> Option<ContactTerm> {
        let calvados = |strength| ContactTerm {
            scale: ContactScale::Calvados3,
            strength,
            core: ContactCore::Surface,
        };
        match self {
            Self::Natural1 => Some(calvados(1.9)),
            Self::Solution1 => Some(calvados(0.75)),
            Self::Solution2 => Some(calvados(0.6)),
            Self::Thesis => None,
        }
    }

    /// The inside of the bodies, whose displaced salt water responds to the charges of both.
    pub fn solvent_response(self) -> Option<SoluteModel> {
        match self {
            Self::Natural1 | Self::Solution1 | Self::Solution2 => Some(SoluteModel::default()),
            Self::Thesis => None,
        }
    }

    /// Hard core of the bodies of this model.
    pub fn core(self) -> HardCore {
        match self {
            Self::Natural1 | Self::Solution1 | Self::Solution2 => HardCore::Native,
            Self::Thesis => HardCore::Surface,
        }
    }

    /// Titration of structure files for this model, in the salt of the medium; pKa values in water for `None`.
    pub fn titration(self) -> Option<StructureTitration> {
        match self {
            Self::Solution2 => Some(StructureTitration {
                anion_binding_per_molar: 12.0,
            }),
            Self::Natural1 | Self::Solution1 | Self::Thesis => None,
        }
    }

    /// The settings that make bodies of structure files for this model.
    pub fn body_settings(self) -> BodySettings {
        let mut settings = BodySettings::default();
        // Points without elements have no native core; their surface is hard unless the model insists.
        settings.surface.core = Some(self.core()).filter(|core| *core == HardCore::Surface);
        settings
    }

    /// Terms in addition to the charges.
    fn terms(self) -> FurtherTerms {
        FurtherTerms {
            contacts: self.contacts(),
            response: self.solvent_response(),
            ..FurtherTerms::default()
        }
    }

    /// The model with these terms between bodies whose own charges interact; `None` if no model has them.
    pub fn with_terms(terms: &FurtherTerms) -> Option<Self> {
        let is_it = |model: &Self| *terms == model.terms();
        Self::ALL.iter().copied().find(is_it)
    }

    /// The first body of residues whose hard core is not that of the model.
    fn other_core(self, bodies: &[Arc<Body>]) -> Option<&Body> {
        let is_native = self.core() == HardCore::Native;
        let is_other = |body: &&Body| !body.residues.is_empty() && body.core.is_some() != is_native;
        bodies.iter().map(AsRef::as_ref).find(is_other)
    }

    /// The first body of residues whose charges are not from the titration of the model.
    fn other_charges(self, bodies: &[Arc<Body>]) -> Option<&Body> {
        let constant = self.titration()?.anion_binding_per_molar.to_string();
        let is_other = |body: &&Body| {
            let stated = body.provenance.settings.get(ANION_BINDING_SETTING);
            !body.residues.is_empty() && stated != Some(&constant)
        };
        bodies.iter().map(AsRef::as_ref).find(is_other)
    }

    /// A warning for bodies whose hard core or charges are not those of the model.
    pub fn body_warning(self, bodies: &[Arc<Body>]) -> Option<String> {
        let (flags, difference, other) = match (self.other_core(bodies), self.other_charges(bodies))
        {
            (Some(other), _) => (
                format!("--core {}", self.core().name()),
                "energies at contact are",
                other,
            ),
            (None, Some(other)) => {
                let titration = self.titration()?;
                let constant = titration.anion_binding_per_molar;
                let flags = format!(
                    "--protonation structure --anion-binding {constant} and --protonation-salt of the medium"
                );
                (flags, "charges are", other)
            }
            (None, None) => return None,
        };
        Some(format!(
            "warning: the model {} is meant for bodies made with {flags}, which '{}' is not: its {difference} \
             another model's; ingest it again",
            self.name(),
            other.name
        ))
    }
}

/// The name of the model of these bodies with these terms, `has_own_charges` where the charges of the bodies
/// themselves interact.
pub fn name_of_terms(
    terms: &FurtherTerms,
    has_own_charges: bool,
    bodies: &[Arc<Body>],
) -> &'static str {
    let is_whole = |model: &Model| {
        has_own_charges
            && model.other_core(bodies).is_none()
            && model.other_charges(bodies).is_none()
    };
    let model = Model::with_terms(terms).filter(is_whole);
    model.map_or(OWN_TERMS, Model::name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_named_by_the_model_that_has_them() {
        for &model in Model::ALL {
            let terms = model.terms();
            assert_eq!(name_of_terms(&terms, true, &[]), model.name());
            assert!(model.body_warning(&[]).is_none());
            assert_eq!(name_of_terms(&terms, false, &[]), OWN_TERMS);
            let desolvated = FurtherTerms {
                desolvation: Some(SoluteModel::default()),
                ..terms
            };
            assert_eq!(name_of_terms(&desolvated, true, &[]), OWN_TERMS);
        }
    }
}
