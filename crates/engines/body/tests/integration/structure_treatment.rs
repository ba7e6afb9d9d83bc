//! How residues are treated that are not one of the twenty in the middle of a chain: disulfide
//! bonds, ends of chains, modified residues, ligands, traces.

use crate::small::{atom, line, residue, select, select_with};
use protomer_body::chemistry::{
    AminoAcid, ChargeModel, SiteSettings, build_sites, mutate, parse_mutations,
};
use protomer_body::structure::{
    DisulfideEvidence, MissingAtoms, ResidueClass, Selection, SelectionSettings, Structure,
};
use protomer_body::{BodySettings, Source, SurfaceSettings, build_body};

fn charge_e(selection: &Selection, ph: f64) -> f64 {
    let charges = ChargeModel::Formal;
    let sites = build_sites(
        selection,
        &SiteSettings {
            ph,
            charges,
            ..SiteSettings::default()
        },
    )
    .unwrap();
    sites.net_charge_e()
}

/// The classes of the selected residues by name.
fn classes(selection: &Selection) -> Vec<(&str, ResidueClass)> {
    let residues = selection.residues.iter();
    residues
        .map(|residue| (&*residue.name, residue.class))
        .collect()
}

/// A cysteine with its sulfur at height z above the chain.
fn cysteine(place: &str, i: usize, z: f64) -> String {
    let sulfur = [3.8 * i as f64, 2.5, z];
    residue("ATOM", "CYS", place, i) + &atom("SG", "CYS", place, sulfur)
}

/// An SSBOND record between chains and numbers, with the operators of both.
fn ssbond(first: (char, usize), second: (char, usize), operators: [&str; 2]) -> String {
    let [from, to] = operators;
    format!(
        "SSBOND   1 CYS {} {:>4}    CYS {} {:>4}                       {from:>6} {to:>6}\n",
        first.0, first.1, second.0, second.1
    )
}

const IDENTITY: [&str; 2] = ["1555", "1555"];

/// Two cysteines in one chain whose sulfurs are `distance` apart.
fn pair(distance: f64) -> String {
    let second = residue("ATOM", "CYS", "A   2 ", 1)
        + &atom("SG", "CYS", "A   2 ", [0.0, 2.5, 5.0 + distance]);
    cysteine("A   1 ", 0, 5.0) + &second
}

#[test]
fn a_recorded_bond_counts_however_long_it_is() {
    let record = ssbond(('A', 1), ('A', 2), IDENTITY);
    for distance in [2.05, 2.57, 2.79, 6.0] {
        let bonded = select(&format!("{record}{}", pair(distance)));
        let is_close = distance <= 2.5;
        let bond = &bonded.report.disulfides[0];
        assert_eq!(bonded.report.disulfides.len(), 1);
        assert!((bond.distance_angstrom.unwrap() - distance).abs() < 1e-9);
        let evidence = if is_close {
            DisulfideEvidence::RecordAndDistance
        } else {
            DisulfideEvidence::Record
        };
        assert_eq!(bond.evidence, evidence, "{distance}");
        // At pH 9 a free thiol carries half a charge.
        let free = select(&pair(if is_close { 9.0 } else { distance }));
        assert!((charge_e(&free, 9.0) - charge_e(&bonded, 9.0) + 1.0).abs() < 1e-9);
        assert!((charge_e(&bonded, 9.0) - charge_e(&select(&pair(2.0)), 9.0)).abs() < 1e-9);
    }
}

#[test]
fn the_records_of_both_formats_agree() {
    let pdb = format!("{}{}", ssbond(('A', 1), ('A', 2), IDENTITY), pair(2.7));
    let mut cif = String::from(
        "data_x\n_struct_conn.id d1\n_struct_conn.conn_type_id disulf\n\
         _struct_conn.ptnr1_auth_asym_id A\n_struct_conn.ptnr1_auth_seq_id 1\n\
         _struct_conn.ptnr1_symmetry 1_555\n\
         _struct_conn.ptnr2_auth_asym_id A\n_struct_conn.ptnr2_auth_seq_id 2\n\
         _struct_conn.ptnr2_symmetry 1_555\n\
         loop_\n_atom_site.group_PDB\n_atom_site.auth_atom_id\n_atom_site.auth_comp_id\n\
         _atom_site.auth_asym_id\n_atom_site.auth_seq_id\n_atom_site.Cartn_x\n\
         _atom_site.Cartn_y\n_atom_site.Cartn_z\n",
    );
    for atom in &Structure::read("x.pdb", pdb.as_bytes()).unwrap().models[0].atoms {
        let [x, y, z] = atom.position.into();
        let number = atom.residue_number;
        cif += &format!("ATOM {} CYS A {number} {x} {y} {z}\n", atom.name);
    }
    let of_pdb = select(&pdb);
    let of_cif = Structure::read("x.cif", cif.as_bytes())
        .unwrap()
        .select(&SelectionSettings::default())
        .unwrap();
    assert_eq!(of_pdb.report.disulfides, of_cif.report.disulfides);
    assert!(of_cif.residues.iter().all(|residue| residue.in_disulfide));
}

