//! Dense work on one front: the columns of a supernode with all rows they reach.
//!
//! A front has m rows, the first k of which are its own columns. L is kept in tiles of eight rows; a
//! tile holds eight numbers for column 0, eight for column 1, and so on, up to column k or the last
//! one that reaches below the diagonal. So every inner loop reads one tile from end to end, eight
//! rows at a time:
//!
//! ```text
//! tile 0:  columns 0..8     strictly lower triangle, zeros above it and on the diagonal
//! tile 1:  columns 0..16    eight full columns, then a triangle
//! tile t:  columns 0..k     full
//! ```
//!
//! When a front is done, the triangle T at the end of a diagonal tile (with ones on the diagonal,
//! and for rows below the front's own) is replaced by T⁻¹ less its diagonal, so that solutions need
//! no recurrence.
//!
//! What is left for the rows k to m, S = A' - L D Lᵀ, is kept by columns, its rows counted from the
//! tile that holds row k. No operations are fused: every processor gives the same bits.

// Loops over lanes are written by index, alike on both sides, so that they vectorise.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

/// Rows per tile.
pub(super) const LANES: usize = 8;
/// Columns finished at a time.
pub(super) const BLOCK: usize = 4;

/// Smallest pivot, as a part of its diagonal entry; smaller ones count as zero.
const SMALLEST_PIVOT: f64 = 1e-13;

/// The size of a front: its own columns, and all its rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub columns: usize,
    pub height: usize,
}

impl Shape {
    pub fn tiles(self) -> usize {
        self.height.div_ceil(LANES)
    }

    /// Columns held by a tile.
    #[inline(always)]
    pub fn width(self, tile: usize) -> usize {
        self.columns.min(LANES * (tile + 1))
    }

    /// Start of a tile.
    #[inline(always)]
    pub fn tile_start(self, tile: usize) -> usize {
        // Tile t of the triangle holds 8 (t + 1) columns
        // of eight rows, later ones `columns`: their sum.
        let triangular = (self.columns / LANES).min(tile);
        LANES * (LANES * triangular * (triangular + 1) / 2 + (tile - triangular) * self.columns)
    }

    /// Position of column 0 of a row.
    pub fn row_start(self, row: usize) -> usize {
        self.tile_start(row / LANES) + row % LANES
    }

    /// Rows below the front's own.
    #[inline(always)]
    pub fn below(self) -> usize {
        self.height - self.columns
    }

    /// Numbers in all tiles.
    pub fn panel_size(self) -> usize {
        self.tile_start(self.tiles())
    }

    /// The tile that holds the first row below the front's own.
    #[inline(always)]
    pub fn first_left_tile(self) -> usize {
        self.columns / LANES
    }

    /// The distance between columns of the left-over.
    #[inline(always)]
    pub fn left_stride(self) -> usize {
        LANES * (self.tiles() - self.first_left_tile())
    }

    /// Number of values in the left-over.
    pub fn left_size(self) -> usize {
        self.below() * self.left_stride()
    }
}

type Tile = [f64; LANES];
type Packed = [f64; BLOCK];

/// The numbers of one tile, column by column.
#[inline(always)]
fn columns_of(panel: &[f64], shape: Shape, tile: usize) -> &[Tile] {
    let start = shape.tile_start(tile);
    panel[start..start + LANES * shape.width(tile)]
        .as_chunks()
        .0
}

/// Sums tile · row over the columns, for T tiles of eight rows and four columns to come.
#[inline(always)]
fn accumulate<const T: usize>(tiles: [&[Tile]; T], packed: &[Packed]) -> [[Tile; BLOCK]; T] {
    let mut sum = [[[0.0; LANES]; BLOCK]; T];
    // Equal lengths known to the compiler: no bound is checked in the loop.
    let tiles = tiles.map(|tile| &tile[..packed.len()]);
    // T · 4 sums of eight lanes stay in registers; each number of L is read once per block of four.
    for (column, packed) in packed.iter().enumerate() {
        for t in 0..T {
            let tile = &tiles[t][column];
            for c in 0..BLOCK {
                for lane in 0..LANES {
                    sum[t][c][lane] += tile[lane] * packed[c];
                }
            }
        }
    }
    sum
}

