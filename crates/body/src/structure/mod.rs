//! Structure files: PDB and mmCIF text to one [`Structure`], and the selection of what becomes a
//! body.
//!
//! The readers are our own. pdbtbx 0.12, the natural choice in Rust, was measured on 120 PDB and
//! mmCIF files: at its loosest level it read 90, refused 27 (free-text remarks, coordinate lines
//! shorter than 80 columns, odd charges) and panicked on three; where blank and labelled alternate
//! locations stand side by side its atom iterator yields the blank ones once per conformer (5PTI:
//! 1119 atoms for 1104 records), which would count charges twice; and it reads no biological
//! assemblies from either format. It serves as an independent witness in the tests.
//!
//! | module | one idea |
//! |---|---|
//! | [`mod@format`] | which format a file is in |
//! | `columns` | fixed-column fields: numbers, hybrid-36, the error that names line and column |
//! | `pdb` | PDB coordinate records |
//! | `pdb_header` | PDB title records and remarks |
//! | `cif_syntax` | the grammar of CIF: tokens, loops, rows |
//! | `mmcif` | mmCIF categories |
//! | [`biological_assembly`] | assemblies, their operators, and operator expressions |
//! | `assembled` | selected residues copied by an assembly's operators |
//! | [`mod@ending`] | whether a file is whole |
//! | `element` | elements, and guessing them from atom names |
//! | `residues` | atoms grouped to residues, and what kind of residue each is |
//! | `alternates` | one conformer per residue |
//! | `completeness` | missing atoms, chain breaks, real chain ends |
//! | [`selection`] | what becomes a body, and the count of what does not |

mod alternates;
mod assembled;
pub mod biological_assembly;
mod cif_syntax;
mod columns;
mod completeness;
mod element;
pub mod ending;
pub mod format;
mod mmcif;
mod pdb;
mod pdb_header;
mod residues;
pub mod selection;

pub use biological_assembly::{BiologicalAssembly, Operator};
pub(crate) use completeness::mark_disulfides;
pub use completeness::{ChainBreak, IncompleteResidue};
pub use ending::Ending;
pub use format::Format;
pub use residues::{ResidueClass, ResidueKey};
pub use selection::{MissingAtoms, SelectedResidue, Selection, SelectionReport, SelectionSettings};

use crate::{BodyError, Result};
use protomer_kernel::Vec3;
use std::collections::HashSet;
use std::sync::Arc;

/// Everything this project needs to know from a structure file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Structure {
    /// The file as the user named it.
    pub source: String,
    /// Title, method, cell and the like.
    pub header: Header,
    /// At least one model, each with at least one atom.
    pub models: Vec<Model>,
    /// Biological assemblies the file describes.
    pub assemblies: Vec<BiologicalAssembly>,
    /// What the reader put right or passed over, each with its line.
    pub warnings: Warnings,
    /// Whether the file is whole; a file that was cut off is warned of as well.
    pub ending: Ending,
}

/// What the head of the file says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Header {
    /// Entry identifier; empty if the file has none.
    pub entry: String,
    /// Title; empty if the file has none.
    pub title: String,
    /// Experimental method in the words of the file; empty if it has none.
    pub method: String,
    /// Resolution, Å.
    pub resolution_angstrom: Option<f64>,
    /// The crystal's unit cell; `None` without a crystal (the conventional 1 x 1 x 1 Å cell is not
    /// one).
    pub cell: Option<UnitCell>,
    /// Hermann-Mauguin symbol of the space group, where there is a crystal.
    pub space_group: Option<String>,
    /// Residues of the sequence that have no coordinates, as the file lists them.
    pub unobserved: Vec<UnobservedResidue>,
}

/// Edge lengths and angles of a unit cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitCell {
    /// Edge lengths a, b, c, Å.
    pub lengths_angstrom: [f64; 3],
    /// Angles α, β, γ, degrees.
    pub angles_degree: [f64; 3],
}

impl UnitCell {
    /// `None` for the 1 x 1 x 1 Å cell by which files without a crystal fill a mandatory record,
    /// and for nonsense.
    pub(crate) fn of_crystal(lengths_angstrom: [f64; 3], angles_degree: [f64; 3]) -> Option<Self> {
        let is_cell = lengths_angstrom
            .iter()
            .all(|length| length.is_finite() && *length > 2.0)
            && angles_degree
                .iter()
                .all(|angle| angle.is_finite() && *angle > 0.0 && *angle < 180.0);
        is_cell.then_some(Self {
            lengths_angstrom,
            angles_degree,
        })
    }
}

/// A residue the experiment did not see.
#[derive(Debug, Clone, PartialEq)]
pub struct UnobservedResidue {
    /// Chain, residue number, insertion code.
    pub key: ResidueKey,
    /// Residue name.
    pub name: Arc<str>,
}

