//! Bodies between walls: what the walls bear, and how high the bodies are.
//!
//! A wall bears βP A = n'(0), where n(x) is the number of bodies with less than x between them and the wall:
//! so many would be in the way of a wall that moved in by x. The gaps are counted in bins, and their
//! density is extrapolated to zero as for [`compression`](crate::compression). In a field that pulls down
//! with m g, the walls' pressures differ by the weight, whatever the bodies are: β(P_low - P_high) A =
//! N β m g. With depletants this holds for all that the walls bear: those push with the pressure of
//! their reservoir, z kT, wherever they can touch a wall.

use crate::compression::{BINS, weights};
use crate::field::Gravity;
use crate::system::System;

/// Bins of heights.
pub const HEIGHT_BINS: usize = 200;
/// Gaps to a wall are counted up to this part of the length on which their density falls.
const GAPS: f64 = 0.4;

/// Pressures on the walls, and mean height of the bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walls {
    /// βP at the lower wall and at the upper, kT per volume.
    pub pressures: [f64; 2],
    /// The mean height of the centres over the lower wall.
    pub mean_height: f64,
}

impl Walls {
    /// Measures one state, at a pressure of about this size, kT per volume, under gravity.
    ///
    /// A body at the wall that rises by x is replaced by others that cross its area, so that the density
    /// of gaps falls about as exp(-(βP a + β m g) x).
    pub fn from_system<const D: usize>(
        system: &System<D>,
        gravity: &Gravity,
        pressure: f64,
    ) -> Self {
        let edges = system.space().lengths();
        let width = 2.0 * system.widest;
        let steepness = pressure * width.powi(D as i32 - 1) + gravity.weight_kt_per_length;
        let area: f64 = edges.iter().take(D - 1).product();
        let pressed = system.len() as f64 * gravity.weight_kt_per_length / area;
        // Weight of the column over the lower wall: there the gaps fall faster.
        let steepness = steepness + pressed * width.powi(D as i32 - 1);
        // Depletants press bodies that cover them to the wall, at most with all of their pressure.
        let depletants: f64 = system.depletants().iter().map(|kind| kind.fugacity).sum();
        let steepness = steepness + depletants * width.powi(D as i32 - 1);
        // Not more than a tenth of the height, or both walls would see each other.
        let largest = (GAPS / steepness).min(0.1 * edges[D - 1]);
        let weights = weights();
        let (mut density, mut heights) = ([0.0; 2], 0.0);
        for body in 0..system.len() {
            let pose = system.where_it_is(body);
            heights += pose.position[D - 1];
            let gaps = system.gaps_to_walls(&pose);
            for (density, gap) in density.iter_mut().zip(gaps) {
                // A negative gap by rounding belongs to the first bin.
                let bin = gap / largest * BINS as f64;
                if bin < BINS as f64 {
                    *density += weights[bin.max(0.0) as usize];
                }
            }
        }
        Self {
            pressures: density.map(|density| density / (largest * area)),
            mean_height: heights / system.len() as f64,
        }
    }
}

/// Numbers of centres in equal bins from the lower wall to the upper, over all samples.
///
/// ```
/// use protomer_hpmc::heights::Heights;
/// assert_eq!(Heights(vec![3, 1, 0]).parts(), [0.75, 0.25, 0.0]);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Heights(pub Vec<u64>);

impl Heights {
    pub(crate) fn count<const D: usize>(&mut self, system: &System<D>) {
        self.0.resize(HEIGHT_BINS, 0);
        let bins_per_length = HEIGHT_BINS as f64 / system.space().lengths()[D - 1];
        for place in system.positions() {
            let bin = (place[D - 1] * bins_per_length) as usize;
            self.0[bin.min(HEIGHT_BINS - 1)] += 1;
        }
    }

    /// The part of the centres in each bin.
    pub fn parts(&self) -> Vec<f64> {
        let all: u64 = self.0.iter().sum();
        self.0
            .iter()
            .map(|count| *count as f64 / all.max(1) as f64)
            .collect()
    }
}
