//! The format of a structure file by its name.

use anyhow::{Result, bail};
use std::path::Path;

/// A format that structures are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StructureFormat {
    /// PDB with fixed columns: up to 62 chains and 99 999 atoms.
    Pdb,
    /// mmCIF with any number of chains and atoms.
    Mmcif,
}

impl StructureFormat {
    /// The format by the extension of a file name.
    ///
    /// # Errors
    /// For another extension.
    ///
    /// ```
    /// use protomer_protein_verbs::export::StructureFormat;
    /// use std::path::Path;
    /// assert_eq!(StructureFormat::of_path(Path::new("ring.cif"))?, StructureFormat::Mmcif);
    /// assert!(StructureFormat::of_path(Path::new("ring.xyz")).is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn of_path(path: &Path) -> Result<Self> {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        match ending.to_ascii_lowercase().as_str() {
            "pdb" | "ent" => Ok(Self::Pdb),
            "cif" | "mmcif" => Ok(Self::Mmcif),
            _ => bail!(
                "{} ends in none of .pdb, .cif and .gsd; choose one of them",
                path.display()
            ),
        }
    }
}
