//! Polynomials of three variables up to a total degree, and the Taylor polynomials of the screened Coulomb potential.

use crate::charges::LANES;

/// The monomials x^i y^j z^k with i + j + k <= degree, ordered by total degree, so that a lower degree is a prefix.
#[derive(Debug, Clone)]
pub(super) struct Monomials {
    degree: usize,
    exponents: Vec<[usize; 3]>,
    /// For each monomial and axis: the monomial with that exponent one lower, and two lower; `len()` where there is none.
    lower: Vec<[[usize; 3]; 2]>,
    /// For each monomial but the first: a monomial of one degree less and the axis that leads from it to this one.
    parent: Vec<(usize, usize)>,
}

impl Monomials {
    pub fn new(degree: usize) -> Self {
        let mut exponents = Vec::with_capacity(count(degree));
        for total in 0..=degree {
            for i in (0..=total).rev() {
                for j in (0..=total - i).rev() {
                    exponents.push([i, j, total - i - j]);
                }
            }
        }
        let none = exponents.len();
        let less = |e: &[usize; 3], axis: usize, by: usize| {
            let mut lower = *e;
            match lower[axis].checked_sub(by) {
                None => none,
                Some(exponent) => {
                    lower[axis] = exponent;
                    index(lower)
                }
            }
        };
        let lower: Vec<[[usize; 3]; 2]> =
            exponents.iter().map(|e| [1, 2].map(|by| std::array::from_fn(|axis| less(e, axis, by)))).collect();
        let parent = lower
            .iter()
            .map(|l| (0..3).find(|axis| l[0][*axis] != none).map_or((none, 0), |axis| (l[0][axis], axis)))
            .collect();
        Self { degree, exponents, lower, parent }
    }

    pub fn len(&self) -> usize {
        self.exponents.len()
    }

    /// Writes the value of every monomial at a point.
    #[cfg(test)]
    pub fn values(&self, point: [f64; 3], values: &mut [f64]) {
        values[0] = 1.0;
        for (i, (parent, axis)) in self.parent.iter().enumerate().skip(1) {
            values[i] = values[*parent] * point[*axis];
        }
    }

    /// The polynomial as a function of the offset from a point `shift` away from its present origin.
    pub fn shift(&self, coefficients: &mut [f64], shift: [f64; 3]) {
        for (axis, step) in shift.into_iter().enumerate() {
            // Horner's scheme in this variable: repeated synthetic division.
            for round in 0..self.degree {
                for i in (0..self.len()).rev() {
                    let lower = self.lower[i][0][axis];
                    if lower < self.len() && self.exponents[i][axis] > round {
                        coefficients[lower] += step * coefficients[i];
                    }
                }
            }
        }
    }

    /// Multiplies each variable by a scale: the coefficients of p(scale · u) as a polynomial of u.
    pub fn scale(&self, coefficients: &mut [f64], scale: [f64; 3]) {
        let mut powers = vec![1.0; self.len()];
        for (i, (parent, axis)) in self.parent.iter().enumerate().skip(1) {
            powers[i] = powers[*parent] * scale[*axis];
            coefficients[i] *= powers[i];
        }
    }

    /// Economisation: rewrites the polynomial of u in products of Chebyshev polynomials, drops those of total degree
    /// above `kept`, and goes back to powers of u. As |T_n| <= 1, dropping changes the value on the cube |u_i| <= 1 by at
    /// most the sum of the dropped coefficients' magnitudes, which is returned.
    pub fn economise(&self, coefficients: &mut Vec<f64>, kept: usize, chebyshev: &Chebyshev) -> f64 {
        for axis in 0..3 {
            self.transform(coefficients, axis, &chebyshev.from_powers);
        }
        let keep = count(kept);
        let dropped = coefficients.drain(keep..).map(f64::abs).sum();
        coefficients.resize(self.len(), 0.0);
        for axis in 0..3 {
            self.transform(coefficients, axis, &chebyshev.to_powers);
        }
        coefficients.truncate(keep);
        dropped
    }

    /// Replaces the basis functions of one variable: x^n becomes the sum over m <= n of `matrix[n][m]` times the new m.
    fn transform(&self, coefficients: &mut [f64], axis: usize, matrix: &[Vec<f64>]) {
        for i in 0..self.len() {
            // In ascending order every lower entry has been rewritten already and only collects further terms.
            let n = self.exponents[i][axis];
            let value = coefficients[i];
            if value == 0.0 || n == 0 {
                continue;
            }
            let mut target = i;
            coefficients[i] = value * matrix[n][n];
            for m in (0..n).rev() {
                target = self.lower[target][0][axis];
                coefficients[target] += value * matrix[n][m];
            }
        }
    }
}