/// Factors the columns of a front. `diagonal` gives the diagonal entry of each column before any
/// elimination; pivots and their reciprocals are returned in `pivots` and `inverse`.
///
/// # Errors
/// The column whose pivot is not safely positive, and the pivot.
#[inline(always)]
pub(super) fn factor_panel(
    panel: &mut [f64],
    shape: Shape,
    diagonal: impl Fn(usize) -> f64,
    pivots: &mut [f64],
    inverse: &mut [f64],
    packed: &mut Vec<Packed>,
) -> Result<(), (usize, f64)> {
    // Left-looking by blocks: four columns take everything to their left in one pass.
    for first in (0..shape.columns).step_by(BLOCK) {
        let count = BLOCK.min(shape.columns - first);
        let (diagonal_tile, lane) = (first / LANES, first % LANES);
        pack_rows(
            packed,
            columns_of(panel, shape, diagonal_tile),
            lane,
            &pivots[..first],
        );
        let mut block = PivotBlock::default();
        for tile in diagonal_tile..shape.tiles() {
            let [sum] = accumulate([columns_of(panel, shape, tile)], packed);
            let start = shape.tile_start(tile) + LANES * first;
            // Only the columns of this block are written; those to the left are final.
            let targets = panel[start..start + LANES * count].as_chunks_mut().0;
            let mut value = difference(targets, &sum);
            // The diagonal tile comes first and gives the
            // pivots by which all tiles below are divided.
            if tile == diagonal_tile {
                // Numbered within the block by `factor`, within the front by the caller.
                let diagonal = |column: usize| diagonal(first + column);
                block = PivotBlock::factor(value, lane, count, diagonal)
                    .map_err(|(column, pivot)| (first + column, pivot))?;
                let columns = first..first + count;
                pivots[columns.clone()].copy_from_slice(&block.pivots[..count]);
                inverse[columns].copy_from_slice(&block.reciprocals[..count]);
            }
            block.divide(&mut value, count);
            if tile == diagonal_tile {
                // Above and on the diagonal stands no L: zeros
                // keep whole tiles usable in the products.
                for c in 0..count {
                    value[c][..=lane + c].fill(0.0);
                }
            }
            targets.copy_from_slice(&value[..count]);
        }
    }
    Ok(())
}

/// Packs D Lᵀ of four rows, which begin at `lane` of a tile, for the columns that have pivots.
#[inline(always)]
fn pack_rows(packed: &mut Vec<Packed>, tile: &[Tile], lane: usize, pivots: &[f64]) {
    packed.clear();
    // D is folded in here once instead of in every product of the inner loop.
    packed.extend(tile.iter().zip(pivots).map(|(column, pivot)| {
        let mut row = [0.0; BLOCK];
        for c in 0..BLOCK {
            row[c] = column[lane + c] * pivot;
        }
        row
    }));
}

/// The difference targets - sum.
#[inline(always)]
fn difference(targets: &[Tile], sum: &[Tile; BLOCK]) -> [Tile; BLOCK] {
    let mut value = [[0.0; LANES]; BLOCK];
    for c in 0..targets.len() {
        for l in 0..LANES {
            value[c][l] = targets[c][l] - sum[c][l];
        }
    }
    value
}

/// The factorisation of up to four columns among themselves.
#[derive(Default)]
struct PivotBlock {
    pivots: [f64; BLOCK],
    reciprocals: [f64; BLOCK],
    /// Entries d_c L_ec for the columns e > c: upper[c][e].
    upper: [[f64; BLOCK]; BLOCK],
}

