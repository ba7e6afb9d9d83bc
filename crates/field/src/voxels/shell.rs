//! Which voxels the surface passes through, and which are inside.

use super::lattice::Lattice;
use protomer_body::surface::ImplicitSolid;
use rayon::prelude::*;

/// Voxels of the surface and of the solid, ascending.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Occupied {
    /// Voxels whose centre is less than half an edge from the surface, on either side.
    pub shell: Vec<u32>,
    /// Voxels whose centre is inside the surface.
    pub inside: Vec<u32>,
}

/// Sorts the voxels of a lattice by the signed distance d of their centres from a solid's surface:
/// the shell has |d| < h/2, the inside d < 0. (Not ≤: at the largest spacing h/2 is where distances
/// are cut off.)
///
/// The shell has no holes: d changes by at most h between neighbours across a face, so of two such
/// neighbours on different sides of the surface one at least is in the shell. Walls of cavities are
/// part of it.
pub fn occupied(lattice: &Lattice, solid: &dyn ImplicitSolid) -> Occupied {
    let (low, high) = solid.bounds();
    let (size, half) = (lattice.size(), 0.5 * lattice.spacing_angstrom());
    let near = |axis: usize| {
        let is_near = |at: &usize| {
            let place = lattice.coordinate(*at);
            place >= low[axis] - half && place <= high[axis] + half
        };
        (0..size).filter(is_near).collect::<Vec<usize>>()
    };
    let [columns, rows, layers] = [near(0), near(1), near(2)];
    let parts: Vec<Occupied> = layers
        .par_iter()
        .map(|&z| {
            let mut part = Occupied::default();
            for &y in &rows {
                for &x in &columns {
                    let index = lattice.index(x, y, z);
                    let distance = solid.signed_distance(&lattice.centre(index));
                    if distance.abs() < half {
                        part.shell.push(index);
                    }
                    if distance < 0.0 {
                        part.inside.push(index);
                    }
                }
            }
            part
        })
        .collect();
    Occupied {
        shell: parts
            .iter()
            .flat_map(|part| part.shell.iter().copied())
            .collect(),
        inside: parts
            .iter()
            .flat_map(|part| part.inside.iter().copied())
            .collect(),
    }
}
