//! The free volume of depletants in a perfect crystal whose bodies do not move.
//!
//! A line along the last axis meets each body swept by a depletant in an interval (see
//! [`swept`](protomer_kernel::shape::swept)). What the intervals of all bodies leave of it is free. The
//! free volume is the mean over lines through a grid of the first face of the box, and the scatter of the
//! means over grids that are shifted against each other tells its error.

use crate::crystal::Crystal;
use crate::{Error, Result, error::require};
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::swept::Swept;
use protomer_kernel::statistics::summarize;
use protomer_kernel::{Pose, Vec3};

/// Grids that are shifted at random.
const GRIDS: u64 = 8;

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

/// Of depletants of a radius in a crystal of rounded shapes, by so many lines per unit of length along
/// each edge.
///
/// # Errors
/// For bodies in a plane, and for numbers that are not positive.
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
    let bodies = Bodies::of(crystal, shape, radius)?;
    let counts = [0, 1].map(|axis: usize| (crystal.edges[axis] * lines_per_length).ceil() as usize);
    let means: Vec<f64> = (0..GRIDS)
        .map(|grid| bodies.mean_over_lines(&counts, grid))
        .collect();
    let summary = summarize(&means);
    Ok(StaticFreeVolume {
        fraction: summary.mean,
        error: summary.standard_error,
    })
}

/// All that a line in the box can meet.
struct Bodies {
    edges: [f64; 3],
    /// No body reaches farther from its centre.
    reach: f64,
    near: Vec<Near>,
}

impl Bodies {
    fn of(crystal: &Crystal<3>, shape: &Shape, radius: f64) -> Result<Self> {
        let edges = crystal.edges;
        let unplaced = Swept::new(shape, radius, &Pose::identity())?;
        let longest = unplaced
            .corners()
            .iter()
            .map(Vec3::norm)
            .fold(0.0, f64::max);
        let reach = longest + radius;
        let images = edges.map(|edge| 1 + (reach / edge).floor() as i32);
        let mut near = Vec::new();
        for (place, rotation) in crystal.positions.iter().zip(&crystal.rotations) {
            let (x, y, z) = (images[0], images[1], images[2]);
            for i in -x..=x {
                for j in -y..=y {
                    for k in -z..=z {
                        let shift = [i, j, k].map(f64::from);
                        let mut centre = Vec3::from(*place);
                        for axis in 0..3 {
                            centre[axis] += shift[axis] * edges[axis];
                        }
                        let is_near = (0..3).all(|axis| {
                            centre[axis] > -reach && centre[axis] < edges[axis] + reach
                        });
                        if is_near {
                            let pose = Pose {
                                position: centre,
                                rotation: *rotation,
                            };
                            let swept = Swept::new(shape, radius, &pose)?;
                            near.push(Near { swept, centre });
                        }
                    }
                }
            }
        }
        Ok(Self { edges, reach, near })
    }

    fn mean_over_lines(&self, counts: &[usize; 2], grid: u64) -> f64 {
        let mut rng = CounterRng::new(1, 0, grid);
        let shift = [rng.uniform(), rng.uniform()];
        let mut sum = 0.0;
        for line in 0..counts[0] * counts[1] {
            let cell = [line % counts[0], line / counts[0]];
            let mut origin = Vec3::zeros();
            for axis in 0..2 {
                let part = (cell[axis] as f64 + shift[axis]) / counts[axis] as f64;
                origin[axis] = part * self.edges[axis];
            }
            sum += self.free_part(&origin);
        }
        sum / (counts[0] * counts[1]) as f64
    }

    /// The part of a line along the last axis, from one face of the box to the other, that is in no body.
    fn free_part(&self, origin: &Vec3) -> f64 {
        let height = self.edges[2];
        let mut covered = Vec::new();
        for body in &self.near {
            let apart = body.centre.xy() - origin.xy();
            if apart.norm_squared() < self.reach * self.reach
                && let Some([from, to]) = body.swept.interval(origin, &Vec3::z())
                && to > 0.0
                && from < height
            {
                covered.push([from, to]);
            }
        }
        covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut free, mut reached) = (0.0, 0.0);
        for [from, to] in covered {
            free += f64::max(from - reached, 0.0);
            reached = f64::max(reached, to);
        }
        (free + f64::max(height - reached, 0.0)) / height
    }
}
