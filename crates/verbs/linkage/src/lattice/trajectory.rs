//! `trajectory.gsd`: squares as polygons, the ends of the rods as dots on their corners, the rods
//! as bonds between these.
//!
//! Particles 0 to n-1 are the squares; particles n + 2k and n + 2k + 1 are the two ends of rod k.

use anyhow::Result;
use protomer_io::gsd::{Chunk, ChunkData, FrameWriter, GsdFile};
use protomer_linkage::lattice::{Cell, Corner, Network, State};
use serde_json::json;
use std::f64::consts::FRAC_PI_4;
use std::path::Path;

/// Chunk with H_xx, H_yy and H_xy of a flexible cell.
pub(super) const CELL: &str = "log/cell";
/// Diameter of the dots on the corners.
const DOT_DIAMETER: f64 = 0.04;

/// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one).
///
/// # Errors
/// If the file cannot be written, or holds fewer frames than the checkpoint records.
pub fn open_trajectory(path: &Path, network: &Network, frames: u64) -> Result<FrameWriter> {
    Ok(FrameWriter::open(path, header(network)?, frames)?)
}

/// The position of a corner of a square with x, y, θ.
pub fn corner_position(network: &Network, positions: &[f64], corner: Corner) -> [f64; 2] {
    let s = &positions[3 * corner.square..3 * corner.square + 3];
    let (sine, cosine) = (s[2] + corner_angle(corner.vertex)).sin_cos();
    let half_diagonal = network.squares[corner.square].half_diagonal;
    [s[0] + half_diagonal * cosine, s[1] + half_diagonal * sine]
}

/// Angle of vertices 1 to 4 relative to θ, radians.
fn corner_angle(vertex: u8) -> f64 {
    match vertex {
        1 => 3.0 * FRAC_PI_4,
        2 => FRAC_PI_4,
        3 => 5.0 * FRAC_PI_4,
        _ => -FRAC_PI_4,
    }
}

/// The distinct sizes of squares in order of first appearance, and the index of the size of each
/// square.
fn sizes(network: &Network) -> (Vec<f64>, Vec<u32>) {
    let mut sizes: Vec<f64> = Vec::new();
    let mut kinds = Vec::with_capacity(network.squares.len());
    for square in &network.squares {
        let index = sizes.iter().position(|size| *size == square.half_diagonal);
        kinds.push(index.unwrap_or(sizes.len()) as u32);
        if index.is_none() {
            sizes.push(square.half_diagonal);
        }
    }
    (sizes, kinds)
}

/// The data that is the same in every frame.
pub(super) fn header(network: &Network) -> Result<Vec<Chunk>> {
    let (sizes, mut kinds) = sizes(network);
    let (mut names, mut shapes) = (Vec::new(), Vec::new());
    for (kind, size) in sizes.iter().enumerate() {
        names.push(format!("square{}", kind + 1));
        shapes.push(polygon(*size));
    }
    names.push("rod_end".into());
    shapes.push(json!({ "type": "Sphere", "diameter": DOT_DIAMETER }).to_string());
    let number_of_ends = 2 * network.rods.len();
    kinds.extend(vec![sizes.len() as u32; number_of_ends]);
    let squares = network.squares.len() as u32;
    let ends = (squares..squares + number_of_ends as u32).collect();
    let mut masses = Vec::with_capacity(kinds.len());
    for square in &network.squares {
        masses.push(square.mass as f32);
    }
    masses.extend(vec![1e-6; number_of_ends]);
    Ok(vec![
        Chunk::new("configuration/dimensions", 1, ChunkData::U8(vec![2])),
        Chunk::text("particles/types", &names)?,
        Chunk::text("particles/type_shapes", &shapes)?,
        Chunk::new("particles/typeid", 1, ChunkData::U32(kinds)),
        Chunk::new("particles/mass", 1, ChunkData::F32(masses)),
        Chunk::text("bonds/types", &["rod"])?,
        Chunk::new(
            "bonds/N",
            1,
            ChunkData::U32(vec![network.rods.len() as u32]),
        ),
        Chunk::new(
            "bonds/typeid",
            1,
            ChunkData::U32(vec![0; network.rods.len()]),
        ),
        Chunk::new("bonds/group", 2, ChunkData::U32(ends)),
    ])
}

/// The shape of a square of this size.
fn polygon(size: f64) -> String {
    // Counter-clockwise, as readers of the format expect.
    let vertices = [2, 1, 3, 4].map(|vertex: u8| {
        let (sine, cosine) = corner_angle(vertex).sin_cos();
        [(size * cosine) as f32, (size * sine) as f32]
    });
    json!({ "type": "Polygon", "rounding_radius": 0.0, "vertices": vertices }).to_string()
}

