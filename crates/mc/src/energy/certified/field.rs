//! The screened potential of one body's charges in the space around it, in cells with one polynomial each.

use super::Charges;
use super::polynomial::{Chebyshev, Monomials, YukawaTaylor, count, fill_monomials, taylor_remainder};
use protomer_kernel::Vec3;

/// Degree of the Taylor polynomials from which the cells' polynomials are made.
const TAYLOR_DEGREE: usize = 10;
/// Degree of the polynomial of a cell.
const CELL_DEGREE: usize = 5;
/// Coefficients per cell.
const COEFFICIENTS: usize = count(CELL_DEGREE);
/// A smallest cell with this many charges within [`DEEP_DISTANCE`] (Å) lies inside the body, where hardly a charge of
/// another body comes: it gets no polynomial, and a charge that does come is summed with all.
const DEEP_COUNT: usize = 8;
const DEEP_DISTANCE: f64 = 3.0;
const NO_CHILD: u32 = 0;
const NO_POLYNOMIAL: u32 = u32::MAX;

/// λ_B Σ_b Z_b exp(-κ r_b)/r_b without cut-off, in an octree about the body. Every cell holds a polynomial for the far
/// charges and a list of the near ones, which are summed one by one.
#[derive(Debug, Clone)]
pub(super) struct ScreenedField {
    charges: Charges,
    bjerrum: f64,
    kappa: f64,
    half_width: f64,
    cells: Vec<Cell>,
    coefficients: Vec<f64>,
    near: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    /// The first of eight children that follow each other, or [`NO_CHILD`].
    children: u32,
    /// Which polynomial, or [`NO_POLYNOMIAL`].
    polynomial: u32,
    near_start: u32,
    near_count: u32,
    /// Bound of the polynomial's error anywhere in the cell, kT/e.
    error: f64,
    /// Bound of λ_B Σ |Z_b| exp(-κ r_b)/r_b over the far charges, kT/e.
    absolute: f64,
}

/// A value with what is known about it, per unit charge.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Potential {
    /// kT/e.
    pub value: f64,
    /// The true value is within this of `value`, rounding aside, kT/e.
    pub error: f64,
    /// Bound of the sum of the terms' magnitudes, kT/e: what rounding errors are proportional to.
    pub absolute: f64,
}

struct Builder<'a> {
    field: &'a mut ScreenedField,
    monomials: Monomials,
    chebyshev: Chebyshev,
    taylor: YukawaTaylor,
    smallest_edge: f64,
    /// A cell is divided while its bound is above this, kT/e.
    error_target: f64,
    /// The Taylor remainders of the charges that one level of cells takes into its polynomials may add up to this, kT/e.
    remainder_target: f64,
    /// Distance from the body's centre beyond which no potential is asked for.
    reach: f64,
}

/// What a cell hands down to its children.
struct Inherited {
    centre: Vec3,
    half: f64,
    taylor: Vec<f64>,
    near: Vec<u32>,
    error: f64,
    absolute: f64,
}

impl ScreenedField {
    /// The field of `charges` within `reach` of the origin, with an error below `error_target` (kT/e) where cells of edge
    /// `smallest_edge` (Å) suffice for it.
    pub fn new(charges: &Charges, bjerrum: f64, kappa: f64, reach: f64, smallest_edge: f64, error_target: f64) -> Self {
        let mut half_width = 0.5 * smallest_edge;
        while half_width < reach {
            half_width *= 2.0;
        }
        let mut field = Self {
            charges: charges.clone(),
            bjerrum,
            kappa,
            half_width,
            cells: vec![Cell::empty()],
            coefficients: Vec::new(),
            near: Vec::new(),
        };
        let monomials = Monomials::new(TAYLOR_DEGREE);
        let root = Inherited {
            centre: Vec3::zeros(),
            half: half_width,
            taylor: vec![0.0; monomials.len()],
            near: (0..charges.len() as u32).collect(),
            error: 0.0,
            absolute: 0.0,
        };
        let taylor = YukawaTaylor::new(kappa, &monomials);
        let chebyshev = Chebyshev::new(TAYLOR_DEGREE);
        let remainder_target = 0.2 * error_target;
        Builder {
            field: &mut field,
            monomials,
            chebyshev,
            taylor,
            smallest_edge,
            error_target,
            remainder_target,
            reach,
        }
        .build(0, root);
        field
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.coefficients[..]) + size_of_val(&self.near[..])
    }

    /// The potential at a point.
    #[inline(always)]
    pub fn potential(&self, x: f64, y: f64, z: f64) -> Potential {
        let mut half = self.half_width;
        if !(x.abs() < half && y.abs() < half && z.abs() < half) {
            return self.sum(0..self.charges.len(), x, y, z);
        }
        let (mut u, mut v, mut w) = (x, y, z);
        let mut cell = &self.cells[0];
        while cell.children != NO_CHILD {
            half *= 0.5;
            let octant = usize::from(u >= 0.0) + 2 * usize::from(v >= 0.0) + 4 * usize::from(w >= 0.0);
            u -= half.copysign(u_sign(u));
            v -= half.copysign(u_sign(v));
            w -= half.copysign(u_sign(w));
            cell = &self.cells[cell.children as usize + octant];
        }
        if cell.polynomial == NO_POLYNOMIAL {
            return self.sum(0..self.charges.len(), x, y, z);
        }
        let start = cell.polynomial as usize * COEFFICIENTS;
        let inverse = 1.0 / half;
        let value = evaluate(&self.coefficients[start..start + COEFFICIENTS], [u * inverse, v * inverse, w * inverse]);
        let mut potential = Potential { value, error: cell.error, absolute: cell.absolute };
        if cell.near_count > 0 {
            let near = &self.near[cell.near_start as usize..(cell.near_start + cell.near_count) as usize];
            let close = self.sum(near.iter().map(|index| *index as usize), x, y, z);
            potential.value += close.value;
            potential.absolute += close.absolute;
        }
        potential
    }

    /// The plain sum over some of the charges.
    fn sum(&self, indices: impl Iterator<Item = usize>, x: f64, y: f64, z: f64) -> Potential {
        let (mut value, mut absolute) = (0.0, 0.0);
        for i in indices {
            let (dx, dy, dz) = (x - self.charges.x[i], y - self.charges.y[i], z - self.charges.z[i]);
            let r = (dx * dx + dy * dy + dz * dz).sqrt();
            let term = self.bjerrum * self.charges.charge[i] * (-self.kappa * r).exp() / r;
            value += term;
            absolute += term.abs();
        }
        Potential { value, error: 0.0, absolute }
    }
}

