//! The free volume of depletants in a perfect crystal whose bodies do not move.
//!
//! A line along the last axis meets each body swept by a depletant in an interval (see
//! [`swept`](protomer_kernel::shape::swept)). What the intervals of all bodies leave of it is free. The
//! free volume is the mean over lines through a grid of the first face of the box, and the scatter of the
//! means over grids that are shifted against each other tells its error. The lines stand upright on that face
//! and are as long as the box is high: together they fill a prism that has the volume of the box and, repeated
//! by its edges, fills space as the box does.

use crate::body::HardBody;
use crate::crystal::Crystal;
use crate::{Error, Result, error::require};
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::swept::Swept;
use protomer_kernel::statistics::summarize;
use protomer_kernel::{Pose, Vec3};

/// Grids that are shifted at random.
const GRIDS: u64 = 8;
/// Lines of a grid that take hours.
const MOST_LINES: f64 = 1e9;

/// A free volume as a part of the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticFreeVolume {
    /// The mean over lines.
    pub fraction: f64,
    /// The standard error over shifted grids. Faces along the grid make it an estimate.
    pub error: f64,
}

/// A body, or its image, swept by a depletant.
struct Near {
    swept: Swept,
    centre: Vec3,
}

/// Free volume of depletants of a radius in a crystal of rounded shapes, by so many lines per unit
/// of length along each edge.
///
/// # Errors
/// For bodies in a plane or that overlap, and for numbers that are not positive.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::crystal::{Crystal, UnitCell};
/// use protomer_hpmc::static_free_volume::static_free_volume;
/// use protomer_kernel::shape::builders::by_name;
/// let cube = by_name("cube")?;
/// let body = HardBody::<3>::new(&cube, 0.0)?;
/// let crystal = Crystal::new(&UnitCell::by_name("simple-cubic")?, &body, 1, 0.125)?;
/// let free = static_free_volume(&crystal, &cube, 0.0, 0.25, 40.0)?;
/// // What the cube and its plates, quarter cylinders and eighths of balls leave of eight cubes.
/// let swept = 1.0 + 6.0 * 0.25 + 12.0 * 0.0625 * 0.785_398 + 0.065_45;
/// assert!((free.fraction - (1.0 - swept / 8.0)).abs() < 1e-3);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
pub fn static_free_volume(
    crystal: &Crystal<3>,
    shape: &Shape,
    rounding_radius: f64,
    depletant_radius: f64,
    lines_per_length: f64,
) -> Result<StaticFreeVolume> {
    let radius = rounding_radius + depletant_radius;
    require(
        "the radius of the depletants",
        radius,
        "positive",
        depletant_radius > 0.0,
    )?;
    let holds = lines_per_length > 0.0;
    require(
        "the number of lines per length",
        lines_per_length,
        "positive",
        holds,
    )?;
    if shape.dimension() != 3 {
        return Err(Error::Dimension {
            shape: shape.dimension(),
            space: 3,
        });
    }
    let body = HardBody::<3>::new(shape, rounding_radius)?;
    if let Some(bodies) = crystal.first_overlap(&body) {
        return Err(Error::Overlap {
            bodies: bodies.map(|number| number + 1),
            packing_fraction: crystal.positions.len() as f64 * body.volume / crystal.space.volume(),
        });
    }
    // Swept once by the radius of a depletant: a point in them is closed to its centre.
    let bodies = Bodies::from_crystal(crystal, shape, radius)?;
    let lengths = crystal.space.lengths();
    let counts = [0, 1].map(|axis: usize| (lengths[axis] * lines_per_length).ceil());
    let lines = counts[0] * counts[1];
    let holds = lines <= MOST_LINES;
    require("the number of lines of a grid", lines, "at most 1e9", holds)?;
    let counts = counts.map(|count| count as usize);
    // Eight shifts of one grid: independent estimates, whose scatter is the error.
    let means: Vec<f64> = (0..GRIDS)
        .map(|grid| bodies.mean_over_lines(&counts, grid))
        .collect();
    let summary = summarize(&means);
    Ok(StaticFreeVolume {
        fraction: summary.mean,
        error: summary.standard_error,
    })
}

