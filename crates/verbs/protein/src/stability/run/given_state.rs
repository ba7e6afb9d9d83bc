//! Poses of the bodies of an assembly as a frame of a GSD file has them, whatever program wrote it.
//!
//! Files name the kinds of their bodies. These names are compared with those of the assembly; the names that other
//! programs give by default (`A`, `B`, …) say nothing, and kinds are then compared by their numbers.

use super::{Engine, RunSettings};
use crate::assemblies::assembly_file::Assembly;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_io::gsd::TrajectoryReader;
use protomer_kernel::Pose;
use protomer_mc::hard::overlapping_pairs;
use std::path::Path;

/// Largest difference of two edges of a box, as a part of them: far above the rounding of single precision.
const SAME_EDGE: f64 = 1e-5;

/// Poses of all bodies of an assembly, from a file.
///
/// ```no_run
/// use protomer_protein_verbs::assemblies::assembly_file::Assembly;
/// use protomer_protein_verbs::stability::run::{Engine, GivenState};
/// use std::path::Path;
/// let engine = Engine::new(Assembly::read(Path::new("ring.json"))?)?;
/// let last = GivenState::read(Path::new("run/salt_0.100000M/replica_0/trajectory.gsd"), None, &engine)?;
/// assert_eq!(last.poses.len(), engine.assembly().len());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GivenState {
    /// Pose of each body, Å.
    pub poses: Vec<Pose>,
}

impl GivenState {
    /// Reads a frame, counted from zero; without a number, the last one.
    ///
    /// # Errors
    /// If there is no such file or frame, for other bodies than those of the assembly, another box, and bodies that
    /// overlap.
    pub fn read(path: &Path, frame: Option<u64>, engine: &Engine) -> Result<Self> {
        if path.is_dir() {
            bail!(
                "--state {0} is a directory; give the trajectory.gsd of one of its simulations",
                path.display()
            );
        }
        let mut reader = TrajectoryReader::open(path)?;
        let Some(last) = reader.frames().checked_sub(1) else {
            bail!("{} holds no frame; give another file", path.display());
        };
        let number = frame.unwrap_or(last);
        let origin = format!("{}, frame {number}", path.display());
        let posed = reader.frame(number)?;
        let assembly = engine.assembly();
        let names = reader.type_names()?;
        check_bodies(&origin, &posed.type_ids, &names, assembly)?;
        check_box(
            &origin,
            &posed.box_lengths_angstrom,
            &posed.tilt_factors,
            assembly,
        )?;
        let system = engine
            .system_at(&posed.poses)
            .with_context(|| origin.clone())?;
        if let Some((first, second)) = overlapping_pairs(&system).first() {
            bail!(
                "{origin}: bodies {} and {} overlap; choose another --frame, or give the assembly whose bodies the file has",
                first + 1,
                second + 1
            );
        }
        Ok(Self { poses: posed.poses })
    }

    /// The state that settings want; `None` for the poses of the assembly.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn wanted(settings: &RunSettings, engine: &Engine) -> Result<Option<Self>> {
        let read = |path: &String| Self::read(Path::new(path), settings.frame, engine);
        settings.state.as_ref().map(read).transpose()
    }

    /// SHA-256 of everything that enters a run.
    pub fn sha256(&self) -> String {
        let numbers = self.poses.iter().flat_map(|pose| {
            let position: [f64; 3] = pose.position.into();
            position.into_iter().chain(pose.wxyz())
        });
        let bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        sha256_hex(&bytes)
    }
}

/// Refuses another number of bodies, and bodies of other kinds.
fn check_bodies(
    origin: &str,
    type_ids: &[u32],
    names: &[String],
    assembly: &Assembly,
) -> Result<()> {
    if type_ids.len() != assembly.len() {
        bail!(
            "{origin} has {} bodies, and the assembly has {}; give the assembly of the file",
            type_ids.len(),
            assembly.len()
        );
    }
    let has_names = !names
        .iter()
        .enumerate()
        .all(|(n, name)| is_default(n, name));
    for (body, (type_id, kind)) in type_ids.iter().zip(&assembly.kinds).enumerate() {
        let wanted = &assembly.bodies[*kind].name;
        let name = names.get(*type_id as usize);
        let is_same = match name.filter(|_| has_names) {
            Some(name) => name == wanted,
            None => *type_id as usize == *kind,
        };
        if !is_same {
            bail!(
                "{origin}: body {} is of kind {}, and in the assembly it is '{wanted}'; give the assembly of the file, or \
                 a file with the bodies in its order",
                body + 1,
                name.map_or_else(|| (type_id + 1).to_string(), |name| format!("'{name}'"))
            );
        }
    }
    Ok(())
}

/// Whether a kind has the name that programs give by default: A, B, ….
fn is_default(number: usize, name: &str) -> bool {
    let letter = u8::try_from(number).map(|number| char::from(b'A'.saturating_add(number)));
    letter.is_ok_and(|letter| name.chars().eq([letter]))
}

/// Refuses another periodic box than that of the assembly. Open space has none; files then have a box around the bodies.
fn check_box(
    origin: &str,
    lengths: &[f64; 3],
    tilt_factors: &[f64; 3],
    assembly: &Assembly,
) -> Result<()> {
    let Some(wanted) = assembly.box_angstrom() else {
        return Ok(());
    };
    let is_same = |(edge, wanted): (&f64, &f64)| (edge - wanted).abs() <= SAME_EDGE * wanted;
    if !lengths.iter().zip(&wanted).all(is_same) || tilt_factors.iter().any(|tilt| *tilt != 0.0) {
        bail!(
            "{origin} has the box {lengths:?} Å with tilt factors {tilt_factors:?}, and that of the assembly is {wanted:?} Å; \
             give the box of the file as \"box_angstrom\" in the assembly file"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_in_their_order_are_names_by_default() {
        assert!(is_default(0, "A") && is_default(1, "B"));
        assert!(!is_default(0, "B") && !is_default(0, "plus") && !is_default(300, "A"));
    }
}
