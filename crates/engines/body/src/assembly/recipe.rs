//! Rings C_n and stacks D_n of given bodies, closed to contact.
//!
//! Position i of n in a ring has the azimuth 2πi/n. The local frame has z along the ring's axis and
//! x outward. A body there is turned by R_z(azimuth) R_x(tilt) [R_x(π) if it points down] R_z(spin)
//! F, where F turns the body's own frame so that z is the axis to align with that of the ring
//! ([`upright_frame`]). The second ring of a stack is above the first, its azimuths advanced by the
//! stagger.
//!
//! A half turn about an axis in the plane between two rings maps R_z(φ) R_x(t) to R_z(φ') R_x(t)
//! R_x(π): equal tilts and opposite directions make a stack dihedral, which is what
//! [`Recipe::dihedral`] does.

use super::contact::from_outside;
use super::placement::Placement;
use crate::{BodyError, Result};
use nalgebra::{Matrix3, Rotation3};
use protomer_kernel::{Pose, Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// One position of a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RecipeSite {
    /// Index of the body in the caller's list.
    pub body: usize,
    /// Whether the body's axis points along the ring's axis rather than against it.
    pub up: bool,
    /// Lean of the body's axis about the outward direction, radian.
    pub tilt_radian: f64,
    /// Turn of the body about its own axis, radian.
    pub spin_radian: f64,
}

impl RecipeSite {
    /// An upright body: no tilt, no spin.
    ///
    /// ```
    /// use protomer_body::assembly::RecipeSite;
    /// let leaning = RecipeSite { tilt_radian: 0.2, ..RecipeSite::upright(1) };
    /// assert!(leaning.up && leaning.body == 1 && leaning.spin_radian == 0.0);
    /// ```
    pub fn upright(body: usize) -> Self {
        Self {
            body,
            up: true,
            tilt_radian: 0.0,
            spin_radian: 0.0,
        }
    }

    /// The same position turned over by a half turn in the plane of the ring.
    fn turned_over(self) -> Self {
        Self {
            up: !self.up,
            ..self
        }
    }
}

/// A ring or a stack of rings of equal size.
///
/// ```
/// use protomer_body::assembly::{Recipe, RecipeSite};
/// let [a, b] = [0, 1].map(RecipeSite::upright);
/// let recipe = Recipe { stagger: 0.5, ..Recipe::dihedral(8, &[a, b]) };
/// assert_eq!((recipe.rings.len(), recipe.rings[0].len()), (2, 8));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Rings from bottom to top, each with its positions in order of azimuth.
    pub rings: Vec<Vec<RecipeSite>>,
    /// Azimuth of each ring relative to the one below, as a fraction of the angle between
    /// neighbours.
    pub stagger: f64,
    /// Distance by which neighbours around a ring stay apart beyond contact before the rings are brought
    /// together, Å.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub opening_angstrom: f64,
}

/// Whether a recipe leaves no opening; files of recipes without one do not name it.
#[allow(clippy::trivially_copy_pass_by_ref)] // serde gives a reference
fn is_zero(angstrom: &f64) -> bool {
    *angstrom == 0.0
}

/// A recipe brought to contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedAssembly {
    /// Bodies and poses, ring by ring.
    pub placements: Vec<Placement>,
    /// Distance of the bodies' origins from the axis, Å.
    pub radius_angstrom: f64,
    /// Distance between the planes of neighbouring rings, Å; zero for one ring.
    pub ring_distance_angstrom: f64,
    /// Tilt added to that of each position, radian.
    pub tilt_radian: f64,
}

impl Recipe {
    /// One ring of `members`, the pattern repeated around it.
    ///
    /// ```
    /// use protomer_body::assembly::{Recipe, RecipeSite};
    /// let recipe = Recipe::ring(4, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
    /// let bodies: Vec<usize> = recipe.rings[0].iter().map(|site| site.body).collect();
    /// assert_eq!(bodies, [0, 1, 0, 1]);
    /// ```
    pub fn ring(members: usize, pattern: &[RecipeSite]) -> Self {
        Self {
            rings: vec![pattern.iter().cycle().take(members).copied().collect()],
            stagger: 0.0,
            opening_angstrom: 0.0,
        }
    }

