//! `protomer shape virial`: virial coefficients of hard bodies.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::range;
use protomer_shape_verbs::hard_bodies::settings::parse_depletants;
use protomer_shape_verbs::shapes::virial::{VirialSettings, virial_coefficients};

/// Print virial coefficients of hard bodies: the second one of a shape, or of two different shapes, exactly; and if
/// requested, the third one, and the second one among depletants.
///
/// Shapes are those of `shape`. A concave body is given by its convex pieces, joined by + as for `hpmc`; its
/// coefficients are sampled with --triples.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "shape virial cube tetrahedron",
    "shape virial cube --triples 100000 --depletants 0.1:5"
))]
pub struct VirialArgs {
    /// File or name of a shape.
    first: String,
    /// File or name of another shape, for B12; two bodies of the first if omitted.
    second: Option<String>,
    /// Radius of the ball, or disk, that rounds the first shape, or both if there is one.
    #[arg(long, default_value_t = 0.0, value_name = "RADIUS")]
    rounding: f64,
    /// Radius of the ball, or disk, that rounds the second shape.
    #[arg(long, default_value_t = 0.0, value_name = "RADIUS")]
    second_rounding: f64,
    /// Sample the third virial coefficient by this many triples of bodies, such as 100000.
    #[arg(long, default_value_t = 0, value_name = "NUMBER", value_parser = range::MOVES_OR_NONE.number::<u64>())]
    triples: u64,
    /// Penetrable hard spheres, or disks: radius and number density in the reservoir, such as 0.1:20; several with
    /// commas between them.
    #[arg(long, value_name = "RADIUS:FUGACITY,…", allow_hyphen_values = true)]
    depletants: Option<String>,
    /// Rays along which the coefficient among depletants is integrated.
    #[arg(long, default_value_t = 300, value_name = "NUMBER", value_parser = range::OBJECTS.number::<u64>())]
    rays: u64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl VirialArgs {
    pub fn run(&self) -> Result<Reply> {
        let depletants = self.depletants.as_deref().map(parse_depletants);
        Ok(Reply::data(virial_coefficients(&VirialSettings {
            first: self.first.clone(),
            second: self.second.clone(),
            rounding: self.rounding,
            second_rounding: self.second_rounding,
            triples: self.triples,
            depletants: depletants.transpose()?.unwrap_or_default(),
            rays: self.rays,
            seed: self.seed,
        })?))
    }
}
