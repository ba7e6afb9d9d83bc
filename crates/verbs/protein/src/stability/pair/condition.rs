//! One salt and pH: a run in its own directory.

use super::input::Prepared;
use super::pose_files;
use super::residues::{self, RESIDUES, residue_energies};
use super::result::{Association, ConditionResult, PoseResult, b22_per_b2, mean_force_to_csv};
use super::settings::{Energies, PairRunSettings, label};
use crate::stability::effective::range::out_of_range;
use crate::stability::effective::{self, EffectiveStore};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Error, Result, bail};
use protomer_common::answer::counted;
use protomer_field::effective_charges::EffectiveCharges;
use protomer_io::atomic::write_atomically;
use protomer_kernel::RelativePose;
use protomer_kernel::overlap::comes_within;
use protomer_mc::charges::ChargeCloud;
use protomer_mc::pair::{
    BodyPair, Charged, Estimator, PairSettings, Term, Terms, Well, WellIntegral, Wells,
};
use protomer_results::{ResultKind, Run, Turn, Work};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// The potential of mean force of one condition.
const MEAN_FORCE: &str = "mean_force.csv";
const RESULT: &str = "condition.json";

/// Two bodies in one medium.
pub struct Condition<'a> {
    settings: &'a PairRunSettings,
    bodies: &'a [Prepared; 2],
    ph: Option<f64>,
    salt_molar: Option<f64>,
    identity: String,
    interaction: ScreenedCoulomb,
    effective_store: &'a EffectiveStore,
}

/// An estimate in memory.
pub struct State {
    estimator: Estimator,
    /// Wells, searched for after the estimate.
    wells: Option<Wells>,
    pair: BodyPair,
    effective: Option<[EffectiveCharges; 2]>,
}

/// The state of an estimate on the disk.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    estimator: Estimator,
    #[serde(default)]
    wells: Option<Wells>,
}

impl<'a> Condition<'a> {
    pub(super) fn new(
        settings: &'a PairRunSettings,
        bodies: &'a [Prepared; 2],
        ph: Option<f64>,
        salt_molar: Option<f64>,
        identity: &str,
        effective_store: &'a EffectiveStore,
    ) -> Result<Self> {
        let interaction = settings.medium.interaction(salt_molar)?;
        Ok(Self {
            settings,
            bodies,
            ph,
            salt_molar,
            identity: identity.to_owned(),
            interaction,
            effective_store,
        })
    }

    /// The name of its directory.
    pub(super) fn label(&self) -> String {
        label(self.ph, self.salt_molar)
    }

    fn are_equal(&self) -> bool {
        let [first, second] = self.bodies;
        Arc::ptr_eq(&first.kind, &second.kind)
    }

    /// Settings of the sampling, with the error of B₂₂ as one of B₂.
    fn sampling(&self) -> Result<PairSettings> {
        let mut sampling = self.settings.sampling;
        if let Some(error) = self.settings.b22_error_mol_ml_per_g2 {
            let bodies = self
                .bodies
                .each_ref()
                .map(|prepared| prepared.body.as_ref());
            let Some(per_b2) = b22_per_b2(bodies) else {
                bail!(
                    "the molar mass of a body is not known, so its B22 has no error to reach; give \
                     --relative-error instead of --b22-error"
                );
            };
            // B₂₂ is proportional to B₂, so its error becomes one of B₂.
            sampling.error_angstrom3 = Some(error / per_b2);
        }
        Ok(sampling)
    }

    /// The effective charges of both bodies, if they are requested.
    fn effective_charges(&self) -> Result<Option<[EffectiveCharges; 2]>> {
        if self.settings.energies != Energies::Effective {
            return Ok(None);
        }
        let solute = self.settings.solute.unwrap_or_default();
        let fitted = |prepared: &Prepared| -> Result<EffectiveCharges> {
            let store = self.effective_store;
            let charges = store.charges(&prepared.body, &self.interaction, &solute)?;
            Ok(charges.as_ref().clone())
        };
        let [first, second] = self.bodies;
        let of_first = fitted(first)?;
        // Equal bodies are fitted once.
        let of_second = match self.are_equal() {
            true => of_first.clone(),
            false => fitted(second)?,
        };
        Ok(Some([of_first, of_second]))
    }

