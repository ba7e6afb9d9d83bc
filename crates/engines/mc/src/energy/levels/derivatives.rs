//! Derivatives of the coarse potential, for expansions.
//!
//! A lane stands for one order of differentiation in y and one in z, so that no sum runs across lanes:
//! all six pairs of orders come from one pass over the coefficients, and the orders in x last.

use super::field::{Field, Spots};
use super::lanes::BLOCK;
use super::packed::{COARSE, Head, LAST, Packed};
use protomer_kernel::fused::add;
use std::hint::black_box;

/// The potential at a place (kT/e) with its first and second derivatives (per Å and Å²).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Derivatives {
    pub value: f32,
    pub gradient: [f32; 3],
    /// Second derivatives by xx, yy, zz, xy, xz and yz.
    pub second: [f32; 6],
}

/// Six pairs of orders, and two lanes without use.
const LANES: usize = 8;
/// Orders of differentiation in y.
const IN_Y: [usize; LANES] = [0, 1, 2, 0, 1, 0, 0, 0];
/// Orders of differentiation in z.
const IN_Z: [usize; LANES] = [0, 0, 0, 1, 1, 2, 0, 0];

/// Values by order of differentiation in x.
type ByOrder = [[f32; LANES]; 3];

impl Field {
    /// The coarse potential at each spot with its derivatives; `None` in no cell.
    #[inline(always)]
    pub fn derivatives<const FUSED: bool>(&self, spots: &Spots) -> Option<[Derivatives; BLOCK]> {
        // Compilers take lanes apart whose constants are equal, or that are used one by one: the
        // functions are hidden from them, and whole lanes go to memory.
        let functions = black_box(&FUNCTIONS);
        let mut lanes: [ByOrder; BLOCK] = [[[0.0; LANES]; 3]; BLOCK];
        for point in 0..BLOCK {
            let series = self.coarse.get(spots.cell[point] as usize)?;
            lanes[point] = by_order::<FUSED>(series, functions, spots.place(point));
        }
        let mut derivatives = [Derivatives::default(); BLOCK];
        for point in 0..BLOCK {
            let cell = spots.cell[point] as usize;
            let (series, head) = (self.coarse.get(cell)?, self.heads.get(cell)?);
            let (place, edge) = (spots.place(point), spots.edge[point]);
            derivatives[point] = assemble(&lanes[point], series, head, place, edge);
        }
        Some(derivatives)
    }
}

#[inline(always)]
fn by_order<const FUSED: bool>(
    series: &Packed,
    [in_y, in_z]: &[Functions; 2],
    [x, y, z]: [f32; 3],
) -> ByOrder {
    let sums = in_y_and_z::<FUSED>(
        series,
        &in_y.evaluate::<FUSED>(y),
        &in_z.evaluate::<FUSED>(z),
    );
    in_x::<FUSED>(&sums, x)
}

/// For each order i the sum of c_ijk T_j(y) T_k(z), differentiated as the lane says.
#[inline(always)]
fn in_y_and_z<const FUSED: bool>(
    Packed(rows): &Packed,
    of_y: &[[f32; LANES]; COARSE],
    of_z: &[[f32; LANES]; COARSE],
) -> [[f32; LANES]; COARSE] {
    let mut coefficients = [[0.0; BLOCK]; COARSE];
    for k in 0..COARSE {
        for lane in 0..BLOCK {
            coefficients[k][lane] = f32::from(rows[k][lane]);
        }
        // That lane holds something else.
        // It holds the coefficients of T_4, which `assemble` adds.
        coefficients[k][LAST] = 0.0;
    }
    let mut sums = [[0.0; LANES]; COARSE];
    for j in 0..COARSE {
        for i in 0..COARSE {
            // The four orders in z of one product of x and y, for all lanes at once.
            let along_z = [0, 1, 2, 3].map(|k: usize| coefficients[k][COARSE * j + i]);
            for lane in 0..LANES {
                let mut sum = along_z[0] * of_z[0][lane];
                sum = add::<FUSED>(along_z[1], of_z[1][lane], sum);
                sum = add::<FUSED>(along_z[2], of_z[2][lane], sum);
                sum = add::<FUSED>(along_z[3], of_z[3][lane], sum);
                // The loop runs over j outside and i inside: one value of T_j(y) for four sums.
                sums[i][lane] = add::<FUSED>(sum, of_y[j][lane], sums[i][lane]);
            }
        }
    }
    sums
}

/// The sums over the orders i with T_i(x), its first and its second derivative.
#[inline(always)]
fn in_x<const FUSED: bool>(sums: &[[f32; LANES]; COARSE], x: f32) -> ByOrder {
    let mut by_order = [[0.0; LANES]; 3];
    for (of_x, total) in chebyshev_derivatives(x).iter().zip(&mut by_order) {
        for i in 0..COARSE {
            for lane in 0..LANES {
                total[lane] = add::<FUSED>(of_x[i], sums[i][lane], total[lane]);
            }
        }
    }
    by_order
}

