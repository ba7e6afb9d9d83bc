//! Structures that are damaged, cut or of other kinds.

use super::{Place, bundled, peptide, settings};
use crate::common::program;
use protomer_learn::SampleSource;
use protomer_learn_verbs::voxels::merge::merge;
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_learn_verbs::voxels::structure::Reason;
use protomer_learn_verbs::voxels::{Spacing, VoxelizeSettings};
use protomer_results::Shard;
use std::path::PathBuf;

#[test]
fn a_damaged_file_is_named_with_its_samples() {
    let place = Place::new();
    place.make("a.zarr", Shard::WHOLE, &settings());
    let file = place.path("a.zarr/potential/c/0");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let message = VoxelSet::open(&place.path("a.zarr"))
        .unwrap()
        .voxels(1)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("a.zarr/potential/c/0") && message.contains("one to three"),
        "{message}"
    );
}

#[test]
fn a_structure_that_was_cut_in_half_is_never_a_silent_sample() {
    let place = Place::new();
    let settings = VoxelizeSettings {
        size: 48,
        spacing: Spacing::Angstrom(2.0),
        ..settings()
    };
    let mut files = Vec::new();
    for ((zipped, whole), ending) in [
        (bundled("4e43.pdb.gz"), "pdb"),
        (bundled("5pti.cif.gz"), "cif"),
    ] {
        let first = whole.find("\nATOM ").unwrap() + 1;
        let last = whole.rfind("\nHETATM").unwrap();
        let after_a_line = |start: usize| start + whole[start..].find('\n').unwrap() + 1;
        let middle = after_a_line((first + last) / 2);
        let mut cuts: Vec<usize> = (1..=5)
            .map(|part| first + part * (last - first) / 6)
            .collect();
        // Between two lines, with and without the end of the one before, and at each place of the
        // next line.
        cuts.extend([middle - 1, middle]);
        cuts.extend(
            (1..after_a_line(middle) - middle)
                .step_by(3)
                .map(|within| middle + within),
        );
        for cut in cuts {
            let name = format!("cut{cut}.{ending}");
            std::fs::write(place.path(&name), &whole[..cut]).unwrap();
            files.push(name);
        }
        for part in [1, 2, 3] {
            let name = format!("zipped{part}{ending}.{ending}.gz");
            std::fs::write(place.path(&name), &zipped[..part * zipped.len() / 4]).unwrap();
            files.push(name);
        }
    }
    place.list(&files);
    let report = place.make("a.zarr", Shard::WHOLE, &settings);
    assert_eq!(
        (report.samples, report.excluded.len()),
        (0, files.len()),
        "{:?}",
        report.warnings
    );
    let count = |reason| {
        report
            .excluded
            .iter()
            .filter(|excluded| excluded.reason == reason)
            .count()
    };
    assert!(
        count(Reason::Truncated) > 5 && count(Reason::Unreadable) > 5,
        "{:?}",
        report.excluded
    );
    assert_eq!(
        count(Reason::Truncated) + count(Reason::Unreadable),
        files.len()
    );
    let zipped = report
        .excluded
        .iter()
        .filter(|excluded| excluded.row.file.ends_with(".gz"));
    assert!(
        zipped.clone().count() == 6
            && zipped
                .clone()
                .all(|excluded| excluded.detail.contains("damaged or truncated"))
    );
}

#[test]
fn a_file_by_hand_without_an_end_is_a_sample_with_a_warning() {
    let place = Place::new();
    let whole = peptide(["ALA"; 5], 1.7);
    let atoms = whole.strip_suffix("END\n").unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    write("bare.pdb", atoms);
    write("open.pdb", atoms.trim_end());
    write("whole.pdb", &whole);
    write("within.pdb", &atoms[..atoms.len() - 40]);
    write("digits.pdb", &atoms[..atoms.len() - 28]);
    let pqr: String = atoms
        .lines()
        .map(|line| format!("{}  {:>8.4} {:>7.4}\n", &line[..54], 0.1, 1.7))
        .collect();
    write("bare.pqr", &pqr);
    write("within.pqr", pqr.strip_suffix("00\n").unwrap());
    write(
        "set.csv",
        "file,label,cluster,name\nbare.pdb,x,,bare\nopen.pdb,x,,open\nwhole.pdb,x,,whole\nwithin.pdb,x,,within\n\
                      digits.pdb,x,,digits\nbare.pqr,x,,pqr\nwithin.pqr,x,,within_pqr\n",
    );
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    let reasons: Vec<(&str, Reason)> = report
        .excluded
        .iter()
        .map(|e| (e.row.name.as_str(), e.reason))
        .collect();
    let [within, digits] = [
        ("within", Reason::Unreadable),
        ("digits", Reason::Truncated),
    ];
    assert_eq!(
        reasons,
        [within, digits, ("within_pqr", Reason::Truncated)],
        "{:?}",
        report.excluded
    );
    let warned: Vec<&str> = report.warnings.keys().map(String::as_str).collect();
    assert_eq!(warned, ["bare", "open", "pqr"]);
    assert!(
        report
            .warnings
            .values()
            .all(|warnings| warnings[0].contains("no mark of its end")),
        "{:?}",
        report.warnings
    );
}

