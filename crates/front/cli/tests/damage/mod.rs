//! Damage done to files, and a watch on the memory that reading them takes.

#![allow(dead_code)] // each test program uses its part

use protomer_kernel::random::CounterRng;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The largest block that was asked for since the last reset.
pub static LARGEST_BLOCK: AtomicUsize = AtomicUsize::new(0);

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
pub const PREFIX: usize = 20;
pub const CHECKSUM: usize = 32;

/// Puts the right length and checksum on a file that was changed between them.
pub fn sign(mut content: Vec<u8>) -> Vec<u8> {
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
pub fn damaged(content: &[u8], random: &mut CounterRng) -> Vec<u8> {
    let mut content = content.to_vec();
    for _ in 0..1 + random.index(4) {
        let reach = if random.uniform() < 0.5 {
            content.len().min(1000)
        } else {
            content.len()
        };
        let start = random.index(reach.max(1)).min(content.len());
        let length = (1 + random.index(16)).min(content.len() - start);
        match random.index(6) {
            0 => content[start..start + length].fill_with(|| random.index(256) as u8),
            1 if start < content.len() => content[start] ^= 1 << random.index(8),
            2 => content.truncate(start.max(PREFIX)),
            3 => drop(content.drain(start..start + length)),
            4 => drop(content.splice(start..start, (0..length).map(|_| random.index(256) as u8))),
            _ => {
                let word = WORDS[random.index(WORDS.len())].to_le_bytes();
                let end = (start + [1, 2, 4, 8][random.index(4)]).min(content.len());
                content[start..end].copy_from_slice(&word[..end - start]);
            }
        }
    }
    content
}

/// Changes a value somewhere in a document: lists one shorter or longer, numbers at the ends of their
/// ranges, values of another type, missing and unknown keys.
pub fn damaged_document(document: &Value, random: &mut CounterRng) -> Value {
    let mut document = document.clone();
    for _ in 0..1 + random.index(2) {
        let count = nodes(&document);
        let mut left = random.index(count);
        if let Some(node) = node_mut(&mut document, &mut left) {
            change(node, random);
        }
    }
    document
}

fn nodes(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(nodes).sum::<usize>(),
        Value::Object(fields) => fields.values().map(nodes).sum(),
        _ => 0,
    }
}

/// The node with this number in a walk through the document.
fn node_mut<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    let children: Vec<&mut Value> = match value {
        Value::Array(items) => items.iter_mut().collect(),
        Value::Object(fields) => fields.values_mut().collect(),
        _ => Vec::new(),
    };
    for child in children {
        if let Some(found) = node_mut(child, left) {
            return Some(found);
        }
    }
    None
}

fn change(node: &mut Value, random: &mut CounterRng) {
    const NUMBERS: [&str; 12] = [
        "0",
        "-1",
        "1",
        "2",
        "255",
        "4294967296",
        "9223372036854775807",
        "18446744073709551615",
        "1e308",
        "-1e308",
        "1e-308",
        "0.5",
    ];
    match node {
        Value::Array(items) if random.uniform() < 0.8 => match random.index(4) {
            0 => drop(items.pop()),
            1 if !items.is_empty() => drop(items.remove(random.index(items.len()))),
            2 => items.extend(items.last().cloned()),
            _ => items.clear(),
        },
        Value::Object(fields) if random.uniform() < 0.8 && !fields.is_empty() => {
            let key = fields
                .keys()
                .nth(random.index(fields.len()))
                .cloned()
                .unwrap();
            let value = fields.remove(&key).unwrap();
            if random.uniform() < 0.3 {
                fields.insert(format!("{key}x"), value);
            }
        }
        _ => {
            *node = match random.index(8) {
                0 => Value::Null,
                1 => Value::String("x".into()),
                2 => Value::Bool(true),
                3 => Value::Array(Vec::new()),
                _ => serde_json::from_str(NUMBERS[random.index(NUMBERS.len())]).unwrap(),
            }
        }
    }
}
