//! Conformational domains: how far neighbours close to the same side.
//!
//! A crystal closes from its open state to either of two sides: in the coherent motion θ_c goes from
//! π/4 to 0 or to π/2. The side of a square is that of
//!
//! u = (-1)^(i+j) (θ - ⟨θ⟩₀) - π/4,
//!
//! with ⟨θ⟩₀ the rotation of the crystal as a whole. A domain is a set of squares that rods join and
//! whose u have one sign. Over all pairs of squares d apart in one row or column,
//!
//! C(d) = ⟨u u'⟩ / ⟨u²⟩,
//!
//! 1 in a single domain that closes evenly and 0 at distances over which squares know nothing of each
//! other. No mean is taken off: with domains of either side it is zero, and a single domain has C = 1.

use crate::error::{CrystalError, Result};
use crate::lattice::Network;
use crate::lattice::force::coherent_part;
use protomer_kernel::disjoint_sets::DisjointSets;
use serde::{Deserialize, Serialize};
use std::f64::consts::{E, FRAC_PI_4};

/// u of every square: how far it is from open, with the side to which it closes.
///
/// ```
/// use protomer_linkage::analysis::domains::sides;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let sides = sides(&network, &State::coherent(&network, 0.3).positions);
/// assert!(sides.iter().all(|u| (u - 0.3 + std::f64::consts::FRAC_PI_4).abs() < 1e-12));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub fn sides(network: &Network, positions: &[f64]) -> Vec<f64> {
    let [uniform, _] = coherent_part(network, positions);
    let mut sides = Vec::with_capacity(network.squares.len());
    for p in 0..network.squares.len() {
        sides.push(network.sign(p) * (positions[3 * p + 2] - uniform) - FRAC_PI_4);
    }
    sides
}

/// Domains of one state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Domains {
    /// Number of domains.
    pub count: usize,
    /// Number of squares in the largest.
    pub largest: usize,
}

impl Domains {
    /// Domains of squares with these u.
    ///
    /// ```
    /// use protomer_linkage::analysis::domains::Domains;
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(1, 4, 0.5, Square::default(), Edges::Open, 0.3)?;
    /// let domains = Domains::find(&network, &[0.1, 0.2, -0.1, 0.3]);
    /// assert_eq!(domains, Domains { count: 3, largest: 2 });
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn find(network: &Network, sides: &[f64]) -> Self {
        let mut sets = DisjointSets::new(sides.len());
        for rod in &network.rods {
            let (p, q) = (rod.from.square, rod.to.square);
            if (sides[p] > 0.0) == (sides[q] > 0.0) {
                sets.join(p as u32, q as u32);
            }
        }
        let mut sizes = vec![0; sides.len()];
        for root in sets.into_roots() {
            sizes[root as usize] += 1;
        }
        Self {
            count: sizes.iter().filter(|size| **size > 0).count(),
            largest: sizes.into_iter().max().unwrap_or(0),
        }
    }
}

/// Averages of u u' over pairs of squares and over states.
///
/// ```
/// use protomer_linkage::analysis::domains::SideCorrelation;
/// use protomer_linkage::lattice::{Edges, Network, Square};
/// let network = Network::lattice(1, 4, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let mut correlation = SideCorrelation::new(&network);
/// correlation.push(&[0.1, 0.1, -0.1, -0.1])?;
/// assert_eq!(correlation.values().len(), 4);
/// assert!((correlation.values()[1] - 1.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SideCorrelation {
    /// Pairs of squares and their distance in squares; a square with itself at 0.
    pairs: Vec<([usize; 2], usize)>,
    sums: Vec<f64>,
    counts: Vec<f64>,
    squares: usize,
}

impl SideCorrelation {
    /// Averages for this network, without states.
    pub fn new(network: &Network) -> Self {
        let squares = network.squares.len();
        let longest = network.rows.max(network.columns);
        let mut pairs = Vec::new();
        for first in 0..squares {
            pairs.push(([first; 2], 0));
            let [row, column] = network.place(first);
            for (line, length) in [(true, network.columns), (false, network.rows)] {
                let from = if line { column } else { row };
                for to in from + 1..length {
                    let place = if line { [row, to] } else { [to, column] };
                    let apart = match network.cell {
                        Some(_) => (to - from).min(length + from - to),
                        None => to - from,
                    };
                    if let Some(second) = network.square(place[0], place[1]) {
                        pairs.push(([first, second], apart));
                    }
                }
            }
        }
        Self {
            pairs,
            sums: vec![0.0; longest],
            counts: vec![0.0; longest],
            squares,
        }
    }

    /// Adds a state, by the u of its squares.
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for another number of squares.
    pub fn push(&mut self, sides: &[f64]) -> Result<()> {
        if sides.len() != self.squares {
            return Err(CrystalError::BadState(format!(
                "{} angles for {} squares",
                sides.len(),
                self.squares
            )));
        }
        for ([first, second], apart) in &self.pairs {
            self.sums[*apart] += sides[*first] * sides[*second];
            self.counts[*apart] += 1.0;
        }
        Ok(())
    }

