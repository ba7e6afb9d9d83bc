//! What a page consists of. The crate of an answer says what belongs on its page; `report` arranges
//! and renders it, and knows no kind of results.
//!
//! ```text
//! directory --contents of its kind--> Contents: title, Verdict, Section, Section, ... --report--> HTML
//! Section: title, Part, Part, ...
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `number` | numbers as a reader sees them: few digits, with errors |
//! | [`scene`] | bodies in three dimensions |
//! | `verdict` | whether the results may be used as they are |

mod number;
pub mod scene;
mod verdict;

pub use number::{millimolar, significant, significant_or_dash, with_error, with_error_to};
pub use verdict::Verdict;

use anyhow::Error;
use protomer_plot::{ColourMap, Figure};
use scene::Shown;

/// Contents of the page of a directory.
///
/// ```
/// use protomer_common::page::{Contents, Part, Section};
/// let mut contents = Contents::new("Random walk");
/// contents.add(Section::new("Results", vec![Part::file("log.csv")]));
/// assert_eq!(contents.sections[0].title, "Results");
/// ```
#[derive(Debug, Clone)]
pub struct Contents {
    /// Title; the page adds the name of the directory.
    pub title: &'static str,
    /// A line below the title.
    pub subtitle: String,
    /// The verdict of the run on its results; `None` for a kind of results that has none.
    pub verdict: Option<Verdict>,
    /// Descriptions of what failed or is missing.
    pub problems: Vec<String>,
    /// Sections in order.
    pub sections: Vec<Section>,
    /// Origin of the results, the last section of the page.
    pub origin: Origin,
}

/// Origin of results, in addition to their record.
#[derive(Debug, Clone)]
pub struct Origin {
    /// The settings.
    pub settings: SettingsText,
    /// Further names and values.
    pub more: Vec<(&'static str, String)>,
    /// A sentence at the end; may be empty.
    pub note: &'static str,
    /// Whether the results are those of a run, which may be unfinished.
    pub is_run: bool,
}

/// Settings of results as text.
#[derive(Debug, Clone)]
pub enum SettingsText {
    /// A file of the directory, by its name.
    File(&'static str),
    /// The text itself, for results that hold their settings elsewhere.
    Text(String),
    /// No text: the command has no settings.
    None,
}

/// A part of a page under a heading.
///
/// ```
/// use protomer_common::page::{Part, Section};
/// let text = Part::Paragraph("The bodies keep their distance.".into());
/// let section = Section { title: "Results", parts: vec![text, Part::file("log.csv")] };
/// assert_eq!(section.parts.len(), 2);
/// ```
#[derive(Debug, Clone)]
pub struct Section {
    /// Heading.
    pub title: &'static str,
    /// Content from top to bottom.
    pub parts: Vec<Part>,
}

/// A piece of a section.
///
/// ```
/// use protomer_common::page::{Data, Part};
/// let Part::Data(Data::File(file)) = Part::file("log.csv") else { panic!() };
/// assert_eq!(file, "log.csv");
/// ```
#[derive(Debug, Clone)]
pub enum Part {
    /// Plain text.
    Paragraph(String),
    /// A heading inside of the section.
    Heading(String),
    /// Items of a list.
    List(Vec<String>),
    /// Names and values.
    Values(Vec<(&'static str, String)>),
    /// A table.
    Table {
        /// Headings of the columns.
        columns: Vec<&'static str>,
        /// Rows with a cell for each column.
        rows: Vec<Vec<String>>,
    },
    /// A wide table, in small letters.
    Compact {
        /// Headings of the columns.
        columns: Vec<String>,
        /// Rows with a cell for each column.
        rows: Vec<Vec<String>>,
    },
    /// A square table of numbers, each shaded by its share of its row.
    Shares {
        /// Meaning of rows and columns.
        corner: &'static str,
        /// Names of the rows, and of the columns.
        names: Vec<String>,
        /// Numbers by row.
        rows: Vec<Vec<f64>>,
    },
    /// A table that a click on a heading sorts.
    Sortable {
        /// Headings of the columns.
        columns: Vec<String>,
        /// Rows with a cell for each column.
        rows: Vec<Vec<String>>,
    },
    /// A table, folded, with a link that saves it.
    Data(Data),
    /// A figure, and what it is drawn from.
    Figure(Box<Figure>, Option<Data>),
    /// A table of numbers as colours.
    Map(Box<ColourMap>),
    /// A picture (SVG) of the directory; nothing if there is no such file.
    Picture {
        /// Path of the file from the directory.
        file: String,
        /// Text for readers who do not see the picture.
        title: &'static str,
        /// Numbers that the picture shows.
        data: Option<Data>,
    },
    /// Bodies to look at from all sides.
    Scenes(Shown),
    /// A program that runs in the page.
    Program(Program),
    /// Text of a file, folded.
    Text {
        /// Name of the file.
        name: &'static str,
        /// Text in full.
        text: String,
    },
}

/// Numbers behind a figure.
#[derive(Debug, Clone)]
pub enum Data {
    /// A table (CSV) of the directory, by its path from there; nothing if there is no such file.
    File(String),
    /// A table (CSV).
    Table {
        /// Name under which it is saved.
        name: String,
        /// Text of the table.
        csv: String,
    },
}

/// A program that runs in a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// Element that the script works on.
    pub html: String,
    /// Style of the element; identical styles appear once.
    pub style: String,
    /// Functions that the script calls; identical libraries appear once.
    pub library: &'static str,
    /// The script that runs at the end.
    pub script: String,
}

impl Contents {
    /// A page without sections, of results that are not finished.
    ///
    /// ```
    /// use protomer_common::page::Contents;
    /// let contents = Contents::new("Random walk");
    /// assert_eq!((contents.subtitle.as_str(), contents.sections.len()), ("Not finished", 0));
    /// ```
    pub fn new(title: &'static str) -> Self {
        Self {
            title,
            subtitle: "Not finished".into(),
            verdict: None,
            problems: Vec::new(),
            sections: Vec::new(),
            origin: Origin {
                settings: SettingsText::File("run.toml"),
                more: Vec::new(),
                note: "",
                is_run: true,
            },
        }
    }

