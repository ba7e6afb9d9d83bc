//! Voxel sets come back as they went in, and damage is never taken for data.

use proptest::prelude::*;
use protomer_io::zarr::layout::elements_per_file;
use protomer_io::zarr::{SampleReader, SetPlan, SetReader, SetWriter, StoredSample, attributes};
use serde_json::{Map, json};
use std::path::{Path, PathBuf};

const SIZE: usize = 32;

fn names(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Writes samples of the channels `shape` (implied) and `potential`.
fn write(path: &Path, samples: &[StoredSample]) {
    let voxels = samples.iter().map(|sample| sample.index.len() as u64).sum();
    let plan = SetPlan {
        size: SIZE,
        channels: names(&["shape", "potential"]),
        implied: names(&["shape"]),
        columns: names(&["one", "two"]),
        samples: samples.len() as u64,
        voxels,
    };
    let mut writer = SetWriter::create(path, plan).unwrap();
    for (number, sample) in samples.iter().enumerate() {
        let row = [number as f64, 0.5 * number as f64];
        writer
            .push(&sample.index, &[&sample.values[1]], &row)
            .unwrap();
    }
    let list: Vec<String> = (0..samples.len())
        .map(|sample| format!("name{sample}"))
        .collect();
    let attributes = Map::from_iter([("samples".to_owned(), json!({"name": list}))]);
    writer.finish(&attributes).unwrap();
}

/// A sample of `count` voxels with values that half precision holds exactly.
fn sample(count: usize, seed: u32) -> StoredSample {
    let step = (SIZE.pow(3) / count.max(1)) as u32;
    let index: Vec<u32> = (0..count as u32)
        .map(|n| n * step + n.wrapping_mul(seed) % step.max(1))
        .collect();
    let values = index
        .iter()
        .map(|n| (n.wrapping_mul(2_654_435_761).wrapping_add(seed) % 4001) as f32 / 8.0 - 250.0);
    StoredSample {
        values: vec![vec![1.0; count], values.collect()],
        index,
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path))
        } else {
            found.push(path)
        }
    }
    found.sort();
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn samples_come_back(counts in prop::collection::vec(0_usize..6000, 0..8), seed in 1_u32..1000) {
        let folder = tempfile::tempdir().unwrap();
        let samples: Vec<StoredSample> = (seed..).zip(&counts).map(|(seed, count)| sample(*count, seed)).collect();
        write(folder.path(), &samples);
        let set = SetReader::open(folder.path()).unwrap();
        prop_assert_eq!((set.len(), set.size(), set.channels()), (samples.len(), SIZE, &names(&["shape", "potential"])[..]));
        for (number, sample) in samples.iter().enumerate() {
            prop_assert_eq!(&set.sample(number).unwrap(), sample);
            prop_assert_eq!(set.voxels(number), sample.index.len());
            prop_assert_eq!(set.row(number), &[number as f64, 0.5 * number as f64]);
        }
        prop_assert!(set.sample(samples.len()).unwrap_err().to_string().contains("there is no sample"));
        prop_assert_eq!(set.words("name").unwrap().len(), samples.len());
    }

    #[test]
    fn damaged_headings_are_errors(cut in 0_usize..4000, place in 0_usize..4000, byte in 0_u8..=255) {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[sample(50, 1), sample(70, 2)]);
        for name in ["zarr.json", "index/zarr.json", "properties/zarr.json", "potential/zarr.json", "offsets/c/0"] {
            let path = folder.path().join(name);
            let whole = std::fs::read(&path).unwrap();
            std::fs::write(&path, &whole[..cut % whole.len()]).unwrap();
            if let Ok(set) = SetReader::open(folder.path()) {
                prop_assert!(false, "{name} cut to {} of {}: {} samples", cut % whole.len(), whole.len(), set.len());
            }
            let mut changed = whole.clone();
            changed[place % whole.len()] = byte;
            std::fs::write(&path, &changed).unwrap();
            // Whatever it says now, nothing panics.
            if let Ok(set) = SetReader::open(folder.path()) {
                (0..set.len()).for_each(|number| drop(set.sample(number)));
            }
            std::fs::write(&path, &whole).unwrap();
        }
    }
}

#[test]
fn values_are_rounded_to_half_precision_and_no_further() {
    let folder = tempfile::tempdir().unwrap();
    let values: Vec<f32> = (0..2000)
        .map(|n| ((n as f32) * 0.37).sin() * 30.0)
        .collect();
    let index: Vec<u32> = (0..2000).collect();
    write(
        folder.path(),
        &[StoredSample {
            index,
            values: vec![vec![1.0; 2000], values.clone()],
        }],
    );
    let back = SetReader::open(folder.path()).unwrap().sample(0).unwrap();
    for (one, two) in values.iter().zip(&back.values[1]) {
        assert!(
            (one - two).abs() <= one.abs() / 2048.0 + 1e-7,
            "{one} {two}"
        );
    }
}

