//! Virial coefficients of hard bodies that have no closed form: the third one, and the second one among
//! depletants.
//!
//! **Third.** B3 = ⅓ ∫∫ ⟨o₁₂ o₁₃ o₂₃⟩ over the places of two bodies relative to a first, with o = 1
//! where a pair overlaps. Places of one body that overlaps the first fill 2 B2 on average, so that
//!
//! B3 = 4/3 B2² p,
//!
//! with the probability p that two bodies overlap which overlap the first (spheres: p = 15/32, B3 = 5/8 B2²; disks:
//! B3/B2² = 4/3 - √3/π). Both are drawn uniformly from a ball that holds all such places until they do.
//!
//! **Second, among depletants.** Penetrable depletants of number density n in a reservoir multiply the weight of a
//! pair by exp(n v), where v is the volume that both bodies close to their centres ([`swept`]), so that
//!
//! B2 = B2(hard) - ½ ∫ ⟨exp(Σ n v) - 1⟩ over places without overlap.
//!
//! On a ray from the first body, with the second in a random orientation, convex bodies are apart beyond one
//! distance, and share no volume beyond another. Between them the integral is done by a Gauss rule; the mean and the
//! error are those over rays. A line along the ray meets each swept body in an interval, and where the second body
//! moves along the ray, so does its interval. So v is a sum over lines whose intervals are found once for all
//! distances. The lines pierce the plane across the ray in a Fibonacci lattice, which is right to about 10⁻³ of v;
//! a random turn of it for each ray lets these errors average out.
//!
//! [`swept`]: protomer_kernel::shape::swept

use crate::body::HardBody;
use crate::reservoir::{Depletant, ball_volume};
use crate::{Error, Result};
use protomer_kernel::bisection::halved;
use protomer_kernel::quadrature::{Node, gauss_legendre};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::separation::{Block, minus};
use protomer_kernel::shape::swept::Swept;
use protomer_kernel::{Pose, Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Draws of a neighbour before a body is called too slender: one of a million places overlaps.
const MOST_DRAWS: u64 = 10_000_000;
/// Nodes of the rule between two distances at which a kind of depletant begins to act.
const NODES: usize = 12;
/// Lines along a ray.
const LINES: usize = 4000;
/// Halvings that find a distance.
const HALVINGS: u32 = 50;

/// Result of one draw of three bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Triple {
    /// Places that were drawn until two bodies overlapped the first.
    pub draws: u64,
    /// Whether these two overlap each other.
    pub overlaps: bool,
}

/// Counts over many triples.
///
/// ```
/// use protomer_hpmc::virial::{Triple, Triples};
/// let triples = Triples::default().with(Triple { draws: 5, overlaps: true });
/// let more = Triples::default().with(Triple { draws: 3, overlaps: false });
/// let all = triples.merge(more);
/// assert_eq!((all.count, all.overlapping, all.draws), (2, 1, 8));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Triples {
    /// Number of triples.
    pub count: u64,
    /// Triples in which all pairs overlap.
    pub overlapping: u64,
    /// Places that were drawn.
    pub draws: u64,
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Standard error.
    pub error: f64,
}

/// Second and third virial coefficient from triples of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledVirials {
    /// Second virial coefficient.
    pub b2: Estimate,
    /// Third virial coefficient over the square of the second.
    pub b3_over_b2_squared: Estimate,
}

/// Draws the triple of a number; equal numbers and seeds give equal triples.
///
/// # Errors
/// [`Error::TooSlender`] for a body of whose ball its neighbours fill less than a millionth.
pub fn draw_triple<const D: usize>(body: &HardBody<D>, seed: u64, number: u64) -> Result<Triple> {
    let mut rng = CounterRng::for_purpose(seed, 0, number, Purpose::VirialTriple);
    let mut still = vec![[[0.0; 4]; D]; body.blocks()];
    body.turned_into(&Rotation::identity(), &mut still);
    let second = Neighbour::draw(body, &still, &mut rng)?;
    let third = Neighbour::draw(body, &still, &mut rng)?;
    let offset = minus(&third.place, &second.place);
    Ok(Triple {
        draws: second.draws + third.draws,
        overlaps: body.overlaps_at(body, &second.corners, &third.corners, &offset),
    })
}

