//! What the cut-off takes away: λ_B Σ_b Z_b exp(-κ r_b)/r_b over the charges of one body at r_b >= r_cut.
//!
//! Seen from a point x in the direction m of the body's centre, x = s m + p with p perpendicular to m and short, the
//! sphere of radius r_cut about x sweeps over the charges in an order that hardly depends on x: a charge at y is beyond the
//! cut-off exactly when
//!
//! τ_b <= s + σ_b(p),  τ_b = y·m + √(r_cut² - y⊥²),  σ_b(p) = √(r_cut² - y⊥²) - √(r_cut² - |y⊥ - p|²),
//!
//! and |σ_b| is about |p| y⊥/r_cut, a fraction of |p|. So for a set of directions ("rays") the charges are sorted by τ_b.
//! All charges before the window of |σ_b| about s are beyond the cut-off and enter through one polynomial of (s, p) that
//! belongs to the ray and the place in its order; all charges behind it are within; the few in the window are compared
//! with the cut-off one by one.

use super::Charges;
use super::polynomial::{Chebyshev, Monomials, YukawaTaylor, count, fill_monomials, taylor_remainder};
use super::ray_sum::{BLOCK, Block, KernelPolynomial, Window, sum_window};
use protomer_kernel::Vec3;

/// Degree of the Taylor polynomials from which those of the prefixes are made.
const TAYLOR_DEGREE: usize = 10;
/// Degree of the polynomial of a prefix.
const PREFIX_DEGREE: usize = 4;
const COEFFICIENTS: usize = count(PREFIX_DEGREE);
/// A block of charges spans at most this much in τ, Å.
const LONGEST_BLOCK: f64 = 0.6;
/// Width of the bins in which the first block of a window is looked up, Å.
const BIN: f64 = 0.125;
/// Prefixes whose references lie within this share the Taylor polynomial that is built up, Å.
const SHARED_REFERENCE: f64 = 2.0;
/// An empty place in a block.
const NOBODY: u16 = u16::MAX;
/// Added to every window against rounding, Å.
const MARGIN: f64 = 1e-5;

/// The rays of one body.
#[derive(Debug, Clone)]
pub(super) struct CutTail {
    charges: Charges,
    bjerrum: f64,
    kappa: f64,
    cutoff: f64,
    radius: f64,
    rays_per_edge: usize,
    rays: Vec<Ray>,
    kernels: Vec<KernelPolynomial>,
}

#[derive(Debug, Clone)]
struct Ray {
    axes: [Vec3; 3],
    /// Sine of the largest angle between the ray and a point that belongs to it.
    sine: f64,
    /// Largest distance of a charge from the ray's line, Å.
    off_axis: f64,
    blocks: Vec<Block>,
    /// The charges of each block.
    members: Vec<[u16; BLOCK]>,
    /// For each bin of τ: the number of blocks that end before it, and of those that start before its end.
    bins: Vec<[u32; 2]>,
    first_bin: f64,
    /// For every number of whole blocks: the polynomial of the charges in them.
    prefixes: Vec<Prefix>,
    /// Σ |Z_b| over the blocks before each, e.
    absolute: Vec<f64>,
}

/// The potential of the charges before a place in the order, in the coordinates (s, p_1, p_2) of the ray.
#[derive(Debug, Clone)]
struct Prefix {
    coefficients: [f32; COEFFICIENTS],
    centre: f64,
    inverse_half: [f64; 2],
    error: f64,
}

/// The tail at one point, per unit charge.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tail {
    pub value: f64,
    pub error: f64,
}

