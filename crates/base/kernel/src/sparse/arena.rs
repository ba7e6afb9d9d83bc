//! Places in a workspace that is planned ahead.

/// Ranges of a workspace, the lowest free one first.
#[derive(Debug, Default)]
pub(super) struct Arena {
    /// Free ranges (start, end) below `size`, ascending.
    free: Vec<(usize, usize)>,
    /// The length that the workspace must have.
    pub size: usize,
}

impl Arena {
    /// Reserves a range of this length and returns its start.
    pub fn take(&mut self, length: usize) -> usize {
        // First fit: places are planned once per pattern, so the scan costs nothing in a run.
        for index in 0..self.free.len() {
            let (start, end) = self.free[index];
            if end - start >= length {
                self.free[index].0 += length;
                if start + length == end {
                    self.free.remove(index);
                }
                return start;
            }
        }
        // A free range at the end is too short but can be lengthened.
        let start = self.take_free_end();
        self.size = start + length;
        start
    }

    /// Takes the free range at the end of the workspace and returns its start, or the end of the
    /// workspace if there is none.
    fn take_free_end(&mut self) -> usize {
        match self.free.last() {
            Some(&(start, end)) if end == self.size => {
                self.free.pop();
                start
            }
            _ => self.size,
        }
    }

    /// Frees a range.
    pub fn give(&mut self, start: usize, length: usize) {
        if length == 0 {
            return;
        }
        let end = start + length;
        let index = self.free.partition_point(|range| range.0 < start);
        self.free.insert(index, (start, end));
        // Neighbours are merged at once, so no two free ranges ever touch.
        let touches_next = self.free.get(index + 1).is_some_and(|next| next.0 == end);
        if touches_next {
            self.free[index].1 = self.free.remove(index + 1).1;
        }
        if index > 0 && self.free[index - 1].1 == start {
            self.free[index - 1].1 = self.free.remove(index).1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn freed_ranges_are_joined_and_taken_again() {
        let mut arena = Arena::default();
        let starts = [3, 4, 5].map(|length| arena.take(length));
        assert_eq!((starts, arena.size), ([0, 3, 7], 12));
        arena.give(0, 3);
        arena.give(3, 4);
        assert_eq!(arena.take(6), 0);
        arena.give(7, 5);
        // The free ranges 6..7 and 7..12 are one, and grow beyond the end.
        assert_eq!((arena.take(10), arena.size), (6, 16));
    }
}
