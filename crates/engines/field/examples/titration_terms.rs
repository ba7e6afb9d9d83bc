//! Terms of the pKa shifts of structures, unscaled, for a fit of the titration model.
//!
//! ```text
//! cargo run --release -p protomer-field --example titration_terms -- STRUCTURE... > terms.jsonl
//! ```
//!
//! One line of JSON for each structure, at 100 mM and 298.15 K: groups, desolvation, background, tautomers
//! and pairs in kT.

#![allow(clippy::print_stdout)]

use protomer_body::chemistry::titration::titratable_sites;
use protomer_body::structure::{SelectionSettings, Structure};
use protomer_field::DielectricModel;
use protomer_field::titration::{TitrationModel, group_energies, solve_settings};
use protomer_io::gzip::read_maybe_gzip;
use protomer_kernel::Electrolyte;
use serde_json::json;
use std::error::Error;
use std::path::Path;

/// Bytes that a structure may have.
const LIMIT_BYTES: u64 = 1 << 30;

fn main() -> Result<(), Box<dyn Error>> {
    let dielectric = DielectricModel {
        inner_permittivity: TitrationModel::default().inner_permittivity,
        ..DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?)
    };
    for file in std::env::args().skip(1) {
        let bytes = read_maybe_gzip(Path::new(&file), LIMIT_BYTES)?;
        let structure = Structure::read(file.trim_end_matches(".gz"), &bytes[..])?;
        let selection = structure.select(&SelectionSettings::default())?;
        let sites = titratable_sites(&selection);
        let energies = group_energies(&sites, &dielectric, &solve_settings(), &|| true)?;
        let mut groups = Vec::new();
        for group in &sites.groups {
            let residue = &selection.residues[group.residue];
            groups.push(json!({
                "chain": residue.key.chain.to_string(),
                "number": residue.key.number,
                "name": residue.name.to_string(),
                "kind": format!("{:?}", group.kind),
                "model": group.model_pka,
                "charge": group.charge_e,
            }));
        }
        let terms = json!({
            "file": file,
            "groups": groups,
            "desolvation": energies.desolvation_kt,
            "background": energies.background_kt,
            "tautomer": energies.tautomer_kt,
            "pair": energies.pair_kt,
            "tautomer_pair": energies.tautomer_pair_kt,
        });
        println!("{terms}");
    }
    Ok(())
}
