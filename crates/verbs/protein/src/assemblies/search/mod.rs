//! Search of symmetric arrangements for low energies.
//!
//! The pattern of a ring or stack fixes which bodies stand where and which of them point up. Tilts, spins, the
//! stagger of the rings and the opening between neighbours are left. A grid over tilts and spins comes
//! first; the lowest arrangements are then refined one coordinate at a time, by steps that are halved when
//! no step helps. Every arrangement is closed to contact by the exact overlap test, so no energy is that of
//! bodies in each other.
//!
//! | module | one idea |
//! |---|---|
//! | `coordinates` | what is left free, and the recipe that it makes |
//! | `energies` | energies by orbits |

mod coordinates;
mod energies;

use anyhow::Result;
use coordinates::{Coordinates, Steps, grid};
use energies::PairEnergies;
use protomer_body::assembly::{ClosedAssembly, HardBodies, Recipe};
use protomer_common::cpu_time::ProcessClock;
use protomer_kernel::Rotation;
use protomer_mc::energy::terms::{EnergyParts, Terms};
use protomer_results::Execution;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// Tolerance of contacts in the grid, Å.
const COARSE_ANGSTROM: f64 = 0.02;
/// Tolerance of contacts of refined arrangements, Å: that of `assemble ring`.
const FINE_ANGSTROM: f64 = 1e-3;
/// First steps of a refinement where the grid has none, and the last ones.
const FIRST: Steps = Steps {
    angle_degrees: 10.0,
    angstrom: 1.0,
    stagger: 0.1,
};
/// Halvings of the steps until an arrangement counts as refined: 0.6°, 0.06 Å and 0.006 in the end.
const HALVINGS: usize = 4;
/// Arrangements are one if their energies are nearer than this, kT, and their sizes as below.
const SAME_KT: f64 = 0.05;
/// Radii and ring distances of one arrangement are nearer than this, Å.
const SAME_ANGSTROM: f64 = 0.1;

/// Grid of a search and number of refinements.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchSettings {
    /// Tilts of the grid, degrees.
    pub tilts_degrees: Vec<f64>,
    /// Spins of the grid, degrees.
    pub spins_degrees: Vec<f64>,
    /// Number of arrangements that are refined.
    pub refined: usize,
    /// Gap between neighbours and between rings, Å.
    pub gap_angstrom: f64,
}

impl SearchSettings {
    /// Number of arrangements that are refined where none is stated.
    pub const REFINED: usize = 12;
}

/// An arrangement that the search found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundArrangement {
    /// Direction of each body (true: up), ring by ring from below.
    pub up: Vec<bool>,
    /// Tilt of each kind of body, degrees.
    pub tilt_degrees: Vec<f64>,
    /// Spin of each kind of body, degrees.
    pub spin_degrees: Vec<f64>,
    /// Azimuth of the upper ring over the angle between neighbours.
    pub stagger: f64,
    /// Distance that neighbours keep beyond contact and gap, Å.
    pub opening_angstrom: f64,
    /// Radius of the rings, Å.
    pub radius_angstrom: f64,
    /// Distance of the two rings, Å; zero for one ring.
    pub ring_distance_angstrom: f64,
    /// Energy of the whole arrangement, kT.
    pub energy_kt: f64,
    /// Terms of the energy, kT.
    pub terms_kt: BTreeMap<&'static str, f64>,
    /// Whether the arrangement was refined, or is a point of the grid.
    pub is_refined: bool,
    /// The recipe.
    #[serde(skip)]
    pub recipe: Recipe,
}

/// The arrangements of a search, the lowest energy first.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Different arrangements.
    pub arrangements: Vec<FoundArrangement>,
    /// Arrangements that were tried.
    pub evaluated: usize,
    /// Arrangements of the grid that cannot be closed, because bodies interlock.
    pub unusable: usize,
    /// Processor time of the search, s.
    pub cpu_seconds: f64,
}

/// A pattern of bodies: which stand where, and which of them point up.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Direction of each body (true: up).
    pub up: Vec<bool>,
    /// Recipe of the pattern, without tilts and spins.
    pub recipe: Recipe,
}

/// One arrangement in the search.
#[derive(Debug, Clone)]
struct Point {
    pattern: usize,
    coordinates: Coordinates,
    closed: ClosedAssembly,
    energy: EnergyParts,
}

impl Point {
    fn is_below(&self, other: &Self) -> bool {
        self.energy.total_kt() < other.energy.total_kt()
    }
}

/// Searches the patterns for arrangements of low energy; `None` if the work was interrupted.
///
/// # Errors
/// For recipes that do not fit the bodies, and bodies that overlap at every distance.
pub fn search(
    bodies: &HardBodies,
    potentials: BTreeMap<(usize, usize), Terms>,
    patterns: &[Pattern],
    settings: &SearchSettings,
    execution: &Execution,
) -> Result<Option<Found>> {
    let clock = ProcessClock::start();
    let kinds = 1 + patterns
        .iter()
        .flat_map(|pattern| pattern.recipe.rings.iter().flatten())
        .map(|site| site.body)
        .max()
        .unwrap_or(0);
    let search = Search {
        bodies,
        energies: PairEnergies(potentials),
        patterns,
        settings,
        execution,
    };
    // What is wrong with a pattern is an error; what cannot be closed later is an arrangement less.
    let frames = vec![Rotation::identity(); kinds];
    for pattern in patterns {
        pattern.recipe.placements(&frames, 1.0, 1.0, 0.0)?;
    }
    let grid = grid(kinds, &settings.tilts_degrees, &settings.spins_degrees);
    let Some(points) = search.grid(&grid) else {
        return Ok(None);
    };
    let mut evaluated = points.len();
    let points: Vec<Point> = points.into_iter().flatten().collect();
    let unusable = evaluated - points.len();
    let mut sorted = different(points);
    let remaining = sorted.split_off(settings.refined.min(sorted.len()));
    let refined: Vec<Option<(Point, usize)>> = sorted
        .into_par_iter()
        .map(|point| search.refine(point))
        .collect();
    let Some(refined) = refined.into_iter().collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    evaluated += refined.iter().map(|(_, tried)| tried).sum::<usize>();
    let refined = different(refined.into_iter().map(|(point, _)| point).collect());
    let mut arrangements: Vec<FoundArrangement> = Vec::new();
    for (points, is_refined) in [(refined, true), (remaining, false)] {
        arrangements.extend(points.into_iter().map(|p| search.found(p, is_refined)));
    }
    arrangements.sort_by(|a, b| a.energy_kt.total_cmp(&b.energy_kt));
    Ok(Some(Found {
        arrangements,
        evaluated,
        unusable,
        cpu_seconds: clock.seconds(),
    }))
}

