//! Bodies where a file has them: a frame of a GSD file, whatever program wrote it.

use crate::hard_bodies::start::FLUID;
use crate::shape_words::ShapeWords;
use anyhow::{Context, Result, bail};
use nalgebra::Quaternion;
use protomer_common::live::{Arrays, Column, Live, Rows, refuse_others, require_rows, take};
use protomer_hpmc::crystal::UnitCell;
use protomer_io::atomic::sha256_hex;
use protomer_io::gsd::TrajectoryReader;
use protomer_kernel::{Rotation, Vec3};
use serde_json::Value;
use std::path::Path;

/// Whether a start is a state: a GSD file, or the directory of a run. The name of a start is that start, whatever directories
/// there are.
///
/// ```
/// use protomer_shape_verbs::given_state::is_state;
/// assert!(is_state("melt.gsd") && !is_state("fluid") && !is_state("fcc"));
/// ```
pub fn is_state(start: &str) -> bool {
    let path = Path::new(start);
    let is_name = start == FLUID
        || UnitCell::<1>::by_name(start).is_ok()
        || UnitCell::<2>::by_name(start).is_ok()
        || UnitCell::<3>::by_name(start).is_ok();
    !is_name
        && (path.is_dir()
            || path
                .extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("gsd")))
}

/// Bodies of a frame, from the middle of their box.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenState {
    /// File and frame, for messages.
    pub origin: String,
    /// Number of dimensions, 2 or 3.
    pub dimensions: usize,
    /// Edges of the box.
    pub lengths: [f64; 3],
    /// Tilt factors of the box: xy, xz, yz.
    pub tilt_factors: [f64; 3],
    /// Centres, from the middle of the box.
    pub positions: Vec<Vec3>,
    /// Orientations.
    pub rotations: Vec<Rotation>,
    /// Number of the kind of each body.
    pub kinds: Vec<usize>,
    /// Shapes of the kinds in the words of the schema; empty where the file has none.
    pub shapes: Vec<String>,
    /// Velocities of the centres, where the file has them.
    pub velocities: Option<Vec<Vec3>>,
    /// Angular momenta in the frame of each body, where the file has them.
    pub spins: Option<Vec<Vec3>>,
}

impl GivenState {
    /// Reads a frame of a GSD file; without a number, the last one.
    ///
    /// # Errors
    /// If the file cannot be read or has no such frame.
    pub fn read(path: &Path, frame: Option<u64>) -> Result<Self> {
        let mut reader = TrajectoryReader::open(path)?;
        let Some(last) = reader.frames().checked_sub(1) else {
            bail!("{} holds no frame; give another file", path.display());
        };
        let number = frame.unwrap_or(last);
        let frame = reader.frame(number)?;
        let poses = frame
            .poses
            .into_iter()
            .map(|pose| (pose.position, pose.rotation));
        let (positions, rotations) = poses.unzip();
        Ok(Self {
            origin: format!("{}, frame {number}", path.display()),
            dimensions: reader.dimensions(number)?,
            lengths: frame.box_lengths_angstrom,
            tilt_factors: frame.tilt_factors,
            positions,
            rotations,
            kinds: frame
                .type_ids
                .into_iter()
                .map(|kind| kind as usize)
                .collect(),
            shapes: reader.texts("particles/type_shapes")?,
            velocities: reader.vectors(number, "particles/velocity")?,
            spins: reader.vectors(number, "log/particles/spin")?,
        })
    }

    /// SHA-256 of everything in the state that enters a run.
    pub fn sha256(&self) -> String {
        let mut bytes = Vec::new();
        let mut add = |numbers: &[f64]| {
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        };
        add(&self.lengths);
        add(&self.tilt_factors);
        for position in &self.positions {
            add(position.as_slice());
        }
        for rotation in &self.rotations {
            add(rotation.coords.as_slice());
        }
        for vectors in [&self.velocities, &self.spins].into_iter().flatten() {
            vectors.iter().for_each(|vector| add(vector.as_slice()));
        }
        bytes.extend(
            self.kinds
                .iter()
                .flat_map(|kind| (*kind as u64).to_le_bytes()),
        );
        sha256_hex(&bytes)
    }