#[test]
fn a_bond_without_a_record_is_found_by_distance_and_reported() {
    let unrecorded = cysteine("A   4 ", 3, 20.0)
        + &residue("ATOM", "CYS", "A   5 ", 4)
        + &atom("SG", "CYS", "A   5 ", [11.4, 2.5, 22.0]);
    let text = ssbond(('A', 1), ('A', 2), IDENTITY) + &pair(2.04) + &unrecorded;
    let report = select(&text).report;
    assert_eq!(report.disulfides.len(), 2);
    assert_eq!(report.disulfides[1].evidence, DisulfideEvidence::Distance);
    let source = Source {
        file: "x.pdb",
        sha256: "",
    };
    let built = build_body("x", source, text.as_bytes(), &BodySettings::default()).unwrap();
    let warned = built
        .warnings
        .iter()
        .find(|text| text.contains("cysteines"));
    assert!(warned.unwrap().ends_with("A:4-A:5"), "{warned:?}");
}

#[test]
fn the_partner_may_be_in_another_chain_or_in_a_symmetry_copy() {
    let chains = ssbond(('A', 1), ('B', 2), IDENTITY)
        + &cysteine("A   1 ", 0, 5.0)
        + &residue("ATOM", "CYS", "B   2 ", 9)
        + &atom("SG", "CYS", "B   2 ", [0.0, 2.5, 7.05]);
    let only_a = SelectionSettings {
        chains: vec!["A".into()],
        ..SelectionSettings::default()
    };
    let alone = select_with(&chains, &only_a);
    assert!(alone.residues[0].in_disulfide);
    assert!(!alone.report.disulfides[0].partner_is_selected);
    assert!(select(&chains).report.disulfides[0].partner_is_selected);
    // The same cysteine of a symmetry copy: bonded to itself, across the axis.
    let symmetric =
        ssbond(('A', 1), ('A', 1), ["1555", "2655"]) + TURNED + &cysteine("A   1 ", 0, 5.0);
    let deposited = select(&symmetric);
    assert!(deposited.residues[0].in_disulfide);
    let bond = &deposited.report.disulfides[0];
    assert_eq!(
        (bond.partner_is_selected, bond.distance_angstrom),
        (false, None)
    );
    // The assembly contains the partner.
    let assembly = SelectionSettings {
        assembly: Some("1".into()),
        ..SelectionSettings::default()
    };
    let assembled = select_with(&symmetric, &assembly);
    assert!(
        assembled
            .residues
            .iter()
            .all(|residue| residue.in_disulfide)
    );
    let [bond] = assembled.report.disulfides.as_slice() else {
        panic!("{:?}", assembled.report.disulfides)
    };
    assert_eq!(bond.partner.to_string(), "A-2:1");
    assert!((bond.distance_angstrom.unwrap() - 2.7).abs() < 1e-9);
}

/// A half turn about an axis along x at y = 2.5, z = 6.35: a sulfur at (0, 2.5, 5) gets its image
/// at a distance of 2.7 Å.
const TURNED: &str = "\
REMARK 350 BIOMOLECULE: 1
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   2  0.000000 -1.000000  0.000000        5.00000
REMARK 350   BIOMT3   2  0.000000  0.000000 -1.000000       12.70000
";

#[test]
fn a_mutation_frees_the_partner_of_a_recorded_bond() {
    let text = ssbond(('A', 1), ('A', 2), IDENTITY) + &pair(2.79);
    let mut selection = select(&text);
    mutate(&mut selection, &parse_mutations("A:C1S").unwrap()).unwrap();
    assert!(
        selection
            .residues
            .iter()
            .all(|residue| !residue.in_disulfide)
    );
    assert!(selection.report.disulfides.is_empty());
}

