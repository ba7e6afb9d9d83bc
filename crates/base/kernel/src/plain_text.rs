//! Bytes of a file as text: encodings, line ends, and what is not text.
//!
//! Text files come from many programs: with the line ends of three operating systems, in UTF-8,
//! UTF-16 or Latin-1, with a byte-order mark or a closing Ctrl-Z. [`decode`] gives all of them as
//! lines that end with `\n`, so that the readers of formats count and split lines alike.

use std::borrow::Cow;

/// Reasons why bytes are not the text of a file.
///
/// ```
/// use protomer_kernel::plain_text::{NotText, decode};
/// assert_eq!(decode(b" \n"), Err(NotText::Empty));
/// assert_eq!(decode(b"<html><body>404"), Err(NotText::WebPage));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotText {
    /// A file that is empty or holds only blanks.
    Empty,
    /// Compressed data.
    Compressed {
        /// Name of the compression.
        format: &'static str,
        /// The command that decompresses such a file.
        command: &'static str,
    },
    /// A page of the web, as servers send it instead of a file that they do not have.
    WebPage,
    /// A density map, MRC or CCP4, with which structures often lie together.
    DensityMap,
    /// Binary data of another kind.
    Binary {
        /// The line of the first byte that is not text, counted from one.
        line: usize,
    },
}

impl NotText {
    /// The line to name in a message; zero for the whole file.
    ///
    /// ```
    /// use protomer_kernel::plain_text::{NotText, decode};
    /// let fault = decode(b"ATOM\nATOM\n\0\x01");
    /// assert_eq!(fault.map_err(|fault| fault.line()), Err(3));
    /// ```
    pub fn line(&self) -> usize {
        match self {
            NotText::Binary { line } => *line,
            _ => 0,
        }
    }

    /// Description of the fault, for a message.
    ///
    /// ```
    /// use protomer_kernel::plain_text::NotText;
    /// assert_eq!(NotText::Binary { line: 3 }.cause(), "binary data, not text");
    /// ```
    pub fn cause(&self) -> String {
        match self {
            NotText::Empty => "the file is empty".into(),
            NotText::Compressed { format, .. } => format!("the data are {format}-compressed"),
            NotText::WebPage => "a web page (HTML), not a file of data".into(),
            NotText::DensityMap => "this is a density map (MRC or CCP4), not a structure".into(),
            NotText::Binary { .. } => "binary data, not text".into(),
        }
    }

    /// Advice to the user, for a message.
    ///
    /// ```
    /// use protomer_kernel::plain_text::{NotText, decode};
    /// let remedy = decode(b"BZh91AY").map_err(|fault| fault.remedy());
    /// let expected = "decompress the file with 'bzip2 -d FILE' and give the result";
    /// assert_eq!(remedy, Err(expected.to_owned()));
    /// ```
    pub fn remedy(&self) -> String {
        match self {
            NotText::Empty => "give a file with content, or fetch it again".into(),
            NotText::Compressed { command, .. } => {
                format!("decompress the file with '{command}' and give the result")
            }
            NotText::WebPage => {
                "fetch the file itself: the address led to a page about it, or to an error".into()
            }
            NotText::DensityMap => "give the atoms that were built into it, as PDB or mmCIF".into(),
            NotText::Binary { .. } => {
                "give the text format; BinaryCIF, MMTF and trajectories are not read".into()
            }
        }
    }
}

/// The text in these bytes, with `\n` at the end of each line and without a byte-order mark.
///
/// Bytes that are not UTF-8 are Latin-1, the encoding of old remarks: one character per byte, so
/// that fixed columns stay in place.
///
/// ```
/// use protomer_kernel::plain_text::{NotText, decode};
/// assert_eq!(decode(b"\xef\xbb\xbfATOM\rTER\r\n")?, "ATOM\nTER\n");
/// assert_eq!(decode(b"\xfe\xff\0A\0\n")?, "A\n");
/// assert!(matches!(decode(b"\xfd7zXZ\0\0"), Err(NotText::Compressed { format: "xz", .. })));
/// # Ok::<(), NotText>(())
/// ```
///
/// # Errors
/// [`NotText`] for nothing but blanks, compressed data, a web page, a density map and other binary data.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, NotText> {
    for (magic, format, command) in COMPRESSIONS {
        if bytes.starts_with(magic) {
            return Err(NotText::Compressed { format, command });
        }
    }
    if is_density_map(bytes) {
        return Err(NotText::DensityMap);
    }
    let text = match utf16(bytes) {
        Some(text) => Cow::Owned(text),
        None => of_single_bytes(bytes)?,
    };
    if text.trim().is_empty() {
        return Err(NotText::Empty);
    }
    if is_web_page(&text) {
        return Err(NotText::WebPage);
    }
    Ok(with_line_feeds(text))
}

/// A warning about lines that end with a carriage return alone, which most other programs take for one
/// long line; `None` for other line ends.
///
/// ```
/// use protomer_kernel::plain_text::line_end_warning;
/// assert!(line_end_warning(b"ATOM\rTER\r").is_some());
/// assert_eq!(line_end_warning(b"ATOM\r\nTER\r\n"), None);
/// ```
pub fn line_end_warning(bytes: &[u8]) -> Option<String> {
    let is_old = bytes.contains(&b'\r') && !bytes.contains(&b'\n');
    is_old.then(|| {
        "the lines end with CR alone, as on early Macintosh computers; they are read as lines, but \
         other programs may see one line only"
            .to_owned()
    })
}

