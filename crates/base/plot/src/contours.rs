//! Lines of equal value through a table of numbers on a grid (marching squares).
//!
//! A line crosses an edge of the grid between a number below the level and one that is not. Where it crosses is found
//! by linear interpolation; of the logarithm, if both numbers have the sign of the level, because a potential rises as
//! a high power. Cells with a corner without a number have no line.

use std::collections::{BTreeMap, BTreeSet};

/// Numbers on a grid, row after row from the bottom.
pub(crate) struct Grid<'a> {
    pub columns: usize,
    pub rows: usize,
    pub values: &'a [Option<f64>],
}

/// An edge of the grid: the lower or left node, and whether it goes up.
type Edge = (usize, bool);

impl Grid<'_> {
    /// The lines of a level, in units of the grid: columns and rows. A line that returns to its start ends with it.
    pub fn lines(&self, level: f64) -> Vec<Vec<[f64; 2]>> {
        let mut neighbours: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for row in 0..self.rows.saturating_sub(1) {
            for column in 0..self.columns.saturating_sub(1) {
                for [from, to] in self.segments(level, row * self.columns + column) {
                    neighbours.entry(from).or_default().push(to);
                    neighbours.entry(to).or_default().push(from);
                }
            }
        }
        self.joined(level, &neighbours)
    }

    /// Segments of a cell, by the edges that they join; the cell is named by its lower left node.
    fn segments(&self, level: f64, node: usize) -> Vec<[Edge; 2]> {
        let corners = [node, node + 1, node + 1 + self.columns, node + self.columns];
        let values = corners.map(|corner| self.values[corner]);
        let [Some(a), Some(b), Some(c), Some(d)] = values else {
            return Vec::new();
        };
        let above = [a, b, c, d].map(|value| value >= level);
        // Lower, right, upper, left: edge k lies between corners k and k + 1.
        let edges = [
            (corners[0], false),
            (corners[1], true),
            (corners[3], false),
            (corners[0], true),
        ];
        let crossed: Vec<usize> = (0..4).filter(|k| above[*k] != above[(k + 1) % 4]).collect();
        match crossed.as_slice() {
            [first, second] => vec![[edges[*first], edges[*second]]],
            // A saddle: the mean of the corners says which of them the lines cut off.
            [..] if crossed.len() == 4 => {
                let middle_is_above = (a + b + c + d) / 4.0 >= level;
                match above[0] == middle_is_above {
                    true => vec![[edges[0], edges[1]], [edges[2], edges[3]]],
                    false => vec![[edges[3], edges[0]], [edges[1], edges[2]]],
                }
            }
            _ => Vec::new(),
        }
    }

    /// Segments joined to lines: first those with ends, then closed ones.
    fn joined(&self, level: f64, neighbours: &BTreeMap<Edge, Vec<Edge>>) -> Vec<Vec<[f64; 2]>> {
        let with_ends = neighbours.iter().filter(|(_, next)| next.len() == 1);
        let starts = with_ends.chain(neighbours).map(|(edge, _)| *edge);
        let mut seen = BTreeSet::new();
        let mut lines = Vec::new();
        for start in starts {
            if !seen.insert(start) {
                continue;
            }
            let mut line = vec![self.crossing(level, start)];
            let mut edge = start;
            while let Some(next) = neighbours[&edge].iter().find(|next| !seen.contains(next)) {
                seen.insert(*next);
                line.push(self.crossing(level, *next));
                edge = *next;
            }
            if line.len() > 2 && neighbours[&edge].contains(&start) {
                line.push(line[0]);
            }
            lines.push(line);
        }
        lines
    }

    fn crossing(&self, level: f64, (node, is_up): Edge) -> [f64; 2] {
        let other = node + if is_up { self.columns } else { 1 };
        let ends = [node, other].map(|node| self.values[node].unwrap_or(level));
        let [from, to] = match ends.map(|value| value / level) {
            ratios if ratios.iter().all(|ratio| *ratio > 0.0) => ratios.map(f64::ln),
            _ => ends.map(|value| value - level),
        };
        let part = from / (from - to);
        let [column, row] = [node % self.columns, node / self.columns].map(|index| index as f64);
        match is_up {
            true => [column, row + part],
            false => [column + part, row],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(size: usize, function: impl Fn(f64, f64) -> Option<f64>) -> Vec<Option<f64>> {
        let middle = (size - 1) as f64 / 2.0;
        (0..size * size)
            .map(|node| {
                let [x, y] = [node % size, node / size].map(|index| index as f64 - middle);
                function(x, y)
            })
            .collect()
    }

    #[test]
    fn a_circle_is_one_closed_line_at_its_radius() {
        let values = sampled(41, |x, y| Some(x.hypot(y)));
        let grid = Grid {
            columns: 41,
            rows: 41,
            values: &values,
        };
        let lines = grid.lines(15.3);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        for [x, y] in &lines[0] {
            assert!(((x - 20.0).hypot(y - 20.0) - 15.3).abs() < 0.02);
        }
        assert!(grid.lines(100.0).is_empty());
    }

    #[test]
    fn steep_potentials_are_cut_where_the_level_is() {
        // Interpolated as it stands, r to the power -12 is off by up to 0.1 of a cell.
        let values = sampled(81, |x, y| Some((x.hypot(y) / 20.0).powi(-12)));
        let values: Vec<_> = values
            .into_iter()
            .map(|v| v.filter(|v| v.is_finite()))
            .collect();
        let grid = Grid {
            columns: 81,
            rows: 81,
            values: &values,
        };
        let lines = grid.lines(10.0);
        assert_eq!(lines.len(), 1);
        let radius = 20.0 * 10_f64.powf(-1.0 / 12.0);
        for [x, y] in &lines[0] {
            let distance = (x - 40.0).hypot(y - 40.0);
            assert!((distance - radius).abs() < 0.02, "{distance} and {radius}");
        }
    }

    #[test]
    fn lines_end_at_the_border_and_at_gaps() {
        let values = sampled(21, |x, y| (x.abs() > 2.5 || y > 0.0).then_some(y + 0.5));
        let grid = Grid {
            columns: 21,
            rows: 21,
            values: &values,
        };
        let lines = grid.lines(0.0);
        assert_eq!(lines.len(), 2, "{lines:?}");
        for line in lines {
            assert_ne!(line.first(), line.last());
            assert!(line.iter().all(|[_, y]| (y - 9.5).abs() < 1e-12));
        }
    }

    #[test]
    fn saddles_keep_two_lines_apart() {
        let values = sampled(2, |x, y| Some(4.0 * x * y));
        let grid = Grid {
            columns: 2,
            rows: 2,
            values: &values,
        };
        for level in [-0.5, 0.5] {
            let lines = grid.lines(level);
            assert_eq!(lines.len(), 2);
            assert!(lines.iter().all(|line| line.len() == 2));
        }
    }
}
