//! Cubes of 2 x 2 x 2 cells: where the surface runs through one as a single plain disk, the cube
//! does the work of its eight cells.
//!
//! The nodes of a cube are 27 bits, node (x, y, z) the bit 9 x + 3 y + z. A cube is plain if the
//! surface crosses none of its 12 edges twice and runs through each of its 6 faces in one curve at
//! most, so that its boundary there is that of the sheet of a single cell of twice the size, and if
//! what it bounds is one disk: V - E + F = 1 for the crossed edges of the cells, the lines between
//! them on the faces of the cells, and the sheets in the cells.

use super::cycles::Cycles;

/// Nodes of a cube.
pub(super) const ALL: u32 = (1 << 27) - 1;
/// Number of bits by which a node comes after its neighbour along each axis.
const STEP: [u32; 3] = [9, 3, 1];
/// The lower ends of those edges of cells along each axis that lie on edges of the cube.
const ON_EDGES: [u32; 3] = edges(0);
/// The same for edges inside the faces of the cube.
const IN_FACES: [u32; 3] = edges(1);
/// The same for edges in the interior of the cube.
const INSIDE: [u32; 3] = edges(2);
/// The nodes of the second layer along each axis.
const SECOND: [u32; 3] = layers(1);
/// The nodes of the third layer along each axis.
const THIRD: [u32; 3] = layers(2);
/// The corners of a cell, as bits from its lowest node.
const CELL: u32 = 0b11_0110_0001_1011;

/// Lower ends of the edges along each axis that lie in the middle of the cube along so many others.
const fn edges(middles: u32) -> [u32; 3] {
    let mut masks = [0; 3];
    let mut axis = 0;
    while axis < 3 {
        let mut bit = 0;
        while bit < 27 {
            let node = [bit / 9, bit / 3 % 3, bit % 3];
            let (u, v) = (node[(axis + 1) % 3], node[(axis + 2) % 3]);
            if node[axis] < 2 && (u % 2) + (v % 2) == middles {
                masks[axis] |= 1 << bit;
            }
            bit += 1;
        }
        axis += 1;
    }
    masks
}

const fn layers(layer: u32) -> [u32; 3] {
    let mut masks = [0; 3];
    let mut bit = 0;
    while bit < 27 {
        let node = [bit / 9, bit / 3 % 3, bit % 3];
        let mut axis = 0;
        while axis < 3 {
            if node[axis] == layer {
                masks[axis] |= 1 << bit;
            }
            axis += 1;
        }
        bit += 1;
    }
    masks
}

/// The inside corners of the cell whose lowest node is `first`, in the numbering of [`Cycles`].
pub(super) fn corners(nodes: u32, first: u32) -> usize {
    let cell = nodes >> first;
    let side = |bits: u32| usize::from(CORNERS[(bits & 0b11011) as usize]);
    // The side at x + 1 comes after by nine bits; its corners have the odd numbers.
    side(cell) | side(cell >> STEP[0]) << 1
}

/// The corners of the side of a cell whose nodes are these bits: node 3 y + z is the corner
/// 2 y + 4 z.
const CORNERS: [u8; 28] = {
    let mut corners = [0; 28];
    let mut nodes = 0;
    while nodes < 28 {
        let [y, z] = [nodes >> 3 & 1, nodes >> 1 & 1];
        let both = nodes >> 4 & 1;
        corners[nodes] = (nodes & 1 | y << 2 | z << 4 | both << 6) as u8;
        nodes += 1;
    }
    corners
};

/// The lowest node of the cell that comes second along the axes in the bits of `cell`.
pub(super) fn first_node(cell: usize) -> u32 {
    let cell = cell as u32;
    (cell & 1) * STEP[0] + (cell >> 1 & 1) * STEP[1] + (cell >> 2 & 1) * STEP[2]
}

