//! Convex shapes from files and names: what is known of them exactly, and what two of them feel.

pub mod contact;
pub mod contact_map;
pub mod free_volume;
pub mod overlap;
mod places;
pub mod virial;

use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_common::output_file::write_once;
use protomer_io::mesh::{MeshFormat, read_mesh, write_mesh};
use protomer_kernel::Vec3;
use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
use protomer_kernel::shape::hull::Hull;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::{Shape, builders};
use serde::Serialize;
use std::path::Path;

/// Measured properties of a shape. Lengths are in the unit of its points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShapeReport {
    /// File or name of the shape.
    pub shape: String,
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Corners of the convex hull; of an ellipsoid none.
    pub corners: usize,
    /// Radius of the ball (in a plane, the disk) that is added to the shape.
    pub rounding_radius: f64,
    /// Volume; in a plane, the area.
    pub volume: f64,
    /// Surface; in a plane, the perimeter.
    pub surface: f64,
    /// Integral of the mean curvature over the surface; in a plane 2π.
    pub integrated_mean_curvature: f64,
    /// Second virial coefficient of hard bodies of this shape.
    pub b2: f64,
    /// Second virial coefficient over the volume.
    pub b2_over_volume: f64,
}

impl Answer for ShapeReport {
    fn text(&self) -> String {
        let names = match self.dimension {
            2 => ["area", "perimeter"],
            _ => ["volume", "surface"],
        };
        let corners = match self.corners {
            0 => "no".into(),
            corners => corners.to_string(),
        };
        format!(
            "{}: {} corners, rounded by {}\n\
             {} {:.12}, {} {:.12}, integrated mean curvature {:.12}\n\
             second virial coefficient {:.12}, {:.12} {}s",
            self.shape,
            corners,
            self.rounding_radius,
            names[0],
            self.volume,
            names[1],
            self.surface,
            self.integrated_mean_curvature,
            self.b2,
            self.b2_over_volume,
            names[0]
        )
    }
}

/// Measures a shape and, if an output file is given, writes the mesh of its hull without rounding, in
/// the format of the file's extension.
///
/// # Errors
/// As [`read_shape`]; also for an unknown extension, a shape that has no mesh, or a file that exists
/// with other content, unless `force` is set.
///
/// ```
/// let cube = protomer_shape_verbs::shapes::measure_shape("cube", 0.1, None, false)?;
/// assert_eq!(cube.corners, 8);
/// assert!(cube.volume > 1.0);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn measure_shape(
    file_or_name: &str,
    rounding_radius: f64,
    output: Option<&Path>,
    force: bool,
) -> Result<ShapeReport> {
    let format = output.map(|path| MeshFormat::from_name(&path.display().to_string()));
    let format = format.transpose()?;
    if let Some(axes) = half_axes(file_or_name)? {
        if output.is_some() {
            bail!("{file_or_name} has no faces, so there is no mesh to write; leave out --output");
        }
        let measures =
            measures_of_ellipsoid(&axes, rounding_radius).context(file_or_name.to_owned())?;
        return Ok(report(
            file_or_name,
            (axes.len(), 0),
            rounding_radius,
            &measures,
        ));
    }
    let shape = read_shape(file_or_name)?;
    let measures =
        Measures::from_shape(&shape, rounding_radius).context(file_or_name.to_owned())?;
    if let (Some(path), Some(format)) = (output, format) {
        let Shape::Solid(Hull::Polyhedron(mesh)) = &shape else {
            bail!("{file_or_name} has no faces, so there is no mesh to write; leave out --output");
        };
        let bytes = write_mesh(format, mesh);
        write_once(path, &bytes, force)?;
    }
    let size = (shape.dimension(), shape.corners());
    Ok(report(file_or_name, size, rounding_radius, &measures))
}

fn report(
    file_or_name: &str,
    (dimension, corners): (usize, usize),
    rounding_radius: f64,
    measures: &Measures,
) -> ShapeReport {
    ShapeReport {
        shape: file_or_name.to_owned(),
        dimension,
        corners,
        rounding_radius,
        volume: measures.volume,
        surface: measures.surface,
        integrated_mean_curvature: measures.integrated_mean_curvature,
        b2: measures.b2,
        b2_over_volume: measures.b2 / measures.volume,
    }
}

/// The half axes of an ellipse or an ellipsoid, as its name has them; `None` for other names.
///
/// # Errors
/// For a name with another number of half axes, or with something that is no number.
pub(crate) fn half_axes(name: &str) -> Result<Option<Vec<f64>>> {
    let (dimension, numbers) = match name.split_once(':').unwrap_or((name, "")) {
        ("ellipse", numbers) => (2, numbers),
        ("ellipsoid", numbers) => (3, numbers),
        _ => return Ok(None),
    };
    let numbers = numbers.split(',').map(|cell| cell.trim().parse().ok());
    match numbers.collect::<Option<Vec<f64>>>() {
        Some(numbers) if numbers.len() == dimension => Ok(Some(numbers)),
        _ => bail!("{name}: give ellipse:A,B or ellipsoid:A,B,C with half axes"),
    }
}

