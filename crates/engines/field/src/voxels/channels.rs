//! Atoms in, sparse values out.

use super::hydropathy::HydropathyMap;
use super::lattice::Lattice;
use super::outer::at_surface;
use super::shell::{Occupied, occupied};
use crate::charged_sphere::ChargedSphere;
use crate::debye_huckel::Superposition;
use crate::dielectric::DielectricModel;
use crate::poisson_boltzmann::{SolveSettings, solve_within};
use crate::surface::solvent_excluded;
use crate::{FieldError, Result};
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::setting::Choices;
use protomer_kernel::{Rotation, Vec3};
use rayon::prelude::*;

protomer_kernel::choices! {
    /// A value that voxels can hold. A voxel is on the shell, 1 in `shape`, where |d| < h/2 with d the distance of its
    /// centre from the surface and h its edge. Potential (at the point of the surface nearest to the centre) and
    /// hydropathy are 0 off the shell.
    pub enum Channel {
        /// 1 where the solvent-excluded surface passes through the voxel.
        Shape = "shape",
        /// 1 inside the surface.
        Solid = "solid",
        /// Electrostatic potential on the surface, kT/e.
        Potential = "potential",
        /// Hydropathy index of nearby residues.
        Hydropathy = "hydropathy",
        /// Edge of the voxels, Å: shows the size of structures scaled to the grid.
        Spacing = "spacing",
        /// Shape of the second body of an interface.
        PartnerShape = "partner_shape",
        /// Potential of the second body of an interface, kT/e.
        PartnerPotential = "partner_potential",
        /// Hydropathy of the second body of an interface.
        PartnerHydropathy = "partner_hydropathy",
    }
}

impl Channel {
    /// Channels of the second body of an interface.
    pub const PARTNER: [Channel; 3] = [
        Channel::PartnerShape,
        Channel::PartnerPotential,
        Channel::PartnerHydropathy,
    ];
    /// Channels of a body alone.
    ///
    /// ```
    /// use protomer_field::voxels::Channel;
    /// use protomer_kernel::setting::Choices;
    /// let names = Channel::SINGLE.map(Channel::name);
    /// assert_eq!(names, ["shape", "solid", "potential", "hydropathy", "spacing"]);
    /// ```
    pub const SINGLE: [Channel; 5] = [
        Channel::Shape,
        Channel::Solid,
        Channel::Potential,
        Channel::Hydropathy,
        Channel::Spacing,
    ];
}

protomer_kernel::choices! {
    /// Model of the potential.
    pub enum PotentialModel, default PoissonBoltzmann {
        /// The Poisson-Boltzmann equation.
        PoissonBoltzmann = "poisson-boltzmann",
        /// The sum of the atoms' Debye-Hückel potentials in a uniform solvent: faster, but
        /// ignores the dielectric boundary.
        DebyeHueckel = "debye-hueckel",
    }
}

/// An atom to be voxelised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoxelAtom {
    /// Sphere and charge.
    pub sphere: ChargedSphere,
    /// Index of its residue.
    pub residue: Option<u32>,
}

/// Channels of the voxels, and the settings with which they are computed.
///
/// ```
/// use protomer_field::DielectricModel;
/// use protomer_field::voxels::{Channel, VoxelSettings};
/// use protomer_kernel::Electrolyte;
/// let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.15)?);
/// let settings = VoxelSettings { channels: vec![Channel::Solid], ..VoxelSettings::new(model) };
/// assert_eq!((settings.solve.spacing_angstrom, settings.hydropathy_reach_angstrom), (1.0, 5.0));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelSettings {
    /// Channels, in this order.
    pub channels: Vec<Channel>,
    /// Model of the potential.
    pub potential: PotentialModel,
    /// The electrolyte, the permittivities, and the probe of the surface.
    pub dielectric: DielectricModel,
    /// Settings for the solution of the Poisson-Boltzmann equation.
    pub solve: SolveSettings,
    /// Residues with an atom this near to a voxel's centre count for its hydropathy, Å.
    pub hydropathy_reach_angstrom: f64,
}

