//! Periodic boxes of any shape, in D dimensions: a rectangular box, sheared.
//!
//! The edges of the box are the columns of an upper triangular matrix h, as in files of GSD and HOOMD:
//!
//! ```text
//!     | Lx  xy Ly  xz Lz |
//! h = |  0     Ly  yz Lz | = N diag(Lx, Ly, Lz),   x = N u,   0 ≤ u_k < L_k
//!     |  0      0     Lz |
//! ```
//!
//! with the lengths L and the tilt factors xy, xz, yz, the entries of N above its diagonal of ones. So a place x
//! in the box is a place u in a rectangular box of the edges L, sheared by N, and to move x by an edge of the
//! box is to move u by an edge of the rectangular one.
//!
//! **Nearest images.** The last coordinate of a displacement changes only by whole Lz. So where its nearest
//! image has components shorter than L_k/2, the last of them tells how many edges along z were passed, then
//! the one before it how many along y, and so on. This finds the nearest image, whatever the tilt, if it is
//! shorter than half of the smallest L. Images of one place are never nearer to each other than the smallest L.
//!
//! **Reduction.** An edge that is added to a later one changes the box and not the lattice of its images. It
//! leaves the lengths as they are and takes an edge's part along an earlier axis to within half of the length
//! there ([`reduced`](PeriodicBox::reduced)).

use crate::Result;
use crate::error::require;

/// Largest part of the length along an earlier axis that an edge may overhang before it is reduced.
/// As it is more than a half, boxes with angles of 60 degrees keep them while they change a little.
const LARGEST_OVERHANG: f64 = 0.75;
/// Places are left where they are if they are outside of a tilted box by less than this part of an edge.
/// Otherwise rounding could move a place on a face to the opposite one and back.
const ON_FACE: f64 = 1e-12;

/// A periodic box with a corner at the origin.
///
/// ```
/// use protomer_kernel::periodic_box::PeriodicBox;
/// let hexagonal = PeriodicBox::with_angles(&[2.0, 2.0], &[60.0])?;
/// assert!((hexagonal.volume() - 2.0 * 3.0_f64.sqrt()).abs() < 1e-12);
/// let [x, y] = hexagonal.nearest_image(&[1.6, 1.7]);
/// assert!((x - 0.6).abs() < 1e-12 && (y + 0.032).abs() < 1e-3);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodicBox<const D: usize> {
    lengths: [f64; D],
    /// Entries of N - 1: `tilts[row][column]` for column > row, otherwise zero.
    tilts: [[f64; D]; D],
    is_rectangular: bool,
}

impl<const D: usize> PeriodicBox<D> {
    /// A box with right angles and these edges.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::rectangular([2.0, 3.0, 4.0])?;
    /// assert_eq!(space.volume(), 24.0);
    /// assert!(PeriodicBox::rectangular([2.0, 0.0]).is_err());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless they are positive and finite.
    pub fn rectangular(lengths: [f64; D]) -> Result<Self> {
        Self::new(lengths, &[])
    }

    /// A box of these lengths and tilt factors: xy, xz, yz in space, xy in a plane. Without any it is
    /// rectangular.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let sheared = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// assert_eq!((sheared.edge(0), sheared.edge(1)), ([4.0, 0.0], [1.0, 2.0]));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) for lengths that are not positive, tilt
    /// factors that are not finite, and another number of them.
    pub fn new(lengths: [f64; D], tilt_factors: &[f64]) -> Result<Self> {
        for length in lengths {
            require("an edge of the box", length, "positive", length > 0.0)?;
        }
        let count = D * (D - 1) / 2;
        require(
            "the number of tilt factors of the box",
            tilt_factors.len() as f64,
            "none, one in a plane or three in space",
            tilt_factors.is_empty() || tilt_factors.len() == count,
        )?;
        let mut tilts = [[0.0; D]; D];
        let above = (0..D).flat_map(|row| (row + 1..D).map(move |column| (row, column)));
        for ((row, column), factor) in above.zip(tilt_factors) {
            require("a tilt factor of the box", *factor, "finite", true)?;
            tilts[row][column] = *factor;
        }
        Ok(Self::of_parts(lengths, tilts))
    }

