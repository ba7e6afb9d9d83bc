//! The larger set of real structures, which is not part of the repository.

use crate::common::{bytes, many_structures, read, select};
use protomer_body::assembly::body_types;
use protomer_body::chemistry::{SiteSettings, build_sites, residue_names};
use protomer_body::structure::{Atom, Model, ResidueKey, SelectionSettings, Structure};
use protomer_kernel::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The rows of the manifest by column name.
fn manifest(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.tsv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split('\t').collect();
    let row = |line: &str| {
        names
            .iter()
            .map(|name| name.to_string())
            .zip(line.split('\t').map(str::to_string))
            .collect()
    };
    lines.map(row).collect()
}

fn residues_of(model: &Model, is_kind: impl Fn(&str) -> bool) -> usize {
    let key = |atom: &Atom| {
        (
            atom.chain.clone(),
            atom.residue_number,
            atom.insertion_code.clone(),
            atom.residue_name.clone(),
        )
    };
    let atoms = model
        .atoms
        .iter()
        .filter(|atom| is_kind(&atom.residue_name));
    atoms.map(key).collect::<BTreeSet<_>>().len()
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn every_file_reads_and_agrees_with_the_manifest() {
    let folder = many_structures();
    for entry in manifest(&folder) {
        let file = &entry["file"];
        let structure =
            Structure::read(file, &bytes(&folder, file)).unwrap_or_else(|error| panic!("{error}"));
        let number = |column: &str| entry[column].parse::<usize>().unwrap();
        let model = &structure.models[0];
        assert_eq!(model.atoms.len(), number("n_atoms_model1"), "{file} atoms");
        assert_eq!(structure.models.len(), number("n_models"), "{file} models");
        // The manifest counts no deuterium.
        let hydrogens = model
            .atoms
            .iter()
            .filter(|atom| &*atom.element == "H")
            .count();
        assert_eq!(hydrogens, number("n_hydrogens"), "{file} hydrogens");
        let nucleotides = residues_of(model, |name| {
            name.len() < 3 && residue_names::is_nucleotide(name)
        });
        assert_eq!(nucleotides, number("n_nucleotides"), "{file} nucleotides");
        let symmetry = structure.header.space_group.clone().unwrap_or_default();
        let expected = if structure.header.cell.is_some() {
            entry["space_group"].as_str()
        } else {
            ""
        };
        assert_eq!(symmetry, expected, "{file}");
        let resolution = entry["resolution"].parse::<f64>().unwrap();
        assert_eq!(
            structure.header.resolution_angstrom.unwrap_or(0.0),
            resolution,
            "{file}"
        );
        let method: String = structure.header.method.split_whitespace().collect();
        assert_eq!(
            method,
            entry["method"].split_whitespace().collect::<String>(),
            "{file}"
        );
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn insertion_codes_and_operators_are_all_found() {
    let folder = many_structures();
    for entry in manifest(&folder) {
        let structure = read(&folder, &entry["file"]);
        let number = |column: &str| entry[column].parse::<usize>().unwrap();
        let with_code = |model: &Model| {
            let atoms = model
                .atoms
                .iter()
                .filter(|atom| !atom.insertion_code.is_empty());
            atoms
                .map(|atom| {
                    (
                        atom.chain.clone(),
                        atom.residue_number,
                        atom.insertion_code.clone(),
                    )
                })
                .collect::<BTreeSet<_>>()
                .len()
        };
        if number("n_nucleotides") == 0 {
            assert_eq!(
                with_code(&structure.models[0]),
                number("n_icode"),
                "{}",
                entry["file"]
            );
        }
        let operators = structure.assemblies.first().map_or(0, |assembly| {
            assembly
                .parts
                .iter()
                .map(|part| part.operators.len())
                .max()
                .unwrap_or(0)
        });
        assert_eq!(operators, number("n_assembly_ops"), "{}", entry["file"]);
        for assembly in &structure.assemblies {
            for operator in assembly.parts.iter().flat_map(|part| &part.operators) {
                operator.pose().unwrap();
            }
        }
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn no_file_is_a_crystal_by_a_conventional_cell() {
    let folder = many_structures();
    for (file, is_crystal) in [
        ("6msm.pdb.gz", false),
        ("5a9z.cif.gz", false),
        ("1ssu.pdb.gz", false),
        ("4d0a.cif.gz", true),
    ] {
        let header = read(&folder, file).header;
        assert_eq!(
            (header.cell.is_some(), header.space_group.is_some()),
            (is_crystal, is_crystal),
            "{file}"
        );
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn both_formats_of_one_entry_give_the_same_sites() {
    let folder = many_structures();
    for name in [
        "1crn", "1ubq", "1aki", "5pti", "4hhb", "1f2n", "1ssu", "1ema",
    ] {
        let structures = ["pdb", "cif"].map(|format| read(&folder, &format!("{name}.{format}.gz")));
        let [pdb, cif] = structures.each_ref().map(|structure| {
            let selection = select(structure);
            let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
            (selection, sites)
        });
        assert_eq!(pdb.0.report.skipped, cif.0.report.skipped, "{name}");
        assert_eq!(pdb.0.report.unobserved, cif.0.report.unobserved, "{name}");
        assert_eq!(pdb.1.residues, cif.1.residues, "{name}");
        assert_eq!(pdb.1.sites.len(), cif.1.sites.len(), "{name}");
        for (a, b) in pdb.1.sites.iter().zip(&cif.1.sites) {
            assert_eq!(
                (&a.atom_name, a.residue),
                (&b.atom_name, b.residue),
                "{name}"
            );
            // 1F2N was remediated into another frame between the two files.
            assert!(
                (a.charge_e - b.charge_e).abs() < 1e-9 && (a.position - b.position).norm() < 2e-3,
                "{name} {a:?} {b:?}"
            );
        }
    }
}

/// Counts of charged residues and the published model pKa values give these net charges
/// (protonation by hand).
#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn net_charges_at_ph_7_4() {
    let folder = many_structures();
    for (file, expected) in [
        ("1crn.pdb.gz", -0.20),
        ("1aki.pdb.gz", 7.90),
        ("1hel.pdb.gz", 7.90),
        ("5pti.pdb.gz", 5.79),
    ] {
        let sites = build_sites(&select(&read(&folder, file)), &SiteSettings::default()).unwrap();
        assert!(
            (sites.net_charge_e() - expected).abs() < 0.05,
            "{file} {}",
            sites.net_charge_e()
        );
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn net_charges_are_protonation_sums_everywhere() {
    let folder = many_structures();
    for entry in manifest(&folder) {
        let settings = SelectionSettings {
            keep_ligands: true,
            keep_nucleic_acids: true,
            ..SelectionSettings::default()
        };
        let sites = build_sites(
            &read(&folder, &entry["file"]).select(&settings).unwrap(),
            &SiteSettings::default(),
        )
        .unwrap();
        let sum: f64 = sites.residues.iter().map(|residue| residue.charge_e).sum();
        assert!(
            (sites.net_charge_e() - sum).abs() < 1e-9,
            "{}",
            entry["file"]
        );
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn the_chromophore_of_gfp_keeps_its_atoms() {
    let folder = many_structures();
    let selection = select(&read(&folder, "1ema.pdb.gz"));
    let chromophore = selection
        .residues
        .iter()
        .find(|residue| &*residue.name == "CRO")
        .unwrap();
    assert_eq!(chromophore.atoms.len(), 22);
    assert!(
        selection.report.chain_breaks.is_empty()
            && selection.report.skipped.keys().eq(["water"].iter())
    );
    assert!(
        selection
            .report
            .modified
            .iter()
            .any(|entry| entry.note.contains("chromophore"))
    );
    // Residues 1 and 230-238 are listed as unobserved, so neither end is a real one.
    assert_eq!(selection.report.unobserved, 10);
    assert!(
        selection
            .residues
            .iter()
            .all(|residue| !residue.n_terminus && !residue.c_terminus)
    );
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn microheterogeneous_residues_are_one_residue() {
    let folder = many_structures();
    for file in ["1en2.pdb.gz", "1ejg.pdb.gz"] {
        let selection = select(&read(&folder, file));
        assert!(!selection.report.microheterogeneous.is_empty(), "{file}");
        let keys: BTreeSet<&ResidueKey> = selection
            .residues
            .iter()
            .map(|residue| &residue.key)
            .collect();
        assert_eq!(keys.len(), selection.residues.len(), "{file}");
        for residue in &selection.residues {
            let names: BTreeSet<&str> = residue.atoms.iter().map(|atom| &*atom.name).collect();
            assert_eq!(names.len(), residue.atoms.len(), "{file} {}", residue.key);
            assert!(
                residue
                    .atoms
                    .iter()
                    .all(|atom| atom.residue_name == residue.name),
                "{file} {}",
                residue.key
            );
        }
    }
}

/// Every copy of an assembly is the reference moved by its pose, and the assembly has the symmetry
/// it should have.
#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn assemblies_become_copies_of_few_bodies() {
    let folder = many_structures();
    for (file, id, copies) in [
        ("4qnb.pdb.gz", "1", &[6][..]),
        ("4oyn.pdb.gz", "1", &[24]),
        ("1stp.cif.gz", "1", &[4]),
        ("1f2n.cif.gz", "3", &[15]),
        ("1f2n.pdb.gz", "1", &[180]),
        ("4hhb.cif.gz", "1", &[2, 2]),
        ("1ncb.cif.gz", "1", &[4, 4, 4]),
    ] {
        let settings = SelectionSettings {
            assembly: Some(id.into()),
            ..SelectionSettings::default()
        };
        let selection = read(&folder, file).select(&settings).unwrap();
        let types = body_types(&selection).unwrap();
        let counts: Vec<usize> = types.iter().map(|body| body.copies.len()).collect();
        assert_eq!(counts, copies, "{file}");
        let worst = types
            .iter()
            .flat_map(|body| &body.copies)
            .map(|copy| copy.rmsd_angstrom)
            .fold(0.0, f64::max);
        println!("{file} {id}: {counts:?} worst RMSD {worst:.3}");
        // The chains of the T = 3 capsid 1F2N are only quasi-equivalent.
        assert!(
            worst < if file.starts_with("1f2n") { 2.0 } else { 1.0 },
            "{file} {worst}"
        );
        let chains: BTreeSet<&str> = types
            .iter()
            .flat_map(|body| &body.copies)
            .map(|copy| copy.chain.as_str())
            .collect();
        assert_eq!(chains.len(), copies.iter().sum::<usize>(), "{file}");
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn the_capsid_protein_hexamer_is_a_ring_about_an_axis() {
    let folder = many_structures();
    let settings = SelectionSettings {
        assembly: Some("1".into()),
        ..SelectionSettings::default()
    };
    let selection = read(&folder, "4qnb.pdb.gz").select(&settings).unwrap();
    let copies = &body_types(&selection).unwrap()[0].copies;
    let centre = copies.iter().map(|copy| copy.pose.position).sum::<Vec3>() / 6.0;
    let radius = (copies[0].pose.position - centre).norm();
    for copy in copies {
        assert!(
            copy.rmsd_angstrom < 1e-4
                && ((copy.pose.position - centre).norm() - radius).abs() < 1e-3
        );
        let turn = copies[0]
            .pose
            .rotation
            .angle_to(&copy.pose.rotation)
            .to_degrees()
            / 60.0;
        assert!((turn - turn.round()).abs() < 1e-3, "{turn}");
    }
}

/// Where pdbtbx reads a file without alternate locations, it finds the same atoms in the same
/// places.
#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn pdbtbx_is_a_second_witness() {
    let folder = many_structures();
    let mut agreed = 0;
    for entry in manifest(&folder) {
        let file = &entry["file"];
        let ours = read(&folder, file);
        let has_alternates = ours.models[0]
            .atoms
            .iter()
            .any(|atom| atom.alternate.is_some());
        if has_alternates || file.starts_with("5a9z") || file.starts_with("4v8r") {
            continue;
        }
        let format = if file.contains(".cif") {
            pdbtbx::Format::Mmcif
        } else {
            pdbtbx::Format::Pdb
        };
        let text = bytes(&folder, file);
        let attempt = std::panic::catch_unwind(|| {
            let reader = std::io::BufReader::new(std::io::Cursor::new(text));
            pdbtbx::ReadOptions::new()
                .set_level(pdbtbx::StrictnessLevel::Loose)
                .set_format(format)
                .read_raw(reader)
        });
        let Ok(Ok((theirs, _))) = attempt else {
            println!("{file}: not read by pdbtbx");
            continue;
        };
        let Some(model) = theirs.models().next() else {
            continue;
        };
        let place = |x: f64, y: f64, z: f64| [x, y, z].map(|value| (value * 1e3).round() as i64);
        let mut expected: Vec<_> = model
            .atoms()
            .map(|atom| (atom.name().to_string(), place(atom.x(), atom.y(), atom.z())))
            .collect();
        let atoms = &ours.models[0].atoms;
        let mut found: Vec<_> = atoms
            .iter()
            .map(|atom| {
                (
                    atom.name.to_string(),
                    place(atom.position.x, atom.position.y, atom.position.z),
                )
            })
            .collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found.len(), expected.len(), "{file}");
        assert_eq!(found, expected, "{file}");
        agreed += 1;
    }
    assert!(agreed >= 15, "only {agreed} files compared");
}
