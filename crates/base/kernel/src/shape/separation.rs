//! Whether two convex bodies overlap, for engines that ask many million times.
//!
//! Two convex bodies are apart if and only if some direction separates them. The caller keeps the
//! direction that did it last time: where bodies move little it does so again, and a test is one
//! pass over the corners of each. Else a portal is sought in the difference of the bodies, through which
//! a ray from its inside to the origin leaves (Snethen's method). The search stops as soon as a
//! direction separates the bodies, or as soon as the origin is inside. Nearer to the surface than
//! floating-point numbers can tell, exact arithmetic has the last word (see [`exact`](super::exact)).
//!
//! Bodies may be rounded: with radii whose sum is `reach`, they overlap if the distance of their
//! cores is less than that. Then the walk of Gilbert, Johnson and Keerthi (see
//! [`closest`](super::closest)) goes towards the origin, and stops as soon as the distance is
//! known to be more or less than the reach.

use crate::{Rotation, Vec3, vectorised};

/// Corners that are handled together.
pub const LANES: usize = 4;

/// Coordinates of four corners, axis by axis.
pub type Block<const D: usize> = [[f64; LANES]; D];

/// Limit on the number of steps: the walk visits a corner of the difference at most once, but for
/// rounding.
const MOST_STEPS: usize = 60;
/// Distance from the surface of the difference, as a part of its size, below which the walk does
/// not decide.
const NEAR_SURFACE: f64 = 1e-7;
/// Relative error of the difference of two heights, as a part of the sizes it is made of: three
/// products and sums for each, and that of their difference.
const OF_A_HEIGHT: f64 = 8.0 * f64::EPSILON;
/// Gain of a step in squared distance up to which it counts as none, as a part of the squared size.
const NO_GAIN: f64 = 1e-14;

/// Packs corners for [`Pair`]; the last block repeats the last corner.
///
/// ```
/// use protomer_kernel::shape::separation::pack;
/// let triangle = pack(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
/// assert_eq!(triangle, [[[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]]]);
/// ```
pub fn pack<const D: usize>(corners: &[[f64; D]]) -> Vec<Block<D>> {
    let mut blocks = vec![[[0.0; LANES]; D]; corners.len().div_ceil(LANES)];
    for (number, block) in blocks.iter_mut().enumerate() {
        for lane in 0..LANES {
            // Repeated corners change no maximum, so the loops need no remainder.
            let corner = corners[(number * LANES + lane).min(corners.len() - 1)];
            for axis in 0..D {
                block[axis][lane] = corner[axis];
            }
        }
    }
    blocks
}

/// Turns packed corners by a matrix, of which the first D rows and columns count.
///
/// ```
/// use protomer_kernel::shape::separation::{pack, turn};
/// let from = pack(&[[1.0, 0.0]]);
/// let mut to = from.clone();
/// turn(&[[0.0, -1.0], [1.0, 0.0]], &from, &mut to);
/// assert_eq!(to, pack(&[[0.0, 1.0]]));
/// ```
pub fn turn<const D: usize>(matrix: &[[f64; D]; D], from: &[Block<D>], to: &mut [Block<D>]) {
    for (from, to) in from.iter().zip(to) {
        for (row, out) in matrix.iter().zip(to.iter_mut()) {
            // Row after row with the inner loop over lanes:
            // one factor, four corners, one vector operation.
            *out = [0.0; LANES];
            for (factor, x) in row.iter().zip(from) {
                for lane in 0..LANES {
                    out[lane] += factor * x[lane];
                }
            }
        }
    }
}

/// The inner product of two vectors.
///
/// ```
/// use protomer_kernel::shape::separation::dot;
/// assert_eq!(dot(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]), 32.0);
/// assert_eq!(dot(&[1.0, 2.0], &[-2.0, 1.0]), 0.0, "they are perpendicular");
/// ```
#[inline(always)]
pub fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        sum += a[axis] * b[axis];
    }
    sum
}

