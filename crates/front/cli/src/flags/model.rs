//! The flag that names a model.

use super::solute::{Charges, ChargesArgs, Insides};
use super::terms::{ContactArgs, Scale, TermsArgs};
use anyhow::Result;
use clap::{Args, ValueEnum};
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_protein_verbs::stability::model::Model;
use protomer_protein_verbs::stability::run::RunSettings;

/// Choice of a named model.
#[derive(Debug, Clone, Copy, Args)]
pub struct ModelArgs {
    /// Model of the interactions between the bodies; other flags change single terms of it
    /// [default: none; natural-1 for binding and stability].
    #[arg(long, value_enum)]
    pub model: Option<ModelChoice>,
}

/// The named models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelChoice {
    /// For complexes with native contacts: --interaction response --contacts calvados3 --contact-strength 1.9, for
    /// bodies with native cores.
    #[value(name = "natural-1")]
    Natural1,
    /// For proteins in solution, whose surfaces meet anywhere: natural-1 with --contact-strength
    /// 0.75.
    #[value(name = "solution-1")]
    Solution1,
    /// For proteins in solution whose positive groups bind anions: natural-1 with --contact-strength 0.6
    /// and structure files with --protonation structure --anion-binding 12.
    #[value(name = "solution-2")]
    Solution2,
    /// Model of the thesis: --interaction bare --contacts none, for bodies with hard surfaces.
    Thesis,
}

impl From<ModelChoice> for Model {
    fn from(choice: ModelChoice) -> Self {
        match choice {
            ModelChoice::Natural1 => Self::Natural1,
            ModelChoice::Solution1 => Self::Solution1,
            ModelChoice::Solution2 => Self::Solution2,
            ModelChoice::Thesis => Self::Thesis,
        }
    }
}

impl ModelArgs {
    /// The named model, if any.
    pub fn model(&self) -> Option<Model> {
        self.model.map(Into::into)
    }

    /// A warning for bodies that were made for another model than the named one.
    pub fn body_warning(&self, assembly: &Assembly) -> Option<String> {
        self.model()?.body_warning(&assembly.bodies)
    }

    /// Settings of a pose with the interactions of the model and the flags.
    ///
    /// # Errors
    /// For flags that contradict each other.
    pub fn acting(
        &self,
        charges: &ChargesArgs,
        terms: &TermsArgs,
        usual: RunSettings,
    ) -> Result<RunSettings> {
        let insides = self.charges(charges).insides(Insides::default())?;
        let terms = self.terms(terms);
        Ok(RunSettings {
            effective_charges: insides.effective,
            solvent_response: insides.response,
            contacts: terms.contacts(None, ContactCore::Surface)?,
            desolvation: terms.desolvation,
            ..usual
        })
    }

    /// The flags of the charges, completed by the model.
    pub fn charges(&self, flags: &ChargesArgs) -> ChargesArgs {
        let charges = |model: Model| match model.solvent_response() {
            Some(_) => Charges::Response,
            None => Charges::Bare,
        };
        ChargesArgs {
            interaction: flags.interaction.or(self.model().map(charges)),
            solute: flags.solute.clone(),
        }
    }

    /// The flags of the further terms, completed by the model.
    pub fn terms(&self, flags: &TermsArgs) -> TermsArgs {
        TermsArgs {
            attraction: self.attraction(&flags.attraction),
            ..flags.clone()
        }
    }

    fn attraction(&self, flags: &ContactArgs) -> ContactArgs {
        let Some(model) = self.model().filter(|_| flags.contacts.is_none()) else {
            return flags.clone();
        };
        let contacts = model.contacts();
        let strength = contacts.map(|term| term.strength);
        ContactArgs {
            contacts: Some(contacts.map_or(Scale::None, |term| term.scale.into())),
            contact_strength: flags.contact_strength.or(strength),
        }
    }
}
