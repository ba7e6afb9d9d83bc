//! A distribution of orientations: uniform, mixed with caps around chosen ones.

use super::orientation::{EvenSequence, Orientation};
use nalgebra::{Unit, UnitQuaternion};
use protomer_kernel::bisection::halved;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The half-widths of a cap: directions within an angle of the cap's direction, rotations within
/// an angle of its rotation, both uniform.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Width {
    /// Half-width of the direction, rad.
    pub direction_rad: f64,
    /// Half-width of the rotation, rad.
    pub rotation_rad: f64,
}

/// The mixture q = (1 - s) + s/K Σ_k c_k, relative to the uniform distribution; c_k is the constant
/// that makes the integral of a cap one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    centres: Vec<Orientation>,
    width: Width,
    share_of_caps: f64,
}

impl Proposal {
    /// Whether it has a cap where a share of the draws lies in caps.
    pub fn fits(&self) -> bool {
        (0.0..=1.0).contains(&self.share_of_caps)
            && (self.share_of_caps == 0.0 || !self.centres.is_empty())
    }

    /// The uniform distribution.
    pub fn uniform() -> Self {
        Self {
            centres: Vec::new(),
            width: Width {
                direction_rad: PI,
                rotation_rad: PI,
            },
            share_of_caps: 0.0,
        }
    }

    /// A share of the draws in caps of this width around the centres, the others uniform.
    pub fn new(centres: Vec<Orientation>, width: Width, share_of_caps: f64) -> Self {
        match centres.is_empty() {
            true => Self::uniform(),
            false => Self {
                centres,
                width,
                share_of_caps,
            },
        }
    }

    /// Number of uniform draws among `count`.
    fn uniform_draws(&self, count: u64) -> u64 {
        // A fixed number, not a random one: the even sequence keeps its evenness.
        ((1.0 - self.share_of_caps) * count as f64).round() as u64
    }

    /// Draw `number` of `count`: the first ones from the even sequence, the others from caps.
    pub fn draw(
        &self,
        number: u64,
        count: u64,
        even: &EvenSequence,
        rng: &mut CounterRng,
    ) -> Orientation {
        // The first draws are the uniform ones, in the order of the sequence.
        if number < self.uniform_draws(count) {
            return even.orientation(number);
        }
        let centre = &self.centres[rng.index(self.centres.len())];
        Orientation {
            direction: self.draw_direction(&centre.direction, rng),
            rotation: self.draw_turn(rng) * centre.rotation,
        }
    }

    /// The density of one of `count` draws taken at random, relative to the uniform distribution.
    pub fn density(&self, orientation: &Orientation, count: u64) -> f64 {
        let uniform = self.uniform_draws(count) as f64 / count as f64;
        if self.centres.is_empty() {
            return 1.0;
        }
        let least_cosine = self.width.direction_rad.cos();
        // Of quaternions: |q·q'| = cos(ω/2).
        let least_scalar = (0.5 * self.width.rotation_rad).cos();
        let mut covering = 0_u32;
        for centre in &self.centres {
            let near = centre.direction.dot(&orientation.direction) > least_cosine
                // Both signs of a quaternion are the same rotation.
                && centre
                    .rotation
                    .coords
                    .dot(&orientation.rotation.coords)
                    .abs()
                    > least_scalar;
            covering += u32::from(near);
        }
        let in_caps = f64::from(covering) / self.centres.len() as f64 * self.peak();
        // Uniform draws reach everywhere, so the density is never zero where a draw may fall.
        uniform + (1.0 - uniform) * in_caps
    }

    /// The density of one cap: the inverse of its share of all orientations.
    fn peak(&self) -> f64 {
        let share_of_directions = 0.5 * (1.0 - self.width.direction_rad.cos());
        1.0 / (share_of_directions * share_of_rotations(self.width.rotation_rad))
    }

    fn draw_direction(&self, centre: &Vec3, rng: &mut CounterRng) -> Vec3 {
        // Uniform on the cap: the cosine is uniform.
        let cosine = 1.0 - rng.uniform() * (1.0 - self.width.direction_rad.cos());
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (across_1, across_2) = rng_frame(centre);
        let (s, c) = (TAU * rng.uniform()).sin_cos();
        (cosine * centre + sine * (c * across_1 + s * across_2)).normalize()
    }

    /// A rotation about a random axis; its angle follows 1 - cos ω up to the width.
    fn draw_turn(&self, rng: &mut CounterRng) -> Rotation {
        let widest = self.width.rotation_rad;
        // Inversion of (ω - sin ω)/π by halving: it has no closed form and rises everywhere.
        let share = rng.uniform() * share_of_rotations(widest);
        let is_less = |angle_rad: f64| share_of_rotations(angle_rad) < share;
        let [low, high] = halved([0.0, widest], 50, is_less);
        let axis = Unit::new_unchecked(rng.unit_vector());
        UnitQuaternion::from_axis_angle(&axis, 0.5 * (low + high))
    }
}

/// The share of all rotations whose angle is at most this (rad): (ω - sin ω)/π.
fn share_of_rotations(angle_rad: f64) -> f64 {
    (angle_rad - angle_rad.sin()) / PI
}

/// Two unit vectors across a direction.
fn rng_frame(direction: &Vec3) -> (Vec3, Vec3) {
    // Any axis that is not nearly parallel to the direction.
    let helper = match direction.x.abs() < 0.7 {
        true => Vec3::x(),
        false => Vec3::y(),
    };
    let first = direction.cross(&helper).normalize();
    (first, direction.cross(&first))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ f = Σ f/q over draws from q, for functions whose averages are known, and for q itself.
    #[test]
    fn draws_and_densities_belong_together() {
        let centre = |seed| {
            let mut rng = CounterRng::new(seed, 0, 0);
            Orientation {
                direction: rng.unit_vector(),
                rotation: rng.rotation(),
            }
        };
        let width = Width {
            direction_rad: 0.8,
            rotation_rad: 1.1,
        };
        let proposal = Proposal::new((0..5).map(centre).collect(), width, 0.6);
        let even = EvenSequence::new(&mut CounterRng::new(1, 0, 0));
        let count = 40_000;
        let (mut one, mut height, mut scalar) = (0.0, 0.0, 0.0);
        for number in 0..count {
            let mut rng = CounterRng::new(2, 0, number);
            let drawn = proposal.draw(number, count, &even, &mut rng);
            let weight = 1.0 / proposal.density(&drawn, count);
            one += weight;
            height += weight * drawn.direction.z.powi(2);
            scalar += weight * drawn.rotation.quaternion().w.powi(2);
        }
        let count = count as f64;
        assert!((one / count - 1.0).abs() < 0.01, "{}", one / count);
        assert!((height / count - 1.0 / 3.0).abs() < 0.006);
        assert!((scalar / count - 0.25).abs() < 0.006);
    }
}
