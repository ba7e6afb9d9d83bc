//! The surface that separates the solute from the solvent, by any of the usual definitions.

use crate::charged_sphere::ChargedSphere;
use crate::{FieldError, Result};
use protomer_body::surface::{Arrangement, ImplicitSolid, SesSolid};
use protomer_kernel::cells::CellList;
use protomer_kernel::{Boundary, Vec3};

protomer_kernel::choices! {
    /// Surface at which the permittivity changes.
    ///
    /// ```
    /// use protomer_field::{ChargedSphere, SurfaceDefinition, surface::surface_of};
    /// use protomer_kernel::Vec3;
    /// let atom = |x| ChargedSphere { centre: Vec3::new(x, 0.0, 0.0), radius_angstrom: 2.0, charge_e: 0.0 };
    /// let pair = [atom(-2.2), atom(2.2)];
    /// let crevice = Vec3::zeros();
    /// let spheres = surface_of(&pair, SurfaceDefinition::VanDerWaals, 1.4)?;
    /// let excluded = surface_of(&pair, SurfaceDefinition::SolventExcluded, 1.4)?;
    /// assert!(spheres.signed_distance(&crevice) > 0.0 && excluded.signed_distance(&crevice) < 0.0);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    pub enum SurfaceDefinition, default SolventExcluded {
        /// The solvent-excluded surface, which a probe rolling over the atoms cannot enter.
        SolventExcluded = "solvent-excluded",
        /// The surface of the atoms: crevices between them contain solvent.
        VanDerWaals = "van-der-waals",
        /// The solvent-accessible surface: the atoms enlarged by the probe radius.
        SolventAccessible = "solvent-accessible",
    }
}

/// The surface of those spheres that have a radius.
///
/// ```
/// use protomer_field::{ChargedSphere, SurfaceDefinition, surface::surface_of};
/// use protomer_kernel::Vec3;
/// let atom = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: 0.0 };
/// let solid = surface_of(&[atom], SurfaceDefinition::SolventAccessible, 1.4)?;
/// assert!((solid.signed_distance(&Vec3::new(3.0, 0.0, 0.0)) + 0.4).abs() < 1e-12);
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
///
/// # Errors
/// [`FieldError::BadInput`] if no sphere has a radius, [`FieldError::Body`] for spheres without a
/// surface.
pub fn surface_of(
    spheres: &[ChargedSphere],
    definition: SurfaceDefinition,
    probe_angstrom: f64,
) -> Result<Box<dyn ImplicitSolid>> {
    Ok(match definition {
        SurfaceDefinition::SolventExcluded => Box::new(solvent_excluded(spheres, probe_angstrom)?),
        SurfaceDefinition::VanDerWaals => Box::new(SphereUnion::new(spheres, 0.0)?),
        SurfaceDefinition::SolventAccessible => {
            Box::new(SphereUnion::new(spheres, probe_angstrom)?)
        }
    })
}

/// The solvent-excluded surface of those spheres that have a radius.
///
/// ```
/// use protomer_body::surface::ImplicitSolid;
/// use protomer_field::{ChargedSphere, surface::solvent_excluded};
/// use protomer_kernel::Vec3;
/// let atom = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: 0.0 };
/// let solid = solvent_excluded(&[atom], 1.4)?;
/// assert!((solid.signed_distance(&Vec3::new(3.0, 0.0, 0.0)) - 1.0).abs() < 1e-6);
/// let point_charge = ChargedSphere { radius_angstrom: 0.0, ..atom };
/// assert!(solvent_excluded(&[point_charge], 1.4).is_err());
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
///
/// # Errors
/// As [`surface_of`].
pub fn solvent_excluded(spheres: &[ChargedSphere], probe_angstrom: f64) -> Result<SesSolid> {
    let (centres, radii) = centres_and_radii(spheres, 0.0)?;
    let arrangement = Arrangement::new(&centres, &radii, probe_angstrom)?;
    Ok(SesSolid::new(&arrangement))
}

/// Centres and radii of the spheres that have a radius, each grown by a length in Å.
fn centres_and_radii(spheres: &[ChargedSphere], growth: f64) -> Result<(Vec<Vec3>, Vec<f64>)> {
    let (mut centres, mut radii) = (Vec::new(), Vec::new());
    for sphere in spheres {
        if sphere.radius_angstrom > 0.0 {
            centres.push(sphere.centre);
            radii.push(sphere.radius_angstrom + growth);
        }
    }
    if centres.is_empty() {
        let reason = "no atom has a radius, so there is no surface; give radii (a PQR has them)";
        return Err(FieldError::BadInput(reason.into()));
    }
    Ok((centres, radii))
}

