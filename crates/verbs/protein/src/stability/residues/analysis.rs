//! From frames to averages.

use super::frames::AtSalt;
use super::mutations::{Scan, ScannedSalt};
use super::settings::ResiduesSettings;
use crate::stability::run::Engine;
use anyhow::{Context, Result, bail};
use protomer_kernel::Pose;
use protomer_mc::System;
use protomer_mc::contributions::{
    Averages, Contributions, ResiduesOfKind, Response, StateEnergies,
};
use protomer_results::Progress;
use rayon::prelude::*;

/// Frames that are in memory together.
const TOGETHER: usize = 16;

/// Results of one frame.
struct Found {
    system: System,
    counts: bool,
    state: Option<StateEnergies>,
    responses: Vec<Response>,
}

/// The averages at one salt, if they are wanted, and the frames of a scan.
///
/// # Errors
/// If no frame counts: says at which salt to look.
pub fn analyse(
    settings: &ResiduesSettings,
    ensemble: &AtSalt,
    scan: Option<&Scan>,
    with_averages: bool,
    progress: &dyn Progress,
) -> Result<(Averages, Option<ScannedSalt>)> {
    let shared_out = contributions(
        settings,
        ensemble,
        ensemble.plain.as_ref().unwrap_or(&ensemble.engine),
    )?;
    let contributions = contributions(settings, ensemble, &ensemble.engine)?;
    let start = ensemble.engine.system()?;
    let mut averages = Averages::new(&shared_out, &start);
    let mut scanned = scan.map(|scan| scan.scan(ensemble, &contributions));
    let of_frame = |poses: &Vec<Pose>| -> Result<Found> {
        let system = ensemble.engine.system_at(poses)?;
        let responses = match scan {
            Some(scan) => contributions.responses(&system, scan.sites())?,
            None => Vec::new(),
        };
        let counts = ensemble.counts(&system);
        let state = (with_averages && counts).then(|| shared_out.evaluate(&system));
        progress.advance(1);
        Ok(Found {
            system,
            counts,
            state,
            responses,
        })
    };
    for (block, frames) in ensemble.blocks.iter().enumerate() {
        for together in frames.chunks(TOGETHER) {
            let observations: Vec<Found> =
                together.par_iter().map(of_frame).collect::<Result<_>>()?;
            for frame in observations {
                if let Some(state) = &frame.state {
                    averages.push(state, &frame.system);
                }
                if let (Some(scan), Some(scanned)) = (scan, &mut scanned) {
                    let contacts_left = scan.contacts_left(&frame.system);
                    scanned.push(block, frame.counts, contacts_left, frame.responses);
                }
            }
        }
        averages.end_block();
    }
    if with_averages && averages.frames() == 0 {
        bail!(
            "in none of the {} frames at {} does the assembly hold (more than half of its contacts), and \
             only such frames count where runs disagree; choose another salt with --salt, or run longer",
            ensemble.frames_read(),
            ensemble.salt_in_words()
        );
    }
    Ok((averages, scanned))
}

/// Contributions of residues with the charges of these bodies, and the terms of the medium.
fn contributions(
    settings: &ResiduesSettings,
    ensemble: &AtSalt,
    charges: &Engine,
) -> Result<Contributions> {
    let system = charges.system()?;
    let mut kinds = Vec::new();
    for (body, kind) in ensemble.engine.assembly().bodies.iter().zip(system.types()) {
        let of_kind = ResiduesOfKind::new(body, kind);
        kinds.push(of_kind.with_context(|| format!("body '{}' has no residues", body.name))?);
    }
    let yukawa = ensemble.interaction.yukawa()?;
    let terms = ensemble.engine.terms().cloned();
    let touching = settings.touching_angstrom;
    Ok(Contributions::new(&system, kinds, yukawa, terms, touching))
}