/// Writes the value of every monomial of degree up to `DEGREE` (at most 5) at a point; the first value must be one.
#[inline(always)]
pub(super) fn fill_monomials<T: Copy + std::ops::Mul<Output = T>, const DEGREE: usize, const N: usize>(
    point: [T; 3],
    values: &mut [T; N],
) {
    // Written out so that every length is known when the code is compiled.
    if DEGREE >= 1 {
        next_degree::<T, 1, N>(point, values);
    }
    if DEGREE >= 2 {
        next_degree::<T, 2, N>(point, values);
    }
    if DEGREE >= 3 {
        next_degree::<T, 3, N>(point, values);
    }
    if DEGREE >= 4 {
        next_degree::<T, 4, N>(point, values);
    }
    if DEGREE >= 5 {
        next_degree::<T, 5, N>(point, values);
    }
}

/// The monomials of one degree are x times those of the degree below, then y times those of them without x, then z times
/// the power of z.
#[inline(always)]
fn next_degree<T: Copy + std::ops::Mul<Output = T>, const DEGREE: usize, const N: usize>(
    [x, y, z]: [T; 3],
    values: &mut [T; N],
) {
    let (length, next) = (DEGREE * (DEGREE + 1) / 2, count(DEGREE - 1));
    for i in 0..length {
        values[next + i] = values[next - length + i] * x;
    }
    for i in 0..DEGREE {
        values[next + length + i] = values[next - DEGREE + i] * y;
    }
    values[next + length + DEGREE] = values[next - 1] * z;
}

/// Number of monomials of three variables up to this total degree.
pub(super) const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) * (degree + 3) / 6
}

fn index([i, j, k]: [usize; 3]) -> usize {
    let total = i + j + k;
    let before = if total == 0 { 0 } else { count(total - 1) };
    // Within a total degree the exponent of x falls, and for each that of y.
    before + (j + k) * (j + k + 1) / 2 + k
}

/// Change of basis between powers and Chebyshev polynomials of the first kind.
#[derive(Debug, Clone)]
pub(super) struct Chebyshev {
    from_powers: Vec<Vec<f64>>,
    to_powers: Vec<Vec<f64>>,
}

impl Chebyshev {
    pub fn new(degree: usize) -> Self {
        let mut to_powers = vec![vec![1.0]];
        let mut from_powers = vec![vec![1.0]];
        for n in 1..=degree {
            // T_n = 2 u T_(n-1) - T_(n-2), T_1 = u.
            let mut next = vec![0.0; n + 1];
            for (m, value) in to_powers[n - 1].iter().enumerate() {
                next[m + 1] += if n == 1 { 1.0 } else { 2.0 } * value;
            }
            if n >= 2 {
                for (m, value) in to_powers[n - 2].iter().enumerate() {
                    next[m] -= value;
                }
            }
            to_powers.push(next);
            // u T_0 = T_1, u T_m = (T_(m+1) + T_(m-1)) / 2.
            let mut next = vec![0.0; n + 1];
            for (m, value) in from_powers[n - 1].iter().enumerate() {
                if m == 0 {
                    next[1] += value;
                } else {
                    next[m + 1] += 0.5 * value;
                    next[m - 1] += 0.5 * value;
                }
            }
            from_powers.push(next);
        }
        Self { from_powers, to_powers }
    }
}

/// The Taylor polynomials of φ(d) = exp(-κ|d|)/|d|, several centres at a time.
///
/// With ψ = exp(-κ|d|), a_k and b_k the Taylor coefficients of φ and ψ, the equations ∂_i ψ = -κ d_i φ and
/// |d|² ∂_i φ = -d_i (κ ψ + φ) give recurrences (Li, Johnston and Krasny, J. Comput. Phys. 228, 3858 (2009)).
#[derive(Debug)]
pub(super) struct YukawaTaylor {
    kappa: f64,
    a: Vec<[f64; LANES]>,
    b: Vec<[f64; LANES]>,
    sum: Vec<[f64; LANES]>,
}

impl YukawaTaylor {
    pub fn new(kappa: f64, monomials: &Monomials) -> Self {
        // One more entry, always zero, stands for coefficients that do not exist.
        let zeros = vec![[0.0; LANES]; monomials.len() + 1];
        Self { kappa, a: zeros.clone(), b: zeros.clone(), sum: zeros }
    }