/// Whether the surface is one plain disk in a cube with nodes on both sides.
pub(super) fn is_plain(nodes: u32, table: &[Cycles]) -> bool {
    has_plain_boundary(nodes, table) && {
        let mut sheets = 0;
        for cell in 0..8 {
            let first = first_node(cell);
            let inside = nodes >> first & CELL;
            // A cell all inside or all outside has no sheet.
            if inside != 0 && inside != CELL {
                sheets += u32::from(table[corners(nodes, first)].count);
            }
        }
        // An edge of a cell lies on two of the cells' faces in the cube, three or four, and every
        // line on a face ends at two: V - E + F = F - (edges in faces) / 2 - (edges inside).
        let (mut in_faces, mut inside) = (0, 0);
        for axis in 0..3 {
            // A bit is set where a node and the next along the axis differ.
            let crossed = nodes ^ nodes >> STEP[axis];
            in_faces += (crossed & IN_FACES[axis]).count_ones();
            inside += (crossed & INSIDE[axis]).count_ones();
        }
        // Doubled, so that the halves stay integers: V - E + F = 1.
        2 * sheets == 2 + in_faces + 2 * inside
    }
}

/// Whether each edge of a cube is crossed once at most, each face holds one curve at most, and
/// these curves close into one.
fn has_plain_boundary(nodes: u32, table: &[Cycles]) -> bool {
    for (axis, step) in STEP.into_iter().enumerate() {
        let crossed = nodes ^ nodes >> step;
        let first = ON_EDGES[axis] & !SECOND[axis];
        // Both halves of an edge of the cube are crossed:
        // its ends agree, and one tile cannot show it.
        if crossed & crossed >> step & first != 0 {
            return false;
        }
        let (u, v) = (STEP[(axis + 1) % 3], STEP[(axis + 2) % 3]);
        for side in [0, 2 * step] {
            let face = nodes >> side;
            let node = |bit: u32| face >> bit & 1;
            let middle = node(u + v);
            let sides = node(u) + node(v) + node(2 * u + v) + node(u + 2 * v);
            // The middle differs from all four around it: a closed curve in the face.
            let is_alone = sides == if middle == 1 { 0 } else { 4 };
            let [a, b, c, d] = [node(0), node(2 * u), node(2 * v), node(2 * (u + v))];
            // Diagonal corners agree and neighbours do not: two curves, or one of two ways to join.
            if is_alone || (a == d && b == c && a != b) {
                return false;
            }
        }
    }
    // The corners of the cube as those of a cell of twice the size.
    let mut cube = 0;
    for corner in 0..8 {
        cube |= ((nodes >> (2 * first_node(corner)) & 1) as usize) << corner;
    }
    table[cube].count == 1
}

/// The node with this bit.
pub(super) fn node(bit: usize) -> [i32; 3] {
    let bit = bit as i32;
    [bit / 9, bit / 3 % 3, bit % 3]
}

/// The lower ends of the crossed edges along an axis, on edges of the cube or on its faces too.
pub(super) fn crossed(nodes: u32, axis: usize, with_faces: bool) -> u32 {
    let edges = if with_faces {
        ON_EDGES[axis] | IN_FACES[axis]
    } else {
        ON_EDGES[axis]
    };
    (nodes ^ nodes >> STEP[axis]) & edges
}

/// The number of crossed edges of the cells of a cube, and the sum of their middles in halves of a
/// cell from the lowest node.
pub(super) fn crossings(nodes: u32) -> (u16, [u16; 3]) {
    let (mut count, mut sum) = (0, [0; 3]);
    for direction in 0..3 {
        let edges = ON_EDGES[direction] | IN_FACES[direction] | INSIDE[direction];
        let crossed = (nodes ^ nodes >> STEP[direction]) & edges;
        let number = crossed.count_ones() as u16;
        count += number;
        for axis in 0..3 {
            // Coordinates 1 and 2 in halves of a cell are
            // 2 and 4; the edge's own half follows below.
            sum[axis] += 2 * (crossed & SECOND[axis]).count_ones() as u16;
            sum[axis] += 4 * (crossed & THIRD[axis]).count_ones() as u16;
        }
        sum[direction] += number;
    }
    (count, sum)
}

