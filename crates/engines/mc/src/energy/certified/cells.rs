//! The potential of a body in cells of space, each with a proven bound of its error.
//!
//! In a cubic cell the charges near it are summed one by one. The potential of all others is a polynomial
//! (`series`), which misses it by no more than
//!
//! ε = C_n h^n Σ_k |q_k| D_n(d_k),   D_n(d) = sup |∂^n v| / n! at distances of d and more,
//!
//! with the half edge h and the distance d_k of charge k from the cell. The cells are the leaves of an
//! octree: the largest whose ε is small enough and that are near few charges. They are made when a charge
//! first comes there, each a function of its place alone.

use super::series::{Interpolation, POINTS, Series, value};
use crate::charges::{ChargeCloud, ChargeGroup, LANES};
use crate::energy::SitePotential;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::vectorised;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Groups of charges nearer to a cell than this many of its half edges are summed one by one.
const NEAR_HALF_EDGES: f64 = 4.0;
/// Largest number of groups near a cell that is not divided.
const MOST_NEAR_GROUPS: usize = 8;
/// Half edge of the cells that are never divided, Å.
const LEAST_HALF_EDGE_ANGSTROM: f64 = 2.0;
/// The largest octree, Å. Charges farther away are summed directly.
const MOST_HALF_EDGE_ANGSTROM: f64 = 16384.0;
/// A body like this one, all of it in cells of the largest error, would have this error, kT.
const TARGET_KT: f64 = 2e-3;
/// Roundings of a value that is summed over N charges, in units of N + 1: a sum of N terms, potentials to
/// a few units in the last place, and the polynomial with its 24 terms along three axes.
const ROUNDINGS: f64 = 64.0;

/// The potential of one body type, in its frame.
#[derive(Debug)]
pub struct Cells {
    potential: Yukawa,
    charges: ChargeCloud,
    half_edge_angstrom: f64,
    root: Node,
    interpolation: Interpolation,
    made: AtomicUsize,
}

/// A cube of space; empty until a charge comes there.
#[derive(Debug, Default)]
struct Node(OnceLock<Content>);

#[derive(Debug)]
enum Content {
    Divided(Box<[Node; 8]>),
    Leaf(Cell),
}

#[derive(Debug)]
struct Cell {
    centre: Vec3,
    half_edge_angstrom: f64,
    /// Groups of charges that are summed one by one.
    near: Vec<u32>,
    series: Box<Series>,
    /// Largest error of the potential anywhere in the cell, kT/e.
    error_kt_per_e: f64,
}

/// An energy and the largest error that it can have, kT.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Interval {
    /// Middle of the interval.
    pub energy_kt: f64,
    /// Largest distance of the energy from the middle.
    pub error_kt: f64,
}

impl Cell {
    fn holds(&self, x: &Vec3) -> bool {
        (x - self.centre).amax() <= self.half_edge_angstrom
    }
}

/// The charges around a cell, and what they mean for a polynomial in it.
struct Surroundings<'a> {
    near: Vec<u32>,
    far: Vec<&'a ChargeGroup>,
    /// ε, kT/e.
    error_kt_per_e: f64,
    /// Σ |q| v at the nearest place of the cell, kT/e: no potential of the far charges is larger.
    magnitude_kt_per_e: f64,
}

impl Cells {
    /// Cells around these charges, out to this distance from the body's origin.
    pub fn new(charges: &ChargeCloud, potential: &Yukawa, reach_angstrom: f64) -> Self {
        let mut half_edge_angstrom = LEAST_HALF_EDGE_ANGSTROM;
        // Doubled, so that halving leads back to the least half edge exactly.
        while half_edge_angstrom < reach_angstrom.min(MOST_HALF_EDGE_ANGSTROM) {
            half_edge_angstrom *= 2.0;
        }
        Self {
            potential: *potential,
            charges: charges.clone(),
            half_edge_angstrom,
            root: Node::default(),
            interpolation: Interpolation::new(),
            made: AtomicUsize::new(0),
        }
    }

    /// The charges.
    pub(super) fn charges(&self) -> &ChargeCloud {
        &self.charges
    }

