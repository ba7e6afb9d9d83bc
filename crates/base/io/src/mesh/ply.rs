//! Polygon File Format (Stanford): a text header that declares elements and their properties, then
//! the values, as text or binary of either byte order.

use super::builder::MeshBuilder;
use crate::bytes::Cursor;
use crate::text::shown;
use crate::{IoError, Result};
use protomer_kernel::{TriangleMesh, Vec3};
use std::fmt::Write;

const REMEDY: &str = "the file is damaged, truncated or not PLY: make it again";

/// Reads the vertices (`x`, `y`, `z`) and faces (`vertex_indices` or `vertex_index`) of a PLY file:
/// ASCII, binary little-endian or binary big-endian. Other elements and properties are ignored;
/// polygons are triangulated.
///
/// ```
/// let text = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
///              property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
///              end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let mesh = protomer_io::mesh::ply::read_ply("triangle.ply", text)?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`]; the line is given for the header and for ASCII files.
pub fn read_ply(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let header = Header::read(name, bytes)?;
    let body = &bytes[header.length..];
    let cursor = Cursor::new(body);
    let mut values: Box<dyn Values> = match header.encoding {
        Encoding::Ascii => Box::new(TextValues {
            lines: body.split(|byte| *byte == b'\n'),
            line: header.lines,
            row: vec![],
        }),
        Encoding::LittleEndian => Box::new(BinaryValues {
            cursor,
            big_endian: false,
        }),
        Encoding::BigEndian => Box::new(BinaryValues {
            cursor,
            big_endian: true,
        }),
    };
    let mut builder = MeshBuilder::new(name);
    // One list for all rows: its memory is taken once.
    let mut list = Vec::new();
    for element in &header.elements {
        // The count only controls the loop: every row consumes at least a byte, so a wrong
        // header runs out of bytes.
        for _ in 0..element.count {
            read_row(name, element, values.as_mut(), &mut list, &mut builder)?;
        }
    }
    builder.finish()
}

/// Reads one row of an element; `list` is scratch space.
fn read_row(
    name: &str,
    element: &Element,
    values: &mut dyn Values,
    list: &mut Vec<f64>,
    builder: &mut MeshBuilder,
) -> Result<()> {
    let failed = |line: usize, cause: String| {
        let cause = format!("in element {}: {cause}", shown(&element.name));
        Err(IoError::parse(name, line, cause, REMEDY))
    };
    if let Err(cause) = values.begin_row() {
        return failed(values.line(), cause);
    }
    let mut position = Vec3::zeros();
    for property in &element.properties {
        if let Err(cause) = values.read(property, list) {
            return failed(values.line(), cause);
        }
        match (element.role, property.role) {
            (ElementRole::Vertices, PropertyRole::Coordinate(axis)) => {
                position[axis] = list.first().copied().unwrap_or(f64::NAN);
            }
            (ElementRole::Faces, PropertyRole::Corners) => {
                // A cast saturates; what was no index before is refused as out of range.
                let corners: Vec<i64> = list.iter().map(|value| *value as i64).collect();
                builder.add_polygon(values.line(), &corners)?;
            }
            _ => {}
        }
    }
    if element.role == ElementRole::Vertices {
        builder.add_vertex(values.line(), position)?;
    }
    Ok(())
}

/// The bytes of a binary little-endian PLY file with `double` coordinates, which read back exactly.
///
/// ```
/// use protomer_io::mesh::ply::{read_ply, write_ply_binary};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x() / 3.0, Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert_eq!(read_ply("mesh.ply", &write_ply_binary(&mesh))?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_ply_binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = header_text(mesh, "binary_little_endian").into_bytes();
    for coordinate in mesh.vertices.iter().flatten() {
        bytes.extend_from_slice(&coordinate.to_le_bytes());
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for corner in triangle {
            bytes.extend_from_slice(&corner.to_le_bytes());
        }
    }
    bytes
}

