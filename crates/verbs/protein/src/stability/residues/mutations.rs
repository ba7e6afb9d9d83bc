//! Exchanges of single charges, and the half salt they lead to.
//!
//! The frames of a run stand for those of the changed bodies with weights exp(-ΔU). Where few frames
//! carry the weight, they do not, and no number is given.

use super::bound::AssemblyContacts;
use super::frames::{AtSalt, Run, SweepAnswer};
use super::result::{Change, MutationAtSalt, MutationRow, ResidueName};
use super::surface;
use crate::stability::sweep::half_salt::{FractionAt, crossing_molar};
use anyhow::Result;
use protomer_body::chemistry::AminoAcid;
use protomer_body::chemistry::protonation::side_chain_groups;
use protomer_body::chemistry::residue_names::force_field_amino_acid;
use protomer_body::{Body, Residue};
use protomer_kernel::statistics::jackknife_error;
use protomer_mc::System;
use protomer_mc::contributions::{
    Averages, ChargeSites, Contributions, Mean, Response, charge_sites, mean_of_blocks, reweighted,
};

/// Least number of effective frames; with fewer there is no number.
pub const FEWEST_EFFECTIVE_FRAMES: f64 = 10.0;
/// Exchanges of residues that touch another body in more than this share of frames and copies are
/// not recommended.
const MOST_TOUCHING: f64 = 0.1;
/// The pH of bodies that do not state theirs.
const USUAL_PH: f64 = 7.4;

/// One exchange.
struct Exchange {
    site: usize,
    residue: usize,
    name: ResidueName,
    mutation: String,
    change: Change,
    charge_change_e: f64,
}

/// All exchanges of a run, and the contacts that count.
pub struct Scan {
    sites: Vec<ChargeSites>,
    exchanges: Vec<Exchange>,
    contacts: AssemblyContacts,
}

/// The frames at one salt concentration.
pub struct ScannedSalt {
    salt_molar: f64,
    /// Effective charge of one elementary charge for each kind of body: 1 without effective
    /// charges.
    effective_per_charge: Vec<f64>,
    frames: Vec<ScannedFrame>,
}

struct ScannedFrame {
    block: usize,
    /// Whether the energies of the frame count.
    counts: bool,
    contacts_left: f64,
    responses: Vec<Response>,
}

/// Salt at which half of the contacts are left, with the number of effective frames.
struct Half {
    salt_molar: f64,
    effective_frames: f64,
}

impl Scan {
    /// The exchanges on the surfaces of the bodies.
    pub fn from_run(run: &Run) -> Result<Self> {
        let (mut sites, mut exchanges) = (Vec::new(), Vec::new());
        for (kind, body) in run.assembly().bodies.iter().enumerate() {
            let areas = surface::areas_angstrom2(body);
            for (residue, area) in areas.into_iter().enumerate() {
                let possible = exchanges_of(body, residue);
                let places = charge_sites(body, residue);
                // Buried charges would need the inside of the body; only what shows is scanned.
                if surface::is_buried(area) || possible.is_empty() || places.is_empty() {
                    continue;
                }
                for (change, to, charge_change_e) in possible {
                    let name = ResidueName::from_body(body, residue);
                    exchanges.push(Exchange {
                        site: sites.len(),
                        residue,
                        mutation: format!("{}{}", name.short(), to.letter()),
                        name,
                        change,
                        charge_change_e,
                    });
                }
                // One site may have several exchanges, which share its response.
                sites.push(ChargeSites { kind, places });
            }
        }
        Ok(Self {
            sites,
            exchanges,
            contacts: AssemblyContacts::new(&run.system()?, &run.settings),
        })
    }

    /// Sites at which charges are changed.
    pub fn sites(&self) -> &[ChargeSites] {
        &self.sites
    }

    /// The fraction of the contacts of the assembly that are left; NaN if it has none.
    pub fn contacts_left(&self, system: &System) -> f64 {
        self.contacts.left(system)
    }

