//! Tables, and comparisons of their levels, that outlive the process: what takes long to make, between
//! a line that says of what it is and a hash of all before it.
//!
//! | bytes | |
//! |---|---|
//! | 17 | `protomer table 9` and a line feed |
//! | 64 | the [fingerprint](Table::fingerprint) of charges and potential |
//! | 4, then 36 each | number of nodes of the tree, and the nodes |
//! | 4, then 16 each | number of points of the tree, and the points |
//! | ... | for each cell of the field: distance, errors and coefficients |
//! | 32 | SHA-256 of everything before |
//!
//! Numbers are little-endian. Everything else about a table is rebuilt, which takes milliseconds.
//!
//! A comparison is the line `protomer calibration 3`, its fingerprint, 23 numbers of 8 bytes each, and
//! the hash.

use super::calibration::{Calibration, ListScales, Scales};
use super::field::Field;
use super::fine::Fine;
use super::sampler::Sites;
use super::sharpening::STEPS;
use super::table::Table;
use super::tree::{Node, Tree};
use crate::charges::ChargeCloud;
use crate::energy::SitePotential;
use crate::{McError, Result};
use protomer_kernel::instructions;
use protomer_kernel::potential::Yukawa;
use sha2::{Digest, Sha256};
use std::io::{BufWriter, Read, Write};

/// The first line; its number is raised when the layout changes, or when equal charges give other
/// tables.
const FIRST_LINE: &[u8; 17] = b"protomer table 9\n";
/// Characters of the fingerprint after the first line.
const FINGERPRINT_LENGTH: usize = 64;

/// The first line of a comparison; its number is raised when equal tables give another one.
const FIRST_LINE_OF_CALIBRATION: &[u8; 23] = b"protomer calibration 3\n";

impl Table {
    /// The SHA-256, in hexadecimal, of all that shapes a table: the charges in their order, the
    /// potential, the reach and the kind of processor, whose vector instructions decide the last
    /// bits.
    pub fn fingerprint(charges: &ChargeCloud, potential: &Yukawa, reach_angstrom: f64) -> String {
        let mut hash = Sha256::new();
        hash.update(FIRST_LINE);
        for word in [std::env::consts::ARCH, std::env::consts::OS, instructions()] {
            hash.update(word.as_bytes());
            // A zero between words: "a" "bc" and "ab" "c" must not have one hash.
            hash.update([0]);
        }
        let charges = charges.iter();
        let charges = charges.flat_map(|(place, charge)| [place.x, place.y, place.z, charge]);
        for number in potential
            .parameters()
            .into_iter()
            .chain([reach_angstrom])
            .chain(charges)
        {
            // The bits, not the decimal text: tables differ if a charge differs in its last bit.
            hash.update(number.to_le_bytes());
        }
        hexadecimal(hash)
    }

    /// Writes what takes long to make. `fingerprint` is that of what the table was made of.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write_to(&self, writer: impl Write, fingerprint: &str) -> std::io::Result<()> {
        write_hashed(writer, FIRST_LINE, fingerprint, |writer| {
            self.tree.write_to(writer)?;
            self.field.write_to(writer)
        })
    }

    /// Reads what [`write_to`](Self::write_to) wrote for these charges under this potential: the
    /// same table, bit for bit.
    ///
    /// # Errors
    /// [`McError::UnusableTable`] if the bytes end early, go on too long, were changed, are of
    /// another table, or cannot be read. Memory is taken only as bytes arrive.
    pub fn read_from(
        reader: impl Read,
        charges: &ChargeCloud,
        potential: &Yukawa,
        reach_angstrom: f64,
    ) -> Result<Self> {
        let mut reader = Hashing::new(reader);
        let fingerprint = Self::fingerprint(charges, potential, reach_angstrom);
        read_head(&mut reader, FIRST_LINE, &fingerprint)?;
        let tree = Tree::read_from(&mut reader, charges).map_err(failed)?;
        let mut field = Self::empty_field(charges, reach_angstrom);
        // The cells follow from the charges; only their contents are in the file.
        let cells = field.number_cells(&Sites::new(charges)).len();
        field.read_cells(cells, &mut reader).map_err(failed)?;
        // Checked before the table is used; the cells above were only read.
        read_hash(reader)?;
        Ok(Self::assemble(charges, potential, tree, field))
    }
}

