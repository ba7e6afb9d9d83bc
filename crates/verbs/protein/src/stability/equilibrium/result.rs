//! The equilibrium of an assembly and its parts, as JSON has it.

use super::box_proposal::proposed_box_angstrom;
use super::condition::{ConditionParts, MOST_AT_LIMIT, PartFound};
use super::input::StabilityBodies;
use super::plan::Plan;
use super::yields::{Counted, Interval, Mixture, PartLogs, half_salt};
use super::{StabilitySettings, Way};
use anyhow::Result;
use protomer_mc::parts::{PartKind, WindowsFound};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Bodies farther than this from their place in the assembly are in another arrangement, Å.
const SAME_PLACE_ANGSTROM: f64 = 2.5;
/// A part with a smaller share of the bodies decides nothing.
const LEAST_SHARE: f64 = 0.01;
/// Largest error of a logarithm of a partition function that an answer may rest on.
const MOST_ERROR: f64 = 3.0;

/// Smallest share of accepted exchanges with which windows overlap.
const LEAST_EXCHANGED: f64 = 0.03;
/// Fewest frames, by weight, of the bound part and of the free body.
const FEWEST_FRAMES: f64 = 40.0;

/// The equilibrium of an assembly and its parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StabilityResult {
    /// Version of the program.
    pub version: String,
    /// Name of the model whose terms these are, or `own terms`.
    pub model: Cow<'static, str>,
    /// SHA-256 of the bodies.
    pub input_sha256: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Edge of the cubic box that is proposed for simulations of the bodies of a structure, Å; `None` for an assembly file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proposed_box_angstrom: Option<f64>,
    /// Species of the bodies, with their numbers in the assembly.
    pub species: Vec<SpeciesRow>,
    /// Way of the answer.
    pub way: Cow<'static, str>,
    /// Reason for the way, and what it rests on.
    pub reason: String,
    /// Whether the answer is that of an equilibrium: `yes`, `no` or `unknown`.
    pub equilibrated: Cow<'static, str>,
    /// Reason for that, in words.
    pub equilibration: String,
    /// Salt at which half of the bodies are in whole assemblies, at the first pH and concentration, mol/L; `None` if
    /// that is at no salt between those of the table.
    pub half_salt_molar: Option<f64>,
    /// Interval of 95 % of `half_salt_molar`, mol/L.
    pub half_salt_interval_molar: Option<[Option<f64>; 2]>,
    /// Salt at which half of the bodies are in parts of any size, at the first pH and concentration, mol/L; `None` if that is
    /// at no salt between those of the table.
    #[serde(default)]
    pub half_bound_salt_molar: Option<f64>,
    /// Interval of 95 % of `half_bound_salt_molar`, mol/L.
    #[serde(default)]
    pub half_bound_salt_interval_molar: Option<[Option<f64>; 2]>,
    /// Share of the bodies in whole assemblies by salt, at the first pH and concentration.
    #[serde(rename = "yield")]
    pub whole: Vec<f64>,
    /// Standard errors of `yield`.
    #[serde(rename = "yield_error")]
    pub whole_error: Vec<f64>,
    /// Half salts at each pH and concentration.
    pub half_salts: Vec<HalfSaltRow>,
    /// The different parts of the assembly, the whole last.
    pub parts: Vec<PartRow>,
    /// Number of parts of each size that were left out, from one body on.
    pub omitted_parts: Vec<usize>,
    /// Results at each pH and salt.
    pub conditions: Vec<ConditionRow>,
    /// The settings.
    pub settings: StabilitySettings,
    /// Warnings about the energies and the sampling.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// A species of bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeciesRow {
    /// Name of the body.
    pub name: String,
    /// Number of these bodies in the assembly.
    pub bodies: usize,
}

