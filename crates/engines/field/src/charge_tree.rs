//! Sums over many charges: a treecode.
//!
//! A mesh of the whole box would cost more than the sums it replaces: charges lie 3 Å apart, and
//! their potentials are wanted only on a surface and on six faces.
//!
//! Charges lie in the leaves of a tree of boxes. Seen from far away, a box with many charges is a
//! grid of few: the kernel is interpolated between the Chebyshev points s_k of the box, so that
//!
//! Σ_i q_i G(x, y_i) ≈ Σ_k Q_k G(x, s_k),   Q_k = Σ_i q_i L_k(y_i),
//!
//! for any kernel G that is smooth there, screened or not (Wang, Tlupova and Krasny, J. Comput.
//! Phys. X 8, 100074 (2020)). So far charges are charges like any others, and places that lie
//! together share one short list.
//!
//! A box is far if the places are at least some multiple of its half-diagonal from its middle. For
//! 1.7 ([`FAR`]) ρ of [`protomer_kernel::chebyshev`] is at least 5.7 in a cube, and five points along
//! each edge leave some 10⁻⁴ of the largest potential that the charges of a box could have there; for
//! 2.5 ([`FARTHER`]) it is 8.5 and 2 · 10⁻⁵. Errors of many boxes and signs cancel. In the tests, with
//! up to 20 000 charges at the density of a protein, these are not exceeded:
//!
//! | | potential, Σ \|q_i\| / r_i | slope or flux, Σ \|q_i\| / r_i² |
//! |---|---|---|
//! | 1.7 | 5 · 10⁻⁶ | 3 · 10⁻⁵ |
//! | 2.5 | 10⁻⁶ | 3 · 10⁻⁶ |

use crate::point_charges::Source;
use protomer_kernel::Vec3;
use protomer_kernel::chebyshev::Interpolation;
use std::ops::Range;

/// Chebyshev points along each edge of a box.
const POINTS: usize = 5;
/// Boxes with fewer charges than this are seen charge by charge.
const FEWEST: usize = 140;
/// Boxes with at most this many charges are not divided further.
const LEAF: usize = 32;
/// Distance from the middle of a box at which it is far, in half-diagonals, for terms at a surface,
/// which the grid makes less exact by far.
pub(crate) const FAR: f64 = 1.7;
/// Distance from the middle of a box at which it is far, in half-diagonals, for potentials that are
/// small because those of many charges cancel.
pub(crate) const FARTHER: f64 = 2.5;

/// Charges in a tree of boxes.
#[derive(Debug, Clone, Default)]
pub(crate) struct ChargeTree {
    /// Charges in the order of the leaves.
    sources: Vec<Source>,
    /// Boxes, the root first.
    boxes: Vec<ChargeBox>,
}

#[derive(Debug, Clone)]
struct ChargeBox {
    middle: Vec3,
    half_diagonal: f64,
    sources: Range<usize>,
    children: Option<[usize; 2]>,
    /// Charges that stand for those of the box from far away; empty where they are few.
    equivalent: Vec<Source>,
}

impl ChargeTree {
    pub fn new(sources: &[Source]) -> Self {
        let mut tree = Self {
            sources: sources.to_vec(),
            boxes: Vec::new(),
        };
        if !sources.is_empty() {
            tree.divide(0..sources.len());
        }
        tree
    }

    /// The charges.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Makes the box of these charges and those within it. Returns its number.
    fn divide(&mut self, range: Range<usize>) -> usize {
        let sources = &mut self.sources[range.clone()];
        let (low, high) = bounds(sources.iter().map(|source| &source.place));
        let number = self.boxes.len();
        self.boxes.push(ChargeBox {
            middle: 0.5 * (low + high),
            half_diagonal: 0.5 * (high - low).norm(),
            equivalent: equivalent(sources, &low, &high),
            // Before the children, as they sort their parts of the same list.
            sources: range.clone(),
            children: None,
        });
        if range.len() > LEAF {
            let (axis, _) = (high - low).argmax();
            let half = range.len() / 2;
            // Median cut along the longest side: balanced boxes, no list is copied.
            sources.select_nth_unstable_by(half, |a, b| a.place[axis].total_cmp(&b.place[axis]));
            let middle = range.start + half;
            let children = [
                self.divide(range.start..middle),
                self.divide(middle..range.end),
            ];
            // Known only now; boxes have been added since.
            self.boxes[number].children = Some(children);
        }
        number
    }

    /// Charges that stand for all charges at any place of a box, given by its lowest and highest
    /// corner; `far` is [`FAR`] or [`FARTHER`].
    pub fn seen_from(&self, low: &Vec3, high: &Vec3, far: f64) -> Vec<Source> {
        let mut sources = Vec::new();
        let mut waiting = vec![0];
        while let Some(number) = waiting.pop() {
            let Some(cluster) = self.boxes.get(number) else {
                break;
            };
            // The nearest place of the box of places to the middle of the cluster, by clamping.
            let nearest = cluster.middle.sup(low).inf(high);
            let is_far = (nearest - cluster.middle).norm() >= far * cluster.half_diagonal;
            // Far and worth it: the cluster. Else its parts, at a leaf its charges.
            match cluster.children {
                _ if is_far && !cluster.equivalent.is_empty() => {
                    sources.extend(&cluster.equivalent)
                }
                Some(children) => waiting.extend(children),
                None => sources.extend(&self.sources[cluster.sources.clone()]),
            }
        }
        sources
    }
}

