use super::*;
use crate::augmentation::CubeRotation;
use crate::scaling::ScalingMode;
use crate::split::Fractions;
use crate::targets::Target;
use crate::{BlockSettings, Description, GlobalPooling, InMemory, SparseGrid};
use candle_core::{DType, Tensor};
use protomer_kernel::random::CounterRng;
use serde_json::Value;

const SIZE: usize = 8;

/// Random voxels on a shell whose potential has the sign of the class; classes are `minus` and
/// `plus`. Shapes say nothing.
fn source(count: usize) -> InMemory {
    let mut rng = CounterRng::new(21, 0, 0);
    let (mut descriptions, mut grids) = (Vec::new(), Vec::new());
    for number in 0..count {
        let sign = if rng.uniform() < 0.6 { 1.0 } else { -1.0 };
        let index: Vec<u32> = (0..SIZE.pow(3) as u32)
            .filter(|_| rng.uniform() < 0.1)
            .collect();
        let mut values = vec![1.0; index.len()];
        values.extend(
            index
                .iter()
                .map(|_| (sign + rng.uniform_in(-2.0, 2.0)) as f32),
        );
        descriptions.push(Description {
            name: format!("s{number}"),
            label: if sign > 0.0 {
                "plus".into()
            } else {
                "minus".into()
            },
            cluster: format!("c{}", number / 2),
            family: if number % 3 == 0 {
                format!("f{}", number / 6)
            } else {
                String::new()
            },
            ..Description::default()
        });
        grids.push(SparseGrid {
            size: SIZE,
            channels: 2,
            index,
            values,
        });
    }
    InMemory {
        size: SIZE,
        channels: vec!["shape".into(), "potential".into()],
        descriptions,
        grids,
    }
}

fn classes(source: &InMemory) -> Classes {
    let labels: Vec<&str> = source
        .descriptions
        .iter()
        .map(|description| description.label.as_str())
        .collect();
    Classes::from_labels(&labels, Target::Label, 1).unwrap()
}

fn network(channels: usize) -> NetworkSettings {
    let block = BlockSettings {
        width: 8,
        kernel: 3,
        groups: None,
        pool: true,
    };
    NetworkSettings {
        channels,
        classes: 2,
        blocks: vec![block; 2],
        pooling: GlobalPooling::AverageAndMaximum,
    }
}

fn settings(epochs: usize) -> TrainingSettings {
    TrainingSettings {
        epochs,
        batch: 4,
        learning_rate: 5e-3,
        patience: None,
        seed: 3,
        ..TrainingSettings::default()
    }
}

fn run(
    settings: &TrainingSettings,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer,
) -> Result<Trained> {
    let source = source(60);
    let split = Split::grouped(&source.descriptions, 1, Fractions::default())?;
    let network = network(if settings.channels.is_empty() {
        2
    } else {
        settings.channels.len()
    });
    let classes = classes(&source);
    let training = Training {
        source: &source,
        classes: &classes,
        split: &split,
        network: &network,
        settings,
        numbers: None,
        start_from: None,
        device: Device::Cpu,
    };
    training.run(checkpoint, observer)
}

/// Keeps the last checkpoint; ends after some epochs or steps.
#[derive(Default)]
struct Keeper {
    bytes: Vec<u8>,
    epochs: Option<usize>,
    steps: Option<usize>,
}

impl Observer for Keeper {
    fn step(&mut self, _: StepReport) -> ControlFlow<()> {
        match &mut self.steps {
            Some(0) => return ControlFlow::Break(()),
            Some(remaining) => *remaining -= 1,
            None => {}
        }
        ControlFlow::Continue(())
    }

    fn epoch(
        &mut self,
        record: &EpochRecord,
        checkpoint: &dyn Fn() -> Result<Vec<u8>>,
    ) -> Result<ControlFlow<()>> {
        self.bytes = checkpoint()?;
        Ok(if Some(record.epoch) == self.epochs {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        })
    }
}

