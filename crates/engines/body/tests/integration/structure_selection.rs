//! Small structures written for one rule each.

use crate::small::{atom, line, residue, select, select_with};
use protomer_body::assembly::body_types;
use protomer_body::chemistry::{
    ChargeModel, SiteSettings, build_sites, mutate, parse_mutations, sites_of_points,
};
use protomer_body::structure::{SelectedResidue, Selection, SelectionSettings, Structure};
use protomer_kernel::{PointRecord, Vec3};

fn names(residue: &SelectedResidue) -> Vec<&str> {
    residue.atoms.iter().map(|atom| &*atom.name).collect()
}

fn charges(selection: &Selection, charges: ChargeModel) -> Vec<f64> {
    let sites = build_sites(
        selection,
        &SiteSettings {
            ph: 7.4,
            charges,
            ..SiteSettings::default()
        },
    )
    .unwrap();
    let sum: f64 = sites.residues.iter().map(|residue| residue.charge_e).sum();
    assert!((sum - sites.net_charge_e()).abs() < 1e-9);
    sites
        .residues
        .iter()
        .map(|residue| residue.charge_e)
        .collect()
}

#[test]
fn the_conformer_with_the_highest_occupancy_is_taken_whole() {
    let conformers = |a: f64, b: f64| {
        let letters = [('A', a, 0.0), ('B', b, 1.0)];
        let atoms = letters.iter().flat_map(|(code, occupancy, x)| {
            [("CB", 1.0), ("OG", 2.0)].map(|(name, y)| {
                line(
                    "ATOM",
                    name,
                    *code,
                    "SER",
                    "A   1 ",
                    [*x, y, 0.0],
                    *occupancy,
                )
            })
        });
        atom("CA", "SER", "A   1 ", [0.0; 3]) + &atoms.collect::<String>()
    };
    let x_of = |selection: &Selection| {
        selection.residues[0]
            .atoms
            .iter()
            .map(|atom| atom.position.x)
            .collect::<Vec<_>>()
    };
    assert_eq!(x_of(&select(&conformers(0.4, 0.6))), [0.0, 1.0, 1.0]);
    assert_eq!(
        x_of(&select(&conformers(0.5, 0.5))),
        [0.0, 0.0, 0.0],
        "ties go to the first letter"
    );
    let stated = SelectionSettings {
        alternate: Some('A'),
        ..SelectionSettings::default()
    };
    let chosen = select_with(&conformers(0.4, 0.6), &stated);
    assert_eq!(x_of(&chosen), [0.0, 0.0, 0.0]);
    assert_eq!(chosen.report.skipped["alternate location"], 2);
    let absent = SelectionSettings {
        alternate: Some('Q'),
        ..SelectionSettings::default()
    };
    assert_eq!(
        x_of(&select_with(&conformers(0.4, 0.6), &absent)),
        [0.0, 1.0, 1.0]
    );
}

#[test]
fn an_atom_that_only_another_conformer_has_is_not_lost() {
    let text = line("ATOM", "CA", 'A', "SER", "A   1 ", [0.0; 3], 0.7)
        + &line("ATOM", "CA", 'B', "SER", "A   1 ", [1.0, 0.0, 0.0], 0.3)
        + &line("ATOM", "OG", 'B', "SER", "A   1 ", [2.0, 0.0, 0.0], 0.3);
    let selection = select(&text);
    assert_eq!(names(&selection.residues[0]), ["CA", "OG"]);
    assert_eq!(selection.residues[0].atoms[0].position.x, 0.0);
}

#[test]
fn of_two_residues_in_one_place_one_is_chosen() {
    let text = line("ATOM", "CA", 'A', "SER", "A   1 ", [0.0; 3], 0.4)
        + &line("ATOM", "CA", 'B', "PRO", "A   1 ", [0.1; 3], 0.6);
    let selection = select(&text);
    assert_eq!(selection.residues.len(), 1);
    assert_eq!(&*selection.residues[0].name, "PRO");
    assert_eq!(
        selection.report.microheterogeneous[0].note,
        "chosen over SER"
    );
}