/// The lowest and the highest corner of the box around places.
pub(crate) fn bounds<'a>(places: impl Iterator<Item = &'a Vec3>) -> (Vec3, Vec3) {
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for place in places {
        low = low.inf(place);
        high = high.sup(place);
    }
    (low, high)
}

/// Q_k at the points s_k of a box.
fn equivalent(sources: &[Source], low: &Vec3, high: &Vec3) -> Vec<Source> {
    if sources.len() < FEWEST {
        return Vec::new();
    }
    let points = [0, 1, 2].map(|axis| Interpolation::<POINTS>::new(low[axis], high[axis]));
    let mut strengths = [[[0.0; POINTS]; POINTS]; POINTS];
    for source in sources {
        let [x, y, z] = [0, 1, 2].map(|axis| points[axis].weights_at(source.place[axis]));
        // z outside, x inside: the weights of an axis are multiplied in once per plane and row.
        for (plane, weight) in strengths.iter_mut().zip(z) {
            let in_plane = source.strength * weight;
            for (row, weight) in plane.iter_mut().zip(y) {
                let in_row = in_plane * weight;
                for (strength, weight) in row.iter_mut().zip(x) {
                    *strength += in_row * weight;
                }
            }
        }
    }
    let mut equivalent = Vec::with_capacity(POINTS.pow(3));
    for (k, plane) in strengths.iter().enumerate() {
        for (j, row) in plane.iter().enumerate() {
            for (i, strength) in row.iter().enumerate() {
                let [x, y, z] = [
                    points[0].points[i],
                    points[1].points[j],
                    points[2].points[k],
                ];
                equivalent.push(Source {
                    place: Vec3::new(x, y, z),
                    strength: *strength,
                    least_distance_angstrom: 0.0,
                });
            }
        }
    }
    equivalent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_charges::{EdgeCharges, EdgePlace};
    use crate::point_charges::PointCharges;
    use protomer_kernel::random::CounterRng;

    /// Charges of a ball, some of them in one plane.
    fn charges(count: usize, radius: f64, rng: &mut CounterRng) -> Vec<Source> {
        (0..count)
            .map(|number| {
                let mut place = rng.vector_in_ball(radius);
                place.z *= if number % 4 == 0 { 0.0 } else { 1.0 };
                Source {
                    place,
                    strength: rng.uniform_in(-1.0, 1.0),
                    least_distance_angstrom: 1e-3,
                }
            })
            .collect()
    }

    #[test]
    fn what_is_seen_is_the_sum_over_all_charges() {
        let mut rng = CounterRng::new(18, 1, 0);
        let mut worst = [[0.0_f64; 2]; 2];
        // The density of a protein: 20 Å³ for each charge.
        for (count, radius) in [(0, 1.0), (1, 1.0), (40, 6.0), (4000, 27.0), (20000, 46.0)] {
            let sources = charges(count, radius, &mut rng);
            let tree = ChargeTree::new(&sources);
            let direct = PointCharges::new(&sources);
            let direct_at_edge = EdgeCharges::new(sources.clone(), Vec3::zeros());
            for turn in 0..24 {
                // Boxes inside, on the surface and outside.
                let low = rng.unit_vector() * (radius * turn as f64 / 16.0);
                let seen = tree.seen_from(&low, &low.add_scalar(8.0), [FAR, FARTHER][turn % 2]);
                let points = PointCharges::new(&seen);
                let at_edge = EdgeCharges::new(seen, low);
                for _ in 0..20 {
                    let place = low + Vec3::from([0, 1, 2].map(|_| rng.uniform_in(0.0, 8.0)));
                    let edge = EdgePlace {
                        middle: place,
                        axis: 1,
                        length: 0.5,
                        offset: 0.1,
                    };
                    let (mut of_value, mut of_slope) = (1e-300, 1e-300);
                    for source in &sources {
                        let r = (source.place - place).norm();
                        of_value += source.strength.abs() / r;
                        of_slope += source.strength.abs() / (r * r);
                    }
                    let (found, exact) = (at_edge.value_at(&edge), direct_at_edge.value_at(&edge));
                    let slopes = [found.slope - exact.slope, (found.flux - exact.flux) / 0.25];
                    let values = [
                        points.coulomb(&place) - direct.coulomb(&place),
                        points.screened(&place, 0.1) - direct.screened(&place, 0.1),
                        found.value - exact.value,
                    ];
                    let largest =
                        |errors: &[f64]| errors.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                    let worst = &mut worst[turn % 2];
                    worst[0] = worst[0].max(largest(&values) / of_value);
                    worst[1] = worst[1].max(largest(&slopes) / of_slope);
                }
            }
        }
        let allowed = [[5e-6, 3e-5], [1e-6, 3e-6]];
        for (worst, allowed) in worst.iter().flatten().zip(allowed.iter().flatten()) {
            assert!(worst < allowed, "{worst} {allowed}");
        }
    }
}
