//! A sweep: salt concentrations × replicas, on all threads, resumable, with one table and one
//! figure at the end.
//!
//! ```text
//! DIR/run.toml  run.json  sweep.csv  sweep.json  sweep.svg  sweep.png
//! DIR/simulation.svg  simulation.png   instead of the curve, for a single simulation
//! DIR/salt_0.100000M/replica_0/ log.csv trajectory.gsd checkpoint.bin run.json
//! DIR/ladder_0/ checkpoint.bin run.json   with exchange between salt concentrations
//! ```

pub mod figure;
pub mod half_salt;
pub mod page;
pub mod result;
pub mod series;
pub mod stability;
pub mod table;

use crate::stability::effective;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{
    AcceptedFractions, EnergyMode, Engine, Exchanged, GivenState, LadderRun, LogRow, Replica,
    RunSettings, Rung, replica_directory,
};
use anyhow::{Context, Error, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::atomic::{sha256_hex, write_atomically};
use protomer_kernel::Boundary;
use protomer_mc::observables::contacts;
use protomer_plot::Figure;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, ResultsDirectory, Shard, Work, carry_out,
    carry_out_shard, drive, keys, log, settings,
};
use result::{RESULT, SweepResult};
use serde_json::{Value, json};
use stability::Stability;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use table::{ReplicaResult, SaltRow, to_csv};

/// The directory of a sweep.
const LAYOUT: Layout = Layout {
    kind: ResultKind::Sweep,
    settings: "run.toml",
    results: &[
        "run.json",
        "sweep.csv",
        "sweep.json",
        "sweep.svg",
        "sweep.png",
        "simulation.svg",
        "simulation.png",
        "report.html",
    ],
    is_result: is_simulation,
};

impl Answer for SweepResult {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "salt (M)",
            "R_g (Å)",
            "± sd",
            "native contacts",
            "bound",
            "largest cluster",
            "energy (kT)",
        ])];
        for row in &self.salts {
            let averages = &row.averages;
            rows.push(vec![
                format!("{:.4}", row.salt_molar),
                format!("{:.2}", averages.r_g_angstrom.mean),
                // The deviation of one replica from itself says nothing.
                match row.replicas {
                    1 => "-".into(),
                    _ => format!("{:.2}", averages.r_g_angstrom.deviation),
                },
                format!("{:.3}", averages.native_contacts.mean),
                format!("{:.3}", averages.bound_fraction.mean),
                format!("{:.2}", averages.largest_cluster.mean),
                format!("{:.2}", averages.energy_kt.mean),
            ]);
        }
        let mut lines = vec![self.stability.verdict(), columns(&rows)];
        for exchanged in &self.exchanges {
            lines.push(exchanged.text());
        }
        lines.extend(self.stability.lines());
        lines.extend(self.missing_errors());
        lines.push(self.settings.what_attracts());
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(self))
    }
}

/// Whether this is the folder of the simulations at one salt concentration, of a ladder, or of what
/// other verbs make of them.
fn is_simulation(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_of_salt = name.starts_with("salt_") && name.ends_with('M');
    // A folder of the user may be called so too; the record tells ours.
    let is_ladder = name.starts_with("ladder_") && path.join("run.json").is_file();
    let companions = [
        crate::stability::residues::FOLDER,
        crate::stability::reweighting::FOLDER,
        crate::scattering::FOLDER,
    ];
    let is_companion = companions.contains(&name.as_ref()) && path.is_dir();
    (is_of_salt && path.join("replica_0").is_dir()) || is_ladder || is_companion
}