    /// A scan of one salt concentration, without frames yet.
    pub fn scan(&self, ensemble: &AtSalt, contributions: &Contributions) -> ScannedSalt {
        let bodies = &ensemble.engine.assembly().bodies;
        let is_effective = ensemble.engine.effective_bodies().is_some();
        let mut effective_per_charge = Vec::new();
        // By how much effective charges are larger than those they stand for.
        for (body, kind) in bodies.iter().zip(contributions.kinds()) {
            effective_per_charge.push(match is_effective {
                true => slope(&charges_of_residues(body), &kind.charges_of_residues()),
                false => 1.0,
            });
        }
        ScannedSalt {
            salt_molar: ensemble.interaction.electrolyte.salt_molar().unwrap_or(0.0),
            effective_per_charge,
            frames: Vec::new(),
        }
    }

    /// The rows of the answer, the exchange that lowers the energy most first. `rise_kt`: how the
    /// energy of the assembly rises with the logarithm of the salt.
    pub fn rows(
        &self,
        scanned: &[ScannedSalt],
        shown_molar: f64,
        sweep: &SweepAnswer,
        rise_kt: Option<f64>,
        averages: &Averages,
    ) -> Vec<MutationRow> {
        let unchanged = self.half(scanned, None, None);
        let is_shown = |salt: &&ScannedSalt| salt.salt_molar == shown_molar;
        let shown = scanned.iter().find(is_shown).or(scanned.first());
        let mut rows = Vec::new();
        for exchange in &self.exchanges {
            let changed = self.half(scanned, Some(exchange), None);
            let at_shown = shown.map(|salt| self.weighted(salt, Some(exchange), None));
            let effective_frames = match &changed {
                Some(half) => half.effective_frames,
                None => at_shown.map_or(0.0, |average| average.effective_frames),
            };
            // Only an equilibrium has a half salt, and only enough frames show its shift.
            let resolved_half = changed.filter(|half| {
                sweep.is_equilibrated && half.effective_frames >= FEWEST_EFFECTIVE_FRAMES
            });
            let energy_change_kt =
                shown.map_or(NOT_KNOWN, |salt| self.energy_change(salt, exchange));
            // Only a rise with the salt can make up for an exchange.
            let makes_up = rise_kt.filter(|rise_kt| *rise_kt > 0.0);
            let first_order = sweep.half_salt_molar.zip(makes_up);
            let shift = match (&resolved_half, &unchanged) {
                (Some(changed), Some(unchanged)) => Some(Mean {
                    mean: changed.salt_molar - unchanged.salt_molar,
                    error: self.error_of_shift(scanned, exchange),
                }),
                _ => None,
            };
            let kind = self.sites[exchange.site].kind;
            let touching = averages.residue(kind, exchange.residue).touching;
            rows.push(MutationRow {
                name: exchange.name.clone(),
                mutation: exchange.mutation.clone(),
                change: exchange.change,
                charge_change_e: exchange.charge_change_e,
                touching,
                recommended: touching <= MOST_TOUCHING,
                energy_change_kt,
                effective_frames,
                half_salt_molar: resolved_half.map(|half| half.salt_molar),
                half_salt_shift_molar: shift,
                first_order_half_salt_molar: first_order
                    // To first order the half salt moves until the
                    // rise with ln(salt) makes up for the change.
                    .map(|(half, rise_kt)| half * (-energy_change_kt.mean / rise_kt).exp()),
                at_salts: scanned
                    .iter()
                    .map(|salt| self.at_salt(salt, exchange))
                    .collect(),
            });
        }
        let change = |row: &MutationRow| row.energy_change_kt.mean;
        // NaN of an unknown energy sorts last.
        rows.sort_by(|a, b| change(a).total_cmp(&change(b)));
        rows
    }

