//! The answer, as JSON has it.

use super::frames::{AtSalt, Run, ShownSalt};
use super::settings::ResiduesSettings;
use super::surface;
use crate::stability::interaction::ScreenedCoulomb;
use protomer_body::chemistry::AminoAcid;
use protomer_body::{Body, Residue};
use protomer_kernel::null;
use protomer_mc::contributions::{Averages, Mean};
use protomer_mc::pair::{EnergyParts, PairParts, Term};
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Name of the file of the result.
pub(super) const FILE: &str = "residues.json";

/// Energies of residues and of pairs of residues, averaged over frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResiduesResult {
    /// The version of the program.
    pub version: String,
    /// Name of the model whose terms the energies have, or `own terms`.
    #[serde(default)]
    pub model: Cow<'static, str>,
    /// The assembly file, or the directory of the run.
    pub input: PathBuf,
    /// The identity of the run, or the hash of the assembly with its bodies.
    pub identity: String,
    /// Reason for the choice of this salt; null if it was requested, or is the only one.
    pub salt_chosen: Option<Cow<'static, str>>,
    /// The medium.
    #[serde(flatten)]
    pub interaction: ScreenedCoulomb,
    /// Number of bodies.
    pub bodies: usize,
    /// Frames that were averaged over; one for an assembly.
    pub frames: usize,
    /// Frames that were read.
    #[serde(default)]
    pub frames_read: usize,
    /// Whether only frames count in which more than half of the contacts of the assembly are left:
    /// where the sweep is not equilibrated.
    #[serde(default)]
    pub bound_frames_only: bool,
    /// Blocks of frames, from whose spread the errors come.
    pub blocks: usize,
    /// Replicas that the frames come from.
    pub replicas: usize,
    /// Residues touch where heavy atoms of them are closer than this, Å.
    pub touching_angstrom: f64,
    /// The charges by which energies are shared out.
    #[serde(default)]
    pub shared_by: SharedBy,
    /// Caveat about the energies of residues, in words; null where the charges of the bodies
    /// interact.
    pub charges_note: Option<Cow<'static, str>>,
    /// The mean energy of the run itself, with effective charges or the response of the solvent, kT;
    /// null where the charges of the bodies interact and nothing else.
    pub effective_energy_kt: Option<f64>,
    /// Warnings about the energies.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// The energy that is shared out: that of the whole assembly.
    pub energy: WholeEnergy,
    /// Share of the residues that touch no residue of another body.
    pub residues_outside_contacts: Mean,
    /// Energy of the charges of residues outside contacts, kT: half of each pair counts with each
    /// of its residues.
    pub outside_contacts_kt: Mean,
    /// Energy of the charges of residues outside contacts, as a share of the energy of all charges;
    /// null where that is not negative.
    pub outside_contacts_share: Option<Mean>,
    /// The share of the energy of the charges between residues that do not touch each other; null
    /// where the energy is not negative.
    pub apart_share: Option<Mean>,
    /// Every residue of every kind of body.
    pub residues: Vec<ResidueRow>,
    /// Pairs with 0.01 kT or more, and those that touch.
    pub pairs: Vec<PairRow>,
    /// Reason why frames with weights give no half salts for `mutations`, in words; null if they
    /// do.
    pub mutations_note: Option<Cow<'static, str>>,
    /// Exchanges of single charges, the one that lowers the energy most first; null unless
    /// requested.
    pub mutations: Option<Vec<MutationRow>>,
    /// Whether exchanges of residues that touch another body are recommended, too.
    #[serde(default)]
    pub recommends_touching: bool,
    /// The files that were written.
    pub files: Vec<PathBuf>,
}

/// The charges by which energies are shared out among residues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SharedBy {
    /// Charges of the bodies, which are those that interact.
    #[default]
    Charges,
    /// Charges of the bodies, in the place of the effective ones that interact.
    PlainCharges,
}

/// An energy by terms, kT.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WholeEnergy {
    /// Sum of the terms.
    pub total_kt: Mean,
    /// The terms.
    #[serde(flatten)]
    pub parts: EnergyParts<Mean>,
}

/// The name of a residue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidueName {
    /// Name of the body.
    pub body: String,
    /// Chain of the residue in the source of the body.
    pub chain: String,
    /// Number of the residue in the source of the body.
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
    /// Name of the residue, three letters.
    pub residue: String,
}

