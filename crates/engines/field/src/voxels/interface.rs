//! Two bodies in one box about their interface: the pose is the sample.
//!
//! Surface, potential and hydropathy belong to each body alone and are made once, in its own frame.
//! A pose only places them, so thousands of poses of the same two bodies cost no new surface.

use super::channels::{Channel, PotentialModel, VoxelAtom, VoxelSettings, Voxels, check_settings};
use super::channels::{scatter, spheres_of, union};
use super::hydropathy::HydropathyMap;
use super::lattice::Lattice;
use super::outer::at_surface;
use super::shell::occupied;
use crate::debye_huckel::Superposition;
use crate::poisson_boltzmann::{Potential, solve_within};
use crate::{FieldError, Result};
use protomer_body::surface::{ExactSurface, ImplicitSolid, Placed};
use protomer_kernel::setting::Choices;
use protomer_kernel::{Pose, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A body with its surface, potential and hydropathy in its own frame.
pub struct InterfaceBody {
    surface: ExactSurface,
    atoms: Vec<Vec3>,
    cells: Cells,
    potential: Option<BodyPotential>,
    hydropathy: HydropathyMap,
}

/// The potential of a body alone.
enum BodyPotential {
    Screened(Superposition),
    Solved(Box<Potential>),
}

impl InterfaceBody {
    /// A body of atoms and the surface around them, in one frame; `hydropathy` is the index of each
    /// residue. The potential is computed only if `settings` have a channel for it.
    ///
    /// # Errors
    /// As [`solve`](crate::solve).
    pub fn new(
        surface: ExactSurface,
        atoms: &[VoxelAtom],
        hydropathy: &[Option<f64>],
        settings: &VoxelSettings,
        reach_angstrom: f64,
    ) -> Result<Self> {
        let spheres = spheres_of(atoms);
        let has_potential = [Channel::Potential, Channel::PartnerPotential]
            .iter()
            .any(|channel| settings.channels.contains(channel));
        let potential = match (has_potential, settings.potential) {
            (false, _) => None,
            (true, PotentialModel::DebyeHueckel) => Some(BodyPotential::Screened(
                Superposition::new(&spheres, &settings.dielectric),
            )),
            (true, PotentialModel::PoissonBoltzmann) => {
                let (dielectric, solve) = (&settings.dielectric, &settings.solve);
                let solved = solve_within(surface.solid(), &spheres, dielectric, solve)?;
                Some(BodyPotential::Solved(Box::new(solved)))
            }
        };
        let places: Vec<Vec3> = atoms.iter().map(|atom| atom.sphere.centre).collect();
        let of_residues = atoms.iter().map(|atom| (atom.sphere.centre, atom.residue));
        Ok(Self {
            hydropathy: HydropathyMap::new(
                of_residues,
                hydropathy,
                settings.hydropathy_reach_angstrom,
            ),
            cells: Cells::new(&places, reach_angstrom),
            atoms: places,
            potential,
            surface,
        })
    }

    /// The potential at places on the surface, in the frame of the body, kT/e.
    fn potentials(&self, places: &[Vec3]) -> Vec<f64> {
        match &self.potential {
            None => vec![0.0; places.len()],
            Some(BodyPotential::Screened(sum)) => {
                places.par_iter().map(|place| sum.value_at(place)).collect()
            }
            Some(BodyPotential::Solved(solved)) => at_surface(solved, places),
        }
    }
}

/// The middle of the interface of two placed bodies: the mean of the atoms of each within the reach of
/// the other, and the mean of these two means. Bodies that are farther apart meet halfway between
/// their closest atoms.
///
/// # Errors
/// [`FieldError::BadInput`] for a body without atoms.
pub fn interface_middle(bodies: [&InterfaceBody; 2], poses: &[Pose; 2]) -> Result<Vec3> {
    let mut middle = Vec3::zeros();
    for [body, other] in [[0, 1], [1, 0]] {
        let back = poses[other].inverse();
        let placed = bodies[body].atoms.iter();
        let placed = placed.map(|atom| poses[body].transform_point(atom));
        let near =
            placed.filter(|atom| bodies[other].cells.has_within(&back.transform_point(atom)));
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for atom in near {
            sum += atom;
            count += 1.0;
        }
        if count == 0.0 {
            return between_closest(bodies, poses);
        }
        middle += 0.5 * sum / count;
    }
    Ok(middle)
}

/// The point halfway between the closest atoms.
fn between_closest(bodies: [&InterfaceBody; 2], poses: &[Pose; 2]) -> Result<Vec3> {
    let place = |body: usize| -> Vec<Vec3> {
        let atoms = bodies[body].atoms.iter();
        atoms
            .map(|atom| poses[body].transform_point(atom))
            .collect()
    };
    let (first, second) = (place(0), place(1));
    let closest_to = |one: &Vec3| {
        let others = second
            .iter()
            .map(|other| ((one - other).norm_squared(), *other));
        let closest = others.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((closest.0, 0.5 * (one + closest.1)))
    };
    let closest = first.par_iter().filter_map(closest_to);
    match closest.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((_, halfway)) => Ok(halfway),
        None => Err(FieldError::BadInput("a body has no atoms".into())),
    }
}

