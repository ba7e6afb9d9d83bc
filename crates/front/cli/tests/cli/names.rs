//! Names from outside: those that could become something else are refused at every door, and what is
//! allowed stays a name in tables, scripts, pages and folders.

use crate::common::{TemporaryFolder, contents, is_ok, message, program};
use protomer_kernel::name::is_forbidden;
use protomer_protein_verbs::bodies::body_file;
use std::collections::BTreeSet;
use std::process::Output;

/// Allowed in a name, and dangerous where it is not written as one.
const HOSTILE: &str = "=HYPERLINK(\"http://x\");</script><!-- 'a' \\";
/// Refused: a line of a script, a bell, an escape sequence, a change of direction.
const REFUSED: [&str; 4] = ["a\nopen x", "a\u{7}", "a\u{1b}[2J", "a\u{202e}b"];

/// Runs the program with arguments that may hold blanks.
fn run(place: &TemporaryFolder, arguments: &[&str]) -> Output {
    let mut command = program(arguments);
    command.current_dir(place.path("")).output().unwrap()
}

fn is_refused(output: &Output, name: &str) {
    let said = message(output);
    assert_eq!(output.status.code(), Some(1), "{name:?}: {said}");
    assert!(
        said.contains("the character U+") || said.contains("control character"),
        "{said}"
    );
    // Nor does the message itself command the terminal.
    let commands = |character: char| is_forbidden(character) && character != '\n';
    assert!(!said.contains(commands), "{said:?}");
}

/// An mmCIF file with a chain of this name, which may run over lines.
fn mmcif(chain: &str) -> String {
    mmcif_chains(&[&format!("\n;{chain}\n;\n")])
}

/// Residues by which chains differ, so that none is a copy of another.
const RESIDUES: [&str; 11] = [
    "GLY", "ALA", "SER", "VAL", "LEU", "ILE", "THR", "PRO", "CYS", "MET", "PHE",
];

/// An mmCIF file with chains of these names, written as they are given: quotes are part of the format.
fn mmcif_chains(chains: &[&str]) -> String {
    let columns = "group_PDB id type_symbol label_atom_id label_alt_id label_comp_id label_asym_id \
                   label_entity_id label_seq_id auth_seq_id auth_asym_id Cartn_x Cartn_y Cartn_z \
                   occupancy B_iso_or_equiv pdbx_PDB_model_num";
    let mut text = "data_x\nloop_\n".to_owned();
    for column in columns.split_whitespace() {
        text += &format!("_atom_site.{column}\n");
    }
    let atoms = [
        ("N", 0.0, 0.0),
        ("CA", 1.46, 0.7),
        ("C", 2.0, 1.4),
        ("O", 1.4, 2.1),
    ];
    let mut serial = 0;
    for (place, (chain, kind)) in (0..).zip(chains.iter().zip(RESIDUES)) {
        for residue in 1..4 {
            for (name, x, y) in atoms {
                serial += 1;
                let (x, y) = (x + 3.8 * f64::from(residue), y + 20.0 * f64::from(place));
                text += &format!(
                    "ATOM {serial} {} {name} . {kind} A 1 {residue} {residue} {chain} {x:.3} {y:.3} 0.0 1.0 0.0 1\n",
                    &name[..1]
                );
            }
        }
    }
    text
}

#[test]
fn names_that_could_become_something_else_are_refused_at_every_door() {
    let place = TemporaryFolder::new();
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    let (mut body, _) = body_file::read(&place.path("a.body")).unwrap();
    for name in REFUSED {
        let own = ["body", "--mesh", "cube.off", "-o", "x.body", "--name", name];
        is_refused(&run(&place, &own), name);
        assert!(!place.path("x.body").exists());

        write("chain.cif", &mmcif(name));
        let ingest = ["ingest", "chain.cif", "-o", "bodies", "--density", "0.5"];
        is_refused(&run(&place, &ingest), name);
        write("one.cif", &mmcif("A"));
        let named = ["ingest", "one.cif", "-o", "bodies", "--name", name];
        is_refused(&run(&place, &named), name);

        // A body file of another program.
        name.clone_into(&mut body.name);
        body_file::write(&place.path("forged.body"), &body).unwrap();
        is_refused(
            &run(&place, &["export", "forged.body", "-o", "x.cif"]),
            name,
        );

        let ring = std::fs::read_to_string(place.path("ring.json")).unwrap();
        let quoted = serde_json::to_string(name).unwrap();
        write("forged.json", &ring.replace("\"a\"", &quoted));
        is_refused(&run(&place, &["inspect", "forged.json"]), name);

        let label = name.replace('\n', "\r");
        write(
            "set.csv",
            &format!("file,label,cluster\none.cif,\"{label}x\",a\n"),
        );
        let voxels = ["voxelize", "--manifest", "set.csv", "-o", "set.zarr"];
        is_refused(&run(&place, &voxels), name);
    }
    write(
        "a.pqr",
        "ATOM 1 CA\u{1b} ALA A 1 0.0 0.0 0.0 0.5 1.7\nATOM 2 CB ALA A 1 1.5 0.0 0.0 0.5 1.7\n",
    );
    is_refused(&run(&place, &["ingest", "a.pqr", "-o", "bodies"]), "CA");
    let outside = run(
        &place,
        &["ingest", "one.cif", "-o", "bodies", "--name", "../x"],
    );
    assert!(
        message(&outside).contains("not a path"),
        "{}",
        message(&outside)
    );
    assert!(!place.path("x.body").exists());
}

