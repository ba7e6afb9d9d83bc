//! A directory of results as one self-contained HTML page: figures with their numbers, rotatable
//! shapes, animated lattices, conditions, provenance, and failures.
//!
//! ```text
//! directory --kind--> what it holds --contents of its crate--> sections --page--> report.html
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `kind` | what a directory holds |
//! | `contents` | pages whose contents the crate of the results states |
//! | `mesh_view` | meshes as data for the viewer |
//! | `figures`, `data` | embedded figures, folded tables with a link to save them |
//! | `provenance` | version, hashes, seed, how it ended |
//! | `page`, `html` | the page around the sections, and its HTML |
//!
//! The same directory gives the same bytes. The page loads nothing: it carries a policy that
//! forbids the browser to do so. It works offline and for ever, because the viewer, figures and
//! data are in the page. The viewer is our own: the usual 3D libraries are half a megabyte and
//! more, and its script, which also plays films, is under 13 kB.

mod contents;
mod data;
mod figures;
mod html;
mod kind;
mod mesh_view;
mod page;
mod provenance;
mod sortable;

use anyhow::{Result, bail};
use kind::Kind;
use page::Page;
use protomer_common::answer::Answer;
use protomer_common::output_file::write_once;
use protomer_protein_verbs::stability::sweep;
use protomer_results::{Record, ResultKind};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of a report.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The output file; by default `report.html` in the directory, or next to it for a set of
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
    let kind = kind::detect(directory)?;
    let page = request
        .output
        .clone()
        .unwrap_or_else(|| default_page(directory));
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
/// written next to it: `SET.zarr.report.html`.
fn default_page(directory: &Path) -> PathBuf {
    match ResultKind::detect(directory) {
        Some(ResultKind::VoxelSet) => {
            directory.with_file_name(provenance::name(directory) + ".report.html")
        }
        _ => directory.join("report.html"),
    }
}

fn page_of(directory: &Path, kind: &Kind, assembly: Option<&Path>) -> Result<Page> {
    match kind {
        Kind::Sweep => {
            let record = Record::read(directory)?;
            let record = record.as_ref();
            let contents = sweep::page::contents(directory, record, assembly)?;
            contents::arranged(directory, record, contents)
        }
        _ if assembly.is_some() => {
            bail!("{} has no assembly; omit --assembly", directory.display())
        }
        Kind::Stated(contents) => contents::page(directory, *contents),
    }
}