    /// Refuses a state whose bodies have other shapes than those that a run has been given, in the words of
    /// the schema. A file without shapes says nothing about them.
    ///
    /// # Errors
    /// Names the kind, the shape in the file and that of the run.
    pub fn check_shapes(&self, shapes: &[Value], names: &[String]) -> Result<()> {
        if let Some(kind) = self.kinds.iter().find(|kind| **kind >= shapes.len()) {
            bail!(
                "{} has a body of kind {}, and the run has {} {}; give a --shape for each kind of the file, in its order",
                self.origin,
                kind + 1,
                shapes.len(),
                if shapes.len() == 1 { "shape" } else { "shapes" },
            );
        }
        for (number, (shape, name)) in shapes.iter().zip(names).enumerate() {
            let Some(text) = self.shapes.get(number) else {
                continue;
            };
            let words =
                |what: &str| format!("{}: the shape of kind {} {what}", self.origin, number + 1);
            let found: Option<ShapeWords> =
                serde_json::from_str(text).with_context(|| words("cannot be read"))?;
            let wanted: Option<ShapeWords> = serde_json::from_value(shape.clone())?;
            if let (Some(found), Some(wanted)) = (found, wanted)
                && !found.is_empty()
                && !found.is_like(&wanted)
            {
                bail!(
                    "{} is {found}, and --shape {name} is {wanted}; give the shape and the rounding of the file",
                    words("in the file")
                );
            }
        }
        Ok(())
    }
}

/// Arrays of bodies that a caller gives: `positions` from the middle of the box, in a plane with two columns; `orientations`,
/// quaternions with the scalar first, or in a plane `angles` in radians; `velocities`, `spins`; and `box`, one row of edges
/// and, if it is tilted, tilt factors behind them. Bodies are not turned unless they are given so.
///
/// # Errors
/// Names the array that is missing or does not fit.
pub fn given_arrays(mut arrays: Arrays, dimensions: usize) -> Result<GivenState> {
    let column = |name, columns| Column { name, columns };
    let places = column("positions", dimensions);
    let Some(positions) = take(&mut arrays, places, None)? else {
        bail!("there is no array positions; give the centres of the bodies");
    };
    let positions: Vec<Vec3> = positions.chunks_exact(dimensions).map(in_space).collect();
    let count = positions.len();
    let space = arrays
        .remove("box")
        .map(|rows| rows.values)
        .unwrap_or_default();
    let (lengths, tilts) = match (dimensions, space.len()) {
        (2, 2 | 3) | (3, 3 | 6) => space.split_at(dimensions),
        (2, 6) => (&space[..2], &space[3..4]),
        (_, given) => bail!(
            "box has {given} numbers; give {dimensions} edges, and for a tilted box {} behind them",
            if dimensions == 2 { "xy" } else { "xy, xz, yz" }
        ),
    };
    let mut rotations = vec![Rotation::identity(); count];
    if let Some(angles) = take(&mut arrays, column("angles", 1), Some(count))? {
        for (rotation, angle) in rotations.iter_mut().zip(angles) {
            *rotation = Rotation::from_scaled_axis(angle * Vec3::z());
        }
    }
    if let Some(numbers) = take(&mut arrays, column("orientations", 4), Some(count))? {
        for (rotation, wxyz) in rotations.iter_mut().zip(numbers.as_chunks::<4>().0) {
            let [w, x, y, z] = *wxyz;
            let quaternion = Quaternion::new(w, x, y, z);
            if quaternion.norm() < 1e-6 {
                bail!(
                    "orientations holds a quaternion of zeros; give w, x, y, z, with 1, 0, 0, 0 for no turn"
                );
            }
            *rotation = Rotation::new_normalize(quaternion);
        }
    }
    let mut vectors = |name| -> Result<Option<Vec<Vec3>>> {
        let numbers = take(&mut arrays, column(name, 3), Some(count))?;
        Ok(numbers.map(|numbers| numbers.chunks_exact(3).map(in_space).collect()))
    };
    let (velocities, spins) = (vectors("velocities")?, vectors("spins")?);
    let kinds = take(&mut arrays, column("kinds", 1), Some(count))?;
    refuse_others(&arrays, &[places, column("orientations", 4)])?;
    Ok(GivenState {
        origin: "the arrays".into(),
        dimensions,
        lengths: in_space(lengths).into(),
        tilt_factors: in_space(tilts).into(),
        positions,
        rotations,
        kinds: kinds.map_or_else(
            || vec![0; count],
            |kinds| kinds.iter().map(|kind| *kind as usize).collect(),
        ),
        shapes: Vec::new(),
        velocities,
        spins,
    })
}