impl CutTail {
    /// The tail of these charges (given about the centre of their box), or `None` if the cut-off is not larger than the
    /// body by the factor that the sweep needs.
    pub fn new(charges: &Charges, bjerrum: f64, kappa: f64, cutoff: f64, rays_per_edge: usize) -> Option<Self> {
        let radius = charges.radius();
        let mut tail = Self {
            charges: charges.clone(),
            bjerrum,
            kappa,
            cutoff,
            radius,
            rays_per_edge,
            rays: Vec::new(),
            kernels: Vec::new(),
        };
        let cells: Vec<(Vec3, f64)> =
            (0..6 * rays_per_edge * rays_per_edge).map(|i| ray_cell(i, rays_per_edge)).collect();
        let largest_offset = cells.iter().map(|cell| cell.1).fold(0.0, f64::max) * (cutoff + radius);
        if charges.len() >= usize::from(NOBODY) {
            return None;
        }
        // A charge beside or behind x, seen along the ray, must always be within.
        if !(cutoff.is_finite() && std::f64::consts::SQRT_2 * (radius + largest_offset) < cutoff) {
            return None;
        }
        let widest = tail.window_bounds(radius, largest_offset);
        let reach = widest[1] - widest[0] + LONGEST_BLOCK + 2.0 * BIN;
        tail.kernels = [0.2, 0.35, 0.6, 1.0]
            .map(|fraction| KernelPolynomial::new(bjerrum, kappa, cutoff, fraction * reach))
            .to_vec();
        let monomials = Monomials::new(TAYLOR_DEGREE);
        let chebyshev = Chebyshev::new(TAYLOR_DEGREE);
        let mut taylor = YukawaTaylor::new(kappa, &monomials);
        for (direction, sine) in cells {
            let ray = tail.build_ray(direction, sine, &monomials, &chebyshev, &mut taylor);
            tail.rays.push(ray);
        }
        Some(tail)
    }

    pub fn memory_bytes(&self) -> usize {
        self.rays
            .iter()
            .map(|ray| {
                size_of_val(&ray.blocks[..])
                    + size_of_val(&ray.members[..])
                    + size_of_val(&ray.bins[..])
                    + size_of_val(&ray.prefixes[..])
                    + size_of_val(&ray.absolute[..])
            })
            .sum()
    }

    /// The least and the largest σ over charges at most `off_axis` from the ray, for |p| = `offset`.
    #[inline(always)]
    fn window_bounds(&self, off_axis: f64, offset: f64) -> [f64; 2] {
        let square = self.cutoff * self.cutoff;
        let short = 2.0 * (square - (off_axis + offset) * (off_axis + offset)).sqrt();
        let (least, most) = (offset * (offset - 2.0 * off_axis), offset * (offset + 2.0 * off_axis));
        // The least is negative, or positive over the longest denominator.
        [(least / short).min(least / (2.0 * self.cutoff)) - MARGIN, most / short + MARGIN]
    }

    /// Between what bounds the least σ lies for offsets up to this one.
    fn least_range(&self, off_axis: f64, offset: f64) -> [f64; 2] {
        let short = 2.0 * (self.cutoff * self.cutoff - (off_axis + offset) * (off_axis + offset)).sqrt();
        let turning = off_axis.min(offset);
        let (low, high) = (turning * (turning - 2.0 * off_axis), offset * (offset - 2.0 * off_axis));
        [low / short - 2.0 * MARGIN, high.max(0.0) / short + 2.0 * MARGIN]
    }

