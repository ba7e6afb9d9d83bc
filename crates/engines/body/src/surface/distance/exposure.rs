//! Whether a point of an expanded sphere belongs to the accessible surface: whether it lies in all
//! half-spaces that the other balls leave of the sphere.

use crate::surface::arrangement::Arrangement;
use protomer_kernel::{Vec3, vectorised};

/// Half-spaces that are looked at together.
const LANES: usize = 8;

/// Half-spaces n·u <= h with u from the atom's centre, Å.
#[derive(Debug, Clone, Copy)]
struct HalfSpaces {
    axes: [[f64; LANES]; 3],
    heights: [f64; LANES],
}

impl HalfSpaces {
    /// Half-spaces that hold everything.
    const EVERYTHING: Self = Self {
        // n = 0 and h = ∞: 0 <= ∞ holds for every point, so padding never decides.
        axes: [[0.0; LANES]; 3],
        heights: [f64::INFINITY; LANES],
    };

    #[inline(always)]
    fn hold(&self, [x, y, z]: [f64; 3]) -> bool {
        let mut hold = true;
        // All eight without a branch between them: that is what vectorises.
        for lane in 0..LANES {
            let [nx, ny, nz] = &self.axes;
            hold &= nx[lane] * x + ny[lane] * y + nz[lane] * z <= self.heights[lane];
        }
        hold
    }
}

/// The exposed parts of the expanded spheres.
#[derive(Debug, Clone)]
pub(super) struct Exposure {
    /// Whether anything of an atom is exposed.
    pub(super) atoms: Vec<bool>,
    /// Starts of the half-spaces of each atom: those of atom i are `starts[i] .. starts[i + 1]`,
    /// largest cap first; buried atoms have none.
    starts: Vec<u32>,
    half_spaces: Vec<HalfSpaces>,
}

impl Exposure {
    pub(super) fn from_arrangement(accessible: &Arrangement) -> Self {
        let radii = accessible.expanded_radii_angstrom();
        let mut atoms = vec![false; radii.len()];
        for atom in accessible.exposed_atoms() {
            atoms[atom as usize] = true;
        }
        let mut half_spaces = Vec::new();
        let mut starts = vec![0];
        let mut caps = Vec::new();
        for (atom, (radius, is_exposed)) in radii.iter().zip(&atoms).enumerate() {
            if *is_exposed && accessible.caps(atom as u32, &mut caps).is_some() {
                // Largest cap first: a point that is covered at
                // all is most likely covered by one of these.
                for caps in caps.chunks(LANES) {
                    let mut together = HalfSpaces::EVERYTHING;
                    for (lane, cap) in caps.iter().enumerate() {
                        for axis in 0..3 {
                            together.axes[axis][lane] = cap.axis[axis];
                        }
                        // The cap's height is a cosine on the unit sphere;
                        // times the radius it compares with a point in Å.
                        together.heights[lane] = cap.height * radius;
                    }
                    half_spaces.push(together);
                }
            }
            starts.push(half_spaces.len() as u32);
        }
        Self {
            atoms,
            starts,
            half_spaces,
        }
    }

    vectorised!(
        /// Whether the point of the sphere of an exposed atom that is at `onto` from its centre, Å, is in
        /// no other ball.
        pub(super) fn is_exposed[is_exposed_avx512, is_exposed_avx2, is_exposed_any](self: &Self, atom: usize, onto: &Vec3) -> bool
    );

    #[inline(always)]
    pub(super) fn is_exposed_any(&self, atom: usize, onto: &Vec3) -> bool {
        let range = self.starts[atom] as usize..self.starts[atom + 1] as usize;
        // A loop: the closure of an iterator's method would be compiled for the oldest processors.
        for some in &self.half_spaces[range] {
            if !some.hold([onto.x, onto.y, onto.z]) {
                return false;
            }
        }
        true
    }
}
