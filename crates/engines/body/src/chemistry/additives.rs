//! Molecules that come from the crystallisation, the cryoprotectant or the buffer and do not belong to
//! the protein, by their names in the Chemical Component Dictionary of the wwPDB.

/// Alcohols and ethers, acids and salts, amines and buffers, thiols, and atoms of unknown kind.
const ADDITIVES: &[&str] = &[
    "1PE", "2PE", "7PE", "ACN", "BU1", "BU3", "CCN", "DIO", "DMF", "DMS", "EDO", "EOH", "GOL",
    "IPA", "MOH", "MPD", "MRD", "P33", "P6G", "PE4", "PE8", "PEG", "PG0", "PG4", "PGE", "PGO",
    "XPE", "ACT", "ACY", "AZI", "BCT", "CIT", "CO3", "FLC", "FMT", "MLA", "MLI", "NO3", "PO4",
    "SCN", "SO4", "TAR", "TLA", "BTB", "CXS", "EPE", "IMD", "MES", "NH4", "NHE", "TRS", "BME",
    "DTT", "DTV", "UNL", "UNX",
];

/// Whether a residue of this name is an additive of the crystallisation.
pub(crate) fn is_crystallisation_additive(name: &str) -> bool {
    ADDITIVES.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glycerol_is_an_additive_and_haem_is_not() {
        assert!(is_crystallisation_additive("GOL"));
        assert!(!is_crystallisation_additive("HEM"));
    }
}
