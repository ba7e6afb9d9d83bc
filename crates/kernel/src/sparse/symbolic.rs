//! What follows from the pattern alone: fronts, and where every number goes.
//!
//! Columns of L with the same rows below them form a supernode; its front (see `front`) takes the
//! entries of A in its columns and what its children in the tree of supernodes left over
//! (multifrontal method: Duff and Reid, ACM Trans. Math. Softw. 9, 302 (1983)). A child joins its
//! parent where the work on the zeros this brings is less than the cost of a front of its own.

use super::front::{BLOCK, LANES, Shape};
use super::nested_dissection;

/// One front.
#[derive(Debug, Clone)]
pub(super) struct Front {
    pub shape: Shape,
    /// Its first column in the order of elimination.
    pub first: usize,
    /// Where its rows below its own columns begin in `Symbolic::rows`.
    pub rows: usize,
    /// Where its tiles begin among the numbers of L.
    pub values: usize,
    /// Where its left-over begins in the workspace.
    pub left: usize,
    /// Its entries of A, as a range of `Symbolic::assembly`.
    pub assembly: (usize, usize),
    /// Its children, as a range of `Symbolic::children`.
    pub children: (usize, usize),
}

/// Where a child's row is in its parent's front.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seat {
    /// The row.
    pub row: u32,
    /// The number of column 0 in that row of the tiles.
    pub tile: u32,
}

/// All that is fixed once.
#[derive(Debug, Clone)]
pub(super) struct Symbolic {
    /// Which unknown is eliminated at each step.
    pub order: Vec<u32>,
    pub fronts: Vec<Front>,
    pub children: Vec<u32>,
    /// Rows below the own columns of every front, as steps of elimination.
    pub rows: Vec<u32>,
    /// The same rows in the parent's front.
    pub seats: Vec<Seat>,
    /// (entry of A, place in the tiles of its front).
    pub assembly: Vec<(u32, u32)>,
    /// The entry of A on the diagonal at each step.
    pub diagonal: Vec<u32>,
    /// Numbers in all tiles, and in the workspace for what is left over.
    pub values_size: usize,
    pub left_size: usize,
    /// The tallest front in tiles.
    pub tallest: usize,
}

/// A rough price of a front in nanoseconds: a factorisation and some five solutions.
fn price(columns: usize, below: usize) -> f64 {
    let (k, r) = (columns as f64, below as f64);
    let blocks = |x: f64| (x / BLOCK as f64).ceil();
    let tiles = |x: f64| (x / LANES as f64).ceil();
    let multiplications = k * k * (k / 3.0 + r) + k * r * r;
    // Overhead, columns, tiles begun, arithmetic, children's numbers added, five passes over L and
    // back.
    60.0 + 8.0 * k
        + 3.0 * (blocks(k) + blocks(r)) * tiles(k + r)
        + 0.08 * multiplications
        + 0.6 * r * (r + 1.0) / 2.0
        + 5.0 * (25.0 + 6.0 * k + r + 0.25 * k * (0.5 * k + r))
}

