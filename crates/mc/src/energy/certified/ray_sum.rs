//! The inner loop: charges near the cut-off of a point, compared and summed in single precision, sixteen at a time.

use super::Charges;

/// Charges worked on together.
pub(super) const BLOCK: usize = 16;
/// Degree of the polynomial that stands for the kernel near the cut-off.
const KERNEL_DEGREE: usize = 8;
/// Unit roundoff of single precision.
const ROUNDOFF: f64 = 5.97e-8;

/// Up to [`BLOCK`] charges of one body; empty lanes repeat the first charge's place without charge.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Block {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    z: [f32; BLOCK],
    /// |y|², Å².
    square: [f32; BLOCK],
    charge: [f32; BLOCK],
}

impl Block {
    pub fn new(charges: &Charges, members: &[u32]) -> Self {
        let at = |lane: usize| *members.get(lane).unwrap_or(&members[0]) as usize;
        let pick = |values: &[f64]| std::array::from_fn(|lane| values[at(lane)] as f32);
        let square = |i: usize| charges.x[i].powi(2) + charges.y[i].powi(2) + charges.z[i].powi(2);
        Self {
            x: pick(&charges.x),
            y: pick(&charges.y),
            z: pick(&charges.z),
            square: std::array::from_fn(|lane| square(at(lane)) as f32),
            charge: std::array::from_fn(|lane| members.get(lane).map_or(0.0, |i| charges.charge[*i as usize] as f32)),
        }
    }
}

/// λ_B exp(-κ r)/r as a polynomial of m = r_cut² - r², for |r - r_cut| <= `reach`.
#[derive(Debug, Clone)]
pub(super) struct KernelPolynomial {
    pub reach: f64,
    coefficients: [f32; KERNEL_DEGREE + 1],
    /// Bound of |polynomial - kernel|, rounding of its evaluation included, kT/e².
    error: f64,
    /// Bound of the kernel, kT/e².
    largest: f64,
    /// Bound of the kernel's slope in m, kT/(e² Å²).
    steepest: f64,
}

impl KernelPolynomial {
    /// Interpolates at the Chebyshev points. f(t) = exp(-κ√t)/√t is completely monotone, with derivatives
    /// f⁽ⁿ⁾(t) = (-1/2)ⁿ exp(-κr) θ_n(κr)/r^(2n+1), r = √t, θ_n the reverse Bessel polynomials; so the interpolation error
    /// is at most 2 (w/2)^(n+1) |f⁽ⁿ⁺¹⁾(t_min)|/(n+1)! on an interval of half-width w.
    pub fn new(bjerrum: f64, kappa: f64, cutoff: f64, reach: f64) -> Self {
        const N: usize = KERNEL_DEGREE + 1;
        let (low, high) = ((cutoff - reach).powi(2), (cutoff + reach).powi(2));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let kernel = |t: f64| bjerrum * (-kappa * t.sqrt()).exp() / t.sqrt();
        let nodes: [f64; N] =
            std::array::from_fn(|i| middle + half * (std::f64::consts::PI * (i as f64 + 0.5) / N as f64).cos());
        // Newton's divided differences in m, then powers of m.
        let m = nodes.map(|t| cutoff * cutoff - t);
        let mut differences = nodes.map(kernel);
        for order in 1..N {
            for i in (order..N).rev() {
                differences[i] = (differences[i] - differences[i - 1]) / (m[i] - m[i - order]);
            }
        }
        let mut powers = [0.0; N];
        for i in (0..N).rev() {
            for degree in (0..N).rev() {
                powers[degree] = if degree > 0 { powers[degree - 1] } else { 0.0 } - m[i] * powers[degree];
            }
            powers[0] += differences[i];
        }
        let derivative = |order: usize| {
            let r = low.sqrt();
            let x = kappa * r;
            let (mut before, mut theta) = (1.0, if order == 0 { 1.0 } else { x + 1.0 });
            for n in 2..=order {
                (before, theta) = (theta, (2 * n - 1) as f64 * theta + x * x * before);
            }
            bjerrum * (-x).exp() * theta / r.powi(2 * order as i32 + 1) * 0.5f64.powi(order as i32)
        };
        let factorial: f64 = (1..=N).map(|n| n as f64).product();
        let interpolation = 2.0 * (0.5 * half).powi(N as i32) * derivative(N) / factorial;
        let widest = (high - cutoff * cutoff).max(cutoff * cutoff - low);
        let terms: f64 = powers.iter().enumerate().map(|(n, c)| c.abs() * widest.powi(n as i32)).sum();
        Self {
            reach,
            coefficients: powers.map(|c| c as f32),
            error: interpolation + (2 * N + 1) as f64 * ROUNDOFF * terms,
            largest: kernel(low),
            steepest: derivative(1),
        }
    }
}

