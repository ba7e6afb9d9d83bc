//! Virial coefficients of hard bodies, alone and among depletants.

use super::half_axes;
use crate::hard_bodies::start::BodyShape;
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::virial::{DepletedPair, Estimate, Triples, draw_triple};
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::statistics::RunningMoments;
use rayon::prelude::*;
use serde::Serialize;

/// Smallest number of rays or triples; fewer have no meaningful error.
const FEWEST: u64 = 10;

/// Settings for virial coefficients. Lengths are in the unit of the shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct VirialSettings {
    /// File or name of the first shape; pieces of a concave one are joined by `+`.
    pub first: String,
    /// File or name of another shape; `None` for two bodies of the first.
    pub second: Option<String>,
    /// Radius of the ball that rounds the first shape.
    pub rounding: f64,
    /// Radius of the ball that rounds the second shape.
    pub second_rounding: f64,
    /// Triples for the third coefficient of the first; zero to leave it out.
    pub triples: u64,
    /// Penetrable hard spheres, or disks, in equilibrium with a reservoir.
    pub depletants: Vec<Depletant>,
    /// Rays for the coefficient among depletants.
    pub rays: u64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Virial coefficients. Lengths are in the unit of the shapes; keys that end in `_error` are standard errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VirialReport {
    /// File or name of the first shape.
    pub first: String,
    /// File or name of the second shape; the first again if there is none.
    pub second: String,
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Second virial coefficient of the pair, half its mean excluded volume; of different bodies B12.
    pub b2: f64,
    /// Standard error of B2; zero where it is known exactly.
    pub b2_error: f64,
    /// B2 over the volume, of equal bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b2_over_volume: Option<f64>,
    /// Second virial coefficients of the first body alone and of the second alone, of different bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b2_alone: Option<[f64; 2]>,
    /// Third virial coefficient, if it was wanted.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub third: Option<ThirdVirial>,
    /// Second virial coefficient among depletants, if there are any.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub osmotic: Option<OsmoticVirial>,
}

/// The third virial coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThirdVirial {
    /// Third virial coefficient.
    pub b3: f64,
    /// Standard error of B3.
    pub b3_error: f64,
    /// B3 over the square of B2.
    pub b3_over_b2_squared: f64,
    /// Standard error of B3 over the square of B2.
    pub b3_over_b2_squared_error: f64,
}

/// The second virial coefficient among depletants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OsmoticVirial {
    /// Second virial coefficient of the bodies in the reservoir.
    pub osmotic_b2: f64,
    /// Standard error of the coefficient.
    pub osmotic_b2_error: f64,
}

impl Answer for VirialReport {
    fn text(&self) -> String {
        let mut lines = vec![match &self.b2_alone {
            None => format!(
                "{}: hard bodies in {} dimensions",
                self.first, self.dimension
            ),
            Some(_) => {
                let dimension = self.dimension;
                format!(
                    "{} and {}: hard bodies in {dimension} dimensions",
                    self.first, self.second
                )
            }
        }];
        let exact = |value: f64, error: f64| match error {
            0.0 => format!("{value:.12}"),
            error => format!("{value:.6} ± {error:.6}"),
        };
        let b2 = exact(self.b2, self.b2_error);
        match (self.b2_over_volume, self.b2_alone) {
            (Some(over_volume), _) => {
                let volumes = if self.dimension == 2 {
                    "areas"
                } else {
                    "volumes"
                };
                lines.push(format!("B2 {b2}, {over_volume:.6} {volumes}"));
            }
            (None, Some([first, second])) => {
                lines.push(format!(
                    "B12 {b2}; B2 of each alone {first:.12} and {second:.12}"
                ));
            }
            (None, None) => lines.push(format!("B2 {b2}")),
        }
        if let Some(third) = &self.third {
            lines.push(format!(
                "B3 {}, {} of B2²",
                exact(third.b3, third.b3_error),
                exact(third.b3_over_b2_squared, third.b3_over_b2_squared_error)
            ));
        }
        if let Some(osmotic) = &self.osmotic {
            let value = exact(osmotic.osmotic_b2, osmotic.osmotic_b2_error);
            lines.push(format!("among the depletants {value}"));
        }
        lines.join("\n")
    }
}