impl Symbolic {
    pub fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let mut neighbours = vec![Vec::new(); dimension];
        for &(row, column) in entries.iter().filter(|(row, column)| row != column) {
            neighbours[row].push(column);
            neighbours[column].push(row);
        }
        let dissected = nested_dissection(&neighbours, places);
        let mut position = vec![0_u32; dimension];
        for (step, unknown) in dissected.iter().enumerate() {
            position[*unknown] = step as u32;
        }
        let (parent, counts) = elimination_tree(&dissected, &position, &neighbours);
        let nodes = amalgamate(&parent, &counts);
        // Number the columns along the tree.
        let mut order = Vec::with_capacity(dimension);
        let mut step_of = vec![0_usize; dimension];
        for node in &nodes {
            for column in &node.columns {
                let unknown = dissected[*column as usize];
                step_of[unknown] = order.len();
                order.push(unknown as u32);
            }
        }
        Self::fill(order, &step_of, &nodes, entries)
    }

    fn fill(
        order: Vec<u32>,
        step_of: &[usize],
        nodes: &[Node],
        entries: &[(usize, usize)],
    ) -> Self {
        let dimension = order.len();
        // Entries by column of L: (row, entry).
        let mut starts = vec![0_usize; dimension + 1];
        let place = |&(row, column): &(usize, usize)| {
            let (a, b) = (step_of[row], step_of[column]);
            (a.max(b), a.min(b))
        };
        for entry in entries {
            starts[place(entry).1 + 1] += 1;
        }
        for column in 0..dimension {
            starts[column + 1] += starts[column];
        }
        let mut by_column = vec![(0_u32, 0_u32); entries.len()];
        let mut filled = starts.clone();
        let mut diagonal = vec![0; dimension];
        for (index, entry) in entries.iter().enumerate() {
            let (row, column) = place(entry);
            by_column[filled[column]] = (row as u32, index as u32);
            filled[column] += 1;
            if row == column {
                diagonal[row] = index as u32;
            }
        }
        let mut symbolic = Self {
            order,
            fronts: Vec::with_capacity(nodes.len()),
            children: Vec::new(),
            rows: Vec::new(),
            seats: Vec::new(),
            assembly: Vec::with_capacity(entries.len()),
            diagonal,
            values_size: 0,
            left_size: 0,
            tallest: 0,
        };
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); nodes.len()];
        let mut local = vec![u32::MAX; dimension];
        let mut arena = Arena::default();
        let mut first = 0;
        for (index, node) in nodes.iter().enumerate() {
            let (columns, end) = (node.columns.len(), first + node.columns.len());
            let mut below: Vec<u32> = by_column[starts[first]..starts[end]]
                .iter()
                .map(|(row, _)| *row)
                .filter(|row| *row as usize >= end)
                .collect();
            for child in &children[index] {
                let child = &symbolic.fronts[*child as usize];
                let rows = &symbolic.rows
                    [child.rows..child.rows + child.shape.height - child.shape.columns];
                below.extend(rows.iter().filter(|row| **row as usize >= end));
            }
            below.sort_unstable();
            below.dedup();
            let shape = Shape {
                columns,
                height: columns + below.len(),
            };
            for (at, step) in (first..end)
                .map(|step| step as u32)
                .chain(below.iter().copied())
                .enumerate()
            {
                local[step as usize] = at as u32;
            }
            let tile_place = |row: usize| shape.tile_start(row / LANES) + row % LANES;
            let assembled = symbolic.assembly.len();
            for column in first..end {
                for &(row, entry) in &by_column[starts[column]..starts[column + 1]] {
                    let at = tile_place(local[row as usize] as usize) + LANES * (column - first);
                    symbolic.assembly.push((entry, at as u32));
                }
            }
            for child in &children[index] {
                let child = &symbolic.fronts[*child as usize];
                for at in child.rows..child.rows + child.shape.height - child.shape.columns {
                    let row = local[symbolic.rows[at] as usize];
                    symbolic.seats[at] = Seat {
                        row,
                        tile: tile_place(row as usize) as u32,
                    };
                }
            }
            let left = arena.take(shape.left_size());
            for child in &children[index] {
                let child = &symbolic.fronts[*child as usize];
                arena.give(child.left, child.shape.left_size());
            }
            let child_range = (
                symbolic.children.len(),
                symbolic.children.len() + children[index].len(),
            );
            symbolic.children.append(&mut children[index]);
            if let Some(parent) = node.parent {
                children[parent].push(index as u32);
            }
            symbolic.fronts.push(Front {
                shape,
                first,
                rows: symbolic.rows.len(),
                values: symbolic.values_size,
                left,
                assembly: (assembled, symbolic.assembly.len()),
                children: child_range,
            });
            symbolic
                .seats
                .resize(symbolic.rows.len() + below.len(), Seat { row: 0, tile: 0 });
            symbolic.rows.append(&mut below);
            symbolic.values_size += shape.panel_size();
            symbolic.tallest = symbolic.tallest.max(shape.tiles());
            first = end;
        }
        symbolic.left_size = arena.size;
        symbolic
    }
}

/// The parent of each column in the elimination tree (the number of columns for roots), and the
/// number of entries below the diagonal of each column of L.
fn elimination_tree(
    order: &[usize],
    position: &[u32],
    neighbours: &[Vec<usize>],
) -> (Vec<u32>, Vec<u32>) {
    let none = order.len() as u32;
    let mut parent = vec![none; order.len()];
    let mut flag = vec![u32::MAX; order.len()];
    let mut counts = vec![0; order.len()];
    for (k, unknown) in order.iter().enumerate() {
        let k = k as u32;
        flag[k as usize] = k;
        for other in &neighbours[*unknown] {
            let mut i = position[*other];
            while i < k && flag[i as usize] != k {
                if parent[i as usize] == none {
                    parent[i as usize] = k;
                }
                counts[i as usize] += 1;
                flag[i as usize] = k;
                i = parent[i as usize];
            }
        }
    }
    (parent, counts)
}

