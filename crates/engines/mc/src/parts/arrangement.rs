//! An assembly whose parts are sought.

use protomer_kernel::Pose;

/// A body of an assembly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedBody {
    /// Species: bodies of one species cannot be told apart.
    pub species: usize,
    /// Pose in the assembly.
    pub pose: Pose,
    /// Pose of the frame that all bodies of the species share; that of the body unless copies have frames of their own.
    pub frame: Pose,
    /// Square of the radius of gyration of its volume, Å².
    pub square_of_gyration_angstrom2: f64,
}

/// Bodies of an assembly and the energies between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    /// The bodies.
    pub bodies: Vec<PlacedBody>,
    /// Energy of each two bodies at their poses, kT: rows of a symmetric matrix.
    pub energies_kt: Vec<Vec<f64>>,
    /// Bodies that each body touches.
    pub neighbours: Vec<Vec<usize>>,
}

impl Arrangement {
    /// Number of species.
    pub fn species(&self) -> usize {
        let last = self.bodies.iter().map(|body| body.species).max();
        last.map_or(0, |last| last + 1)
    }

    /// Energy of some of the bodies at their poses, kT.
    pub fn energy_kt(&self, bodies: &[usize]) -> f64 {
        let mut sum = 0.0;
        for (number, first) in bodies.iter().enumerate() {
            for second in &bodies[..number] {
                sum += self.energies_kt[*first][*second];
            }
        }
        sum
    }

    /// Number of bodies of each species among some of the bodies.
    pub fn composition(&self, bodies: &[usize]) -> Vec<usize> {
        let mut counts = vec![0; self.species()];
        for body in bodies {
            counts[self.bodies[*body].species] += 1;
        }
        counts
    }

    /// The rotations with a shift that map some of the bodies onto others of the same species, within a
    /// tolerance of the displacement of each body: their number.
    pub(super) fn motions(&self, from: &[usize], onto: &[usize], tolerance_angstrom: f64) -> usize {
        let first = &self.bodies[from[0]];
        let images = onto
            .iter()
            .filter(|image| self.bodies[**image].species == first.species);
        // A body has no symmetry itself, so its image says which motion is meant.
        let motions = images.map(|image| first.frame.inverse().then(&self.bodies[*image].frame));
        motions
            .filter(|motion| self.maps(motion, from, onto, tolerance_angstrom))
            .count()
    }

    /// Whether a motion maps bodies onto others, each onto a different one.
    fn maps(&self, motion: &Pose, from: &[usize], onto: &[usize], tolerance_angstrom: f64) -> bool {
        let mut is_met = vec![false; onto.len()];
        for body in from {
            let moved = self.bodies[*body].frame.then(motion);
            let met = onto.iter().position(|image| {
                let image = &self.bodies[*image];
                let angle_rad = image.frame.rotation.angle_to(&moved.rotation);
                let square = (image.frame.position - moved.position).norm_squared()
                    + image.square_of_gyration_angstrom2 * angle_rad.powi(2);
                image.species == self.bodies[*body].species && square < tolerance_angstrom.powi(2)
            });
            match met {
                Some(number) if !is_met[number] => is_met[number] = true,
                _ => return false,
            }
        }
        true
    }
}