#[test]
fn a_changed_byte_is_an_error_that_names_file_and_samples_or_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let samples: Vec<StoredSample> = (0..12).map(|seed| sample(3000, seed + 1)).collect();
    write(folder.path(), &samples);
    for name in ["index/c/0", "potential/c/0"] {
        let path = folder.path().join(name);
        let whole = std::fs::read(&path).unwrap();
        let mut met = 0;
        let places = (0..whole.len())
            .step_by(whole.len() / 60 + 1)
            .chain(whole.len() - 90..whole.len());
        for place in places {
            let mut changed = whole.clone();
            changed[place] ^= 0x10;
            std::fs::write(&path, &changed).unwrap();
            let set = SetReader::open(folder.path()).unwrap();
            for (number, sample) in samples.iter().enumerate() {
                match set.sample(number) {
                    Ok(back) => assert!(
                        &back == sample,
                        "{name}, byte {place}: sample {number} is another"
                    ),
                    Err(error) => {
                        let message = error.to_string();
                        assert!(
                            message.contains(name) && message.contains("name0 to name11"),
                            "{message}"
                        );
                        assert!(message.contains(&format!("name{number}")), "{message}");
                        met += 1;
                    }
                }
            }
        }
        assert!(met > 100, "{name}: {met} errors");
        let require_refusal = || {
            let set = SetReader::open(folder.path()).unwrap();
            let message = set.sample(3).unwrap_err().to_string();
            assert!(
                message.contains(name) && message.contains("name3"),
                "{message}"
            );
        };
        for damaged in [&whole[..whole.len() / 2], &[]] {
            std::fs::write(&path, damaged).unwrap();
            require_refusal();
        }
        std::fs::remove_file(&path).unwrap();
        require_refusal();
        std::fs::write(&path, &whole).unwrap();
    }
}

#[test]
fn the_same_samples_give_the_same_files() {
    let samples: Vec<StoredSample> = (0..20).map(|seed| sample(5000, seed + 1)).collect();
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    folders
        .iter()
        .for_each(|folder| write(folder.path(), &samples));
    let [one, two] = folders.each_ref().map(|folder| files(folder.path()));
    assert_eq!(one.len(), 9, "{one:?}");
    for (one, two) in one.iter().zip(&two) {
        assert!(
            std::fs::read(one).unwrap() == std::fs::read(two).unwrap(),
            "{} differs",
            one.display()
        );
    }
}

/// The table of a large set is cut into files; reading it whole and reading it file by file give the
/// same rows.
#[test]
fn a_long_table_is_read_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let samples: Vec<StoredSample> = (0..2500).map(|number| sample(number % 3, 1)).collect();
    write(folder.path(), &samples);
    let table = folder.path().join("properties/c");
    assert_eq!(files(&table).len(), 3);
    let whole = SetReader::open(folder.path()).unwrap();
    let open = || SampleReader::open(folder.path()).unwrap();
    let parts: Vec<f64> = open()
        .table()
        .parts()
        .flat_map(|part| part.unwrap())
        .collect();
    let rows: Vec<f64> = (0..whole.len())
        .flat_map(|n| whole.row(n).to_vec())
        .collect();
    assert_eq!(whole.row(2499), [2499.0, 1249.5]);
    assert_eq!(parts, rows);
    std::fs::write(table.join("1/0"), "damaged").unwrap();
    assert!(SetReader::open(folder.path()).is_err());
    let readable = open()
        .table()
        .parts()
        .map(|part| part.is_ok())
        .collect::<Vec<_>>();
    assert_eq!(readable, [true, false, true]);
}

/// The twin: all attributes in memory.
#[test]
fn some_attributes_are_read_without_the_others() {
    #[derive(serde::Deserialize)]
    struct Some {
        size: usize,
        channels: Vec<String>,
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[sample(50, 1), sample(70, 2)]);
    let some: Some = attributes(folder.path()).unwrap();
    let all = SetReader::open(folder.path()).unwrap();
    assert_eq!(json!(some.size), all.attributes()["size"]);
    assert_eq!(json!(some.channels), all.attributes()["channels"]);
}

#[test]
fn large_arrays_are_cut_into_files() {
    assert_eq!(
        [1, 8192, 8193, 20_000_000, u64::MAX / 2].map(elements_per_file),
        [8192, 8192, 16_384, 1 << 18, 1 << 18]
    );
}

