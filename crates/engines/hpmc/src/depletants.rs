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
use protomer_kernel::shell::Shell;
use serde::{Deserialize, Serialize};

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
        let shell = Shell::<D>::new(
            (body.inner_radius + radius - length).max(0.0),
            body.outer_radius + radius,
        );
        // From the centre of `inside` to that of `outside`.
        let apart = match counting {
            Counting::Lost => *step,
            Counting::Covered => step.map(|x| -x),
        };
        let expected = kind.fugacity * shell.volume();
        // Arrivals of a Poisson process: points are drawn only until one forbids the move.
        let mut arrived = rng.exponential();
        let mut is_gathered = false;
        while arrived < expected {
            arrived += rng.exponential();
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
        let mut arrived = rng.exponential();
        while arrived < expected {
            let parts = std::array::from_fn(|_| rng.uniform());
            if !self.is_covered(&self.space.point(&parts), kind.radius) {
                points.push(parts);
            }
            arrived += rng.exponential();
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::HardBody;
    use crate::field::Nothing;
    use crate::system::{MoveCounts, Steps};
    use protomer_kernel::Rotation;
    use protomer_kernel::bisection::halved;
    use protomer_kernel::periodic_box::PeriodicBox;
    use protomer_kernel::random::Purpose;
    use protomer_kernel::statistics::summarize;
    use std::f64::consts::PI;

    /// Half axes of a spheroid across and along its axis.
    const HALF_AXES: [f64; 2] = [0.5, 1.0];
    const RADIUS: f64 = 0.2;

    fn spheroid() -> HardBody<3> {
        HardBody::ellipsoid([HALF_AXES[0], HALF_AXES[0], HALF_AXES[1]]).unwrap()
    }

    /// Radius of the circle that the spheroid, widened by the depletant, has at a height of its axis.
    fn profile(height: f64) -> f64 {
        let [a, c] = HALF_AXES;
        // The point of the surface at an angle, moved along its normal.
        let widened = |angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            let normal = [cosine / a, sine / c];
            let length = normal[0].hypot(normal[1]);
            [
                a * cosine + RADIUS * normal[0] / length,
                c * sine + RADIUS * normal[1] / length,
            ]
        };
        if height.abs() >= c + RADIUS {
            return 0.0;
        }
        let is_below = |angle: f64| widened(angle)[1] < height.abs();
        widened(halved([0.0, 0.5 * PI], 60, is_below)[0])[0]
    }

    /// Area that two circles share.
    fn lens(first: f64, second: f64, apart: f64) -> f64 {
        if apart >= first + second {
            return 0.0;
        }
        if apart <= (first - second).abs() {
            return PI * first.min(second).powi(2);
        }
        let [p, q] = [(first, second), (second, first)].map(|(one, other)| {
            let along = (apart * apart + one * one - other * other) / (2.0 * apart);
            let cosine = (along / one).clamp(-1.0, 1.0);
            one * one * (cosine.acos() - cosine * (1.0 - cosine * cosine).sqrt())
        });
        p + q
    }

    /// Volume that two parallel widened spheroids share, by slices.
    fn shared_volume(profiles: &[f64], spacing: f64, across: f64, along: f64) -> f64 {
        let middle = (profiles.len() / 2) as isize;
        let shift = (along / spacing).round() as isize;
        let radius = |slice: isize| {
            profiles
                .get((slice + middle) as usize)
                .copied()
                .unwrap_or(0.0)
        };
        let slices = -middle..=middle;
        slices
            .map(|slice| lens(radius(slice), radius(slice - shift), across))
            .sum::<f64>()
            * spacing
    }

    /// Part of the time for which two parallel spheroids that do not turn are nearer than `near` contacts, in a box.
    fn exact_part(fugacity: f64, edge: f64, near: f64) -> f64 {
        let [a, c] = HALF_AXES;
        let spacing = 0.01;
        let half = ((c + RADIUS) / spacing).ceil() as isize;
        let profiles: Vec<f64> = (-half..=half)
            .map(|slice| profile(slice as f64 * spacing))
            .collect();
        // Distances in contacts s and the cosine u of the angle, in the space in which the spheroids are balls.
        let (steps, farthest) = (160, 1.0 + RADIUS / a);
        let (mut excess, mut inside) = (0.0, 0.0);
        for number in 0..steps {
            let s = 1.0 + (farthest - 1.0) * (number as f64 + 0.5) / steps as f64;
            for angle in 0..200 {
                let u = (f64::from(angle) + 0.5) / 200.0;
                let (across, along) = (2.0 * a * s * (1.0 - u * u).sqrt(), 2.0 * c * s * u);
                let weight = (fugacity * shared_volume(&profiles, spacing, across, along)).exp();
                let volume =
                    4.0 * PI * s * s * 8.0 * a * a * c * (farthest - 1.0) / (steps as f64 * 200.0);
                excess += (weight - 1.0) * volume;
                inside += if s < near { weight * volume } else { 0.0 };
            }
        }
        let contact = 4.0 * PI / 3.0 * 8.0 * a * a * c;
        inside / (edge.powi(3) - contact + excess)
    }

    /// Two parallel spheroids among depletants, side by side, tip to tip and anything between, by the volume that they
    /// share as integrals over slices.
    #[test]
    fn parallel_spheroids_have_their_exact_statistics() {
        let (edge, fugacity, near) = (5.0, 14.0, 1.15);
        let exact = exact_part(fugacity, edge, near);
        let depletants = vec![Depletant {
            radius: RADIUS,
            fugacity,
        }];
        let space = PeriodicBox::rectangular([edge; 3]).unwrap();
        let places = vec![[1.0, 1.0, 1.0], [3.0, 3.0, 3.0]];
        let rotations = vec![Rotation::identity(); 2];
        let mut system = System::new(spheroid(), depletants, space, places, rotations).unwrap();
        // Turns by nothing: the bodies stay parallel.
        let steps = Steps {
            translation: 0.6,
            rotation: 0.0,
        };
        let mut counts = MoveCounts::default();
        let mut series = Vec::new();
        for number in 0..400_000_u64 {
            let mut rng = CounterRng::for_purpose(3, 0, number, Purpose::HardBodyMove);
            let counting = Counting::Lost;
            system.trial(&mut rng, &steps, counting, &mut Nothing, &mut counts);
            if number % 4 == 0 {
                let [x, y, z] = system.nearest_image(&system.positions[0], &system.positions[1]);
                let [a, c] = HALF_AXES;
                let contacts = 0.5 * (x / a).hypot(y / a).hypot(z / c);
                assert!(contacts >= 1.0 - 1e-9);
                series.push(f64::from(u8::from(contacts < near)));
            }
        }
        let found = summarize(&series);
        assert!(found.standard_error < 0.04 * exact, "{exact}, {found:?}");
        assert!(
            (found.mean - exact).abs() < 4.0 * found.standard_error,
            "{exact}, {found:?}"
        );
    }

    /// The volume that an ellipsoid leaves free is exact by the formula of Steiner: V + S r + M r² + 4π/3 r³.
    #[test]
    fn one_ellipsoid_leaves_the_volume_of_steiner_s_formula() {
        let half_axes = [0.4, 1.0, 1.5];
        let body = HardBody::<3>::ellipsoid(half_axes).unwrap();
        let space = PeriodicBox::rectangular([4.0; 3]).unwrap();
        let turn = Rotation::from_scaled_axis(protomer_kernel::Vec3::new(0.3, 0.8, -0.5));
        let system = System::new(body, Vec::new(), space, vec![[2.0; 3]], vec![turn]).unwrap();
        for radius in [0.1, 0.45] {
            let widened =
                protomer_kernel::shape::ellipsoid::measures_of_ellipsoid(&half_axes, radius)
                    .unwrap();
            let mut rng = CounterRng::for_purpose(1, 0, 0, Purpose::HardBodyInsertion);
            let free = system.free_volume(radius, 400_000, &mut rng);
            let exact = 1.0 - widened.volume / 64.0;
            assert!((free - exact).abs() < 4e-4, "{radius}: {free}, {exact}");
        }
    }
}
