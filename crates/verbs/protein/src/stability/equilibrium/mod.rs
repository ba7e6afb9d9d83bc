//! How much of an assembly there is at equilibrium: the yield of the whole and of its parts over salt, pH and
//! concentration, by the partition functions of all connected parts and the law of mass action.
//!
//! ```text
//! DIR/run.toml  run.json  stability.csv  parts.csv  stability.json  stability.svg  stability.png
//! DIR/assembly/    assembly.json  *.body         bodies and places of a structure, at the first pH
//! DIR/condition/   run.json  checkpoint.bin      all salts at one pH
//! DIR/ph_4.50/                                   where a pH is stated
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is requested, as stored in `run.toml` |
//! | `input` | the assembly, from its file or from structure files at each pH |
//! | `interacting` | the energies between the bodies at one salt |
//! | `plan` | which bodies hold together, and the parts that this makes |
//! | `species` | copies of one protein |
//! | `condition` | one pH and all salts: a run in its own directory |
//! | `yields` | the law of mass action, with errors and half yields |
//! | `result` | what is found, and its table |
//! | `assembly` | the bodies of a structure, kept for the page and for other verbs |
//! | `box_proposal` | the box in which other verbs simulate them |
//! | `answer` | the answer in words and files |
//! | `figure` | yields against salt |
//! | [`page`] | the page of a directory |

mod answer;
mod assembly;
mod box_proposal;
mod condition;
pub mod figure;
mod input;
mod interacting;
pub mod page;
mod plan;
mod result;
mod settings;
mod species;
mod yields;

pub use input::{StabilityBodies, StructureChoices};
pub use protomer_mc::parts::{GrowthSettings, WindowSettings};
pub use result::{
    ConditionRow, HalfSaltRow, PartAtCondition, PartRow, SpeciesRow, StabilityResult,
};
pub use settings::{StabilitySettings, Way};
pub use yields::Mixture;

use crate::assemblies::assembly_file::Assembly;
use crate::stability::run::Engine;
use anyhow::{Error, Result};
use condition::{Condition, ConditionParts};
use plan::{Plan, in_medium};
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, ResultsDirectory, Shard, Work, carry_out,
    carry_out_shard, drive, settings as stored,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The directory of an equilibrium.
pub const LAYOUT: Layout = Layout {
    kind: ResultKind::Equilibrium,
    settings: "run.toml",
    results: &[
        "run.json",
        "stability.csv",
        "parts.csv",
        "stability.json",
        "stability.svg",
        "stability.png",
        "report.html",
    ],
    is_result,
};

/// Whether this is the folder of one condition, or of the bodies of a structure.
fn is_result(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let named = name == "condition" || name.starts_with("ph_");
    let is_assembly = name == assembly::FOLDER && path.join(assembly::FILE).is_file();
    (named && path.join("run.json").is_file()) || is_assembly
}

/// Makes the engine of an assembly, with the tables and the cache of the caller.
pub type Prepare<'a> = dyn Fn(Assembly) -> Result<Engine> + Sync + 'a;

/// Computes or continues the equilibrium of an assembly in a directory.
///
/// # Errors
/// For settings that make no sense, bodies that do not touch, a directory that holds other work or is in use, and files
/// that cannot be written.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::stability::equilibrium::{
///     StabilityBodies, StabilitySettings, StructureChoices, run_stability,
/// };
/// use protomer_protein_verbs::stability::model::Model;
/// use protomer_protein_verbs::stability::run::Engine;
/// use protomer_results::{End, Execution};
/// use std::path::Path;
/// let settings = StabilitySettings::of_model(Model::Natural1);
/// let bodies = StabilityBodies::read(&["4hhb.cif.gz".into()], &settings, &StructureChoices::default())?;
/// match run_stability(&bodies, &settings, &Engine::new, Path::new("4hhb"), &Execution::default())? {
///     End::Finished(found) => println!("{}", found.text()),
///     End::Stopped => println!("the same call continues it"),
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_stability(
    bodies: &StabilityBodies,
    settings: &StabilitySettings,
    prepare: &Prepare<'_>,
    directory: &Path,
    execution: &Execution,
) -> Result<End<StabilityResult>> {
    settings.check()?;
    ResultsDirectory::refuse_other_settings(directory, &LAYOUT, settings, execution)?;
    let plan = Plan::new(bodies.first(), &bodies.names, settings, prepare)?;
    let conditions = Conditions::new(bodies, &plan, settings, prepare, directory)?;
    carry_out(&conditions, directory, &LAYOUT, settings, execution)
}