    /// Bytes held so far.
    pub fn memory_bytes(&self) -> usize {
        // Counted, not walked: cells are made by several threads while others read.
        self.made.load(Ordering::Relaxed) * (size_of::<Series>() + size_of::<Node>())
    }

    /// The cell that holds a place; `None` beyond the octree.
    fn cell_at(&self, x: &Vec3) -> Option<&Cell> {
        // Nothing is inside for a place that is not a number.
        let is_inside = x.amax() <= self.half_edge_angstrom;
        if !is_inside {
            return None;
        }
        let (mut node, mut centre, mut half) = (&self.root, Vec3::zeros(), self.half_edge_angstrom);
        loop {
            // Made by the first thread that comes here; others wait for it. A cell
            // depends on its place alone, so results do not depend on who made it.
            match node.0.get_or_init(|| self.content(centre, half)) {
                Content::Leaf(cell) => return Some(cell),
                Content::Divided(parts) => {
                    half *= 0.5;
                    let mut part = 0;
                    for axis in 0..3 {
                        let is_above = x[axis] > centre[axis];
                        // Bit `axis` of the number of a part says
                        // on which side of the centre it lies.
                        part |= usize::from(is_above) << axis;
                        centre[axis] += if is_above { half } else { -half };
                    }
                    node = &parts[part];
                }
            }
        }
    }

    /// A cell, or a division into eight.
    fn content(&self, centre: Vec3, half_edge_angstrom: f64) -> Content {
        let around = self.surroundings(&centre, half_edge_angstrom);
        // Each charge of a like body may have the error ε: together Σ|q| ε stays at the target.
        let tolerance = TARGET_KT / self.charges.sum_of_magnitudes_e().max(1.0);
        let serves = around.error_kt_per_e <= tolerance && around.near.len() <= MOST_NEAR_GROUPS;
        // At the least edge a cell is accepted as it is; its ε says how good it is.
        if !serves && half_edge_angstrom > LEAST_HALF_EDGE_ANGSTROM {
            return Content::Divided(Box::default());
        }
        let value = |coordinates| {
            let place = centre + half_edge_angstrom * Vec3::from(coordinates);
            self.potential_of(&around.far, &place)
        };
        let values: Vec<f64> = self.interpolation.points().map(value).collect();
        self.made.fetch_add(1, Ordering::Relaxed);
        // A sum of N terms rounds by N units of its largest partial sum at most.
        let roundings = ROUNDINGS * (self.charges.len() + 1) as f64 * f64::EPSILON;
        // Errors at the points, enlarged by the interpolation along three axes.
        let rounding = roundings * self.interpolation.amplification * around.magnitude_kt_per_e;
        let (series, change) = self.interpolation.series(&values);
        Content::Leaf(Cell {
            centre,
            half_edge_angstrom,
            near: around.near,
            series: Box::new(series),
            error_kt_per_e: around.error_kt_per_e + rounding + change,
        })
    }