    /// The bodies and what acts between them.
    fn pair(&self, effective: Option<&[EffectiveCharges; 2]>) -> Result<BodyPair> {
        let [first, second] = self.bodies.each_ref().map(|body| Arc::clone(&body.kind));
        let clouds = match effective {
            Some(effective) => effective
                .each_ref()
                .map(|fitted| ChargeCloud::new(&fitted.charges)),
            None => [first.charges.clone(), second.charges.clone()],
        };
        let mut potential = Terms::default();
        if self.settings.energies != Energies::Hard {
            let yukawa = self.interaction.yukawa()?;
            let charged = Charged::new(yukawa, &clouds[0], &clouds[1])?;
            // One table serves both if the bodies are equal.
            let charged = charged.with_tables(self.are_equal());
            potential.0.push(Arc::new(charged));
        }
        let kinds = [first.as_ref(), second.as_ref()];
        let [of_first, of_second] = self.bodies;
        let charged = [
            (&*of_first.body, kinds[0], &clouds[0]),
            (&*of_second.body, kinds[1], &clouds[1]),
        ];
        let further = self.settings.further_terms();
        let prepared = further.prepare(&charged, &self.interaction)?;
        potential.0.extend(prepared.terms(&kinds, 0, 1).0);
        Ok(BodyPair {
            first,
            second,
            potential,
            core: self.settings.core(),
            contact_gap_angstrom: self.settings.contact_gap_angstrom,
        })
    }

    /// The bodies with their plain charges and the other terms of this condition, by which residues
    /// share energies where effective charges interact; `None` where plain ones do. Effective charges
    /// stand for the field around a body and not for its residues.
    fn with_plain_charges(&self, state: &State) -> Result<Option<BodyPair>> {
        if state.effective.is_none() {
            return Ok(None);
        }
        let mut pair = state.pair.clone();
        // The charges' term is replaced; the others stay as they are.
        pair.potential.0.retain(|term| term.term() != Term::Charges);
        let (first, second) = (&pair.first.charges, &pair.second.charges);
        let charged = Charged::new(self.interaction.yukawa()?, first, second)?;
        // In its place among the terms.
        pair.potential.0.insert(0, Arc::new(charged));
        Ok(Some(pair))
    }

    /// A warning if the search for bound poses went far below what the sampling has met: such a well
    /// is not in B₂, nor in its error. Wells that are integrated are in both.
    fn deep_well(&self, estimator: &Estimator, wells: &Wells) -> Option<String> {
        // The minimum of a well that is sampled lies a few kT below the samples.
        const USUAL_KT: f64 = 6.0;
        if wells.are_integrated() {
            return None;
        }
        let found = wells.wells();
        // Sorted by energy: the first is the lowest.
        let (sampled, lowest) = (estimator.lowest().first()?, found.first()?.pose);
        (lowest.energy_kt < sampled.energy_kt - USUAL_KT).then(|| {
            format!(
                "warning: {}: a pose of {:.1} kT lies far below the lowest sampled ({:.1} kT), so B2 and \
                 K_D may miss a deep, narrow well; check that no charge lies at the surface, and \
                 compare seeds and --interaction effective",
                self.label(),
                lowest.energy_kt,
                sampled.energy_kt
            )
        })
    }

    /// A warning if the integration of a well did not come down to its minimum.
    fn narrow_well(&self, wells: &[Well]) -> Option<String> {
        const MISSED_KT: f64 = 1.0;
        let is_narrow = |well: &&Well| {
            let missed = |integral: &WellIntegral| {
                integral.lowest.energy_kt > integral.minimum_kt + MISSED_KT
            };
            well.integral.as_ref().is_some_and(missed)
        };
        let narrow = wells.iter().filter(is_narrow).count();
        let integrated = wells.iter().filter(|well| well.integral.is_some()).count();
        (narrow > 0).then(|| {
            format!(
                "warning: {}: the integration does not resolve {narrow} of {}: narrow minima were not met again, so K_D is \
                 too large; compare seeds",
                self.label(),
                counted(integrated, "well", "wells")
            )
        })
    }

    /// A warning if the surfaces of a bound pose are too near for effective charges.
    fn poses_too_near(&self, pair: &BodyPair, wells: &[Well]) -> Option<String> {
        if self.settings.energies != Energies::Effective {
            return None;
        }
        let (first, second) = (&pair.first.shape, &pair.second.shape);
        let is_near = |well: &&Well| {
            // The pose is that of the second body; the first is at the origin.
            let pose = &well.pose.pose;
            let relative = RelativePose::from(pose);
            comes_within(first, second, &relative, effective::LEAST_GAP_ANGSTROM)
        };
        let near = wells.iter().filter(is_near).count();
        let surfaces = format!("the surfaces of {near} of {} bound poses", wells.len());
        (near > 0).then(|| out_of_range(&surfaces, self.settings.desolvation))
    }