#[test]
fn a_potential_is_learnt_and_its_absence_is_not() {
    let source = source(120);
    let split = Split::grouped(&source.descriptions, 1, Fractions::default()).unwrap();
    let classes = classes(&source);
    let truth: Vec<usize> = split
        .test
        .iter()
        .map(|sample| classes.labels[*sample])
        .collect();
    let accuracy = |channels: &[&str]| {
        let settings = TrainingSettings {
            channels: channels.iter().map(|name| name.to_string()).collect(),
            ..settings(12)
        };
        let trained = train(
            &source,
            &classes,
            &split,
            &network(channels.len()),
            &settings,
            &mut (),
        )
        .unwrap();
        let p = trained
            .model
            .predict(&source, &split.test, PredictionSettings::default())
            .unwrap();
        Scores::from_probabilities(&p.probabilities, &truth, 2, None)
            .unwrap()
            .balanced_accuracy
    };
    let (with, without) = (accuracy(&["shape", "potential"]), accuracy(&["shape"]));
    assert!(with > 0.95, "{with}");
    assert!(without < 0.75, "{without}");
}

#[test]
fn two_and_two_epochs_are_four_bit_for_bit() {
    let (mut whole, mut first, mut second) =
        (Keeper::default(), Keeper::default(), Keeper::default());
    let four = run(&settings(4), None, &mut whole).unwrap();
    run(&settings(2), None, &mut first).unwrap();
    let resumed = run(&settings(4), Some(&first.bytes), &mut second).unwrap();
    assert_eq!(four.history, resumed.history);
    assert_eq!(
        four.model.to_bytes().unwrap(),
        resumed.model.to_bytes().unwrap()
    );
    // Everything: current weights, best weights, the memory of the optimiser, counters.
    assert!(whole.bytes == second.bytes);
}

#[test]
fn an_interrupted_epoch_is_repeated_in_full() {
    let (mut whole, mut broken, mut rest) = (
        Keeper::default(),
        Keeper {
            steps: Some(17),
            ..Keeper::default()
        },
        Keeper::default(),
    );
    run(&settings(3), None, &mut whole).unwrap();
    let interrupted = run(&settings(3), None, &mut broken).unwrap();
    assert_eq!(
        (interrupted.outcome, interrupted.history.len()),
        (Outcome::Interrupted, 1)
    );
    run(&settings(3), Some(&broken.bytes), &mut rest).unwrap();
    assert!(whole.bytes == rest.bytes);
    let mut one = Keeper {
        epochs: Some(1),
        ..Keeper::default()
    };
    assert_eq!(
        run(&settings(3), None, &mut one).unwrap().outcome,
        Outcome::Interrupted
    );
    assert!(one.bytes == broken.bytes);
}

#[test]
fn threads_do_not_matter_and_the_seed_does() {
    let weights = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let settings = TrainingSettings {
            seed,
            ..settings(2)
        };
        pool.install(|| {
            run(&settings, None, &mut ())
                .unwrap()
                .model
                .to_bytes()
                .unwrap()
        })
    };
    assert!(weights(1, 3) == weights(3, 3));
    assert!(weights(1, 3) != weights(1, 4));
}

#[test]
fn checkpoints_of_other_trainings_are_refused() {
    let mut keeper = Keeper::default();
    run(&settings(1), None, &mut keeper).unwrap();
    let other = TrainingSettings {
        learning_rate: 1e-4,
        ..settings(2)
    };
    let error = run(&other, Some(&keeper.bytes), &mut ())
        .unwrap_err()
        .to_string();
    assert!(error.contains("settings differ"), "{error}");
    let cut = &keeper.bytes[..keeper.bytes.len() - 9];
    assert!(
        run(&settings(2), Some(cut), &mut ())
            .unwrap_err()
            .to_string()
            .contains("checkpoint")
    );
    assert!(run(&settings(2), Some(b"nothing"), &mut ()).is_err());
}