/// The cells of a line of RFC 4180.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut is_quoted) = (vec![String::new()], false);
    for character in line.chars() {
        match character {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => cells.last_mut().unwrap().push(character),
        }
    }
    assert!(!is_quoted, "{line}");
    cells
}

/// Every cell of a table on one line, and none a formula.
fn is_plain_table(name: &str, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).unwrap();
    let count = cells(text.lines().next().unwrap()).len();
    for line in text.lines() {
        let cells = cells(line);
        assert_eq!(cells.len(), count, "{name}: {line}");
        let is_number = |cell: &str| cell == "-" || cell.parse::<f64>().is_ok();
        let formula = |cell: &&String| cell.starts_with(['=', '+', '-', '@']) && !is_number(cell);
        assert_eq!(cells.iter().find(formula), None, "{name}: {line}");
    }
}

/// Only the commands that scripts are made of, one a line.
fn is_plain_script(name: &str, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).unwrap();
    const COMMANDS: [&str; 20] = [
        "#",
        "open",
        "hide",
        "cartoon",
        "surface",
        "color",
        "graphics",
        "lighting",
        "view",
        "load",
        "create",
        "set_color",
        "delete",
        "show",
        "spectrum",
        "bg_color",
        "orient",
        "set",
        "camera",
        "transparency",
    ];
    for line in text.lines() {
        let command = line.split(' ').next().unwrap();
        assert!(COMMANDS.contains(&command), "{name}: {line}");
        assert!(
            !line.contains(';') && !line.ends_with('\\'),
            "{name}: {line}"
        );
    }
}

/// Every script element ends where the page ends it, and holds no other.
fn is_plain_page(name: &str, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).unwrap();
    assert_eq!(
        text.matches("<script").count(),
        text.matches("</script>").count(),
        "{name}"
    );
    for part in text.split("<script").skip(1) {
        let script = part.split("</script>").next().unwrap();
        assert!(!script.contains("<!--"), "{name}");
    }
    assert!(
        !text.contains("HYPERLINK(\"http://x\");</script>"),
        "{name}"
    );
}

#[test]
fn a_hostile_name_stays_a_name_wherever_it_is_written() {
    let place = TemporaryFolder::new();
    for (number, chain) in ["../../x", "/etc/x"].into_iter().enumerate() {
        std::fs::write(place.path(&format!("p{number}.cif")), mmcif(chain)).unwrap();
        let structure = format!("p{number}.cif");
        let folder = format!("p{number}");
        let assembled = run(
            &place,
            &[
                "assemble",
                "structure",
                &structure,
                "-o",
                &folder,
                "--density",
                "0.5",
                "-q",
            ],
        );
        is_ok(&assembled);
        let written = contents(&place.path(&folder));
        assert!(
            written.keys().any(|name| name.ends_with(".body")),
            "{:?}",
            written.keys()
        );
    }
    let atoms = [
        "ingest",
        "p0.cif",
        "-o",
        ".",
        "--density",
        "0.5",
        "-q",
        "--name",
        "peptide",
    ];
    is_ok(&run(&place, &atoms));
    let (mut body, _) = body_file::read(&place.path("peptide.body")).unwrap();
    HOSTILE.clone_into(&mut body.name);
    for residue in &mut body.residues {
        HOSTILE.clone_into(&mut residue.chain);
    }
    body_file::write(&place.path("hostile.body"), &body).unwrap();
    let name = serde_json::to_string(HOSTILE).unwrap();
    let placed = |x: f64| {
        format!(
            "{{\"body\": {name}, \"position_angstrom\": [{x}, 0, 0], \"orientation_wxyz\": [1, 0, 0, 0]}}"
        )
    };
    let assembly = format!(
        "{{\"box_angstrom\": [90, 90, 90], \"bodies\": [{{\"name\": {name}, \"file\": \"hostile.body\"}}], \
         \"placements\": [{}, {}]}}",
        placed(-12.0),
        placed(12.0)
    );
    std::fs::write(place.path("two.json"), assembly).unwrap();
    for command in [
        "sweep two.json --salt 50mM,300mM --energy direct --replicas 1 --equilibration 5 --sweeps 20 \
         --trajectory-every 5 -q -o run",
        "residues run --script chimerax -q",
        "reweight run -q -o run/reweighting",
        "scattering run -q -o run/scattering",
        "pair hostile.body hostile.body --salt 100mM --relative-error 0.5 --interaction bare -q -o pair",
        "report run -q",
        "report pair -q",
        "export two.json -o chimerax.cif --script chimerax -q",
        "export two.json -o pymol.cif --script pymol -q",
        "export two.json -o two.pdb -q",
        "inspect two.json",
    ] {
        is_ok(&place.run(command));
    }
    let mut seen = [0; 3];
    for (file, bytes) in contents(&place.path("")) {
        match file.rsplit('.').next() {
            Some("csv") => {
                is_plain_table(&file, &bytes);
                seen[0] += 1;
            }
            Some("cxc" | "pml") => {
                is_plain_script(&file, &bytes);
                seen[1] += 1;
            }
            Some("html") => {
                is_plain_page(&file, &bytes);
                seen[2] += 1;
            }
            _ => {}
        }
    }
    assert!(seen[0] >= 6 && seen[1] >= 3 && seen[2] == 2, "{seen:?}");
    // The structure files are read back.
    for file in ["chimerax.cif", "two.pdb"] {
        let again = run(
            &place,
            &["ingest", file, "-o", "again", "--density", "0.5", "-q"],
        );
        assert!(
            !message(&again).contains("error"),
            "{file}: {}",
            message(&again)
        );
    }
    let named = ["export", "two.json", "-o", "a;b.cif", "--script", "pymol"];
    let refused = message(&run(&place, &named));
    assert!(refused.contains("cannot name the file"), "{refused}");
}

