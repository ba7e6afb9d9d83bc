//! The solvent-accessible surface as faces, arcs and vertices.
//!
//! The accessible surface is the boundary of the union of balls of radius R = r + p about the atoms
//! (Lee and Richards, J. Mol. Biol. 55, 379 (1971)). A *face* is a connected part of it on one
//! ball, an *arc* a part of the circle in which two balls meet, a *vertex* a probe position that
//! touches three atoms. Arcs are found by clipping each circle with the balls near it (`circle`),
//! which is linear in the number of atoms; the pieces are then joined by their names alone
//! (`join`): each vertex must be met by exactly three circles, otherwise a coincidence was not
//! resolved and everything is repeated with a larger perturbation (`balls`). Faces are traced when they
//! are first requested (`faces`): a signed distance does without them.

mod balls;
mod cells;
pub(crate) mod circle;
mod faces;
mod join;
pub(crate) mod spherical;

use crate::Result;
use balls::Balls;
pub(crate) use balls::{hashed_fraction, invalid};
pub(crate) use cells::CellList;
use circle::Cap;
use faces::Traced;
use join::Joined;
use protomer_kernel::Vec3;
use std::sync::OnceLock;

/// Amplitudes of the perturbation of the radii, Å, tried in turn. The first is the rule, the others
/// have never been needed for real structures.
const PERTURBATIONS_ANGSTROM: [f64; 5] = [1e-8, 3e-8, 1e-7, 1e-6, 1e-5];

/// An arc of the accessible surface: a part of the circle in which the expanded balls of two atoms
/// meet, or all of it.
#[derive(Debug, Clone, Copy)]
pub struct Arc {
    /// The two atoms, the smaller index first.
    pub atoms: [u32; 2],
    /// Centre of the circle, Å.
    pub centre: Vec3,
    /// Unit vector from the first atom to the second.
    pub axis: Vec3,
    /// Radius of the circle, Å.
    pub radius: f64,
    /// Signed distance of the circle's plane from the first atom along the axis, Å.
    pub height: f64,
    /// Unit vectors from the circle's centre to the start and the end of the arc, which runs
    /// counter-clockwise about the axis; equal for a whole circle.
    pub ends: [Vec3; 2],
    /// Unit vector from the circle's centre to the middle of the arc.
    pub middle: Vec3,
    /// Angle of the arc, radians; 2π for a whole circle.
    pub angle: f64,
    /// The vertices at its start and end; none for a whole circle.
    pub vertices: Option<[u32; 2]>,
}

/// A probe position that touches three atoms.
#[derive(Debug, Clone, Copy)]
pub struct Vertex {
    /// The three atoms, in increasing order.
    pub atoms: [u32; 3],
    /// The probe's centre, Å.
    pub position: Vec3,
    /// The arcs that end here, on the circles of atoms (0, 1), (0, 2) and (1, 2).
    pub arcs: [u32; 3],
}

/// A connected part of the accessible surface on one ball.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// The atom on whose ball the face lies.
    pub atom: u32,
    /// Shell of the face: its connected component of the accessible surface.
    pub shell: u32,
    /// Solid angle seen from the atom.
    pub solid_angle: f64,
    /// ∫ u dΩ of the unit normals u of the face.
    pub vector_angle: Vec3,
}

/// The accessible surface of a set of atoms.
///
/// ```
/// use protomer_body::surface::Arrangement;
/// use protomer_kernel::Vec3;
/// let atoms = [Vec3::zeros(), Vec3::new(1.5, 0.0, 0.0)];
/// let accessible = Arrangement::new(&atoms, &[1.7, 1.7], 1.4)?;
/// assert_eq!((accessible.faces().len(), accessible.arcs().len()), (2, 1));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Arrangement {
    probe_radius: f64,
    perturbation: f64,
    balls: Balls,
    joined: Joined,
    traced: OnceLock<Traced>,
}

