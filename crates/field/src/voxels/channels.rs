//! Atoms in, sparse values out.

use super::hydropathy::HydropathyMap;
use super::lattice::Lattice;
use super::outer::at_surface;
use super::shell::{Occupied, occupied};
use crate::debye_huckel::Superposition;
use crate::poisson_boltzmann::{ChargedSphere, DielectricModel, SolveSettings, solve};
use crate::surface::solvent_excluded;
use crate::{FieldError, Result};
use protomer_body::surface::{ImplicitSolid, SesSolid};
use protomer_kernel::{Rotation, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a voxel can carry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// 1 where the solvent-excluded surface passes through: |d| ≤ h/2 with d the distance of the
    /// centre from it.
    Shape,
    /// 1 where the centre is inside the surface.
    Solid,
    /// Electrostatic potential, kT/e, at the point of the surface nearest to the voxel's centre; 0
    /// off the shell.
    Potential,
    /// Kyte-Doolittle index averaged over the residues near by, -4.5 to 4.5; 0 off the shell.
    Hydropathy,
}

impl Channel {
    /// All channels.
    pub const ALL: [Channel; 4] = [
        Channel::Shape,
        Channel::Solid,
        Channel::Potential,
        Channel::Hydropathy,
    ];

    /// The channel's name.
    pub fn name(self) -> &'static str {
        match self {
            Channel::Shape => "shape",
            Channel::Solid => "solid",
            Channel::Potential => "potential",
            Channel::Hydropathy => "hydropathy",
        }
    }
}

/// Which potential.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PotentialModel {
    /// The linearised Poisson-Boltzmann equation, solved.
    #[default]
    PoissonBoltzmann,
    /// Screened Coulomb potentials in a uniform solvent, added up.
    DebyeHueckel,
}

/// An atom on its way into voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoxelAtom {
    /// Sphere and charge.
    pub sphere: ChargedSphere,
    /// Index of its residue.
    pub residue: Option<u32>,
}

/// What to put into voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelSettings {
    /// Channels, in this order.
    pub channels: Vec<Channel>,
    /// Which potential.
    pub potential: PotentialModel,
    /// Salt, temperature, permittivities; the probe of the surface.
    pub dielectric: DielectricModel,
    /// How the Poisson-Boltzmann equation is solved.
    pub solve: SolveSettings,
    /// Residues with an atom this near to a voxel's centre count for its hydropathy, Å.
    pub hydropathy_reach_angstrom: f64,
}

impl VoxelSettings {
    /// Shape, potential and hydropathy with this model: the equation solved at 1 Å to 1e-4 (values
    /// are kept to three digits), residues within 5 Å averaged.
    pub fn new(dielectric: DielectricModel) -> Self {
        let solve = SolveSettings {
            spacing_angstrom: 1.0,
            relative_tolerance: 1e-4,
            ..SolveSettings::default()
        };
        Self {
            channels: vec![Channel::Shape, Channel::Potential, Channel::Hydropathy],
            potential: PotentialModel::default(),
            dielectric,
            solve,
            hydropathy_reach_angstrom: 5.0,
        }
    }
}

/// Occupied voxels and what each channel has there. Voxels inside the surface but not of its shell
/// are occupied only where [`Channel::Solid`] is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Voxels {
    /// Numbers of the occupied voxels, ascending.
    pub index: Vec<u32>,
    /// For each channel the values in the order of `index`.
    pub values: Vec<Vec<f32>>,
}

/// Turns atoms and moves the middle of the box about their spheres to the origin. Returns that
/// middle, in turned coordinates: a place p of the file lies at R p - middle.
///
/// ```
/// use protomer_field::{ChargedSphere, voxels::{VoxelAtom, channels::pose}};
/// use protomer_kernel::{Rotation, Vec3};
/// let sphere = ChargedSphere { centre: Vec3::new(3.0, 1.0, 0.0), radius_angstrom: 1.5, charge_e: 0.0 };
/// let mut atoms = [VoxelAtom { sphere, residue: None }];
/// let middle = pose(&mut atoms, &Rotation::identity());
/// assert_eq!((middle, atoms[0].sphere.centre), (sphere.centre, Vec3::zeros()));
/// ```
pub fn pose(atoms: &mut [VoxelAtom], rotation: &Rotation) -> Vec3 {
    for atom in atoms.iter_mut() {
        atom.sphere.centre = rotation * atom.sphere.centre;
    }
    let (low, high) = bounds(atoms);
    let middle = if atoms.is_empty() {
        Vec3::zeros()
    } else {
        0.5 * (low + high)
    };
    for atom in atoms.iter_mut() {
        atom.sphere.centre -= middle;
    }
    middle
}