#[test]
fn a_ligand_after_ter_is_no_part_of_the_chain_and_a_modified_residue_is() {
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + &residue("HETATM", "MSE", "A   2 ", 1)
        + &residue("HETATM", "XYZ", "A   3 ", 2)
        + &residue("ATOM", "ALA", "A   4 ", 3)
        + "TER\n"
        + &residue("HETATM", "GLY", "A 101 ", 20)
        + &line("HETATM", "O", ' ', "HOH", "A 201 ", [9.0; 3], 1.0)
        + &line("HETATM", "ZN", ' ', " ZN", "A 301 ", [12.0; 3], 1.0);
    let selection = select(&text);
    let kept: Vec<&str> = selection
        .residues
        .iter()
        .map(|residue| &*residue.name)
        .collect();
    assert_eq!(kept, ["ALA", "MSE", "XYZ", "ALA"]);
    assert_eq!(
        (
            selection.report.skipped["ligand"],
            selection.report.skipped["water"]
        ),
        (6, 1)
    );
    assert_eq!(
        selection.report.modified[0].note,
        "selenomethionine, counted as MET"
    );
    assert_eq!(selection.report.unknown[0].residue.to_string(), "A:3");
    assert!(selection.report.chain_breaks.is_empty());
    let everything = SelectionSettings {
        keep_ligands: true,
        keep_waters: true,
        ..SelectionSettings::default()
    };
    let all = select_with(&text, &everything);
    let zinc = charges(&all, ChargeModel::ForceField);
    assert_eq!(zinc.last(), Some(&2.0));
    // The free glycine is a ligand, not an end of the chain.
    assert!(
        all.residues
            .iter()
            .filter(|residue| residue.n_terminus)
            .count()
            == 1
            && all.residues[3].c_terminus
    );
}

#[test]
fn ends_of_chains() {
    let chain = |header: &str| {
        format!(
            "{header}{}{}",
            residue("ATOM", "ALA", "A   5 ", 0),
            residue("ATOM", "ALA", "A   6 ", 1)
        )
    };
    let net = |text: &str| charges(&select(text), ChargeModel::ForceField);
    let both = net(&chain(""));
    assert!((both[0] - 0.799).abs() < 1e-3 && (both[1] + 1.0).abs() < 1e-3);
    let heading = "REMARK 465   M RES C SSSEQI\n";
    let before = net(&chain(&format!("{heading}REMARK 465     MET A     4\n")));
    assert!(before[0] == 0.0 && before[1] < -0.99, "{before:?}");
    let after = net(&chain(&format!("{heading}REMARK 465     MET A     7\n")));
    assert!(after[0] > 0.79 && after[1] == 0.0, "{after:?}");
    // An OXT is an end in any case.
    let with_oxt = chain(&format!("{heading}REMARK 465     MET A     7\n"))
        + &atom("OXT", "ALA", "A   6 ", [6.5, 1.0, 0.0]);
    assert!(net(&with_oxt)[1] < -0.99);
    let blocked = residue("HETATM", "PCA", "A   1 ", 0) + &residue("ATOM", "ALA", "A   2 ", 1);
    assert_eq!(net(&blocked)[0], 0.0);
    let capped = line("HETATM", "C", ' ', "ACE", "A   4 ", [-1.33, 0.0, 0.0], 1.0) + &chain("");
    assert_eq!(net(&capped)[..2], [0.0, 0.0]);
}

#[test]
fn breaks_are_found_by_distance_not_by_number() {
    let numbered_with_gap =
        residue("ATOM", "ALA", "A   1 ", 0) + &residue("ATOM", "ALA", "A   9 ", 1);
    assert!(select(&numbered_with_gap).report.chain_breaks.is_empty());
    let apart = residue("ATOM", "ALA", "A   1 ", 0) + &residue("ATOM", "ALA", "A   4 ", 3);
    let gap = &select(&apart).report.chain_breaks[0];
    assert_eq!(
        (gap.before.number, gap.after.number, gap.missing_numbers),
        (1, 4, 2)
    );
    assert!(gap.distance_angstrom.unwrap() > 8.0);
    // Without the atoms of the bond, the numbers decide.
    let traces = atom("CA", "ALA", "A   1 ", [0.0; 3])
        + &atom("CA", "ALA", "A   2 ", [3.8, 0.0, 0.0])
        + &atom("CA", "ALA", "A   7 ", [9.0; 3]);
    assert_eq!(select(&traces).report.chain_breaks.len(), 1);
}

#[test]
fn bonded_cysteines_do_not_titrate() {
    let pair = |z: f64| {
        residue("ATOM", "CYS", "A   1 ", 0)
            + &atom("SG", "CYS", "A   1 ", [0.0, 3.0, 5.0])
            + &residue("ATOM", "CYS", "A   2 ", 1)
            + &atom("SG", "CYS", "A   2 ", [0.0, 3.0, 5.0 + z])
    };
    for (distance, bonded) in [(2.05, true), (2.6, false), (2.0 * 2.5, false)] {
        let selection = select(&pair(distance));
        assert!(
            selection
                .residues
                .iter()
                .all(|residue| residue.in_disulfide == bonded),
            "{distance}"
        );
    }
    let mut cut = select(&pair(2.05));
    mutate(&mut cut, &parse_mutations("A:C1S").unwrap()).unwrap();
    assert!(
        !cut.residues[1].in_disulfide,
        "a cysteine without its partner titrates"
    );
}