/// A body that overlaps the one at the origin.
struct Neighbour<const D: usize> {
    corners: Vec<Block<D>>,
    place: [f64; D],
    draws: u64,
}

impl<const D: usize> Neighbour<D> {
    fn draw(body: &HardBody<D>, still: &[Block<D>], rng: &mut CounterRng) -> Result<Self> {
        let mut corners = still.to_vec();
        for draws in 1..=MOST_DRAWS {
            let place = place_in_ball(2.0 * body.outer_radius, rng);
            body.turned_into(&random_rotation::<D>(rng), &mut corners);
            if body.overlaps_at(body, still, &corners, &place) {
                return Ok(Self {
                    corners,
                    place,
                    draws,
                });
            }
        }
        Err(Error::TooSlender)
    }
}

fn place_in_ball<const D: usize>(radius: f64, rng: &mut CounterRng) -> [f64; D] {
    let direction = random_direction::<D>(rng);
    let distance = radius * rng.uniform().powf(1.0 / D as f64);
    std::array::from_fn(|axis| distance * direction[axis])
}

/// A random direction; in a plane, in that of the first two axes.
fn random_direction<const D: usize>(rng: &mut CounterRng) -> Vec3 {
    match D {
        2 => {
            let (sine, cosine) = (TAU * rng.uniform()).sin_cos();
            Vec3::new(cosine, sine, 0.0)
        }
        _ => rng.unit_vector(),
    }
}

fn random_rotation<const D: usize>(rng: &mut CounterRng) -> Rotation {
    match D {
        2 => Rotation::from_scaled_axis(TAU * rng.uniform() * Vec3::z()),
        _ => rng.rotation(),
    }
}

impl Triples {
    /// Counts a triple.
    pub fn with(mut self, triple: Triple) -> Self {
        self.count += 1;
        self.draws += triple.draws;
        self.overlapping += u64::from(triple.overlaps);
        self
    }

    /// Adds the counts of another stream.
    pub fn merge(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            overlapping: self.overlapping + other.overlapping,
            draws: self.draws + other.draws,
        }
    }

    /// The coefficients of the body that the triples are of. Their errors are independent: the number of
    /// draws says nothing about the places that end them.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, virial::{Triples, draw_triple}};
    /// let ball = HardBody::<3>::ball(0.5)?;
    /// let mut triples = Triples::default();
    /// for number in 0..4000 {
    ///     triples = triples.with(draw_triple(&ball, 1, number)?);
    /// }
    /// let found = triples.virials(&ball).b3_over_b2_squared;
    /// assert!((found.mean - 0.625).abs() < 4.0 * found.error);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn virials<const D: usize>(&self, body: &HardBody<D>) -> SampledVirials {
        let count = self.count as f64;
        let accepted = 2.0 * count / self.draws as f64;
        let half_ball = 0.5 * ball_volume(D, 2.0 * body.outer_radius);
        let part = self.overlapping as f64 / count;
        // None or all overlapping does not make it certain: the error is that of one triple more or less.
        let uncertain = part.max(1.0 / count).min(1.0 - 1.0 / count);
        SampledVirials {
            b2: Estimate {
                mean: half_ball * accepted,
                error: half_ball * accepted * ((1.0 - accepted) / (2.0 * count)).sqrt(),
            },
            b3_over_b2_squared: Estimate {
                mean: 4.0 / 3.0 * part,
                error: 4.0 / 3.0 * (uncertain * (1.0 - uncertain) / count).sqrt(),
            },
        }
    }
}