/// Lowest and highest corner of the box about the spheres, Å.
pub fn bounds(atoms: &[VoxelAtom]) -> (Vec3, Vec3) {
    crate::surface::bounds(atoms.iter().map(|atom| &atom.sphere))
}

/// The voxels of atoms that are posed already; `hydropathy` has the index of each residue.
///
/// # Errors
/// [`FieldError::BadInput`] for no channels, no atoms with a radius, and atoms that reach off the
/// lattice; else as [`solve`].
pub fn voxelise(
    atoms: &[VoxelAtom],
    hydropathy: &[Option<f64>],
    lattice: &Lattice,
    settings: &VoxelSettings,
) -> Result<Voxels> {
    if settings.channels.is_empty() {
        return Err(FieldError::BadInput(
            "there are no channels; give at least one".into(),
        ));
    }
    if !(settings.hydropathy_reach_angstrom > 0.0 && settings.hydropathy_reach_angstrom <= 50.0) {
        return Err(FieldError::BadSetting {
            setting: "hydropathy reach",
            value: settings.hydropathy_reach_angstrom,
            requirement: "above 0, at most 50 Å",
        });
    }
    let spheres: Vec<ChargedSphere> = atoms.iter().map(|atom| atom.sphere).collect();
    let solid = solvent_excluded(&spheres, settings.dielectric.probe_angstrom)?;
    let (low, high) = bounds(atoms);
    let reach = low.amax().max(high.amax());
    if reach > 0.5 * lattice.room_angstrom() {
        return Err(FieldError::BadInput(format!(
            "the atoms reach {reach:.1} Å from the middle of a lattice with {:.1} Å of room; use more or larger voxels",
            0.5 * lattice.room_angstrom()
        )));
    }
    let Occupied { shell, inside } = occupied(lattice, &solid);
    let index = if settings.channels.contains(&Channel::Solid) {
        union(&shell, &inside)
    } else {
        shell.clone()
    };
    let on_shell = |values: Vec<f64>| -> Vec<f32> {
        let mut spread = vec![0.0; index.len()];
        scatter(
            &index,
            &shell,
            values.iter().map(|value| *value as f32),
            &mut spread,
        );
        spread
    };
    let mut values = Vec::with_capacity(settings.channels.len());
    for channel in &settings.channels {
        let of_channel = match channel {
            Channel::Shape => on_shell(vec![1.0; shell.len()]),
            Channel::Solid => {
                let mut spread = vec![0.0; index.len()];
                scatter(&index, &inside, std::iter::repeat(1.0), &mut spread);
                spread
            }
            Channel::Potential => on_shell(potential(&spheres, &solid, lattice, &shell, settings)?),
            Channel::Hydropathy => {
                let places = atoms.iter().map(|atom| (atom.sphere.centre, atom.residue));
                let map =
                    HydropathyMap::new(places, hydropathy, settings.hydropathy_reach_angstrom);
                on_shell(
                    shell
                        .par_iter()
                        .map(|voxel| map.at(&lattice.centre(*voxel)).unwrap_or(0.0))
                        .collect(),
                )
            }
        };
        values.push(of_channel);
    }
    Ok(Voxels { index, values })
}

/// The potential at the points of the surface nearest to the centres of these voxels, kT/e.
fn potential(
    spheres: &[ChargedSphere],
    solid: &SesSolid,
    lattice: &Lattice,
    shell: &[u32],
    settings: &VoxelSettings,
) -> Result<Vec<f64>> {
    let places: Vec<Vec3> = shell
        .par_iter()
        .map(|voxel| solid.project(&lattice.centre(*voxel)).0)
        .collect();
    Ok(match settings.potential {
        PotentialModel::DebyeHueckel => {
            let superposition = Superposition::new(spheres, &settings.dielectric);
            places
                .par_iter()
                .map(|place| superposition.at(place))
                .collect()
        }
        PotentialModel::PoissonBoltzmann => {
            let solved = solve(spheres, &settings.dielectric, &settings.solve)?;
            at_surface(&solved, solid, &places)
        }
    })
}

/// Two ascending lists as one.
fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.dedup();
    all
}

/// Writes values of some voxels to their places among all. Both lists ascend, and `some` is part of
/// `all`.
fn scatter(all: &[u32], some: &[u32], values: impl Iterator<Item = f32>, out: &mut [f32]) {
    let mut some = some.iter().zip(values).peekable();
    for (voxel, out) in all.iter().zip(out) {
        if let Some((_, value)) = some.next_if(|(next, _)| *next == voxel) {
            *out = value;
        }
    }
}
