//! Trajectories: read back, continued byte for byte, cut and damaged.

use crate::common::{cases, message};
use proptest::prelude::*;
use protomer_io::gsd::trajectory::enclosing_box;
use protomer_io::gsd::{
    Chunk, ChunkData, GsdFile, GsdWriter, ParticleType, TrajectoryFrame, TrajectoryHeader,
    TrajectoryWriter,
};
use protomer_kernel::{Pose, TriangleMesh, Vec3};
use std::path::Path;

fn header() -> TrajectoryHeader {
    let mesh = TriangleMesh {
        vertices: vec![Vec3::zeros(), Vec3::x() * 3.5, Vec3::y(), Vec3::z()],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    TrajectoryHeader {
        types: vec![
            ParticleType {
                name: "positive".into(),
                mesh: Some(mesh),
            },
            ParticleType {
                name: "b".into(),
                mesh: None,
            },
        ],
        type_ids: vec![0, 1, 0],
        charges_e: vec![6.0, -4.5, 6.0],
    }
}

/// Frame k of the trajectory that `python/checks/check_gsd.py` knows.
fn poses(k: u64) -> Vec<Pose> {
    (0..3)
        .map(|i| {
            let angle = 0.1 * k as f64 + i as f64;
            let quaternion = [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()];
            Pose::from_wxyz(
                Vec3::new(i as f64, 10.0 - k as f64 * 0.01, -0.5 * i as f64),
                quaternion,
            )
        })
        .collect()
}

fn append(writer: &mut TrajectoryWriter, frames: std::ops::Range<u64>) {
    for k in frames {
        let energy = -1.5 * k as f64;
        let log = [("energy_kT", energy), ("r_g_angstrom", 50.0 + k as f64)];
        let frame = TrajectoryFrame {
            step: 1000 * k,
            box_lengths_angstrom: [90.0, 80.0, 70.0],
            poses: &poses(k),
            log: &log,
            charges_e: None,
        };
        writer.append(&frame).unwrap();
    }
}

fn write(path: &Path, frames: u64) {
    let mut writer = TrajectoryWriter::create(path, &header()).unwrap();
    append(&mut writer, 0..frames);
    writer.sync().unwrap();
}

#[test]
fn frames_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gsd");
    write(&path, 100);
    let mut file = GsdFile::open(&path).unwrap();
    assert_eq!((file.frames(), file.schema()), (100, ("hoomd", (1, 4))));
    assert!(file.application().starts_with("protomer"));
    let step = file.chunk(99, "configuration/step").unwrap().unwrap();
    assert_eq!(step.data, ChunkData::U64(vec![99_000]));
    let position = file.chunk(42, "particles/position").unwrap().unwrap();
    assert_eq!((position.columns, position.data.len()), (3, 9));
    let ChunkData::F32(values) = position.data else {
        panic!("not f32")
    };
    assert_eq!(values[4], (10.0 - 0.42) as f32);
    assert!(file.chunk(1, "particles/types").unwrap().is_none());
    assert_eq!(
        file.chunk(7, "log/energy_kT").unwrap().unwrap().data,
        ChunkData::F64(vec![-10.5])
    );
    let ChunkData::I8(shapes) = file
        .chunk(0, "particles/type_shapes")
        .unwrap()
        .unwrap()
        .data
    else {
        panic!("not i8")
    };
    let text = String::from_utf8(shapes.iter().map(|byte| *byte as u8).collect()).unwrap();
    let mut rows = text.split('\0').filter(|row| !row.is_empty());
    let shape: serde_json::Value = serde_json::from_str(rows.next().unwrap()).unwrap();
    assert_eq!(
        (&shape["type"], &shape["indices"][1]),
        (&"Mesh".into(), &serde_json::json!([0, 1, 3]))
    );
    assert_eq!(rows.next(), Some("{}"));
}

#[test]
fn a_resumed_trajectory_equals_the_uninterrupted_one_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut] = ["whole.gsd", "cut.gsd"].map(|name| folder.path().join(name));
    write(&whole, 200);
    let expected = std::fs::read(&whole).unwrap();
    for (written, kept) in [
        (0, 0),
        (3, 0),
        (1, 1),
        (150, 20),
        (60, 59),
        (200, 137),
        (200, 200),
    ] {
        write(&cut, written);
        let mut writer = TrajectoryWriter::resume(&cut, &header(), kept).unwrap();
        assert_eq!(writer.frames(), kept);
        append(&mut writer, kept..200);
        assert!(
            std::fs::read(&cut).unwrap() == expected,
            "{written} written, {kept} kept"
        );
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_trajectory_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gsd");
    write(&path, 5);
    let before = std::fs::read(&path).unwrap();
    let error = message(TrajectoryWriter::resume(&path, &header(), 6));
    assert!(
        error.contains("it holds 5 frames where the checkpoint has written 6"),
        "{error}"
    );
    let mut other = header();
    other.charges_e[0] = 7.0;
    let error = message(TrajectoryWriter::resume(&path, &other, 5));
    assert!(error.contains("other bodies"), "{error}");
    assert!(std::fs::read(&path).unwrap() == before);
    other.charges_e.pop();
    assert!(message(TrajectoryWriter::create(&path, &other)).contains("2 charges for 3 bodies"));
    other = header();
    other.type_ids[1] = 2;
    assert!(message(TrajectoryWriter::create(&path, &other)).contains("a body is of type 2"));
    std::fs::write(&path, "not a trajectory").unwrap();
    assert!(message(GsdFile::open(&path)).contains("is truncated"));
    std::fs::write(&path, [b'x'; 500]).unwrap();
    assert!(message(GsdFile::open(&path)).contains("it is not a GSD file"));
}