/// Contribution of one residue, per copy of its body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidueRow {
    /// Name of the residue.
    #[serde(flatten)]
    pub name: ResidueName,
    /// Energy of the residue with all residues of other bodies, kT; each pair counts in full with
    /// both.
    pub energy_kt: Mean,
    /// Energy of the residue by terms.
    #[serde(flatten)]
    pub parts: EnergyParts,
    /// Share of frames and copies in which the residue touches a residue of another body.
    pub touching: f64,
    /// Area of the residue in the surface of its own body, Å².
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub surface_angstrom2: f64,
    /// Whether this area is so little that the residue is buried in its own body.
    #[serde(default)]
    pub buried: bool,
}

/// Contribution of one pair of residues, over all pairs of bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairRow {
    /// A residue.
    pub first: ResidueName,
    /// A residue of another body.
    pub second: ResidueName,
    /// Energy of the pair, kT.
    pub energy_kt: Mean,
    /// The energy by terms.
    #[serde(flatten)]
    pub parts: PairParts,
    /// Share of frames in which two such residues touch.
    pub touching: f64,
    /// Mean number of such pairs that touch.
    pub contacts: f64,
}

/// Changes of the charge of a residue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Change {
    /// A charged side chain becomes an uncharged one.
    Neutralise,
    /// A charged side chain becomes one of the opposite charge.
    Invert,
    /// An uncharged side chain becomes a lysine.
    Positive,
    /// An uncharged side chain becomes a glutamate.
    Negative,
}

/// The exchange of one charge, in all copies of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MutationRow {
    /// Name of the residue.
    #[serde(flatten)]
    pub name: ResidueName,
    /// Name of the exchange as `ingest --mutate` takes it.
    pub mutation: String,
    /// Kind of the exchange.
    pub change: Change,
    /// Change of the charge of the residue, e.
    pub charge_change_e: f64,
    /// Share of frames and copies in which the residue touches a residue of another body.
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub touching: f64,
    /// Whether the exchange is listed without being requested: false for a residue that touches in
    /// more than a tenth of frames and copies. The scan knows the change of the charge and nothing
    /// of the contact.
    #[serde(default = "is_recommended")]
    pub recommended: bool,
    /// Change of the energy of the assembly while the bodies stay as they are, kT.
    pub energy_change_kt: Mean,
    /// Effective frames at the salts between which the half salt lies, the fewer; at the salt that is
    /// shown if there is none.
    pub effective_frames: f64,
    /// The salt at which half of the contacts are left, from the frames with weights, mol/L; null if
    /// the runs are not known to be in equilibrium, or the frames are too few to tell.
    pub half_salt_molar: Option<f64>,
    /// Difference from the half salt without the exchange, mol/L.
    pub half_salt_shift_molar: Option<Mean>,
    /// The half salt to first order, at which salt makes up for the change of the energy, mol/L;
    /// null if the sweep has no half salt, or salt does not weaken the assembly.
    pub first_order_half_salt_molar: Option<f64>,
    /// Effects at each salt of the run, ascending.
    #[serde(default)]
    pub at_salts: Vec<MutationAtSalt>,
}

/// Whether an exchange is listed in results of earlier versions, which listed all.
fn is_recommended() -> bool {
    true
}

/// Effect of an exchange at one salt concentration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MutationAtSalt {
    /// Salt concentration, mol/L.
    pub salt_molar: f64,
    /// Fraction of the contacts of the assembly that are left, with its error by leaving out a block
    /// of frames at a time.
    pub contacts_left: Mean,
    /// Effective frames.
    pub effective_frames: f64,
}

const EFFECTIVE: &str = "the energy is that of effective charges, which belong to whole bodies and not to residues; it is \
                         shared out by the plain charges of the bodies";
const RESPONSE: &str = "the response of the solvent counts with the residues whose charges and volume it acts on, and not \
                        with pairs; charges are at their own places there, so the sum may differ from the energy of the run by \
                        some tenths of a kT";

/// Pairs with less energy that never touch are left out, kT.
pub const LEAST_KT: f64 = 0.01;

