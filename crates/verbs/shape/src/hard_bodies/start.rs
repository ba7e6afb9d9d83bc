//! Bodies and starts from what a user gives: names and files.

use crate::shapes::{half_axes, read_shape};
use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::{NAMES, NAMES_OF_SEVERAL, Site, UnitCell};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::Shape;
use protomer_kernel::{Rotation, Vec3};
use std::path::Path;

/// Names of the crystals of these dimensions, as the help of a flag lists them.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::start::names_of_crystals;
/// assert_eq!(names_of_crystals(&[2, 1]), "square, hexagonal; row");
/// ```
pub fn names_of_crystals(dimensions: &[usize]) -> String {
    lists(&NAMES, dimensions)
}

fn lists(names: &[&[&str]; 3], dimensions: &[usize]) -> String {
    let names = dimensions.iter().filter_map(|number| names.get(number - 1));
    let lists: Vec<String> = names.map(|names| names.join(", ")).collect();
    lists.join("; ")
}

/// Names of the crystals of several shapes, as the help of a flag lists them.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::start::names_of_mixed_crystals;
/// assert_eq!(names_of_mixed_crystals(&[2, 1]), "checkerboard; alternating");
/// ```
pub fn names_of_mixed_crystals(dimensions: &[usize]) -> String {
    lists(&NAMES_OF_SEVERAL, dimensions)
}

/// The start that is no crystal.
pub const FLUID: &str = "fluid";

/// The shape of bodies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BodyShape {
    /// A rod of this length, on a line.
    Rod(f64),
    /// A shape in a plane or in space.
    Shape(Shape),
    /// Several shapes, where their coordinates have them, as one body.
    Pieces(Vec<Shape>),
    /// An ellipse or an ellipsoid with these half axes.
    Ellipsoid(Vec<f64>),
}

impl BodyShape {
    /// Reads a shape from a file or a name; `rod:LENGTH` lives on a line. Pieces of one body are
    /// joined by `+`.
    pub(crate) fn read(file_or_name: &str) -> Result<Self> {
        let Some(length) = file_or_name.strip_prefix("rod:") else {
            return Self::read_pieces(file_or_name);
        };
        match length.trim().parse() {
            Ok(length) if (1e-30..=1e30).contains(&length) => Ok(Self::Rod(length)),
            _ => {
                bail!("'{file_or_name}' has no length from 1e-30 to 1e30; write one, such as rod:1")
            }
        }
    }

    fn read_pieces(file_or_name: &str) -> Result<Self> {
        if let Some(axes) = half_axes(file_or_name)? {
            return Ok(Self::Ellipsoid(axes));
        }
        if !file_or_name.contains('+') || Path::new(file_or_name).exists() {
            return Ok(Self::Shape(read_shape(file_or_name)?));
        }
        let mut shapes = Vec::new();
        for name in file_or_name.split('+') {
            shapes.push(read_shape(name).context("pieces of a body are joined by '+'")?);
        }
        Ok(Self::Pieces(shapes))
    }

    /// Number of dimensions, 1, 2 or 3.
    pub(crate) fn dimension(&self) -> usize {
        match self {
            Self::Rod(_) => 1,
            Self::Shape(shape) => shape.dimension(),
            Self::Pieces(shapes) => shapes[0].dimension(),
            Self::Ellipsoid(axes) => axes.len(),
        }
    }

    /// The body, rounded.
    pub(crate) fn body<const D: usize>(&self, rounding_radius: f64) -> Result<HardBody<D>> {
        Ok(match self {
            Self::Rod(length) => HardBody::ball(0.5 * length + rounding_radius)?,
            Self::Shape(shape) => HardBody::new(shape, rounding_radius)?,
            Self::Pieces(shapes) => HardBody::of_pieces(shapes, rounding_radius)?,
            Self::Ellipsoid(axes) => ellipsoid(axes, rounding_radius)?,
        })
    }

    /// The body with all coordinates scaled, rounded by a radius that is not; `in_pieces` keeps one piece as a body of pieces.
    pub(super) fn body_scaled<const D: usize>(
        &self,
        rounding_radius: f64,
        scale: f64,
        in_pieces: bool,
    ) -> Result<HardBody<D>> {
        if scale == 1.0 && !in_pieces {
            return self.body(rounding_radius);
        }
        let shapes = match self {
            Self::Rod(length) => return Self::Rod(scale * length).body(rounding_radius),
            Self::Shape(shape) => std::slice::from_ref(shape),
            Self::Pieces(shapes) => shapes,
            Self::Ellipsoid(axes) => {
                let axes: Vec<f64> = axes.iter().map(|axis| scale * axis).collect();
                return ellipsoid(&axes, rounding_radius);
            }
        };
        let scaled = shapes.iter().map(|shape| scaled(shape, scale));
        let scaled = scaled.collect::<Result<Vec<Shape>>>()?;
        Ok(match in_pieces {
            true => HardBody::in_pieces(&scaled, rounding_radius)?,
            false => HardBody::of_pieces(&scaled, rounding_radius)?,
        })
    }

