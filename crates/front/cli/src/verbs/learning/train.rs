//! `protomer train`: one network, or a control, in its directory; and the flags that `tune` shares
//! with it.

use super::labels::LabelArgs;
use crate::flags::device::DeviceArgs;
use crate::flags::execution::ExecutionArgs;
use crate::flags::override_with;
use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, anyhow, bail};
use clap::Args;
use protomer_common::range;
use protomer_learn::controls::{Control, Form};
use protomer_learn::network::GlobalPooling;
use protomer_learn::scaling::ScalingMode;
use protomer_learn::split::Fractions;
use protomer_learn::targets::Target;
use protomer_learn::training::Loss;
use protomer_learn::{BlockSettings, Device, View};
use protomer_learn_verbs::learning::labels::excluded_names;
use protomer_learn_verbs::learning::train::{
    ControlRun, Job, Metrics, SplitBy, TrainSettings, channels_of, open_set, run_control, run_job,
};
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_protein_verbs::file_kind::FileKind;
use protomer_results::{End, Execution, ResultKind};
use std::path::{Path, PathBuf};

/// The task. Omitted settings come from the defaults, or from the control.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Task")]
pub struct TaskArgs {
    /// The quantity to predict [default: label].
    #[arg(long, value_parser = choice::<Target>())]
    target: Option<Target>,
    /// Classes with fewer samples become one class, "other" [default: 10].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    least_samples: Option<usize>,
    /// Ordered classes that the numbers of --target number are cut into [default: 5].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    number_classes: Option<usize>,
    /// Loss; 'normal' predicts a number with its spread and needs --target number
    /// [default: cross-entropy].
    #[arg(long, value_parser = choice::<Loss>())]
    loss: Option<Loss>,
    /// Input channels of the network, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// Unit of the split [default: cluster].
    #[arg(long, value_parser = choice::<SplitBy>())]
    split_by: Option<SplitBy>,
    /// Seed of the split [default: that of --seed, or the one a configuration names].
    #[arg(long)]
    split_seed: Option<u64>,
    /// Shares of training, validation and test [default: 0.7,0.15,0.15].
    #[arg(long, value_delimiter = ',')]
    fractions: Option<Vec<f64>>,
    /// Share of the clusters of the training part to train on, for a learning curve; validation and test
    /// part stay the same [default: 1].
    #[arg(long)]
    training_share: Option<f64>,
    /// Scaling of the channels [default: robust].
    #[arg(long, value_parser = choice::<ScalingMode>())]
    scaling: Option<ScalingMode>,
    /// Exchanges of labels in the permutation test [default: 1000].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    permutations: Option<usize>,
    /// Average predictions over the 24 rotations of the cube, at 24 times the cost.
    #[arg(long)]
    rotations: bool,
}

impl TaskArgs {
    /// The set under the labels of the table, if there is one, which then decides the target unless a
    /// flag does.
    pub fn label<'a>(
        &self,
        labels: &LabelArgs,
        settings: &mut TrainSettings,
        set: &'a VoxelSet,
    ) -> Result<View<'a>> {
        let is_new = settings.labels.is_none();
        let Some(table) = labels.note(settings)? else {
            return Ok(View::new(set));
        };
        if is_new && self.target.is_none() {
            settings.target = table.target();
        }
        table.join(set, &excluded_names(set)?)
    }

    /// Overrides settings with the flags.
    pub fn override_in(&self, settings: &mut TrainSettings) -> Result<()> {
        override_with(&mut settings.target, self.target);
        override_with(&mut settings.least_samples, self.least_samples);
        if self.target.is_some() && settings.target != Target::Number {
            // Another target than that of the configuration has no use for its number of classes.
            settings.number_classes = None;
        }
        settings.number_classes = self.number_classes.or(settings.number_classes);
        if settings.number_classes.is_some() && settings.target != Target::Number {
            bail!("--number-classes cuts numbers into classes; add --target number, or omit it");
        }
        override_with(&mut settings.training.loss, self.loss);
        if let Some(channels) = &self.channels {
            settings.training.channels.clone_from(channels);
        }
        override_with(&mut settings.split_by, self.split_by);
        settings.split_seed = self.split_seed.or(settings.split_seed);
        settings.training_share = self.training_share.or(settings.training_share);
        if let Some(shares) = &self.fractions {
            let [training, validation, test] = shares[..] else {
                bail!(
                    "--fractions has {} shares; give three, such as 0.7,0.15,0.15",
                    shares.len()
                )
            };
            settings.fractions = Fractions {
                training,
                validation,
                test,
            };
        }
        override_with(&mut settings.training.scaling, self.scaling);
        override_with(&mut settings.permutations, self.permutations);
        settings.rotations |= self.rotations;
        Ok(())
    }
}

