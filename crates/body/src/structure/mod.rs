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
//! | module | one idea |
//! |---|---|
//! | `contents` | the content of a structure file, the same for both formats |
//! | `read` | from the bytes of a file to its content |
//! | [`mod@format`] | the format of a file |
//! | `columns` | fixed-column fields: numbers, hybrid-36, errors with line and column |
//! | `pdb` | PDB coordinate records |
//! | `pdb_header` | PDB title records and remarks |
//! | `cif_syntax` | the grammar of CIF: tokens, loops, rows |
//! | `mmcif` | mmCIF categories |
//! | `atom_site` | the rows of mmCIF's `_atom_site` |
//! | [`biological_assembly`] | assemblies, their operators, and operator expressions |
//! | [`mod@ending`] | whether a file is complete |
//! | `element` | elements, and how to guess them from atom names |
//! | `residue_key` | what identifies a residue |
//! | `residues` | atoms grouped into residues, and which groups form a chain |
//! | [`classes`] | what kind of residue each is |
//! | `alternates` | one conformer per residue |
//! | [`selected`] | the selected residues |
//! | [`report`] | what was selected, what was left out, and how residues were treated |
//! | `completeness` | missing atoms and chain breaks |
//! | `ends` | free amines and carboxylates at the ends of chains |
//! | `disulfides` | disulfide bonds, from records first and by distance second |
//! | `assembled` | selected residues copied by an assembly's operators |
//! | [`selection`] | the part of a structure that becomes a body |
//! | [`mod@write`] | placed bodies as PDB and mmCIF text |
//! | `messages`, `names` | messages of the readers; shared strings |

mod alternates;
mod assembled;
mod atom_site;
pub mod biological_assembly;
mod cif_syntax;
pub mod classes;
mod columns;
mod completeness;
mod contents;
mod disulfides;
mod element;
pub mod ending;
mod ends;
pub mod format;
pub(crate) mod messages;
mod mmcif;
mod names;
mod pdb;
mod pdb_header;
mod read;
pub mod report;
mod residue_key;
mod residues;
pub mod selected;
pub mod selection;
pub mod write;

pub use biological_assembly::{BiologicalAssembly, Operator};
pub use classes::ResidueClass;
pub use contents::{
    Atom, Header, Model, RecordedDisulfide, Structure, UnitCell, UnobservedResidue,
};
pub use ending::Ending;
pub use format::Format;
pub use messages::Warnings;
pub use report::{
    ChainBreak, Disulfide, DisulfideEvidence, IncompleteResidue, ListedResidue, SelectionReport,
};
pub use residue_key::ResidueKey;
pub use selected::{SelectedResidue, Selection};
pub use selection::{MissingAtoms, SelectionSettings};
