//! The verbs, one file each: flags, the settings they make, the call, the reply.

mod assemblies;
mod bodies;
mod export;
mod frameworks;
mod generate;
mod hpmc;
mod lattice;
mod learning;
mod phase_diagram;
mod potential;
mod report;
mod shape;
mod stability;
mod voxels;

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Subcommand;

pub use frameworks::explain_usage;

/// A verb with its flags.
#[derive(Debug, Subcommand)]
pub enum Verb {
    Ingest(bodies::ingest::IngestArgs),
    Fetch(bodies::fetch::FetchArgs),
    Surface(bodies::surface::SurfaceArgs),
    Potential(potential::PotentialArgs),
    Shape(shape::ShapeArgs),
    Hpmc(hpmc::HpmcArgs),
    PhaseDiagram(phase_diagram::PhaseDiagramArgs),
    Body(bodies::body::BodyArgs),
    Assemble(assemblies::assemble::AssembleArgs),
    Candidates(assemblies::candidates::CandidatesArgs),
    Compare(stability::compare::CompareArgs),
    Framework(frameworks::FrameworkArgs),
    Inspect(stability::inspect::InspectArgs),
    Pair(Box<stability::pair::PairArgs>),
    Simulate(stability::simulate::SimulateArgs),
    Sweep(stability::sweep::SweepArgs),
    Lattice(lattice::LatticeArgs),
    Report(report::ReportArgs),
    Export(export::ExportArgs),
    Train(Box<learning::train::TrainArgs>),
    Predict(learning::predict::PredictArgs),
    Tune(Box<learning::tune::TuneArgs>),
    Voxelize(voxels::voxelize::VoxelizeArgs),
    Merge(voxels::merge::MergeArgs),
    Bench(stability::bench::BenchArgs),
    Completions(generate::CompletionsArgs),
    Man(generate::ManArgs),
}

impl Verb {
    /// Runs the verb.
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match self {
            Verb::Ingest(args) => args.run(front),
            Verb::Fetch(args) => args.run(front),
            Verb::Surface(args) => args.run(front),
            Verb::Potential(args) => args.run(front),
            Verb::Shape(args) => args.run(front),
            Verb::Hpmc(args) => args.run(front),
            Verb::PhaseDiagram(args) => args.run(),
            Verb::Body(args) => args.run(front),
            Verb::Assemble(args) => args.run(front),
            Verb::Candidates(args) => args.run(front),
            Verb::Compare(args) => args.run(front),
            Verb::Framework(args) => args.run(front),
            Verb::Inspect(args) => args.run(front),
            Verb::Pair(args) => args.run(front),
            Verb::Simulate(args) => args.run(front),
            Verb::Sweep(args) => args.run(front),
            Verb::Lattice(args) => args.run(front),
            Verb::Report(args) => args.run(front),
            Verb::Export(args) => args.run(front),
            Verb::Train(args) => args.run(front),
            Verb::Predict(args) => args.run(front),
            Verb::Tune(args) => args.run(front),
            Verb::Voxelize(args) => args.run(front),
            Verb::Merge(args) => args.run(front),
            Verb::Bench(args) => args.run(front),
            Verb::Completions(args) => args.run(),
            Verb::Man(args) => args.run(front),
        }
    }
}
