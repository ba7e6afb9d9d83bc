//! Joins the vertices of a dual surface in coarse cells, where that keeps the topology.
//!
//! A vertex of the dual stands for a sheet in a cell, a patch of the surface; the patches tile it.
//! Patches that hang together within one coarse cell are merged into one if their union is a disk,
//! V - E + F = 1. Merging disks into disks changes nothing of the surface, only its tiling, so
//! whatever the fine lattice resolves is kept, at the coarse number of vertices wherever the
//! surface is simple. Merged patches that touch another one along two seams, or fewer than three
//! others, are taken apart again, since a triangle mesh cannot express them.

use super::dual::{Dual, NOTHING, Tile};
use super::lattice::Cell;
use protomer_kernel::disjoint_sets::DisjointSets;

/// The vertices merged into each other.
pub(super) struct Patches {
    /// The patch of each vertex of the dual: one of its members.
    patch: Vec<u32>,
    size: Vec<usize>,
    apart: Vec<bool>,
}

impl Patches {
    /// Patches no wider than `widths` says.
    pub(super) fn merged(dual: &Dual, widths: &Widths) -> Self {
        let patch = united(dual, widths);
        let size = sizes(&patch);
        let apart = vec![false; patch.len()];
        let mut patches = Self { patch, size, apart };
        let doubled_euler = patches.doubled_euler_numbers(dual);
        for (patch, euler) in doubled_euler.into_iter().enumerate() {
            // A union that is no disk (2 (V - E + F) = 2) would close a hole or join two sheets.
            if euler != 2 {
                patches.take_apart(patch as u32);
            }
        }
        patches
    }

    /// The patch that a vertex of the dual belongs to.
    pub(super) fn patch(&self, vertex: u32) -> u32 {
        let patch = self.patch[vertex as usize];
        if self.apart[patch as usize] {
            vertex
        } else {
            patch
        }
    }

    /// Undoes a merger; whether there was one to undo.
    pub(super) fn take_apart(&mut self, patch: u32) -> bool {
        let merged = self.is_merged(patch);
        if merged {
            self.apart[patch as usize] = true;
        }
        merged
    }

    fn is_merged(&self, patch: u32) -> bool {
        self.size[patch as usize] > 1 && !self.apart[patch as usize]
    }

    /// Merged patches that have fewer than `least` corners.
    pub(super) fn with_fewer_corners(&self, corners: &[u32], least: u32) -> Vec<u32> {
        let mut few = Vec::new();
        for (patch, corners) in (0..).zip(corners) {
            if self.is_merged(patch) && *corners < least {
                few.push(patch);
            }
        }
        few
    }

    /// 2 (V - E + F) of each closed patch: its tiles are the vertices of the dual, its edges those
    /// of the dual (each on two quadrangles), its vertices the quadrangles.
    fn doubled_euler_numbers(&self, dual: &Dual) -> Vec<i32> {
        // Doubled, since an edge of the patch's rim lies on one quadrangle here and on one beyond.
        let mut sum = vec![0; self.patch.len()];
        for patch in &self.patch {
            sum[*patch as usize] += 2;
        }
        for quad in &dual.quads {
            let corners = quad.corners.map(|vertex| self.patch[vertex as usize]);
            for i in 0..4 {
                // A quadrangle is one vertex of each patch that
                // it touches, however many of its corners belong.
                if !corners[..i].contains(&corners[i]) {
                    sum[corners[i] as usize] += 2;
                }
                if quad.corners[i] == quad.corners[(i + 1) % 4] {
                    continue; // no edge: a cube's tile that is there twice
                }
                let (a, b) = (corners[i], corners[(i + 1) % 4]);
                // Half an edge: the other half comes from the quadrangle on its other side.
                sum[a as usize] -= 1;
                if a != b {
                    sum[b as usize] -= 1;
                }
            }
        }
        sum
    }
}

/// The width of patches along each axis, in cells.
pub(super) struct Widths {
    pub(super) of_large_shells: i32,
    pub(super) of_small_shells: i32,
    /// Shells with fewer tiles than this are small.
    pub(super) tiles_of_large_shells: usize,
}

/// Root, for each vertex, of a tree that holds its neighbours in the same coarse cell.
fn united(dual: &Dual, widths: &Widths) -> Vec<u32> {
    let coarse_cell = |tile: &Tile, width: i32| tile.cell.map(|x| x.div_euclid(width));
    let (large, small) = (widths.of_large_shells, widths.of_small_shells);
    // One width for all: shells need not be told apart.
    if large == small {
        return forest(dual, |tile, _| coarse_cell(tile, large));
    }
    // With one cell for everything the trees are the connected shells.
    let shells = forest(dual, |_, _| [0; 3]);
    let tiles = sizes(&shells);
    forest(dual, |tile, vertex| {
        let is_large = tiles[shells[vertex] as usize] >= widths.tiles_of_large_shells;
        coarse_cell(tile, if is_large { large } else { small })
    })
}

/// Root, for each vertex, of a tree that holds its neighbours in the same cell.
fn forest(dual: &Dual, cell: impl Fn(&Tile, usize) -> Cell) -> Vec<u32> {
    let mut sets = DisjointSets::new(dual.tiles.len());
    let mut cells = Vec::with_capacity(dual.tiles.len());
    for (vertex, tile) in dual.tiles.iter().enumerate() {
        cells.push(cell(tile, vertex));
    }
    for quad in &dual.quads {
        for i in 0..4 {
            let (a, b) = (quad.corners[i], quad.corners[(i + 1) % 4]);
            if a != b && cells[a as usize] == cells[b as usize] {
                sets.join(a, b);
            }
        }
    }
    sets.into_roots()
}

/// Number of vertices of each root.
fn sizes(roots: &[u32]) -> Vec<usize> {
    let mut sizes = vec![0; roots.len()];
    for root in roots {
        sizes[*root as usize] += 1;
    }
    sizes
}

/// Number of polygons at each edge.
pub(super) struct EdgeCounts {
    /// The first entry of each vertex, which lists the edges to vertices of higher number.
    head: Vec<u32>,
    entries: Vec<EdgeCount>,
}

struct EdgeCount {
    other: u32,
    next: u32,
    count: u32,
}

impl EdgeCounts {
    pub(super) fn new(vertices: usize) -> Self {
        Self {
            head: vec![NOTHING; vertices],
            entries: Vec::new(),
        }
    }

    /// Counts an edge once more, and says how often it has been by now.
    pub(super) fn add(&mut self, a: u32, b: u32) -> u32 {
        let (low, high) = (a.min(b), a.max(b));
        if let Some(index) = self.find(low, high) {
            let entry = &mut self.entries[index as usize];
            entry.count += 1;
            return entry.count;
        }
        // A list for each lower vertex: few edges each, and no hash.
        let head = &mut self.head[low as usize];
        self.entries.push(EdgeCount {
            other: high,
            next: *head,
            count: 1,
        });
        *head = self.entries.len() as u32 - 1;
        1
    }

    pub(super) fn count(&self, a: u32, b: u32) -> u32 {
        match self.find(a.min(b), a.max(b)) {
            Some(entry) => self.entries[entry as usize].count,
            None => 0,
        }
    }

    fn find(&self, low: u32, high: u32) -> Option<u32> {
        let mut index = self.head[low as usize];
        while index != NOTHING {
            let entry = &self.entries[index as usize];
            if entry.other == high {
                return Some(index);
            }
            index = entry.next;
        }
        None
    }
}
