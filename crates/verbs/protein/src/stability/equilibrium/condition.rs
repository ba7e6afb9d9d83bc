//! The parts of an assembly at one pH and all salts: a run in its own directory.
//!
//! Parts are sampled at one salt in the middle, and weighted for the others. The change with the salt is then free of the
//! noise of the sampling. Where the weights rest on too few samples, the part is sampled at that salt.

use super::StabilitySettings;
use super::interacting::Interacting;
use super::plan::Plan;
use super::settings::label;
use crate::stability::run::Engine;
use anyhow::{Error, Result};
use protomer_mc::parts::{Attached, GrowthSettings, PartKind, PartSamples, attach, free_body};
use protomer_results::checkpoint::require_lengths;
use protomer_results::{ResultKind, Run, Turn, Work};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

/// Limits of a part that are tried, of that in the settings: bodies that interlock leave room to hardly any pose within the
/// widest.
const LIMITS: [f64; 3] = [1.0, 0.5, 0.25];
/// Limit of a part that spreads to that of the settings, relative to it.
const WIDER: f64 = 2.0;
/// Largest share of a part near its limit; with more, the limit decides.
pub(super) const MOST_AT_LIMIT: f64 = 0.1;
/// Fewest samples, by weight, that a part may rest on.
const FEWEST_SAMPLES: f64 = 40.0;

/// A part at one salt; `None` where it has no room.
pub(super) type PartFound = Option<AtSalt>;

/// A part at one salt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtSalt {
    /// The partition function and how it came about.
    pub attached: Attached,
    /// Error of the change from the middle salt, zero for that salt; null for a part that was sampled at another salt.
    pub change_error: Option<f64>,
}

/// An assembly at one pH.
pub struct Condition<'a> {
    pub(super) settings: &'a StabilitySettings,
    pub(super) plan: &'a Plan,
    pub(super) ph: Option<f64>,
    pub(super) identity: String,
    pub(super) input_sha256: String,
    /// Makes the engine of the assembly at a salt, by the number of the salt.
    pub(super) engine: Box<dyn Fn(usize) -> Result<Engine> + Sync + 'a>,
    /// Energies at each salt.
    pub(super) interacting: Vec<OnceLock<Interacting>>,
}

/// Parts in memory.
#[derive(Default)]
pub struct State {
    /// Parts that are done, at each salt.
    found: Vec<Vec<PartFound>>,
    /// Samples that further parts grow from, by part and salt.
    samples: BTreeMap<usize, PartSamples>,
}

/// Parts on the disk.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    found: Vec<Vec<PartFound>>,
    samples: BTreeMap<usize, PartSamples>,
}

/// All parts at one pH.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionParts {
    /// Parts in the order of the plan, at each salt.
    pub parts: Vec<Vec<PartFound>>,
}

