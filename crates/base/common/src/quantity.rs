//! Parses numbers with units: `150mM`, `0.15M`, `1.4A`, `0.14nm`, `10mM..300mM/8`.

use crate::range::{ANGLE, SALT};
use anyhow::{Result, anyhow, bail};

/// Concentration above which a salt is warned of, mol/L.
const USUAL_SALT_MOLAR: f64 = 1.0;

/// Parses a salt concentration in mol/L from `150mM` or `0.15M`. Only zero needs no unit: a bare
/// 100 may mean mmol/L or mol/L.
///
/// # Errors
/// Quotes the input and gives the accepted forms.
///
/// ```
/// assert_eq!(protomer_common::quantity::salt_molar("150mM")?, 0.15);
/// let error = protomer_common::quantity::salt_molar("100").unwrap_err();
/// assert_eq!(error.to_string(), "100 what? write 100mM");
/// assert!(protomer_common::quantity::salt_molar("150000M").is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn salt_molar(text: &str) -> Result<f64> {
    const UNITS: [(&str, i32); 5] = [("uM", -6), ("µM", -6), ("mM", -3), ("M", 0), ("", 0)];
    let salt = parse(text, "a salt concentration", &UNITS, "100mM or 0.1M")?;
    let number = text.trim();
    // Every unit of concentration ends in M.
    if salt != 0.0 && !number.ends_with('M') {
        // A number below one is likely meant in mol/L.
        let unit = if salt < 1.0 { "M" } else { "mM" };
        bail!("{number} what? write {number}{unit}");
    }
    if salt < 0.0 {
        bail!("the salt concentration '{text}' is negative; give zero or more, such as 100mM");
    }
    if !SALT.holds(salt) {
        bail!("the salt concentration '{text}' is that of no solution; give {SALT}, such as 100mM");
    }
    Ok(salt)
}

/// A warning for concentrations (mol/L) at which screened charges describe no salt water.
///
/// ```
/// use protomer_common::quantity::salt_warning;
/// assert!(salt_warning([0.1, 2.0]).unwrap().starts_with("warning: 2 M of salt"));
/// assert_eq!(salt_warning([0.0, 1.0]), None);
/// ```
pub fn salt_warning(salts_molar: impl IntoIterator<Item = f64>) -> Option<String> {
    let highest = salts_molar.into_iter().fold(0.0, f64::max);
    (highest > USUAL_SALT_MOLAR).then(|| {
        format!(
            "warning: {highest} M of salt: screened charges describe salt water up to some 0.1 M, and \
             little of it above 1 M; if mmol/L are meant, write {highest}mM"
        )
    })
}

/// Parses a length in Å from `1.4A`, `0.14nm` or a bare number in Å.
///
/// ```
/// use protomer_common::quantity::length_angstrom;
/// assert_eq!(length_angstrom("4.8nm")?, 48.0);
/// assert_eq!(length_angstrom("48")?, 48.0);
/// assert!(length_angstrom("48mm").is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// Quotes the input and gives the accepted forms.
pub fn length_angstrom(text: &str) -> Result<f64> {
    const UNITS: [(&str, i32); 4] = [("nm", 1), ("Å", 0), ("A", 0), ("", 0)];
    parse(text, "a length", &UNITS, "48A or 4.8nm")
}

/// Parses an absolute temperature in K from `298.15K` or a bare number in K.
///
/// # Errors
/// Quotes the input and gives the accepted forms.
///
/// ```
/// assert_eq!(protomer_common::quantity::temperature_kelvin("298.15K")?, 298.15);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn temperature_kelvin(text: &str) -> Result<f64> {
    parse(text, "a temperature", &[("K", 0), ("", 0)], "298.15K")
}

