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

/// A node of the Gauss-Kronrod rule of 15 points, with its weight and that in the Gauss rule of seven
/// of them. The difference of the two rules tells how far either can be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KronrodNode {
    pub place: f64,
    pub weight: f64,
    pub gauss_weight: f64,
}

/// The rule of Kronrod, Nodes and Weights of Quadrature Formulas (1965), as Piessens et al., QUADPACK
/// (1983), print it: places, weights, weights of Gauss.
const POSITIVE: [[f64; 3]; 8] = [
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_22, 0.0],
    [
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_56,
        0.129_484_966_168_869_7,
    ],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_2, 0.0],
    [
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_9,
        0.279_705_391_489_276_7,
    ],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ],
    [0.207_784_955_007_898_5, 0.204_432_940_075_298_9, 0.0],
    [0.0, 0.209_482_141_084_727_8, 0.417_959_183_673_469_4],
];

/// The nodes in rising order.
pub(crate) fn gauss_kronrod() -> [KronrodNode; 15] {
    std::array::from_fn(|number| {
        let [place, weight, gauss_weight] = POSITIVE[number.min(14 - number)];
        let sign = if number < 7 { -1.0 } else { 1.0 };
        KronrodNode {
            place: sign * place,
            weight,
            gauss_weight,
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
        for power in 0..23 {
            let found = sum(power, |node| node.weight);
            assert!((found - exact(power)).abs() < 1e-14, "{power}: {found}");
        }
        for power in 0..14 {
            let found = sum(power, |node| node.gauss_weight);
            assert!((found - exact(power)).abs() < 1e-14, "{power}: {found}");
        }
        assert!((sum(24, |node| node.weight) - exact(24)).abs() > 1e-12);
    }
}
