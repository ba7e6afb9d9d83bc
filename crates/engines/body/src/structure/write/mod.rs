//! Back to atoms: placed bodies as PDB and mmCIF text.
//!
//! A body keeps the atoms it was made from, in its own frame. Here they are moved by the pose of
//! each copy and written with their names, residues, numbers and insertion codes. Chains get new
//! identifiers, because two copies of a body would otherwise have the same; a table in the file
//! says which copy and which chain each was, and how the atoms of its source were moved.
//!
//! The rules, the same in both formats:
//!
//! * Amino acids and nucleotides are `ATOM`, everything else (modified residues, caps, ligands,
//!   ions, waters) is `HETATM`.
//! * Within a chain the polymer comes first; a `TER` follows it.
//! * The occupancy is 1.00. The B factor holds a number per residue, given by the caller; zero if
//!   there is none.
//! * A mutated residue has its new name on the atoms of the source: a body has no new side chains.
//! * Only atoms of residues are written. Bare points (a mesh with charges, an XYZR file) are no
//!   atoms, and a viewer would draw them as if they were: a body of nothing else is refused.
//!
//! | module | one idea |
//! |---|---|
//! | `chains` | chains of bodies, and new identifiers for their copies |
//! | `symbol` | the element of an atom from its name, residue and radius |
//! | `pdb` | fixed columns |
//! | `mmcif` | categories of mmCIF |

mod chains;
mod mmcif;
mod pdb;
mod symbol;

use crate::body::Body;
use crate::{BodyError, Result};
use chains::Layout;
use protomer_kernel::Pose;

pub use chains::WrittenChain;

/// Bodies at their poses, to be written as atoms.
///
/// ```
/// use protomer_body::structure::Structure;
/// use protomer_body::structure::write::{PlacedBodies, PlacedBody};
/// use protomer_body::{BodySettings, Source, build_body};
/// use protomer_kernel::{Pose, Vec3};
/// let text = "\
/// ATOM      1  N   LYS A   1      11.104   6.134  -6.504  1.00 10.00           N
/// ATOM      2  CA  LYS A   1      11.639   6.071  -5.147  1.00 10.00           C";
/// let source = Source { file: "lysine.pdb", sha256: "" };
/// let body = build_body("lysine", source, text.as_bytes(), &BodySettings::default())?.body;
/// let far = Pose { position: Vec3::new(20.0, 0.0, 0.0), ..Pose::identity() };
/// let pair = PlacedBodies {
///     title: "two lysines".into(),
///     copies: vec![PlacedBody::new(&body, Pose::identity()), PlacedBody::new(&body, far)],
///     box_angstrom: None,
/// };
/// let written = Structure::read("pair.pdb", pair.to_pdb()?.as_bytes())?;
/// let chains: Vec<&str> = written.models[0].atoms.iter().map(|atom| &*atom.chain).collect();
/// assert_eq!(chains, ["A", "A", "B", "B"]);
/// assert_eq!(pair.to_mmcif()?.lines().next(), Some("data_protomer"));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone)]
pub struct PlacedBodies<'a> {
    /// Title of the file.
    pub title: String,
    /// The copies.
    pub copies: Vec<PlacedBody<'a>>,
    /// Edge lengths of a periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
}

/// A copy of a body.
#[derive(Debug, Clone)]
pub struct PlacedBody<'a> {
    /// The body.
    pub body: &'a Body,
    /// Pose of the copy.
    pub pose: Pose,
    /// A number for each residue, written as the B factor of its atoms; empty for zero.
    pub residue_values: Vec<f64>,
}

impl<'a> PlacedBody<'a> {
    /// A copy whose residues have no values.
    pub fn new(body: &'a Body, pose: Pose) -> Self {
        Self {
            body,
            pose,
            residue_values: Vec::new(),
        }
    }

    /// The value of a residue; zero where there are none.
    fn value(&self, residue: usize) -> f64 {
        self.residue_values.get(residue).copied().unwrap_or(0.0)
    }

    /// The motion of the atoms of its source file: a point r was moved to `rotation * r + position`.
    fn motion_of_source(&self) -> Pose {
        let to_body = Pose {
            position: -self.body.provenance.origin_angstrom,
            ..Pose::identity()
        };
        to_body.then(&self.pose)
    }
}

impl PlacedBodies<'_> {
    /// The text of a PDB file.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a body without atoms, for values that are not one finite number
    /// per residue, and for what does not fit the columns of the format: more than 62 chains or
    /// 99 999 records, long names, large numbers.
    pub fn to_pdb(&self) -> Result<String> {
        self.check()?;
        pdb::text(self, &Layout::for_pdb(&self.copies)?)
    }

    /// The text of an mmCIF file.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a body without atoms, and for values that are not one finite
    /// number per residue.
    pub fn to_mmcif(&self) -> Result<String> {
        self.check()?;
        Ok(mmcif::text(self, &Layout::for_mmcif(&self.copies)))
    }

    /// The chains of the PDB file, in its order.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] if there are more than the format has identifiers for.
    pub fn chains_of_pdb(&self) -> Result<Vec<WrittenChain>> {
        Ok(Layout::for_pdb(&self.copies)?.table())
    }

    /// The chains of the mmCIF file, in its order.
    pub fn chains_of_mmcif(&self) -> Vec<WrittenChain> {
        Layout::for_mmcif(&self.copies).table()
    }

    /// The number of atoms that are written.
    pub fn atoms(&self) -> usize {
        let copies = self.copies.iter();
        copies.map(|copy| chains::atoms_of(copy.body)).sum()
    }

    fn check(&self) -> Result<()> {
        for copy in &self.copies {
            require_atoms(copy.body)?;
            check_values(copy)?;
        }
        Ok(())
    }
}

/// Whether a body has atoms of residues; one of a bare mesh and charges has none.
pub fn has_atoms(body: &Body) -> bool {
    chains::atoms_of(body) > 0
}

fn require_atoms(body: &Body) -> Result<()> {
    if has_atoms(body) {
        return Ok(());
    }
    Err(BodyError::Invalid {
        cause: format!(
            "body '{}' has no atoms: it was made of a mesh or of bare points",
            body.name
        ),
        remedy: "make it from a PDB, mmCIF or PQR file with 'protomer ingest'".into(),
    })
}

fn check_values(copy: &PlacedBody) -> Result<()> {
    let (count, wanted) = (copy.residue_values.len(), copy.body.residues.len());
    if count != 0 && count != wanted {
        return Err(BodyError::Invalid {
            cause: format!(
                "body '{}' has {wanted} residues, but {count} values are given",
                copy.body.name
            ),
            remedy: "give one for each residue, or none".into(),
        });
    }
    for (value, residue) in copy.residue_values.iter().zip(&copy.body.residues) {
        if !value.is_finite() {
            return Err(BodyError::Invalid {
                cause: format!(
                    "the value of residue {}:{}{} of body '{}' is {value}",
                    residue.chain, residue.number, residue.insertion_code, copy.body.name
                ),
                remedy: "give a finite number, such as zero".into(),
            });
        }
    }
    Ok(())
}

/// Text that a file of either format can hold on one line: visible ASCII and single blanks.
fn plain(text: &str) -> String {
    let words = text.split_whitespace().map(|word| {
        let letters = word.chars();
        letters
            .map(|letter| {
                if letter.is_ascii_graphic() {
                    letter
                } else {
                    '?'
                }
            })
            .collect::<String>()
    });
    words.collect::<Vec<_>>().join(" ")
}

/// A number rounded to some decimals, never "-0".
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    match is_zero {
        true => text.trim_start_matches('-').to_owned(),
        false => text,
    }
}
