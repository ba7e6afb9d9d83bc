//! Charges of bodies whose groups take up and lose protons: each body has a state of its own.

use crate::charges::ChargeCloud;
use crate::moves::protonation;
use crate::system::System;
use crate::titratable::TitratableCharges;
use crate::{McError, Result};
use protomer_kernel::random::CounterRng;
use std::sync::Arc;

/// States and charges of the bodies of a system.
#[derive(Debug, Clone)]
pub(super) struct Protons {
    /// Groups by type of body; `None` for a type whose charges are fixed.
    groups: Vec<Option<Arc<TitratableCharges>>>,
    /// Charged groups of each body.
    states: Vec<Vec<bool>>,
    clouds: Vec<ChargeCloud>,
}

/// A change of the protons of a body.
pub(super) struct Change {
    /// Rise of the total energy up to which it is accepted, kT.
    pub budget_kt: f64,
    /// Rise of the energy of the body itself, kT.
    pub own_kt: f64,
    /// Differences of its charges, new less old.
    pub charges: ChargeCloud,
    /// Charged groups afterwards.
    pub states: Vec<bool>,
}

impl Protons {
    pub fn new(groups: Vec<Option<Arc<TitratableCharges>>>) -> Self {
        Self {
            groups,
            states: Vec::new(),
            clouds: Vec::new(),
        }
    }

    fn groups_of(&self, kind: usize) -> Option<&TitratableCharges> {
        self.groups.get(kind).and_then(Option::as_deref)
    }

    /// Σ|q| (e) and radius (Å) of the strongest charges that bodies of a type can have.
    pub fn strongest(&self, system: &System, kind: usize) -> (f64, f64) {
        match self.groups_of(kind) {
            Some(groups) => (groups.sum_of_magnitudes_e(), groups.radius_angstrom()),
            None => {
                let charges = &system.types()[kind].charges;
                (charges.sum_of_magnitudes_e(), charges.radius_angstrom())
            }
        }
    }

    /// Finds the charges of all bodies in their states; bodies without a state begin with one.
    pub fn prepare(&mut self, system: &System) {
        if self.states.len() != system.len() {
            let start = |body: usize| match self.groups_of(system.type_index(body)) {
                Some(groups) => groups.start(),
                None => Vec::new(),
            };
            self.states = (0..system.len()).map(start).collect();
        }
        let charges = |body: usize| match self.groups_of(system.type_index(body)) {
            Some(groups) => groups.charges(&self.states[body]),
            None => system.body_type(body).charges.clone(),
        };
        self.clouds = (0..system.len()).map(charges).collect();
    }

    /// Present charges of a body.
    pub fn charges(&self, body: usize) -> &ChargeCloud {
        &self.clouds[body]
    }

    /// A random change of a body of this type; `None` if none of its groups changes.
    pub fn propose(&self, kind: usize, body: usize, rng: &mut CounterRng) -> Option<Change> {
        let groups = self.groups_of(kind)?;
        let budget_kt = -rng.uniform().ln();
        let changed = protonation::propose(&self.states[body], rng);
        if changed.is_empty() {
            return None;
        }
        let mut states = self.states[body].clone();
        for group in &changed {
            states[*group] = !states[*group];
        }
        Some(Change {
            budget_kt,
            own_kt: groups.energy_kt(&states) - groups.energy_kt(&self.states[body]),
            charges: groups.change(&changed, &states),
            states,
        })
    }

    /// Gives a body of this type these charged groups.
    pub fn take(&mut self, kind: usize, body: usize, states: Vec<bool>) {
        if let Some(groups) = self.groups_of(kind) {
            self.clouds[body] = groups.charges(&states);
            self.states[body] = states;
        }
    }

    /// Charged groups of each body.
    pub fn states(&self) -> &[Vec<bool>] {
        &self.states
    }

    /// Gives all bodies the groups of a checkpoint.
    ///
    /// # Errors
    /// [`McError::ForeignCheckpoint`] if the groups are others.
    pub fn take_all(&mut self, system: &System, states: &[Vec<bool>]) -> Result<()> {
        let groups = |body: usize| {
            self.groups_of(system.type_index(body))
                .map_or(0, |groups| groups.len())
        };
        let is_of_system = states.len() == system.len()
            && (0..system.len()).all(|body| states[body].len() == groups(body));
        if !is_of_system {
            let difference = "it has other titratable groups".into();
            return Err(McError::ForeignCheckpoint(difference));
        }
        self.states = states.to_vec();
        Ok(())
    }

    /// Net charge of each body, e.
    pub fn net_charges_e(&self) -> Vec<f64> {
        self.clouds.iter().map(ChargeCloud::net_charge_e).collect()
    }
}
