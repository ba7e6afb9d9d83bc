//! The space between two concentric balls, and points drawn in it.

use crate::random::CounterRng;
use std::f64::consts::PI;

/// The space between two balls about the origin: in a plane between two disks, on a line two intervals.
///
/// ```
/// use protomer_kernel::random::CounterRng;
/// use protomer_kernel::shell::Shell;
/// let ring = Shell::<2>::new(1.0, 2.0);
/// assert!((ring.volume() - 3.0 * std::f64::consts::PI).abs() < 1e-12);
/// let [x, y] = ring.point(&mut CounterRng::new(1, 0, 0));
/// assert!((1.0..=2.0).contains(&x.hypot(y)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shell<const D: usize> {
    inner_power: f64,
    outer_power: f64,
}

impl<const D: usize> Shell<D> {
    /// The shell between these radii, in one, two or three dimensions.
    pub fn new(inner_radius: f64, outer_radius: f64) -> Self {
        Self {
            inner_power: inner_radius.powi(D as i32),
            outer_power: outer_radius.powi(D as i32),
        }
    }

    /// Volume; in a plane area, on a line length.
    ///
    /// ```
    /// use protomer_kernel::shell::Shell;
    /// assert_eq!(Shell::<1>::new(0.5, 2.0).volume(), 3.0);
    /// ```
    pub fn volume(&self) -> f64 {
        let unit = [2.0, PI, 4.0 * PI / 3.0][D - 1];
        unit * (self.outer_power - self.inner_power)
    }

    /// A point uniform in the shell.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// use protomer_kernel::shell::Shell;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let ball = Shell::<3>::new(0.0, 2.0);
    /// let radius = |point: [f64; 3]| point.iter().map(|x| x * x).sum::<f64>().sqrt();
    /// let inner = (0..8000).filter(|_| radius(ball.point(&mut rng)) < 1.0).count();
    /// assert!((850..1150).contains(&inner), "half of the radius holds an eighth of the volume");
    /// ```
    pub fn point(&self, rng: &mut CounterRng) -> [f64; D] {
        // Uniform in r^D is uniform in the volume.
        let power = rng.uniform_in(self.inner_power, self.outer_power);
        let mut point = [0.0; D];
        if D == 1 {
            point[0] = if rng.uniform() < 0.5 { power } else { -power };
        } else if D == 2 {
            let (sine, cosine) = (2.0 * PI * rng.uniform()).sin_cos();
            let radius = power.sqrt();
            point[0] = radius * cosine;
            point[1] = radius * sine;
        } else {
            let direction = rng.unit_vector() * power.cbrt();
            for (axis, x) in point.iter_mut().enumerate() {
                *x = direction[axis];
            }
        }
        point
    }
}
