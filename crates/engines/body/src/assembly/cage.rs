//! Cages: bodies in general positions of a cubic group, closed to contact.
//!
//! A group of order n makes n bodies of each site: the rotation g maps the position p and the
//! orientation R of the site to g p and g R.

use super::contact::from_outside;
use super::orbits::Orbit;
use super::placement::Placement;
use crate::{BodyError, Result};
use protomer_kernel::{Pose, Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

protomer_kernel::choices! {
    /// Group of the proper rotations of a regular polyhedron.
    pub enum CubicGroup {
        /// Rotations of the tetrahedron, T: 12 bodies of each kind.
        Tetrahedral = "tetrahedral",
        /// Rotations of the octahedron and the cube, O: 24 bodies of each kind.
        Octahedral = "octahedral",
        /// Rotations of the icosahedron and the dodecahedron, I: 60 bodies of each kind.
        Icosahedral = "icosahedral",
    }
}

impl CubicGroup {
    /// Number of the rotations.
    ///
    /// ```
    /// use protomer_body::assembly::CubicGroup;
    /// assert_eq!(CubicGroup::Icosahedral.order(), 60);
    /// ```
    pub fn order(self) -> usize {
        match self {
            Self::Tetrahedral => 12,
            Self::Octahedral => 24,
            Self::Icosahedral => 60,
        }
    }

    /// Rotations of the group, the identity first. A three-fold axis is along (1, 1, 1); T has two-fold axes and O
    /// four-fold axes along x, y and z, I has a five-fold axis along (0, 1, φ) with the golden ratio φ.
    ///
    /// ```
    /// use protomer_body::assembly::CubicGroup;
    /// let rotations = CubicGroup::Octahedral.rotations();
    /// assert!(rotations.len() == 24 && rotations[0].angle() == 0.0);
    /// ```
    pub fn rotations(self) -> &'static [Rotation] {
        // A search places millions of cages, and making the icosahedral group takes 3600 comparisons of rotations.
        static TETRAHEDRAL: LazyLock<Vec<Rotation>> =
            LazyLock::new(|| CubicGroup::Tetrahedral.generate());
        static OCTAHEDRAL: LazyLock<Vec<Rotation>> =
            LazyLock::new(|| CubicGroup::Octahedral.generate());
        static ICOSAHEDRAL: LazyLock<Vec<Rotation>> =
            LazyLock::new(|| CubicGroup::Icosahedral.generate());
        match self {
            Self::Tetrahedral => &TETRAHEDRAL,
            Self::Octahedral => &OCTAHEDRAL,
            Self::Icosahedral => &ICOSAHEDRAL,
        }
    }

    /// Products of two generators, until no new rotation appears.
    fn generate(self) -> Vec<Rotation> {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let turn = |axis: Vec3, angle: f64| Rotation::new(axis.normalize() * angle);
        let other = match self {
            Self::Tetrahedral => turn(Vec3::z(), PI),
            Self::Octahedral => turn(Vec3::z(), FRAC_PI_2),
            Self::Icosahedral => turn(Vec3::new(0.0, 1.0, golden), TAU / 5.0),
        };
        let generators = [turn(Vec3::new(1.0, 1.0, 1.0), TAU / 3.0), other];
        let mut group = vec![Rotation::identity()];
        let mut number = 0;
        while number < group.len() && group.len() < self.order() {
            for generator in &generators {
                let product = generator * group[number];
                if group.iter().all(|member| member.angle_to(&product) > 1e-3) {
                    group.push(product);
                }
            }
            number += 1;
        }
        group
    }
}

/// One site of a cage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CageSite {
    /// Index of the body in the caller's list.
    pub body: usize,
    /// Position, in units of the radius of the cage.
    pub position: Vec3,
    /// Orientation of the body.
    pub rotation: Rotation,
}

/// A cage: a body, or one of each kind, in a general position of a group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cage {
    /// The group.
    pub group: CubicGroup,
    /// The sites, of which the group makes the others.
    pub sites: Vec<CageSite>,
}

/// A cage brought to contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedCage {
    /// Bodies and poses: those of the first site, then those of the second, and so on.
    pub placements: Vec<Placement>,
    /// Bodies that the group maps onto each other.
    pub orbits: Vec<Orbit>,
    /// Distance of the bodies of the first site from the centre, Å.
    pub radius_angstrom: f64,
}

impl Cage {
    /// Bodies and poses at a radius, Å.
    ///
    /// ```
    /// use protomer_body::assembly::{Cage, CageSite, CubicGroup};
    /// use protomer_kernel::{Rotation, Vec3};
    /// let position = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    /// let sites = vec![CageSite { body: 0, position, rotation: Rotation::identity() }];
    /// let cage = Cage { group: CubicGroup::Octahedral, sites };
    /// let placements = cage.placements(50.0);
    /// assert_eq!(placements.len(), 24);
    /// assert!(placements.iter().all(|(_, pose)| (pose.position.norm() - 50.0).abs() < 1e-9));
    /// ```
    pub fn placements(&self, radius_angstrom: f64) -> Vec<Placement> {
        let rotations = self.group.rotations();
        let mut placements = Vec::with_capacity(self.sites.len() * rotations.len());
        for site in &self.sites {
            placements.extend(rotations.iter().map(|rotation| {
                let pose = Pose {
                    position: rotation * (site.position * radius_angstrom),
                    rotation: rotation * site.rotation,
                };
                (site.body, pose)
            }));
        }
        placements
    }

