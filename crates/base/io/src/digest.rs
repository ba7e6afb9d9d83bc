//! SHA-256 (FIPS 180-4): a third of the memory of its hexadecimal form, and of text as it is
//! written.

use sha2::{Digest as _, Sha256};
use std::fmt::{self, Display, Formatter};
use std::io::Write;

/// A SHA-256. It is displayed in hexadecimal.
///
/// ```
/// use protomer_io::digest::Digest;
/// let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
/// assert_eq!(Digest::hash(b"abc").to_string(), hash);
/// assert_eq!(Digest::from_hex(hash), Some(Digest::hash(b"abc")));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest([u8; 32]);

impl Digest {
    /// The SHA-256 of these bytes.
    ///
    /// ```
    /// use protomer_io::digest::Digest;
    /// assert_eq!(Digest::hash(b"").to_string()[..8], *"e3b0c442");
    /// assert_ne!(Digest::hash(b"abc"), Digest::hash(b"abc\n"));
    /// ```
    pub fn hash(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// The SHA-256 of what is written, which is not kept.
    ///
    /// ```
    /// use protomer_io::digest::Digest;
    /// let written = Digest::of_written(|writer| write!(writer, "{}{}", "ab", "c"))?;
    /// assert_eq!(written, Digest::hash(b"abc"));
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// The error that `write` returns.
    pub fn of_written(
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> std::io::Result<Self> {
        let mut hasher = Hasher(Sha256::new());
        write(&mut hasher)?;
        Ok(Self(hasher.0.finalize().into()))
    }

    /// First 64 bits of the hash, which in practice differ for different content, but not for
    /// certain.
    ///
    /// ```
    /// use protomer_io::digest::Digest;
    /// assert_eq!(Digest::hash(b"abc").short(), 0xba78_16bf_8f01_cfea);
    /// ```
    pub fn short(&self) -> u64 {
        let [a, b, c, d, e, f, g, h, ..] = self.0;
        u64::from_be_bytes([a, b, c, d, e, f, g, h])
    }

    /// Reads its hexadecimal form, as it is displayed; `None` for anything else.
    ///
    /// ```
    /// use protomer_io::digest::Digest;
    /// assert!(Digest::from_hex(&"0a".repeat(32)).is_some());
    /// assert_eq!(Digest::from_hex(&"0A".repeat(32)), None, "capital letters");
    /// assert_eq!(Digest::from_hex("0a"), None, "too short");
    /// ```
    pub fn from_hex(text: &str) -> Option<Self> {
        // Small letters only, as `Display` writes them: one digest has one form.
        let is_hex = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        if text.len() != 64 || !text.bytes().all(is_hex) {
            return None;
        }
        let mut bytes = [0; 32];
        for (place, byte) in bytes.iter_mut().enumerate() {
            *byte = u8::from_str_radix(text.get(2 * place..2 * place + 2)?, 16).ok()?;
        }
        Some(Self(bytes))
    }
}

struct Hasher(Sha256);

impl Write for Hasher {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Display for Digest {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        for byte in self.0 {
            write!(formatter, "{byte:02x}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_displayed_is_read() {
        let shown = Digest::hash(b"").to_string();
        assert_eq!(Digest::from_hex(&shown), Some(Digest::hash(b"")));
        for other in [
            "",
            "e3",
            &shown.to_uppercase(),
            &shown[1..],
            &"é".repeat(32),
        ] {
            assert_eq!(Digest::from_hex(other), None, "{other}");
        }
    }

    /// The twin: all at once.
    #[test]
    fn text_in_pieces_has_the_hash_of_the_whole() {
        let text: String = (0..1000).map(|number| number.to_string()).collect();
        for pieces in [1, 7, 64, 65, 5000] {
            let written = Digest::of_written(|writer| {
                text.as_bytes()
                    .chunks(pieces)
                    .try_for_each(|piece| writer.write_all(piece))
            });
            assert_eq!(written.unwrap(), Digest::hash(text.as_bytes()));
        }
    }
}
