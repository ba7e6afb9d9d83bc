//! The rotations that leave a body as it is, and the potential that holds its orientation.
//!
//! With the angle ω of the smallest rotation from an orientation to one that looks like the wanted one,
//! the potential is u = 4 sin²(ω/2), which is ω² for small angles. All orientations that look alike
//! have the same energy, so each of them is counted.

use crate::body::{HardBody, norm};
use crate::{Error, Result};
use nalgebra::{Matrix3, Rotation3};
use protomer_kernel::quadrature::gauss_legendre;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::shape::separation::{Block, dot, matrix};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::PI;

/// Corners this near to each other, in radii of the body, are the same.
const SAME: f64 = 1e-6;
/// Random points that compare a body of pieces with itself when it is turned. A difference that fills a
/// thousandth of its ball is missed with a probability of (1 - 0.001)^5000 = 0.7 %.
const POINTS: usize = 5000;
/// Energies beyond this, in kT, count for nothing: exp(-40) = 4e-18.
const BEYOND_KT: f64 = 40.0;

/// The proper rotations of a body onto itself, with the identity.
///
/// ```
/// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
/// use protomer_kernel::shape::builders::by_name;
/// let square = HardBody::<2>::new(&by_name("polygon:4")?, 0.0)?;
/// let symmetry = Symmetry::find(&square)?;
/// assert_eq!((symmetry.rotations().len(), symmetry.degrees_of_freedom()), (4, 1));
/// assert_eq!(Symmetry::find(&HardBody::<3>::ball(1.0)?)?.degrees_of_freedom(), 0);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    dimension: usize,
    rotations: Vec<Rotation>,
    is_round: bool,
    /// Half the smallest angle of a rotation other than the identity; π if there is none.
    half_angle_rad: f64,
}

