//! Placed bodies are written as PDB and mmCIF, and read back.

use crate::common::{bundled, many_structures, read};
use proptest::prelude::*;
use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::write::{PlacedBodies, PlacedBody, has_atoms};
use protomer_body::structure::{Atom, Ending, SelectionSettings, Structure};
use protomer_body::{Body, Provenance, Residue, Site};
use protomer_kernel::{Pose, TriangleMesh, Vec3};
use std::collections::BTreeMap;

/// A body of these atoms; its mesh does not matter here.
fn body(name: &str, sites: Vec<Site>, residues: Vec<Residue>, origin: Vec3) -> Body {
    Body {
        residues,
        provenance: Provenance {
            source: format!("{name}.pdb"),
            origin_angstrom: origin,
            ..Provenance::default()
        },
        ..Body::of_mesh(name, TriangleMesh::tetrahedron(1.0), sites).unwrap()
    }
}

fn body_of(name: &str, structure: &Structure, settings: &SelectionSettings) -> Body {
    let selection = structure.select(settings).unwrap();
    let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
    body(name, sites.sites, sites.residues, sites.origin_angstrom)
}

/// A body of one residue for each entry: chain, number, insertion code, name, atoms.
fn small(residues: &[(&str, i32, &str, &str, &[&str])]) -> Body {
    let (mut sites, mut of_body) = (Vec::new(), Vec::new());
    for (index, (chain, number, code, name, atoms)) in residues.iter().enumerate() {
        for (place, atom) in atoms.iter().enumerate() {
            sites.push(Site {
                position: Vec3::new(4.0 * index as f64, 1.4 * place as f64, 0.5),
                charge_e: 0.0,
                radius_angstrom: 1.7,
                atom_name: (*atom).into(),
                residue: Some(index as u32),
            });
        }
        of_body.push(Residue {
            chain: (*chain).into(),
            number: *number,
            insertion_code: (*code).into(),
            name: (*name).into(),
            charge_e: 0.0,
            hydropathy: None,
        });
    }
    body("small", sites, of_body, Vec3::zeros())
}

fn placed<'a>(bodies: &[(&'a Body, Pose)]) -> PlacedBodies<'a> {
    let copies = bodies
        .iter()
        .map(|(body, pose)| PlacedBody::new(body, *pose));
    PlacedBodies {
        title: "a test of writing".into(),
        copies: copies.collect(),
        box_angstrom: None,
    }
}

fn read_text(name: &str, text: &str) -> Structure {
    let structure = Structure::read(name, text.as_bytes()).unwrap();
    assert_eq!(structure.warnings.messages, [""; 0], "{name}");
    assert_eq!(structure.models.len(), 1);
    structure
}

/// Both files, read again.
fn both(bodies: &PlacedBodies) -> [Structure; 2] {
    let pdb = read_text("written.pdb", &bodies.to_pdb().unwrap());
    assert_eq!(pdb.ending, Ending::Whole);
    [pdb, read_text("written.cif", &bodies.to_mmcif().unwrap())]
}

/// What identifies an atom.
type Key = (String, i32, String, String, String);

fn key(chain: &str, number: i32, code: &str, residue: &str, atom: &str) -> Key {
    let own = str::to_owned;
    (own(chain), number, own(code), own(residue), own(atom))
}

/// The atoms of placed bodies by their key in a file with these chains.
fn expected(bodies: &PlacedBodies, is_pdb: bool) -> BTreeMap<Key, Vec3> {
    let chains = match is_pdb {
        true => bodies.chains_of_pdb().unwrap(),
        false => bodies.chains_of_mmcif(),
    };
    let mut atoms = BTreeMap::new();
    for (number, copy) in bodies.copies.iter().enumerate() {
        for site in &copy.body.sites {
            let residue = &copy.body.residues[site.residue.unwrap() as usize];
            let chain = chains
                .iter()
                .find(|chain| chain.copy == number && chain.source_chain == residue.chain)
                .unwrap();
            let key = key(
                &chain.chain,
                residue.number,
                &residue.insertion_code,
                &residue.name,
                &site.atom_name,
            );
            let position = copy.pose.transform_point(&site.position);
            assert!(
                atoms.insert(key, position).is_none(),
                "an atom occurs twice"
            );
        }
    }
    atoms
}

