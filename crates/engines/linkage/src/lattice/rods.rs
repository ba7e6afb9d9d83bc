//! The rods as constraints.
//!
//! With Δ = r(from) - r(to) and u = Δ/r0, a rod demands σ = (|Δ|² - r0²) / (2 r0) = 0. Its row of
//! the Jacobian J holds, for the square at either end (sign + and -),
//!
//! ∂σ/∂(x, y, θ) = ± (u_x, u_y, u · G ρ), G ρ = (-ρ_y, ρ_x),
//!
//! and, for a rod to the image n in a flexible [`cell`](super::cell), for the cell
//!
//! ∂σ/∂(H_xx, H_yy, H_xy) = - (u_x n_x, u_y n_y, u_x n_y),
//!
//! where ρ leads from the centre to the corner. Multipliers λ are forces along the rods (positive
//! pushes the ends apart), the accelerations they give are M⁻¹ Jᵀ λ, and A = J M⁻¹ Jᵀ couples rods
//! that share a square, or cross the edges of a flexible cell.

use super::cell::{Cell, cell_gradient};
use super::network::{Corner, Network, Rod};
use super::state::angles;
use crate::plane::{Vector, direction, dot, minus, norm, turned};
use crate::{CrystalError, Result};
use protomer_kernel::sparse::{LdlFactor, SparseError};

/// The rods of a network with what changes from state to state: their rows of J, and A factored.
///
/// ```
/// use protomer_linkage::lattice::rods::RodSystem;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let state = State::coherent(&network, 0.3);
/// let mut rods = RodSystem::new(&network);
/// let mut sigma = vec![0.0; rods.len()];
/// let (_, worst) = rods.violations(&state.positions, &mut sigma);
/// assert!(worst.abs() < 1e-15);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone)]
pub struct RodSystem {
    rods: Vec<RodGeometry>,
    /// Reciprocal mass and inertia per square.
    inverse_mass: Vec<[f64; 2]>,
    /// Blocks of J: for each rod the three numbers of either end.
    rows: Vec<[[f64; 3]; 2]>,
    /// Products of blocks that add up to the entries of A.
    products: Vec<Product>,
    /// Pairs of rods that both move the flexible cell.
    cell_products: Vec<CellProduct>,
    /// Reciprocal mass of a component of the cell.
    inverse_cell_mass: f64,
    numbers: Vec<f64>,
    factor: LdlFactor,
    /// The positions last seen, and the rods there.
    last_positions: Vec<f64>,
    spans: Vec<Span>,
    /// Cosine and sine of every angle at the positions last seen.
    directions: Vec<Vector>,
}

/// A rod at some positions.
#[derive(Debug, Clone, Copy, Default)]
struct Span {
    /// Vector Δ along the rod.
    delta: Vector,
    /// Arm ρ at either end.
    arms: [Vector; 2],
}

#[derive(Debug, Clone, Copy)]
struct RodGeometry {
    squares: [usize; 2],
    /// The corners at θ = 0, from the centres.
    corners: [Vector; 2],
    /// Vector from the second square to its periodic image.
    shift: Vector,
    /// Image and cell of a rod that crosses the edges of a flexible cell.
    crossing: Option<Crossing>,
    length: f64,
}

/// A rod across the edges of a flexible cell.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    /// The image n of the second square.
    image: Vector,
    /// The first of the coordinates of the cell.
    place: usize,
}

/// The product of two blocks of J that share a square.
#[derive(Debug, Clone, Copy)]
struct Product {
    entry: u32,
    square: u32,
    blocks: [u32; 2],
}

/// The product of the entries of two rods for the cell.
#[derive(Debug, Clone, Copy)]
struct CellProduct {
    entry: u32,
    rods: [u32; 2],
}

impl Crossing {
    /// The cell, or its rate, among the coordinates or velocities.
    fn cell(&self, coordinates: &[f64]) -> Cell {
        let place = self.place;
        Cell {
            xx: coordinates[place],
            yy: coordinates[place + 1],
            xy: coordinates[place + 2],
        }
    }

    /// ∂σ/∂H of a rod with this row.
    fn row(&self, row: &[[f64; 3]; 2]) -> [f64; 3] {
        // The second square has the sign of H n.
        cell_gradient([row[1][0], row[1][1]], self.image)
    }
}

impl RodGeometry {
    fn new(network: &Network, rod: &Rod) -> Self {
        let image = rod.image.map(f64::from);
        let crosses = |place| (rod.image != [0, 0]).then_some(Crossing { image, place });
        Self {
            squares: [rod.from.square, rod.to.square],
            corners: [
                corner_at_rest(network, rod.from),
                corner_at_rest(network, rod.to),
            ],
            shift: Cell::coherent(network).shift(image),
            crossing: network.cell_place().and_then(crosses),
            length: rod.length,
        }
    }