/// A checkpoint that holds what was written, and does not fit.
#[test]
fn checkpoints_whose_lists_do_not_fit_are_refused() {
    let mut keeper = Keeper::default();
    run(&settings(2), None, &mut keeper).unwrap();
    let (tensors, progress): (Vec<(String, Tensor)>, Value) =
        container::unpack(&keeper.bytes, "checkpoint", &Device::Cpu).unwrap();
    let refused = |tensors: &[(String, Tensor)], progress: &Value, why: &str| {
        let bytes = container::pack(tensors, progress).unwrap();
        let said = run(&settings(3), Some(&bytes), &mut ())
            .unwrap_err()
            .to_string();
        assert!(said.contains(why), "{why}: {said}");
    };
    for (list, why) in [
        ("/card/classes", "1 classes where the training has 2"),
        ("/card/log_prior", "1 shares of classes where"),
        ("/card/channels", "1 channels where"),
        ("/card/scaling/channels", "1 scaled channels where"),
        ("/card/scaling/transforms", "1 scalings where"),
        ("/history", "steps of the optimiser where"),
    ] {
        let mut short = progress.clone();
        let list = short.pointer_mut(list).unwrap();
        list.as_array_mut().unwrap().pop().unwrap();
        if why.contains("optimiser") {
            short["best_epoch"] = 1.into();
        }
        refused(&tensors, &short, why);
    }
    let mut forged = progress.clone();
    forged["best_epoch"] = 7.into();
    refused(&tensors, &forged, "epoch 7 is its best");
    let mut late = progress.clone();
    late["history"].as_array_mut().unwrap().remove(0);
    refused(&tensors, &late, "lacks epochs: it has 1");
    for (prefix, why) in [
        ("network.", "weights where"),
        ("best.", "best weights where"),
    ] {
        let place = tensors
            .iter()
            .position(|(name, _)| name.starts_with(prefix));
        let mut fewer = tensors.clone();
        fewer.remove(place.unwrap());
        refused(&fewer, &progress, why);
    }
    let place = tensors
        .iter()
        .position(|(name, _)| name == "best.head.bias");
    let mut reshaped = tensors.clone();
    reshaped[place.unwrap()].1 = Tensor::zeros(5, DType::F32, &Device::Cpu).unwrap();
    refused(&reshaped, &progress, "head.bias");
    // Nothing else is wrong with them.
    let bytes = container::pack(&tensors, &progress).unwrap();
    run(&settings(3), Some(&bytes), &mut ()).unwrap();
}

/// A batch without a finite gradient is no step of the optimiser.
#[test]
fn a_checkpoint_with_a_skipped_step_is_continued() {
    let mut keeper = Keeper::default();
    run(&settings(1), None, &mut keeper).unwrap();
    let (mut tensors, mut progress): (Vec<(String, Tensor)>, Value) =
        container::unpack(&keeper.bytes, "checkpoint", &Device::Cpu).unwrap();
    let mut counter = tensors
        .iter_mut()
        .filter(|(name, _)| name == "optimiser.step");
    let (_, steps) = counter.next().unwrap();
    let taken = steps.to_scalar::<u32>().unwrap();
    *steps = Tensor::new(taken - 1, &Device::Cpu).unwrap();
    let short = container::pack(&tensors, &progress).unwrap();
    assert!(run(&settings(2), Some(&short), &mut ()).is_err());
    progress["history"][0]["skipped_steps"] = 1.into();
    let skipped = container::pack(&tensors, &progress).unwrap();
    run(&settings(2), Some(&skipped), &mut ()).unwrap();
}

#[test]
fn training_starts_from_the_prior() {
    // With a vanishing rate nothing is learnt: the loss stays at the entropy of the shares.
    for logit_adjustment in [0.0, 1.0] {
        let settings = TrainingSettings {
            learning_rate: 1e-12,
            logit_adjustment,
            ..settings(1)
        };
        let trained = run(&settings, None, &mut ()).unwrap();
        let shares: Vec<f64> = trained
            .model
            .card
            .log_prior
            .iter()
            .map(|log| log.exp())
            .collect();
        let entropy: f64 = shares.iter().map(|share| -share * share.ln()).sum();
        let loss = trained.history[0].training_loss_nats;
        assert!((loss / entropy - 1.0).abs() < 0.05, "{loss} {entropy}");
        // Predictions restore the prior, unless classes are to be treated alike.
        let source = source(60);
        let predict = |balanced| {
            let how = PredictionSettings {
                balanced,
                ..PredictionSettings::default()
            };
            trained
                .model
                .predict(&source, &[0, 1, 2], how)
                .unwrap()
                .probabilities
        };
        assert!(
            predict(false)
                .chunks(2)
                .all(|p| (p[1] - shares[1]).abs() < 0.1)
        );
        let expected = if logit_adjustment == 1.0 {
            0.5
        } else {
            shares[1]
        };
        assert!(
            predict(true)
                .chunks(2)
                .all(|p| (p[1] - expected).abs() < 0.1)
        );
    }
}