impl VoxelSettings {
    /// Shape, potential and hydropathy with this model: the equation is solved at 1 Å to 1e-4, which
    /// leaves 0.1 to 0.5 % of the potentials of proteins, on grids of 8 n cells, and residues within 5 Å
    /// are averaged.
    pub fn new(dielectric: DielectricModel) -> Self {
        let solve = SolveSettings {
            spacing_angstrom: 1.0,
            cells_multiple: 8,
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

/// Occupied voxels and the values of each channel there. Voxels inside the surface but off its shell
/// are occupied only if [`Channel::Solid`] is requested.
#[derive(Debug, Clone, PartialEq)]
pub struct Voxels {
    /// Numbers of the occupied voxels, ascending.
    pub index: Vec<u32>,
    /// Values of each channel, in the order of `index`.
    pub values: Vec<Vec<f32>>,
}

/// Turns atoms and moves the middle of the box around their spheres to the origin. Returns that
/// middle in turned coordinates: a place p of the file lies at R p - middle.
///
/// ```
/// use protomer_field::{ChargedSphere, voxels::{VoxelAtom, channels::pose}};
/// use protomer_kernel::{Rotation, Vec3};
/// let centre = Vec3::new(3.0, 1.0, 0.0);
/// let sphere = ChargedSphere { centre, radius_angstrom: 1.5, charge_e: 0.0 };
/// let mut atoms = [VoxelAtom { sphere, residue: None }];
/// let middle = pose(&mut atoms, &Rotation::identity());
/// assert_eq!((middle, atoms[0].sphere.centre), (centre, Vec3::zeros()));
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

/// Lowest and highest corner of the box around the spheres, Å.
pub fn bounds(atoms: &[VoxelAtom]) -> (Vec3, Vec3) {
    crate::charged_sphere::bounds(atoms.iter().map(|atom| &atom.sphere))
}

/// The voxels of atoms that have been posed on a lattice; `hydropathy` is the index of each residue.
///
/// ```
/// use protomer_field::voxels::{Channel, Lattice, VoxelAtom, VoxelSettings, voxelise};
/// use protomer_field::{ChargedSphere, DielectricModel};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let sphere = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 3.0, charge_e: 0.0 };
/// let atom = VoxelAtom { sphere, residue: None };
/// let settings = VoxelSettings {
///     channels: vec![Channel::Shape],
///     ..VoxelSettings::new(DielectricModel::new(Electrolyte::in_water(298.15, 0.15)?))
/// };
/// let voxels = voxelise(&[atom], &[], &Lattice::new(16, 1.0)?, &settings)?;
/// // About the area of the sphere, in voxels of 1 Å.
/// assert!((90..150).contains(&voxels.index.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FieldError::BadInput`] for no channels, no atoms with a radius, and atoms that reach off the
/// lattice; else as [`solve`](crate::solve).
pub fn voxelise(
    atoms: &[VoxelAtom],
    hydropathy: &[Option<f64>],
    lattice: &Lattice,
    settings: &VoxelSettings,
) -> Result<Voxels> {
    check_settings(settings)?;
    let solid = solvent_excluded(&spheres_of(atoms), settings.dielectric.probe_angstrom)?;
    voxelise_within(&solid, atoms, hydropathy, lattice, settings)
}

/// Variant of [`voxelise`] that is given the solvent-excluded surface of these atoms for the probe
/// of the settings.
///
/// # Errors
/// As [`voxelise`].
pub fn voxelise_within(
    solid: &dyn ImplicitSolid,
    atoms: &[VoxelAtom],
    hydropathy: &[Option<f64>],
    lattice: &Lattice,
    settings: &VoxelSettings,
) -> Result<Voxels> {
    check_settings(settings)?;
    check_room(atoms, lattice)?;
    let Occupied { shell, inside } = occupied(lattice, solid);
    let index = if settings.channels.contains(&Channel::Solid) {
        union(&shell, &inside)
    } else {
        shell.clone()
    };
    let mut values = Vec::with_capacity(settings.channels.len());
    for channel in &settings.channels {
        let of_channel = match channel {
            Channel::Shape => scatter(&index, &shell, &vec![1.0; shell.len()]),
            Channel::Solid => scatter(&index, &inside, &vec![1.0; inside.len()]),
            Channel::Potential => {
                let potential = potentials(&spheres_of(atoms), solid, lattice, &shell, settings)?;
                scatter(&index, &shell, &potential)
            }
            Channel::Hydropathy => {
                let places = atoms.iter().map(|atom| (atom.sphere.centre, atom.residue));
                let map =
                    HydropathyMap::new(places, hydropathy, settings.hydropathy_reach_angstrom);
                let centres: Vec<Vec3> = shell.iter().map(|voxel| lattice.centre(*voxel)).collect();
                let indices = map.at_all(&centres).into_iter();
                let indices: Vec<f64> = indices.map(Option::unwrap_or_default).collect();
                scatter(&index, &shell, &indices)
            }
            Channel::Spacing => vec![lattice.spacing_angstrom() as f32; index.len()],
            Channel::PartnerShape | Channel::PartnerPotential | Channel::PartnerHydropathy => {
                let reason = format!(
                    "the channel {} is that of a partner, and this body has none",
                    channel.name()
                );
                return Err(FieldError::BadInput(reason));
            }
        };
        values.push(of_channel);
    }
    Ok(Voxels { index, values })
}

pub(super) fn spheres_of(atoms: &[VoxelAtom]) -> Vec<ChargedSphere> {
    atoms.iter().map(|atom| atom.sphere).collect()
}

pub(super) fn check_settings(settings: &VoxelSettings) -> Result<()> {
    if settings.channels.is_empty() {
        let reason = "there are no channels; give at least one";
        return Err(FieldError::BadInput(reason.into()));
    }
    let reach = settings.hydropathy_reach_angstrom;
    if !(reach > 0.0 && reach <= 50.0) {
        return Err(FieldError::BadSetting {
            setting: "hydropathy reach",
            value: reach,
            requirement: "above 0, at most 50 Å",
        });
    }
    Ok(())
}

/// Refuses atoms that reach off the lattice.
fn check_room(atoms: &[VoxelAtom], lattice: &Lattice) -> Result<()> {
    let (low, high) = bounds(atoms);
    let reach = low.amax().max(high.amax());
    let room = 0.5 * lattice.room_angstrom();
    if reach > room {
        return Err(FieldError::BadInput(format!(
            "the atoms reach {reach:.1} Å from the middle of a lattice with {room:.1} Å of room; \
             use more or larger voxels"
        )));
    }
    Ok(())
}

/// The potential at the points of the surface nearest to the centres of these voxels, kT/e.
fn potentials(
    spheres: &[ChargedSphere],
    solid: &dyn ImplicitSolid,
    lattice: &Lattice,
    shell: &[u32],
    settings: &VoxelSettings,
) -> Result<Vec<f64>> {
    // At the surface and not at the centre, which may lie inside, where φ rises to the charges.
    let nearest_on_surface = |voxel: &u32| solid.project(&lattice.centre(*voxel)).0;
    let places: Vec<Vec3> = shell.par_iter().map(nearest_on_surface).collect();
    Ok(match settings.potential {
        PotentialModel::DebyeHueckel => {
            let superposition = Superposition::new(spheres, &settings.dielectric);
            let potential_at = |place: &Vec3| superposition.value_at(place);
            places.par_iter().map(potential_at).collect()
        }
        PotentialModel::PoissonBoltzmann => {
            let solved = solve_within(solid, spheres, &settings.dielectric, &settings.solve)?;
            at_surface(&solved, &places)
        }
    })
}

/// Two ascending lists merged into one without duplicates.
pub(super) fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.dedup();
    all
}

/// The values of some voxels among all, zero for the others. Both lists ascend, and `some` is part
/// of `all`.
pub(super) fn scatter(all: &[u32], some: &[u32], values: &[f64]) -> Vec<f32> {
    let mut remaining = some.iter().zip(values).peekable();
    let mut spread = vec![0.0; all.len()];
    for (voxel, target) in all.iter().zip(&mut spread) {
        // Both ascend: one pass, no search.
        if let Some((_, value)) = remaining.next_if(|(next, _)| *next == voxel) {
            *target = *value as f32;
        }
    }
    spread
}
