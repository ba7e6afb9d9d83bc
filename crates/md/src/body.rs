//! A kind of rigid body: its shape about the centre of mass, its mass and its moments of inertia.
//!
//! The density is one. A body of polygons or polyhedra is turned so that its axes are the principal
//! axes of inertia. Disks and balls have no faces: they are a point with a radius.

use crate::{Error, Result};
use nalgebra::{Matrix3, SymmetricEigen};
use protomer_kernel::Vec3;
use protomer_kernel::shape::polytope::Polytope;
use std::f64::consts::PI;

/// Products of inertia smaller than this part of the moments are rounding.
const ALONG_THE_AXES: f64 = 1e-10;
/// Moments that differ by less than this part are equal.
const EQUAL_MOMENTS: f64 = 1e-12;

/// The shape, mass and moments of bodies of one kind.
///
/// ```
/// use protomer_kernel::shape::{builders, polytope::Polytope};
/// use protomer_md::body::Kind;
/// let cube = Kind::of(&Polytope::of(&builders::by_name("cube")?)?)?;
/// assert!((cube.mass - 1.0).abs() < 1e-12);
/// assert!((cube.moments.x - 1.0 / 6.0).abs() < 1e-12);
/// let disk = Kind::ball(2, 0.5)?;
/// assert!((disk.mass - std::f64::consts::PI / 4.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// 2 or 3.
    pub dimension: usize,
    /// Corners, faces and edges; a disk or a ball is one corner at the centre.
    pub polytope: Polytope,
    /// The radius of a disk or a ball; 0 for the others.
    pub radius: f64,
    /// Mass: the area or the volume.
    pub mass: f64,
    /// Moments of inertia about the axes of the body; in a plane the last is that about the normal.
    pub moments: Vec3,
    /// The distances of the faces from the centre.
    pub(crate) offsets: Vec<f64>,
    pub(crate) inradius: f64,
    pub(crate) circumradius: f64,
}

impl Kind {
    /// A polygon or a polyhedron of density one.
    ///
    /// # Errors
    /// [`Error::NoVolume`] for a shape without area or volume.
    pub fn of(polytope: &Polytope) -> Result<Self> {
        let (mass, moments, polytope) = match polytope.dimension {
            2 => {
                let (mass, moment) = of_polygon(polytope);
                (mass, Vec3::new(moment, moment, moment), polytope.clone())
            }
            _ => {
                let (mass, inertia) = of_polyhedron(polytope);
                let (moments, axes) = principal(&inertia);
                (mass, moments, turned(polytope, &axes))
            }
        };
        if !(mass.is_finite() && mass > 0.0) {
            return Err(Error::NoVolume);
        }
        Ok(Self {
            dimension: polytope.dimension,
            offsets: polytope.faces.iter().map(|face| face.offset).collect(),
            inradius: polytope.inradius(),
            circumradius: polytope.circumradius(),
            radius: 0.0,
            mass,
            moments,
            polytope,
        })
    }