/// The charges to compare with the cut-off.
pub(super) struct Window<'a> {
    pub blocks: &'a [Block],
    pub cutoff: f64,
    pub kernel: &'a KernelPolynomial,
}

/// λ_B Σ Z_b exp(-κ r_b)/r_b over the window's charges at r_b >= r_cut, and a bound of its error; `magnitude` is Σ |Z_b| over
/// the window. `None` if a charge is so close to the cut-off that single precision cannot tell the side.
#[inline(always)]
pub(super) fn sum_window<const FMA: bool>(
    window: &Window<'_>,
    x: [f64; 3],
    magnitude: f64,
    radius: f64,
) -> Option<(f64, f64)> {
    let square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    let base = window.cutoff * window.cutoff - square;
    // m = base - |y|² + 2 x·y: inputs rounded once, then four sums of numbers no larger than `terms`.
    let terms = base.abs() + radius * radius + 2.0 * square.sqrt() * radius;
    let band = 8.0 * ROUNDOFF * terms;
    let [x2, y2, z2] = x.map(|x| (2.0 * x) as f32);
    let (base, c) = (base as f32, &window.kernel.coefficients);
    let mut total = [0.0f32; BLOCK];
    let mut closest = [f32::INFINITY; BLOCK];
    // One operation on all lanes at a time: this is the form that compilers turn into vector instructions.
    for block in window.blocks {
        let mut m: [f32; BLOCK] = std::array::from_fn(|l| base - block.square[l]);
        m = std::array::from_fn(|l| fma::<FMA>(x2, block.x[l], m[l]));
        m = std::array::from_fn(|l| fma::<FMA>(y2, block.y[l], m[l]));
        m = std::array::from_fn(|l| fma::<FMA>(z2, block.z[l], m[l]));
        let mut kernel = [c[KERNEL_DEGREE]; BLOCK];
        for i in (0..KERNEL_DEGREE).rev() {
            kernel = std::array::from_fn(|l| fma::<FMA>(kernel[l], m[l], c[i]));
        }
        let charge: [f32; BLOCK] = std::array::from_fn(|l| if m[l] <= 0.0 { block.charge[l] } else { 0.0 });
        total = std::array::from_fn(|l| fma::<FMA>(charge[l], kernel[l], total[l]));
        let size: [f32; BLOCK] = std::array::from_fn(|l| m[l].abs());
        closest = std::array::from_fn(|l| if size[l] < closest[l] { size[l] } else { closest[l] });
    }
    if closest.iter().fold(f32::INFINITY, |a, b| if a < *b { a } else { *b }) <= band as f32 {
        return None;
    }
    let value: f64 = total.iter().map(|t| f64::from(*t)).sum();
    let kernel = window.kernel;
    let summing = (window.blocks.len() + 3) as f64 * ROUNDOFF * 1.01 * kernel.largest;
    Some((value, magnitude * (kernel.error + kernel.steepest * band + summing)))
}

#[inline(always)]
fn fma<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}
