//! Bodies in motion that begin where another simulation left them: a frame of a GSD file, or a run's directory.

use super::run::saved_motion;
use super::settings::DynamicsSettings;
use super::start::{
    self, Begun, hash_of_files, kinds, mean_volume_with_layer, require_room, scale_per_step,
};
use super::trajectory::shape;
use crate::given_state::GivenState;
use anyhow::{Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::{Boundary, Rotation, Vec3};
use protomer_md::body::Kind;
use protomer_md::start::{ACROSS_THE_PLANE, set_velocities};
use protomer_md::state::{Bodies, State};
use std::path::Path;

/// Bodies and their motion, as a file or a run has them.
pub(super) struct Found {
    pub(super) bodies: Bodies,
    pub(super) state: State,
    has_velocities: bool,
    sha256: String,
}

/// The settings with the number of bodies of the state in which they start, and with its packing fraction unless another
/// one is given. Settings that start on a lattice stay as they are.
///
/// # Errors
/// For a state that cannot be read or does not have the shapes of the settings, and for numbers that it does not have.
pub fn with_state(settings: DynamicsSettings) -> Result<DynamicsSettings> {
    let Some(start) = &settings.start else {
        return Ok(settings);
    };
    let found = find(&settings, start, kinds(&settings)?)?;
    let (defaults, count) = (DynamicsSettings::default(), found.bodies.count());
    if ![defaults.bodies, count].contains(&settings.bodies) {
        bail!(
            "--bodies is {}, and {start} has {count}; leave --bodies out",
            settings.bodies
        );
    }
    let packing = packing_fraction(&found);
    let target = match settings.packing_fraction == defaults.packing_fraction {
        true => packing,
        false => settings.packing_fraction,
    };
    if target < packing * (1.0 - 1e-9) {
        bail!(
            "--packing-fraction is {target}, and {start} has {packing}, with the layer of each body; give a larger one to \
             compress it, or leave it out"
        );
    }
    Ok(DynamicsSettings {
        bodies: count,
        packing_fraction: target,
        ..settings
    })
}

/// Part of the space that the bodies of a state fill with their layers.
pub(super) fn packing_fraction(found: &Found) -> f64 {
    let (bodies, state) = (&found.bodies, &found.state);
    bodies.count() as f64 * mean_volume_with_layer(bodies) / state.volume(bodies.dimension())
}

/// Begins where a state is.
pub(super) fn begin(settings: &DynamicsSettings, start: &str, kinds: Vec<Kind>) -> Result<Begun> {
    let found = find(settings, start, kinds)?;
    let count = found.bodies.count();
    if count != settings.bodies {
        bail!(
            "{start} has {count} bodies, and the settings have {}; give those of the state",
            settings.bodies
        );
    }
    begin_from(settings, found)
}

/// Begins from a state; bodies without velocities get those of the temperature.
pub(super) fn begin_from(settings: &DynamicsSettings, found: Found) -> Result<Begun> {
    let first = packing_fraction(&found);
    let Found {
        bodies,
        mut state,
        has_velocities,
        sha256,
    } = found;
    let scale_per_step = scale_per_step(settings, first, bodies.dimension())?;
    let added = settings.added(bodies.dimension())?;
    require_room(&bodies, &state, first, settings, &added)?;
    if !has_velocities {
        set_velocities(&mut state, &bodies, settings.temperature, settings.seed)?;
    }
    let files = hash_of_files(&settings.shape)?;
    Ok(Begun {
        volume_with_layer: mean_volume_with_layer(&bodies),
        bodies,
        state,
        added,
        scale_per_step,
        first_packing_fraction: first,
        input_sha256: sha256_hex(format!("{files}{sha256}").as_bytes()),
    })
}

fn find(settings: &DynamicsSettings, start: &str, kinds: Vec<Kind>) -> Result<Found> {
    let path = Path::new(start);
    match (path.is_dir(), settings.frame) {
        (true, Some(_)) => bail!(
            "--frame is for a GSD file, and {start} is a directory, of which the last state counts; give {start}/trajectory.gsd"
        ),
        (true, None) => of_directory(path, settings, kinds),
        (false, frame) => of_file(&GivenState::read(path, frame)?, settings, kinds),
    }
}

/// The bodies of a frame.
pub(super) fn of_file(
    given: &GivenState,
    settings: &DynamicsSettings,
    kinds: Vec<Kind>,
) -> Result<Found> {
    let dimension = kinds.first().map_or(3, |kind| kind.dimension);
    if given.dimensions != dimension {
        bail!(
            "{} has {} dimensions, and --shape {} has {dimension}; give shapes of the same space",
            given.origin,
            given.dimensions,
            settings.shape.join(", ")
        );
    }
    let shapes: Vec<_> = kinds.iter().map(shape).collect();
    given.check_shapes(&shapes, &settings.shape)?;
    if given.tilt_factors.iter().any(|tilt| *tilt != 0.0) {
        bail!(
            "{}: the box is tilted; give one with right angles",
            given.origin
        );
    }
    let mut lengths = Vec3::from(given.lengths);
    if dimension == 2 {
        lengths.z = ACROSS_THE_PLANE;
    }
    if !lengths.iter().all(|length| *length > 0.0) {
        bail!("{}: there is no box; give a frame with one", given.origin);
    }
    let bodies = Bodies {
        kinds,
        kind_of: given.kinds.clone(),
    };
    let space = Boundary::Periodic {
        lengths_angstrom: lengths,
    };
    let mut state = State::at_rest(&bodies, space, given.positions.clone());
    for body in 0..bodies.count() {
        match state.angles_rad.get_mut(body) {
            Some(angle) => *angle = angle_in_plane(&given.rotations[body], &given.origin)?,
            None => state.rotations[body] = given.rotations[body],
        }
    }
    // Zeros are what programs write that have no velocities.
    let velocities = given
        .velocities
        .as_ref()
        .filter(|all| all.iter().any(|one| *one != Vec3::zeros()));
    if let Some(velocities) = velocities {
        state.velocities.clone_from(velocities);
        if let Some(spins) = &given.spins {
            state.spins.clone_from(spins);
        }
    }
    Ok(Found {
        bodies,
        state,
        has_velocities: velocities.is_some(),
        sha256: given.sha256(),
    })
}

/// Angle of a rotation about the third axis, radians.
fn angle_in_plane(rotation: &Rotation, origin: &str) -> Result<f64> {
    let parts = rotation.coords;
    if parts.x.hypot(parts.y) > 1e-4 {
        bail!(
            "{origin}: a body is turned out of the plane; give rotations about the third axis only"
        );
    }
    Ok(2.0 * parts.z.atan2(parts.w))
}

/// The bodies of a run, as its checkpoint has them to the last bit.
fn of_directory(path: &Path, settings: &DynamicsSettings, kinds: Vec<Kind>) -> Result<Found> {
    let (theirs, motion) = saved_motion(path)?;
    let shapes = |settings: &DynamicsSettings| {
        (
            settings.shape.to_vec(),
            settings.rounding,
            settings.keep_size,
            settings.share.clone(),
        )
    };
    if shapes(&theirs) != shapes(settings) {
        bail!(
            "{} has the shapes {} (--rounding {}), and this run has {} (--rounding {}); give the same --shape, --share, \
             --rounding and --keep-size",
            path.display(),
            theirs.shape.join(", "),
            theirs.rounding,
            settings.shape.join(", "),
            settings.rounding
        );
    }
    let kind_of = match kinds.len() {
        1 => vec![0; motion.state.positions.len()],
        _ => start::begin(&theirs)?.bodies.kind_of,
    };
    let text = serde_json::to_string(&motion.state)?;
    Ok(Found {
        bodies: Bodies { kinds, kind_of },
        state: motion.state,
        has_velocities: true,
        sha256: sha256_hex(text.as_bytes()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::run::{DynamicsResult, run_dynamics};
    use protomer_results::Execution;
    use std::path::PathBuf;

    fn run(settings: &DynamicsSettings, path: &Path) -> DynamicsResult {
        let end = run_dynamics(settings, path, &Execution::default()).unwrap();
        end.finished().unwrap()
    }

    /// A short run of a shape to start from, in its folder.
    fn first_run(shape: &str) -> (tempfile::TempDir, PathBuf, DynamicsResult) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("first");
        let settings = DynamicsSettings {
            shape: shape.into(),
            bodies: 64,
            packing_fraction: 0.3,
            steps: 200,
            compress_steps: 200,
            equilibrate_steps: 200,
            trajectory_every: 100,
            ..DynamicsSettings::default()
        };
        let result = run(&settings, &path);
        (folder, path, result)
    }

    fn on_from(shape: &str, start: &Path) -> DynamicsSettings {
        DynamicsSettings {
            shape: shape.into(),
            start: Some(start.display().to_string()),
            equilibrate_steps: 0,
            compress_steps: 0,
            steps: 200,
            trajectory_every: 0,
            ..DynamicsSettings::default()
        }
    }

    /// Velocities and spins are taken over, so the energy is that of the first run.
    #[test]
    fn motion_goes_on_where_another_run_stands() {
        for shape in ["polygon:3", "cube"] {
            let (folder, first, result) = first_run(shape);
            for (name, start) in [
                ("exact", first.clone()),
                ("file", first.join("trajectory.gsd")),
            ] {
                let settings = with_state(on_from(shape, &start)).unwrap();
                assert_eq!(settings.bodies, 64);
                assert!((settings.packing_fraction - 0.3).abs() < 1e-6);
                // A run and its continuation resolve to the same settings.
                assert_eq!(with_state(settings.clone()).unwrap(), settings);
                let next = run(&settings, &folder.path().join(name));
                let gap = (next.energy_per_body - result.energy_per_body).abs();
                assert!(gap < 1e-3, "{shape} {name}: {gap}");
            }
        }
    }

    #[test]
    fn a_denser_target_compresses_and_a_wider_one_is_refused() {
        let (folder, first, _) = first_run("disk");
        let denser = DynamicsSettings {
            packing_fraction: 0.4,
            compress_steps: 500,
            ..on_from("disk", &first)
        };
        let settings = with_state(denser.clone()).unwrap();
        let result = run(&settings, &folder.path().join("denser"));
        assert!((result.packing_fraction - 0.4).abs() < 1e-6);
        let complaint =
            |settings: DynamicsSettings| format!("{:#}", with_state(settings).unwrap_err());
        let wider = DynamicsSettings {
            packing_fraction: 0.2,
            ..denser.clone()
        };
        assert!(complaint(wider).contains("give a larger one"));
        let fewer = DynamicsSettings {
            bodies: 12,
            ..denser.clone()
        };
        assert!(complaint(fewer).contains("leave --bodies out"));
        let square = DynamicsSettings {
            shape: "polygon:4".into(),
            ..denser.clone()
        };
        assert!(complaint(square.clone()).contains("give the same --shape"));
        let file = Some(first.join("trajectory.gsd").display().to_string());
        assert!(
            complaint(DynamicsSettings {
                start: file,
                ..square
            })
            .contains("is a Sphere")
        );
        let frame = DynamicsSettings {
            frame: Some(0),
            ..denser
        };
        assert!(complaint(frame).contains("--frame is for a GSD file"));
    }
}
