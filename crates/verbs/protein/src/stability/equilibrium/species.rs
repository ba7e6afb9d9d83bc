//! Which kinds of bodies are copies of one protein.

use protomer_body::assembly::superpose;
use protomer_body::{Body, Residue};
use protomer_kernel::{Pose, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Share of the residues of the smaller of two bodies that copies of one protein have in common: ends and loops that
/// were not resolved may differ.
const SAME_RESIDUES: f64 = 0.9;
/// Copies of one protein are nearer to each other than this, Å (root mean square over one atom of each residue).
const SAME_SHAPE_ANGSTROM: f64 = 5.0;
/// Atom by which residues are compared.
const ATOM: &str = "CA";

/// A kind of bodies as a copy of a protein.
#[derive(Debug, Clone, Copy)]
pub(super) struct Copy {
    /// Number of the species.
    pub species: usize,
    /// Motion from the frame of the first kind of the species into the frame of this kind.
    pub frame: Pose,
}

/// Number, insertion code and name of a residue.
type Key<'a> = (i32, &'a str, &'a str);

/// The species of each kind of body, and the kind that names each species. Copies with shapes of their own are one
/// species: mass action cannot tell them apart.
pub(super) fn species(bodies: &[Arc<Body>]) -> (Vec<Copy>, Vec<usize>) {
    let (mut copies, mut names): (Vec<Copy>, Vec<usize>) = (Vec::new(), Vec::new());
    for (number, body) in bodies.iter().enumerate() {
        let same = names
            .iter()
            .enumerate()
            .find_map(|(species, first)| Some((species, frame(&bodies[*first], body)?)));
        copies.push(match same {
            Some((species, frame)) => Copy { species, frame },
            None => Copy {
                species: names.len(),
                frame: Pose::identity(),
            },
        });
        if same.is_none() {
            names.push(number);
        }
    }
    (copies, names)
}

/// Motion of the frame of one body onto that of another copy; `None` if they are different proteins.
fn frame(first: &Body, copy: &Body) -> Option<Pose> {
    let (residues, other) = (places(first), places(copy));
    // Bodies without residues are told apart by their kind.
    let smaller = residues.len().min(other.len());
    let mut pairs: (Vec<Vec3>, Vec<Vec3>) = (Vec::new(), Vec::new());
    for (key, place) in &residues {
        if let Some(same) = other.get(key) {
            pairs.0.push(*place);
            pairs.1.push(*same);
        }
    }
    if smaller == 0 || (pairs.0.len() as f64) < SAME_RESIDUES * smaller as f64 {
        return None;
    }
    let best = superpose(&pairs.0, &pairs.1).ok()?;
    (best.rmsd_angstrom < SAME_SHAPE_ANGSTROM).then_some(best.pose)
}

/// Places of one atom of each residue.
fn places(body: &Body) -> BTreeMap<Key<'_>, Vec3> {
    let atoms = body.sites.iter().filter(|site| site.atom_name == ATOM);
    let place = |site: &protomer_body::Site| {
        let residue: &Residue = body.residues.get(site.residue? as usize)?;
        let key = (residue.number, &*residue.insertion_code, &*residue.name);
        Some((key, site.position))
    };
    atoms.filter_map(place).collect()
}