/// Distances outside are exact up to this, Å, and cut off beyond.
const REACH_ANGSTROM: f64 = 2.5;

/// The union of spheres.
struct SphereUnion {
    centres: Vec<Vec3>,
    radii: Vec<f64>,
    cells: CellList,
    bounds: (Vec3, Vec3),
}

impl SphereUnion {
    fn new(spheres: &[ChargedSphere], growth: f64) -> Result<Self> {
        let (centres, radii) = centres_and_radii(spheres, growth)?;
        let mut largest: f64 = 0.0;
        let mut low = Vec3::repeat(f64::INFINITY);
        let mut high = Vec3::repeat(f64::NEG_INFINITY);
        for (centre, radius) in centres.iter().zip(&radii) {
            largest = largest.max(*radius);
            low = low.inf(&centre.add_scalar(-radius));
            high = high.sup(&centre.add_scalar(*radius));
        }
        Ok(Self {
            // As wide as the largest sphere and the exact reach: no sphere that matters is missed.
            cells: CellList::new(&Boundary::Open, largest + REACH_ANGSTROM, &centres),
            bounds: (low, high),
            centres,
            radii,
        })
    }

    /// The sphere whose surface is nearest from outside, or deepest from inside, and the signed
    /// distance from it, Å.
    fn nearest(&self, point: &Vec3) -> Option<(usize, f64)> {
        let mut candidates = Vec::new();
        self.cells.candidates(point, &mut candidates);
        let mut nearest = None;
        let mut least = f64::INFINITY;
        for index in candidates {
            let distance = (point - self.centres[index]).norm() - self.radii[index];
            if distance < least {
                least = distance;
                nearest = Some((index, distance));
            }
        }
        nearest
    }
}

impl ImplicitSolid for SphereUnion {
    fn signed_distance(&self, point: &Vec3) -> f64 {
        match self.nearest(point) {
            Some((_, distance)) => distance.min(REACH_ANGSTROM),
            None => REACH_ANGSTROM,
        }
    }

    fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
        let Some((sphere, _)) = self.nearest(point) else {
            return (*point, Vec3::x());
        };
        let centre = self.centres[sphere];
        // At a centre all directions are alike.
        let normal = (point - centre)
            .try_normalize(1e-12)
            .unwrap_or_else(Vec3::x);
        (centre + self.radii[sphere] * normal, normal)
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn cover(&self) -> Vec<(Vec3, f64)> {
        let centres = self.centres.iter().copied();
        centres.zip(self.radii.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn a_place_is_inside_if_it_is_in_a_sphere() {
        let mut rng = CounterRng::new(1, 0, 0);
        let mut place =
            |half: f64| Vec3::from(std::array::from_fn(|_| rng.uniform_in(-half, half)));
        let sphere = |centre: Vec3| ChargedSphere {
            centre,
            radius_angstrom: 1.0 + 0.05 * centre.x.abs(),
            charge_e: 0.0,
        };
        let spheres: Vec<ChargedSphere> = (0..200).map(|_| sphere(place(10.0))).collect();
        for (definition, grown) in [
            (SurfaceDefinition::VanDerWaals, 0.0),
            (SurfaceDefinition::SolventAccessible, 1.4),
        ] {
            let solid = surface_of(&spheres, definition, 1.4).unwrap();
            for _ in 0..2000 {
                let point = place(14.0);
                let slow = slow_distance(&spheres, grown, &point);
                let fast = solid.signed_distance(&point);
                let expected = slow.min(REACH_ANGSTROM);
                assert!((fast - expected).abs() < 1e-12, "{fast} {slow}");
                if slow.abs() < 1.0 {
                    let (on, normal) = solid.project(&point);
                    assert!(solid.signed_distance(&on) <= 1e-9);
                    assert!((normal.norm() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    fn slow_distance(spheres: &[ChargedSphere], grown: f64, point: &Vec3) -> f64 {
        let mut least = f64::INFINITY;
        for sphere in spheres {
            least = least.min((point - sphere.centre).norm() - sphere.radius_angstrom - grown);
        }
        least
    }
}