/// The text of an ASCII PLY file; coordinates are written so that they read back exactly.
///
/// ```
/// use protomer_io::mesh::ply::{read_ply, write_ply_ascii};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x() / 3.0, Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert_eq!(read_ply("mesh.ply", write_ply_ascii(&mesh).as_bytes())?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_ply_ascii(mesh: &TriangleMesh) -> String {
    let mut text = header_text(mesh, "ascii");
    for v in &mesh.vertices {
        let _ = writeln!(text, "{} {} {}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

fn header_text(mesh: &TriangleMesh, encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\ncomment protomer surface mesh, lengths in angstrom\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }
}

#[derive(Clone, Copy, PartialEq)]
enum ElementRole {
    Vertices,
    Faces,
    Other,
}

#[derive(Clone, Copy, PartialEq)]
enum PropertyRole {
    Coordinate(usize),
    Corners,
    Other,
}

struct Element {
    name: String,
    role: ElementRole,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    role: PropertyRole,
    /// The type of a list's length; `None` for a plain value.
    length: Option<Scalar>,
    value: Scalar,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Bytes and lines up to the first value.
    length: usize,
    lines: usize,
}

impl Header {
    fn read(name: &str, bytes: &[u8]) -> Result<Self> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut length = 0;
        for (index, raw) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
            length += raw.len();
            let text = String::from_utf8_lossy(raw);
            // Lossy decoding: comments may hold anything, keywords are ASCII.
            let tokens: Vec<&str> = text.split_whitespace().collect();
            let line = index + 1;
            let bad = |cause: &str| Err(IoError::parse(name, line, cause, REMEDY));
            match tokens[..] {
                ["ply"] if index == 0 => {}
                _ if index == 0 => return bad("the file does not begin with `ply`"),
                [] | ["comment" | "obj_info", ..] => {}
                ["format", format, "1.0"] => match Encoding::from_name(format) {
                    Some(format) => encoding = Some(format),
                    None => return bad("the line is not part of a PLY header"),
                },
                ["element", element, count] => match count.parse() {
                    Ok(count) => elements.push(Element::new(element, count)),
                    Err(_) => return bad("the count of an element is not a whole number"),
                },
                ["property", ref declaration @ ..] => {
                    let Some(element) = elements.last_mut() else {
                        return bad("a property comes before any element");
                    };
                    match Property::parse(declaration) {
                        Some(property) => element.properties.push(property),
                        None => return bad("no such property type"),
                    }
                }
                ["end_header"] => {
                    let Some(encoding) = encoding else {
                        return bad("the header states no known format");
                    };
                    check_elements(name, &elements)?;
                    return Ok(Self {
                        encoding,
                        elements,
                        length,
                        lines: line,
                    });
                }
                _ => return bad("the line is not part of a PLY header"),
            }
        }
        Err(IoError::parse(name, 0, "the header has no end", REMEDY))
    }
}

/// Checks once that the rows hold everything needed.
fn check_elements(name: &str, elements: &[Element]) -> Result<()> {
    let mut vertices = None;
    let mut faces = None;
    let mut is_empty = false;
    for (place, element) in elements.iter().enumerate() {
        // Rows without properties take no bytes, so a stated count of them would never run out.
        is_empty |= element.properties.is_empty() && element.count > 0;
        match element.role {
            ElementRole::Vertices if vertices.is_none() => vertices = Some((place, element)),
            ElementRole::Faces if faces.is_none() => faces = Some((place, element)),
            _ => {}
        }
    }
    let cause = match (vertices, faces) {
        _ if is_empty => "an element has no properties",
        (Some((_, vertex)), _) if !vertex.has_coordinates() => {
            "its vertices lack a property x, y or z"
        }
        (Some(_), Some((_, face))) if !face.has(PropertyRole::Corners) => {
            "its faces lack the list vertex_indices"
        }
        // Faces refer to vertices by number, so these must come first.
        (Some((first, _)), Some((second, _))) if second < first => {
            "its faces come before its vertices"
        }
        (Some(_), Some(_)) => return Ok(()),
        _ => "it needs an element `vertex` and an element `face`",
    };
    let remedy = "give a PLY file of a surface mesh";
    Err(IoError::parse(name, 0, cause, remedy))
}

impl Encoding {
    fn from_name(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Encoding::Ascii),
            "binary_little_endian" => Some(Encoding::LittleEndian),
            "binary_big_endian" => Some(Encoding::BigEndian),
            _ => None,
        }
    }
}

impl Element {
    fn new(name: &str, count: u64) -> Self {
        let role = match name {
            "vertex" => ElementRole::Vertices,
            "face" => ElementRole::Faces,
            _ => ElementRole::Other,
        };
        Self {
            name: name.to_owned(),
            role,
            count,
            properties: Vec::new(),
        }
    }

