//! The bodies near a place.

use crate::system::System;
use protomer_kernel::Vec3;
use protomer_kernel::cells::CellList;

/// Finds bodies that may touch one at a place, and bodies that interact with it.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    /// Cells as wide as the range of the interaction.
    cells: CellList,
    /// Smaller ones, where bodies interact farther than they touch.
    touching: Option<CellList>,
    ranges: Ranges,
}

/// Distances of origins, Å.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranges {
    /// Bodies beyond it cannot touch.
    pub hard_angstrom: f64,
    /// Of the interaction as the direct sum knows it. Random numbers depend on it.
    pub interaction_angstrom: f64,
    /// Of the interaction as the model knows it, no longer; zero without any.
    pub reach_angstrom: f64,
}

impl Neighbours {
    pub(crate) fn new(system: &System, ranges: Ranges) -> Self {
        let positions: Vec<Vec3> = system.poses().iter().map(|pose| pose.position).collect();
        let cells = |range: f64| CellList::new(system.boundary(), range, &positions);
        let ranges = Ranges {
            interaction_angstrom: ranges.hard_angstrom.max(ranges.interaction_angstrom),
            ..ranges
        };
        let is_longer = ranges.interaction_angstrom > ranges.hard_angstrom;
        Self {
            cells: cells(ranges.interaction_angstrom),
            touching: is_longer.then(|| cells(ranges.hard_angstrom)),
            ranges,
        }
    }

    /// Writes all bodies in the cells around a place into `found`, ascending: those in range among them.
    pub(crate) fn around(&self, place: &Vec3, found: &mut Vec<usize>) {
        self.cells.candidates(place, found);
    }

    /// Writes the bodies that may touch one at this place into `found`, ascending.
    pub(crate) fn find_touching(&self, system: &System, place: &Vec3, found: &mut Vec<usize>) {
        let cells = self.touching.as_ref().unwrap_or(&self.cells);
        cells.candidates(place, found);
        retain_within(system, &[*place], self.ranges.hard_angstrom, found);
    }

    /// Writes the bodies in reach of either of two places into `found`, ascending; others that are
    /// hardly farther may be among them.
    pub(crate) fn find_at_both(
        &self,
        system: &System,
        [from, to]: [&Vec3; 2],
        found: &mut Vec<usize>,
    ) {
        let reach = self.ranges.reach_angstrom;
        if reach == 0.0 {
            return found.clear();
        }
        let of_both = reach + system.boundary().displacement(from, to).norm();
        self.around(to, found);
        if of_both <= self.ranges.interaction_angstrom {
            return retain_within(system, &[*to], of_both, found);
        }
        let mut around_from = Vec::new();
        self.around(from, &mut around_from);
        found.extend(around_from);
        found.sort_unstable();
        found.dedup();
        retain_within(system, &[*from, *to], reach, found);
    }

    /// A body has moved.
    pub(crate) fn moved(&mut self, body: usize, from: &Vec3, to: &Vec3) {
        self.cells.moved(body, from, to);
        if let Some(touching) = &mut self.touching {
            touching.moved(body, from, to);
        }
    }
}

/// Keeps the bodies with an image nearer than this (Å) to one of the places.
fn retain_within(system: &System, places: &[Vec3], angstrom: f64, found: &mut Vec<usize>) {
    let square = angstrom * angstrom;
    found.retain(|body| {
        let position = &system.pose(*body).position;
        places.iter().any(|place| {
            let displacement = system.boundary().displacement(place, position);
            displacement.norm_squared() < square
        })
    });
}