impl Condition<'_> {
    /// The name of its directory.
    pub(super) fn label(&self) -> String {
        label(self.ph)
    }

    /// Number of the salt at which parts are sampled: the middle one, from which the others are nearest.
    fn sampled_salt(&self) -> usize {
        let salts = &self.settings.salt_molar;
        let mut order: Vec<usize> = (0..salts.len()).collect();
        order.sort_by(|a, b| salts[*a].total_cmp(&salts[*b]));
        order[salts.len() / 2]
    }

    /// The energies of the bodies at a salt, made when they are first needed.
    fn interacting(&self, salt: usize) -> Result<&Interacting> {
        let place = &self.interacting[salt];
        if let Some(interacting) = place.get() {
            return Ok(interacting);
        }
        let engine = (self.engine)(salt)?;
        let made = Interacting::new(&engine, self.settings, self.settings.salt_molar[salt])?;
        Ok(place.get_or_init(|| made))
    }

    fn part(&self, number: usize) -> (u32, &PartKind) {
        (number as u32, &self.plan.parts.parts[number])
    }

    /// Key of the samples of a part at a salt.
    fn key(&self, number: usize, salt: usize) -> usize {
        number * self.settings.salt_molar.len() + salt
    }

    /// Samples of a part at a salt that further parts may grow from; `None` without room.
    fn samples_at(&self, state: &State, number: usize, salt: usize) -> Result<Option<PartSamples>> {
        if let Some(samples) = state.samples.get(&self.key(number, salt)) {
            return Ok(Some(samples.clone()));
        }
        let sampled = state.samples.get(&self.key(number, self.sampled_salt()));
        let Some(sampled) = sampled else {
            return Ok(None);
        };
        let interacting = self.interacting(salt)?;
        Ok(Some(sampled.moved(
            self.part(number),
            interacting,
            &self.settings.sampling,
        )))
    }

    /// Samples of the next part at a salt; `None` without room, or if the work was ended.
    fn grown(&self, state: &State, salt: usize, turn: &Turn<'_>) -> Result<Option<PartSamples>> {
        let arrangement = &self.plan.arrangement;
        let number = state.found.len();
        let (_, part) = self.part(number);
        let Some(smaller) = part.grown_from else {
            let pose = arrangement.bodies[part.bodies[0]].pose;
            return Ok(Some(free_body(pose, &self.settings.sampling)));
        };
        // A part of one without room has none either.
        let Some(smaller) = self.samples_at(state, smaller, salt)? else {
            return Ok(None);
        };
        // The widest that has room: too narrow a limit would cut the part off.
        for share in LIMITS {
            let samples = self.attached(number, &smaller, salt, share, turn)?;
            let Some(samples) = samples else {
                match turn.must_stop() {
                    true => return Ok(None),
                    false => continue,
                }
            };
            if share < 1.0 || samples.attached().share_at_limit <= MOST_AT_LIMIT {
                return Ok(Some(samples));
            }
            // A wide well: the limit would decide the result.
            let wider = self.attached(number, &smaller, salt, WIDER, turn)?;
            return Ok(Some(wider.unwrap_or(samples)));
        }
        Ok(None)
    }

    /// A part grown at a salt from samples of the smaller one, within a share of the limit of the settings.
    fn attached(
        &self,
        number: usize,
        smaller: &PartSamples,
        salt: usize,
        share: f64,
        turn: &Turn<'_>,
    ) -> Result<Option<PartSamples>> {
        let settings = GrowthSettings {
            limit_angstrom: share * self.settings.sampling.limit_angstrom,
            ..self.settings.sampling
        };
        let interacting = self.interacting(salt)?;
        let goes_on = || !turn.must_stop();
        let arrangement = &self.plan.arrangement;
        let part = self.part(number);
        Ok(attach(
            arrangement,
            part,
            smaller,
            interacting,
            &settings,
            &goes_on,
        )?)
    }

    /// The next part at a salt by weights on the samples of another; `None` if they rest on too few of them.
    fn weighted(&self, samples: &PartSamples, number: usize, salt: usize) -> Result<PartFound> {
        let interacting = self.interacting(salt)?;
        let weighted = samples.weighted(self.part(number).1, interacting);
        Ok(
            (weighted.effective_samples >= FEWEST_SAMPLES).then_some(AtSalt {
                attached: weighted.attached,
                change_error: Some(weighted.change_error),
            }),
        )
    }

    /// Whether a part that is still to come grows from this one.
    fn is_needed(&self, number: usize, from: usize) -> bool {
        let coming = &self.plan.parts.parts[from..];
        coming.iter().any(|part| part.grown_from == Some(number))
    }

    /// The next part at all salts; an end that was requested leaves it undone.
    fn next_part(&self, state: &mut State, turn: &Turn<'_>) -> Result<()> {
        let (number, salts) = (state.found.len(), self.settings.salt_molar.len());
        let is_single = self.part(number).1.grown_from.is_none();
        let mut found: Vec<PartFound> = vec![None; salts];
        let mut made = Vec::new();
        let first = self.sampled_salt();
        let sampled = self.grown(state, first, turn)?;
        for salt in std::iter::once(first).chain((0..salts).filter(|salt| *salt != first)) {
            let weighted = match &sampled {
                Some(samples) if salt != first && !is_single => {
                    self.weighted(samples, number, salt)?
                }
                _ => None,
            };
            if weighted.is_some() {
                found[salt] = weighted;
                continue;
            }
            let samples = match salt == first {
                true => sampled.clone(),
                false => self.grown(state, salt, turn)?,
            };
            found[salt] = samples.as_ref().map(|samples| AtSalt {
                attached: *samples.attached(),
                change_error: (salt == first).then_some(0.0),
            });
            made.extend(samples.map(|samples| (self.key(number, salt), samples)));
        }
        // An interrupted part is begun again.
        if turn.must_stop() {
            return Ok(());
        }
        state.found.push(found);
        state.samples.extend(made);
        let next = number + 1;
        state
            .samples
            .retain(|key, _| self.is_needed(key / salts, next));
        Ok(())
    }
}

impl Run for Condition<'_> {
    type State = State;
    type Checkpoint = Saved;
    type Answer = ConditionParts;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::EquilibriumCondition,
            "stability",
            &self.identity,
            &self.input_sha256,
        )
    }

    fn length(&self) -> u64 {
        self.plan.parts.parts.len() as u64
    }

    fn open(&self, _: &Path, saved: Option<Saved>) -> Result<State> {
        let Some(Saved { found, samples }) = saved else {
            return Ok(State::default());
        };
        for part in &found {
            require_lengths(&[(
                "salts of a part",
                part.len(),
                self.settings.salt_molar.len(),
            )])?;
        }
        Ok(State { found, samples })
    }

    fn done(&self, state: &State) -> u64 {
        state.found.len() as u64
    }

    fn advance(&self, state: &mut State, turn: &Turn<'_>) -> Result<()> {
        self.next_part(state, turn)
    }

    fn save(&self, state: &mut State) -> Result<Saved> {
        Ok(Saved {
            found: state.found.clone(),
            samples: state.samples.clone(),
        })
    }

    fn answer(&self, state: &mut State, _: &Path) -> Result<ConditionParts> {
        Ok(ConditionParts {
            parts: state.found.clone(),
        })
    }
}
