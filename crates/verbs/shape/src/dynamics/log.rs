//! `log.csv`: energies, temperatures and pressure of a run at regular steps.

use protomer_md::engine::Engine;

protomer_results::log_row! {
    /// One row of the log. Reduced units, energies per body.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub struct LogRow {
        /// Steps since the preparation; below zero during it.
        pub step: i64,
        /// Time since the preparation; below zero during it.
        pub time: f64,
        /// Energy of the repulsion.
        pub potential_energy: f64 => "energy per body" as "repulsion",
        /// Energy of the repulsion and the motion.
        pub energy: f64 => "energy per body" as "repulsion and motion",
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
        }
    }
}
