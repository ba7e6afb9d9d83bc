//! One complex, from its files to its record.

use super::record::ScoreRecord;
use super::{
    Measure, ScoreSettings, StatedComplex, confidence, energies, geometry, reality,
    self_attraction, solved,
};
use crate::stability::binding::BindingSettings;
use crate::stability::binding::input::{Inputs, Partners};
use crate::stability::binding::interface::Interface;
use anyhow::Result;
use protomer_common::input::InputFile;
use protomer_results::{End, Execution};
use std::path::Path;

/// Version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Scores a complex in its directory, as far as an earlier record of the same files does not hold it.
pub(super) fn score(
    complex: &StatedComplex,
    settings: &ScoreSettings,
    earlier: Option<ScoreRecord>,
    place: (&Path, &Execution),
) -> End<ScoreRecord> {
    let sha256 = complex
        .files()
        .map(|file| InputFile::sha256_of(file).unwrap_or_default());
    let sha256: Vec<String> = sha256.collect();
    let is_same = |record: &ScoreRecord| {
        record.version == VERSION
            && record.sha256 == sha256
            && record.bodies == complex.bodies
            && !sha256.contains(&String::new())
    };
    let mut record = earlier.filter(is_same).unwrap_or_default();
    record.version = VERSION.to_owned();
    record.sha256 = sha256;
    record.bodies.clone_from(&complex.bodies);
    let is_missing = |measure: &Measure| !record.has(*measure);
    let missing: Vec<Measure> = settings
        .columns
        .iter()
        .copied()
        .filter(is_missing)
        .collect();
    // A failure belongs to the files, which have not changed, and to the groups that were tried.
    let was_tried = |measure: &Measure| record.tried.contains(measure);
    if !missing.is_empty() && missing.iter().all(was_tried) {
        return End::Finished(record);
    }
    record.error = None;
    record.tried.clear();
    if missing.is_empty() {
        return End::Finished(record);
    }
    match measure(complex, settings, &missing, &mut record, place) {
        Ok(End::Finished(())) => {}
        Ok(End::Stopped) => return End::Stopped,
        Err(_) if place.1.interrupt.is_requested() => return End::Stopped,
        Err(error) => {
            record.error = Some(format!("{error:#}"));
            record.tried = missing;
        }
    }
    End::Finished(record)
}

fn measure(
    complex: &StatedComplex,
    settings: &ScoreSettings,
    missing: &[Measure],
    record: &mut ScoreRecord,
    (directory, execution): (&Path, &Execution),
) -> Result<End<()>> {
    let binding = BindingSettings {
        bodies: complex.chain_names()?,
        ..complex.binding(settings)?
    };
    if missing.iter().any(|measure| !measure.is_solved()) {
        let pose = Pose::read(&binding)?;
        record.warn(pose.warnings());
        for measure in missing.iter().filter(|measure| !measure.is_solved()) {
            let values = match measure {
                Measure::Real => reality::columns(complex, &pose),
                Measure::Confidence => confidence::columns(&binding.receptor),
                Measure::Energy => energies::columns(&pose, &binding)?,
                Measure::B22 => {
                    match self_attraction::columns(&pose, settings, directory, execution)? {
                        End::Finished(values) => values,
                        End::Stopped => return Ok(End::Stopped),
                    }
                }
                cheap => geometry::columns(*cheap, &pose)?,
            };
            record.add(*measure, values);
        }
    }
    let expensive: Vec<Measure> = missing
        .iter()
        .copied()
        .filter(|measure| measure.is_solved())
        .collect();
    match expensive.is_empty() {
        true => Ok(End::Finished(())),
        false => {
            let conditions = (&binding, settings.concentration_molar);
            solved::measure(&expensive, conditions, record, execution)
        }
    }
}

/// A complex as its files have it.
pub(super) struct Pose {
    pub inputs: Inputs,
    pub partners: Partners,
    pub interface: Interface,
}

impl Pose {
    /// Reads the files, makes the bodies and finds what touches.
    ///
    /// # Errors
    /// As [`binding`](crate::stability::binding::binding) without its solves.
    pub fn read(settings: &BindingSettings) -> Result<Self> {
        let inputs = Inputs::read(settings)?;
        let ph = inputs.ph.first().copied().flatten();
        let partners = inputs.partners(ph)?;
        let interface = Interface::find(&partners)?;
        Ok(Self {
            inputs,
            partners,
            interface,
        })
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.inputs.warnings.clone();
        warnings.extend(self.interface.warnings.iter().cloned());
        warnings.extend(self.interface.affinity(&self.partners).warning());
        warnings.extend(geometry::backbone_warnings(&self.partners));
        warnings
    }
}