#[test]
fn nucleotides_are_no_amino_acids() {
    let place = Place::new();
    let line = |number: usize, name: &str| {
        format!(
            "ATOM {number} P {name} {number} {}.0 0.0 0.0 -1.0 1.9\n",
            3 * number
        )
    };
    let rna: String = ["A", "C", "G", "A"]
        .iter()
        .enumerate()
        .map(|(number, name)| line(number + 1, name))
        .collect();
    std::fs::write(place.path("rna.pqr"), format!("{rna}END\n")).unwrap();
    std::fs::write(
        place.path("mixed.pqr"),
        format!("\u{feff}{rna}{}END\n", line(5, "ALA")),
    )
    .unwrap();
    place.list(&["rna.pqr".into(), "mixed.pqr".into()]);
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        (report.samples, report.excluded[0].reason),
        (1, Reason::NoProtein),
        "{:?}",
        report.excluded
    );
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    assert_eq!(
        (
            set.descriptions()[0].residues,
            set.descriptions()[0].composition[0]
        ),
        (1.0, 1.0)
    );
}

#[test]
fn relatives_in_several_clusters_are_told() {
    let place = Place::new();
    std::fs::copy(place.path("one.pdb"), place.path("copy.pdb")).unwrap();
    std::fs::write(
        place.path("set.csv"),
        "file,label,cluster,family\none.pdb,x,a,\ncopy.pdb,x,b,\ntwo.pdb,y,c,f\nthree.pdb,y,d,f\n",
    )
    .unwrap();
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        report.manifest_warnings.len(),
        2,
        "{:?}",
        report.manifest_warnings
    );
    let said = report.manifest_warnings.join("\n");
    assert!(
        said.contains("'one' and 'copy'") && said.contains("the family 'f'"),
        "{said}"
    );
    // Parts that each have one of them do not see it; where they meet it is seen.
    let parts: Vec<PathBuf> = (1..=2)
        .map(|index| {
            place.make(
                &format!("{index}.zarr"),
                Shard { index, of: 2 },
                &settings(),
            )
        })
        .inspect(|part| assert_eq!(part.manifest_warnings, [""; 0]))
        .map(|part| part.set)
        .collect();
    assert_eq!(
        merge(&parts, &place.path("b.zarr"), false)
            .unwrap()
            .manifest_warnings,
        report.manifest_warnings
    );
    let output = place.run("voxelize --manifest set.csv -o c.zarr --size 32 --channels shape");
    assert_eq!(output.status.code(), Some(0));
    assert!(
        String::from_utf8_lossy(&output.stderr)
            .contains("warning: 'one' and 'copy' are in different clusters")
    );
}

#[test]
fn a_run_without_a_single_sample_has_failed() {
    let place = Place::new();
    place.list(&["broken.pdb".into(), "missing.pdb".into()]);
    for words in ["-q", "--json -q"] {
        let output = place.run(&format!(
            "voxelize --manifest set.csv -o a.zarr --size 32 --channels shape {words}"
        ));
        assert_eq!(output.status.code(), Some(1), "{words}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(
            said.contains("none of the 2 structures could be used") && said.contains("'excluded'"),
            "{said}"
        );
    }
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    assert_eq!(
        set.reader().attributes()["excluded"]
            .as_array()
            .unwrap()
            .len(),
        2,
        "the report is there"
    );
    // A part may be without samples; all parts together may not.
    for part in [1, 2] {
        let words = format!(
            "voxelize --manifest set.csv -o {part}.zarr --shard {part}/2 --size 32 --channels shape -q"
        );
        assert_eq!(place.run(&words).status.code(), Some(0));
    }
    let output = place.run("merge 1.zarr 2.zarr -o b.zarr -q");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("has no samples"));
}

/// The exit code on request, where structures are left out.
#[test]
fn strict_runs_fail_where_structures_are_left_out() {
    let place = Place::new();
    let run = |flags: &str| {
        let line = format!(
            "voxelize --manifest set.csv -o set.zarr --size 24 --channels shape -q {flags}"
        );
        let mut command = program(line.split_whitespace());
        let output = command.current_dir(place.folder.path()).output().unwrap();
        output.status.code()
    };
    assert_eq!(run(""), Some(0));
    // The set is there already, and the answer is the same.
    assert_eq!(run("--strict"), Some(1));
    assert_eq!(run("--strict --force"), Some(1));
    assert!(place.path("set.zarr").exists());
}
