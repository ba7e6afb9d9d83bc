//! Which atoms are a residue, which residues a chain, and which records no atoms, in files as programs
//! for molecular dynamics, NMR and electrostatics write them.

use crate::small::{atom, line, residue, select, select_with};
use protomer_body::assembly::body_types;
use protomer_body::chemistry::{SiteSettings, build_sites, mutate, parse_mutations};
use protomer_body::structure::{Selection, SelectionSettings, Structure};
use protomer_body::{BodySettings, Source, build_body, structure_warnings};

/// A chain of alanines from number `first`, `y` Å from the axis.
fn chain(place: &str, first: usize, count: usize, y: f64) -> String {
    let mut text = String::new();
    for number in 0..count {
        let place = format!("{place}{:>4} ", first + number);
        text += &residue("ATOM", "ALA", &place, number);
    }
    moved(&text, y)
}

/// The same atoms, `y` Å farther.
fn moved(text: &str, y: f64) -> String {
    let mut lines = String::new();
    for line in text.lines() {
        let old: f64 = line[38..46].trim().parse().unwrap();
        lines += &format!("{}{:8.3}{}\n", &line[..38], old + y, &line[46..]);
    }
    lines
}

fn keys(selection: &Selection) -> Vec<String> {
    let residues = selection.residues.iter();
    residues.map(|residue| residue.key.to_string()).collect()
}

fn names(selection: &Selection) -> Vec<&str> {
    let residues = selection.residues.iter();
    residues.map(|residue| &*residue.name).collect()
}

fn net_charge_e(selection: &Selection) -> f64 {
    build_sites(selection, &SiteSettings::default())
        .unwrap()
        .net_charge_e()
}

fn warnings(text: &str) -> String {
    let structure = Structure::read("test.pdb", text.as_bytes()).unwrap();
    let selection = structure.select(&SelectionSettings::default()).unwrap();
    structure_warnings(&structure, &selection.report).join("\n")
}

fn everything() -> SelectionSettings {
    SelectionSettings {
        keep_ligands: true,
        keep_waters: true,
        keep_hydrogens: true,
        ..SelectionSettings::default()
    }
}

/// Amine and carboxylate of a chain at pH 7.4.
const ENDS_E: f64 = 0.799_240 - 0.999_937;

#[test]
fn ter_and_segments_end_a_chain_and_each_chain_has_a_name() {
    let (one, other) = (chain(" ", 1, 3, 0.0), chain(" ", 1, 3, 30.0));
    let with_segment = |text: &str, segment: &str| {
        let lines = text.lines().map(|line| format!("{line:<72}{segment}\n"));
        lines.collect::<String>()
    };
    let same_letter = format!("{}TER\n{}", chain("A", 1, 3, 0.0), chain("A", 1, 3, 30.0));
    let by_segment = with_segment(&one, "PROA") + &with_segment(&other, "PROB");
    let next_number = format!("{one}TER\n{}", chain(" ", 3, 3, 30.0));
    for (text, expected) in [
        (format!("{one}TER\n{other}"), ["A", "B"]),
        (format!("{one}{other}"), ["A", "B"]),
        (next_number, ["A", "B"]),
        (by_segment, ["PROA", "PROB"]),
        (same_letter, ["A", "A2"]),
    ] {
        let selection = select(&text);
        let names = [0, 3].map(|index| selection.residues[index].key.chain.to_string());
        assert_eq!(names, expected, "{text}");
        assert_eq!(selection.report.atoms, 30);
        assert!(selection.report.chain_breaks.is_empty());
        assert!((net_charge_e(&selection) - 2.0 * ENDS_E).abs() < 1e-4);
        assert!(warnings(&text).contains(expected[1]), "{}", warnings(&text));
    }
    // Two chains, two copies.
    let types = body_types(&select(&format!("{one}TER\n{other}"))).unwrap();
    assert_eq!((types.len(), types[0].copies.len()), (1, 2));
    assert!(types[0].copies.iter().all(|copy| copy.rmsd_angstrom < 1e-3));
}

