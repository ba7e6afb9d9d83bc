//! Numbers as a reader sees them: few digits, with errors.

/// A number with `digits` significant digits, without trailing zeros; a dash if it is not finite.
///
/// ```
/// use protomer_common::page::significant;
/// assert_eq!(significant(-12.345_678, 5), "−12.346");
/// assert_eq!(significant(f64::NAN, 5), "–");
/// ```
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() || value == 0.0 {
        return if value == 0.0 {
            "0".into()
        } else {
            "–".into()
        };
    }
    let magnitude = value.abs().log10().floor() as i32;
    let text = if (-4..9).contains(&magnitude) {
        let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    };
    let (number, exponent) = text
        .split_once('e')
        .map_or((text.as_str(), String::new()), |(n, e)| {
            (n, format!("e{e}"))
        });
    let number = if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    };
    format!("{number}{exponent}").replace('-', "−")
}

/// A number with `digits` significant digits, or a dash if it is unknown.
///
/// ```
/// use protomer_common::page::significant_or_dash;
/// assert_eq!(significant_or_dash(Some(3.14159), 3), "3.14");
/// assert_eq!(significant_or_dash(None, 3), "–");
/// ```
pub fn significant_or_dash(value: Option<f64>, digits: usize) -> String {
    match value {
        Some(value) => significant(value, digits),
        None => "–".to_owned(),
    }
}

/// A concentration (mol/L) in mmol/L.
///
/// ```
/// assert_eq!(protomer_common::page::millimolar(0.05), "50");
/// ```
pub fn millimolar(molar: f64) -> String {
    significant(1e3 * molar, 6)
}

/// A number with six significant digits, and its error, if it is known, with two.
///
/// ```
/// use protomer_common::page::with_error;
/// assert_eq!(with_error(1.25, Some(0.031)), "1.25 ± 0.031");
/// assert_eq!(with_error(1.25, None), "1.25");
/// ```
pub fn with_error(value: f64, error: Option<f64>) -> String {
    with_error_to(value, error, 6)
}

/// A number with `digits` significant digits, and its error, if it is known, with two.
///
/// ```
/// use protomer_common::page::with_error_to;
/// assert_eq!(with_error_to(1.23456, Some(0.0314), 3), "1.23 ± 0.031");
/// ```
pub fn with_error_to(value: f64, error: Option<f64>, digits: usize) -> String {
    let value = significant(value, digits);
    match error {
        Some(error) => format!("{value} ± {}", significant(error, 2)),
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let short = [
            (12.345_678, "12.346"),
            (-0.5, "−0.5"),
            (0.0, "0"),
            (1.0e-7, "1e−7"),
            (123_456.7, "123457"),
        ];
        for (value, text) in short {
            assert_eq!(significant(value, 5), text);
        }
        assert_eq!(significant(f64::NAN, 3), "–");
    }
}
