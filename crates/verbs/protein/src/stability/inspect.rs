//! The state of an assembly: overlaps, pair energies, radius of gyration.

use crate::stability::effective::{self, EffectiveBody};
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{EnergyMode, Engine, RunSettings, require_room};
use anyhow::Result;
use protomer_common::answer::{Answer, columns};
use protomer_kernel::units::kilojoule_per_mol_per_kt;
use protomer_mc::System;
use protomer_mc::energy::terms::{EnergyParts, Term};
use protomer_mc::energy::{PairEnergy, TermsByType};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::observables::{contacts, r_g_angstrom};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Pairs of bodies in the table of terms.
const PAIRS_SHOWN: usize = 10;

/// The result of [`inspect`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Number of bodies.
    pub bodies: usize,
    /// Pairs of bodies that overlap.
    pub overlaps: Vec<(usize, usize)>,
    /// Name of the model whose terms the energies have, or `own terms`; `None` without energies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<&'static str>,
    /// Total energy, kT; `None` if no medium was stated.
    #[serde(rename = "energy_kT")]
    pub energy_kt: Option<f64>,
    /// Total energy, kJ/mol.
    #[serde(rename = "energy_kJ_per_mol")]
    pub energy_kilojoule_per_mol: Option<f64>,
    /// Energies of the pairs in range: first body, second body, kT.
    pub pair_energies: Vec<(usize, usize, f64)>,
    /// The energy by terms, kT; null if no medium was stated.
    pub terms_kt: Option<BTreeMap<&'static str, f64>>,
    /// Energies of the pairs in range by terms, where more than the charges acts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pair_terms: Vec<PairTerms>,
    /// Largest error bound of a pair energy, kT; zero for direct sums.
    pub error_bound_kt_per_pair: f64,
    /// Pairs whose surfaces are closer than the contact gap.
    pub contacts: Vec<(usize, usize)>,
    /// Radius of gyration of the body positions, Å.
    pub r_g_angstrom: f64,
    /// Concentration of the bodies, mol/L; zero in open space.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// The medium, if one was stated.
    #[serde(flatten)]
    pub interaction: Option<ScreenedCoulomb>,
    /// Effective charges of each kind of body, where they interact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
    /// Warnings about the energies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// The energy of two bodies by terms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairTerms {
    /// Number of the first body.
    pub first: usize,
    /// Number of the second body.
    pub second: usize,
    /// Names of the two kinds of bodies.
    pub names: [String; 2],
    /// Energies by the name of the term, kT.
    pub terms_kt: BTreeMap<&'static str, f64>,
}

