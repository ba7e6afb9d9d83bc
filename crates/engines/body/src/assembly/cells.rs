//! Near pairs of points by a grid of cells.

use protomer_kernel::Vec3;
use std::collections::BTreeMap;

/// Points sorted into cubes.
pub(super) struct Cells {
    points: Vec<Vec3>,
    edge: f64,
    members: BTreeMap<[i64; 3], Vec<u32>>,
}

/// The cube itself and one of each opposite pair of its neighbours.
const HALF: [[i64; 3]; 14] = [
    [0, 0, 0],
    [1, 0, 0],
    [-1, 1, 0],
    [0, 1, 0],
    [1, 1, 0],
    [-1, -1, 1],
    [0, -1, 1],
    [1, -1, 1],
    [-1, 0, 1],
    [0, 0, 1],
    [1, 0, 1],
    [-1, 1, 1],
    [0, 1, 1],
    [1, 1, 1],
];

impl Cells {
    /// Sorts points into cubes of this edge, which is the longest distance that can be requested.
    pub(super) fn new(points: Vec<Vec3>, edge: f64) -> Self {
        let mut members: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
        for (number, point) in (0_u32..).zip(&points) {
            members.entry(cube(point, edge)).or_default().push(number);
        }
        Self {
            points,
            edge,
            members,
        }
    }

    /// Calls `visit` with the numbers of each pair of points at most `distance` apart, once, in an
    /// order that depends on the points alone.
    pub(super) fn for_each_pair(&self, distance: f64, mut visit: impl FnMut(usize, usize)) {
        let square = distance.min(self.edge).powi(2);
        for (place, members) in &self.members {
            for step in HALF {
                let neighbour: [i64; 3] = std::array::from_fn(|axis| place[axis] + step[axis]);
                let Some(others) = self.members.get(&neighbour) else {
                    continue;
                };
                for (rank, one) in members.iter().enumerate() {
                    let from = if step == [0; 3] { rank + 1 } else { 0 };
                    for other in &others[from..] {
                        let (one, other) = (*one as usize, *other as usize);
                        if (self.points[one] - self.points[other]).norm_squared() <= square {
                            visit(one, other);
                        }
                    }
                }
            }
        }
    }
}

fn cube(point: &Vec3, edge: f64) -> [i64; 3] {
    std::array::from_fn(|axis| (point[axis] / edge).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// The twin: all pairs.
    #[test]
    fn the_pairs_of_cells_are_those_of_all_points() {
        let mut rng = CounterRng::new(5, 0, 0);
        let points: Vec<Vec3> = (0..300).map(|_| rng.vector_in_ball(9.0)).collect();
        let cells = Cells::new(points.clone(), 3.0);
        for distance in [1.0, 2.2, 3.0] {
            let mut found = Vec::new();
            cells.for_each_pair(distance, |a, b| found.push((a.min(b), a.max(b))));
            let mut expected = Vec::new();
            for b in 0..points.len() {
                for a in 0..b {
                    if (points[a] - points[b]).norm() <= distance {
                        expected.push((a, b));
                    }
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            assert!(found == expected && !found.is_empty());
        }
    }
}
