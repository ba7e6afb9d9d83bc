//! Implicit depletants: penetrable hard spheres, ideal among themselves, in osmotic equilibrium with a
//! reservoir.
//!
//! A depletant of radius r cannot have its centre within r of a body. With fugacity z (the number
//! density in the reservoir) the depletants integrate out to the weight exp(z V_free) of a state, where
//! V_free is the volume open to their centres (Asakura and Oosawa, J. Chem. Phys. 22, 1255 (1954)). V_free
//! is never computed. A trial move takes a body from O to N, both widened by r, while the others
//! cover J. Points are drawn from the Poisson process of density z, and the move is refused if one of them
//! lies in a region A that depends on O, N and J. It is allowed with the probability exp(-z |A|), its
//! reverse with exp(-z |B|), where B is A with O and N exchanged. That is detailed balance if
//! |B| - |A| is the change of V_free. Two regions do this:
//!
//! * *covered*: A = N \ O \ J, what the body takes from the depletants, and B = O \ N \ J, what it
//!   leaves them; the change of V_free is |B| - |A| by definition. This is the move of Glaser, Karas and
//!   Glotzer, J. Chem. Phys. 143, 184110 (2015), without reinsertion.
//! * *lost*: A = (O \ N) ∩ J, the overlap with others that is lost, and B = (N \ O) ∩ J, the overlap
//!   gained. Since |O| = |N|, |O \ N| = |N \ O|, and |B| - |A| is again the change of V_free.
//!
//! With small depletants little overlaps, and *lost* hardly ever refuses a body that meets no other; among
//! many large depletants little is free, and *covered* refuses less. A run tries both while it
//! equilibrates and keeps the better one.
//!
//! **Walls** cover what is less than r away from them. They are part of J, so both regions stay as they are.
//!
//! **A box that changes** takes its depletants along: they are drawn around the bodies, which is exact because
//! they are ideal among themselves, the change moves them with the space, is refused if one of them is covered then, and
//! they are forgotten again (see [`box_moves`](crate::box_moves)).
//!
//! A point in a ball about the centre that O and N share is in neither region, so points are drawn
//! only in the shell around it.

use crate::grid::Near;
use crate::reservoir::Depletant;
use crate::system::{System, Trial};
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::minus;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Depletants that forbid a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Counting {
    /// Depletants in the overlap with other bodies that would be lost.
    Lost,
    /// Depletants in the volume that would be covered.
    Covered,
}

