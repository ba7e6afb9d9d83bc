//! Supernodes: columns of L with the same rows below them.
//!
//! They follow from the elimination tree, in which the parent of a column is the row of its first
//! entry below the diagonal. A child joins its parent where the work on the zeros this brings is
//! less than the cost of a separate front.

use super::front::{BLOCK, LANES};

/// A supernode: consecutive columns, in the numbering of the elimination tree.
#[derive(Debug, Default)]
pub(super) struct Supernode {
    pub columns: Vec<u32>,
    /// Rows below the last column.
    below: usize,
    /// Index of the parent in the list.
    pub parent: Option<usize>,
}

/// The supernodes for this order of elimination, children before parents.
pub(super) fn supernodes(order: &[usize], neighbours: &[Vec<usize>]) -> Vec<Supernode> {
    let tree = EliminationTree::new(order, neighbours);
    let mut forest = Forest::new(&tree);
    forest.join_children();
    forest.into_post_order()
}

struct EliminationTree {
    /// The parent of each column.
    parent: Vec<Option<usize>>,
    /// The number of entries below the diagonal of each column of L.
    below: Vec<usize>,
}

impl EliminationTree {
    /// The elimination tree. Row k of L has its entries on the paths from the neighbours of unknown
    /// k up the tree to k.
    fn new(order: &[usize], neighbours: &[Vec<usize>]) -> Self {
        let mut position = vec![0; order.len()];
        for (step, unknown) in order.iter().enumerate() {
            position[*unknown] = step;
        }
        let mut parent = vec![None; order.len()];
        let mut below = vec![0; order.len()];
        let mut last_row = vec![usize::MAX; order.len()];
        for (row, unknown) in order.iter().enumerate() {
            // A row of its own marks, so that each path is
            // climbed once per row: work as large as L.
            last_row[row] = row;
            for other in &neighbours[*unknown] {
                let mut column = position[*other];
                // Up the tree until a column that this row has passed
                // already: the rest of the path is marked too.
                while column < row && last_row[column] != row {
                    below[column] += 1;
                    last_row[column] = row;
                    // The first row to reach a column without
                    // a parent is its parent, as rows ascend.
                    column = *parent[column].get_or_insert(row);
                }
            }
        }
        Self { parent, below }
    }
}

/// The supernodes and the tree that they form.
struct Forest {
    nodes: Vec<Supernode>,
    children: Vec<Vec<usize>>,
    roots: Vec<usize>,
    /// All nodes by their last columns: children before parents.
    ascending: Vec<usize>,
}

impl Forest {
    fn new(tree: &EliminationTree) -> Self {
        let (nodes, node_of) = fundamental_supernodes(tree);
        let last = |node: &usize| nodes[*node].columns.last().copied();
        let mut ascending: Vec<usize> = (0..nodes.len()).collect();
        // Children before parents, by their last columns, whatever joins happen later.
        ascending.sort_by_key(last);
        let mut children = vec![Vec::new(); nodes.len()];
        let mut roots = Vec::new();
        for node in &ascending {
            let above = last(node).and_then(|column| tree.parent[column as usize]);
            match above {
                Some(column) => children[node_of[column]].push(*node),
                None => roots.push(*node),
            }
        }
        Self {
            nodes,
            children,
            roots,
            ascending,
        }
    }

    /// Joins children to their parents while that is cheaper.
    fn join_children(&mut self) {
        for index in 0..self.ascending.len() {
            let node = self.ascending[index];
            // Repeated: grandchildren become children by a join and may be worth joining too.
            while let Some(sibling) = self.cheapest_to_join(node) {
                self.join(node, sibling);
            }
        }
    }

    /// Child of a node whose merger saves most, as a place among its siblings.
    fn cheapest_to_join(&self, node: usize) -> Option<usize> {
        let mut best = None;
        let mut most = 0.0;
        for (sibling, child) in self.children[node].iter().enumerate() {
            let saved = self.saved_by_joining(node, *child);
            // `>=`: of equal savings the last one counts, so the result is unique.
            if saved > 0.0 && saved >= most {
                most = saved;
                best = Some(sibling);
            }
        }
        best
    }