/// Adds the first coefficient and those of T_4; from units and coordinates of the cell to kT/e and Å.
#[inline(always)]
fn assemble(
    [of_0, of_1, of_2]: &ByOrder,
    series: &Packed,
    head: &Head,
    place: [f32; 3],
    edge: f32,
) -> Derivatives {
    let mut value = of_0[0];
    // Lanes: (y, z) orders (0,0) (1,0) (2,0) (0,1) (1,1) (0,2), see `IN_Y` and `IN_Z`.
    let mut gradient = [of_1[0], of_0[1], of_0[3]];
    let mut second = [of_2[0], of_0[2], of_0[5], of_1[1], of_1[3], of_0[4]];
    for (axis, coefficient) in series.fourth().into_iter().enumerate() {
        let (coefficient, t, square) = (
            f32::from(coefficient),
            place[axis],
            place[axis] * place[axis],
        );
        // T_4 = 8t⁴ - 8t² + 1, its first and its second derivative.
        value += coefficient * (8.0 * square * (square - 1.0) + 1.0);
        gradient[axis] += coefficient * t * (32.0 * square - 16.0);
        second[axis] += coefficient * (96.0 * square - 16.0);
    }
    // Coordinates run from -1 to 1 over an edge, so d/dx is 2/edge times d/dt.
    let scale = 2.0 / edge;
    let (of_gradient, of_second) = (head.unit * scale, head.unit * (scale * scale));
    Derivatives {
        value: head.first + head.unit * value,
        gradient: gradient.map(|g| g * of_gradient),
        second: second.map(|h| h * of_second),
    }
}

/// T_0 to T_3 at t, their first and their second derivatives.
#[inline(always)]
fn chebyshev_derivatives(t: f32) -> [[f32; COARSE]; 3] {
    [
        [1.0, t, 2.0 * t * t - 1.0, t * (4.0 * t * t - 3.0)],
        [0.0, 1.0, 4.0 * t, 12.0 * t * t - 3.0],
        [0.0, 0.0, 4.0, 24.0 * t],
    ]
}

/// T_0 to T_3 of one coordinate, differentiated as each lane says: coefficients of t⁰ to t³.
struct Functions([[[f32; LANES]; 4]; COARSE]);

/// Coefficients of t⁰ to t³ of T_n, and of its first and its second derivative.
const POWERS: [[[f32; 4]; 3]; COARSE] = [
    [[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]],
    [[0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0; 4]],
    [
        [-1.0, 0.0, 2.0, 0.0],
        [0.0, 4.0, 0.0, 0.0],
        [4.0, 0.0, 0.0, 0.0],
    ],
    [
        [0.0, -3.0, 0.0, 4.0],
        [-3.0, 0.0, 12.0, 0.0],
        [0.0, 24.0, 0.0, 0.0],
    ],
];

static FUNCTIONS: [Functions; 2] = [Functions::from_orders(IN_Y), Functions::from_orders(IN_Z)];

impl Functions {
    const fn from_orders(orders: [usize; LANES]) -> Self {
        let mut lanes = [[[0.0; LANES]; 4]; COARSE];
        let mut place = 0;
        while place < COARSE * 4 * LANES {
            let (n, power, lane) = (place / (4 * LANES), place / LANES % 4, place % LANES);
            lanes[n][power][lane] = POWERS[n][orders[lane]][power];
            place += 1;
        }
        Self(lanes)
    }

    #[inline(always)]
    fn evaluate<const FUSED: bool>(&self, t: f32) -> [[f32; LANES]; COARSE] {
        let mut values = [[0.0; LANES]; COARSE];
        for n in 0..COARSE {
            for lane in 0..LANES {
                let coefficient = |power: usize| self.0[n][power][lane];
                // T_n has no higher power than t^n.
                values[n][lane] = match n {
                    0 => coefficient(0),
                    1 => add::<FUSED>(coefficient(1), t, coefficient(0)),
                    2 => add::<FUSED>(
                        add::<FUSED>(coefficient(2), t, coefficient(1)),
                        t,
                        coefficient(0),
                    ),
                    _ => {
                        let high = add::<FUSED>(
                            add::<FUSED>(coefficient(3), t, coefficient(2)),
                            t,
                            coefficient(1),
                        );
                        add::<FUSED>(high, t, coefficient(0))
                    }
                };
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::tests::{field, places};
    use super::BLOCK;

    #[test]
    fn derivatives_are_those_of_differences() {
        let field = field();
        let step = 0.01;
        let mut compared = 0;
        for place in places(400) {
            let shifted = |shift: [f32; 3]| {
                let moved = [0, 1, 2].map(|axis| place[axis] + step * shift[axis]);
                let spots = field.locate(&moved.map(|x| [x; BLOCK])).unwrap();
                (
                    spots.cell[7],
                    field.derivatives::<false>(&spots).unwrap()[7],
                )
            };
            let (cell, centre) = shifted([0.0; 3]);
            for axis in 0..3 {
                let mut shift = [0.0; 3];
                shift[axis] = 1.0;
                let (above_cell, above) = shifted(shift);
                let (below_cell, below) = shifted(shift.map(|x| -x));
                // Derivatives jump from cell to cell.
                if above_cell != cell || below_cell != cell {
                    continue;
                }
                compared += 1;
                let slope = (above.value - below.value) / (2.0 * step);
                let size = centre.gradient.map(f32::abs).iter().sum::<f32>() + 1e-3;
                assert!((slope - centre.gradient[axis]).abs() < 0.01 * size + 1e-3);
                let curvature = (above.gradient[axis] - below.gradient[axis]) / (2.0 * step);
                let size = centre.second.map(f32::abs).iter().sum::<f32>();
                assert!((curvature - centre.second[axis]).abs() < 0.01 * size + 1e-4);
                let mixed = |a: usize, b: usize| [[0, 3, 4], [3, 1, 5], [4, 5, 2]][a][b];
                let other = (axis + 1) % 3;
                let curvature = (above.gradient[other] - below.gradient[other]) / (2.0 * step);
                assert!((curvature - centre.second[mixed(axis, other)]).abs() < 0.01 * size + 1e-4);
            }
        }
        assert!(compared > 600, "{compared}");
    }
}