/// The first D rows and columns of a rotation matrix.
///
/// ```
/// use protomer_kernel::{Rotation, Vec3, shape::separation::matrix};
/// let quarter = Rotation::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
/// let [[_, sine], _] = matrix::<2>(&quarter);
/// assert!((sine + 1.0).abs() < 1e-12);
/// ```
pub fn matrix<const D: usize>(rotation: &Rotation) -> [[f64; D]; D] {
    let full = rotation.to_rotation_matrix();
    let mut matrix = [[0.0; D]; D];
    for (row, numbers) in matrix.iter_mut().enumerate() {
        for (column, number) in numbers.iter_mut().enumerate() {
            *number = full[(row, column)];
        }
    }
    matrix
}

/// The difference of two vectors.
///
/// ```
/// use protomer_kernel::shape::separation::minus;
/// assert_eq!(minus(&[4.0, 1.0], &[1.0, 3.0]), [3.0, -2.0]);
/// ```
#[inline(always)]
pub fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    let mut difference = [0.0; D];
    for axis in 0..D {
        difference[axis] = a[axis] - b[axis];
    }
    difference
}

/// Heights of four corners along a direction.
#[inline(always)]
fn heights<const D: usize>(block: &Block<D>, direction: &[f64; D]) -> [f64; LANES] {
    let mut heights = [0.0; LANES];
    for axis in 0..D {
        for lane in 0..LANES {
            heights[lane] += block[axis][lane] * direction[axis];
        }
    }
    heights
}

/// The largest height of corners along a direction.
#[inline(always)]
fn highest<const D: usize>(corners: &[Block<D>], direction: &[f64; D]) -> f64 {
    // Four running maxima, one per lane, are combined once at the end, not after every block.
    let mut best = [f64::NEG_INFINITY; LANES];
    for block in corners {
        let heights = heights(block, direction);
        for lane in 0..LANES {
            if heights[lane] > best[lane] {
                best[lane] = heights[lane];
            }
        }
    }
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    larger(larger(best[0], best[1]), larger(best[2], best[3]))
}

/// The corner that is highest along a direction.
#[inline(always)]
fn farthest<const D: usize>(corners: &[Block<D>], direction: &[f64; D]) -> [f64; D] {
    // Numbers of blocks as floats: a compiler makes vectors of equal types only.
    let (mut best, mut numbers) = ([f64::NEG_INFINITY; LANES], [0.0; LANES]);
    let mut number = 0.0;
    for block in corners {
        let heights = heights(block, direction);
        for lane in 0..LANES {
            let is_higher = heights[lane] > best[lane];
            best[lane] = if is_higher { heights[lane] } else { best[lane] };
            numbers[lane] = if is_higher { number } else { numbers[lane] };
        }
        number += 1.0;
    }
    let left = usize::from(best[1] > best[0]);
    // Ties go to the lower lane, so the result does not depend on the width of the vectors.
    let right = 2 + usize::from(best[3] > best[2]);
    let lane = if best[right] > best[left] {
        right
    } else {
        left
    };
    let block = &corners[numbers[lane] as usize];
    let mut corner = [0.0; D];
    for axis in 0..D {
        corner[axis] = block[axis][lane];
    }
    corner
}

/// Two bodies in their places.
///
/// ```
/// use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
/// let square = pack(&[[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]);
/// let pair = Pair {
///     first: &square,
///     second: &square,
///     offset: [3.0, 0.0],
///     reach: 0.5,
///     error: error_of_heights(5.0),
/// };
/// assert!(pair.is_separated_along(&[1.0, 0.0]) && !pair.is_separated_along(&[0.0, 1.0]));
/// assert_eq!(pair.gap_along(&[1.0, 0.0]), 3.0 - 1.0 - 0.5);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a, const D: usize> {
    /// The corners of the first body from its centre, turned as it is.
    pub first: &'a [Block<D>],
    /// The corners of the second body from its centre, turned as it is.
    pub second: &'a [Block<D>],
    /// Vector from the centre of the first body to that of the second.
    pub offset: [f64; D],
    /// Sum of the rounding radii.
    pub reach: f64,
    /// Error bound of a height along a direction, over the sum of its components: see
    /// [`error_of_heights`].
    pub error: f64,
}

