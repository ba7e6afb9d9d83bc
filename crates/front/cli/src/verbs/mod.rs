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

/// Declares the verbs in groups, in the order of the help.
macro_rules! verbs {
    ($($group:literal { $($(#[cfg($feature:meta)])? $verb:ident($flags:ty),)* })*) => {
        /// A verb with its flags.
        #[derive(Debug, Subcommand)]
        pub enum Verb {
            $($($(#[cfg($feature)])? $verb($flags),)*)*
        }

        impl Verb {
            /// Runs the verb.
            pub fn run(&self, front: &Front) -> Result<Reply> {
                match self {
                    $($($(#[cfg($feature)])? Self::$verb(flags) => flags.run(front),)*)*
                }
            }
        }

        /// Groups of verbs by the names of their variants, also of those that this build does not have.
        pub const GROUPS: &[(&str, &[&str])] = &[$(($group, &[$(stringify!($verb)),*])),*];
    };
}

verbs! {
    "Structures" {
        Fetch(bodies::fetch::FetchArgs),
        Ingest(bodies::ingest::IngestArgs),
        Surface(bodies::surface::SurfaceArgs),
        Body(bodies::body::BodyArgs),
    }
    "Assemblies" {
        Assemble(assemblies::assemble::AssembleArgs),
        Candidates(assemblies::candidates::CandidatesArgs),
        Inspect(stability::inspect::InspectArgs),
        Export(export::ExportArgs),
    }
    "Stability" {
        Stability(Box<stability::equilibrium::StabilityArgs>),
        Simulate(stability::simulate::SimulateArgs),
        Sweep(stability::sweep::SweepArgs),
        Residues(stability::residues::ResiduesArgs),
        Reweight(stability::reweight::ReweightArgs),
        Compare(stability::compare::CompareArgs),
        Pair(Box<stability::pair::PairArgs>),
        Binding(Box<stability::binding::BindingArgs>),
        Score(Box<stability::score::ScoreArgs>),
        Scattering(scattering::ScatteringArgs),
    }
    "Potentials" {
        Potential(potential::PotentialArgs),
        Titrate(titrate::TitrateArgs),
    }
    "Learning" {
        #[cfg(feature = "learning")]
        Voxelize(voxels::voxelize::VoxelizeArgs),
        #[cfg(feature = "learning")]
        Merge(voxels::merge::MergeArgs),
        #[cfg(feature = "learning")]
        Train(Box<learning::train::TrainArgs>),
        #[cfg(feature = "learning")]
        Tune(Box<learning::tune::TuneArgs>),
        #[cfg(feature = "learning")]
        Predict(learning::predict::PredictArgs),
    }
    "Lattices" {
        Lattice(lattice::LatticeArgs),
        Framework(frameworks::FrameworkArgs),
    }
    "Hard shapes" {
        Shape(shape::ShapeArgs),
        Hpmc(hpmc::HpmcArgs),
        FreeEnergy(free_energy::FreeEnergyArgs),
        Md(md::MdArgs),
        PhaseDiagram(phase_diagram::PhaseDiagramArgs),
    }
    "Tools" {
        Report(report::ReportArgs),
        Bench(stability::bench::BenchArgs),
        Completions(generate::CompletionsArgs),
        Man(generate::ManArgs),
    }
}