impl Symmetry {
    /// Symmetry of a body in D dimensions.
    ///
    /// # Errors
    /// For a rounded segment, which any rotation about its axis leaves as it is, and for ellipsoids.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = HardBody::<3>::new(&by_name("cube")?, 0.0)?;
    /// assert_eq!(Symmetry::find(&cube)?.rotations().len(), 24);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn find<const D: usize>(body: &HardBody<D>) -> Result<Self> {
        if body.half_axes().is_some() {
            return Err(Error::Ellipsoid);
        }
        // The hull of a body that is not convex has all rotations of the body, and perhaps more.
        let corners = corners(body);
        let mut rotations = match (body.is_round(), D) {
            (true, _) => vec![Rotation::identity()],
            (false, 2) => in_plane(&corners),
            (false, _) => in_space(&corners)?,
        };
        if body.pieces().is_some() {
            let compared = Compared::new(body);
            rotations.retain(|rotation| compared.is_the_same(rotation));
        }
        let smallest = rotations
            .iter()
            .map(|rotation| rotation.angle())
            .filter(|angle| *angle > SAME)
            .fold(2.0 * PI, f64::min);
        Ok(Self {
            dimension: D,
            rotations,
            is_round: body.is_round(),
            half_angle_rad: 0.5 * smallest,
        })
    }

    /// The rotations.
    pub fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }

    /// Degrees of freedom of an orientation: 0, 1 or 3.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = HardBody::<3>::new(&by_name("cube")?, 0.0)?;
    /// assert_eq!(Symmetry::find(&cube)?.degrees_of_freedom(), 3);
    /// assert_eq!(Symmetry::find(&HardBody::<3>::ball(1.0)?)?.degrees_of_freedom(), 0);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn degrees_of_freedom(&self) -> usize {
        match (self.is_round, self.dimension) {
            (true, _) => 0,
            (false, 2) => 1,
            (false, _) => 3,
        }
    }

    /// Whether two orientations look alike.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::{Rotation, Vec3, shape::builders::by_name};
    /// let cube = Symmetry::find(&HardBody::<3>::new(&by_name("cube")?, 0.0)?)?;
    /// let about_z = |degrees: f64| Rotation::new(degrees.to_radians() * Vec3::z());
    /// assert!(cube.are_alike(&about_z(10.0), &about_z(100.0)));
    /// assert!(!cube.are_alike(&about_z(10.0), &about_z(55.0)));
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn are_alike(&self, first: &Rotation, second: &Rotation) -> bool {
        self.is_round || self.potential(first, second) < SAME * SAME
    }

    /// The potential u of an orientation about a wanted one; from 0 to 4.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::{Rotation, Vec3, shape::builders::by_name};
    /// let cube = Symmetry::find(&HardBody::<3>::new(&by_name("cube")?, 0.0)?)?;
    /// let about_z = |degrees: f64| Rotation::new(degrees.to_radians() * Vec3::z());
    /// assert!(cube.potential(&about_z(0.0), &about_z(90.0)) < 1e-12, "a quarter turn changes nothing");
    /// assert!(cube.potential(&about_z(0.0), &about_z(45.0)) > 0.5);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn potential(&self, wanted: &Rotation, orientation: &Rotation) -> f64 {
        if self.is_round {
            return 0.0;
        }
        let difference = wanted.inverse() * orientation;
        let mut cosine: f64 = 0.0;
        for rotation in &self.rotations {
            cosine = cosine.max(difference.coords.dot(&rotation.coords).abs());
        }
        4.0 * (1.0 - cosine * cosine).max(0.0)
    }

    /// Squared sine of half the angle up to which orientations count.
    fn largest_squared_sine(&self) -> f64 {
        (0.5 * self.half_angle_rad).sin().powi(2).min(0.5)
    }

    /// The least strength, kT, at which orientations between two wanted ones count for nothing.
    pub fn least_strength_kt(&self) -> f64 {
        if self.is_round {
            return 0.0;
        }
        BEYOND_KT / (4.0 * self.largest_squared_sine())
    }

    /// The integral of exp(-strength u) over all orientations, 1 for a strength of zero. Exact to
    /// rounding from [`least_strength_kt`](Self::least_strength_kt) on; without symmetry, for any.
    ///
    /// An orientation at the angle ω has the density (1 - cos ω)/π in space, 1/π in a plane.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = Symmetry::find(&HardBody::<3>::new(&by_name("cube")?, 0.0)?)?;
    /// let stiff = cube.least_strength_kt();
    /// // A stiff spring in three dimensions: the integral falls as the strength to the power -3/2.
    /// let ratio = cube.integral(100.0 * stiff) / cube.integral(400.0 * stiff);
    /// assert!((ratio - 8.0).abs() < 0.01);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn integral(&self, strength_kt: f64) -> f64 {
        if self.is_round {
            return 1.0;
        }
        // exp(-81) and less is left out.
        let end = self
            .half_angle_rad
            .min(18.0 / strength_kt.max(1e-300).sqrt());
        let mut integral = 0.0;
        for node in gauss_legendre(64) {
            let angle = 0.5 * end * (node.place + 1.0);
            let density = match self.dimension {
                2 => 1.0,
                _ => 2.0 * (0.5 * angle).sin().powi(2),
            };
            let energy = strength_kt * 4.0 * (0.5 * angle).sin().powi(2);
            integral += 0.5 * end * node.weight * density / PI * (-energy).exp();
        }
        self.rotations.len() as f64 * integral
    }

    /// An orientation about a wanted one with the density exp(-strength u).
    ///
    /// The sines of half the angle along the axes are normal, but for the factor 1/√(1 - s²) of the
    /// measure, which a rejection makes exact.
    pub(crate) fn sample(
        &self,
        wanted: &Rotation,
        strength_kt: f64,
        rng: &mut CounterRng,
    ) -> Rotation {
        if self.is_round {
            return *wanted;
        }
        let width = (8.0 * strength_kt).recip().sqrt();
        let most = self.largest_squared_sine();
        loop {
            let mut sines = Vec3::zeros();
            for axis in if self.dimension == 2 { 2..3 } else { 0..3 } {
                sines[axis] = width * rng.normal();
            }
            let squared = sines.norm_squared();
            let is_inside = squared < most;
            if is_inside && rng.uniform() * ((1.0 - squared) / (1.0 - most)).sqrt() < 1.0 {
                let [x, y, z] = sines.into();
                let turn = nalgebra::Quaternion::new((1.0 - squared).sqrt(), x, y, z);
                return wanted * Rotation::new_normalize(turn);
            }
        }
    }
}

