//! Damaged files: read or refused with a message, never a panic, a hang or an allocation out of
//! proportion. No test measures time: a hang is one that never ends, and a reader that takes more than
//! linear time shows in [`a_hundred_megabytes_are_read_or_refused`].

use crate::common::{bundled, bytes, many_structures};
use proptest::prelude::*;
use protomer_body::assembly::body_types;
use protomer_body::chemistry::{ChargeModel, SiteSettings, build_sites};
use protomer_body::structure::{SelectionSettings, Structure};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// Everything this crate does with a file.
fn digest(text: &[u8]) {
    let structure = match Structure::read("fuzz", text) {
        Ok(structure) => structure,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz:"), "{error}");
            return;
        }
    };
    let everything = SelectionSettings {
        keep_ligands: true,
        keep_waters: true,
        keep_hydrogens: true,
        keep_nucleic_acids: true,
        ..SelectionSettings::default()
    };
    let assembly = structure
        .assemblies
        .first()
        .map(|assembly| assembly.id.clone());
    let assembled = SelectionSettings {
        assembly,
        ..SelectionSettings::default()
    };
    for (settings, charges) in [
        (SelectionSettings::default(), ChargeModel::ForceField),
        (everything, ChargeModel::Formal),
        (assembled, ChargeModel::None),
    ] {
        let Ok(selection) = structure.select(&settings) else {
            continue;
        };
        assert!(
            selection
                .residues
                .iter()
                .all(|residue| !residue.atoms.is_empty())
        );
        let Ok(sites) = build_sites(
            &selection,
            &SiteSettings {
                ph: 7.4,
                charges,
                ..SiteSettings::default()
            },
        ) else {
            continue;
        };
        let sum: f64 = sites.residues.iter().map(|residue| residue.charge_e).sum();
        let scale = 1.0
            + sites
                .residues
                .iter()
                .map(|residue| residue.charge_e.abs())
                .sum::<f64>();
        assert!((sites.net_charge_e() - sum).abs() < 1e-9 * scale);
        body_types(&selection).unwrap();
    }
}

/// Text that means something to the readers.
const WORDS: [&str; 30] = [
    "ATOM  ",
    "HETATM",
    "MODEL",
    "ENDMDL",
    "TER",
    "REMARK 350   BIOMT1   1",
    "REMARK 465",
    "loop_",
    "_atom_site.id",
    "data_",
    "'",
    "\"",
    "\n;",
    ";",
    "\n",
    "\r\n",
    "?",
    ".",
    "(1-99999)",
    "(1,2)(3",
    "1e308",
    "NaN",
    "-",
    "A0000",
    "\u{e9}",
    "\0",
    "99999999999999999999",
    "_pdbx_struct_assembly_gen.oper_expression",
    "#",
    "   ",
];

/// A few edits: bytes changed, pieces cut, doubled, moved, words put in, the end cut off.
fn damage(original: &[u8], rng: &mut SmallRng) -> Vec<u8> {
    let mut text = original.to_vec();
    for _ in 0..rng.random_range(1..6) {
        if text.is_empty() {
            break;
        }
        let start = rng.random_range(0..text.len());
        let end = (start + rng.random_range(0..200)).min(text.len());
        match rng.random_range(0..8) {
            0 => text[start] = rng.random(),
            1 => {
                text[start] = *b" 0123456789.-ABCDH'\";_\n(),?"[..]
                    .get(rng.random_range(0..27))
                    .unwrap_or(&b' ')
            }
            2 => drop(text.drain(start..end)),
            3 => {
                let piece = text[start..end].to_vec();
                let to = rng.random_range(0..text.len());
                text.splice(to..to, piece);
            }
            4 => {
                let word = WORDS[rng.random_range(0..WORDS.len())].as_bytes();
                text.splice(start..start, word.iter().copied());
            }
            5 => {
                let word = WORDS[rng.random_range(0..WORDS.len())].as_bytes();
                let end = (start + word.len()).min(text.len());
                text.splice(start..end, word.iter().copied());
            }
            6 => text.truncate(start),
            _ => text[start..end].reverse(),
        }
    }
    text
}

