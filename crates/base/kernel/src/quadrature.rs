//! Rules of quadrature on (-1, 1), ∫ f(x) dx ≈ Σ wᵢ f(xᵢ), and points of equal weight on the sphere.

use crate::Vec3;
use std::f64::consts::PI;

/// A place between -1 and 1, with the weight of the value there.
///
/// ```
/// use protomer_kernel::quadrature::gauss_legendre;
/// let midpoint = gauss_legendre(1)[0];
/// assert!(midpoint.place.abs() < 1e-15 && (midpoint.weight - 2.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// The place xᵢ.
    pub place: f64,
    /// The weight wᵢ.
    pub weight: f64,
}

/// The Gauss-Legendre rule of n nodes, in rising order; exact for polynomials up to the degree 2n - 1.
///
/// The nodes are the zeros of the Legendre polynomial Pₙ, by Newton's method; their weights are
/// wᵢ = 2/((1 - xᵢ²) Pₙ'(xᵢ)²).
///
/// ```
/// use protomer_kernel::quadrature::gauss_legendre;
/// let fourth_powers = gauss_legendre(3).into_iter().map(|node| node.weight * node.place.powi(4));
/// assert!((fourth_powers.sum::<f64>() - 0.4).abs() < 1e-14);
/// ```
pub fn gauss_legendre(count: usize) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(count);
    for number in 0..count {
        let mut x = -(PI * (number as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut before, mut value) = (1.0, x);
            for order in 2..=count {
                let n = order as f64;
                (before, value) = (
                    value,
                    ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n,
                );
            }
            slope = count as f64 * (x * value - before) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        nodes.push(Node {
            place: x,
            weight: 2.0 / ((1.0 - x * x) * slope * slope),
        });
    }
    nodes
}

/// Nodes in the right half of the Gauss-Legendre rule of ten, from the middle outwards.
pub(crate) const GAUSS_TEN: [Node; 5] = [
    Node {
        place: 0.148_874_338_981_631_22,
        weight: 0.295_524_224_714_752_87,
    },
    Node {
        place: 0.433_395_394_129_247_2,
        weight: 0.269_266_719_309_996_35,
    },
    Node {
        place: 0.679_409_568_299_024_4,
        weight: 0.219_086_362_515_982_04,
    },
    Node {
        place: 0.865_063_366_688_984_5,
        weight: 0.149_451_349_150_580_6,
    },
    Node {
        place: 0.973_906_528_517_171_7,
        weight: 0.066_671_344_308_688_14,
    },
];

/// Points on the unit sphere, spread evenly along a spiral from z = 1 down to z = -1 (Fibonacci grid;
/// Swinbank and Purser, Q. J. R. Meteorol. Soc. 132, 1769 (2006)).
///
/// Point i of N lies in the middle of its layer, zᵢ = 1 - (2i + 1)/N, and is turned by the golden angle
/// π (3 - √5) against the one before.
///
/// ```
/// use protomer_kernel::quadrature::points_on_sphere;
/// let squares = points_on_sphere(1000).map(|point| point.x * point.x);
/// assert!((squares.sum::<f64>() / 1000.0 - 1.0 / 3.0).abs() < 1e-3);
/// ```
#[inline]
pub fn points_on_sphere(count: usize) -> impl Iterator<Item = Vec3> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |number| {
        let z = 1.0 - (2 * number + 1) as f64 / count as f64;
        let axis_distance = (1.0 - z * z).sqrt();
        let (sine, cosine) = (golden_angle * number as f64).sin_cos();
        Vec3::new(axis_distance * cosine, axis_distance * sine, z)
    })
}

/// Nodes of the Gauss-Kronrod rule.
pub const KRONROD_NODES: usize = 21;

/// A node of the Gauss-Kronrod rule, with its weight and that in the Gauss rule of ten of them. The
/// difference of the two rules tells how far either can be off.
///
/// ```
/// use protomer_kernel::quadrature::gauss_kronrod;
/// let middle = gauss_kronrod()[10];
/// assert_eq!((middle.place, middle.gauss_weight), (0.0, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KronrodNode {
    /// The place xᵢ.
    pub place: f64,
    /// The weight wᵢ.
    pub weight: f64,
    /// The weight in the Gauss rule; zero where that has no node.
    pub gauss_weight: f64,
}