impl Calibration {
    /// The SHA-256, in hexadecimal, of the tables that are compared: the [fingerprint of
    /// each](Table::fingerprint), in the order of the types.
    pub fn fingerprint(tables: &[String]) -> String {
        let mut hash = Sha256::new();
        hash.update(FIRST_LINE_OF_CALIBRATION);
        tables.iter().for_each(|table| hash.update(table));
        hexadecimal(hash)
    }

    /// Writes the comparison. `fingerprint` is that of the tables that were compared.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write_to(&self, writer: impl Write, fingerprint: &str) -> std::io::Result<()> {
        write_hashed(writer, FIRST_LINE_OF_CALIBRATION, fingerprint, |writer| {
            let lists = [self.contact, self.distant];
            let counts = [f64::from(self.poses), f64::from(self.exceeded)];
            let numbers = lists.iter().flat_map(numbers_of).chain(counts);
            let mut numbers = numbers.chain([self.largest]);
            numbers.try_for_each(|number| writer.write_all(&number.to_le_bytes()))
        })
    }

    /// Reads what [`write_to`](Self::write_to) wrote with this fingerprint: the same comparison, bit
    /// for bit.
    ///
    /// # Errors
    /// [`McError::UnusableTable`] if the bytes end early, go on too long, were changed, or are of
    /// other tables.
    pub fn read_from(reader: impl Read, fingerprint: &str) -> Result<Self> {
        let mut reader = Hashing::new(reader);
        read_head(&mut reader, FIRST_LINE_OF_CALIBRATION, fingerprint)?;
        let mut number = || bytes::<8>(&mut reader).map(f64::from_le_bytes);
        let mut read = || {
            Ok(Self {
                contact: scales_from(&mut number)?,
                distant: scales_from(&mut number)?,
                poses: number()? as u32,
                exceeded: number()? as u32,
                largest: number()?,
            })
        };
        let calibration = read().map_err(failed)?;
        read_hash(reader)?;
        Ok(calibration)
    }
}

/// The numbers of [`ListScales`], in the order in which [`scales_from`] reads them.
fn numbers_of(scales: &ListScales) -> Vec<f64> {
    let both = [scales.coarse, scales.expansion];
    let mut numbers: Vec<f64> = both
        .iter()
        .flat_map(|scale| [scale.energy, scale.change])
        .collect();
    numbers.extend(scales.fine);
    numbers
}

fn scales_from(number: &mut impl FnMut() -> std::io::Result<f64>) -> std::io::Result<ListScales> {
    let mut both = || {
        Ok::<_, std::io::Error>(Scales {
            energy: number()?,
            change: number()?,
        })
    };
    let (coarse, expansion) = (both()?, both()?);
    let mut fine = [0.0; 1 + STEPS];
    for scale in &mut fine {
        *scale = number()?;
    }
    Ok(ListScales {
        coarse,
        expansion,
        fine,
    })
}

fn unusable(reason: &str) -> McError {
    McError::UnusableTable(reason.to_owned())
}

fn failed(error: std::io::Error) -> McError {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => unusable("they end too early"),
        _ => McError::UnusableTable(error.to_string()),
    }
}

/// Writes a first line, a fingerprint, a content, and the hash of all three.
fn write_hashed<W: Write>(
    writer: W,
    first_line: &[u8],
    fingerprint: &str,
    content: impl FnOnce(&mut BufWriter<Hashing<W>>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, Hashing::new(writer));
    writer.write_all(first_line)?;
    writer.write_all(fingerprint.as_bytes())?;
    content(&mut writer)?;
    // Taken out of the hashing writer, so that the hash does not include itself.
    let Hashing { mut inner, hash } = writer.into_inner().map_err(|error| error.into_error())?;
    inner.write_all(&hash.finalize())?;
    inner.flush()
}

/// Reads a first line and a fingerprint, which must be these.
fn read_head<const N: usize>(
    reader: &mut impl Read,
    first_line: &[u8; N],
    fingerprint: &str,
) -> Result<()> {
    if bytes::<N>(reader).map_err(failed)? != *first_line {
        return Err(unusable("they are of another kind or version"));
    }
    if bytes::<FINGERPRINT_LENGTH>(reader).map_err(failed)? != *fingerprint.as_bytes() {
        return Err(unusable(
            "they are of other charges, another potential or another kind of processor",
        ));
    }
    Ok(())
}

