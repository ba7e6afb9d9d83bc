//! What can be predicted without a network: nothing counts as learnt before it beats these on the
//! same split.

use crate::logistic::{Logistic, Table, prior};
use crate::scores::{Scores, most_probable};
use crate::split::Split;
use crate::{Description, LearnError, Result};

/// Strengths of the ridge; the validation part chooses.
const RIDGES: [f64; 6] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0];

/// A prediction from less than the voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    /// What it rests on: `majority`, `prior`, `size`, `size_and_charge` or `composition`.
    pub name: &'static str,
    /// Probabilities for the samples of the test part, in order.
    pub probabilities: Vec<f64>,
}

/// What a regression looks at.
type Features = fn(&Description) -> Vec<f64>;

/// The baselines on a split.
///
/// * `majority`: the most frequent class of the training part, with certainty. Only its accuracies
///   mean anything.
/// * `prior`: the shares of the classes in the training part.
/// * `size`: multinomial logistic regression on logarithms of residues, radius of gyration and
///   extents.
/// * `size_and_charge`: the same with net charge, its size, and charge per residue.
/// * `composition`: shares of the amino acids.
///
/// Regressions are fitted to the training part, their ridge is chosen by the log-loss of the
/// validation part (the largest if that is empty).
///
/// # Errors
/// [`LearnError::Settings`] if lengths disagree or a part is missing; a description that is not
/// finite is named.
pub fn baselines(
    descriptions: &[Description],
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
    split: &Split,
) -> Result<Vec<Baseline>> {
    split.check(labels.len())?;
    if descriptions.len() != labels.len() || split.training.is_empty() || split.test.is_empty() {
        let reason = format!(
            "{} samples, {} labels; training and test must not be empty",
            descriptions.len(),
            labels.len()
        );
        return Err(LearnError::Settings(reason));
    }
    let shares = prior(&split.training, labels, weights, classes);
    let mut majority = vec![0.0; classes];
    if let Some(most) = majority.get_mut(most_probable(&shares)) {
        *most = 1.0;
    }
    let repeated = |p: &[f64]| p.repeat(split.test.len());
    let mut all = vec![
        Baseline {
            name: "majority",
            probabilities: repeated(&majority),
        },
        Baseline {
            name: "prior",
            probabilities: repeated(&shares),
        },
    ];
    let regressions: [(&'static str, Features); 3] = [
        ("size", size),
        ("size_and_charge", size_and_charge),
        ("composition", composition),
    ];
    for (name, features_of) in regressions {
        let mut features = Vec::new();
        for description in descriptions {
            let row = features_of(description);
            if row.iter().any(|value| !value.is_finite()) {
                let reason = format!(
                    "its description for the baseline {name} holds a number that is not finite"
                );
                return Err(LearnError::Sample {
                    name: description.name.clone(),
                    reason,
                });
            }
            features.extend(row);
        }
        let table = Table {
            features: &features,
            columns: features.len() / descriptions.len().max(1),
        };
        all.push(Baseline {
            name,
            probabilities: regression(table, labels, classes, weights, split)?,
        });
    }
    Ok(all)
}

/// Probabilities for the test part by the regression whose ridge the validation part prefers.
///
/// # Errors
/// [`LearnError::Settings`] as [`Logistic::fit`].
pub fn regression(
    table: Table,
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
    split: &Split,
) -> Result<Vec<f64>> {
    let pick = |samples: &[usize]| {
        samples
            .iter()
            .map(|sample| labels[*sample])
            .collect::<Vec<_>>()
    };
    let mut best: Option<(f64, Logistic)> = None;
    for ridge in RIDGES.into_iter().rev() {
        let fit = Logistic::fit(table, &split.training, labels, weights, classes, ridge)?;
        if split.validation.is_empty() {
            return fit.probabilities(table, &split.test);
        }
        let p = fit.probabilities(table, &split.validation)?;
        let chosen: Option<Vec<f64>> =
            weights.map(|all| split.validation.iter().map(|sample| all[*sample]).collect());
        let loss =
            Scores::of(&p, &pick(&split.validation), classes, chosen.as_deref())?.log_loss_nats;
        if best.as_ref().is_none_or(|(least, _)| loss < *least) {
            best = Some((loss, fit));
        }
    }
    match best {
        Some((_, fit)) => fit.probabilities(table, &split.test),
        None => Err(LearnError::Settings("no ridge to try".into())),
    }
}

/// Logarithms, with sizes that are not known (zero) kept finite.
fn size(description: &Description) -> Vec<f64> {
    let mut lengths = vec![
        description.residues,
        description.radius_of_gyration_angstrom,
    ];
    lengths.extend(description.extents_angstrom);
    lengths
        .into_iter()
        .map(|length| if length < 1.0 { 0.0 } else { length.ln() })
        .collect()
}

fn size_and_charge(description: &Description) -> Vec<f64> {
    let mut features = size(description);
    let charge = description.net_charge_e;
    features.extend([charge, charge.abs(), charge / description.residues.max(1.0)]);
    features
}

fn composition(description: &Description) -> Vec<f64> {
    description.composition.to_vec()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::split::Fractions;
    use protomer_kernel::random::CounterRng;

    /// The class follows the sign of the charge; size and composition say nothing. The class 2
    /// never occurs.
    fn set() -> (Vec<Description>, Vec<usize>) {
        let mut rng = CounterRng::new(6, 0, 0);
        let sample = |number: usize| {
            let charge = rng.uniform_in(-12.0, 8.0);
            let description = Description {
                name: format!("s{number}"),
                label: format!("{}", charge > 0.0),
                cluster: format!("{}", number / 2),
                residues: rng.uniform_in(50.0, 400.0),
                radius_of_gyration_angstrom: rng.uniform_in(10.0, 30.0),
                extents_angstrom: [0.0; 3].map(|_: f64| rng.uniform_in(20.0, 60.0)),
                net_charge_e: charge,
                composition: [0.0; 20].map(|_: f64| rng.uniform()),
                ..Description::default()
            };
            (description, usize::from(charge > 0.0))
        };
        (0..300).map(sample).unzip()
    }

    #[test]
    fn charge_is_found_and_only_where_it_is() {
        let (descriptions, labels) = set();
        let split = Split::grouped(&descriptions, 1, Fractions::default()).unwrap();
        let test: Vec<usize> = split.test.iter().map(|sample| labels[*sample]).collect();
        let all = baselines(&descriptions, &labels, 3, None, &split).unwrap();
        let score = |name: &str| {
            let baseline = all.iter().find(|baseline| baseline.name == name).unwrap();
            Scores::of(&baseline.probabilities, &test, 3, None).unwrap()
        };
        let share = test.iter().filter(|label| **label == 0).count() as f64 / test.len() as f64;
        assert_eq!(score("majority").accuracy, share);
        assert!(score("size_and_charge").accuracy > 0.9);
        assert!(score("size_and_charge").nats_gained_over(&score("prior")) > 0.3);
        for name in ["size", "composition"] {
            assert!(
                score(name).nats_gained_over(&score("prior")).abs() < 0.1,
                "{name}"
            );
        }
        // The prior by its definition.
        let prior = &all
            .iter()
            .find(|baseline| baseline.name == "prior")
            .unwrap()
            .probabilities[..3];
        let ones = split
            .training
            .iter()
            .filter(|sample| labels[**sample] == 1)
            .count() as f64;
        assert!(
            (prior[1] - (ones + 1.0 / 3.0) / (split.training.len() as f64 + 1.0)).abs() < 1e-12
        );
    }

    #[test]
    fn test_labels_are_not_looked_at() {
        let (descriptions, mut labels) = set();
        let split = Split::grouped(&descriptions, 1, Fractions::default()).unwrap();
        let before = baselines(&descriptions, &labels, 3, None, &split).unwrap();
        for sample in &split.test {
            labels[*sample] = 2;
        }
        assert_eq!(
            baselines(&descriptions, &labels, 3, None, &split).unwrap(),
            before
        );
    }

    #[test]
    fn a_damaged_description_is_named() {
        let (mut descriptions, labels) = set();
        descriptions[7].net_charge_e = f64::NAN;
        let split = Split::grouped(&descriptions, 1, Fractions::default()).unwrap();
        let error = baselines(&descriptions, &labels, 3, None, &split)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("s7") && error.contains("size_and_charge"),
            "{error}"
        );
    }
}