    fn change_kt(&self, salt: &ScannedSalt, frame: &ScannedFrame, exchange: &Exchange) -> f64 {
        let kind = self.sites[exchange.site].kind;
        let charge_e = salt.effective_per_charge[kind] * exchange.charge_change_e;
        frame.responses[exchange.site].energy_change_kt(charge_e)
    }

    /// The mean change of the energy over the frames that count, as they are.
    fn energy_change(&self, salt: &ScannedSalt, exchange: &Exchange) -> Mean {
        // Blocks ascend with the frames.
        let blocks = salt.frames.last().map_or(0, |frame| frame.block + 1);
        let mut means = Vec::with_capacity(blocks);
        for block in 0..blocks {
            let frames = salt.frames.iter().filter(|frame| frame.block == block);
            let changes: Vec<f64> = frames
                .filter(|frame| frame.counts)
                .map(|frame| self.change_kt(salt, frame, exchange))
                .collect();
            if changes.is_empty() {
                continue;
            }
            means.push(changes.iter().sum::<f64>() / changes.len() as f64);
        }
        mean_of_blocks(&means)
    }

    /// The contacts that are left with an exchange, without the frames of one block.
    fn weighted(
        &self,
        salt: &ScannedSalt,
        exchange: Option<&Exchange>,
        without: Option<usize>,
    ) -> protomer_mc::contributions::Reweighted {
        let frames = salt.frames.iter();
        // Blocks of all frames, also of those that do not count: weights are of all.
        let frames = frames.filter(|frame| Some(frame.block) != without);
        reweighted(frames.map(|frame| {
            let change_kt = exchange.map_or(0.0, |substitution| {
                self.change_kt(salt, frame, substitution)
            });
            (frame.contacts_left, change_kt)
        }))
    }

    fn at_salt(&self, salt: &ScannedSalt, exchange: &Exchange) -> MutationAtSalt {
        let all = self.weighted(salt, Some(exchange), None);
        let blocks = salt.frames.last().map_or(0, |frame| frame.block + 1);
        let without = |block| self.weighted(salt, Some(exchange), Some(block)).mean;
        let values: Vec<f64> = (0..blocks).map(without).collect();
        MutationAtSalt {
            salt_molar: salt.salt_molar,
            contacts_left: Mean {
                mean: all.mean,
                error: jackknife_error(&values),
            },
            effective_frames: all.effective_frames,
        }
    }

    fn half(
        &self,
        scanned: &[ScannedSalt],
        exchange: Option<&Exchange>,
        without: Option<usize>,
    ) -> Option<Half> {
        let mut points = Vec::with_capacity(scanned.len());
        let mut effective = Vec::with_capacity(scanned.len());
        for salt in scanned {
            let average = self.weighted(salt, exchange, without);
            effective.push((salt.salt_molar, average.effective_frames));
            points.push(FractionAt {
                salt_molar: salt.salt_molar,
                fraction: average.mean,
                error: 0.0,
            });
        }
        let salt_molar = crossing_molar(&points)?;
        // The fewer of the two neighbours.
        let (below, above): (Vec<_>, Vec<_>) =
            effective.iter().partition(|(salt, _)| *salt <= salt_molar);
        let ends = [below.last(), above.first()];
        let frames = ends.into_iter().flatten().map(|(_, frames)| *frames);
        Some(Half {
            salt_molar,
            effective_frames: frames.fold(f64::INFINITY, f64::min),
        })
    }

    /// Standard error of the shift of the half salt, by leaving out a block at a time (jackknife);
    /// `None` if a shift without one is not known.
    fn error_of_shift(&self, scanned: &[ScannedSalt], exchange: &Exchange) -> Option<f64> {
        let last = |salt: &ScannedSalt| salt.frames.last().map_or(0, |frame| frame.block + 1);
        let blocks = scanned.iter().map(last).min().unwrap_or(0);
        let mut shifts = Vec::with_capacity(blocks);
        for block in 0..blocks {
            let changed = self.half(scanned, Some(exchange), Some(block))?;
            let unchanged = self.half(scanned, None, Some(block))?;
            shifts.push(changed.salt_molar - unchanged.salt_molar);
        }
        jackknife_error(&shifts)
    }
}

