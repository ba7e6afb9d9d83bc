//! The bodies near a place.

use crate::system::System;
use protomer_kernel::Vec3;
use protomer_kernel::cells::CellList;

/// Finds bodies that may touch one at a place, and bodies that interact with it.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    /// Cells as wide as the range of the interaction.
    cells: CellList,
    /// Smaller cells, where bodies interact farther than they touch.
    touching: Option<CellList>,
    /// Wider cells, where bodies share places for depletants farther apart than they interact.
    sharing: Option<CellList>,
    ranges: Ranges,
}

/// Distances of origins, Å.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranges {
    /// Distance beyond which bodies cannot touch.
    pub hard_angstrom: f64,
    /// Range of the interaction as the direct sum knows it. Random numbers depend on it.
    pub interaction_angstrom: f64,
    /// Range of the interaction as the model knows it, no longer than that of the direct sum; zero
    /// without an interaction.
    pub reach_angstrom: f64,
    /// Distance beyond which no depletant touches two bodies; zero without depletants.
    pub depletion_angstrom: f64,
}

impl Neighbours {
    pub(crate) fn new(system: &System, ranges: Ranges) -> Self {
        let positions: Vec<Vec3> = system.poses().iter().map(|pose| pose.position).collect();
        let cells = |range: f64| CellList::new(system.boundary(), range, &positions);
        // One list must serve both questions where ranges are alike.
        let ranges = Ranges {
            interaction_angstrom: ranges.hard_angstrom.max(ranges.interaction_angstrom),
            ..ranges
        };
        let is_longer = ranges.interaction_angstrom > ranges.hard_angstrom;
        let is_longest = ranges.depletion_angstrom > ranges.interaction_angstrom;
        // A second, finer grid pays only where surfaces touch much nearer than charges reach.
        Self {
            cells: cells(ranges.interaction_angstrom),
            touching: is_longer.then(|| cells(ranges.hard_angstrom)),
            // Cells of their own: the draws of cluster moves depend on those of the interaction.
            sharing: is_longest.then(|| cells(ranges.depletion_angstrom)),
            ranges,
        }
    }

    /// Writes all bodies in the cells around a place into `bodies`, ascending: those in range among them.
    pub(crate) fn around(&self, place: &Vec3, bodies: &mut Vec<usize>) {
        self.cells.candidates(place, bodies);
    }

    /// Writes the bodies that may touch one at this place into `bodies`, ascending.
    pub(crate) fn find_touching(&self, system: &System, place: &Vec3, bodies: &mut Vec<usize>) {
        let cells = self.touching.as_ref().unwrap_or(&self.cells);
        cells.candidates(place, bodies);
        retain_within(system, &[*place], self.ranges.hard_angstrom, bodies);
    }

    /// Writes the bodies that may share places for depletants with one at this place into `bodies`, ascending; others may be among
    /// them.
    pub(crate) fn find_sharing(&self, place: &Vec3, bodies: &mut Vec<usize>) {
        let cells = self.sharing.as_ref().unwrap_or(&self.cells);
        cells.candidates(place, bodies);
    }

    /// Writes the bodies in reach of either of two places into `bodies`, ascending; others that are
    /// hardly farther may be among them.
    pub(crate) fn find_at_both(
        &self,
        system: &System,
        [from, to]: [&Vec3; 2],
        bodies: &mut Vec<usize>,
    ) {
        let reach = self.ranges.reach_angstrom;
        // Nothing interacts, and no decision needs a partner.
        if reach == 0.0 {
            return bodies.clear();
        }
        // Every partner of the old place is this near to the new one.
        let of_both = reach + system.boundary().displacement(from, to).norm();
        self.around(to, bodies);
        // One search for both places, as long as the cells are wide enough for the sum.
        if of_both <= self.ranges.interaction_angstrom {
            return retain_within(system, &[*to], of_both, bodies);
        }
        let mut around_from = Vec::new();
        self.around(from, &mut around_from);
        bodies.extend(around_from);
        bodies.sort_unstable();
        bodies.dedup();
        retain_within(system, &[*from, *to], reach, bodies);
    }

    /// Notes that a body has moved.
    pub(crate) fn moved(&mut self, body: usize, from: &Vec3, to: &Vec3) {
        self.cells.moved(body, from, to);
        if let Some(touching) = &mut self.touching {
            touching.moved(body, from, to);
        }
        if let Some(sharing) = &mut self.sharing {
            sharing.moved(body, from, to);
        }
    }
}

/// Keeps the bodies with an image nearer than this (Å) to one of the places.
fn retain_within(system: &System, places: &[Vec3], angstrom: f64, bodies: &mut Vec<usize>) {
    let square = angstrom * angstrom;
    bodies.retain(|body| {
        let position = &system.pose(*body).position;
        places.iter().any(|place| {
            let displacement = system.boundary().displacement(place, position);
            displacement.norm_squared() < square
        })
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::test_support::tetrahedron;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Boundary, Pose};
    use std::sync::Arc;

    const RANGES: Ranges = Ranges {
        hard_angstrom: 6.0,
        interaction_angstrom: 24.0,
        reach_angstrom: 15.0,
        depletion_angstrom: 0.0,
    };

    fn system(boundary: Boundary, edge: f64, rng: &mut CounterRng) -> System {
        let mesh = tetrahedron(1.0);
        let kind = Arc::new(BodyType::new("body", &mesh, &[]).unwrap());
        let mut body = |_| {
            let position = Vec3::from_fn(|_, _| edge * rng.uniform_in(-0.5, 0.5));
            let rotation = rng.rotation();
            (0, Pose { position, rotation })
        };
        let bodies: Vec<_> = (0..300).map(&mut body).collect();
        System::new(vec![kind], &bodies, boundary).unwrap()
    }

    /// Short moves take one look at the cells, long ones two; the last box has too few cells.
    #[test]
    fn bodies_near_either_place_are_those_of_a_search_among_all() {
        let mut rng = CounterRng::new(72, 0, 0);
        let cube = |edge: f64| Boundary::periodic(Vec3::repeat(edge)).unwrap();
        for (boundary, edge) in [
            (cube(120.0), 120.0),
            (Boundary::Open, 100.0),
            (cube(50.0), 50.0),
        ] {
            let system = system(boundary, edge, &mut rng);
            let neighbours = Neighbours::new(&system, RANGES);
            let distance = |place: &Vec3, body: usize| {
                let position = &system.pose(body).position;
                system.boundary().displacement(place, position).norm()
            };
            for moved_angstrom in [0.5, 8.0, 60.0] {
                for _ in 0..60 {
                    let from = Vec3::from_fn(|_, _| edge * rng.uniform_in(-0.5, 0.5));
                    let to = boundary.wrap(&(from + moved_angstrom * rng.unit_vector()));
                    let mut found = Vec::new();
                    neighbours.find_touching(&system, &to, &mut found);
                    let touching = (0..300).filter(|body| distance(&to, *body) < 6.0);
                    assert_eq!(found, touching.collect::<Vec<_>>());
                    neighbours.find_at_both(&system, [&from, &to], &mut found);
                    assert!(found.is_sorted_by(|a, b| a < b));
                    for body in 0..300 {
                        let nearest = distance(&from, body).min(distance(&to, body));
                        let is_found = found.binary_search(&body).is_ok();
                        assert!(is_found || nearest >= 15.0, "{edge} {moved_angstrom}");
                        assert!(!is_found || nearest < 15.0 + moved_angstrom);
                    }
                }
            }
        }
    }
}
