//! What independent replicas say together.

/// The mean of independent values and its standard error.
pub(super) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let mut squares = 0.0;
    for value in values {
        squares += (value - mean).powi(2);
    }
    (mean, (squares / (count * (count - 1.0))).sqrt())
}
