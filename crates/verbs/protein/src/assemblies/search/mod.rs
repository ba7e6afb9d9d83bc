//! Search of symmetric arrangements for low energies.
//!
//! Starting points come first: a grid over tilts and spins of a ring or stack (`ring`), or random sites of a
//! cubic group (`cage`). The lowest are then refined one coordinate at a time, by steps that are halved when no
//! step helps. Every arrangement is closed to contact by the exact overlap test, so no energy is that of
//! bodies in each other.
//!
//! | module | one idea |
//! |---|---|
//! | [`ring`] | tilts, spins, stagger and opening of rings and stacks |
//! | [`cage`] | positions and orientations in a cubic group |
//! | `energies` | energies by orbits |

pub mod cage;
mod energies;
pub mod ring;

use energies::PairEnergies;
use protomer_body::assembly::orbits::Orbit;
use protomer_body::assembly::{HardBodies, Placement};
use protomer_common::cpu_time::ProcessClock;
use protomer_mc::energy::terms::{EnergyParts, TermsOfKinds};
use protomer_results::Execution;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Tolerance of contacts of starting points, Å.
const COARSE_ANGSTROM: f64 = 0.02;
/// Tolerance of contacts of refined arrangements, Å: that of `assemble ring`.
const FINE_ANGSTROM: f64 = 1e-3;
/// First steps of a refinement.
const FIRST: Steps = Steps {
    angle_degrees: 10.0,
    angstrom: 1.0,
    share: 0.1,
};
/// Starting points that take the first steps, for each arrangement that is refined to the end: wells are narrow, and
/// the lowest starting point need not lie in the lowest one.
const TRIED_FOR_ONE: usize = 6;
/// Step sizes of these first steps: 10° and 5°.
const FIRST_SIZES: usize = 2;
/// Step sizes of the remaining refinement: down to 0.6°, 0.06 Å and 0.006.
const LAST_SIZES: usize = 3;
/// Energies of one arrangement that was found twice are nearer than this, kT.
const SAME_KT: f64 = 0.05;
/// Sizes of one arrangement that was found twice are nearer than this, Å.
const SAME_ANGSTROM: f64 = 0.1;

/// Bodies of a search and the energies between them.
pub struct Searched<'a> {
    /// The bodies, prepared for overlap tests.
    pub bodies: &'a HardBodies,
    /// Terms of the energy of each two kinds of bodies, the lower kind first.
    pub potentials: TermsOfKinds,
    /// Gap between bodies beyond contact, Å.
    pub gap_angstrom: f64,
    /// Number of arrangements that are refined.
    pub refined: usize,
}

impl Searched<'_> {
    /// Number of arrangements that are refined where none is stated.
    pub const REFINED: usize = 12;
}

/// The arrangements of a search, the lowest energy first.
#[derive(Debug, Clone, PartialEq)]
pub struct Found<F> {
    /// Different arrangements.
    pub arrangements: Vec<F>,
    /// Arrangements that were tried.
    pub evaluated: usize,
    /// Starting points that cannot be closed, because bodies interlock.
    pub unusable: usize,
    /// Processor time of the search, s.
    pub cpu_seconds: f64,
}

/// Steps of a refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Steps {
    /// Step of angles, degrees.
    angle_degrees: f64,
    /// Step of distances, Å.
    angstrom: f64,
    /// Step of what is a share of another length or angle.
    share: f64,
}

impl Steps {
    /// Steps of half the size.
    fn halved(self) -> Self {
        Self {
            angle_degrees: 0.5 * self.angle_degrees,
            angstrom: 0.5 * self.angstrom,
            share: 0.5 * self.share,
        }
    }
}

/// A symmetric arrangement with free coordinates.
trait Arrangement: Clone + Send + Sync {
    /// Number of free coordinates.
    fn coordinates(&self) -> usize;

    /// The arrangement with one coordinate moved by a step; `None` where there is no such arrangement.
    fn moved(&self, coordinate: usize, steps: &Steps, sign: f64) -> Option<Self>;

    /// The arrangement at contact; `None` if bodies interlock.
    fn close(&self, bodies: &HardBodies, gap_angstrom: f64, tolerance: f64) -> Option<Closed>;
}

/// An arrangement at contact.
#[derive(Debug, Clone, PartialEq)]
struct Closed {
    placements: Vec<Placement>,
    orbits: Vec<Orbit>,
    radius_angstrom: f64,
    /// Distance of the two rings of a stack, Å.
    ring_distance_angstrom: f64,
}

/// An arrangement at contact, with its energy.
#[derive(Debug, Clone)]
struct Point<A> {
    arrangement: A,
    closed: Closed,
    energy: EnergyParts,
    is_refined: bool,
}

impl<A> Point<A> {
    fn is_below(&self, other: &Self) -> bool {
        self.energy.total_kt() < other.energy.total_kt()
    }

    fn has_size_of(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < SAME_ANGSTROM;
        near(self.closed.radius_angstrom, other.closed.radius_angstrom)
            && near(
                self.closed.ring_distance_angstrom,
                other.closed.ring_distance_angstrom,
            )
    }
}