/// Finds virial coefficients: the second of convex bodies exactly, that of concave ones and the third by sampling,
/// the one among depletants by an integral over rays.
///
/// # Errors
/// For shapes that cannot be read or have different dimensions, a third coefficient of two shapes, depletants of
/// concave bodies and ellipsoids, rounded ellipsoids in triples, and numbers that make no sense.
///
/// ```
/// use protomer_shape_verbs::shapes::virial::{VirialSettings, virial_coefficients};
/// let found = virial_coefficients(&VirialSettings {
///     first: "cube".into(),
///     second: Some("tetrahedron".into()),
///     ..VirialSettings::default()
/// })?;
/// let [cube, tetrahedron] = found.b2_alone.unwrap();
/// assert!(found.b2 < cube && found.b2 > tetrahedron);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn virial_coefficients(settings: &VirialSettings) -> Result<VirialReport> {
    if settings.second.is_some() && settings.triples > 0 {
        bail!("the third coefficient is that of one shape; leave out the second, or the triples");
    }
    if settings.second.is_none() && settings.second_rounding != 0.0 {
        bail!("there is no second shape to round; name it, or leave its rounding out");
    }
    for (quantity, count) in [("triples", settings.triples), ("rays", settings.rays)] {
        // No triples at all means that none are wanted; a few give a mean without an error.
        if (1..FEWEST).contains(&count) {
            bail!("{count} {quantity} are too few for an error; give at least {FEWEST}");
        }
    }
    let first = Member::read(&settings.first, settings.rounding)?;
    match &settings.second {
        None => first.with_itself(settings),
        Some(name) => {
            let second = Member::read(name, settings.second_rounding)?;
            first.with_another(&second, settings)
        }
    }
}

impl Default for VirialSettings {
    fn default() -> Self {
        Self {
            first: String::new(),
            second: None,
            rounding: 0.0,
            second_rounding: 0.0,
            triples: 0,
            depletants: Vec::new(),
            rays: 300,
            seed: 1,
        }
    }
}

/// A body of a pair.
struct Member {
    name: String,
    rounding: f64,
    dimension: usize,
    form: Form,
}

enum Form {
    Ellipsoid(Measures),
    Convex(Shape, Measures),
    Pieces(BodyShape),
}

impl Member {
    fn read(name: &str, rounding: f64) -> Result<Self> {
        let named = || name.to_owned();
        if let Some(axes) = half_axes(name)? {
            return Ok(Self {
                name: named(),
                rounding,
                dimension: axes.len(),
                form: Form::Ellipsoid(measures_of_ellipsoid(&axes, rounding).with_context(named)?),
            });
        }
        let body = match BodyShape::read(name)? {
            BodyShape::Rod(_) => bail!(
                "{name}: rods on a line have B2 of their length; give a shape in a plane or in space"
            ),
            body => body,
        };
        let dimension = body.dimension();
        let form = match body {
            BodyShape::Shape(shape) => {
                let measures = Measures::from_shape(&shape, rounding).with_context(named)?;
                Form::Convex(shape, measures)
            }
            pieces => Form::Pieces(pieces),
        };
        Ok(Self {
            name: named(),
            rounding,
            dimension,
            form,
        })
    }

    fn measures(&self) -> Option<&Measures> {
        match &self.form {
            Form::Ellipsoid(measures) | Form::Convex(_, measures) => Some(measures),
            Form::Pieces(_) => None,
        }
    }

    fn convex(&self) -> Result<&Shape> {
        match &self.form {
            Form::Convex(shape, _) => Ok(shape),
            _ => bail!(
                "{}: depletants act between polygons, polyhedra and balls, rounded or not; leave them out",
                self.name
            ),
        }
    }

    fn with_itself(&self, settings: &VirialSettings) -> Result<VirialReport> {
        let sampled = match (&self.form, settings.triples) {
            (Form::Pieces(_), 0) => bail!(
                "{}: B2 of a concave body is sampled; add --triples 100000",
                self.name
            ),
            (_, 0) => None,
            (Form::Pieces(pieces), count) => Some(self.sample(pieces, count, settings.seed)?),
            (_, count) => {
                let body = BodyShape::read(&self.name)?;
                Some(self.sample(&body, count, settings.seed)?)
            }
        };
        let (b2, volume) = match (self.measures(), &sampled) {
            (Some(measures), _) => (
                Estimate {
                    mean: measures.b2,
                    error: 0.0,
                },
                measures.volume,
            ),
            (None, Some(sampled)) => (sampled.b2, sampled.volume),
            (None, None) => bail!("{}: nothing was sampled", self.name),
        };
        Ok(VirialReport {
            first: self.name.clone(),
            second: self.name.clone(),
            dimension: self.dimension,
            b2: b2.mean,
            b2_error: b2.error,
            b2_over_volume: Some(b2.mean / volume),
            b2_alone: None,
            third: sampled.map(|sampled| third(b2, sampled.b3_over_b2_squared)),
            osmotic: self.osmotic(self, b2.mean, settings)?,
        })
    }

