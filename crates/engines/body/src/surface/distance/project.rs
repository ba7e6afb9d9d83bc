//! Projection onto the excluded surface.
//!
//! With c the accessible point nearest to x, the surface point is c + p (x - c)/|x - c|. From
//! inside the solid this is exact. From outside, a second probe may reach over that point (at a
//! cusp); then the surface point lies on the circle in which both probes meet, or where three of
//! them meet.

use super::SesSolid;
use protomer_kernel::Vec3;

/// Number of steps after which a projection is taken as it is.
const MAX_STEPS: usize = 40;
/// A projected point is this near the surface, Å.
const TOLERANCE_ANGSTROM: f64 = 1e-10;
/// Two probe centres nearer than this are the same, Å.
const SAME_PROBE_ANGSTROM: f64 = 1e-7;

/// The surface point for `point` and the outward unit normal there.
pub(super) fn project(solid: &SesSolid, point: &Vec3) -> (Vec3, Vec3) {
    let probe = solid.probe_radius;
    let (mut from, mut place, mut normal);
    let mut probes: Vec<Vec3> = Vec::new();
    if let Some(step) = first_step(solid, point) {
        if step.value <= 0.0 {
            return (step.onto, step.normal);
        }
        (from, place, normal) = (*point, step.onto, step.normal);
        probes.push(step.centre);
    } else {
        (from, normal) = onto_accessible_solid(solid, point);
        place = from;
    }
    for _ in 0..MAX_STEPS {
        let Some(nearest) = solid.nearest_accessible(&place) else {
            break;
        };
        let centre = nearest.point;
        normal = (centre - place).try_normalize(1e-8).unwrap_or(normal);
        if (nearest.distance - probe).abs() <= TOLERANCE_ANGSTROM {
            break;
        }
        let pushed = centre - normal * probe;
        if nearest.distance > probe
            || probes
                .iter()
                .any(|c| (c - centre).norm() < SAME_PROBE_ANGSTROM)
        {
            (place, from) = (pushed, pushed);
            probes.clear();
            continue;
        }
        if probes.len() == 3 {
            from = place;
            probes.clear();
        }
        probes.push(centre);
        place = nearest_on_all(&from, &probes, probe).unwrap_or(pushed);
    }
    (place, normal)
}

/// The first step of [`project`]: exact from inside the solid, and from outside unless a second probe
/// reaches over the point.
pub(super) fn pull(solid: &SesSolid, point: &Vec3) -> (Vec3, Vec3) {
    match first_step(solid, point) {
        Some(step) => (step.onto, step.normal),
        None => project(solid, point),
    }
}

/// The first step of a projection.
struct Step {
    /// The signed distance of the point that is projected.
    value: f64,
    /// The accessible point nearest to it.
    centre: Vec3,
    /// Point where a probe at `centre` touches on the side of the point, and the outward unit
    /// normal.
    onto: Vec3,
    normal: Vec3,
}

/// The first step from a point. `None` if a probe centred there would touch no atom, or no
/// accessible point is near.
fn first_step(solid: &SesSolid, point: &Vec3) -> Option<Step> {
    let (value, centre) = solid.signed_distance_and_probe(point);
    let centre = centre?;
    if value >= solid.probe_radius {
        return None;
    }
    let normal = (centre - point).try_normalize(1e-8)?;
    Some(Step {
        value,
        centre,
        onto: centre - normal * solid.probe_radius,
        normal,
    })
}

/// Point of the accessible solid for a point, and an outward direction: the point itself if a probe
/// centred there would touch an atom, otherwise a point of an atom in its direction.
fn onto_accessible_solid(solid: &SesSolid, point: &Vec3) -> (Vec3, Vec3) {
    let Some((atom, depth)) = solid.deepest_anywhere(point) else {
        return (*point, Vec3::z());
    };
    let (centre, radius) = (solid.centres[atom as usize], solid.radii[atom as usize]);
    let outward = (point - centre).try_normalize(0.0).unwrap_or_else(Vec3::z);
    if depth > 1e-9 * radius {
        (*point, outward)
    } else {
        (centre + outward * (radius - solid.probe_radius), outward)
    }
}

/// The point nearest to `from` among those at distance `radius` from each of one, two or three
/// centres.
fn nearest_on_all(from: &Vec3, centres: &[Vec3], radius: f64) -> Option<Vec3> {
    match centres {
        [a] => Some(a + (from - a).try_normalize(0.0)? * radius),
        [a, b] => {
            let half = (b - a) * 0.5;
            let axis = half.try_normalize(1e-12)?;
            let square = radius * radius - half.norm_squared();
            let out = from - a - axis * axis.dot(&(from - a));
            (square > 0.0).then_some(())?;
            Some(a + half + out.try_normalize(1e-12)? * square.sqrt())
        }
        [a, b, c] => {
            let (u, v) = (b - a, c - a);
            let normal = u.cross(&v);
            let area = normal.norm_squared();
            (area > 1e-14).then_some(())?;
            // Circumcentre of the three centres, then up or down along the normal.
            let base = (v.cross(&normal) * u.norm_squared() + normal.cross(&u) * v.norm_squared())
                / (2.0 * area);
            let height = ((radius * radius - base.norm_squared()).max(0.0) / area).sqrt();
            let side = if normal.dot(&(from - a)) >= 0.0 {
                height
            } else {
                -height
            };
            Some(a + base + normal * side)
        }
        _ => None,
    }
}