fn found(structure: &Structure) -> BTreeMap<Key, Vec3> {
    let atom = |atom: &Atom| {
        let key = key(
            &atom.chain,
            atom.residue_number,
            &atom.insertion_code,
            &atom.residue_name,
            &atom.name,
        );
        (key, atom.position)
    };
    structure.models[0].atoms.iter().map(atom).collect()
}

fn require_round_trip(bodies: &PlacedBodies) {
    for (structure, is_pdb) in both(bodies).iter().zip([true, false]) {
        let (found, expected) = (found(structure), expected(bodies, is_pdb));
        assert_eq!(structure.models[0].atoms.len(), expected.len());
        assert!(found.keys().eq(expected.keys()));
        for (place, wanted) in found.values().zip(expected.values()) {
            assert!((place - wanted).amax() < 0.000_501, "{place} {wanted}");
        }
        for (number, atom) in structure.models[0].atoms.iter().enumerate() {
            assert_eq!((atom.occupancy, atom.alternate), (1.0, None));
            assert!(is_pdb || atom.serial == number as i64 + 1);
        }
    }
}

fn far() -> Pose {
    Pose::from_wxyz(Vec3::new(60.0, -35.5, 12.25), [0.3, -0.4, 0.8, 0.33])
}

fn with_everything() -> SelectionSettings {
    SelectionSettings {
        keep_ligands: true,
        keep_waters: true,
        keep_hydrogens: true,
        keep_nucleic_acids: true,
        ..SelectionSettings::default()
    }
}

#[test]
fn bundled_structures_survive() {
    for name in ["5pti.cif.gz", "4e43.pdb.gz", "1bd2_short.pdb.gz"] {
        for settings in [SelectionSettings::default(), with_everything()] {
            let body = body_of(name, &read(&bundled(), name), &settings);
            let turned = Pose::from_wxyz(Vec3::new(3.0, 2.0, 1.0), [0.5, 0.5, -0.5, 0.5]);
            require_round_trip(&placed(&[(&body, Pose::identity()), (&body, turned)]));
        }
    }
}

#[test]
fn selections_of_written_files_are_those_of_the_source() {
    for name in ["5pti.cif.gz", "4e43.pdb.gz"] {
        let structure = read(&bundled(), name);
        let source = body_of(name, &structure, &SelectionSettings::default());
        for written in both(&placed(&[(&source, Pose::identity())])) {
            let again = body_of(name, &written, &SelectionSettings::default());
            let is_close = |a: f64, b: f64| (a - b).abs() < 1e-9;
            assert_eq!(again.residues.len(), source.residues.len());
            for (a, b) in again.residues.iter().zip(&source.residues) {
                assert_eq!((&a.name, a.number), (&b.name, b.number));
                assert!(
                    is_close(a.charge_e, b.charge_e),
                    "{name} {} {}",
                    a.name,
                    a.number
                );
            }
            assert!(
                is_close(again.net_charge_e(), source.net_charge_e()),
                "{name}"
            );
        }
    }
}

