//! What follows from the pattern alone: fronts, and where every number goes.
//!
//! Each supernode has a front (see `front`), which takes the entries of A in its columns and what
//! its children in the tree of supernodes left over (multifrontal method: Duff and Reid, ACM Trans.
//! Math. Softw. 9, 302 (1983)).

use super::arena::Arena;
use super::front::{LANES, Shape};
use super::ordering::nested_dissection;
use super::supernodes::{Supernode, supernodes};
use std::ops::Range;

/// One front.
#[derive(Debug, Clone)]
pub(super) struct Front {
    pub shape: Shape,
    /// First column of the front in the order of elimination.
    pub first: usize,
    /// Start of the rows below the own columns in `Symbolic::rows`.
    pub rows: usize,
    /// Start of the tiles among the numbers of L.
    pub values: usize,
    /// Start of the left-over in the workspace.
    pub left_over_start: usize,
    /// Range of the entries of A in `Symbolic::assembly`.
    pub assembly: Range<usize>,
    /// Range of the children in `Symbolic::children`.
    pub children: Range<usize>,
}

impl Front {
    /// Own columns of the front, as steps of elimination.
    pub fn own(&self) -> Range<usize> {
        self.first..self.first + self.shape.columns
    }

    /// Range of the rows below the own columns in `Symbolic::rows` and `Symbolic::seats`.
    pub fn below(&self) -> Range<usize> {
        self.rows..self.rows + self.shape.below()
    }

    /// Range of the tiles among the numbers of L.
    pub fn tiles(&self) -> Range<usize> {
        self.values..self.values + self.shape.panel_size()
    }

    /// Range of the left-over in the workspace.
    pub fn left_over(&self) -> Range<usize> {
        self.left_over_start..self.left_over_start + self.shape.left_size()
    }
}

/// Position of a child's row in the front of its parent.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seat {
    /// The row.
    pub row: u32,
    /// The place of column 0 of that row in the tiles.
    pub tile: u32,
}

/// Plan of a factorisation, computed once for a pattern.
#[derive(Debug, Clone, Default)]
pub(super) struct Symbolic {
    /// The unknown that is eliminated at each step.
    pub order: Vec<u32>,
    /// All fronts, children before parents.
    pub fronts: Vec<Front>,
    pub children: Vec<u32>,
    /// Rows below the own columns of every front, as steps of elimination.
    pub rows: Vec<u32>,
    /// Positions of these rows in the front of the parent.
    pub seats: Vec<Seat>,
    /// Pairs of an entry of A and its place in the tiles of its front.
    pub assembly: Vec<(u32, u32)>,
    /// The entry of A on the diagonal at each step.
    pub diagonal: Vec<u32>,
    /// The length of all tiles together.
    pub values_size: usize,
    /// The length of the workspace for left-overs.
    pub left_size: usize,
    /// The tallest front in tiles.
    pub tallest: usize,
}

impl Symbolic {
    pub fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let neighbours = neighbours(dimension, entries);
        let dissected = nested_dissection(&neighbours, places);
        let nodes = supernodes(&dissected, &neighbours);
        // Columns are numbered along the tree of supernodes.
        let mut order = Vec::with_capacity(dimension);
        let mut step_of = vec![0; dimension];
        for column in nodes.iter().flat_map(|node| &node.columns) {
            // `order` lists unknowns by step, `step_of` steps by unknown.
            let unknown = dissected[*column as usize];
            step_of[unknown] = order.len();
            order.push(unknown as u32);
        }
        let columns = Columns::new(&step_of, entries);
        let mut builder = Builder::new(&columns, nodes.len());
        for (index, node) in nodes.iter().enumerate() {
            builder.add_front(index, node);
        }
        Self {
            order,
            diagonal: columns.diagonal(),
            left_size: builder.arena.size,
            ..builder.symbolic
        }
    }
}

/// The unknowns coupled to each unknown.
fn neighbours(dimension: usize, entries: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); dimension];
    for &(row, column) in entries {
        if row != column {
            neighbours[row].push(column);
            neighbours[column].push(row);
        }
    }
    neighbours
}

/// The entries of A by columns, in the order of elimination.
struct Columns {
    /// Start of each column, and the end of the last one.
    starts: Vec<usize>,
    /// Pairs of a row and an entry, in the order in which entries are given.
    entries: Vec<(u32, u32)>,
}

impl Columns {
    fn new(step_of: &[usize], entries: &[(usize, usize)]) -> Self {
        let dimension = step_of.len();
        let permuted: Vec<(usize, usize)> = entries
            .iter()
            .map(|(row, column)| (step_of[*row], step_of[*column]))
            .collect();
        let mut starts = vec![0; dimension + 1];
        // Counting sort: sizes, running sums, then each entry to the next free place of its column.
        for (a, b) in &permuted {
            starts[a.min(b) + 1] += 1;
        }
        for column in 0..dimension {
            starts[column + 1] += starts[column];
        }
        let mut next = starts.clone();
        let mut by_column = vec![(0, 0); entries.len()];
        for (entry, (a, b)) in permuted.iter().enumerate() {
            // In the lower triangle the earlier step is the
            // column, whatever side the entry was given on.
            let column = *a.min(b);
            by_column[next[column]] = (*a.max(b) as u32, entry as u32);
            next[column] += 1;
        }
        Self {
            starts,
            entries: by_column,
        }
    }

