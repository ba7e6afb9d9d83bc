//! Deformations of the box, with the bodies in it.

use super::System;
use protomer_kernel::shape::separation::dot;

/// Outcome of an attempt to deform the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Deformation {
    /// The box is deformed.
    Done,
    /// Bodies would overlap; nothing has changed.
    Blocked,
    /// No two bodies overlap, but the box would be too small to tell whether a body meets its own images;
    /// nothing has changed.
    TooSmall,
}

impl<const D: usize> System<D> {
    /// Deforms the box and the places in it by an upper triangular matrix (see [`PeriodicBox::deformed`]),
    /// unless bodies overlap then or could meet images of themselves.
    pub(crate) fn try_deform(&mut self, matrix: &[[f64; D]; D]) -> Deformation {
        let space = self.space.deformed(matrix).reduced();
        let is_too_small = space.smallest_length() < self.least_edge();
        // Copied before: a blocked change, which is the usual end, must leave no trace.
        let before = (self.space, self.positions.clone(), self.grid.clone());
        self.space = space;
        for place in &mut self.positions {
            // The centres move with the space, the bodies keep their shape and orientation.
            let new_place = matrix.map(|row| dot(&row, place));
            *place = space.wrap(&new_place);
        }
        self.sort();
        // Pairs first try the direction that separated them last: after a small change it mostly still does.
        let is_blocked = (0..self.len()).any(|body| self.collides(&self.where_it_is(body)));
        if !is_blocked && !is_too_small {
            return Deformation::Done;
        }
        (self.space, self.positions, self.grid) = before;
        match is_blocked {
            true => Deformation::Blocked,
            false => Deformation::TooSmall,
        }
    }
}