#[test]
fn what_a_set_cannot_hold_require_refusal() {
    let folder = tempfile::tempdir().unwrap();
    let create = |channels: &[&str], implied: &[&str]| {
        let plan = SetPlan {
            size: SIZE,
            channels: names(channels),
            implied: names(implied),
            columns: Vec::new(),
            samples: 1,
            voxels: 2,
        };
        SetWriter::create(folder.path(), plan)
    };
    for (channels, implied) in [
        (&["a/b"][..], &[][..]),
        (&["index"], &[]),
        (&[""], &[]),
        (&["a"], &["b"]),
    ] {
        assert!(
            create(channels, implied).is_err(),
            "{channels:?} {implied:?}"
        );
    }
    let mut writer = create(&["a"], &[]).unwrap();
    for (index, values) in [
        (vec![1, 1], vec![0.0; 2]),
        (vec![5, 1 << 15], vec![0.0; 2]),
        (vec![1, 2], vec![0.0]),
        (vec![1, 2], vec![0.0, 1e5]),
    ] {
        assert!(
            writer.push(&index, &[&values], &[]).is_err(),
            "{index:?} {values:?}"
        );
    }
    assert!(writer.push(&[1, 2], &[&[0.0, f32::NAN]], &[]).is_err());
    assert!(
        writer.push(&[1], &[&[1.0]], &[0.5]).is_err(),
        "a number too many"
    );
    let unfinished = |writer: SetWriter| writer.finish(&Map::new()).unwrap_err().to_string();
    assert!(unfinished(writer).contains("0 samples were pushed, 1 were promised"));
    let mut writer = create(&["a"], &[]).unwrap();
    writer.push(&[1], &[&[1.0]], &[]).unwrap();
    assert!(unfinished(writer).contains("1 voxels were pushed, 2 were promised"));
    assert!(SetReader::open(folder.path()).is_err(), "an unfinished set");
    assert!(SetReader::open(Path::new("/no/such/set.zarr")).is_err());
}

/// The checksum of zarr's shards, CRC-32C, bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ (0x82f6_3b78 & (sum & 1).wrapping_neg());
        }
    }
    !sum
}

/// Reads everything; the message of the first error.
fn read_all(path: &Path) -> Option<String> {
    let set = match SetReader::open(path) {
        Ok(set) => set,
        Err(error) => return Some(error.to_string()),
    };
    (0..set.len()).find_map(|number| set.sample(number).err().map(|error| error.to_string()))
}

#[test]
fn absurd_shapes_are_refused_before_memory_is_taken_for_them() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[sample(50, 1), sample(70, 2)]);
    assert_eq!(read_all(folder.path()), None);
    let rows = SetReader::open(folder.path()).unwrap();
    let absurd = [
        "0",
        "1",
        "7",
        "1099511627776",
        "1152921504606846976",
        "18446744073709551615",
    ];
    for array in ["offsets", "index", "potential", "properties"] {
        let path = folder.path().join(array).join("zarr.json");
        let whole = std::fs::read_to_string(&path).unwrap();
        let value: serde_json::Value = serde_json::from_str(&whole).unwrap();
        let places = [
            "/shape/0",
            "/chunk_grid/configuration/chunk_shape/0",
            "/codecs/0/configuration/chunk_shape/0",
            "/codecs/0/configuration/codecs/1/configuration/typesize",
        ];
        for place in places.iter().filter(|place| value.pointer(place).is_some()) {
            for number in absurd {
                let mut changed = value.clone();
                *changed.pointer_mut(place).unwrap() = serde_json::from_str(number).unwrap();
                if changed == value {
                    continue;
                }
                std::fs::write(&path, changed.to_string()).unwrap();
                // Files of more rows than there are hold the same rows.
                let is_read = read_all(folder.path()).is_none();
                let is_same =
                    is_read && SetReader::open(folder.path()).unwrap().row(1) == rows.row(1);
                assert!(is_same || !is_read, "{array} {place} = {number} is read");
            }
        }
        std::fs::write(&path, whole).unwrap();
    }
}

#[test]
fn chunks_stated_to_lie_elsewhere_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[sample(50, 1), sample(70, 2)]);
    let path = folder.path().join("potential/c/0");
    let whole = std::fs::read(&path).unwrap();
    // One chunk: its place and its length, and the checksum of both.
    let list = whole.len() - 20;
    assert_eq!(
        crc32c(&whole[list..list + 16]).to_le_bytes(),
        whole[list + 16..]
    );
    for (offset, length) in [
        (0, 1 << 40),
        (0, u64::MAX),
        (u64::MAX, 1),
        (u64::MAX, u64::MAX),
        (1 << 62, 1 << 62),
        (whole.len() as u64 - 1, 30),
        (0, 0),
    ] {
        let mut forged = whole.clone();
        forged[list..list + 8].copy_from_slice(&u64::to_le_bytes(offset));
        forged[list + 8..list + 16].copy_from_slice(&u64::to_le_bytes(length));
        let sum = crc32c(&forged[list..list + 16]);
        forged[list + 16..].copy_from_slice(&sum.to_le_bytes());
        std::fs::write(&path, &forged).unwrap();
        let message = read_all(folder.path()).unwrap();
        assert!(message.contains("potential/c/0"), "{message}");
    }
}

#[test]
fn a_table_with_a_lost_file_require_refusal() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[sample(50, 1)]);
    std::fs::remove_file(folder.path().join("properties/c/0/0")).unwrap();
    let message = read_all(folder.path()).unwrap();
    assert!(message.contains("c/0/0 is missing"), "{message}");
}
