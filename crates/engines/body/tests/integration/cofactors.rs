//! Charged groups of cofactors against the atoms of deposited entries.

use crate::common::read;
use crate::test_data;

use protomer_body::Site;
use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::SelectionSettings;

/// Longest bond between two heavy atoms of a phosphate or a carboxylate, Å.
const LONGEST_BOND_ANGSTROM: f64 = 1.9;

/// Entries with their cofactors, and the charge of these near pH 7. None of the files states formal charges of its own.
const ENTRIES: &[(&str, &str, f64)] = &[
    ("1d1t.cif.gz", "NAD", -1.0),
    ("1rx1.pdb.gz", "NAP", -3.0),
    ("4kya.pdb.gz", "NDP", -4.0),
    ("1kf6.pdb.gz", "FAD", -2.0),
    ("5h73.pdb.gz", "FMN", -2.0),
    ("1xdn.pdb.gz", "ATP", -4.0),
    ("1osn.pdb.gz", "ADP", -3.0),
    ("6ep0.cif.gz", "AMP", -2.0),
    ("5vq2.pdb.gz", "GTP", -4.0),
    ("1ir3.pdb.gz", "ANP", -4.0),
    ("3he3.cif.gz", "UDP", -3.0),
    ("2wsy.pdb.gz", "PLP", -2.0),
    ("6a5k.cif.gz", "SAM", 1.0),
    ("2efj.pdb.gz", "SAH", 0.0),
    ("3pqr.pdb.gz", "ACT", -1.0),
    ("2pvb.pdb.gz", "FMT", -1.0),
];

/// Heavy atoms bonded to one of the sites, by their elements.
fn bonded<'a>(site: &Site, residue: &[&'a Site]) -> Vec<&'a Site> {
    let is_bonded = |other: &&&Site| {
        let distance = (other.position - site.position).norm();
        !other.is_hydrogen() && distance > 0.1 && distance < LONGEST_BOND_ANGSTROM
    };
    residue.iter().filter(is_bonded).copied().collect()
}

/// Negative charges are on oxygens with one bond, to the phosphorus or carbon of their group, and every oxygen that only a
/// phosphorus holds has one; positive ones are on nitrogen or sulfur. The sum is the charge near pH 7.
#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/spacegroups"]
fn groups_of_cofactors_are_where_deposited_atoms_are() {
    let folder = test_data::test_data("data/spacegroups");
    for (file, name, charge_e) in ENTRIES {
        let settings = SelectionSettings {
            keep_ligands: true,
            ..SelectionSettings::default()
        };
        let selection = read(&folder, file).select(&settings).unwrap();
        let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
        let mut met = 0;
        for (index, residue) in sites.residues.iter().enumerate() {
            if residue.name != *name {
                continue;
            }
            let is_part = |site: &&Site| site.residue == u32::try_from(index).ok();
            let atoms: Vec<&Site> = sites.sites.iter().filter(is_part).collect();
            let sum: f64 = atoms.iter().map(|site| site.charge_e).sum();
            assert!((sum - charge_e).abs() < 1e-9, "{file} {name}: {sum} e");
            for site in &atoms {
                let bonds = bonded(site, &atoms);
                let label = format!("{file} {name} {} {:.2} e", site.atom_name, site.charge_e);
                let element = site.atom_name.chars().next();
                let is_terminal = bonds.len() == 1 && element == Some('O');
                if site.charge_e < -1e-9 {
                    assert!(is_terminal, "{label}: {} bonds", bonds.len());
                    assert!(bonds[0].atom_name.starts_with(['P', 'C']), "{label}");
                } else if site.charge_e > 1e-9 {
                    assert!(matches!(element, Some('N' | 'S')), "{label}");
                } else if is_terminal {
                    assert!(!bonds[0].atom_name.starts_with('P'), "{label}");
                }
            }
            met += 1;
        }
        assert!(met > 0, "{file} has no {name}");
        println!("{file}: {met} {name} with {charge_e} e");
    }
}
