//! How the surface runs through a cell whose corners are inside or outside.
//!
//! Corner c of a cell has the coordinates (c & 1, c >> 1 & 1, c >> 2); edge 4a + p runs along axis
//! a. On every face of the cell the crossed edges are linked in pairs, around each run of outside
//! corners: a face with two outside corners on a diagonal keeps them apart and joins the inside
//! corners, as seen from both cells that share it. A wall that is thinner than the lattice, as
//! solvent-excluded surfaces have them at their cusps, then stays in one piece more often than with
//! the opposite rule. Every crossed edge lies on two faces, so the links form closed cycles: one
//! sheet of the surface each.

/// Corner sets of a cell.
const MASKS: usize = 256;
/// Edges of a cell.
pub(super) const EDGES: usize = 12;
/// The mark of an edge that is not crossed.
pub(super) const NOT_CROSSED: u8 = u8::MAX;

/// The sheets in a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cycles {
    /// Number of sheets, at most four.
    pub(super) count: u8,
    /// The sheet that crosses each edge.
    pub(super) of_edge: [u8; EDGES],
}

/// The sheets for every set of inside corners.
pub(super) fn table() -> Vec<Cycles> {
    (0..MASKS).map(cycles).collect()
}

/// Lower corner of an edge.
pub(super) fn lower_corner(edge: usize) -> usize {
    let (axis, place) = (edge / 4, edge % 4);
    (place & 1) << ((axis + 1) % 3) | (place >> 1) << ((axis + 2) % 3)
}

/// The edge between two corners that differ along `axis`.
fn edge_between(axis: usize, corner: usize) -> usize {
    4 * axis + (corner >> ((axis + 1) % 3) & 1) + 2 * (corner >> ((axis + 2) % 3) & 1)
}

fn cycles(mask: usize) -> Cycles {
    // Linked edges have the same label.
    let mut label: [usize; EDGES] = std::array::from_fn(|edge| edge);
    let mut crossed = [false; EDGES];
    for face in 0..6 {
        for [from, to] in links(mask, face) {
            (crossed[from], crossed[to]) = (true, true);
            let (survivor, gone) = (label[from], label[to]);
            // Twelve labels: renaming all is simpler than a
            // tree, and this runs once for each of 256 masks.
            for label in &mut label {
                if *label == gone {
                    *label = survivor;
                }
            }
        }
    }
    let mut of_edge = [NOT_CROSSED; EDGES];
    let mut count = 0;
    for first in 0..EDGES {
        if !crossed[first] || of_edge[first] != NOT_CROSSED {
            continue;
        }
        // Edges below `first` belong to sheets that are already numbered.
        for edge in first..EDGES {
            if crossed[edge] && label[edge] == label[first] {
                of_edge[edge] = count;
            }
        }
        count += 1;
    }
    Cycles { count, of_edge }
}

/// The pairs of crossed edges that are linked on a face of the cell: those at both ends of each run
/// of outside corners.
pub(super) fn links(mask: usize, face: usize) -> Vec<[usize; 2]> {
    let (axis, side) = (face % 3, face / 3);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| side << axis | i << u | j << v);
    let is_inside = |i: usize| mask >> corners[i % 4] & 1 == 1;
    // Side i of the face runs from its corner i to the next.
    let side_edge = |i: usize| {
        let direction = if i.is_multiple_of(2) { u } else { v };
        edge_between(direction, corners[i % 4])
    };
    let mut links = Vec::new();
    for start in 0..4 {
        if is_inside(start) && !is_inside(start + 1) {
            let mut end = start + 1;
            // Ends at the latest at the corner where it began, which is inside.
            while !is_inside(end + 1) {
                end += 1;
            }
            links.push([side_edge(start), side_edge(end)]);
        }
    }
    links
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_that_changes_sign_is_on_one_sheet_of_at_least_three_edges() {
        for (mask, cycles) in table().iter().enumerate() {
            for edge in 0..EDGES {
                let (low, high) = (lower_corner(edge), lower_corner(edge) | 1 << (edge / 4));
                assert_ne!(low, high);
                let changes = (mask >> low & 1) != (mask >> high & 1);
                assert_eq!(
                    changes,
                    cycles.of_edge[edge] != NOT_CROSSED,
                    "{mask} {edge}"
                );
            }
            for sheet in 0..cycles.count {
                assert!(
                    cycles
                        .of_edge
                        .iter()
                        .filter(|owner| **owner == sheet)
                        .count()
                        >= 3
                );
            }
        }
    }

    #[test]
    fn outside_corners_on_a_diagonal_have_sheets_of_their_own() {
        let inside = [
            0b0,
            0b1,
            0b1001,
            0b0110_1001,
            0b1111,
            0b1000_0001,
            0xff ^ 0b1001,
            0xff ^ 0b1000_0001,
        ];
        assert_eq!(
            inside.map(|mask| table()[mask].count),
            [0, 1, 1, 4, 1, 2, 2, 2]
        );
    }
}