    /// Adds the averages of another run of the same network.
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for another number of squares.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if other.sums.len() != self.sums.len() || other.squares != self.squares {
            return Err(CrystalError::BadState(format!(
                "correlations of {} and {} squares cannot be merged",
                self.squares, other.squares
            )));
        }
        let sums = self.sums.iter_mut().zip(&other.sums);
        for ((sum, new), (count, more)) in sums.zip(self.counts.iter_mut().zip(&other.counts)) {
            *sum += new;
            *count += more;
        }
        Ok(())
    }

    /// C(d) of distances 0, 1, 2, ... squares; NaN where there is no pair or no u.
    pub fn values(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.sums.len());
        let square = self.sums[0] / self.counts[0];
        for (sum, count) in self.sums.iter().zip(&self.counts) {
            values.push(sum / count / square);
        }
        values
    }

    /// The distance in squares at which C first falls to 1/e, between distances by a straight line;
    /// `None` where it does not.
    ///
    /// ```
    /// use protomer_linkage::analysis::domains::SideCorrelation;
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(1, 4, 0.5, Square::default(), Edges::Open, 0.3)?;
    /// let mut correlation = SideCorrelation::new(&network);
    /// correlation.push(&[0.1; 4])?;
    /// assert_eq!(correlation.length(), None, "one domain");
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn length(&self) -> Option<f64> {
        let values = self.values();
        let level = 1.0 / E;
        for (d, pair) in values.windows(2).enumerate() {
            if pair[1] <= level {
                return Some(d as f64 + (pair[0] - level) / (pair[0] - pair[1]));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Edges, Square, State};
    use protomer_kernel::random::CounterRng;

    /// The slow twin: every pair of squares, by its rows and columns; domains by painting.
    #[test]
    fn correlations_and_domains_are_those_of_all_pairs() {
        let whole = Network::lattice(5, 4, 0.3, Square::default(), Edges::Open, 0.4).unwrap();
        let network = whole.without_squares(&[6]).unwrap();
        let mut rng = CounterRng::new(3, 0, 0);
        let mut correlation = SideCorrelation::new(&network);
        let (mut sums, mut counts) = (vec![0.0; 5], vec![0.0; 5]);
        for _ in 0..4 {
            let mut state = State::coherent(&network, FRAC_PI_4);
            for theta in state.positions.iter_mut().skip(2).step_by(3) {
                *theta += rng.uniform_in(-0.5, 0.5) + 0.2;
            }
            let sides = sides(&network, &state.positions);
            correlation.push(&sides).unwrap();
            for p in 0..sides.len() {
                for q in 0..sides.len() {
                    let ([a, b], [c, d]) = (network.place(p), network.place(q));
                    if a == c || b == d {
                        let apart = a.abs_diff(c) + b.abs_diff(d);
                        sums[apart] += sides[p] * sides[q];
                        counts[apart] += 1.0;
                    }
                }
            }
            assert_eq!(Domains::find(&network, &sides), painted(&network, &sides));
        }
        let square = sums[0] / counts[0];
        for (d, value) in correlation.values().into_iter().enumerate() {
            assert!((value - sums[d] / counts[d] / square).abs() < 1e-12);
        }
    }

    fn painted(network: &Network, sides: &[f64]) -> Domains {
        let mut colours: Vec<usize> = (0..sides.len()).collect();
        for _ in 0..sides.len() {
            for rod in &network.rods {
                let (p, q) = (rod.from.square, rod.to.square);
                if sides[p].signum() == sides[q].signum() {
                    let colour = colours[p].min(colours[q]);
                    (colours[p], colours[q]) = (colour, colour);
                }
            }
        }
        let size = |colour: usize| colours.iter().filter(|other| **other == colour).count();
        let sizes: Vec<usize> = (0..sides.len()).map(size).collect();
        Domains {
            count: sizes.iter().filter(|size| **size > 0).count(),
            largest: *sizes.iter().max().unwrap(),
        }
    }

    #[test]
    fn stripes_have_the_correlation_of_stripes() {
        let network = Network::lattice(8, 8, 0.3, Square::default(), Edges::Open, 0.4).unwrap();
        // Two domains, left and right.
        let sides: Vec<f64> = (0..64)
            .map(|p| if p % 8 < 4 { 0.2 } else { -0.2 })
            .collect();
        assert_eq!(
            Domains::find(&network, &sides),
            Domains {
                count: 2,
                largest: 32
            }
        );
        let mut correlation = SideCorrelation::new(&network);
        correlation.push(&sides).unwrap();
        // In a row 7 pairs are next to each other and one of them differs; in a column none.
        assert!((correlation.values()[1] - (5.0 + 7.0) / 14.0).abs() < 1e-12);
        // 0.4 at a distance of 3 and 0 at 4.
        let level = 1.0 / E;
        assert!((correlation.length().unwrap() - 3.0 - (0.4 - level) / 0.4).abs() < 1e-12);
        assert!(correlation.push(&[0.1; 3]).is_err());
    }

    #[test]
    fn rotation_of_the_crystal_is_no_side() {
        let network = Network::lattice(4, 4, 0.3, Square::default(), Edges::Open, 0.4).unwrap();
        let mut state = State::coherent(&network, 0.6);
        let before = sides(&network, &state.positions);
        for theta in state.positions.iter_mut().skip(2).step_by(3) {
            *theta += 1.3;
        }
        for (a, b) in before.iter().zip(sides(&network, &state.positions)) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
