//! Formatted numbers.

/// Several numbers with a fixed number of decimals.
pub(super) fn fixed(values: &[f64], decimals: usize) -> String {
    let texts: Vec<String> = values.iter().map(|x| rounded(*x, decimals)).collect();
    texts.join(", ")
}

/// A number with a fixed number of decimals; a value that rounds to zero has no sign.
pub(super) fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|byte| b"0.".contains(&byte)) => size.to_owned(),
        _ => text,
    }
}
