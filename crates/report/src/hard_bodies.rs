//! The pages of runs of hard bodies and of free energies of crystals.

use super::html::{definitions, paragraph, significant, table};
use super::mesh_view::{self, Scene, Shown, ShownMesh};
use super::page::{Page, Section};
use super::{data, figures, provenance};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_convex::hard_bodies::free_energy::FreeEnergyResult;
use protomer_convex::hard_bodies::log::LogRow;
use protomer_convex::hard_bodies::result::HardBodyResult;
use protomer_convex::hard_bodies::sweep::EquationOfState;
use protomer_io::gsd::{ChunkData, GsdFile, TrajectoryReader};
use protomer_kernel::shape::{Shape, hull::Hull};
use protomer_kernel::{TriangleMesh, Vec3};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys::read_json_if_present;
use protomer_results::{Record, log};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// The title of a sweep.
const SWEEP: &str = "Equation of state";
/// Rows of a log that are drawn.
const MOST_ROWS: usize = 500;
/// More bodies than this are slow to turn.
const MOST_BODIES: usize = 512;
/// Tilt factors of a box, in their order.
const TILTS: [&str; 3] = ["tilt factor xy", "tilt factor xz", "tilt factor yz"];
/// Points of a rounded corner in space, and in a plane.
const ON_SPHERE: usize = 92;
const ON_CIRCLE: usize = 24;

/// The page of a run.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_run(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<HardBodyResult> = details(record.as_ref(), directory)?;
    let rows: Vec<LogRow> = match directory.join("log.csv") {
        path if path.is_file() => log::read_so_far(&path)?,
        _ => Vec::new(),
    };
    let mut html = String::new();
    if let Some(result) = &result {
        html += &definitions(&values_of_run(result));
    }
    if !rows.is_empty() {
        let csv = data::of_file(directory, "log.csv")?;
        html += &figures::drawn(&course(&rows), &csv)?;
    }
    html += &data::of_file(directory, "profile.csv")?;
    let subtitle = result
        .as_ref()
        .map(|result| format!("{} bodies ({})", result.bodies, result.shape));
    page(
        directory,
        "Hard bodies",
        subtitle,
        html,
        "trajectory.gsd",
        record.as_ref(),
    )
}

/// The page of a sweep: the equation of state, and the bodies of its densest run.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_sweep(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let equation: Option<EquationOfState> = read_json_if_present(&directory.join("equation.json"))?;
    let (mut html, mut trajectory) = (String::new(), String::new());
    if let Some(equation) = &equation {
        let csv = data::of_file(directory, "equation.csv")?;
        if let Some(figure) = equation.figure() {
            html += &figures::drawn(&figure, &csv)?;
        }
        if let Some(task) = equation.settings.tasks(Path::new(""))?.pop() {
            let path = task.directory().join("trajectory.gsd");
            trajectory = path.display().to_string();
        }
    }
    let subtitle = equation.as_ref().map(|equation| {
        let run = &equation.settings.run;
        format!(
            "{} bodies ({}), {} states",
            run.bodies,
            run.shape,
            equation.points.len()
        )
    });
    page(
        directory,
        SWEEP,
        subtitle,
        html,
        &trajectory,
        record.as_ref(),
    )
}

/// The page of a free energy.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_free_energy(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<FreeEnergyResult> = details(record.as_ref(), directory)?;
    let mut html = String::new();
    if let Some(result) = &result {
        html += &terms(result);
        let csv = data::of_file(directory, "points.csv")?;
        html += &figures::drawn(&integrand(result), &csv)?;
        if !result.slow_points.is_empty() {
            html += &paragraph(
                "Some points have few independent samples; more sweeps would make their errors certain.",
            );
        }
    }
    let subtitle = result.as_ref().map(|result| {
        format!(
            "{} bodies ({}), {}",
            result.bodies, result.shape, result.crystal
        )
    });
    page(
        directory,
        "Free energy",
        subtitle,
        html,
        "crystal.gsd",
        record.as_ref(),
    )
}

fn page(
    directory: &Path,
    kind: &str,
    subtitle: Option<String>,
    results: String,
    trajectory: &str,
    record: Option<&Record>,
) -> Result<Page> {
    let mut problems: Vec<String> = provenance::unfinished(record).into_iter().collect();
    let mut sections = vec![Section::new("Results", results)];
    let trajectory = directory.join(trajectory);
    match bodies(&trajectory) {
        // A sweep may have been told to keep no trajectories.
        _ if !trajectory.is_file() && kind == SWEEP => {}
        Ok(section) => sections.push(section),
        Err(error) => problems.push(format!("The bodies cannot be shown: {error:#}")),
    }
    sections.push(provenance::section(
        directory,
        "run.toml",
        record,
        Vec::new(),
    )?);
    Ok(Page {
        title: format!("{kind}: {}", provenance::name(directory)),
        subtitle: subtitle.unwrap_or_else(|| "Not finished".into()),
        problems,
        sections,
    })
}