    fn saved_by_joining(&self, node: usize, child: usize) -> f64 {
        let (node, child) = (&self.nodes[node], &self.nodes[child]);
        let (columns, more) = (node.columns.len(), child.columns.len());
        let apart = price(columns, node.below) + price(more, child.below);
        apart - price(columns + more, node.below)
    }

    fn join(&mut self, node: usize, sibling: usize) {
        let child = self.children[node].remove(sibling);
        let mut columns = std::mem::take(&mut self.nodes[child].columns);
        // The child's columns come first, as they are eliminated before the node's.
        columns.append(&mut self.nodes[node].columns);
        self.nodes[node].columns = columns;
        let grandchildren = std::mem::take(&mut self.children[child]);
        self.children[node].extend(grandchildren);
    }

    /// The nodes that are left, depth first.
    fn into_post_order(mut self) -> Vec<Supernode> {
        // A stack of tasks instead of recursion: the tree may be as deep as the matrix is large.
        enum Task {
            Enter(usize),
            Leave(usize),
        }
        let mut result: Vec<Supernode> = Vec::new();
        let mut place = vec![usize::MAX; self.nodes.len()];
        let mut tasks: Vec<Task> = self.roots.iter().rev().copied().map(Task::Enter).collect();
        while let Some(task) = tasks.pop() {
            match task {
                Task::Enter(node) => {
                    tasks.push(Task::Leave(node));
                    tasks.extend(self.children[node].iter().rev().copied().map(Task::Enter));
                }
                Task::Leave(node) => {
                    place[node] = result.len();
                    for child in &self.children[node] {
                        // All children have their places by now.
                        result[place[*child]].parent = Some(place[node]);
                    }
                    result.push(std::mem::take(&mut self.nodes[node]));
                }
            }
        }
        result
    }
}

/// Supernodes without any zeros, and the one of each column: a column whose rows are those of its
/// first child, less itself, continues the supernode of that child.
fn fundamental_supernodes(tree: &EliminationTree) -> (Vec<Supernode>, Vec<usize>) {
    let columns = tree.parent.len();
    let mut nodes: Vec<Supernode> = Vec::new();
    let mut node_of = Vec::with_capacity(columns);
    let mut continued: Vec<Option<usize>> = vec![None; columns];
    for column in 0..columns {
        let node = continued[column].unwrap_or(nodes.len());
        if node == nodes.len() {
            nodes.push(Supernode::default());
        }
        node_of.push(node);
        nodes[node].columns.push(column as u32);
        nodes[node].below = tree.below[column];
        if let Some(above) = tree.parent[column]
            // Same rows less itself, so no zeros arise where the two share a front.
            && tree.below[above] + 1 == tree.below[column]
        {
            // The first child only: a supernode is one chain of columns.
            continued[above].get_or_insert(node);
        }
    }
    (nodes, node_of)
}

/// A rough price of a front in nanoseconds: one factorisation and some five solutions.
fn price(columns: usize, below: usize) -> f64 {
    let (k, r) = (columns as f64, below as f64);
    let blocks = (k / BLOCK as f64).ceil() + (r / BLOCK as f64).ceil();
    let tiles = ((k + r) / LANES as f64).ceil();
    let multiplications = k * k * (k / 3.0 + r) + k * r * r;
    // Overhead, columns, tiles begun, arithmetic, numbers that the children left.
    let factorisation =
        60.0 + 8.0 * k + 3.0 * blocks * tiles + 0.08 * multiplications + 0.6 * r * (r + 1.0) / 2.0;
    let solution = 25.0 + 6.0 * k + r + 0.25 * k * (0.5 * k + r);
    factorisation + 5.0 * solution
}