#[test]
fn a_chain_is_one_across_ter_where_it_is_bonded_and_across_a_gap() {
    let whole = chain("A", 1, 4, 0.0);
    let lines: Vec<&str> = whole.lines().collect();
    let (first, second) = (lines[..10].join("\n"), lines[10..].join("\n"));
    let bonded = select(&format!("{first}\nTER\n{second}\n"));
    assert_eq!(keys(&bonded), ["A:1", "A:2", "A:3", "A:4"]);
    assert!((net_charge_e(&bonded) - ENDS_E).abs() < 1e-4);
    // A gap without TER is a break, with TER the end of a chain that keeps its letter.
    let gap = format!("{first}\n{}", lines[15..].join("\n"));
    assert_eq!(select(&gap).report.chain_breaks.len(), 1);
    let ended = select(&format!("{first}\nTER\n{}", lines[15..].join("\n")));
    assert_eq!(keys(&ended), ["A:1", "A:2", "A:4"]);
    assert!((net_charge_e(&ended) - 2.0 * ENDS_E).abs() < 1e-4);
    // Both names select a chain that begins again.
    let again = format!("{whole}TER\n{}", chain("A", 1, 4, 30.0));
    let chosen = |name: &str| {
        let settings = SelectionSettings {
            chains: vec![name.into()],
            ..SelectionSettings::default()
        };
        select_with(&again, &settings).residues.len()
    };
    assert_eq!((chosen("A"), chosen("A2")), (8, 4));
}

#[test]
fn a_modified_residue_after_ter_takes_its_place_in_the_chain() {
    let mut text = String::new();
    for number in [0, 1, 3, 4] {
        text += &residue("ATOM", "ALA", &format!("A{:>4} ", number + 1), number);
    }
    text += "TER\n";
    text += &residue("HETATM", "MSE", "A   3 ", 2);
    // Free, and without bonds: a ligand.
    text += &moved(&residue("HETATM", "GLY", "A 101 ", 2), 30.0);
    let selection = select(&text);
    assert_eq!(keys(&selection), ["A:1", "A:2", "A:3", "A:4", "A:5"]);
    assert_eq!(names(&selection)[2], "MSE");
    assert!(selection.report.chain_breaks.is_empty());
    assert_eq!(selection.report.skipped["ligand"], 5);
    assert!((net_charge_e(&selection) - ENDS_E).abs() < 1e-4);
    // The first residue of the chain.
    let mut text = String::new();
    for number in [1, 2] {
        text += &residue("ATOM", "ALA", &format!("A{:>4} ", number + 1), number);
    }
    text += "TER\n";
    text += &residue("HETATM", "MSE", "A   1 ", 0);
    assert_eq!(names(&select(&text)), ["MSE", "ALA", "ALA"]);
}

#[test]
fn ions_waters_and_ligands_of_one_number_are_several() {
    let zinc = |x: f64| line("HETATM", "ZN", ' ', "ZN", "A   1 ", [x, 30.0, 0.0], 1.0);
    let water = |x: f64| line("HETATM", "O", ' ', "HOH", "A   1 ", [x, 40.0, 0.0], 1.0);
    let ligand = |x: f64| {
        let atoms = [("C1", 0.0), ("C2", 1.5), ("O1", 3.0)];
        atoms
            .map(|(name, z)| line("HETATM", name, ' ', "LIG", "A   1 ", [x, 50.0, z], 1.0))
            .concat()
    };
    // As psfgen writes it, without TER, the ion has the number of a residue.
    let text = chain("A", 1, 2, 0.0)
        + &[60.0, 66.0, 72.0].map(zinc).concat()
        + &[60.0, 66.0].map(water).concat()
        + &[60.0, 66.0].map(ligand).concat();
    let selection = select_with(&text, &everything());
    assert_eq!(
        names(&selection),
        ["ALA", "ALA", "ZN", "ZN", "ZN", "HOH", "HOH", "LIG", "LIG"]
    );
    assert!(
        selection.report.skipped.is_empty(),
        "{:?}",
        selection.report.skipped
    );
    assert!((net_charge_e(&selection) - ENDS_E - 6.0).abs() < 1e-4);
}