/// Upper limit: each seed trains every subset once.
const MOST_ABLATION_SEEDS: u64 = 1000;

/// The network and its optimisation.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
struct NetworkArgs {
    /// Channels of each block, separated by commas [default: 16,32,64].
    #[arg(long, value_delimiter = ',', value_parser = range::CHANNELS.number::<usize>())]
    widths: Option<Vec<usize>>,
    /// Edge of the kernels, 1, 3 or 5: one for all blocks, or one for each [default: 3].
    #[arg(long, value_delimiter = ',')]
    kernels: Option<Vec<usize>>,
    /// Groups of the group normalisation; 0 for none [default: 8].
    #[arg(long, value_parser = range::CHANNELS_OR_NONE.number::<usize>())]
    groups: Option<usize>,
    /// Pool by the average only at the end, instead of average and maximum.
    #[arg(long)]
    average_only: bool,
    /// Maximum number of passes over the training part [default: 50].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    epochs: Option<usize>,
    /// Stop after this many epochs without a smaller validation loss; 0 for never [default: 10].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    patience: Option<usize>,
    /// Logit adjustment τ: 0 learns with the observed class frequencies; 1 as if all classes
    /// were equally frequent, with the frequencies restored in the predictions [default: 0].
    #[arg(long)]
    logit_adjustment: Option<f64>,
    /// Samples per step [default: 8].
    #[arg(long, value_parser = range::OBJECTS.number::<usize>())]
    batch: Option<usize>,
    /// Learning rate after the warm-up [default: 0.001].
    #[arg(long)]
    learning_rate: Option<f64>,
    /// Seed of weights, order and rotations, and of the split without --split-seed [default: 1].
    #[arg(long)]
    seed: Option<u64>,
}

impl NetworkArgs {
    fn override_in(&self, settings: &mut TrainSettings) -> Result<()> {
        if self.widths.is_some() || self.kernels.is_some() || self.groups.is_some() {
            let present =
                |value: fn(&BlockSettings) -> usize| settings.blocks.iter().map(value).collect();
            let widths = self
                .widths
                .clone()
                .unwrap_or_else(|| present(|block| block.width));
            let kernels = self.kernels.clone().unwrap_or_else(|| match self.widths {
                Some(_) => vec![3],
                None => present(|block| block.kernel),
            });
            let groups = self.groups.or(settings
                .blocks
                .first()
                .map(|block| block.groups.unwrap_or(0)));
            settings.blocks = BlockSettings::chain(&widths, &kernels, groups.unwrap_or(0))?;
        }
        if self.average_only {
            settings.pooling = GlobalPooling::Average;
        }
        override_with(&mut settings.training.epochs, self.epochs);
        if let Some(patience) = self.patience {
            // TOML has no null, so a number that is never reached means never.
            settings.training.patience = Some(if patience > 0 { patience } else { 1_000_000 });
        }
        override_with(&mut settings.training.batch, self.batch);
        override_with(
            &mut settings.training.logit_adjustment,
            self.logit_adjustment,
        );
        override_with(&mut settings.training.learning_rate, self.learning_rate);
        override_with(&mut settings.training.seed, self.seed);
        Ok(())
    }
}