/// A supernode: its columns in the numbering of the elimination tree.
#[derive(Debug, Default)]
struct Node {
    columns: Vec<u32>,
    below: usize,
    parent: Option<usize>,
}

/// Supernodes, children before parents.
fn amalgamate(parent: &[u32], counts: &[u32]) -> Vec<Node> {
    let dimension = parent.len();
    // A column whose rows are those of its first child, less itself, continues that child's
    // supernode.
    let mut node_of = vec![usize::MAX; dimension];
    let mut nodes: Vec<Node> = Vec::new();
    let mut continued = vec![usize::MAX; dimension];
    for column in 0..dimension {
        let node = if continued[column] == usize::MAX {
            nodes.push(Node::default());
            nodes.len() - 1
        } else {
            continued[column]
        };
        node_of[column] = node;
        nodes[node].columns.push(column as u32);
        nodes[node].below = counts[column] as usize;
        let above = parent[column] as usize;
        if above < dimension
            && counts[above] + 1 == counts[column]
            && continued[above] == usize::MAX
        {
            continued[above] = node;
        }
    }
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut roots = Vec::new();
    // By their last columns, children come before parents.
    let mut by_last: Vec<usize> = (0..nodes.len()).collect();
    by_last.sort_by_key(|node| nodes[*node].columns.last().copied());
    for &node in &by_last {
        let above = nodes[node]
            .columns
            .last()
            .map_or(dimension, |last| parent[*last as usize] as usize);
        match node_of.get(above) {
            Some(parent) => children[*parent].push(node),
            None => roots.push(node),
        }
    }
    for &node in &by_last {
        loop {
            let (columns, below) = (nodes[node].columns.len(), nodes[node].below);
            let gain = |child: usize| {
                let (more, reach) = (nodes[child].columns.len(), nodes[child].below);
                price(columns, below) + price(more, reach) - price(columns + more, below)
            };
            let best = (0..children[node].len())
                .map(|at| (at, gain(children[node][at])))
                .max_by(|(_, a), (_, b)| a.total_cmp(b))
                .filter(|(_, gain)| *gain > 0.0);
            let Some((at, _)) = best else { break };
            let child = children[node].remove(at);
            let mut columns = std::mem::take(&mut nodes[child].columns);
            columns.append(&mut nodes[node].columns);
            nodes[node].columns = columns;
            let mut grandchildren = std::mem::take(&mut children[child]);
            children[node].append(&mut grandchildren);
        }
    }
    // Depth first.
    let mut result: Vec<Node> = Vec::new();
    let mut stack: Vec<(usize, bool)> = roots.iter().rev().map(|root| (*root, false)).collect();
    let mut place = vec![usize::MAX; nodes.len()];
    while let Some((node, visited)) = stack.pop() {
        if visited {
            place[node] = result.len();
            for child in &children[node] {
                result[place[*child]].parent = Some(result.len());
            }
            result.push(std::mem::take(&mut nodes[node]));
        } else {
            stack.push((node, true));
            stack.extend(children[node].iter().rev().map(|child| (*child, false)));
        }
    }
    result
}

/// Places in a workspace, the lowest free one first.
#[derive(Debug, Default)]
struct Arena {
    /// Free ranges below `size`, in order.
    free: Vec<(usize, usize)>,
    size: usize,
}

impl Arena {
    fn take(&mut self, length: usize) -> usize {
        if let Some(at) = self
            .free
            .iter()
            .position(|(start, end)| end - start >= length)
        {
            let start = self.free[at].0;
            self.free[at].0 += length;
            if self.free[at].0 == self.free[at].1 {
                self.free.remove(at);
            }
            return start;
        }
        // Extend the free range at the end, if there is one.
        let start = match self.free.pop() {
            Some((start, end)) if end == self.size => start,
            Some(range) => {
                self.free.push(range);
                self.size
            }
            None => self.size,
        };
        self.size = start + length;
        start
    }

    fn give(&mut self, start: usize, length: usize) {
        if length == 0 {
            return;
        }
        let at = self.free.partition_point(|range| range.0 < start);
        self.free.insert(at, (start, start + length));
        if self
            .free
            .get(at + 1)
            .is_some_and(|next| next.0 == start + length)
        {
            self.free[at].1 = self.free.remove(at + 1).1;
        }
        if at > 0 && self.free[at - 1].1 == start {
            self.free[at - 1].1 = self.free.remove(at).1;
        }
    }
}
