//! Bodies on the way to a set, and poses of two of them.

use super::{Counting, Place, content, rayon_pool, settings};
use crate::common::{Watcher, program};
use protomer_learn::SampleSource;
use protomer_learn_verbs::voxels::body_store::BodyStore;
use protomer_learn_verbs::voxels::manifest::Manifest;
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_learn_verbs::voxels::{State, voxelize};
use protomer_results::Shard;
use std::path::Path;

/// The rows of a table that say `ok`.
fn good_rows(table: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(table).unwrap();
    let rows = text.lines().filter(|row| row.contains(",ok,"));
    rows.map(|row| row.replace("ingested/", "made/")).collect()
}

/// The slow twin: voxels and bodies one after the other.
#[test]
fn bodies_on_the_way_are_those_of_ingest_and_the_set_is_the_same() {
    let place = Place::new();
    let set = "voxelize --manifest set.csv --size 32 --most-incomplete 0.3 -o";
    let both = place.run(&format!("{set} both.zarr --bodies made --density 0.3"));
    assert!(both.status.success(), "{both:?}");
    assert!(place.run(&format!("{set} alone.zarr")).status.success());
    place.run("ingest --stream one.pdb two.pdb far.pdb three.pdb --density 0.3 -o ingested");
    assert_eq!(
        content(&place.path("both.zarr")),
        content(&place.path("alone.zarr"))
    );
    // The one that does not fit the grid has a body too.
    for name in ["one", "two", "far", "three"] {
        let [made, ingested] = ["made", "ingested"]
            .map(|folder| std::fs::read(place.path(&format!("{folder}/{name}.body"))).unwrap());
        assert!(made == ingested, "{name}");
    }
    let [made, ingested] =
        ["made", "ingested"].map(|folder| good_rows(&place.path(&format!("{folder}/ingest.csv"))));
    assert_eq!((made.len(), &made), (4, &ingested));
    let warnings = std::fs::read_to_string(place.path("made/warnings.csv")).unwrap();
    let errors = warnings.lines().filter(|line| line.contains(",error,"));
    assert_eq!(errors.count(), 4, "{warnings}");

    let again = place.run(&format!("{set} both.zarr --bodies made --density 0.3"));
    assert!(again.status.success(), "{again:?}");
    let late = place.run(&format!("{set} alone.zarr --bodies late"));
    let told = String::from_utf8(late.stderr).unwrap();
    assert!(told.contains("'protomer ingest'"), "{told}");
    assert!(!place.path("late").exists());
    let told = String::from_utf8(both.stderr).unwrap();
    assert!(told.contains("for 4 of 8 structures"), "{told}");
    let taken = place.run(&format!("{set} other.zarr --bodies ingested"));
    let told = String::from_utf8(taken.stderr).unwrap();
    assert!(
        !taken.status.success() && told.contains("--stream"),
        "{told}"
    );
    std::fs::write(
        place.path("paths.csv"),
        "file,label,cluster,name\none.pdb,x,a,../one\n",
    )
    .unwrap();
    let escaping = place.run("voxelize --manifest paths.csv -o paths.zarr --bodies paths");
    let told = String::from_utf8(escaping.stderr).unwrap();
    assert!(told.contains("'../one'"), "{told}");
    let wrong = place.run(&format!("{set} wrong.zarr --bodies wrong --density -1"));
    assert!(!wrong.status.success() && !place.path("wrong").exists());
}

#[test]
fn bodies_of_a_run_that_was_continued_are_made_once_and_told_in_order() {
    let place = Place::new();
    let manifest = Manifest::read(&place.path("set.csv")).unwrap();
    let (output, store) = (place.path("set.zarr"), Counting::default());
    loop {
        let watcher = Watcher::stopping_after(1);
        let execution = watcher.execution();
        let pool = rayon_pool(1);
        let report = pool.install(|| {
            let bodies = Some(&store as &dyn BodyStore);
            voxelize(
                &manifest,
                Shard::WHOLE,
                &settings(),
                bodies,
                &output,
                &execution,
            )
            .unwrap()
        });
        if report.state == State::Written {
            break;
        }
        assert!(store.finished.lock().unwrap().is_empty());
    }
    let mut kept = store.kept.into_inner().unwrap();
    kept.sort();
    assert_eq!(kept, ["far.pdb", "one.pdb", "three.pdb", "two.pdb"]);
    let expected = [
        "one.pdb",
        "trace.pdb",
        "two.pdb",
        "broken.pdb",
        "water.pdb",
        "missing.pdb",
        "far.pdb",
        "three.pdb",
    ];
    assert_eq!(store.finished.into_inner().unwrap(), expected);
}

