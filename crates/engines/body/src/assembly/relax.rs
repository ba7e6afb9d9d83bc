//! The least displacements that leave placed bodies without overlap.
//!
//! Each body may move by a translation t and turn by a small rotation vector ω about its origin. The
//! displacements with the least Σ |t|² + r² |ω|² are sought, r the body's radius of gyration, so that
//! this is about the sum of the mean square displacements of the bodies' atoms.
//!
//! The atoms near other bodies stand for the surfaces while displacements are sought. For atoms a and b of
//! two bodies at a distance d along n, with the distance c that they should keep,
//!
//!   n · (δₐ - δ_b) ≥ c - d,   δ = t + ω × r.
//!
//! Minimising a sum of squares under such inequalities is a projection, which Hildreth's method finds
//! (Naval Res. Logist. Q. 4, 79 (1957)): each inequality in turn adds what it lacks, or takes back what
//! it gave. n and d are taken again after each such solution.
//!
//! The exact overlap test decides. A pair that still overlaps asks for a larger distance between its
//! atoms, step by step, as its surfaces also touch between atoms; a pair that is free may keep the
//! distances that it had. In the end all displacements are scaled down as far as the test allows.

use super::cells::Cells;
use super::placement::Placement;
use crate::{BodyError, Result};
use nalgebra::UnitQuaternion;
use protomer_kernel::bisection::narrowed;
use protomer_kernel::{Pose, Vec3};
use std::collections::BTreeMap;

/// The atoms of a body for [`separate`].
#[derive(Debug, Clone, PartialEq)]
pub struct CoreAtoms {
    /// Positions in the frame of the body, Å.
    pub positions: Vec<Vec3>,
    /// Radii of the hard spheres at these positions, Å.
    pub radii_angstrom: Vec<f64>,
}

/// Placements after [`separate`].
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// The placements, free of overlap.
    pub placements: Vec<Placement>,
    /// Displacement of each body: root mean square over its atoms, Å.
    pub moved_angstrom: Vec<f64>,
}

/// The first distance that the atoms of overlapping bodies are moved apart in excess of their
/// radii, Å.
const FIRST_MARGIN_ANGSTROM: f64 = 0.05;
/// The factor by which that distance grows, before the first one is added to it again, as long as
/// the bodies overlap.
const MARGIN_GROWTH: f64 = 1.25;
/// Largest margin, Å: beyond it small displacements do not help.
const LARGEST_MARGIN_ANGSTROM: f64 = 8.0;
/// Excess of the distance of two atoms over the one that they must keep, Å, up to which they are
/// watched.
const WATCHED_ANGSTROM: f64 = 1.0;
/// Largest number of sweeps of Hildreth's method.
const MOST_SWEEPS: usize = 400;
/// The violation of an inequality that may remain, Å.
const TOLERANCE_ANGSTROM: f64 = 1e-3;

