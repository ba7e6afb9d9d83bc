//! Convex pieces, and bodies that are made of several of them and need not be convex.
//!
//! Two such bodies overlap if a piece of one overlaps a piece of the other. Most are apart already by their convex
//! hulls, which are tested first, as convex bodies are. Where distances between centres
//! change by a factor, each pair of pieces overlaps over one interval of factors, because the difference of
//! two convex pieces is convex; its near end is found by walking from plane to plane, each of which separates the
//! pieces where it was found (after van den Bergen, *Ray casting against general convex objects with
//! application to continuous collision detection*, 2004).
//!
//! With pieces every test stays one of convex bodies and is exact at contact, and depletants, walls
//! and pressures need nothing else. A mesh of the surface would not tell what lies inside the body.

use crate::body::{is_within, norm};
use crate::{Error, Result};
use protomer_kernel::Vec3;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::exact::overlap_exactly;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Block, LANES, Pair, dot, error_of_heights, minus, pack};
use std::ops::Range;

/// Pieces that no longer overlap when each is smaller by this part touch.
const TOUCHING: f64 = 1e-6;
/// The walk towards a contact takes steps of at least this part of its range, and so overshoots by less.
const LEAST_STEP: f64 = 1e-4;

/// A convex shape, rounded or not.
#[derive(Debug, Clone)]
pub struct Piece<const D: usize> {
    /// The corners from the centre of the piece.
    pub corners: Vec<[f64; D]>,
    /// The corners of each face; in a plane, of each edge.
    pub faces: Vec<Vec<usize>>,
    /// Centre of the piece, in the coordinates of the shape; in a body, from the centre of the
    /// body.
    pub centre: [f64; D],
    /// Radius of a ball about the centre of the piece that fits in.
    pub inner_radius: f64,
    /// Radius of the ball about the centre of the piece that holds it.
    pub outer_radius: f64,
    /// Volume; in a plane, area.
    pub volume: f64,
}

impl<const D: usize> Piece<D> {
    /// The Minkowski sum of a shape and a ball of this radius.
    pub(crate) fn new(shape: &Shape, rounding_radius: f64) -> Result<Self> {
        if shape.dimension() != D {
            return Err(Error::Dimension {
                shape: shape.dimension(),
                space: D,
            });
        }
        let measures = Measures::from_shape(shape, rounding_radius)?;
        // Corners from the centroid, whose place in the shape is kept.
        let (corners, faces, centre, inradius) = match Polytope::placed(shape) {
            Ok((polytope, centre)) => (
                polytope.corners.iter().map(coordinates).collect(),
                polytope
                    .faces
                    .iter()
                    .map(|face| face.corners.clone())
                    .collect(),
                coordinates(&centre),
                polytope.inradius(),
            ),
            // A point, a segment or a polygon in space, which only its rounding makes a body.
            Err(_) => {
                let (corners, mean) = thin_corners(shape);
                (corners, Vec::new(), mean, 0.0)
            }
        };
        let outer: f64 = corners.iter().map(norm).fold(0.0, f64::max);
        Ok(Self {
            corners,
            faces,
            centre,
            inner_radius: inradius + rounding_radius,
            outer_radius: outer + rounding_radius,
            volume: measures.volume,
        })
    }
}

/// Pieces about the centre of mass of all.
///
/// Packed, a body has the corners of its hull, those of each piece from the centre of that piece, and then the
/// centres of the pieces.
#[derive(Debug, Clone)]
pub struct Pieces<const D: usize> {
    pieces: Vec<Piece<D>>,
    /// Corners of the convex hull of all, from the centre of the body.
    hull: Vec<[f64; D]>,
    /// The blocks of each piece.
    blocks: Vec<Range<usize>>,
    rounding_radius: f64,
}

/// A piece of a body that has been turned.
struct Turned<'a, const D: usize> {
    piece: &'a Piece<D>,
    corners: &'a [Block<D>],
    centre: [f64; D],
}

impl<const D: usize> Pieces<D> {
    pub(crate) fn new(mut pieces: Vec<Piece<D>>, rounding_radius: f64) -> Result<Self> {
        // Weighted by volumes: the centre of mass of all.
        let volume: f64 = pieces.iter().map(|piece| piece.volume).sum();
        let mut centre = [0.0; D];
        for piece in &pieces {
            for (axis, x) in centre.iter_mut().enumerate() {
                *x += piece.volume / volume * piece.centre[axis];
            }
        }
        for piece in &mut pieces {
            piece.centre = minus(&piece.centre, &centre);
        }
        let hull = hull(&pieces)?;
        // Blocks of a packed body: hull, pieces, centres of the pieces.
        let mut blocks = Vec::new();
        let mut first = pack(&hull).len();
        for piece in &pieces {
            let after = first + pack(&piece.corners).len();
            blocks.push(first..after);
            first = after;
        }
        let pieces = Self {
            pieces,
            hull,
            blocks,
            rounding_radius,
        };
        pieces.check_apart()?;
        Ok(pieces)
    }

