//! From the bytes of a file to a [`Structure`].

use super::contents::Structure;
use super::ending::Ending;
use super::format::{Format, as_text};
use super::messages::{parse_error, quoted};
use super::{mmcif, pdb};
use crate::{BodyError, Result};
use protomer_kernel::name::first_forbidden;
use protomer_kernel::plain_text::line_end_warning;

impl Structure {
    /// Reads PDB or mmCIF text; the format follows from the content, whatever its name. `source`
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
    /// [`BodyError::Parse`](crate::BodyError::Parse) with line, cause and remedy for anything that
    /// is not a readable structure.
    pub fn read(source: &str, bytes: &[u8]) -> Result<Self> {
        let text = as_text(source, bytes)?;
        let format = Format::detect(source, &text)?;
        let mut structure = match format {
            Format::Pdb => pdb::read(source, &text)?,
            Format::Mmcif => mmcif::read(source, &text)?,
            Format::Pqr => {
                let cause = "this is PQR, and PDB or mmCIF was expected";
                let remedy = "give PDB or mmCIF; 'protomer ingest' makes a body of PQR, which has \
                              charges and radii of its own";
                return Err(parse_error(source, 0, cause, remedy));
            }
        };
        if structure.models.iter().all(|model| model.atoms.is_empty()) {
            return Err(no_atoms(&structure, &text));
        }
        if let Some(warning) = format.contradiction(source) {
            structure.warnings.add(1, &warning);
        }
        if let Some(warning) = line_end_warning(bytes) {
            structure.warnings.add(1, &warning);
        }
        refuse_names(source, &structure)?;
        Ok(structure)
    }
}

/// The error for a file without atoms: whether it was cut off, or holds something else.
fn no_atoms(structure: &Structure, text: &str) -> BodyError {
    let cause = format!("no atoms in {} lines of text", text.lines().count());
    let remedy = match structure.ending {
        Ending::CutOff(_) => "the file was cut off before its coordinates; fetch it again",
        _ => "give a PDB file with ATOM records, or an mmCIF file with _atom_site",
    };
    parse_error(&structure.source, 0, cause, remedy)
}

/// Refuses names that could become something else where they are written ([`protomer_kernel::name`]).
fn refuse_names(source: &str, structure: &Structure) -> Result<()> {
    for atom in structure.models.iter().flat_map(|model| &model.atoms) {
        let names = [
            ("atom", &atom.name),
            ("residue", &atom.residue_name),
            ("chain", &atom.chain),
            ("chain", &atom.label_chain),
            ("insertion code", &atom.insertion_code),
            ("element", &atom.element),
        ];
        for (kind, name) in names {
            if let Some(character) = first_forbidden(name) {
                let cause = format!(
                    "atom {}: the {kind} {} holds the character U+{:04X}",
                    atom.serial,
                    quoted(name),
                    u32::from(character)
                );
                let remedy = "write names of visible characters";
                return Err(parse_error(source, 0, cause, remedy));
            }
        }
    }
    Ok(())
}