/// The result in the record; `None` before there is one.
fn details<T: DeserializeOwned>(record: Option<&Record>, directory: &Path) -> Result<Option<T>> {
    match record {
        Some(record) if !record.details.is_null() => Ok(record.read_details(directory).ok()),
        _ => Ok(None),
    }
}

fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} ± {}", significant(value, 6), significant(error, 2)),
        None => significant(value, 6),
    }
}

fn values_of_run(result: &HardBodyResult) -> Vec<(&'static str, String)> {
    let mut values = vec![
        (
            "Packing fraction",
            with_error(result.packing_fraction, result.packing_fraction_error),
        ),
        (
            "Compressibility factor",
            with_error(
                result.compressibility_factor,
                result.compressibility_factor_error,
            ),
        ),
        ("Sweeps", result.sweeps.to_string()),
        ("Accepted moves", significant(result.acceptance, 3)),
    ];
    if let Some(mean) = &result.mean_box {
        let several = |numbers: &[f64], errors: &[Option<f64>]| {
            let numbers = numbers.iter().zip(errors);
            let words: Vec<String> = numbers.map(|(x, error)| with_error(*x, *error)).collect();
            words.join(", ")
        };
        values.push((
            "Lengths of the box",
            several(&mean.lengths, &mean.length_errors),
        ));
        if !mean.tilt_factors.is_empty() {
            let tilts = several(&mean.tilt_factors, &mean.tilt_factor_errors);
            values.push(("Tilt factors of the box", tilts));
        }
    }
    if let Some(walls) = &result.walls {
        values.extend([
            (
                "Pressure at the lower wall",
                with_error(walls.lower_pressure, walls.lower_pressure_error),
            ),
            ("Weight per area", significant(walls.weight_per_area, 6)),
            (
                "Mean height",
                with_error(walls.mean_height, walls.mean_height_error),
            ),
        ]);
    }
    if let Some(potential) = result.excess_chemical_potential_kt {
        let error = result.excess_chemical_potential_error_kt;
        values.push((
            "Excess chemical potential (kT)",
            with_error(potential, error),
        ));
    }
    if let Some(fraction) = result.free_volume_fraction {
        let error = result.free_volume_fraction_error;
        values.push(("Free volume of depletants", with_error(fraction, error)));
    }
    values
}

/// The measurements against sweeps.
fn course(rows: &[LogRow]) -> Figure {
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    let panel = |label: &str, value: &dyn Fn(&LogRow) -> Option<f64>| {
        let points = rows.iter().step_by(every);
        let replicas: Vec<[f64; 2]> = points
            .filter_map(|row| Some([row.sweep as f64, value(row)?]))
            .collect();
        let series = Series {
            name: label.into(),
            replicas,
            ..Series::default()
        };
        Panel {
            y: Axis::linear(label),
            series: vec![series],
        }
    };
    let first = rows.first().map(|row| row.packing_fraction);
    let changes = rows.iter().any(|row| Some(row.packing_fraction) != first);
    let mut panels = vec![panel("compressibility factor", &|row| {
        Some(row.compressibility_factor)
    })];
    if changes {
        panels.push(panel("packing fraction", &|row| Some(row.packing_fraction)));
    }
    for (number, label) in TILTS.into_iter().enumerate() {
        let tilt = |row: &LogRow| row.box_tilt_factors.get(number).copied();
        if rows.iter().any(|row| tilt(row).is_some()) {
            panels.push(panel(label, &tilt));
        }
    }
    if rows.iter().any(|row| row.walls.is_some()) {
        panels.push(panel("mean height", &|row| Some(row.walls?.mean_height)));
    }
    if rows.iter().any(|row| !row.free_volume.is_empty()) {
        panels.push(panel("free volume fraction", &|row| {
            row.free_volume.first().copied()
        }));
    }
    Figure {
        title: "Course of the run".into(),
        caption: "single measurements".into(),
        x: Axis::linear("sweeps"),
        panels,
    }
}

fn terms(result: &FreeEnergyResult) -> String {
    let terms = &result.terms;
    let row = |name: &str, value: f64, error: Option<f64>| {
        vec![name.to_owned(), with_error(value, error)]
    };
    let rows = [
        row("centre of mass", terms.centre_of_mass_kt, None),
        row("strongest springs", terms.springs_kt, None),
        row("orientations", terms.orientations_kt, None),
        row(
            "overlaps with them",
            terms.overlaps_kt,
            Some(terms.overlaps_error_kt),
        ),
        row(
            "weaker springs",
            -terms.integral_kt,
            Some(terms.integral_error_kt),
        ),
        row("free energy", terms.total_kt, Some(terms.error_kt)),
        row(
            "excess over an ideal gas",
            result.excess_free_energy_per_body_kt,
            Some(result.excess_free_energy_per_body_error_kt),
        ),
        row(
            "difference to a coarser rule",
            terms.rules_difference_kt,
            Some(terms.rules_difference_error_kt),
        ),
    ];
    let head = ["term", "kT per body"];
    table(&head.map(str::to_owned), &rows)
}