    /// Adds a section.
    ///
    /// ```
    /// use protomer_common::page::{Contents, Section};
    /// let mut contents = Contents::new("Random walk");
    /// contents.add(Section::new("Results", Vec::new()));
    /// contents.add(Section::new("Errors", Vec::new()));
    /// assert_eq!(contents.sections[1].title, "Errors", "they keep their order");
    /// ```
    pub fn add(&mut self, section: Section) {
        self.sections.push(section);
    }

    /// Adds a section, or a problem that begins with `failure`, as in "*The bodies cannot be shown*:
    /// the trajectory holds no frame".
    ///
    /// ```
    /// use protomer_common::page::{Contents, Section};
    /// let mut page = Contents::new("Walk");
    /// page.add_if_readable(Ok(Section::new("Path", Vec::new())), "The path cannot be shown");
    /// page.add_if_readable(Err(anyhow::anyhow!("no frame")), "The bodies cannot be shown");
    /// assert_eq!(page.sections.len(), 1);
    /// assert_eq!(page.problems, ["The bodies cannot be shown: no frame"]);
    /// ```
    pub fn add_if_readable(&mut self, section: Result<Section, Error>, failure: &str) {
        match section {
            Ok(section) => self.add(section),
            Err(error) => self.problems.push(format!("{failure}: {error:#}")),
        }
    }
}

impl Part {
    /// A figure with the table (CSV) of the directory that it is drawn from.
    pub fn figure(figure: Figure, file: &str) -> Self {
        Self::Figure(Box::new(figure), Some(Data::File(file.into())))
    }

    /// A table (CSV) of the directory.
    pub fn file(file: &str) -> Self {
        Self::Data(Data::File(file.into()))
    }

    /// A picture of the directory, drawn from the table (CSV) `data`.
    ///
    /// ```
    /// use protomer_common::page::{Data, Part};
    /// let part = Part::picture("walk.svg", "Path of the walk", Some("walk.csv"));
    /// let Part::Picture { data: Some(Data::File(table)), .. } = part else { panic!() };
    /// assert_eq!(table, "walk.csv");
    /// ```
    pub fn picture(file: &str, title: &'static str, data: Option<&str>) -> Self {
        Self::Picture {
            file: file.into(),
            title,
            data: data.map(|file| Data::File(file.into())),
        }
    }
}

impl Section {
    /// A section with its parts.
    pub fn new(title: &'static str, parts: Vec<Part>) -> Self {
        Self { title, parts }
    }
}
