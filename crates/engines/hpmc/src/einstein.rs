//! Bodies on springs, and the free energy of bodies on springs alone (Einstein crystal).
//!
//! The energy of N bodies with displacements d_i from their sites and orientations with the potentials
//! u_i (see [`symmetry`](crate::symmetry)) is
//!
//! ```text
//! E = λ [ Σ |d_i - d|² + κ Σ u_i ],   d = Σ d_i / N
//! ```
//!
//! The springs hold the bodies to a lattice that goes with their centre of mass. It may drift: no body is
//! fixed and nothing is pulled back, so weak springs leave no slow motion of the whole crystal
//! (compare Polson, Trizac, Pronk and Frenkel, J. Chem. Phys. 112, 5339 (2000), who fix it).
//!
//! Rows of bodies with flat faces slide. A row that has slid by a translation of the lattice is the same
//! crystal with other bodies on its sites, which is counted already. So a body may slip past another, to
//! which a translation t leads, by no more than half of any translation across t: in d_i - d_j the part
//! along a translation s is at most s²/2, where t and s are nearly at right angles.

use crate::crystal::{Bond, Crystal};
use crate::field::Field;
use crate::symmetry::Symmetry;
use crate::system::{System, Trial};
use protomer_kernel::Rotation;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::dot;
use std::f64::consts::PI;

/// Bodies on springs.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::crystal::{Crystal, UnitCell};
/// use protomer_hpmc::{einstein::Springs, symmetry::Symmetry};
/// let ball = HardBody::<3>::ball(0.5)?;
/// let crystal = Crystal::new(&UnitCell::by_name("fcc")?, &ball, 32, 0.5)?;
/// let springs = Springs::new(&crystal, &Symmetry::find(&ball)?, 0.0).with_strength(100.0);
/// assert_eq!((springs.strength(), springs.extent()), (100.0, 0.0), "all stand on their sites");
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Springs<const D: usize> {
    symmetry: Symmetry,
    wanted: Vec<Rotation>,
    bonds: Vec<Bond<D>>,
    /// Smaller slips than this, squared, are not too long for any bond.
    short_squared: f64,
    /// λ, kT per squared length.
    strength: f64,
    /// κ, squared length.
    turning: f64,
    displacements: Vec<[f64; D]>,
    sum: [f64; D],
    squares: f64,
    potentials: Vec<f64>,
    potential: f64,
    /// Step of the move whose change was requested last.
    step: [f64; D],
    new_potential: f64,
}

impl<const D: usize> Springs<D> {
    /// Springs without strength for bodies that stand on the sites of a crystal.
    pub fn new(crystal: &Crystal<D>, symmetry: &Symmetry, turning: f64) -> Self {
        let bodies = crystal.positions.len();
        let bonds = crystal.bonds(symmetry);
        let mut short_squared = f64::INFINITY;
        for slip in bonds.iter().flat_map(|bond| &bond.slips) {
            // Half a translation, squared: no shorter
            // displacement can be more than half way along it.
            short_squared = short_squared.min(0.25 * dot(slip, slip));
        }
        Self {
            symmetry: symmetry.clone(),
            wanted: crystal.rotations.clone(),
            bonds,
            short_squared,
            strength: 0.0,
            turning,
            displacements: vec![[0.0; D]; bodies],
            sum: [0.0; D],
            squares: 0.0,
            potentials: vec![0.0; bodies],
            potential: 0.0,
            step: [0.0; D],
            new_potential: 0.0,
        }
    }

    /// The same springs with the strength λ, kT per squared length.
    pub fn with_strength(mut self, strength: f64) -> Self {
        self.strength = strength;
        self
    }

    /// Strength λ, kT per squared length.
    pub fn strength(&self) -> f64 {
        self.strength
    }

    /// The displacements from the sites, from one image to the next without jumps.
    pub fn displacements(&self) -> &[[f64; D]] {
        &self.displacements
    }

    /// Takes displacements as they were saved; [`refresh`](Self::refresh) must follow before a move.
    pub(crate) fn restore(&mut self, displacements: &[[f64; D]]) {
        self.displacements = displacements.to_vec();
    }

    /// Computes all sums again, with displacements about the centre of mass.
    pub(crate) fn refresh(&mut self, rotations: &[Rotation]) {
        let bodies = self.displacements.len() as f64;
        let mut mean = [0.0; D];
        for displacement in &self.displacements {
            for axis in 0..D {
                mean[axis] += displacement[axis] / bodies;
            }
        }
        (self.sum, self.squares, self.potential) = ([0.0; D], 0.0, 0.0);
        // About the centre of mass: the sum is zero again, and rounding does not add up over a run.
        for displacement in &mut self.displacements {
            for axis in 0..D {
                displacement[axis] -= mean[axis];
                self.sum[axis] += displacement[axis];
            }
            self.squares += dot(displacement, displacement);
        }
        for (body, rotation) in rotations.iter().enumerate() {
            self.potentials[body] = self.symmetry.potential(&self.wanted[body], rotation);
            self.potential += self.potentials[body];
        }
    }

    /// Whether a body, after a step, has slipped too far past another.
    fn slips(&self, body: usize, step: &[f64; D]) -> bool {
        self.bonds.iter().any(|bond| {
            let other = &self.displacements[bond.others[body]];
            let displacement = &self.displacements[body];
            let apart: [f64; D] =
                std::array::from_fn(|axis| displacement[axis] + step[axis] - other[axis]);
            // |d·s| > s²/2: past the middle between two sites of the row.
            let is_too_long = |slip: &[f64; D]| 2.0 * dot(&apart, slip).abs() > dot(slip, slip);
            // The cheap bound first; nearly all steps end with it.
            dot(&apart, &apart) > self.short_squared && bond.slips.iter().any(is_too_long)
        })
    }