#[test]
fn damaged_samples_are_left_out_unless_they_are_a_whole_class() {
    let mut source = source(60);
    let split = Split::grouped(&source.descriptions, 1, Fractions::default()).unwrap();
    let (train_one, validation_one) = (split.training[3], split.validation[0]);
    source.grids[train_one].values[5] = f32::NAN;
    source.grids[validation_one].index[0] = 4000;
    let all = classes(&source);
    let trained = train(&source, &all, &split, &network(2), &settings(1), &mut ()).unwrap();
    let names: Vec<usize> = trained.quarantined.iter().map(|bad| bad.sample).collect();
    assert_eq!(names, [train_one, validation_one]);
    assert!(trained.quarantined[0].reason.contains("NaN"));
    let predicted = trained
        .model
        .predict(
            &source,
            &[train_one, split.test[0]],
            PredictionSettings::default(),
        )
        .unwrap();
    assert_eq!(
        (predicted.samples, predicted.probabilities.len()),
        (vec![split.test[0]], 2)
    );
    // The same as if they had never been there.
    let mut clean = split.clone();
    clean.training.retain(|sample| *sample != train_one);
    clean.validation.retain(|sample| *sample != validation_one);
    let without = train(&source, &all, &clean, &network(2), &settings(1), &mut ()).unwrap();
    assert_eq!(
        without.model.to_bytes().unwrap(),
        trained.model.to_bytes().unwrap()
    );
    for sample in &split.training {
        if source.descriptions[*sample].label == "minus" {
            source.grids[*sample].values[0] = f32::INFINITY;
        }
    }
    let error = train(&source, &all, &split, &network(2), &settings(1), &mut ())
        .unwrap_err()
        .to_string();
    assert!(error.contains("class minus"), "{error}");
}

#[test]
fn patience_ends_a_training_that_only_memorises() {
    let settings = TrainingSettings {
        channels: vec!["shape".into()],
        patience: Some(3),
        augment: false,
        ..settings(200)
    };
    let trained = run(&settings, None, &mut ()).unwrap();
    assert_eq!(trained.outcome, Outcome::Stopped);
    assert_eq!(trained.history.len(), trained.best_epoch + 3);
    let loss = |record: &EpochRecord| record.validation_loss_nats.unwrap();
    let least = trained
        .history
        .iter()
        .map(loss)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(loss(&trained.history[trained.best_epoch - 1]), least);
}

#[test]
fn predictions_over_all_rotations_do_not_depend_on_the_rotation() {
    let source = source(60);
    let trained = run(&settings(2), None, &mut ()).unwrap();
    let grids = CubeRotation::all()
        .iter()
        .map(|turn| turn.sparse(&source.grids[0]))
        .collect();
    let orientations = InMemory {
        grids,
        descriptions: vec![Description::default(); 24],
        ..source.clone()
    };
    let predict = |rotations| {
        let how = PredictionSettings {
            rotations,
            batch: 5,
            ..PredictionSettings::default()
        };
        let p = trained
            .model
            .predict(&orientations, &(0..24).collect::<Vec<_>>(), how)
            .unwrap()
            .probabilities;
        let first: Vec<f64> = p.chunks(2).map(|p| p[0]).collect();
        let mean = first.iter().sum::<f64>() / 24.0;
        (
            mean,
            first.iter().map(|p| (p - mean).abs()).fold(0.0, f64::max),
        )
    };
    let ((mean, spread), (averaged, averaged_spread)) = (predict(false), predict(true));
    assert!(
        spread > 1e-4 && averaged_spread < 1e-6,
        "{spread} {averaged_spread}"
    );
    assert!((mean - averaged).abs() < 1e-6);
}