    fn with_another(&self, other: &Self, settings: &VirialSettings) -> Result<VirialReport> {
        if self.dimension != other.dimension {
            bail!(
                "{} has {} dimensions and {} has {}; give shapes of one dimension",
                self.name,
                self.dimension,
                other.name,
                other.dimension
            );
        }
        let (Some(measures), Some(others)) = (self.measures(), other.measures()) else {
            bail!(
                "{} and {}: B12 is that of convex bodies; give one file each",
                self.name,
                other.name
            );
        };
        let b2 = measures.mixed_b2(others, self.dimension);
        Ok(VirialReport {
            first: self.name.clone(),
            second: other.name.clone(),
            dimension: self.dimension,
            b2,
            b2_error: 0.0,
            b2_over_volume: None,
            b2_alone: Some([measures.b2, others.b2]),
            third: None,
            osmotic: self.osmotic(other, b2, settings)?,
        })
    }

    fn sample(&self, body: &BodyShape, count: u64, seed: u64) -> Result<Sampled> {
        match self.dimension {
            2 => sample(&body.body::<2>(self.rounding)?, count, seed),
            _ => sample(&body.body::<3>(self.rounding)?, count, seed),
        }
        .with_context(|| self.name.clone())
    }

    fn osmotic(
        &self,
        other: &Self,
        hard: f64,
        settings: &VirialSettings,
    ) -> Result<Option<OsmoticVirial>> {
        if settings.depletants.is_empty() {
            return Ok(None);
        }
        if settings.rays == 0 {
            bail!("the coefficient among depletants needs rays; give at least {FEWEST}");
        }
        // The integral over rays needs support functions, which only convex shapes have.
        let shapes = [self.convex()?, other.convex()?];
        let roundings = [self.rounding, other.rounding];
        let pair = DepletedPair::new(shapes, roundings, &settings.depletants)?;
        // Each ray has its own stream of random numbers, so threads do not matter.
        let on_ray = |number| pair.on_ray(settings.seed, number);
        let gains: Vec<f64> = (0..settings.rays)
            .into_par_iter()
            .map(on_ray)
            .collect::<Result<_, _>>()?;
        let gain: RunningMoments = gains.into_iter().collect();
        // Depletants so strong that the weight overflows: no number of rays helps.
        if !gain.mean().is_finite() {
            bail!(
                "the depletants hold two bodies together by more than numbers can tell; give a lower fugacity"
            );
        }
        Ok(Some(OsmoticVirial {
            // Depletants attract: they lower the coefficient of the hard bodies.
            osmotic_b2: hard - gain.mean(),
            osmotic_b2_error: gain.independent_standard_error(),
        }))
    }
}

/// Results of triples of one body.
struct Sampled {
    volume: f64,
    b2: Estimate,
    b3_over_b2_squared: Estimate,
}

fn sample<const D: usize>(body: &HardBody<D>, count: u64, seed: u64) -> Result<Sampled> {
    let triples = (0..count)
        .into_par_iter()
        .map(|number| draw_triple(body, seed, number))
        .try_fold(Triples::default, |triples, triple| {
            triple.map(|triple| triples.with(triple))
        })
        // Sums of counts: their order does not matter, unlike that of floating-point numbers.
        .try_reduce(Triples::default, |a, b| Ok(a.merge(b)))?;
    let coefficients = triples.virials(body);
    Ok(Sampled {
        volume: body.volume,
        b2: coefficients.b2,
        b3_over_b2_squared: coefficients.b3_over_b2_squared,
    })
}

