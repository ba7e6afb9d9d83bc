//! The pages of runs, of sweeps of them, and of free energies of crystals.

pub mod free_energy;
pub mod run;
pub mod sweep;

/// Reason why a run of hard bodies does not tell whether it is in equilibrium.
const ONE_START: &str = "a run does not test it; compare the course with that of a run from \
                         another start (--start) or seed";
/// Beginning of the problem of bodies without a readable trajectory.
const NO_BODIES: &str = "The bodies cannot be shown";

/// Answer of a run to whether it is in equilibrium, as a reader sees it.
fn reached(is_reached: bool) -> String {
    match is_reached {
        true => "reached".into(),
        false => "not reached".into(),
    }
}
