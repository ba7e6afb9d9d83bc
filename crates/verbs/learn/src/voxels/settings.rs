//! The settings of voxel grids.

use anyhow::{Result, bail};
use protomer_body::chemistry::StructureTitration;
use protomer_field::DielectricModel;
use protomer_field::voxels::{Channel, Lattice, Orientation, PotentialModel, VoxelSettings};
use protomer_kernel::Electrolyte;
use protomer_kernel::setting::Choices;
use serde::{Deserialize, Serialize};

/// Edge of the voxels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Spacing {
    /// One edge for all structures, Å.
    Angstrom(f64),
    /// An edge for each structure, with which it fills the grid.
    Fit(Fit),
}

/// The word `fit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// The word `fit`.
    Fit,
}

impl Spacing {
    /// Parses a length in Å, or `fit`.
    ///
    /// ```
    /// use protomer_learn_verbs::voxels::{Fit, Spacing};
    /// assert_eq!(Spacing::parse("0.1nm")?, Spacing::Angstrom(1.0));
    /// assert_eq!(Spacing::parse("fit")?, Spacing::Fit(Fit::Fit));
    /// assert!(Spacing::parse("fill").is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Quotes the input and gives the accepted form.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "fit" => Ok(Spacing::Fit(Fit::Fit)),
            _ => match protomer_common::quantity::length_angstrom(text) {
                Ok(length) => Ok(Spacing::Angstrom(length)),
                Err(error) => bail!("{error}, or 'fit'"),
            },
        }
    }
}

/// Everything that determines a sample besides the structure and its name.
///
/// ```
/// use protomer_learn_verbs::voxels::{Spacing, VoxelizeSettings};
/// let settings = VoxelizeSettings {
///     size: 32,
///     spacing: Spacing::parse("2.0")?,
///     ..VoxelizeSettings::default()
/// };
/// settings.check()?;
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VoxelizeSettings {
    /// Voxels along each edge.
    pub size: usize,
    /// Edge of a voxel.
    pub spacing: Spacing,
    /// Channels in order.
    pub channels: Vec<Channel>,
    /// The orientation of structures.
    pub orientation: Orientation,
    /// Seed of random orientations.
    pub seed: u64,
    /// The model of the potential.
    pub potential: PotentialModel,
    /// Salt, mol/L.
    pub salt_molar: f64,
    /// Temperature, K.
    pub temperature_kelvin: f64,
    /// pH of the protonation.
    pub ph: f64,
    /// Titration of the structures in this salt; pKa values in water for `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub titration: Option<StructureTitration>,
    /// Probe radius of the surface, Å.
    pub probe_angstrom: f64,
    /// Range of the hydropathy: residues with an atom within this distance of a voxel count, Å.
    pub hydropathy_reach_angstrom: f64,
    /// Structures are excluded if a larger share of their residues lacks heavy atoms.
    pub most_incomplete: f64,
    /// For interfaces: voxels of one body are kept if an atom of the other is this near, Å.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interface_reach_angstrom: Option<f64>,
}

impl Default for VoxelizeSettings {
    fn default() -> Self {
        Self {
            size: 64,
            spacing: Spacing::Angstrom(1.0),
            channels: vec![Channel::Shape, Channel::Potential, Channel::Hydropathy],
            orientation: Orientation::Random,
            seed: 0,
            potential: PotentialModel::PoissonBoltzmann,
            salt_molar: 0.15,
            temperature_kelvin: 298.15,
            ph: 7.4,
            titration: None,
            probe_angstrom: 1.4,
            hydropathy_reach_angstrom: 5.0,
            most_incomplete: 0.25,
            interface_reach_angstrom: None,
        }
    }
}

impl VoxelizeSettings {
    /// The usual reach of an interface.
    pub const INTERFACE_REACH_ANGSTROM: f64 = 8.0;

    /// Checks the settings.
    ///
    /// # Errors
    /// Names the setting and its range.
    pub fn check(&self) -> Result<()> {
        let spacing = match self.spacing {
            Spacing::Angstrom(spacing) => spacing,
            Spacing::Fit(_) => 1.0,
        };
        Lattice::new(self.size, spacing)?;
        if self.channels.is_empty() {
            bail!("no channels are given; give at least one");
        }
        for (place, channel) in self.channels.iter().enumerate() {
            let is_of_partner = Channel::PARTNER.contains(channel);
            if is_of_partner && self.interface_reach_angstrom.is_none() {
                bail!(
                    "the channel {} is that of a partner; give a manifest with a column 'partner'",
                    channel.name()
                );
            }
            let is_alone = matches!(channel, Channel::Solid | Channel::Spacing);
            if is_alone && self.interface_reach_angstrom.is_some() {
                bail!(
                    "the channel {} is that of one body alone; choose others for interfaces",
                    channel.name()
                );
            }
            if self.channels[..place].contains(channel) {
                bail!(
                    "the channel {} is given twice; give it once",
                    channel.name()
                );
            }
        }
        let ranges = [
            ("the probe radius", self.probe_angstrom, 0.1, 20.0, " Å"),
            (
                "the range of the hydropathy",
                self.hydropathy_reach_angstrom,
                0.1,
                50.0,
                " Å",
            ),
            (
                "the share of incomplete residues",
                self.most_incomplete,
                0.0,
                1.0,
                "",
            ),
            (
                "the reach of an interface",
                self.interface_reach_angstrom.unwrap_or(1.0),
                1.0,
                50.0,
                " Å",
            ),
            ("the pH", self.ph, -10.0, 30.0, ""),
        ];
        for (quantity, value, low, high, unit) in ranges {
            if !(low..=high).contains(&value) {
                bail!("{quantity} is {value}; give {low} to {high}{unit}");
            }
        }
        self.voxel_settings()?;
        Ok(())
    }

    /// Converts the settings to those for the voxels of one structure.
    ///
    /// # Errors
    /// For unphysical solvent conditions.
    pub fn voxel_settings(&self) -> Result<VoxelSettings> {
        let electrolyte = Electrolyte::in_water(self.temperature_kelvin, self.salt_molar)?;
        let dielectric = DielectricModel {
            probe_angstrom: self.probe_angstrom,
            ..DielectricModel::new(electrolyte)
        };
        Ok(VoxelSettings {
            channels: self.channels.clone(),
            potential: self.potential,
            hydropathy_reach_angstrom: self.hydropathy_reach_angstrom,
            ..VoxelSettings::new(dielectric)
        })
    }

    /// Channels that are 1 in every occupied voxel: the shape, if only the shell is occupied.
    pub fn implied_channels(&self) -> Vec<String> {
        let has = |channel| self.channels.contains(&channel);
        let is_alone = self.interface_reach_angstrom.is_none();
        match is_alone && has(Channel::Shape) && !has(Channel::Solid) {
            true => vec![Channel::Shape.name().to_owned()],
            false => Vec::new(),
        }
    }
}