/// Reads the hash of what was read before, with which the bytes must end.
fn read_hash(reader: Hashing<impl Read>) -> Result<()> {
    let Hashing { mut inner, hash } = reader;
    if hash.finalize()[..] != bytes::<32>(&mut inner).map_err(failed)? {
        return Err(unusable("their checksum is wrong"));
    }
    // Nothing may follow, or the file is not what its hash says.
    if inner.read(&mut [0]).map_err(failed)? != 0 {
        return Err(unusable("there is more than they need"));
    }
    Ok(())
}

impl Tree {
    fn write_to(&self, writer: &mut impl Write) -> std::io::Result<()> {
        writer.write_all(&(self.nodes.len() as u32).to_le_bytes())?;
        for node in &self.nodes {
            put(writer, &node.centre)?;
            put(writer, &[node.radius, node.error])?;
            for number in [node.first, node.count, node.second] {
                writer.write_all(&number.to_le_bytes())?;
            }
        }
        writer.write_all(&(self.points.len() as u32).to_le_bytes())?;
        self.points.iter().try_for_each(|point| put(writer, point))
    }

    fn read_from(reader: &mut impl Read, charges: &ChargeCloud) -> std::io::Result<Self> {
        let mut tree = Self::without_nodes(charges);
        // No capacity is reserved by a number from the
        // file: a damaged one could ask for everything.
        for _ in 0..number(reader)? {
            let (centre, [radius, error]) = (numbers(reader)?, numbers(reader)?);
            let [first, count, second] = [number(reader)?, number(reader)?, number(reader)?];
            tree.nodes.push(Node {
                centre,
                radius,
                first,
                count,
                second,
                error,
            });
        }
        for _ in 0..number(reader)? {
            tree.points.push(numbers(reader)?);
        }
        Ok(tree)
    }
}

impl Field {
    fn write_to(&self, writer: &mut impl Write) -> std::io::Result<()> {
        for cell in 0..self.distance.len() {
            put(writer, &[self.distance[cell]])?;
            put(writer, &self.errors[cell])?;
            self.fine[cell].write_to(writer)?;
        }
        Ok(())
    }

    /// Fills the cells of a field without any.
    fn read_cells(&mut self, cells: usize, reader: &mut impl Read) -> std::io::Result<()> {
        for _ in 0..cells {
            let ([distance], errors) = (numbers(reader)?, numbers(reader)?);
            self.add_cell(distance, errors, Fine::read_from(reader)?);
        }
        Ok(())
    }
}

impl Fine {
    fn write_to(&self, writer: &mut impl Write) -> std::io::Result<()> {
        put(writer, self.leading.as_flattened())?;
        let rows = self.low.iter().chain(&self.high);
        rows.flatten()
            .try_for_each(|number| writer.write_all(&number.to_le_bytes()))
    }

    fn read_from(reader: &mut impl Read) -> std::io::Result<Self> {
        let mut fine = Self {
            leading: [numbers(reader)?, numbers(reader)?],
            low: Default::default(),
            high: Default::default(),
        };
        for number in fine.low.iter_mut().chain(&mut fine.high).flatten() {
            *number = i16::from_le_bytes(bytes(reader)?);
        }
        Ok(fine)
    }
}

fn put(writer: &mut impl Write, numbers: &[f32]) -> std::io::Result<()> {
    numbers
        .iter()
        .try_for_each(|number| writer.write_all(&number.to_le_bytes()))
}

fn bytes<const N: usize>(reader: &mut impl Read) -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn number(reader: &mut impl Read) -> std::io::Result<u32> {
    bytes::<4>(reader).map(u32::from_le_bytes)
}

fn numbers<const N: usize>(reader: &mut impl Read) -> std::io::Result<[f32; N]> {
    let mut bytes = vec![0; 4 * N];
    reader.read_exact(&mut bytes)?;
    let mut numbers = [0.0; N];
    for (number, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(4)) {
        // Little-endian on every machine.
        *number = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    }
    Ok(numbers)
}

/// The vector instructions that the tables' makers are compiled for.
fn instructions() -> &'static str {
    if instructions!(wide_fused: detected) {
        "avx512f fma"
    } else if instructions!(narrow_fused: detected) {
        "avx2 fma"
    } else {
        ""
    }
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

impl<T> Hashing<T> {
    fn new(inner: T) -> Self {
        let hash = Sha256::new();
        Self { inner, hash }
    }
}

impl<T: Write> Write for Hashing<T> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes)?;
        // Only the bytes that were accepted; the rest is offered again.
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