    /// A disk (dimension 2) or a ball (dimension 3) of density one.
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
        Ok(Self {
            dimension,
            polytope: Polytope {
                dimension,
                corners: vec![Vec3::zeros()],
                edges: Vec::new(),
                faces: Vec::new(),
            },
            radius,
            mass,
            moments: Vec3::repeat(moment),
            offsets: Vec::new(),
            inradius: radius,
            circumradius: radius,
        })
    }

    /// The same shape with all lengths multiplied by a factor; the density stays one.
    ///
    /// # Errors
    /// [`Error::NoVolume`] unless the factor is positive.
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        if self.is_ball() {
            return Self::ball(self.dimension, factor * self.radius);
        }
        let mut polytope = self.polytope.clone();
        for corner in &mut polytope.corners {
            *corner *= factor;
        }
        for face in &mut polytope.faces {
            face.offset *= factor;
        }
        Self::of(&polytope)
    }

    /// The same shape with area or volume one.
    ///
    /// # Errors
    /// As [`Kind::scaled`].
    pub fn of_unit_volume(&self) -> Result<Self> {
        self.scaled(self.mass.powf(-1.0 / self.dimension as f64))
    }

    /// Whether it is a disk or a ball, whose rotation nothing changes.
    pub fn is_ball(&self) -> bool {
        self.polytope.faces.is_empty()
    }

    /// The radius of the largest ball about the centre that fits in.
    pub fn inradius(&self) -> f64 {
        self.inradius
    }

    /// The radius of the smallest ball about the centre that holds it.
    pub fn circumradius(&self) -> f64 {
        self.circumradius
    }

    /// The number of ways in which it turns.
    pub fn turns(&self) -> usize {
        match (self.is_ball(), self.dimension) {
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

/// Area and polar moment about the centroid.
fn of_polygon(polytope: &Polytope) -> (f64, f64) {
    let (mut area, mut moment) = (0.0, 0.0);
    let next = polytope.corners.iter().cycle().skip(1);
    for (a, b) in polytope.corners.iter().zip(next) {
        let twice = a.x * b.y - a.y * b.x;
        area += 0.5 * twice;
        moment += twice / 12.0 * (a.dot(a) + a.dot(b) + b.dot(b));
    }
    (area, moment)
}

/// Volume and inertia tensor about the centroid, from the tetrahedra that join it with the faces.
fn of_polyhedron(polytope: &Polytope) -> (f64, Matrix3<f64>) {
    let (mut volume, mut second) = (0.0, Matrix3::zeros());
    for face in &polytope.faces {
        let corner = |place: usize| polytope.corners[face.corners[place]];
        for place in 1..face.corners.len().saturating_sub(1) {
            let [a, b, c] = [corner(0), corner(place), corner(place + 1)];
            let six_volumes = a.dot(&b.cross(&c));
            volume += six_volumes / 6.0;
            let sum = a + b + c;
            for x in [sum, a, b, c] {
                second += six_volumes / 120.0 * x * x.transpose();
            }
        }
    }
    (volume, Matrix3::identity() * second.trace() - second)
}

/// Principal moments, and the axes as columns of a rotation; the axes of the body where they are
/// principal axes already.
fn principal(inertia: &Matrix3<f64>) -> (Vec3, Matrix3<f64>) {
    let off = [(0, 1), (0, 2), (1, 2)].map(|place| inertia[place].abs());
    let largest = off.iter().fold(0.0_f64, |a, b| a.max(*b));
    if largest <= ALONG_THE_AXES * inertia.trace() {
        return (inertia.diagonal(), Matrix3::identity());
    }
    let eigen = SymmetricEigen::new(*inertia);
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2).into_owned());
    }
    (eigen.eigenvalues, axes)
}

/// The body seen from these axes.
fn turned(polytope: &Polytope, axes: &Matrix3<f64>) -> Polytope {
    let into = axes.transpose();
    let mut turned = polytope.clone();
    for corner in &mut turned.corners {
        *corner = into * *corner;
    }
    for face in &mut turned.faces {
        face.normal = into * face.normal;
    }
    turned
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use protomer_kernel::shape::Shape;
    use protomer_kernel::shape::builders::by_name;

    fn kind(name: &str) -> Kind {
        Kind::of(&Polytope::of(&by_name(name).unwrap()).unwrap()).unwrap()
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
        let points: Vec<Vec3> = brick.polytope.corners.iter().map(|x| turn * x).collect();
        let turned = Polytope::of(&Shape::solid(&points).unwrap()).unwrap();
        let turned = Kind::of(&turned).unwrap();
        let mut moments: Vec<f64> = turned.moments.iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        for (found, expected) in moments.iter().zip([2.5, 5.0, 6.5]) {
            assert!((found - expected).abs() < 1e-11, "{moments:?}");
        }
        let (_, inertia) = of_polyhedron(&turned.polytope);
        assert!((inertia - Matrix3::from_diagonal(&turned.moments)).norm() < 1e-11);
        assert!(Kind::ball(3, 0.0).is_err());
    }
}
