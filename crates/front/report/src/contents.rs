//! Pages whose contents the crate of the results states: arranged, with their provenance, as HTML.

use super::html::{definitions, escape, folded_text, list, paragraph, shares, table};
use super::page::{Page, Section};
use super::{data, figures, mesh_view, provenance, sortable};
use anyhow::Result;
use protomer_common::page::{self, Contents, Data, Part, Program};
use protomer_results::Record;
use std::path::Path;

/// States what the page of a directory shows.
pub type ContentsOf = fn(&Path, Option<&Record>) -> Result<Contents>;

/// The page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path, contents: ContentsOf) -> Result<Page> {
    let record = Record::read(directory)?;
    let contents = contents(directory, record.as_ref())?;
    arranged(directory, record.as_ref(), contents)
}

/// The page with these contents.
///
/// # Errors
/// If a file that belongs on it is damaged.
pub fn arranged(directory: &Path, record: Option<&Record>, contents: Contents) -> Result<Page> {
    let origin = contents.origin;
    let mut problems = Vec::new();
    if origin.is_run {
        problems.extend(provenance::unfinished(record));
    }
    problems.extend(contents.problems);
    let mut sections = Vec::new();
    for stated in contents.sections {
        sections.push(section(directory, stated)?);
    }
    let record = record.filter(|_| origin.is_run);
    let mut provenance = provenance::section(directory, &origin.settings, record, origin.more)?;
    if !origin.note.is_empty() {
        provenance.html += &paragraph(origin.note);
    }
    sections.push(provenance);
    Ok(Page {
        title: format!("{}: {}", contents.title, provenance::name(directory)),
        subtitle: contents.subtitle,
        verdict: contents.verdict,
        problems,
        sections,
    })
}

fn section(directory: &Path, stated: page::Section) -> Result<Section> {
    let mut section = Section::new(stated.title, String::new());
    for part in stated.parts {
        match part {
            Part::Scenes(shown) => add(&mut section, mesh_view::program(&shown)),
            Part::Program(program) => add(&mut section, program),
            Part::Sortable { columns, rows } => {
                add(&mut section, sortable::program(&columns, &rows));
            }
            part => section.html += &to_html(directory, part)?,
        }
    }
    Ok(section)
}

fn add(section: &mut Section, program: Program) {
    section.html += &program.html;
    section.programs.push(program);
}

/// A part without a program.
fn to_html(directory: &Path, part: Part) -> Result<String> {
    Ok(match part {
        Part::Paragraph(text) => paragraph(&text),
        Part::Heading(text) => format!("<h3>{}</h3>\n", escape(&text)),
        Part::List(items) => list(&items),
        Part::Values(rows) => definitions(&rows),
        Part::Table { columns, rows } => {
            let head: Vec<String> = columns.into_iter().map(str::to_owned).collect();
            table(&head, &rows)
        }
        Part::Compact { columns, rows } => {
            format!("<div class=\"compact\">{}</div>\n", table(&columns, &rows))
        }
        Part::Shares {
            corner,
            names,
            rows,
        } => shares(corner, &names, &rows),
        Part::Text { name, text } => folded_text(name, &text),
        Part::Data(numbers) => folded(directory, Some(numbers))?,
        Part::Figure(figure, numbers) => figures::drawn(&figure, &folded(directory, numbers)?)?,
        Part::Map(map) => figures::map(&map)?,
        Part::Picture {
            file,
            title,
            data: numbers,
        } => {
            let numbers = folded(directory, numbers)?;
            match directory.join(&file).is_file() {
                true => figures::of_file(directory, &file, title, &numbers)?,
                false => numbers,
            }
        }
        Part::Scenes(_) | Part::Program(_) | Part::Sortable { .. } => String::new(),
    })
}

fn folded(directory: &Path, numbers: Option<Data>) -> Result<String> {
    match numbers {
        None => Ok(String::new()),
        Some(Data::File(file)) => data::of_file(directory, &file),
        Some(Data::Table { name, csv }) => data::data(&name, &csv),
    }
}