/// Moves bodies apart by the least displacements found at which none overlap. Bodies that overlap no
/// other stay where they are unless another one would be moved into them.
///
/// `overlap` decides about all pairs, those far apart too, so it should begin with bounding spheres.
///
/// ```
/// use protomer_body::assembly::{CoreAtoms, Placement, separate};
/// use protomer_kernel::{Pose, Vec3};
/// let ball = CoreAtoms { positions: vec![Vec3::zeros()], radii_angstrom: vec![1.0] };
/// let placed = |x| (0, Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() });
/// let overlap = |a: &Placement, b: &Placement| (a.1.position - b.1.position).norm() < 2.0;
/// let apart = separate(&[ball], &[placed(0.0), placed(1.6), placed(9.0)], overlap)?;
/// assert!((apart.moved_angstrom[0] - 0.2).abs() < 1e-2 && apart.moved_angstrom[2] == 0.0);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Interlocked`] if displacements of a few ångström do not help, as for bodies that
/// interlock or lie in one place.
pub fn separate(
    bodies: &[CoreAtoms],
    placements: &[Placement],
    overlap: impl Fn(&Placement, &Placement) -> bool,
) -> Result<Separation> {
    let mut search = Search::new(bodies, placements, overlap);
    let mut motions = vec![Motion::default(); placements.len()];
    // Each round asks for more distance where bodies still
    // overlap, so the loop ends in a placement or in an error.
    while let Some(overlapping) = search.overlapping(&motions) {
        search.widen(&overlapping)?;
        motions = search.project(&motions);
    }
    // The margins overshoot: the least part of the motion that is free of overlap is enough.
    let overlaps = |scale: f64| search.overlapping(&scaled(&motions, scale)).is_some();
    let scale = narrowed([0.0, 1.0], 1e-3, overlaps)[1];
    // The bisection ends at a scale that was found free; a scale of one is.
    let motions = scaled(&motions, scale);
    let places = 0..placements.len();
    Ok(Separation {
        moved_angstrom: places
            .map(|i| search.moved_angstrom(i, &motions[i]))
            .collect(),
        placements: search.moved(&motions),
    })
}

/// A translation and a rotation vector about the body's origin, in Å and in radian.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    translation: Vec3,
    rotation: Vec3,
}

fn scaled(motions: &[Motion], scale: f64) -> Vec<Motion> {
    let scaled = |motion: &Motion| Motion {
        translation: scale * motion.translation,
        rotation: scale * motion.rotation,
    };
    motions.iter().map(scaled).collect()
}

/// n · (δₐ - δ_b) ≥ least, for atoms of two placed bodies at these arms about their origins.
struct Inequality {
    bodies: (usize, usize),
    direction: Vec3,
    /// Arm × n of each body over its radius of gyration: the derivative of n · δ by r ω.
    turns: (Vec3, Vec3),
    least: f64,
    /// Square of the length of the derivative.
    square: f64,
    multiplier: f64,
}

struct Search<'a, F> {
    bodies: &'a [CoreAtoms],
    placements: &'a [Placement],
    overlap: F,
    /// The margin of each pair that has overlapped, Å.
    margins: BTreeMap<(usize, usize), f64>,
    /// Radius of gyration of each kind, Å; at least 1, for bodies of few atoms.
    gyration: Vec<f64>,
}

impl<'a, F: Fn(&Placement, &Placement) -> bool> Search<'a, F> {
    fn new(bodies: &'a [CoreAtoms], placements: &'a [Placement], overlap: F) -> Self {
        Self {
            bodies,
            placements,
            overlap,
            margins: BTreeMap::new(),
            gyration: bodies.iter().map(CoreAtoms::gyration).collect(),
        }
    }

    fn pose(&self, place: usize, motion: &Motion) -> Pose {
        let pose = &self.placements[place].1;
        Pose {
            position: pose.position + motion.translation,
            rotation: UnitQuaternion::new(motion.rotation) * pose.rotation,
        }
    }

    fn moved(&self, motions: &[Motion]) -> Vec<Placement> {
        let places = motions.iter().enumerate();
        places
            .map(|(place, motion)| (self.placements[place].0, self.pose(place, motion)))
            .collect()
    }

    /// The pairs that overlap; `None` if there are none.
    fn overlapping(&self, motions: &[Motion]) -> Option<Vec<(usize, usize)>> {
        let poses = self.moved(motions);
        let mut pairs = Vec::new();
        // All pairs: a body that lay deep in another may have
        // moved farther than any list made at the start foresees.
        for (second, placement) in poses.iter().enumerate() {
            for (first, other) in poses[..second].iter().enumerate() {
                if (self.overlap)(other, placement) {
                    pairs.push((first, second));
                }
            }
        }
        (!pairs.is_empty()).then_some(pairs)
    }

