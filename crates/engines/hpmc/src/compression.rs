//! The pressure by trial compressions.
//!
//! When all distances between centres shrink by the factor 1 - x, n(x) pairs overlap. The
//! compressibility factor of convex bodies is Z = 1 + n'(0) / (d N) in d dimensions (Eppenga and Frenkel,
//! Mol. Phys. 52, 1303 (1984)). Bodies that are not convex may also meet when they move apart: then
//! Z = 1 + (n'(0) - m'(0)) / (d N), where m(x) pairs overlap when distances grow by the factor 1 + x (de Miguel
//! and Jackson, Mol. Phys. 104, 3717 (2006)). Convex bodies that overlap when shrunk to 1 - x overlap for all larger
//! x, and of other bodies the first contact is what counts, so each pair has one contraction. These are counted in equal bins up to
//! a largest contraction. The density of pairs, times (1 - x)^(d+1), is for spheres the radial
//! distribution function; it is fitted with a cubic polynomial, whose value at zero is n'(0).
//!
//! A [potential](crate::potential) adds the virial -r du/dr of its continuous part, and for each distance at which it jumps
//! the pairs that would cross it, counted as those that would overlap, with 1 - exp(-Δu) for each: Δu is the energy inside less
//! that outside, which for a hard core is infinite (de Miguel and Jackson, Mol. Phys. 104, 3717 (2006)).

use crate::grid::Grid;
use crate::potential::PosedPair;
use crate::system::System;
use nalgebra::{Matrix4, Vector4};

/// Bins of contractions; a power of two, because pairs are placed by bisection.
pub(crate) const BINS: usize = 32;
/// The largest contraction times the compressibility factor: over this range the density of pairs
/// falls by about half.
const RANGE: f64 = 0.8;
/// The largest contraction at low density.
const LARGEST: f64 = 0.2;
/// Relative distance from a jump of the potential at which its two sides are looked at.
const STEP: f64 = 1e-9;
/// The least value of the largest contraction.
const SMALLEST: f64 = 1e-5;

/// Measures compressibility factors by compressing up to a largest contraction.
///
/// ```
/// use protomer_hpmc::{body::HardBody, compression::Compression, system::System};
/// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
/// let disk = HardBody::<2>::ball(0.5)?;
/// let space = PeriodicBox::rectangular([10.0, 10.0])?;
/// let far_apart = vec![[0.0, 0.0], [5.0, 5.0]];
/// let system = System::new(disk, Vec::new(), space, far_apart, vec![Rotation::identity(); 2])?;
/// assert_eq!(Compression::new(&system, 1.0).factor(&system), 1.0, "an ideal gas");
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Compression {
    largest: f64,
    weights: [f64; BINS],
}

impl Compression {
    /// A measurement for a compressibility factor of about this size.
    pub fn new<const D: usize>(system: &System<D>, factor: f64) -> Self {
        // In a small box no body may meet an image of itself.
        let room = 1.0 - 2.0 * system.widest / system.space.smallest_length();
        let largest = (RANGE / factor.max(1.0))
            .min(LARGEST)
            .min(room)
            .min(before_jumps(system))
            .max(SMALLEST);
        let mut weights = weights();
        // The weights see the density of pairs times (1 - x)^(d+1), which is nearly a cubic.
        for (bin, weight) in weights.iter_mut().enumerate() {
            let middle = largest * (bin as f64 + 0.5) / BINS as f64;
            *weight *= (1.0 - middle).powi(D as i32 + 1);
        }
        Self { largest, weights }
    }

    /// The compressibility factor of one state. Its mean over states is that of the system.
    pub fn factor<const D: usize>(&self, system: &System<D>) -> f64 {
        let mut density = 0.0;
        let virial = self.visit(system, |bin, sign| density += sign * self.weights[bin]);
        1.0 + (density / self.largest + virial) / (D as f64 * system.len() as f64)
    }

    /// The factor without extrapolation, too small for a wide range but less noisy.
    pub fn rough_factor<const D: usize>(&self, system: &System<D>) -> f64 {
        let mut pairs = 0.0;
        let virial = self.visit(system, |_, sign| pairs += sign);
        1.0 + (pairs / self.largest + virial) / (D as f64 * system.len() as f64)
    }