/// Parses a number of bytes from `500MB` or `2GB`, in powers of 1000, or a bare number.
///
/// # Errors
/// Quotes the input and gives the accepted forms.
///
/// ```
/// assert_eq!(protomer_common::quantity::memory_bytes("1.5GB")?, 1_500_000_000);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn memory_bytes(text: &str) -> Result<u64> {
    const UNITS: [(&str, i32); 5] = [("TB", 12), ("GB", 9), ("MB", 6), ("kB", 3), ("", 0)];
    let bytes = parse(text, "an amount of memory", &UNITS, "500MB or 2GB")?;
    // f64 holds whole numbers exactly to 9·10¹⁵ only, but no machine has an exabyte.
    if !(0.0..1e18).contains(&bytes) {
        bail!(
            "the amount of memory '{text}' is not a positive number of bytes; give zero or more, such as 2GB"
        );
    }
    Ok(bytes.round() as u64)
}

/// Parses salt concentrations in mol/L from a comma-separated list of values and ranges. A range
/// `10mM..300mM/8` is eight values spaced evenly on a logarithmic axis; `0..100mM/5` (from zero) is
/// spaced evenly on a linear one.
///
/// # Errors
/// Names the item of the list that cannot be parsed.
///
/// ```
/// let salts = protomer_common::quantity::salt_list("10mM..1000mM/3,2M")?;
/// assert_eq!(salts, vec![0.01, 0.1, 1.0, 2.0]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn salt_list(text: &str) -> Result<Vec<f64>> {
    let mut salts = Vec::new();
    for item in text.split(',').map(str::trim) {
        match item.split_once("..") {
            Some((first, remainder)) => salts.extend(salt_range(item, first, remainder)?),
            None => match range_of_other_programs(item) {
                Some(range) => bail!(
                    "'{item}' is no range; write its ends and the number of values as {range}"
                ),
                None => salts.push(salt_molar(item)?),
            },
        }
    }
    Ok(salts)
}

/// Parses concentrations of bodies in mol/L from a comma-separated list such as `100nM,1uM,10uM`.
///
/// # Errors
/// Names the item of the list that cannot be parsed; also for a concentration of zero, or more than any solution has.
///
/// ```
/// use protomer_common::quantity::concentration_list;
/// assert_eq!(concentration_list("100nM,1uM")?, [1e-7, 1e-6]);
/// let error = concentration_list("0").unwrap_err();
/// assert!(error.to_string().starts_with("without bodies there is no equilibrium"));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn concentration_list(text: &str) -> Result<Vec<f64>> {
    text.split(',').map(concentration_molar).collect()
}

/// Reads a concentration of bodies, mol/L.
///
/// ```
/// use protomer_common::quantity::concentration_molar;
/// assert!((concentration_molar("50nM")? - 5e-8).abs() < 1e-20);
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// Says what is wrong, and what a concentration looks like.
pub fn concentration_molar(text: &str) -> Result<f64> {
    const UNITS: [(&str, i32); 7] = [
        ("pM", -12),
        ("nM", -9),
        ("uM", -6),
        ("µM", -6),
        ("mM", -3),
        ("M", 0),
        ("", 0),
    ];
    const MOST_MOLAR: f64 = 1.0;
    let molar = parse(text, "a concentration", &UNITS, "1uM or 50nM")?;
    let number = text.trim();
    if molar == 0.0 {
        bail!(
            "without bodies there is no equilibrium; give a concentration above zero, such as 1uM"
        );
    }
    if !number.ends_with('M') {
        bail!("{number} what? write {number}uM or {number}nM");
    }
    if !(molar > 0.0 && molar <= MOST_MOLAR) {
        bail!(
            "the concentration '{number}' is that of no solution of proteins; give one above zero and up to \
             {MOST_MOLAR} M, such as 1uM"
        );
    }
    Ok(molar)
}