    /// Asks for more distance between the bodies of pairs that overlap.
    fn widen(&mut self, overlapping: &[(usize, usize)]) -> Result<()> {
        for pair in overlapping {
            let margin = self.margins.entry(*pair).or_insert(0.0);
            // Grows faster than linearly, but never from
            // zero: the first step is the constant alone.
            *margin = MARGIN_GROWTH * *margin + FIRST_MARGIN_ANGSTROM;
            if *margin > LARGEST_MARGIN_ANGSTROM {
                return Err(BodyError::Interlocked {
                    first: pair.0,
                    second: pair.1,
                });
            }
        }
        Ok(())
    }

    /// The least motions, linearised about the present ones, that keep the distances which the pairs
    /// ask for.
    fn project(&self, present: &[Motion]) -> Vec<Motion> {
        let mut inequalities = self.inequalities(present);
        let mut motions = vec![Motion::default(); present.len()];
        // Rotations are r ω here, in Å.
        for _ in 0..MOST_SWEEPS {
            let mut lacking = 0.0_f64;
            for inequality in &mut inequalities {
                // Sweep after sweep: Hildreth's method meets one inequality at a time.
                lacking = lacking.max(inequality.meet(&mut motions));
            }
            if lacking < TOLERANCE_ANGSTROM {
                break;
            }
        }
        for (motion, (kind, _)) in motions.iter_mut().zip(self.placements) {
            // Sought in Å, so that translations and rotations weigh alike; back to radians.
            motion.rotation /= self.gyration[*kind];
        }
        motions
    }

    /// The inequalities of all pairs of atoms that are near each other at these motions.
    fn inequalities(&self, present: &[Motion]) -> Vec<Inequality> {
        let poses = self.moved(present);
        let (mut positions, mut atoms) = (Vec::new(), Vec::new());
        for (place, (kind, pose)) in poses.iter().enumerate() {
            for (atom, position) in self.bodies[*kind].positions.iter().enumerate() {
                positions.push(pose.transform_point(position));
                atoms.push((place, atom));
            }
        }
        let margin = self.margins.values().copied().fold(0.0, f64::max);
        let radii = self.bodies.iter().flat_map(|body| &body.radii_angstrom);
        let largest = radii.copied().fold(0.0, f64::max);
        let reach = 2.0 * largest + margin + WATCHED_ANGSTROM;
        let mut inequalities = Vec::new();
        let cells = Cells::new(positions, reach);
        cells.for_each_pair(reach, |one, other| {
            let (one, other) = (one.min(other), one.max(other));
            // Atoms of one body keep their distances.
            if atoms[one].0 != atoms[other].0 {
                inequalities.extend(self.inequality(present, &poses, atoms[one], atoms[other]));
            }
        });
        inequalities
    }

    /// The inequality of two atoms, each by the place of its body and its number there; `None` if
    /// they are farther apart than they need be watched.
    fn inequality(
        &self,
        present: &[Motion],
        poses: &[Placement],
        first: (usize, usize),
        second: (usize, usize),
    ) -> Option<Inequality> {
        let [a, b] = [first, second].map(|(place, atom)| self.atom(place, atom, poses));
        let apart = a.position - b.position;
        let distance = apart.norm();
        let sum = a.radius + b.radius;
        let wanted = match self.margins.get(&(first.0, second.0)) {
            Some(margin) => sum + margin,
            // A pair that never overlapped only must not come closer
            // than it is, where that is closer than the radii ask for.
            None => {
                let native = [first, second].map(|(place, atom)| {
                    let (kind, pose) = &self.placements[place];
                    pose.transform_point(&self.bodies[*kind].positions[atom])
                });
                sum.min((native[0] - native[1]).norm())
            }
        };
        // Coinciding atoms have no direction; others of the two bodies decide.
        if distance > wanted + WATCHED_ANGSTROM || distance <= 0.0 {
            return None;
        }
        let direction = apart / distance;
        let turns = (
            a.arm.cross(&direction) / a.gyration,
            b.arm.cross(&direction) / b.gyration,
        );
        let (of_a, of_b) = (&present[first.0], &present[second.0]);
        // Linearised about the present motion while the total is sought:
        // what it already adds to the distance goes to the other side.
        let already = direction.dot(&(of_a.translation - of_b.translation))
            + a.gyration * turns.0.dot(&of_a.rotation)
            - b.gyration * turns.1.dot(&of_b.rotation);
        Some(Inequality {
            bodies: (first.0, second.0),
            direction,
            square: 2.0 + turns.0.norm_squared() + turns.1.norm_squared(),
            turns,
            least: wanted - distance + already,
            multiplier: 0.0,
        })
    }