    /// E/(λ N): the squared displacement per body from a lattice that goes with the bodies, and κ times the
    /// potential of the orientations.
    pub fn extent(&self) -> f64 {
        let bodies = self.displacements.len() as f64;
        let centres = self.squares - dot(&self.sum, &self.sum) / bodies;
        (centres + self.turning * self.potential) / bodies
    }
}

impl<const D: usize> Field<D> for Springs<D> {
    fn change_kt(&mut self, system: &System<D>, trial: &Trial<D>) -> f64 {
        let body = trial.body;
        if trial.is_turned {
            self.new_potential = self.symmetry.potential(&self.wanted[body], &trial.rotation);
            return self.strength * self.turning * (self.new_potential - self.potentials[body]);
        }
        self.step = system.nearest_image(&system.positions[body], &trial.position);
        // Infinite energy: refused whatever the number drawn.
        if self.slips(body, &self.step) {
            return f64::INFINITY;
        }
        let bodies = self.displacements.len() as f64;
        let squared = dot(&self.step, &self.step);
        // Change of the squares of all about a centre of mass that moves with the step.
        let body_term = 2.0 * dot(&self.displacements[body], &self.step) + squared;
        let all = (2.0 * dot(&self.sum, &self.step) + squared) / bodies;
        self.strength * (body_term - all)
    }

    fn moved(&mut self, trial: &Trial<D>) {
        let body = trial.body;
        if trial.is_turned {
            self.potential += self.new_potential - self.potentials[body];
            self.potentials[body] = self.new_potential;
            return;
        }
        let squared = dot(&self.step, &self.step);
        // The same change, now kept.
        self.squares += 2.0 * dot(&self.displacements[body], &self.step) + squared;
        for axis in 0..D {
            self.displacements[body][axis] += self.step[axis];
            self.sum[axis] += self.step[axis];
        }
    }
}

/// An ideal crystal: bodies that feel springs and not each other.
#[derive(Debug, Clone)]
pub struct EinsteinCrystal<'a, const D: usize> {
    /// The sites.
    pub crystal: &'a Crystal<D>,
    /// The symmetry of the bodies.
    pub symmetry: &'a Symmetry,
    /// λ, kT per squared length.
    pub strength: f64,
    /// κ, squared length.
    pub turning: f64,
}

/// The terms of the free energy of an Einstein crystal, in kT per body, for a thermal wavelength of one
/// and an integral of one over all orientations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EinsteinTerms {
    /// Term of the centre of mass: -[ln v + (D/2) ln N]/N, with the volume v of the primitive cell.
    pub centre_of_mass_kt: f64,
    /// Term of the springs: -D (1 - 1/N)/2 ln(π/λ).
    pub springs_kt: f64,
    /// Term of the orientations: -ln z(λκ).
    pub orientations_kt: f64,
}

impl EinsteinTerms {
    /// Sum of the terms.
    pub fn total_kt(&self) -> f64 {
        self.centre_of_mass_kt + self.springs_kt + self.orientations_kt
    }
}

impl<const D: usize> EinsteinCrystal<'_, D> {
    /// The free energy, exactly, at this number of bodies.
    ///
    /// The N! ways to give the sites to the bodies cancel the 1/N! of equal bodies. A place X of the centre
    /// of mass and displacements e_i that sum to zero make a state, and X moved by a translation of the
    /// lattice makes the same state again, so X is integrated over one primitive cell of volume v:
    ///
    /// ```text
    /// Q = v ∫ δ(Σ e_i/N) exp(-λ Σ e_i²) = v N^(D/2) (π/λ)^(D(N-1)/2)
    /// ```
    ///
    /// and each orientation adds a factor z. With one body per primitive cell, v = V/N.
    pub fn terms(&self) -> EinsteinTerms {
        let (bodies, dimension) = (self.crystal.positions.len() as f64, D as f64);
        let cell = self.crystal.primitive_volume(self.symmetry);
        let springs = 0.5 * dimension * (1.0 - 1.0 / bodies);
        EinsteinTerms {
            centre_of_mass_kt: -(cell.ln() + 0.5 * dimension * bodies.ln()) / bodies,
            springs_kt: -springs * (PI / self.strength).ln(),
            // Without orientations this is zero, not minus zero.
            orientations_kt: 0.0 - self.symmetry.integral(self.strength * self.turning).ln(),
        }
    }

    /// A state: displacements that sum to zero, and orientations.
    pub(crate) fn sample(&self, rng: &mut CounterRng) -> (Vec<[f64; D]>, Vec<Rotation>) {
        // exp(-λ d²) is normal with the variance 1/(2λ).
        let width = (2.0 * self.strength).recip().sqrt();
        let bodies = self.crystal.positions.len();
        let (mut displacements, mut rotations) = (Vec::new(), Vec::new());
        let mut mean = [0.0; D];
        for wanted in &self.crystal.rotations {
            let mut displacement = [0.0; D];
            for axis in 0..D {
                displacement[axis] = width * rng.normal();
                mean[axis] += displacement[axis] / bodies as f64;
            }
            displacements.push(displacement);
            let strength = self.strength * self.turning;
            rotations.push(self.symmetry.sample(wanted, strength, rng));
        }
        // Without the centre of mass, which the free energy counts separately.
        for displacement in &mut displacements {
            for axis in 0..D {
                displacement[axis] -= mean[axis];
            }
        }
        (displacements, rotations)
    }
}
