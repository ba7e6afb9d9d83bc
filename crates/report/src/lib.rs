//! A directory of results as one self-contained HTML page: figures with their numbers, rotatable
//! shapes, animated lattices, conditions, provenance, and failures.
//!
//! ```text
//! directory --kind--> what it holds --monte_carlo, lattice, framework, training, ...--> sections --page--> report.html
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `kind` | what a directory holds |
//! | `monte_carlo`, `lattice`, `framework`, `framework_tables`, `hard_bodies`, `dynamics`, `pair`, `learning` | the sections of each kind |
//! | `verdict` | whether a run is in equilibrium, or a control passed, according to the run itself |
//! | `traces` | the logs of simulations as a figure |
//! | `scenes` | the bodies shown, and their positions |
//! | `convex_bodies` | convex shapes and unions of them, from a trajectory |
//! | `pair_surfaces` | two bodies in their best pose, coloured by the energies of residues |
//! | `residues` | what holds an assembly together |
//! | `companions` | what other verbs left in the directory of a run |
//! | `mesh_view` | meshes as data for the viewer |
//! | `figures`, `data` | embedded figures, folded tables with a link to save them |
//! | `provenance` | version, hashes, seed, how it ended |
//! | `page`, `html` | the page around the sections, and its HTML |
//!
//! The same directory gives the same bytes. The page loads nothing: it carries a policy that
//! forbids the browser to do so.

mod companions;
mod convex_bodies;
mod data;
mod dynamics;
mod figures;
mod framework;
mod framework_tables;
mod hard_bodies;
mod html;
mod kind;
mod lattice;
#[cfg(feature = "learning")]
mod learning;
mod mesh_view;
mod monte_carlo;
mod page;
mod pair;
mod pair_surfaces;
mod provenance;
mod residues;
mod scenes;
mod traces;
mod verdict;

use anyhow::{Result, bail};
use kind::Kind;
use page::Page;
use protomer_common::answer::Answer;
use protomer_common::output_file::write_once;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of a report.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The output file; by default `report.html` in the directory, or beside it for a set of
    /// voxels.
    pub output: Option<PathBuf>,
    /// The assembly of a sweep or a simulation, if it has moved.
    pub assembly: Option<PathBuf>,
    /// Whether to overwrite an existing page.
    pub force: bool,
}

/// A page that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Written {
    /// Path of the page.
    pub page: PathBuf,
    /// Size of the page, bytes.
    pub bytes: usize,
    /// Titles of the sections of the page.
    pub sections: Vec<String>,
}

impl Answer for Written {
    fn text(&self) -> String {
        format!("{}: {}", self.page.display(), self.sections.join(", "))
    }
}

/// Writes the page of a directory.
///
/// # Errors
/// If the directory holds no results, one of its files is damaged, the page already exists, or
/// it cannot be written.
pub fn report(directory: &Path, request: &Request) -> Result<Written> {
    let kind = kind::of(directory)?;
    let page = request
        .output
        .clone()
        .unwrap_or_else(|| default_page(directory, &kind));
    let contents = page_of(directory, &kind, request.assembly.as_deref())?;
    let html = contents.to_html();
    write_once(&page, &html, request.force)?;
    Ok(Written {
        page,
        bytes: html.len(),
        sections: contents.titles(),
    })
}

/// `report.html` in the directory; a zarr group must not contain other files, so its page is
/// written beside it: `SET.zarr.report.html`.
fn default_page(directory: &Path, kind: &Kind) -> PathBuf {
    match kind {
        #[cfg(feature = "learning")]
        Kind::Learning(learning::Learning::VoxelSet) => {
            directory.with_file_name(provenance::name(directory) + ".report.html")
        }
        _ => directory.join("report.html"),
    }
}

fn page_of(directory: &Path, kind: &Kind, assembly: Option<&Path>) -> Result<Page> {
    match kind {
        Kind::MonteCarlo(settings) => monte_carlo::page(directory, settings, assembly),
        _ if assembly.is_some() => {
            bail!("{} has no assembly; omit --assembly", directory.display())
        }
        Kind::Pair => pair::page(directory),
        Kind::Lattice(settings) => lattice::page_of_run(directory, settings),
        Kind::LatticeSweep(settings) => lattice::page_of_sweep(directory, settings),
        Kind::HardBodies => hard_bodies::page_of_run(directory),
        Kind::HardBodySweep => hard_bodies::page_of_sweep(directory),
        Kind::FreeEnergy => hard_bodies::page_of_free_energy(directory),
        Kind::Dynamics => dynamics::page(directory),
        Kind::Framework => framework::page(directory),
        Kind::FrameworkTables => framework_tables::page(directory),
        #[cfg(feature = "learning")]
        Kind::Learning(results) => results.page(directory),
    }
}
