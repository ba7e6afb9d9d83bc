//! `trajectory.gsd`: bodies with their shapes in HOOMD's schema, which OVITO and freud read.
//!
//! Positions are wrapped into the box. `log/particles/unwrapped_position` (and in a plane
//! `log/particles/unwrapped_angle`) lead through its faces and through full turns.

use anyhow::Result;
use protomer_io::gsd::{Chunk, ChunkData, FrameWriter};
use protomer_kernel::{Boundary, Vec3};
use protomer_md::body::Kind;
use protomer_md::body::part::Part;
use protomer_md::engine::Engine;
use protomer_md::state::{Bodies, State};
use serde_json::{Value, json};
use std::path::Path;

/// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one).
///
/// # Errors
/// If the file cannot be written, or holds fewer frames than the checkpoint records.
pub fn open_trajectory(path: &Path, bodies: &Bodies, frames: u64) -> Result<FrameWriter> {
    Ok(FrameWriter::open(path, header(bodies)?, frames)?)
}

/// The data that is the same in every frame.
pub(super) fn header(bodies: &Bodies) -> Result<Vec<Chunk>> {
    let (mut names, mut shapes) = (Vec::new(), Vec::new());
    for (number, kind) in bodies.kinds.iter().enumerate() {
        names.push(format!("body{}", number + 1));
        shapes.push(shape(kind).to_string());
    }
    let count = bodies.count();
    let kinds = bodies.kind_of.iter().map(|kind| *kind as u32).collect();
    let (mut masses, mut moments) = (Vec::new(), Vec::new());
    for body in 0..count {
        let kind = bodies.kind(body);
        masses.push(kind.mass as f32);
        moments.extend(kind.moments.iter().map(|moment| *moment as f32));
    }
    let dimensions = vec![bodies.dimension() as u8];
    Ok(vec![
        Chunk::new("configuration/dimensions", 1, ChunkData::U8(dimensions)),
        Chunk::text("particles/types", &names)?,
        Chunk::text("particles/type_shapes", &shapes)?,
        Chunk::new("particles/typeid", 1, ChunkData::U32(kinds)),
        Chunk::new("particles/mass", 1, ChunkData::F32(masses)),
        Chunk::new("particles/moment_inertia", 3, ChunkData::F32(moments)),
    ])
}

/// The shape of a kind, as viewers read it; a union of parts is a mesh.
pub(super) fn shape(kind: &Kind) -> Value {
    match kind.parts.as_slice() {
        [part] => shape_of_part(part),
        parts => mesh(parts),
    }
}

fn shape_of_part(part: &Part) -> Value {
    let corners = &part.polytope.corners;
    match (part.half_axes, part.dimension) {
        (Some(axes), 2) => {
            json!({ "type": "Ellipsoid", "a": axes.x, "b": axes.y, "c": axes.x.min(axes.y) })
        }
        (Some(axes), _) => json!({ "type": "Ellipsoid", "a": axes.x, "b": axes.y, "c": axes.z }),
        (None, _) if part.is_ball() => json!({ "type": "Sphere", "diameter": 2.0 * part.radius }),
        (None, 2) => {
            let corners: Vec<[f64; 2]> = corners.iter().map(|x| [x.x, x.y]).collect();
            json!({ "type": "Polygon", "rounding_radius": part.radius, "vertices": corners })
        }
        (None, _) => {
            let corners: Vec<[f64; 3]> = corners.iter().map(|x| (*x).into()).collect();
            json!({ "type": "ConvexPolyhedron", "rounding_radius": part.radius, "vertices": corners })
        }
    }
}

/// The faces of all parts as triangles, without rounding; in a plane the parts themselves.
fn mesh(parts: &[Part]) -> Value {
    let (mut corners, mut triangles): (Vec<[f64; 3]>, Vec<[usize; 3]>) = (Vec::new(), Vec::new());
    for part in parts {
        let before = corners.len();
        let polytope = &part.polytope;
        corners.extend(
            polytope
                .corners
                .iter()
                .map(|x| <[f64; 3]>::from(x + part.centre)),
        );
        let mut fan = |rim: &[usize]| {
            for place in 1..rim.len().saturating_sub(1) {
                triangles.push([rim[0], rim[place], rim[place + 1]].map(|corner| before + corner));
            }
        };
        match part.dimension {
            2 => fan(&(0..polytope.corners.len()).collect::<Vec<usize>>()),
            _ => polytope.faces.iter().for_each(|face| fan(&face.corners)),
        }
    }
    json!({ "type": "Mesh", "vertices": corners, "indices": triangles })
}

/// The data that changes from frame to frame.
pub fn frame(step: u64, time: f64, engine: &Engine) -> Vec<Chunk> {
    let state = &engine.motion().state;
    let is_flat = engine.bodies().dimension() == 2;
    let lengths = lengths(state, is_flat);
    let wrapped: Vec<Vec3> = state
        .positions
        .iter()
        .map(|x| state.space.wrap(x))
        .collect();
    let turns = |body: usize| {
        let rotation = state.rotation(body);
        let q = rotation.quaternion();
        [q.w, q.i, q.j, q.k]
    };
    let turns: Vec<f32> = (0..wrapped.len())
        .flat_map(turns)
        .map(|part| part as f32)
        .collect();
    let mut chunks = vec![
        Chunk::new("configuration/step", 1, ChunkData::U64(vec![step])),
        Chunk::new("configuration/box", 1, ChunkData::F32(lengths)),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![wrapped.len() as u32])),
        Chunk::new("particles/position", 3, ChunkData::F32(single(&wrapped))),
        Chunk::new("particles/orientation", 4, ChunkData::F32(turns)),
        Chunk::new(
            "particles/velocity",
            3,
            ChunkData::F32(single(&state.velocities)),
        ),
        Chunk::new("log/time", 1, ChunkData::F64(vec![time])),
        Chunk::new("log/energy", 1, ChunkData::F64(vec![engine.energy()])),
        Chunk::new(
            "log/particles/unwrapped_position",
            3,
            ChunkData::F64(state.positions.iter().flatten().copied().collect()),
        ),
        Chunk::new(
            "log/particles/spin",
            3,
            ChunkData::F64(state.spins.iter().flatten().copied().collect()),
        ),
    ];
    if is_flat {
        let angles = ChunkData::F64(state.angles_rad.clone());
        chunks.push(Chunk::new("log/particles/unwrapped_angle", 1, angles));
    }
    chunks
}

/// Edges and tilts of the box.
fn lengths(state: &State, is_flat: bool) -> Vec<f32> {
    let lengths = match state.space {
        Boundary::Periodic { lengths_angstrom } => lengths_angstrom,
        Boundary::Open | Boundary::SphereWall { .. } => Vec3::zeros(),
    };
    let third = if is_flat { 0.0 } else { lengths.z };
    [lengths.x, lengths.y, third, 0.0, 0.0, 0.0]
        .map(|x| x as f32)
        .to_vec()
}

fn single(vectors: &[Vec3]) -> Vec<f32> {
    vectors.iter().flatten().map(|x| *x as f32).collect()
}