#[test]
fn the_archives_chains_tell_ions_of_one_number_apart() {
    let rows = ["B", "C", "D"].map(|chain| {
        format!(
            "HETATM ZN ZN ZN {chain} A 1 {}.0 0 0\n",
            u32::from(chain.as_bytes()[0])
        )
    });
    let text = format!(
        "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.type_symbol\n_atom_site.label_atom_id\n\
         _atom_site.label_comp_id\n_atom_site.label_asym_id\n_atom_site.auth_asym_id\n_atom_site.auth_seq_id\n\
         _atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n{}",
        rows.concat()
    );
    assert_eq!(select_with(&text, &everything()).residues.len(), 3);
}

#[test]
fn two_names_of_one_residue_are_one_residue() {
    // As pdb2pqr writes names of CHARMM: the patch names the side chain.
    let side_chain = [("CG", 3.8), ("CD", 5.2), ("OE1", 5.9), ("OE2", 6.0)];
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + &residue("ATOM", "GLU", "A   2 ", 1)
        + &side_chain
            .map(|(name, y)| {
                atom(
                    name,
                    "GLUP",
                    "A   2 ",
                    [5.0, y, if name == "OE2" { 1.0 } else { 0.0 }],
                )
                .replace("GLUP A", "GLUPA")
            })
            .concat()
        + &residue("ATOM", "ALA", "A   3 ", 2);
    let selection = select(&text);
    assert_eq!(names(&selection), ["ALA", "GLU", "ALA"]);
    assert_eq!(selection.residues[1].atoms.len(), 9);
    assert!(selection.report.incomplete.is_empty());
    assert!((net_charge_e(&selection) - ENDS_E + 1.0).abs() < 0.01);
    assert!(
        warnings(&text).contains("GLU A:2: the file has a part of its atoms under the name GLUP")
    );
}

#[test]
fn residues_without_numbers_are_told_apart_by_names_and_atoms() {
    for number in ["   1", "    ", "****"] {
        let mut text = String::new();
        for (place, name) in ["ALA", "GLY", "GLY", "SER", "ALA"].iter().enumerate() {
            text += &residue("ATOM", name, &format!("A{number} "), place);
        }
        let selection = select(&text);
        assert_eq!(
            names(&selection),
            ["ALA", "GLY", "GLY", "SER", "ALA"],
            "{number}"
        );
        assert_eq!(keys(&selection), ["A:1", "A:2", "A:3", "A:4", "A:5"]);
        assert_eq!(selection.report.atoms, 25);
        assert!((net_charge_e(&selection) - ENDS_E).abs() < 1e-4);
        assert!(
            warnings(&text).contains("numbered from 1"),
            "{}",
            warnings(&text)
        );
    }
}

#[test]
fn alternate_locations_without_letters_stay_one_residue() {
    let half = |name: &str, y: f64| line("ATOM", name, ' ', "SER", "A   1 ", [1.2, y, 0.5], 0.5);
    let text = residue("ATOM", "SER", "A   1 ", 0)
        + &half("OG", 3.0)
        + &half("OG", 3.2)
        + &residue("ATOM", "ALA", "A   2 ", 1);
    let selection = select(&text);
    assert_eq!(selection.residues.len(), 2);
    assert_eq!(selection.report.skipped["duplicate atom"], 1);
}

#[test]
fn four_letter_names_are_those_of_their_amino_acid() {
    let mut text = residue("ATOM", "ALA", "A  14 ", 0);
    for (place, name) in ["LYSH", "HISE", "ASPH", "CYS2"].iter().enumerate() {
        let line = residue("ATOM", "XXX", &format!("A{:>4} ", place + 15), place + 1);
        text += &line.replace("XXX A", &format!("{name}A"));
    }
    text += &residue("ATOM", "ALA", "A  19 ", 5);
    let mut selection = select(&text);
    assert_eq!(
        names(&selection),
        ["ALA", "LYSH", "HISE", "ASPH", "CYS2", "ALA"]
    );
    assert!(
        selection
            .residues
            .iter()
            .all(|residue| &*residue.key.chain == "A")
    );
    assert!(selection.report.chain_breaks.is_empty());
    // The names of force fields hide no missing atoms.
    assert_eq!(selection.report.incomplete.len(), 4);
    mutate(&mut selection, &parse_mutations("A:K15E").unwrap()).unwrap();
    assert_eq!(&*selection.residues[1].name, "GLU");
}