    pub(super) fn sha256(&self, cell_text: Option<&str>) -> String {
        let mut text = match self {
            Self::Rod(length) => format!("rod {length}"),
            Self::Shape(shape) => format!("{shape:?}"),
            Self::Pieces(shapes) => format!("{shapes:?}"),
            Self::Ellipsoid(axes) => format!("ellipsoid {axes:?}"),
        };
        text.push_str(cell_text.unwrap_or_default());
        sha256_hex(text.as_bytes())
    }
}

/// The ellipsoid with these half axes, which is round already.
fn ellipsoid<const D: usize>(axes: &[f64], rounding_radius: f64) -> Result<HardBody<D>> {
    if rounding_radius > 0.0 {
        bail!("ellipses and ellipsoids are round already; leave out --rounding");
    }
    let Ok(axes) = <[f64; D]>::try_from(axes) else {
        bail!(
            "an ellipsoid with {} half axes is no body in {D} dimensions; give ellipse:A,B or ellipsoid:A,B,C",
            axes.len()
        );
    };
    Ok(HardBody::ellipsoid(axes)?)
}

/// The shape with all coordinates scaled.
fn scaled(shape: &Shape, scale: f64) -> Result<Shape> {
    let corners = shape
        .corner_points()
        .into_iter()
        .map(|corner| scale * corner);
    Ok(match shape {
        Shape::Flat(_) => Shape::flat(
            &corners
                .map(|corner| [corner.x, corner.y])
                .collect::<Vec<_>>(),
        )?,
        Shape::Solid(_) => Shape::solid(&corners.collect::<Vec<_>>())?,
    })
}

/// The text of the file of a unit cell; `None` for a name.
pub(super) fn cell_text(file_or_name: &str) -> Result<Option<String>> {
    let path = Path::new(file_or_name);
    if !path.is_file() {
        return Ok(None);
    }
    let file = InputFile::read(path)?;
    Ok(Some(String::from_utf8_lossy(&file.bytes).into_owned()))
}

/// The unit cell of a file or a name, with every body turned first: by degrees in a plane, by a
/// quaternion w, x, y, z in space.
pub(super) fn unit_cell<const D: usize>(
    file_or_name: &str,
    text: Option<&str>,
    turn: &[f64],
) -> Result<UnitCell<D>> {
    let cell = match text {
        Some(text) => parse_cell(file_or_name, text)?,
        None => UnitCell::by_name(file_or_name)
            .context("a start is 'fluid', the name of a crystal, or the file of a unit cell")?,
    };
    if turn.is_empty() {
        return Ok(cell);
    }
    match rotation::<D>(turn) {
        Some(rotation) => Ok(cell.with_bodies_turned(&rotation)),
        None => bail!(
            "--turn has {} numbers; {}",
            turn.len(),
            numbers_of_a_turn::<D>()
        ),
    }
}

fn numbers_of_a_turn<const D: usize>() -> &'static str {
    match D {
        1 => "rods on a line do not turn",
        2 => "give one angle in degrees",
        _ => "give a quaternion, four numbers with the scalar first, not all zero",
    }
}

fn rotation<const D: usize>(numbers: &[f64]) -> Option<Rotation> {
    match (D, numbers) {
        (2, [degrees]) => Some(Rotation::from_scaled_axis(degrees.to_radians() * Vec3::z())),
        (3, [w, x, y, z]) => {
            let quaternion = nalgebra::Quaternion::new(*w, *x, *y, *z);
            let norm = quaternion.norm();
            (norm > 0.0 && norm.is_finite()).then(|| Rotation::new_normalize(quaternion))
        }
        _ => None,
    }
}

/// A line of the file of a unit cell.
enum CellLine<const D: usize> {
    /// `cell`: edges, and angles between them in degrees.
    Cell([f64; D], Vec<f64>),
    /// `site`: a body.
    Site(Site<D>),
}

/// `None` if the words do not make a line.
fn cell_line<const D: usize>(words: &[&str]) -> Option<CellLine<D>> {
    let (words, shape) = match words {
        [words @ .., "shape", number] => (words, number.parse().ok().filter(|n| *n > 0)?),
        words => (words, 1_u32),
    };
    let (kind, numbers) = words.split_first()?;
    let finite = |word: &&str| word.parse().ok().filter(|number: &f64| number.is_finite());
    let numbers: Option<Vec<f64>> = numbers.iter().map(finite).collect();
    let numbers = numbers?;
    let (components, further) = numbers.split_at_checked(D)?;
    let components: [f64; D] = components.try_into().ok()?;
    match (*kind, further) {
        ("cell", _) if shape > 1 => None,
        ("cell", angles) if angles.is_empty() || angles.len() == D * (D - 1) / 2 => {
            Some(CellLine::Cell(components, angles.to_vec()))
        }
        ("site", turn) => Some(CellLine::Site(Site {
            place: components,
            rotation: match turn {
                [] => Rotation::identity(),
                turn => rotation::<D>(turn)?,
            },
            kind: shape - 1,
        })),
        _ => None,
    }
}