#[test]
fn models_survive_as_bytes_and_can_be_calibrated() {
    let source = source(60);
    let mut trained = run(&settings(3), None, &mut ()).unwrap();
    let split = Split::grouped(&source.descriptions, 1, Fractions::default()).unwrap();
    let labels = classes(&source).labels;
    let how = PredictionSettings::default();
    let temperature = trained
        .model
        .calibrate(&source, &split.validation, &labels, None, how)
        .unwrap();
    assert!(temperature > 0.0 && temperature == trained.model.card.temperature);
    let copy = Model::from_bytes(&trained.model.to_bytes().unwrap()).unwrap();
    let p = |model: &Model| model.predict(&source, &split.test, how).unwrap();
    assert_eq!(p(&copy), p(&trained.model));
    assert!(Model::from_bytes(&trained.model.to_bytes().unwrap()[..50]).is_err());
    let mut shorter = trained.model.clone();
    shorter.card.scaling.transforms.pop();
    let refused = Model::from_bytes(&shorter.to_bytes().unwrap());
    assert!(refused.is_err_and(|error| error.to_string().contains("disagree")));
    let other = InMemory {
        channels: vec!["shape".into(), "charge".into()],
        ..source.clone()
    };
    assert!(copy.predict(&other, &[0], how).is_err());
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let with = |change: fn(&mut TrainingSettings)| {
        let mut settings = settings(1);
        change(&mut settings);
        run(&settings, None, &mut ()).unwrap_err().to_string()
    };
    assert!(with(|s| s.batch = 0).contains("batch"));
    assert!(with(|s| s.learning_rate = f64::NAN).contains("learning_rate"));
    assert!(with(|s| s.warm_up = -1.0).contains("warm_up"));
    assert!(with(|s| s.clip = Some(0.0)).contains("clip"));
    assert!(with(|s| s.channels = vec!["charge".into()]).contains("no channel charge"));
    assert!(with(|s| s.channels = vec!["shape".into(), "shape".into()]).contains("twice"));
    assert!(serde_json::from_str::<TrainingSettings>(r#"{"epoch": 3}"#).is_err());
    assert_eq!(
        serde_json::from_str::<TrainingSettings>("{}").unwrap(),
        TrainingSettings::default()
    );
}

#[test]
fn divergence_is_said_and_not_hidden() {
    let mut source = source(60);
    source
        .grids
        .iter_mut()
        .flat_map(|grid| grid.values.iter_mut())
        .for_each(|value| *value *= 1e30);
    let split = Split::grouped(&source.descriptions, 1, Fractions::default()).unwrap();
    let settings = TrainingSettings {
        scaling: ScalingMode::Raw,
        ..settings(2)
    };
    let error = train(
        &source,
        &classes(&source),
        &split,
        &network(2),
        &settings,
        &mut (),
    )
    .unwrap_err()
    .to_string();
    assert!(error.contains("diverged"), "{error}");
}

#[test]
fn the_weights_of_the_best_epoch_come_back() {
    let settings = TrainingSettings {
        channels: vec!["shape".into()],
        augment: false,
        ..settings(12)
    };
    let trained = run(&settings, None, &mut ()).unwrap();
    assert!(trained.best_epoch < 12, "{}", trained.best_epoch);
    let until_best = run(
        &TrainingSettings {
            epochs: trained.best_epoch,
            ..settings
        },
        None,
        &mut (),
    )
    .unwrap();
    assert_eq!(
        until_best.model.to_bytes().unwrap(),
        trained.model.to_bytes().unwrap()
    );
}

/// A network that cannot learn eight samples by heart has an error somewhere.
#[test]
fn eight_samples_are_learnt_by_heart() {
    let source = source(8);
    let all = Classes {
        names: vec!["a".into(), "b".into()],
        labels: vec![0, 1, 1, 0, 1, 0, 0, 1],
    };
    let split = Split {
        training: (0..8).collect(),
        ..Split::default()
    };
    let settings = TrainingSettings {
        epochs: 150,
        batch: 8,
        learning_rate: 1e-2,
        augment: false,
        ..settings(1)
    };
    let trained = train(&source, &all, &split, &network(2), &settings, &mut ()).unwrap();
    assert_eq!(
        (trained.best_epoch, trained.outcome),
        (150, Outcome::Completed)
    );
    let p = trained
        .model
        .predict(&source, &split.training, PredictionSettings::default())
        .unwrap()
        .probabilities;
    assert_eq!(
        Scores::from_probabilities(&p, &all.labels, 2, None)
            .unwrap()
            .accuracy,
        1.0
    );
}