/// The elements of the archive against those that are derived from names and radii, on every
/// structure at hand.
#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn elements_are_those_of_the_archive() {
    let folder = many_structures();
    let (mut atoms, mut wrong) = (
        0,
        BTreeMap::<(String, String, String, String), usize>::new(),
    );
    for name in [
        "1aye.pdb.gz",
        "1bc8.pdb.gz",
        "1ema.cif.gz",
        "1kx5.pdb.gz",
        "1lz1.pdb.gz",
        "1ncb.cif.gz",
        "1stp.cif.gz",
        "2lzm.pdb.gz",
        "4d0a.cif.gz",
        "4hhb.cif.gz",
        "4oyn.pdb.gz",
        "4qnb.pdb.gz",
        "4xow_prepared.pdb.gz",
        "6msm.pdb.gz",
    ] {
        if !folder.join(name).is_file() {
            continue;
        }
        let structure = read(&folder, name);
        let selection = structure.select(&with_everything()).unwrap();
        let elements = selection.residues.iter().flat_map(|residue| &residue.atoms);
        let elements: Vec<&str> = elements.map(|atom| &*atom.element).collect();
        let source = body_of(name, &structure, &with_everything());
        let placed = placed(&[(&source, Pose::identity())]);
        let written = read_text("written.cif", &placed.to_mmcif().unwrap());
        // Chains may be written in another order than residues are stored.
        let of_key: BTreeMap<Key, &str> = {
            let chains = placed.chains_of_mmcif();
            let new = |old: &str| {
                &chains
                    .iter()
                    .find(|chain| chain.source_chain == old)
                    .unwrap()
                    .chain
            };
            let sites = source.sites.iter().zip(&elements);
            sites
                .map(|(site, element)| {
                    let residue = &source.residues[site.residue.unwrap() as usize];
                    let (chain, code) = (new(&residue.chain), &residue.insertion_code);
                    let key = key(chain, residue.number, code, &residue.name, &site.atom_name);
                    (key, *element)
                })
                .collect()
        };
        for atom in &written.models[0].atoms {
            let (chain, code) = (&atom.chain, &atom.insertion_code);
            let key = key(
                chain,
                atom.residue_number,
                code,
                &atom.residue_name,
                &atom.name,
            );
            atoms += 1;
            let truth = of_key[&key];
            if truth != &*atom.element {
                let elements = format!("{truth} {}", atom.element);
                let case = (name.into(), key.3, key.4, elements);
                *wrong.entry(case).or_default() += 1;
            }
        }
    }
    assert!(
        atoms > 10_000 && wrong.is_empty(),
        "{atoms} atoms, {wrong:?}"
    );
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: data/structures"]
fn many_structures_survive() {
    let folder = many_structures();
    // Insertion codes, DNA, haem, chromophores.
    for name in ["1aye.pdb.gz", "1kx5.pdb.gz", "4hhb.cif.gz", "1ema.cif.gz"] {
        let settings = SelectionSettings {
            keep_ligands: true,
            keep_nucleic_acids: true,
            ..SelectionSettings::default()
        };
        let body = body_of(name, &read(&folder, name), &settings);
        require_round_trip(&placed(&[(&body, Pose::identity()), (&body, far())]));
    }
}

#[test]
fn numbers_codes_and_names_of_every_kind_survive() {
    let body = small(&[
        ("A", -5, "", "MET", &["N", "CA", "C", "O"]),
        ("A", 52, "", "SER", &["N", "CA", "C", "O", "OG"]),
        ("A", 52, "A", "GLY", &["N", "CA", "C"]),
        ("A", 52, "B", "MSE", &["N", "CA", "C", "SE"]),
        ("B-2", 9999, "", "DA", &["P", "O5'", "C5'", "H5''"]),
        ("B-2", -999, "", "ATP", &["PA", "O2A", "C1'"]),
        ("", 1, "", "CA", &["CA"]),
        ("", 2, "", "HOH", &["O"]),
        ("", 3, "", "HOH", &["O"]),
        ("A", 300, "", "NA", &["NA"]),
    ]);
    let copies = placed(&[
        (&body, Pose::identity()),
        (&body, far()),
        (&body, far().inverse()),
    ]);
    require_round_trip(&copies);
    let [pdb, mmcif] = both(&copies);
    for structure in [&pdb, &mmcif] {
        let lines = |residue: &str, name: &str| {
            let atoms = structure.models[0].atoms.iter();
            let mut atoms =
                atoms.filter(|atom| &*atom.residue_name == residue && &*atom.name == name);
            atoms.next().unwrap().clone()
        };
        assert!(!lines("SER", "CA").hetero && !lines("DA", "P").hetero);
        assert!(lines("MSE", "SE").hetero && !lines("MSE", "SE").outside_polymer);
        for (residue, name) in [("ATP", "PA"), ("NA", "NA")] {
            assert!(lines(residue, name).hetero && lines(residue, name).outside_polymer);
        }
        assert_eq!(
            (&*lines("CA", "CA").element, &*lines("SER", "CA").element),
            ("CA", "C")
        );
        assert_eq!(
            (&*lines("MSE", "SE").element, &*lines("ATP", "PA").element),
            ("SE", "P")
        );
    }
    // One chain per copy and source chain; each ligand has its own label in mmCIF.
    let chains = copies.chains_of_pdb().unwrap();
    assert_eq!(chains.len(), 9);
    let described: Vec<(&str, usize, &str)> = chains
        .iter()
        .map(|chain| (&*chain.chain, chain.copy, &*chain.source_chain))
        .collect();
    assert_eq!(
        described[..4],
        [("A", 0, "A"), ("B", 0, "B-2"), ("C", 0, ""), ("D", 1, "A")]
    );
    let label = |residue: &str, number: i32| {
        let mut atoms = mmcif.models[0].atoms.iter();
        let atom =
            atoms.find(|atom| &*atom.residue_name == residue && atom.residue_number == number);
        atom.unwrap().label_chain.to_string()
    };
    assert_eq!(label("MET", -5), "A");
    assert_ne!(label("CA", 1), label("HOH", 2));
    assert_eq!(label("HOH", 2), label("HOH", 3));
}

