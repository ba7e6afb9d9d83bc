//! Hard bodies that begin where another simulation left them: a frame of a GSD file, or a run's directory.

use super::kinds::Shapes;
use super::run::saved_state;
use super::settings::HardBodySettings;
use super::start::cell_text;
use super::trajectory::shape;
use crate::given_state::{GivenState, is_state};
use anyhow::{Context, Result, bail};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::start::Placed;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;
use std::path::Path;

/// Largest relative difference of the packing fraction of a state from that of the settings.
const SAME: f64 = 1e-9;

/// A state, and the hash of all that is in it.
pub(super) struct State<const D: usize> {
    pub(super) placed: Placed<D>,
    pub(super) kind_of: Vec<u32>,
    pub(super) sha256: String,
}

impl<const D: usize> State<D> {
    /// Part of the box that bodies of these kinds fill.
    pub(super) fn packing_fraction(&self, kinds: &[HardBody<D>]) -> f64 {
        let volumes = self
            .kind_of
            .iter()
            .filter_map(|kind| kinds.get(*kind as usize));
        let volume: f64 = volumes.map(|kind| kind.volume).sum();
        let mean = volume / self.kind_of.len().max(1) as f64;
        self.placed.packing_fraction(mean)
    }
}

/// The settings with the number of bodies and the packing fraction of the state in which they start. Numbers that were
/// given must be those of the state.
///
/// # Errors
/// For a state that cannot be read or does not have the shape of the settings, and for numbers that it does not have.
pub fn with_state(
    settings: HardBodySettings,
    bodies: Option<usize>,
    packing_fraction: Option<f64>,
) -> Result<HardBodySettings> {
    settings.check_start()?;
    let shape = Shapes::read(&settings)?;
    match shape.dimension() {
        1 => resolve::<1>(settings, &shape, bodies, packing_fraction),
        2 => resolve::<2>(settings, &shape, bodies, packing_fraction),
        _ => resolve::<3>(settings, &shape, bodies, packing_fraction),
    }
}

fn resolve<const D: usize>(
    settings: HardBodySettings,
    shape: &Shapes,
    bodies: Option<usize>,
    packing_fraction: Option<f64>,
) -> Result<HardBodySettings> {
    let state = read(&settings, &shape.kinds::<D>(&settings)?)?;
    let start = &settings.start;
    let (count, packing) = (
        state.kind_of.len(),
        state.packing_fraction(&shape.kinds(&settings)?),
    );
    if let Some(given) = bodies.filter(|given| *given != count) {
        bail!("--bodies is {given}, and {start} has {count}; leave --bodies out");
    }
    if let Some(given) = packing_fraction.filter(|given| !is_same(*given, packing)) {
        bail!(
            "--packing-fraction is {given}, and that of {start} is {packing}; leave --packing-fraction out (a --pressure \
             changes the box)"
        );
    }
    Ok(HardBodySettings {
        bodies: count,
        packing_fraction: packing,
        ..settings
    })
}

/// Text that says what bodies start from, for the identity of the work: that of the file of a unit cell, or the hash of a
/// state; `None` for a name.
///
/// # Errors
/// If the file or the state cannot be read.
pub(super) fn start_text(settings: &HardBodySettings, shape: &Shapes) -> Result<Option<String>> {
    if !is_state(&settings.start) {
        return cell_text(&settings.start);
    }
    Ok(Some(match shape.dimension() {
        1 => read::<1>(settings, &shape.kinds(settings)?)?.sha256,
        2 => read::<2>(settings, &shape.kinds(settings)?)?.sha256,
        _ => read::<3>(settings, &shape.kinds(settings)?)?.sha256,
    }))
}

fn is_same(first: f64, second: f64) -> bool {
    (first - second).abs() <= SAME * second
}

