//! The order of elimination.

use std::cmp::Ordering;

/// Size up to which parts are not divided any further.
const SMALLEST_PART: usize = 8;
/// Smallest part of the unknowns that the smaller side of a cut may hold.
const SMALLEST_SIDE: f64 = 0.35;

/// An order of elimination by nested dissection: the unknowns are cut in two along an axis, those on
/// one side that have a neighbour on the other are the separator and come last, and each half is
/// ordered likewise. For a planar network of n unknowns the factor has O(n log n) entries (George,
/// SIAM J. Numer. Anal. 10, 345 (1973)). Of all cuts along all axes that leave neither side too
/// small, the one with the smallest separator is taken.
///
/// `neighbours[i]` lists the unknowns coupled to i, `places[i]` is where it is. Returns the unknowns
/// in the order in which they are to be eliminated. Where the network is periodic, edges that go
/// around are edges like any other, so the separators hold both of its sides.
pub(super) fn nested_dissection(neighbours: &[Vec<usize>], places: &[[f64; 3]]) -> Vec<usize> {
    // Depth first; a separator is emitted after both of its halves.
    enum Task {
        Divide(Vec<usize>),
        Emit(Vec<usize>),
    }
    let mut divider = Divider {
        neighbours,
        places,
        ranks: vec![OUTSIDE; neighbours.len()],
        sorted_along: None,
    };
    let mut order = Vec::with_capacity(neighbours.len());
    let mut tasks = vec![Task::Divide((0..neighbours.len()).collect())];
    while let Some(task) = tasks.pop() {
        match task {
            Task::Emit(separator) => order.extend(separator),
            Task::Divide(part) if part.len() <= SMALLEST_PART => order.extend(part),
            Task::Divide(part) => {
                let [near, far, separator] = divider.divide(part);
                tasks.push(Task::Emit(separator));
                tasks.push(Task::Divide(far));
                tasks.push(Task::Divide(near));
            }
        }
    }
    order
}

/// The rank of unknowns outside the part that is divided.
const OUTSIDE: u32 = u32::MAX;

/// A cut: unknowns of rank `cut` and more along the axis are on the far side.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    cut: usize,
    separator: usize,
    /// Whether the separator is taken from the far side.
    far: bool,
    price: f64,
}

struct Divider<'a> {
    neighbours: &'a [Vec<usize>],
    places: &'a [[f64; 3]],
    /// Ranks of the unknowns in the part, [`OUTSIDE`] for all others.
    ranks: Vec<u32>,
    /// The axis along which the part is sorted and ranked.
    sorted_along: Option<usize>,
}

