//! The energy of two bodies as an interval.

use super::Charges;
use super::field::ScreenedField;
use super::tail::CutTail;
use crate::charges::ChargeCloud;
use crate::energy::yukawa_energy_kt;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;

/// Error of the potentials of two bodies without cut-off that the cells' polynomials aim at, kT.
const FIELD_ERROR_KT: f64 = 1e-2;

/// How closely an interval is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Accuracy {
    /// Charges near the cut-off in single precision.
    Fast,
    /// Charges near the cut-off in double precision.
    Fine,
}

/// An energy between two bounds, kT.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyInterval {
    /// The best estimate, kT.
    pub middle_kt: f64,
    /// Half the width of the interval, kT.
    pub error_kt: f64,
}

impl EnergyInterval {
    /// Lower bound, kT.
    pub fn low_kt(&self) -> f64 {
        self.middle_kt - self.error_kt
    }

    /// Upper bound, kT.
    pub fn high_kt(&self) -> f64 {
        self.middle_kt + self.error_kt
    }
}

/// The energy of two bodies to a tolerance: the cheapest interval whose half-width is at most `tolerance_kt`, the direct sum
/// (as an interval of no width) if none is. `clouds` are the charges of the tables; `relative` is the pose of the second
/// body in the frame of the first.
pub fn pair_energy_interval(
    tables: [&ChargeTable; 2],
    clouds: [&ChargeCloud; 2],
    relative: &RelativePose,
    tolerance_kt: f64,
) -> EnergyInterval {
    for accuracy in [Accuracy::Fast, Accuracy::Fine] {
        match tables[0].energy_interval(tables[1], relative, accuracy) {
            Some(interval) if interval.error_kt <= tolerance_kt => return interval,
            _ => {}
        }
    }
    let middle_kt = yukawa_energy_kt(&tables[0].yukawa, clouds[0], clouds[1], relative);
    EnergyInterval { middle_kt, error_kt: 0.0 }
}

/// What is precomputed about the charges of one body under one potential; immutable, to be shared.
#[derive(Debug, Clone)]
pub struct ChargeTable {
    yukawa: Yukawa,
    /// Middle of the charges' box in the body's frame, Å; everything below is relative to it.
    centre: Vec3,
    points: Charges,
    radius: f64,
    magnitude: f64,
    field: ScreenedField,
    tail: Option<CutTail>,
}

impl ChargeTable {
    /// The tables of these charges.
    pub fn new(charges: &ChargeCloud, yukawa: &Yukawa, rays_per_edge: usize) -> Self {
        let mut low = Vec3::repeat(f64::INFINITY);
        let mut high = -low;
        for (place, _) in charges.iter() {
            low = low.inf(&place);
            high = high.sup(&place);
        }
        let centre = if charges.is_empty() { Vec3::zeros() } else { 0.5 * (low + high) };
        let points = Charges::new(charges.iter().map(|(place, charge)| (place - centre, charge)));
        let radius = points.radius();
        let (bjerrum, kappa) = (yukawa.bjerrum_length_angstrom, yukawa.inverse_debye_length_per_angstrom);
        let cutoff = yukawa.cutoff_angstrom;
        let reach = radius + cutoff.min(60.0);
        let magnitude: f64 = points.charge.iter().map(|charge| charge.abs()).sum();
        let field = ScreenedField::new(&points, bjerrum, kappa, reach, 1.0, FIELD_ERROR_KT / magnitude.max(1.0));
        let tail = CutTail::new(&points, bjerrum, kappa, cutoff, rays_per_edge);
        Self { yukawa: *yukawa, centre, points, radius, magnitude, field, tail }
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.field.memory_bytes() + self.tail.as_ref().map_or(0, CutTail::memory_bytes)
    }

    /// The energy of the body of this table and another whose pose in this one's frame is `relative`; `None` where the
    /// tables do not serve (a cut-off not much larger than the body).
    pub fn energy_interval(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
        accuracy: Accuracy,
    ) -> Option<EnergyInterval> {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("fma")
            {
                // SAFETY: the processor has the features the function is compiled for.
                return unsafe { self.interval_avx512(other, relative, accuracy) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the processor has the features the function is compiled for.
                return unsafe { self.interval_avx2(other, relative, accuracy) };
            }
        }
        self.interval::<false>(other, relative, accuracy)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    fn interval_avx512(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
        accuracy: Accuracy,
    ) -> Option<EnergyInterval> {
        self.interval::<true>(other, relative, accuracy)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn interval_avx2(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
        accuracy: Accuracy,
    ) -> Option<EnergyInterval> {
        self.interval::<true>(other, relative, accuracy)
    }

    #[inline(always)]
    fn interval<const FMA: bool>(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
        accuracy: Accuracy,
    ) -> Option<EnergyInterval> {
        let cutoff = self.yukawa.cutoff_angstrom;
        if cutoff.is_finite() && self.tail.is_none() {
            return None;
        }
        let (r, points) = (&relative.rotation, &other.points);
        // From this table's centre to the other's, in this body's frame.
        let t = relative.transform_point(&other.centre) - self.centre;
        let beyond = self.radius + cutoff + 1e-6;
        let (mut value, mut error, mut absolute) = (0.0, 0.0, 0.0);
        for i in 0..points.len() {
            let (px, py, pz, charge) = (points.x[i], points.y[i], points.z[i], points.charge[i]);
            let x = r.m11 * px + r.m12 * py + r.m13 * pz + t.x;
            let y = r.m21 * px + r.m22 * py + r.m23 * pz + t.y;
            let z = r.m31 * px + r.m32 * py + r.m33 * pz + t.z;
            let distance = (x * x + y * y + z * z).sqrt();
            if distance >= beyond {
                continue;
            }
            let field = self.field.potential(x, y, z);
            let (mut inside, mut bound) = (field.value, field.error);
            if let Some(tail) = &self.tail {
                let tail = tail.at::<FMA>([x, y, z], distance, accuracy == Accuracy::Fine);
                inside -= tail.value;
                bound += tail.error;
            }
            value += charge * inside;
            error += charge.abs() * bound;
            absolute += charge.abs() * field.absolute;
        }
        // The direct sum adds its terms in a few partial sums, in double precision.
        let terms = points.len() as f64 * self.points.len() as f64;
        let rounding = (terms / crate::charges::LANES as f64 + 100.0) * f64::EPSILON * absolute;
        Some(EnergyInterval {
            middle_kt: value,
            error_kt: error + rounding + 1e-12 * self.magnitude * other.magnitude * 1e-3,
        })
    }
}