/// Chain J of 1A2C, aeruginosin 298-A: a hydroxy acid that the file calls no amino acid, leucine, a
/// hydroxylated octahydroindole carboxylic acid, and argininol.
const AERUGINOSIN: &str = "\
HETATM 2413  O4  34H J   1      13.094 -17.697  23.835  1.00 31.86           O
HETATM 2422  C2  34H J   1      13.818 -18.307  22.736  1.00 32.06           C
HETATM 2423  C1  34H J   1      15.236 -17.781  22.754  1.00 32.42           C
HETATM 2424  O2  34H J   1      16.115 -18.127  21.955  1.00 33.11           O
ATOM   2425  N   LEU J   2      15.422 -16.873  23.701  1.00 33.67           N
ATOM   2426  CA  LEU J   2      16.566 -16.038  24.045  1.00 34.16           C
ATOM   2427  C   LEU J   2      16.445 -14.947  23.015  1.00 33.75           C
ATOM   2428  O   LEU J   2      15.451 -14.204  23.115  1.00 33.64           O
ATOM   2429  CB  LEU J   2      17.767 -16.950  24.218  1.00 35.33           C
ATOM   2430  CG  LEU J   2      17.658 -17.686  25.547  1.00 33.72           C
ATOM   2431  CD1 LEU J   2      18.588 -17.049  26.554  1.00 34.12           C
ATOM   2432  CD2 LEU J   2      16.243 -17.585  26.122  1.00 32.53           C
HETATM 2433  O   PRJ J   3      15.522 -13.947  19.768  1.00 35.93           O
HETATM 2434  N   PRJ J   3      17.262 -14.761  21.976  1.00 34.05           N
HETATM 2435  C   PRJ J   3      16.007 -13.108  20.529  1.00 34.79           C
HETATM 2436  CA  PRJ J   3      17.151 -13.511  21.311  1.00 34.56           C
HETATM 2437  CB  PRJ J   3      18.536 -13.275  20.659  1.00 34.43           C
HETATM 2438  CG  PRJ J   3      19.539 -14.175  21.363  1.00 34.37           C
HETATM 2443  CD  PRJ J   3      18.518 -15.334  21.587  1.00 34.90           C
HETATM 2444  O2  PRJ J   3      20.409 -17.461  20.107  1.00 36.25           O
HETATM 2445  O   OAR J   4      15.761 -11.052  17.937  1.00 33.76           O
HETATM 2446  N   OAR J   4      15.461 -11.891  20.571  1.00 33.49           N
HETATM 2447  NE  OAR J   4      11.498 -12.160  23.680  1.00 29.99           N
HETATM 2448  NH1 OAR J   4      10.367 -10.548  25.008  1.00 29.07           N
HETATM 2449  NH2 OAR J   4      10.157 -12.834  25.468  1.00 29.35           N
HETATM 2450  CA  OAR J   4      14.254 -11.607  19.907  1.00 33.28           C
HETATM 2451  CB  OAR J   4      13.209 -10.809  20.739  1.00 32.00           C
HETATM 2452  CG  OAR J   4      13.174 -11.783  21.908  1.00 30.27           C
HETATM 2453  CD  OAR J   4      12.218 -11.100  22.929  1.00 29.94           C
HETATM 2454  CZ  OAR J   4      10.674 -11.833  24.720  1.00 29.47           C
HETATM 2455  C   OAR J   4      14.551 -10.698  18.713  1.00 33.28           C
TER    2456      OAR J   4
";

#[test]
fn an_inhibitor_that_ends_in_argininol_carries_its_guanidinium_and_nothing_else() {
    let selection = select(AERUGINOSIN);
    let classes = classes(&selection);
    assert_eq!(classes[0].1, ResidueClass::AminoAcid(AminoAcid::Leu));
    assert_eq!(classes[1], ("PRJ", ResidueClass::UnknownAminoAcid));
    assert_eq!(
        classes[2],
        ("OAR", ResidueClass::LikeAminoAcid(AminoAcid::Arg))
    );
    // Neither the amide of the leucine nor the alcohol is the end of a chain.
    let blocked = &selection.report.blocked_ends;
    assert_eq!(blocked.len(), 1);
    assert_eq!(blocked[0].residue.to_string(), "J:2");
    assert_eq!(
        blocked[0].note,
        "no free amine: N is bonded to C1 of 34H J:1"
    );
    assert!((charge_e(&selection, 7.4) - 1.0).abs() < 1e-4);
    let source = Source {
        file: "x.pdb",
        sha256: "",
    };
    let text = AERUGINOSIN.as_bytes();
    let built = build_body("x", source, text, &BodySettings::default()).unwrap();
    let says = |part: &str| built.warnings.iter().any(|warning| warning.contains(part));
    assert!(says(
        "OAR J:4: in no table; has the heavy atoms of ARG, counted as ARG; +1.00 e"
    ));
    assert!(says(
        "PRJ J:3: in no table, side chain taken as neutral; +0.00 e"
    ));
    assert!(says("LEU J:2: no free amine"));
}