/// A bound on the rounding error of differences of heights, for corners whose coordinates, with those of
/// the offset, add up to no more than `size`.
pub fn error_of_heights(size: f64) -> f64 {
    OF_A_HEIGHT * size
}

impl<const D: usize> Pair<'_, D> {
    /// The largest rounding error of a difference of heights along a direction.
    #[inline(always)]
    fn doubt(&self, direction: &[f64; D]) -> f64 {
        let mut sum = 0.0;
        for x in direction {
            sum += x.abs();
        }
        self.error * sum
    }

    /// Whether this direction, of any length, separates the bodies for certain; touching bodies are not
    /// apart.
    ///
    /// ```
    /// use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
    /// let square = pack(&[[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]);
    /// let (offset, error) = ([1.5, 0.0], error_of_heights(4.0));
    /// let pair = Pair { first: &square, second: &square, offset, reach: 0.0, error };
    /// assert!(pair.is_separated_along(&[1.0, 0.0]) && !pair.is_separated_along(&[0.0, 1.0]));
    /// ```
    #[inline(always)]
    pub fn is_separated_along(&self, direction: &[f64; D]) -> bool {
        let top = highest(self.first, direction);
        let down = direction.map(|x| -x);
        // Lowest of the second less highest of the first: the signed gap of the two shadows.
        let bottom = dot(&self.offset, direction) - highest(self.second, &down);
        let gap = bottom - top;
        if self.reach == 0.0 {
            // Inside the rounding error the answer stays "not
            // certain", and the search or exact numbers decide.
            return gap > self.doubt(direction);
        }
        // Squares: no root, and the sign is tested first.
        gap > 0.0 && gap * gap > self.reach * self.reach * dot(direction, direction)
    }

    /// Lower bound on the distance of the bodies along a direction, in units of its length;
    /// negative if it does not separate them. The offset counts as it is.
    ///
    /// ```
    /// use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
    /// let square = pack(&[[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]);
    /// let (offset, error) = ([2.0, 0.0], error_of_heights(4.0));
    /// let pair = Pair { first: &square, second: &square, offset, reach: 0.25, error };
    /// assert_eq!(pair.gap_along(&[1.0, 0.0]), 0.75, "rounding takes a quarter of the gap");
    /// assert_eq!(pair.gap_along(&[3.0, 0.0]), 0.75, "the length of the direction does not count");
    /// ```
    pub fn gap_along(&self, direction: &[f64; D]) -> f64 {
        let down = direction.map(|x| -x);
        let cores = dot(&self.offset, direction)
            - highest(self.second, &down)
            - highest(self.first, direction);
        cores / dot(direction, direction).sqrt() - self.reach
    }

    /// Whether the bodies overlap; those that touch do. `direction` is where the search begins: the
    /// direction that separated them last, or the offset; if they are apart, it separates them
    /// afterwards. `exact` decides where cores that are not rounded touch, as far as numbers can
    /// tell.
    ///
    /// ```
    /// use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
    /// let square = pack(&[[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]);
    /// let error = error_of_heights(4.0);
    /// let touches = |x: f64| {
    ///     let offset = [x, 0.3];
    ///     let pair = Pair { first: &square, second: &square, offset, reach: 0.0, error };
    ///     pair.overlap(&mut { offset }, || unreachable!())
    /// };
    /// assert!(touches(0.99) && !touches(1.01));
    /// ```
    pub fn overlap(&self, direction: &mut [f64; D], exact: impl FnOnce() -> bool) -> bool {
        self.decide(direction).unwrap_or_else(exact)
    }

    vectorised!(
        narrow
        /// Variant of [`overlap`](Self::overlap) that returns `None` where the search cannot tell.
        fn decide[decide_avx2, decide_anywhere](self: &Self, direction: &mut [f64; D]) -> Option<bool>
    );

    /// Body of `decide`: the same operations in the same order for every processor, which give the
    /// same bits.
    #[inline(always)]
    fn decide_anywhere(&self, direction: &mut [f64; D]) -> Option<bool> {
        // The remembered direction ends most calls here, with one pass over the corners.
        if self.is_separated_along(direction) {
            return Some(false);
        }
        match (self.reach > 0.0, D) {
            (true, _) => self.walk(direction),
            (false, 2) => self.portal_in_plane(direction),
            (false, _) => self.portal_in_space(direction),
        }
    }

    /// The corner of the difference (second less first) that is lowest along a direction.
    #[inline(always)]
    fn lowest(&self, direction: &[f64; D]) -> [f64; D] {
        let first = farthest(self.first, direction);
        let second = farthest(self.second, &direction.map(|x| -x));
        let mut corner = self.offset;
        for axis in 0..D {
            corner[axis] += second[axis] - first[axis];
        }
        corner
    }

    /// The corner of the difference that is highest along a direction. If it is not above the origin, the
    /// opposite direction separates the bodies.
    #[inline(always)]
    fn beyond(&self, normal: &[f64; D], direction: &mut [f64; D]) -> Option<[f64; D]> {
        let down = normal.map(|x| -x);
        let corner = self.lowest(&down);
        // All of the difference lies below the origin along this normal, by more than rounding:
        // apart.
        if dot(&corner, normal) < -self.doubt(normal) {
            *direction = down;
            return None;
        }
        Some(corner)
    }

    /// Variant of `beyond` for vectors in space.
    #[inline(always)]
    fn beyond_in_space(&self, normal: &Vec3, direction: &mut [f64; D]) -> Option<Vec3> {
        let normal = in_plane_or_space(normal);
        Some(in_space(&self.beyond(&normal, direction)?))
    }

    /// Decides whether polygons overlap. The ray from the inside of the difference to the origin
    /// leaves a simplex that grows through a face, the portal (Snethen, Game Programming Gems 7
    /// (2008), 165).
    #[inline(always)]
    fn portal_in_plane(&self, direction: &mut [f64; D]) -> Option<bool> {
        // The centres' difference lies inside the difference of the bodies, whatever their shapes.
        let inside = self.offset;
        let Some(mut a) = self.beyond(&inside.map(|x| -x), direction) else {
            return Some(false);
        };
        let mut size_squared = dot(&a, &a).max(dot(&inside, &inside));
        let Some(mut b) = self.beyond(&across(&inside, &a), direction) else {
            return Some(false);
        };
        for step in 0..=MOST_STEPS {
            // Until the ray passes between the two corners.
            let side = across(&inside, &b);
            if dot(&side, &a) >= dot(&side, &inside) {
                break;
            }
            match self.beyond(&side, direction) {
                None => return Some(false),
                Some(next) => (a, b) = (b, next),
            }
            // Rounding can make the loop cycle; exact arithmetic takes over.
            if step == MOST_STEPS {
                return None;
            }
        }
        for _ in 0..MOST_STEPS {
            let mut normal = across_edge(&a, &b);
            // Outwards: away from the inside.
            if dot(&normal, &minus(&a, &inside)) < 0.0 {
                normal = normal.map(|x| -x);
            }
            let height = dot(&normal, &a);
            let near = NEAR_SURFACE * NEAR_SURFACE * size_squared * dot(&normal, &normal);
            // Too near to the edge for a sign that is certain.
            if height * height <= near {
                return None;
            }
            // The portal lies beyond the origin, so the origin is inside.
            if height > 0.0 {
                return Some(true);
            }
            let Some(next) = self.beyond(&normal, direction) else {
                return Some(false);
            };
            let gain = dot(&minus(&next, &a), &normal);
            // No corner lies beyond the portal, though the origin seemed to: left to exact signs.
            if gain * gain <= near {
                return None;
            }
            size_squared = size_squared.max(dot(&next, &next));
            // The origin lies on the same side of the ray through the new corner as a or b does.
            let side = across(&inside, &next);
            if (dot(&side, &a) > dot(&side, &inside)) == (dot(&side, &inside) < 0.0) {
                b = next;
            } else {
                a = next;
            }
        }
        None
    }

    /// Variant of [`portal_in_plane`](Self::portal_in_plane) for polyhedra; the portal is a
    /// triangle.
    #[inline(always)]
    fn portal_in_space(&self, direction: &mut [f64; D]) -> Option<bool> {
        let inside = in_space(&self.offset);
        let Some(mut a) = self.beyond_in_space(&-inside, direction) else {
            return Some(false);
        };
        let mut size_squared = a.norm_squared().max(inside.norm_squared());
        let mut normal = a.cross(&inside);
        if normal.norm_squared() <= NEAR_SURFACE * NEAR_SURFACE * size_squared * size_squared {
            // The origin is on the line from the inside to the corner, where any portal begins well.
            let least = inside.iamin();
            normal = inside.cross(&Vec3::ith(least, 1.0));
        }
        let Some(mut b) = self.beyond_in_space(&normal, direction) else {
            return Some(false);
        };
        normal = (a - inside).cross(&(b - inside));
        if normal.dot(&inside) > 0.0 {
            std::mem::swap(&mut a, &mut b);
            normal = -normal;
        }
        // Now the origin is on the outer side of the plane through the inside, a and b.
        let mut c = a;
        for step in 0..=MOST_STEPS {
            if step == MOST_STEPS {
                return None;
            }
            match self.beyond_in_space(&normal, direction) {
                None => return Some(false),
                Some(corner) => c = corner,
            }
            // Outside of the edge a c, the next plane is through a and c; likewise for c and b.
            if a.cross(&c).dot(&inside) < 0.0 {
                b = c;
            } else if c.cross(&b).dot(&inside) < 0.0 {
                a = c;
            } else {
                break;
            }
            normal = (a - inside).cross(&(b - inside));
        }
        for _ in 0..MOST_STEPS {
            let normal = (b - a).cross(&(c - a));
            let height = normal.dot(&a);
            let near = NEAR_SURFACE * NEAR_SURFACE * size_squared * normal.norm_squared();
            if height * height <= near {
                return None;
            }
            if height > 0.0 {
                return Some(true);
            }
            let Some(next) = self.beyond_in_space(&normal, direction) else {
                return Some(false);
            };
            let gain = (next - a).dot(&normal);
            if gain * gain <= near {
                return None;
            }
            size_squared = size_squared.max(next.norm_squared());
            // The plane through the inside, the origin and the new corner divides the portal.
            let plane = next.cross(&inside);
            if a.dot(&plane) > 0.0 {
                if b.dot(&plane) > 0.0 {
                    a = next;
                } else {
                    c = next;
                }
            } else if c.dot(&plane) > 0.0 {
                b = next;
            } else {
                a = next;
            }
        }
        None
    }

    /// Walks to the point of the difference nearest to the origin; `None` if the surface of the
    /// difference is too near to the origin to tell.
    #[inline(always)]
    fn walk(&self, direction: &mut [f64; D]) -> Option<bool> {
        let mut simplex = Simplex::new(self.lowest(direction));
        let mut nearest = simplex.corners[0];
        let mut size_squared = dot(&nearest, &nearest);
        let reach_squared = self.reach * self.reach;
        for _ in 0..MOST_STEPS {
            let squared = dot(&nearest, &nearest);
            // The nearest point of the simplex is one of the difference.
            if self.reach > 0.0 && squared <= reach_squared {
                return Some(true);
            }
            if squared <= NEAR_SURFACE * NEAR_SURFACE * size_squared {
                return None;
            }
            let next = self.lowest(&nearest);
            let height = dot(&nearest, &next);
            // The plane across `nearest` at this height is
            // farther than the reach: apart for certain.
            if height > 0.0 && height * height > reach_squared * squared {
                *direction = nearest;
                return Some(false);
            }
            size_squared = size_squared.max(dot(&next, &next));
            if squared - height <= NO_GAIN * size_squared {
                // The nearest point of the difference, to rounding: it is at the distance `reach`.
                return (self.reach > 0.0).then_some(false);
            }
            simplex.add(next);
            match simplex.nearest(size_squared) {
                Nearest::Inside => return Some(true),
                Nearest::Unclear => return None,
                Nearest::At(point) => nearest = point,
            }
        }
        None
    }
}