    /// Calls `visit` with the bin of every pair that overlaps in the range, and 1 if it is contracted for that or
    /// -1 if it is expanded; and with the bin of every pair that crosses a jump of the potential, and its weight.
    /// Returns the virial of the potential.
    fn visit<const D: usize>(&self, system: &System<D>, mut visit: impl FnMut(usize, f64)) -> f64 {
        let outer = 2.0 * system.widest;
        let potential = system.potential.as_deref();
        let jumps = potential
            .map(|potential| potential.jumps())
            .unwrap_or_default();
        // Pairs that touch after the largest contraction are farther apart before it.
        let contact = outer / (1.0 - self.largest);
        let farthest = jumps.iter().map(|jump| jump / (1.0 - self.largest));
        let farthest = farthest.chain(potential.map(|potential| potential.range()));
        let range = farthest.fold(contact, f64::max);
        let grid = Grid::new(&system.space, range, &system.positions);
        let is_convex = system.body().pieces().is_none();
        let mut virial = 0.0;
        for body in 0..system.len() {
            let pose = system.where_it_is(body);
            let but = body as u32;
            // Each pair once.
            grid.any_near(&pose.position, range * range, but, |near| {
                if near.body <= but {
                    return false;
                }
                if let Some(potential) = potential {
                    let rotations = [&pose.rotation, &system.rotations[near.body as usize]];
                    let pair = PosedPair::new(near.offset, rotations);
                    virial += potential.virial_kt(&pair);
                    for jump in &jumps {
                        let change = 1.0 - jump / pair.distance;
                        if (0.0..self.largest).contains(&change) {
                            let side =
                                |factor: f64| potential.energy_kt(&pair.at_distance(jump * factor));
                            let inward = side(1.0 - STEP) - side(1.0 + STEP);
                            let bin = (change / self.largest * BINS as f64) as usize;
                            visit(bin.min(BINS - 1), 1.0 - (-inward).exp());
                        }
                    }
                }
                if near.squared >= contact * contact {
                    return false;
                }
                if is_convex {
                    let overlaps_within = |bins: usize| {
                        let part = bins as f64 / BINS as f64;
                        system.is_overlap(&pose, &near, 1.0 - part * self.largest)
                    };
                    // Once overlapping, always: only pairs that overlap at the end are bisected.
                    if overlaps_within(BINS) {
                        visit(first(overlaps_within) - 1, 1.0);
                    }
                    return false;
                }
                // Bodies with several pieces may meet either way.
                for sign in [-1.0, 1.0] {
                    if let Some(change) = system.first_contact(&pose, &near, sign, self.largest) {
                        let bin = (change / self.largest * BINS as f64) as usize;
                        visit(bin.min(BINS - 1), -sign);
                    }
                }
                false
            });
        }
        virial
    }
}

/// The largest contraction that does not bring a pair that touches, or one at a jump, to another jump: the density of pairs has a step
/// there, and is not extrapolated across it.
fn before_jumps<const D: usize>(system: &System<D>) -> f64 {
    let Some(potential) = &system.potential else {
        return f64::INFINITY;
    };
    let mut steps = potential.jumps();
    steps.push(2.0 * system.widest);
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let gaps = steps.windows(2).map(|pair| 1.0 - pair[0] / pair[1]);
    gaps.fold(f64::INFINITY, f64::min)
}

/// The least number, from 1 to `BINS`, for which a statement holds that holds for `BINS` and, with
/// any number, for all larger ones.
fn first(holds: impl Fn(usize) -> bool) -> usize {
    // Invariant: no overlap at `fails`, overlap at `works`; BINS is a power of two.
    let (mut fails, mut works) = (0, BINS);
    while works - fails > 1 {
        let middle = usize::midpoint(fails, works);
        if holds(middle) {
            works = middle;
        } else {
            fails = middle;
        }
    }
    works
}

/// Contribution of a pair in each bin to the density at zero, times the largest contraction: least
/// squares of a cubic polynomial to the counts, whose means over the bins are exact.
pub(crate) fn weights() -> [f64; BINS] {
    let mean_of_power = |bin: usize, power: usize| {
        let [low, high] = [bin, bin + 1].map(|edge| edge as f64 / BINS as f64);
        let order = power as i32 + 1;
        (high.powi(order) - low.powi(order)) / f64::from(order)
    };
    let row = |bin: usize| Vector4::from_fn(|power, _| mean_of_power(bin, power));
    // Normal equations of a cubic whose means over the bins are fitted.
    let mut normal = Matrix4::zeros();
    for bin in 0..BINS {
        normal += row(bin) * row(bin).transpose();
    }
    // The value at zero is the coefficient of the power zero.
    let at_zero = normal
        .lu()
        .solve(&Vector4::x())
        .unwrap_or_else(Vector4::zeros);
    std::array::from_fn(|bin| at_zero.dot(&row(bin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_densities_are_extrapolated_exactly() {
        let weights = weights();
        for coefficients in [[3.0, 0.0, 0.0, 0.0], [1.0, -2.0, 5.0, -0.5]] {
            let integral = |x: f64| {
                let powers = coefficients.iter().enumerate();
                powers
                    .map(|(power, c)| c * x.powi(power as i32 + 1) / (power as f64 + 1.0))
                    .sum::<f64>()
            };
            let mut found = 0.0;
            for (bin, weight) in weights.iter().enumerate() {
                let [low, high] = [bin, bin + 1].map(|edge| edge as f64 / BINS as f64);
                found += weight * (integral(high) - integral(low));
            }
            assert!((found - coefficients[0]).abs() < 1e-10, "{found}");
        }
    }

    #[test]
    fn bisection_finds_the_first() {
        for wanted in 1..=BINS {
            assert_eq!(first(|number| number >= wanted), wanted);
        }
    }
}