/// Finds arrangements of low energy from these starting points; `None` if the work was interrupted.
/// `describe` makes the answer of each; it gets the terms of its energy by name, kT.
fn search<A: Arrangement, F>(
    searched: Searched,
    starts: Vec<A>,
    execution: &Execution,
    describe: impl Fn(Point<A>, BTreeMap<&'static str, f64>) -> F,
) -> Option<Found<F>> {
    let clock = ProcessClock::start();
    let search = Search {
        bodies: searched.bodies,
        energies: PairEnergies(searched.potentials),
        gap_angstrom: searched.gap_angstrom,
        execution,
    };
    let points = search.start(starts)?;
    let mut evaluated = points.len();
    let points: Vec<Point<A>> = points.into_iter().flatten().collect();
    let unusable = evaluated - points.len();
    let mut lowest = different(points);
    let mut remaining = lowest.split_off(lowest.len().min(TRIED_FOR_ONE * searched.refined));
    let last = (0..FIRST_SIZES).fold(FIRST, |steps, _| steps.halved());
    lowest = search.refine(lowest, FIRST, FIRST_SIZES, COARSE_ANGSTROM, &mut evaluated)?;
    remaining.extend(lowest.split_off(lowest.len().min(searched.refined)));
    let mut refined = search.refine(lowest, last, LAST_SIZES, FINE_ANGSTROM, &mut evaluated)?;
    for point in &mut refined {
        point.is_refined = true;
    }
    let mut points = refined;
    points.extend(remaining);
    points.sort_by(|a, b| a.energy.total_kt().total_cmp(&b.energy.total_kt()));
    let answer = |point: Point<A>| {
        let terms_kt = search.energies.by_name(&point.energy);
        describe(point, terms_kt)
    };
    Some(Found {
        arrangements: points.into_iter().map(answer).collect(),
        evaluated,
        unusable,
        cpu_seconds: clock.seconds(),
    })
}

/// Bodies and energies that all arrangements of a search share.
struct Search<'a> {
    bodies: &'a HardBodies,
    energies: PairEnergies,
    gap_angstrom: f64,
    execution: &'a Execution,
}

impl Search<'_> {
    /// The starting points that can be closed; `None` if the work was interrupted.
    fn start<A: Arrangement>(&self, starts: Vec<A>) -> Option<Vec<Option<Point<A>>>> {
        let progress = &self.execution.progress;
        progress.begin(starts.len() as u64, "arrangements");
        let closed = starts.into_par_iter().map(|start| {
            if self.execution.interrupt.is_requested() {
                return None;
            }
            let point = self.point(start, COARSE_ANGSTROM);
            progress.advance(1);
            Some(point)
        });
        closed.collect()
    }

    /// An arrangement, closed to contact, with its energy.
    fn point<A: Arrangement>(&self, arrangement: A, tolerance: f64) -> Option<Point<A>> {
        let closed = arrangement.close(self.bodies, self.gap_angstrom, tolerance)?;
        Some(Point {
            arrangement,
            energy: self.energies.energy(&closed.placements, &closed.orbits),
            closed,
            is_refined: false,
        })
    }

    /// The different arrangements after steps of this many sizes, the lowest first. Adds to the number of
    /// arrangements that were tried; `None` if the work was interrupted.
    fn refine<A: Arrangement>(
        &self,
        points: Vec<Point<A>>,
        first: Steps,
        sizes: usize,
        tolerance: f64,
        tried: &mut usize,
    ) -> Option<Vec<Point<A>>> {
        let descended = points
            .into_par_iter()
            .map(|point| self.descend(point, first, sizes, tolerance));
        let descended: Vec<(Point<A>, usize)> = descended.collect::<Option<_>>()?;
        *tried += descended.iter().map(|(_, tried)| tried).sum::<usize>();
        let points = descended.into_iter().map(|(point, _)| point);
        Some(different(points.collect()))
    }

    /// The arrangement after steps of its coordinates, each of which lowered the energy, and the number
    /// of arrangements that were tried; `None` if the work was interrupted.
    fn descend<A: Arrangement>(
        &self,
        start: Point<A>,
        first: Steps,
        sizes: usize,
        tolerance: f64,
    ) -> Option<(Point<A>, usize)> {
        let mut steps = first;
        // Closed again, because the tolerance may have been wider before.
        let closed = self.point(start.arrangement.clone(), tolerance);
        let mut best = closed.unwrap_or(start);
        let mut tried = 1;
        for _ in 0..sizes {
            while let Some(lower) = self.lower(&best, &steps, tolerance, &mut tried)? {
                best = lower;
            }
            steps = steps.halved();
        }
        Some((best, tried))
    }

    /// The arrangement after a round of steps, one for each coordinate that helps; `Some(None)` if none
    /// does, `None` if the work was interrupted.
    #[allow(clippy::option_option)] // ended, no step helps, a lower one
    fn lower<A: Arrangement>(
        &self,
        point: &Point<A>,
        steps: &Steps,
        tolerance: f64,
        tried: &mut usize,
    ) -> Option<Option<Point<A>>> {
        let mut best: Option<Point<A>> = None;
        for coordinate in 0..point.arrangement.coordinates() {
            for sign in [1.0, -1.0] {
                if self.execution.interrupt.is_requested() {
                    return None;
                }
                let lowest = best.as_ref().unwrap_or(point);
                let Some(moved) = lowest.arrangement.moved(coordinate, steps, sign) else {
                    continue;
                };
                *tried += 1;
                let next = self.point(moved, tolerance);
                if let Some(next) = next.filter(|next| next.is_below(lowest)) {
                    best = Some(next);
                    break;
                }
            }
        }
        Some(best)
    }
}

/// The points in the order of their energies, without those that are the same arrangement as an earlier
/// one: of the same energy and size.
fn different<A>(mut points: Vec<Point<A>>) -> Vec<Point<A>> {
    points.sort_by(|a, b| a.energy.total_kt().total_cmp(&b.energy.total_kt()));
    let mut kept: Vec<Point<A>> = Vec::with_capacity(points.len());
    for point in points {
        let energy_kt = point.energy.total_kt();
        let mut near = kept
            .iter()
            .rev()
            .take_while(|other| energy_kt - other.energy.total_kt() < SAME_KT);
        if !near.any(|other| point.has_size_of(other)) {
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
mod tests;
