//! Container files: round trips, and every kind of damage.

use crate::common::{cases, message};
use proptest::prelude::*;
use protomer_io::container::{Array, Container, Values};
use sha2::{Digest, Sha256};

fn any_values() -> impl Strategy<Value = Values> {
    use prop::collection::vec;
    prop_oneof![
        vec(any::<u64>().prop_map(f64::from_bits), 0..30).prop_map(Values::F64),
        vec(any::<f32>(), 0..30).prop_map(Values::F32),
        vec(any::<u64>(), 0..30).prop_map(Values::U64),
        vec(any::<i64>(), 0..30).prop_map(Values::I64),
        vec(any::<u32>(), 0..30).prop_map(Values::U32),
        vec(any::<i32>(), 0..30).prop_map(Values::I32),
        vec(any::<u8>(), 0..30).prop_map(Values::U8),
    ]
}

fn any_container() -> impl Strategy<Value = Container> {
    let number = any::<f64>().prop_filter("JSON", |x| x.is_finite());
    let arrays = prop::collection::btree_map("[a-zé/]{0,8}", any_values(), 0..5);
    (arrays, "\\PC{0,20}", number).prop_map(|(arrays, text, number)| {
        let mut container = Container::new(
            "body",
            serde_json::json!({ "text": text, "number": number }),
        );
        for (name, values) in arrays {
            let length = match &values {
                Values::F64(v) => v.len(),
                Values::F32(v) => v.len(),
                Values::U64(v) => v.len(),
                Values::I64(v) => v.len(),
                Values::U32(v) => v.len(),
                Values::I32(v) => v.len(),
                Values::U8(v) => v.len(),
            };
            let shape = if length % 3 == 0 {
                vec![length / 3, 3]
            } else {
                vec![length]
            };
            container.insert(name, Array::new(values, shape).unwrap());
        }
        container
    })
}

fn refusal(bytes: &[u8]) -> String {
    message(Container::from_bytes("x.body", "body", bytes))
}

/// Gives changed content a length and checksum that fit, as a hostile file would have.
fn sign(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.len() >= 20 {
        let length = (bytes.len() + 32) as u64;
        bytes[12..20].copy_from_slice(&length.to_le_bytes());
    }
    let checksum = Sha256::digest(&bytes);
    bytes.extend_from_slice(&checksum);
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(128)))]

    #[test]
    fn containers_read_back_bit_for_bit(container in any_container()) {
        let bytes = container.to_bytes().unwrap();
        let back = Container::from_bytes("x.body", "body", &bytes).unwrap();
        // Comparing bytes also compares NaNs.
        prop_assert_eq!(back.to_bytes().unwrap(), bytes);
        prop_assert_eq!(back.header, container.header);
    }

    #[test]
    fn a_changed_byte_is_noticed(container in any_container(), place in any::<prop::sample::Index>(), change in 1..=255u8) {
        let mut bytes = container.to_bytes().unwrap();
        let place = place.index(bytes.len());
        bytes[place] ^= change;
        prop_assert!(Container::from_bytes("x", "body", &bytes).is_err());
    }

    #[test]
    fn hostile_content_with_a_right_checksum_does_not_panic(
        container in any_container(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = container.to_bytes().unwrap();
        bytes.truncate(bytes.len() - 32);
        for (place, value) in changes {
            let place = 12 + place.index(bytes.len() - 12);
            bytes[place] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = Container::from_bytes("x", "body", &sign(bytes));
    }

    #[test]
    fn junk_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Container::from_bytes("x", "body", &bytes).is_err());
    }
}

#[test]
fn each_kind_of_damage_has_its_message() {
    let mut container = Container::new("body", serde_json::json!({ "name": "a" }));
    container.insert("vertices", Array::f64(vec![1.0; 6], [2, 3]).unwrap());
    let bytes = container.to_bytes().unwrap();
    assert!(refusal(b"").contains("x.body: it is not a protomer file"));
    assert!(refusal(b"HEADER    HYDROLASE").contains("it is not a protomer file"));
    for length in 8..bytes.len() {
        assert!(
            refusal(&bytes[..length]).contains("truncated at byte"),
            "{length}: {}",
            refusal(&bytes[..length])
        );
    }
    let mut newer = bytes.clone();
    newer[8] = 9;
    assert!(refusal(&newer).contains("version 9 is newer than this program"));
    let mut damaged = bytes.clone();
    damaged[60] ^= 1;
    assert!(refusal(&damaged).contains("its checksum differs: the file is damaged; make it again"));
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(refusal(&longer).contains("checksum differs"));
    let wrong_kind = message(Container::from_bytes("x", "checkpoint", &bytes));
    assert!(
        wrong_kind.contains("it is a body file where a checkpoint file was expected"),
        "{wrong_kind}"
    );
}

#[test]
fn an_absurd_shape_takes_no_memory() {
    let mut container = Container::new("body", serde_json::Value::Null);
    container.insert("v", Array::f64(vec![], [0]).unwrap());
    let mut bytes = container.to_bytes().unwrap();
    bytes.truncate(bytes.len() - 32);
    let shape = bytes.len() - 8;
    for length in [u64::MAX, 1 << 60, 1 << 40] {
        bytes[shape..].copy_from_slice(&length.to_le_bytes());
        assert!(
            refusal(&sign(bytes.clone())).contains("a value is missing at byte"),
            "{length}"
        );
    }
}

#[test]
fn arrays_are_asked_for_by_type_and_shape() {
    let mut container = Container::new("body", serde_json::Value::Null);
    container.insert("v", Array::f64(vec![1.0; 6], [2, 3]).unwrap());
    assert_eq!(container.f64("x", "v", &[None, Some(3)]).unwrap().len(), 6);
    assert!(message(container.f64("x", "v", &[None])).contains("unexpected shape [2, 3]"));
    assert!(container.f64("x", "v", &[Some(3), Some(2)]).is_err());
    assert!(message(container.f64("x", "w", &[None])).contains("array \"w\" is missing"));
    assert!(message(container.u32("x", "v", &[None, None])).contains("does not have the type u32"));
    assert!(Array::f64(vec![1.0; 5], [2, 3]).is_err());
    assert!(Array::f64(vec![], [usize::MAX, 2]).is_err());
}
