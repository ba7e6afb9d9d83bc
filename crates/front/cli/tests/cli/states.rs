//! Simulations of an assembly that begin where a GSD file has the bodies.

use crate::common::{TemporaryFolder, is_ok, message};
use protomer_io::gsd::{Chunk, ChunkData, FrameWriter, TrajectoryReader};
use std::path::Path;

const FIRST: &str = "simulate ring.json --salt 100mM --energy none --equilibration 0 --sweeps 40 --log-every 1 \
                     --trajectory-every 10 -q -o first";
const TRAJECTORY: &str = "first/salt_0.100000M/replica_0/trajectory.gsd";

/// The run that begins in a state; its sweeps and its directory come last.
fn from_state(state: &str, rest: &str) -> String {
    format!(
        "simulate ring.json --salt 100mM --energy none --equilibration 0 --log-every 1 --trajectory-every 1 \
         --cluster-moves 0 -q --state {state} {rest}"
    )
}

fn bytes(place: &TemporaryFolder, name: &str) -> Vec<u8> {
    std::fs::read(place.path(name)).unwrap()
}

/// A file as another program writes it: without names of kinds, orientations or a second frame.
fn write_plain(path: &Path, edge: f32, positions: Vec<f32>, type_ids: Vec<u32>) {
    let count = type_ids.len() as u32;
    let chunks = vec![
        Chunk::new(
            "configuration/box",
            1,
            ChunkData::F32(vec![edge, edge, edge, 0.0, 0.0, 0.0]),
        ),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![count])),
        Chunk::new("particles/position", 3, ChunkData::F32(positions)),
        Chunk::new("particles/typeid", 1, ChunkData::U32(type_ids)),
    ];
    let mut writer = FrameWriter::open(path, Vec::new(), 0).unwrap();
    writer.append(chunks).unwrap();
    writer.sync().unwrap();
}

/// One sweep with the smallest steps moves bodies little: the first row has the radius of gyration of the state.
#[test]
fn a_run_begins_where_a_trajectory_has_the_bodies() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(FIRST));
    let mut reader = TrajectoryReader::open(&place.path(TRAJECTORY)).unwrap();
    let frames = reader.frames();
    assert_eq!(frames, 4);
    let first = reader.frame(1).unwrap();
    let [last, stated] = ["", "--frame 1"].map(|frame| {
        let name = if frame.is_empty() { "last" } else { "stated" };
        is_ok(&place.run(&from_state(
            TRAJECTORY,
            &format!("{frame} --sweeps 1 -o {name}"),
        )));
        let path = place.path(&format!("{name}/salt_0.100000M/replica_0/trajectory.gsd"));
        TrajectoryReader::open(&path).unwrap().frame(0).unwrap()
    });
    // A sweep moves every body once at most; one that was refused its move stands where the file has it.
    let unmoved = |state: &protomer_io::gsd::PosedFrame, run: &protomer_io::gsd::PosedFrame| {
        let pairs = state.poses.iter().zip(&run.poses);
        pairs
            .filter(|(a, b)| (a.position - b.position).norm() < 1e-4)
            .count()
    };
    let largest = |state: &protomer_io::gsd::PosedFrame, run: &protomer_io::gsd::PosedFrame| {
        let shifts = state.poses.iter().zip(&run.poses).map(|(a, b)| {
            let shift = a.position - b.position;
            shift.map(|x| x - 80.0 * (x / 80.0).round()).norm()
        });
        shifts.fold(0.0, f64::max)
    };
    let end = reader.frame(frames - 1).unwrap();
    assert!(largest(&first, &stated) < 15.0 && largest(&end, &last) < 15.0);
    assert!(
        unmoved(&first, &stated) > 0,
        "turns and refused moves leave centres alone"
    );
    assert_ne!(stated.poses, last.poses);
}