/// The voxels of two bodies at poses in the frame of the lattice: for each, those of its surface that
/// have an atom of the other body within the reach. The first body has the channels `shape`, `potential`
/// and `hydropathy`, the second those of the partner.
///
/// # Errors
/// [`FieldError::BadInput`] for no channels, and for channels that belong to one body alone.
pub fn voxelise_interface(
    bodies: [&InterfaceBody; 2],
    poses: &[Pose; 2],
    lattice: &Lattice,
    settings: &VoxelSettings,
) -> Result<Voxels> {
    check_settings(settings)?;
    let shells = [0, 1].map(|body| {
        let other = 1 - body;
        let solid = Placed::new(bodies[body].surface.solid(), poses[body]);
        let back = poses[other].inverse();
        let mut shell = occupied(lattice, &solid).shell;
        shell.retain(|voxel| {
            let place = back.transform_point(&lattice.centre(*voxel));
            bodies[other].cells.has_within(&place)
        });
        shell
    });
    let index = union(&shells[0], &shells[1]);
    let mut values = Vec::with_capacity(settings.channels.len());
    for channel in &settings.channels {
        let number = match channel {
            Channel::Shape | Channel::Potential | Channel::Hydropathy => 0,
            Channel::PartnerShape | Channel::PartnerPotential | Channel::PartnerHydropathy => 1,
            Channel::Solid | Channel::Spacing => {
                return Err(FieldError::BadInput(format!(
                    "the channel {} is that of one body alone; choose others for an interface",
                    channel.name()
                )));
            }
        };
        let (body, shell) = (bodies[number], &shells[number]);
        let back = poses[number].inverse();
        let in_body = || -> Vec<Vec3> {
            let centres = shell.iter().map(|voxel| lattice.centre(*voxel));
            centres
                .map(|centre| back.transform_point(&centre))
                .collect()
        };
        let of_shell = match channel {
            Channel::Potential | Channel::PartnerPotential => {
                let solid = body.surface.solid();
                let places = in_body();
                let places: Vec<Vec3> = places.par_iter().map(|p| solid.project(p).0).collect();
                body.potentials(&places)
            }
            Channel::Hydropathy | Channel::PartnerHydropathy => {
                let indices = body.hydropathy.at_all(&in_body()).into_iter();
                indices.map(Option::unwrap_or_default).collect()
            }
            _ => vec![1.0; shell.len()],
        };
        values.push(scatter(&index, shell, &of_shell));
    }
    Ok(Voxels { index, values })
}

/// Points by cells as wide as a reach: whether one is near is decided by 27 of them.
struct Cells {
    reach: f64,
    points: FxHashMap<[i32; 3], Vec<Vec3>>,
}

impl Cells {
    fn new(points: &[Vec3], reach: f64) -> Self {
        let mut cells = Self {
            reach,
            points: FxHashMap::default(),
        };
        for point in points {
            cells
                .points
                .entry(cells.cell(point))
                .or_default()
                .push(*point);
        }
        cells
    }

    fn cell(&self, point: &Vec3) -> [i32; 3] {
        [0, 1, 2].map(|axis| (point[axis] / self.reach).floor() as i32)
    }

