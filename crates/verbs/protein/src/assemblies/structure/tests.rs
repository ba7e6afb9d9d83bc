use super::*;
use crate::assemblies::assembly_file::AssemblyFile;
use protomer_common::answer::Answer;

fn settings() -> StructureSettings {
    StructureSettings {
        body: BodySettings::default(),
        joined: Vec::new(),
        shapes: CopyShapes::Fitting,
        relax: true,
        box_angstrom: None,
        force: false,
    }
}

/// A lysine (without the end of its side chain where `is_whole` is false), then a gap, then an
/// alanine, in a chain at a height z.
fn chain(chain: char, z: f64, is_whole: bool) -> String {
    let lysine = [
        ("N", 0.0, 0.0),
        ("CA", 1.46, 0.0),
        ("C", 2.0, 1.4),
        ("O", 1.2, 2.4),
        ("CB", 2.0, -1.4),
        ("CG", 3.5, -1.4),
        ("CD", 4.0, -2.8),
        ("CE", 5.5, -2.8),
        ("NZ", 6.0, -4.2),
    ];
    let atoms = if is_whole { 9 } else { 6 };
    let alanine = lysine[..5]
        .iter()
        .map(|(name, x, y)| ("ALA", 5, *name, x + 9.0, *y));
    let lysine = lysine[..atoms]
        .iter()
        .map(|(name, x, y)| ("LYS", 1, *name, *x, *y));
    let mut text = String::new();
    for (residue, number, name, x, y) in lysine.chain(alanine) {
        let element = &name[..1];
        text += &format!(
            "ATOM      1  {name:<3} {residue} {chain}{number:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {element:>2}\n"
        );
    }
    text
}

/// Two nucleotides of three atoms each.
fn adenosines(chain: char) -> String {
    let mut text = String::new();
    for number in 1..=2 {
        for (name, element, x) in [("P", "P", 0.0), ("O5'", "O", 1.6), ("C5'", "C", 3.0)] {
            let x = x + 6.0 * f64::from(number);
            text += &format!(
                "ATOM      1  {name:<3}  DA {chain}{number:4}    {x:8.3}{:8.3}{:8.3}  1.00  0.00          {element:>2}\n",
                40.0, 40.0
            );
        }
    }
    text
}

/// Everything that `ingest` says of the file is said, and what each body is like.
#[test]
fn a_structure_is_taken_apart_with_all_that_ingest_says_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("two.pdb");
    let water = "HETATM    1  O   HOH A 101      30.000  30.000  30.000  1.00  0.00           O\n";
    let haem = "HETATM    1 FE   HEM A 100      20.000  20.000  20.000  1.00  0.00          FE\n";
    let text = chain('A', 0.0, true) + &chain('B', 15.0, false) + &adenosines('I') + haem + water;
    std::fs::write(&input, text).unwrap();
    let settings = settings();
    let made = assemble_structure(
        std::slice::from_ref(&input),
        &folder.path().join("out"),
        &settings,
    )
    .unwrap();
    let said = made.warnings().join("\n");
    let body = crate::bodies::ingest::read_and_build(&input, "two", &settings.body).unwrap();
    let of_surface = |warning: &&String| warning.contains("surface");
    for warning in body.warnings.iter().filter(|warning| !of_surface(warning)) {
        assert!(said.contains(warning), "{warning}\n{said}");
    }
    for wanted in [
        "ligands of chain A left out: 1 HEM; --keep-ligands keeps them",
        "nucleic acids of chain I left out: 2 DA; --keep-nucleic-acids keeps them",
        "chain break between A:1 and A:5",
        "LYS B:1 lacks CD, CE, NZ",
    ] {
        assert_eq!(said.matches(wanted).count(), 1, "{wanted}\n{said}");
    }
    let json = serde_json::to_value(&made).unwrap();
    let skipped = serde_json::json!({"ligand": 1, "nucleic acid": 6, "water": 1});
    assert_eq!(json["skipped"], skipped);
    let left_out = &json["selection"]["skipped_residues"];
    assert_eq!(left_out["ligand"]["names"]["HEM"], 1);
    assert_eq!(left_out["nucleic acid"]["chains"][0], "I");
    let words = "left out: 1 ligand, 6 nucleic acid, 1 water";
    assert!(made.text().contains(words), "{}", made.text());
    let charges_e = made.bodies.iter().map(|of_kind| {
        let copies = u32::try_from(of_kind.chains.len()).unwrap();
        f64::from(copies) * of_kind.measures.net_charge_e
    });
    let difference_e = charges_e.sum::<f64>() - body.body.net_charge_e();
    assert!(difference_e.abs() < 1e-9, "{difference_e}");
    let listed = json["structure_warnings"].as_array().unwrap();
    assert!(
        listed
            .iter()
            .any(|line| line.as_str().unwrap().contains("1 HEM"))
    );
}

