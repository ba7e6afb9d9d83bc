//! Tables that outlive the process: the field, between a line that says of what it is and a hash of
//! all before it.
//!
//! | bytes | |
//! |---|---|
//! | 17 | `protomer table 1` and a line feed |
//! | 64 | the [fingerprint](ChargeTable::fingerprint) of charges and potential |
//! | 1 | whether there is a field |
//! | ... | the field (`field/storage.rs`) |
//! | 32 | SHA-256 of everything before |
//!
//! Everything else about the charges is made anew, which takes milliseconds.

use super::field::SmoothField;
use super::pair::ChargeTable;
use crate::charges::ChargeCloud;
use crate::{McError, Result};
use protomer_kernel::potential::Yukawa;
use sha2::{Digest, Sha256};
use std::io::{BufWriter, Read, Write};

/// The first line; its number is raised when the layout changes.
const FIRST_LINE: &[u8; 17] = b"protomer table 1\n";
/// Raised when equal charges and constants give another field.
const FIELD_VERSION: &str = "smooth field 1";
const FINGERPRINT_LENGTH: usize = 64;

impl ChargeTable {
    /// The SHA-256, in hexadecimal, of all that shapes a table: the charges in their order, the
    /// potential, the constants of the tables, and the kind of processor, whose vector instructions
    /// decide the last bits.
    pub fn fingerprint(charges: &ChargeCloud, yukawa: &Yukawa) -> String {
        let (split, edge, reach) = Self::scales(yukawa);
        let mut hash = Sha256::new();
        for word in [
            FIELD_VERSION,
            std::env::consts::ARCH,
            std::env::consts::OS,
            instructions(),
        ] {
            hash.update(word.as_bytes());
            hash.update([0]);
        }
        let lengths = [
            split.bjerrum,
            split.kappa,
            split.cutoff,
            split.near_radius,
            edge,
            reach,
        ];
        let constants = SmoothField::PARAMETERS
            .into_iter()
            .chain(split.near)
            .chain(split.step);
        let charges = charges
            .iter()
            .flat_map(|(place, charge)| [place.x, place.y, place.z, charge]);
        for number in lengths.into_iter().chain(constants).chain(charges) {
            hash.update(number.to_le_bytes());
        }
        hexadecimal(hash)
    }

    /// Writes what takes long to make. `fingerprint` is that of the charges and the potential the
    /// table was made of.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write_to(&self, writer: impl Write, fingerprint: &str) -> std::io::Result<()> {
        let mut writer = BufWriter::with_capacity(
            1 << 16,
            Hashing {
                inner: writer,
                hash: Sha256::new(),
            },
        );
        writer.write_all(FIRST_LINE)?;
        writer.write_all(fingerprint.as_bytes())?;
        writer.write_all(&[u8::from(self.field.is_some())])?;
        if let Some(field) = &self.field {
            field.write_to(&mut writer)?;
        }
        let Hashing { mut inner, hash } =
            writer.into_inner().map_err(|error| error.into_error())?;
        inner.write_all(&hash.finalize())?;
        inner.flush()
    }

    /// Reads what [`write_to`](Self::write_to) wrote for these charges under this potential: the
    /// same table, bit for bit.
    ///
    /// # Errors
    /// [`McError::UnusableTable`] if the bytes end early, go on too long, were changed, are of
    /// another table, or cannot be read. Memory is taken only as bytes arrive.
    pub fn read_from(reader: impl Read, charges: &ChargeCloud, yukawa: &Yukawa) -> Result<Self> {
        let unusable = |what: &str| McError::UnusableTable(what.to_owned());
        let failed = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => unusable("they end too early"),
            _ => McError::UnusableTable(error.to_string()),
        };
        let mut reader = Hashing {
            inner: reader,
            hash: Sha256::new(),
        };
        let mut line = [0; FIRST_LINE.len()];
        reader.read_exact(&mut line).map_err(failed)?;
        if line != *FIRST_LINE {
            return Err(unusable("they are of another kind or version"));
        }
        let mut fingerprint = [0; FINGERPRINT_LENGTH];
        reader.read_exact(&mut fingerprint).map_err(failed)?;
        if fingerprint != *Self::fingerprint(charges, yukawa).as_bytes() {
            return Err(unusable(
                "they are of other charges, another potential or another kind of processor",
            ));
        }
        let mut has_field = [0];
        reader.read_exact(&mut has_field).map_err(failed)?;
        let field = if has_field == [0] {
            None
        } else {
            Some(SmoothField::read_from(&mut reader).map_err(failed)?)
        };
        let Hashing { mut inner, hash } = reader;
        let mut stored = [0; 32];
        inner.read_exact(&mut stored).map_err(failed)?;
        if hash.finalize()[..] != stored {
            return Err(unusable("their checksum is wrong"));
        }
        if inner.read(&mut [0]).map_err(failed)? != 0 {
            return Err(unusable("there is more than they need"));
        }
        let mut missing = false;
        let table = Self::with_field(charges, yukawa, |leaves, split, edge, reach| {
            missing = field.is_none();
            field.unwrap_or_else(|| SmoothField::new(leaves, split, edge, reach))
        });
        if missing {
            Err(unusable("the field is missing"))
        } else {
            Ok(table)
        }
    }
}

