//! Which voxels the surface passes through, and which are inside.

use super::lattice::Lattice;
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// Layers of voxels that are sorted together.
const LAYERS: usize = 12;

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
/// part of it.
pub fn occupied(lattice: &Lattice, solid: &dyn ImplicitSolid) -> Occupied {
    let (low, high) = solid.bounds();
    let [columns, rows, layers] =
        [0, 1, 2].map(|axis| layers_within(lattice, low[axis], high[axis]));
    let occupied_of_layers = |layers: &[usize]| {
        let mut voxels = Vec::with_capacity(columns.len() * rows.len() * layers.len());
        for z in layers {
            for y in &rows {
                voxels.extend(columns.iter().map(|x| lattice.index(*x, *y, *z)));
            }
        }
        Occupied::among(voxels, lattice, solid)
    };
    let of_layers: Vec<Occupied> = layers.par_chunks(LAYERS).map(occupied_of_layers).collect();
    let mut all = Occupied::default();
    for layers in of_layers {
        all.shell.extend(layers.shell);
        all.inside.extend(layers.inside);
    }
    all
}

impl Occupied {
    /// Sorts some voxels.
    fn among(voxels: Vec<u32>, lattice: &Lattice, solid: &dyn ImplicitSolid) -> Self {
        let mut occupied = Self::default();
        let centres: Vec<Vec3> = voxels.iter().map(|voxel| lattice.centre(*voxel)).collect();
        let mut distances = Vec::new();
        solid.signed_distances(&centres, &mut distances);
        for (voxel, distance) in voxels.into_iter().zip(distances) {
            if distance.abs() < 0.5 * lattice.spacing_angstrom() {
                occupied.shell.push(voxel);
            }
            if distance < 0.0 {
                occupied.inside.push(voxel);
            }
        }
        occupied
    }
}

/// The layers along an axis whose voxels reach between two coordinates, Å.
fn layers_within(lattice: &Lattice, low: f64, high: f64) -> Vec<usize> {
    let half = 0.5 * lattice.spacing_angstrom();
    let reaches = |layer: &usize| {
        let place = lattice.coordinate(*layer);
        place >= low - half && place <= high + half
    };
    (0..lattice.size()).filter(reaches).collect()
}