#[test]
fn a_ligand_of_bonded_parts_is_neither_protein_nor_nucleic_acid() {
    // As in 1A4W: arginine and ethylpiperidine of an inhibitor, after the TER of their chain.
    let chain = residue("ATOM", "ALA", "H   1 ", 0) + &residue("ATOM", "ALA", "H   2 ", 1);
    let inhibitor = residue("HETATM", "ARG", "H 350 ", 10)
        + &line("HETATM", "N1", ' ', "2EP", "H 375 ", [41.8, 0.0, 0.0], 1.0)
        + &line("HETATM", "C1'", ' ', "2EP", "H 375 ", [43.0, 0.8, 0.0], 1.0);
    let selection = select(&format!("{chain}TER\n{inhibitor}"));
    assert_eq!(selection.report.skipped["ligand"], 7);
    assert!(!selection.report.skipped.contains_key("nucleic acid"));
    assert_eq!(selection.residues.len(), 2);
    // As in 1PIN: a dipeptide after TER.
    let dipeptide =
        residue("HETATM", "ALA", "H 201 ", 10) + &residue("HETATM", "PRO", "H 202 ", 11);
    let selection = select(&format!("{chain}TER\n{dipeptide}"));
    assert_eq!(selection.report.skipped["ligand"], 10);
    assert!(selection.residues[1].c_terminus);
    // Inside a chain one atom of a sugar does not make a nucleotide either.
    let bonded = line("HETATM", "N1", ' ', "2EP", "H   3 ", [7.6, 0.0, 0.0], 1.0)
        + &line("HETATM", "C1'", ' ', "2EP", "H   3 ", [8.8, 0.8, 0.0], 1.0);
    let selection = select(&format!("{chain}{bonded}"));
    assert_eq!(selection.report.skipped["ligand"], 2);
    // Its carbonyl carbon is bonded, so the chain ends without a carboxylate.
    assert!(!selection.residues[1].c_terminus);
}

#[test]
fn a_residue_that_is_bonded_to_the_chain_after_ter_belongs_to_it() {
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + "TER\n"
        + &residue("HETATM", "MSE", "A   2 ", 1)
        + &residue("HETATM", "ALA", "A   3 ", 2);
    assert_eq!(select(&text).residues.len(), 3);
}

#[test]
fn d_amino_acids_have_the_charges_of_their_mirror_images() {
    let names = [
        ("DAR", 1.0),
        ("DLY", 0.999),
        ("DAS", -1.0),
        ("DGL", -0.999),
        ("DHI", 0.112),
        ("DCY", -0.0245),
        ("DTY", -0.0025),
        ("DAL", 0.0),
        ("ORN", 1.0),
        ("SEC", -0.993),
        ("LLP", -1.941),
    ];
    for (name, expected) in names {
        let text = residue("ATOM", "ALA", "A   1 ", 0)
            + &residue("HETATM", name, "A   2 ", 1)
            + &residue("ATOM", "ALA", "A   3 ", 2);
        let ends = residue("ATOM", "ALA", "A   1 ", 0) + &residue("ATOM", "ALA", "A   3 ", 1);
        let charge = charge_e(&select(&text), 7.4) - charge_e(&select(&ends), 7.4);
        assert!((charge - expected).abs() < 2e-3, "{name} {charge}");
    }
}

