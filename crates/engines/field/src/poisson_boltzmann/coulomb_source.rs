//! The right-hand side: the Coulomb potential φ_C, taken out inside the surface, appears as sources
//! where that ends.
//!
//! The unknown is u = φ - φ_C at points inside and φ at points outside. The equations balance the
//! fluxes through the faces of boxes around the points. An edge of length h from i inside to j
//! outside meets the surface at Γ, a part t of the way, where u + φ_C and φ agree, and so do their
//! fluxes. Let ε be the permittivity of the edge, φ_C' the slope of φ_C along the edge at Γ, and
//! φ_i = φ_C - t h φ_C' the value at Γ extended to i. Then the flux of φ at Γ is
//!
//! F = ε (u_i + φ_i - φ_j),   of which φ_C has E = -ε_in h φ_C'.
//!
//! Between points inside, the part of φ_C in the fluxes needs no equation: through all six faces of
//! a box it is that of the charges in the box. So what leaves through the face in the middle of a
//! cut edge must be known exactly,
//!
//! G = ε_in/h · flux of -∇φ_C through the face,
//!
//! a sum of solid angles. Where the face is inside the surface, the flux through it is F - E + G,
//! and where it is outside, F:
//!
//! b_i = E - ε φ_i,   b_j = ε φ_i + G - E   (t > ½);      b_i = G - ε φ_i,   b_j = ε φ_i   (t ≤ ½).
//!
//! A charge in the box of a point outside adds 4π l q/h to its b. The sum over all points is then
//! that of the charges wherever the grid cuts the surface. With E for G it would only be a
//! quadrature of Gauss's integral on the points Γ: it misses 0.03 e of crambin at 0.35 Å, and 1 % of
//! the potential outside a Born ion at 0.5 Å, to no order of the spacing.

use crate::charge_tree::{ChargeTree, FAR, FARTHER, bounds};
use crate::edge_charges::{AtEdge, EXACT_IN_EDGES, EdgeCharges, EdgePlace};
use crate::far_charges::{FAR_IN_RADII, FarCharges};
use crate::grid::{Block, Grid};
use crate::point_charges::{PointCharges, Source};
use protomer_kernel::Vec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Add;

/// Edges are moved by this much, in spacings, so that no face passes through a charge that lies on the
/// grid.
const ASIDE: f64 = 1e-7;

/// An edge from a point inside to one outside.
struct Crossing {
    inside: usize,
    outside: usize,
    axis: usize,
    /// ε.
    permittivity: f64,
    /// t.
    part: f64,
    /// The middle of the edge.
    middle: Vec3,
    /// Direction from the inner to the outer end along the axis, 1 or -1.
    direction: f64,
}

/// Least number of crossings for which a polynomial of the far charges is worth its cost.
const FEWEST_CROSSINGS: usize = 10;

/// Points along the edge of a block, whose places see far charges as the same clusters.
pub(super) const BLOCK: usize = 8;

/// b of the charges, in units of permittivity times potential, with ε_in and ε_out.
pub(super) fn at_surface(
    grid: &Grid,
    edges: &[Vec<f32>; 3],
    inside: &[bool],
    coulomb: &ChargeTree,
    permittivities: [f64; 2],
) -> Vec<f64> {
    let [inner, _] = permittivities;
    let h = grid.spacing_angstrom;
    let sources_of_block = |block: &Block| {
        let crossings = crossings(block, grid, edges, inside, permittivities);
        let mut sources = Vec::with_capacity(2 * crossings.len());
        // A block without crossings needs no charges: most of them.
        if !crossings.is_empty() {
            let (low, high) = block.corners(grid);
            let merged_sources = coulomb.seen_from(&low, &high.add_scalar(ASIDE * h), FAR);
            each_with_charges(&crossings, &merged_sources, h, &mut |crossing, at_edge| {
                let [to_inside, to_outside] = crossing.sources(at_edge, inner, h);
                // Two sources per crossed edge, for the balances of both its ends.
                sources.push((crossing.inside, to_inside));
                sources.push((crossing.outside, to_outside));
            });
        }
        sources
    };
    let blocks = grid.blocks(BLOCK);
    let of_blocks: Vec<Vec<(usize, f64)>> = blocks.par_iter().map(sources_of_block).collect();
    let mut right = vec![0.0; grid.len()];
    // Collected by blocks and added in their order, whatever the threads did.
    for (point, source) in of_blocks.into_iter().flatten() {
        right[point] += source;
    }
    add_charges_outside(&mut right, grid, inside, coulomb, inner);
    right
}