#[inline(always)]
fn in_plane_or_space<const D: usize>(vector: &Vec3) -> [f64; D] {
    let mut coordinates = [0.0; D];
    for (axis, x) in coordinates.iter_mut().enumerate() {
        *x = vector[axis];
    }
    coordinates
}

/// A vector of the plane at right angles to the line from a place to another, on the side of the origin.
#[inline(always)]
fn across<const D: usize>(from: &[f64; D], to: &[f64; D]) -> [f64; D] {
    let normal = across_edge(from, to);
    if dot(&normal, from) > 0.0 {
        return normal.map(|x| -x);
    }
    normal
}

#[inline(always)]
fn across_edge<const D: usize>(from: &[f64; D], to: &[f64; D]) -> [f64; D] {
    let edge = minus(to, from);
    let mut normal = [0.0; D];
    normal[0] = edge[1];
    normal[1] = -edge[0];
    normal
}

/// A simplex of at most four corners of the difference.
#[derive(Debug, Clone, Copy)]
struct Simplex<const D: usize> {
    corners: [[f64; D]; 4],
    count: usize,
}

/// Position of the origin relative to a simplex.
enum Nearest<const D: usize> {
    /// The origin is outside of the simplex, nearest to this point of it.
    At([f64; D]),
    Inside,
    /// The origin is on its surface, as far as numbers can tell.
    Unclear,
}

