//! Which voxels the surface passes through, and which are inside.

use super::lattice::Lattice;
use protomer_body::surface::{Ball, ImplicitSolid};
use protomer_kernel::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Layers of voxels that are sorted together.
const LAYERS: usize = 12;
/// More than the rounding of a voxel's place, Å.
const ROUNDING_ANGSTROM: f64 = 1e-6;

/// Voxels of the surface and of the solid, ascending.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Occupied {
    /// Voxels whose centre is less than half an edge from the surface, on either side.
    pub shell: Vec<u32>,
    /// Voxels whose centre is inside the surface.
    pub inside: Vec<u32>,
}

/// Sorts the voxels of a lattice by the signed distance d of their centres from the surface of a
/// solid: the shell has |d| < h/2, the inside d < 0. (Not ≤: at the largest spacing distances are
/// cut off at h/2.)
///
/// The shell has no holes: d changes by at most h between neighbours across a face, so of two such
/// neighbours on different sides of the surface at least one is in the shell. Walls of cavities are
/// part of it. For the same reason neighbours that are both far from the surface are on one side of it,
/// and one distance does for a whole run of them.
///
/// ```
/// use protomer_field::voxels::{Lattice, shell::occupied};
/// use protomer_field::{ChargedSphere, SurfaceDefinition, surface::surface_of};
/// use protomer_kernel::Vec3;
/// let ball = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 6.0, charge_e: 0.0 };
/// let solid = surface_of(&[ball], SurfaceDefinition::VanDerWaals, 1.4)?;
/// let voxels = occupied(&Lattice::new(16, 1.0)?, &*solid);
/// let volume = 4.0 / 3.0 * std::f64::consts::PI * 6.0_f64.powi(3);
/// assert!((voxels.inside.len() as f64 / volume - 1.0).abs() < 0.05);
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
pub fn occupied(lattice: &Lattice, solid: &dyn ImplicitSolid) -> Occupied {
    let (low, high) = solid.bounds();
    let half = 0.5 * lattice.spacing_angstrom() + ROUNDING_ANGSTROM;
    let [columns, rows, layers] =
        [0, 1, 2].map(|axis| layers_between(lattice, low[axis] - half, high[axis] + half));
    let cover = solid.cover();
    let occupied_of_layers = |start: usize| {
        // Layers together: distances of many points are found with one look at the atoms.
        let together = start..(start + LAYERS).min(layers.end);
        let near = near_cover(lattice, &cover, &together);
        let mut runs = Vec::new();
        for z in together {
            for y in rows.clone() {
                let row = lattice.index(columns.start, y, z)..lattice.index(columns.end, y, z);
                add_runs(row, lattice.index(0, 0, start), &near, &mut runs);
            }
        }
        Occupied::of_runs(runs, lattice, solid)
    };
    let starts: Vec<usize> = layers.clone().step_by(LAYERS).collect();
    let of_layers: Vec<Occupied> = starts.into_par_iter().map(occupied_of_layers).collect();
    let mut all = Occupied::default();
    for layers in of_layers {
        all.shell.extend(layers.shell);
        all.inside.extend(layers.inside);
    }
    all
}

impl Occupied {
    /// Sorts runs of voxels by the distances of their first voxels.
    fn of_runs(runs: Vec<Range<u32>>, lattice: &Lattice, solid: &dyn ImplicitSolid) -> Self {
        let mut occupied = Self::default();
        let firsts = runs.iter().map(|run| lattice.centre(run.start));
        let firsts: Vec<Vec3> = firsts.collect();
        let mut distances = Vec::new();
        solid.signed_distances(&firsts, &mut distances);
        for (run, distance) in runs.into_iter().zip(distances) {
            // A run near the surface is a single voxel, so the first stands for it.
            if distance.abs() < 0.5 * lattice.spacing_angstrom() {
                occupied.shell.push(run.start);
            }
            if distance < 0.0 {
                occupied.inside.extend(run);
            }
        }
        occupied
    }
}

