//! The reader of body files on damaged files whose checksum is right again: never a panic, never
//! more memory than a small multiple of the file.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

mod common;
mod damage;

use common::TemporaryFolder;
use damage::{CHECKSUM, LARGEST_BLOCK, damaged, sign};
use protomer_kernel::random::CounterRng;
use protomer_protein_verbs::bodies::body_file;
use std::sync::atomic::Ordering;

/// Reads this many damaged files; returns how many of them are bodies all the same.
fn fuzz(inputs: u64, seed: u64) -> u64 {
    let place = TemporaryFolder::new();
    let valid = std::fs::read(place.path("a.body")).unwrap();
    let content = &valid[..valid.len() - CHECKSUM];
    assert_eq!(
        sign(content.to_vec()),
        valid,
        "the test signs as the writer does"
    );
    let mut accepted = 0;
    for input in 0..inputs {
        let mut random = CounterRng::new(seed, 0, input);
        let changed = damaged(content, &mut random);
        let bytes = if random.uniform() < 0.95 {
            sign(changed)
        } else {
            changed
        };
        LARGEST_BLOCK.store(0, Ordering::Relaxed);
        let result = std::panic::catch_unwind(|| body_file::from_bytes("x.body", &bytes));
        let largest = LARGEST_BLOCK.load(Ordering::Relaxed);
        assert!(
            largest <= 64 * bytes.len() + (1 << 20),
            "input {input} of seed {seed}: a block of {largest} bytes"
        );
        match result.unwrap_or_else(|_| panic!("input {input} of seed {seed} panics")) {
            Err(error) => assert!(format!("{error:#}").starts_with("x.body"), "{error:#}"),
            Ok(body) => {
                accepted += 1;
                let volume = body.mass_properties.volume_angstrom3;
                assert!(
                    volume.is_finite() && volume > 0.0,
                    "input {input} of seed {seed}: a volume of {volume}"
                );
                assert!(
                    body.net_charge_e().is_finite(),
                    "input {input} of seed {seed}: charge"
                );
                assert!(
                    body.mesh_radius_angstrom().is_finite(),
                    "input {input} of seed {seed}: radius"
                );
            }
        }
    }
    accepted
}

#[test]
fn damaged_body_files_give_errors() {
    let accepted = fuzz(600, 1);
    assert!(
        accepted > 0 && accepted < 500,
        "{accepted} of 600: the damage is too hard or too soft to test anything"
    );
}

#[test]
#[ignore = "slow; run by name: cargo test -p protomer-cli --test body_file_fuzz -- --ignored"]
fn many_damaged_body_files_give_errors() {
    let accepted = fuzz(200_000, 2);
    eprintln!("{accepted} of 200000 damaged files are bodies all the same");
}