/// Parses angles in degrees from a comma-separated list of values and ranges. A range `0..90/7` is seven
/// values spaced evenly.
///
/// # Errors
/// Names the item that is not an angle or a range.
///
/// ```
/// let angles = protomer_common::quantity::angle_list("0..90/3,180")?;
/// assert_eq!(angles, [0.0, 45.0, 90.0, 180.0]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn angle_list(text: &str) -> Result<Vec<f64>> {
    let angle = |text: &str| -> Result<f64> {
        let degrees: f64 = text.trim().parse().map_err(|_| {
            anyhow!("'{text}' is not an angle; write degrees such as 90, a list, or 0..90/7")
        })?;
        ANGLE.require("angle", degrees)?;
        Ok(degrees)
    };
    let mut angles = Vec::new();
    for item in text.split(',') {
        let Some((first, remainder)) = item.split_once("..") else {
            angles.push(angle(item)?);
            continue;
        };
        let Some((last, count)) = remainder.split_once('/') else {
            bail!("the range '{item}' lacks the number of values; write it as 0..90/7");
        };
        let (first, last) = (angle(first)?, angle(last)?);
        let count: u32 = match count.trim().parse() {
            Ok(count) if (2..=361).contains(&count) => count,
            _ => bail!("the range '{item}' asks for '{count}' values; give a number from 2 to 361"),
        };
        let step = (last - first) / f64::from(count - 1);
        angles.extend((0..count).map(|number| first + step * f64::from(number)));
    }
    Ok(angles)
}

fn salt_range(item: &str, first: &str, remainder: &str) -> Result<Vec<f64>> {
    let Some((last, count)) = remainder.split_once('/') else {
        bail!("the range '{item}' lacks the number of values; write it as 10mM..300mM/8");
    };
    // The lower end of a range may omit the unit: 10..300mM/8.
    let unit = last.trim_start_matches(|c: char| c.is_ascii_digit() || ".-+eE".contains(c));
    let first_has_unit = first.ends_with('M');
    let low = salt_molar(&if first_has_unit {
        first.to_owned()
    } else {
        format!("{first}{unit}")
    })?;
    let high = salt_molar(last)?;
    let count: usize = match count.trim().parse() {
        Ok(count) if (2..=10_000).contains(&count) => count,
        _ => bail!("the range '{item}' asks for '{count}' values; give a number from 2 to 10000"),
    };
    if high <= low {
        bail!("the range '{item}' does not increase; put the smaller concentration first");
    }
    let fraction = |i: usize| i as f64 / (count - 1) as f64;
    let value = |i: usize| match i {
        // The ends as they were written: powers and products would change their last digit.
        0 => low,
        i if i == count - 1 => high,
        // From zero the steps are even; a logarithmic axis has no zero.
        i if low == 0.0 => round_to_micromolar(high * fraction(i)),
        i => round_to_micromolar(low * (high / low).powf(fraction(i))),
    };
    Ok((0..count).map(value).collect())
}

/// A range as other programs write it, `0.1-0.5M`, `10mM:300mM:5` or `10 to 300mM`, in the form that is
/// read here; `None` for anything else.
fn range_of_other_programs(item: &str) -> Option<String> {
    const USUAL_COUNT: &str = "5";
    let marks = [":", " to ", "–", "-"];
    let mark = marks.iter().find(|mark| item.contains(**mark))?;
    let parts: Vec<&str> = item.split(mark).map(str::trim).collect();
    let (first, last, count) = match parts[..] {
        [first, last] => {
            let (last, count) = last.split_once('/').unwrap_or((last, USUAL_COUNT));
            (first, last, count)
        }
        [first, last, count] => (first, last, count),
        _ => return None,
    };
    count.parse::<u32>().ok()?;
    let last_number = last.trim_end_matches(|c: char| c.is_alphabetic());
    let has_unit = |text: &str| text.ends_with('M');
    let bare_unit = match &last[last_number.len()..] {
        "" if last_number.parse::<f64>().ok()? < 1.0 => "M",
        "" => "mM",
        unit => unit,
    };
    let with_unit = |text: &str| match has_unit(text) {
        true => text.to_owned(),
        false => format!("{text}{bare_unit}"),
    };
    let (first, last) = (with_unit(first), with_unit(last));
    // Only two concentrations make a range: 1e-3M and -5mM are none.
    (salt_molar(&first).is_ok() && salt_molar(&last).is_ok())
        .then(|| format!("{first}..{last}/{count}"))
}