/// Marks the voxels of some layers whose centres may be less than half an edge from the surface:
/// those that are so near to a ball of the cover.
fn near_cover(lattice: &Lattice, cover: &[Ball], layers: &Range<usize>) -> Vec<bool> {
    let half = 0.5 * lattice.spacing_angstrom() + ROUNDING_ANGSTROM;
    let first = lattice.index(0, 0, layers.start);
    let mut near = vec![false; layers.len() * lattice.size().pow(2)];
    for (centre, radius) in cover {
        let reach = radius + half;
        let within = |x: f64, reach: f64| layers_between(lattice, x - reach, x + reach);
        let reached = within(centre.z, reach);
        for z in reached.start.max(layers.start)..reached.end.min(layers.end) {
            // Spheres cut by planes and rows: a range of columns per row, no test per voxel.
            let square = reach * reach - (lattice.coordinate(z) - centre.z).powi(2);
            for y in within(centre.y, reach) {
                let square = square - (lattice.coordinate(y) - centre.y).powi(2);
                if square > 0.0 {
                    let columns = within(centre.x, square.sqrt());
                    let row = (lattice.index(0, y, z) - first) as usize;
                    near[row + columns.start..row + columns.end].fill(true);
                }
            }
        }
    }
    near
}

/// Adds the runs of a row of voxels: each voxel near the cover alone, the others as they hang together.
/// `near` says which are, from the voxel `first` on.
fn add_runs(row: Range<u32>, first: u32, near: &[bool], runs: &mut Vec<Range<u32>>) {
    let mut start = row.start;
    while start < row.end {
        let is_far = |voxel: &u32| !near[(voxel - first) as usize];
        let far = (start..row.end).take_while(is_far).count() as u32;
        // A voxel near the cover is a run of its own.
        let end = start + far.max(1);
        runs.push(start..end);
        start = end;
    }
}

/// The layers along an axis whose centres lie between two coordinates, Å.
fn layers_between(lattice: &Lattice, low: f64, high: f64) -> Range<usize> {
    let size = lattice.size() as f64;
    let layer = |x: f64| x / lattice.spacing_angstrom() + 0.5 * (size - 1.0);
    // Converted to integers, numbers out of range become the nearest in range.
    let first = layer(low).ceil().min(size) as usize;
    let end = (layer(high).floor() + 1.0).min(size) as usize;
    first..end.max(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charged_sphere::ChargedSphere;
    use crate::surface::{SurfaceDefinition, surface_of};
    use protomer_kernel::random::CounterRng;

    /// The slow twin: the distance of every voxel.
    #[test]
    fn runs_of_voxels_are_sorted_as_each_voxel_is() {
        let mut rng = CounterRng::new(7, 0, 0);
        let (mut inside, mut asked, mut voxels) = (0, 0, 0);
        for (radius, spheres) in [(14.0, 1500), (6.0, 30)] {
            // Dense, with a core far from all exposed spheres, and loose, with gaps.
            let spheres: Vec<ChargedSphere> = (0..spheres)
                .map(|_| ChargedSphere {
                    centre: rng.vector_in_ball(radius),
                    radius_angstrom: rng.uniform_in(1.0, 2.0),
                    charge_e: 0.0,
                })
                .collect();
            for definition in [
                SurfaceDefinition::SolventExcluded,
                SurfaceDefinition::VanDerWaals,
                SurfaceDefinition::SolventAccessible,
            ] {
                let solid = surface_of(&spheres, definition, 1.4).unwrap();
                for (size, spacing) in [(48, 0.8), (24, 2.0), (40, 0.3)] {
                    let lattice = Lattice::new(size, spacing).unwrap();
                    let found = occupied(&lattice, &*solid);
                    let mut twin = Occupied::default();
                    for voxel in 0..(size as u32).pow(3) {
                        let distance = solid.signed_distance(&lattice.centre(voxel));
                        if distance.abs() < 0.5 * spacing {
                            twin.shell.push(voxel);
                        }
                        if distance < 0.0 {
                            twin.inside.push(voxel);
                        }
                    }
                    assert_eq!(found, twin, "{definition:?} {size} {spacing}");
                    inside += twin.inside.len();
                    let near = near_cover(&lattice, &solid.cover(), &(0..size));
                    let mut runs = Vec::new();
                    add_runs(0..near.len() as u32, 0, &near, &mut runs);
                    asked += runs.len();
                    voxels += near.len();
                }
            }
        }
        assert!(inside > 10_000, "{inside} voxels inside");
        assert!(2 * asked < voxels, "{asked} of {voxels} voxels");
    }
}
