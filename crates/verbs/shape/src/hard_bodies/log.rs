//! `log.csv`: the measurements of a run.

use protomer_hpmc::heights::Walls;

protomer_results::log_row! {
    /// One measurement.
    #[derive(Debug, Clone, PartialEq)]
    pub struct LogRow {
        /// Sweeps done, with those of the equilibration.
        pub sweep: u64,
        /// Compressibility factor.
        pub compressibility_factor: f64 => "compressibility factor",
        /// The part of inserted bodies that overlap none.
        pub insertion_probability: Option<f64> => "insertion probability",
        /// Free volume of each depletant, as a part of the box.
        pub free_volume_fraction: Vec<f64> => "free volume fraction",
        /// The part of the box that the bodies fill.
        pub packing_fraction: f64 => "packing fraction",
        /// Pressure on the lower wall, kT per volume; between walls, as the next two.
        pub lower_wall_pressure: Option<f64> => "pressure on a wall" as "lower wall",
        /// Pressure on the upper wall, kT per volume.
        pub upper_wall_pressure: Option<f64> => "pressure on a wall" as "upper wall",
        /// Mean height of the bodies over the lower wall.
        pub mean_height: Option<f64> => "mean height",
        /// Lengths of the box, where more than its volume changes.
        pub box_lengths: Vec<f64> = Vec::new() => "length of the box" as "x" | "y" | "z",
        /// Tilt factors of the box, where more than its volume changes.
        pub box_tilt_factors: Vec<f64> = Vec::new() => "tilt factor of the box" as "xy" | "xz" | "yz",
        /// Energy of all pairs over the number of bodies, kT, with a potential.
        pub energy("energy_kt_per_body"): Option<f64> = None => "energy per body (kT)",
    }
}

impl LogRow {
    /// Pressures on the walls and mean height of the bodies, between walls.
    pub fn walls(&self) -> Option<Walls> {
        Some(Walls {
            pressures: [self.lower_wall_pressure?, self.upper_wall_pressure?],
            mean_height: self.mean_height?,
        })
    }
}