/// Two convex bodies, each rounded, among depletants.
#[derive(Debug, Clone)]
pub struct DepletedPair<'a> {
    shapes: [&'a Shape; 2],
    roundings: [f64; 2],
    depletants: &'a [Depletant],
    /// Corners of both about their centroids.
    corners: [Vec<Vec3>; 2],
    nodes: Vec<Node>,
}

impl<'a> DepletedPair<'a> {
    /// A pair of shapes of one dimension, with the radii by which they are rounded.
    ///
    /// # Errors
    /// For shapes of different dimensions, radii and densities that are negative or not finite.
    pub fn new(
        shapes: [&'a Shape; 2],
        roundings: [f64; 2],
        depletants: &'a [Depletant],
    ) -> Result<Self> {
        if shapes[0].dimension() != shapes[1].dimension() {
            return Err(Error::Dimension {
                shape: shapes[1].dimension(),
                space: shapes[0].dimension(),
            });
        }
        for kind in depletants {
            kind.check()?;
        }
        let corners = |which: usize| -> Result<Vec<Vec3>> {
            let swept = Swept::new(shapes[which], roundings[which], &Pose::identity())?;
            Ok(swept.corners().to_vec())
        };
        Ok(Self {
            shapes,
            roundings,
            depletants,
            corners: [corners(0)?, corners(1)?],
            nodes: gauss_legendre(NODES),
        })
    }

    /// Reduction of the second virial coefficient by depletants, along the ray of this number; the
    /// mean over rays is the integral. Infinite where they hold the bodies together too strongly
    /// for numbers.
    ///
    /// # Errors
    /// As [`Swept::new`].
    pub fn on_ray(&self, seed: u64, number: u64) -> Result<f64> {
        let mut rng = CounterRng::for_purpose(seed, 0, number, Purpose::VirialRay);
        let dimension = self.shapes[0].dimension();
        let (direction, rotation, sphere) = match dimension {
            2 => (
                random_direction::<2>(&mut rng),
                random_rotation::<2>(&mut rng),
                TAU,
            ),
            _ => (
                random_direction::<3>(&mut rng),
                random_rotation::<3>(&mut rng),
                4.0 * PI,
            ),
        };
        let ray = Ray {
            pair: self,
            direction,
            rotation,
        };
        let phase = rng.uniform();
        let lines = self.depletants.iter().map(|kind| ray.lines(kind, phase));
        let lines = lines.collect::<Result<Vec<_>>>()?;
        let mut ends = vec![ray.distance_at_gap(0.0)];
        ends.extend(
            self.depletants
                .iter()
                .map(|kind| ray.distance_at_gap(2.0 * kind.radius)),
        );
        ends.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for ends in ends.windows(2) {
            let half = 0.5 * (ends[1] - ends[0]);
            for node in &self.nodes {
                let distance = ends[0] + half * (1.0 + node.place);
                let measure = distance.powi(dimension as i32 - 1);
                sum += half * node.weight * measure * exponent(&lines, distance).exp_m1();
            }
        }
        Ok(0.5 * sphere * sum)
    }
}

/// Places of the second body along a direction, in one orientation.
struct Ray<'a> {
    pair: &'a DepletedPair<'a>,
    direction: Vec3,
    rotation: Rotation,
}