/// A unit cell: a line `cell` with its edges and, unless they are right, the angles between them (see
/// [`PeriodicBox::with_angles`]), and a line `site` for each body, with its place in parts of the edges and,
/// if it is turned, an angle in degrees (plane) or a quaternion (space). `shape` and a number from 1 at its end name the shape
/// of the body; without them it is the first.
fn parse_cell<const D: usize>(name: &str, text: &str) -> Result<UnitCell<D>> {
    let mut space = None;
    let mut sites = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let separated = line.split([' ', '\t', ',']);
        let words: Vec<&str> = separated.filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let place = format!("{name}:{}", number + 1);
        match cell_line::<D>(&words) {
            Some(CellLine::Cell(edges, angles)) if space.is_none() => {
                space = Some(PeriodicBox::with_angles(&edges, &angles).context(place)?);
            }
            Some(CellLine::Site(site)) => sites.push(site),
            _ => bail!("{place}: '{line}' is not understood; {}", what_to_write(D)),
        }
    }
    match (space, sites.is_empty()) {
        (Some(space), false) => Ok(UnitCell { space, sites }),
        (None, _) => {
            bail!("{name}: the edges of the cell are missing; write 'cell' and {D} numbers")
        }
        (_, true) => bail!("{name}: there is no body; write 'site' and {D} parts of the edges"),
    }
}

fn what_to_write(dimensions: usize) -> String {
    let (angles, turn) = match dimensions {
        1 => ("", "quaternion (scalar first)"),
        2 => (
            " (and the angle between them in degrees, if it is not right)",
            "angle in degrees",
        ),
        _ => (
            " (and the angles α, β and γ between them in degrees, if they are not right)",
            "quaternion (scalar first)",
        ),
    };
    format!(
        "write 'cell' and {dimensions} edges once{angles}, and for each body 'site', {dimensions} parts of the \
         edges and, if it is turned, its {turn}; among several shapes, 'shape' and the number of its own at the end"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_read_and_errors_name_the_line() {
        let text = "# two bodies\ncell 1 1, 2\nsite 0 0 0\nsite 0.5 0.5 0.5 1 0 0 1 # turned\n";
        let cell = parse_cell::<3>("file", text).unwrap();
        assert_eq!(
            (cell.space.lengths(), cell.sites.len()),
            (&[1.0, 1.0, 2.0], 2)
        );
        let angle = cell.sites[1].rotation.angle();
        assert!(
            (angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12,
            "{angle}"
        );
        let oblique = parse_cell::<2>("file", "cell 2 1 120\nsite 0 0").unwrap();
        let [xy] = oblique.space.tilt_factors()[..] else {
            unreachable!()
        };
        assert!((xy + 3.0_f64.sqrt().recip()).abs() < 1e-12, "{xy}");
        for text in [
            "cell 1 1 1\nsite 0 0",
            "site 0 0 0\ncell 1 1 1 90 90",
            "site 0 0 0\ncell 1 1 1 60 60 130",
            "site 0 0 0\ncell 1 1 0",
            "cell 1 1 1\ncell 1 1 1",
            "cell 1 1 1\nsite 0 0 0 0 0 0 0",
            "cell 1 1 1\natom 0 0 0",
            "cell 1 1 1\nsite nan 0 0",
            "cell 1 1 1\nsite 0 0 inf",
            "cell 1 1 1\nsite 0 0 0 shape 0",
            "cell 1 1 1\nsite 0 0 0 shape",
            "site 0 0 0 shape 2\ncell 1 1 1 shape 2",
        ] {
            let words = format!("{:#}", parse_cell::<3>("file", text).unwrap_err());
            assert!(words.starts_with("file:2: "), "{words}");
        }
        let mixed = "cell 1 1 1\nsite 0 0 0\nsite 0.5 0.5 0.5 1 0 0 1 shape 2";
        let mixed = parse_cell::<3>("file", mixed).unwrap();
        assert_eq!(mixed.composition(), [1, 1]);
        assert!(parse_cell::<2>("file", "site 0 0").is_err());
        assert!(parse_cell::<2>("file", "cell 1 1").is_err());
        assert!(unit_cell::<2>("square", None, &[45.0]).is_ok());
        assert!(unit_cell::<3>("fcc", None, &[45.0]).is_err());
    }
}
