//! What of a body scatters.

use super::filling::fill;
use super::sinc;
use nalgebra::Complex;
use protomer_body::Body;
use protomer_body::structure::write::has_atoms;
use protomer_kernel::{KernelError, Vec3};

/// Width of the bins of distances, Å. The mean distance of each bin is kept, so that the error is of
/// the order (q w)²/24 of the spread within a bin only.
const BIN_ANGSTROM: f64 = 0.1;

/// Points that scatter, in the frame of a body, each with the volume that it stands for: the contrast
/// of a protein with water is the same everywhere inside.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::scattering::scatterers::Scatterers;
/// let pair = Scatterers::new([(Vec3::zeros(), 2.0), (Vec3::new(30.0, 0.0, 0.0), 2.0)]);
/// assert_eq!((pair.volume_angstrom3(), pair.radius_angstrom()), (4.0, 30.0));
/// assert!((pair.form_factor(0.1) - (0.5 + 0.5 * 3.0_f64.sin() / 3.0)).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scatterers {
    positions_angstrom: Vec<Vec3>,
    volumes_angstrom3: Vec<f64>,
}

impl Scatterers {
    /// Points with weights.
    pub fn new(points: impl IntoIterator<Item = (Vec3, f64)>) -> Self {
        let (positions_angstrom, volumes_angstrom3) = points.into_iter().unzip();
        Self {
            positions_angstrom,
            volumes_angstrom3,
        }
    }

    /// The atoms of a body with equal shares of its volume. A body without atoms is filled with some
    /// 4000 points that have its centre and its radius of gyration.
    ///
    /// # Errors
    /// If the mesh bounds no solid, or one too thin to be filled.
    pub fn of_body(body: &Body) -> Result<Self, KernelError> {
        let volume = body.mass_properties.volume_angstrom3;
        if !has_atoms(body) {
            let points = fill(&body.mesh, &body.mass_properties)?;
            let share = volume / points.len() as f64;
            return Ok(Self::new(points.into_iter().map(|point| (point, share))));
        }
        let is_atom = |site: &&protomer_body::Site| site.residue.is_some();
        let atoms: Vec<Vec3> = body
            .sites
            .iter()
            .filter(is_atom)
            .map(|site| site.position)
            .collect();
        let share = volume / atoms.len() as f64;
        Ok(Self::new(atoms.into_iter().map(|atom| (atom, share))))
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions_angstrom.len()
    }

    /// Whether nothing scatters.
    pub fn is_empty(&self) -> bool {
        self.positions_angstrom.is_empty()
    }

    /// Sum of the volumes, Å³.
    pub fn volume_angstrom3(&self) -> f64 {
        self.volumes_angstrom3.iter().sum()
    }

    /// The largest distance of a point from the origin of the body, Å.
    pub fn radius_angstrom(&self) -> f64 {
        let distances = self.positions_angstrom.iter().map(Vec3::norm);
        distances.fold(0.0, f64::max)
    }

    /// F(q) = Σ v exp(i q·r), Å³, for a wave vector in the frame of the body.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_mc::scattering::scatterers::Scatterers;
    /// let pair = Scatterers::new([(-Vec3::x(), 1.0), (Vec3::x(), 1.0)]);
    /// let amplitude = pair.amplitude(&Vec3::new(0.5, 9.0, 0.0));
    /// assert!((amplitude.re - 2.0 * 0.5_f64.cos()).abs() < 1e-12 && amplitude.im.abs() < 1e-12);
    /// ```
    pub fn amplitude(&self, wave_vector: &Vec3) -> Complex<f64> {
        let (mut real, mut imaginary) = (0.0, 0.0);
        for (position, volume) in self.positions_angstrom.iter().zip(&self.volumes_angstrom3) {
            let (sine, cosine) = wave_vector.dot(position).sin_cos();
            (real, imaginary) = (real + volume * cosine, imaginary + volume * sine);
        }
        Complex::new(real, imaginary)
    }

    /// P(q), 1 at q = 0, by the sum over all pairs: Σ_ij v_i v_j sin(q r_ij)/(q r_ij) / (Σ v)².
    pub fn form_factor(&self, q_per_angstrom: f64) -> f64 {
        let mut sum = 0.0;
        for (second, position) in self.positions_angstrom.iter().enumerate() {
            let volume = self.volumes_angstrom3[second];
            let mut with_earlier = 0.0;
            for (first, other) in self.positions_angstrom[..second].iter().enumerate() {
                let distance = (position - other).norm();
                with_earlier += self.volumes_angstrom3[first] * sinc(q_per_angstrom * distance);
            }
            sum += volume * (volume + 2.0 * with_earlier);
        }
        sum / self.volume_angstrom3().powi(2)
    }

    /// The distances of all pairs, for P(q) at many q.
    pub fn distances(&self) -> Distances {
        let mut bins: Vec<(f64, f64)> = Vec::new();
        let mut alone = 0.0;
        for (second, position) in self.positions_angstrom.iter().enumerate() {
            let volume = self.volumes_angstrom3[second];
            alone += volume * volume;
            for (first, other) in self.positions_angstrom[..second].iter().enumerate() {
                let distance = (position - other).norm();
                let bin = (distance / BIN_ANGSTROM) as usize;
                if bin >= bins.len() {
                    bins.resize(bin + 1, (0.0, 0.0));
                }
                let weight = 2.0 * volume * self.volumes_angstrom3[first];
                bins[bin].0 += weight;
                bins[bin].1 += weight * distance;
            }
        }
        let total = self.volume_angstrom3().powi(2);
        let filled = bins.into_iter().filter(|(weight, _)| *weight > 0.0);
        Distances {
            alone: alone / total,
            bins: filled
                .map(|(weight, sum)| (weight / total, sum / weight))
                .collect(),
        }
    }
}

/// The distances between the points of a body: how often each occurs.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::scattering::scatterers::Scatterers;
/// let points = (0..50).map(|i| (Vec3::new(f64::from(i), f64::from(i * i % 7), 0.0), 1.0));
/// let chain = Scatterers::new(points);
/// let distances = chain.distances();
/// assert!((distances.form_factor(0.1) - chain.form_factor(0.1)).abs() < 1e-4);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Distances {
    /// Share of the points with themselves.
    alone: f64,
    /// Share of the pairs, and their mean distance, Å.
    bins: Vec<(f64, f64)>,
}

impl Distances {
    /// P(q) as [`Scatterers::form_factor`], to some 10⁻⁵.
    pub fn form_factor(&self, q_per_angstrom: f64) -> f64 {
        let pairs = self.bins.iter();
        self.alone
            + pairs
                .map(|(share, distance)| share * sinc(q_per_angstrom * distance))
                .sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn bins_of_distances_give_the_form_factor_of_the_sum_over_pairs() {
        let mut rng = CounterRng::new(3, 0, 0);
        let points = (0..400).map(|_| {
            (
                rng.unit_vector() * 25.0 * rng.uniform(),
                0.5 + rng.uniform(),
            )
        });
        let scatterers = Scatterers::new(points.collect::<Vec<_>>());
        let distances = scatterers.distances();
        for step in 0..=50 {
            let q = 0.01 * f64::from(step);
            let (fast, direct) = (distances.form_factor(q), scatterers.form_factor(q));
            assert!((fast - direct).abs() < 1e-5, "{q}: {fast} {direct}");
        }
        assert!((scatterers.form_factor(0.0) - 1.0).abs() < 1e-12);
    }
}