    fn of_parts(lengths: [f64; D], tilts: [[f64; D]; D]) -> Self {
        Self {
            lengths,
            tilts,
            is_rectangular: tilts.as_flattened().iter().all(|tilt| *tilt == 0.0),
        }
    }

    /// A box with these lengths of its edges and angles between them in degrees: α between the second and the
    /// third, β between the first and the third, γ between the first and the second; in a plane γ.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let rhombohedral = PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3])?;
    /// assert!((rhombohedral.volume() - 0.5_f64.sqrt()).abs() < 1e-12);
    /// assert!(PeriodicBox::with_angles(&[1.0; 3], &[150.0; 3]).is_err(), "no such corner");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) for edges that are not positive, and
    /// angles that no box has.
    pub fn with_angles(edges: &[f64; D], angles_degrees: &[f64]) -> Result<Self> {
        let angles = "the number of angles between the edges";
        let count = D * (D - 1) / 2;
        let given = angles_degrees.len();
        let wanted = "none, one in a plane or three in space";
        require(angles, given as f64, wanted, given == 0 || given == count)?;
        for angle in angles_degrees {
            let holds = *angle > 0.0 && *angle < 180.0;
            let between = "between 0 and 180 degrees";
            require(
                "an angle between the edges of the box",
                *angle,
                between,
                holds,
            )?;
        }
        if angles_degrees.is_empty() {
            return Self::rectangular(*edges);
        }
        // Exact zeros for right angles.
        let cosine = |degrees: f64| match degrees == 90.0 {
            true => 0.0,
            false => degrees.to_radians().cos(),
        };
        let gamma = angles_degrees[count - 1];
        let sine = (1.0 - cosine(gamma).powi(2)).sqrt();
        // Directions of the edges, each of length one.
        // Columns of an upper triangular matrix: x along the first edge, y in the plane of two.
        let mut directions = vec![vec![1.0], vec![cosine(gamma), sine]];
        if let [alpha, beta, _] = angles_degrees {
            // From the scalar products b·c = cos α, with the known parts along x and y.
            let y = (cosine(*alpha) - cosine(*beta) * cosine(gamma)) / sine;
            let squared = 1.0 - cosine(*beta).powi(2) - y * y;
            let solid = "such that three edges meet in a corner: each angle smaller than the sum of \
                the other two, and all three together below 360 degrees";
            let quantity = "the angle between the first two edges of the box";
            require(quantity, gamma, solid, squared > 0.0)?;
            directions.push(vec![cosine(*beta), y, squared.sqrt()]);
        }
        let (mut lengths, mut tilts) = ([0.0; D], [[0.0; D]; D]);
        for (column, direction) in directions.iter().enumerate() {
            lengths[column] = edges[column] * direction[column];
            // N is h with its columns divided by the diagonal.
            for row in 0..column {
                tilts[row][column] = direction[row] / direction[column];
            }
        }
        for edge in edges {
            require("an edge of the box", *edge, "positive", *edge > 0.0)?;
        }
        Ok(Self::of_parts(lengths, tilts))
    }