/// Inspects the present state of an assembly. Without a medium there are no energies.
///
/// # Errors
/// If a setting is invalid, the interaction reaches further than the box allows, an energy is not
/// finite, or effective charges cannot be fitted.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::assemblies::assembly_file::Assembly;
/// use protomer_protein_verbs::stability::inspect::{inspect, inspection_settings};
/// use protomer_protein_verbs::stability::interaction::InteractionSettings;
/// use protomer_protein_verbs::stability::run::{EnergyMode, Engine};
/// use std::path::Path;
/// let engine = Engine::new(Assembly::read(Path::new("6mdr/assembly.json"))?)?;
/// let settings = inspection_settings(EnergyMode::Direct, None, 5.0);
/// let interaction = InteractionSettings::default().interaction(Some(0.1))?;
/// println!("{}", inspect(&engine, &settings, Some(interaction))?.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn inspect(
    engine: &Engine,
    settings: &RunSettings,
    interaction: Option<ScreenedCoulomb>,
) -> Result<Inspection> {
    settings.check()?;
    let Some(interaction) = interaction else {
        return without_energies(engine, settings);
    };
    let engine = &engine.in_medium(settings, &interaction)?;
    let system = engine.system()?;
    let mut model = engine.energy_model(settings, &interaction)?;
    require_room(&system, model.as_ref(), &interaction)?;
    model.reset(&system)?;
    let pairs = model.pairs(&system);
    let energy_kt = model.total_kt(&system);
    let mut warnings = effective::warnings(engine.effective_bodies().into_iter().flatten());
    warnings.extend(effective::near_contact_warning(&system, settings));
    let pair_terms = pair_terms(engine, &system, &pairs);
    let temperature_kelvin = interaction.electrolyte.temperature_kelvin();
    Ok(Inspection {
        bodies: system.len(),
        overlaps: overlapping_pairs(&system),
        model: Some(settings.model_name(&engine.assembly().bodies)),
        energy_kt: Some(energy_kt),
        energy_kilojoule_per_mol: Some(energy_kt * kilojoule_per_mol_per_kt(temperature_kelvin)),
        pair_energies: pairs
            .iter()
            .map(|pair| (pair.first, pair.second, pair.total_kt()))
            .collect(),
        terms_kt: Some(sum_of_terms(&pair_terms)),
        pair_terms: match engine.terms() {
            Some(_) => pair_terms,
            None => Vec::new(),
        },
        error_bound_kt_per_pair: model.error_bound_kt(&system),
        contacts: contacts(&system, settings.contact_gap_angstrom),
        r_g_angstrom: r_g_angstrom(&system, |_| 1.0),
        concentration_molar: engine.assembly().concentration_molar(),
        interaction: Some(interaction),
        effective_bodies: engine.effective_bodies().map(<[_]>::to_vec),
        warnings,
    })
}

/// The energies of pairs by terms; each term that acts stands for every pair.
fn pair_terms(engine: &Engine, system: &System, pairs: &[PairEnergy]) -> Vec<PairTerms> {
    let kinds = engine.terms().map_or_else(Vec::new, TermsByType::kinds);
    let further = engine.terms().map(|terms| terms.parts_of_pairs(system));
    let further: HashMap<(usize, usize), EnergyParts> = further
        .into_iter()
        .flatten()
        .map(|(first, second, parts)| ((first, second), parts))
        .collect();
    let name = |body: usize| {
        let assembly = engine.assembly();
        assembly.bodies[assembly.kinds[body]].name.clone()
    };
    let terms_of = |pair: &PairEnergy| {
        let parts = further.get(&(pair.first, pair.second));
        let parts = parts.copied().unwrap_or_default();
        let of_kind = |kind: &Term| (kind.name(), parts.part_kt(*kind));
        let mut terms_kt: BTreeMap<_, _> = kinds.iter().map(of_kind).collect();
        terms_kt.insert(Term::Charges.name(), pair.energy_kt);
        terms_kt
    };
    let mut rows = Vec::with_capacity(pairs.len());
    for pair in pairs {
        rows.push(PairTerms {
            first: pair.first,
            second: pair.second,
            names: [name(pair.first), name(pair.second)],
            terms_kt: terms_of(pair),
        });
    }
    rows
}

/// The sums over all pairs.
fn sum_of_terms(pairs: &[PairTerms]) -> BTreeMap<&'static str, f64> {
    let mut sums = BTreeMap::from([(Term::Charges.name(), 0.0)]);
    for (name, energy_kt) in pairs.iter().flat_map(|pair| &pair.terms_kt) {
        *sums.entry(*name).or_default() += energy_kt;
    }
    sums
}

/// Inspection of the surfaces alone.
fn without_energies(engine: &Engine, settings: &RunSettings) -> Result<Inspection> {
    let system = engine.system()?;
    Ok(Inspection {
        bodies: system.len(),
        overlaps: overlapping_pairs(&system),
        model: None,
        energy_kt: None,
        energy_kilojoule_per_mol: None,
        pair_energies: Vec::new(),
        terms_kt: None,
        pair_terms: Vec::new(),
        error_bound_kt_per_pair: 0.0,
        contacts: contacts(&system, settings.contact_gap_angstrom),
        r_g_angstrom: r_g_angstrom(&system, |_| 1.0),
        concentration_molar: engine.assembly().concentration_molar(),
        interaction: None,
        effective_bodies: None,
        warnings: Vec::new(),
    })
}