/// Visits each crossing with what charges do there: those far from all crossings as one polynomial, the
/// others one by one.
fn each_with_charges(
    crossings: &[Crossing],
    charges: &[Source],
    h: f64,
    visit: &mut dyn FnMut(&Crossing, AtEdge),
) {
    let Some(first) = crossings.first() else {
        return;
    };
    let (far, near) = far_and_near(crossings, charges, h);
    let near = EdgeCharges::new(near, first.middle);
    for crossing in crossings {
        let edge = crossing.edge(h);
        let of_far = far.iter().map(|charges| charges.value_at(&edge));
        visit(crossing, of_far.fold(near.value_at(&edge), AtEdge::add));
    }
}

/// The charges far from these crossings as a polynomial, if that is worth its cost, and the others.
fn far_and_near(
    crossings: &[Crossing],
    charges: &[Source],
    h: f64,
) -> (Option<FarCharges>, Vec<Source>) {
    if crossings.len() < FEWEST_CROSSINGS {
        return (None, charges.to_vec());
    }
    let (low, high) = bounds(crossings.iter().map(|crossing| &crossing.middle));
    let middle = 0.5 * (low + high);
    let radius = crossings.iter().fold(0.0_f64, |radius, crossing| {
        radius.max((crossing.middle - middle).norm())
    });
    // At more than six edges from every crossing single sums would use Taylor's series too.
    let limit = (FAR_IN_RADII * radius).max(radius + (EXACT_IN_EDGES + 0.1) * h);
    let mut near = Vec::with_capacity(charges.len());
    let mut far = Vec::with_capacity(charges.len());
    for source in charges {
        let is_near = (source.place - middle).norm_squared() < limit * limit;
        let side = if is_near { &mut near } else { &mut far };
        side.push(*source);
    }
    (Some(FarCharges::new(&far, middle)), near)
}

impl Crossing {
    /// The edge and the place on it where the surface is.
    fn edge(&self, h: f64) -> EdgePlace {
        EdgePlace {
            middle: self.middle + Vec3::repeat(ASIDE * h),
            axis: self.axis,
            length: h,
            // From the middle of the edge, towards the outer end for t > ½.
            offset: (self.part - 0.5) * h * self.direction,
        }
    }

    /// b_i and b_j.
    fn sources(&self, at_edge: AtEdge, inner: f64, h: f64) -> [f64; 2] {
        // h φ_C': per edge, not per Å.
        let slope = h * self.direction * at_edge.slope;
        // ε φ_i, E and G.
        let extended = self.permittivity * (at_edge.value - self.part * slope);
        let at_crossing = -inner * slope;
        let through_face = inner / h * self.direction * at_edge.flux;
        // t > ½: the face in the middle of the edge is inside.
        if self.part > 0.5 {
            [
                at_crossing - extended,
                extended + through_face - at_crossing,
            ]
        } else {
            [through_face - extended, extended]
        }
    }
}

/// 4π l q/h = 4π ε_in/h · strength for charges that are nearer to a point outside than to any point
/// inside.
fn add_charges_outside(
    right: &mut [f64],
    grid: &Grid,
    inside: &[bool],
    coulomb: &ChargeTree,
    inner: f64,
) {
    let h = grid.spacing_angstrom;
    for source in coulomb.sources() {
        let (place, strength) = (source.place, source.strength);
        let mut nearest = [0; 3];
        for axis in 0..3 {
            // The same shift as for the faces: a charge on a face is given to one box only.
            let coordinate = (place[axis] - grid.origin_angstrom[axis]) / h - ASIDE;
            nearest[axis] = (coordinate.round().max(0.0) as usize).min(grid.shape[axis] - 1);
        }
        let index = grid.index(nearest[0], nearest[1], nearest[2]);
        if !inside[index] {
            right[index] += 4.0 * PI * inner * strength / h;
        }
    }
}

/// Σ s_i / r_i at some points of a grid.
pub(super) fn at_points(
    grid: &Grid,
    coulomb: &ChargeTree,
    wanted: impl Fn(usize) -> bool + Sync,
) -> Vec<(usize, f64)> {
    let of_block = |block: &Block| {
        let mut values = Vec::new();
        for row in block.rows(grid) {
            values.extend(row.filter(|point| wanted(*point)).map(|point| (point, 0.0)));
        }
        if !values.is_empty() {
            // Values are wanted at single points: only blocks that hold some look at the charges.
            let (low, high) = block.corners(grid);
            let charges = PointCharges::new(&coulomb.seen_from(&low, &high, FARTHER));
            for (point, value) in &mut values {
                *value = charges.coulomb(&grid.point_at(*point));
            }
        }
        values
    };
    let blocks = grid.blocks(BLOCK);
    let of_blocks: Vec<Vec<(usize, f64)>> = blocks.par_iter().map(of_block).collect();
    of_blocks.into_iter().flatten().collect()
}