/// B3 = ratio B2², with the errors of both.
///
/// They are independent, though both may come from the same triples: B2 is that of the number of draws,
/// the ratio that of the places that were accepted, and in rejection sampling the number of draws says
/// nothing about the place that ends them.
fn third(b2: Estimate, ratio: Estimate) -> ThirdVirial {
    let square = b2.mean * b2.mean;
    ThirdVirial {
        b3: ratio.mean * square,
        // Absolute, not relative, errors: the ratio may be zero.
        b3_error: (square * ratio.error).hypot(2.0 * ratio.mean * b2.mean * b2.error),
        b3_over_b2_squared: ratio.mean,
        b3_over_b2_squared_error: ratio.error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn settings(first: &str, second: Option<&str>) -> VirialSettings {
        VirialSettings {
            first: first.into(),
            second: second.map(str::to_owned),
            ..VirialSettings::default()
        }
    }

    /// Balls as ellipsoids have B3 = 5/8 B2².
    #[test]
    fn triples_of_ellipsoids_are_those_of_balls() {
        let found = virial_coefficients(&VirialSettings {
            triples: 20_000,
            ..settings("ellipsoid:0.5,0.5,0.5", None)
        });
        let third = found.unwrap().third.unwrap();
        let (ratio, error) = (third.b3_over_b2_squared, third.b3_over_b2_squared_error);
        assert!(
            (ratio - 0.625).abs() < 4.0 * error && error < 0.01,
            "{ratio} ± {error}"
        );
    }

    #[test]
    fn the_error_of_the_third_coefficient_is_that_of_a_product() {
        let estimate = |mean, error| Estimate { mean, error };
        // 0.01/0.2 and twice 0.1/4 of 0.2 · 16, both 0.05.
        let found = third(estimate(4.0, 0.1), estimate(0.2, 0.01));
        assert!((found.b3 - 3.2).abs() < 1e-12);
        assert!((found.b3_error - 3.2 * 0.05 * 2.0_f64.sqrt()).abs() < 1e-12);
        let none = third(estimate(4.0, 0.1), estimate(0.0, 0.01));
        assert_eq!((none.b3, none.b3_error), (0.0, 0.16));
    }

    fn complaint(settings: VirialSettings) -> String {
        format!("{:#}", virial_coefficients(&settings).unwrap_err())
    }

    #[test]
    fn mixed_coefficients_are_those_of_balls_and_of_one_shape_with_itself() {
        let folder = tempfile::tempdir().unwrap();
        let point = folder.path().join("point.txt").display().to_string();
        std::fs::write(&point, "1 2 3\n").unwrap();
        let found = virial_coefficients(&VirialSettings {
            rounding: 0.5,
            second_rounding: 1.5,
            ..settings(&point, Some(&point))
        });
        // Half of the ball of the sum of the radii.
        assert!((found.unwrap().b2 - 2.0 * PI / 3.0 * 8.0).abs() < 1e-12);
        for name in ["cube", "polygon:5", "ellipsoid:1,2,3", "ellipse:1,2"] {
            let alone = virial_coefficients(&settings(name, None)).unwrap();
            let mixed = virial_coefficients(&settings(name, Some(name))).unwrap();
            assert!((alone.b2 / mixed.b2 - 1.0).abs() < 1e-14, "{name}");
        }
    }

    #[test]
    fn numbers_do_not_depend_on_the_threads() {
        let asked = VirialSettings {
            triples: 500,
            depletants: vec![Depletant {
                radius: 0.1,
                fugacity: 20.0,
            }],
            rays: 10,
            ..settings("tetrahedron", None)
        };
        let pool = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
        };
        let [one, three] =
            [1, 3].map(|threads| pool(threads).install(|| virial_coefficients(&asked).unwrap()));
        assert_eq!(one, three);
        assert!(one.osmotic.unwrap().osmotic_b2 < one.b2);
    }

    #[test]
    fn what_has_no_answer_says_so() {
        let with_triples = |name: &str, second| VirialSettings {
            triples: 100,
            ..settings(name, second)
        };
        for (asked, words) in [
            (settings("cube", Some("polygon:4")), "one dimension"),
            (with_triples("cube", Some("cube")), "leave out the second"),
            (settings("rod:1", None), "rods on a line"),
            (
                VirialSettings {
                    second_rounding: 1.0,
                    ..settings("cube", None)
                },
                "no second shape",
            ),
            (
                VirialSettings {
                    triples: 3,
                    ..settings("cube", None)
                },
                "too few",
            ),
            (
                VirialSettings {
                    depletants: vec![Depletant {
                        radius: 0.1,
                        fugacity: 1e9,
                    }],
                    rays: 10,
                    ..settings("cube", None)
                },
                "lower fugacity",
            ),
        ] {
            let said = complaint(asked);
            assert!(said.contains(words), "{said}");
        }
    }
}