#[test]
fn a_name_that_its_atoms_contradict_is_not_believed() {
    let rest = [("CG", 3.8), ("SD", 5.6), ("CE", 7.4)];
    let mut methionine = residue("ATOM", "NME", "A   1 ", 0);
    methionine += &rest
        .map(|(name, y)| atom(name, "NME", "A   1 ", [1.2, y, 0.0]))
        .concat();
    let text = methionine + &residue("ATOM", "ALA", "A   2 ", 1);
    let selection = select(&text);
    assert_eq!(names(&selection), ["MET", "ALA"]);
    assert!((net_charge_e(&selection) - ENDS_E).abs() < 1e-4);
    assert!(
        warnings(&text).contains("NME A:1: has the heavy atoms of MET"),
        "{}",
        warnings(&text)
    );
    // The cap is one.
    let cap = atom("N", "NME", "A   2 ", [3.8, 0.0, 0.0])
        + &atom("CH3", "NME", "A   2 ", [5.2, 0.0, 0.0]);
    let capped = select(&(residue("ATOM", "ALA", "A   1 ", 0) + &cap));
    assert!((net_charge_e(&capped) - 0.799).abs() < 1e-3);
}

#[test]
fn what_is_no_atom_is_left_out_and_named() {
    let text = chain("A", 1, 3, 0.0)
        + &atom("QB", "ALA", "A   3 ", [9.0, 2.6, 0.3])
        + &atom("MG", "ALA", "A   3 ", [9.0, 2.8, 0.3])
        + &atom("LP1", "ALA", "A   3 ", [9.0, 2.9, 0.3])
        + &atom("CG", "ALA", "A   3 ", [9999.0; 3])
        + &atom("CD", "ALA", "A   3 ", [0.0; 3])
        + &atom("CE", "ALA", "A   3 ", [0.0; 3]);
    let selection = select(&text);
    // The first atom of the chain is at the origin as well.
    assert_eq!(selection.report.atoms, 14);
    assert_eq!(selection.report.skipped["pseudoatom"], 3);
    assert_eq!(selection.report.skipped["unbuilt atom"], 4);
    let warnings = warnings(&text);
    assert!(
        warnings.contains("3 pseudoatoms left out: 1 LP1, 1 MG, 1 QB"),
        "{warnings}"
    );
    assert!(
        warnings.contains("4 unbuilt atoms left out: 1 CD, 1 CE, 1 CG, 1 N"),
        "{warnings}"
    );
    // A water has one oxygen.
    let water = ["OW", "HW1", "HW2", "MW"]
        .map(|name| {
            line(
                "HETATM",
                name,
                ' ',
                "SOL",
                "A   9 ",
                [
                    20.0,
                    f64::from(name.as_bytes()[1]),
                    f64::from(name.as_bytes()[name.len() - 1]),
                ],
                1.0,
            )
        })
        .concat();
    let kept = select_with(&(chain("A", 1, 1, 9.0) + &water), &everything());
    assert_eq!(kept.residues[1].atoms.len(), 3);
}

#[test]
fn the_same_atoms_twice_are_one() {
    let text = chain("A", 1, 3, 9.0);
    let twice_by_lines: String = text
        .lines()
        .map(|line| format!("{line}\n{line}\n"))
        .collect();
    let other_letter = text.replace(" A ", " B ");
    for (doubled, reason) in [
        (format!("{text}{text}"), "repeated atom"),
        (format!("{text}TER\n{text}"), "repeated atom"),
        (twice_by_lines, "repeated atom"),
        (
            format!("{text}{other_letter}"),
            "atom in the place of another",
        ),
    ] {
        let selection = select(&doubled);
        assert_eq!(selection.report.atoms, 15, "{reason}");
        assert_eq!(selection.report.skipped[reason], 15);
        assert!((net_charge_e(&selection) - ENDS_E).abs() < 1e-4);
        assert!(warnings(&doubled).contains("15 "), "{}", warnings(&doubled));
    }
}