    fn build_ray(
        &self,
        m: Vec3,
        sine: f64,
        monomials: &Monomials,
        chebyshev: &Chebyshev,
        taylor: &mut YukawaTaylor,
    ) -> Ray {
        let helper = if m.x.abs() < 0.7 { Vec3::x() } else { Vec3::y() };
        let e1 = m.cross(&helper).normalize();
        let axes = [m, e1, m.cross(&e1)];
        let c = &self.charges;
        let in_ray: Vec<[f64; 3]> = (0..c.len())
            .map(|i| {
                let y = Vec3::new(c.x[i], c.y[i], c.z[i]);
                [y.dot(&axes[0]), y.dot(&axes[1]), y.dot(&axes[2])]
            })
            .collect();
        let key = |y: &[f64; 3]| y[0] + (self.cutoff * self.cutoff - y[1] * y[1] - y[2] * y[2]).sqrt();
        let off_axis = in_ray.iter().map(|y| y[1].hypot(y[2])).fold(0.0, f64::max);
        let mut order: Vec<u32> = (0..c.len() as u32).collect();
        order.sort_by(|a, b| key(&in_ray[*a as usize]).total_cmp(&key(&in_ray[*b as usize])));
        let mut ray = Ray {
            axes,
            sine,
            off_axis,
            blocks: Vec::new(),
            members: Vec::new(),
            bins: Vec::new(),
            first_bin: 0.0,
            prefixes: Vec::new(),
            absolute: vec![0.0],
        };
        let keys: Vec<f64> = order.iter().map(|i| key(&in_ray[*i as usize])).collect();
        let (mut starts, mut ends, mut at) = (Vec::new(), Vec::new(), 0);
        while at < order.len() {
            let length = keys[at..].iter().take(BLOCK).take_while(|key| **key <= keys[at] + LONGEST_BLOCK).count();
            let members = &order[at..at + length];
            ray.blocks.push(Block::new(c, members));
            let sum: f64 = members.iter().map(|i| c.charge[*i as usize].abs()).sum();
            ray.absolute.push(ray.absolute[ray.absolute.len() - 1] + sum);
            ray.members.push(std::array::from_fn(|l| members.get(l).map_or(NOBODY, |i| *i as u16)));
            starts.push(keys[at]);
            ends.push(keys[at + length - 1]);
            at += length;
        }
        ray.fill_bins(&starts, &ends);
        self.build_prefixes(&mut ray, &ends, &in_ray, monomials, chebyshev, taylor);
        ray
    }

    fn build_prefixes(
        &self,
        ray: &mut Ray,
        ends: &[f64],
        in_ray: &[[f64; 3]],
        monomials: &Monomials,
        chebyshev: &Chebyshev,
        taylor: &mut YukawaTaylor,
    ) {
        let beyond = self.cutoff + self.radius;
        let mut sum: Vec<f64> = Vec::new();
        let (mut reference, mut summed) = (f64::NEG_INFINITY, 0);
        let offset = beyond * ray.sine;
        let [least, most] = self.least_range(ray.off_axis, offset);
        ray.prefixes.push(Prefix::nothing());
        for blocks in 1..=ray.blocks.len() {
            // A point uses this prefix when s + least σ lies between the ends of the last block in it and of the next.
            let low = ends[blocks - 1] - most;
            let high = ends.get(blocks).map_or(f64::INFINITY, |end| end - least + BIN).min(beyond).max(low + BIN);
            let centre = 0.5 * (low + high);
            let offset = high * ray.sine / (1.0 - ray.sine * ray.sine).sqrt();
            let half = [0.5 * (high - low) + 1e-6, offset];
            if (centre - reference).abs() > SHARED_REFERENCE || sum.is_empty() {
                (reference, summed) = (centre, 0);
                sum = vec![0.0; monomials.len()];
            }
            let (mut displacements, mut weights) = (Vec::new(), Vec::new());
            for member in ray.members[summed..blocks].iter().flatten().filter(|i| **i != NOBODY) {
                let y = in_ray[*member as usize];
                displacements.push([reference - y[0], -y[1], -y[2]]);
                weights.push(self.bjerrum * self.charges.charge[*member as usize]);
            }
            taylor.add(monomials, &displacements, &weights, &mut sum);
            summed = blocks;
            // The farthest point of the domain from the reference, and the nearest charge in the prefix to it: one of
            // τ at most that of the last block's end, and r changes no faster than s.
            let far = (half[0] + (centre - reference).abs()).hypot(offset);
            let nearest = self.cutoff - (ends[blocks - 1] - reference).max(0.0);
            let remainder = taylor_remainder(self.kappa, nearest, far, TAYLOR_DEGREE);
            let mut polynomial = sum.clone();
            monomials.shift(&mut polynomial, [centre - reference, 0.0, 0.0]);
            monomials.scale(&mut polynomial, [half[0], half[1], half[1]]);
            let magnitude =
                ray.absolute[blocks] * self.bjerrum * (-self.kappa * (nearest - far)).exp() / (nearest - far);
            let dropped = monomials.economise(&mut polynomial, PREFIX_DEGREE, chebyshev);
            let error = dropped + ray.absolute[blocks] * self.bjerrum * remainder + 1e-13 * magnitude;
            let rounding = 8.0 * f64::from(f32::EPSILON) * polynomial.iter().map(|c| c.abs()).sum::<f64>();
            ray.prefixes.push(Prefix {
                coefficients: std::array::from_fn(|i| polynomial[i] as f32),
                centre,
                inverse_half: [1.0 / half[0], 1.0 / half[1]],
                error: error + rounding,
            });
        }
    }

