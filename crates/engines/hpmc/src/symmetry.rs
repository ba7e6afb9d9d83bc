//! The rotations that leave a body as it is, and the potential that holds its orientation.
//!
//! With the angle ω of the smallest rotation from an orientation to one that looks like the wanted one,
//! the potential is u = 4 sin²(ω/2), which is ω² for small angles. All orientations that look alike
//! have the same energy, so each of them is counted. A body of revolution is held by its axis: ω is the angle between two axes,
//! whichever way they point.

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
    /// Axis about which any rotation leaves the body as it is.
    axis: Option<Vec3>,
    /// Half the smallest angle of a rotation other than the identity; π if there is none.
    half_angle_rad: f64,
}

impl Symmetry {
    /// Symmetry of a body in D dimensions.
    ///
    /// # Errors
    /// For a rounded segment, which any rotation about its axis leaves as it is.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, symmetry::Symmetry};
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = HardBody::<3>::new(&by_name("cube")?, 0.0)?;
    /// assert_eq!(Symmetry::find(&cube)?.rotations().len(), 24);
    /// let egg = HardBody::<3>::ellipsoid([1.0, 1.0, 1.5])?;
    /// assert_eq!(Symmetry::find(&egg)?.degrees_of_freedom(), 2);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn find<const D: usize>(body: &HardBody<D>) -> Result<Self> {
        if let Some(half_axes) = body.half_axes() {
            return Ok(Self::from_half_axes(&half_axes));
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
            axis: None,
            half_angle_rad: 0.5 * smallest,
        })
    }

    /// Symmetry of an ellipsoid, or an ellipse.
    fn from_half_axes<const D: usize>(half_axes: &[f64; D]) -> Self {
        let largest = half_axes.iter().copied().fold(0.0, f64::max);
        let are_equal = |first: usize, second: usize| {
            (half_axes[first] - half_axes[second]).abs() <= SAME * largest
        };
        // The axis across two equal ones.
        let across = (0..D).find(|axis| are_equal((axis + 1) % D, (axis + 2) % D));
        let is_round = (1..D).all(|axis| are_equal(0, axis));
        let axis = across.filter(|_| D == 3 && !is_round);
        let turned = match (is_round, axis) {
            (true, _) => Vec::new(),
            // One half turn stands for all that reverse the axis.
            (false, Some(axis)) => vec![(axis + 1) % 3],
            (false, None) if D == 2 => vec![2],
            (false, None) => vec![0, 1, 2],
        };
        let mut rotations = vec![Rotation::identity()];
        for axis in turned {
            rotations.push(Rotation::from_scaled_axis(PI * unit(axis)));
        }
        Self {
            dimension: D,
            rotations,
            is_round,
            axis: axis.map(unit),
            half_angle_rad: 0.5 * PI,
        }
    }

    /// The rotations; of a body of revolution one of those that keep its axis and one of those that reverse it.
    pub fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }

    /// Degrees of freedom of an orientation: 0, 1, 2 or 3.
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
            (false, _) if self.axis.is_some() => 2,
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
        if let Some(axis) = &self.axis {
            let cosine = axis.dot(&(difference * axis)).abs();
            return 2.0 * (1.0 - cosine).max(0.0);
        }
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
    /// rounding from [`least_strength_kt`](Self::least_strength_kt) on; without symmetry, and for bodies of revolution, for any.
    ///
    /// An orientation at the angle ω has the density (1 - cos ω)/π in space, 1/π in a plane; an axis at the angle ω to
    /// another, up to π/2, has sin ω.
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
        if self.axis.is_some() {
            // With 1 - cos ω, which has a uniform density from 0 to 1, the energy is linear.
            let largest = 2.0 * strength_kt;
            return match largest > 0.0 {
                true => -(-largest).exp_m1() / largest,
                false => 1.0,
            };
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
    /// measure, which a rejection makes exact. An axis is tilted by its exponential distribution of 1 - cos ω.
    pub(crate) fn sample(
        &self,
        wanted: &Rotation,
        strength_kt: f64,
        rng: &mut CounterRng,
    ) -> Rotation {
        if self.is_round {
            return *wanted;
        }
        if let Some(axis) = &self.axis {
            return wanted * tilt(axis, strength_kt, rng);
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

/// A rotation that tilts an axis, with the density exp(-2 strength (1 - cos ω)) up to a right angle.
fn tilt(axis: &Vec3, strength_kt: f64, rng: &mut CounterRng) -> Rotation {
    let largest = 2.0 * strength_kt;
    // The inverse of the distribution of 1 - cos ω, between 0 and 1.
    let fall = (-(rng.uniform() * -(-largest).exp_m1())).ln_1p() / -largest;
    let angle = (1.0 - fall).clamp(0.0, 1.0).acos();
    let azimuth = 2.0 * PI * rng.uniform();
    let first = axis.yzx();
    let across = azimuth.cos() * first + azimuth.sin() * axis.cross(&first);
    Rotation::from_scaled_axis(angle * across)
}

/// The unit vector along an axis.
fn unit(axis: usize) -> Vec3 {
    Vec3::from_fn(|row, _| if row == axis { 1.0 } else { 0.0 })
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

    fn ellipsoid_symmetry(half_axes: [f64; 3]) -> Symmetry {
        Symmetry::find(&HardBody::ellipsoid(half_axes).unwrap()).unwrap()
    }

    /// A spheroid looks the same from both ends and however it is turned about its axis; an ellipsoid after half turns only.
    #[test]
    fn ellipsoids_that_look_alike_have_one_potential() {
        let mut rng = CounterRng::for_purpose(4, 0, 0, Purpose::HardBodyStart);
        let (plate, triaxial) = (
            ellipsoid_symmetry([2.0, 0.5, 2.0]),
            ellipsoid_symmetry([1.0, 2.0, 3.0]),
        );
        for _ in 0..100 {
            let (wanted, other) = (rng.rotation(), rng.rotation());
            let own_turn = Rotation::from_scaled_axis(rng.uniform() * 7.0 * Vec3::y());
            let reversed = Rotation::from_scaled_axis(PI * Vec3::new(0.6, 0.0, 0.8));
            assert!(plate.are_alike(&wanted, &(wanted * own_turn * reversed)));
            let expected = 4.0
                * (0.5 * (wanted * Vec3::y()).angle(&(other * Vec3::y())))
                    .sin()
                    .powi(2);
            let potential = plate.potential(&wanted, &other);
            let nearest = expected.min(4.0 - expected);
            assert!((potential - nearest).abs() < 1e-12, "{potential} {nearest}");
            for axis in 0..3 {
                let half_turn = Rotation::from_scaled_axis(PI * unit(axis));
                assert!(triaxial.are_alike(&wanted, &(wanted * half_turn)));
            }
            assert!(!triaxial.are_alike(&wanted, &(wanted * reversed)));
        }
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
        for (half_axes, order, freedom) in [
            ([1.0, 2.0, 3.0], 4, 3),
            ([2.0, 2.0, 1.0], 2, 2),
            ([2.0, 1.0, 2.0], 2, 2),
            ([1.0, 2.0, 2.0], 2, 2),
            ([1.5; 3], 1, 0),
        ] {
            let symmetry = ellipsoid_symmetry(half_axes);
            assert_eq!(symmetry.rotations().len(), order, "{half_axes:?}");
            assert_eq!(symmetry.degrees_of_freedom(), freedom, "{half_axes:?}");
        }
        let ellipse = Symmetry::find(&HardBody::<2>::ellipsoid([1.0, 2.0]).unwrap()).unwrap();
        assert_eq!(ellipse.rotations().len(), 2);
        assert_eq!(ellipse.degrees_of_freedom(), 1);
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
        for symmetry in [
            symmetry::<3>("prism:3,1"),
            ellipsoid_symmetry([1.0, 2.0, 3.0]),
            ellipsoid_symmetry([1.0, 1.0, 3.0]),
        ] {
            let strength = symmetry.least_strength_kt();
            let (samples, mut sum, mut squares) = (2_000_000, 0.0, 0.0);
            for _ in 0..samples {
                let energy = strength * symmetry.potential(&wanted, &rng.rotation());
                sum += (-energy).exp();
                squares += (-2.0 * energy).exp();
            }
            let mean = sum / f64::from(samples);
            let variance = squares / f64::from(samples) - mean * mean;
            let error = variance.sqrt() / f64::from(samples).sqrt();
            let exact = symmetry.integral(strength);
            assert!(error < 0.05 * exact, "{error}");
            assert!((mean - exact).abs() < 4.0 * error, "{mean} {error} {exact}");
        }
    }

    /// The integral over the angle of two axes, by a sum.
    #[test]
    fn the_integral_of_an_axis_is_exact_for_any_strength() {
        let plate = ellipsoid_symmetry([2.0, 2.0, 1.0]);
        for strength in [0.0_f64, 1e-9, 0.3, 7.0, 400.0] {
            let steps = 200_000;
            let width = 0.5 * PI / f64::from(steps);
            let mut sum = 0.0;
            for step in 0..steps {
                let angle = (f64::from(step) + 0.5) * width;
                sum += width * angle.sin() * (-strength * 4.0 * (0.5 * angle).sin().powi(2)).exp();
            }
            let found = plate.integral(strength);
            assert!((found / sum - 1.0).abs() < 1e-7, "{found} {sum}");
        }
    }

    #[test]
    fn sampled_orientations_have_the_mean_energy_of_the_integral() {
        for symmetry in [
            symmetry::<3>("cube"),
            symmetry::<2>("polygon:5"),
            ellipsoid_symmetry([1.0, 2.0, 3.0]),
            ellipsoid_symmetry([1.0, 3.0, 1.0]),
        ] {
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