/// Computes some of the conditions, while other processes compute others in the same directory; returns their
/// number.
/// [`run_stability`] finds them done and writes the tables and the figure.
///
/// # Errors
/// As [`run_stability`].
pub fn run_stability_shard(
    bodies: &StabilityBodies,
    settings: &StabilitySettings,
    prepare: &Prepare<'_>,
    directory: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    settings.check()?;
    ResultsDirectory::refuse_other_settings(directory, &LAYOUT, settings, execution)?;
    let plan = Plan::new(bodies.first(), &bodies.names, settings, prepare)?;
    let conditions = Conditions::new(bodies, &plan, settings, prepare, directory)?;
    carry_out_shard(&conditions, directory, &LAYOUT, settings, shard, execution)
}

/// All conditions of an equilibrium.
struct Conditions<'a> {
    bodies: &'a StabilityBodies,
    plan: &'a Plan,
    settings: &'a StabilitySettings,
    directory: &'a Path,
    identity: String,
    tasks: Vec<Condition<'a>>,
}

impl<'a> Conditions<'a> {
    fn new(
        bodies: &'a StabilityBodies,
        plan: &'a Plan,
        settings: &'a StabilitySettings,
        prepare: &'a Prepare<'_>,
        directory: &'a Path,
    ) -> Result<Self> {
        let identity = stored::identity(settings, &bodies.sha256)?;
        let mut tasks = Vec::new();
        for (number, ph) in settings.ph_values().into_iter().enumerate() {
            let engine = move |salt: usize| {
                let assembly = bodies.assembly(number, salt);
                in_medium(assembly, settings, settings.salt_molar[salt], prepare)
            };
            let salts = settings.salt_molar.iter();
            tasks.push(Condition {
                settings,
                plan,
                ph,
                identity: identity.clone(),
                input_sha256: bodies.sha256.clone(),
                engine: Box::new(engine),
                interacting: salts.map(|_| OnceLock::new()).collect(),
            });
        }
        Ok(Self {
            bodies,
            plan,
            settings,
            directory,
            identity,
            tasks,
        })
    }
}

impl<'a> Campaign for Conditions<'a> {
    type Task = Condition<'a>;
    type Part = (Option<f64>, ConditionParts);
    type Answer = StabilityResult;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::Equilibrium,
            "stability",
            &self.identity,
            &self.bodies.sha256,
        )
    }

    /// Tells a report where to find the bodies.
    fn details(&self) -> Value {
        json!({ assembly::KEY: assembly::path_in(self.bodies.first(), self.directory) })
    }

    fn tasks(&self) -> &[Condition<'a>] {
        &self.tasks
    }

    fn length(&self) -> (u64, &'static str) {
        (self.plan.parts.parts.len() as u64, "parts")
    }

    fn directory(&self, condition: &Condition<'a>) -> PathBuf {
        self.directory.join(condition.label())
    }

    fn run(
        &self,
        condition: &Condition<'a>,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Self::Part>> {
        let end = drive(condition, directory, execution);
        let end = end.map_err(|error| error.context(condition.label()))?;
        Ok(end.map(|parts| (condition.ph, parts)))
    }

    fn collect(&self, found: Vec<Self::Part>) -> Result<StabilityResult> {
        let result = StabilityResult::new(self.bodies, self.plan, self.settings, &found)?;
        assembly::keep(
            self.bodies.first(),
            result.proposed_box_angstrom,
            self.directory,
        )?;
        result.write(self.directory)?;
        Ok(result)
    }
}