    /// The volume of the body is the sum of those of its pieces, so these must not overlap.
    fn check_apart(&self) -> Result<()> {
        let smaller = 1.0 - TOUCHING;
        let shrunk = |piece: &Piece<D>| {
            let corners = piece
                .corners
                .iter()
                .map(|corner| corner.map(|x| smaller * x));
            pack(&corners.collect::<Vec<_>>())
        };
        // Each pair once. Shrunk a little, as pieces that share a face touch.
        for (first, a) in self.pieces.iter().enumerate() {
            for (second, b) in self.pieces.iter().enumerate().skip(first + 1) {
                let offset = minus(&b.centre, &a.centre);
                let (shrunk_first, shrunk_second) = (shrunk(a), shrunk(b));
                let pair = Pair {
                    first: &shrunk_first,
                    second: &shrunk_second,
                    offset,
                    reach: 2.0 * smaller * self.rounding_radius,
                    error: error_of_heights(
                        4.0 * D as f64 * (norm(&offset) + a.outer_radius + b.outer_radius),
                    ),
                };
                // Pieces with the same centre overlap, and give the search no direction to begin with.
                if norm(&offset) == 0.0 || pair.overlap(&mut { offset }, || true) {
                    return Err(Error::Pieces {
                        pieces: [first + 1, second + 1],
                    });
                }
            }
        }
        Ok(())
    }

    /// The pieces, where they are in the body before it is turned.
    pub fn pieces(&self) -> &[Piece<D>] {
        &self.pieces
    }

    /// All corners, from the centre of the body.
    pub(crate) fn corners(&self) -> Vec<[f64; D]> {
        corners_of(&self.pieces)
    }

    /// Corners of the convex hull, from the centre of the body.
    pub(crate) fn hull(&self) -> &[[f64; D]] {
        &self.hull
    }

    /// Blocks of the corners of the hull; they are the first of a packed body.
    pub(crate) fn hull_blocks(&self) -> usize {
        self.hull.len().div_ceil(LANES)
    }

    pub(crate) fn pack(&self) -> Vec<Block<D>> {
        let mut blocks = pack(&self.hull);
        for piece in &self.pieces {
            blocks.extend(pack(&piece.corners));
        }
        let centres: Vec<[f64; D]> = self.pieces.iter().map(|piece| piece.centre).collect();
        blocks.extend(pack(&centres));
        blocks
    }