#[test]
fn charges_of_modified_residues() {
    let middle = |name: &str| {
        let text = residue("ATOM", "ALA", "A   1 ", 0)
            + &residue("HETATM", name, "A   2 ", 1)
            + &residue("ATOM", "ALA", "A   3 ", 2);
        let selection = select(&text);
        let formal = charges(&selection, ChargeModel::Formal);
        let force_field = charges(&selection, ChargeModel::ForceField);
        assert_eq!(formal, force_field);
        formal[1]
    };
    let cases = [
        ("MSE", 0.0),
        ("SEP", -1.98),
        ("TPO", -1.95),
        ("CSO", 0.0),
        ("MLY", 1.0),
        ("M3L", 1.0),
        ("KCX", -1.0),
        ("HYP", 0.0),
        ("OCS", -1.0),
        ("CGU", -2.0),
        ("ALY", 0.0),
        ("HIP", 0.11),
        ("CRO", 0.0),
        ("UNK", 0.0),
    ];
    for (name, expected) in cases {
        assert!(
            (middle(name) - expected).abs() < 0.01,
            "{name} {}",
            middle(name)
        );
    }
}

#[test]
fn nucleic_acids_are_counted_or_kept_with_their_phosphates() {
    let base = |name: &str, place: &str, x: f64| {
        [("P", 0.0), ("OP1", 1.5), ("OP2", -1.5), ("C1'", 3.0)]
            .iter()
            .map(|(atom_name, y)| atom(atom_name, name, place, [x, *y, 0.0]))
            .collect::<String>()
    };
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + &base(" DG", "B   1 ", 20.0)
        + &base("  U", "B   2 ", 30.0);
    assert_eq!(select(&text).report.skipped["nucleic acid"], 8);
    let kept = select_with(
        &text,
        &SelectionSettings {
            keep_nucleic_acids: true,
            ..SelectionSettings::default()
        },
    );
    assert_eq!(charges(&kept, ChargeModel::Formal)[1..], [-1.0, -1.0]);
    assert_eq!(charges(&kept, ChargeModel::ForceField)[1..], [-1.0, -1.0]);
}

#[test]
fn hydrogens_that_are_kept_leave_the_charge_on_their_heavy_atom() {
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + &line("ATOM", "HA", ' ', "ALA", "A   1 ", [1.2, 0.2, 0.9], 1.0);
    let kept = select_with(
        &text,
        &SelectionSettings {
            keep_hydrogens: true,
            ..SelectionSettings::default()
        },
    );
    let sites = build_sites(&kept, &SiteSettings::default()).unwrap().sites;
    assert_eq!(
        (
            sites[5].atom_name.as_str(),
            sites[5].charge_e,
            sites[5].radius_angstrom
        ),
        ("HA", 0.0, 1.10)
    );
    assert_eq!(select(&text).report.skipped["hydrogen"], 1);
}

const TURNED: &str = "\
REMARK 350 BIOMOLECULE: 1
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000       10.00000
REMARK 350   BIOMT2   2  0.000000 -1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000        5.00000
REMARK 350 BIOMOLECULE: 2
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A,
REMARK 350                    AND CHAINS: B
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000 -1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
";

#[test]
fn an_assembly_is_copies_of_its_chains() {
    let text = format!(
        "{TURNED}{}{}{}",
        residue("ATOM", "LYS", "A   1 ", 0),
        residue("ATOM", "ALA", "A   2 ", 1),
        residue("ATOM", "TRP", "B   1 ", 9)
    );
    let settings = SelectionSettings {
        assembly: Some("1".into()),
        ..SelectionSettings::default()
    };
    let mut selection = select_with(&text, &settings);
    let keys: Vec<String> = selection
        .residues
        .iter()
        .map(|residue| residue.key.to_string())
        .collect();
    assert_eq!(keys, ["A:1", "A:2", "A-2:1", "A-2:2"]);
    assert_eq!(selection.report.skipped["not in the assembly"], 5);
    let first = selection.residues[0].atoms[1].position;
    let expected = Vec3::new(10.0 - first.x, -first.y, first.z + 5.0);
    assert!((selection.residues[2].atoms[1].position - expected).norm() < 1e-9);
    // A mutation holds for every copy of the chain.
    mutate(&mut selection, &parse_mutations("A:K1E").unwrap()).unwrap();
    assert!(
        selection
            .residues
            .iter()
            .step_by(2)
            .all(|residue| &*residue.name == "GLU")
    );
    let types = body_types(&selection).unwrap();
    assert_eq!((types.len(), types[0].copies.len()), (1, 2));
    assert!((types[0].copies[1].pose.rotation.angle().to_degrees() - 180.0).abs() < 1e-6);
    let mirror = SelectionSettings {
        assembly: Some("2".into()),
        ..SelectionSettings::default()
    };
    let refused = Structure::read("test.pdb", text.as_bytes())
        .unwrap()
        .select(&mirror)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("determinant -1.0000"), "{refused}");
}