impl<const D: usize> Simplex<D> {
    fn new(corner: [f64; D]) -> Self {
        Self {
            corners: [corner; 4],
            count: 1,
        }
    }

    fn add(&mut self, corner: [f64; D]) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// The point nearest to the origin; keeps the corners that carry it.
    fn nearest(&mut self, size_squared: f64) -> Nearest<D> {
        match self.count {
            1 => Nearest::At(self.corners[0]),
            2 => {
                let [a, b, ..] = self.corners;
                let face = on_segment(&a, &b);
                self.keep(&[a, b], &face);
                Nearest::At(face.point)
            }
            3 => {
                let [a, b, c, _] = self.corners;
                let face = on_triangle(&a, &b, &c);
                // In a plane, three carriers mean that the
                // origin is inside: there is no fourth corner.
                if D == 2 && face.carriers == [true; 3] {
                    return Nearest::inside_if(inner_distance_2d(&[a, b, c]), size_squared);
                }
                self.keep(&[a, b, c], &face);
                Nearest::At(face.point)
            }
            _ => self.of_tetrahedron(size_squared),
        }
    }

    fn keep(&mut self, corners: &[[f64; D]], face: &Face<D>) {
        self.count = 0;
        for (corner, carries) in corners.iter().zip(face.carriers) {
            if carries {
                self.add(*corner);
            }
        }
    }