    /// The tail at a point (about the centre of the charges' box). `distance` is its distance from the origin, Å.
    #[inline(always)]
    pub fn at<const FMA: bool>(&self, x: [f64; 3], distance: f64, exact: bool) -> Tail {
        if distance + self.radius < self.cutoff {
            return Tail::default();
        }
        let ray = &self.rays[self.nearest_ray(x)];
        let along = |axis: usize| x[0] * ray.axes[axis].x + x[1] * ray.axes[axis].y + x[2] * ray.axes[axis].z;
        let (s, p1, p2) = (along(0), along(1), along(2));
        let offset = (p1 * p1 + p2 * p2).sqrt();
        let [least, most] = self.window_bounds(ray.off_axis, offset);
        let first = ray.bin(s + least)[0] as usize;
        let last = ray.bin(s + most)[1] as usize;
        let mut tail = ray.prefixes[first].value(s, p1, p2);
        if first < last {
            let kernel = self.kernel(most - least);
            let window = Window { blocks: &ray.blocks[first..last], cutoff: self.cutoff, kernel };
            let magnitude = ray.absolute[last] - ray.absolute[first];
            match if exact { None } else { sum_window::<FMA>(&window, x, magnitude, self.radius) } {
                Some((value, error)) => {
                    tail.value += value;
                    tail.error += error;
                }
                None => {
                    let members = ray.members[first..last].iter().flatten();
                    let sum = self.sum_exactly(members.copied().filter(|i| *i != NOBODY), x);
                    tail.value += sum.value;
                    tail.error += sum.error;
                }
            }
        }
        tail
    }

    /// The cheapest polynomial of the kernel that is good in a window of this width.
    #[inline(always)]
    fn kernel(&self, width: f64) -> &KernelPolynomial {
        let reach = width + LONGEST_BLOCK + 2.0 * BIN;
        let last = self.kernels.len() - 1;
        &self.kernels[(0..last).find(|i| reach <= self.kernels[*i].reach).unwrap_or(last)]
    }

    /// The same sum in double precision; charges within rounding of the cut-off count as error.
    fn sum_exactly(&self, members: impl Iterator<Item = u16>, x: [f64; 3]) -> Tail {
        let mut tail = Tail::default();
        let mut magnitude = 0.0;
        for i in members {
            let i = i as usize;
            let (dx, dy, dz) = (x[0] - self.charges.x[i], x[1] - self.charges.y[i], x[2] - self.charges.z[i]);
            let r = (dx * dx + dy * dy + dz * dz).sqrt();
            let term = self.bjerrum * self.charges.charge[i] * (-self.kappa * r).exp() / r;
            if (r - self.cutoff).abs() < 1e-9 {
                tail.error += term.abs();
            }
            if r >= self.cutoff {
                tail.value += term;
                magnitude += term.abs();
            }
        }
        tail.error += 1e-13 * magnitude;
        tail
    }

    #[inline(always)]
    fn nearest_ray(&self, x: [f64; 3]) -> usize {
        let a = x.map(f64::abs);
        let axis = if a[0] >= a[1] && a[0] >= a[2] {
            0
        } else if a[1] >= a[2] {
            1
        } else {
            2
        };
        let (u, v) = (x[(axis + 1) % 3] / a[axis], x[(axis + 2) % 3] / a[axis]);
        let n = self.rays_per_edge;
        let place = |t: f64| (((spread(t) + 1.0) * 0.5 * n as f64) as usize).min(n - 1);
        ((2 * axis + usize::from(x[axis] < 0.0)) * n + place(u)) * n + place(v)
    }
}