/// A vector of up to three numbers, with zeros for those that are missing.
fn in_space(numbers: &[f64]) -> Vec3 {
    Vec3::from_fn(|axis, _| numbers.get(axis).copied().unwrap_or(0.0))
}

/// The state of a simulation with these arrays in the place of its own, as [`given_arrays`] takes them.
///
/// # Errors
/// For arrays without a row for each body.
pub(crate) fn replaced(simulation: &dyn Live, mut arrays: Arrays) -> Result<Arrays> {
    require_rows(&arrays, simulation.count())?;
    let mut all = arrays_of(simulation);
    if arrays.contains_key("angles") {
        all.remove("orientations");
    }
    all.append(&mut arrays);
    Ok(all)
}

fn arrays_of(simulation: &dyn Live) -> Arrays {
    let mut arrays = Arrays::new();
    for Column { name, columns } in simulation.arrays() {
        let mut values = vec![0.0; columns * simulation.count()];
        simulation.copy(name, &mut values);
        arrays.insert(name.to_owned(), Rows { columns, values });
    }
    let values = simulation.space().to_vec();
    arrays.insert("box".into(), Rows { columns: 6, values });
    arrays
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn state(shapes: &[Value]) -> GivenState {
        GivenState {
            origin: "melt.gsd, frame 3".into(),
            dimensions: 2,
            lengths: [4.0, 4.0, 0.0],
            tilt_factors: [0.0; 3],
            positions: vec![Vec3::zeros()],
            rotations: vec![Rotation::identity()],
            kinds: vec![0],
            shapes: shapes.iter().map(Value::to_string).collect(),
            velocities: None,
            spins: None,
        }
    }

    #[test]
    fn corners_are_compared_whatever_their_order_and_precision() {
        let triangle =
            json!({ "type": "Polygon", "vertices": [[0.0, 1.0], [-0.8, -0.6], [0.8, -0.6]] });
        let same = json!({ "type": "Polygon", "rounding_radius": 0.0,
                           "vertices": [[0.8, -0.600_001, 0.0], [0.0, 1.0, 0.0], [-0.8, -0.6, 0.0]] });
        let names = ["polygon:3".to_owned()];
        let check = |file: &Value, run: &Value| {
            state(std::slice::from_ref(file)).check_shapes(std::slice::from_ref(run), &names)
        };
        check(&same, &triangle).unwrap();
        check(&json!({}), &triangle).unwrap();
        state(&[])
            .check_shapes(std::slice::from_ref(&triangle), &names)
            .unwrap();
        let rounded =
            json!({ "type": "Polygon", "rounding_radius": 0.1, "vertices": same["vertices"] });
        let message = check(&rounded, &triangle).unwrap_err().to_string();
        assert!(
            message.contains("melt.gsd, frame 3") && message.contains("rounded by 0.10000"),
            "{message}"
        );
        let disk = json!({ "type": "Sphere", "diameter": 1.0 });
        let message = check(&disk, &triangle).unwrap_err().to_string();
        assert!(
            message.contains("a Sphere of diameter 1.00000"),
            "{message}"
        );
    }

    #[test]
    fn a_kind_without_a_shape_is_named() {
        let two = GivenState {
            kinds: vec![1],
            ..state(&[])
        };
        let message = two
            .check_shapes(&[json!({})], &["disk".into()])
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("a body of kind 2") && message.contains("1 shape;"),
            "{message}"
        );
    }

    #[test]
    fn the_hash_sees_every_number() {
        let still = state(&[]);
        let moving = GivenState {
            velocities: Some(vec![Vec3::x()]),
            ..still.clone()
        };
        assert_ne!(still.sha256(), moving.sha256());
    }
}
