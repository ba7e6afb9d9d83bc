//! A kind of rigid body: its convex parts about the centre of mass, its mass and its moments of
//! inertia.
//!
//! | module | one idea |
//! |---|---|
//! | [`part`] | a convex part: a polytope, a ball or an ellipsoid, rounded or not |
//! | `moments` | volume, centroid and second moments of a part |
//!
//! The density is one. A body in space is turned so that its axes are the principal axes of inertia.
//! Disks, balls and ellipsoids have no faces. A concave body is a rigid union of convex parts, which
//! may touch and must not overlap; each part counts with the ball that fits into it. So every test
//! stays one of convex bodies.

mod moments;
pub mod part;

use crate::{Error, Result};
use moments::Moments;
use nalgebra::{Matrix3, SymmetricEigen};
use part::Part;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::PI;

/// Size of products of inertia that are taken for rounding, as a part of the moments.
const ALONG_THE_AXES: f64 = 1e-10;
/// Relative difference below which moments are equal.
const EQUAL_MOMENTS: f64 = 1e-12;
/// Overlap below which the parts of a union only touch, as a part of their size.
const TOUCHING: f64 = 1e-6;

/// The parts, mass and moments of bodies of one kind.
///
/// ```
/// use protomer_kernel::shape::{builders, polytope::Polytope};
/// use protomer_md::body::Kind;
/// let cube = Kind::from_polytope(&Polytope::from_shape(&builders::by_name("cube")?)?)?;
/// assert!((cube.mass - 1.0).abs() < 1e-12);
/// assert!((cube.moments.x - 1.0 / 6.0).abs() < 1e-12);
/// let disk = Kind::ball(2, 0.5)?;
/// assert!((disk.mass - std::f64::consts::PI / 4.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// The convex parts; most bodies have one.
    pub parts: Vec<Part>,
    /// Mass: the area or the volume.
    pub mass: f64,
    /// Moments of inertia about the axes of the body; in a plane the last is that about the normal.
    pub moments: Vec3,
    /// Turn from the frame of the shape, as its file has it, to the axes of the body.
    pub frame: Rotation,
    is_fixed: bool,
    pub(crate) inradius: f64,
    pub(crate) circumradius: f64,
}

impl Kind {
    /// A polygon or a polyhedron of density one.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// use protomer_md::body::Kind;
    /// let cuboid = Kind::from_polytope(&Polytope::from_shape(&by_name("cuboid:1,2,3")?)?)?;
    /// assert!((cuboid.mass - 6.0).abs() < 1e-12 && cuboid.turns() == 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoVolume`] for a shape without area or volume.
    pub fn from_polytope(polytope: &Polytope) -> Result<Self> {
        Self::rounded(polytope, 0.0)
    }

