//! The rods as constraints.
//!
//! With Δ = r(from) - r(to) and u = Δ/r0, a rod demands σ = (|Δ|² - r0²) / (2 r0) = 0. Its row of
//! the Jacobian J holds, for the square at either end (sign + and -),
//!
//! ∂σ/∂(x, y, θ) = ± (u_x, u_y, u · G ρ), G ρ = (-ρ_y, ρ_x),
//!
//! where ρ leads from the centre to the corner. Multipliers λ are forces along the rods (positive
//! pushes the ends apart), the accelerations they give are M⁻¹ Jᵀ λ, and A = J M⁻¹ Jᵀ couples rods
//! that share a square.

use super::network::{Network, corner_direction};
use protomer_kernel::sparse::{LdlFactor, SparseError};

/// The rods of a network with what changes from state to state: their rows of J, and A factored.
#[derive(Debug, Clone)]
pub struct RodSystem {
    rods: Vec<RodGeometry>,
    /// Reciprocal mass and inertia per square.
    inverse_mass: Vec<[f64; 2]>,
    /// Blocks of J: for each rod the three numbers of either end.
    rows: Vec<[[f64; 3]; 2]>,
    /// Where products of blocks add up to entries of A.
    products: Vec<Product>,
    numbers: Vec<f64>,
    factor: LdlFactor,
    /// cos θ and sin θ per square at the positions last seen.
    turned: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, Copy)]
struct RodGeometry {
    squares: [usize; 2],
    /// The corners at θ = 0, from the centres.
    corners: [[f64; 2]; 2],
    /// From the second square to its periodic image.
    shift: [f64; 2],
    length: f64,
}

#[derive(Debug, Clone, Copy)]
struct Product {
    entry: u32,
    rods: [u32; 2],
    ends: [u8; 2],
}

impl RodSystem {
    /// Prepares the rods of a network. The order of elimination follows from where squares are in
    /// the lattice, not from a state, so that a run resumed elsewhere gives the same bits.
    pub fn new(network: &Network) -> Self {
        let cell = network.cell.unwrap_or([0.0; 2]);
        let rods: Vec<RodGeometry> = network
            .rods
            .iter()
            .map(|rod| {
                let corner = |corner: super::Corner| {
                    corner_direction(corner.vertex)
                        .map(|x| x * network.squares[corner.square].half_diagonal)
                };
                RodGeometry {
                    squares: [rod.from.square, rod.to.square],
                    corners: [corner(rod.from), corner(rod.to)],
                    shift: [
                        f64::from(rod.image[0]) * cell[0],
                        f64::from(rod.image[1]) * cell[1],
                    ],
                    length: rod.length,
                }
            })
            .collect();
        let (entries, products) = gram_pattern(&rods, network.squares.len());
        // Columns along x, rows against y; the middle of a rod on the way to the periodic image it
        // leads to.
        let place = |rod: &super::Rod| {
            let at = |square: usize| {
                [
                    (square % network.columns) as f64,
                    (square / network.columns) as f64,
                ]
            };
            let ([x, y], [to_x, to_y]) = (at(rod.from.square), at(rod.to.square));
            let [around_x, around_y] = rod.image.map(f64::from);
            let (to_x, to_y) = (
                to_x + around_x * network.columns as f64,
                to_y - around_y * network.rows as f64,
            );
            [0.5 * (x + to_x), 0.5 * (y + to_y), 0.0]
        };
        let places: Vec<[f64; 3]> = network.rods.iter().map(place).collect();
        let factor = LdlFactor::new(rods.len(), &entries, &places);
        Self {
            rows: vec![[[0.0; 3]; 2]; rods.len()],
            inverse_mass: network
                .squares
                .iter()
                .map(|square| [1.0 / square.mass, 1.0 / square.inertia])
                .collect(),
            numbers: vec![0.0; entries.len()],
            turned: vec![[0.0; 2]; network.squares.len()],
            rods,
            products,
            factor,
        }
    }

    /// Number of rods.
    pub fn len(&self) -> usize {
        self.rods.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rods.is_empty()
    }

