//! Two bodies: virial coefficient, potential of mean force, association, bound poses, over a grid
//! of salt and pH.
//!
//! ```text
//! DIR/run.toml  run.json  pair.csv  pair.json  pair.svg  pair.png
//! DIR/pair_map.svg  pair_map.png                                        with several salts and pH values
//! DIR/salt_0.100000M/        run.json  checkpoint.bin  mean_force.csv   one condition each
//! DIR/salt_0.100000M/        residues.csv                           energies of residues at its poses
//! DIR/salt_0.100000M/poses/  pose_01.pdb  pose_01.cif ...               its bound poses
//! DIR/ph_4.50_salt_0.100000M/                                           where a pH is stated
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is requested, as stored in `run.toml` |
//! | `input` | body files, or structure files made into bodies at each pH |
//! | `condition` | one salt and pH: a run in its own directory |
//! | `residues` | which residues hold a pose together |
//! | `pose_files` | bound poses with all atoms |
//! | `result` | what is found, and its table |
//! | `figure` | B₂ against salt, over salt and pH, and w(r) |
//! | [`page`] | the page of a directory |

mod answer;
mod condition;
pub mod figure;
mod input;
pub mod page;
mod pose_files;
mod residues;
mod result;
mod settings;

pub use input::PairBodies;
pub(super) use input::protonations;
pub use protomer_mc::contributions::ResiduePlaces;
pub use residues::ResidueTable;
pub use result::{ConditionResult, PairResult, PoseResult};
pub use settings::{Energies, PairRunSettings};

use anyhow::{Error, Result};
use condition::Condition;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, Shard, Work, carry_out, carry_out_shard, drive,
    settings as stored,
};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The directory of a pair.
pub const LAYOUT: Layout = Layout {
    kind: ResultKind::Pair,
    settings: "run.toml",
    results: &[
        "run.json",
        "pair.csv",
        "pair.json",
        "pair.svg",
        "pair.png",
        "pair_map.svg",
        "pair_map.png",
        "report.html",
    ],
    is_result: is_condition,
};

/// Whether this is the folder of one condition.
fn is_condition(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let named = name.starts_with("salt_") || name.starts_with("ph_") || name == "condition";
    named && path.join("run.json").is_file()
}

/// Computes or continues the thermodynamics of two bodies in a directory.
///
/// # Errors
/// For settings that make no sense, a directory that holds other work or is in use, and files that
/// cannot be written.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::stability::pair::{PairBodies, PairRunSettings, run_pair};
/// use protomer_results::{End, Execution};
/// use std::path::Path;
/// let file = Path::new("4lzt.pdb.gz");
/// let settings = PairRunSettings {
///     salt_molar: vec![0.1, 0.3, 0.5],
///     ph: vec![4.5],
///     ..PairRunSettings::default()
/// };
/// let bodies = PairBodies::read(file, None, &settings)?;
/// match run_pair(&bodies, &settings, Path::new("lysozyme"), &Execution::default())? {
///     End::Finished(pair) => println!("{}", pair.text()),
///     End::Stopped => println!("the same call continues it"),
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_pair(
    bodies: &PairBodies,
    settings: &PairRunSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<End<PairResult>> {
    let conditions = Conditions::new(bodies, settings, directory)?;
    carry_out(&conditions, directory, &LAYOUT, settings, execution)
}

/// Computes some of the conditions, while other processes compute others in the same directory; returns their
/// number.
/// [`run_pair`] finds them done and writes the table and the figure.
///
/// # Errors
/// As [`run_pair`].
pub fn run_pair_shard(
    bodies: &PairBodies,
    settings: &PairRunSettings,
    directory: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    let conditions = Conditions::new(bodies, settings, directory)?;
    carry_out_shard(&conditions, directory, &LAYOUT, settings, shard, execution)
}

/// All conditions of a pair.
struct Conditions<'a> {
    bodies: &'a PairBodies,
    settings: &'a PairRunSettings,
    directory: &'a Path,
    identity: String,
    tasks: Vec<Condition<'a>>,
}

impl<'a> Conditions<'a> {
    fn new(
        bodies: &'a PairBodies,
        settings: &'a PairRunSettings,
        directory: &'a Path,
    ) -> Result<Self> {
        settings.check()?;
        let identity = stored::identity(settings, &bodies.sha256)?;
        let mut tasks = Vec::new();
        for (ph, pairs) in bodies.at_each_ph() {
            for (number, salt_molar) in settings.salts().into_iter().enumerate() {
                // One pair serves all salts unless its charges depend on them.
                let pair = &pairs[number.min(pairs.len() - 1)];
                let store = bodies.effective_store.as_ref();
                tasks.push(Condition::new(
                    settings, pair, ph, salt_molar, &identity, store,
                )?);
            }
        }
        Ok(Self {
            bodies,
            settings,
            directory,
            identity,
            tasks,
        })
    }
}

impl<'a> Campaign for Conditions<'a> {
    type Task = Condition<'a>;
    type Part = ConditionResult;
    type Answer = PairResult;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::Pair,
            "pair",
            &self.identity,
            &self.bodies.sha256,
        )
    }

    /// Tells a report where to find the surfaces of the bodies.
    fn details(&self) -> Value {
        self.bodies.details(self.directory)
    }

    fn tasks(&self) -> &[Condition<'a>] {
        &self.tasks
    }

    fn length(&self) -> (u64, &'static str) {
        (self.settings.steps(), "steps")
    }

    fn directory(&self, condition: &Condition<'a>) -> PathBuf {
        self.directory.join(condition.label())
    }

    fn run(
        &self,
        condition: &Condition<'a>,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<ConditionResult>> {
        let end = drive(condition, directory, execution);
        end.map_err(|error| error.context(condition.label()))
    }

    fn collect(&self, conditions: Vec<ConditionResult>) -> Result<PairResult> {
        let result = PairResult::new(self.bodies, self.settings, conditions);
        result.write(self.directory)?;
        Ok(result)
    }
}
