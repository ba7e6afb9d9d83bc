//! A network over ranges of its parameters: which geometry is auxetic.

use super::report::{Report, Settings, analyse};
use super::text::rounded;
use anyhow::{Result, bail};
use protomer_common::answer::{Answer, columns};
use protomer_linkage::framework::Framework;
use serde::Serialize;
use std::collections::BTreeMap;

/// Relative difference of ratios that are the same.
const ROUNDING: f64 = 1e-9;

/// The largest number of networks of a scan.
const MOST_NETWORKS: usize = 100_000;

/// A parameter and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct ScannedParameter {
    /// Name of the parameter, that of the flag.
    pub name: String,
    /// The values.
    pub values: Vec<f64>,
}

/// The moduli of a network for values of its parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScanRow {
    /// Values of the parameters by their names.
    pub parameters: BTreeMap<String, f64>,
    /// Moduli on the axes, keys as in a report; empty where there is no network.
    pub moduli: BTreeMap<String, Option<f64>>,
    /// The least Poisson's ratio over the directions of a load in the plane.
    pub least_nu: Option<f64>,
    /// The direction of that load from y, degrees.
    pub least_nu_angle_deg: Option<f64>,
    /// Strains that cost no energy.
    pub mechanisms: usize,
    /// The reason why these values make no network.
    pub problem: Option<String>,
}

/// Networks over all combinations of values.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Scan {
    /// One row for each combination, the last parameter fastest.
    pub rows: Vec<ScanRow>,
}

impl ScannedParameter {
    /// Reads `theta=30:150:10` (from, to, step; both ends belong to it) or `theta=30,60,90`.
    ///
    /// ```
    /// use protomer_linkage_verbs::frameworks::scan::ScannedParameter;
    /// assert_eq!(ScannedParameter::parse("theta=30:60:10")?.values, [30.0, 40.0, 50.0, 60.0]);
    /// assert_eq!(ScannedParameter::parse("h=1,2.5")?.values, [1.0, 2.5]);
    /// assert!(ScannedParameter::parse("theta=60:30:10").is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Names the text that cannot be read.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = || format!("--scan is '{text}'; write it like theta=30:150:10 or h=1,2");
        let Some((name, values)) = text.split_once('=') else {
            bail!(wrong());
        };
        let separator = if values.contains(':') { ':' } else { ',' };
        let numbers = values.split(separator).map(|value| value.trim().parse());
        let Ok(numbers) = numbers.collect::<Result<Vec<f64>, _>>() else {
            bail!(wrong());
        };
        let values = match (separator, numbers.as_slice()) {
            (',', _) => numbers,
            (_, [from, to, step]) => steps(*from, *to, *step)?,
            _ => bail!(wrong()),
        };
        if values.iter().any(|value| !value.is_finite()) {
            bail!(wrong());
        }
        Ok(Self {
            name: name.trim().to_owned(),
            values,
        })
    }
}

/// Evenly spaced values; the last is at most `to`, up to rounding.
fn steps(from: f64, to: f64, step: f64) -> Result<Vec<f64>> {
    let count = ((to - from) / step + 1e-9).floor();
    if !(0.0..MOST_NETWORKS as f64).contains(&count) {
        bail!(
            "--scan from {from} to {to} by {step} has no values, or too many; give FROM:TO:STEP with a step towards TO"
        );
    }
    Ok((0..=count as usize)
        .map(|index| from + index as f64 * step)
        .collect())
}

impl Scan {
    /// Analyses the networks that `build` makes of each combination of values, given in the order of the
    /// parameters.
    ///
    /// # Errors
    /// If there are too many combinations, or none of them makes a network; the reason is that of the first.
    pub fn run(
        parameters: &[ScannedParameter],
        settings: &Settings,
        build: impl Fn(&[f64]) -> Result<Framework>,
    ) -> Result<Self> {
        let counts = parameters.iter().map(|parameter| parameter.values.len());
        let networks = counts.fold(1_usize, usize::saturating_mul);
        if networks > MOST_NETWORKS {
            bail!("the scan has {networks} networks; ask for at most {MOST_NETWORKS}");
        }
        let mut rows = Vec::with_capacity(networks);
        for number in 0..networks {
            let values = combination(parameters, number);
            let names = parameters.iter().map(|parameter| parameter.name.clone());
            let named = names.zip(values.iter().copied()).collect();
            let found = build(&values).and_then(|network| Ok(analyse(&network, "", settings)?.1));
            rows.push(row(named, found));
        }
        if let Some(problem) = rows.first().and_then(|row| row.problem.as_ref())
            && rows.iter().all(|row| row.problem.is_some())
        {
            bail!("no network of the scan can be analysed; the first: {problem}");
        }
        Ok(Self { rows })
    }
}

/// The values of a combination by its number, the last parameter fastest.
fn combination(parameters: &[ScannedParameter], mut number: usize) -> Vec<f64> {
    let mut values = vec![0.0; parameters.len()];
    for (value, parameter) in values.iter_mut().zip(parameters).rev() {
        *value = parameter.values[number % parameter.values.len()];
        number /= parameter.values.len();
    }
    values
}

fn row(parameters: BTreeMap<String, f64>, found: Result<Report>) -> ScanRow {
    match found {
        Err(error) => ScanRow {
            parameters,
            moduli: BTreeMap::new(),
            least_nu: None,
            least_nu_angle_deg: None,
            mechanisms: 0,
            problem: Some(format!("{error:#}")),
        },
        Ok(report) => {
            let ratios = report
                .polar
                .iter()
                .filter_map(|d| Some((d.nu?, d.angle_deg)));
            // Of directions that differ by rounding only, the first.
            let least = ratios.reduce(|least, next| {
                let is_less = next.0 < least.0 - ROUNDING * least.0.abs().max(1.0);
                if is_less { next } else { least }
            });
            ScanRow {
                parameters,
                moduli: report.moduli,
                least_nu: least.map(|(nu, _)| nu),
                least_nu_angle_deg: least.map(|(_, angle)| angle),
                mechanisms: report.mechanisms.len(),
                problem: None,
            }
        }
    }
}

impl Answer for Scan {
    fn text(&self) -> String {
        let Some(first) = self.rows.iter().find(|row| row.problem.is_none()) else {
            return String::new();
        };
        let keys: Vec<&String> = first.moduli.keys().collect();
        let mut head: Vec<String> = first.parameters.keys().cloned().collect();
        head.extend(keys.iter().map(|key| (*key).clone()));
        head.extend(["least_nu", "at_degrees"].map(str::to_owned));
        let mut lines = vec![head];
        for row in &self.rows {
            let mut line: Vec<String> = row
                .parameters
                .values()
                .map(|value| format!("{}", (value * 1e9).round() / 1e9))
                .collect();
            match &row.problem {
                Some(problem) => line.push(problem.clone()),
                None => {
                    let moduli = keys
                        .iter()
                        .map(|key| row.moduli.get(*key).copied().flatten());
                    line.extend(moduli.map(shown));
                    line.extend([shown(row.least_nu), shown(row.least_nu_angle_deg)]);
                }
            }
            lines.push(line);
        }
        columns(&lines)
    }
}

fn shown(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(value) if value.abs() < 1e7 => rounded(value, 4),
        Some(value) => format!("{value:.3e}"),
    }
}
