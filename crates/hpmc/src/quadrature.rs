//! Rules of quadrature on (-1, 1).

use std::f64::consts::PI;

/// Nodes and weights of the Gauss-Legendre rule, the zeros of the Legendre polynomial by Newton's
/// method.
pub(crate) fn gauss_legendre(count: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut nodes, mut weights) = (Vec::new(), Vec::new());
    for number in 0..count {
        let mut x = -(PI * (number as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
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
        nodes.push(x);
        weights.push(2.0 / ((1.0 - x * x) * slope * slope));
    }
    (nodes, weights)
}

/// Nodes of the Gauss-Kronrod rule.
pub(crate) const KRONROD_NODES: usize = 21;

/// A node of the Gauss-Kronrod rule, with its weight and that in the Gauss rule of ten of them. The
/// difference of the two rules tells how far either can be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KronrodNode {
    pub place: f64,
    pub weight: f64,
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

/// Weights of the Gauss rule at every second of these nodes, from the second on.
const GAUSS_WEIGHTS: [f64; 5] = [
    0.066_671_344_308_688_14,
    0.149_451_349_150_580_6,
    0.219_086_362_515_982_04,
    0.269_266_719_309_996_35,
    0.295_524_224_714_752_87,
];

/// The nodes in rising order.
pub(crate) fn gauss_kronrod() -> [KronrodNode; KRONROD_NODES] {
    const MIDDLE: usize = KRONROD_NODES / 2;
    std::array::from_fn(|number| {
        let row = number.min(KRONROD_NODES - 1 - number);
        let (place, weight) = PLACES_AND_WEIGHTS[row];
        KronrodNode {
            place: if number < MIDDLE { -place } else { place },
            weight,
            gauss_weight: if row % 2 == 1 {
                GAUSS_WEIGHTS[row / 2]
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
        let (nodes, weights) = gauss_legendre(20);
        for power in 0..40 {
            let terms = nodes.iter().zip(&weights);
            let sum: f64 = terms.map(|(x, weight)| weight * x.powi(power)).sum();
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
}