/// Poses of two bodies: each is a sample, cropped to its contact, and the pose itself is in its identity.
#[test]
fn poses_of_two_bodies_become_samples() {
    let place = Place::new();
    let poses = [
        ("touching", "0,0,6.5,1,0,0,0"),
        ("again", "0,0,6.5,1,0,0,0"),
        ("turned", "0,0,6.5,0,1,0,0"),
        ("apart", "0,0,90,1,0,0,0"),
    ];
    let heading = "file,partner,label,cluster,name,x_angstrom,y_angstrom,z_angstrom,qw,qx,qy,qz\n";
    let rows = poses.map(|(name, pose)| format!("one.pdb,two.pdb,x,one-two,{name},{pose}\n"));
    let manifest = place.path("poses.csv");
    std::fs::write(&manifest, heading.to_owned() + &rows.concat()).unwrap();
    let words = |output: &str, threads: usize| {
        let flags = "--size 24 --spacing 1 --potential debye-hueckel --orientation deposited";
        let line = format!("voxelize --manifest poses.csv -o {output} {flags} -q -j {threads}");
        let mut command = program(line.split_whitespace());
        command.current_dir(place.folder.path()).output().unwrap()
    };
    let made = words("poses.zarr", 1);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    assert!(words("again.zarr", 3).status.success());
    assert_eq!(
        content(&place.path("poses.zarr")),
        content(&place.path("again.zarr"))
    );

    let set = VoxelSet::open(&place.path("poses.zarr")).unwrap();
    let channels = [
        "shape",
        "potential",
        "hydropathy",
        "partner_shape",
        "partner_potential",
        "partner_hydropathy",
    ];
    assert_eq!(set.channels(), channels);
    let names: Vec<&str> = set
        .descriptions()
        .iter()
        .map(|known| &*known.name)
        .collect();
    assert_eq!(
        names,
        ["touching", "again", "turned"],
        "bodies apart have no interface"
    );
    let grids: Vec<_> = (0..3).map(|sample| set.voxels(sample).unwrap()).collect();
    // One pose under two names, in the frame of the file: the same voxels.
    assert_eq!(grids[0], grids[1]);
    assert_ne!(grids[0], grids[2]);
    for grid in &grids {
        let count = grid.index.len();
        for body in [0, 3] {
            let shape = &grid.values[body * count..(body + 1) * count];
            let potential = &grid.values[(body + 1) * count..(body + 2) * count];
            assert!(shape.iter().sum::<f32>() > 30.0);
            let on_shell = shape.iter().zip(potential);
            assert!(
                on_shell
                    .clone()
                    .any(|(shape, value)| *shape == 1.0 && *value != 0.0)
            );
            assert!(
                on_shell
                    .clone()
                    .all(|(shape, value)| *shape == 1.0 || *value == 0.0)
            );
        }
    }
    // Poses of one complex differ in their hashes, or a training could not tell them apart.
    assert_ne!(set.file_sha256(0), set.file_sha256(2));

    for (text, flags, expected) in [
        (
            "file,label,cluster,qw\none.pdb,x,c,1\n",
            "",
            "add a column 'partner'",
        ),
        (
            "file,partner,label,cluster\none.pdb,,x,c\n",
            "",
            "column partner: the cell is empty",
        ),
        (
            "file,partner,label,cluster,qw\none.pdb,two.pdb,x,c,1\n",
            "",
            "column x_angstrom: '' is not a number",
        ),
        (
            "file,partner,label,cluster\none.pdb,two.pdb,x,c\n",
            "--channels solid",
            "of one body alone",
        ),
        (
            "file,label,cluster\none.pdb,x,c\n",
            "--channels partner_shape",
            "column 'partner'",
        ),
        (
            "file,label,cluster\none.pdb,x,c\n",
            "--interface-reach 5",
            "is for interfaces",
        ),
    ] {
        std::fs::write(place.path("bad.csv"), text).unwrap();
        let line = format!("voxelize --manifest bad.csv -o bad.zarr --size 24 {flags}");
        let mut command = program(line.split_whitespace());
        let refused = command.current_dir(place.folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && said.contains(expected),
            "{said}"
        );
    }
}