    /// The bodies that the group maps onto each other: those of a site.
    ///
    /// ```
    /// use protomer_body::assembly::{Cage, CageSite, CubicGroup};
    /// use protomer_kernel::{Rotation, Vec3};
    /// let site = |body| CageSite { body, position: Vec3::x(), rotation: Rotation::identity() };
    /// let cage = Cage { group: CubicGroup::Tetrahedral, sites: vec![site(0), site(1)] };
    /// let first: Vec<usize> = cage.orbits().iter().map(|orbit| orbit.representative).collect();
    /// assert_eq!(first, [0, 12]);
    /// ```
    pub fn orbits(&self) -> Vec<Orbit> {
        let bodies = self.group.order();
        let sites = 0..self.sites.len();
        let orbit = |site: usize| Orbit {
            representative: site * bodies,
            bodies,
        };
        sites.map(orbit).collect()
    }

    /// Shrinks the cage until bodies touch, to `tolerance_angstrom`, and opens it again until the nearest
    /// bodies are `gap_angstrom` further apart.
    ///
    /// ```
    /// use protomer_body::assembly::{Cage, CageSite, CubicGroup, Placement};
    /// use protomer_kernel::{Rotation, Vec3};
    /// let position = Vec3::new(1.0, 0.4, 0.2).normalize();
    /// let site = CageSite { body: 0, position, rotation: Rotation::identity() };
    /// let cage = Cage { group: CubicGroup::Tetrahedral, sites: vec![site] };
    /// let spheres_overlap = |a: &Placement, b: &Placement| (a.1.position - b.1.position).norm() < 2.0;
    /// let closed = cage.close(0.0, 1e-6, spheres_overlap)?;
    /// assert_eq!(closed.placements.len(), 12);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// [`BodyError::Invalid`] if bodies overlap at every radius, or the gap brings bodies that interlock
    /// into each other.
    pub fn close(
        &self,
        gap_angstrom: f64,
        tolerance_angstrom: f64,
        overlap: impl Fn(&Placement, &Placement) -> bool,
    ) -> Result<ClosedCage> {
        let invalid = |cause: String| BodyError::Invalid {
            cause,
            remedy: "try other positions".into(),
        };
        let orbits = self.orbits();
        let any_overlap = |radius: f64| {
            let placements = self.placements(radius);
            // Every body is the image of a representative.
            orbits.iter().any(|orbit| {
                let body = &placements[orbit.representative];
                let others = placements.iter().enumerate();
                others
                    .filter(|(other, _)| *other != orbit.representative)
                    .any(|(_, other)| overlap(body, other))
            })
        };
        let contact = from_outside(1.0, tolerance_angstrom, any_overlap)
            .ok_or_else(|| invalid("the bodies of the cage overlap at any radius".into()))?;
        let nearest = self.nearest(&orbits, contact);
        let radius = contact * (1.0 + gap_angstrom / nearest);
        if gap_angstrom > 0.0 && any_overlap(radius) {
            return Err(invalid(format!(
                "a gap of {gap_angstrom} Å brings bodies of the cage into each other"
            )));
        }
        let first = self.sites.first().map_or(1.0, |site| site.position.norm());
        Ok(ClosedCage {
            placements: self.placements(radius),
            orbits,
            radius_angstrom: first * radius,
        })
    }

    /// The least distance of two bodies' origins, Å.
    fn nearest(&self, orbits: &[Orbit], radius_angstrom: f64) -> f64 {
        let placements = self.placements(radius_angstrom);
        let mut nearest = f64::INFINITY;
        for orbit in orbits {
            let body = placements[orbit.representative].1.position;
            for (other, (_, pose)) in placements.iter().enumerate() {
                if other != orbit.representative {
                    nearest = nearest.min((pose.position - body).norm());
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::point_group::point_group;

    #[test]
    fn cages_have_the_point_group_that_they_are_made_of() {
        for (group, name) in [
            (CubicGroup::Tetrahedral, "T"),
            (CubicGroup::Octahedral, "O"),
            (CubicGroup::Icosahedral, "I"),
        ] {
            let site = |body, position: [f64; 3]| CageSite {
                body,
                position: Vec3::from(position).normalize(),
                rotation: Rotation::new(Vec3::new(0.4, -1.0, 0.2)),
            };
            let cage = Cage {
                group,
                sites: vec![site(0, [1.0, 0.3, 0.1]), site(1, [0.3, 0.2, 1.2])],
            };
            let spheres_overlap =
                |a: &Placement, b: &Placement| (a.1.position - b.1.position).norm() < 2.0;
            let closed = cage.close(0.25, 1e-9, spheres_overlap).unwrap();
            assert_eq!(closed.placements.len(), 2 * group.order());
            let found = point_group(&closed.placements, &[1.0, 1.0], 1e-6).unwrap();
            assert_eq!(found.name, name);
            let apart = cage.nearest(&closed.orbits, closed.radius_angstrom);
            assert!((apart - 2.25).abs() < 1e-8, "{apart}");
        }
    }
}