/// Runs or continues a sweep in a directory.
///
/// # Errors
/// For invalid settings or an impossible start, a directory that holds other work or is in use by
/// another process, or a file that cannot be written. If a simulation fails, the others stop at
/// their next sweep and keep their progress, and `run.json` records the error.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::assemblies::assembly_file::Assembly;
/// use protomer_protein_verbs::stability::{run::{Engine, RunSettings}, sweep::run_sweep};
/// use protomer_results::{End, Execution};
/// use std::path::Path;
/// let engine = Engine::new(Assembly::read(Path::new("6mdr/assembly.json"))?)?;
/// let salt_molar = protomer_common::quantity::salt_list("10mM..300mM/8")?;
/// let settings = RunSettings { salt_molar, ..RunSettings::default() };
/// match run_sweep(&engine, &settings, Path::new("sweep"), &Execution::default())? {
///     End::Finished(sweep) => println!("{}", sweep.text()),
///     End::Stopped => println!("the same call continues it"),
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_sweep(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<End<SweepResult>> {
    let settings = &resolved(engine, settings, directory, execution)?;
    let sweep = Sweep::new(engine, settings, directory)?;
    carry_out(&sweep, directory, &LAYOUT, settings, execution)
}

/// Runs or continues one simulation in a directory: a sweep of one salt concentration and one
/// replica.
///
/// # Errors
/// As [`run_sweep`]; also if the settings describe several simulations.
pub fn simulate(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<End<ReplicaResult>> {
    if settings.simulations() != 1 {
        bail!("the settings describe several simulations; use 'protomer sweep'");
    }
    let End::Finished(result) = run_sweep(engine, settings, directory, execution)? else {
        return Ok(End::Stopped);
    };
    let only = result.replicas.into_iter().flatten().next();
    let of_salt = result.salts.into_iter().next();
    Ok(End::Finished(ReplicaResult {
        effective_bodies: of_salt.and_then(|row| row.effective_bodies),
        warnings: result.warnings,
        ..only.context("the simulation has left no result")?
    }))
}

/// Runs or continues the simulations of one part of a sweep, while other processes do other parts
/// in the same directory; returns their number. [`run_sweep`] finds them done and writes the table and the figure.
///
/// # Errors
/// As [`run_sweep`].
pub fn run_shard(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    let settings = &resolved(engine, settings, directory, execution)?;
    let sweep = Sweep::new(engine, settings, directory)?;
    carry_out_shard(&sweep, directory, &LAYOUT, settings, shard, execution)
}

/// The settings with everything chosen that they leave open, as [`run_sweep`] uses and stores them.
/// A sweep that is continued keeps its energy mode.
///
/// # Errors
/// As [`Engine::resolved`].
pub fn resolved(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<RunSettings> {
    settings.check()?;
    refuse_other_settings(settings, directory, execution)?;
    engine.require_space_for(settings)?;
    engine.resolved(settings, begun_energy(directory, execution))
}

/// Refuses a directory with other settings, before bodies are read or charges fitted.
///
/// # Errors
/// If the directory holds other work or other settings, and there is no new start.
pub fn refuse_other_settings(
    settings: &RunSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<()> {
    let begun = begun_energy(directory, execution);
    let settings = Engine::resolved_as_begun(settings, begun);
    ResultsDirectory::refuse_other_settings(directory, &LAYOUT, &settings, execution)?;
    Ok(())
}

/// The energy mode of a sweep that is continued.
fn begun_energy(directory: &Path, execution: &Execution) -> Option<EnergyMode> {
    // A new start forgets the old settings, its energy mode among them.
    if execution.start_anew {
        return None;
    }
    // A file that cannot be read is reported when the directory is entered.
    let begun = keys::read_toml::<RunSettings>(&directory.join(LAYOUT.settings)).ok()?;
    begun.energy
}

/// Task of a sweep that runs by itself.
enum Task {
    /// One simulation.
    Simulation { salt_index: usize, replica: u32 },
    /// One replica at all salt concentrations, which exchange their states.
    Ladder { replica: u32 },
}

/// Result of a task.
struct Part {
    replica: u32,
    /// Acceptance ratios, with the index of the salt concentration.
    accepted: Vec<(usize, AcceptedFractions)>,
    exchanged: Option<Exchanged>,
}

/// One salt concentration of a sweep.
struct Medium {
    interaction: ScreenedCoulomb,
    /// Engine with the effective charges and the terms of this medium, made by the first simulation
    /// that needs it.
    engine: OnceLock<Engine>,
}

/// A sweep whose settings have been checked.
struct Sweep<'a> {
    engine: &'a Engine,
    settings: &'a RunSettings,
    directory: &'a Path,
    media: Vec<Medium>,
    state: Option<GivenState>,
    identity: String,
    tasks: Vec<Task>,
}

impl<'a> Sweep<'a> {
    fn new(engine: &'a Engine, settings: &'a RunSettings, directory: &'a Path) -> Result<Self> {
        settings.check()?;
        let of_salt = |salt: &f64| settings.medium.interaction(Some(*salt));
        let interactions: Vec<ScreenedCoulomb> = settings
            .salt_molar
            .iter()
            .map(of_salt)
            .collect::<Result<_>>()?;
        engine.check(settings, &interactions)?;
        let medium = |interaction| Medium {
            interaction,
            engine: OnceLock::new(),
        };
        let state = GivenState::wanted(settings, engine)?;
        let of_assembly = &engine.assembly().sha256;
        let input = match &state {
            None => of_assembly.clone(),
            Some(state) => sha256_hex((of_assembly.clone() + &state.sha256()).as_bytes()),
        };
        Ok(Self {
            engine,
            settings,
            directory,
            media: interactions.into_iter().map(medium).collect(),
            state,
            identity: settings::identity(settings, &input)?,
            tasks: tasks(settings),
        })
    }

    /// The engine for one salt concentration, which its replicas share.
    fn engine(&self, salt_index: usize) -> Result<&Engine> {
        let settings = self.settings;
        // Nothing depends on the salt but the charges' screening: one engine serves all.
        if settings.effective_charges.is_none() && settings.further_terms().is_none() {
            return Ok(self.engine);
        }
        let Medium {
            interaction,
            engine,
        } = &self.media[salt_index];
        // Filled by whoever comes first.
        if let Some(engine) = engine.get() {
            return Ok(engine);
        }
        // Two replicas may both come here; the charges are fitted once all the same.
        let made = self.engine.in_medium(self.settings, interaction)?;
        made.check(self.settings, &[*interaction])?;
        Ok(engine.get_or_init(|| made))
    }

    fn run_simulation(
        &self,
        salt_index: usize,
        replica: u32,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Part>> {
        let simulation = Replica {
            engine: self.engine(salt_index)?,
            settings: self.settings,
            interaction: self.media[salt_index].interaction,
            salt_index: salt_index as u32,
            replica,
            state: self.state.as_ref(),
            identity: &self.identity,
        };
        let end = drive(&simulation, directory, execution)?;
        Ok(end.map(|accepted| Part {
            replica,
            accepted: vec![(salt_index, accepted)],
            exchanged: None,
        }))
    }

    fn run_ladder(
        &self,
        replica: u32,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Part>> {
        // By salt: only neighbours in this order exchange states.
        let order = self.salts_ascending();
        let mut rungs = Vec::with_capacity(order.len());
        for &salt_index in &order {
            let salt_molar = self.settings.salt_molar[salt_index];
            rungs.push(Rung {
                engine: self.engine(salt_index)?,
                interaction: self.media[salt_index].interaction,
                salt_index: salt_index as u32,
                directory: replica_directory(self.directory, salt_molar, replica),
            });
        }
        let ladder = LadderRun {
            rungs,
            settings: self.settings,
            replica,
            state: self.state.as_ref(),
            identity: &self.identity,
        };
        let end = drive(&ladder, directory, execution)?;
        Ok(end.map(|answer| Part {
            replica,
            accepted: order.into_iter().zip(answer.accepted).collect(),
            exchanged: Some(answer.exchanged),
        }))
    }

    /// Indices of the salt concentrations, the lowest first: only neighbours exchange states.
    fn salts_ascending(&self) -> Vec<usize> {
        let salts = &self.settings.salt_molar;
        let mut order: Vec<usize> = (0..salts.len()).collect();
        order.sort_by(|a, b| salts[*a].total_cmp(&salts[*b]));
        order
    }
}

impl Sweep<'_> {
    /// Warnings about the energies: fits that stand badly for a body, and bodies nearer to each
    /// other than effective charges hold.
    fn warnings(&self, salts: &[SaltRow], replicas: &[Vec<ReplicaResult>]) -> Result<Vec<String>> {
        let bodies = salts.iter().flat_map(|row| &row.effective_bodies).flatten();
        let mut warnings = effective::warnings(bodies);
        let contacts = replicas
            .iter()
            .flatten()
            .filter_map(|one| one.averages.contacts);
        let most = contacts.map(|contacts| contacts.mean).fold(0.0, f64::max);
        let system = self.engine.system()?;
        warnings.extend(effective::run_warning(&system, self.settings, most));
        Ok(warnings)
    }
}

impl Campaign for Sweep<'_> {
    type Task = Task;
    type Part = Part;
    type Answer = SweepResult;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::Sweep,
            "sweep",
            &self.identity,
            &self.engine.assembly().sha256,
        )
    }

    /// Tells a report where to find the shapes of the bodies.
    fn details(&self) -> Value {
        json!({ "assembly": self.engine.assembly().path_from(self.directory) })
    }

    fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    fn length(&self) -> (u64, &'static str) {
        // With exchange a task is a whole ladder.
        let simulations = match self.settings.exchange_every {
            0 => 1,
            _ => self.settings.salt_molar.len() as u64,
        };
        let sweeps = self.settings.total_sweeps();
        (simulations.saturating_mul(sweeps), "sweeps")
    }

    fn directory(&self, task: &Task) -> PathBuf {
        match *task {
            Task::Simulation {
                salt_index,
                replica,
            } => {
                let salt_molar = self.settings.salt_molar[salt_index];
                replica_directory(self.directory, salt_molar, replica)
            }
            Task::Ladder { replica } => self.directory.join(format!("ladder_{replica}")),
        }
    }

    fn run(&self, task: &Task, directory: &Path, execution: &Execution) -> Result<End<Part>> {
        match *task {
            Task::Simulation {
                salt_index,
                replica,
            } => self
                .run_simulation(salt_index, replica, directory, execution)
                .with_context(|| {
                    let salt = self.settings.salt_molar[salt_index];
                    format!("salt {salt} M, replica {replica}")
                }),
            Task::Ladder { replica } => self
                .run_ladder(replica, directory, execution)
                .with_context(|| format!("replica {replica}")),
        }
    }

    /// Averages every log, and writes the table and the figure.
    fn collect(&self, parts: Vec<Part>) -> Result<SweepResult> {
        let mut replicas = vec![Vec::new(); self.settings.salt_molar.len()];
        let mut exchanges = Vec::new();
        let mut only_log = Vec::new();
        for part in parts {
            for (salt_index, accepted) in part.accepted {
                let salt_molar = self.settings.salt_molar[salt_index];
                let directory = replica_directory(self.directory, salt_molar, part.replica);
                let rows: Vec<LogRow> = log::read(&directory.join("log.csv"))?;
                let result = ReplicaResult::new(part.replica, &rows, accepted);
                replicas[salt_index].push(result);
                // With one simulation this is its log; with several nothing is shown of it.
                only_log = rows;
            }
            exchanges.extend(part.exchanged);
        }
        let mut salts = Vec::with_capacity(replicas.len());
        for (salt_index, replicas) in replicas.iter().enumerate() {
            let salt_molar = self.settings.salt_molar[salt_index];
            let interaction = &self.media[salt_index].interaction;
            let bodies = self.engine(salt_index)?.effective_bodies();
            salts.push(SaltRow {
                effective_bodies: bodies.map(<[_]>::to_vec),
                ..SaltRow::new(salt_molar, interaction, replicas)
            });
        }
        let assembly = self.engine.assembly();
        let gap_angstrom = self.settings.contact_gap_angstrom;
        let native = contacts(&self.engine.system()?, gap_angstrom).len();
        let is_open = matches!(assembly.boundary, Boundary::Open);
        let stability = Stability::new(self.settings, &replicas, native, is_open);
        let result = SweepResult {
            equilibrium: stability.equilibrium().into(),
            warnings: self.warnings(&salts, &replicas)?,
            stability,
            exchanges,
            version: env!("CARGO_PKG_VERSION").into(),
            model: self.settings.model_name(&assembly.bodies).into(),
            input_sha256: assembly.sha256.clone(),
            bodies: assembly.len(),
            concentration_molar: assembly.concentration_molar(),
            box_angstrom: assembly.box_angstrom(),
            settings: self.settings.clone(),
            salts,
            replicas,
            time_series: match self.settings.simulations() {
                1 => only_log,
                _ => Vec::new(),
            },
        };
        write_results(&result, self.directory)?;
        Ok(result)
    }
}

/// All tasks of the sweep, ordered by replica first, so that an interrupted sweep has a complete
/// curve early.
fn tasks(settings: &RunSettings) -> Vec<Task> {
    let of_replica = |replica| -> Vec<Task> {
        if settings.exchange_every > 0 {
            return vec![Task::Ladder { replica }];
        }
        let simulation = |salt_index| Task::Simulation {
            salt_index,
            replica,
        };
        (0..settings.salt_molar.len()).map(simulation).collect()
    };
    (0..settings.replicas).flat_map(of_replica).collect()
}

fn write_results(result: &SweepResult, directory: &Path) -> Result<()> {
    let csv = to_csv(&result.salts)?;
    let json = serde_json::to_string_pretty(result).context("the result cannot be serialised")?;
    write_atomically(&directory.join("sweep.csv"), |file| {
        file.write_all(csv.as_bytes())
    })?;
    write_atomically(&directory.join(RESULT), |file| writeln!(file, "{json}"))?;
    figure::write(result, directory)
}