    /// A polygon or a polyhedron with a layer: its Minkowski sum with a disk or a ball.
    ///
    /// # Errors
    /// As [`Kind::from_polytope`], and [`Error::OutOfRange`] for a negative radius.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders, polytope::Polytope};
    /// use protomer_md::body::Kind;
    /// let cube = Polytope::from_shape(&builders::by_name("cube")?)?;
    /// let rounded = Kind::rounded(&cube, 0.1)?;
    /// let expected = 1.0 + 0.6 + 0.03 * std::f64::consts::PI * (1.0 + 0.4 / 9.0);
    /// assert!((rounded.mass - expected).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rounded(polytope: &Polytope, radius: f64) -> Result<Self> {
        Self::union(&[(polytope.clone(), Vec3::zeros())], radius)
    }

    /// A body of convex parts that move as one, each with the place of its centroid. All are
    /// rounded by the same radius.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// use protomer_md::body::Kind;
    /// let cube = Polytope::from_shape(&by_name("cube")?)?;
    /// let domino = Kind::union(&[(cube.clone(), Vec3::zeros()), (cube.clone(), Vec3::x())], 0.0)?;
    /// assert!((domino.mass - 2.0).abs() < 1e-12);
    /// let overlapping = [(cube.clone(), Vec3::zeros()), (cube, 0.5 * Vec3::x())];
    /// assert!(Kind::union(&overlapping, 0.0).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Kind::rounded`]; [`Error::MixedDimensions`] for parts in a plane and in space, and
    /// [`Error::OverlappingParts`] for parts whose volume would count twice.
    pub fn union(parts: &[(Polytope, Vec3)], radius: f64) -> Result<Self> {
        if !(radius.is_finite() && radius >= 0.0) {
            return Err(Error::OutOfRange {
                what: "the radius by which a body is rounded",
                value: radius,
                expected: "a number that is not negative",
            });
        }
        let dimension = parts.first().map_or(3, |(polytope, _)| polytope.dimension);
        if parts
            .iter()
            .any(|(polytope, _)| polytope.dimension != dimension)
        {
            return Err(Error::MixedDimensions);
        }
        check_apart(parts, radius)?;
        let mut total: Option<Moments> = None;
        for (polytope, place) in parts {
            // Seen from the origin of the union: the part is at `place`.
            let part_moments = Moments::from_polytope(polytope, radius).seen_from(&-place);
            match &mut total {
                Some(total) => total.add(&part_moments),
                None => total = Some(part_moments),
            }
        }
        let total = total.ok_or(Error::NoVolume)?;
        if !(total.volume.is_finite() && total.volume > 0.0) {
            return Err(Error::NoVolume);
        }
        let centroid = total.centroid();
        // About the centre of mass, where translation and rotation separate.
        let inertia = total.seen_from(&centroid).inertia();
        let (moments, axes) = match dimension {
            2 => (Vec3::repeat(inertia[(2, 2)]), Matrix3::identity()),
            _ => principal(&inertia),
        };
        let placed = parts.iter().map(|(polytope, place)| {
            let (polytope, place) = about_layer(polytope, *place, radius, parts.len());
            let centre = axes.transpose() * (place - centroid);
            // One part has its centre of mass at its origin to the last bit.
            let centre = if parts.len() == 1 {
                Vec3::zeros()
            } else {
                centre
            };
            Part::faceted(turned(&polytope, &axes), radius, centre)
        });
        Ok(Self {
            frame: Rotation::from_matrix(&axes.transpose()),
            ..Self::made(dimension, placed.collect(), total.volume, moments)
        })
    }

    /// A disk (dimension 2) or a ball (dimension 3) of density one.
    ///
    /// ```
    /// use protomer_md::body::Kind;
    /// let ball = Kind::ball(3, 2.0)?;
    /// assert!(ball.is_ball() && ball.inradius() == 2.0 && ball.circumradius() == 2.0);
    /// assert!((ball.moments.x / ball.mass - 0.4 * 4.0).abs() < 1e-12);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoVolume`] unless the radius is positive.
    pub fn ball(dimension: usize, radius: f64) -> Result<Self> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(Error::NoVolume);
        }
        let square = radius * radius;
        let (mass, moment) = match dimension {
            2 => (PI * square, 0.5 * PI * square * square),
            _ => (
                4.0 / 3.0 * PI * square * radius,
                8.0 / 15.0 * PI * square * square * radius,
            ),
        };
        let part = Part::ball(dimension, radius);
        Ok(Self::made(
            dimension,
            vec![part],
            mass,
            Vec3::repeat(moment),
        ))
    }

    /// An ellipse (dimension 2, whose third half axis plays no part) or an ellipsoid of density one.
    ///
    /// # Errors
    /// [`Error::NoVolume`] unless the half axes are positive.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// let prolate = Kind::ellipsoid(3, Vec3::new(1.0, 1.0, 2.0))?;
    /// assert!((prolate.moments.z / prolate.mass - 0.4).abs() < 1e-12);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn ellipsoid(dimension: usize, half_axes: Vec3) -> Result<Self> {
        let axes = &half_axes.as_slice()[..dimension];
        if !axes.iter().all(|axis| axis.is_finite() && *axis > 0.0) {
            return Err(Error::NoVolume);
        }
        let product: f64 = axes.iter().product();
        let squares = half_axes.component_mul(&half_axes);
        let (mass, moments) = match dimension {
            2 => {
                let mass = PI * product;
                (mass, Vec3::repeat(0.25 * mass * (squares.x + squares.y)))
            }
            _ => {
                let mass = 4.0 / 3.0 * PI * product;
                let sum = squares.sum();
                (mass, squares.map(|square| 0.2 * mass * (sum - square)))
            }
        };
        let part = Part::ellipsoid(dimension, half_axes);
        Ok(Self::made(dimension, vec![part], mass, moments))
    }

    fn made(dimension: usize, parts: Vec<Part>, mass: f64, moments: Vec3) -> Self {
        let inradii = parts.iter().map(|part| part.inradius);
        let outer = parts
            .iter()
            .map(|part| part.centre.norm() + part.circumradius);
        Self {
            dimension,
            inradius: inradii.fold(f64::INFINITY, f64::min),
            circumradius: outer.fold(0.0, f64::max),
            parts,
            mass,
            moments,
            frame: Rotation::identity(),
            is_fixed: false,
        }
    }

    /// The same shape with all lengths multiplied by a factor; the density stays one.
    ///
    /// ```
    /// use protomer_md::body::Kind;
    /// let disk = Kind::ball(2, 1.0)?;
    /// let larger = disk.scaled(3.0)?;
    /// assert!((larger.mass / disk.mass - 9.0).abs() < 1e-12);
    /// assert!((larger.moments.z / disk.moments.z - 81.0).abs() < 1e-9);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoVolume`] unless the factor is positive.
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(Error::NoVolume);
        }
        let dimension = self.dimension as i32;
        let parts = self.parts.iter().map(|part| part.scaled(factor)).collect();
        let mass = self.mass * factor.powi(dimension);
        let moments = self.moments * factor.powi(dimension + 2);
        Ok(Self {
            frame: self.frame,
            is_fixed: self.is_fixed,
            ..Self::made(self.dimension, parts, mass, moments)
        })
    }

    /// The same shape with area or volume one.
    ///
    /// ```
    /// use protomer_md::body::Kind;
    /// let ball = Kind::ball(3, 7.0)?.of_unit_volume()?;
    /// assert!((ball.mass - 1.0).abs() < 1e-12 && (ball.inradius() - 0.62035).abs() < 1e-5);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Kind::scaled`].
    pub fn of_unit_volume(&self) -> Result<Self> {
        self.scaled(self.mass.powf(-1.0 / self.dimension as f64))
    }

    /// Whether the body is a disk or a ball, whose rotation no force changes.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// assert!(Kind::ball(3, 1.0)?.is_ball());
    /// assert!(!Kind::ellipsoid(3, Vec3::new(1.0, 1.0, 2.0))?.is_ball());
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn is_ball(&self) -> bool {
        self.parts.iter().all(Part::is_ball)
    }

    /// A body whose orientation never changes, whatever torques act on it.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// let needle = Kind::ellipsoid(3, Vec3::new(1.0, 1.0, 2.0))?;
    /// assert_eq!(needle.with_fixed_orientation().turns(), 0);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    #[must_use]
    pub fn with_fixed_orientation(self) -> Self {
        Self {
            is_fixed: true,
            ..self
        }
    }

    /// Axis of the body about which no contact turns it: that of a spheroid, if it can turn at all.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// assert_eq!(Kind::ellipsoid(3, Vec3::new(1.0, 2.0, 1.0))?.axis_of_revolution(), Some(1));
    /// assert_eq!(Kind::ellipsoid(3, Vec3::new(1.0, 2.0, 3.0))?.axis_of_revolution(), None);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn axis_of_revolution(&self) -> Option<usize> {
        let [part] = self.parts.as_slice() else {
            return None;
        };
        let axes = part.half_axes.filter(|_| self.turns() == 3)?;
        (0..3).find(|axis| axes[(axis + 1) % 3] == axes[(axis + 2) % 3])
    }

    /// Whether the orientation never changes.
    pub(crate) fn is_fixed(&self) -> bool {
        self.is_fixed
    }

    /// The inradius of the smallest part: the radius of the largest ball about its centre that fits
    /// in.
    pub fn inradius(&self) -> f64 {
        self.inradius
    }

    /// The radius of the smallest ball about the centre that holds the body.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// let ellipse = Kind::ellipsoid(2, Vec3::new(1.0, 3.0, 0.0))?;
    /// assert_eq!((ellipse.inradius(), ellipse.circumradius()), (1.0, 3.0));
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn circumradius(&self) -> f64 {
        self.circumradius
    }

    /// Number of rotational degrees of freedom.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// assert_eq!(Kind::ball(3, 1.0)?.turns(), 0, "no force turns a ball");
    /// assert_eq!(Kind::ellipsoid(3, Vec3::new(1.0, 1.0, 2.0))?.turns(), 3);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn turns(&self) -> usize {
        match (self.is_ball() || self.is_fixed, self.dimension) {
            (true, _) => 0,
            (false, 2) => 1,
            (false, _) => 3,
        }
    }

    /// Whether all three moments are equal, and whether the first two are.
    pub(crate) fn symmetry(&self) -> (bool, bool) {
        let near = |a: f64, b: f64| (a - b).abs() <= EQUAL_MOMENTS * a.abs().max(b.abs());
        let [x, y, z] = self.moments.into();
        (near(x, y) && near(y, z), near(x, y))
    }
}