    pub(crate) fn volume(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.volume).sum()
    }

    /// Radius of a ball about the centre of the body that fits into one of its pieces, or zero.
    pub(crate) fn inner_radius(&self) -> f64 {
        let depths = self.pieces.iter();
        depths
            .map(|piece| piece.inner_radius - norm(&piece.centre))
            .fold(0.0, f64::max)
    }

    fn turned<'a>(&'a self, packed: &'a [Block<D>]) -> impl Iterator<Item = Turned<'a, D>> {
        let centres = &packed[self.blocks.last().map_or(0, |last| last.end)..];
        let numbered = self.pieces.iter().zip(&self.blocks).enumerate();
        numbered.map(move |(number, (piece, blocks))| Turned {
            piece,
            corners: &packed[blocks.clone()],
            // Centres are packed like corners: block number / 4, lane number % 4.
            centre: std::array::from_fn(|axis| centres[number / LANES][axis][number % LANES]),
        })
    }

    /// Whether two bodies overlap, given their turned corners and the vector between their centres.
    pub(crate) fn overlap(
        &self,
        others: &Self,
        first: &[Block<D>],
        second: &[Block<D>],
        offset: &[f64; D],
        error: f64,
    ) -> bool {
        self.turned(first).any(|a| {
            let to_second = minus(offset, &a.centre);
            others.turned(second).any(|b| {
                let between = plus(&to_second, &b.centre);
                let outer = a.piece.outer_radius + b.piece.outer_radius;
                // Spheres around both pieces: most pairs of pieces end here.
                if dot(&between, &between) >= outer * outer {
                    return false;
                }
                let pair = self.pair(others, &a, &b, between, error);
                pair.overlap(&mut { between }, || self.exact(others, &pair, &a, &b))
            })
        })
    }

    fn pair<'a>(
        &self,
        others: &Self,
        first: &Turned<'a, D>,
        second: &Turned<'a, D>,
        offset: [f64; D],
        error: f64,
    ) -> Pair<'a, D> {
        Pair {
            first: first.corners,
            second: second.corners,
            offset,
            reach: self.rounding_radius + others.rounding_radius,
            error,
        }
    }

    /// Decides whether two pieces that touch to within rounding overlap.
    fn exact(
        &self,
        others: &Self,
        pair: &Pair<'_, D>,
        first: &Turned<'_, D>,
        second: &Turned<'_, D>,
    ) -> bool {
        let faces = [first, second].map(|turned_piece| turned_piece.piece.faces.as_slice());
        // Rounded pieces and those without faces have no
        // exact predicate; touching counts as overlap.
        let is_rounded = self.rounding_radius > 0.0 || others.rounding_radius > 0.0;
        if is_rounded || faces.iter().any(|faces| faces.is_empty()) {
            return true;
        }
        overlap_exactly(pair, faces)
    }

    /// Whether a point, from the centre of the body, is within a radius of it.
    pub(crate) fn cover(&self, corners: &[Block<D>], point: &[f64; D], radius: f64) -> bool {
        self.turned(corners).any(|turned_piece| {
            let from_piece = minus(point, &turned_piece.centre);
            let outer = turned_piece.piece.outer_radius + radius;
            // The ball around the piece, widened, before its corners.
            dot(&from_piece, &from_piece) < outer * outer
                && is_within(
                    turned_piece.corners,
                    &from_piece,
                    self.rounding_radius + radius,
                )
        })
    }

    /// The smallest change of the factor on the way between two bodies that do not overlap, up to a largest, at
    /// which they do: a factor that falls from one (`sign` is -1) or rises (1).
    pub(crate) fn first_contact(
        &self,
        others: &Self,
        [first, second]: [&[Block<D>]; 2],
        offset: &[f64; D],
        sign: f64,
        largest: f64,
        error: f64,
    ) -> Option<f64> {
        let mut nearest = None;
        let mut range = largest;
        for a in self.turned(first) {
            for b in others.turned(second) {
                let apart = minus(&b.centre, &a.centre);
                let separation =
                    |change: f64| plus(&offset.map(|x| x * (1.0 + sign * change)), &apart);
                let outer = a.piece.outer_radius + b.piece.outer_radius;
                // The whole way from now to the limit, as a segment, keeps the spheres apart.
                if least_distance_squared(&separation(0.0), &separation(range)) >= outer * outer {
                    continue;
                }
                let pair = |change: f64| self.pair(others, &a, &b, separation(change), error);
                let velocity = offset.map(|x| x * sign);
                if let Some(first_change) = contact(pair, &velocity, range, LEAST_STEP * largest) {
                    // Later pairs only matter if they meet earlier.
                    range = first_change;
                    nearest = Some(first_change);
                }
            }
        }
        nearest
    }
}

/// All corners of pieces, from the centre of the body.
fn corners_of<const D: usize>(pieces: &[Piece<D>]) -> Vec<[f64; D]> {
    let mut corners = Vec::new();
    for piece in pieces {
        for corner in &piece.corners {
            corners.push(plus(corner, &piece.centre));
        }
    }
    corners
}

/// The corners of the convex hull of pieces.
fn hull<const D: usize>(pieces: &[Piece<D>]) -> Result<Vec<[f64; D]>> {
    let corners = corners_of(pieces);
    let shape = match D {
        2 => Shape::flat(&corners.iter().map(|x| [x[0], x[1]]).collect::<Vec<_>>())?,
        _ => {
            let point = |corner: &[f64; D]| Vec3::from_fn(|axis, _| corner[axis]);
            Shape::solid(&corners.iter().map(point).collect::<Vec<_>>())?
        }
    };
    Ok(shape.corner_points().iter().map(coordinates).collect())
}

/// Change at which two pieces first overlap while the offset changes along a velocity.
fn contact<'a, const D: usize>(
    pair: impl Fn(f64) -> Pair<'a, D>,
    velocity: &[f64; D],
    range: f64,
    least_step: f64,
) -> Option<f64> {
    let mut change = 0.0;
    let mut direction = pair(0.0).offset;
    while change < range {
        let current_pair = pair(change);
        // Touching ends the walk: the bodies meet here.
        if current_pair.overlap(&mut direction, || true) {
            return Some(change);
        }
        // The plane that separates them moves towards the second piece with this velocity.
        // Speed at which the gap along this direction closes.
        let closing = -dot(velocity, &direction) / norm(&direction);
        // They move apart across the plane that separates them: never.
        if closing <= 0.0 {
            return None;
        }
        // To where the plane would be reached; at least a step, as gaps shrink ever more slowly.
        change += (current_pair.gap_along(&direction) / closing).max(least_step);
    }
    None
}

