//! From 0 at 0 to 1 at 1 with two continuous derivatives: 10 x³ - 15 x⁴ + 6 x⁵.

/// Value of the step; 0 below 0 and 1 above 1.
pub(crate) fn step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

/// Derivative of the step.
pub(crate) fn step_slope(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    30.0 * (x * (1.0 - x)).powi(2)
}
