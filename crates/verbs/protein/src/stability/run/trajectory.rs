//! `trajectory.gsd`: the poses of all bodies, with their meshes.

use crate::assemblies::assembly_file::Assembly;
use anyhow::Result;
use protomer_io::gsd::trajectory::{enclosing_box, frame_chunks, header_chunks};
use protomer_io::gsd::{Chunk, ParticleType, TrajectoryFrame, TrajectoryHeader, TrajectoryWriter};
use protomer_mc::Simulation;
use std::path::Path;

/// A trajectory that is being written.
#[derive(Debug)]
pub struct Trajectory {
    writer: TrajectoryWriter,
    box_angstrom: Option<[f64; 3]>,
    largest_radius_angstrom: f64,
}

impl Trajectory {
    /// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one).
    ///
    /// # Errors
    /// If the file cannot be written, or holds fewer frames than the checkpoint records.
    pub fn open(path: &Path, assembly: &Assembly, frames: u64) -> Result<Self> {
        let header = trajectory_header(assembly);
        let writer = match frames {
            0 => TrajectoryWriter::create(path, &header)?,
            _ => TrajectoryWriter::resume(path, &header, frames)?,
        };
        Ok(Self {
            writer,
            box_angstrom: assembly.box_angstrom(),
            largest_radius_angstrom: largest_radius_angstrom(assembly),
        })
    }

    /// Appends the current state.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn append(&mut self, sweep: u64, simulation: &Simulation) -> Result<()> {
        let poses = simulation.system().poses();
        let charges_e = simulation.net_charges_e();
        let box_lengths_angstrom = self
            .box_angstrom
            .unwrap_or_else(|| enclosing_box(poses, self.largest_radius_angstrom));
        Ok(self.writer.append(&TrajectoryFrame {
            step: sweep,
            box_lengths_angstrom,
            poses,
            log: &logged(simulation),
            charges_e: charges_e.as_deref(),
        })?)
    }

    /// Flushes everything to disk and returns the number of frames.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sync(&mut self) -> Result<u64> {
        self.writer.sync()?;
        Ok(self.writer.frames())
    }
}

/// Observables in every frame.
fn logged(simulation: &Simulation) -> [(&'static str, f64); 2] {
    let observables = simulation.observables();
    [
        ("r_g_angstrom", observables.r_g_angstrom),
        ("energy_kT", observables.energy_kt),
    ]
}

fn largest_radius_angstrom(assembly: &Assembly) -> f64 {
    let bodies = assembly.bodies.iter();
    let radii = bodies.map(|body| body.mesh_radius_angstrom());
    radii.fold(0.0, f64::max)
}

/// Data of a trajectory that are the same in every frame.
///
/// # Errors
/// If a name does not fit.
pub(crate) fn header(assembly: &Assembly) -> Result<Vec<Chunk>> {
    Ok(header_chunks(&trajectory_header(assembly))?)
}

/// The present state as a frame.
pub(crate) fn frame(sweep: u64, simulation: &Simulation, assembly: &Assembly) -> Vec<Chunk> {
    let poses = simulation.system().poses();
    let charges_e = simulation.net_charges_e();
    let enclosing = || enclosing_box(poses, largest_radius_angstrom(assembly));
    frame_chunks(&TrajectoryFrame {
        step: sweep,
        box_lengths_angstrom: assembly.box_angstrom().unwrap_or_else(enclosing),
        poses,
        log: &logged(simulation),
        charges_e: charges_e.as_deref(),
    })
}

fn trajectory_header(assembly: &Assembly) -> TrajectoryHeader {
    let particle_type = |body: &std::sync::Arc<protomer_body::Body>| ParticleType {
        name: body.name.clone(),
        mesh: Some(body.mesh.clone()),
    };
    TrajectoryHeader {
        types: assembly.bodies.iter().map(particle_type).collect(),
        type_ids: assembly.kinds.iter().map(|kind| *kind as u32).collect(),
        charges_e: assembly
            .kinds
            .iter()
            .map(|kind| assembly.bodies[*kind].net_charge_e())
            .collect(),
    }
}