#[test]
fn a_run_from_a_state_continues_bit_for_bit_and_refuses_another_state() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(FIRST));
    is_ok(&place.run(&from_state(TRAJECTORY, "--sweeps 10 -o parts")));
    is_ok(&place.run(&from_state(TRAJECTORY, "--sweeps 20 -o parts")));
    is_ok(&place.run(&from_state(TRAJECTORY, "--sweeps 20 -o whole")));
    for file in ["log.csv", "trajectory.gsd"] {
        let [parts, whole] = ["parts", "whole"]
            .map(|run| bytes(&place, &format!("{run}/salt_0.100000M/replica_0/{file}")));
        assert!(parts == whole, "{file}");
    }
    let refused = place.run(&from_state(TRAJECTORY, "--frame 0 --sweeps 20 -o whole"));
    assert!(!refused.status.success(), "another frame is another run");
    // The same words on a file with other content.
    std::fs::copy(place.path(TRAJECTORY), place.path("state.gsd")).unwrap();
    is_ok(&place.run(&from_state("state.gsd", "--sweeps 10 -o copy")));
    is_ok(&place.run(&FIRST.replace("--sweeps 40", "--sweeps 50")));
    std::fs::copy(place.path(TRAJECTORY), place.path("state.gsd")).unwrap();
    let refused = place.run(&from_state("state.gsd", "--sweeps 20 -o copy"));
    assert!(!refused.status.success(), "the state has changed");
}

#[test]
fn files_of_other_programs_are_taken_and_wrong_ones_named() {
    let place = TemporaryFolder::new();
    let square = |gap: f32| vec![0.0, 0.0, 0.0, gap, 0.0, 0.0, gap, gap, 0.0, 0.0, gap, 0.0];
    let kinds = vec![0, 1, 0, 1];
    let write = |name: &str, edge, positions, type_ids| {
        write_plain(&place.path(name), edge, positions, type_ids);
    };
    write("good.gsd", 80.0, square(20.0), kinds.clone());
    is_ok(&place.run(&from_state("good.gsd", "--sweeps 1 -o good")));
    write("overlap.gsd", 80.0, square(6.0), kinds.clone());
    write("box.gsd", 90.0, square(20.0), kinds);
    write("kinds.gsd", 80.0, square(20.0), vec![1, 0, 0, 1]);
    write("three.gsd", 80.0, square(20.0)[..9].to_vec(), vec![0, 1, 0]);
    is_ok(&place.run(FIRST));
    let named = std::fs::read_to_string(place.path("ring.json")).unwrap();
    let swapped = named
        .replace("\"body\": \"a\"", "\"body\": \"c\"")
        .replace("\"body\": \"b\"", "\"body\": \"a\"")
        .replace("\"body\": \"c\"", "\"body\": \"b\"");
    std::fs::write(place.path("swapped.json"), swapped).unwrap();
    for (command, expected) in [
        (
            from_state("three.gsd", "-o bad"),
            "three.gsd, frame 0 has 3 bodies, and the assembly has 4",
        ),
        (
            from_state("good.gsd", "--frame 3 -o bad"),
            "it has no frame 3, only 0 to 0",
        ),
        (
            from_state("overlap.gsd", "-o bad"),
            "bodies 1 and 2 overlap; choose another --frame",
        ),
        (
            from_state("box.gsd", "-o bad"),
            "give the box of the file as \"box_angstrom\"",
        ),
        (
            from_state("kinds.gsd", "-o bad"),
            "body 1 is of kind 2, and in the assembly it is 'a'",
        ),
        (
            from_state("first", "-o bad"),
            "first is a directory; give the trajectory.gsd",
        ),
        (from_state("none.gsd", "-o bad"), "none.gsd"),
        (from_state("ring.json", "-o bad"), "ring.json"),
        (
            from_state("good.gsd", "-o bad").replace("--state good.gsd", "--frame 1"),
            "add --state FILE.gsd",
        ),
        (
            from_state(TRAJECTORY, "-o bad").replace("ring.json", "swapped.json"),
            "body 1 is of kind 'a', and in the assembly it is 'b'",
        ),
    ] {
        let output = place.run(&command);
        assert!(!output.status.success(), "{command}");
        assert!(
            message(&output).contains(expected),
            "{command}: {}",
            message(&output)
        );
        assert!(!place.path("bad").exists(), "{command}");
    }
}
