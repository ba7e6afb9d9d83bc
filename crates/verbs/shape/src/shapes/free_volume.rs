//! Free volumes of depletants among hard convex bodies, by scaled particle theory.

use super::{half_axes, read_shape};
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_hpmc::free_volume_theory::BodyMeasures;
use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
use protomer_kernel::shape::measures::Measures;
use serde::Serialize;

/// The free volume of one kind of depletant at one packing fraction. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScaledParticleRow {
    /// The part of space that the bodies fill.
    pub packing_fraction: f64,
    /// Radius of the depletants.
    pub depletant_radius: f64,
    /// The part of space that is open to the centres of depletants.
    pub free_volume_fraction: f64,
    /// Excess chemical potential of a depletant, -ln of the free volume fraction, kT.
    pub excess_chemical_potential_kt: f64,
}

/// Free volumes.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct ScaledParticles(pub Vec<ScaledParticleRow>);

impl Answer for ScaledParticles {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "packing fraction",
            "depletant radius",
            "free volume fraction",
            "excess chemical potential/kT",
        ])];
        for row in &self.0 {
            rows.push(vec![
                row.packing_fraction.to_string(),
                row.depletant_radius.to_string(),
                format!("{:.10}", row.free_volume_fraction),
                format!("{:.9}", row.excess_chemical_potential_kt),
            ]);
        }
        columns(&rows)
    }
}

/// Free volumes of depletants in fluids of convex bodies in space, for all packing fractions and radii.
///
/// # Errors
/// For a shape that is concave or flat, and numbers out of range.
///
/// ```
/// let found = protomer_shape_verbs::shapes::free_volume::scaled_particles("ellipsoid:1,1,1", 0.0, &[0.25], &[0.4])?;
/// assert!((found.0[0].free_volume_fraction - 0.37626565710018645).abs() < 1e-12);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn scaled_particles(
    file_or_name: &str,
    rounding_radius: f64,
    packing_fractions: &[f64],
    depletant_radii: &[f64],
) -> Result<ScaledParticles> {
    let bodies = measures(file_or_name, rounding_radius)?;
    let mut rows = Vec::new();
    for packing_fraction in packing_fractions.iter().copied() {
        if !(0.0..1.0).contains(&packing_fraction) {
            bail!("the packing fraction is {packing_fraction}; give 0 or more, below 1");
        }
        for depletant_radius in depletant_radii.iter().copied() {
            if !(0.0..=LARGEST_RADIUS).contains(&depletant_radius) {
                bail!(
                    "the radius of the depletants is {depletant_radius}; give 0 to {LARGEST_RADIUS}"
                );
            }
            let excess = -bodies.ln_free_volume_fraction(packing_fraction, depletant_radius);
            if !excess.is_finite() || (-excess).exp() == 0.0 {
                bail!(
                    "depletants of radius {depletant_radius} do not fit between these bodies at a packing fraction \
                     of {packing_fraction}; give smaller ones"
                );
            }
            rows.push(ScaledParticleRow {
                packing_fraction,
                depletant_radius,
                free_volume_fraction: (-excess).exp(),
                excess_chemical_potential_kt: excess,
            });
        }
    }
    Ok(ScaledParticles(rows))
}

/// Depletants are at most as large as their cubes are numbers.
const LARGEST_RADIUS: f64 = 1e50;

fn measures(file_or_name: &str, rounding_radius: f64) -> Result<BodyMeasures> {
    let named = || file_or_name.to_owned();
    let (dimension, measures) = match half_axes(file_or_name)? {
        Some(axes) => (axes.len(), measures_of_ellipsoid(&axes, rounding_radius)),
        None => {
            let shape = read_shape(file_or_name)?;
            (
                shape.dimension(),
                Measures::from_shape(&shape, rounding_radius),
            )
        }
    };
    let measures = measures.with_context(named)?;
    if dimension != 3 {
        bail!(
            "{file_or_name} is flat, and the theory is that of bodies in space; give a polyhedron"
        );
    }
    Ok(BodyMeasures {
        volume: measures.volume,
        surface: measures.surface,
        integrated_mean_curvature: measures.integrated_mean_curvature,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_free_in_what_the_bodies_leave_and_flat_shapes_are_refused() {
        let found = scaled_particles("cube", 0.1, &[0.0, 0.3], &[0.0, 0.2])
            .unwrap()
            .0;
        let fractions: Vec<f64> = found.iter().map(|row| row.free_volume_fraction).collect();
        assert_eq!(fractions[..2], [1.0, 1.0]);
        assert!(
            (fractions[2] - 0.7).abs() < 1e-15 && fractions[3] < 0.7,
            "{fractions:?}"
        );
        // To first order in the density a depletant is kept from the swept volume of each body.
        let thin = scaled_particles("cube", 0.1, &[1e-7], &[0.2]).unwrap().0[0]
            .excess_chemical_potential_kt;
        let shape = read_shape("cube").unwrap();
        let [body, swept] =
            [0.1, 0.3].map(|radius| Measures::from_shape(&shape, radius).unwrap().volume);
        assert!((thin / (1e-7 * swept / body) - 1.0).abs() < 1e-6, "{thin}");
        for (shape, packing_fraction, radius, words) in [
            ("polygon:4", 0.1, 0.1, "flat"),
            ("cube", 1.0, 0.1, "below 1"),
            ("cube", 0.1, f64::NAN, "radius"),
            ("cube", 0.999, 1e50, "smaller"),
        ] {
            let error = scaled_particles(shape, 0.0, &[packing_fraction], &[radius]).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