#[test]
fn many_chains_need_mmcif() {
    let body = small(&[("A", 1, "", "GLY", &["N", "CA", "C"])]);
    let copies: Vec<(&Body, Pose)> = (0..62)
        .map(|number| {
            let position = Vec3::new(0.0, 0.0, 10.0 * f64::from(number));
            (
                &body,
                Pose {
                    position,
                    ..Pose::identity()
                },
            )
        })
        .collect();
    let full = placed(&copies);
    require_round_trip(&full);
    let last = full.chains_of_pdb().unwrap().pop().unwrap();
    assert_eq!((&*last.chain, last.copy), ("9", 61));
    let mut more = copies.clone();
    more.extend((0..700).map(|_| (&body, far())));
    let more = placed(&more);
    let message = more.to_pdb().unwrap_err().to_string();
    assert_eq!(
        message,
        "762 chains, and a PDB file has identifiers for 62; write mmCIF instead"
    );
    let written = read_text("written.cif", &more.to_mmcif().unwrap());
    assert_eq!(written.models[0].atoms.len(), 3 * 762);
    assert_eq!(&*written.models[0].atoms[3 * 761].chain, "ACH");
}

#[test]
fn what_does_not_fit_a_pdb_file_is_refused() {
    let gly = |number| small(&[("A", number, "", "GLY", &["N", "CA"])]);
    let shifted = |x| Pose {
        position: Vec3::new(x, 0.0, 0.0),
        ..Pose::identity()
    };
    let cases = [
        (gly(1), shifted(10_000.0), "10000.000"),
        (gly(1), shifted(-1001.0), "-1001.000"),
        (gly(10_000), shifted(0.0), "GLY A:10000"),
        (small(&[("A", 1, "", "GLYX", &["N"])]), shifted(0.0), "GLYX"),
        (
            small(&[("A", 1, "", "GLY", &["H12'3"])]),
            shifted(0.0),
            "H12'3",
        ),
    ];
    for (body, pose, named) in &cases {
        let placed = placed(&[(body, *pose)]);
        let message = placed.to_pdb().unwrap_err().to_string();
        assert!(
            message.contains(named) && message.ends_with("write mmCIF instead"),
            "{message}"
        );
        read_text("written.cif", &placed.to_mmcif().unwrap());
    }
    let atoms: Vec<String> = (0..10).map(|number| format!("C{number}")).collect();
    let atoms: Vec<&str> = atoms.iter().map(String::as_str).collect();
    let residues: Vec<_> = (0..1000)
        .map(|number| ("A", number, "", "LIG", &*atoms))
        .collect();
    let large = small(&residues);
    let copies = vec![(&large, Pose::identity()); 10];
    let message = placed(&copies).to_pdb().unwrap_err().to_string();
    assert!(
        message.contains("99999") && message.contains("mmCIF"),
        "{message}"
    );
}

