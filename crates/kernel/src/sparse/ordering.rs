//! The order of elimination.

/// Parts of at most this size are not divided any further.
const SMALLEST_PART: usize = 8;

/// An order of elimination by nested dissection: the unknowns are halved along their longest extent, those on one side that
/// have a neighbour on the other are the separator and come last, and each half is ordered likewise. For a planar network of
/// n unknowns the factor has O(n log n) entries (George, SIAM J. Numer. Anal. 10, 345 (1973)).
///
/// `neighbours[i]` lists the unknowns coupled to i, `places[i]` is where it is. Returns the unknowns in the order in which
/// they are to be eliminated. Where the network is periodic, edges that go around are edges like any other, so the
/// separators hold both of its sides.
pub fn nested_dissection(neighbours: &[Vec<usize>], places: &[[f64; 3]]) -> Vec<usize> {
    let mut order = Vec::with_capacity(neighbours.len());
    let mut side = vec![0_u32; neighbours.len()];
    let mut mark = 0;
    let mut separators: Vec<Vec<usize>> = Vec::new();
    // Depth first; a separator is emitted after both of its halves.
    enum Task {
        Divide(Vec<usize>),
        Emit(usize),
    }
    let mut tasks = vec![Task::Divide((0..neighbours.len()).collect())];
    while let Some(task) = tasks.pop() {
        let mut part = match task {
            Task::Emit(separator) => {
                order.append(&mut separators[separator]);
                continue;
            }
            Task::Divide(part) if part.len() <= SMALLEST_PART => {
                order.extend(part);
                continue;
            }
            Task::Divide(part) => part,
        };
        let axis = longest_axis(&part, places);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |a, b| {
            places[*a][axis].total_cmp(&places[*b][axis]).then_with(|| a.cmp(b))
        });
        mark += 1;
        for unknown in &part[middle..] {
            side[*unknown] = mark;
        }
        let (separator, near): (Vec<usize>, Vec<usize>) =
            part[..middle].iter().partition(|unknown| neighbours[**unknown].iter().any(|other| side[*other] == mark));
        let far = part[middle..].to_vec();
        separators.push(separator);
        tasks.push(Task::Emit(separators.len() - 1));
        tasks.push(Task::Divide(far));
        tasks.push(Task::Divide(near));
    }
    order
}

fn longest_axis(part: &[usize], places: &[[f64; 3]]) -> usize {
    let extent = |axis: usize| {
        let coordinates = part.iter().map(|unknown| places[*unknown][axis]);
        let (low, high) =
            coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(0)
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