#[test]
fn side_chains_that_lack_atoms_at_an_interface_are_named() {
    let warnings = |z, is_whole| {
        let text = chain('A', 0.0, true) + &chain('B', z, is_whole);
        made(&[text], &settings()).unwrap().0.warnings().join("\n")
    };
    let wanted = "missing there: LYS B:1; rebuild the side chains";
    assert!(warnings(4.0, false).contains(wanted));
    assert!(!warnings(4.0, true).contains("rebuild"));
    assert!(!warnings(15.0, false).contains("rebuild"));
}

/// A strand of four nucleotides with the ring nitrogens that pair, 3.4 Å apart along z.
fn strand(chain: char, residue: &str, pairing: &str, x: f64) -> String {
    let ring = if pairing == "N1" { "N9" } else { "N1" };
    let outwards = x.signum() * 4.0;
    let nucleotide = |number: i32| {
        let z = 3.4 * f64::from(number);
        atom(pairing, residue, chain, number, [x, 0.0, z])
            + &atom(ring, residue, chain, number, [x + outwards, 0.0, z])
    };
    (1..=4).map(nucleotide).collect()
}

#[test]
fn strands_of_a_duplex_are_a_proposal_with_their_flag() {
    let mut settings = settings();
    settings.body.selection.keep_nucleic_acids = true;
    let paired = strand('I', " DA", "N1", -1.45) + &strand('J', " DT", "N3", 1.45);
    let (duplex, _) = made(&[paired], &settings).unwrap();
    assert_eq!(
        duplex.proposals,
        ["I and J belong together, by 4 base pairs; --body I,J makes them one body"]
    );
    let equal = strand('I', " DA", "N1", -1.45) + &strand('J', " DA", "N1", 1.45);
    let (equal, _) = made(&[equal], &settings).unwrap();
    assert!(equal.proposals.is_empty(), "{:?}", equal.proposals);
}

/// A line of an atom.
fn atom(name: &str, residue: &str, chain: char, number: i32, [x, y, z]: [f64; 3]) -> String {
    let element = &name[..1];
    format!(
        "ATOM      1  {name:<3} {residue} {chain}{number:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {element:>2}\n"
    )
}

/// A row of carbons along x, as one residue each, that begins at a place.
fn row(chain: char, [x, y, z]: [f64; 3]) -> String {
    let atoms = (0..4).map(|k| atom("C", "GLY", chain, k + 1, [x + 1.5 * f64::from(k), y, z]));
    atoms.collect()
}

/// Assembles a structure from texts, one file each.
fn made(
    texts: &[String],
    settings: &StructureSettings,
) -> Result<(StructureAssembly, AssemblyFile)> {
    let folder = tempfile::tempdir()?;
    let mut files = Vec::new();
    for (number, text) in texts.iter().enumerate() {
        let path = folder.path().join(format!("part{number}.pdb"));
        std::fs::write(&path, text)?;
        files.push(path);
    }
    let made = assemble_structure(&files, &folder.path().join("out"), settings)?;
    let assembly = serde_json::from_slice(&std::fs::read(&made.assembly)?)?;
    Ok((made, assembly))
}

fn message(texts: &[String], settings: &StructureSettings) -> String {
    format!("{:#}", made(texts, settings).unwrap_err())
}

#[test]
fn two_files_in_one_frame_are_two_bodies_where_they_are() {
    let (made, assembly) = made(
        &[row('A', [0.0; 3]), row('A', [1.0, 3.8, 0.0])],
        &settings(),
    )
    .unwrap();
    assert_eq!(made.placed, ["part0", "part1"]);
    let apart = |axis: usize| {
        let [a, b] = [0, 1].map(|place| assembly.placements[place].position_angstrom[axis]);
        b - a
    };
    assert!((apart(0) - 1.0).abs() < 1e-9 && (apart(1) - 3.8).abs() < 1e-9);
    assert_eq!(made.native_contacts_kept, Some(1.0));
    assert!(made.proposed_box_angstrom > 20.0);
}

#[test]
fn files_in_different_frames_are_said() {
    let far = made(
        &[row('A', [0.0; 3]), row('B', [0.0, 30.0, 0.0])],
        &settings(),
    )
    .unwrap()
    .0;
    let said = far.warnings().join("\n");
    assert!(
        said.contains("30.0 Å away") && said.contains("superpose"),
        "{said}"
    );
    assert_eq!(far.native_contacts_kept, None);
    let same = message(
        &[row('A', [0.0; 3]), row('B', [0.2, 0.0, 0.0])],
        &settings(),
    );
    assert!(
        same.contains("4 atoms of part0 and part1 lie in the same places"),
        "{same}"
    );
}