    fn surroundings(&self, centre: &Vec3, half_edge_angstrom: f64) -> Surroundings<'_> {
        let mut around = Surroundings {
            near: Vec::new(),
            far: Vec::new(),
            error_kt_per_e: 0.0,
            magnitude_kt_per_e: 0.0,
        };
        // Vector from the cube to a place, zero along axes where the place is within.
        let outside = |x: Vec3| (x - centre).map(|x| (x.abs() - half_edge_angstrom).max(0.0));
        for (number, group) in self.charges.groups().iter().enumerate() {
            let distance = outside(group.centre).norm() - group.radius_angstrom;
            // A polynomial converges for charges outside of it; nearer groups are kept as they are.
            if distance < NEAR_HALF_EDGES * half_edge_angstrom {
                around.near.push(number as u32);
                continue;
            }
            around.far.push(group);
            for lane in 0..LANES {
                let place = Vec3::new(group.x[lane], group.y[lane], group.z[lane]);
                let (distance, charge) = (outside(place).norm(), group.charge_e[lane].abs());
                // The nearest place of the cell: derivatives
                // fall with the distance, so none is larger.
                let derivative = self.potential.derivative_bound(POINTS, distance);
                around.error_kt_per_e += charge * derivative;
                around.magnitude_kt_per_e += charge * self.potential.at_square(distance.powi(2));
            }
        }
        // C_n h^n, the same for every charge, last.
        around.error_kt_per_e *=
            self.interpolation.error_factor * half_edge_angstrom.powi(POINTS as i32);
        around
    }

    vectorised! {
        fused
        /// The potential of groups of charges at a place, kT/e.
        fn potential_of[potential_avx512, potential_avx2, potential_sum](
            self: &Self,
            groups: &[&ChargeGroup],
            x: &Vec3
        ) -> f64
    }

    #[inline(always)]
    fn potential_sum<const FUSED: bool>(&self, groups: &[&ChargeGroup], x: &Vec3) -> f64 {
        let (mut lanes, mut magnitudes) = ([0.0; LANES], [0.0; LANES]);
        for group in groups {
            self.add_group(group, x, &mut lanes, &mut magnitudes);
        }
        lanes.iter().sum()
    }

    /// Adds the potentials of a group at a place, and their magnitudes, kT/e.
    #[inline(always)]
    fn add_group(
        &self,
        group: &ChargeGroup,
        x: &Vec3,
        lanes: &mut [f64; LANES],
        magnitudes: &mut [f64; LANES],
    ) {
        // Magnitudes in the same pass: they bound the rounding of the sum.
        for lane in 0..LANES {
            let (dx, dy, dz) = (
                x.x - group.x[lane],
                x.y - group.y[lane],
                x.z - group.z[lane],
            );
            let potential =
                group.charge_e[lane] * self.potential.at_square(dx * dx + dy * dy + dz * dz);
            lanes[lane] += potential;
            magnitudes[lane] += potential.abs();
        }
    }

    vectorised! {
        fused
        /// The energy with the charges of another body at this pose; `None` if one lies beyond the
        /// octree.
        pub fn energy_with[energy_avx512, energy_avx2, energy_sum](
            self: &Self,
            other: &ChargeCloud,
            pose: &RelativePose
        ) -> Option<Interval>
    }

    #[inline(always)]
    fn energy_sum<const FUSED: bool>(
        &self,
        other: &ChargeCloud,
        pose: &RelativePose,
    ) -> Option<Interval> {
        let (mut energy_kt, mut error_kt, mut magnitude_kt) = (0.0, 0.0, 0.0);
        let mut last: Option<&Cell> = None;
        for group in other.groups() {
            for lane in 0..LANES {
                let charge = group.charge_e[lane];
                // Empty lanes: a cell for a charge of zero would be made for nothing.
                if charge == 0.0 {
                    continue;
                }
                let place = Vec3::new(group.x[lane], group.y[lane], group.z[lane]);
                let x = pose.transform_point(&place);
                // Neighbours are in the same cell more often than not.
                let cell = match last {
                    Some(cell) if cell.holds(&x) => cell,
                    _ => self.cell_at(&x)?,
                };
                last = Some(cell);
                let (potential, magnitude) = self.potential_in::<FUSED>(cell, &x);
                energy_kt += charge * potential;
                // Worst case: errors of all charges in the same
                // direction. This is a bound, not an estimate.
                error_kt += charge.abs() * cell.error_kt_per_e;
                magnitude_kt += charge.abs() * (magnitude + potential.abs());
            }
        }
        // Sums over the charges of both bodies, hence both numbers.
        let roundings = ROUNDINGS * (self.charges.len() + other.len()) as f64 * f64::EPSILON;
        Some(Interval {
            energy_kt,
            error_kt: error_kt + roundings * magnitude_kt,
        })
    }

    /// The potential at a place in a cell, and the sum of magnitudes of the charges near it, kT/e.
    #[inline(always)]
    fn potential_in<const FUSED: bool>(&self, cell: &Cell, x: &Vec3) -> (f64, f64) {
        let coordinates = (x - cell.centre) / cell.half_edge_angstrom;
        let (mut lanes, mut magnitudes) = ([0.0; LANES], [0.0; LANES]);
        for group in &cell.near {
            let group = &self.charges.groups()[*group as usize];
            // Near charges by the plain potential, to rounding.
            self.add_group(group, x, &mut lanes, &mut magnitudes);
        }
        let potential =
            value::<FUSED>(&cell.series, coordinates.into()) + lanes.iter().sum::<f64>();
        (potential, magnitudes.iter().sum())
    }
}