    /// A stack of two rings, mapped onto each other by half turns about axes between them: position
    /// i of the upper ring is position 1 - i of the lower, turned over. Where two bodies alternate,
    /// each is above one of the other kind.
    ///
    /// ```
    /// use protomer_body::assembly::{Recipe, RecipeSite};
    /// let recipe = Recipe::dihedral(4, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
    /// let upper: Vec<(usize, bool)> = recipe.rings[1].iter().map(|site| (site.body, site.up)).collect();
    /// assert_eq!(upper, [(1, false), (0, false), (1, false), (0, false)]);
    /// ```
    pub fn dihedral(members: usize, pattern: &[RecipeSite]) -> Self {
        let lower: Vec<RecipeSite> = pattern.iter().cycle().take(members).copied().collect();
        let upper = (0..lower.len())
            .map(|i| lower[(lower.len() + 1 - i) % lower.len()].turned_over())
            .collect();
        Self {
            rings: vec![lower, upper],
            stagger: 0.0,
            opening_angstrom: 0.0,
        }
    }

    /// The placements at a radius and a distance between rings, Å, with `tilt_radian` added to
    /// every tilt. `frames` has one rotation per body.
    ///
    /// ```
    /// use protomer_body::assembly::{Recipe, RecipeSite};
    /// use protomer_kernel::{Rotation, Vec3};
    /// let ring = Recipe::ring(4, &[RecipeSite::upright(0)]);
    /// let placements = ring.placements(&[Rotation::identity()], 10.0, 0.0, 0.0)?;
    /// let (body, pose) = placements[1];
    /// assert_eq!(body, 0);
    /// assert!((pose.position - Vec3::new(0.0, 10.0, 0.0)).norm() < 1e-12, "a quarter of the way round");
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for rings that are empty or differ in size, and for a body without a
    /// frame.
    pub fn placements(
        &self,
        frames: &[Rotation],
        radius_angstrom: f64,
        ring_distance_angstrom: f64,
        tilt_radian: f64,
    ) -> Result<Vec<Placement>> {
        self.check(frames)?;
        let middle = 0.5 * (self.rings.len() as f64 - 1.0);
        let mut placements = Vec::new();
        for (level, ring) in self.rings.iter().enumerate() {
            let height = (level as f64 - middle) * ring_distance_angstrom;
            for (i, site) in ring.iter().enumerate() {
                let azimuth = TAU * (i as f64 + self.stagger * level as f64) / ring.len() as f64;
                let rotation = orientation(site, azimuth, tilt_radian) * frames[site.body];
                let (sine, cosine) = azimuth.sin_cos();
                let position = Vec3::new(radius_angstrom * cosine, radius_angstrom * sine, height);
                placements.push((site.body, Pose { position, rotation }));
            }
        }
        Ok(placements)
    }

    /// Shrinks the radius until bodies of a ring touch, opens the ring by the opening of the recipe, and
    /// shrinks the distance between rings until rings touch, to `tolerance_angstrom`. The result is
    /// free of overlap.
    ///
    /// ```
    /// use protomer_body::assembly::{Placement, Recipe, RecipeSite};
    /// use protomer_kernel::Rotation;
    /// let spheres_overlap = |placements: &[Placement]| {
    ///     let place = |i: usize| placements[i].1.position;
    ///     (0..placements.len()).any(|i| (0..i).any(|j| (place(i) - place(j)).norm() < 2.0))
    /// };
    /// let ring = Recipe::ring(6, &[RecipeSite::upright(0)]);
    /// let closed = ring.close(&[Rotation::identity()], 0.0, 1e-9, spheres_overlap)?;
    /// assert!((closed.radius_angstrom - 2.0).abs() < 1e-8);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Recipe::placements`]; [`BodyError::Invalid`] if the bodies overlap at every
    /// distance.
    pub fn close(
        &self,
        frames: &[Rotation],
        tilt_radian: f64,
        tolerance_angstrom: f64,
        overlaps: impl Fn(&[Placement]) -> bool,
    ) -> Result<ClosedAssembly> {
        self.check(frames)?;
        let arrangement = |radius: f64, distance: f64| {
            self.placements(frames, radius, distance, tilt_radian)
                .unwrap_or_default()
        };
        let members = self.rings.first().map_or(1, Vec::len);
        let ring_overlaps = |radius: f64| arrangement(radius, 0.0).chunks(members).any(&overlaps);
        let radius = from_outside(1.0, tolerance_angstrom, ring_overlaps).ok_or_else(never_free)?;
        let radius = radius + self.opening_angstrom / self.distance_per_radius();
        let stack_overlaps = |distance: f64| overlaps(&arrangement(radius, distance));
        let distance = match self.rings.len() {
            1 => 0.0,
            _ => from_outside(1.0, tolerance_angstrom, stack_overlaps).ok_or_else(never_free)?,
        };
        Ok(ClosedAssembly {
            placements: arrangement(radius, distance),
            radius_angstrom: radius,
            ring_distance_angstrom: distance,
            tilt_radian,
        })
    }