#[test]
fn of_hydrogen_and_deuterium_on_one_point_one_is_kept() {
    let exchange = |codes: [char; 2]| {
        chain("A", 1, 1, 9.0)
            + &line(
                "ATOM",
                "H",
                codes[0],
                "ALA",
                "A   1 ",
                [-0.5, 9.9, 0.0],
                0.4,
            )
            + &line(
                "ATOM",
                "D",
                codes[1],
                "ALA",
                "A   1 ",
                [-0.5, 9.9, 0.0],
                0.6,
            )
    };
    for codes in [['A', 'B'], [' ', ' ']] {
        let selection = select_with(&exchange(codes), &everything());
        let atoms = &selection.residues[0].atoms;
        assert_eq!(atoms.len(), 6, "{codes:?}");
        assert!(atoms.iter().any(|atom| &*atom.name == "D"));
    }
}

#[test]
fn ions_have_charge_and_element_under_the_names_of_other_programs() {
    for (name, element, charge_e) in [
        ("SOD", "NA", 1.0),
        ("CLA", "CL", -1.0),
        ("POT", "K", 1.0),
        ("CAL", "CA", 2.0),
        ("CES", "CS", 1.0),
        ("NA+", "NA", 1.0),
        ("Cl-", "CL", -1.0),
        ("ZN2", "ZN", 2.0),
        ("MG2", "MG", 2.0),
    ] {
        let text = chain("A", 1, 1, 9.0) + &line("ATOM", name, ' ', name, "A 301 ", [40.0; 3], 1.0);
        let selection = select_with(&text, &everything());
        let ion = selection.residues.last().unwrap();
        assert_eq!(&*ion.atoms[0].element, element, "{name}");
        assert!(
            (net_charge_e(&selection) - ENDS_E - charge_e).abs() < 1e-4,
            "{name}"
        );
    }
}

#[test]
fn elements_that_are_first_letters_of_names_are_not_believed() {
    let text = chain("A", 1, 2, 9.0);
    let with_elements: String = text
        .lines()
        .map(|line| {
            format!(
                "{line:<76}{:>2}\n",
                line[12..16].trim().get(..2).unwrap_or(line[12..16].trim())
            )
        })
        .collect();
    assert_eq!(
        select(&with_elements).residues[0].atoms[1].element,
        select(&text).residues[0].atoms[1].element
    );
    assert!(
        warnings(&with_elements).contains("2 atoms state another element"),
        "{}",
        warnings(&with_elements)
    );
}

#[test]
fn coordinates_in_other_units_are_refused() {
    for (scale, unit) in [(0.1, "nm"), (1.0 / 0.529_177, "Bohr")] {
        let text = chain("A", 1, 4, 9.0);
        let mut scaled = String::new();
        for line in text.lines() {
            let place = [30..38, 38..46, 46..54]
                .map(|columns| line[columns].trim().parse::<f64>().unwrap() * scale);
            let [x, y, z] = place;
            scaled += &format!("{}{x:8.3}{y:8.3}{z:8.3}{}\n", &line[..30], &line[54..]);
        }
        let structure = Structure::read("md.pdb", scaled.as_bytes()).unwrap();
        let error = structure
            .select(&SelectionSettings::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("md.pdb") && error.contains(unit) && error.contains("multiply"),
            "{error}"
        );
    }
}

#[test]
fn one_of_several_models_is_used_with_a_warning() {
    let model =
        |number: usize, y: f64| format!("MODEL {number:>8}\n{}TER\nENDMDL\n", chain("A", 1, 2, y));
    let text = model(1, 0.0) + &model(2, 30.0);
    assert!(
        warnings(&text).contains("model 1 of 2 models is used"),
        "{}",
        warnings(&text)
    );
    let structure = Structure::read("a.pdb1", text.as_bytes()).unwrap();
    let chosen = SelectionSettings {
        model: Some(2),
        ..SelectionSettings::default()
    };
    let report = structure.select(&chosen).unwrap().report;
    assert!(structure_warnings(&structure, &report).is_empty());
}

#[test]
fn an_assembly_without_a_list_of_chains_applies_to_all() {
    let operators = "\
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2  1.000000  0.000000  0.000000      400.00000
REMARK 350   BIOMT2   2  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000        0.00000
";
    let head = "REMARK 350 BIOMOLECULE: 1\n";
    let list = "REMARK 350 APPLY THE FOLLOWING TO CHAINS: NULL\n";
    for remark in [
        format!("{head}{list}{operators}"),
        format!("{head}{operators}"),
        operators.into(),
    ] {
        let text = remark + &chain(" ", 1, 2, 9.0);
        let settings = SelectionSettings {
            assembly: Some("1".into()),
            ..SelectionSettings::default()
        };
        assert_eq!(select_with(&text, &settings).report.atoms, 20);
        assert!(
            warnings(&text).contains("names no chains"),
            "{}",
            warnings(&text)
        );
    }
}