/// The vector instructions that the tables' makers ask for.
fn instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        let fused = is_x86_feature_detected!("fma");
        match (
            is_x86_feature_detected!("avx512f"),
            is_x86_feature_detected!("avx2"),
        ) {
            (true, _) if fused => "avx512f fma",
            (true, _) => "avx512f",
            (_, true) if fused => "avx2 fma",
            (_, true) => "avx2",
            _ => "",
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    ""
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Hashes what passes through.
struct Hashing<T> {
    inner: T,
    hash: Sha256,
}

impl<T: Write> Write for Hashing<T> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hash.update(bytes.get(..written).unwrap_or_default());
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Hashing<T> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.hash.update(bytes.get(..read).unwrap_or_default());
        Ok(read)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use protomer_kernel::Vec3;

    fn charges() -> ChargeCloud {
        ChargeCloud::new(&[
            (Vec3::new(0.0, 0.0, 0.0), 2.0),
            (Vec3::new(3.0, 1.0, 0.0), -1.5),
        ])
    }

    fn yukawa(cutoff_angstrom: f64) -> Yukawa {
        Yukawa::new(7.0, 1.0 / 9.6, cutoff_angstrom).unwrap()
    }

    /// The table and its bytes; with a field for a cut-off from 24 Å on.
    fn stored(cutoff_angstrom: f64) -> (ChargeTable, Vec<u8>) {
        let (charges, yukawa) = (charges(), yukawa(cutoff_angstrom));
        let table = ChargeTable::new(&charges, &yukawa);
        let mut bytes = Vec::new();
        table
            .write_to(&mut bytes, &ChargeTable::fingerprint(&charges, &yukawa))
            .unwrap();
        (table, bytes)
    }

    fn read(bytes: &[u8], cutoff_angstrom: f64) -> Result<ChargeTable> {
        ChargeTable::read_from(bytes, &charges(), &yukawa(cutoff_angstrom))
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit() {
        for (cutoff, field) in [(24.0, true), (60.0, true), (10.0, false)] {
            let (table, bytes) = stored(cutoff);
            assert_eq!(table.field.is_some(), field);
            let again = read(&bytes, cutoff).unwrap();
            assert_eq!(again, table);
            // Equal numbers may differ in bits, as zeros of two signs do.
            let mut second = Vec::new();
            again
                .write_to(
                    &mut second,
                    &ChargeTable::fingerprint(&charges(), &yukawa(cutoff)),
                )
                .unwrap();
            assert!(second == bytes);
        }
    }

    #[test]
    fn every_changed_byte_and_every_cut_is_noticed() {
        let (_, bytes) = stored(24.0);
        // All of the head and of the end, and a sample between.
        let places = (0..400)
            .chain((400..bytes.len() - 40).step_by(bytes.len() / 60))
            .chain(bytes.len() - 40..bytes.len());
        for place in places {
            for flip in [1, 0x80] {
                let mut changed = bytes.clone();
                changed[place] ^= flip;
                assert!(read(&changed, 24.0).is_err(), "changed at {place}");
            }
            assert!(read(&bytes[..place], 24.0).is_err(), "cut at {place}");
        }
        let mut longer = bytes.clone();
        longer.push(0);
        assert!(
            read(&longer, 24.0)
                .unwrap_err()
                .to_string()
                .contains("more than they need")
        );
    }

    #[test]
    fn tables_of_others_are_refused() {
        let (_, bytes) = stored(24.0);
        assert!(
            read(&bytes, 25.0)
                .unwrap_err()
                .to_string()
                .contains("other charges")
        );
        let other = ChargeCloud::new(&[(Vec3::zeros(), 2.0)]);
        assert!(ChargeTable::read_from(&bytes[..], &other, &yukawa(24.0)).is_err());
    }

    /// With a checksum that is right, too.
    #[test]
    fn senseless_lengths_and_cubes_take_no_memory() {
        let (_, bytes) = stored(24.0);
        let head = FIRST_LINE.len() + FINGERPRINT_LENGTH + 1;
        let sealed = |at: usize, with: &[u8]| {
            let mut changed = bytes[..bytes.len() - 32].to_vec();
            changed[at..at + with.len()].copy_from_slice(with);
            let hash = Sha256::digest(&changed);
            changed.extend_from_slice(&hash);
            read(&changed, 24.0)
        };
        for word in 4..8 {
            for length in [u64::MAX, 1 << 40, 1 << 62] {
                assert!(
                    sealed(head + 8 * word, &length.to_le_bytes()).is_err(),
                    "length {word}"
                );
            }
        }
        for cube in [u32::MAX - 1, 1 << 30] {
            assert!(sealed(head + 64, &cube.to_le_bytes()).is_err());
        }
        assert!(sealed(head - 1, &[0]).is_err());
    }
}
