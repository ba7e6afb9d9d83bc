//! Tilts and spins of rings and stacks.
//!
//! The pattern of a ring or stack fixes which bodies stand where and which of them point up. Tilts, spins, the
//! stagger of the rings and the opening between neighbours are left.

use super::{Arrangement, Closed, Found, Searched, Steps, search};
use anyhow::Result;
use protomer_body::assembly::{HardBodies, Recipe};
use protomer_kernel::Rotation;
use protomer_results::Execution;
use serde::Serialize;
use std::collections::BTreeMap;

/// Grid of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct RingGrid {
    /// Tilts, degrees.
    pub tilts_degrees: Vec<f64>,
    /// Spins, degrees.
    pub spins_degrees: Vec<f64>,
}

/// A pattern of bodies: which stand where, and which of them point up.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Direction of each body (true: up).
    pub up: Vec<bool>,
    /// Recipe of the pattern, without tilts and spins.
    pub recipe: Recipe,
}

/// An arrangement that the search found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundRing {
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

/// Searches the patterns for arrangements of low energy; `None` if the work was interrupted.
///
/// # Errors
/// For recipes that do not fit the bodies.
pub fn search_rings(
    searched: Searched,
    patterns: &[Pattern],
    grid: &RingGrid,
    execution: &Execution,
) -> Result<Option<Found<FoundRing>>> {
    let sites = patterns
        .iter()
        .flat_map(|pattern| pattern.recipe.rings.iter().flatten());
    let kinds = 1 + sites.map(|site| site.body).max().unwrap_or(0);
    // What is wrong with a pattern is an error; what cannot be closed later is an arrangement less.
    let frames = vec![Rotation::identity(); kinds];
    for pattern in patterns {
        pattern.recipe.placements(&frames, 1.0, 1.0, 0.0)?;
    }
    let points = grid_points(kinds, &grid.tilts_degrees, &grid.spins_degrees);
    let mut starts = Vec::with_capacity(patterns.len() * points.len());
    for pattern in patterns {
        starts.extend(points.iter().map(|coordinates| RingArrangement {
            pattern,
            coordinates: coordinates.clone(),
        }));
    }
    let found = search(searched, starts, execution, |point, terms_kt| {
        let RingArrangement {
            pattern,
            coordinates,
        } = point.arrangement;
        let recipe = coordinates.recipe(&pattern.recipe);
        let Coordinates {
            tilt_degrees,
            spin_degrees,
            stagger,
            opening_angstrom,
        } = coordinates.wrapped();
        FoundRing {
            up: pattern.up.clone(),
            tilt_degrees,
            spin_degrees,
            stagger,
            opening_angstrom,
            radius_angstrom: point.closed.radius_angstrom,
            ring_distance_angstrom: point.closed.ring_distance_angstrom,
            energy_kt: point.energy.total_kt(),
            terms_kt,
            is_refined: point.is_refined,
            recipe,
        }
    });
    Ok(found)
}

/// A pattern with its free coordinates.
#[derive(Debug, Clone)]
struct RingArrangement<'a> {
    pattern: &'a Pattern,
    coordinates: Coordinates,
}

impl Arrangement for RingArrangement<'_> {
    fn coordinates(&self) -> usize {
        self.coordinates.count(self.pattern.recipe.rings.len())
    }

    fn moved(&self, coordinate: usize, steps: &Steps, sign: f64) -> Option<Self> {
        Some(Self {
            coordinates: self.coordinates.moved(coordinate, steps, sign)?,
            ..self.clone()
        })
    }

    fn close(&self, bodies: &HardBodies, gap_angstrom: f64, tolerance: f64) -> Option<Closed> {
        let recipe = self.coordinates.recipe(&self.pattern.recipe);
        let symmetric = bodies
            .close_symmetric(&recipe, gap_angstrom, tolerance)
            .ok()?;
        Some(Closed {
            placements: symmetric.closed.placements,
            orbits: symmetric.orbits,
            radius_angstrom: symmetric.closed.radius_angstrom,
            ring_distance_angstrom: symmetric.closed.ring_distance_angstrom,
        })
    }
}

/// Tilts and spins of the kinds of bodies, stagger of the rings and opening between neighbours.
#[derive(Debug, Clone, PartialEq)]
struct Coordinates {
    /// Tilt of each kind of body, degrees.
    tilt_degrees: Vec<f64>,
    /// Spin of each kind of body, degrees.
    spin_degrees: Vec<f64>,
    /// Azimuth of the upper ring over the angle between neighbours.
    stagger: f64,
    /// Distance that neighbours keep beyond contact and gap, Å.
    opening_angstrom: f64,
}