/// Reason why frames with weights give no half salts; `None` if they do.
pub fn note(run: &Run, sweep: &SweepAnswer) -> Option<&'static str> {
    match (run.salts().len(), sweep.is_equilibrated) {
        (1, _) => Some("there is one salt, so there is no half salt; scan a sweep over several"),
        (_, false) => Some(
            "the sweep is not known to be in equilibrium, so frames with weights say nothing of the half \
             salt; its first order, from the frames in which the assembly holds, does not need it",
        ),
        (_, true) => None,
    }
}

const NOT_KNOWN: Mean = Mean {
    mean: f64::NAN,
    error: None,
};

impl ScannedSalt {
    /// Adds a frame.
    pub fn push(
        &mut self,
        block: usize,
        counts: bool,
        contacts_left: f64,
        responses: Vec<Response>,
    ) {
        self.frames.push(ScannedFrame {
            block,
            counts,
            contacts_left,
            responses,
        });
    }
}

/// Exchanges that are possible for a residue, each with the change of its charge (e).
pub(crate) fn exchanges_of(body: &Body, residue: usize) -> Vec<(Change, AminoAcid, f64)> {
    let Residue { name, .. } = &body.residues[residue];
    let ph = body.provenance.settings.get("ph");
    let ph = ph.and_then(|ph| ph.parse().ok()).unwrap_or(USUAL_PH);
    let charge_e = |amino_acid: AminoAcid| -> f64 {
        let groups = side_chain_groups(amino_acid).iter();
        groups.map(|group| group.charge_e(ph)).sum()
    };
    let from = AminoAcid::of_residue(name).or_else(|| force_field_amino_acid(name));
    let Some(from) = from else {
        return Vec::new();
    };
    let (positive, negative) = (AminoAcid::Lys, AminoAcid::Glu);
    let to = match from {
        // A bridge and a kink are not exchanged for a charge.
        AminoAcid::Cys | AminoAcid::Pro => return Vec::new(),
        AminoAcid::Lys | AminoAcid::Arg => [
            (Change::Neutralise, AminoAcid::Gln),
            (Change::Invert, negative),
        ],
        AminoAcid::Asp => [
            (Change::Neutralise, AminoAcid::Asn),
            (Change::Invert, positive),
        ],
        AminoAcid::Glu => [
            (Change::Neutralise, AminoAcid::Gln),
            (Change::Invert, positive),
        ],
        _ => [(Change::Positive, positive), (Change::Negative, negative)],
    };
    let exchange = |(change, to): (Change, AminoAcid)| (change, to, charge_e(to) - charge_e(from));
    to.map(exchange).to_vec()
}

fn charges_of_residues(body: &Body) -> Vec<f64> {
    let mut charges = vec![0.0; body.residues.len()];
    for site in &body.sites {
        let of_residue = site
            .residue
            .and_then(|index| charges.get_mut(index as usize));
        if let Some(charge) = of_residue {
            *charge += site.charge_e;
        }
    }
    charges
}

/// Effective charge of one elementary charge of a body: least squares through the origin.
fn slope(charges_e: &[f64], effective_e: &[f64]) -> f64 {
    let products = charges_e
        .iter()
        .zip(effective_e)
        .map(|(q, effective_charge)| q * effective_charge);
    let squares = charges_e.iter().map(|q| q * q);
    // Least squares through the origin: Σ q q' / Σ q².
    let slope = products.sum::<f64>() / squares.sum::<f64>();
    // A body without charges has 0 / 0.
    if slope.is_finite() { slope } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_elementary_charge_looks_like_the_slope() {
        assert_eq!(slope(&[1.0, -1.0, 0.0], &[1.5, -1.7, 9.0]), 1.6);
        assert_eq!(slope(&[0.0], &[1.0]), 1.0);
    }
}
