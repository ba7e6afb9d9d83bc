//! The pipeline learns what it should, and nothing that it should not: the short forms of the
//! controls. Three of them run every time: one that must be learnt, one that must not, and one that
//! gives its label away. `--include-ignored` runs all.

use protomer_kernel::setting::Choices;
use protomer_learn::SampleSource;
use protomer_learn::controls::{Control, Experiment, Form, Verdict};
use protomer_learn::scores::Scores;
use protomer_learn::targets::{Classes, Target};
use protomer_learn::training::{PredictionSettings, train};
use std::collections::BTreeSet;

const SEED: u64 = 1;

/// Trains one experiment in its short form and judges it on its test part.
fn verdict(control: Control, experiment: &Experiment) -> Verdict {
    let plan = control.plan(experiment, Form::Short);
    let set = control.samples(experiment.variant, plan.samples, plan.size, SEED);
    let samples = set.descriptions();
    let labels: Vec<&str> = samples.iter().map(|sample| &*sample.label).collect();
    let classes = Classes::from_labels(&labels, Target::Label, 1).unwrap();
    let split = experiment.split(samples, SEED, plan.fractions).unwrap();
    let network = control.network(experiment, Form::Short);
    let settings = control.training(experiment, Form::Short, SEED);
    let trained = train(&set, &classes, &split, &network, &settings, &mut ()).unwrap();
    let how = PredictionSettings::default();
    let predictions = trained.model.predict(&set, &split.test, how).unwrap();
    let (mut truth, mut independent) = (Vec::new(), BTreeSet::new());
    for sample in &split.test {
        truth.push(classes.labels[*sample]);
        independent.insert(if experiment.split_by_cluster {
            &samples[*sample].cluster
        } else {
            &samples[*sample].name
        });
    }
    let count = classes.names.len();
    let scores =
        Scores::from_probabilities(&predictions.probabilities, &truth, count, None).unwrap();
    let expected = experiment.expected;
    expected.verdict(scores.balanced_accuracy, count, independent.len())
}

/// All experiments of a control come out as it says.
fn check(control: Control) {
    for experiment in control.experiments() {
        let verdict = verdict(control, &experiment);
        eprintln!("{} {}: {verdict:?}", control.name(), experiment.name);
        assert!(
            verdict.is_reached,
            "{} {}: {verdict:?}",
            control.name(),
            experiment.name
        );
    }
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn shapes_are_told_apart() {
    check(Control::Shapes);
}

#[test]
fn the_sign_of_the_charge_is_read_from_the_potential_alone() {
    check(Control::Charge);
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn a_hydrophobic_patch_is_read_from_the_hydropathy_alone() {
    check(Control::Patch);
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn what_two_channels_say_together_is_learnt_from_both_only() {
    check(Control::Xor);
}

#[test]
fn permuted_labels_teach_nothing() {
    check(Control::Permuted);
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn proteins_are_recognised_through_a_random_split_only() {
    check(Control::Identity);
}

#[test]
fn the_deposited_frame_gives_its_label_away_until_it_is_turned() {
    check(Control::Orientation);
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn size_is_learnt_at_a_fixed_scale_only() {
    check(Control::Size);
}

#[test]
#[ignore = "trains for 15 s and more; run by name"]
fn outliers_drown_the_potential_until_it_is_scaled_robustly() {
    check(Control::HeavyTails);
}
