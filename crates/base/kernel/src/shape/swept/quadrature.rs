//! The integral of a function that is smooth but for kinks.

use crate::quadrature::GAUSS_TEN;

/// Largest number of panels; a kink needs about one per digit of the result.
const MOST_PANELS: usize = 4000;

/// A part of the range.
#[derive(Debug, Clone, Copy)]
struct Panel {
    from: f64,
    to: f64,
    /// Integrals by the rule on the two halves.
    halves: [f64; 2],
    /// Difference between the rule on the whole panel and that on its halves.
    difference: f64,
}

/// The Gauss-Legendre rule of ten nodes.
fn rule(function: &mut impl FnMut(f64) -> f64, from: f64, to: f64) -> f64 {
    let (centre, half) = (f64::midpoint(from, to), 0.5 * (to - from));
    let mut sum = 0.0;
    for node in GAUSS_TEN {
        let offset = half * node.place;
        sum += node.weight * (function(centre - offset) + function(centre + offset));
    }
    half * sum
}

impl Panel {
    fn new(function: &mut impl FnMut(f64) -> f64, from: f64, to: f64, whole: f64) -> Self {
        let middle = f64::midpoint(from, to);
        let halves = [rule(function, from, middle), rule(function, middle, to)];
        Self {
            from,
            to,
            halves,
            difference: (halves[0] + halves[1] - whole).abs(),
        }
    }
}

/// The integral over a range, which is divided at these places first. Where the rule on a panel and on
/// its halves differ most, the panel is divided, until the differences add up to less than a part of the
/// integral.
pub(super) fn integral(mut function: impl FnMut(f64) -> f64, places: &[f64], accuracy: f64) -> f64 {
    let mut panels = Vec::new();
    for pair in places.windows(2) {
        // Each half is judged against the rule on the whole;
        // halves are kept as the wholes of the next level.
        let whole = rule(&mut function, pair[0], pair[1]);
        panels.push(Panel::new(&mut function, pair[0], pair[1], whole));
    }
    loop {
        // Sums are formed afresh every time: a running sum
        // would gather rounding over thousands of panels.
        let (mut sum, mut doubt, mut worst) = (0.0, 0.0, 0);
        for (number, panel) in panels.iter().enumerate() {
            sum += panel.halves[0] + panel.halves[1];
            doubt += panel.difference;
            if panel.difference > panels[worst].difference {
                worst = number;
            }
        }
        // The differences exceed the errors by far for
        // smooth functions, so this is on the safe side.
        if doubt <= accuracy * f64::abs(sum) || panels.len() >= MOST_PANELS {
            return sum;
        }
        let panel = panels.swap_remove(worst);
        let middle = f64::midpoint(panel.from, panel.to);
        panels.push(Panel::new(
            &mut function,
            panel.from,
            middle,
            panel.halves[0],
        ));
        panels.push(Panel::new(&mut function, middle, panel.to, panel.halves[1]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_functions_and_kinks() {
        let exponential = integral(f64::exp, &[0.0, 1.0], 1e-12);
        assert!((exponential - (1.0_f64.exp() - 1.0)).abs() < 1e-14);
        // A polynomial of degree 19 is exact without a division.
        let mut calls = 0;
        let power = |x: f64| {
            calls += 1;
            x.powi(19)
        };
        assert!((integral(power, &[0.0, 2.0], 1e-13) - 2.0_f64.powi(20) / 20.0).abs() < 1e-8);
        assert_eq!(calls, 30);
        let kink = integral(|x: f64| (x - 0.3).abs(), &[0.0, 1.0], 1e-11);
        assert!((kink - 0.29).abs() < 1e-11, "{kink}");
        let jump = integral(|x| f64::from(u8::from(x > 0.7)), &[0.0, 0.5, 1.0], 1e-9);
        assert!((jump - 0.3).abs() < 1e-9, "{jump}");
    }
}
