//! What can be predicted without a network. Nothing counts as learnt before it beats these on the
//! same split.
//!
//! They know nothing of the voxels: majority, prior, size (with and without charge) and
//! composition. The learning curve of a training is never shown without them.

use crate::error::refuse;
use crate::logistic::{Logistic, Table, prior};
use crate::ridge::Ridge;
use crate::scores::{Scores, most_probable};
use crate::split::{Split, family_weights};
use crate::{Description, LearnError, Result};

/// Strengths of the ridge, strongest first. The validation part chooses.
const RIDGES: [f64; 6] = [10.0, 1.0, 1e-1, 1e-2, 1e-3, 1e-4];

/// A prediction from less than the voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    /// Name of the baseline, after what it rests on: `majority`, `prior`, `size`, `size_and_charge`
    /// or `composition`.
    pub name: &'static str,
    /// Probabilities for the samples of the test part, in order.
    pub probabilities: Vec<f64>,
}

/// Function that computes the features of a regression.
type Features = fn(&Description) -> Vec<f64>;

/// The regressions by name.
const REGRESSIONS: [(&str, Features); 3] = [
    ("size", size),
    ("size_and_charge", size_and_charge),
    ("composition", composition),
];

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
/// Regressions are fitted to the training part. Their ridge is chosen by the log-loss of the
/// validation part (the largest if that is empty).
///
/// ```
/// use protomer_learn::baselines::baselines;
/// use protomer_learn::controls::{Control, Variant};
/// use protomer_learn::scores::Scores;
/// use protomer_learn::split::{Fractions, Split};
///
/// let set = Control::Charge.samples(Variant::Usual, 100, 16, 1);
/// let labels: Vec<usize> = (0..100).map(|sample| sample % 2).collect();
/// let split = Split::grouped(&set.descriptions, 1, Fractions::default())?;
/// let truth: Vec<usize> = split.test.iter().map(|sample| labels[*sample]).collect();
///
/// // The label is the sign of the net charge, which one of the regressions knows.
/// for baseline in baselines(&set.descriptions, &labels, 2, None, &split)? {
///     let scores = Scores::from_probabilities(&baseline.probabilities, &truth, 2, None)?;
///     assert_eq!(scores.accuracy > 0.9, baseline.name == "size_and_charge");
/// }
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`] if lengths disagree or a part is missing. [`LearnError::Sample`] names
/// a description that is not finite.
pub fn baselines(
    descriptions: &[Description],
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
    split: &Split,
) -> Result<Vec<Baseline>> {
    split.check(labels.len())?;
    if descriptions.len() != labels.len() || split.training.is_empty() || split.test.is_empty() {
        return refuse(format!(
            "{} samples, {} labels; training and test must not be empty",
            descriptions.len(),
            labels.len()
        ));
    }
    let shares = prior(&split.training, labels, weights, classes);
    let mut majority = vec![0.0; classes];
    if let Some(most) = majority.get_mut(most_probable(&shares)) {
        *most = 1.0;
    }
    let mut all = vec![
        Baseline {
            name: "majority",
            probabilities: majority.repeat(split.test.len()),
        },
        Baseline {
            name: "prior",
            probabilities: shares.repeat(split.test.len()),
        },
    ];
    for (name, features_of) in REGRESSIONS {
        let features = table(descriptions, name, features_of)?;
        let table = Table {
            features: &features,
            columns: features.len() / descriptions.len(),
        };
        all.push(Baseline {
            name,
            probabilities: regression(table, labels, classes, weights, split)?,
        });
    }
    Ok(all)
}

/// The baselines of numbers for the test part, by name: the mean of the training part (`prior`), and
/// linear regressions on the features of [`baselines`], whose ridge the validation part chooses.
///
/// # Errors
/// As for [`baselines`].
pub fn number_baselines(
    descriptions: &[Description],
    numbers: &[f64],
    split: &Split,
) -> Result<Vec<(&'static str, Vec<f64>)>> {
    split.check(numbers.len())?;
    let weights = family_weights(descriptions);
    let mut all = Vec::new();
    for (name, features_of) in REGRESSIONS {
        let features = table(descriptions, name, features_of)?;
        let table = Table {
            features: &features,
            columns: features.len() / descriptions.len().max(1),
        };
        let fit = |ridge| Ridge::fit(table, &split.training, numbers, &weights, ridge);
        let loss = |fit: &Ridge| -> f64 {
            let predicted = fit.predicted(table, &split.validation);
            let pairs = split.validation.iter().zip(predicted);
            pairs
                .map(|(sample, x)| weights[*sample] * (x - numbers[*sample]).powi(2))
                .sum()
        };
        // As for classes: of equal losses the strongest ridge stays.
        let mut best = fit(RIDGES[0])?;
        for ridge in &RIDGES[1..] {
            let other = fit(*ridge)?;
            if loss(&other) < loss(&best) {
                best = other;
            }
        }
        all.push((name, best.predicted(table, &split.test)));
    }
    let (mut sum, mut total) = (0.0, 0.0);
    for sample in &split.training {
        sum += weights[*sample] * numbers[*sample];
        total += weights[*sample];
    }
    all.push(("prior", vec![sum / total; split.test.len()]));
    Ok(all)
}

/// The features of all samples.
///
/// # Errors
/// [`LearnError::Sample`] names a description that is not finite.
fn table(descriptions: &[Description], name: &str, features_of: Features) -> Result<Vec<f64>> {
    let mut features = Vec::new();
    for description in descriptions {
        let row = features_of(description);
        if row.iter().any(|value| !value.is_finite()) {
            return Err(LearnError::Sample {
                name: description.name.clone(),
                reason: format!(
                    "its description for the baseline {name} holds a number that is not finite"
                ),
            });
        }
        features.extend(row);
    }
    Ok(features)
}

/// Probabilities for the test part by the regression whose ridge the validation part prefers.
///
/// # Errors
/// [`LearnError::Settings`] as for [`Logistic::fit`].
fn regression(
    table: Table,
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
    split: &Split,
) -> Result<Vec<f64>> {
    // Weights and labels in the order of the validation part, as the probabilities are.
    let pick = |all: &[f64]| -> Vec<f64> { split.validation.iter().map(|i| all[*i]).collect() };
    let weights_there = weights.map(pick);
    let truth: Vec<usize> = split.validation.iter().map(|i| labels[*i]).collect();
    let fit = |ridge| Logistic::fit(table, &split.training, labels, weights, classes, ridge);
    // The strongest ridge serves when nothing is there to choose by: it promises least.
    let mut best = fit(RIDGES[0])?;
    if split.validation.is_empty() {
        return best.probabilities(table, &split.test);
    }
    let loss = |model: &Logistic| -> Result<f64> {
        let p = model.probabilities(table, &split.validation)?;
        Ok(
            Scores::from_probabilities(&p, &truth, classes, weights_there.as_deref())?
                .log_loss_nats,
        )
    };
    let mut least = loss(&best)?;
    for ridge in &RIDGES[1..] {
        let other = fit(*ridge)?;
        let loss = loss(&other)?;
        // Strictly: of equal losses the stronger ridge stays.
        if loss < least {
            (least, best) = (loss, other);
        }
    }
    best.probabilities(table, &split.test)
}

/// Logarithms of the sizes, with those that are not known (zero) kept finite.
fn size(description: &Description) -> Vec<f64> {
    let mut features = vec![
        description.residues,
        description.radius_of_gyration_angstrom,
    ];
    features.extend(description.extents_angstrom);
    for length in &mut features {
        // Less than one residue or one ångström means that the size is unknown.
        *length = if *length < 1.0 { 0.0 } else { length.ln() };
    }
    features
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
            Scores::from_probabilities(&baseline.probabilities, &test, 3, None).unwrap()
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
