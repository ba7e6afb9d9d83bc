//! `trajectory.gsd`: the bodies with their shape, which OVITO draws.

use anyhow::Result;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::pieces::Piece;
use protomer_hpmc::system::System;
use protomer_io::gsd::{Chunk, ChunkData, FrameWriter};
use serde_json::{Value, json};
use std::path::Path;

/// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one). It says in which sweep
/// the equilibration ends, if there is one.
///
/// # Errors
/// If the file cannot be written, or holds fewer frames than the checkpoint records.
pub fn open_trajectory<const D: usize>(
    path: &Path,
    system: &System<D>,
    equilibration_sweeps: Option<u64>,
    frames: u64,
) -> Result<FrameWriter> {
    let mut header = header(system)?;
    header.extend(equilibration_sweeps.map(equilibration));
    Ok(FrameWriter::open(path, header, frames)?)
}

/// The sweep with which the equilibration ends: frames of later steps are of the measurement. Readers of GSD files
/// take what is logged in the first frame for all of them.
fn equilibration(sweeps: u64) -> Chunk {
    Chunk::new("log/equilibration_sweeps", 1, ChunkData::U64(vec![sweeps]))
}

/// The data that is the same in every frame.
pub(super) fn header<const D: usize>(system: &System<D>) -> Result<Vec<Chunk>> {
    let kinds = system.kinds();
    let names: Vec<String> = match kinds {
        [_] => vec!["body".into()],
        _ => (1..=kinds.len())
            .map(|number| format!("body{number}"))
            .collect(),
    };
    let shapes: Vec<String> = kinds.iter().map(|kind| shape(kind).to_string()).collect();
    Ok(vec![
        Chunk::new(
            "configuration/dimensions",
            1,
            ChunkData::U8(vec![D.max(2) as u8]),
        ),
        Chunk::text("particles/types", &names)?,
        Chunk::new(
            "particles/typeid",
            1,
            ChunkData::U32(system.kind_of().to_vec()),
        ),
        Chunk::text("particles/type_shapes", &shapes)?,
    ])
}

/// The shape in the words of the schema.
pub(super) fn shape<const D: usize>(body: &HardBody<D>) -> Value {
    let rounding = body.rounding_radius;
    if body.is_round() {
        return json!({ "type": "Sphere", "diameter": 2.0 * rounding });
    }
    if let Some(axes) = body.half_axes() {
        // In a plane the third half axis is the shorter one, as the trajectories of contact dynamics have it.
        let third = axes.get(2).copied().unwrap_or(axes[0].min(axes[D - 1]));
        return json!({ "type": "Ellipsoid", "a": axes[0], "b": axes[D.min(2) - 1], "c": third });
    }
    if let Some(pieces) = body.pieces() {
        return shape_of_pieces(pieces.pieces(), rounding);
    }
    let corner = |corner: &[f64; D]| -> Vec<f32> { corner.iter().map(|x| *x as f32).collect() };
    let vertices: Vec<Vec<f32>> = body.corners.iter().map(corner).collect();
    let kind = match D {
        2 => "Polygon",
        _ => "ConvexPolyhedron",
    };
    json!({ "type": kind, "rounding_radius": rounding, "vertices": vertices })
}

/// Balls, or the faces of all pieces, without their rounding.
fn shape_of_pieces<const D: usize>(pieces: &[Piece<D>], rounding: f64) -> Value {
    let in_space = |place: &[f64; D], from: &[f64; D]| -> [f32; 3] {
        std::array::from_fn(|axis| match axis < D {
            true => (place[axis] + from[axis]) as f32,
            false => 0.0,
        })
    };
    if pieces.iter().all(|piece| piece.corners.len() == 1) {
        let origin = [0.0; D];
        let centers: Vec<[f32; 3]> = pieces
            .iter()
            .map(|piece| in_space(&piece.centre, &origin))
            .collect();
        let diameters = vec![2.0 * rounding; pieces.len()];
        return json!({ "type": "SphereUnion", "centers": centers, "diameters": diameters });
    }
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for piece in pieces {
        let numbers: Vec<usize> = piece
            .corners
            .iter()
            .map(|corner| number_of(in_space(corner, &piece.centre), &mut vertices))
            .collect();
        // The corners of a polygon are in their order, those of a face too.
        let polygon: Vec<usize> = (0..numbers.len()).collect();
        let faces = match D {
            2 => std::slice::from_ref(&polygon),
            _ => &piece.faces,
        };
        for face in faces {
            for pair in face[1..].windows(2) {
                triangles.push([face[0], pair[0], pair[1]].map(|corner| numbers[corner]));
            }
        }
    }
    json!({ "type": "Mesh", "vertices": vertices, "indices": triangles })
}

/// The number of a vertex, which is added if it is not there: pieces that touch share vertices.
fn number_of(vertex: [f32; 3], vertices: &mut Vec<[f32; 3]>) -> usize {
    let size = vertex.iter().fold(1e-3_f32, |size, x| size.max(x.abs()));
    let is_same = |other: &[f32; 3]| {
        let gaps = vertex.iter().zip(other).map(|(a, b)| (a - b).abs());
        gaps.fold(0.0, f32::max) < 1e-5 * size
    };
    vertices.iter().position(is_same).unwrap_or_else(|| {
        vertices.push(vertex);
        vertices.len() - 1
    })
}

/// The data that changes from frame to frame; the box is centred on the origin, and given by its lengths and
/// tilt factors.
pub fn frame<const D: usize>(sweep: u64, system: &System<D>) -> Vec<Chunk> {
    let space = system.space();
    let middle = space.point(&[0.5; D]);
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for (place, rotation) in system.positions().iter().zip(system.rotations()) {
        let mut centre = [0.0_f32; 3];
        for axis in 0..D {
            centre[axis] = (place[axis] - middle[axis]) as f32;
        }
        positions.extend(centre);
        let q = rotation.quaternion();
        orientations.extend([q.w, q.i, q.j, q.k].map(|x| x as f32));
    }
    // Without a depth a box is flat; a line is drawn as a strip.
    let mut numbers = vec![0.0; 6];
    for (number, length) in numbers.iter_mut().zip(space.lengths()) {
        *number = *length as f32;
    }
    for (number, factor) in numbers[3..].iter_mut().zip(space.tilt_factors()) {
        *number = factor as f32;
    }
    if D == 1 {
        let radii = system.kinds().iter().map(|kind| kind.outer_radius);
        numbers[1] = 2.0 * radii.fold(0.0, f64::max) as f32;
    }
    vec![
        Chunk::new("configuration/step", 1, ChunkData::U64(vec![sweep])),
        Chunk::new("configuration/box", 1, ChunkData::F32(numbers)),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![system.len() as u32])),
        Chunk::new("particles/position", 3, ChunkData::F32(positions)),
        Chunk::new("particles/orientation", 4, ChunkData::F32(orientations)),
    ]
}