#[inline(always)]
fn u_sign(u: f64) -> f64 {
    if u >= 0.0 { 1.0 } else { -1.0 }
}

impl Cell {
    fn empty() -> Self {
        Self { children: NO_CHILD, polynomial: NO_POLYNOMIAL, near_start: 0, near_count: 0, error: 0.0, absolute: 0.0 }
    }
}

impl Builder<'_> {
    fn build(&mut self, index: usize, mut cell: Inherited) {
        let radius = 3f64.sqrt() * cell.half;
        if cell.centre.norm() - radius > self.reach {
            return;
        }
        let smallest = 2.0 * cell.half <= self.smallest_edge * 1.001;
        let charges = &self.field.charges;
        let at = |i: u32| Vec3::new(charges.x[i as usize], charges.y[i as usize], charges.z[i as usize]);
        let (bjerrum, kappa) = (self.field.bjerrum, self.field.kappa);
        let mut ordered: Vec<(u32, Vec3, f64)> =
            cell.near.iter().map(|i| (*i, cell.centre - at(*i), (cell.centre - at(*i)).norm())).collect();
        ordered.sort_by(|a, b| b.2.total_cmp(&a.2));
        if smallest && ordered.iter().filter(|charge| charge.2 < DEEP_DISTANCE).count() >= DEEP_COUNT {
            return;
        }
        // Far charges first, as long as their remainders leave this level's share of the error.
        let mut far: Vec<(Vec3, f64)> = Vec::new();
        let mut near: Vec<u32> = Vec::new();
        let mut spent = 0.0;
        for (i, displacement, distance) in ordered {
            let weight = bjerrum * charges.charge[i as usize];
            if near.is_empty() && distance > 1.5 * radius {
                spent += weight.abs() * taylor_remainder(kappa, distance, radius, TAYLOR_DEGREE);
            } else {
                spent = f64::INFINITY;
            }
            if spent <= self.remainder_target {
                cell.absolute += weight.abs() * (-kappa * (distance - radius)).exp() / (distance - radius);
                far.push((displacement, weight));
            } else {
                near.push(i);
            }
        }
        cell.error +=
            far.iter().map(|(d, w)| w.abs() * taylor_remainder(kappa, d.norm(), radius, TAYLOR_DEGREE)).sum::<f64>();
        let displacements: Vec<[f64; 3]> = far.iter().map(|charge| charge.0.into()).collect();
        let weights: Vec<f64> = far.iter().map(|charge| charge.1).collect();
        self.taylor.add(&self.monomials, &displacements, &weights, &mut cell.taylor);
        cell.near = near;
        let mut polynomial = cell.taylor.clone();
        self.monomials.scale(&mut polynomial, [cell.half; 3]);
        let dropped = self.monomials.economise(&mut polynomial, CELL_DEGREE, &self.chebyshev);
        let good = cell.near.is_empty() && cell.error + dropped <= self.error_target;
        if good || smallest {
            let field = &mut *self.field;
            field.cells[index] = Cell {
                children: NO_CHILD,
                polynomial: (field.coefficients.len() / COEFFICIENTS) as u32,
                near_start: field.near.len() as u32,
                near_count: cell.near.len() as u32,
                // Rounding of the coefficients and of their sum.
                error: cell.error + dropped + 1e-13 * cell.absolute,
                absolute: cell.absolute,
            };
            field.coefficients.extend_from_slice(&polynomial);
            field.near.extend_from_slice(&cell.near);
        } else {
            self.divide(index, &cell);
        }
    }

    fn divide(&mut self, index: usize, cell: &Inherited) {
        let first = self.field.cells.len();
        self.field.cells[index].children = first as u32;
        self.field.cells.extend([Cell::empty(); 8]);
        let half = 0.5 * cell.half;
        for octant in 0..8 {
            let step = |bit: usize| if octant >> bit & 1 == 1 { half } else { -half };
            let shift = [step(0), step(1), step(2)];
            let mut taylor = cell.taylor.clone();
            self.monomials.shift(&mut taylor, shift);
            let child = Inherited {
                centre: cell.centre + Vec3::from(shift),
                half,
                taylor,
                near: cell.near.clone(),
                error: cell.error,
                absolute: cell.absolute,
            };
            self.build(first + octant, child);
        }
    }
}

#[inline(always)]
fn evaluate(coefficients: &[f64], point: [f64; 3]) -> f64 {
    let mut values = [1.0; COEFFICIENTS];
    fill_monomials::<f64, CELL_DEGREE, COEFFICIENTS>(point, &mut values);
    let mut lanes = [0.0; 8];
    for row in 0..COEFFICIENTS / 8 {
        for l in 0..8 {
            lanes[l] += coefficients[8 * row + l] * values[8 * row + l];
        }
    }
    lanes.iter().sum()
}
