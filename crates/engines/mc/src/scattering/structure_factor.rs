//! S(q) between points.

use super::sinc;
use protomer_kernel::Vec3;

/// The structure factor of N points in open space, averaged over all orientations (Debye, Ann. Phys.
/// 351, 809 (1915)):
///
/// S(q) = 1 + (2/N) Σ_{i<j} sin(q r_ij) / (q r_ij).
///
/// It tends to N for q → 0.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::scattering::structure_factor::open;
/// let pair = [Vec3::zeros(), Vec3::new(0.0, 30.0, 0.0)];
/// assert!((open(&pair, 0.1) - (1.0 + 3_f64.sin() / 3.0)).abs() < 1e-15);
/// ```
pub fn open(positions_angstrom: &[Vec3], q_per_angstrom: f64) -> f64 {
    let mut sum = 0.0;
    for (second, position) in positions_angstrom.iter().enumerate() {
        for other in &positions_angstrom[..second] {
            sum += sinc(q_per_angstrom * (position - other).norm());
        }
    }
    1.0 + 2.0 * sum / positions_angstrom.len() as f64
}

/// The structure factor of N points at one wave vector, |Σ exp(i q·r)|² / N. In a periodic box only
/// its own wave vectors have a meaning.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::scattering::structure_factor::evaluate;
/// let row: Vec<Vec3> = (0..4).map(|i| Vec3::new(10.0 * f64::from(i), 0.0, 0.0)).collect();
/// let [in_step, against] = [0.2, 0.1].map(|q| evaluate(&row, &Vec3::new(q * std::f64::consts::PI, 0.0, 0.0)));
/// assert!((in_step - 4.0).abs() < 1e-12 && against.abs() < 1e-12);
/// ```
pub fn evaluate(positions_angstrom: &[Vec3], wave_vector: &Vec3) -> f64 {
    let (mut real, mut imaginary) = (0.0, 0.0);
    for position in positions_angstrom {
        let (sine, cosine) = wave_vector.dot(position).sin_cos();
        (real, imaginary) = (real + cosine, imaginary + sine);
    }
    (real * real + imaginary * imaginary) / positions_angstrom.len() as f64
}
