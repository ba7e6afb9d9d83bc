//! What tests at constant pressure share.

use protomer_hpmc::box_moves::{Freedom, Pressure};
use protomer_hpmc::simulation::Settings;

/// A run at a constant pressure, kT per volume.
pub fn pressed(kt_per_volume: f64, freedom: Freedom) -> Settings {
    Settings {
        equilibration_sweeps: 2000,
        pressure: Some(Pressure {
            kt_per_volume,
            freedom,
            changes_per_sweep: None,
        }),
        ..Settings::default()
    }
}