/// The salt of half yield at one pH and concentration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HalfSaltRow {
    /// pH; null where none is stated.
    pub ph: Option<f64>,
    /// Total concentration of the bodies, mol/L.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// Salt, mol/L; null if it is at no salt between those of the table.
    pub half_salt_molar: Option<f64>,
    /// Interval of 95 %, mol/L.
    pub half_salt_interval_molar: Option<[Option<f64>; 2]>,
    /// Salt at which half of the bodies are in parts of any size, mol/L; null as above.
    #[serde(default)]
    pub half_bound_salt_molar: Option<f64>,
    /// Interval of 95 %, mol/L.
    #[serde(default)]
    pub half_bound_salt_interval_molar: Option<[Option<f64>; 2]>,
}

/// A part of the assembly, one for all that motions map onto it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartRow {
    /// Name: the species and their numbers.
    pub name: String,
    /// Numbers of the bodies in the assembly, in the order in which they are attached.
    pub bodies: Vec<usize>,
    /// Number of bodies of each species.
    pub composition: Vec<usize>,
    /// Motions that map the part onto itself.
    pub symmetry_number: usize,
}

/// Results at one pH and salt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionRow {
    /// pH; null where none is stated.
    pub ph: Option<f64>,
    /// Salt, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// The parts, in the order of the table of parts.
    pub parts: Vec<PartAtCondition>,
    /// Mixtures at each total concentration.
    pub mixtures: Vec<Mixture>,
    /// Total concentration at which half of the bodies are in whole assemblies, mol/L.
    pub half_concentration_molar: Option<f64>,
    /// Interval of 95 % of it, mol/L.
    pub half_concentration_interval_molar: Option<[Option<f64>; 2]>,
}

/// A part at one pH and salt; numbers are null where the part has no room.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PartAtCondition {
    /// Standard free energy against free bodies at 1 mol/L, kT.
    pub free_energy_kt: Option<f64>,
    /// Standard error of it, kT.
    pub free_energy_error_kt: Option<f64>,
    /// Mean energy, kT.
    pub mean_energy_kt: Option<f64>,
    /// Root mean square displacement of the last body from its place next to the body that it is attached to, Å.
    pub displacement_angstrom: Option<f64>,
    /// Share of the part near the limit of that displacement.
    pub share_at_limit: Option<f64>,
    /// The limit, Å.
    pub limit_angstrom: Option<f64>,
    /// Connection of the windows, where the way has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub windows: Option<WindowsFound>,
}

impl PartAtCondition {
    fn new(found: &PartFound, free_energy_kt: Option<f64>) -> Self {
        let found = found.map(|part| part.attached);
        Self {
            free_energy_kt,
            free_energy_error_kt: found.map(|part| part.ln_partition_error),
            mean_energy_kt: found.map(|part| part.mean_energy_kt),
            displacement_angstrom: found.map(|part| part.displacement_angstrom),
            share_at_limit: found.map(|part| part.share_at_limit),
            limit_angstrom: found.map(|part| part.limit_angstrom),
            windows: found.and_then(|part| part.windows),
        }
    }

    /// Reason why the free energy of the part cannot be trusted.
    fn doubt(&self) -> Option<&'static str> {
        let above = |value: Option<f64>, limit: f64| value.is_some_and(|value| value > limit);
        if self.free_energy_kt.is_none() {
            return Some("has no partition function: no room for its last body was found");
        }
        if above(self.share_at_limit, MOST_AT_LIMIT) {
            return Some("lies at the limit of its poses: the model holds no well there");
        }
        if above(self.displacement_angstrom, SAME_PLACE_ANGSTROM) {
            return Some(
                "lies far from the arrangement of the assembly: the model prefers another",
            );
        }
        if let Some(doubt) = self.windows.as_ref().and_then(doubt_of_windows) {
            return Some(doubt);
        }
        above(self.free_energy_error_kt, MOST_ERROR).then_some(match self.windows {
            None => "has too large an error; raise --live-states",
            Some(_) => "has too large an error; raise --sweeps",
        })
    }
}