#[cfg(test)]
mod tests {
    use super::super::cycles::{links, lower_corner, table};
    use super::*;
    use std::collections::{HashMap, HashSet};

    fn node(bit: u32) -> [u32; 3] {
        super::node(bit as usize).map(|x| x as u32)
    }

    type Edge = ([u32; 3], usize);

    /// The slow twin: the sheets of all cells, joined along the lines on the faces of the cells that
    /// they have in common; crossed edges, lines and sheets counted one by one.
    fn is_one_disk(nodes: u32) -> bool {
        let table = table();
        let mut edges: HashSet<Edge> = HashSet::new();
        let mut lines: HashMap<[Edge; 2], Vec<usize>> = HashMap::new();
        let mut sheets = 0;
        for cell in 0..8 {
            let first = node(first_node(cell));
            let inside = corners(nodes, first_node(cell));
            let place = |edge: usize| {
                let low = lower_corner(edge) as u32;
                let from = [0, 1, 2].map(|axis| first[axis] + (low >> axis & 1));
                (from, edge / 4)
            };
            for [a, b] in (0..6).flat_map(|face| links(inside, face)) {
                let mut line = [place(a), place(b)];
                line.sort_unstable();
                edges.extend(line);
                let sheet = sheets + usize::from(table[inside].of_edge[a]);
                lines.entry(line).or_default().push(sheet);
            }
            sheets += usize::from(table[inside].count);
        }
        let mut parent: Vec<usize> = (0..sheets).collect();
        for members in lines.values() {
            let (from, to) = (parent[members[0]], parent[members[members.len() - 1]]);
            for parent in &mut parent {
                if *parent == from {
                    *parent = to;
                }
            }
        }
        let is_connected = parent.iter().all(|p| *p == parent[0]);
        let euler = edges.len() as i64 - lines.len() as i64 + sheets as i64;
        is_connected && euler == 1
    }

    #[test]
    fn what_counts_as_plain_is_one_disk_with_one_crossing_on_each_crossed_edge() {
        let table = table();
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            state >> 33
        };
        let (mut plain, mut others) = (0, 0);
        for _ in 0..20_000 {
            // Half-spaces with some nodes turned over, so that both kinds are common.
            let mut draw = || next() as f64 / (1_u64 << 30) as f64 - 1.0;
            let (direction, offset) = ([draw(), draw(), draw()], draw());
            let mut nodes = 0;
            for bit in 0..27 {
                let corner = node(bit).map(|x| f64::from(x) - 1.0);
                let height: f64 = (0..3).map(|axis| corner[axis] * direction[axis]).sum();
                nodes |= u32::from(height < offset) << bit;
            }
            for _ in 0..next() % 4 {
                nodes ^= 1 << (next() % 27);
            }
            if nodes == 0 || nodes == ALL {
                continue;
            }
            if is_plain(nodes, &table) {
                plain += 1;
                assert!(is_one_disk(nodes), "{nodes:b}");
                // Its polygons need three corners.
                let crossed: u32 = (0..3)
                    .map(|axis| ((nodes ^ nodes >> STEP[axis]) & ON_EDGES[axis]).count_ones())
                    .sum();
                assert!(crossed >= 3, "{nodes:b}");
            } else {
                others += 1;
            }
            let (mut count, mut sum) = (0, [0.0; 3]);
            for axis in 0..3 {
                for bit in 0..27 {
                    let corner = node(bit);
                    if corner[axis] < 2 && (nodes >> bit ^ nodes >> (bit + STEP[axis])) & 1 == 1 {
                        count += 1;
                        for along in 0..3 {
                            sum[along] += f64::from(corner[along]);
                        }
                        sum[axis] += 0.5;
                    }
                }
            }
            let found = crossings(nodes);
            assert_eq!(found.0, count);
            assert_eq!(found.1.map(|halves| f64::from(halves) / 2.0), sum);
        }
        assert!(plain > 3000 && others > 3000, "{plain} {others}");
    }
}