/// The edges from the points of a block, but for those on the faces of the grid, that cross the surface.
fn crossings(
    block: &Block,
    grid: &Grid,
    edges: &[Vec<f32>; 3],
    inside: &[bool],
    permittivities: [f64; 2],
) -> Vec<Crossing> {
    let strides = grid.strides();
    let mut crossings = Vec::new();
    for row in block.without_faces(grid).rows(grid) {
        let sides = &inside[row.clone()];
        // Most rows have neighbours on their own side only.
        let is_crossed = |stride: &usize| *sides != inside[row.start + stride..row.end + stride];
        if !strides.iter().any(is_crossed) {
            continue;
        }
        for point in row {
            for (axis, stride) in strides.iter().enumerate() {
                if inside[point] != inside[point + stride] {
                    let edge = Edge {
                        grid,
                        point,
                        axis,
                        permittivity: f64::from(edges[axis][point]),
                        starts_inside: inside[point],
                    };
                    crossings.push(edge.crossing(permittivities));
                }
            }
        }
    }
    crossings
}

/// An edge from a point to the next along an axis.
struct Edge<'a> {
    grid: &'a Grid,
    point: usize,
    axis: usize,
    permittivity: f64,
    starts_inside: bool,
}

impl Edge<'_> {
    /// Crossing of the surface on this edge: t follows from 1/ε = t/ε_in + (1 - t)/ε_out.
    fn crossing(&self, [inner, outer]: [f64; 2]) -> Crossing {
        let contrast = 1.0 / inner - 1.0 / outer;
        // Without a contrast every t gives the same permittivity.
        let part = if contrast.abs() < 1e-12 {
            0.5
        } else {
            ((1.0 / self.permittivity - 1.0 / outer) / contrast).clamp(0.0, 1.0)
        };
        let next = self.point + self.grid.strides()[self.axis];
        let (inside, outside, direction) = if self.starts_inside {
            (self.point, next, 1.0)
        } else {
            (next, self.point, -1.0)
        };
        let start = self.grid.point_at(self.point);
        let step = Vec3::ith(self.axis, self.grid.spacing_angstrom);
        Crossing {
            inside,
            outside,
            axis: self.axis,
            permittivity: self.permittivity,
            part,
            middle: start + step * 0.5,
            direction,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dielectric_map::DielectricMap;
    use super::*;
    use protomer_body::surface::{Arrangement, SesSolid};
    use protomer_kernel::random::CounterRng;

    #[test]
    fn the_charge_seen_from_outside_is_all_there_is() {
        let mut rng = CounterRng::new(7, 0, 0);
        // In the smallest spheres every charge is so near to every face that its flux is exact but for
        // rounding; in the others some fluxes are expansions.
        for (radius, spacing, tolerance) in [
            (0.4, 0.5, 1e-9),
            (0.7, 1.0, 1e-9),
            (0.8, 0.5, 3e-6),
            (1.2, 1.0, 3e-6),
            (4.0, 0.5, 3e-6),
            (4.0, 2.0, 3e-6),
        ] {
            let solid = SesSolid::new(&Arrangement::new(&[Vec3::zeros()], &[radius], 1.4).unwrap());
            let sources = |rng: &mut CounterRng| Source {
                place: rng.vector_in_ball(0.98 * radius),
                strength: 1.0,
                least_distance_angstrom: 1e-3,
            };
            for _ in 0..20 {
                let corner = Vec3::repeat(radius + 5.0) + rng.vector_in_ball(spacing);
                let grid =
                    Grid::around(&(-corner), &Vec3::repeat(radius + 5.0), spacing, 2).unwrap();
                let map = DielectricMap::new(&grid, &solid, [2.0, 80.0], None);
                let mut charges: Vec<Source> = (0..20).map(|_| sources(&mut rng)).collect();
                // On a point, on a face and on the corner of a box.
                let point = grid.point(grid.shape[0] / 2, grid.shape[1] / 2, grid.shape[2] / 2);
                for part in [Vec3::zeros(), Vec3::new(0.5, 0.0, 0.0), Vec3::repeat(0.5)] {
                    charges.push(Source {
                        place: point - spacing * part,
                        ..charges[0]
                    });
                }
                charges.retain(|charge| charge.place.norm() < 0.98 * radius);
                let coulomb = ChargeTree::new(&charges);
                let right = at_surface(&grid, &map.edges, &map.inside, &coulomb, [2.0, 80.0]);
                let seen =
                    right.iter().sum::<f64>() * spacing / (4.0 * PI * 2.0) / charges.len() as f64;
                assert!((seen - 1.0).abs() < tolerance, "{radius} {spacing}: {seen}");
            }
        }
    }
}