impl Arrangement {
    /// The accessible surface of atoms at `centres` (Å) with `radii_angstrom` for a probe of radius
    /// `probe_radius_angstrom`.
    ///
    /// # Errors
    /// [`crate::BodyError::Invalid`] for no atoms, for coordinates or radii that are negative, not
    /// finite or absurdly large, and for so many atoms on top of each other that no result could be
    /// had in reasonable time.
    pub fn new(
        centres: &[Vec3],
        radii_angstrom: &[f64],
        probe_radius_angstrom: f64,
    ) -> Result<Self> {
        let exact = Balls::new(centres, radii_angstrom, probe_radius_angstrom)?;
        // Each amplitude gives every radius another hash, so that a
        // coincidence that survives one does not survive the next.
        for amplitude in PERTURBATIONS_ANGSTROM {
            let balls = exact.perturbed(amplitude);
            let Some(joined) = join::join(&balls) else {
                continue;
            };
            return Ok(Self {
                probe_radius: probe_radius_angstrom,
                perturbation: amplitude,
                balls,
                joined,
                traced: OnceLock::new(),
            });
        }
        Err(invalid(
            "the atoms coincide in a way that no perturbation resolved",
            "move the atoms by about 1e-3 Å",
        ))
    }

    /// Radius of the probe, Å.
    pub fn probe_radius_angstrom(&self) -> f64 {
        self.probe_radius
    }

    /// Largest growth of the radii to resolve coincidences, Å.
    pub fn perturbation_angstrom(&self) -> f64 {
        self.perturbation
    }

    /// Centres of the atoms, Å.
    pub fn centres(&self) -> &[Vec3] {
        &self.balls.centres
    }

    /// Radii of the expanded balls: atomic radius, probe radius and perturbation, Å.
    ///
    /// ```
    /// use protomer_body::surface::Arrangement;
    /// use protomer_kernel::Vec3;
    /// let arrangement = Arrangement::new(&[Vec3::zeros()], &[1.7], 1.4)?;
    /// assert!((arrangement.expanded_radii_angstrom()[0] - 3.1).abs() < 1e-6);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn expanded_radii_angstrom(&self) -> &[f64] {
        &self.balls.radii
    }

    /// The arcs.
    pub fn arcs(&self) -> &[Arc] {
        &self.joined.arcs
    }

    /// The vertices.
    pub fn vertices(&self) -> &[Vertex] {
        &self.joined.vertices
    }

    /// The faces, in the order of their atoms.
    pub fn faces(&self) -> &[Face] {
        &self.traced().faces
    }

    /// Number of shells, the connected components of the accessible surface.
    ///
    /// ```
    /// use protomer_body::surface::Arrangement;
    /// use protomer_kernel::Vec3;
    /// let shells = |x| Arrangement::new(&[Vec3::zeros(), Vec3::new(x, 0.0, 0.0)], &[1.7; 2], 1.4);
    /// assert_eq!((shells(6.0)?.shell_count(), shells(6.5)?.shell_count()), (1, 2));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn shell_count(&self) -> usize {
        self.traced().shells as usize
    }

    /// The shell that an arc belongs to.
    pub fn shell_of_arc(&self, arc: usize) -> Option<u32> {
        self.traced().arc_shells.get(arc).copied()
    }

    /// Atoms with at least one face, in increasing order.
    ///
    /// ```
    /// use protomer_body::surface::Arrangement;
    /// use protomer_kernel::Vec3;
    /// let centres = [Vec3::zeros(), Vec3::new(0.5, 0.0, 0.0)];
    /// let arrangement = Arrangement::new(&centres, &[3.0, 1.0], 1.4)?;
    /// assert_eq!(arrangement.exposed_atoms(), [0], "the small atom is inside the large one");
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn exposed_atoms(&self) -> Vec<u32> {
        let mut atoms = self.joined.free_atoms.clone();
        for arc in &self.joined.arcs {
            atoms.extend(arc.atoms);
        }
        atoms.sort_unstable();
        atoms.dedup();
        atoms
    }

    fn traced(&self) -> &Traced {
        let trace = || faces::trace(&self.balls, &self.joined);
        self.traced.get_or_init(trace)
    }

    /// Faces whose boundary did not close to a possible solid angle: zero, unless rounding defeated
    /// the arrangement.
    pub(crate) fn defects(&self) -> u32 {
        self.traced().defects
    }

    /// The caps that other balls cut off the ball of `atom`, largest first.
    pub(crate) fn caps(&self, atom: u32, caps: &mut Vec<Cap>) -> Option<()> {
        self.balls.caps(atom, caps)
    }

    /// Atoms that take part (of duplicates, the largest), neighbours in space next to each other.
    pub(crate) fn members(&self) -> &[u32] {
        self.balls.members()
    }
}

impl Arc {
    /// The point of the arc in this direction from the circle's centre, Å.
    pub(crate) fn point(&self, direction: &Vec3) -> Vec3 {
        self.centre + direction * self.radius
    }
}

#[cfg(test)]
mod tests;
