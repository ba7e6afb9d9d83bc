//! The surface that separates the solute from the solvent, by either of the usual definitions.

use crate::poisson_boltzmann::{ChargedSphere, DielectricModel};
use crate::{FieldError, Result};
use protomer_body::surface::{Arrangement, ImplicitSolid, SesSolid};
use protomer_kernel::cells::CellList;
use protomer_kernel::{Boundary, Vec3};

/// What the dielectric boundary is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceDefinition {
    /// Where a probe that rolls over the spheres cannot get in (Richards, Annu. Rev. Biophys.
    /// Bioeng. 6, 151 (1977)).
    #[default]
    SolventExcluded,
    /// The spheres themselves: crevices between them hold solvent.
    VanDerWaals,
    /// Where the centre of the probe gets: the spheres grown by its radius.
    SolventAccessible,
}

/// The surface of those spheres that have a radius.
///
/// # Errors
/// [`FieldError::BadInput`] if none has, [`FieldError::Body`] for spheres without a surface.
pub fn surface_of(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
) -> Result<Box<dyn ImplicitSolid>> {
    let grown = if dielectric.surface == SurfaceDefinition::SolventAccessible {
        dielectric.probe_angstrom
    } else {
        0.0
    };
    let (centres, radii) = solid_spheres(spheres, grown)?;
    Ok(match dielectric.surface {
        SurfaceDefinition::SolventExcluded => {
            Box::new(excluded(&centres, &radii, dielectric.probe_angstrom)?)
        }
        SurfaceDefinition::VanDerWaals | SurfaceDefinition::SolventAccessible => {
            Box::new(SphereUnion::new(centres, radii)?)
        }
    })
}

/// The solvent-excluded surface of those spheres that have a radius.
///
/// # Errors
/// As [`surface_of`].
pub fn solvent_excluded(spheres: &[ChargedSphere], probe_angstrom: f64) -> Result<SesSolid> {
    let (centres, radii) = solid_spheres(spheres, 0.0)?;
    excluded(&centres, &radii, probe_angstrom)
}

fn excluded(centres: &[Vec3], radii: &[f64], probe_angstrom: f64) -> Result<SesSolid> {
    Ok(SesSolid::new(&Arrangement::new(
        centres,
        radii,
        probe_angstrom,
    )?))
}

fn solid_spheres(spheres: &[ChargedSphere], grown: f64) -> Result<(Vec<Vec3>, Vec<f64>)> {
    let solid = spheres.iter().filter(|sphere| sphere.radius_angstrom > 0.0);
    let (centres, radii): (Vec<Vec3>, Vec<f64>) = solid
        .map(|sphere| (sphere.centre, sphere.radius_angstrom + grown))
        .unzip();
    if centres.is_empty() {
        let reason = "no atom has a radius, so there is no surface; give radii (a PQR has them)";
        return Err(FieldError::BadInput(reason.into()));
    }
    Ok((centres, radii))
}

/// Lowest and highest corner of the box about spheres, Å.
pub(crate) fn bounds<'a>(spheres: impl Iterator<Item = &'a ChargedSphere>) -> (Vec3, Vec3) {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    spheres.fold(start, |(low, high), sphere| {
        let r = Vec3::repeat(sphere.radius_angstrom);
        (
            low.inf(&(sphere.centre - r)),
            high.sup(&(sphere.centre + r)),
        )
    })
}

/// Distances outside are told up to this, Å.
const REACH_ANGSTROM: f64 = 2.5;

/// The union of spheres.
struct SphereUnion {
    centres: Vec<Vec3>,
    radii: Vec<f64>,
    cells: CellList,
    bounds: (Vec3, Vec3),
}

impl SphereUnion {
    fn new(centres: Vec<Vec3>, radii: Vec<f64>) -> Result<Self> {
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let cells = CellList::new(&Boundary::Open, largest + REACH_ANGSTROM, &centres)
            .map_err(|error| FieldError::BadInput(error.to_string()))?;
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let bounds = centres
            .iter()
            .zip(&radii)
            .fold(start, |(low, high), (centre, radius)| {
                (
                    low.inf(&centre.add_scalar(-radius)),
                    high.sup(&centre.add_scalar(*radius)),
                )
            });
        Ok(Self {
            centres,
            radii,
            cells,
            bounds,
        })
    }

    /// The sphere whose surface is least far outside, or deepest inside, and that distance.
    fn nearest(&self, point: &Vec3) -> Option<(usize, f64)> {
        let mut near = Vec::new();
        self.cells.candidates(point, &mut near);
        let distance = |i: usize| (point - self.centres[i]).norm() - self.radii[i];
        near.into_iter()
            .map(|i| (i, distance(i)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl ImplicitSolid for SphereUnion {
    fn signed_distance(&self, point: &Vec3) -> f64 {
        self.nearest(point)
            .map_or(REACH_ANGSTROM, |(_, distance)| distance.min(REACH_ANGSTROM))
    }

    fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
        let Some((sphere, _)) = self.nearest(point) else {
            return (*point, Vec3::x());
        };
        let normal = (point - self.centres[sphere])
            .try_normalize(1e-12)
            .unwrap_or_else(Vec3::x);
        (self.centres[sphere] + self.radii[sphere] * normal, normal)
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn cover(&self) -> Vec<(Vec3, f64)> {
        self.centres
            .iter()
            .copied()
            .zip(self.radii.iter().copied())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use protomer_kernel::Electrolyte;
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
        let mut dielectric = DielectricModel::new(Electrolyte::in_water(298.15, 0.1).unwrap());
        for (definition, grown) in [
            (SurfaceDefinition::VanDerWaals, 0.0),
            (SurfaceDefinition::SolventAccessible, 1.4),
        ] {
            dielectric.surface = definition;
            let solid = surface_of(&spheres, &dielectric).unwrap();
            for _ in 0..2000 {
                let point = place(14.0);
                let slow =
                    |s: &ChargedSphere| (point - s.centre).norm() - s.radius_angstrom - grown;
                let slow = spheres.iter().map(slow).fold(f64::INFINITY, f64::min);
                let fast = solid.signed_distance(&point);
                assert!(
                    (fast - slow.min(REACH_ANGSTROM)).abs() < 1e-12,
                    "{fast} {slow}"
                );
                if slow.abs() < 1.0 {
                    let (on, normal) = solid.project(&point);
                    assert!(
                        (solid.signed_distance(&on) <= 1e-9) && (normal.norm() - 1.0).abs() < 1e-12
                    );
                }
            }
        }
    }
}
