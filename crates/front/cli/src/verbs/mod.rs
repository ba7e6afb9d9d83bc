//! The verbs, one file each: flags, the settings they make, the call, the reply.

mod assemblies;
mod bodies;
mod export;
mod frameworks;
mod free_energy;
mod generate;
mod hpmc;
mod lattice;
#[cfg(feature = "learning")]
mod learning;
mod md;
mod phase_diagram;
mod potential;
mod report;
mod scattering;
mod shape;
mod stability;
mod titrate;
#[cfg(feature = "learning")]
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
    Titrate(titrate::TitrateArgs),
    Shape(shape::ShapeArgs),
    Md(md::MdArgs),
    Hpmc(hpmc::HpmcArgs),
    FreeEnergy(free_energy::FreeEnergyArgs),
    PhaseDiagram(phase_diagram::PhaseDiagramArgs),
    Body(bodies::body::BodyArgs),
    Assemble(assemblies::assemble::AssembleArgs),
    Candidates(assemblies::candidates::CandidatesArgs),
    Compare(stability::compare::CompareArgs),
    Framework(frameworks::FrameworkArgs),
    Inspect(stability::inspect::InspectArgs),
    Binding(Box<stability::binding::BindingArgs>),
    Score(Box<stability::score::ScoreArgs>),
    Pair(Box<stability::pair::PairArgs>),
    Stability(Box<stability::equilibrium::StabilityArgs>),
    Simulate(stability::simulate::SimulateArgs),
    Sweep(stability::sweep::SweepArgs),
    Residues(stability::residues::ResiduesArgs),
    Reweight(stability::reweight::ReweightArgs),
    Lattice(lattice::LatticeArgs),
    Report(report::ReportArgs),
    Export(export::ExportArgs),
    Scattering(scattering::ScatteringArgs),
    #[cfg(feature = "learning")]
    #[command(flatten)]
    Learning(learning::LearningVerb),
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
            Verb::Titrate(args) => args.run(front),
            Verb::Shape(args) => args.run(front),
            Verb::Md(args) => args.run(front),
            Verb::Hpmc(args) => args.run(front),
            Verb::FreeEnergy(args) => args.run(front),
            Verb::PhaseDiagram(args) => args.run(front),
            Verb::Body(args) => args.run(front),
            Verb::Assemble(args) => args.run(front),
            Verb::Candidates(args) => args.run(front),
            Verb::Compare(args) => args.run(front),
            Verb::Framework(args) => args.run(front),
            Verb::Inspect(args) => args.run(front),
            Verb::Binding(args) => args.run(front),
            Verb::Score(args) => args.run(front),
            Verb::Pair(args) => args.run(front),
            Verb::Stability(args) => args.run(front),
            Verb::Simulate(args) => args.run(front),
            Verb::Sweep(args) => args.run(front),
            Verb::Residues(args) => args.run(front),
            Verb::Reweight(args) => args.run(front),
            Verb::Lattice(args) => args.run(front),
            Verb::Report(args) => args.run(front),
            Verb::Export(args) => args.run(front),
            Verb::Scattering(args) => args.run(front),
            #[cfg(feature = "learning")]
            Verb::Learning(verb) => verb.run(front),
            Verb::Bench(args) => args.run(front),
            Verb::Completions(args) => args.run(),
            Verb::Man(args) => args.run(front),
        }
    }
}
