//! Terms that add up.

use super::{PairForce, PairPotential, PosedPair, SmoothPotential, Term};
use crate::error::Result;

/// Sum of several potentials.
///
/// ```
/// use protomer_kernel::pair_energy::{PairPotential, PosedPair, Sum, Term};
/// use protomer_kernel::Rotation;
/// let well = Term::SquareWell { range: 1.5, depth_kt: 1.0 };
/// let step = Term::Radial { distances: vec![1.0, 2.0], energies_kt: vec![0.5, 0.0], curve: None };
/// let both = Sum::<3>::new(&[well, step])?;
/// let turn = Rotation::identity();
/// let pair = |distance| PosedPair::new([distance, 0.0, 0.0], [&turn, &turn]);
/// assert_eq!(both.energy_kt(&pair(1.2)), -0.6);
/// assert_eq!((both.range(), both.energy_kt(&pair(2.1))), (2.0, 0.0));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug)]
pub struct Sum<const D: usize>(Vec<Box<dyn PairPotential<D>>>);

impl<const D: usize> Sum<D> {
    /// The potential of these terms.
    ///
    /// # Errors
    /// As [`Term::potential`].
    pub fn new(terms: &[Term]) -> Result<Self> {
        Ok(Self(
            terms.iter().map(Term::potential).collect::<Result<_>>()?,
        ))
    }
}

impl<const D: usize> PairPotential<D> for Sum<D> {
    fn range(&self) -> f64 {
        self.0.iter().map(|term| term.range()).fold(0.0, f64::max)
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        self.0.iter().map(|term| term.energy_kt(pair)).sum()
    }

    fn virial_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        self.0.iter().map(|term| term.virial_kt(pair)).sum()
    }

    fn jumps(&self) -> Vec<f64> {
        self.0.iter().flat_map(|term| term.jumps()).collect()
    }

    fn is_directed(&self) -> bool {
        self.0.iter().any(|term| term.is_directed())
    }
}

/// Sum of several potentials with forces.
///
/// ```
/// use protomer_kernel::Rotation;
/// use protomer_kernel::pair_energy::{PosedPair, SmoothSum, Term};
/// let step = Term::Radial { distances: vec![1.0, 2.0], energies_kt: vec![0.5, 0.0], curve: None };
/// let sum = SmoothSum::<3>::new(&[step.clone(), step])?;
/// let turn = Rotation::identity();
/// let found = sum.forces_kt(&PosedPair::new([1.5, 0.0, 0.0], [&turn, &turn]));
/// assert!(found.force_kt_per_length[0] < 0.0, "they repel each other");
/// assert_eq!((sum.range(), sum.is_directed()), (2.0, false));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug)]
pub struct SmoothSum<const D: usize>(Vec<Box<dyn SmoothPotential<D>>>);

impl<const D: usize> SmoothSum<D> {
    /// The potential of these terms.
    ///
    /// # Errors
    /// As [`Term::smooth_potential`].
    pub fn new(terms: &[Term]) -> Result<Self> {
        let terms = terms.iter().map(Term::smooth_potential);
        Ok(Self(terms.collect::<Result<_>>()?))
    }

    /// Distance of the centres beyond which the energy is zero.
    pub fn range(&self) -> f64 {
        self.0.iter().map(|term| term.range()).fold(0.0, f64::max)
    }

    /// Whether the energy depends on the orientations.
    pub fn is_directed(&self) -> bool {
        self.0.iter().any(|term| term.is_directed())
    }

    /// Energy, force and torques.
    pub fn forces_kt(&self, pair: &PosedPair<'_, D>) -> PairForce<D> {
        let mut total = PairForce::zero();
        for term in &self.0 {
            total.add(&term.forces_kt(pair));
        }
        total
    }
}