impl Answer for Inspection {
    fn text(&self) -> String {
        let overlaps = match self.overlaps.as_slice() {
            [] => "none".to_owned(),
            pairs => pairs
                .iter()
                .map(|(i, j)| format!("{i}-{j}"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let mut effective = String::new();
        for body in self.effective_bodies.iter().flatten() {
            effective.push_str(&body.describe());
            effective.push('\n');
        }
        let mut energy = "energy: not computed; state the salt for it, such as --salt 100mM".into();
        if let (Some(interaction), Some(kt), Some(kilojoule_per_mol)) = (
            &self.interaction,
            self.energy_kt,
            self.energy_kilojoule_per_mol,
        ) {
            energy = format!(
                "medium: {}\n{effective}energy: {kt:.6} kT ({kilojoule_per_mol:.4} kJ/mol) over {} \
                 pairs in range{}",
                interaction.describe(),
                self.pair_energies.len(),
                error_bound(self.error_bound_kt_per_pair)
            );
            if let (Some(terms_kt), false) = (&self.terms_kt, self.pair_terms.is_empty()) {
                energy += &format!("\n{}", table_of_terms(&self.pair_terms, terms_kt));
            }
        }
        format!(
            "{} bodies, {} contacts, overlaps: {overlaps}\n{energy}\nradius of gyration: {:.3} Å",
            self.bodies,
            self.contacts.len(),
            self.r_g_angstrom
        )
    }
}

/// The strongest pairs of bodies by terms, and the sum over all.
fn table_of_terms(pairs: &[PairTerms], sums: &BTreeMap<&'static str, f64>) -> String {
    let total = |terms_kt: &BTreeMap<&'static str, f64>| terms_kt.values().sum::<f64>();
    let line = |label: String, terms_kt: &BTreeMap<&'static str, f64>| {
        let numbers = terms_kt.values().copied().chain([total(terms_kt)]);
        let mut cells = vec![label];
        cells.extend(numbers.map(|energy_kt| format!("{energy_kt:.2}")));
        cells
    };
    let mut heading = vec!["energy (kT)".to_owned()];
    heading.extend(sums.keys().map(|name| name.replace('_', " ")));
    heading.push("sum".into());
    let mut rows = vec![heading];
    let mut strongest: Vec<&PairTerms> = pairs.iter().collect();
    let size = |pair: &PairTerms| total(&pair.terms_kt).abs();
    strongest.sort_by(|a, b| size(b).total_cmp(&size(a)));
    for pair in strongest.iter().take(PAIRS_SHOWN) {
        let [first, second] = &pair.names;
        let label = format!("{} {first}, {} {second}", pair.first, pair.second);
        rows.push(line(label, &pair.terms_kt));
    }
    match pairs.len() {
        1 => {}
        2..=PAIRS_SHOWN => rows.push(line("all pairs".into(), sums)),
        all => rows.push(line(format!("all {all} pairs"), sums)),
    }
    columns(&rows)
}

/// The error bound (kT per pair of bodies) in words, to follow an energy; empty for a direct sum.
pub(crate) fn error_bound(error_bound_kt_per_pair: f64) -> String {
    match error_bound_kt_per_pair > 0.0 {
        true => format!(", each to within {error_bound_kt_per_pair:.2e} kT"),
        false => String::new(),
    }
}

/// The settings relevant to [`inspect`]: the energy mode and the contact gap.
pub fn inspection_settings(
    energy: EnergyMode,
    tolerance_kt: Option<f64>,
    contact_gap_angstrom: f64,
) -> RunSettings {
    RunSettings {
        energy: Some(energy),
        tolerance_kt,
        contact_gap_angstrom,
        ..RunSettings::default()
    }
}
