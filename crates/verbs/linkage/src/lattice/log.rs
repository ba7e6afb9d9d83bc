//! `log.csv`: observables of a run at regular steps.

use protomer_linkage::analysis::modes::{ModeEnergies, Modes, OutOf, orientational_spread};
use protomer_linkage::analysis::strain::{biot_strain, gradient_between};
use protomer_linkage::lattice::{Mover, Network, State};

protomer_results::log_row! {
    /// One row of the log. Reduced units.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub struct LogRow {
        /// Number of steps done.
        pub step: u64,
        /// Time.
        pub time: f64,
        /// Kinetic energy.
        pub kinetic_energy: f64,
        /// Energy of the potentials.
        pub potential_energy: f64,
        /// Sum of the kinetic energy and the energy of the potentials.
        pub energy: f64,
        /// Mean orientation ⟨θ⟩₀.
        pub uniform: f64,
        /// Amplitude ⟨θ⟩₁ of (-1)^(i+j).
        pub checkerboard: f64,
        /// Amplitude of (-1)^j.
        pub vertical: f64,
        /// Amplitude of (-1)^i.
        pub horizontal: f64,
        /// Share of the checkerboard mode in the rotational energy, without that of the uniform mode;
        /// NaN if nothing rotates.
        pub checkerboard_fraction: f64,
        /// Share of the checkerboard mode in the energy as a whole, without that of the uniform mode.
        pub checkerboard_fraction_of_total: f64,
        /// Standard deviation of the angles about the coherent state.
        pub angle_spread: f64,
        /// Strain along x since the start, of a flexible cell or else from the corners of all squares.
        pub strain_xx: f64,
        /// Strain along y since the start.
        pub strain_yy: f64,
        /// Shear since the start.
        pub strain_xy: f64,
        /// Strain along x since the last row.
        pub step_strain_xx: f64,
        /// Strain along y since the last row.
        pub step_strain_yy: f64,
        /// Largest deviation of a rod from its length.
        pub rod_violation: f64,
        /// Number of collisions so far.
        pub events: u64,
        /// Rate of change of `checkerboard`; NaN in logs of earlier versions.
        pub checkerboard_rate: f64 = f64::NAN,
    }
}

impl LogRow {
    /// Computes the row of a state; strains are relative to the positions at the start and at
    /// the last row.
    pub fn new(step: u64, mover: &mut Mover, state: &State, start: &[f64], last: &[f64]) -> Self {
        let network = mover.network().clone();
        let potential_energy = mover.potential_energy();
        let kinetic_energy = state.kinetic_energy(&network);
        let modes = Modes::from_coordinates(&network, &state.positions);
        let energies = ModeEnergies::from_state(&network, state);
        let fraction = |out_of| {
            energies
                .checkerboard_fraction(out_of, potential_energy)
                .unwrap_or(f64::NAN)
        };
        let [strain_xx, strain_yy, strain_xy] = strain(&network, start, &state.positions);
        let [step_strain_xx, step_strain_yy, _] = strain(&network, last, &state.positions);
        Self {
            step,
            time: state.time,
            kinetic_energy,
            potential_energy,
            energy: kinetic_energy + potential_energy,
            uniform: modes.uniform,
            checkerboard: modes.checkerboard,
            vertical: modes.vertical,
            horizontal: modes.horizontal,
            checkerboard_fraction: fraction(OutOf::Rotational),
            checkerboard_fraction_of_total: fraction(OutOf::Total),
            angle_spread: orientational_spread(&network, &state.positions),
            strain_xx,
            strain_yy,
            strain_xy,
            step_strain_xx,
            step_strain_yy,
            rod_violation: mover.rod_violation(state),
            events: mover.events(),
            checkerboard_rate: Modes::from_coordinates(&network, &state.velocities).checkerboard,
        }
    }
}

/// Components xx, yy and xy of the strain from one array of positions to another; NaN where it is
/// undefined.
fn strain(network: &Network, from: &[f64], to: &[f64]) -> [f64; 3] {
    match gradient_between(network, from, to) {
        Ok(gradient) => {
            let strain = biot_strain(&gradient);
            [strain[(0, 0)], strain[(1, 1)], strain[(0, 1)]]
        }
        Err(_) => [f64::NAN; 3],
    }
}