impl PivotBlock {
    /// Factors the block whose rows begin at `lane`.
    ///
    /// # Errors
    /// The column whose pivot is not safely positive, and the pivot.
    #[inline(always)]
    fn factor(
        mut value: [Tile; BLOCK],
        lane: usize,
        count: usize,
        diagonal: impl Fn(usize) -> f64,
    ) -> Result<Self, (usize, f64)> {
        let mut block = Self::default();
        for c in 0..count {
            let pivot = value[c][lane + c];
            // Compared with its own entry in A: relative to
            // it, rounding leaves a dependent row about 1e-16.
            if !(pivot.is_finite() && pivot > SMALLEST_PIVOT * diagonal(c)) {
                return Err((c, pivot));
            }
            block.pivots[c] = pivot;
            block.reciprocals[c] = 1.0 / pivot;
            for e in c + 1..count {
                block.upper[c][e] = value[c][lane + e];
                // Outer product of the rows still to come; only the lower triangle (f ≥ e) is used.
                let entry = block.upper[c][e] * block.reciprocals[c];
                for f in e..count {
                    value[e][lane + f] -= entry * value[c][lane + f];
                }
            }
        }
        Ok(block)
    }

    /// Divides eight rows by this block, which gives L of those rows.
    #[inline(always)]
    fn divide(&self, value: &mut [Tile; BLOCK], count: usize) {
        for c in 0..count {
            for l in 0..LANES {
                // A product with the reciprocal: quotients
                // would cost more, and every tile needs it.
                value[c][l] *= self.reciprocals[c];
            }
            for e in c + 1..BLOCK {
                for l in 0..LANES {
                    value[e][l] -= value[c][l] * self.upper[c][e];
                }
            }
        }
    }
}

/// Writes -L D Lᵀ of the rows below the front's own into `left_over`.
#[inline(always)]
pub(super) fn start_left(
    panel: &[f64],
    shape: Shape,
    pivots: &[f64],
    left_over: &mut [f64],
    packed: &mut Vec<Packed>,
) {
    let (stride, tiles, base) = (shape.left_stride(), shape.tiles(), shape.first_left_tile());
    // Lower triangle only: the tiles above that of the first row are never read.
    for first in (shape.columns..shape.height).step_by(BLOCK) {
        let count = BLOCK.min(shape.height - first);
        pack_rows_below(packed, panel, shape, first..first + count, pivots);
        let block = &mut left_over[(first - shape.columns) * stride..][..count * stride];
        let mut tile = first / LANES;
        // Two tiles at a time share the packed rows: half of their loads.
        while tile + 2 <= tiles {
            let pair = [tile, tile + 1].map(|tile| columns_of(panel, shape, tile));
            let [upper, lower] = accumulate(pair, packed);
            store(block, stride, tile - base, &upper);
            store(block, stride, tile + 1 - base, &lower);
            tile += 2;
        }
        if tile < tiles {
            let [sum] = accumulate([columns_of(panel, shape, tile)], packed);
            store(block, stride, tile - base, &sum);
        }
    }
}

/// Packs D Lᵀ of up to four rows below the front's own, which may lie in different tiles.
#[inline(always)]
fn pack_rows_below(
    packed: &mut Vec<Packed>,
    panel: &[f64],
    shape: Shape,
    rows: Range<usize>,
    pivots: &[f64],
) {
    packed.clear();
    packed.resize(shape.columns, [0.0; BLOCK]);
    for (c, row) in rows.enumerate() {
        let tile = columns_of(panel, shape, row / LANES);
        for ((out, column), pivot) in packed.iter_mut().zip(tile).zip(pivots) {
            out[c] = column[row % LANES] * pivot;
        }
    }
}

/// Writes -sum into a tile of four columns.
#[inline(always)]
fn store(block: &mut [f64], stride: usize, tile: usize, sum: &[Tile; BLOCK]) {
    // Fewer than four columns may be left at the end; `zip` stops there.
    for (column, sum) in block.chunks_exact_mut(stride).zip(sum) {
        for (target, sum) in column[LANES * tile..LANES * (tile + 1)].iter_mut().zip(sum) {
            *target = -sum;
        }
    }
}