impl ResiduesResult {
    /// Reads the result in a folder; `None` if there is none.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn read(folder: &Path) -> protomer_results::Result<Option<Self>> {
        read_json_if_present(&folder.join(FILE))
    }

    pub(super) fn new(
        settings: &ResiduesSettings,
        run: &Run,
        shown: &ShownSalt,
        ensemble: &AtSalt,
        averages: &Averages,
    ) -> Self {
        let bodies = &run.assembly().bodies;
        let name = |kind: usize, residue: usize| ResidueName::from_body(&bodies[kind], residue);
        let mut residues = Vec::new();
        for (kind, body) in bodies.iter().enumerate() {
            let areas = surface::areas_angstrom2(body);
            for (residue, area) in areas.into_iter().enumerate() {
                let means = averages.residue(kind, residue);
                residues.push(ResidueRow {
                    name: name(kind, residue),
                    energy_kt: means.energy_kt,
                    parts: means.parts,
                    touching: means.touching,
                    surface_angstrom2: area,
                    buried: surface::is_buried(area),
                });
            }
        }
        let mut pairs = Vec::new();
        for (index, (first, second)) in averages.pairs_of_kinds().into_iter().enumerate() {
            for a in 0..averages.residues(first) {
                for b in 0..averages.residues(second) {
                    let means = averages.pair(index, a, b);
                    if means.energy_kt.mean.abs() < LEAST_KT && means.touching == 0.0 {
                        continue;
                    }
                    pairs.push(PairRow {
                        first: name(first, a),
                        second: name(second, b),
                        energy_kt: means.energy_kt,
                        parts: means.parts.parts,
                        touching: means.touching,
                        contacts: means.parts.touching,
                    });
                }
            }
        }
        pairs.sort_by(|a, b| a.energy_kt.mean.total_cmp(&b.energy_kt.mean));
        let parts = averages.energy_kt();
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            model: run.settings.model_name(bodies).into(),
            input: settings.input.clone(),
            identity: run.identity.clone(),
            salt_chosen: shown.why.map(Into::into),
            interaction: ensemble.interaction,
            bodies: run.assembly().len(),
            frames: averages.frames(),
            frames_read: ensemble.frames_read(),
            bound_frames_only: ensemble.counts_bound_only(),
            blocks: averages.blocks(),
            replicas: ensemble.replicas,
            touching_angstrom: settings.touching_angstrom,
            shared_by: match ensemble.plain {
                Some(_) => SharedBy::PlainCharges,
                None => SharedBy::Charges,
            },
            charges_note: match (&ensemble.plain, parts.solvent_response_kt.mean) {
                (Some(_), _) => Some(EFFECTIVE.into()),
                (None, response_kt) => (response_kt != 0.0).then_some(RESPONSE.into()),
            },
            effective_energy_kt: None,
            warnings: Vec::new(),
            energy: WholeEnergy {
                total_kt: averages.total_kt(),
                parts,
            },
            residues_outside_contacts: averages.untouched_share(),
            outside_contacts_kt: averages.outside_kt(),
            outside_contacts_share: averages.outside_share(),
            apart_share: averages.apart_share(),
            residues,
            pairs,
            mutations_note: None,
            mutations: None,
            recommends_touching: settings.recommends_touching,
            files: Vec::new(),
        }
    }

    /// The rows of residues, that with the largest magnitude first.
    pub fn strongest(&self) -> Vec<&ResidueRow> {
        let mut rows: Vec<&ResidueRow> = self.residues.iter().collect();
        let size = |row: &ResidueRow| row.energy_kt.mean.abs();
        rows.sort_by(|a, b| size(b).total_cmp(&size(a)));
        rows
    }

    /// The terms besides the charges that act, each with the energy of the assembly.
    pub(super) fn further_terms(&self) -> Vec<(Term, Mean)> {
        let energies = Term::ALL.map(|term| (term, self.energy.parts.part_kt(term)));
        let acts =
            |(term, energy_kt): &(Term, Mean)| *term != Term::Charges && energy_kt.mean != 0.0;
        energies.into_iter().filter(acts).collect()
    }

    /// Whether the solvent that the bodies displace responds to their charges.
    pub(super) fn has_response(&self) -> bool {
        self.energy.parts.solvent_response_kt.mean != 0.0
    }
}

impl ResidueName {
    pub(crate) fn from_body(body: &Body, residue: usize) -> Self {
        let Residue {
            chain,
            number,
            insertion_code,
            name,
            ..
        } = &body.residues[residue];
        Self {
            body: body.name.clone(),
            chain: chain.clone(),
            number: *number,
            insertion_code: insertion_code.clone(),
            residue: name.clone(),
        }
    }

    /// Short name, such as `A:K15`.
    pub fn short(&self) -> String {
        let letter = match AminoAcid::of_residue(&self.residue) {
            Some(amino_acid) => amino_acid.letter().to_string(),
            None => self.residue.clone(),
        };
        format!(
            "{}:{letter}{}{}",
            self.chain, self.number, self.insertion_code
        )
    }

    /// Full name, such as `plus A:K15`.
    pub fn full(&self) -> String {
        format!("{} {}", self.body, self.short())
    }
}