/// What is integrated, against the logarithm of the strength.
fn integrand(result: &FreeEnergyResult) -> Figure {
    let mut points = Vec::new();
    for point in &result.points {
        points.push(Point {
            x: point.strength_kt_per_area,
            y: point.strength_kt_per_area * point.extent,
            error: Some(point.strength_kt_per_area * point.extent_error),
        });
    }
    let series = Series {
        name: "springs".into(),
        points,
        line: true,
        ..Series::default()
    };
    Figure {
        title: "Energy of the springs".into(),
        caption: "half of the degrees of freedom where bodies hardly meet".into(),
        x: Axis::log("strength of the springs λ"),
        panels: vec![Panel {
            y: Axis::linear("λ f (kT per body)"),
            series: vec![series],
        }],
    }
}

/// The shape in a trajectory, in the words of its schema.
#[derive(Debug, Deserialize)]
struct ShapeWords {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    diameter: f64,
    #[serde(default)]
    rounding_radius: f64,
    #[serde(default)]
    vertices: Vec<Vec<f64>>,
    /// Corners of the triangles of a mesh.
    #[serde(default)]
    indices: Vec<[u32; 3]>,
    /// Of a union of balls.
    #[serde(default)]
    centers: Vec<[f64; 3]>,
    #[serde(default)]
    diameters: Vec<f64>,
}

/// The last frame of a trajectory.
fn bodies(path: &Path) -> Result<Section> {
    let mut reader = TrajectoryReader::open(path)?;
    let Some(last) = reader.frames().checked_sub(1) else {
        bail!("{} holds no frame", path.display());
    };
    let frame = reader.frame(last)?;
    if frame.poses.len() > MOST_BODIES {
        let count = frame.poses.len();
        return Ok(Section::new(
            "Bodies",
            paragraph(&format!(
                "{count} bodies are not drawn; OVITO opens {}.",
                path.display()
            )),
        ));
    }
    let text = shape_text(path)?;
    let words: ShapeWords = serde_json::from_str(&text)
        .with_context(|| format!("{} has no shape that is understood", path.display()))?;
    let shown = Shown {
        meshes: vec![ShownMesh {
            name: "body".into(),
            mesh: mesh(&words)?,
            values: Vec::new(),
        }],
        colourings: Vec::new(),
        scenes: vec![Scene {
            name: format!("after {} sweeps", frame.step),
            bodies: frame.poses.into_iter().map(|pose| (0, pose)).collect(),
            colouring: None,
            film: None,
        }],
    };
    Ok(mesh_view::section(&shown, ""))
}

fn shape_text(path: &Path) -> Result<String> {
    let mut file = GsdFile::open(path)?;
    let chunk = file.chunk(0, "particles/type_shapes")?;
    let Some(ChunkData::I8(letters)) = chunk.map(|chunk| chunk.data) else {
        bail!("{} has no shape", path.display());
    };
    let bytes = letters.iter().map(|letter| *letter as u8);
    let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// What is drawn of a body.
fn mesh(words: &ShapeWords) -> Result<TriangleMesh> {
    match words.kind.as_str() {
        "Mesh" => Ok(TriangleMesh {
            vertices: words.vertices.iter().map(|vertex| point(vertex)).collect(),
            triangles: words.indices.clone(),
        }),
        "SphereUnion" => balls(&words.centers, &words.diameters),
        _ => hull(words),
    }
}

fn point(vertex: &[f64]) -> Vec3 {
    Vec3::from_fn(|axis, _| vertex.get(axis).copied().unwrap_or(0.0))
}

fn balls(centers: &[[f64; 3]], diameters: &[f64]) -> Result<TriangleMesh> {
    let mut all = TriangleMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    for (centre, diameter) in centers.iter().zip(diameters) {
        let points: Vec<Vec3> = sphere(0.5 * diameter)
            .into_iter()
            .map(|by| point(centre) + by)
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
        for by in &around {
            let point = corner + by;
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
    let at = |number: usize| {
        let (sine, cosine) = (TAU * number as f64 / ON_CIRCLE as f64).sin_cos();
        radius * Vec3::new(cosine, sine, 0.0)
    };
    (0..ON_CIRCLE).map(at).collect()
}

/// Points on a spiral of equal areas.
fn sphere(radius: f64) -> Vec<Vec3> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let at = |number: usize| {
        let height = 1.0 - (2.0 * number as f64 + 1.0) / ON_SPHERE as f64;
        let across = (1.0 - height * height).sqrt();
        let (sine, cosine) = (golden_angle * number as f64).sin_cos();
        radius * Vec3::new(across * cosine, across * sine, height)
    };
    (0..ON_SPHERE).map(at).collect()
}
