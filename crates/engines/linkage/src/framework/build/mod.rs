//! Networks that are often wanted. Where `ks` and `kh` are stiffnesses, they are those of every rod
//! (kcal/mol/Å²) and every hinge (kcal/mol/rad²).
//!
//! | module | one idea |
//! |---|---|
//! | `honeycomb` | hexagonal honeycombs and arrowheads: ribs that hinge |
//! | `polygons` | stiff squares and triangles, joined at corners or by rods |
//! | `ribs` | crosses, stars and wheels joined by ribs |
//! | `cristobalite` | tetrahedra of alpha-cristobalite |
//! | `cubic` | nets of nearest neighbours in a cubic cell |
//! | `hinges` | which rods a hinge joins |

mod cristobalite;
mod cubic;
mod hinges;
mod honeycomb;
mod polygons;
mod ribs;

pub use cristobalite::alpha_cristobalite;
pub use cubic::{diamond, face_centred_cubic};
pub(super) use hinges::{hinge, rods_at};
pub use honeycomb::{arrowhead, honeycomb};
pub use polygons::{rod_lattice, rotating_squares, rotating_triangles};
pub use ribs::{MissingRib, chiral, missing_rib, stars};

use super::model::{Framework, Neighbour, Rod};

/// A network of nodes and rods of unit thickness.
fn network(cell: Vec<Vec<f64>>, nodes: Vec<Vec<f64>>, rods: Vec<Rod>) -> Framework {
    Framework {
        cell_angstrom: cell,
        thickness_angstrom: 1.0,
        nodes_angstrom: nodes,
        rods,
        hinges: Vec::new(),
        torsions: Vec::new(),
    }
}

/// A rod that is at rest as built.
fn rod(from: usize, to: Neighbour, stiffness_kcal_mol_angstrom2: f64) -> Rod {
    Rod {
        from,
        to,
        stiffness_kcal_mol_angstrom2,
        rest_length_angstrom: None,
    }
}

/// A node in the cell y, z cells away.
fn neighbour(node: usize, y: i32, z: i32) -> Neighbour {
    Neighbour::in_image(node, &[y, z])
}

/// Degrees for a message: without the last bits, which a conversion there and back changes.
fn degrees(angle_rad: f64) -> f64 {
    (angle_rad.to_degrees() * 1e9).round() / 1e9
}
