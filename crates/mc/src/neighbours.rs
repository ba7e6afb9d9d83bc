//! The bodies in range of a place.

use crate::system::System;
use protomer_kernel::Vec3;
use protomer_kernel::cells::CellList;

/// Finds bodies whose origins are within a range of a place.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    cells: CellList,
    square_angstrom2: f64,
}

impl Neighbours {
    /// Cells are for the range; bodies beyond the reach, which is no longer, are not found.
    pub(crate) fn new(system: &System, range_angstrom: f64, reach_angstrom: f64) -> Self {
        let positions: Vec<Vec3> = system.poses().iter().map(|pose| pose.position).collect();
        Self {
            cells: CellList::new(system.boundary(), range_angstrom, &positions),
            square_angstrom2: reach_angstrom.powi(2),
        }
    }

    /// Writes all bodies in the cells around a place into `found`, ascending: those in range among them.
    pub(crate) fn around(&self, place: &Vec3, found: &mut Vec<usize>) {
        self.cells.candidates(place, found);
    }

    /// Writes the bodies with an image in range of a place into `found`, ascending. The cells around a
    /// place hold some six times as many.
    pub(crate) fn find(&self, system: &System, place: &Vec3, found: &mut Vec<usize>) {
        self.around(place, found);
        found.retain(|body| {
            let position = &system.pose(*body).position;
            let displacement = system.boundary().displacement(place, position);
            displacement.norm_squared() < self.square_angstrom2
        });
    }

    /// A body has moved.
    pub(crate) fn moved(&mut self, body: usize, from: &Vec3, to: &Vec3) {
        self.cells.moved(body, from, to);
    }
}
