//! Flags of hard bodies, shared by the verbs that move them and those that look for room among them.

use clap::Args;

/// The rounding of a shape.
#[derive(Debug, Args)]
pub struct RoundingArgs {
    /// Radius of the ball, or disk, that rounds it (Minkowski sum).
    #[arg(long, default_value_t = 0.0, value_name = "RADIUS")]
    pub rounding: f64,
}

/// A hard body.
#[derive(Debug, Args)]
pub struct HardBodyArgs {
    /// File with points, or the name of a shape, as for `shape`; rod:LENGTH for rods on a line. Several joined
    /// by + are the convex pieces of one body.
    #[arg(long, value_name = "FILE")]
    pub shape: String,
    #[command(flatten)]
    pub rounding: RoundingArgs,
}

/// Conditions of free volumes: all pairs of a packing fraction and a radius.
#[derive(Debug, Args)]
pub struct FreeVolumeGridArgs {
    /// The part of space that the bodies fill; several with commas between them.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "FRACTION,…",
        required = true
    )]
    pub packing_fraction: Vec<f64>,
    /// Radius of the depletants; several with commas between them.
    #[arg(long, value_delimiter = ',', value_name = "RADIUS,…", required = true)]
    pub depletant_radius: Vec<f64>,
}
