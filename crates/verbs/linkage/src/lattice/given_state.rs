//! Squares where another simulation left them: a frame of a GSD file, the directory of a run, or arrays.
//!
//! Squares are the first particles of a file; what follows them, such as the ends of the rods, is not read. Files in single
//! precision are off the rods by their rounding, so every state is brought onto the rods.

use super::run::saved_state;
use super::settings::LatticeSettings;
use super::trajectory::CELL;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_io::gsd::{Chunk, ChunkData, GsdFile, TrajectoryReader};
use protomer_linkage::lattice::{Cell, Network, Started, State};
use std::path::Path;

/// Largest distance by which a state may be off the rods, half-diagonals and radians: far above the rounding of single
/// precision, far below a rod of another length.
const LARGEST_SHIFT: f64 = 1e-3;

/// Squares, as a file, a run or arrays have them.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenState {
    /// Source, for messages.
    pub origin: String,
    /// x, y, θ of each square, and perhaps the components of a flexible cell.
    pub positions: Vec<f64>,
    /// ẋ, ẏ, ω of each square, and perhaps the rates of the cell; `None` for those of the settings.
    pub velocities: Option<Vec<f64>>,
}

impl GivenState {
    /// Reads the state of a GSD file, by the number of its frame or else the last, or of a run's directory.
    ///
    /// # Errors
    /// If there is no such file, frame or checkpoint, or a frame has too few particles.
    pub fn read(start: &str, frame: Option<u64>, squares: usize) -> Result<Self> {
        let path = Path::new(start);
        match (path.is_dir(), frame) {
            (true, Some(_)) => bail!(
                "--frame is for a GSD file, and {start} is a directory, of which the last state counts; give {start}/trajectory.gsd"
            ),
            (true, None) => {
                let state = saved_state(path)?;
                Ok(Self {
                    origin: start.to_owned(),
                    positions: state.positions,
                    velocities: Some(state.velocities),
                })
            }
            (false, frame) => Self::of_file(path, frame, squares),
        }
    }

    fn of_file(path: &Path, frame: Option<u64>, squares: usize) -> Result<Self> {
        let mut reader = TrajectoryReader::open(path)?;
        let Some(last) = reader.frames().checked_sub(1) else {
            bail!("{} holds no frame; give another file", path.display());
        };
        let number = frame.unwrap_or(last);
        let origin = format!("{}, frame {number}", path.display());
        // Trajectories of lattices hold the state in double precision, across the edges of the cell.
        let exact = GsdFile::open(path)?.chunk(number, "log/positions")?;
        if let Some(Chunk {
            data: ChunkData::F64(positions),
            ..
        }) = exact
        {
            let cell = GsdFile::open(path)?.chunk(number, CELL)?;
            return Ok(Self {
                origin,
                positions: match cell.map(|chunk| chunk.data) {
                    Some(ChunkData::F64(cell)) => [positions, cell].concat(),
                    _ => positions,
                },
                velocities: None,
            });
        }
        let frame = reader.frame(number)?;
        if frame.poses.len() < squares {
            bail!(
                "{origin} has {} particles, and the lattice has {squares} squares; give its --rows and --columns",
                frame.poses.len()
            );
        }
        let mut positions = Vec::with_capacity(3 * squares);
        for pose in &frame.poses[..squares] {
            let turn = pose.rotation.coords;
            if turn.x.hypot(turn.y) > 1e-4 {
                bail!(
                    "{origin}: a square is turned out of the plane; give rotations about the third axis only"
                );
            }
            let angle_rad = 2.0 * turn.z.atan2(turn.w);
            positions.extend([pose.position.x, pose.position.y, angle_rad]);
        }
        Ok(Self {
            origin,
            positions,
            velocities: None,
        })
    }

    /// SHA-256 of everything that enters a run.
    pub fn sha256(&self) -> String {
        let numbers = self
            .positions
            .iter()
            .chain(self.velocities.iter().flatten());
        let bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
        sha256_hex(&bytes)
    }

    /// The state on the rods of a network, with velocities that they allow.
    ///
    /// # Errors
    /// For another number of squares, and squares that are off their rods.
    pub(super) fn on_rods(&self, network: &Network, settings: &LatticeSettings) -> Result<Started> {
        let needed = network.squares.len();
        let has_cell = self.positions.len() == network.coordinates();
        let found = if has_cell {
            needed
        } else {
            self.positions.len() / 3
        };
        if found != needed {
            bail!(
                "{} has {found} squares, and the lattice has {needed}; give its --rows and --columns",
                self.origin
            );
        }
        if settings.angle_spread > 0.0 {
            bail!(
                "--angle-spread turns the squares of a coherent start, and the squares start as in {}; leave it out",
                self.origin
            );
        }
        let mut state = State {
            time: 0.0,
            positions: self.positions.clone(),
            velocities: self
                .velocities
                .clone()
                .unwrap_or_else(|| vec![0.0; self.positions.len()]),
        };
        if !has_cell && network.cell_mass.is_some() {
            // Squares from elsewhere: the cell is that of the settings, at rest.
            state.positions.extend(Cell::coherent(network).components());
            state.velocities.extend([0.0; 3]);
        }
        let first_state = settings.first_state();
        let started = first_state
            .build_from(network, state, self.velocities.is_some())
            .with_context(|| format!("{}: squares cannot be joined by these rods", self.origin))?;
        let moved = self.positions.iter().zip(&started.state.positions);
        let largest = moved.fold(0.0_f64, |largest, (from, to)| {
            largest.max((to - from).abs())
        });
        if largest > LARGEST_SHIFT {
            bail!(
                "{}: squares are off their rods by up to {largest:.2e}; give the --r0, --edges and --start of the lattice that \
                 the state is from",
                self.origin
            );
        }
        Ok(started)
    }
}