/// Inverts the triangle of every diagonal tile. With T = 1 + L, the columns of V = T⁻¹ are V_c =
/// e_c - Σ_{j>c} V_j L_jc.
#[inline(always)]
pub(super) fn invert_triangles(panel: &mut [f64], shape: Shape) {
    for tile in 0..shape.columns.div_ceil(LANES) {
        let start = shape.tile_start(tile) + LANES * LANES * tile;
        let count = LANES.min(shape.columns - LANES * tile);
        let columns = panel[start..start + LANES * count]
            .as_chunks_mut::<LANES>()
            .0;
        let mut inverse = [[0.0; LANES]; LANES];
        // From the last column to the first: V_c needs V_j of all later columns.
        for c in (0..LANES).rev() {
            // Columns beyond the front's own do not exist; they count as those of the unit matrix.
            if let Some(column) = columns.get_mut(c) {
                let mut sum = [0.0; LANES];
                for j in c + 1..LANES {
                    for l in 0..LANES {
                        sum[l] -= inverse[j][l] * column[j];
                    }
                }
                *column = sum;
                inverse[c] = sum;
            }
            inverse[c][c] = 1.0;
        }
    }
}

/// Solves L y = t for the front's own rows and subtracts L y from t for those below; t has room for
/// all tiles.
#[inline(always)]
pub(super) fn solve_forward(panel: &[f64], shape: Shape, t: &mut [Tile]) {
    let diagonal_tiles = shape.columns.div_ceil(LANES);
    // Tile after tile: each needs the solution of those above and none below.
    for tile in 0..diagonal_tiles {
        let (solved_tiles, remaining_tiles) = t.split_at_mut(tile);
        remaining_tiles[0] = solve_tile(
            columns_of(panel, shape, tile),
            solved_tiles,
            remaining_tiles[0],
        );
    }
    let (solution, lower_tiles) = t.split_at_mut(diagonal_tiles);
    // The padding of the last diagonal tile holds rows
    // below the front's own, which are no unknowns yet.
    let solution = &solution.as_flattened()[..shape.columns];
    let mut lower_tiles = lower_tiles[..shape.tiles() - diagonal_tiles].iter_mut();
    let below = &panel[shape.tile_start(diagonal_tiles)..shape.panel_size()];
    let mut below = below.as_chunks::<LANES>().0.chunks_exact(shape.columns);
    // Four tiles at a time read the solution once.
    while lower_tiles.len() >= 4 {
        let tiles = (below.next(), below.next(), below.next(), below.next());
        if let (Some(a), Some(b), Some(c), Some(d)) = tiles {
            for sum in combine([a, b, c, d], solution) {
                subtract(lower_tiles.next(), &sum);
            }
        }
    }
    for columns in below {
        let [sum] = combine([columns], solution);
        subtract(lower_tiles.next(), &sum);
    }
}

/// Solves L y = t for the eight rows of a diagonal tile, given y of the rows above.
#[inline(always)]
fn solve_tile(columns: &[Tile], solved_tiles: &[Tile], mut value: Tile) -> Tile {
    // Two sums, so that one addition need not wait for the other.
    let mut sum = [[0.0; LANES]; 2];
    for (columns, tile) in columns.chunks_exact(LANES).zip(solved_tiles) {
        for c in 0..LANES {
            for l in 0..LANES {
                sum[c % 2][l] += columns[c][l] * tile[c];
            }
        }
    }
    for l in 0..LANES {
        value[l] -= sum[0][l] + sum[1][l];
    }
    // The triangle holds T⁻¹ - 1, so one product replaces the recurrence.
    let given = value;
    for (column, given) in columns[LANES * solved_tiles.len()..].iter().zip(&given) {
        for l in 0..LANES {
            value[l] += column[l] * given;
        }
    }
    value
}