impl Ray {
    fn fill_bins(&mut self, starts: &[f64], ends: &[f64]) {
        let (Some(first), Some(last)) = (starts.first(), ends.last()) else { return };
        self.first_bin = first - BIN;
        let count = ((last - self.first_bin) / BIN) as usize + 2;
        let edge = |bin: usize| self.first_bin + BIN * bin as f64;
        self.bins = (0..count)
            .map(|bin| {
                let ended = ends.partition_point(|end| *end < edge(bin) - MARGIN);
                let started = starts.partition_point(|start| *start < edge(bin + 1) + MARGIN);
                [ended as u32, started as u32]
            })
            .collect();
    }

    /// The blocks certainly before this τ, and those possibly not behind it.
    #[inline(always)]
    fn bin(&self, tau: f64) -> [u32; 2] {
        let bin = (tau - self.first_bin) * (1.0 / BIN);
        if bin < 0.0 { [0, 0] } else { self.bins.get(bin as usize).copied().unwrap_or([self.blocks.len() as u32; 2]) }
    }
}

impl Prefix {
    fn nothing() -> Self {
        Self { coefficients: [0.0; COEFFICIENTS], centre: 0.0, inverse_half: [0.0; 2], error: 0.0 }
    }

    #[inline(always)]
    fn value(&self, s: f64, p1: f64, p2: f64) -> Tail {
        let [u, v, w] =
            [(s - self.centre) * self.inverse_half[0], p1 * self.inverse_half[1], p2 * self.inverse_half[1]];
        debug_assert!(self.error == 0.0 || (u.abs() <= 1.0 && v.abs() <= 1.0 && w.abs() <= 1.0), "{u} {v} {w}");
        let mut values = [1.0f32; COEFFICIENTS];
        fill_monomials::<f32, PREFIX_DEGREE, COEFFICIENTS>([u as f32, v as f32, w as f32], &mut values);
        let value: f32 = dot(&self.coefficients, &values);
        let value = f64::from(value);
        Tail { value, error: self.error }
    }
}

/// Spreads [-1, 1] so that equal steps are nearly equal angles on a cube's face seen from its centre.
#[inline(always)]
fn spread(t: f64) -> f64 {
    t * (1.2 - 0.2 * t * t)
}

/// The middle of a cell of a cube's faces as a direction, and the sine of the largest angle to it within the cell: that of
/// a corner, as the cell is a convex spherical polygon.
fn ray_cell(index: usize, edge: usize) -> (Vec3, f64) {
    let (face, row, column) = (index / (edge * edge), index / edge % edge, index % edge);
    let axis = face / 2;
    let direction = |row: f64, column: f64| {
        let mut d = Vec3::zeros();
        d[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
        d[(axis + 1) % 3] = unspread(2.0 * row / edge as f64 - 1.0);
        d[(axis + 2) % 3] = unspread(2.0 * column / edge as f64 - 1.0);
        d.normalize()
    };
    let (row, column) = (row as f64, column as f64);
    let middle = direction(row + 0.5, column + 0.5);
    let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(i, j)| direction(row + i, column + j));
    let sine = corners.iter().map(|corner| corner.cross(&middle).norm()).fold(0.0, f64::max);
    (middle, sine + 1e-9)
}

/// The inverse of [`spread`], by bisection.
fn unspread(target: f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..60 {
        let t = 0.5 * (low + high);
        if spread(t) < target { low = t } else { high = t }
    }
    0.5 * (low + high)
}

#[inline(always)]
fn dot(a: &[f32; COEFFICIENTS], b: &[f32; COEFFICIENTS]) -> f32 {
    let mut lanes = [0.0f32; 7];
    for row in 0..COEFFICIENTS / 7 {
        for l in 0..7 {
            lanes[l] += a[7 * row + l] * b[7 * row + l];
        }
    }
    lanes.iter().sum()
}
