//! The flag that names a model.

use super::settings::{Chosen, choice};
use super::solute::{Charges, ChargesArgs, Insides};
use super::terms::{ContactArgs, TermsArgs};
use anyhow::Result;
use clap::Args;
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_protein_verbs::stability::model::Model;
use protomer_protein_verbs::stability::run::RunSettings;
use protomer_protein_verbs::stability::terms::StatedTerms;

/// Choice of a named model.
#[derive(Debug, Clone, Copy, Args)]
pub struct ModelArgs {
    /// Model of the interactions between the bodies; other flags change single terms of it
    /// [default: none; natural-1 for binding, score and stability].
    #[arg(long, value_parser = choice::<Model>())]
    pub model: Option<Model>,
}

impl ModelArgs {
    /// The named model, if any.
    pub fn model(&self) -> Option<Model> {
        self.model
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
        let mut settings = RunSettings {
            effective_charges: None,
            solvent_response: None,
            ..usual
        };
        settings.set_terms(StatedTerms::default());
        self.override_in(&mut settings, charges, terms)?;
        Ok(settings)
    }

    /// Overrides the interactions of settings by those of the model and the flags.
    ///
    /// # Errors
    /// For flags that contradict each other.
    pub fn override_in(
        &self,
        settings: &mut RunSettings,
        charges: &ChargesArgs,
        terms: &TermsArgs,
    ) -> Result<()> {
        let insides = self.charges(charges).insides(Insides {
            effective: settings.effective_charges,
            response: settings.solvent_response,
        })?;
        settings.effective_charges = insides.effective;
        settings.solvent_response = insides.response;
        let terms = self.terms(terms);
        settings.set_terms(terms.over(settings.stated_terms(), ContactCore::Surface)?);
        Ok(())
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
            contacts: Some(Chosen(contacts.map(|term| term.scale))),
            contact_strength: flags.contact_strength.or(strength),
        }
    }
}