/// Names of chains as mmCIF writes them, and as they are.
fn difficult_chains() -> Vec<(String, String)> {
    let mut chains: Vec<(String, String)> = [
        ("'a/b'", "a/b"),
        ("'a:b'", "a:b"),
        ("\"a_b_2\"", "a_b_2"),
        ("A", "A"),
        ("a", "a"),
        ("\"it's\"", "it's"),
        ("'say \"A\"'", "say \"A\""),
        ("a'b", "a'b"),
        ("\"=1+1\"", "=1+1"),
    ]
    .map(|(written, name)| (written.to_owned(), name.to_owned()))
    .into();
    for end in ["1", "2"] {
        let long = "x".repeat(300) + end;
        chains.push((long.clone(), long));
    }
    chains
}

#[test]
fn chains_of_any_name_get_files_of_their_own() {
    let place = TemporaryFolder::new();
    let chains = difficult_chains();
    let written: Vec<&str> = chains.iter().map(|(written, _)| written.as_str()).collect();
    std::fs::write(place.path("all.cif"), mmcif_chains(&written)).unwrap();
    is_ok(&place.run("assemble structure all.cif -o all --density 0.5 -q"));
    // Each chain has its file, also where capital and small letters are the same.
    let (mut files, mut found) = (BTreeSet::new(), BTreeSet::new());
    for file in contents(&place.path("all")).into_keys() {
        if !file.ends_with(".body") {
            continue;
        }
        let (body, _) = body_file::read(&place.path("all").join(&file)).unwrap();
        found.insert(body.residues[0].chain.clone());
        files.insert(file.to_lowercase());
    }
    let expected: BTreeSet<String> = chains.into_iter().map(|(_, name)| name).collect();
    assert_eq!(found, expected);
    assert_eq!(files.len(), expected.len(), "{files:?}");
    assert!(files.iter().all(|file| file.len() < 230), "{files:?}");
    for command in [
        "inspect all/assembly.json",
        "residues all/assembly.json --salt 100mM -o residues -q",
        "export all/assembly.json -o all.pdb --script pymol -q",
        "export all/assembly.json -o again.cif --script chimerax -q",
    ] {
        is_ok(&place.run(command));
    }
    for table in ["residues.csv", "residue_pairs.csv"] {
        is_plain_table(
            table,
            &std::fs::read(place.path("residues").join(table)).unwrap(),
        );
    }
    for script in ["all.pml", "again.cxc"] {
        is_plain_script(script, &std::fs::read(place.path(script)).unwrap());
    }
    let atoms = ["all.pdb", "again.cif"].map(|file| {
        let bytes = std::fs::read(place.path(file)).unwrap();
        protomer_body::structure::Structure::read(file, &bytes)
            .unwrap()
            .models[0]
            .atoms
            .len()
    });
    assert_eq!(atoms, [12 * expected.len(); 2]);
    let long = "x".repeat(300);
    let named = ["ingest", "all.cif", "-o", "named", "--name", &long];
    let refused = message(&run(&place, &named));
    assert!(refused.contains("300 bytes"), "{refused}");
}
