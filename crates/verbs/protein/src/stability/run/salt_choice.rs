//! One salt concentration of a run, chosen by the digits that a table or a page shows of it.

use super::salt_label;
use anyhow::{Result, bail};
use protomer_common::page::millimolar;
use std::path::Path;

/// Decimals of a number in mmol/L that are told apart.
const MOST_DECIMALS: i32 = 6;

/// The salt of a directory (mol/L) that another number means: the same to 1 µM, or the only one that
/// rounds to its decimals in mmol/L. A table shows 94.868 mM as 94.9, and 94.9 finds it.
///
/// # Errors
/// If none or several salts of the directory round to the number; it lists them.
///
/// ```
/// use protomer_protein_verbs::stability::run::chosen_salt;
/// let salts = [0.03, 0.094868, 0.3];
/// assert_eq!(chosen_salt("stability".as_ref(), 0.0949, &salts)?, 0.094868);
/// let error = chosen_salt("stability".as_ref(), 0.1, &salts).unwrap_err().to_string();
/// assert_eq!(error, "stability holds no salt of 100 mM, only 30, 94.868, 300 mM; choose one of them");
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn chosen_salt(directory: &Path, asked_molar: f64, salts_molar: &[f64]) -> Result<f64> {
    let label = salt_label(asked_molar);
    let is_same = |salt: &&f64| salt_label(**salt) == label;
    if let Some(same) = salts_molar.iter().find(is_same) {
        return Ok(*same);
    }
    let rounding: Vec<f64> = salts_molar
        .iter()
        .copied()
        .filter(|salt| rounds_to(*salt, asked_molar))
        .collect();
    let directory = directory.display();
    let asked = millimolar(asked_molar);
    match rounding[..] {
        [only] => Ok(only),
        [] => bail!(
            "{directory} holds no salt of {asked} mM, only {}; choose one of them",
            listed_salts(salts_molar)
        ),
        _ => bail!(
            "{directory} holds several salts that round to {asked} mM: {}; write one of them in full",
            listed_salts(&rounding)
        ),
    }
}

/// Salt concentrations (mol/L) in a sentence, in mmol/L.
///
/// ```
/// assert_eq!(protomer_protein_verbs::stability::run::listed_salts(&[0.1, 0.094868]), "100, 94.868 mM");
/// ```
pub fn listed_salts(salts_molar: &[f64]) -> String {
    let salts: Vec<String> = salts_molar.iter().map(|salt| millimolar(*salt)).collect();
    format!("{} mM", salts.join(", "))
}

/// Whether a salt rounds to a number at the number's decimals in mmol/L.
pub(crate) fn rounds_to(salt_molar: f64, asked_molar: f64) -> bool {
    let (salt, asked) = (1e3 * salt_molar, 1e3 * asked_molar);
    let decimal = |decimals: i32| 10_f64.powi(-decimals);
    // The product above is not exact, so that 94.9 may be 94.90000000000001.
    let slack = 1e-9 * asked;
    let ends = |decimals: &i32| {
        let units = asked / decimal(*decimals);
        (units - units.round()).abs() * decimal(*decimals) <= slack
    };
    let decimals = (0..MOST_DECIMALS).find(ends).unwrap_or(MOST_DECIMALS);
    asked > 0.0 && (salt - asked).abs() <= 0.5 * decimal(decimals) + slack
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(asked_molar: f64, salts_molar: &[f64]) -> Result<f64> {
        chosen_salt("run".as_ref(), asked_molar, salts_molar)
    }

    #[test]
    fn shown_digits_find_their_salt() {
        let salts = [0.0, 0.01, 0.094868, 1.234_56];
        for text in ["94.868mM", "94.87mM", "94.9mM", "95mM", "0.0949M", "0.095M"] {
            let asked = protomer_common::quantity::salt_molar(text).unwrap();
            assert_eq!(chosen(asked, &salts).unwrap(), 0.094868, "{text}");
        }
        for (asked, salt) in [(1.235, 1.234_56), (0.0, 0.0), (0.01, 0.01)] {
            assert_eq!(chosen(asked, &salts).unwrap(), salt);
        }
        for beyond in [0.0948, 0.094_8, 0.094, 0.0004, 0.09487 + 1e-5] {
            assert!(chosen(beyond, &salts).is_err(), "{beyond}");
        }
    }

    #[test]
    fn several_salts_that_round_alike_are_listed() {
        let salts = [0.0949, 0.094868, 0.09492];
        assert_eq!(chosen(0.0949, &salts).unwrap(), 0.0949);
        let error = chosen(0.095, &salts).unwrap_err().to_string();
        assert_eq!(
            error,
            "run holds several salts that round to 95 mM: 94.9, 94.868, 94.92 mM; write one of them in full"
        );
    }

    #[test]
    fn every_salt_is_found_by_its_digits() {
        for number in 1..2000 {
            let salt = f64::from(number) * 0.000_377;
            for decimals in 0..5 {
                let text = format!("{:.decimals$}", 1e3 * salt);
                let asked: f64 = text.parse::<f64>().unwrap() / 1e3;
                let is_shown = asked > 0.0;
                assert_eq!(rounds_to(salt, asked), is_shown, "{salt} {text}");
            }
        }
    }
}