/// All that a line in the prism can meet.
struct Bodies {
    space: PeriodicBox<3>,
    /// No body reaches farther from its centre.
    reach: f64,
    near: Vec<Near>,
}

impl Bodies {
    fn from_crystal(crystal: &Crystal<3>, shape: &Shape, radius: f64) -> Result<Self> {
        let space = crystal.space.reduced();
        let unplaced = Swept::new(shape, radius, &Pose::identity())?;
        let longest = unplaced
            .corners()
            .iter()
            .map(Vec3::norm)
            .fold(0.0, f64::max);
        let reach = longest + radius;
        // Edges that overhang by up to one length take images that far from the prism.
        let overhang = if space.is_rectangular() { 1 } else { 3 };
        let images = space
            .heights()
            // Images that can reach the prism, plus those that overhang takes there.
            .map(|height| overhang + (reach / height).floor() as i32);
        let [x, y, z] = images;
        let mut near = Vec::new();
        for (place, rotation) in crystal.positions.iter().zip(&crystal.rotations) {
            for i in -x..=x {
                for j in -y..=y {
                    for k in -z..=z {
                        let mut centre = space.wrap(place);
                        for (edge, times) in [i, j, k].into_iter().enumerate() {
                            space.add_edges(&mut centre, edge, f64::from(times));
                        }
                        if is_near_prism(&space, &centre, reach) {
                            let position = Vec3::from(centre);
                            let pose = Pose {
                                position,
                                rotation: *rotation,
                            };
                            let swept = Swept::new(shape, radius, &pose)?;
                            near.push(Near {
                                swept,
                                centre: position,
                            });
                        }
                    }
                }
            }
        }
        Ok(Self { space, reach, near })
    }

    fn mean_over_lines(&self, counts: &[usize; 2], grid: u64) -> f64 {
        let mut rng = CounterRng::new(1, 0, grid);
        let shift = [rng.uniform(), rng.uniform()];
        let mut sum = 0.0;
        for line in 0..counts[0] * counts[1] {
            let cell = [line % counts[0], line / counts[0]];
            let mut parts = [0.0; 3];
            for axis in 0..2 {
                parts[axis] = (cell[axis] as f64 + shift[axis]) / counts[axis] as f64;
            }
            sum += self.free_part(&Vec3::from(self.space.point(&parts)));
        }
        sum / (counts[0] * counts[1]) as f64
    }

    /// The part of a line along the last axis, from one face of the box to the other, that is in no body.
    fn free_part(&self, origin: &Vec3) -> f64 {
        let height = self.space.lengths()[2];
        let mut covered = Vec::new();
        for body in &self.near {
            // A quick test by distance before the shape is intersected.
            let apart = body.centre.xy() - origin.xy();
            if apart.norm_squared() < self.reach * self.reach
                && let Some([from, to]) = body.swept.interval(origin, &Vec3::z())
                && to > 0.0
                && from < height
            {
                covered.push([from, to]);
            }
        }
        // By entry, so that one pass merges overlapping intervals.
        covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut free, mut reached) = (0.0, 0.0);
        for [from, to] in covered {
            // Only the part beyond what is covered already is free.
            free += f64::max(from - reached, 0.0);
            reached = f64::max(reached, to);
        }
        (free + f64::max(height - reached, 0.0)) / height
    }
}

/// Whether a place may be within a distance of the prism that stands upright on the first face of a box.
fn is_near_prism(space: &PeriodicBox<3>, place: &[f64; 3], distance: f64) -> bool {
    let [width, depth, height] = *space.lengths();
    // The prism in the plane of its foot, sheared to a rectangle: along x a distance may look longer.
    let [x, y, _] = space.unsheared(&[place[0], place[1], 0.0]);
    let longer = distance * (1.0 + space.tilt_factors()[0].abs());
    let is_along = |x: f64, length: f64, reach: f64| x > -reach && x < length + reach;
    is_along(x, width, longer)
        && is_along(y, depth, distance)
        && is_along(place[2], height, distance)
}
