//! A hard body, ready for tests of overlap: convex, of several convex pieces, or an ellipsoid.

use crate::ellipsoids;
use crate::pieces::{Piece, Pieces};
use crate::reservoir::ball_volume;
use crate::{Result, error::require};
use protomer_kernel::Rotation;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
use protomer_kernel::shape::exact::overlap_exactly;
use protomer_kernel::shape::separation::{Block, Pair, dot, error_of_heights, matrix, pack, turn};

/// A convex polygon (D = 2) or polyhedron (D = 3), rounded or not, about its centre; several of them, held
/// together; or an ellipse or ellipsoid.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_kernel::shape::builders::by_name;
/// let disk_like = HardBody::<2>::new(&by_name("polygon:6")?, 0.0)?;
/// assert!((disk_like.volume - 1.0).abs() < 1e-12);
/// assert!(HardBody::<3>::new(&by_name("polygon:6")?, 0.0).is_err(), "a plane has no solids");
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct HardBody<const D: usize> {
    /// The corners from the centre; those of all pieces. An ellipsoid has none.
    pub corners: Vec<[f64; D]>,
    /// Radius of the ball, or disk, that is added to the hull of the corners.
    pub rounding_radius: f64,
    /// Radius of a ball about the centre that fits in.
    pub inner_radius: f64,
    /// Radius of the ball about the centre that holds the body.
    pub outer_radius: f64,
    /// Volume; in a plane, area.
    pub volume: f64,
    /// The corners in lanes; of an ellipsoid its half axes, as vectors.
    packed: Vec<Block<D>>,
    /// The corners of each face; in a plane, of each edge.
    faces: Vec<Vec<usize>>,
    /// Pieces of a body that is not convex.
    pieces: Option<Pieces<D>>,
    /// Half axes of an ellipsoid.
    half_axes: Option<[f64; D]>,
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
        let piece = Piece::new(shape, rounding_radius)?;
        Ok(Self {
            packed: pack(&piece.corners),
            rounding_radius,
            inner_radius: piece.inner_radius,
            outer_radius: piece.outer_radius,
            volume: piece.volume,
            corners: piece.corners,
            faces: piece.faces,
            pieces: None,
            half_axes: None,
        })
    }

    /// Convex shapes, each rounded, where their coordinates have them, as one body about its centre of mass. It
    /// need not be convex.
    ///
    /// # Errors
    /// As [`HardBody::new`] for each shape; also for pieces that overlap. They may touch.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_kernel::{Vec3, shape::Shape};
    /// let ball = |x: f64| Shape::solid(&[Vec3::new(x, 0.0, 0.0)]);
    /// let dumbbell = HardBody::<3>::of_pieces(&[ball(-0.5)?, ball(0.5)?], 0.5)?;
    /// assert!((dumbbell.volume - std::f64::consts::PI / 3.0).abs() < 1e-12);
    /// assert_eq!(dumbbell.outer_radius, 1.0);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn of_pieces(shapes: &[Shape], rounding_radius: f64) -> Result<Self> {
        match shapes {
            [shape] => Self::new(shape, rounding_radius),
            shapes => Self::in_pieces(shapes, rounding_radius),
        }
    }

    /// Variant of [`of_pieces`](Self::of_pieces) that keeps a single piece as one, for mixtures with bodies of several.
    ///
    /// # Errors
    /// As [`of_pieces`](Self::of_pieces).
    pub fn in_pieces(shapes: &[Shape], rounding_radius: f64) -> Result<Self> {
        let pieces = shapes
            .iter()
            .map(|shape| Piece::new(shape, rounding_radius));
        let pieces = Pieces::new(pieces.collect::<Result<_>>()?, rounding_radius)?;
        let corners = pieces.corners();
        let outer: f64 = corners.iter().map(norm).fold(0.0, f64::max);
        Ok(Self {
            packed: pieces.pack(),
            rounding_radius,
            inner_radius: pieces.inner_radius(),
            outer_radius: outer + rounding_radius,
            volume: pieces.volume(),
            corners,
            faces: Vec::new(),
            pieces: Some(pieces),
            half_axes: None,
        })
    }

    /// A ball about the centre: in one dimension a rod, in two a disk.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// let disk = HardBody::<2>::ball(0.5)?;
    /// assert!(disk.is_round() && (disk.volume - std::f64::consts::PI / 4.0).abs() < 1e-12);
    /// assert!(HardBody::<3>::ball(0.0).is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
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
            pieces: None,
            half_axes: None,
        })
    }

    /// An ellipsoid about its centre with half axes along the coordinates; in a plane an ellipse. In a mixture all
    /// bodies are ellipsoids, or none.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// let egg = HardBody::<3>::ellipsoid([1.0, 1.0, 1.5])?;
    /// assert!((egg.volume - 2.0 * std::f64::consts::PI).abs() < 1e-12);
    /// assert_eq!((egg.inner_radius, egg.outer_radius), (1.0, 1.5));
    /// assert!(HardBody::<2>::ellipsoid([1.0, 0.0]).is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// For half axes outside 1e-50 to 1e50.
    pub fn ellipsoid(half_axes: [f64; D]) -> Result<Self> {
        let measures = measures_of_ellipsoid(&half_axes, 0.0)?;
        let vectors: Vec<[f64; D]> = (0..D)
            .map(|axis| {
                let mut vector = [0.0; D];
                vector[axis] = half_axes[axis];
                vector
            })
            .collect();
        Ok(Self {
            packed: pack(&vectors),
            corners: Vec::new(),
            rounding_radius: 0.0,
            inner_radius: half_axes.iter().copied().fold(f64::INFINITY, f64::min),
            outer_radius: half_axes.iter().copied().fold(0.0, f64::max),
            volume: measures.volume,
            faces: Vec::new(),
            pieces: None,
            half_axes: Some(half_axes),
        })
    }

    /// The half axes of an ellipsoid.
    pub fn half_axes(&self) -> Option<[f64; D]> {
        self.half_axes
    }

    /// Whether the body is a ball or a disk, which looks the same however it is turned.
    pub fn is_round(&self) -> bool {
        self.corners.len() == 1
    }

    /// The pieces of a body that was made of several.
    pub fn pieces(&self) -> Option<&Pieces<D>> {
        self.pieces.as_ref()
    }

    /// Number of blocks of four corners.
    #[inline]
    pub(crate) fn blocks(&self) -> usize {
        self.packed.len()
    }

    /// The corners from the centre when the body is turned.
    pub(crate) fn turned_into(&self, rotation: &Rotation, corners: &mut [Block<D>]) {
        turn(&matrix(rotation), &self.packed, corners);
    }

    /// Bound on the rounding of heights in a pair with another body; see [`Pair::error`].
    #[inline]
    pub(crate) fn error_of_heights(&self, other: &Self) -> f64 {
        // Two bodies and the offset between their centres.
        error_of_heights(2.0 * D as f64 * (self.outer_radius + other.outer_radius))
    }

    /// Whether this body overlaps another, given their turned corners and the vector between their
    /// centres.
    pub(crate) fn overlaps_at(
        &self,
        other: &Self,
        first: &[Block<D>],
        second: &[Block<D>],
        offset: &[f64; D],
    ) -> bool {
        let inner = self.inner_radius + other.inner_radius;
        let outer = self.outer_radius + other.outer_radius;
        let squared: f64 = offset.iter().map(|x| x * x).sum();
        if squared < inner * inner || squared >= outer * outer {
            return squared < outer * outer;
        }
        if self.half_axes.is_some() {
            return ellipsoids::overlap(&first[0], &second[0], offset, &mut { *offset });
        }
        let pair = self.pair_of_hulls(other, first, second, offset);
        pair.overlap(&mut { *offset }, || self.exact(other, &pair))
            && self.overlap_as_their_hulls_do(other, first, second, offset)
    }

    /// The convex hulls of two bodies; of convex ones, the bodies.
    #[inline]
    pub(crate) fn pair_of_hulls<'a>(
        &self,
        other: &Self,
        first: &'a [Block<D>],
        second: &'a [Block<D>],
        offset: &[f64; D],
    ) -> Pair<'a, D> {
        let hull = |body: &Self| {
            body.pieces
                .as_ref()
                .map_or(body.blocks(), Pieces::hull_blocks)
        };
        Pair {
            first: &first[..hull(self)],
            second: &second[..hull(other)],
            offset: *offset,
            reach: self.rounding_radius + other.rounding_radius,
            error: self.error_of_heights(other),
        }
    }

    /// Whether two bodies overlap whose hulls do.
    pub(crate) fn overlap_as_their_hulls_do(
        &self,
        other: &Self,
        first: &[Block<D>],
        second: &[Block<D>],
        offset: &[f64; D],
    ) -> bool {
        match (&self.pieces, &other.pieces) {
            (Some(pieces), Some(others)) => {
                let error = self.error_of_heights(other);
                pieces.overlap(others, first, second, offset, error)
            }
            // A mixture has pieces in all of its bodies or in none.
            _ => true,
        }
    }

    /// Whether a point, from the centre of a body with these corners, is within a radius of it.
    pub(crate) fn covers(&self, corners: &[Block<D>], point: &[f64; D], radius: f64) -> bool {
        let squared = dot(point, point);
        let (inner, outer) = (self.inner_radius + radius, self.outer_radius + radius);
        if squared < inner * inner || squared >= outer * outer {
            return squared < inner * inner;
        }
        if self.half_axes.is_some() {
            return ellipsoids::covers(&corners[0], point, radius);
        }
        let reach = self.rounding_radius + radius;
        match &self.pieces {
            Some(pieces) => pieces.cover(corners, point, radius),
            None => is_within(corners, point, reach),
        }
    }

    /// Reach of a turned body down and up along the last axis from its centre.
    pub(crate) fn extent(&self, corners: &[Block<D>]) -> [f64; 2] {
        if self.half_axes.is_some() {
            let reach = ellipsoids::reach_along_last(&corners[0]);
            return [-reach, reach];
        }
        let hull = self
            .pieces
            .as_ref()
            .map_or(corners.len(), Pieces::hull_blocks);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for block in &corners[..hull] {
            for x in block[D - 1] {
                low = low.min(x);
                high = high.max(x);
            }
        }
        [low - self.rounding_radius, high + self.rounding_radius]
    }

    /// Decides whether two bodies that touch to within rounding overlap.
    #[inline]
    pub(crate) fn exact(&self, other: &Self, pair: &Pair<'_, D>) -> bool {
        let is_rounded = self.rounding_radius > 0.0 || other.rounding_radius > 0.0;
        if is_rounded || self.faces.is_empty() || other.faces.is_empty() {
            return true;
        }
        overlap_exactly(pair, [&self.faces, &other.faces])
    }
}

/// Whether a point is within a distance of the hull of corners.
pub(crate) fn is_within<const D: usize>(
    corners: &[Block<D>],
    point: &[f64; D],
    reach: f64,
) -> bool {
    let origin = [[[0.0; 4]; D]];
    let pair = Pair {
        first: corners,
        second: &origin,
        offset: *point,
        reach,
        error: 0.0,
    };
    pair.overlap(&mut { *point }, || true)
}

pub(crate) fn norm<const D: usize>(vector: &[f64; D]) -> f64 {
    dot(vector, vector).sqrt()
}