/// One model of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// Number of the model in the file.
    pub number: i32,
    /// Atoms in file order, alternate locations and all.
    pub atoms: Vec<Atom>,
}

/// One atom record.
#[derive(Debug, Clone, PartialEq)]
pub struct Atom {
    /// Serial number; the previous one plus one where the file's is unreadable.
    pub serial: i64,
    /// Atom name, trimmed.
    pub name: Arc<str>,
    /// Alternate location letter.
    pub alternate: Option<char>,
    /// Residue name.
    pub residue_name: Arc<str>,
    /// Chain as the authors call it.
    pub chain: Arc<str>,
    /// Chain as the archive calls it (`label_asym_id`); the author's where there is none.
    pub label_chain: Arc<str>,
    /// Residue number (author's).
    pub residue_number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: Arc<str>,
    /// Element symbol in upper case; `D` for deuterium, `X` where it cannot be known.
    pub element: Arc<str>,
    /// Occupancy; 1 where the file has none.
    pub occupancy: f64,
    /// Isotropic displacement parameter B, Å².
    pub b_factor_angstrom2: f64,
    /// Formal charge, e, where the file states one.
    pub formal_charge_e: Option<i32>,
    /// Position, Å.
    pub position: Vec3,
    /// Whether the record is a HETATM.
    pub hetero: bool,
    /// Whether the file shows the atom to stand outside of any polymer (after the chain's TER; no
    /// sequence number).
    pub outside_polymer: bool,
}

impl Atom {
    /// Hydrogen or deuterium.
    pub fn is_hydrogen(&self) -> bool {
        matches!(&*self.element, "H" | "D")
    }
}

impl Structure {
    /// Reads PDB or mmCIF text; the format follows from the content ([`Format::detect`]). `source`
    /// names the file in errors.
    ///
    /// ```
    /// use protomer_body::structure::Structure;
    /// let line = "ATOM      1  CA  GLY A   7      11.104   6.134  -6.504  1.00 10.00           C";
    /// let structure = Structure::read("one.pdb", line.as_bytes())?;
    /// assert_eq!(structure.models[0].atoms[0].residue_number, 7);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// [`BodyError::Parse`] with line, cause and remedy for anything that is not a readable
    /// structure.
    pub fn read(source: &str, bytes: &[u8]) -> Result<Self> {
        let text = format::as_text(source, bytes)?;
        let structure = match Format::detect(source, &text)? {
            Format::Pdb => pdb::read(source, &text)?,
            Format::Mmcif => mmcif::read(source, &text)?,
            Format::Pqr => {
                let remedy = "read it as PQR, which brings its own charges and radii";
                return Err(parse_error(
                    source,
                    0,
                    "a PQR file where PDB or mmCIF was expected",
                    remedy,
                ));
            }
        };
        if structure.models.iter().all(|model| model.atoms.is_empty()) {
            let remedy =
                "give a PDB or mmCIF file with coordinates; the download may have been cut short";
            return Err(parse_error(source, 0, "no atoms", remedy));
        }
        Ok(structure)
    }
}

pub(crate) fn parse_error(
    source: &str,
    line: usize,
    cause: impl Into<String>,
    remedy: impl Into<String>,
) -> BodyError {
    BodyError::Parse {
        file: source.to_string(),
        line,
        cause: cause.into(),
        remedy: remedy.into(),
    }
}

/// Text quoted in a message, shortened and without control characters.
pub(crate) fn quoted(text: &str) -> String {
    const LONGEST: usize = 40;
    let clean: String = text
        .chars()
        .map(|c| if c.is_control() { '·' } else { c })
        .take(LONGEST + 1)
        .collect();
    if clean.chars().count() > LONGEST {
        format!("`{}...`", clean.chars().take(LONGEST).collect::<String>())
    } else {
        format!("`{clean}`")
    }
}

/// Warnings of a reader: the first few in full, and how many there were.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Warnings {
    /// The first warnings, each beginning with its line.
    pub messages: Vec<String>,
    /// How many there were in all.
    pub count: usize,
}

impl Warnings {
    /// Warnings kept in full.
    const KEPT: usize = 50;

    pub(crate) fn add(&mut self, line: usize, message: &str) {
        self.count += 1;
        if self.messages.len() < Self::KEPT {
            self.messages.push(format!("line {line}: {message}"));
        }
    }
}

/// Shares equal strings: a structure has few different names and many atoms.
#[derive(Debug, Default)]
pub(crate) struct Names {
    seen: HashSet<Arc<str>>,
}

impl Names {
    pub(crate) fn share(&mut self, text: &str) -> Arc<str> {
        if let Some(name) = self.seen.get(text) {
            return name.clone();
        }
        let name: Arc<str> = Arc::from(text);
        self.seen.insert(name.clone());
        name
    }
}
