//! Σ_i Z_i p(t_ij) over the members of a target leaf, as a polynomial of the place of the source
//! charge.

use super::super::split::Split;
use super::sources::{MOMENTS, Target};

/// Coefficients of Σ_i Z_i p(t_ij): as a polynomial of y in the order of [`moments`], and for
/// charges one by one.
pub struct Contraction {
    pub global: [f64; MOMENTS],
    /// p summed = k0 + t (k1 + t k2), k0 and k1 polynomials of d, t that of the centre.
    pub k0: [f32; 10],
    pub k1: [f32; 4],
    pub k2: f32,
}

impl Contraction {
    pub fn new(target: &Target, split: &Split, square: f64) -> Self {
        let [c0, c1, c2] = split.step;
        let c = target.centre;
        let m = &target.moments;
        let (q, d, o, h) = (m[0], [m[1], m[2], m[3]], [m[10], m[11], m[12]], m[13]);
        let quadratic = [[m[4], m[7], m[8]], [m[7], m[5], m[9]], [m[8], m[9], m[6]]];
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let qc = [
            dot(&quadratic[0], &c),
            dot(&quadratic[1], &c),
            dot(&quadratic[2], &c),
        ];
        let e = m[4] + m[5] + m[6] + 2.0 * dot(&d, &c);
        let f: [f64; 3] = std::array::from_fn(|i| o[i] + 2.0 * qc[i]);
        let ee = h + 4.0 * dot(&o, &c) + 4.0 * dot(&c, &qc);
        let (k, k2) = (c1 * q + 2.0 * c2 * e, c2 * q);
        let l = d.map(|d| -4.0 * c2 * d);
        let g = c.map(|c| -2.0 * c);
        let a = dot(&c, &c) - square;
        let constant = c0 * q + c1 * e + c2 * ee;
        let linear: [f64; 3] = std::array::from_fn(|i| -2.0 * c1 * d[i] - 4.0 * c2 * f[i]);
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        // Off the diagonal both orders count.
        let twice = |i: usize, j: usize| if i == j { 1.0 } else { 2.0 };
        let own: [f64; 6] = pairs.map(|(i, j)| 4.0 * c2 * twice(i, j) * quadratic[i][j]);
        let mut global = [0.0; MOMENTS];
        global[0] = constant + k * a + k2 * a * a;
        for i in 0..3 {
            global[1 + i] = linear[i] + k * g[i] + a * l[i] + 2.0 * k2 * a * g[i];
            global[10 + i] = l[i] + 2.0 * k2 * g[i];
        }
        for (n, (i, j)) in pairs.into_iter().enumerate() {
            let mixed = if i == j {
                l[i] * g[i]
            } else {
                l[i] * g[j] + l[j] * g[i]
            };
            global[4 + n] = own[n] + mixed + k2 * twice(i, j) * g[i] * g[j];
            if i == j {
                global[4 + n] += k + 2.0 * k2 * a;
            }
        }
        global[13] = k2;
        let trace = m[4] + m[5] + m[6];
        let mut k0 = [(c0 * q + c1 * trace + c2 * h) as f32; 10];
        for i in 0..3 {
            k0[1 + i] = (-2.0 * c1 * d[i] - 4.0 * c2 * o[i]) as f32;
        }
        for n in 0..6 {
            k0[4 + n] = own[n] as f32;
        }
        let k = c1 * q + 2.0 * c2 * trace;
        Self {
            global,
            k0,
            k1: [k as f32, l[0] as f32, l[1] as f32, l[2] as f32],
            k2: k2 as f32,
        }
    }
}