#[test]
fn a_file_cut_in_its_last_frame_still_gives_the_frames_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gsd");
    write(&path, 10);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let mut file = GsdFile::open(&path).unwrap();
    let step = file.chunk(8, "configuration/step").unwrap().unwrap();
    assert_eq!(step.data, ChunkData::U64(vec![8000]));
    let mut writer = TrajectoryWriter::resume(&path, &header(), 9).unwrap();
    append(&mut writer, 9..10);
    assert!(std::fs::read(&path).unwrap() == bytes);
}

#[test]
fn an_index_that_names_more_frames_than_it_has_is_refused() {
    const ENTRY: usize = 32;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gsd");
    write(&path, 10);
    let bytes = std::fs::read(&path).unwrap();
    let start = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
    let frame = |entry: usize| start + ENTRY * entry..start + ENTRY * entry + 8;
    let number = |entry: usize| u64::from_le_bytes(bytes[frame(entry)].try_into().unwrap());
    let last = (0..).find(|entry| number(*entry) == 9).unwrap();
    for forged in [1 << 40, u64::MAX / 4, u64::MAX] {
        let mut damaged = bytes.clone();
        damaged[frame(last)].copy_from_slice(&forged.to_le_bytes());
        std::fs::write(&path, damaged).unwrap();
        // The index ends with this entry, because those behind it are of earlier frames.
        let refused = message(GsdFile::open(&path));
        assert!(
            refused.contains(&format!("it names frame {forged} and has")),
            "{refused}"
        );
    }
}

#[test]
fn names_that_outgrow_their_list_move() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.gsd");
    let mut writer = GsdWriter::create(&path, "test", "other", (1, 0)).unwrap();
    let chunk = |i: u32, f: u32| Chunk {
        name: format!("a rather long name {i}"),
        columns: 1,
        data: ChunkData::U32(vec![i + f]),
    };
    for frame in 0..4 {
        // Chunks in an order that is not that of their names.
        let chunks: Vec<Chunk> = (0..100 * (frame + 1))
            .rev()
            .map(|i| chunk(i, frame))
            .collect();
        writer.append_frame(&chunks).unwrap();
    }
    let mut file = GsdFile::open(&path).unwrap();
    for frame in 0..4 {
        for i in [0, 50, 99 + 100 * frame] {
            assert_eq!(
                file.chunk(frame.into(), &format!("a rather long name {i}"))
                    .unwrap(),
                Some(chunk(i, frame))
            );
        }
    }
    assert_eq!(file.frame(2).unwrap().len(), 300);
}

#[test]
fn frames_that_cannot_be_written_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer =
        GsdWriter::create(&folder.path().join("x.gsd"), "test", "other", (1, 0)).unwrap();
    let chunk = |name: &str, columns| Chunk {
        name: name.into(),
        columns,
        data: ChunkData::U8(vec![0; 4]),
    };
    for chunks in [
        vec![],
        vec![chunk("a", 3)],
        vec![chunk("a", 0)],
        vec![chunk("", 1)],
        vec![chunk("a", 1), chunk("a", 1)],
    ] {
        assert!(writer.append_frame(&chunks).is_err());
    }
    assert_eq!(writer.frames(), 0);
    let mut trajectory = TrajectoryWriter::create(&folder.path().join("t.gsd"), &header()).unwrap();
    let frame = TrajectoryFrame {
        step: 0,
        box_lengths_angstrom: [1.0; 3],
        poses: &poses(0)[..2],
        log: &[],
        charges_e: None,
    };
    assert!(message(trajectory.append(&frame)).contains("2 poses for 3 bodies"));
}

#[test]
fn open_space_gets_a_box_that_holds_every_body() {
    assert_eq!(enclosing_box(&poses(0), 5.0), [30.0; 3]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named() {
    let error = message(TrajectoryWriter::create(Path::new("/dev/full"), &header()));
    assert!(
        error.contains("cannot write /dev/full: No space left on device"),
        "{error}"
    );
}

/// Writes the file that `python/checks/check_gsd.py` reads, where the environment says so.
#[test]
fn the_file_for_the_python_check() {
    match std::env::var_os("PROTOMER_GSD_CHECK") {
        Some(path) => write(Path::new(&path), 300),
        None => eprintln!(
            "skipped: set PROTOMER_GSD_CHECK to a path to write the trajectory of check_gsd.py"
        ),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(128)))]

    #[test]
    fn no_mutation_of_a_valid_file_panics(
        changes in prop::collection::vec((0..2000usize, any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.gsd");
        write(&path, 4);
        let mut bytes = std::fs::read(&path).unwrap();
        for (place, value) in changes {
            bytes[place] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        std::fs::write(&path, bytes).unwrap();
        if let Ok(mut file) = GsdFile::open(&path) {
            for frame in 0..file.frames().min(10) {
                let _ = file.frame(frame);
            }
        }
    }
}
