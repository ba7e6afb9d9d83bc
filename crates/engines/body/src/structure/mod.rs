//! Structure files: reads PDB and mmCIF text into a [`Structure`], selects the part that becomes
//! a body, and writes the atoms of placed bodies.
//!
//! The readers are our own. pdbtbx 0.12, the natural choice in Rust, was measured on 120 PDB and
//! mmCIF files: at its loosest level it read 90, refused 27 (free-text remarks, coordinate lines
//! shorter than 80 columns, odd charges) and panicked on three. Where a residue has both
//! blank and labelled alternate locations, its atom iterator yields the blank ones once per
//! conformer (5PTI: 1119 atoms for 1104 records), which would count charges twice. It does not read
//! biological assemblies. The tests use it as an independent reference.
//!
//! ```
//! use protomer_body::structure::{SelectionSettings, Structure};
//! let text = "\
//! ATOM      1  N   GLY A   7      11.104   6.134  -6.504  1.00 10.00           N
//! ATOM      2  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C
//! HETATM    3  O   HOH A 101      18.000   6.000  -5.000  1.00 20.00           O";
//! let structure = Structure::read("glycine.pdb", text.as_bytes())?;
//! let selection = structure.select(&SelectionSettings::default())?;
//! assert_eq!(selection.residues[0].key.to_string(), "A:7");
//! assert_eq!(selection.report.skipped["water"], 1);
//! # Ok::<(), protomer_body::BodyError>(())
//! ```
//!
//! A file becomes residues in five steps, each of which counts what it leaves out or takes otherwise
//! than the file says:
//!
//! 1. *text*: bytes in any encoding and with any line ends (`protomer_kernel::plain_text`), and the
//!    format that the content shows;
//! 2. *records*: what the lines or rows state, with the file's own names and numbers;
//! 3. *atoms*: the records that are atoms, and not pseudoatoms, placeholders or repetitions;
//! 4. *residues*: which atoms belong together, which residues are bonded to chains, and where one
//!    chain ends and the next begins;
//! 5. *selection*: one conformer, the class of each residue, what is kept.
//!
//! | module | step | one idea |
//! |---|---|---|
//! | [`mod@format`] | 1 | the format of a file, by its content |
//! | `read` | 1 | from the bytes of a file to its content |
//! | [`mod@ending`] | 1 | whether a file is complete |
//! | `contents` | 2 | the content of a structure file, the same for both formats |
//! | `columns` | 2 | fixed-column fields: numbers, hybrid-36, shifts, errors with line and column |
//! | `pdb` | 2 | PDB coordinate records |
//! | `pdb_names` | 2 | names of residues and chains in the columns of PDB |
//! | `pdb_header` | 2 | PDB title records and remarks |
//! | `cif_syntax` | 2 | the grammar of CIF: tokens, loops, rows |
//! | `mmcif` | 2 | mmCIF categories |
//! | `atom_site` | 2 | the rows of mmCIF's `_atom_site` |
//! | [`biological_assembly`] | 2 | assemblies, their operators, and operator expressions |
//! | `element` | 2 | elements: what is stated, and what follows from names |
//! | `corrections` | 2 | what the reader takes otherwise than the file says |
//! | `records` | 3 | which records are atoms |
//! | `residue_key` | 4 | what identifies a residue |
//! | `residues` | 4 | atoms grouped into residues |
//! | `links` | 4 | bonds between residues, and their order in chains |
//! | `strands` | 4 | separate polymers, and names that tell them apart |
//! | `alternates` | 5 | one conformer per residue |
//! | [`classes`] | 5 | what kind of residue each is |
//! | [`selected`] | 5 | the selected residues |
//! | `scale` | 5 | coordinates in another unit than Å |
//! | [`report`] | 5 | what was selected, what was left out, and how residues were treated |
//! | `residue_range` | 5 | ranges of residues by chain and number |
//! | `completeness` | 5 | missing atoms and chain breaks |
//! | `confidence` | 5 | residues of low confidence in predicted models |
//! | `ends` | 5 | free amines and carboxylates at the ends of chains |
//! | `disulfides` | 5 | disulfide bonds, from records first and by distance second |
//! | `assembled` | 5 | selected residues copied by an assembly's operators |
//! | [`selection`] | 5 | the part of a structure that becomes a body |
//! | [`mod@write`] | | placed bodies as PDB and mmCIF text |
//! | `messages`, `names` | | messages of the readers; shared strings |

mod alternates;
mod assembled;
mod atom_site;
pub mod biological_assembly;
mod cif_syntax;
pub mod classes;
mod columns;
mod completeness;
pub(crate) mod confidence;
mod contents;
mod corrections;
mod disulfides;
mod element;
pub mod ending;
mod ends;
pub mod format;
mod links;
pub(crate) mod messages;
mod mmcif;
mod names;
mod pdb;
mod pdb_header;
mod pdb_names;
mod read;
pub(crate) mod records;
pub mod report;
mod residue_key;
mod residue_range;
pub(crate) mod residues;
pub(crate) mod scale;
pub mod selected;
pub mod selection;
mod strands;
pub mod write;

pub use biological_assembly::{BiologicalAssembly, Operator};
pub use classes::ResidueClass;
pub use confidence::LowConfidence;
pub use contents::{
    Atom, Header, Model, RecordedDisulfide, Structure, UnitCell, UnobservedResidue,
};
pub use corrections::{Correction, Corrections};
pub use ending::Ending;
pub use format::Format;
pub use messages::Warnings;
pub use report::{
    ChainBreak, Disulfide, DisulfideEvidence, IncompleteResidue, ListedResidue, SelectionReport,
    SkippedResidues,
};
pub use residue_key::ResidueKey;
pub use residue_range::ResidueRange;
pub(crate) use selected::atom_count;
pub use selected::{SelectedResidue, Selection};
pub use selection::{MissingAtoms, SelectionSettings};
