//! `log.csv`: energies, temperatures and pressure of a run at regular steps.

use super::settings::DynamicsSettings;
use protomer_md::engine::Engine;

protomer_results::log_row! {
    /// One row of the log. Reduced units, energies per body.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub struct LogRow {
        /// Steps since the preparation; below zero during it.
        pub step: i64,
        /// Time since the preparation; below zero during it.
        pub time: f64,
        /// Energy of the repulsion and of everything in addition to it.
        pub potential_energy: f64 => "energy per body" as "potential",
        /// Potential energy and energy of the motion.
        pub energy: f64 => "energy per body" as "potential and motion",
        /// The energy without the heat of the bath.
        pub kept_energy: f64 => "conserved energy per body",
        /// kT of all motion.
        pub temperature: f64 => "kT" as "all motion",
        /// kT of the centres.
        pub translational_temperature: f64 => "kT" as "centres",
        /// kT of the rotations.
        pub rotational_temperature: f64 => "kT" as "rotations",
        /// Pressure.
        pub pressure: f64 => "pressure",
        /// Part of the space that bodies with their layer fill.
        pub packing_fraction: f64 => "packing fraction",
        /// Energy of the pair potential, a part of the potential energy; in the log of a run that has one.
        pub pair_potential_energy: Option<f64> = None => "energy per body" as "pair potential",
        /// Energy of the field, a part of the potential energy; in the log of a run that has one.
        pub field_energy: Option<f64> = None => "energy per body" as "field",
    }
}

impl LogRow {
    /// The row of a state.
    pub fn new(step: i64, time: f64, engine: &Engine, volume_with_layer: f64) -> Self {
        let bodies = engine.bodies();
        let count = bodies.count() as f64;
        let [
            temperature,
            translational_temperature,
            rotational_temperature,
        ] = engine.temperatures();
        let added = engine.added_energies();
        let volume = engine.motion().state.volume(bodies.dimension());
        Self {
            step,
            time,
            potential_energy: engine.motion().potential_energy / count,
            energy: engine.energy() / count,
            kept_energy: engine.kept_energy() / count,
            temperature,
            translational_temperature,
            rotational_temperature,
            pressure: engine.pressure(),
            packing_fraction: count * volume_with_layer / volume,
            pair_potential_energy: added.pairs.map(|energy| energy / count),
            field_energy: added.heights.map(|energy| energy / count),
        }
    }

    /// The columns of energies that a run with these settings does not have.
    pub fn left_out(settings: &DynamicsSettings) -> Vec<&'static str> {
        let mut columns = Vec::new();
        if settings.pair_potential.is_empty() {
            columns.push("pair_potential_energy");
        }
        if settings.field.is_none() {
            columns.push("field_energy");
        }
        columns
    }
}