/// The convex shape of a file (corners of a polygon, two columns; points in space, three columns, which stand for
/// their hull; or a mesh), or the shape of this name. Every shape file enters here.
///
/// ```
/// use protomer_shape_verbs::shapes::read_shape;
/// # let folder = tempfile::tempdir()?;
/// assert_eq!(read_shape("cube")?.corners(), 8);
/// let file = folder.path().join("triangle.txt");
/// std::fs::write(&file, "0 0\n1 0\n0 1 # the last corner\n")?;
/// assert_eq!(read_shape(&file.to_string_lossy())?.corners(), 3);
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// Names the file and the line, or lists the names; refuses what is not convex.
pub fn read_shape(file_or_name: &str) -> Result<Shape> {
    let path = Path::new(file_or_name);
    // A run of cubes may stand in a folder `cube`.
    let named = builders::by_name(file_or_name);
    if !path.exists() || path.is_dir() && named.is_ok() {
        if half_axes(file_or_name)?.is_some() {
            bail!(
                "{file_or_name} has no corners; `shape`, `hpmc` and `md` take ellipses and ellipsoids, alone as a body"
            );
        }
        return Ok(named?);
    }
    let file = InputFile::read(path)?;
    if MeshFormat::from_name(&file.name).is_ok() {
        let mesh = read_mesh(&file.name, &file.bytes)?;
        return Shape::mesh(&mesh).context(file.name);
    }
    let text = String::from_utf8_lossy(&file.bytes);
    shape_of_columns(&file.name, &text)
}

/// Points, one per line; what follows a # is a comment.
fn shape_of_columns(name: &str, text: &str) -> Result<Shape> {
    let (mut flat, mut solid) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let numbers = line.split([' ', '\t', ',']).filter(|cell| !cell.is_empty());
        let numbers: Option<Vec<f64>> = numbers.map(|cell| cell.parse().ok()).collect();
        match numbers.as_deref() {
            Some([]) => {}
            Some([x, y]) if solid.is_empty() => flat.push([*x, *y]),
            Some([x, y, z]) if flat.is_empty() => solid.push(Vec3::new(*x, *y, *z)),
            _ => bail!(
                "{name}:{}: '{}' is not a point like those before it; write two numbers per line \
                 for a polygon, three for a polyhedron",
                number + 1,
                line.trim()
            ),
        }
    }
    match flat.is_empty() {
        true => Shape::solid(&solid),
        false => Shape::polygon(&flat),
    }
    .with_context(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipsoids_are_measured_and_not_moved() {
        let report = measure_shape("ellipsoid:1,2,3", 0.0, None, false).unwrap();
        // The surface by Legendre's integrals.
        assert!((report.surface - 48.882_146_302_582).abs() < 1e-9);
        assert!(report.text().contains("no corners"));
        for name in [
            "ellipse",
            "ellipsoid:1,2",
            "ellipse:1,2,3",
            "ellipse:a,b",
            "ellipse:0,1",
        ] {
            assert!(measure_shape(name, 0.0, None, false).is_err(), "{name}");
        }
        let words = read_shape("ellipse:1,2").unwrap_err().to_string();
        assert!(words.contains("`md`"), "{words}");
    }

    #[test]
    fn columns_say_the_dimension() {
        let square = shape_of_columns("square", "0 0\n1,0 # corner\n\n1\t1\n0 1\n").unwrap();
        assert_eq!((square.dimension(), square.corners()), (2, 4));
        let solid = shape_of_columns("solid", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n").unwrap();
        assert_eq!((solid.dimension(), solid.corners()), (3, 4));
    }

    #[test]
    fn concave_files_are_refused_with_what_to_do() {
        // An L of three unit cubes, whose hull has the volume 3.5.
        let base = "0 0\n2 0\n2 1\n1 1\n1 2\n0 2\n";
        let words = format!("{:#}", shape_of_columns("ell", base).unwrap_err());
        assert!(
            words.contains("ell: ") && words.contains("join them with +"),
            "{words}"
        );
        let points: String = base
            .lines()
            .map(|line| format!("{line} 0\n{line} 1\n"))
            .collect();
        assert_eq!(shape_of_columns("points", &points).unwrap().corners(), 10);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ell.off");
        let vertices: String = [0, 1]
            .map(|z| base.replace('\n', &format!(" {z}\n")))
            .concat();
        let faces = "6 5 4 3 2 1 0\n6 6 7 8 9 10 11\n4 0 1 7 6\n4 1 2 8 7\n4 2 3 9 8\n4 3 4 10 9\n4 4 5 11 10\n4 5 0 6 11\n";
        std::fs::write(&file, format!("OFF\n12 8 0\n{vertices}{faces}")).unwrap();
        let words = format!("{:#}", read_shape(&file.display().to_string()).unwrap_err());
        assert!(
            words.contains("3.000000") && words.contains("3.500000"),
            "{words}"
        );
    }

    #[test]
    fn what_is_not_a_point_is_named_with_its_line() {
        for text in ["0 0\n1 2 3\n", "0 0 0\n1 2\n", "0 0\nx y\n", "0 0\n1\n"] {
            let words = shape_of_columns("file", text).unwrap_err().to_string();
            assert!(words.starts_with("file:2: "), "{words}");
        }
        assert!(shape_of_columns("file", "# nothing\n").is_err());
        let words = format!(
            "{:#}",
            shape_of_columns("file", "0 nan\n1 1\n").unwrap_err()
        );
        assert!(words.contains("finite"), "{words}");
    }
}