/// Fails if two parts overlap by more than they touch.
fn check_apart(parts: &[(Polytope, Vec3)], radius: f64) -> Result<()> {
    // Shrunk a little, as parts that share a face touch.
    let shrunk = |(polytope, place): &(Polytope, Vec3)| -> Vec<Vec3> {
        let shrink = |corner: &Vec3| place + (1.0 - TOUCHING) * corner;
        polytope.corners.iter().map(shrink).collect()
    };
    for (number, first) in parts.iter().enumerate() {
        for (other, second) in parts.iter().enumerate().skip(number + 1) {
            let closest = closest_points(&shrunk(first), &shrunk(second));
            let least = 2.0 * radius * (1.0 - TOUCHING);
            if closest.is_none_or(|points| points.distance() < least) {
                return Err(Error::OverlappingParts {
                    first: number + 1,
                    second: other + 1,
                });
            }
        }
    }
    Ok(())
}

/// A part with its origin at the centroid of its layered shape, if it is all of the body: the centre
/// of mass of a rounded body is not that of its core. Parts of a union keep the centroid of the core.
fn about_layer(polytope: &Polytope, place: Vec3, radius: f64, parts: usize) -> (Polytope, Vec3) {
    if radius == 0.0 || parts > 1 {
        return (polytope.clone(), place);
    }
    let centroid = Moments::from_polytope(polytope, radius).centroid();
    let mut centred = polytope.clone();
    for corner in &mut centred.corners {
        *corner -= centroid;
    }
    for face in &mut centred.faces {
        face.offset -= face.normal.dot(&centroid);
    }
    (centred, place + centroid)
}