    /// Extents Lx, Ly, Lz of the rectangular box that is sheared. Without tilt they are the edges.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let sheared = PeriodicBox::with_angles(&[2.0, 2.0], &[30.0])?;
    /// let [width, height] = *sheared.lengths();
    /// assert!((width - 2.0).abs() < 1e-12 && (height - 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn lengths(&self) -> &[f64; D] {
        &self.lengths
    }

    /// Tilt factors xy, xz, yz; in a plane xy.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let sheared = PeriodicBox::with_angles(&[2.0, 2.0], &[45.0])?;
    /// assert!((sheared.tilt_factors()[0] - 1.0).abs() < 1e-12);
    /// assert_eq!(PeriodicBox::rectangular([1.0, 2.0, 3.0])?.tilt_factors(), [0.0; 3]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn tilt_factors(&self) -> Vec<f64> {
        let above = (0..D).flat_map(|row| (row + 1..D).map(move |column| (row, column)));
        above.map(|(row, column)| self.tilts[row][column]).collect()
    }

    /// Whether all angles are right.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// assert!(PeriodicBox::with_angles(&[2.0, 3.0], &[90.0])?.is_rectangular());
    /// assert!(!PeriodicBox::with_angles(&[2.0, 3.0], &[89.0])?.is_rectangular());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn is_rectangular(&self) -> bool {
        self.is_rectangular
    }

    /// The edge vector of this number.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let sheared = PeriodicBox::with_angles(&[2.0, 2.0], &[60.0])?;
    /// assert_eq!(sheared.edge(0), [2.0, 0.0], "the first edge lies along x");
    /// let [x, y] = sheared.edge(1);
    /// assert!((x - 1.0).abs() < 1e-12 && (y - 3.0_f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn edge(&self, number: usize) -> [f64; D] {
        let mut edge = self.tilts.map(|row| row[number] * self.lengths[number]);
        edge[number] = self.lengths[number];
        edge
    }

    /// The smallest of the lengths. Ranges up to half of it meet one image of a place at most.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// assert_eq!(PeriodicBox::rectangular([5.0, 3.0, 4.0])?.smallest_length(), 3.0);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn smallest_length(&self) -> f64 {
        self.lengths.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Volume; in a plane, area.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// assert_eq!(PeriodicBox::rectangular([1.0, 2.0, 3.0])?.volume(), 6.0);
    /// let rhombus = PeriodicBox::with_angles(&[2.0, 2.0], &[30.0])?;
    /// assert!((rhombus.volume() - 2.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn volume(&self) -> f64 {
        self.lengths.iter().product()
    }

    /// The distances between opposite faces, L_k/|row k of the inverse of N|.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let [width, height] = PeriodicBox::with_angles(&[2.0, 2.0], &[30.0])?.heights();
    /// assert!((width - 1.0).abs() < 1e-12 && (height - 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn heights(&self) -> [f64; D] {
        let mut heights = self.lengths;
        for (axis, height) in heights.iter_mut().enumerate() {
            // u = N⁻¹ x by back substitution for each unit vector x.
            let mut squared = 0.0;
            for column in 0..D {
                let mut unit = [0.0; D];
                unit[column] = 1.0;
                // Row `axis` of N⁻¹, one column at a time; its length shortens the height.
                squared += self.unsheared(&unit)[axis].powi(2);
            }
            *height /= squared.sqrt();
        }
        heights
    }

    /// The place u in the rectangular box that shears to x.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// assert_eq!(space.unsheared(&[3.0, 2.0]), [2.0, 2.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn unsheared(&self, place: &[f64; D]) -> [f64; D] {
        let mut straight = *place;
        // Back substitution: later components are straight already.
        for row in (0..D).rev() {
            let tilts = self.tilts[row].iter().zip(straight).skip(row + 1);
            straight[row] -= tilts.map(|(tilt, component)| tilt * component).sum::<f64>();
        }
        straight
    }

    /// The place x = N u.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// assert_eq!(space.sheared(&[2.0, 2.0]), [3.0, 2.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn sheared(&self, straight: &[f64; D]) -> [f64; D] {
        let mut place = *straight;
        for (x, row) in place.iter_mut().zip(&self.tilts) {
            // What is not above the diagonal is zero.
            for (tilt, component) in row.iter().zip(straight) {
                *x += tilt * component;
            }
        }
        place
    }

    /// The place at these parts of the edges.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// assert_eq!(space.point(&[0.5, 0.5]), [2.5, 1.0], "the middle");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn point(&self, parts: &[f64; D]) -> [f64; D] {
        self.sheared(&std::array::from_fn(|axis| {
            parts[axis] * self.lengths[axis]
        }))
    }

    /// Moves a place by whole edge vectors.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// let mut place = [0.0, 0.0];
    /// space.add_edges(&mut place, 1, -2.0);
    /// assert_eq!(place, [-2.0, -4.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn add_edges(&self, place: &mut [f64; D], edge: usize, times: f64) {
        place[edge] += times * self.lengths[edge];
        for (x, row) in place.iter_mut().zip(&self.tilts) {
            *x += times * row[edge] * self.lengths[edge];
        }
    }

    /// The image of a place in the box.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::rectangular([4.0, 2.0])?;
    /// assert_eq!(space.wrap(&[-1.0, 5.0]), [3.0, 1.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn wrap(&self, place: &[f64; D]) -> [f64; D] {
        if self.is_rectangular {
            return std::array::from_fn(|axis| wrapped(place[axis], self.lengths[axis]));
        }
        let mut inside = *place;
        // From the last axis: edges along later axes shift
        // the earlier components, not the other way.
        for axis in (0..D).rev() {
            let part = self.unsheared(&inside)[axis] / self.lengths[axis];
            // Within rounding of a face the place stays, see `ON_FACE`.
            if !(-ON_FACE..=1.0 + ON_FACE).contains(&part) {
                self.add_edges(&mut inside, axis, -part.floor());
            }
        }
        inside
    }

    /// The image of a displacement whose components are shorter than half of the lengths. It is the
    /// shortest one if that is shorter than half of the [smallest length](Self::smallest_length).
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::rectangular([4.0, 10.0])?;
    /// assert_eq!(space.nearest_image(&[3.0, 3.0]), [-1.0, 3.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn nearest_image(&self, displacement: &[f64; D]) -> [f64; D] {
        let mut nearest = *displacement;
        if self.is_rectangular {
            // Rectangular boxes, by far the most frequent,
            // need no dependent steps and are vectorised.
            for (x, length) in nearest.iter_mut().zip(&self.lengths) {
                *x -= length * (*x / length).round();
            }
            return nearest;
        }
        // As in `wrap`: a step along a later axis changes the earlier components.
        for axis in (0..D).rev() {
            let times = (nearest[axis] / self.lengths[axis]).round();
            self.add_edges(&mut nearest, axis, -times);
        }
        nearest
    }

    /// Calls `visit` with every image of a displacement that is shorter than a range, and perhaps with some longer
    /// ones, until it returns `true`; whether it did. Ranges beyond half of the
    /// [smallest length](Self::smallest_length) can meet several images.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::rectangular([2.0, 10.0])?;
    /// let mut images = Vec::new();
    /// space.any_image_within(&[0.5, 9.0], 1.8, |image| {
    ///     images.push(image);
    ///     false
    /// });
    /// assert_eq!(images, [[-1.5, -1.0], [0.5, -1.0]]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn any_image_within(
        &self,
        displacement: &[f64; D],
        range: f64,
        mut visit: impl FnMut([f64; D]) -> bool,
    ) -> bool {
        self.any_image_along(D, displacement, range, &mut visit)
    }

    /// Variant of `any_image_within` for images by the first `axes` edges. Edges have no part along
    /// later axes, so the last of these edges alone decides how far an image is along its axis.
    fn any_image_along(
        &self,
        axes: usize,
        displacement: &[f64; D],
        range: f64,
        visit: &mut impl FnMut([f64; D]) -> bool,
    ) -> bool {
        let Some(axis) = axes.checked_sub(1) else {
            return visit(*displacement);
        };
        let (x, length) = (displacement[axis], self.lengths[axis]);
        // All whole numbers of edges with |x + times · length| ≤ range.
        let mut times = ((-range - x) / length).ceil();
        let last = ((range - x) / length).floor();
        while times <= last {
            let mut image = *displacement;
            self.add_edges(&mut image, axis, times);
            if self.any_image_along(axis, &image, range, visit) {
                return true;
            }
            times += 1.0;
        }
        false
    }

    /// The box after the space has been deformed: x → E x with an upper triangular E, row by row, whose diagonal
    /// is positive.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let square = PeriodicBox::rectangular([2.0, 2.0])?;
    /// let sheared = square.deformed(&[[1.0, 0.25], [0.0, 1.0]]);
    /// assert_eq!((sheared.edge(1), sheared.volume()), ([0.5, 2.0], 4.0));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn deformed(&self, deformation: &[[f64; D]; D]) -> Self {
        let mut lengths = self.lengths;
        for axis in 0..D {
            lengths[axis] *= deformation[axis][axis];
        }
        if self.is_rectangular
            && (0..D).all(|row| deformation[row][row + 1..].iter().all(|x| *x == 0.0))
        {
            return Self::of_parts(lengths, self.tilts);
        }
        // E N diag(L) = (E N diag(E)⁻¹) diag(E L).
        let mut tilts = [[0.0; D]; D];
        for row in 0..D {
            for column in row + 1..D {
                let products = deformation[row].iter().zip(&self.tilts);
                let sum: f64 = products.map(|(part, tilts)| part * tilts[column]).sum();
                tilts[row][column] = (deformation[row][column] + sum) / deformation[column][column];
            }
        }
        Self::of_parts(lengths, tilts)
    }

    /// The same box larger by this factor.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::rectangular([1.0, 2.0, 3.0])?;
    /// assert_eq!(space.scaled(2.0).volume(), 8.0 * space.volume());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn scaled(&self, factor: f64) -> Self {
        Self::of_parts(self.lengths.map(|length| length * factor), self.tilts)
    }

    /// The box made of this many copies along each edge.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let cell = PeriodicBox::new([4.0, 2.0], &[0.5])?;
    /// assert_eq!(cell.repeated(&[1, 3]).edge(1), [3.0, 6.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn repeated(&self, times: &[usize; D]) -> Self {
        let lengths = std::array::from_fn(|axis| self.lengths[axis] * times[axis] as f64);
        Self::of_parts(lengths, self.tilts)
    }

    /// The box itself if its edges overhang little: the part of each along an earlier axis is at most 3/4 of
    /// the length there. Otherwise a box with the same images in which these parts are at most half of it.
    ///
    /// ```
    /// use protomer_kernel::periodic_box::PeriodicBox;
    /// let space = PeriodicBox::new([1.0, 1.0], &[2.25])?;
    /// assert_eq!(space.reduced().tilt_factors(), [0.25]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn reduced(&self) -> Self {
        let overhangs = |row: usize, column: usize, tilts: &[[f64; D]; D]| {
            tilts[row][column] * self.lengths[column] / self.lengths[row]
        };
        let is_little = (0..D).all(|row| {
            (row + 1..D).all(|column| overhangs(row, column, &self.tilts).abs() <= LARGEST_OVERHANG)
        });
        if is_little {
            return *self;
        }
        let mut tilts = self.tilts;
        for column in 0..D {
            for row in (0..column).rev() {
                // Edge `column` less so many times edge `row`.
                let times = overhangs(row, column, &tilts).round();
                let taken = times * self.lengths[row] / self.lengths[column];
                tilts[row][column] -= taken;
                for above in &mut tilts[..row] {
                    above[column] -= taken * above[row];
                }
            }
        }
        Self::of_parts(self.lengths, tilts)
    }
}