    /// The rod at these positions, where squares are turned by the angles of these cosines and
    /// sines.
    #[inline(always)]
    fn span(&self, positions: &[f64], turned_by: &[Vector]) -> Span {
        let [p, q] = self.squares;
        let a = turned(self.corners[0], turned_by[p]);
        let b = turned(self.corners[1], turned_by[q]);
        let (p, q) = (3 * p, 3 * q);
        let x = (positions[p] - positions[q] - self.shift[0]) + (a[0] - b[0]);
        let y = (positions[p + 1] - positions[q + 1] - self.shift[1]) + (a[1] - b[1]);
        Span {
            delta: [x, y],
            arms: [a, b],
        }
    }

    /// Rate Δ̇ of the vector along the rod.
    #[inline(always)]
    fn span_rate(&self, [a, b]: &[Vector; 2], velocities: &[f64]) -> Vector {
        let (p, q) = (3 * self.squares[0], 3 * self.squares[1]);
        // v + ω × ρ of both ends, and their difference.
        let (wp, wq) = (velocities[p + 2], velocities[q + 2]);
        let rate = [
            velocities[p] - velocities[q] - wp * a[1] + wq * b[1],
            velocities[p + 1] - velocities[q + 1] + wp * a[0] - wq * b[0],
        ];
        match self.crossing {
            Some(crossing) => minus(rate, crossing.cell(velocities).shift(crossing.image)),
            None => rate,
        }
    }
}

fn corner_at_rest(network: &Network, corner: Corner) -> Vector {
    let half_diagonal = network.squares[corner.square].half_diagonal;
    corner.direction().map(|x| x * half_diagonal)
}

impl RodSystem {
    /// Prepares the rods of a network. The order of elimination follows from where squares are in
    /// the lattice, not from a state, so that a run resumed elsewhere gives the same bits.
    pub fn new(network: &Network) -> Self {
        let squares = network.squares.len();
        let mut rods = Vec::with_capacity(network.rods.len());
        let mut places = Vec::with_capacity(network.rods.len());
        for rod in &network.rods {
            rods.push(RodGeometry::new(network, rod));
            places.push(place_in_lattice(network, rod));
        }
        let mut blocks = blocks_at_squares(&rods, squares);
        blocks.push(first_blocks_across_edges(&rods));
        let (entries, mut products) = gram_pattern(&blocks);
        let cell_products = split_off_cell(&mut products, squares);
        let mut inverse_mass = Vec::with_capacity(squares);
        for square in &network.squares {
            inverse_mass.push([1.0 / square.mass, 1.0 / square.inertia]);
        }
        Self {
            rows: vec![[[0.0; 3]; 2]; rods.len()],
            numbers: vec![0.0; entries.len()],
            factor: LdlFactor::new(rods.len(), &entries, &places),
            // NaN equals nothing, so the first look at any positions computes them.
            last_positions: vec![f64::NAN; network.coordinates()],
            spans: vec![Span::default(); rods.len()],
            directions: vec![[0.0; 2]; squares],
            rods,
            inverse_mass,
            products,
            cell_products,
            inverse_cell_mass: network.cell_mass.map_or(0.0, f64::recip),
        }
    }

    /// Number of rods.
    pub fn len(&self) -> usize {
        self.rods.len()
    }

    /// Whether there are no rods.
    pub fn is_empty(&self) -> bool {
        self.rods.is_empty()
    }

    /// Brings the rods up to date, unless the positions are those seen last: a step is linearised
    /// where its last correction ended.
    fn look_at(&mut self, positions: &[f64]) {
        if self.last_positions == positions {
            return;
        }
        self.last_positions.copy_from_slice(positions);
        // One sine and cosine per square, not one per end of a rod.
        for (unit_vector, angle) in self.directions.iter_mut().zip(angles(positions)) {
            *unit_vector = direction(angle);
        }
        for (rod, span) in self.rods.iter_mut().zip(&mut self.spans) {
            if let Some(crossing) = rod.crossing {
                rod.shift = crossing.cell(positions).shift(crossing.image);
            }
            *span = rod.span(positions, &self.directions);
        }
    }

    /// σ of every rod at these positions. Returns the rod farthest from its length and its σ, which
    /// is |Δ| - r0 to first order.
    pub fn violations(&mut self, positions: &[f64], sigma: &mut [f64]) -> (usize, f64) {
        self.look_at(positions);
        let mut worst = (0, 0.0_f64);
        let rods = self.rods.iter().zip(&self.spans);
        for (index, ((rod, span), sigma)) in rods.zip(sigma).enumerate() {
            let [x, y] = span.delta;
            // ½ (|Δ|²/r0 - r0): no root, and smooth where rods are nearly right.
            *sigma = (x * x + y * y - rod.length * rod.length) / (2.0 * rod.length);
            // Nothing compares as larger than a NaN: it stays the worst.
            if sigma.is_nan() || sigma.abs() > worst.1.abs() {
                worst = (index, *sigma);
            }
        }
        worst
    }