fn vector<const D: usize>(coordinates: &[f64; D]) -> Vec3 {
    Vec3::from_fn(|axis, _| coordinates.get(axis).copied().unwrap_or(0.0))
}

/// The corners of the convex hull of a body.
fn corners<const D: usize>(body: &HardBody<D>) -> Vec<Vec3> {
    let corners = match body.pieces() {
        Some(pieces) => pieces.hull(),
        None => &body.corners,
    };
    corners.iter().map(vector).collect()
}

/// Compares a body of pieces with itself when it is turned.
///
/// The same body can be cut in many ways, so its pieces decide nothing. Turned corners of pieces must lie in the body,
/// and each of many random points must lie in both the body and the turned body, or in neither.
struct Compared<'a, const D: usize> {
    body: &'a HardBody<D>,
    packed: Vec<Block<D>>,
    points: Vec<[f64; D]>,
}

impl<'a, const D: usize> Compared<'a, D> {
    fn new(body: &'a HardBody<D>) -> Self {
        let mut packed = vec![[[0.0; 4]; D]; body.blocks()];
        body.turned_into(&Rotation::identity(), &mut packed);
        let mut rng = CounterRng::for_purpose(0, 0, 0, Purpose::HardBodyInsertion);
        let mut points = Vec::with_capacity(POINTS);
        while points.len() < POINTS {
            let point: [f64; D] =
                std::array::from_fn(|_| rng.uniform_in(-1.0, 1.0) * body.outer_radius);
            if norm(&point) < body.outer_radius {
                points.push(point);
            }
        }
        Self {
            body,
            packed,
            points,
        }
    }

    fn is_the_same(&self, rotation: &Rotation) -> bool {
        let matrix = matrix::<D>(rotation);
        let rotate = |point: &[f64; D]| matrix.map(|row| dot(&row, point));
        let holds = |point: &[f64; D], radius| self.body.covers(&self.packed, point, radius);
        let margin = SAME * self.body.outer_radius;
        self.body
            .corners
            .iter()
            .all(|corner| holds(&rotate(corner), margin))
            && self
                .points
                .iter()
                .all(|point| holds(point, 0.0) == holds(&rotate(point), 0.0))
    }
}

/// Whether a rotation takes each corner to a corner.
fn maps_onto_itself(rotation: &Rotation, corners: &[Vec3], size: f64) -> bool {
    let is_corner = |place: Vec3| {
        let is_near = |corner: &Vec3| (corner - place).norm() < SAME * size;
        corners.iter().any(is_near)
    };
    corners.iter().all(|corner| is_corner(rotation * corner))
}

fn in_plane(corners: &[Vec3]) -> Vec<Rotation> {
    let size = corners.iter().map(Vec3::norm).fold(0.0, f64::max);
    let angle = |corner: &Vec3| corner.y.atan2(corner.x);
    let turns = corners
        .iter()
        .map(|corner| Rotation::from_scaled_axis((angle(corner) - angle(&corners[0])) * Vec3::z()));
    turns
        .filter(|turn| maps_onto_itself(turn, corners, size))
        .collect()
}

/// Two corners and the body's centre span a plane; a rotation is known by where it takes them.
fn in_space(corners: &[Vec3]) -> Result<Vec<Rotation>> {
    let size = corners.iter().map(Vec3::norm).fold(0.0, f64::max);
    let first = corners[0];
    let spans = |corner: &&Vec3| first.cross(corner).norm() > 1e-3 * size * size;
    let Some(second) = corners.iter().find(spans) else {
        return Err(Error::Axis);
    };
    let from = frame(&first, second);
    let mut rotations = Vec::new();
    for a in corners {
        for b in corners {
            let is_alike = (a.norm() - first.norm()).abs() < SAME * size
                && (b.norm() - second.norm()).abs() < SAME * size
                && (a.dot(b) - first.dot(second)).abs() < SAME * size * size;
            if !is_alike {
                continue;
            }
            let matrix = frame(a, b) * from.transpose();
            let rotation =
                Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
            if maps_onto_itself(&rotation, corners, size) {
                rotations.push(rotation);
            }
        }
    }
    Ok(rotations)
}

