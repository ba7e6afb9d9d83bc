//! The terms of the energy in addition to the charges: attraction between residues, desolvation,
//! and the response of the solvent.

use crate::stability::contacts::ContactTerm;
use crate::stability::effective::SoluteModel;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::response::response_of;
use anyhow::{Context, Result};
use protomer_body::Body;
use protomer_mc::BodyType;
use protomer_mc::charges::ChargeCloud;
use protomer_mc::desolvation::{Desolvation, DesolvationBody, Solute};
use protomer_mc::energy::ContactPotential;
use protomer_mc::energy::terms::Terms;
use protomer_mc::pair::Contacts;
use protomer_mc::solvent_response::{ResponseBody, SolventResponse};
use std::sync::Arc;

/// Terms of the energy in addition to the charges, as settings state them; what they need of the inside of the
/// bodies is stated with the charges.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StatedTerms {
    /// Attraction between residues.
    pub contacts: Option<ContactTerm>,
    /// Whether charges lose solvent to other bodies; with effective charges only.
    pub desolvation: bool,
}

impl StatedTerms {
    /// The terms with the inside of the bodies for effective charges and for the response of the solvent.
    pub fn with_insides(
        &self,
        effective: Option<SoluteModel>,
        response: Option<SoluteModel>,
    ) -> FurtherTerms {
        FurtherTerms {
            contacts: self.contacts,
            desolvation: self.desolvation.then(|| effective.unwrap_or_default()),
            response,
        }
    }
}

/// Terms of the energy in addition to the charges.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FurtherTerms {
    /// Attraction between residues.
    pub contacts: Option<ContactTerm>,
    /// The inside of bodies, where charges lose solvent to other bodies.
    pub desolvation: Option<SoluteModel>,
    /// The inside of bodies, whose salt water responds to the charges of both.
    pub response: Option<SoluteModel>,
}

/// The terms of several kinds of bodies in one medium, prepared once.
pub struct PreparedTerms {
    contacts: Option<ContactPotential>,
    desolvation: Vec<Arc<DesolvationBody>>,
    response: Vec<Arc<ResponseBody>>,
}

impl FurtherTerms {
    /// Whether there are no further terms.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Prepares the terms for these kinds of bodies, each with the charges that interact.
    ///
    /// # Errors
    /// For a body without residues where contacts act, and for a medium in which desolvation is not
    /// known.
    pub fn prepare(
        &self,
        kinds: &[(&Body, &BodyType, &ChargeCloud)],
        interaction: &ScreenedCoulomb,
    ) -> Result<PreparedTerms> {
        let temperature_kelvin = interaction.electrolyte.temperature_kelvin();
        let contacts = match &self.contacts {
            Some(contacts) => {
                for (_, kind, _) in kinds {
                    contacts.require_beads(kind)?;
                }
                Some(contacts.potential(temperature_kelvin)?)
            }
            None => None,
        };
        let mut desolvation = Vec::new();
        if let Some(solute) = &self.desolvation {
            for (_, kind, charges) in kinds {
                desolvation.push(Arc::new(desolvated(kind, charges, interaction, solute)?));
            }
        }
        let mut response = Vec::new();
        if let Some(solute) = &self.response {
            for (body, _, _) in kinds {
                response.push(Arc::new(response_of(body, interaction, solute)?));
            }
        }
        Ok(PreparedTerms {
            contacts,
            desolvation,
            response,
        })
    }
}

fn desolvated(
    kind: &BodyType,
    charges: &ChargeCloud,
    interaction: &ScreenedCoulomb,
    solute: &SoluteModel,
) -> Result<DesolvationBody> {
    let solvent = interaction.electrolyte.relative_permittivity();
    let solute = Solute {
        permittivity_ratio: solute.inner_permittivity / solvent,
        ion_radius_angstrom: solute.ion_radius_angstrom,
    };
    DesolvationBody::new(kind, charges, &interaction.yukawa()?, &solute)
        .with_context(|| format!("desolvation of body '{}'", kind.name))
}

impl PreparedTerms {
    /// The terms of two bodies, by the numbers of their kinds.
    pub fn terms(&self, kinds: &[&BodyType], first: usize, second: usize) -> Terms {
        let mut terms = Terms::default();
        if let Some(contacts) = &self.contacts {
            let beads = (&kinds[first].beads, &kinds[second].beads);
            let contacts = Contacts::new(contacts.clone(), beads.0, beads.1);
            terms.0.push(Arc::new(contacts));
        }
        if !self.desolvation.is_empty() {
            let desolvation = |kind: usize| Arc::clone(&self.desolvation[kind]);
            terms.0.push(Arc::new(Desolvation::new(
                desolvation(first),
                desolvation(second),
            )));
        }
        if !self.response.is_empty() {
            let response = |kind: usize| Arc::clone(&self.response[kind]);
            terms.0.push(Arc::new(SolventResponse::new(
                response(first),
                response(second),
            )));
        }
        terms
    }
}