/// The data that changes from frame to frame.
pub fn frame(step: u64, network: &Network, state: &State, energy: f64) -> Vec<Chunk> {
    let (mut places, mut angles) = (Vec::new(), Vec::new());
    let squares = 3 * network.squares.len();
    let square_positions = &state.positions[..squares];
    for square in square_positions.chunks_exact(3) {
        places.push([square[0], square[1]]);
        angles.push(square[2]);
    }
    for corner in network.rods.iter().flat_map(|rod| [rod.from, rod.to]) {
        places.push(corner_position(network, &state.positions, corner));
        angles.push(0.0);
    }
    let cell = network.cell.map(|_| Cell::read(network, &state.positions));
    let lengths = match cell {
        Some(cell) => [cell.xx, cell.yy],
        None => enclosing(network, &places),
    };
    let tilt = cell.map_or(0.0, |cell| cell.xy / cell.yy);
    let mut positions = Vec::with_capacity(3 * places.len());
    for place in &places {
        let [x, y] = match cell {
            Some(cell) => inside(&cell, *place),
            None => *place,
        };
        positions.extend([x as f32, y as f32, 0.0]);
    }
    let mut orientations = Vec::with_capacity(4 * angles.len());
    for angle in angles {
        let (sine, cosine) = (0.5_f64 * angle).sin_cos();
        orientations.extend([cosine as f32, 0.0, 0.0, sine as f32]);
    }
    let mut chunks = vec![
        Chunk::new("configuration/step", 1, ChunkData::U64(vec![step])),
        Chunk::new(
            "configuration/box",
            1,
            ChunkData::F32(vec![
                lengths[0] as f32,
                lengths[1] as f32,
                0.0,
                tilt as f32,
                0.0,
                0.0,
            ]),
        ),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![places.len() as u32])),
        Chunk::new("particles/position", 3, ChunkData::F32(positions)),
        Chunk::new("particles/orientation", 4, ChunkData::F32(orientations)),
        Chunk::new("log/time", 1, ChunkData::F64(vec![state.time])),
        Chunk::new("log/energy", 1, ChunkData::F64(vec![energy])),
        Chunk::new(
            "log/positions",
            3,
            ChunkData::F64(square_positions.to_vec()),
        ),
    ];
    if state.positions.len() > squares {
        let cell = state.positions[squares..].to_vec();
        chunks.push(Chunk::new(CELL, 3, ChunkData::F64(cell)));
    }
    chunks
}

/// The image of a place in the box, as readers of the format expect.
fn inside(cell: &Cell, [x, y]: [f64; 2]) -> [f64; 2] {
    let up = (y / cell.yy).round();
    let right = ((x - cell.xy * up) / cell.xx).round();
    [x - cell.xx * right - cell.xy * up, y - cell.yy * up]
}

/// Edge lengths of a box that contains all squares, for a lattice without a cell.
fn enclosing(network: &Network, places: &[[f64; 2]]) -> [f64; 2] {
    let mut largest = 0.0_f64;
    for square in &network.squares {
        largest = largest.max(square.half_diagonal);
    }
    let mut furthest = [0.0_f64; 2];
    for place in places {
        for (furthest, x) in furthest.iter_mut().zip(place) {
            *furthest = furthest.max(x.abs());
        }
    }
    furthest.map(|furthest| 2.0 * (furthest + largest))
}

/// Reads the states of a trajectory: time, and x, y, θ of every square.
///
/// # Errors
/// If the file cannot be read, or is not the trajectory of a lattice.
pub fn read_states(path: &Path) -> Result<Vec<(f64, Vec<f64>)>> {
    let with_cells = read_states_with_cells(path)?;
    let states = with_cells.into_iter();
    Ok(states.map(|(time, squares, _)| (time, squares)).collect())
}

/// State of a frame: time, x, y, θ of every square, and the coordinates of a flexible cell, if there is one.
pub type StateWithCell = (f64, Vec<f64>, Vec<f64>);

/// Reads the states of a trajectory with their cells.
///
/// # Errors
/// As [`read_states`].
pub fn read_states_with_cells(path: &Path) -> Result<Vec<StateWithCell>> {
    let mut file = GsdFile::open(path)?;
    let mut states = Vec::new();
    for frame in 0..file.frames() {
        let mut numbers = |name: &str| match file.chunk(frame, name)? {
            Some(Chunk {
                data: ChunkData::F64(values),
                ..
            }) => Ok(Some(values)),
            None => Ok(None),
            Some(_) => Err(not_a_lattice(path, frame, name)),
        };
        let mut required = |name: &str| {
            let values: Result<Option<Vec<f64>>> = numbers(name);
            values?.ok_or_else(|| not_a_lattice(path, frame, name))
        };
        let time = required("log/time")?.first().copied().unwrap_or(f64::NAN);
        let squares = required("log/positions")?;
        states.push((time, squares, numbers(CELL)?.unwrap_or_default()));
    }
    Ok(states)
}

fn not_a_lattice(path: &Path, frame: u64, name: &str) -> anyhow::Error {
    anyhow::anyhow!(
        "{}: frame {frame} has no {name}; is it the trajectory of a lattice?",
        path.display()
    )
}