    /// Adds Σ q φ(d + δ), as polynomials of δ, to `sum`. `displacements` lead from the charges to the centre, Å.
    pub fn add(&mut self, monomials: &Monomials, displacements: &[[f64; 3]], charges: &[f64], sum: &mut [f64]) {
        self.sum.fill([0.0; LANES]);
        for (d, q) in displacements.chunks(LANES).zip(charges.chunks(LANES)) {
            let lane = |axis: usize| std::array::from_fn(|l| d.get(l).map_or(1.0, |d| d[axis]));
            let charge = std::array::from_fn(|l| q.get(l).copied().unwrap_or(0.0));
            self.expand(monomials, [lane(0), lane(1), lane(2)], &charge);
        }
        for (sum, lanes) in sum.iter_mut().zip(&self.sum) {
            *sum += lanes.iter().sum::<f64>();
        }
    }

    fn expand(&mut self, monomials: &Monomials, d: [[f64; LANES]; 3], charge: &[f64; LANES]) {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the processor has the feature the function is compiled for.
                return unsafe { self.expand_avx512(monomials, d, charge) };
            }
        }
        self.expand_any(monomials, d, charge);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f")]
    fn expand_avx512(&mut self, monomials: &Monomials, d: [[f64; LANES]; 3], charge: &[f64; LANES]) {
        self.expand_any(monomials, d, charge);
    }

    #[inline(always)]
    fn expand_any(&mut self, monomials: &Monomials, d: [[f64; LANES]; 3], charge: &[f64; LANES]) {
        let kappa = self.kappa;
        let mut inverse_square = [0.0; LANES];
        for l in 0..LANES {
            let square = d[0][l] * d[0][l] + d[1][l] * d[1][l] + d[2][l] * d[2][l];
            let r = square.sqrt();
            inverse_square[l] = 1.0 / square;
            self.b[0][l] = (-kappa * r).exp();
            self.a[0][l] = self.b[0][l] / r;
        }
        let (a, b) = (&mut self.a[..], &mut self.b[..]);
        for i in 1..monomials.len() {
            let total: usize = monomials.exponents[i].iter().sum();
            let [one, two] = &monomials.lower[i];
            let n = total as f64;
            let (two_n, n_1, per_total) = (2.0 * n - 1.0, n - 1.0, 1.0 / n);
            // (2n-1) Σ d_k a_(k-1) + (n-1) Σ a_(k-2) + κ (Σ d_k b_(k-1) + Σ b_(k-2)), one operation on all lanes at a time.
            let mut sum = [0.0; LANES];
            for axis in 0..3 {
                let (a_1, b_1, d) = (&a[one[axis]], &b[one[axis]], &d[axis]);
                sum = std::array::from_fn(|l| sum[l] + d[l] * (two_n * a_1[l] + kappa * b_1[l]));
                let (a_2, b_2) = (&a[two[axis]], &b[two[axis]]);
                sum = std::array::from_fn(|l| sum[l] + (n_1 * a_2[l] + kappa * b_2[l]));
            }
            let axis = monomials.parent[i].1;
            let scale = -kappa / monomials.exponents[i][axis] as f64;
            let (a_1, a_2, d) = (&a[one[axis]], &a[two[axis]], &d[axis]);
            let new_b = std::array::from_fn(|l| scale * (d[l] * a_1[l] + a_2[l]));
            a[i] = std::array::from_fn(|l| -sum[l] * inverse_square[l] * per_total);
            b[i] = new_b;
        }
        for (sum, a) in self.sum.iter_mut().zip(&self.a) {
            *sum = std::array::from_fn(|l| sum[l] + charge[l] * a[l]);
        }
    }
}