    fn of_tetrahedron(&mut self, size_squared: f64) -> Nearest<D> {
        const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]];
        let corners = self.corners;
        let place = corners.map(|corner| in_space(&corner));
        let mut best: Option<([[f64; D]; 3], Face<D>)> = None;
        let mut depth = f64::INFINITY;
        for [a, b, c, opposite] in FACES {
            let normal = (place[b] - place[a]).cross(&(place[c] - place[a]));
            let inward = normal.dot(&(place[opposite] - place[a]));
            let origin = -normal.dot(&place[a]) * inward.signum();
            let length = normal.norm();
            // The origin may be outside of a face that is a mere line.
            if origin < 0.0 || length * length <= f64::MIN_POSITIVE || inward == 0.0 {
                let triangle = [corners[a], corners[b], corners[c]];
                let face = on_triangle(&triangle[0], &triangle[1], &triangle[2]);
                let is_better = |(_, best): &([[f64; D]; 3], Face<D>)| {
                    dot(&face.point, &face.point) < dot(&best.point, &best.point)
                };
                if best.as_ref().is_none_or(is_better) {
                    best = Some((triangle, face));
                }
            } else {
                // Smallest distance to a face, which says how certain "inside" is.
                depth = depth.min(origin / length);
            }
        }
        match best {
            Some((triangle, face)) => {
                self.keep(&triangle, &face);
                Nearest::At(face.point)
            }
            None => Nearest::inside_if(depth, size_squared),
        }
    }
}

