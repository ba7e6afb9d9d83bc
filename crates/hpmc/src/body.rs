//! A hard convex body, ready for tests of overlap.

use crate::reservoir::ball_volume;
use crate::{Error, Result, error::require};
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::exact::overlap_exactly;
use protomer_kernel::shape::hull::Hull;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Block, Pair, error_of_heights, pack, turn};
use protomer_kernel::{Rotation, Vec3};

/// A convex polygon (D = 2) or polyhedron (D = 3), rounded or not, about its centre.
#[derive(Debug, Clone)]
pub struct HardBody<const D: usize> {
    /// The corners from the centre.
    pub corners: Vec<[f64; D]>,
    /// Radius of the ball, or disk, that is added to the hull of the corners.
    pub rounding_radius: f64,
    /// Radius of a ball about the centre that fits in.
    pub inner_radius: f64,
    /// Radius of the ball about the centre that holds the body.
    pub outer_radius: f64,
    /// Volume; in a plane, area.
    pub volume: f64,
    packed: Vec<Block<D>>,
    /// The corners of each face; in a plane, of each edge.
    faces: Vec<Vec<usize>>,
}

impl<const D: usize> HardBody<D> {
    /// The Minkowski sum of a shape and a ball of this radius.
    ///
    /// # Errors
    /// For a shape of another dimension, without volume, or a negative radius.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = HardBody::<3>::new(&by_name("cube")?, 0.1)?;
    /// assert_eq!(cube.corners.len(), 8);
    /// assert!((cube.inner_radius - 0.6).abs() < 1e-12);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn new(shape: &Shape, rounding_radius: f64) -> Result<Self> {
        if shape.dimension() != D {
            return Err(Error::Dimension {
                shape: shape.dimension(),
                space: D,
            });
        }
        let measures = Measures::of(shape, rounding_radius)?;
        let (corners, faces, inradius) = match Polytope::of(shape) {
            Ok(polytope) => (
                polytope.corners.iter().map(coordinates).collect(),
                polytope
                    .faces
                    .iter()
                    .map(|face| face.corners.clone())
                    .collect(),
                polytope.inradius(),
            ),
            // A point, a segment or a polygon in space, which only its rounding makes a body.
            Err(_) => (thin_corners(shape), Vec::new(), 0.0),
        };
        let outer: f64 = corners.iter().map(norm).fold(0.0, f64::max);
        Ok(Self {
            packed: pack(&corners),
            corners,
            rounding_radius,
            inner_radius: inradius + rounding_radius,
            outer_radius: outer + rounding_radius,
            volume: measures.volume,
            faces,
        })
    }

    /// A ball about the centre: in one dimension a rod, in two a disk.
    ///
    /// # Errors
    /// For a radius that is not positive.
    pub fn ball(radius: f64) -> Result<Self> {
        require("the radius", radius, "positive", radius > 0.0)?;
        let corners = vec![[0.0; D]];
        let volume = ball_volume(D, radius);
        Ok(Self {
            packed: pack(&corners),
            corners,
            rounding_radius: radius,
            inner_radius: radius,
            outer_radius: radius,
            volume,
            faces: Vec::new(),
        })
    }

    /// Whether it is a ball or a disk, which looks the same however it is turned.
    pub fn is_round(&self) -> bool {
        self.corners.len() == 1
    }

    /// Corners in groups of four.
    pub(crate) fn blocks(&self) -> usize {
        self.packed.len()
    }

    /// The corners from the centre when the body is turned.
    pub(crate) fn turned_into(&self, rotation: &Rotation, corners: &mut [Block<D>]) {
        turn(&matrix(rotation), &self.packed, corners);
    }

    /// Bound on the rounding of heights in a pair; see [`Pair::error`].
    pub(crate) fn error_of_heights(&self) -> f64 {
        // Two bodies and the offset between their centres.
        error_of_heights(4.0 * D as f64 * self.outer_radius)
    }

    /// Whether two of these bodies overlap: their corners, turned, and the way between their centres.
    pub(crate) fn overlaps_at(
        &self,
        first: &[Block<D>],
        second: &[Block<D>],
        offset: &[f64; D],
    ) -> bool {
        let (inner, outer) = (2.0 * self.inner_radius, 2.0 * self.outer_radius);
        let squared: f64 = offset.iter().map(|x| x * x).sum();
        if squared < inner * inner || squared >= outer * outer {
            return squared < outer * outer;
        }
        let pair = Pair {
            first,
            second,
            offset: *offset,
            reach: 2.0 * self.rounding_radius,
            error: self.error_of_heights(),
        };
        pair.overlap(&mut { *offset }, || self.exact(&pair))
    }

    /// The last word on two bodies that touch to within rounding.
    pub(crate) fn exact(&self, pair: &Pair<'_, D>) -> bool {
        if self.rounding_radius > 0.0 || self.faces.is_empty() {
            return true;
        }
        overlap_exactly(pair, [&self.faces, &self.faces])
    }
}

fn coordinates<const D: usize>(vector: &Vec3) -> [f64; D] {
    let mut coordinates = [0.0; D];
    for (axis, x) in coordinates.iter_mut().enumerate() {
        *x = vector[axis];
    }
    coordinates
}

/// Corners of a shape without volume, from their mean.
fn thin_corners<const D: usize>(shape: &Shape) -> Vec<[f64; D]> {
    let corners: Vec<Vec3> = match shape {
        Shape::Flat(corners) => corners
            .iter()
            .map(|[x, y]| Vec3::new(*x, *y, 0.0))
            .collect(),
        Shape::Solid(hull @ (Hull::Point(_) | Hull::Segment(_) | Hull::Polygon(_))) => {
            hull.corners()
        }
        Shape::Solid(hull) => hull.corners(),
    };
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
    corners
        .iter()
        .map(|corner| coordinates(&(corner - mean)))
        .collect()
}

pub(crate) fn norm<const D: usize>(vector: &[f64; D]) -> f64 {
    protomer_kernel::shape::separation::dot(vector, vector).sqrt()
}

/// The first D rows and columns of a rotation matrix.
pub(crate) fn matrix<const D: usize>(rotation: &Rotation) -> [[f64; D]; D] {
    let full = rotation.to_rotation_matrix();
    let mut matrix = [[0.0; D]; D];
    for (row, numbers) in matrix.iter_mut().enumerate() {
        for (column, number) in numbers.iter_mut().enumerate() {
            *number = full[(row, column)];
        }
    }
    matrix
}