/// The state in which settings start.
///
/// # Errors
/// As [`with_state`]; also if the state has changed since the settings were made.
pub(super) fn placed<const D: usize>(
    settings: &HardBodySettings,
    kinds: &[HardBody<D>],
) -> Result<State<D>> {
    let state = read(settings, kinds)?;
    let (count, packing) = (state.kind_of.len(), state.packing_fraction(kinds));
    if count != settings.bodies || !is_same(settings.packing_fraction, packing) {
        bail!(
            "{} has {count} bodies at a packing fraction of {packing}, and the settings have {} at {}; give those of the state",
            settings.start,
            settings.bodies,
            settings.packing_fraction
        );
    }
    Ok(state)
}

fn read<const D: usize>(settings: &HardBodySettings, kinds: &[HardBody<D>]) -> Result<State<D>> {
    let path = Path::new(&settings.start);
    if !path.is_dir() {
        let given = GivenState::read(path, settings.frame)?;
        return of_file(&given, settings, kinds);
    }
    if settings.frame.is_some() {
        bail!(
            "--frame is for a GSD file, and {0} is a directory, of which the last state counts; give {0}/trajectory.gsd",
            settings.start
        );
    }
    of_directory(path, settings)
}

/// The bodies of a frame.
pub(super) fn of_file<const D: usize>(
    given: &GivenState,
    settings: &HardBodySettings,
    kinds: &[HardBody<D>],
) -> Result<State<D>> {
    if given.dimensions != D.max(2) {
        bail!(
            "{} has {} dimensions, and --shape {} has {D}; give a shape of the same space",
            given.origin,
            given.dimensions,
            settings.shape.join(", ")
        );
    }
    let shapes: Vec<_> = kinds.iter().map(shape).collect();
    given.check_shapes(&shapes, &settings.shape)?;
    let lengths: [f64; D] = std::array::from_fn(|axis| given.lengths[axis]);
    // xy, xz, yz in space, xy in a plane.
    let tilts = &given.tilt_factors[..D * (D - 1) / 2];
    let space = PeriodicBox::new(lengths, tilts).with_context(|| given.origin.clone())?;
    let middle = space.point(&[0.5; D]);
    let place =
        |centre: &protomer_kernel::Vec3| std::array::from_fn(|axis| centre[axis] + middle[axis]);
    if D == 2 {
        given
            .rotations
            .iter()
            .try_for_each(|rotation| in_plane(rotation, &given.origin))?;
    }
    Ok(State {
        placed: Placed {
            space,
            positions: given.positions.iter().map(place).collect(),
            rotations: given.rotations.clone(),
            has_walls: settings.gravity.is_some(),
        },
        kind_of: given.kinds.iter().map(|kind| *kind as u32).collect(),
        sha256: given.sha256(),
    })
}

/// Refuses a rotation that leads out of the plane.
fn in_plane(rotation: &Rotation, origin: &str) -> Result<()> {
    let out = rotation.coords.x.hypot(rotation.coords.y);
    if out > 1e-4 {
        bail!(
            "{origin}: a body is turned out of the plane; give rotations about the third axis only"
        );
    }
    Ok(())
}

