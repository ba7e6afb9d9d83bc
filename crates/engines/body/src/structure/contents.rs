//! The content of a structure file, the same for both formats.

use super::biological_assembly::BiologicalAssembly;
use super::corrections::Corrections;
use super::ending::Ending;
use super::messages::Warnings;
use super::residue_key::ResidueKey;
use protomer_kernel::Vec3;
use std::sync::Arc;

/// The content of a PDB or mmCIF file; [`Structure::read`] makes it.
///
/// ```
/// use protomer_body::structure::Structure;
/// let text = "\
/// TITLE     ONE ATOM
/// ATOM      1  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C
/// END
/// ";
/// let structure = Structure::read("one.pdb", text.as_bytes())?;
/// assert_eq!(structure.header.title, "ONE ATOM");
/// assert_eq!(structure.models[0].atoms[0].residue_number, 7);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
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
    /// Disulfide bonds the file records.
    pub disulfides: Vec<RecordedDisulfide>,
    /// Warnings about records that the reader ignored or doubts, each with its line.
    pub warnings: Warnings,
    /// Corrections, by kind: data that the reader took otherwise than the file says.
    pub corrections: Corrections,
    /// Whether the file is complete; a file that was cut off also has a warning.
    pub ending: Ending,
}

/// General information from the head of the file.
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
    /// The crystal's unit cell; `None` without a crystal, which files show by a 1 x 1 x 1 Å cell.
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
    /// The unit cell of a crystal. `None` for the 1 x 1 x 1 Å cell by which files without a crystal
    /// fill a mandatory record, and for values that no cell has.
    pub(crate) fn of_crystal(lengths_angstrom: [f64; 3], angles_degree: [f64; 3]) -> Option<Self> {
        for length in lengths_angstrom {
            if !(length.is_finite() && length > 2.0) {
                return None;
            }
        }
        for angle in angles_degree {
            if !(angle > 0.0 && angle < 180.0) {
                return None;
            }
        }
        Some(Self {
            lengths_angstrom,
            angles_degree,
        })
    }
}

/// A residue that the experiment did not resolve.
#[derive(Debug, Clone, PartialEq)]
pub struct UnobservedResidue {
    /// Chain, residue number, insertion code.
    pub key: ResidueKey,
    /// Residue name.
    pub name: Arc<str>,
}

/// A disulfide bond that the file records: SSBOND, or `_struct_conn` of type `disulf`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedDisulfide {
    /// The two cysteines.
    pub residues: [ResidueKey; 2],
    /// The symmetry operator of each in the notation of the file, such as `1555`; empty where the
    /// file states none.
    pub symmetry: [Arc<str>; 2],
}

impl RecordedDisulfide {
    /// Whether one of the cysteines belongs to a symmetry copy of the deposited coordinates.
    ///
    /// ```
    /// use protomer_body::structure::{RecordedDisulfide, ResidueKey};
    /// let cysteine = |number| ResidueKey { chain: "A".into(), number, insertion_code: "".into() };
    /// let bond = |symmetry: [&str; 2]| RecordedDisulfide {
    ///     residues: [cysteine(5), cysteine(9)],
    ///     symmetry: symmetry.map(Into::into),
    /// };
    /// assert!(bond(["1555", "2655"]).is_between_symmetry_copies());
    /// assert!(!bond(["1555", "1555"]).is_between_symmetry_copies());
    /// ```
    pub fn is_between_symmetry_copies(&self) -> bool {
        let [first, second] = &self.symmetry;
        !first.is_empty() && !second.is_empty() && first != second
    }
}

/// One model of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// Number of the model in the file.
    pub number: i32,
    /// Atoms in file order, with all alternate locations.
    pub atoms: Vec<Atom>,
}

/// One atom record.
///
/// ```
/// use protomer_body::structure::Structure;
/// let text = "HETATM    1 ZN    ZN A 101      11.639   6.071  -5.147  0.50 10.00          ZN2+";
/// let structure = Structure::read("zinc.pdb", text.as_bytes())?;
/// let zinc = &structure.models[0].atoms[0];
/// assert_eq!((&*zinc.element, zinc.formal_charge_e, zinc.occupancy), ("ZN", Some(2), 0.5));
/// assert!(zinc.hetero && !zinc.is_hydrogen());
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Atom {
    /// Serial number; one more than the previous where it cannot be read.
    pub serial: i64,
    /// Atom name, trimmed.
    pub name: Arc<str>,
    /// Alternate location letter.
    pub alternate: Option<char>,
    /// Residue name.
    pub residue_name: Arc<str>,
    /// Chain identifier (author's).
    pub chain: Arc<str>,
    /// Chain identifier of the archive (`label_asym_id`); the author's where there is none.
    pub label_chain: Arc<str>,
    /// Segment identifier of PDB files (columns 73-76), by which CHARMM and X-PLOR name chains;
    /// empty for none.
    pub segment: Arc<str>,
    /// Number of TER records that have ended a polymer of this chain before the atom.
    pub polymer: u32,
    /// Residue number (author's); zero where the file has none.
    pub residue_number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: Arc<str>,
    /// Element symbol in upper case; `D` for deuterium, `X` if unknown.
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
    /// Whether the file shows the atom to be outside any polymer: after the chain's TER, or
    /// without a sequence number.
    pub outside_polymer: bool,
}

impl Atom {
    /// Whether the atom is hydrogen or deuterium.
    pub fn is_hydrogen(&self) -> bool {
        matches!(&*self.element, "H" | "D")
    }
}