/// Rounds to 1 µM, so that labels and folder names stay short.
fn round_to_micromolar(salt_molar: f64) -> f64 {
    if salt_molar < 1e-4 {
        salt_molar
    } else {
        (salt_molar * 1e6).round() / 1e6
    }
}

/// Parses `value × unit`; a unit is a suffix and a power of ten. Positive powers of ten are
/// exact, so dividing by them keeps 150mM exactly 0.15.
fn parse(text: &str, quantity: &str, units: &[(&str, i32)], example: &str) -> Result<f64> {
    let text = text.trim();
    // Longer suffixes first, or `mM` would be read as a number `100m` with the unit M.
    for (suffix, power) in units {
        let Some(number) = text.strip_suffix(suffix) else {
            continue;
        };
        if let Ok(value) = number.trim().parse::<f64>()
            && value.is_finite()
        {
            // Dividing by 1000 rounds once; multiplying by 0.001 would round twice.
            return Ok(if *power < 0 {
                value / 10f64.powi(-power)
            } else {
                value * 10f64.powi(*power)
            });
        }
    }
    bail!("'{text}' is not {quantity}; write it like {example}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_understood() {
        assert_eq!(salt_molar("0.15M").unwrap(), salt_molar("150mM").unwrap());
        assert_eq!(salt_molar("0").unwrap(), 0.0);
        assert_eq!(length_angstrom("4.8nm").unwrap(), 48.0);
        assert_eq!(length_angstrom("48A").unwrap(), 48.0);
        assert_eq!(length_angstrom("48").unwrap(), 48.0);
    }

    #[test]
    fn ranges_are_logarithmic_and_hit_their_ends() {
        let salts = salt_list("10mM..300mM/8").unwrap();
        assert_eq!((salts.len(), salts[0], salts[7]), (8, 0.01, 0.3));
        assert!(salts.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(salt_list("10..300mM/8").unwrap(), salts);
        assert_eq!(salt_list("0M..0.1M/3").unwrap(), vec![0.0, 0.05, 0.1]);
    }

    #[test]
    fn ranges_of_other_programs_are_refused_with_their_form_here() {
        for (text, form) in [
            ("0.1-0.5M", "0.1M..0.5M/5"),
            ("10mM:300mM:5", "10mM..300mM/5"),
            ("10:300mM", "10mM..300mM/5"),
            ("50mM,10 to 300mM", "10mM..300mM/5"),
            ("10–300", "10mM..300mM/5"),
            ("0.1-0.5", "0.1M..0.5M/5"),
            ("100uM-1mM", "100uM..1mM/5"),
            ("10mM-300mM/8", "10mM..300mM/8"),
        ] {
            let message = salt_list(text).unwrap_err().to_string();
            assert!(
                message.ends_with(&format!("values as {form}")),
                "{text}: {message}"
            );
            assert!(salt_list(form).is_ok());
        }
        for text in ["-5mM", "1-2-3-4mM", "x-5mM", "a:b", "10mM:300mM:many", "-"] {
            let message = salt_list(text).unwrap_err().to_string();
            assert!(!message.contains("is no range"), "{text}: {message}");
        }
        assert_eq!(salt_list("1e-3M").unwrap(), [1e-3]);
    }

    #[test]
    fn nonsense_is_refused_with_the_offending_text() {
        for text in [
            "-5mM",
            "abc",
            "10mM..5mM/3",
            "1..2",
            "10mM..20mM/1",
            "",
            "nanM",
            "1e400M",
            "100",
            "0.1",
            "10mM,50",
        ] {
            let message = salt_list(text).unwrap_err().to_string();
            let first = text.split("..").next().unwrap();
            let named = first.rsplit(',').next().unwrap();
            assert!(message.contains(named), "{text}: {message}");
        }
    }
}