/// An orthonormal frame from two vectors.
pub(crate) fn frame(first: &Vec3, second: &Vec3) -> Matrix3<f64> {
    let x = first.normalize();
    let z = first.cross(second).normalize();
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::Purpose;
    use protomer_kernel::shape::{Shape, builders::by_name};

    fn symmetry<const D: usize>(name: &str) -> Symmetry {
        Symmetry::find(&HardBody::<D>::new(&by_name(name).unwrap(), 0.0).unwrap()).unwrap()
    }

    #[test]
    fn groups_have_their_orders() {
        for (name, order) in [
            ("tetrahedron", 12),
            ("truncated-tetrahedron:0.667", 12),
            ("octahedron", 24),
            ("icosahedron", 60),
            ("dodecahedron", 60),
            ("cuboid:1,2,3", 4),
            ("cuboid:1,1,3", 8),
            ("prism:6,1", 12),
        ] {
            assert_eq!(symmetry::<3>(name).rotations().len(), order, "{name}");
        }
        assert_eq!(symmetry::<2>("polygon:7").rotations().len(), 7);
        let scalene = Shape::flat(&[[0.0, 0.0], [3.0, 0.0], [0.0, 1.0]]).unwrap();
        let scalene = HardBody::<2>::new(&scalene, 0.0).unwrap();
        assert_eq!(Symmetry::find(&scalene).unwrap().rotations().len(), 1);
        let rod = Shape::solid(&[Vec3::zeros(), Vec3::z()]).unwrap();
        let rod = HardBody::<3>::new(&rod, 0.5).unwrap();
        assert_eq!(Symmetry::find(&rod), Err(Error::Axis));
    }

    #[test]
    fn integrals_of_cubes_are_those_of_an_independent_program() {
        let cube = symmetry::<3>("cube");
        for (strength, expected) in [
            (100.0, 0.001_695_757_302_695_938_8),
            (500.0, 0.000_151_444_775_103_044_47),
            (2000.0, 1.892_526_840_865_926_4e-5),
        ] {
            let found = cube.integral(strength);
            assert!((found / expected - 1.0).abs() < 1e-9, "{found}");
        }
    }

    /// The mean of exp(-strength u) over random orientations, which knows nothing of the angle.
    #[test]
    fn integrals_are_means_over_random_orientations() {
        let mut rng = CounterRng::for_purpose(3, 0, 0, Purpose::HardBodyStart);
        let wanted = rng.rotation();
        let prism = symmetry::<3>("prism:3,1");
        let strength = prism.least_strength_kt();
        let (samples, mut sum, mut squares) = (2_000_000, 0.0, 0.0);
        for _ in 0..samples {
            let energy = strength * prism.potential(&wanted, &rng.rotation());
            sum += (-energy).exp();
            squares += (-2.0 * energy).exp();
        }
        let mean = sum / f64::from(samples);
        let error = (squares / f64::from(samples) - mean * mean).sqrt() / f64::from(samples).sqrt();
        let exact = prism.integral(strength);
        assert!(error < 0.05 * exact, "{error}");
        assert!((mean - exact).abs() < 4.0 * error, "{mean} {error} {exact}");
    }

    #[test]
    fn sampled_orientations_have_the_mean_energy_of_the_integral() {
        for symmetry in [symmetry::<3>("cube"), symmetry::<2>("polygon:5")] {
            let strength = symmetry.least_strength_kt();
            let mut rng = CounterRng::for_purpose(5, 0, 0, Purpose::HardBodyStart);
            let wanted = Rotation::from_scaled_axis(Vec3::z());
            let samples = 40_000;
            let mut sum = 0.0;
            for _ in 0..samples {
                let orientation = symmetry.sample(&wanted, strength, &mut rng);
                sum += symmetry.potential(&wanted, &orientation);
            }
            let step = 1e-4 * strength;
            let slope = symmetry.integral(strength + step) / symmetry.integral(strength - step);
            let exact = -slope.ln() / (2.0 * step);
            let freedom = symmetry.degrees_of_freedom() as f64;
            let error = exact * (2.0 / freedom / f64::from(samples)).sqrt();
            let mean = sum / f64::from(samples);
            assert!((mean - exact).abs() < 4.0 * error, "{mean} {exact} {error}");
        }
    }
}