/// The bodies of a run, as its checkpoint has them to the last bit.
fn of_directory<const D: usize>(path: &Path, settings: &HardBodySettings) -> Result<State<D>> {
    let (theirs, state) = saved_state(path)?;
    let is_same_shape = Shapes::read(&theirs)? == Shapes::read(settings)?
        && theirs.rounding_radius == settings.rounding_radius
        && theirs.spread == settings.spread;
    if !is_same_shape {
        bail!(
            "{} has the shape {}, rounded by {}, and --shape is {}, rounded by {}; give the shape of that run",
            path.display(),
            theirs.shape.join(", "),
            theirs.rounding_radius,
            settings.shape.join(", "),
            settings.rounding_radius
        );
    }
    let text = serde_json::to_string(&(
        &state.lengths,
        &state.tilt_factors,
        &state.positions,
        &state.orientations_wxyz,
    ))?;
    let kind_of = match (theirs.shape.len(), is_state(&theirs.start)) {
        (1, _) => vec![0; state.orientations_wxyz.len()],
        (_, false) => Shapes::read(&theirs)?
            .mixture::<D>(&theirs)?
            .kind_of()
            .to_vec(),
        (_, true) => {
            let kinds = Shapes::read(&theirs)?.kinds::<D>(&theirs)?;
            placed(&theirs, &kinds)?.kind_of
        }
    };
    Ok(State {
        kind_of,
        placed: state.placed(settings.gravity.is_some())?,
        sha256: sha256_hex(text.as_bytes()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard_bodies::run::run_hard_bodies;
    use protomer_results::Execution;

    fn settings(start: &Path) -> HardBodySettings {
        HardBodySettings {
            shape: "polygon:5".into(),
            start: start.display().to_string(),
            equilibration: 20,
            sweeps: 40,
            trajectory_every: 20,
            ..HardBodySettings::default()
        }
    }

    /// A run of pentagons to start from; its folder must live as long.
    fn first_run() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("first");
        let fluid = HardBodySettings {
            start: "fluid".into(),
            bodies: 50,
            packing_fraction: 0.5,
            ..settings(Path::new(""))
        };
        run_hard_bodies(&fluid, &path, &Execution::default()).unwrap();
        (folder, path)
    }

    #[test]
    fn a_run_starts_where_another_stands() {
        let (folder, first) = first_run();
        let (_, theirs) = saved_state(&first).unwrap();
        let resolved = with_state(settings(&first), None, None).unwrap();
        assert_eq!(resolved.bodies, 50);
        assert!((resolved.packing_fraction - 0.5).abs() < 1e-12);
        let kinds = Shapes::read(&resolved)
            .unwrap()
            .kinds::<2>(&resolved)
            .unwrap();
        let state = placed(&resolved, &kinds).unwrap();
        assert_eq!(state.placed.positions.as_flattened(), theirs.positions);
        let next = folder.path().join("next");
        run_hard_bodies(&resolved, &next, &Execution::default()).unwrap();
        // The first frame of the file is the start: single precision is all that differs.
        let of_file = settings(&first.join("trajectory.gsd"));
        for frame in [None, Some(3)] {
            let of_file = HardBodySettings {
                frame,
                ..of_file.clone()
            };
            let again = with_state(of_file, Some(50), None).unwrap();
            let read = placed(&again, &kinds).unwrap();
            for (place, exact) in read
                .placed
                .positions
                .as_flattened()
                .iter()
                .zip(&theirs.positions)
            {
                assert!((place - exact).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_state_with_other_numbers_or_another_shape_is_refused() {
        let (_folder, first) = first_run();
        let complaint = |settings: HardBodySettings, bodies, packing| {
            format!("{:#}", with_state(settings, bodies, packing).unwrap_err())
        };
        let file = settings(&first.join("trajectory.gsd"));
        assert!(complaint(file.clone(), Some(49), None).contains("leave --bodies out"));
        assert!(complaint(file.clone(), None, Some(0.4)).contains("leave --packing-fraction out"));
        let square = |start: HardBodySettings| HardBodySettings {
            shape: "polygon:4".into(),
            ..start
        };
        assert!(complaint(square(file.clone()), None, None).contains("5 corners"));
        assert!(
            complaint(square(settings(&first)), None, None).contains("give the shape of that run")
        );
        let cube = HardBodySettings {
            shape: "cube".into(),
            ..file.clone()
        };
        assert!(complaint(cube, None, None).contains("2 dimensions"));
        let late = HardBodySettings {
            frame: Some(99),
            ..file
        };
        assert!(complaint(late, None, None).contains("no frame 99"));
        let numbered = HardBodySettings {
            frame: Some(0),
            ..settings(&first)
        };
        assert!(complaint(numbered, None, None).contains("--frame is for a GSD file"));
        let empty = tempfile::tempdir().unwrap();
        assert!(complaint(settings(empty.path()), None, None).contains("run.toml"));
    }
}