/// Bound of the remainder of the Taylor polynomial of degree `degree` of exp(-κ|d|)/|d| at offsets up to `radius` < |d|.
///
/// The addition theorem of the screened potential, φ(d - δ) = κ Σ (2n+1) i_n(κ|δ|) k_n(κ|d|) P_n(cos γ), has power series
/// i_n with positive coefficients and |P_n| <= 1. So along every direction the Taylor coefficients are at most those of
/// the case γ = 0, f(t) = exp(-κ(r - t))/(r - t) = (exp(-κ r)/r) Σ g_n t^n with g_n = g_(n-1)/r + κ^n/n!. As
/// g_(n+1)/g_n <= 1/r + κ/(n+1), a geometric series bounds the rest.
pub(super) fn taylor_remainder(kappa: f64, distance: f64, radius: f64, degree: usize) -> f64 {
    let (mut g, mut power) = (1.0, 1.0);
    for n in 1..=degree + 1 {
        power *= kappa / n as f64;
        g = g / distance + power;
    }
    let ratio = radius * (1.0 / distance + kappa / (degree + 2) as f64);
    if ratio >= 1.0 {
        return f64::INFINITY;
    }
    (-kappa * distance).exp() / distance * g * radius.powi(degree as i32 + 1) / (1.0 - ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Vec3;
    use protomer_kernel::random::CounterRng;

    fn evaluate(monomials: &Monomials, coefficients: &[f64], point: [f64; 3]) -> f64 {
        let mut values = vec![0.0; monomials.len()];
        monomials.values(point, &mut values);
        coefficients.iter().zip(&values).map(|(c, v)| c * v).sum()
    }

    #[test]
    fn the_index_is_the_place() {
        let monomials = Monomials::new(9);
        assert_eq!(monomials.len(), count(9));
        for (place, exponents) in monomials.exponents.iter().enumerate() {
            assert_eq!(index(*exponents), place);
        }
    }

    #[test]
    fn shifting_scaling_and_economising_keep_the_function() {
        let mut rng = CounterRng::new(8, 0, 0);
        let monomials = Monomials::new(8);
        let chebyshev = Chebyshev::new(8);
        for _ in 0..50 {
            let c: Vec<f64> = (0..monomials.len()).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
            let (s, u): ([f64; 3], [f64; 3]) = (
                std::array::from_fn(|_| rng.uniform_in(-0.5, 0.5)),
                std::array::from_fn(|_| rng.uniform_in(-1.0, 1.0)),
            );
            let mut shifted = c.clone();
            monomials.shift(&mut shifted, s);
            let expected = evaluate(&monomials, &c, std::array::from_fn(|i| s[i] + u[i]));
            assert!((evaluate(&monomials, &shifted, u) - expected).abs() < 1e-10 * (1.0 + expected.abs()));
            let mut scaled = c.clone();
            monomials.scale(&mut scaled, [0.5, 0.25, 2.0]);
            let expected = evaluate(&monomials, &c, [0.5 * u[0], 0.25 * u[1], 2.0 * u[2]]);
            assert!((evaluate(&monomials, &scaled, u) - expected).abs() < 1e-10 * (1.0 + expected.abs()));
            let mut same = c.clone();
            assert_eq!(monomials.economise(&mut same, 8, &chebyshev), 0.0);
            let expected = evaluate(&monomials, &c, u);
            assert!((evaluate(&monomials, &same, u) - expected).abs() < 1e-11);
            let mut less = c.clone();
            let bound = monomials.economise(&mut less, 4, &chebyshev);
            assert!((evaluate(&Monomials::new(4), &less, u) - expected).abs() <= bound + 1e-11);
        }
    }

    #[test]
    fn taylor_polynomials_stay_within_the_proven_remainder() {
        let mut rng = CounterRng::new(9, 0, 0);
        for kappa in [0.0, 1.0 / 30.0, 0.1, 1.0 / 3.0] {
            for degree in [3, 6, 10] {
                let monomials = Monomials::new(degree);
                let mut taylor = YukawaTaylor::new(kappa, &monomials);
                let mut largest_fraction = 0.0f64;
                for case in 0..300 {
                    let d = rng.unit_vector() * rng.uniform_in(2.0, 30.0);
                    // Offsets straight towards the charge are the worst ones.
                    let direction = if case % 3 == 0 { -d.normalize() } else { rng.unit_vector() };
                    let offset: Vec3 = direction * (0.3 * d.norm());
                    let mut sum = vec![0.0; monomials.len()];
                    taylor.add(&monomials, &[d.into()], &[1.0], &mut sum);
                    let r = (d + offset).norm();
                    let error = (evaluate(&monomials, &sum, offset.into()) - (-kappa * r).exp() / r).abs();
                    let bound = taylor_remainder(kappa, d.norm(), offset.norm(), degree);
                    assert!(error <= bound + 1e-14, "{kappa} {degree} {error} {bound}");
                    if bound > 1e-12 {
                        largest_fraction = largest_fraction.max(error / bound);
                    }
                }
                assert!(largest_fraction > 0.3, "the bound is of the right size: {largest_fraction}");
            }
        }
    }
}