/// Short excerpts of real files: the head, and a stretch of the middle.
fn seeds() -> Vec<Vec<u8>> {
    let mut seeds: Vec<Vec<u8>> = ["1bd2_short.pdb.gz", "1bd2_short.cif.gz"]
        .map(|name| bytes(&bundled(), name))
        .into();
    let mut excerpt = |whole: &[u8], keep: &dyn Fn(&str) -> bool, most: usize| {
        let text = String::from_utf8_lossy(whole);
        let lines: Vec<&str> = text.lines().filter(|line| keep(line)).take(most).collect();
        seeds.push(lines.join("\n").into_bytes());
    };
    let protease = bytes(&bundled(), "4e43.pdb.gz");
    let is_told = |line: &str| {
        line.starts_with("REMARK 350") || line.starts_with("CRYST1") || line.starts_with("ATOM")
    };
    excerpt(&protease, &is_told, 160);
    excerpt(
        &protease,
        &|line| line.starts_with("HETATM") || line.starts_with("TER"),
        60,
    );
    let bpti = bytes(&bundled(), "5pti.cif.gz");
    let text = String::from_utf8_lossy(&bpti).into_owned();
    let lines: Vec<&str> = text.lines().collect();
    let start = |prefix: &str| {
        lines
            .iter()
            .position(|line| line.starts_with(prefix))
            .unwrap_or(0)
    };
    let assembly = start("_pdbx_struct_assembly.id");
    let sites = start("_atom_site.group_PDB");
    let part: Vec<&str> = [
        &["data_5PTI"],
        &lines[assembly - 1..assembly + 40],
        &["#", "loop_"],
        &lines[sites..sites + 90],
    ]
    .concat();
    seeds.push(part.join("\n").into_bytes());
    seeds.iter().for_each(|seed| digest(seed));
    seeds
}

fn fuzz(inputs: u64, seeds: &[Vec<u8>], first: u64) {
    for number in first..first + inputs {
        let mut rng = SmallRng::seed_from_u64(number);
        let original = &seeds[rng.random_range(0..seeds.len())];
        digest(&damage(original, &mut rng));
    }
}

/// Short files of what programs for molecular dynamics, NMR and electrostatics write.
fn seeds_of_programs() -> Vec<Vec<u8>> {
    let mut pdb = String::from("REMARK 350 APPLY THE FOLLOWING TO CHAINS: NULL\n");
    pdb += "REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n";
    pdb += "REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000\n";
    pdb += "REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\nMODEL        1\n";
    let mut pqr = String::new();
    let mut serial = 99_990;
    for (number, residue) in ["NMET", "LYSH", "GLUP", "DISU", "HISE", "NME ", "ALA "]
        .iter()
        .enumerate()
    {
        for (name, y) in [
            ("N", 0.0),
            ("CA", 0.8),
            ("C", 1.5),
            ("O", 2.5),
            ("CB", -1.0),
            ("QB", -2.0),
        ] {
            let (x, record) = (3.8 * number as f64, "ATOM  ");
            let place = format!("{residue:<4}A{:>4}    ", number + 1);
            pdb += &format!(
                "{record}{serial:>5}  {name:<3} {place}{x:8.3}{y:8.3}   0.000  1.00  0.00      PROA\n"
            );
            pqr += &format!(
                "ATOM {serial} {name} {residue} A {number} {x:.3} {y:.3} 0.000 -0.25 1.70\n"
            );
            serial += 1;
        }
    }
    pdb += "TER\nHETATM  900 SOD  SOD A 301      60.000   0.000   0.000  1.00  1.00\n";
    pdb += "HETATM  901  CD  LYS A 302    9999.0009999.0009999.000  1.00  1.00\nENDMDL\nEND\n";
    let carriage_returns = pdb.replace('\n', "\r").into_bytes();
    let utf16: Vec<u8> = pdb.encode_utf16().flat_map(u16::to_be_bytes).collect();
    vec![pdb.into_bytes(), pqr.into_bytes(), carriage_returns, utf16]
}

#[test]
fn damaged_files_are_read_or_refused() {
    fuzz(2_000, &seeds(), 0);
}

#[test]
fn damaged_files_of_programs_are_read_or_refused() {
    fuzz(1_000, &seeds_of_programs(), 5_000_000);
}