/// Bodies, energies and patterns that all arrangements of a search share.
struct Search<'a> {
    bodies: &'a HardBodies,
    energies: PairEnergies,
    patterns: &'a [Pattern],
    settings: &'a SearchSettings,
    execution: &'a Execution,
}

impl Search<'_> {
    /// Every pattern at every point of the grid, where it can be closed; `None` if the work was interrupted.
    fn grid(&self, grid: &[Coordinates]) -> Option<Vec<Option<Point>>> {
        let progress = &self.execution.progress;
        progress.begin((grid.len() * self.patterns.len()) as u64, "arrangements");
        let points = (0..grid.len() * self.patterns.len()).into_par_iter();
        let closed = points.map(|number| {
            if self.execution.interrupt.is_requested() {
                return None;
            }
            let (pattern, point) = (number / grid.len(), number % grid.len());
            let point = self.point(pattern, grid[point].clone(), COARSE_ANGSTROM);
            progress.advance(1);
            Some(point)
        });
        closed.collect()
    }

    /// An arrangement, closed to contact, with its energy; `None` if the gap would bring bodies that
    /// interlock into each other.
    fn point(&self, pattern: usize, coordinates: Coordinates, tolerance: f64) -> Option<Point> {
        let recipe = coordinates.recipe(&self.patterns[pattern].recipe);
        let gap = self.settings.gap_angstrom;
        let symmetric = self.bodies.close_symmetric(&recipe, gap, tolerance).ok()?;
        let placements = &symmetric.closed.placements;
        Some(Point {
            pattern,
            coordinates,
            energy: self.energies.energy(placements, &symmetric.orbits),
            closed: symmetric.closed,
        })
    }

    /// The arrangement after steps of its coordinates, each of which lowered the energy, and the number
    /// of arrangements that were tried; `None` if the work was interrupted.
    fn refine(&self, start: Point) -> Option<(Point, usize)> {
        let pattern = start.pattern;
        let rings = self.patterns[pattern].recipe.rings.len();
        let mut steps = FIRST;
        // Closed again, because the tolerance of the grid is wider.
        let fine = self.point(pattern, start.coordinates.clone(), FINE_ANGSTROM);
        let mut best = fine.unwrap_or(start);
        let mut tried = 1;
        for _ in 0..=HALVINGS {
            let mut helped = true;
            while helped {
                helped = false;
                for coordinate in 0..best.coordinates.count(rings) {
                    for sign in [1.0, -1.0] {
                        if self.execution.interrupt.is_requested() {
                            return None;
                        }
                        let Some(moved) = best.coordinates.moved(coordinate, &steps, sign) else {
                            continue;
                        };
                        tried += 1;
                        let next = self.point(pattern, moved, FINE_ANGSTROM);
                        let lower = next.filter(|next| next.is_below(&best));
                        if let Some(next) = lower {
                            best = next;
                            helped = true;
                            break;
                        }
                    }
                }
            }
            steps = steps.halved();
        }
        Some((best, tried))
    }

    fn found(&self, point: Point, is_refined: bool) -> FoundArrangement {
        let pattern = &self.patterns[point.pattern];
        let recipe = point.coordinates.recipe(&pattern.recipe);
        let Coordinates {
            tilt_degrees,
            spin_degrees,
            stagger,
            opening_angstrom,
        } = point.coordinates.wrapped();
        FoundArrangement {
            up: pattern.up.clone(),
            tilt_degrees,
            spin_degrees,
            stagger,
            opening_angstrom,
            radius_angstrom: point.closed.radius_angstrom,
            ring_distance_angstrom: point.closed.ring_distance_angstrom,
            energy_kt: point.energy.total_kt(),
            terms_kt: self.energies.by_name(&point.energy),
            is_refined,
            recipe,
        }
    }
}

/// The points in the order of their energies, without those that are the same arrangement as an earlier
/// one: of the same energy and size.
fn different(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.energy.total_kt().total_cmp(&b.energy.total_kt()));
    let mut kept: Vec<Point> = Vec::with_capacity(points.len());
    for point in points {
        let is_same = |other: &&Point| {
            (point.closed.radius_angstrom - other.closed.radius_angstrom).abs() < SAME_ANGSTROM
                && (point.closed.ring_distance_angstrom - other.closed.ring_distance_angstrom).abs()
                    < SAME_ANGSTROM
        };
        let near = kept
            .iter()
            .rev()
            .take_while(|other| point.energy.total_kt() - other.energy.total_kt() < SAME_KT);
        if !near.into_iter().any(|other| is_same(&other)) {
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking
mod tests;
