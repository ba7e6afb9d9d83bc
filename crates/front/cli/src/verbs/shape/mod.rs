//! `protomer shape`: what is known exactly of a convex shape, and what two shapes feel.

mod contact;
mod free_volume;
mod overlap_volume;
mod virial;

use crate::flags::hard_body::RoundingArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use protomer_common::output_file::MeshFormat;
use protomer_shape_verbs::shapes::measure_shape;
use std::path::PathBuf;

/// Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second
/// virial coefficient, exactly.
///
/// The shape is that of a file: the corners of a convex polygon (text with two columns), the convex
/// hull of points in space (three columns), or a convex mesh, such as an .off file; concave ones are
/// refused. One point with a rounding is a disk or a ball. Or it has a name: tetrahedron, cube,
/// octahedron, dodecahedron, icosahedron, truncated-octahedron, rhombic-dodecahedron (edges of length
/// 1), truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1, the octahedron;
/// 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area 1),
/// ellipse:A,B and ellipsoid:A,B,C (half axes).
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, arg_required_else_help = true)]
#[command(after_long_help = examples!(
    "shape cube --rounding 0.1",
    "shape corners.txt -o hull.ply"
))]
pub struct ShapeArgs {
    /// File with points, or the name of a shape.
    shape: Option<String>,
    #[command(flatten)]
    rounding: RoundingArgs,
    #[arg(short, long, help = format!("Mesh file to write, without the rounding: {}", MeshFormat::extensions()))]
    output: Option<PathBuf>,
    #[command(subcommand)]
    verb: Option<ShapeVerb>,
}

#[derive(Debug, Subcommand)]
enum ShapeVerb {
    Contact(contact::ContactArgs),
    OverlapVolume(overlap_volume::OverlapVolumeArgs),
    Virial(virial::VirialArgs),
    FreeVolume(free_volume::FreeVolumeArgs),
}

impl ShapeArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match (&self.verb, &self.shape) {
            (Some(ShapeVerb::Contact(args)), _) => args.run(front),
            (Some(ShapeVerb::OverlapVolume(args)), _) => args.run(),
            (Some(ShapeVerb::Virial(args)), _) => args.run(),
            (Some(ShapeVerb::FreeVolume(args)), _) => args.run(),
            (None, Some(shape)) => {
                let output = self.output.as_deref();
                let report = measure_shape(shape, self.rounding.rounding, output, front.force())?;
                Ok(Reply::data(report))
            }
            (None, None) => {
                bail!("give the file or the name of a shape, or: shape contact PAIRS.json")
            }
        }
    }
}