/// Reason why a free energy from windows cannot be trusted.
fn doubt_of_windows(windows: &WindowsFound) -> Option<&'static str> {
    if windows.least_exchanged < LEAST_EXCHANGED {
        return Some("has windows that hardly overlap; raise --windows");
    }
    if windows.round_trips == 0 {
        return Some(
            "was in no simulation pulled apart and put together again, so it rests on the starts; raise --sweeps",
        );
    }
    let frames = windows.bound_frames.min(windows.free_frames);
    (frames < FEWEST_FRAMES).then_some("rests on too few frames; raise --sweeps")
}

impl StabilityResult {
    pub(super) fn new(
        bodies: &StabilityBodies,
        plan: &Plan,
        settings: &StabilitySettings,
        found: &[(Option<f64>, ConditionParts)],
    ) -> Result<Self> {
        let seed = settings.sampling.seed;
        let mut conditions = Vec::new();
        for (ph, of_ph) in found {
            for (salt, salt_molar) in settings.salt_molar.iter().enumerate() {
                let logs = PartLogs::new(plan, &of_ph.parts, salt);
                let rows = of_ph.parts.iter().zip(logs.free_energies_kt());
                let half = logs.half_concentration(seed);
                let mixture = |molar: &f64| logs.mixture(*molar, seed);
                conditions.push(ConditionRow {
                    ph: *ph,
                    salt_molar: *salt_molar,
                    parts: rows
                        .map(|(found, kt)| PartAtCondition::new(&found[salt], kt))
                        .collect(),
                    mixtures: settings.concentration_molar.iter().map(mixture).collect(),
                    half_concentration_molar: half.map(|half| half.value),
                    half_concentration_interval_molar: half.map(|half| half.interval),
                });
            }
        }
        let half_salts = half_salts(settings, found, plan);
        let first = half_salts.first();
        let first_ph = conditions.first().and_then(|row| row.ph);
        let of_first: Vec<&Mixture> = conditions
            .iter()
            .filter(|row| row.ph == first_ph)
            .map(|row| &row.mixtures[0])
            .collect();
        let parts = part_rows(bodies, plan);
        let doubts = doubts(&conditions, &parts);
        let assembly = bodies.first();
        let mut result = Self {
            version: env!("CARGO_PKG_VERSION").into(),
            model: settings.model_name(&assembly.bodies).into(),
            input_sha256: bodies.sha256.clone(),
            bodies: assembly.len(),
            proposed_box_angstrom: proposed_box_angstrom(assembly, settings)?,
            species: species_rows(bodies, plan),
            way: way_in_words(settings).into(),
            reason: reason(plan, settings),
            equilibrated: if doubts.is_empty() { "yes" } else { "unknown" }.into(),
            equilibration: String::new(),
            half_salt_molar: first.and_then(|row| row.half_salt_molar),
            half_salt_interval_molar: first.and_then(|row| row.half_salt_interval_molar),
            half_bound_salt_molar: first.and_then(|row| row.half_bound_salt_molar),
            half_bound_salt_interval_molar: first
                .and_then(|row| row.half_bound_salt_interval_molar),
            whole: of_first.iter().map(|mixture| mixture.whole).collect(),
            whole_error: of_first.iter().map(|mixture| mixture.whole_error).collect(),
            half_salts,
            parts,
            omitted_parts: plan.parts.omitted.clone(),
            conditions,
            settings: settings.clone(),
            warnings: doubts,
        };
        result.equilibration = match result.warnings.first() {
            None => "partition functions of all parts that hold a share of the bodies lie in their wells".into(),
            Some(doubt) => doubt.trim_start_matches("warning: ").to_owned(),
        };
        Ok(result)
    }