/// The square of the distance of the origin from a segment.
fn least_distance_squared<const D: usize>(from: &[f64; D], to: &[f64; D]) -> f64 {
    let displacement = minus(to, from);
    let length = dot(&displacement, &displacement);
    let part = match length > 0.0 {
        true => (-dot(from, &displacement) / length).clamp(0.0, 1.0),
        false => 0.0,
    };
    let nearest = plus(from, &displacement.map(|x| part * x));
    dot(&nearest, &nearest)
}

fn plus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

fn coordinates<const D: usize>(vector: &Vec3) -> [f64; D] {
    std::array::from_fn(|axis| vector[axis])
}

/// Corners of a shape without volume from their mean, and the mean.
fn thin_corners<const D: usize>(shape: &Shape) -> (Vec<[f64; D]>, [f64; D]) {
    let corners = shape.corner_points();
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
    let from_mean = corners.iter().map(|corner| coordinates(&(corner - mean)));
    (from_mean.collect(), coordinates(&mean))
}

#[cfg(test)]
mod tests {
    use crate::body::HardBody;
    use protomer_kernel::random::{CounterRng, Purpose};
    use protomer_kernel::shape::Shape;
    use protomer_kernel::shape::separation::matrix;
    use protomer_kernel::shape::separation::{Block, turn};
    use protomer_kernel::{Rotation, Vec3};
    use std::f64::consts::TAU;

    /// The slow twin: overlaps at every one of many factors, one after the other.
    #[test]
    fn first_contacts_are_those_of_a_scan() {
        let bar = |x: [f64; 2], y: [f64; 2]| {
            Shape::flat(&[[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]).unwrap()
        };
        let horseshoe = [
            bar([0.0, 1.2], [0.0, 0.1]),
            bar([0.0, 0.1], [0.1, 1.7]),
            bar([1.1, 1.2], [0.1, 1.7]),
        ];
        let body = HardBody::<2>::of_pieces(&horseshoe, 0.0).unwrap();
        let pieces = body.pieces().unwrap();
        let error = body.error_of_heights(&body);
        let mut rng = CounterRng::for_purpose(4, 0, 0, Purpose::HardBodyStart);
        let (largest, scans) = (0.2, 500);
        let mut contacts = [0, 0];
        for _ in 0..12_000 {
            let packed: [Vec<Block<2>>; 2] = [0, 1].map(|_| {
                let rotation = Rotation::from_scaled_axis(TAU * rng.uniform() * Vec3::z());
                let mut corners = vec![[[0.0; 4]; 2]; body.blocks()];
                turn(&matrix(&rotation), &pieces.pack(), &mut corners);
                corners
            });
            let offset: [f64; 2] = std::array::from_fn(|_| rng.uniform_in(-1.5, 1.5));
            let overlap = |factor: f64| {
                let offset = offset.map(|x| x * factor);
                pieces.overlap(pieces, &packed[0], &packed[1], &offset, error)
            };
            if overlap(1.0) {
                continue;
            }
            for (kind, sign) in [(0, -1.0), (1, 1.0)] {
                let corners = [&packed[0][..], &packed[1][..]];
                let found = pieces.first_contact(pieces, corners, &offset, sign, largest, error);
                let mut steps =
                    (1..=scans).map(|step| largest * f64::from(step) / f64::from(scans));
                let scanned = steps.find(|change| overlap(1.0 + sign * change));
                contacts[kind] += usize::from(found.is_some());
                // A scan steps over overlaps that are shorter than its steps, never ahead of a contact.
                let step = largest / f64::from(scans);
                match (found, scanned) {
                    (Some(found), Some(scanned)) if found < scanned - 2.0 * step => {
                        assert!(overlap(1.0 + sign * found), "{found} {scanned}");
                    }
                    (Some(found), Some(scanned)) => assert!(found < scanned + step),
                    (Some(found), None) => assert!(overlap(1.0 + sign * found), "{found}"),
                    (None, scanned) => assert_eq!(scanned, None),
                }
            }
        }
        assert!(contacts[0] > 200 && contacts[1] > 20, "{contacts:?}");
    }
}