    fn atom(&self, place: usize, atom: usize, poses: &[Placement]) -> PlacedAtom {
        let (kind, pose) = &poses[place];
        let arm = pose.rotation * self.bodies[*kind].positions[atom];
        PlacedAtom {
            position: pose.position + arm,
            arm,
            radius: self.bodies[*kind].radii_angstrom[atom],
            gyration: self.gyration[*kind],
        }
    }

    /// Root mean square displacement of the atoms of a body, Å.
    fn moved_angstrom(&self, place: usize, motion: &Motion) -> f64 {
        let (kind, before) = &self.placements[place];
        let after = self.pose(place, motion);
        let positions = &self.bodies[*kind].positions;
        let mut sum = 0.0;
        for position in positions {
            let displacement = after.transform_point(position) - before.transform_point(position);
            sum += displacement.norm_squared();
        }
        (sum / positions.len().max(1) as f64).sqrt()
    }
}

struct PlacedAtom {
    position: Vec3,
    /// Position about the origin of its body, Å.
    arm: Vec3,
    radius: f64,
    /// Radius of gyration of its body, Å.
    gyration: f64,
}

impl Inequality {
    /// Moves the bodies by the least change that meets the inequality, or takes back an excess of
    /// earlier changes; returns the distance that was lacking, Å.
    fn meet(&mut self, motions: &mut [Motion]) -> f64 {
        let (a, b) = self.bodies;
        let value = self
            .direction
            .dot(&(motions[a].translation - motions[b].translation))
            + self.turns.0.dot(&motions[a].rotation)
            - self.turns.1.dot(&motions[b].rotation);
        let lacking = self.least - value;
        // A multiplier is never negative: the bodies push each other and do not pull.
        let multiplier = (self.multiplier + lacking / self.square).max(0.0);
        let change = multiplier - self.multiplier;
        self.multiplier = multiplier;
        motions[a].translation += change * self.direction;
        motions[b].translation -= change * self.direction;
        motions[a].rotation += change * self.turns.0;
        motions[b].rotation -= change * self.turns.1;
        lacking
    }
}

impl CoreAtoms {
    /// Radius of gyration about the origin, Å; at least 1.
    fn gyration(&self) -> f64 {
        let squares: f64 = self.positions.iter().map(Vec3::norm_squared).sum();
        (squares / self.positions.len().max(1) as f64)
            .sqrt()
            .max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f64) -> Placement {
        let position = Vec3::new(x, 0.0, 0.0);
        let pose = Pose {
            position,
            ..Pose::identity()
        };
        (0, pose)
    }

    fn atoms(positions: &[Vec3]) -> CoreAtoms {
        CoreAtoms {
            positions: positions.to_vec(),
            radii_angstrom: vec![1.0; positions.len()],
        }
    }

    /// Whether two bodies of balls with a radius of 1 Å overlap.
    fn balls_overlap(bodies: &[CoreAtoms], a: &Placement, b: &Placement) -> bool {
        bodies[a.0].positions.iter().any(|of_a| {
            let of_a = a.1.transform_point(of_a);
            let mut others = bodies[b.0].positions.iter();
            others.any(|of_b| (of_a - b.1.transform_point(of_b)).norm() < 2.0)
        })
    }