/// The rule of Kronrod, Nodes and Weights of Quadrature Formulas (1965), as Piessens et al., QUADPACK
/// (1983), print it: places and weights.
const PLACES_AND_WEIGHTS: [(f64, f64); 11] = [
    (0.995_657_163_025_808_1, 0.011_694_638_867_371_874),
    (0.973_906_528_517_171_7, 0.032_558_162_307_964_725),
    (0.930_157_491_355_708_2, 0.054_755_896_574_351_995),
    (0.865_063_366_688_984_5, 0.075_039_674_810_919_96),
    (0.780_817_726_586_416_9, 0.093_125_454_583_697_6),
    (0.679_409_568_299_024_4, 0.109_387_158_802_297_64),
    (0.562_757_134_668_604_7, 0.123_491_976_262_065_84),
    (0.433_395_394_129_247_2, 0.134_709_217_311_473_34),
    (0.294_392_862_701_460_2, 0.142_775_938_577_060_09),
    (0.148_874_338_981_631_22, 0.147_739_104_901_338_49),
    (0.0, 0.149_445_554_002_916_9),
];

/// The Gauss-Kronrod rule, in rising order. Every second node is one of the Gauss rule.
///
/// ```
/// use protomer_kernel::quadrature::gauss_kronrod;
/// let [mut fine, mut coarse] = [0.0; 2];
/// for node in gauss_kronrod() {
///     fine += node.weight * node.place.exp();
///     coarse += node.gauss_weight * node.place.exp();
/// }
/// let exact = 1_f64.exp() - (-1_f64).exp();
/// assert!((fine - exact).abs() < 1e-14 && (coarse - exact).abs() < 1e-14);
/// ```
pub fn gauss_kronrod() -> [KronrodNode; KRONROD_NODES] {
    const MIDDLE: usize = KRONROD_NODES / 2;
    std::array::from_fn(|number| {
        let row = number.min(KRONROD_NODES - 1 - number);
        let (place, weight) = PLACES_AND_WEIGHTS[row];
        KronrodNode {
            place: if number < MIDDLE { -place } else { place },
            weight,
            gauss_weight: if row % 2 == 1 {
                GAUSS_TEN[GAUSS_TEN.len() - 1 - row / 2].weight
            } else {
                0.0
            },
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral of x^n over (-1, 1).
    fn exact(power: i32) -> f64 {
        if power % 2 == 1 {
            0.0
        } else {
            2.0 / f64::from(power + 1)
        }
    }

    #[test]
    fn rules_are_exact_for_polynomials_of_their_degree() {
        let nodes = gauss_legendre(20);
        for power in 0..40 {
            let terms = nodes.iter();
            let sum: f64 = terms.map(|node| node.weight * node.place.powi(power)).sum();
            assert!((sum - exact(power)).abs() < 1e-13, "{power}: {sum}");
        }
        let rule = gauss_kronrod();
        assert!(rule.is_sorted_by(|a, b| a.place < b.place));
        let sum = |power: i32, weight: fn(&KronrodNode) -> f64| -> f64 {
            let terms = rule.iter();
            terms
                .map(|node| weight(node) * node.place.powi(power))
                .sum()
        };
        for power in 0..32 {
            let found = sum(power, |node| node.weight);
            assert!((found - exact(power)).abs() < 1e-14, "{power}: {found}");
        }
        for power in 0..20 {
            let found = sum(power, |node| node.gauss_weight);
            assert!((found - exact(power)).abs() < 1e-14, "{power}: {found}");
        }
        assert!((sum(34, |node| node.weight) - exact(34)).abs() > 1e-14);
        assert!((sum(20, |node| node.gauss_weight) - exact(20)).abs() > 1e-12);
    }
    #[test]
    fn the_rule_of_ten_is_half_of_that_by_newton() {
        let nodes = gauss_legendre(10);
        for (node, printed) in nodes[5..].iter().zip(GAUSS_TEN) {
            assert!((node.place - printed.place).abs() < 1e-15);
            assert!((node.weight - printed.weight).abs() < 1e-14);
        }
        let gauss = gauss_kronrod()
            .into_iter()
            .filter(|node| node.gauss_weight > 0.0);
        for (node, printed) in gauss.skip(5).zip(GAUSS_TEN) {
            assert_eq!(
                (node.place, node.gauss_weight),
                (printed.place, printed.weight)
            );
        }
    }
}