    /// Computes J and A at these positions and factors A. `time` is for messages.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] names the rod that depends on others,
    /// [`CrystalError::NotFinite`] the square.
    pub fn linearize(&mut self, positions: &[f64], time: f64) -> Result<()> {
        self.look_at(positions);
        for ((rod, span), row) in self.rods.iter().zip(&self.spans).zip(&mut self.rows) {
            let [x, y] = span.delta;
            let (ux, uy) = (x / rod.length, y / rod.length);
            let [a, b] = span.arms;
            // u · Gρ at either end, with Gρ = (-ρ_y, ρ_x).
            let (from, to) = (uy * a[0] - ux * a[1], uy * b[0] - ux * b[1]);
            *row = [[ux, uy, from], [-ux, -uy, -to]];
        }
        self.numbers.fill(0.0);
        let blocks = self.rows.as_flattened();
        // Each product adds to one entry of A; the list was made once from the network.
        for product in &self.products {
            let [first, second] = product.blocks;
            let (a, b) = (&blocks[first as usize], &blocks[second as usize]);
            let [per_mass, per_inertia] = self.inverse_mass[product.square as usize];
            self.numbers[product.entry as usize] +=
                (a[0] * b[0] + a[1] * b[1]) * per_mass + a[2] * b[2] * per_inertia;
        }
        let rods = &self.rods;
        for product in &self.cell_products {
            let [first, second] = product.rods.map(|rod| {
                let row = &self.rows[rod as usize];
                let crossing = rods[rod as usize].crossing;
                crossing.map_or([0.0; 3], |crossing| crossing.row(row))
            });
            self.numbers[product.entry as usize] += dot3(&first, &second) * self.inverse_cell_mass;
        }
        self.factor
            .factor(&self.numbers)
            .map_err(|error| match error {
                SparseError::Dependent { row, .. } => {
                    CrystalError::OverConstrained { rod: row, time }
                }
                SparseError::NotFinite { row } => CrystalError::NotFinite {
                    square: rods[row].squares[0],
                    time,
                },
                other => CrystalError::BadNetwork(other.to_string()),
            })
    }

    /// Replaces b by A⁻¹ b.
    pub fn solve(&mut self, b: &mut [f64]) {
        self.factor.solve(b);
    }

    /// ln det A, for the metric correction of stiff rods.
    pub fn log_determinant(&self) -> f64 {
        self.factor.log_determinant()
    }

    /// The factors of A.
    pub fn factor(&self) -> &LdlFactor {
        &self.factor
    }

    /// Writes J x into `out`, for a vector x over the coordinates.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) {
        for ((rod, row), out) in self.rods.iter().zip(&self.rows).zip(out) {
            let [p, q] = rod.squares;
            *out = dot3(&row[0], &x[3 * p..3 * p + 3]) + dot3(&row[1], &x[3 * q..3 * q + 3]);
            if let Some(crossing) = rod.crossing {
                *out += dot3(&crossing.row(row), &x[crossing.place..crossing.place + 3]);
            }
        }
    }

    /// target += scale · M⁻¹ Jᵀ λ.
    pub fn add_response(&self, multipliers: &[f64], scale: f64, target: &mut [f64]) {
        for ((rod, row), multiplier) in self.rods.iter().zip(&self.rows).zip(multipliers) {
            let force = scale * multiplier;
            for (square, j) in rod.squares.iter().zip(row) {
                // Scattered to the two squares of a rod: J is never transposed.
                let [per_mass, per_inertia] = self.inverse_mass[*square];
                let target = &mut target[3 * square..3 * square + 3];
                target[0] += force * per_mass * j[0];
                target[1] += force * per_mass * j[1];
                target[2] += force * per_inertia * j[2];
            }
            if let Some(crossing) = rod.crossing {
                let force = force * self.inverse_cell_mass;
                let target = &mut target[crossing.place..crossing.place + 3];
                for (target, j) in target.iter_mut().zip(crossing.row(row)) {
                    *target += force * j;
                }
            }
        }
    }

    /// The right-hand side of the equation for the multipliers (eq. 23 of the paper): what is left
    /// of σ̈ = 0 without the rods' own forces, -(J a) - |Δ̇|²/r0 + u · (ω² ρ - ω'² ρ'). Positions
    /// must be those of the last [`linearize`](RodSystem::linearize).
    pub fn acceleration_deficit(&self, velocities: &[f64], accelerations: &[f64], out: &mut [f64]) {
        let rods = self.rods.iter().zip(&self.spans).zip(&self.rows);
        for (((rod, Span { arms, .. }), row), out) in rods.zip(out) {
            let (p, q) = (3 * rod.squares[0], 3 * rod.squares[1]);
            let (wp, wq) = (velocities[p + 2], velocities[q + 2]);
            let [vx, vy] = rod.span_rate(arms, velocities);
            let u = [row[0][0], row[0][1]];
            // -J a, the centripetal terms of the arms, and that of the turning rod.
            let mut of_forces =
                dot3(&row[0], &accelerations[p..p + 3]) + dot3(&row[1], &accelerations[q..q + 3]);
            if let Some(crossing) = rod.crossing {
                let of_cell = &accelerations[crossing.place..crossing.place + 3];
                of_forces += dot3(&crossing.row(row), of_cell);
            }
            *out = -of_forces - (vx * vx + vy * vy) / rod.length + wp * wp * dot(u, arms[0])
                - wq * wq * dot(u, arms[1]);
        }
    }

    /// The largest speed at which the ends of a rod pass each other, over its length, 1/time: rods
    /// turn this fast.
    pub fn largest_turning_rate(&mut self, positions: &[f64], velocities: &[f64]) -> f64 {
        self.look_at(positions);
        let mut largest = 0.0_f64;
        for (rod, span) in self.rods.iter().zip(&self.spans) {
            let rate = rod.span_rate(&span.arms, velocities);
            largest = largest.max(norm(rate) / rod.length);
        }
        largest
    }
}