impl<const D: usize> Nearest<D> {
    fn inside_if(depth: f64, size_squared: f64) -> Self {
        // Nearer to the surface than this, rounding could have chosen the wrong side.
        if depth * depth > NEAR_SURFACE * NEAR_SURFACE * size_squared {
            Nearest::Inside
        } else {
            Nearest::Unclear
        }
    }
}

#[inline(always)]
fn in_space<const D: usize>(corner: &[f64; D]) -> Vec3 {
    let mut place = Vec3::zeros();
    for (axis, x) in corner.iter().enumerate().take(3) {
        place[axis] = *x;
    }
    place
}

/// The distance of the origin, inside a triangle, from its edges.
fn inner_distance_2d<const D: usize>(triangle: &[[f64; D]; 3]) -> f64 {
    let place = triangle.map(|corner| in_space(&corner));
    let mut least = f64::INFINITY;
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let edge = place[to] - place[from];
        least = least.min(edge.cross(&place[from]).norm() / edge.norm());
    }
    least
}

/// The point of a segment or triangle that is nearest to the origin, and the corners it needs.
struct Face<const D: usize> {
    point: [f64; D],
    carriers: [bool; 3],
}

impl<const D: usize> Face<D> {
    fn at_corner(point: &[f64; D], which: usize) -> Self {
        let mut carriers = [false; 3];
        carriers[which] = true;
        Self {
            point: *point,
            carriers,
        }
    }

    fn on_edge(ends: [&[f64; D]; 2], part: f64, which: [usize; 2]) -> Self {
        let mut carriers = [false; 3];
        for end in which {
            carriers[end] = true;
        }
        let mut point = *ends[0];
        for axis in 0..D {
            point[axis] += part * (ends[1][axis] - ends[0][axis]);
        }
        Self { point, carriers }
    }
}

fn on_segment<const D: usize>(a: &[f64; D], b: &[f64; D]) -> Face<D> {
    let edge = minus(b, a);
    let (part, whole) = (-dot(a, &edge), dot(&edge, &edge));
    if part <= 0.0 {
        Face::at_corner(a, 0)
    } else if part >= whole {
        Face::at_corner(b, 1)
    } else {
        Face::on_edge([a, b], part / whole, [0, 1])
    }
}

/// The point of a triangle nearest to the origin, by regions of the plane (Ericson, Real-Time
/// Collision Detection (2005), 5.1.5).
fn on_triangle<const D: usize>(a: &[f64; D], b: &[f64; D], c: &[f64; D]) -> Face<D> {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let (d1, d2) = (-dot(&ab, a), -dot(&ac, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Face::at_corner(a, 0);
    }
    let (d3, d4) = (-dot(&ab, b), -dot(&ac, b));
    if d3 >= 0.0 && d4 <= d3 {
        return Face::at_corner(b, 1);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return Face::on_edge([a, b], d1 / (d1 - d3), [0, 1]);
    }
    let (d5, d6) = (-dot(&ab, c), -dot(&ac, c));
    if d6 >= 0.0 && d5 <= d6 {
        return Face::at_corner(c, 2);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return Face::on_edge([a, c], d2 / (d2 - d6), [0, 2]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return Face::on_edge([b, c], (d4 - d3) / ((d4 - d3) + (d5 - d6)), [1, 2]);
    }
    let scale = 1.0 / (va + vb + vc);
    let mut point = *a;
    for axis in 0..D {
        point[axis] += scale * (vb * ab[axis] + vc * ac[axis]);
    }
    Face {
        point,
        carriers: [true; 3],
    }
}