#[test]
fn a_pqr_brings_its_own_charges_and_radii() {
    let atom = |x: f64, charge_e: f64, residue_name: &str| PointRecord {
        position: Vec3::new(x, 0.0, 0.0),
        charge_e,
        radius_angstrom: 1.5,
        residue_name: residue_name.into(),
        ..PointRecord::default()
    };
    let sites = sites_of_points(&[
        atom(0.0, 0.25, "LYS"),
        atom(2.0, 0.5, "LYS"),
        atom(4.0, -0.125, ""),
    ])
    .unwrap();
    assert_eq!(
        (sites.origin_angstrom.x, sites.net_charge_e()),
        (2.0, 0.625)
    );
    assert_eq!(
        (
            sites.residues.len(),
            sites.residues[0].charge_e,
            sites.residues[0].hydropathy
        ),
        (1, 0.75, Some(-3.9))
    );
    assert_eq!(
        (sites.sites[2].residue, sites.sites[0].radius_angstrom),
        (None, 1.5)
    );
    assert!(sites_of_points(&[]).is_err());
}

#[test]
fn chains_without_names_are_not_taken_for_duplicates() {
    let chain = |y: f64| {
        let text = residue("ATOM", "ALA", "    1 ", 0) + &residue("ATOM", "ALA", "    2 ", 1);
        text.replace("   0.000  1.00", &format!("{y:8.3}  1.00"))
    };
    let selection = select(&(chain(0.0) + "TER\n" + &chain(20.0)));
    assert_eq!(
        (
            selection.report.atoms,
            selection.residues.len(),
            selection.report.repeated_numbers
        ),
        (20, 4, 0)
    );
    // Conformers one after the other are one residue all the same.
    let conformer = |code: char| {
        [("N", 0.0), ("CA", 1.0)]
            .map(|(name, y)| line("ATOM", name, code, "ALA", "A   1 ", [0.0, y, 0.0], 0.5))
            .concat()
    };
    let selection =
        select(&(conformer('A') + &residue("ATOM", "ALA", "A   2 ", 1) + &conformer('B')));
    assert_eq!(
        (
            selection.residues.len(),
            selection.report.skipped["alternate location"]
        ),
        (2, 2)
    );
}

#[test]
fn names_of_simulation_programs_are_understood() {
    let text = residue("ATOM", "ILE", "A   1 ", 0)
        + &atom("CD", "ILE", "A   1 ", [0.0, 0.0, 4.0])
        + &atom("OT2", "ILE", "A   1 ", [0.0, 0.0, 6.0]);
    let selection = select(&text);
    assert!(
        selection.residues[0].atom("CD1").is_some() && selection.residues[0].atom("OXT").is_some()
    );
}

/// Ends of a chain stay those of the file: what a range leaves out has no new termini.
#[test]
fn ranges_leave_out_residues_and_make_no_ends() {
    let mut text = String::new();
    for number in 1..=4 {
        text += &residue("ATOM", "ALA", &format!("A{number:4} "), number);
    }
    text += &residue("ATOM", "LYS", "B   7 ", 9);
    let in_ranges = |ranges: &[&str]| {
        let settings = SelectionSettings {
            residues: ranges.iter().map(|range| range.parse().unwrap()).collect(),
            ..SelectionSettings::default()
        };
        Structure::read("x.pdb", text.as_bytes())
            .unwrap()
            .select(&settings)
    };
    let kept = in_ranges(&["A:2-3"]).unwrap();
    let keys: Vec<String> = kept
        .residues
        .iter()
        .map(|residue| residue.key.to_string())
        .collect();
    assert_eq!(keys, ["A:2", "A:3", "B:7"]);
    assert!(
        kept.residues[..2]
            .iter()
            .all(|residue| !residue.n_terminus && !residue.c_terminus)
    );
    assert!(kept.report.skipped["outside the range"] > 0);
    assert_eq!(in_ranges(&["A:1", "A:4-"]).unwrap().residues.len(), 3);
    let refused = in_ranges(&["A:20-30"]).unwrap_err().to_string();
    assert!(refused.contains("no residue of A:20-30"), "{refused}");
}