impl Divider<'_> {
    /// Divides a part into two sides and a separator.
    fn divide(&mut self, mut part: Vec<usize>) -> [Vec<usize>; 3] {
        let cut = self.cheapest_cut(&mut part);
        self.sort(&mut part, cut.axis);
        // near, far, separator.
        let mut parts = [Vec::new(), Vec::new(), Vec::with_capacity(cut.separator)];
        for (rank, unknown) in part.iter().enumerate() {
            let far = rank >= cut.cut;
            let side = if far == cut.far && self.touches_other_side(*unknown, &cut) {
                2
            } else {
                usize::from(far)
            };
            parts[side].push(*unknown);
        }
        // Ranks are valid for one part at a time; others must see these unknowns as outside.
        for unknown in part {
            self.ranks[unknown] = OUTSIDE;
        }
        self.sorted_along = None;
        parts
    }

    /// The cheapest cut along any axis. An axis along which all places agree is left out, unless
    /// there is no other.
    fn cheapest_cut(&mut self, part: &mut [usize]) -> Cut {
        let mut best: Option<Cut> = None;
        for axis in 0..3 {
            // All places equal along all axes: some cut is still needed, and the last axis serves.
            let is_last_resort = axis == 2 && best.is_none();
            // Equal coordinates make any cut along the axis arbitrary.
            if !is_last_resort && self.all_agree(part, axis) {
                continue;
            }
            self.sort(part, axis);
            let cut = self.cheapest_cut_along(part, axis);
            if best.is_none_or(|best| cut.price < best.price) {
                best = Some(cut);
            }
        }
        best.unwrap_or(Cut::in_the_middle(part.len(), 0))
    }

    fn all_agree(&self, part: &[usize], axis: usize) -> bool {
        let place = |unknown: &usize| self.places[*unknown][axis];
        part.windows(2)
            .all(|pair| place(&pair[0]) == place(&pair[1]))
    }

    /// Sorts a part along an axis and ranks it, unless that has been done.
    fn sort(&mut self, part: &mut [usize], axis: usize) {
        if self.sorted_along == Some(axis) {
            return;
        }
        self.sorted_along = Some(axis);
        // Ties by number, so that the order does not depend on the sort.
        let compare = |a: &usize, b: &usize| -> Ordering {
            let (at_a, at_b) = (self.places[*a][axis], self.places[*b][axis]);
            at_a.total_cmp(&at_b).then(a.cmp(b))
        };
        part.sort_unstable_by(compare);
        for (rank, unknown) in part.iter().enumerate() {
            self.ranks[*unknown] = rank as u32;
        }
    }

    /// The cheapest cut of a part that is sorted along the axis. An unknown is in the near separator
    /// of all cuts above its own rank and up to the largest rank of its neighbours, so sums of
    /// differences give the separators of all cuts at once.
    fn cheapest_cut_along(&self, part: &[usize], axis: usize) -> Cut {
        let count = part.len();
        let mut changes = vec![[0_i32; 2]; count + 2];
        for (rank, unknown) in part.iter().enumerate() {
            let (low, high) = self.range_of_ranks(rank, *unknown);
            // Near separator: cuts rank + 1 ..= high; far separator: cuts low + 1 ..= rank.
            changes[rank + 1][0] += 1;
            changes[high + 1][0] -= 1;
            changes[low + 1][1] += 1;
            changes[rank + 1][1] -= 1;
        }
        let mut best = Cut::in_the_middle(count, axis);
        let mut sizes = [0_i32; 2];
        for (cut, change) in changes.iter().enumerate().take(count).skip(1) {
            // Running sums of the changes: the sizes of both separators at this cut.
            sizes = [sizes[0] + change[0], sizes[1] + change[1]];
            let balance = cut.min(count - cut) as f64 / count as f64;
            if balance < SMALLEST_SIDE {
                continue;
            }
            for (size, far) in [(sizes[0], false), (sizes[1], true)] {
                // A separator costs its size, and up to 1.3
                // times that for a cut at the limit of balance.
                let price = f64::from(size) * (1.0 + 2.0 * (0.5 - balance));
                if price < best.price {
                    best = Cut {
                        axis,
                        cut,
                        separator: size as usize,
                        far,
                        price,
                    };
                }
            }
        }
        best
    }

    /// The least and the largest rank of an unknown and its neighbours in the part.
    fn range_of_ranks(&self, rank: usize, unknown: usize) -> (usize, usize) {
        let (mut low, mut high) = (rank, rank);
        for other in &self.neighbours[unknown] {
            let other = self.ranks[*other];
            if other != OUTSIDE {
                low = low.min(other as usize);
                high = high.max(other as usize);
            }
        }
        (low, high)
    }

    /// Whether an unknown on the separator's side has a neighbour on the other.
    fn touches_other_side(&self, unknown: usize, cut: &Cut) -> bool {
        let on_other_side = |other: &usize| {
            let rank = self.ranks[*other];
            rank != OUTSIDE && (rank as usize >= cut.cut) != cut.far
        };
        self.neighbours[unknown].iter().any(on_other_side)
    }
}

impl Cut {
    /// A cut that any other is better than.
    fn in_the_middle(count: usize, axis: usize) -> Self {
        Self {
            axis,
            cut: count / 2,
            separator: count,
            far: false,
            price: f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unknown_comes_once() {
        let n = 40;
        let index = |i: usize, j: usize| n * i + j;
        let mut neighbours = vec![Vec::new(); n * n];
        let mut places = vec![[0.0; 3]; n * n];
        for i in 0..n {
            for j in 0..n {
                places[index(i, j)] = [i as f64, j as f64, 0.0];
                // A torus.
                for (k, l) in [((i + 1) % n, j), (i, (j + 1) % n)] {
                    neighbours[index(i, j)].push(index(k, l));
                    neighbours[index(k, l)].push(index(i, j));
                }
            }
        }
        let order = nested_dissection(&neighbours, &places);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..n * n));
    }
}