#[inline(always)]
fn dot3(a: &[f64; 3], b: &[f64]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The middle of a rod in the lattice, columns along x and rows against y; of a rod that leads to a
/// periodic image, the middle of the way there.
fn place_in_lattice(network: &Network, rod: &Rod) -> [f64; 3] {
    let columns = network.columns;
    // By rows and columns of the lattice, not by positions: the same order in every run.
    let [[x, y], [to_x, to_y]] = [rod.from.square, rod.to.square]
        .map(|square| [(square % columns) as f64, (square / columns) as f64]);
    let [around_x, around_y] = rod.image.map(f64::from);
    let to_x = to_x + around_x * columns as f64;
    let to_y = to_y - around_y * network.rows as f64;
    [0.5 * (x + to_x), 0.5 * (y + to_y), 0.0]
}

/// The blocks of J at every square, in order of the rods. A block is numbered 2 · rod + end.
fn blocks_at_squares(rods: &[RodGeometry], squares: usize) -> Vec<Vec<u32>> {
    let mut at_squares = vec![Vec::new(); squares];
    for (index, rod) in rods.iter().enumerate() {
        for (end, square) in rod.squares.iter().enumerate() {
            at_squares[*square].push((2 * index + end) as u32);
        }
    }
    at_squares
}

/// One block of every rod that hangs on the flexible cell.
fn first_blocks_across_edges(rods: &[RodGeometry]) -> Vec<u32> {
    let mut blocks = Vec::new();
    for (index, rod) in rods.iter().enumerate() {
        if rod.crossing.is_some() {
            blocks.push(2 * index as u32);
        }
    }
    blocks
}

/// Takes out the products of the cell, which comes after the last square.
fn split_off_cell(products: &mut Vec<Product>, squares: usize) -> Vec<CellProduct> {
    let mut cell_products = Vec::new();
    products.retain(|product| {
        let is_cell = product.square as usize == squares;
        if is_cell {
            cell_products.push(CellProduct {
                entry: product.entry,
                rods: product.blocks.map(|block| block / 2),
            });
        }
        !is_cell
    });
    cell_products
}

/// The places of A's lower triangle, and which products of blocks of J add up to each.
fn gram_pattern(at_squares: &[Vec<u32>]) -> (Vec<(usize, usize)>, Vec<Product>) {
    let rod_of = |block: u32| block as usize / 2;
    let mut terms = Vec::new();
    for (square, blocks) in at_squares.iter().enumerate() {
        for first in blocks {
            // A rod that meets itself at one square (around a periodic cell) counts both crossed
            // products.
            for second in blocks
                .iter()
                .filter(|second| rod_of(**second) <= rod_of(*first))
            {
                let place = (rod_of(*first), rod_of(*second));
                terms.push((place, [*first, *second], square as u32));
            }
        }
    }
    // Products of one entry follow each other: sums have one order, and entries ascend.
    terms.sort_unstable();
    let mut entries: Vec<(usize, usize)> = Vec::new();
    let mut products = Vec::with_capacity(terms.len());
    for (place, blocks, square) in terms {
        if entries.last() != Some(&place) {
            entries.push(place);
        }
        products.push(Product {
            entry: (entries.len() - 1) as u32,
            square,
            blocks,
        });
    }
    (entries, products)
}