    /// Closes the recipe to contact without tilt and then opens it: neighbours around a ring move
    /// `gap_angstrom` further apart (their distance is 2 r sin(π/n)), and so do the rings of a
    /// stack. The gaps between surfaces are at least about this large.
    ///
    /// ```
    /// use protomer_body::assembly::{Placement, Recipe, RecipeSite};
    /// use protomer_kernel::Rotation;
    /// let spheres_overlap = |placements: &[Placement]| {
    ///     let place = |i: usize| placements[i].1.position;
    ///     (0..placements.len()).any(|i| (0..i).any(|j| (place(i) - place(j)).norm() < 2.0))
    /// };
    /// let ring = Recipe::ring(6, &[RecipeSite::upright(0)]);
    /// let opened = ring.close_with_gap(&[Rotation::identity()], 0.5, 1e-9, spheres_overlap)?;
    /// assert!((opened.radius_angstrom - 2.5).abs() < 1e-8, "six neighbours are a radius apart");
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Recipe::close`]; [`BodyError::Invalid`] if the opened assembly overlaps.
    pub fn close_with_gap(
        &self,
        frames: &[Rotation],
        gap_angstrom: f64,
        tolerance_angstrom: f64,
        overlaps: impl Fn(&[Placement]) -> bool,
    ) -> Result<ClosedAssembly> {
        let mut closed = self.close(frames, 0.0, tolerance_angstrom, &overlaps)?;
        closed.radius_angstrom += gap_angstrom / self.distance_per_radius();
        if self.rings.len() > 1 {
            closed.ring_distance_angstrom += gap_angstrom;
        }
        closed.placements = self.placements(
            frames,
            closed.radius_angstrom,
            closed.ring_distance_angstrom,
            0.0,
        )?;
        if overlaps(&closed.placements) {
            return Err(BodyError::Invalid {
                cause: format!(
                    "a gap of {gap_angstrom} Å brings bodies of the recipe into each other"
                ),
                remedy: "try another gap".into(),
            });
        }
        Ok(closed)
    }

    /// Closes the recipe at each of the tilts and returns the most compact assembly: the smallest
    /// mean square distance of the bodies from the centre.
    ///
    /// # Errors
    /// Those of [`Recipe::close`]; [`BodyError::Invalid`] for an empty list of tilts.
    pub fn close_with_best_tilt(
        &self,
        frames: &[Rotation],
        tilts_radian: &[f64],
        tolerance_angstrom: f64,
        overlaps: impl Fn(&[Placement]) -> bool,
    ) -> Result<ClosedAssembly> {
        let mut best: Option<ClosedAssembly> = None;
        for &tilt in tilts_radian {
            let closed = self.close(frames, tilt, tolerance_angstrom, &overlaps)?;
            match &best {
                Some(best) if best.extent_angstrom2() <= closed.extent_angstrom2() => {}
                _ => best = Some(closed),
            }
        }
        best.ok_or_else(|| BodyError::Invalid {
            cause: "no tilt to try".into(),
            remedy: "give at least one".into(),
        })
    }

    /// Distance of neighbours around a ring over its radius, 2 sin(π/n); infinite for a single body,
    /// which has no neighbour.
    fn distance_per_radius(&self) -> f64 {
        match self.rings.first().map_or(1, Vec::len) {
            0 | 1 => f64::INFINITY,
            members => 2.0 * (PI / members as f64).sin(),
        }
    }

    fn check(&self, frames: &[Rotation]) -> Result<()> {
        let members = self.rings.first().map_or(0, Vec::len);
        if members == 0 || self.rings.iter().any(|ring| ring.len() != members) {
            return Err(BodyError::Invalid {
                cause: "a recipe needs rings of one size with at least one position".into(),
                remedy: "give each ring the same number of positions".into(),
            });
        }
        for site in self.rings.iter().flatten() {
            if site.body >= frames.len() {
                return Err(BodyError::Invalid {
                    cause: format!("the recipe names body {} of {}", site.body, frames.len()),
                    remedy: "give as many bodies as the recipe names".into(),
                });
            }
        }
        Ok(())
    }
}

impl ClosedAssembly {
    /// Mean square distance of the bodies from the centre, of one ring or two, Å².
    fn extent_angstrom2(&self) -> f64 {
        self.radius_angstrom.powi(2) + 0.25 * self.ring_distance_angstrom.powi(2)
    }
}

fn never_free() -> BodyError {
    BodyError::Invalid {
        cause: "the bodies of the recipe overlap at any distance".into(),
        remedy: "check the body meshes".into(),
    }
}

fn orientation(site: &RecipeSite, azimuth: f64, tilt_radian: f64) -> Rotation {
    let about = |axis: Vec3, angle: f64| Rotation::new(axis * angle);
    let turn_over = if site.up {
        Rotation::identity()
    } else {
        about(Vec3::x(), PI)
    };
    about(Vec3::z(), azimuth)
        * about(Vec3::x(), site.tilt_radian + tilt_radian)
        * turn_over
        * about(Vec3::z(), site.spin_radian)
}

/// The rotation that turns the longest principal axis of a set of points onto z and the shortest
/// onto x. Its sense along the axis is that in which the third moment is positive, so that it does
/// not depend on the input's orientation.
///
/// ```
/// use protomer_body::assembly::recipe::upright_frame;
/// use protomer_kernel::Vec3;
/// let rod = [-3.0, -1.0, 0.0, 1.0, 5.0].map(|x| Vec3::new(x, 0.0, 0.0));
/// assert!((upright_frame(&rod) * Vec3::x() - Vec3::z()).norm() < 1e-9);
/// ```
pub fn upright_frame(points: &[Vec3]) -> Rotation {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let arms: Vec<Vec3> = points.iter().map(|point| point - mean).collect();
    let mut covariance = Matrix3::zeros();
    for arm in &arms {
        covariance += arm * arm.transpose();
    }
    if !covariance.iter().all(|x| x.is_finite()) {
        return Rotation::identity();
    }
    let eigen = covariance.symmetric_eigen();
    let z = oriented(
        eigen.eigenvectors.column(eigen.eigenvalues.imax()).into(),
        &arms,
    );
    let x = oriented(
        eigen.eigenvectors.column(eigen.eigenvalues.imin()).into(),
        &arms,
    );
    let y = z.cross(&x);
    if y.norm() < 0.5 {
        return Rotation::identity();
    }
    let matrix = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
    Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// The axis in the sense in which the third moment of the arms is positive.
fn oriented(axis: Vec3, arms: &[Vec3]) -> Vec3 {
    let third: f64 = arms.iter().map(|arm| arm.dot(&axis).powi(3)).sum();
    if third < 0.0 { -axis } else { axis }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spheres_overlap(placements: &[Placement]) -> bool {
        let pairs = placements
            .iter()
            .enumerate()
            .flat_map(|(i, a)| placements[..i].iter().map(move |b| (a, b)));
        pairs
            .into_iter()
            .any(|(a, b)| (a.1.position - b.1.position).norm() < 2.0)
    }

    #[test]
    fn a_ring_of_spheres_closes_at_the_polygon_radius() {
        let closed = Recipe::ring(8, &[RecipeSite::upright(0)])
            .close(&[Rotation::identity()], 0.0, 1e-9, spheres_overlap)
            .unwrap();
        assert!((closed.radius_angstrom - 1.0 / (PI / 8.0).sin()).abs() < 1e-8);
        assert_eq!(
            (closed.placements.len(), closed.ring_distance_angstrom),
            (8, 0.0)
        );
    }

    #[test]
    fn a_stack_of_spheres_closes_at_two_radii() {
        let recipe = Recipe::dihedral(8, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
        let closed = recipe
            .close(&[Rotation::identity(); 2], 0.0, 1e-9, spheres_overlap)
            .unwrap();
        assert!((closed.ring_distance_angstrom - 2.0).abs() < 1e-8);
        // Where two bodies alternate, each is above one of the other kind.
        assert!((0..8).all(|i| closed.placements[i].0 != closed.placements[i + 8].0));
    }

    /// The half turns between the rings map the stack onto itself, with its tilts, spins, directions
    /// and frames.
    #[test]
    fn a_dihedral_recipe_is_dihedral() {
        let site = |body, up, tilt_radian, spin_radian| RecipeSite {
            body,
            up,
            tilt_radian,
            spin_radian,
        };
        let recipe = Recipe {
            stagger: 0.3,
            ..Recipe::dihedral(6, &[site(0, true, 0.4, 0.2), site(1, false, -0.7, 1.0)])
        };
        let frames = [
            Rotation::new(Vec3::new(0.3, 0.2, -0.5)),
            Rotation::new(Vec3::new(-1.3, 0.2, 0.5)),
        ];
        let placements = recipe.placements(&frames, 10.0, 7.0, 0.1).unwrap();
        // The axis lies half-way between position 0 below and position 1 above.
        let alpha = 0.5 * TAU * 1.3 / 6.0;
        let half_turn = Rotation::new(Vec3::new(alpha.cos(), alpha.sin(), 0.0) * PI);
        let turn = Rotation::new(Vec3::z() * (2.0 * TAU / 6.0));
        for operation in [half_turn, turn] {
            for (body, pose) in &placements {
                let image = pose.then(&Pose {
                    position: Vec3::zeros(),
                    rotation: operation,
                });
                let matches = placements.iter().filter(|(other, candidate)| {
                    other == body
                        && (candidate.position - image.position).norm() < 1e-9
                        && candidate.rotation.angle_to(&image.rotation) < 1e-6
                });
                assert_eq!(matches.count(), 1);
            }
        }
    }

    #[test]
    fn the_best_tilt_is_the_most_compact() {
        let rods_overlap = |placements: &[Placement]| {
            let points: Vec<Vec<Vec3>> = placements
                .iter()
                .map(|(_, pose)| {
                    (-4..=4)
                        .map(|k| pose.transform_point(&Vec3::new(0.0, 0.0, f64::from(k))))
                        .collect()
                })
                .collect();
            (0..points.len()).any(|i| {
                (0..i).any(|j| {
                    points[i]
                        .iter()
                        .any(|a| points[j].iter().any(|b| (a - b).norm() < 2.0))
                })
            })
        };
        let recipe = Recipe::ring(5, &[RecipeSite::upright(0)]);
        let best = recipe
            .close_with_best_tilt(
                &[Rotation::identity()],
                &[0.0, PI / 2.0],
                1e-6,
                rods_overlap,
            )
            .unwrap();
        assert_eq!(best.tilt_radian, 0.0);
    }

    #[test]
    fn a_long_body_stands_up() {
        let points =
            [0.0, 1.0, 2.0, 5.0].map(|t| Vec3::new(3.0 * t, 4.0 * t, (t * 7.0).sin() * 0.1));
        let frame = upright_frame(&points);
        assert!(((frame * Vec3::new(0.6, 0.8, 0.0)).z - 1.0).abs() < 1e-2);
    }

    #[test]
    fn recipes_that_make_no_sense_are_refused() {
        let site = RecipeSite::upright(3);
        assert!(
            Recipe::ring(4, &[site])
                .close(&[Rotation::identity()], 0.0, 1e-6, spheres_overlap)
                .is_err()
        );
        assert!(
            Recipe::ring(0, &[site])
                .close(&[Rotation::identity()], 0.0, 1e-6, spheres_overlap)
                .is_err()
        );
        let endless = Recipe::ring(2, &[RecipeSite::upright(0)]).close(
            &[Rotation::identity()],
            0.0,
            1e-6,
            |_| true,
        );
        assert!(endless.is_err());
    }
}