    fn turn(&mut self, positions: &[f64]) {
        for (turned, s) in self.turned.iter_mut().zip(positions.chunks_exact(3)) {
            let (sine, cosine) = s[2].sin_cos();
            *turned = [cosine, sine];
        }
    }

    /// ρ: from the centre of the square at this end to the rod's corner.
    #[inline(always)]
    fn arm(&self, rod: &RodGeometry, end: usize) -> [f64; 2] {
        let ([x, y], [cosine, sine]) = (rod.corners[end], self.turned[rod.squares[end]]);
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    /// Δ, and ρ at either end, at the positions last given to `turn`.
    #[inline(always)]
    fn span(&self, rod: &RodGeometry, positions: &[f64]) -> ([f64; 2], [[f64; 2]; 2]) {
        let arms = [self.arm(rod, 0), self.arm(rod, 1)];
        let (p, q) = (3 * rod.squares[0], 3 * rod.squares[1]);
        let delta = |axis: usize| {
            (positions[p + axis] - positions[q + axis] - rod.shift[axis])
                + (arms[0][axis] - arms[1][axis])
        };
        ([delta(0), delta(1)], arms)
    }

    /// σ of every rod at these positions; returns the rod farthest from its length and |Δ| - r0
    /// there.
    pub fn violations(&mut self, positions: &[f64], sigma: &mut [f64]) -> (usize, f64) {
        self.turn(positions);
        let mut worst = (0, 0.0_f64);
        for (index, (rod, sigma)) in self.rods.iter().zip(sigma).enumerate() {
            let ([x, y], _) = self.span(rod, positions);
            *sigma = (x * x + y * y - rod.length * rod.length) / (2.0 * rod.length);
            // A NaN is the worst of all: nothing is larger.
            if sigma.is_nan() || sigma.abs() > worst.1.abs() {
                worst = (index, *sigma);
            }
        }
        worst
    }

    /// J and A at these positions, A factored.
    ///
    /// # Errors
    /// Names the rod that depends on others.
    pub fn linearize(&mut self, positions: &[f64]) -> Result<(), SparseError> {
        self.turn(positions);
        for index in 0..self.rods.len() {
            let rod = self.rods[index];
            let ([x, y], arms) = self.span(&rod, positions);
            let (ux, uy) = (x / rod.length, y / rod.length);
            let torque = |arm: [f64; 2]| uy * arm[0] - ux * arm[1];
            self.rows[index] = [[ux, uy, torque(arms[0])], [-ux, -uy, -torque(arms[1])]];
        }
        self.numbers.fill(0.0);
        for product in &self.products {
            let [first, second] = product.rods.map(|rod| rod as usize);
            let [end, other] = product.ends.map(usize::from);
            let (a, b) = (&self.rows[first][end], &self.rows[second][other]);
            let [per_mass, per_inertia] = self.inverse_mass[self.rods[first].squares[end]];
            self.numbers[product.entry as usize] +=
                (a[0] * b[0] + a[1] * b[1]) * per_mass + a[2] * b[2] * per_inertia;
        }
        self.factor.factor(&self.numbers)
    }

    /// Replaces b by A⁻¹ b.
    pub fn solve(&mut self, b: &mut [f64]) {
        self.factor.solve(b);
    }

    /// ln det A, for the metric correction of stiff rods.
    pub fn log_determinant(&self) -> f64 {
        self.factor.log_determinant()
    }

    /// A factored, for its size.
    pub fn factor(&self) -> &LdlFactor {
        &self.factor
    }

    /// J x for a vector over the squares.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) {
        for ((rod, row), out) in self.rods.iter().zip(&self.rows).zip(out) {
            *out = rod
                .squares
                .iter()
                .zip(row)
                .map(|(square, j)| dot3(j, &x[3 * square..3 * square + 3]))
                .sum();
        }
    }