/// First bytes, name and command of the compressions that files of structures come in.
const COMPRESSIONS: [(&[u8], &str, &str); 8] = [
    (&[0x1f, 0x8b], "gzip", "gzip -d FILE"),
    (b"\xfd7zXZ\0", "xz", "xz -d FILE"),
    (&[0x28, 0xb5, 0x2f, 0xfd], "zstd", "zstd -d FILE"),
    (b"BZh", "bzip2", "bzip2 -d FILE"),
    (&[0x1f, 0x9d], "compress", "uncompress FILE"),
    (b"PK\x03\x04", "zip", "unzip FILE"),
    (&[0x04, 0x22, 0x4d, 0x18], "lz4", "lz4 -d FILE"),
    (b"7z\xbc\xaf\x27\x1c", "7z", "7z x FILE"),
];

/// Whether these bytes are a density map in the format MRC2014 or CCP4, by the word in its header.
///
/// ```
/// use protomer_kernel::plain_text::is_density_map;
/// let mut header = [0; 1024];
/// header[208..212].copy_from_slice(b"MAP ");
/// assert!(is_density_map(&header));
/// assert!(!is_density_map(b"ATOM"));
/// ```
pub fn is_density_map(bytes: &[u8]) -> bool {
    const WORD_AT: usize = 208;
    // A line of text may have the word there, but no zeros before it.
    let (word, before) = (bytes.get(WORD_AT..WORD_AT + 4), bytes.get(..WORD_AT));
    word == Some(b"MAP ".as_slice()) && before.is_some_and(|before| before.contains(&0))
}

/// Text in UTF-16: with a byte-order mark, or without one where every other byte at the beginning
/// is zero.
fn utf16(bytes: &[u8]) -> Option<String> {
    /// Pairs of bytes that show the encoding.
    const SHOWN: usize = 32;
    let from_pairs = |bytes: &[u8], number: fn([u8; 2]) -> u16| {
        let pairs = bytes.chunks_exact(2).map(|pair| number([pair[0], pair[1]]));
        let decoded = char::decode_utf16(pairs);
        decoded
            .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect()
    };
    if let Some(payload) = bytes.strip_prefix(b"\xff\xfe") {
        return Some(from_pairs(payload, u16::from_le_bytes));
    }
    if let Some(payload) = bytes.strip_prefix(b"\xfe\xff") {
        return Some(from_pairs(payload, u16::from_be_bytes));
    }
    let pairs = || bytes.chunks_exact(2).take(SHOWN);
    let is_ascii = |zero: usize| pairs().all(|pair| pair[zero] == 0 && pair[1 - zero] != 0);
    match bytes.len() {
        0..8 => None,
        _ if is_ascii(1) => Some(from_pairs(bytes, u16::from_le_bytes)),
        _ if is_ascii(0) => Some(from_pairs(bytes, u16::from_be_bytes)),
        _ => None,
    }
}

/// Decodes UTF-8 without its byte-order mark, or Latin-1.
fn of_single_bytes(bytes: &[u8]) -> Result<Cow<'_, str>, NotText> {
    if let Some(place) = bytes.iter().position(|byte| *byte == 0) {
        let line = 1 + bytes[..place].iter().filter(|byte| **byte == b'\n').count();
        return Err(NotText::Binary { line });
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
    })
}

fn is_web_page(text: &str) -> bool {
    let start: String = text.trim_start().chars().take(15).collect();
    let start = start.to_ascii_lowercase();
    start.starts_with("<!doctype html") || start.starts_with("<html")
}

/// The text with `\n` for `\r\n` and for `\r`, and without the Ctrl-Z that ends files of DOS.
fn with_line_feeds(text: Cow<'_, str>) -> Cow<'_, str> {
    const CONTROL_Z: char = '\x1a';
    let text = if text.ends_with(CONTROL_Z) {
        Cow::Owned(text.trim_end_matches(CONTROL_Z).to_owned())
    } else {
        text
    };
    if !text.contains('\r') {
        return text;
    }
    Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_alike_whatever_the_operating_system() {
        for text in ["A\nB\n", "A\r\nB\r\n", "A\rB\r", "A\nB\n\x1a"] {
            assert_eq!(decode(text.as_bytes()).unwrap(), "A\nB\n", "{text:?}");
        }
        assert!(matches!(decode(b"A\nB"), Ok(Cow::Borrowed("A\nB"))));
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "REMARK Å é\nATOM\n";
        let pairs = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(order).collect()
        };
        let (little, big) = (pairs(u16::to_le_bytes), pairs(u16::to_be_bytes));
        let encoded = [
            text.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            text.chars().map(|letter| letter as u8).collect(),
            [b"\xff\xfe".to_vec(), little.clone()].concat(),
            [b"\xfe\xff".to_vec(), big.clone()].concat(),
            little,
            big,
        ];
        for (number, bytes) in encoded.iter().enumerate() {
            assert_eq!(decode(bytes).unwrap(), text, "{number}");
        }
    }

    #[test]
    fn what_is_not_text_is_named() {
        let cases: [(&[u8], &str); 9] = [
            (b" \n\t", "empty"),
            (b"\xef\xbb\xbf\n", "empty"),
            (&[0x1f, 0x8b, 8], "gzip"),
            (b"\xfd7zXZ\0\0\x04", "xz"),
            (&[0x28, 0xb5, 0x2f, 0xfd, 4], "zstd"),
            (b"BZh91AY&SY", "bzip2"),
            (b"PK\x03\x04", "zip"),
            (b"\n<!DOCTYPE HTML><html>", "web page"),
            (b"ATOM\n\0\0", "binary"),
        ];
        for (bytes, cause) in cases {
            let error = decode(bytes).unwrap_err();
            assert!(error.cause().contains(cause), "{error:?}");
        }
        assert_eq!(decode(b"ATOM\n\0\0").unwrap_err().line(), 2);
        assert!(
            decode(b"BZh91AY&SY")
                .unwrap_err()
                .remedy()
                .contains("bzip2 -d")
        );
    }
}
