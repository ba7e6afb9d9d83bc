//! The kind of results in a directory, with their settings.

use crate::contents::ContentsOf;
use anyhow::{Result, bail};
#[cfg(feature = "learning")]
use protomer_learn_verbs::{learning, voxels};
use protomer_linkage_verbs::{frameworks, lattice};
use protomer_protein_verbs::file_kind::FileKind;
use protomer_protein_verbs::stability::{equilibrium, pair, score};
use protomer_protein_verbs::titration;
use protomer_results::ResultKind;
use protomer_shape_verbs::{dynamics, hard_bodies};
use std::path::Path;

/// The kind of results in a directory.
#[derive(Debug)]
pub enum Kind {
    /// A simulation of bodies, or a sweep of simulations, whose assembly may have moved.
    Sweep,
    /// Results whose crate states the contents of their page.
    Stated(ContentsOf),
}

/// Determines the kind of results in a directory.
///
/// # Errors
/// If it holds none of these, or its settings cannot be read.
pub fn detect(directory: &Path) -> Result<Kind> {
    if !directory.is_dir() {
        #[cfg(feature = "learning")]
        if voxels::work_path(directory).is_file() {
            bail!(
                "the set {} is not complete yet; the same 'protomer voxelize' command continues it",
                directory.display()
            );
        }
        FileKind::Results(ResultKind::Sweep).require(directory)?;
        bail!(
            "{} is not a directory; give one that protomer wrote its results into",
            directory.display()
        );
    }
    Ok(match ResultKind::detect(directory) {
        Some(ResultKind::Sweep) => Kind::Sweep,
        Some(ResultKind::Pair) => Kind::Stated(pair::page::contents),
        Some(ResultKind::Equilibrium) => Kind::Stated(equilibrium::page::contents),
        Some(ResultKind::Scores) => Kind::Stated(score::page::contents),
        Some(ResultKind::Titration) => Kind::Stated(titration::page::contents),
        Some(ResultKind::LatticeRun) => Kind::Stated(lattice::page::run::contents),
        Some(ResultKind::LatticeSweep) => Kind::Stated(lattice::page::sweep::contents),
        Some(ResultKind::HardBodies) => Kind::Stated(hard_bodies::page::run::contents),
        Some(ResultKind::HardBodySweep) => Kind::Stated(hard_bodies::page::sweep::contents),
        Some(ResultKind::FreeEnergy) => Kind::Stated(hard_bodies::page::free_energy::contents),
        Some(ResultKind::DynamicsRun) => Kind::Stated(dynamics::page::contents),
        Some(ResultKind::ElasticConstants) => Kind::Stated(frameworks::page::contents),
        Some(ResultKind::FrameworkTables) => Kind::Stated(frameworks::tables::page::contents),
        #[cfg(feature = "learning")]
        Some(ResultKind::Training) => Kind::Stated(learning::train::page::contents),
        #[cfg(feature = "learning")]
        Some(ResultKind::Search) => Kind::Stated(learning::tune::page::contents),
        #[cfg(feature = "learning")]
        Some(ResultKind::VoxelSet) => Kind::Stated(voxels::page::contents),
        #[cfg(not(feature = "learning"))]
        Some(kind @ (ResultKind::Training | ResultKind::Search | ResultKind::VoxelSet)) => bail!(
            "{} holds {kind}, and this protomer was built without the feature `learning`; install it \
             with its default features",
            directory.display()
        ),
        Some(ResultKind::Simulation) => bail!(
            "{} is one simulation of a sweep; give the directory of the sweep, which holds run.toml",
            directory.display()
        ),
        Some(ResultKind::PairCondition) => bail!(
            "{} is one condition of a pair; give the directory of the pair, which holds run.toml",
            directory.display()
        ),
        Some(ResultKind::EquilibriumCondition) => bail!(
            "{} is one condition of an equilibrium; give the directory that holds run.toml",
            directory.display()
        ),
        Some(ResultKind::FreeEnergyStrength) => bail!(
            "{} is one strength of a free energy; give the directory that holds run.toml",
            directory.display()
        ),
        None if directory.join("run.toml").is_file() => bail!(
            "{} holds the settings of work that has not begun; the same command begins it, and then it has a page",
            directory.display()
        ),
        Some(ResultKind::Other(_)) | None => bail!(
            "{} holds no results that a report can show; give the directory of a {} command",
            directory.display(),
            verbs()
        ),
    })
}

/// The verbs whose directories have a page, as in "a *simulate, sweep or pair* command".
fn verbs() -> String {
    let mut verbs: Vec<&str> = ResultKind::all()
        .flat_map(ResultKind::verbs)
        .copied()
        .collect();
    let last = verbs.pop().unwrap_or_default();
    format!("{} or {last}", verbs.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_that_a_verb_writes_has_a_page() {
        for kind in ResultKind::all().filter(|kind| !kind.verbs().is_empty()) {
            let folder = tempfile::tempdir().unwrap();
            let record = format!("{{\"kind\": \"{}\"}}", kind.word());
            std::fs::write(folder.path().join("run.json"), record).unwrap();
            // Some then miss their settings.
            if let Err(error) = detect(folder.path()) {
                let told = error.to_string();
                assert!(!told.contains("no results that a report"), "{told}");
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let told = detect(folder.path()).unwrap_err().to_string();
        for verb in ["simulate", "md run", "hpmc sweep", "free-energy"] {
            assert!(told.contains(verb), "{told}");
        }
        std::fs::write(folder.path().join("run.toml"), "bodies = 36").unwrap();
        let told = detect(folder.path()).unwrap_err().to_string();
        assert!(told.contains("has not begun"), "{told}");
    }
}