    /// Three balls in a row, the outer ones in the middle one by 0.4 and 0.2 Å. With x the outward moves of
    /// the outer balls and y that of the middle one to the right: x₁ + y = 0.4 and x₃ - y = 0.2, the least
    /// squares at y = 0.2/3.
    #[test]
    fn the_displacements_of_three_balls_are_the_least_ones() {
        let bodies = [atoms(&[Vec3::zeros()])];
        let start = [ball(0.0), ball(1.6), ball(3.4)];
        let apart = separate(&bodies, &start, |a, b| balls_overlap(&bodies, a, b)).unwrap();
        let moved = [0, 1, 2].map(|i| apart.placements[i].1.position.x - start[i].1.position.x);
        for (found, expected) in moved.into_iter().zip([-1.0 / 3.0, 0.2 / 3.0, 0.8 / 3.0]) {
            assert!((found - expected).abs() < 0.02, "{moved:?}");
        }
        assert!(!balls_overlap(
            &bodies,
            &apart.placements[0],
            &apart.placements[1]
        ));
    }

    /// A rod that is hit at its end turns more than it moves: by the equation at the head, its centre
    /// moves by the share 1 / (2 + (arm / r)²) of the overlap, and the ball as much.
    #[test]
    fn a_rod_hit_at_its_end_turns() {
        let rod: Vec<Vec3> = (-6..=6)
            .map(|k| Vec3::new(0.0, f64::from(k), 0.0))
            .collect();
        let bodies = [atoms(&[Vec3::zeros()]), atoms(&rod)];
        let mut hit = ball(1.8);
        hit.1.position.y = 6.0;
        let rod = (1, Pose::identity());
        let apart = separate(&bodies, &[rod, hit], |a, b| balls_overlap(&bodies, a, b)).unwrap();
        let share = 0.2 / (2.0 + 36.0 / 14.0);
        let [rod, ball] = [0, 1].map(|place| apart.placements[place].1);
        assert!((ball.position.x - 1.8 - share).abs() < 0.01, "{ball:?}");
        assert!((rod.position.x + share).abs() < 0.01, "{rod:?}");
        assert!(rod.rotation.angle() > 0.01, "{rod:?}");
    }

    /// Two balls of radius 30 Å whose centres are 5 Å apart, and a ball of radius 1 Å that is 17 Å from
    /// the nearer one: it is hit only because that one must move by tens of ångström. With a, b and c the
    /// displacements along the line, b - a = 55 and c - b = -17, the least squares at b = 24.
    #[test]
    fn a_body_that_moves_far_overlaps_none_that_was_far_from_it() {
        let radii = [30.0, 1.0];
        let bodies = radii.map(|radius| CoreAtoms {
            positions: vec![Vec3::zeros()],
            radii_angstrom: vec![radius],
        });
        let mut far = ball(53.0);
        far.0 = 1;
        let start = [ball(0.0), ball(5.0), far];
        let overlap = |a: &Placement, b: &Placement| {
            (a.1.position - b.1.position).norm() < radii[a.0] + radii[b.0]
        };
        let apart = separate(&bodies, &start, overlap).unwrap().placements;
        assert!(!overlap(&apart[0], &apart[1]) && !overlap(&apart[1], &apart[2]));
        for (place, moved) in [-31.0, 24.0, 7.0].into_iter().enumerate() {
            let found = apart[place].1.position.x - start[place].1.position.x;
            assert!((found - moved).abs() < 0.1, "{found} {moved}");
        }
    }

    #[test]
    fn bodies_in_one_place_are_an_error_and_free_ones_stay() {
        let bodies = [atoms(&[Vec3::zeros()])];
        let none = separate(&bodies, &[ball(0.0), ball(3.0)], |_, _| false).unwrap();
        assert_eq!(none.placements, [ball(0.0), ball(3.0)]);
        let error = separate(&bodies, &[ball(0.0), ball(1.0)], |_, _| true).unwrap_err();
        assert!(error.to_string().contains("interlock"), "{error}");
    }
}