    /// Salt of half yield in words.
    pub fn headline(&self) -> String {
        let concentration = concentration_in_words(self.settings.concentration_molar[0]);
        match (self.half_salt_molar, self.half_salt_interval_molar) {
            (Some(salt_molar), Some(interval)) => format!(
                "half of the bodies are in whole assemblies at {}, at {concentration} of bodies",
                salt_with_interval(salt_molar, interval)
            ),
            _ => {
                let low = self.whole.iter().copied().fold(f64::INFINITY, f64::min);
                let high = self.whole.iter().copied().fold(0.0, f64::max);
                let side = match (low >= 0.5, high < 0.5) {
                    (true, _) => {
                        "more than half of the bodies are in whole assemblies at every salt"
                    }
                    (_, true) => {
                        "less than half of the bodies are in whole assemblies at every salt"
                    }
                    _ => "the yield does not cross one half",
                };
                format!("{side}, at {concentration} of bodies")
            }
        }
    }
}

impl StabilityResult {
    /// Salt at which half of the bodies are bound in words; empty for a pair, whose only part is the whole.
    pub fn half_bound_in_words(&self) -> String {
        let concentration = concentration_in_words(self.settings.concentration_molar[0]);
        match (
            self.half_bound_salt_molar,
            self.half_bound_salt_interval_molar,
        ) {
            (Some(salt_molar), Some(interval)) if self.bodies > 2 => format!(
                "half of the bodies are bound, in parts of any size, at {}, at {concentration} of bodies",
                salt_with_interval(salt_molar, interval)
            ),
            _ => String::new(),
        }
    }
}

/// A salt concentration with its interval of 95 % in words.
fn salt_with_interval(salt_molar: f64, [low, high]: [Option<f64>; 2]) -> String {
    let end = |end: Option<f64>| end.map_or("open".into(), |molar| format!("{:.0}", 1e3 * molar));
    format!(
        "{:.0} mM of salt (95 %: {} to {} mM)",
        1e3 * salt_molar,
        end(low),
        end(high)
    )
}

/// A concentration with the unit that suits it.
pub(super) fn concentration_in_words(molar: f64) -> String {
    let units = [
        ("M", 1.0),
        ("mM", 1e-3),
        ("µM", 1e-6),
        ("nM", 1e-9),
        ("pM", 1e-12),
    ];
    let unit = units.iter().find(|(_, size)| molar >= 0.9995 * size);
    match unit {
        Some((name, size)) => format!("{} {name}", rounded(molar / size)),
        None => format!("{molar:.1e} M"),
    }
}

fn rounded(value: f64) -> String {
    match value >= 100.0 {
        true => format!("{value:.0}"),
        false => format!("{:.3}", value)
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
    }
}

fn half_salts(
    settings: &StabilitySettings,
    found: &[(Option<f64>, ConditionParts)],
    plan: &Plan,
) -> Vec<HalfSaltRow> {
    let mut rows = Vec::new();
    for (ph, of_ph) in found {
        let logs = |(salt, molar): (usize, &f64)| (*molar, PartLogs::new(plan, &of_ph.parts, salt));
        let mut of_ph: Vec<(f64, PartLogs)> =
            settings.salt_molar.iter().enumerate().map(logs).collect();
        of_ph.sort_by(|a, b| a.0.total_cmp(&b.0));
        for concentration_molar in &settings.concentration_molar {
            let half = |counted: Counted| -> Option<Interval> {
                half_salt(
                    &of_ph,
                    counted,
                    *concentration_molar,
                    settings.sampling.seed,
                )
            };
            let (whole, bound) = (half(Counted::Whole), half(Counted::Bound));
            rows.push(HalfSaltRow {
                ph: *ph,
                concentration_molar: *concentration_molar,
                half_salt_molar: whole.map(|half| half.value),
                half_salt_interval_molar: whole.map(|half| half.interval),
                half_bound_salt_molar: bound.map(|half| half.value),
                half_bound_salt_interval_molar: bound.map(|half| half.interval),
            });
        }
    }
    rows
}