#[test]
#[ignore = "a minute or more; run by name"]
fn forty_thousand_damaged_files_are_read_or_refused() {
    fuzz(25_000, &seeds(), 1_000_000);
    fuzz(15_000, &seeds_of_programs(), 2_000_000);
}

#[test]
#[ignore = "slow; needs PROTOMER_TEST_DATA: data/structures"]
fn damaged_whole_entries_are_read_or_refused() {
    let folder = many_structures();
    let names = [
        "1crn.pdb.gz",
        "1crn.cif.gz",
        "1en2.pdb.gz",
        "1stp.cif.gz",
        "1bc8.pdb.gz",
        "4qnb.pdb.gz",
        "weird_a_structure.pdb.gz",
    ];
    let seeds: Vec<Vec<u8>> = names.iter().map(|name| bytes(&folder, name)).collect();
    fuzz(5_000, &seeds, 9_000_000);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        digest(&bytes);
    }

    #[test]
    fn any_words_are_read_or_refused(words in prop::collection::vec(0..WORDS.len(), 0..60)) {
        let text: String = words.iter().map(|word| format!("{} ", WORDS[*word])).collect();
        digest(text.as_bytes());
        digest(format!("data_x\n{text}").as_bytes());
    }

    #[test]
    fn any_atom_line_is_read_or_refused(fields in prop::collection::vec("[ -~]{0,9}", 8)) {
        digest(format!("ATOM  {}", fields.concat()).as_bytes());
    }
}

/// A hundred megabytes of one thing or another.
#[test]
#[ignore = "reason: slow; run by name"]
fn a_hundred_megabytes_are_read_or_refused() {
    const SIZE: usize = 100 << 20;
    let line = "ATOM      1  CA  GLY A   1      11.104   6.134  -6.504  1.00 10.00           C\n";
    let row = "ATOM 1 C CA GLY A 1 11.104 6.134 -6.504\n";
    let head = "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.auth_atom_id\n\
                _atom_site.auth_comp_id\n_atom_site.auth_asym_id\n_atom_site.auth_seq_id\n_atom_site.Cartn_x\n\
                _atom_site.Cartn_y\n_atom_site.Cartn_z\n";
    let repeated = |head: &str, piece: &str| format!("{head}{}", piece.repeat(SIZE / piece.len()));
    let numbered = |head: &str, make: &dyn Fn(usize) -> String| {
        let mut text = head.to_string();
        let mut i = 0;
        while text.len() < SIZE {
            text.push_str(&make(i));
            i += 1;
        }
        text
    };
    let cases = [
        ("one atom over and over", repeated("", line)),
        ("one row over and over", repeated(head, row)),
        (
            "one residue of many atoms",
            numbered(head, &|i| {
                format!("ATOM 1 C C{i} GLY A 1 11.104 6.134 -6.504\n")
            }),
        ),
        (
            "many residues",
            numbered(head, &|i| {
                format!("ATOM 1 C CA CYS A {i} 11.104 6.134 {}\n", i % 1000)
            }),
        ),
        (
            "many sulphurs in one place",
            numbered(head, &|i| format!("ATOM 1 S SG CYS A {i} 11.104 6.134 1\n")),
        ),
        ("many models", repeated("", &format!("MODEL\n{line}"))),
        ("one line", repeated("", "ATOM  ")),
        ("semicolons", repeated("data_x\n_a.b\n;", "x;")),
        ("items", numbered("data_x\n", &|i| format!("_a.b{i} 1\n"))),
        (
            "remarks",
            repeated(
                "",
                "REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n",
            ),
        ),
        ("zeros", "\0".repeat(SIZE)),
        ("blanks", " ".repeat(SIZE)),
    ];
    for (what, text) in cases {
        let result = Structure::read("big", text.as_bytes());
        let outcome = match result {
            Ok(structure) => match structure.select(&SelectionSettings::default()) {
                Ok(selection) => match build_sites(&selection, &SiteSettings::default()) {
                    Ok(_) => format!("{} atoms", selection.report.atoms),
                    Err(error) => error.to_string(),
                },
                Err(error) => error.to_string(),
            },
            Err(error) => error.to_string(),
        };
        let outcome: String = outcome.chars().take(100).collect();
        println!("{what}: {outcome}");
    }
}