/// Train a network on a set of voxels, or on a control. The same command continues it.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "train set.zarr --target crystal-system --epochs 40 -o run",
    "train --control charge --short -o charge"
))]
#[group(id = "TrainResult")]
pub struct TrainArgs {
    /// Set of voxels (zarr), made by 'protomer voxelize'.
    #[arg(required_unless_present = "control", conflicts_with = "control")]
    set: Option<PathBuf>,
    /// Synthetic set with a known answer: shapes, charge, patch, xor, assemblies, permuted,
    /// identity, orientation, size or heavy-tails.
    #[arg(long)]
    control: Option<String>,
    /// The control's short form: coarser grids, fewer samples.
    #[arg(long, requires = "control")]
    short: bool,
    /// Settings (TOML), such as the best.toml of a search or the settings.toml of another training;
    /// flags override them.
    #[arg(long, conflicts_with = "control")]
    config: Option<PathBuf>,
    /// Directory of another training: its weights are where this one starts, and its blocks, channels
    /// and scaling the defaults.
    #[arg(long, value_name = "DIR", conflicts_with = "control")]
    weights_from: Option<PathBuf>,
    /// Train on every subset of the channels as well.
    #[arg(long)]
    ablate: bool,
    /// Number of seeds per subset.
    #[arg(long, default_value_t = 3, requires = "ablate")]
    ablation_seeds: u64,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    labels: LabelArgs,
    #[command(flatten)]
    task: TaskArgs,
    #[command(flatten)]
    network: NetworkArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl TrainArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let device = self.device.open()?;
        let execution = self.execution.execution(front)?;
        self.check()?;
        let end = match (&self.control, &self.set) {
            (Some(name), _) => self.train_control(name, &device, &execution)?,
            (None, Some(path)) => self.train_on_set(path, &device, &execution)?,
            (None, None) => bail!("give a set of voxels, or --control NAME"),
        };
        let End::Finished(metrics) = end else {
            let directory = self.output.display();
            return Ok(Reply::stopped(format!(
                "stopped; the same command continues {directory}"
            )));
        };
        let control = metrics.control.as_ref();
        let has_missed = control.is_some_and(|control| !control.reached);
        let cautions = metrics.cautions().into_iter();
        let warnings: Vec<String> = cautions
            .map(|caution| format!("warning: {caution}"))
            .collect();
        Ok(Reply::from_answer(metrics)
            .with_notes(warnings)
            .partial_if(has_missed))
    }

    fn check(&self) -> Result<()> {
        // With a set instead of a control, clap does not check what --short requires.
        if self.short && self.control.is_none() {
            bail!("--short is the short form of a control; add --control NAME, or omit --short");
        }
        if !(1..=MOST_ABLATION_SEEDS).contains(&self.ablation_seeds) {
            bail!(
                "--ablation-seeds is {}; give 1 to {MOST_ABLATION_SEEDS}",
                self.ablation_seeds
            );
        }
        Ok(())
    }

    /// Number of seeds per subset of the channels; 0 for no ablation.
    fn seeds(&self) -> u64 {
        if self.ablate { self.ablation_seeds } else { 0 }
    }

    fn train_control(
        &self,
        name: &str,
        device: &Device,
        execution: &Execution,
    ) -> Result<End<Metrics>> {
        self.labels.refuse("a control makes its own labels")?;
        let control = Control::named(name).map_err(|error| anyhow!(error))?;
        let form = if self.short { Form::Short } else { Form::Full };
        let seed = self.network.seed.unwrap_or(1);
        let mut is_main = true;
        let adjust = |settings: &mut TrainSettings| {
            // The other experiments have fixed channels.
            let channels = settings.training.channels.clone();
            self.task.override_in(settings)?;
            if !std::mem::take(&mut is_main) {
                settings.training.channels = channels;
            }
            self.network.override_in(settings)
        };
        let run = ControlRun::new(control, form, seed, self.seeds(), adjust)?;
        run_control(&run, &self.output, device, execution)
    }

    fn train_on_set(
        &self,
        path: &Path,
        device: &Device,
        execution: &Execution,
    ) -> Result<End<Metrics>> {
        FileKind::Results(ResultKind::VoxelSet).require(path)?;
        let (source, set) = open_set(path)?;
        let mut settings = match &self.config {
            None => TrainSettings::of_set(source, channels_of(&set))?,
            Some(path) => TrainSettings {
                source,
                ..TrainSettings::read(path)?
            },
        };
        if let Some(directory) = &self.weights_from {
            if self.ablate {
                bail!(
                    "--weights-from starts from a network of certain channels, so there is no --ablate \
                     of them; omit one of the two"
                );
            }
            settings.start_from(directory)?;
        }
        let labelled = self.task.label(&self.labels, &mut settings, &set)?;
        self.task.override_in(&mut settings)?;
        self.network.override_in(&mut settings)?;
        let job = Job {
            settings,
            ablation_seeds: self.seeds(),
        };
        run_job(&job, &labelled, &self.output, device, execution)
    }
}
