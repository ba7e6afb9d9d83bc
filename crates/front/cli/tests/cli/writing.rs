//! Errors of writing are not errors of the input, inputs that have changed are noticed, and only regular
//! files are replaced.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use std::collections::BTreeMap;

/// Glycines in a row: a body in milliseconds.
fn peptide(shift: f64) -> String {
    let mut text = String::new();
    let atoms = [
        ("N", 0.0, 0.0),
        ("CA", 1.46, 0.7),
        ("C", 2.0, 1.4),
        ("O", 1.4, 2.1),
    ];
    for (serial, (residue, (name, x, y))) in (1..=4)
        .flat_map(|residue| atoms.map(|atom| (residue, atom)))
        .enumerate()
    {
        let x = x + shift + 3.8 * f64::from(residue);
        text += &format!(
            "ATOM  {:>5}  {name:<3} GLY A{residue:>4}    {x:>8.3}{y:>8.3}   0.000  1.00  0.00           {}\n",
            serial + 1,
            &name[..1]
        );
    }
    text + "END\n"
}

pub fn place() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    std::fs::create_dir(place.path("in")).unwrap();
    for number in 0..3 {
        let name = format!("in/s{number}.pdb");
        std::fs::write(place.path(&name), peptide(0.01 * f64::from(number))).unwrap();
    }
    std::fs::write(
        place.path("set.csv"),
        "file,label,cluster\nin/s0.pdb,x,a\nin/s1.pdb,y,b\nin/s2.pdb,x,c\n",
    )
    .unwrap();
    place
}

/// Everything in a folder but the locks.
fn results(place: &TemporaryFolder, name: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = contents(&place.path(name));
    files.retain(|name, _| !name.contains(".lock"));
    files
}

const STREAM: &str = "ingest in --stream --density 2 -j 1 -q -o";
const VOXELS: &str =
    "voxelize --manifest set.csv --size 16 --spacing 2 --channels shape -j 1 -q -o";

#[test]
fn a_full_disk_ends_a_stream_and_loses_no_body() {
    let place = place();
    is_ok(&place.run(&format!("{STREAM} whole")));
    // Tables fit into what a body does not fit into.
    let full = place.run_limited(4, &format!("{STREAM} full"));
    let said = message(&full);
    assert_eq!(full.status.code(), Some(1), "{said}");
    assert!(
        said.contains("cannot write full/s0.body") && said.contains("same command continues"),
        "{said}"
    );
    is_ok(&place.run(&format!("{STREAM} full")));
    let renamed = |files: BTreeMap<String, Vec<u8>>| -> BTreeMap<String, String> {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).replace("full/", "whole/");
        let files = files.into_iter().filter(|(name, _)| name != "ingest.json");
        files.map(|(name, bytes)| (name, text(bytes))).collect()
    };
    assert!(renamed(results(&place, "full")) == renamed(results(&place, "whole")));
}

#[test]
fn a_full_disk_ends_voxels_with_bodies_and_loses_no_body() {
    let place = place();
    let full = place.run_limited(
        16,
        &format!("{VOXELS} set.zarr --density 2 --bodies bodies"),
    );
    let said = message(&full);
    assert_eq!(full.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write bodies/s0.body"), "{said}");
    is_ok(&place.run(&format!("{VOXELS} set.zarr --density 2 --bodies bodies")));
    let bodies = results(&place, "bodies");
    let count = bodies.keys().filter(|name| name.ends_with(".body")).count();
    assert_eq!(count, 3, "{:?}", bodies.keys());
}

#[test]
fn a_stream_notices_that_a_file_has_changed() {
    let place = place();
    is_ok(&place.run(&format!("{STREAM} bodies")));
    is_ok(&place.run(&format!("{STREAM} bodies")));
    let before = results(&place, "bodies");
    std::fs::write(place.path("in/s1.pdb"), peptide(0.5)).unwrap();
    let refused = place.run(&format!("{STREAM} bodies"));
    let said = message(&refused);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(
        said.contains("in/s1.pdb has changed") && said.contains("--force"),
        "{said}"
    );
    assert!(results(&place, "bodies") == before);
    is_ok(&place.run(&format!("{STREAM} bodies --force")));
    let after = results(&place, "bodies");
    assert!(after["s1.body"] != before["s1.body"] && after["s0.body"] == before["s0.body"]);
}

#[test]
fn voxels_of_a_file_that_has_changed_are_other_voxels() {
    let place = place();
    is_ok(&place.run(&format!("{VOXELS} set.zarr")));
    std::fs::write(place.path("in/s1.pdb"), peptide(0.5)).unwrap();
    let refused = message(&place.run(&format!("{VOXELS} set.zarr")));
    assert!(refused.contains("an input file has changed"), "{refused}");
}

/// As a process killed at its last step leaves it.
#[test]
fn a_work_file_left_beside_a_complete_set_is_removed() {
    let place = place();
    is_ok(&place.run(&format!("{VOXELS} set.zarr")));
    std::fs::write(place.path("set.zarr.work"), b"half a record").unwrap();
    is_ok(&place.run(&format!("{VOXELS} set.zarr")));
    assert!(!place.path("set.zarr.work").exists());
}

#[test]
fn links_stay_and_lead_to_the_new_file_or_folder() {
    let place = place();
    let link = |target: &str, name: &str| {
        std::os::unix::fs::symlink(target, place.path(name)).unwrap();
    };
    link("b.body", "link.body");
    let body = "body --mesh cube.off --charges a.xyzq --name b -q -o link.body";
    let refused = message(&place.run(body));
    assert!(refused.contains("--force"), "{refused}");
    let before = std::fs::read(place.path("b.body")).unwrap();
    is_ok(&place.run(&format!("{body} --force")));
    assert!(std::fs::read(place.path("b.body")).unwrap() != before);
    is_ok(&place.run(&format!("{VOXELS} far.zarr")));
    link("far.zarr", "link.zarr");
    let larger = VOXELS.replace("--size 16", "--size 20");
    is_ok(&place.run(&format!("{larger} link.zarr --force")));
    let set = std::fs::read_to_string(place.path("far.zarr/zarr.json")).unwrap();
    assert!(set.contains("\"size\": 20"), "{set}");
    for name in ["link.body", "link.zarr"] {
        assert!(place.path(name).symlink_metadata().unwrap().is_symlink());
    }
    // A device gets the bytes and needs no permission to be replaced.
    is_ok(&place.run("body --mesh cube.off --charges a.xyzq -q -o /dev/null"));
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}
