//! Convex shapes in two and three dimensions, and what is known of them exactly.
//!
//! | module | one idea |
//! |---|---|
//! | [`hull`] | the convex hull of points |
//! | [`convexity`] | whether polygons and meshes are convex |
//! | [`measures`] | volume, surface, mean curvature, second virial coefficient; rounding by Steiner's formulas |
//! | [`ellipsoid`] | the same of ellipsoids and ellipses |
//! | [`builders`] | shapes by name |
//! | [`polytope`] | corners, edges and faces about the centroid |
//! | [`closest`] | the closest points of two convex bodies |
//! | [`remembered`] | the same for bodies that moved little since |
//! | [`separation`] | whether two convex bodies overlap, fast |
//! | [`exact`] | the same, exactly |
//! | [`swept`] | bodies swept by a ball, and the volume that two of them share |
//!
//! Shapes have no unit of length.
//!
//! ```
//! use protomer_kernel::shape::{builders, measures::Measures};
//! let cube = builders::by_name("cube")?;
//! let measures = Measures::from_shape(&cube, 0.0)?;
//! assert!((measures.volume - 1.0).abs() < 1e-12);
//! assert!((measures.b2 - 5.5).abs() < 1e-12);
//! # Ok::<(), protomer_kernel::KernelError>(())
//! ```

pub mod builders;
pub mod closest;
pub mod convexity;
pub mod ellipsoid;
pub mod exact;
mod expansion;
pub mod hull;
pub mod measures;
pub mod polytope;
pub mod remembered;
pub mod separation;
pub mod swept;

use crate::{KernelError, Result, Vec3};
use hull::Hull;

/// The convex hull of points, in a plane or in space.
///
/// ```
/// use protomer_kernel::{Vec3, shape::Shape};
/// let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
/// let tetrahedron = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// assert_eq!(Shape::flat(&triangle)?.dimension(), 2);
/// assert_eq!(Shape::solid(&tetrahedron)?.dimension(), 3);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// The corners of a polygon, counter-clockwise; a segment has two and a point one.
    Flat(Vec<[f64; 2]>),
    /// A polyhedron; it may be as thin as a polygon, a segment or a point.
    Solid(Hull),
}

impl Shape {
    /// The convex hull of points in a plane.
    ///
    /// ```
    /// use protomer_kernel::shape::Shape;
    /// let square = Shape::flat(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0]])?;
    /// assert_eq!(square.corners(), 4, "a point inside is no corner");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadShape`] without points, or for numbers that are not finite.
    pub fn flat(points: &[[f64; 2]]) -> Result<Self> {
        require_finite(points.as_flattened())?;
        Ok(Shape::Flat(hull::polygon(points)))
    }

    /// The convex hull of points in space.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::Shape};
    /// let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), Vec3::repeat(0.1)];
    /// assert_eq!(Shape::solid(&corners)?.corners(), 4);
    /// assert!(Shape::solid(&[]).is_err());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Shape::flat`].
    pub fn solid(points: &[Vec3]) -> Result<Self> {
        let numbers: Vec<f64> = points.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
        require_finite(&numbers)?;
        Ok(Shape::Solid(Hull::from_points(points)))
    }

    /// Number of dimensions, 2 or 3.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::Shape};
    /// let thin = Shape::solid(&[Vec3::zeros(), Vec3::x(), Vec3::y()])?;
    /// assert_eq!(thin.dimension(), 3, "a triangle in space is a shape in space");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn dimension(&self) -> usize {
        match self {
            Shape::Flat(_) => 2,
            Shape::Solid(_) => 3,
        }
    }

    /// The corners; those of a flat shape have z = 0.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::Shape};
    /// let segment = Shape::flat(&[[0.0, 0.0], [3.0, 4.0]])?;
    /// assert_eq!(segment.corner_points(), [Vec3::zeros(), Vec3::new(3.0, 4.0, 0.0)]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn corner_points(&self) -> Vec<Vec3> {
        match self {
            Shape::Flat(corners) => corners
                .iter()
                .map(|[x, y]| Vec3::new(*x, *y, 0.0))
                .collect(),
            Shape::Solid(hull) => hull.corners(),
        }
    }

    /// The number of corners.
    ///
    /// ```
    /// use protomer_kernel::shape::builders::by_name;
    /// assert_eq!((by_name("cube")?.corners(), by_name("cuboid:1,2,3")?.corners()), (8, 8));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn corners(&self) -> usize {
        match self {
            Shape::Flat(corners) => corners.len(),
            Shape::Solid(hull) => hull.corners().len(),
        }
    }
}

fn require_finite(numbers: &[f64]) -> Result<()> {
    let complaint = match numbers {
        [] => "it has no points",
        _ if numbers.iter().any(|number| !number.is_finite()) => {
            "a coordinate is not a finite number"
        }
        _ => return Ok(()),
    };
    Err(KernelError::BadShape(complaint.into()))
}
