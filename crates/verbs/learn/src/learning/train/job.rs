//! A training with the ablation of its channels, and a control with all its experiments.

use super::ablation;
use super::control_report::{ControlReport, ExperimentReport};
use super::history::Validation;
use super::metrics::Metrics;
use super::run::{train_holding, train_in};
use super::settings::{Source, TrainSettings};
use anyhow::{Result, bail};
use protomer_kernel::setting::Choices;
use protomer_learn::Device;
use protomer_learn::ablation::{Ablation, AblationRun, plan};
use protomer_learn::controls::{Control, Experiment, Form};
use protomer_learn::sample::{InMemory, SampleSource};
use protomer_results::{End, Execution, ResultsDirectory, extend};
use std::path::Path;

/// A training, optionally with an ablation.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// The training.
    pub settings: TrainSettings,
    /// Number of seeds per subset of the channels; 0 for no ablation.
    pub ablation_seeds: u64,
}

impl Job {
    /// The trainings of the ablation with their folders, except the one that equals the main
    /// training.
    fn ablation(&self) -> Result<Vec<(String, TrainSettings)>> {
        if self.ablation_seeds == 0 {
            return Ok(Vec::new());
        }
        let (channels, first) = (
            &self.settings.training.channels,
            self.settings.training.seed,
        );
        let mut trainings = Vec::new();
        for (subset, seed) in plan(channels, first, self.ablation_seeds)? {
            let folder = format!("ablation/{}/seed_{seed}", subset.join("+"));
            let mut settings = self.settings.clone();
            (settings.training.channels, settings.training.seed) = (subset, seed);
            if settings != self.settings {
                trainings.push((folder, settings));
            }
        }
        Ok(trainings)
    }

    /// Total number of epochs.
    pub fn epochs(&self) -> u64 {
        let trainings = self.ablation().map_or(0, |trainings| trainings.len()) + 1;
        (trainings * self.settings.training.epochs) as u64
    }
}

/// Runs or continues a training and its ablation in a directory.
///
/// # Errors
/// For invalid settings, a directory that holds something else, or a file that cannot be written.
///
/// ```no_run
/// use protomer_learn_verbs::learning::train::{Job, TrainSettings, channels_of, open_set, run_job};
/// use protomer_learn::device::DeviceChoice;
/// use protomer_results::Execution;
/// use std::path::Path;
/// let (source, set) = open_set(Path::new("set.zarr"))?;
/// let settings = TrainSettings::of_set(source, channels_of(&set))?;
/// let job = Job { settings, ablation_seeds: 0 };
/// let device = DeviceChoice::Cpu.open()?;
/// run_job(&job, &set, Path::new("run"), &device, &Execution::default())?;
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_job(
    job: &Job,
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<End<Metrics>> {
    execution.progress.begin(job.epochs(), "epochs");
    Ok(train_and_ablate(job, set, path, device, execution)?.0)
}

/// Runs or continues a training and its ablation; also returns the directory, held for further work
/// in it.
fn train_and_ablate(
    job: &Job,
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<(End<Metrics>, ResultsDirectory)> {
    let trainings = job.ablation()?;
    let (main, held) = train_holding(&job.settings, set, path, device, execution)?;
    let End::Finished(metrics) = main else {
        return Ok((End::Stopped, held));
    };
    if trainings.is_empty() {
        return Ok((End::Finished(metrics), held));
    }
    let end = extend(path, &execution.interrupt, || {
        ablate(job, metrics, &trainings, set, path, device, execution)
    })?;
    Ok((end, held))
}

/// Runs or continues the further trainings of an ablation, and adds their table to the metrics of the
/// main one.
fn ablate(
    job: &Job,
    mut metrics: Metrics,
    trainings: &[(String, TrainSettings)],
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<End<Metrics>> {
    let run = |metrics: &Metrics, seed: u64, folder: &Path| -> Result<AblationRun> {
        Ok(metrics.ablation_run(seed, Validation::read(folder, metrics.best_epoch)?))
    };
    let mut runs = vec![run(&metrics, job.settings.training.seed, path)?];
    for (folder, settings) in trainings {
        let folder = path.join(folder);
        let End::Finished(of_subset) = train_in(settings, set, &folder, device, execution)? else {
            return Ok(End::Stopped);
        };
        runs.push(run(&of_subset, settings.training.seed, &folder)?);
    }
    let ablation = Ablation::from_runs(runs)?;
    ablation::write_csv(&ablation, path)?;
    metrics.ablation = Some(ablation);
    metrics.write(path)?;
    Ok(End::Finished(metrics))
}

/// A control with the settings of its experiments.
#[derive(Debug, Clone)]
pub struct ControlRun {
    control: Control,
    form: Form,
    /// Experiments with their jobs, the main one first; only it has an ablation.
    experiments: Vec<(Experiment, Job)>,
}

impl ControlRun {
    /// Builds a control; `adjust` may change the settings of each experiment.
    ///
    /// # Errors
    /// As `adjust`.
    pub fn new(
        control: Control,
        form: Form,
        seed: u64,
        ablation_seeds: u64,
        mut adjust: impl FnMut(&mut TrainSettings) -> Result<()>,
    ) -> Result<Self> {
        let mut experiments = Vec::new();
        for (number, experiment) in control.experiments().into_iter().enumerate() {
            let mut settings = TrainSettings::of_control(control, &experiment, form, seed);
            if number == 0 && ablation_seeds > 0 {
                let all = control.channels().iter();
                settings.training.channels = all.map(ToString::to_string).collect();
            }
            adjust(&mut settings)?;
            let ablation_seeds = if number == 0 { ablation_seeds } else { 0 };
            experiments.push((
                experiment,
                Job {
                    settings,
                    ablation_seeds,
                },
            ));
        }
        Ok(Self {
            control,
            form,
            experiments,
        })
    }

    /// Total number of epochs.
    pub fn epochs(&self) -> u64 {
        self.experiments.iter().map(|(_, job)| job.epochs()).sum()
    }
}

/// Runs or continues a control in a directory: the main experiment in it, the others in folders.
///
/// # Errors
/// As [`run_job`].
pub fn run_control(
    run: &ControlRun,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<End<Metrics>> {
    execution.progress.begin(run.epochs(), "epochs");
    let [(experiment, main), others @ ..] = run.experiments.as_slice() else {
        bail!("the control {} has no experiment", run.control.name())
    };
    let set = samples_of_control(&main.settings)?;
    let (end, _held) = train_and_ablate(main, &set, path, device, execution)?;
    let End::Finished(mut metrics) = end else {
        return Ok(End::Stopped);
    };
    extend(path, &execution.interrupt, || {
        let mut reports = vec![ExperimentReport::from_metrics(experiment, &metrics)];
        for (experiment, job) in others {
            let set = samples_of_control(&job.settings)?;
            let folder = path.join(experiment.name);
            let (end, _held) = train_and_ablate(job, &set, &folder, device, execution)?;
            let End::Finished(metrics) = end else {
                return Ok(End::Stopped);
            };
            reports.push(ExperimentReport::from_metrics(experiment, &metrics));
        }
        metrics.control = Some(ControlReport::from_experiments(
            run.control,
            run.form,
            reports,
        ));
        metrics.write(path)?;
        Ok(End::Finished(metrics))
    })
}

/// The samples that a control makes for itself.
fn samples_of_control(settings: &TrainSettings) -> Result<InMemory> {
    let Source::Control {
        name,
        variant,
        samples,
        size,
        seed,
    } = settings.source
    else {
        bail!("a control makes its own samples");
    };
    Ok(name.samples(variant, samples, size, seed))
}
