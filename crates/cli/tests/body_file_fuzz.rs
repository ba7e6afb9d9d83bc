//! The reader of body files on damaged files whose checksum is right again: never a panic, never
//! more memory than a small multiple of the file.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

mod common;

use common::TemporaryFolder;
use protomer::bodies::body_file;
use protomer_kernel::random::CounterRng;
use sha2::{Digest, Sha256};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The largest block that was asked for since the last reset.
static LARGEST_BLOCK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, watched.
struct Watched;

// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST_BLOCK.fetch_max(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the block came from `System` with this layout.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST_BLOCK.fetch_max(size, Ordering::Relaxed);
        // SAFETY: the block came from `System` with this layout.
        unsafe { System.realloc(block, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// Bytes of length, magic and version, and of the checksum at the end.
const PREFIX: usize = 20;
const CHECKSUM: usize = 32;

/// Puts the right length and checksum on a file that was changed between them.
fn sign(mut content: Vec<u8>) -> Vec<u8> {
    if content.len() >= PREFIX {
        let length = (content.len() + CHECKSUM) as u64;
        content[12..PREFIX].copy_from_slice(&length.to_le_bytes());
    }
    let checksum = Sha256::digest(&content);
    content.extend_from_slice(&checksum);
    content
}

/// Numbers at which readers break.
const WORDS: [u64; 12] = [
    0,
    1,
    3,
    255,
    u32::MAX as u64,
    1 << 40,
    1 << 62,
    u64::MAX / 8,
    u64::MAX,
    0x7ff0_0000_0000_0000, // infinity
    0x7ff8_0000_0000_0000, // not a number
    0x7fef_ffff_ffff_ffff, // the largest finite number
];

/// Changes the content of a valid file somewhere. Half of the changes fall into the first kilobyte,
/// where the header and the shapes of the first arrays are.
fn damaged(content: &[u8], random: &mut CounterRng) -> Vec<u8> {
    let mut content = content.to_vec();
    for _ in 0..1 + random.index(4) {
        let reach = if random.uniform() < 0.5 {
            content.len().min(1000)
        } else {
            content.len()
        };
        let at = random.index(reach.max(1)).min(content.len());
        let length = (1 + random.index(16)).min(content.len() - at);
        match random.index(6) {
            0 => content[at..at + length].fill_with(|| random.index(256) as u8),
            1 if at < content.len() => content[at] ^= 1 << random.index(8),
            2 => content.truncate(at.max(PREFIX)),
            3 => drop(content.drain(at..at + length)),
            4 => drop(content.splice(at..at, (0..length).map(|_| random.index(256) as u8))),
            _ => {
                let word = WORDS[random.index(WORDS.len())].to_le_bytes();
                let end = (at + [1, 2, 4, 8][random.index(4)]).min(content.len());
                content[at..end].copy_from_slice(&word[..end - at]);
            }
        }
    }
    content
}

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
