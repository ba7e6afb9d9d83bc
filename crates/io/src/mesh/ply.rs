//! Polygon File Format (Stanford): a text header that declares elements and their properties, then
//! the values, as text or binary of either byte order.

use super::MeshBuilder;
use crate::bytes::Cursor;
use crate::text::shown;
use crate::{IoError, Result, mesh::TriangleMesh};
use protomer_kernel::Vec3;
use std::fmt::Write;

const REMEDY: &str = "the file is damaged, cut or not PLY: make it again";

/// Reads the vertices (`x`, `y`, `z`) and faces (`vertex_indices` or `vertex_index`) of a PLY file:
/// ASCII, binary little-endian or binary big-endian. Other elements and properties are passed over;
/// polygons are triangulated.
///
/// # Errors
/// [`IoError::Parse`]; the line is given for the header and for ASCII files.
pub fn read_ply(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let header = Header::read(name, bytes)?;
    let body = &bytes[header.length..];
    let mut values: Box<dyn Values> = match header.encoding {
        Encoding::Ascii => Box::new(TextValues {
            lines: body.split(|b| *b == b'\n'),
            line: header.lines,
            row: vec![],
        }),
        Encoding::LittleEndian => Box::new(BinaryValues {
            cursor: Cursor::new(body),
            big_endian: false,
        }),
        Encoding::BigEndian => Box::new(BinaryValues {
            cursor: Cursor::new(body),
            big_endian: true,
        }),
    };
    read_elements(name, &header.elements, values.as_mut())
}

fn read_elements(
    name: &str,
    elements: &[Element],
    values: &mut dyn Values,
) -> Result<TriangleMesh> {
    let mut builder = MeshBuilder::new(name);
    let mut list = Vec::new();
    for element in elements {
        // The count steers the loop only: every row takes at least a byte, so a lying header runs
        // out of bytes.
        for _ in 0..element.count {
            let fail = |line: usize, cause: String| {
                IoError::parse(
                    name,
                    line,
                    format!("in element {}: {cause}", shown(&element.name)),
                    REMEDY,
                )
            };
            values
                .begin_row()
                .map_err(|cause| fail(values.line(), cause))?;
            let mut position = Vec3::zeros();
            for property in &element.properties {
                values
                    .read(property, &mut list)
                    .map_err(|cause| fail(values.line(), cause))?;
                match (element.role, property.role) {
                    (ElementRole::Vertices, PropertyRole::Coordinate(axis)) => {
                        position[axis] = list.first().copied().unwrap_or(f64::NAN);
                    }
                    (ElementRole::Faces, PropertyRole::Corners) => {
                        let corners: Vec<i64> = list.iter().map(|value| *value as i64).collect();
                        builder.add_polygon(values.line(), &corners)?;
                    }
                    _ => {}
                }
            }
            if element.role == ElementRole::Vertices {
                builder.add_vertex(values.line(), position)?;
            }
        }
    }
    builder.finish()
}

/// The bytes of a binary little-endian PLY file with `double` coordinates, which read back exactly.
pub fn write_ply_binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = header_text(mesh, "binary_little_endian").into_bytes();
    for coordinate in mesh.vertices.iter().flat_map(|vertex| vertex.iter()) {
        bytes.extend_from_slice(&coordinate.to_le_bytes());
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle
            .iter()
            .for_each(|corner| bytes.extend_from_slice(&corner.to_le_bytes()));
    }
    bytes
}