#[test]
fn bodies_without_atoms_and_bad_values_are_refused() {
    let mut points = small(&[("A", 1, "", "GLY", &["N"])]);
    points.residues.clear();
    points.sites[0].residue = None;
    assert!(!has_atoms(&points));
    let placed_points = placed(&[(&points, Pose::identity())]);
    for error in [
        placed_points.to_pdb().unwrap_err(),
        placed_points.to_mmcif().unwrap_err(),
    ] {
        let message = error.to_string();
        assert!(
            message.contains("'small' has no atoms") && message.contains("ingest"),
            "{message}"
        );
    }
    let body = small(&[("A", 1, "", "GLY", &["N"]), ("A", 2, "", "GLY", &["N"])]);
    let with = |values: &[f64]| {
        let mut placed = placed(&[(&body, Pose::identity())]);
        placed.copies[0].residue_values = values.to_vec();
        placed.to_pdb().map(|text| read_text("x.pdb", &text))
    };
    let found = with(&[-12.345, 7.0]).unwrap();
    let factors = found.models[0]
        .atoms
        .iter()
        .map(|atom| atom.b_factor_angstrom2);
    assert_eq!(factors.collect::<Vec<_>>(), [-12.35, 7.0]);
    for (values, named) in [
        (&[1.0][..], "2 residues, but 1"),
        (&[1.0, f64::NAN][..], "A:2 of body 'small' is NaN"),
        (&[1.0, -1000.0][..], "-1000.00 of residue A:2"),
    ] {
        let message = with(values).unwrap_err().to_string();
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn the_table_tells_how_the_source_was_moved() {
    let mut body = small(&[("X", 1, "", "GLY", &["N", "CA"])]);
    body.provenance.origin_angstrom = Vec3::new(10.0, 20.0, 30.0);
    body.provenance
        .settings
        .insert("mutations".into(), "X:K1G".into());
    let placed = placed(&[(&body, Pose::identity()), (&body, far())]);
    let text = placed.to_pdb().unwrap();
    assert!(text.lines().all(|line| line.len() == 80));
    assert!(text.contains("REMARK   6 CHAIN B COPY 1 SOURCE CHAIN X BODY small"));
    assert!(text.contains("NEW NAMES ON THE ATOMS OF THE SOURCE: X:K1G"));
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter_map(|line| line.split_once("   MATRIX"))
        .map(|(_, row)| {
            row.split_whitespace()
                .skip(1)
                .map(|x| x.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 6);
    // The matrix of the second copy moves the atoms of the source to where they are written.
    let atom = &body.sites[1];
    let in_source = atom.position + body.provenance.origin_angstrom;
    let wanted = far().transform_point(&atom.position);
    for (row, wanted) in rows[3..].iter().zip(wanted.iter()) {
        let coordinate =
            row[0] * in_source.x + row[1] * in_source.y + row[2] * in_source.z + row[3];
        assert!((coordinate - wanted).abs() < 1e-4);
    }
    let mmcif = placed.to_mmcif().unwrap();
    assert!(mmcif.contains("_protomer_copy.matrix[1][1]") && mmcif.contains("\nB 1 X\n"));
}

#[test]
fn the_box_and_the_title_are_read_back() {
    let body = small(&[("A", 1, "", "GLY", &["N", "CA"])]);
    let mut placed = placed(&[(&body, Pose::identity())]);
    placed.box_angstrom = Some([320.0, 100.5, 80.25]);
    placed.title = "a ring: it's \"one\" of four, with a title that is longer than one line of a file in the old format".into();
    for structure in both(&placed) {
        let cell = structure.header.cell.unwrap();
        assert_eq!(cell.lengths_angstrom, [320.0, 100.5, 80.25]);
        assert_eq!(cell.angles_degree, [90.0; 3]);
        assert_eq!(structure.header.space_group.as_deref(), Some("P 1"));
        assert_eq!(structure.header.title, placed.title);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any names, numbers and poses that fit survive both formats.
    #[test]
    fn any_body_survives(
        residues in proptest::collection::btree_map(
            ("[A-Za-z0-9]{0,2}", -999..10_000_i32, "[A-Z]?"),
            ("[A-Z0-9]{1,3}", proptest::collection::btree_set("[A-Z][A-Z0-9'\"*]{0,3}", 1..6)),
            1..20,
        ),
        copies in 1..3_usize,
        angles in proptest::array::uniform4(-1.0..1.0_f64),
        at in proptest::array::uniform3(-900.0..900.0_f64),
    ) {
        prop_assume!(angles.iter().map(|x| x * x).sum::<f64>() > 0.1);
        let names: Vec<(_, _, Vec<&str>)> = residues
            .iter()
            .map(|(key, (name, atoms))| (key, name, atoms.iter().map(String::as_str).collect()))
            .collect();
        let rows: Vec<_> = names
            .iter()
            .map(|((chain, number, code), name, atoms)| {
                (chain.as_str(), *number, code.as_str(), name.as_str(), atoms.as_slice())
            })
            .collect();
        let body = small(&rows);
        let pose = Pose::from_wxyz(Vec3::from(at), angles);
        let bodies = placed(&vec![(&body, pose); copies]);
        require_round_trip(&bodies);
    }
}
