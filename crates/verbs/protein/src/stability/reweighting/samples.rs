//! The frames of a sweep, what is measured of each, and its energy in every medium.

use crate::scattering::Source;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{Engine, RunSettings, salt_label};
use anyhow::Result;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::Pose;
use protomer_mc::System;
use protomer_mc::energy::{Effort, Pairs};
use protomer_mc::observables::{cluster_sizes, contacts};
use protomer_results::Progress;
use rayon::prelude::*;

/// Blocks of frames, so that their spread tells the error.
const FEWEST_BLOCKS: usize = 8;

/// All frames of a sweep.
pub(super) struct Samples {
    /// Salts that were simulated, ascending, mol/L.
    pub(super) simulated_molar: Vec<f64>,
    /// Measurements of each frame.
    pub(super) frames: Vec<Frame>,
    /// Salts of the sweep and of the curves, mol/L, each with the energies of all frames there, kT.
    energies_kt: Vec<(f64, Vec<f64>)>,
    /// Number of blocks.
    pub(super) blocks: usize,
}

/// Measurements of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Index of the salt at which the frame was found.
    pub(super) salt: usize,
    pub(super) replica: usize,
    /// Frames of a replica that follow each other are of one block, at all salts: states that are
    /// exchanged are not independent.
    pub(super) block: usize,
    /// Contacts over those of the assembly; not a number if that has none.
    pub(super) contacts_left: f64,
    pub(super) bound_fraction: f64,
    pub(super) clusters: usize,
}

impl Samples {
    /// Reads the frames and computes their energies at all salts of the sweep and of the curves.
    pub(super) fn gather(
        engine: &Engine,
        run: &RunSettings,
        source: &Source,
        salts: &[f64],
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut simulated_molar = run.salt_molar.clone();
        simulated_molar.sort_by(f64::total_cmp);
        let mut wanted = simulated_molar.clone();
        wanted.extend(salts);
        wanted.sort_by(f64::total_cmp);
        wanted.dedup_by_key(|salt| salt_label(*salt));

        let native = contacts(&engine.system()?, run.contact_gap_angstrom).len();
        let replicas = run.replicas as usize;
        // At least this many over all replicas: with few blocks their spread says little.
        let blocks_of_each = FEWEST_BLOCKS.div_ceil(replicas);
        let (mut frames, mut poses): (Vec<Frame>, Vec<&[Pose]>) = (Vec::new(), Vec::new());
        for (number, series) in source.series.iter().enumerate() {
            // By salt in the order of the settings, and by replica within a salt.
            let salt_molar = run.salt_molar[number / replicas];
            let is_ours = |salt: &f64| *salt == salt_molar;
            let salt = simulated_molar.iter().position(is_ours).unwrap_or(0);
            let replica = number % replicas;
            for (place, of_frame) in series.frames.iter().enumerate() {
                // Frames that follow each other are correlated; a block keeps them together.
                let part = place * blocks_of_each / series.frames.len();
                let system = engine.system_at(of_frame)?;
                frames.push(Frame {
                    salt,
                    replica,
                    block: replica * blocks_of_each + part,
                    ..measured(&system, run.contact_gap_angstrom, native)
                });
                poses.push(of_frame);
            }
        }
        progress.begin((wanted.len() * poses.len()) as u64, "energies");
        let mut media = Vec::with_capacity(wanted.len());
        for salt_molar in wanted {
            let interaction = run.medium.interaction(Some(salt_molar))?;
            // One medium after another: a fit of effective charges uses all threads.
            let engine = engine.in_medium(run, &interaction)?;
            media.push((salt_molar, engine, interaction));
        }
        let in_medium = |(salt_molar, engine, interaction): &(f64, Engine, ScreenedCoulomb)| {
            let energies = energies_kt(run, engine, interaction, &poses, progress)?;
            Ok((*salt_molar, energies))
        };
        let energies_kt = media.par_iter().map(in_medium).collect::<Result<_>>()?;
        Ok(Self {
            simulated_molar,
            frames,
            energies_kt,
            blocks: replicas * blocks_of_each,
        })
    }