#[test]
fn chains_are_joined_as_stated_and_the_others_are_bodies_of_their_own() {
    let text = row('H', [0.0; 3]) + &row('L', [0.0, 4.0, 0.0]) + &row('A', [0.0, 8.0, 0.0]);
    let joined = StructureSettings {
        joined: vec!["H,L".parse().unwrap()],
        ..settings()
    };
    let (joined, _) = made(&[text], &joined).unwrap();
    assert_eq!(joined.placed, ["H,L", "A"]);
    let atoms: Vec<usize> = joined
        .bodies
        .iter()
        .map(|body| body.measures.atoms)
        .collect();
    assert_eq!(atoms, [8, 4]);
}

#[test]
fn a_disulfide_bond_is_a_proposal_with_its_flag() {
    let text = row('H', [0.0; 3])
        + &atom("SG", "CYS", 'H', 9, [0.0, 2.5, 0.0])
        + &row('L', [0.0, 7.0, 0.0])
        + &atom("SG", "CYS", 'L', 9, [0.0, 4.5, 0.0]);
    let (bonded, _) = made(std::slice::from_ref(&text), &settings()).unwrap();
    assert_eq!(
        bonded.proposals,
        [
            "H and L belong together, by the disulfide bond H:9 - L:9; --body H,L makes them one body"
        ]
    );
    assert!(
        bonded
            .moved_angstrom
            .iter()
            .all(|displacement| *displacement > 0.1 && *displacement < 0.6)
    );
    let strict = StructureSettings {
        relax: false,
        ..settings()
    };
    let said = message(&[text], &strict);
    assert!(
        said.contains("overlap: H-L") && said.contains("--body H,L"),
        "{said}"
    );
}

/// A chain in a row whose middle atom stands this high, with an atom at its side.
fn arch(chain: char, height: f64, y: f64) -> String {
    let places = [0.0, 0.0, height, 0.0, 0.0].into_iter().enumerate();
    let row: String = places
        .map(|(k, z)| atom("C", "GLY", chain, k as i32 + 1, [1.5 * k as f64, y, z]))
        .collect();
    row + &atom("C", "GLY", chain, 6, [3.0, y + 3.0, 0.0])
}

/// The middle atom of B lies elsewhere than that of A, and near the place where A has it is C.
#[test]
fn a_copy_keeps_its_own_shape_where_the_shared_one_would_overlap() {
    let text =
        arch('A', 3.0, 0.0) + &arch('B', 0.0, 20.0) + &atom("C", "ALA", 'C', 1, [3.0, 20.0, 3.5]);
    let (fitting, _) = made(std::slice::from_ref(&text), &settings()).unwrap();
    let [shape] = &fitting.own_shapes[..] else {
        panic!("{:?}", fitting.own_shapes);
    };
    assert_eq!(
        (&*shape.copy, &shape.would_overlap[..]),
        ("B", &["C".to_owned()][..])
    );
    assert!(
        fitting
            .text()
            .contains("B keeps its own shape: with that of A")
    );
    assert_eq!(fitting.bodies.len(), 3);
    assert!(
        fitting
            .moved_angstrom
            .iter()
            .all(|displacement| *displacement == 0.0)
    );
    let shared = StructureSettings {
        shapes: CopyShapes::Shared,
        relax: false,
        ..settings()
    };
    let said = message(&[text], &shared);
    assert!(said.contains("B-C; leave out --shapes shared"), "{said}");
}

/// A copy that is bent away from its partner, which the shape of the reference would not touch.
#[test]
fn a_copy_keeps_its_own_shape_where_the_shared_one_would_lose_contacts() {
    let text =
        arch('A', 0.0, 0.0) + &arch('B', 3.0, 20.0) + &atom("C", "ALA", 'C', 1, [3.0, 20.0, 7.0]);
    let (fitting, _) = made(std::slice::from_ref(&text), &settings()).unwrap();
    assert_eq!(fitting.native_contacts_kept, Some(1.0));
    let [shape] = &fitting.own_shapes[..] else {
        panic!("{:?}", fitting.own_shapes);
    };
    assert_eq!((&*shape.copy, shape.would_lose_contacts), ("B", 1));
    let shared = StructureSettings {
        shapes: CopyShapes::Shared,
        ..settings()
    };
    let (shared, _) = made(&[text], &shared).unwrap();
    assert_eq!(shared.native_contacts_kept, Some(0.0));
}
