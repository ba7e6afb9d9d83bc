//! Integrals along one direction: from touching to where the energy no longer counts, and inwards
//! through the openings that bodies of any shape may have.

use super::BodyPair;
use super::approach::contact_distance_angstrom;
use super::orientation::Orientation;
use protomer_kernel::random::CounterRng;

/// The first interval next to contact, Å.
const FIRST_INTERVAL_ANGSTROM: f64 = 0.4;
/// The ratio of each interval to the one before.
const INTERVAL_RATIO: f64 = 1.7;

/// One place on a ray: a random point of an interval, which stands for the whole interval.
#[derive(Debug, Clone, Copy)]
pub struct RadialPoint {
    /// Distance of the origins, Å.
    pub distance_angstrom: f64,
    /// ∫ r² dr over the interval, Å³.
    pub volume_angstrom3: f64,
    /// The energy, kT.
    pub energy_kt: f64,
    /// Whether the bodies are in contact here.
    pub in_contact: bool,
}

/// Samples along one direction.
#[derive(Debug, Clone)]
pub struct RaySample {
    /// The direction and the rotation.
    pub orientation: Orientation,
    /// Points between contact and the end.
    pub outside: Vec<RadialPoint>,
    /// Points nearer than contact where the bodies do not overlap.
    pub openings: Vec<RadialPoint>,
}

impl RaySample {
    /// Samples one direction out to `end_angstrom`.
    pub fn new(
        pair: &BodyPair,
        orientation: Orientation,
        end_angstrom: f64,
        rng: &mut CounterRng,
    ) -> Self {
        // Everything up to contact counts as overlap here; openings are added below.
        let contact = contact_distance_angstrom(pair, &orientation);
        let point = |distance: f64, volume: f64| {
            let pose = orientation.relative_pose(distance);
            RadialPoint {
                distance_angstrom: distance,
                volume_angstrom3: volume,
                energy_kt: pair.potential.energy_kt(&pose),
                in_contact: pair.is_in_contact(&pose),
            }
        };
        let mut outside = Vec::new();
        // Intervals grow with the distance, as the energy varies ever more slowly.
        for [near, far] in intervals((end_angstrom - contact).max(0.0)) {
            // A random point per interval: unbiased for
            // any function, without a rule of integration.
            let (low, high) = (contact + near, contact + far);
            let distance = rng.uniform_in(low, high);
            // Points are uniform in the distance, so each counts r² times the length.
            outside.push(point(distance, distance * distance * (high - low)));
        }
        // Inside contact: concave bodies may interlock where they do not overlap.
        let mut openings = Vec::new();
        for [distance, volume] in inward_points(contact, rng) {
            let pose = orientation.relative_pose(distance);
            if !pair.excludes(&pose) {
                openings.push(point(distance, volume));
            }
        }
        Self {
            orientation,
            outside,
            openings,
        }
    }

    /// Contribution of the ray to ∫ (exp(-U) - 1) r² dr if everything up to contact counts as overlap, Å³.
    pub fn soft_angstrom3(&self) -> f64 {
        let mut sum = 0.0;
        for point in &self.outside {
            sum += point.volume_angstrom3 * (-point.energy_kt).exp_m1();
        }
        for point in &self.openings {
            // exp(-U), not exp(-U) - 1: the -1 of this volume is already in what is covered.
            sum += point.volume_angstrom3 * (-point.energy_kt).exp();
        }
        sum
    }

    /// All points where the bodies do not overlap.
    pub fn points(&self) -> impl Iterator<Item = &RadialPoint> {
        self.outside.iter().chain(&self.openings)
    }

    /// The point of the lowest energy.
    pub fn lowest(&self) -> Option<&RadialPoint> {
        let by_energy = |a: &&RadialPoint, b: &&RadialPoint| a.energy_kt.total_cmp(&b.energy_kt);
        self.points().min_by(by_energy)
    }
}

/// Volumes of a direction that are covered up to contact, and open before contact, Å³; without energies.
pub fn hard_ray(pair: &BodyPair, orientation: &Orientation, rng: &mut CounterRng) -> (f64, f64) {
    let contact = contact_distance_angstrom(pair, orientation);
    let mut open = 0.0;
    for [distance, volume] in inward_points(contact, rng) {
        let pose = orientation.relative_pose(distance);
        if !pair.excludes(&pose) {
            open += volume;
        }
    }
    // ∫ r² dr from zero to contact.
    (contact.powi(3) / 3.0, open)
}

/// Intervals of growing length that fill 0 to `length`.
fn intervals(length: f64) -> Vec<[f64; 2]> {
    let mut intervals = Vec::new();
    let (mut start, mut step) = (0.0, FIRST_INTERVAL_ANGSTROM);
    while start < length {
        let end = (start + step).min(length);
        intervals.push([start, end]);
        start = end;
        step *= INTERVAL_RATIO;
    }
    intervals
}

/// Random points between the origin and contact, with what each stands for: distance, Å, and
/// volume, Å³.
fn inward_points(contact: f64, rng: &mut CounterRng) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for [near, far] in intervals(contact) {
        let distance = contact - rng.uniform_in(near, far);
        points.push([distance, distance * distance * (far - near)]);
    }
    points
}