impl Ray<'_> {
    fn pose(&self, distance: f64) -> Pose {
        Pose {
            position: distance * self.direction,
            rotation: self.rotation,
        }
    }

    /// Distance of the surfaces; zero where they overlap.
    fn gap(&self, distance: f64) -> f64 {
        let pose = self.pose(distance);
        let [first, second] = &self.pair.corners;
        let second: Vec<Vec3> = second.iter().map(|x| pose.transform_point(x)).collect();
        let cores = closest_points(first, &second).map_or(0.0, |points| points.distance());
        (cores - self.pair.roundings[0] - self.pair.roundings[1]).max(0.0)
    }

    /// The distance of the centres beyond which the surfaces are farther apart than a gap. Convex bodies whose
    /// centroids leave each other do not meet again.
    fn distance_at_gap(&self, gap: f64) -> f64 {
        let outer = |corners: &[Vec3]| corners.iter().map(Vec3::norm).fold(0.0, f64::max);
        let reach: f64 = self.pair.corners.iter().map(|corners| outer(corners)).sum();
        let farthest = reach + self.pair.roundings[0] + self.pair.roundings[1] + gap;
        halved([farthest, 0.0], HALVINGS, |distance| {
            self.gap(distance) > gap
        })[0]
    }

    /// Lines along the ray through both bodies swept by a kind of depletant.
    fn lines(&self, kind: &Depletant, phase: f64) -> Result<Lines> {
        let swept = |which: usize, pose: &Pose| {
            let radius = self.pair.roundings[which] + kind.radius;
            Swept::new(self.pair.shapes[which], radius, pose)
        };
        let (first, second) = (swept(0, &Pose::identity())?, swept(1, &self.pose(0.0))?);
        let reach = [(&first, 0), (&second, 1)].map(|(swept, which)| {
            let corners = swept.corners().iter();
            let distances = corners.map(|corner| corner.cross(&self.direction).norm());
            distances.fold(0.0, f64::max) + self.pair.roundings[which] + kind.radius
        });
        let places = Places {
            reach: reach[0].min(reach[1]),
            direction: self.direction,
        };
        let (places, share) = match self.pair.shapes[0].dimension() {
            2 => places.on_segment(phase),
            _ => places.on_disk(phase),
        };
        let mut intervals = Vec::new();
        for place in places {
            let met = [&first, &second].map(|swept| swept.interval(&place, &self.direction));
            if let [Some(first), Some(second)] = met {
                intervals.push([first, second]);
            }
        }
        Ok(Lines {
            intervals,
            weight: kind.fugacity * share,
        })
    }
}

/// Places where lines pierce the plane across a direction.
struct Places {
    reach: f64,
    direction: Vec3,
}

impl Places {
    /// A Fibonacci lattice on a disk, and the area that each place stands for.
    fn on_disk(&self, phase: f64) -> (Vec<Vec3>, f64) {
        let axis = Vec3::ith(self.direction.iamin(), 1.0);
        let x = self.direction.cross(&axis).normalize();
        let y = self.direction.cross(&x);
        let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
        let place = |number: usize| {
            let radius = self.reach * ((number as f64 + 0.5) / LINES as f64).sqrt();
            let (sine, cosine) = (golden_angle * number as f64 + TAU * phase).sin_cos();
            radius * (cosine * x + sine * y)
        };
        let area = PI * self.reach * self.reach / LINES as f64;
        ((0..LINES).map(place).collect(), area)
    }

    /// Even places on a segment, for bodies in a plane.
    fn on_segment(&self, phase: f64) -> (Vec<Vec3>, f64) {
        let normal = Vec3::z().cross(&self.direction);
        let step = 2.0 * self.reach / LINES as f64;
        let place = |number: usize| (step * (number as f64 + phase) - self.reach) * normal;
        ((0..LINES).map(place).collect(), step)
    }
}

/// Intervals in which lines along a ray are inside of two swept bodies whose centres coincide.
struct Lines {
    intervals: Vec<[[f64; 2]; 2]>,
    /// Density of the depletants times the area of a line.
    weight: f64,
}

/// Σ n v with the second body moved along the ray.
fn exponent(kinds: &[Lines], distance: f64) -> f64 {
    let shared = |[first, second]: &[[f64; 2]; 2]| {
        (first[1].min(second[1] + distance) - first[0].max(second[0] + distance)).max(0.0)
    };
    let sums = kinds.iter().map(|lines| {
        let lengths: f64 = lines.intervals.iter().map(shared).sum();
        lines.weight * lengths
    });
    sums.sum()
}
