//! Frames in which the assembly holds.
//!
//! Where runs from the assembly and from a fluid disagree, a mean over all frames is a mean over two
//! states: half of the frames are of bodies that never met, and halve every energy.

use crate::stability::run::RunSettings;
use protomer_mc::System;
use protomer_mc::observables::{contacts, survival};

/// A frame counts as bound with more than this part of the contacts of the assembly.
const LEAST_CONTACTS_LEFT: f64 = 0.5;

/// The contacts of the assembly, and which contacts of a frame are compared with them.
#[derive(Debug, Clone)]
pub struct AssemblyContacts {
    native: Vec<(usize, usize)>,
    counts_native: bool,
    gap_angstrom: f64,
}

impl AssemblyContacts {
    /// The contacts of this state.
    pub fn new(assembly: &System, run: &RunSettings) -> Self {
        let gap_angstrom = run.contact_gap_angstrom;
        Self {
            native: contacts(assembly, gap_angstrom),
            // As in the answer of the sweep: at equilibrium bodies change places.
            counts_native: run.exchange_every == 0 && run.is_from_assembly(),
            gap_angstrom,
        }
    }

    /// The fraction of the contacts of the assembly that are left; NaN if it has none.
    pub fn left(&self, system: &System) -> f64 {
        let present = contacts(system, self.gap_angstrom);
        match self.counts_native {
            true => survival(&self.native, &present).unwrap_or(f64::NAN),
            false => present.len() as f64 / self.native.len() as f64,
        }
    }

    /// Whether the assembly holds in this frame; always in a run whose assembly has no contacts.
    pub fn holds(&self, system: &System) -> bool {
        self.native.is_empty() || self.left(system) > LEAST_CONTACTS_LEFT
    }
}