    fn has(&self, role: PropertyRole) -> bool {
        self.properties.iter().any(|property| property.role == role)
    }

    fn has_coordinates(&self) -> bool {
        (0..3).all(|axis| self.has(PropertyRole::Coordinate(axis)))
    }
}

impl Property {
    fn parse(declaration: &[&str]) -> Option<Self> {
        match declaration {
            ["list", length, value, name] => Some(Self {
                role: match *name {
                    "vertex_indices" | "vertex_index" => PropertyRole::Corners,
                    _ => PropertyRole::Other,
                },
                length: Some(Scalar::from_name(length)?),
                value: Scalar::from_name(value)?,
            }),
            [value, name] => Some(Self {
                role: match *name {
                    "x" => PropertyRole::Coordinate(0),
                    "y" => PropertyRole::Coordinate(1),
                    "z" => PropertyRole::Coordinate(2),
                    _ => PropertyRole::Other,
                },
                length: None,
                value: Scalar::from_name(value)?,
            }),
            _ => None,
        }
    }
}

/// A value or an error message; the caller adds the location.
type Scan<T> = std::result::Result<T, String>;

/// A source of property values, row by row.
trait Values {
    /// The line being read; zero for binary files.
    fn line(&self) -> usize;
    fn begin_row(&mut self) -> Scan<()>;
    /// Replaces `values` by the values of one property.
    fn read(&mut self, property: &Property, values: &mut Vec<f64>) -> Scan<()>;
}

struct TextValues<'a, L: Iterator<Item = &'a [u8]>> {
    lines: L,
    line: usize,
    /// The values still unread of this row, last first.
    row: Vec<f64>,
}

impl<'a, L: Iterator<Item = &'a [u8]>> TextValues<'a, L> {
    fn next(&mut self) -> Scan<f64> {
        self.row
            .pop()
            .ok_or_else(|| "the row has too few values".into())
    }
}

impl<'a, L: Iterator<Item = &'a [u8]>> Values for TextValues<'a, L> {
    fn line(&self) -> usize {
        self.line
    }

    fn begin_row(&mut self) -> Scan<()> {
        // Blank lines separate rows in some files.
        self.row.clear();
        while self.row.is_empty() {
            let Some(line) = self.lines.next() else {
                return Err("the file ends before the last row".into());
            };
            self.line += 1;
            for token in String::from_utf8_lossy(line).split_whitespace() {
                match token.parse() {
                    Ok(number) => self.row.push(number),
                    Err(_) => return Err(format!("{} is not a number", shown(token))),
                }
            }
        }
        // Last first, so that taking the next value is a `pop`.
        self.row.reverse();
        Ok(())
    }

    fn read(&mut self, property: &Property, values: &mut Vec<f64>) -> Scan<()> {
        let count = match property.length {
            Some(_) => list_length(self.next()?)?,
            None => 1,
        };
        values.clear();
        for _ in 0..count {
            values.push(self.next()?);
        }
        Ok(())
    }
}

struct BinaryValues<'a> {
    cursor: Cursor<'a>,
    big_endian: bool,
}

impl BinaryValues<'_> {
    fn bytes<const N: usize>(&mut self) -> Scan<[u8; N]> {
        match self.cursor.array::<N>() {
            Ok(mut bytes) => {
                // Reversed bytes of a big-endian number are its little-endian form.
                if self.big_endian {
                    bytes.reverse();
                }
                Ok(bytes)
            }
            Err(end) => Err(format!("the values end at byte {} of them", end.byte)),
        }
    }

    fn scalar(&mut self, scalar: Scalar) -> Scan<f64> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }
}

impl Values for BinaryValues<'_> {
    fn line(&self) -> usize {
        0
    }

    fn begin_row(&mut self) -> Scan<()> {
        Ok(())
    }

    fn read(&mut self, property: &Property, values: &mut Vec<f64>) -> Scan<()> {
        let count = match property.length {
            Some(length) => list_length(self.scalar(length)?)?,
            None => 1,
        };
        values.clear();
        for _ in 0..count {
            values.push(self.scalar(property.value)?);
        }
        Ok(())
    }
}

fn list_length(count: f64) -> Scan<u64> {
    if count >= 0.0 && count.fract() == 0.0 {
        Ok(count as u64)
    } else {
        Err(format!("a list has {count} values"))
    }
}