    /// target += scale · M⁻¹ Jᵀ λ.
    pub fn add_response(&self, multipliers: &[f64], scale: f64, target: &mut [f64]) {
        for ((rod, row), multiplier) in self.rods.iter().zip(&self.rows).zip(multipliers) {
            let force = scale * multiplier;
            for (square, j) in rod.squares.iter().zip(row) {
                let [per_mass, per_inertia] = self.inverse_mass[*square];
                let target = &mut target[3 * square..3 * square + 3];
                target[0] += force * per_mass * j[0];
                target[1] += force * per_mass * j[1];
                target[2] += force * per_inertia * j[2];
            }
        }
    }

    /// The right-hand side of the equation for the multipliers (eq. 23 of the paper): what is left
    /// of σ̈ = 0 without the rods' own forces, -(J a) - |Δv|²/r0 + u · (ω² ρ - ω'² ρ'). Positions
    /// must be those of the last `linearize`.
    pub fn acceleration_deficit(&self, velocities: &[f64], accelerations: &[f64], out: &mut [f64]) {
        for ((rod, row), out) in self.rods.iter().zip(&self.rows).zip(out) {
            let (u, arms) = ([row[0][0], row[0][1]], [self.arm(rod, 0), self.arm(rod, 1)]);
            let (p, q) = (3 * rod.squares[0], 3 * rod.squares[1]);
            let (wp, wq) = (velocities[p + 2], velocities[q + 2]);
            let vx = velocities[p] - velocities[q] - wp * arms[0][1] + wq * arms[1][1];
            let vy = velocities[p + 1] - velocities[q + 1] + wp * arms[0][0] - wq * arms[1][0];
            let pull = |arm: [f64; 2]| u[0] * arm[0] + u[1] * arm[1];
            let free =
                dot3(&row[0], &accelerations[p..p + 3]) + dot3(&row[1], &accelerations[q..q + 3]);
            *out = -free - (vx * vx + vy * vy) / rod.length + wp * wp * pull(arms[0])
                - wq * wq * pull(arms[1]);
        }
    }

    /// The largest speed at which the ends of a rod pass each other, over its length, 1/time: rods
    /// turn this fast.
    pub fn largest_turning_rate(&mut self, positions: &[f64], velocities: &[f64]) -> f64 {
        self.turn(positions);
        let rate = |rod: &RodGeometry| {
            let arms = [self.arm(rod, 0), self.arm(rod, 1)];
            let (p, q) = (3 * rod.squares[0], 3 * rod.squares[1]);
            let (wp, wq) = (velocities[p + 2], velocities[q + 2]);
            let vx = velocities[p] - velocities[q] - wp * arms[0][1] + wq * arms[1][1];
            let vy = velocities[p + 1] - velocities[q + 1] + wp * arms[0][0] - wq * arms[1][0];
            vx.hypot(vy) / rod.length
        };
        self.rods.iter().map(rate).fold(0.0, f64::max)
    }
}

#[inline(always)]
fn dot3(a: &[f64; 3], b: &[f64]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The places of A's lower triangle, and which products of blocks of J add up to each.
fn gram_pattern(rods: &[RodGeometry], squares: usize) -> (Vec<(usize, usize)>, Vec<Product>) {
    let mut at_square: Vec<Vec<(usize, u8)>> = vec![Vec::new(); squares];
    for (index, rod) in rods.iter().enumerate() {
        at_square[rod.squares[0]].push((index, 0));
        at_square[rod.squares[1]].push((index, 1));
    }
    let mut terms = Vec::new();
    for meeting in &at_square {
        for &(row, end) in meeting {
            for &(column, other) in meeting.iter().filter(|(column, _)| *column <= row) {
                // A rod that meets itself at one square (around a periodic cell) counts both
                // crossed products.
                terms.push(((row, column), [end, other]));
            }
        }
    }
    terms.sort_unstable();
    let mut entries: Vec<(usize, usize)> = Vec::new();
    let mut products = Vec::with_capacity(terms.len());
    for (place, ends) in terms {
        if entries.last() != Some(&place) {
            entries.push(place);
        }
        let entry = (entries.len() - 1) as u32;
        products.push(Product {
            entry,
            rods: [place.0 as u32, place.1 as u32],
            ends,
        });
    }
    (entries, products)
}