/// A coordinate in the box, from 0 to less than its edge.
fn wrapped(x: f64, edge: f64) -> f64 {
    let inside = x.rem_euclid(edge);
    if inside < edge { inside } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    /// A random box, from right angles to edges that overhang several lengths.
    fn random_box<const D: usize>(rng: &mut CounterRng) -> PeriodicBox<D> {
        let lengths = std::array::from_fn(|_| rng.uniform_in(1.0, 3.0));
        let widest = [0.0, 0.6, 5.0][rng.index(3)];
        let tilts = (0..D * (D - 1) / 2).map(|_| rng.uniform_in(-widest, widest));
        PeriodicBox::new(lengths, &tilts.collect::<Vec<_>>()).unwrap()
    }

    fn random_place<const D: usize>(rng: &mut CounterRng, reach: f64) -> [f64; D] {
        std::array::from_fn(|_| rng.uniform_in(-reach, reach))
    }

    fn squared<const D: usize>(vector: &[f64; D]) -> f64 {
        vector.iter().map(|x| x * x).sum()
    }

    /// The images of a displacement by up to so many edges each way.
    fn images<const D: usize>(
        space: &PeriodicBox<D>,
        displacement: &[f64; D],
        most: i32,
    ) -> Vec<[f64; D]> {
        let mut images = vec![*displacement];
        for axis in 0..D {
            let edge = space.edge(axis);
            let mut more = Vec::new();
            for image in &images {
                for times in -most..=most {
                    more.push(std::array::from_fn(|k| {
                        image[k] + f64::from(times) * edge[k]
                    }));
                }
            }
            images = more;
        }
        images
    }

    fn nearest_images_are_those_of_all<const D: usize>() {
        let mut short = 0;
        for number in 0..300 {
            let mut rng = CounterRng::new(1, D as u32, number);
            // Of the reduced box, a few images are enough.
            let space = random_box::<D>(&mut rng);
            let reduced = space.reduced();
            let displacement = random_place(&mut rng, 8.0);
            let inside = reduced.nearest_image(&displacement);
            let all = images(&reduced, &inside, 3);
            let shortest = all.iter().map(squared).fold(f64::INFINITY, f64::min);
            let found = squared(&space.nearest_image(&displacement));
            if shortest.sqrt() < 0.5 * space.smallest_length() {
                assert!(
                    (found - shortest).abs() < 1e-9,
                    "{space:?}: {found} {shortest}"
                );
                short += 1;
            }
            // A displacement whose components are short is its own image.
            let step =
                std::array::from_fn(|axis| 0.499 * inside[axis] / 8.0 * space.lengths()[axis]);
            let mut moved = step;
            space.add_edges(&mut moved, D - 1, 2.0);
            let back = space.nearest_image(&moved);
            let off: [f64; D] = std::array::from_fn(|axis| back[axis] - step[axis]);
            assert!(squared(&off) < 1e-18, "{space:?}");
        }
        assert!(short > 30, "{short}");
    }

    /// Compares ranges from less than half of the smallest length to twice the longest.
    fn images_within_a_range_are_those_of_all<const D: usize>() {
        let (mut one, mut several) = (0, 0);
        for number in 0..300 {
            let mut rng = CounterRng::new(2, D as u32, number);
            let space = random_box::<D>(&mut rng).reduced();
            let range = rng.uniform_in(0.3, 2.0) * space.smallest_length();
            let displacement = space.nearest_image(&random_place(&mut rng, 8.0));
            let is_within = |image: &[f64; D]| squared(image) < range * range;
            let mut expected = images(&space, &displacement, 5);
            expected.retain(is_within);
            let mut found = Vec::new();
            space.any_image_within(&displacement, range, |image| {
                found.extend(Some(image).filter(is_within));
                false
            });
            let order = |a: &[f64; D], b: &[f64; D]| squared(a).total_cmp(&squared(b));
            expected.sort_by(order);
            found.sort_by(order);
            assert_eq!(found.len(), expected.len(), "{space:?} {range}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((squared(found) - squared(expected)).abs() < 1e-9);
            }
            one += usize::from(found.len() == 1);
            several += usize::from(found.len() > 1);
        }
        assert!(one > 30 && several > 30, "{one} {several}");
    }

    #[test]
    fn images_within_a_range_are_found_in_boxes_of_any_shape() {
        images_within_a_range_are_those_of_all::<1>();
        images_within_a_range_are_those_of_all::<2>();
        images_within_a_range_are_those_of_all::<3>();
    }

    #[test]
    fn the_nearest_image_is_the_shortest_of_all() {
        nearest_images_are_those_of_all::<1>();
        nearest_images_are_those_of_all::<2>();
        nearest_images_are_those_of_all::<3>();
    }

    #[test]
    fn places_are_wrapped_into_the_box_and_stay_there() {
        for number in 0..300 {
            let mut rng = CounterRng::new(2, 0, number);
            let space = random_box::<3>(&mut rng);
            let place = random_place(&mut rng, 9.0);
            let inside = space.wrap(&place);
            let straight = space.unsheared(&inside);
            for (along, length) in straight.iter().zip(space.lengths()) {
                let part = along / length;
                assert!((-1e-11..1.0 + 1e-11).contains(&part), "{part}");
            }
            assert_eq!(space.wrap(&inside), inside);
            let moved: [f64; 3] = std::array::from_fn(|axis| inside[axis] - place[axis]);
            let off = squared(&space.nearest_image(&moved));
            assert!(off < 1e-18, "{off}");
            let again = space.sheared(&straight);
            assert!((0..3).all(|axis| (again[axis] - inside[axis]).abs() < 1e-12));
        }
        // A corner, whichever way it was rounded.
        let space = PeriodicBox::<2>::with_angles(&[1.0, 1.0], &[60.0]).unwrap();
        for off in [-1e-17, 0.0, 1e-17] {
            let once = space.wrap(&[1.5 + off, space.lengths()[1] + off]);
            assert_eq!(space.wrap(&once), once);
        }
    }

    #[test]
    fn a_reduced_box_has_the_same_images_and_overhangs_little() {
        for number in 0..300 {
            let mut rng = CounterRng::new(3, 0, number);
            let space = random_box::<3>(&mut rng);
            let reduced = space.reduced();
            assert_eq!(reduced.reduced(), reduced);
            assert_eq!(reduced.lengths(), space.lengths());
            for axis in 0..3 {
                // Each edge of the one is a translation of the other.
                for (one, other) in [(&space, &reduced), (&reduced, &space)] {
                    let left = squared(&one.nearest_image(&other.edge(axis)));
                    assert!(left < 1e-18, "{space:?}: {left}");
                }
                let edge = reduced.edge(axis);
                for (part, length) in edge.iter().zip(reduced.lengths()).take(axis) {
                    assert!(part.abs() <= 0.75 * length + 1e-12);
                }
            }
        }
    }

    #[test]
    fn heights_are_the_distances_between_faces() {
        let space = PeriodicBox::<3>::with_angles(&[1.0; 3], &[60.0; 3]).unwrap();
        for height in space.heights() {
            assert!((height - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{height}");
        }
        assert!((space.volume() - 0.5_f64.sqrt()).abs() < 1e-12);
        let plane = PeriodicBox::<2>::new([2.0, 1.0], &[1.0]).unwrap();
        assert!((plane.heights()[0] - 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((plane.heights()[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn angles_and_edges_are_those_asked_for() {
        let edges = [2.0, 3.0, 4.0];
        let angles = [70.0, 80.0, 100.0];
        let space = PeriodicBox::with_angles(&edges, &angles).unwrap();
        for (number, [one, other]) in [[1, 2], [0, 2], [0, 1]].into_iter().enumerate() {
            let [a, b] = [space.edge(one), space.edge(other)];
            assert!((squared(&a).sqrt() - edges[one]).abs() < 1e-12);
            let dot: f64 = (0..3).map(|axis| a[axis] * b[axis]).sum();
            let angle = (dot / (edges[one] * edges[other])).acos().to_degrees();
            assert!((angle - angles[number]).abs() < 1e-10, "{angle}");
        }
        let right = PeriodicBox::with_angles(&edges, &[90.0; 3]).unwrap();
        assert!(right.is_rectangular());
        for angles in [&[60.0, 60.0, 130.0][..], &[0.0, 90.0, 90.0], &[90.0]] {
            assert!(
                PeriodicBox::with_angles(&edges, angles).is_err(),
                "{angles:?}"
            );
        }
        assert!(PeriodicBox::<2>::new([1.0, 0.0], &[]).is_err());
        assert!(PeriodicBox::<2>::new([1.0, 1.0], &[0.1, 0.2]).is_err());
        assert!(PeriodicBox::<2>::new([1.0, 1.0], &[f64::NAN]).is_err());
    }

    /// Compares the edges with E h, column by column.
    #[test]
    fn a_deformed_box_has_the_deformed_edges() {
        for number in 0..100 {
            let mut rng = CounterRng::new(4, 0, number);
            let space = random_box::<3>(&mut rng);
            let mut deformation = [[0.0; 3]; 3];
            for (number, row) in deformation.iter_mut().enumerate() {
                row[number] = rng.uniform_in(0.5, 2.0);
                row[number + 1..].fill_with(|| rng.uniform_in(-1.0, 1.0));
            }
            let deformed = space.deformed(&deformation);
            for edge in 0..3 {
                let [before, after] = [space.edge(edge), deformed.edge(edge)];
                for row in 0..3 {
                    let expected: f64 = (0..3).map(|k| deformation[row][k] * before[k]).sum();
                    assert!((after[row] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn lengths_and_tilt_factors_say_all() {
        let mut rng = CounterRng::new(5, 0, 0);
        for _ in 0..30 {
            let space = random_box::<3>(&mut rng);
            let again = PeriodicBox::new(*space.lengths(), &space.tilt_factors());
            assert_eq!(again.unwrap(), space);
        }
    }
}