    /// Whether a point lies within the reach of `place`.
    fn has_within(&self, place: &Vec3) -> bool {
        let [i, j, k] = self.cell(place);
        let most = self.reach.powi(2);
        let offsets = (0..27).map(|n| [i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1]);
        offsets
            .filter_map(|cell| self.points.get(&cell))
            .flatten()
            .any(|point| (point - place).norm_squared() <= most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::voxelise_within;
    use crate::{ChargedSphere, DielectricModel};
    use protomer_body::surface::ExactSurface;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Electrolyte, Rotation};

    fn atoms(seed: u64) -> Vec<VoxelAtom> {
        let mut random = CounterRng::new(seed, 0, 0);
        let atom = |number: u32| VoxelAtom {
            sphere: ChargedSphere {
                centre: Vec3::new(
                    random.uniform_in(-6.0, 6.0),
                    random.uniform_in(-6.0, 6.0),
                    random.uniform_in(-6.0, 6.0),
                ),
                radius_angstrom: 1.8,
                charge_e: random.uniform_in(-1.0, 1.0),
            },
            residue: Some(number % 4),
        };
        (0..40).map(atom).collect()
    }

    const HYDROPATHY: [Option<f64>; 4] = [Some(4.5), Some(-3.5), None, Some(1.8)];

    fn settings(channels: &[Channel]) -> VoxelSettings {
        let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.15).unwrap());
        VoxelSettings {
            channels: channels.to_vec(),
            potential: PotentialModel::DebyeHueckel,
            ..VoxelSettings::new(model)
        }
    }

    fn surface_around(atoms: &[VoxelAtom]) -> ExactSurface {
        let spheres: Vec<_> = atoms
            .iter()
            .map(|atom| (atom.sphere.centre, atom.sphere.radius_angstrom))
            .collect();
        let (centres, radii): (Vec<Vec3>, Vec<f64>) = spheres.into_iter().unzip();
        ExactSurface::new(&centres, &radii, 1.4).unwrap()
    }

    /// The twin: each body by itself, moved_atoms atom by atom, as any structure is voxelised; then what is far
    /// from the other body is left out.
    #[test]
    fn placed_bodies_have_the_voxels_of_moved_atoms() {
        const REACH: f64 = 7.0;
        let all = [
            Channel::Shape,
            Channel::Potential,
            Channel::Hydropathy,
            Channel::PartnerShape,
            Channel::PartnerPotential,
            Channel::PartnerHydropathy,
        ];
        let (of_pair, alone) = (settings(&all), settings(&all[..3]));
        let sets = [atoms(1), atoms(2)];
        let bodies = sets.each_ref().map(|atoms| {
            let surface = surface_around(atoms);
            InterfaceBody::new(surface, atoms, &HYDROPATHY, &of_pair, REACH).unwrap()
        });
        let turn = |angle: f64| Rotation::from_scaled_axis(Vec3::new(0.3, angle, -0.2));
        let poses = [
            Pose {
                position: Vec3::new(-7.0, 1.0, 0.0),
                rotation: turn(0.7),
            },
            Pose {
                position: Vec3::new(7.0, -1.0, 2.0),
                rotation: turn(-1.9),
            },
        ];
        let lattice = Lattice::new(40, 1.0).unwrap();
        let pair = voxelise_interface(bodies.each_ref(), &poses, &lattice, &of_pair).unwrap();
        let moved_atoms = [0, 1].map(|body| {
            let mut copies = sets[body].clone();
            for atom in &mut copies {
                atom.sphere.centre = poses[body].transform_point(&atom.sphere.centre);
            }
            copies
        });
        let mut compared = 0;
        for body in [0, 1] {
            let surface = surface_around(&moved_atoms[body]);
            let voxels = voxelise_within(
                surface.solid(),
                &moved_atoms[body],
                &HYDROPATHY,
                &lattice,
                &alone,
            )
            .unwrap();
            for (place, voxel) in voxels.index.iter().enumerate() {
                let centre = lattice.centre(*voxel);
                let is_near = moved_atoms[1 - body]
                    .iter()
                    .any(|atom| (atom.sphere.centre - centre).norm() <= REACH);
                let place_in_pair = pair.index.binary_search(voxel).ok();
                let value = |channel: usize| {
                    place_in_pair.map_or(0.0, |voxel| pair.values[3 * body + channel][voxel])
                };
                if !is_near {
                    assert_eq!(value(0), 0.0);
                    continue;
                }
                compared += 1;
                for channel in 0..3 {
                    let expected = voxels.values[channel][place];
                    assert!(
                        (value(channel) - expected).abs() < 1e-3 * (1.0 + expected.abs()),
                        "{body} {channel}: {} {expected}",
                        value(channel)
                    );
                }
            }
        }
        let ones: f32 = pair.values[0].iter().chain(&pair.values[3]).sum();
        assert!(
            compared > 100 && ones as usize == compared,
            "{compared} {ones}"
        );
    }

    #[test]
    fn the_middle_lies_between_the_bodies_also_if_they_are_apart() {
        let set = atoms(1);
        let shape = settings(&[Channel::Shape]);
        let body =
            InterfaceBody::new(surface_around(&set), &set, &HYDROPATHY, &shape, 5.0).unwrap();
        let shifted = |x: f64| Pose {
            position: Vec3::new(x, 0.0, 0.0),
            ..Pose::identity()
        };
        for distance in [6.0, 30.0] {
            let poses = [shifted(-distance), shifted(distance)];
            let middle = interface_middle([&body, &body], &poses).unwrap();
            assert!(middle.x.abs() < 3.0, "{distance}: {middle}");
        }
    }
}
