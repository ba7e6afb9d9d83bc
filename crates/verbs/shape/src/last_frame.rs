//! The bodies of a trajectory with convex shapes, or unions of them, as meshes to look at.

use crate::shape_words::ShapeWords;
use anyhow::{Context, Result, bail};
use protomer_common::page::scene::{Scene, Shown, ShownMesh};
use protomer_common::page::{Part, Section};
use protomer_io::gsd::{GsdFile, TrajectoryReader};
use protomer_kernel::quadrature::points_on_sphere;
use protomer_kernel::shape::{Shape, hull::Hull};
use protomer_kernel::{TriangleMesh, Vec3};
use std::f64::consts::TAU;
use std::path::Path;

/// Number of bodies beyond which a scene is slow to turn.
const MOST_BODIES: usize = 512;
/// Number of points of a rounded corner in space.
const ON_SPHERE: usize = 92;
/// Number of points of a rounded corner in a plane.
const ON_CIRCLE: usize = 24;

/// The section with the last frame of a trajectory; `unit` is what its steps count.
///
/// # Errors
/// If the trajectory is damaged, holds no frame, or has a shape that cannot be drawn.
pub fn section(path: &Path, unit: &str) -> Result<Section> {
    let mut reader = TrajectoryReader::open(path)?;
    let Some(last) = reader.frames().checked_sub(1) else {
        bail!("{} holds no frame", path.display());
    };
    let frame = reader.frame(last)?;
    if frame.poses.len() > MOST_BODIES {
        let count = frame.poses.len();
        let note = format!(
            "{count} bodies are not drawn; OVITO opens {}.",
            path.display()
        );
        return Ok(Section::new("Bodies", vec![Part::Paragraph(note)]));
    }
    let shapes = shapes(path)?;
    if frame
        .type_ids
        .iter()
        .any(|kind| *kind as usize >= shapes.len())
    {
        bail!("{} has a body without a shape", path.display());
    }
    let mut meshes = Vec::with_capacity(shapes.len());
    for (number, text) in shapes.iter().enumerate() {
        let words: Option<ShapeWords> = serde_json::from_str(text).ok();
        let stated = words.filter(|words| !words.is_empty());
        let words = stated
            .with_context(|| format!("{} has no shape that is understood", path.display()))?;
        meshes.push(ShownMesh {
            name: match shapes.len() {
                1 => "body".into(),
                _ => format!("body {}", number + 1),
            },
            mesh: mesh(&words)?,
            values: Vec::new(),
        });
    }
    let kinds = frame.type_ids.into_iter().map(|kind| kind as usize);
    let shown = Shown {
        scenes: vec![Scene {
            name: format!("after {} {unit}", frame.step),
            bodies: kinds.zip(frame.poses).collect(),
            colouring: None,
            film: None,
        }],
        meshes,
        colourings: Vec::new(),
    };
    Ok(Section::new("Bodies", vec![Part::Scenes(shown)]))
}

/// The texts of the shapes of a trajectory.
fn shapes(path: &Path) -> Result<Vec<String>> {
    let chunk = GsdFile::open(path)?.chunk(0, "particles/type_shapes")?;
    let shapes = chunk.and_then(|chunk| chunk.texts());
    shapes.with_context(|| format!("{} has no shape", path.display()))
}

/// Mesh that is drawn for a body.
fn mesh(words: &ShapeWords) -> Result<TriangleMesh> {
    match words.kind.as_str() {
        "Mesh" => Ok(two_sided_if_flat(TriangleMesh {
            vertices: words.vertices.iter().map(|vertex| point(vertex)).collect(),
            triangles: words.indices.clone(),
        })),
        "Ellipsoid" => ellipsoid([words.a, words.b, words.c]),
        "SphereUnion" => balls(&words.centers, &words.diameters),
        _ => hull(words),
    }
}

/// Adds the other side to a mesh in a plane, which is seen from both sides.
fn two_sided_if_flat(mut mesh: TriangleMesh) -> TriangleMesh {
    if mesh.vertices.iter().all(|vertex| vertex.z == 0.0) {
        let other_side = mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]);
        mesh.triangles.extend(other_side.collect::<Vec<_>>());
    }
    mesh
}

fn ellipsoid([a, b, c]: [f64; 3]) -> Result<TriangleMesh> {
    let points = sphere(1.0).into_iter();
    let points = points.map(|point| Vec3::new(a * point.x, b * point.y, c * point.z));
    of_solid(&points.collect::<Vec<_>>())
}

fn point(vertex: &[f64]) -> Vec3 {
    Vec3::from_fn(|axis, _| vertex.get(axis).copied().unwrap_or(0.0))
}

fn balls(centers: &[Vec<f64>], diameters: &[f64]) -> Result<TriangleMesh> {
    let mut all = TriangleMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    for (centre, diameter) in centers.iter().zip(diameters) {
        let points: Vec<Vec3> = sphere(0.5 * diameter)
            .into_iter()
            .map(|offset| point(centre) + offset)
            .collect();
        let ball = of_solid(&points)?;
        let first = all.vertices.len() as u32;
        all.vertices.extend(ball.vertices);
        let triangles = ball.triangles.into_iter();
        all.triangles
            .extend(triangles.map(|triangle| triangle.map(|corner| first + corner)));
    }
    Ok(all)
}

/// The hull of the corners, each with points of its rounding; polygons are thin plates.
fn hull(words: &ShapeWords) -> Result<TriangleMesh> {
    let is_flat = words.kind == "Polygon";
    let radius = words.rounding_radius.max(0.5 * words.diameter);
    let mut corners = Vec::new();
    for vertex in &words.vertices {
        corners.push(point(vertex));
    }
    if corners.is_empty() {
        corners.push(Vec3::zeros());
    }
    let around: Vec<Vec3> = match (radius > 0.0, is_flat) {
        (false, _) => vec![Vec3::zeros()],
        (true, true) => circle(radius),
        (true, false) => sphere(radius),
    };
    let size = corners.iter().map(Vec3::norm).fold(radius, f64::max);
    let mut points = Vec::new();
    for corner in &corners {
        for offset in &around {
            let point = corner + offset;
            if is_flat {
                points.push(point + 0.1 * size * Vec3::z());
                points.push(point - 0.1 * size * Vec3::z());
            } else {
                points.push(point);
            }
        }
    }
    of_solid(&points)
}

fn of_solid(points: &[Vec3]) -> Result<TriangleMesh> {
    match Shape::solid(points)? {
        Shape::Solid(Hull::Polyhedron(mesh)) => Ok(mesh),
        _ => bail!("a shape without volume cannot be drawn"),
    }
}

fn circle(radius: f64) -> Vec<Vec3> {
    let vertex = |number: usize| {
        let (sine, cosine) = (TAU * number as f64 / ON_CIRCLE as f64).sin_cos();
        radius * Vec3::new(cosine, sine, 0.0)
    };
    (0..ON_CIRCLE).map(vertex).collect()
}

fn sphere(radius: f64) -> Vec<Vec3> {
    let points = points_on_sphere(ON_SPHERE);
    points.map(|point| radius * point).collect()
}
