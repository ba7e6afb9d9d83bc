//! What is asked of a complex.

use super::estimate::salts_to_solve;
use crate::bodies::chain_groups::ChainNames;
use crate::stability::contacts::ContactTerm;
use crate::stability::interaction::InteractionSettings;
use crate::stability::model::Model;
use anyhow::{Result, bail};
use protomer_body::chemistry::{StructureProtonation, StructureTitration};
use protomer_body::structure::SelectionSettings;
use protomer_common::range;
use protomer_field::{DielectricModel, IonModel, SaltValence, SolveSettings};
use protomer_kernel::{Electrolyte, Pose};
use std::path::PathBuf;

/// A complex, the conditions, and how to solve.
#[derive(Debug, Clone, PartialEq)]
pub struct BindingSettings {
    /// Structure, PQR or body file of the receptor, or of the whole complex.
    pub receptor: PathBuf,
    /// Structure, PQR or body file of the ligand, in the frame of the receptor.
    pub ligand: Option<PathBuf>,
    /// The chains of the two bodies; empty for a file each, or for the two chains of one file.
    pub bodies: Vec<ChainNames>,
    /// Motion of the ligand from its place in the file, as that of a symmetry copy in a crystal.
    pub ligand_motion: Option<Pose>,
    /// The model that says which bodies are made and how charges interact, for the energy of simulations.
    pub model: Model,
    /// Attraction between residues, for the energy of simulations.
    pub contacts: Option<ContactTerm>,
    /// Selection of the atoms of structure files.
    pub selection: SelectionSettings,
    /// pH values at which structure files are charged; the usual one if empty.
    pub ph: Vec<f64>,
    /// Titration of structure files at the first salt; pKa values in water for `None`.
    pub titration: Option<StructureTitration>,
    /// Concentrations of a 1:1 salt, mol/L. Differences are from the first.
    pub salt_molar: Vec<f64>,
    /// Temperature, K.
    pub temperature_kelvin: f64,
    /// Relative permittivity of the solvent; that of water at the temperature for `None`.
    pub outer_permittivity: Option<f64>,
    /// Relative permittivity inside the bodies.
    pub inner_permittivity: f64,
    /// Distance of the centres of ions from the atoms, Å.
    pub ion_radius_angstrom: f64,
    /// Response of the ions to the potential.
    pub ions: IonModel,
    /// Spacing of the fine grid, Å.
    pub spacing_angstrom: f64,
    /// Least distance of the atoms from the faces of the fine grid, Å.
    pub margin_angstrom: f64,
    /// Whether to integrate the dissociation constant over the poses around the given one.
    pub integrates: bool,
    /// Seed of the random numbers of the integration.
    pub seed: u64,
    /// Whether to find what single exchanges of charge at the interface would change.
    pub exchanges: bool,
    /// Whether to titrate the complex and both bodies for the protons that they take up on binding.
    pub proton_uptake: bool,
}

impl Default for BindingSettings {
    fn default() -> Self {
        Self {
            receptor: PathBuf::new(),
            ligand: None,
            bodies: Vec::new(),
            ligand_motion: None,
            model: Model::Natural1,
            contacts: Model::Natural1.contacts(),
            selection: SelectionSettings::default(),
            ph: Vec::new(),
            titration: None,
            salt_molar: Vec::new(),
            temperature_kelvin: 298.15,
            outer_permittivity: None,
            inner_permittivity: 2.0,
            ion_radius_angstrom: 2.0,
            ions: IonModel::Linear,
            spacing_angstrom: Self::SPACING_ANGSTROM,
            margin_angstrom: Self::MARGIN_ANGSTROM,
            integrates: true,
            seed: 1,
            exchanges: false,
            proton_uptake: false,
        }
    }
}

impl BindingSettings {
    /// The default of [`Self::spacing_angstrom`].
    pub const SPACING_ANGSTROM: f64 = 0.7;
    /// The default of [`Self::margin_angstrom`].
    pub const MARGIN_ANGSTROM: f64 = 10.0;

    /// The solvent at each salt concentration to solve for.
    ///
    /// # Errors
    /// Without a salt concentration, and for a number out of range.
    pub fn electrolytes(&self) -> Result<Vec<Electrolyte>> {
        if self.salt_molar.is_empty() {
            bail!("the salt is not known; add --salt 50mM,150mM");
        }
        if self.exchanges && self.ions != IonModel::Linear {
            bail!(
                "--exchanges rests on energies that are quadratic in the charges; leave out --ions \
                 boltzmann, or compare two runs with and without the exchange"
            );
        }
        for ph in &self.ph {
            range::PH.require("ph", *ph)?;
        }
        let medium = self.medium();
        let mut electrolytes = Vec::new();
        for salt_molar in salts_to_solve(self) {
            electrolytes.push(medium.interaction(Some(salt_molar))?.electrolyte);
        }
        Ok(electrolytes)
    }

    /// The medium of the fast interaction.
    pub(in crate::stability) fn medium(&self) -> InteractionSettings {
        InteractionSettings {
            temperature_kelvin: self.temperature_kelvin,
            relative_permittivity: self.outer_permittivity,
            ..InteractionSettings::default()
        }
    }

    /// Conditions of the titration of structure files.
    pub(super) fn protonation(&self) -> Option<StructureProtonation> {
        let (titration, salt_molar) = self.titration.zip(self.salt_molar.first().copied())?;
        Some(titration.conditions(salt_molar, self.temperature_kelvin))
    }

    pub(super) fn dielectric(&self, electrolyte: Electrolyte) -> DielectricModel {
        DielectricModel {
            inner_permittivity: self.inner_permittivity,
            ion_radius_angstrom: self.ion_radius_angstrom,
            ion_response: self.ions.with(SaltValence::ONE_TO_ONE),
            ..DielectricModel::new(electrolyte)
        }
    }

    pub(super) fn solve(&self) -> SolveSettings {
        SolveSettings {
            spacing_angstrom: self.spacing_angstrom,
            margin_angstrom: self.margin_angstrom,
            ..SolveSettings::default()
        }
    }
}
