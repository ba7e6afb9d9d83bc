//! The order of elimination.

/// Parts of at most this size are not divided any further.
const SMALLEST_PART: usize = 8;
/// The smaller side of a cut holds at least this part of the unknowns.
const SMALLEST_SIDE: f64 = 0.35;

/// An order of elimination by nested dissection: the unknowns are cut in two along an axis, those
/// on one side that have a neighbour on the other are the separator and come last, and each half is
/// ordered likewise. For a planar network of n unknowns the factor has O(n log n) entries (George,
/// SIAM J. Numer. Anal. 10, 345 (1973)). Of all cuts along all axes that leave neither side too
/// small, the one with the smallest separator is taken.
///
/// `neighbours[i]` lists the unknowns coupled to i, `places[i]` is where it is. Returns the
/// unknowns in the order in which they are to be eliminated. Where the network is periodic, edges
/// that go around are edges like any other, so the separators hold both of its sides.
pub fn nested_dissection(neighbours: &[Vec<usize>], places: &[[f64; 3]]) -> Vec<usize> {
    // Depth first; a separator is emitted after both of its halves.
    enum Task {
        Divide(Vec<usize>),
        Emit(Vec<usize>),
    }
    let mut order = Vec::with_capacity(neighbours.len());
    let mut ranks = vec![OUTSIDE; neighbours.len()];
    let mut tasks = vec![Task::Divide((0..neighbours.len()).collect())];
    while let Some(task) = tasks.pop() {
        let part = match task {
            Task::Emit(separator) => {
                order.extend(separator);
                continue;
            }
            Task::Divide(part) if part.len() <= SMALLEST_PART => {
                order.extend(part);
                continue;
            }
            Task::Divide(part) => part,
        };
        let [near, far, separator] = divide(part, neighbours, places, &mut ranks);
        tasks.push(Task::Emit(separator));
        tasks.push(Task::Divide(far));
        tasks.push(Task::Divide(near));
    }
    order
}

/// The rank of what is not in the part.
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

/// Both sides and the separator. `ranks` is `OUTSIDE` everywhere before and after.
fn divide(
    mut part: Vec<usize>,
    neighbours: &[Vec<usize>],
    places: &[[f64; 3]],
    ranks: &mut [u32],
) -> [Vec<usize>; 3] {
    let mut best: Option<Cut> = None;
    let mut sorted_by = None;
    for axis in 0..3 {
        let first = part.first().map(|unknown| places[*unknown][axis]);
        if part
            .iter()
            .all(|unknown| Some(places[*unknown][axis]) == first)
            && (axis < 2 || best.is_some())
        {
            continue;
        }
        sort(&mut part, axis, places, ranks);
        sorted_by = Some(axis);
        let cut = best_cut(&part, axis, neighbours, ranks);
        if best.is_none_or(|best| cut.price < best.price) {
            best = Some(cut);
        }
    }
    let cut = best.unwrap_or(Cut {
        axis: 0,
        cut: part.len() / 2,
        separator: 0,
        far: false,
        price: 0.0,
    });
    if sorted_by != Some(cut.axis) {
        sort(&mut part, cut.axis, places, ranks);
    }
    let touches = |unknown: usize| {
        neighbours[unknown]
            .iter()
            .any(|other| ranks[*other] != OUTSIDE && (ranks[*other] as usize >= cut.cut) != cut.far)
    };
    let mut parts = [Vec::new(), Vec::new(), Vec::with_capacity(cut.separator)];
    for (rank, unknown) in part.iter().enumerate() {
        let far = rank >= cut.cut;
        let target = if far == cut.far && touches(*unknown) {
            2
        } else {
            usize::from(far)
        };
        parts[target].push(*unknown);
    }
    for unknown in part {
        ranks[unknown] = OUTSIDE;
    }
    parts
}

fn sort(part: &mut [usize], axis: usize, places: &[[f64; 3]], ranks: &mut [u32]) {
    part.sort_unstable_by(|a, b| {
        places[*a][axis]
            .total_cmp(&places[*b][axis])
            .then_with(|| a.cmp(b))
    });
    for (rank, unknown) in part.iter().enumerate() {
        ranks[*unknown] = rank as u32;
    }
}

/// The cheapest cut of a part that is sorted along the axis. An unknown is in the near separator of
/// all cuts above its own rank and up to the largest rank of its neighbours, so that sums of
/// differences give the separators of all cuts at once.
fn best_cut(part: &[usize], axis: usize, neighbours: &[Vec<usize>], ranks: &[u32]) -> Cut {
    let count = part.len();
    let mut changes = vec![[0_i32; 2]; count + 2];
    for (rank, unknown) in part.iter().enumerate() {
        let (mut low, mut high) = (rank, rank);
        for other in neighbours[*unknown]
            .iter()
            .map(|other| ranks[*other])
            .filter(|other| *other != OUTSIDE)
        {
            low = low.min(other as usize);
            high = high.max(other as usize);
        }
        changes[rank + 1][0] += 1;
        changes[high + 1][0] -= 1;
        changes[low + 1][1] += 1;
        changes[rank + 1][1] -= 1;
    }
    let mut best = Cut {
        axis,
        cut: count / 2,
        separator: count,
        far: false,
        price: f64::INFINITY,
    };
    let mut sizes = [0_i32; 2];
    for (cut, change) in changes.iter().enumerate().take(count).skip(1) {
        sizes = [sizes[0] + change[0], sizes[1] + change[1]];
        let balance = cut.min(count - cut) as f64 / count as f64;
        if balance < SMALLEST_SIDE {
            continue;
        }
        for (size, far) in [(sizes[0], false), (sizes[1], true)] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unknown_comes_once_and_fill_is_far_below_a_band() {
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