#[test]
fn the_report_says_how_each_unusual_residue_was_treated() {
    let text = residue("ATOM", "ALA", "A   1 ", 0)
        + &residue("HETATM", "SEP", "A   2 ", 1)
        + &residue("HETATM", "CSO", "A   3 ", 2)
        + &residue("HETATM", "DAR", "A   4 ", 3)
        + &residue("ATOM", "ALA", "A   5 ", 4)
        + "TER\n"
        + &line("HETATM", "ZN", ' ', " ZN", "A 301 ", [9.0; 3], 1.0);
    let settings = BodySettings {
        selection: SelectionSettings {
            keep_ligands: true,
            ..SelectionSettings::default()
        },
        surface: SurfaceSettings {
            density_per_angstrom2: 0.3,
            ..SurfaceSettings::default()
        },
        ..BodySettings::default()
    };
    let source = Source {
        file: "x.pdb",
        sha256: "",
    };
    let built = build_body("x", source, text.as_bytes(), &settings).unwrap();
    let expected = [
        "SEP A:2: phosphoserine: hydropathy of SER, own groups of pKa 1.0 (acid), 5.6 (acid); \
         -1.98 e",
        "CSO A:3: S-hydroxycysteine: hydropathy of CYS, side chain taken as neutral; +0.00 e",
        "DAR A:4: D-arginine, counted as ARG; +1.00 e",
        "ZN (1 kept): ligand, +2 e by its name",
    ];
    for text in expected {
        let is_said = built.warnings.iter().any(|warning| warning == text);
        assert!(is_said, "{text}: {:#?}", built.warnings);
    }
    let report = serde_json::to_value(built.selection.unwrap()).unwrap();
    assert_eq!(report["ligands"][0]["charge_e"], 2.0);
}

#[test]
fn formal_charges_of_the_file_count_for_residues_in_no_table() {
    let charged = residue("HETATM", "XYZ", "A   2 ", 1)
        + "HETATM    6  NX  XYZ A   2       5.000   5.000   0.000  1.00  0.00           N1+\n";
    let text =
        residue("ATOM", "ALA", "A   1 ", 0) + &charged + &residue("ATOM", "ALA", "A   3 ", 2);
    let selection = select(&text);
    let note = &selection.report.unknown[0].note;
    assert!(note.contains("+1 e as the file states"), "{note}");
    let ends = residue("ATOM", "ALA", "A   1 ", 0) + &residue("ATOM", "ALA", "A   3 ", 1);
    let change = charge_e(&selection, 7.4) - charge_e(&select(&ends), 7.4);
    assert!((change - 1.0).abs() < 1e-9, "{change}");
}

#[test]
fn acylated_nitrogens_are_not_amines() {
    // A formyl group on the nitrogen, in a residue that no table knows.
    let formyl = residue("HETATM", "XFM", "A   1 ", 0)
        + &line("HETATM", "CN", ' ', "XFM", "A   1 ", [-0.9, -1.0, 0.0], 1.0)
        + &line(
            "HETATM",
            "O1",
            ' ',
            "XFM",
            "A   1 ",
            [-0.5, -2.15, 0.0],
            1.0,
        );
    let text = formyl + &residue("ATOM", "ALA", "A   2 ", 1);
    assert!(!select(&text).residues[0].n_terminus);
    // Without the oxygen it is a secondary amine.
    let without: String = text
        .lines()
        .filter(|line| !line.contains(" O1 "))
        .fold(String::new(), |text, line| text + line + "\n");
    assert!(select(&without).residues[0].n_terminus);
}

#[test]
fn a_residue_that_is_skipped_leaves_no_end_behind() {
    let whole = residue("ATOM", "ALA", "A   1 ", 0)
        + &residue("ATOM", "LYS", "A   2 ", 1)
        + &residue("ATOM", "ALA", "A   3 ", 2);
    let incomplete_first = whole.replace("ALA A   1", "LEU A   1");
    let settings = SelectionSettings {
        missing: MissingAtoms::Skip,
        ..SelectionSettings::default()
    };
    let selection = select_with(&incomplete_first, &settings);
    assert_eq!(selection.residues.len(), 1);
    assert!(!selection.residues[0].n_terminus && selection.residues[0].c_terminus);
}

#[test]
fn a_trace_of_carbons_is_refused() {
    let trace: String = (1..=5)
        .map(|i| {
            let place = format!("A{i:>4} ");
            atom("CA", "ALA", &place, [3.8 * f64::from(i), 0.0, 0.0])
        })
        .collect();
    let refused = build_sites(&select(&trace), &SiteSettings::default()).unwrap_err();
    assert!(
        refused.to_string().contains("only the Cα atoms"),
        "{refused}"
    );
    // One more atom makes it a structure with missing atoms.
    let with_nitrogen = trace + &atom("N", "ALA", "A   5 ", [18.0, 1.0, 0.0]);
    assert!(build_sites(&select(&with_nitrogen), &SiteSettings::default()).is_ok());
}

#[test]
fn a_body_needs_a_name() {
    let text = residue("ATOM", "ALA", "A   1 ", 0);
    let source = Source {
        file: "x.pdb",
        sha256: "",
    };
    for name in ["", "  "] {
        let refused = build_body(name, source, text.as_bytes(), &BodySettings::default());
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("name of the body is empty"), "{message}");
    }
}