impl Coordinates {
    /// The pattern with these tilts and spins.
    fn recipe(&self, pattern: &Recipe) -> Recipe {
        let mut recipe = pattern.clone();
        for site in recipe.rings.iter_mut().flatten() {
            site.tilt_radian = self.tilt_degrees[site.body].to_radians();
            site.spin_radian = self.spin_degrees[site.body].to_radians();
        }
        recipe.stagger = self.stagger;
        recipe.opening_angstrom = self.opening_angstrom;
        recipe
    }

    /// Number of free coordinates: those of a stack of two rings include the stagger.
    fn count(&self, rings: usize) -> usize {
        2 * self.tilt_degrees.len() + rings
    }

    /// The coordinates with one of them moved by a step; `None` where the opening would be negative.
    fn moved(&self, coordinate: usize, steps: &Steps, sign: f64) -> Option<Self> {
        let kinds = self.tilt_degrees.len();
        let mut moved = self.clone();
        match coordinate {
            tilt if tilt < kinds => moved.tilt_degrees[tilt] += sign * steps.angle_degrees,
            spin if spin < 2 * kinds => {
                moved.spin_degrees[spin - kinds] += sign * steps.angle_degrees;
            }
            opening if opening == 2 * kinds => moved.opening_angstrom += sign * steps.angstrom,
            _ => moved.stagger += sign * steps.share,
        }
        (moved.opening_angstrom >= 0.0).then_some(moved)
    }

    /// The same arrangement with angles from -180 to 180 degrees.
    fn wrapped(mut self) -> Self {
        for angle in self.tilt_degrees.iter_mut().chain(&mut self.spin_degrees) {
            let turns = (*angle / 360.0).round();
            *angle -= 360.0 * turns;
        }
        self
    }
}

/// All combinations of the tilts and spins for this many kinds of bodies, the last kind changing fastest.
fn grid_points(kinds: usize, tilts: &[f64], spins: &[f64]) -> Vec<Coordinates> {
    let choices = tilts.len() * spins.len();
    let mut points = Vec::with_capacity(choices.pow(kinds as u32));
    for mut number in 0..choices.pow(kinds as u32) {
        let (mut tilt_degrees, mut spin_degrees) = (vec![0.0; kinds], vec![0.0; kinds]);
        for kind in (0..kinds).rev() {
            let choice = number % choices;
            number /= choices;
            tilt_degrees[kind] = tilts[choice / spins.len()];
            spin_degrees[kind] = spins[choice % spins.len()];
        }
        points.push(Coordinates {
            tilt_degrees,
            spin_degrees,
            stagger: 0.0,
            opening_angstrom: 0.0,
        });
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::assembly::RecipeSite;

    #[test]
    fn the_grid_has_every_combination_once() {
        let points = grid_points(2, &[0.0, 45.0, 90.0], &[0.0, 30.0]);
        assert_eq!(points.len(), 36);
        for (number, point) in points.iter().enumerate() {
            assert!(!points[..number].contains(point));
        }
        assert_eq!(points[35].tilt_degrees, [90.0, 90.0]);
    }

    #[test]
    fn coordinates_move_one_by_one_and_reach_the_recipe() {
        let pattern = Recipe::dihedral(4, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
        let start = grid_points(2, &[10.0], &[20.0]).remove(0);
        let steps = Steps {
            angle_degrees: 5.0,
            angstrom: 1.0,
            share: 0.1,
        };
        assert_eq!(start.count(2), 6);
        let ways = (0..start.count(2)).filter_map(|k| start.moved(k, &steps, 1.0));
        let recipes: Vec<Recipe> = ways.map(|moved| moved.recipe(&pattern)).collect();
        for (number, recipe) in recipes.iter().enumerate() {
            assert!(*recipe != start.recipe(&pattern) && !recipes[..number].contains(recipe));
        }
        assert_eq!(recipes.len(), 6);
        assert_eq!(start.moved(4, &steps, -1.0), None, "bodies would overlap");
        let turned = Coordinates {
            tilt_degrees: vec![190.0, -540.0],
            ..start
        };
        assert_eq!(turned.wrapped().tilt_degrees, [-170.0, 180.0]);
    }
}