    fn result(&self, state: &State, wells: &Wells) -> ConditionResult {
        let State {
            estimator, pair, ..
        } = state;
        let found = wells.wells();
        let thermodynamics = wells.thermodynamics(pair, estimator);
        let association = Association::new(self.are_equal(), &thermodynamics);
        let pose = |well: &Well| PoseResult::new(pair, well, &association);
        let poses = found.iter().map(pose).collect();
        let net_effective = state
            .effective
            .as_ref()
            .map(|pair| pair.each_ref().map(|charges| charges.charge_from_afar_e()));
        let mut warnings = Vec::new();
        for (charges, prepared) in state.effective.iter().flatten().zip(self.bodies) {
            warnings.extend(effective::warning(&prepared.body, charges));
        }
        // Two equal bodies say the same.
        warnings.dedup();
        warnings.extend(self.deep_well(estimator, wells));
        warnings.extend(self.narrow_well(&found));
        warnings.extend(self.poses_too_near(pair, &found));
        ConditionResult {
            net_effective_charge_e: net_effective,
            warnings,
            ..ConditionResult::new(
                [&self.bodies[0].body, &self.bodies[1].body],
                self.are_equal(),
                self.ph,
                self.interaction,
                thermodynamics,
                poses,
            )
        }
    }
}

impl Run for Condition<'_> {
    type State = State;
    type Checkpoint = Saved;
    type Answer = ConditionResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = "pair";

    fn work(&self) -> Work {
        Work::new(ResultKind::PairCondition, "pair", &self.identity, "")
    }

    fn length(&self) -> u64 {
        self.settings.steps()
    }

    fn open(&self, _: &Path, saved: Option<Saved>) -> Result<State> {
        let sampling = self.sampling()?;
        let (estimator, wells) = match saved {
            Some(saved) => {
                // A state of other settings would be continued wrongly.
                saved.estimator.check(&sampling)?;
                if let Some(wells) = &saved.wells {
                    wells.check(&sampling)?;
                }
                (saved.estimator, saved.wells)
            }
            None => (Estimator::new(sampling)?, None),
        };
        let effective = self.effective_charges()?;
        let pair = self.pair(effective.as_ref())?;
        Ok(State {
            estimator,
            wells,
            pair,
            effective,
        })
    }

    fn done(&self, state: &State) -> u64 {
        let of_wells = |wells: &Wells| wells.done(state.estimator.settings());
        state.estimator.done() + state.wells.as_ref().map_or(0, of_wells)
    }

    fn advance(&self, state: &mut State, turn: &Turn<'_>) -> Result<()> {
        let State {
            estimator,
            wells,
            pair,
            ..
        } = state;
        // The estimate first: wells are looked for where it met low energies.
        if estimator.done() < Estimator::steps(estimator.settings()) {
            estimator.advance(pair);
            return Ok(());
        }
        match wells {
            None => *wells = Some(Wells::find(pair, estimator, self.are_equal())),
            Some(wells) => wells.advance(pair, estimator, &|| !turn.must_stop())?,
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<Saved> {
        Ok(Saved {
            estimator: state.estimator.clone(),
            wells: state.wells.clone(),
        })
    }

    fn answer(&self, state: &mut State, directory: &Path) -> Result<ConditionResult> {
        let Some(wells) = &state.wells else {
            bail!("{}: the wells were not looked for", self.label());
        };
        let mut result = self.result(state, wells);
        let bodies = self.bodies.each_ref().map(|prepared| &*prepared.body);
        let by_plain_charges = self.with_plain_charges(state)?;
        result.residues_by_plain_charges = by_plain_charges.is_some();
        let pair = by_plain_charges.as_ref().unwrap_or(&state.pair);
        let of_pose = |pose: &PoseResult| residue_energies(bodies, pair, pose);
        let residues: Option<Vec<_>> = result.poses.iter().map(of_pose).collect();
        let residues = residues.unwrap_or_default();
        let csv = residues::to_csv(bodies, &residues)?;
        write_atomically(&directory.join(RESIDUES), |file| {
            file.write_all(csv.as_bytes())
        })?;
        let warnings = pose_files::write(directory, bodies, &result.poses, &residues)?;
        result.warnings.extend(warnings);
        let csv = mean_force_to_csv(&result.mean_force)?;
        write_atomically(&directory.join(MEAN_FORCE), |file| {
            file.write_all(csv.as_bytes())
        })?;
        let json = serde_json::to_string_pretty(&result)?;
        // Last: who finds it finds the other files too.
        write_atomically(&directory.join(RESULT), |file| writeln!(file, "{json}"))?;
        Ok(result)
    }

    /// Null: the result is in a separate file.
    fn details(&self, _: &mut State, _: &Path) -> Result<Value> {
        Ok(Value::Null)
    }

    fn finished(
        &self,
        directory: &Path,
        record: Option<&protomer_results::Record>,
    ) -> Result<Option<ConditionResult>> {
        let done = record.is_some_and(|record| record.is_done_at(self.length()));
        match done {
            true => Ok(Some(protomer_results::keys::read_json(
                &directory.join(RESULT),
            )?)),
            false => Ok(None),
        }
    }
}