/// Principal moments, and the axes as columns of a rotation; the axes of the body where they are
/// principal axes already.
fn principal(inertia: &Matrix3<f64>) -> (Vec3, Matrix3<f64>) {
    let off = [(0, 1), (0, 2), (1, 2)].map(|place| inertia[place].abs());
    let largest = off.iter().fold(0.0_f64, |a, b| a.max(*b));
    // Kept as they are: turning a body by rounding would change its coordinates for nothing.
    if largest <= ALONG_THE_AXES * inertia.trace() {
        return (inertia.diagonal(), Matrix3::identity());
    }
    let eigen = SymmetricEigen::new(*inertia);
    let mut axes = eigen.eigenvectors;
    // A rotation, not a reflection.
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2).into_owned());
    }
    (eigen.eigenvalues, axes)
}

/// The body seen from these axes.
fn turned(polytope: &Polytope, axes: &Matrix3<f64>) -> Polytope {
    let into = axes.transpose();
    let mut aligned = polytope.clone();
    for corner in &mut aligned.corners {
        *corner = into * *corner;
    }
    for face in &mut aligned.faces {
        face.normal = into * face.normal;
    }
    aligned
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::shape::Shape;
    use protomer_kernel::shape::builders::by_name;

    fn kind(name: &str) -> Kind {
        Kind::from_polytope(&Polytope::from_shape(&by_name(name).unwrap()).unwrap()).unwrap()
    }

    #[test]
    fn moments_are_the_known_ones() {
        assert!((kind("polygon:4").moments.z - 1.0 / 6.0).abs() < 1e-14);
        assert!((kind("polygon:6").moments.z - 0.160_375_074_774_896).abs() < 1e-14);
        let brick = kind("cuboid:1,2,3");
        let expected = Vec3::new(6.5, 5.0, 2.5);
        assert!((brick.mass - 6.0).abs() < 1e-12);
        assert!(
            (brick.moments - expected).norm() < 1e-11,
            "{}",
            brick.moments
        );
        let octahedron = kind("octahedron").of_unit_volume().unwrap();
        assert!((octahedron.mass - 1.0).abs() < 1e-12);
        // An octahedron of edge a has the moment m a²/10.
        let edge = 2.0_f64.sqrt() * octahedron.circumradius();
        assert!((octahedron.moments - Vec3::repeat(0.1 * edge * edge)).norm() < 1e-12);
        assert!(octahedron.symmetry().0 && !brick.symmetry().1);
    }

    #[test]
    fn a_turned_body_is_seen_from_its_principal_axes() {
        let turn = protomer_kernel::Rotation::from_scaled_axis(Vec3::new(0.3, -0.8, 0.5));
        let brick = kind("cuboid:1,2,3");
        let points: Vec<Vec3> = brick.parts[0]
            .polytope
            .corners
            .iter()
            .map(|x| turn * x)
            .collect();
        let turned = Polytope::from_shape(&Shape::solid(&points).unwrap()).unwrap();
        let turned = Kind::from_polytope(&turned).unwrap();
        let mut moments: Vec<f64> = turned.moments.iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        for (found, expected) in moments.iter().zip([2.5, 5.0, 6.5]) {
            assert!((found - expected).abs() < 1e-11, "{moments:?}");
        }
        let inertia = Moments::from_polytope(&turned.parts[0].polytope, 0.0).inertia();
        assert!((inertia - Matrix3::from_diagonal(&turned.moments)).norm() < 1e-11);
        assert!(Kind::ball(3, 0.0).is_err());
    }

    /// Volume, centroid and second moments from points at random.
    fn sampled(kind: &Kind, count: usize) -> (f64, Vec3, Matrix3<f64>) {
        use protomer_kernel::random::CounterRng;
        let mut rng = CounterRng::new(8, 0, 0);
        let reach = kind.circumradius();
        let half = Vec3::new(reach, reach, if kind.dimension == 2 { 0.0 } else { reach });
        let (mut inside, mut first, mut second) = (0.0, Vec3::zeros(), Matrix3::zeros());
        for _ in 0..count {
            let x = half.map(|edge| edge * (2.0 * rng.uniform() - 1.0));
            let is_inside = kind.parts.iter().any(|part| {
                let core: Vec<Vec3> = part
                    .polytope
                    .corners
                    .iter()
                    .map(|c| c + part.centre)
                    .collect();
                let found = closest_points(&core, &[x]);
                found.is_none_or(|points| points.distance() <= part.radius)
            });
            if is_inside {
                inside += 1.0;
                first += x;
                second += x * x.transpose();
            }
        }
        let cell = (2.0 * reach).powi(kind.dimension as i32) / count as f64;
        (inside * cell, first * cell, second * cell)
    }

    #[test]
    fn rounded_bodies_have_the_volumes_of_steiner_and_the_moments_of_points_at_random() {
        use protomer_kernel::shape::measures::Measures;
        for name in [
            "polygon:3",
            "cube",
            "tetrahedron",
            "truncated-tetrahedron:0.4",
        ] {
            let shape = by_name(name).unwrap();
            let kind = Kind::rounded(&Polytope::from_shape(&shape).unwrap(), 0.2).unwrap();
            let expected = Measures::from_shape(&shape, 0.2).unwrap().volume;
            assert!((kind.mass / expected - 1.0).abs() < 1e-12, "{name}");
        }
        // Bodies whose centroid moves when they are rounded.
        let trapezium = Shape::flat(&[[0.0, 0.0], [3.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let wedge = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 0.5],
        ];
        let wedge = Shape::solid(&wedge.map(Vec3::from)).unwrap();
        for shape in [trapezium, wedge] {
            let kind = Kind::rounded(&Polytope::from_shape(&shape).unwrap(), 0.3).unwrap();
            let (volume, first, second) = sampled(&kind, 200_000);
            assert!(
                (volume / kind.mass - 1.0).abs() < 0.03,
                "{volume} {}",
                kind.mass
            );
            assert!((first / volume).norm() < 0.02, "{first}");
            let inertia = Matrix3::identity() * second.trace() - second;
            let expected = match kind.dimension {
                2 => Matrix3::from_diagonal(&Vec3::new(inertia.m11, inertia.m22, kind.moments.z)),
                _ => Matrix3::from_diagonal(&kind.moments),
            };
            let off = match kind.dimension {
                2 => (inertia.m33 - expected.m33).abs(),
                _ => (inertia - expected).norm(),
            };
            assert!(off < 0.04 * inertia.norm(), "{inertia} {expected}");
        }
    }

    #[test]
    fn a_square_in_two_parts_is_a_square() {
        let half = |x: f64| {
            let corners = [
                [x - 0.25, -0.5],
                [x + 0.25, -0.5],
                [x + 0.25, 0.5],
                [x - 0.25, 0.5],
            ];
            let polytope = Polytope::from_shape(&Shape::flat(&corners).unwrap()).unwrap();
            (polytope, Vec3::new(x, 0.0, 0.0))
        };
        let whole = Kind::union(&[half(1.0), half(1.5)], 0.0).unwrap();
        assert!((whole.mass - 1.0).abs() < 1e-12);
        assert!((whole.moments.z - 1.0 / 6.0).abs() < 1e-12);
        assert!((whole.parts[1].centre.x - 0.25).abs() < 1e-12);
        assert!((whole.circumradius() - (0.25 + 0.3125_f64.sqrt())).abs() < 1e-12);
        let overlapping = Kind::union(&[half(1.0), half(1.4)], 0.0);
        assert!(matches!(
            overlapping,
            Err(Error::OverlappingParts {
                first: 1,
                second: 2
            })
        ));
        let cube = Polytope::from_shape(&by_name("cube").unwrap()).unwrap();
        let mixed = Kind::union(&[half(0.0), (cube, Vec3::x())], 0.0);
        assert!(matches!(mixed, Err(Error::MixedDimensions)));
        assert!(Kind::union(&[], 0.0).is_err());
    }

    #[test]
    fn ellipsoids_have_their_moments() {
        let ball = Kind::ellipsoid(3, Vec3::repeat(0.7)).unwrap();
        let expected = Kind::ball(3, 0.7).unwrap();
        assert!((ball.mass - expected.mass).abs() < 1e-12);
        assert!((ball.moments - expected.moments).norm() < 1e-12);
        let ellipse = Kind::ellipsoid(2, Vec3::new(2.0, 1.0, 0.0)).unwrap();
        assert!((ellipse.mass - 2.0 * PI).abs() < 1e-12);
        assert!((ellipse.moments.z - 2.0 * PI * 1.25).abs() < 1e-12);
        assert!(!ball.is_ball() && ball.turns() == 3 && ellipse.turns() == 1);
        assert!(Kind::ellipsoid(3, Vec3::new(1.0, 0.0, 1.0)).is_err());
    }
}