    /// The energies of all frames at a salt, kT.
    pub(super) fn energies_kt(&self, salt_molar: f64) -> &[f64] {
        let is_meant = |row: &&(f64, Vec<f64>)| salt_label(row.0) == salt_label(salt_molar);
        let matching_row = self.energies_kt.iter().find(is_meant);
        matching_row.map_or(&[], |(_, energies)| energies)
    }

    /// The mean size of the energy of a body in frames in which no two touch, kT, at the salt where it
    /// is largest: zero where bodies that do not touch do not feel each other. `None` without such
    /// frames.
    pub(super) fn energy_apart_kt(&self, bodies: usize) -> Option<f64> {
        let mut largest: Option<f64> = None;
        for (salt, salt_molar) in self.simulated_molar.iter().enumerate() {
            let energies_kt = self.energies_kt(*salt_molar);
            let (mut sum, mut count) = (0.0, 0);
            for (frame, energy_kt) in self.frames.iter().zip(energies_kt) {
                // Each body a cluster of its own: nothing touches.
                if frame.salt == salt && frame.clusters == bodies {
                    sum += energy_kt.abs() / bodies as f64;
                    count += 1;
                }
            }
            if count > 0 {
                let mean = sum / f64::from(count);
                largest = Some(largest.map_or(mean, |largest| largest.max(mean)));
            }
        }
        largest
    }

    /// One row per frame, with its energies at the salts of the sweep.
    pub(super) fn table(&self) -> Result<String> {
        let mut heading = vec![
            "salt_M".to_owned(),
            "replica".into(),
            "block".into(),
            "contacts_left".into(),
            "bound_fraction".into(),
            "clusters".into(),
        ];
        for salt in &self.simulated_molar {
            heading.push(format!("energy_at_{salt}M_kT"));
        }
        let mut table = Table::new(heading);
        for (number, frame) in self.frames.iter().enumerate() {
            let mut row: Vec<Cell> = vec![
                self.simulated_molar[frame.salt].into(),
                frame.replica.into(),
                frame.block.into(),
                Cell::from(Some(frame.contacts_left).filter(|contacts| contacts.is_finite())),
                frame.bound_fraction.into(),
                frame.clusters.into(),
            ];
            for salt in &self.simulated_molar {
                row.push(self.energies_kt(*salt)[number].into());
            }
            table.push(row)?;
        }
        Ok(table.to_csv()?)
    }
}

fn measured(system: &System, gap_angstrom: f64, native: usize) -> Frame {
    let touching = contacts(system, gap_angstrom);
    let clusters = cluster_sizes(system.len(), &touching);
    let alone = clusters.iter().filter(|size| **size == 1).count();
    Frame {
        salt: 0,
        replica: 0,
        block: 0,
        contacts_left: match native {
            0 => f64::NAN,
            _ => touching.len() as f64 / native as f64,
        },
        bound_fraction: 1.0 - alone as f64 / system.len() as f64,
        clusters: clusters.len(),
    }
}

fn energies_kt(
    run: &RunSettings,
    engine: &Engine,
    interaction: &ScreenedCoulomb,
    frames: &[&[Pose]],
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let mut model = engine.energy_model(run, interaction)?;
    // The model is reset once and then asked about frames elsewhere, which keeps its tables.
    model.reset(&engine.system()?)?;
    let mut energies = Vec::with_capacity(frames.len());
    for poses in frames {
        let system = engine.system_at(poses)?;
        // Quick suffices: errors of energies are far below those of the weights.
        energies.push(model.energy_elsewhere_kt(&system, Pairs::All, Effort::Quick)?);
        progress.advance(1);
    }
    Ok(energies)
}