/// The text of an ASCII PLY file; coordinates are written so that they read back exactly.
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
            let line = index + 1;
            let text = String::from_utf8_lossy(raw);
            let tokens: Vec<&str> = text.split_whitespace().collect();
            let bad = |cause: &str| IoError::parse(name, line, cause, REMEDY);
            match tokens[..] {
                ["ply"] if index == 0 => {}
                _ if index == 0 => return Err(bad("the file does not begin with `ply`")),
                [] | ["comment" | "obj_info", ..] => {}
                ["format", "ascii", "1.0"] => encoding = Some(Encoding::Ascii),
                ["format", "binary_little_endian", "1.0"] => {
                    encoding = Some(Encoding::LittleEndian)
                }
                ["format", "binary_big_endian", "1.0"] => encoding = Some(Encoding::BigEndian),
                ["element", element, count] => {
                    let count = count
                        .parse()
                        .map_err(|_| bad("the count of an element is no whole number"))?;
                    elements.push(Element::new(element, count));
                }
                ["property", ref declaration @ ..] => {
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| bad("a property comes before any element"))?;
                    element.properties.push(
                        Property::parse(declaration).ok_or_else(|| bad("no such property type"))?,
                    );
                }
                ["end_header"] => {
                    let encoding =
                        encoding.ok_or_else(|| bad("the header states no known format"))?;
                    check_elements(name, &elements)?;
                    return Ok(Self {
                        encoding,
                        elements,
                        length,
                        lines: line,
                    });
                }
                _ => return Err(bad("the line is not part of a PLY header")),
            }
        }
        Err(IoError::parse(name, 0, "the header has no end", REMEDY))
    }
}

/// Everything the rows must hold, checked once.
fn check_elements(name: &str, elements: &[Element]) -> Result<()> {
    let bad = |cause: &str| {
        Err(IoError::parse(
            name,
            0,
            cause,
            "give a PLY file of a surface mesh",
        ))
    };
    if elements
        .iter()
        .any(|element| element.properties.is_empty() && element.count > 0)
    {
        return bad("an element has no properties");
    }
    let position_of = |role| elements.iter().position(|element| element.role == role);
    let (Some(vertices), Some(faces)) = (
        position_of(ElementRole::Vertices),
        position_of(ElementRole::Faces),
    ) else {
        return bad("it needs an element `vertex` and an element `face`");
    };
    let has = |element: &Element, role| {
        element
            .properties
            .iter()
            .any(|property| property.role == role)
    };
    if !(0..3).all(|axis| has(&elements[vertices], PropertyRole::Coordinate(axis))) {
        return bad("its vertices lack a property x, y or z");
    }
    if !has(&elements[faces], PropertyRole::Corners) {
        return bad("its faces lack the list vertex_indices");
    }
    if faces < vertices {
        return bad("its faces come before its vertices");
    }
    Ok(())
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
}

impl Property {
    fn parse(declaration: &[&str]) -> Option<Self> {
        match declaration {
            ["list", length, value, name] => {
                let corners = matches!(*name, "vertex_indices" | "vertex_index");
                let role = if corners {
                    PropertyRole::Corners
                } else {
                    PropertyRole::Other
                };
                Some(Self {
                    role,
                    length: Some(Scalar::from_name(length)?),
                    value: Scalar::from_name(value)?,
                })
            }
            [value, name] => {
                let axis = ["x", "y", "z"].iter().position(|axis| axis == name);
                let role = axis.map_or(PropertyRole::Other, PropertyRole::Coordinate);
                Some(Self {
                    role,
                    length: None,
                    value: Scalar::from_name(value)?,
                })
            }
            _ => None,
        }
    }
}

/// A value, or what is wrong; the caller adds where.
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

impl<'a, L: Iterator<Item = &'a [u8]>> Values for TextValues<'a, L> {
    fn line(&self) -> usize {
        self.line
    }

    fn begin_row(&mut self) -> Scan<()> {
        loop {
            let line = self
                .lines
                .next()
                .ok_or("the file ends before the last row")?;
            self.line += 1;
            let text = String::from_utf8_lossy(line);
            let number = |token: &str| {
                token
                    .parse::<f64>()
                    .map_err(|_| format!("{} is no number", shown(token)))
            };
            self.row = text.split_whitespace().map(number).collect::<Scan<_>>()?;
            if !self.row.is_empty() {
                self.row.reverse();
                return Ok(());
            }
        }
    }

    fn read(&mut self, property: &Property, values: &mut Vec<f64>) -> Scan<()> {
        let mut next = || self.row.pop().ok_or("the row has too few values");
        let count = if property.length.is_some() {
            next()?
        } else {
            1.0
        };
        values.clear();
        for _ in 0..list_length(count)? {
            values.push(next()?);
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
        let mut bytes = self
            .cursor
            .array::<N>()
            .map_err(|end| format!("the values end at byte {} of them", end.at))?;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
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
        let count = property
            .length
            .map_or(Ok(1.0), |length| self.scalar(length))?;
        values.clear();
        for _ in 0..list_length(count)? {
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