/// Subtracts: target -= sum.
#[inline(always)]
fn subtract(target: Option<&mut Tile>, sum: &Tile) {
    if let Some(target) = target {
        for l in 0..LANES {
            target[l] -= sum[l];
        }
    }
}

/// Sums tile · coefficient over the columns.
#[inline(always)]
fn combine<const T: usize>(tiles: [&[Tile]; T], coefficients: &[f64]) -> [Tile; T] {
    let mut sum = [[0.0; LANES]; T];
    let tiles = tiles.map(|tile| &tile[..coefficients.len()]);
    for (p, coefficient) in coefficients.iter().enumerate() {
        for t in 0..T {
            for l in 0..LANES {
                sum[t][l] += tiles[t][p][l] * coefficient;
            }
        }
    }
    sum
}

/// Solves Lᵀ x = t for the front's own rows; those below are given, the padding is zero.
#[inline(always)]
pub(super) fn solve_backward(panel: &[f64], shape: Shape, t: &mut [Tile], sums: &mut Vec<Tile>) {
    let k = shape.columns;
    sums.clear();
    sums.resize(k, [0.0; LANES]);
    let diagonal_tiles = k.div_ceil(LANES);
    let below = &panel[shape.tile_start(diagonal_tiles)..shape.panel_size()];
    let mut below = below.as_chunks::<LANES>().0.chunks_exact(k);
    let (solution, lower_tiles) = t.split_at_mut(diagonal_tiles);
    let mut lower_tiles = lower_tiles.iter();
    while below.len() >= 4 {
        // Taken together: a tile and its part of t are consumed in step.
        let tiles = (below.next(), below.next(), below.next(), below.next());
        if let (Some(a), Some(b), Some(c), Some(d)) = tiles
            && let (Some(e), Some(f), Some(g), Some(h)) = (
                lower_tiles.next(),
                lower_tiles.next(),
                lower_tiles.next(),
                lower_tiles.next(),
            )
        {
            spread([a, b, c, d], [e, f, g, h], sums);
        }
    }
    for (tile, coefficients) in below.zip(lower_tiles) {
        spread([tile], [coefficients], sums);
    }
    // Backwards, as x of later tiles is known first; `sums` then has all that stands below.
    for tile in (0..diagonal_tiles).rev() {
        let columns = columns_of(panel, shape, tile);
        let value = &mut solution[tile];
        let triangle = &columns[LANES * tile..];
        for (value, sum) in value.iter_mut().zip(&sums[LANES * tile..]) {
            // Lanes are added only here: sums by lanes
            // until the end, then one reduction per column.
            *value -= total(sum);
        }
        let given = *value;
        for (value, column) in value.iter_mut().zip(triangle) {
            let mut product = [0.0; LANES];
            for l in 0..LANES {
                // Along a column, as Lᵀ is wanted: the transposed inverse of the triangle.
                product[l] = column[l] * given[l];
            }
            *value += total(&product);
        }
        // What this tile contributes to the columns of the tiles above it.
        spread([&columns[..LANES * tile]], [value], sums);
    }
}

/// Adds tile · coefficient to the sums, lane by lane.
#[inline(always)]
fn spread<const T: usize>(tiles: [&[Tile]; T], coefficients: [&Tile; T], sums: &mut [Tile]) {
    let coefficients = coefficients.map(|tile| *tile);
    let count = tiles[0].len();
    let tiles = tiles.map(|tile| &tile[..count]);
    for (p, sum) in sums[..count].iter_mut().enumerate() {
        for t in 0..T {
            for l in 0..LANES {
                sum[l] += tiles[t][p][l] * coefficients[t][l];
            }
        }
    }
}

/// The sum of the lanes.
#[inline(always)]
fn total(x: &Tile) -> f64 {
    // A fixed tree of additions, so the result is the same for every width of vectors.
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