impl<const D: usize> System<D> {
    /// Whether no depletant forbids the move.
    pub(crate) fn depletants_allow(
        &mut self,
        trial: &Trial<D>,
        rng: &mut CounterRng,
        counting: Counting,
    ) -> bool {
        let old = self.where_it_is(trial.body);
        let step = self.nearest_image(&old.position, &trial.position);
        // Taken out, as the test borrows the system.
        let mut near = std::mem::take(&mut self.near);
        let is_allowed = self.depletants.iter().all(|kind| {
            // One kind that forbids the move is enough.
            kind.fugacity == 0.0 || self.allows(kind, &old, trial, &step, &mut near, rng, counting)
        });
        self.near = near;
        is_allowed
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "one trial, taken apart by its caller"
    )]
    fn allows(
        &self,
        kind: &Depletant,
        old: &Trial<D>,
        new: &Trial<D>,
        step: &[f64; D],
        near: &mut Vec<Near<D>>,
        rng: &mut CounterRng,
        counting: Counting,
    ) -> bool {
        let radius = kind.radius;
        let length = crate::body::norm(step);
        let (inside, outside) = match counting {
            Counting::Lost => (old, new),
            Counting::Covered => (new, old),
        };
        // Balls of the inner radius about both centres are in O and N alike;
        // around one centre the ball that both share is smaller by the step.
        let body = self.body_of(new.body);
        let shell = Shell::new::<D>(
            (body.inner_radius + radius - length).max(0.0),
            body.outer_radius + radius,
        );
        // From the centre of `inside` to that of `outside`.
        let apart = match counting {
            Counting::Lost => *step,
            Counting::Covered => step.map(|x| -x),
        };
        let expected = kind.fugacity * shell.volume;
        // Arrivals of a Poisson process: points are drawn only until one forbids the move.
        let mut arrived = exponential(rng);
        let mut is_gathered = false;
        while arrived < expected {
            arrived += exponential(rng);
            let point = shell.point(rng);
            let beyond = minus(&point, &apart);
            // The cheaper test first: outside of the widened body at the other end of the move.
            if body.covers(self.corners_of_trial(outside), &beyond, radius)
                || !body.covers(self.corners_of_trial(inside), &point, radius)
            {
                continue;
            }
            // Others are looked up only for the first point that needs them; most moves need none.
            if !is_gathered {
                self.gather(inside, radius, near);
                is_gathered = true;
            }
            let height = inside.position[D - 1] + point[D - 1];
            let is_covered = self.reaches_beyond_wall(height, radius)
                || near.iter().any(|other| {
                    let from_other = minus(&point, &other.offset);
                    self.body_of(other.body as usize).covers(
                        self.corners_of(other.body as usize),
                        &from_other,
                        radius,
                    )
                });
            // Lost: covered by others. Covered: by none. Either way this point forbids the move.
            if is_covered == (counting == Counting::Lost) {
                return false;
            }
        }
        true
    }

    /// The other bodies that can touch the same depletant.
    fn gather(&self, trial: &Trial<D>, radius: f64, near: &mut Vec<Near<D>>) {
        near.clear();
        let range = self.reach(trial) + 2.0 * radius;
        let but = trial.body as u32;
        self.grid
            .any_near(&trial.position, range * range, but, |other| {
                near.push(other);
                false
            });
    }

    /// The free volume of depletants of this radius, as a part of the box: random points, one in each
    /// of about `points` equal cells.
    pub fn free_volume(&self, radius: f64, points: usize, rng: &mut CounterRng) -> f64 {
        // One point per cell: stratified, with less noise than points drawn in the whole box.
        let width = (self.volume() / points.max(1) as f64).powf(1.0 / D as f64);
        let lengths = self.space.lengths();
        let cells = lengths.map(|length| (length / width - 1e-9).ceil().max(1.0) as usize);
        let count: usize = cells.iter().product();
        let mut free = 0;
        for number in 0..count {
            let (mut quotient, mut straight) = (number, [0.0; D]);
            for axis in 0..D {
                let place = (quotient % cells[axis]) as f64 + rng.uniform();
                straight[axis] = place * lengths[axis] / cells[axis] as f64;
                quotient /= cells[axis];
            }
            // Parts of a sheared box are equal in volume.
            let point = self.space.sheared(&straight);
            free += usize::from(!self.is_covered(&point, radius));
        }
        free as f64 / count as f64
    }

    /// Whether the centre of a depletant cannot be in a place.
    pub(crate) fn is_covered(&self, point: &[f64; D], radius: f64) -> bool {
        let range = self.widest + radius;
        self.reaches_beyond_wall(point[D - 1], radius)
            || self.grid.any_near(point, range * range, u32::MAX, |near| {
                let from_body = near.offset.map(|x| -x);
                self.body_of(near.body as usize).covers(
                    self.corners_of(near.body as usize),
                    &from_body,
                    radius,
                )
            })
    }

    /// Whether a depletant with its centre at a height would reach into a wall; without walls, never. To bodies, walls
    /// are one more that covers.
    fn reaches_beyond_wall(&self, height: f64, radius: f64) -> bool {
        let top = self.space.lengths()[D - 1];
        self.has_walls() && (height < radius || height > top - radius)
    }

    /// Parts of the lower and of the upper wall that depletants can touch: random points where their centres would be, one in each
    /// of about `points` equal cells.
    pub(crate) fn free_walls(&self, radius: f64, points: usize, rng: &mut CounterRng) -> [f64; 2] {
        let lengths = self.space.lengths();
        let per_edge = (points.max(1) as f64)
            .powf(1.0 / (D as f64 - 1.0).max(1.0))
            .ceil() as usize;
        let mut cells = [per_edge; D];
        cells[D - 1] = 1;
        let count: usize = cells.iter().product();
        [radius, lengths[D - 1] - radius].map(|height| {
            let mut free = 0;
            for number in 0..count {
                let (mut quotient, mut point) = (number, [height; D]);
                for axis in 0..D - 1 {
                    let place = (quotient % cells[axis]) as f64 + rng.uniform();
                    point[axis] = place * lengths[axis] / cells[axis] as f64;
                    quotient /= cells[axis];
                }
                free += usize::from(!self.is_covered(&point, radius));
            }
            free as f64 / count as f64
        })
    }

    /// Draws the depletants of one kind in equilibrium with their reservoir around the bodies where these are: the points of
    /// the Poisson process that are not covered, in parts of the edges.
    pub(crate) fn draw_depletants(&self, kind: &Depletant, rng: &mut CounterRng) -> Vec<[f64; D]> {
        let expected = kind.fugacity * self.volume();
        let mut points = Vec::new();
        let mut arrived = exponential(rng);
        while arrived < expected {
            let parts = std::array::from_fn(|_| rng.uniform());
            if !self.is_covered(&self.space.point(&parts), kind.radius) {
                points.push(parts);
            }
            arrived += exponential(rng);
        }
        points
    }
}

/// The space between two balls, or disks, about the origin.
struct Shell {
    inner_power: f64,
    outer_power: f64,
    volume: f64,
}

impl Shell {
    fn new<const D: usize>(inner: f64, outer: f64) -> Self {
        let (inner_power, outer_power) = (inner.powi(D as i32), outer.powi(D as i32));
        let unit = [2.0, PI, 4.0 * PI / 3.0][D - 1];
        Self {
            inner_power,
            outer_power,
            volume: unit * (outer_power - inner_power),
        }
    }

    fn point<const D: usize>(&self, rng: &mut CounterRng) -> [f64; D] {
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

/// The time to the next event of a Poisson process of rate one.
fn exponential(rng: &mut CounterRng) -> f64 {
    -(1.0 - rng.uniform()).ln()
}