fn species_rows(bodies: &StabilityBodies, plan: &Plan) -> Vec<SpeciesRow> {
    let assembly = bodies.first();
    let all: Vec<usize> = (0..assembly.len()).collect();
    let counts = plan.arrangement.composition(&all);
    let row = |(kind, bodies): (&usize, usize)| SpeciesRow {
        name: assembly.bodies[*kind].name.clone(),
        bodies,
    };
    plan.species.iter().zip(counts).map(row).collect()
}

fn part_rows(bodies: &StabilityBodies, plan: &Plan) -> Vec<PartRow> {
    let species = species_rows(bodies, plan);
    let row = |part: &PartKind| {
        let composition = plan.arrangement.composition(&part.bodies);
        let counts = composition
            .iter()
            .zip(&species)
            .filter(|(count, _)| **count > 0);
        let names: Vec<String> = counts
            .map(|(count, species)| match count {
                1 => species.name.clone(),
                _ => format!("{count} {}", species.name),
            })
            .collect();
        PartRow {
            name: names.join(" + "),
            bodies: part.bodies.clone(),
            composition,
            symmetry_number: part.symmetry_number,
        }
    };
    plan.parts.parts.iter().map(row).collect()
}

fn way_in_words(settings: &StabilitySettings) -> &'static str {
    match settings.way() {
        Way::MassAction => "mass action",
        Way::Biased => "biased simulation",
    }
}

fn reason(plan: &Plan, settings: &StabilitySettings) -> String {
    let omitted: usize = plan.parts.omitted.iter().sum();
    let all = match omitted {
        0 => "all its different connected parts".to_owned(),
        _ => format!(
            "its {} different connected parts of the lowest energies, {omitted} left out",
            plan.parts.parts.len()
        ),
    };
    let bodies = plan.arrangement.bodies.len();
    let count = plan.parts.parts.len();
    match settings.sampling.windows {
        None => format!(
            "the assembly has {bodies} bodies, and {all} ({count}) are integrated: no simulation has to wait for bodies to \
             part"
        ),
        Some(windows) => format!(
            "the assembly has {bodies} bodies, and from {all} ({count}) one body is taken away in {} windows that exchange \
             states; mass action weighs the parts",
            windows.windows
        ),
    }
}

/// Warnings about parts that hold a share of the bodies and whose free energy cannot be trusted.
fn doubts(conditions: &[ConditionRow], parts: &[PartRow]) -> Vec<String> {
    let mut doubts = Vec::new();
    for (number, part) in parts
        .iter()
        .enumerate()
        .filter(|(_, part)| part.bodies.len() > 1)
    {
        let doubtful = conditions.iter().find_map(|row| {
            let largest = row
                .mixtures
                .iter()
                .map(|mixture| mixture.shares[number])
                .fold(0.0, f64::max);
            let doubt = row.parts[number].doubt()?;
            // A part without a partition function may have any share.
            let is_missing = row.parts[number].free_energy_kt.is_none();
            (is_missing || largest > LEAST_SHARE).then_some((row, largest, doubt))
        });
        if let Some((row, share, doubt)) = doubtful {
            doubts.push(format!(
                "warning: the part {} (bodies {}) {doubt}, and at {:.0} mM of salt it has {:.0} % of the bodies",
                part.name,
                listed(&part.bodies),
                1e3 * row.salt_molar,
                100.0 * share
            ));
        }
    }
    doubts
}

/// Numbers of bodies as users count them, from one.
pub(super) fn listed(bodies: &[usize]) -> String {
    const MOST: usize = 8;
    let mut numbers: Vec<usize> = bodies.iter().map(|body| body + 1).collect();
    numbers.sort_unstable();
    let mut words: Vec<String> = numbers.iter().take(MOST).map(ToString::to_string).collect();
    if numbers.len() > MOST {
        words.push("...".into());
    }
    words.join(" ")
}
