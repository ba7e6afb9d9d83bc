//! From the bytes of a file to a [`Structure`].

use super::contents::Structure;
use super::format::{Format, as_text};
use super::messages::parse_error;
use super::{mmcif, pdb};
use crate::Result;

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
    /// [`BodyError::Parse`](crate::BodyError::Parse) with line, cause and remedy for anything that
    /// is not a readable structure.
    pub fn read(source: &str, bytes: &[u8]) -> Result<Self> {
        let text = as_text(source, bytes)?;
        let structure = match Format::detect(source, &text)? {
            Format::Pdb => pdb::read(source, &text)?,
            Format::Mmcif => mmcif::read(source, &text)?,
            Format::Pqr => {
                let cause = "a PQR file where PDB or mmCIF was expected";
                let remedy = "read it as PQR, which brings its own charges and radii";
                return Err(parse_error(source, 0, cause, remedy));
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