    /// The entries of some consecutive columns.
    fn entries(&self, columns: Range<usize>) -> &[(u32, u32)] {
        &self.entries[self.starts[columns.start]..self.starts[columns.end]]
    }

    /// The entry on the diagonal of each column.
    fn diagonal(&self) -> Vec<u32> {
        let mut diagonal = vec![0; self.starts.len() - 1];
        for (column, diagonal) in diagonal.iter_mut().enumerate() {
            for (row, entry) in self.entries(column..column + 1) {
                if *row as usize == column {
                    *diagonal = *entry;
                }
            }
        }
        diagonal
    }
}

/// Plans fronts one by one, children before parents.
struct Builder<'a> {
    columns: &'a Columns,
    symbolic: Symbolic,
    /// Fronts that wait for each parent.
    waiting: Vec<Vec<u32>>,
    /// The row in the front being planned, for each step of elimination that it reaches.
    local: Vec<u32>,
    arena: Arena,
    /// The first column that has no front yet.
    first: usize,
}

impl<'a> Builder<'a> {
    fn new(columns: &'a Columns, fronts: usize) -> Self {
        Self {
            columns,
            symbolic: Symbolic::default(),
            waiting: vec![Vec::new(); fronts],
            local: vec![u32::MAX; columns.starts.len() - 1],
            arena: Arena::default(),
            first: 0,
        }
    }

    fn add_front(&mut self, index: usize, node: &Supernode) {
        let columns = self.first..self.first + node.columns.len();
        let children = std::mem::take(&mut self.waiting[index]);
        // Children first: their rows may lie far below the entries of A in these columns.
        let below = self.rows_below(&columns, &children);
        let shape = Shape {
            columns: columns.len(),
            height: columns.len() + below.len(),
        };
        self.number_rows(&columns, &below);
        let assembly = self.assemble(&columns, shape);
        self.seat_children(&children, shape);
        let left_over_start = self.reserve_left_over(&children, shape);
        let symbolic = &mut self.symbolic;
        let first_child = symbolic.children.len();
        symbolic.children.extend(children);
        symbolic.fronts.push(Front {
            shape,
            first: columns.start,
            rows: symbolic.rows.len(),
            values: symbolic.values_size,
            left_over_start,
            assembly,
            children: first_child..symbolic.children.len(),
        });
        symbolic.rows.extend(below);
        symbolic.seats.resize(symbolic.rows.len(), Seat::default());
        symbolic.values_size += shape.panel_size();
        symbolic.tallest = symbolic.tallest.max(shape.tiles());
        if let Some(parent) = node.parent {
            self.waiting[parent].push(index as u32);
        }
        self.first = columns.end;
    }

    /// The rows below the own columns: those of the entries of A and those of the children.
    fn rows_below(&self, columns: &Range<usize>, children: &[u32]) -> Vec<u32> {
        let mut rows: Vec<u32> = Vec::new();
        for (row, _) in self.columns.entries(columns.clone()) {
            rows.push(*row);
        }
        for child in children {
            let child = &self.symbolic.fronts[*child as usize];
            rows.extend(&self.symbolic.rows[child.below()]);
        }
        // Rows of children that are own columns here are eliminated in this front.
        rows.retain(|row| *row as usize >= columns.end);
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    fn number_rows(&mut self, columns: &Range<usize>, below: &[u32]) {
        for (row, step) in columns.clone().enumerate() {
            self.local[step] = row as u32;
        }
        for (row, step) in below.iter().enumerate() {
            // `local` is not cleared between fronts: each
            // front overwrites the rows that it reaches.
            self.local[*step as usize] = (columns.len() + row) as u32;
        }
    }

    /// Plans the places of the entries of A in the own columns.
    fn assemble(&mut self, columns: &Range<usize>, shape: Shape) -> Range<usize> {
        let assembly = &mut self.symbolic.assembly;
        let begin = assembly.len();
        for (column, step) in columns.clone().enumerate() {
            for (row, entry) in self.columns.entries(step..step + 1) {
                let row = self.local[*row as usize] as usize;
                // Position of (row, column): start of the row
                // in its tile, eight numbers on per column.
                let place = shape.row_start(row) + LANES * column;
                assembly.push((*entry, place as u32));
            }
        }
        begin..assembly.len()
    }

    /// Plans the places of the rows of the children in this front.
    fn seat_children(&mut self, children: &[u32], shape: Shape) {
        let Symbolic {
            fronts,
            rows,
            seats,
            ..
        } = &mut self.symbolic;
        for child in children {
            for index in fronts[*child as usize].below() {
                let row = self.local[rows[index] as usize];
                let tile = shape.row_start(row as usize) as u32;
                seats[index] = Seat { row, tile };
            }
        }
    }

    /// Reserves a place for the left-over of this front, and frees those of its children, which it
    /// has used by the time that others need the place.
    fn reserve_left_over(&mut self, children: &[u32], shape: Shape) -> usize {
        // Before the children's are freed: the left-over is built while theirs are still read.
        let start = self.arena.take(shape.left_size());
        for child in children {
            let child = &self.symbolic.fronts[*child as usize];
            self.arena
                .give(child.left_over_start, child.shape.left_size());
        }
        start
    }
}