#[test]
fn an_atom_under_a_misspelt_record_is_refused() {
    let text = chain("A", 1, 3, 9.0)
        .replacen("ATOM  ", "ATAM  ", 3)
        .replacen("ATAM  ", "ATOM  ", 2);
    let error = Structure::read("x.pdb", text.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("x.pdb:3") && error.contains("ATAM") && error.contains("write ATOM"),
        "{error}"
    );
}

#[test]
fn serial_numbers_of_six_digits_lose_no_atom() {
    let text = chain("A", 1, 3, 9.0);
    let numbered = |number: usize, line: &str| match number {
        0..5 => format!("ATOM  {:>5}{}\n", 99_995 + number, &line[11..]),
        5..10 => format!("ATOM {}{}\n", 99_995 + number, &line[11..]),
        _ => format!("ATOM  {}{}\n", 99_995 + number, &line[11..]),
    };
    let long: String = text
        .lines()
        .enumerate()
        .map(|(number, line)| numbered(number, line))
        .collect();
    let selection = select(&long);
    assert_eq!(selection.report.atoms, 15);
    assert_eq!(selection.residues[2].atoms[4].serial, 100_009);
    assert!(
        warnings(&long).contains("5 atoms have columns shifted"),
        "{}",
        warnings(&long)
    );
}

#[test]
fn a_file_without_atoms_says_what_it_holds() {
    let error = |name: &str, text: &str| {
        Structure::read(name, text.as_bytes())
            .unwrap_err()
            .to_string()
    };
    let pqr = error(
        "x.pdb",
        "ATOM 1 N ARG A 1 32.231 15.281 -13.143 -0.1500 1.5500\n",
    );
    assert!(pqr.contains("this is PQR") && !pqr.contains("cut"), "{pqr}");
    let none = error("x.pdb", "REMARK   1 NOTHING\nEND\n");
    assert!(
        none.contains("no atoms in 2 lines") && !none.contains("cut"),
        "{none}"
    );
    let cut = error("x.pdb", "HEADER    HYDROLASE\nSEQRES   1 A    5  GLY\n");
    assert!(cut.contains("cut off"), "{cut}");
}

#[test]
fn a_body_has_the_molar_mass_of_its_modified_residues() {
    let body = |names: &[&str]| {
        let mut text = String::new();
        for (place, name) in names.iter().enumerate() {
            text += &residue("ATOM", name, &format!("A{:>4} ", place + 1), place);
        }
        let mut settings = BodySettings::default();
        settings.surface.density_per_angstrom2 = 0.2;
        let source = Source {
            file: "x.pdb",
            sha256: "",
        };
        build_body("x", source, text.as_bytes(), &settings)
            .unwrap()
            .body
    };
    let mass = |names: &[&str]| body(names).molar_mass_g_per_mol().unwrap();
    // HPO3, Se for S, and CO2 on lysine.
    assert!((mass(&["ALA", "SEP"]) - mass(&["ALA", "SER"]) - 79.98).abs() < 1e-9);
    assert!((mass(&["ALA", "MSE"]) - mass(&["ALA", "MET"]) - 46.911).abs() < 1e-9);
    assert!((mass(&["ALA", "KCX"]) - mass(&["ALA", "LYS"]) - 44.009).abs() < 1e-9);
    assert_eq!(mass(&["ALA", "HIE"]), mass(&["ALA", "HIS"]));
    // Ala-Ala, C6H12N2O3.
    assert!((mass(&["ALA", "ALA"]) - 160.173).abs() < 1e-9);
    let unknown = body(&["ALA", "XYZ"]);
    assert_eq!(unknown.molar_mass_g_per_mol(), None);
    assert_eq!(
        unknown
            .residues_of_unknown_mass()
            .into_iter()
            .collect::<Vec<_>>(),
        ["XYZ"]
    );
}
