//! Bodies from the settings of a run, and how they begin.

use super::placed;
use super::settings::DynamicsSettings;
use crate::shapes::{half_axes, read_shape};
use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{AtMost, Boundary, Vec3};
use protomer_md::added::Added;
use protomer_md::body::Kind;
use protomer_md::neighbours::Neighbours;
use protomer_md::pair::CONTACT_RATIO;
use protomer_md::start::{free_density, on_a_lattice, set_velocities};
use protomer_md::state::{Bodies, State};
use std::f64::consts::PI;
use std::path::Path;

/// Difference of a volume from one that leaves lengths as they are.
const SAME_SIZE: f64 = 1e-9;

/// The bodies of a run, how many fit, and where they begin.
#[derive(Debug, Clone)]
pub struct Begun {
    /// The bodies.
    pub bodies: Bodies,
    /// The state at the start.
    pub state: State,
    /// Area or volume of a body with a layer of half of σ_c around it, on average.
    pub volume_with_layer: f64,
    /// Energies in addition to the contacts.
    pub added: Added,
    /// Factor by which the box and the centres are multiplied in each step of the compression.
    pub scale_per_step: f64,
    /// Packing fraction at the start.
    pub first_packing_fraction: f64,
    /// SHA-256 of the files of the shapes and of a state to start from; empty for names on a lattice.
    pub input_sha256: String,
}

/// Reads the shapes and places the bodies.
///
/// # Errors
/// Says what is wrong with the shapes or the densities.
pub fn begin(settings: &DynamicsSettings) -> Result<Begun> {
    settings.check()?;
    let kinds = kinds(settings)?;
    match &settings.start {
        Some(start) => placed::begin(settings, start, kinds),
        None => begin_on_a_lattice(settings, kinds),
    }
}

/// Number of dimensions, 2 or 3, in which the bodies of the settings move.
///
/// # Errors
/// Says what is wrong with the shapes.
pub fn dimension(settings: &DynamicsSettings) -> Result<usize> {
    let Some(name) = settings.shape.iter().next() else {
        bail!("there is no --shape; give one or several");
    };
    Ok(kind(name, settings.rounding)?.dimension)
}

/// Kinds of bodies of the settings, of unit volume unless their size is kept.
pub(super) fn kinds(settings: &DynamicsSettings) -> Result<Vec<Kind>> {
    let mut kinds = Vec::new();
    for name in settings.shape.iter() {
        let kind = kind(name, settings.rounding)?;
        if settings.has_added() && !settings.keep_size && (kind.mass - 1.0).abs() > SAME_SIZE {
            bail!(
                "--pair-potential and --field have their lengths in the unit of the shape, and --shape {name} would be scaled \
                 by {:.4}; give --keep-size",
                kind.mass.powf(-1.0 / kind.dimension as f64)
            );
        }
        let sized = match settings.keep_size {
            true => kind,
            false => kind.of_unit_volume()?,
        };
        kinds.push(match settings.fixed_orientations {
            true => sized.with_fixed_orientation(),
            false => sized,
        });
    }
    Ok(kinds)
}

fn begin_on_a_lattice(settings: &DynamicsSettings, kinds: Vec<Kind>) -> Result<Begun> {
    let bodies = mixture(kinds, settings);
    let volume_with_layer = mean_volume_with_layer(&bodies);
    let free = free_density(&bodies) * volume_with_layer;
    let target = settings.packing_fraction;
    let first = settings.compress_from.unwrap_or(free.min(target));
    if first > free * (1.0 + 1e-12) {
        bail!(
            "--compress-from is {first}, where bodies on a lattice may overlap; give at most {}, or leave it out",
            AtMost(free)
        );
    }
    let scale_per_step = scale_per_step(settings, first, bodies.dimension())?;
    let mut state = on_a_lattice(&bodies, first / volume_with_layer, settings.seed)?;
    let added = settings.added(bodies.dimension())?;
    require_room(&bodies, &state, first, settings, &added)?;
    set_velocities(&mut state, &bodies, settings.temperature, settings.seed)?;
    Ok(Begun {
        bodies,
        state,
        volume_with_layer,
        added,
        scale_per_step,
        first_packing_fraction: first,
        input_sha256: hash_of_files(&settings.shape)?,
    })
}

/// Area or volume of a body with a layer of half of σ_c around it, on average.
pub(super) fn mean_volume_with_layer(bodies: &Bodies) -> f64 {
    let volumes = bodies
        .kind_of
        .iter()
        .map(|kind| with_layer(&bodies.kinds[*kind]));
    volumes.sum::<f64>() / bodies.count() as f64
}

/// Factor of all lengths in each step of the compression from a packing fraction to that of the settings.
pub(super) fn scale_per_step(
    settings: &DynamicsSettings,
    first: f64,
    dimension: usize,
) -> Result<f64> {
    let target = settings.packing_fraction;
    if target > first && settings.compress_steps == 0 {
        bail!(
            "the bodies begin at a packing fraction of {first:.4} and must be compressed to \
             {target}; give --compress-steps"
        );
    }
    let steps = settings.compress_steps.max(1) as f64;
    Ok(match target > first {
        true => (first / target).powf(1.0 / (dimension as f64 * steps)),
        false => 1.0,
    })
}

/// Refuses bodies that would meet their own images in the compressed box, and heights that it would not have.
pub(super) fn require_room(
    bodies: &Bodies,
    state: &State,
    first: f64,
    settings: &DynamicsSettings,
    added: &Added,
) -> Result<()> {
    let target = settings.packing_fraction;
    let scale = (first / target)
        .min(1.0)
        .powf(1.0 / bodies.dimension() as f64);
    let compressed = in_smaller_box(state, scale);
    let (interaction, range) = (settings.interaction(), added.range());
    let fits = Neighbours::find_within(bodies, &compressed, &interaction, range)
        .and_then(|_| added.check(bodies, &compressed));
    fits.with_context(|| {
        format!(
            "{} bodies at a packing fraction of {target}",
            bodies.count()
        )
    })
}

/// The state with its box and its centres drawn together.
fn in_smaller_box(state: &State, scale: f64) -> State {
    let mut smaller = state.clone();
    if let Boundary::Periodic { lengths_angstrom } = &mut smaller.space {
        *lengths_angstrom *= scale;
    }
    for position in &mut smaller.positions {
        *position *= scale;
    }
    smaller
}

/// SHA-256 of the files of the shapes; of several, that of their hashes. Empty for names.
pub(super) fn hash_of_files(names: &[String]) -> Result<String> {
    let mut hashes = Vec::new();
    for name in names.iter().flat_map(|name| name.split('+')) {
        let path = Path::new(name);
        if path.exists() {
            hashes.push(sha256_hex(&InputFile::read(path)?.bytes));
        }
    }
    Ok(match hashes.as_slice() {
        [] => String::new(),
        [hash] => hash.clone(),
        _ => sha256_hex(hashes.concat().as_bytes()),
    })
}

/// Bodies of these kinds in the shares of the settings, shuffled.
fn mixture(kinds: Vec<Kind>, settings: &DynamicsSettings) -> Bodies {
    let count = settings.bodies;
    let shares = match settings.share.is_empty() {
        true => vec![1.0; kinds.len()],
        false => settings.share.clone(),
    };
    let total: f64 = shares.iter().sum();
    let mut kind_of = Vec::with_capacity(count);
    let mut sum = 0.0;
    for (kind, share) in shares.iter().enumerate() {
        sum += share;
        kind_of.resize((count as f64 * sum / total).round() as usize, kind);
    }
    let mut rng = CounterRng::for_purpose(settings.seed, 0, 1, Purpose::ContactStart);
    for place in (1..kind_of.len()).rev() {
        kind_of.swap(place, (rng.uniform() * (place + 1) as f64) as usize);
    }
    Bodies { kinds, kind_of }
}

/// The kind of body of this file or name, rounded; parts of a concave body are joined by `+`.
fn kind(file_or_name: &str, rounding: f64) -> Result<Kind> {
    match file_or_name {
        "disk" => return Ok(Kind::ball(2, PI.sqrt().recip() + rounding)?),
        "ball" => return Ok(Kind::ball(3, (0.75 / PI).cbrt() + rounding)?),
        _ => {}
    }
    if let Some(axes) = half_axes(file_or_name)? {
        if rounding > 0.0 {
            bail!("{file_or_name} is round already; leave out --rounding");
        }
        let three = Vec3::from_fn(|axis, _| axes.get(axis).copied().unwrap_or(0.0));
        return Kind::ellipsoid(axes.len(), three).with_context(|| file_or_name.to_owned());
    }
    let mut parts = Vec::new();
    for name in file_or_name.split('+') {
        let shape = read_shape(name).context(
            "the shape is the file or the name of a convex shape, several joined by '+', or 'disk', \
             'ball', 'ellipse:A,B' or 'ellipsoid:A,B,C'",
        )?;
        parts.push(Polytope::placed(&shape).with_context(|| name.to_owned())?);
    }
    Kind::union(&parts, rounding).with_context(|| file_or_name.to_owned())
}

/// Area or volume of a body with a layer of half of σ_c, the diameter of hard bodies that repel each
/// other at σ_c. The parts of a concave body count apart.
fn with_layer(kind: &Kind) -> f64 {
    let parts = kind.parts.iter();
    parts
        .map(|part| part.volume_with_layer(CONTACT_RATIO * part.inradius()))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_common::settings::Words;

    #[test]
    fn the_layer_is_that_of_the_thesis() {
        // A square: 1 + 4·0.075 + π 0.075².
        let square = kind("polygon:4", 0.0).unwrap();
        let expected = 1.3 + PI * 0.075 * 0.075;
        assert!((with_layer(&square) - expected).abs() < 1e-12);
        let disk = kind("disk", 0.0).unwrap();
        let radius = 1.15 * disk.inradius();
        assert!((with_layer(&disk) - PI * radius * radius).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_begin_says_what_to_do() {
        let complaint = |settings: DynamicsSettings| format!("{:#}", begin(&settings).unwrap_err());
        let settings = DynamicsSettings::default();
        let dense = complaint(DynamicsSettings {
            compress_from: Some(0.6),
            packing_fraction: 0.7,
            ..settings.clone()
        });
        assert!(dense.contains("give at most 0.5"), "{dense}");
        let no_steps = complaint(DynamicsSettings {
            packing_fraction: 0.7,
            compress_steps: 0,
            ..settings.clone()
        });
        assert!(no_steps.contains("--compress-steps"), "{no_steps}");
        let unknown = complaint(DynamicsSettings {
            shape: "egg".into(),
            ..settings
        });
        assert!(
            unknown.contains("'egg'") && unknown.contains("'disk'"),
            "{unknown}"
        );
    }

    #[test]
    fn mixtures_have_their_shares_and_parts_their_places() {
        let settings = DynamicsSettings {
            shape: Words(vec!["polygon:3".into(), "disk".into()]),
            share: vec![3.0, 1.0],
            bodies: 40,
            packing_fraction: 0.2,
            ..DynamicsSettings::default()
        };
        let begun = begin(&settings).unwrap();
        let disks = begun
            .bodies
            .kind_of
            .iter()
            .filter(|kind| **kind == 1)
            .count();
        assert_eq!(disks, 10);
        assert!(begun.bodies.kind_of[..10].contains(&1));

        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let upright = file("upright.txt", "0 0\n1 0\n1 3\n0 3\n");
        let foot = file("foot.txt", "1 0\n2 0\n2 1\n1 1\n");
        let body = kind(&format!("{upright}+{foot}"), 0.0).unwrap();
        assert!((body.mass - 4.0).abs() < 1e-12);
        // The centroid of the L is at (3/4, 5/4).
        assert!((body.parts[0].centre - Vec3::new(-0.25, 0.25, 0.0)).norm() < 1e-12);
        assert!((body.parts[1].centre - Vec3::new(0.75, -0.75, 0.0)).norm() < 1e-12);
        let twice = format!(
            "{:#}",
            kind(&format!("{upright}+{upright}"), 0.0).unwrap_err()
        );
        assert!(twice.contains("overlap"), "{twice}");
    }

    #[test]
    fn ellipses_are_told_from_their_names() {
        let ellipse = kind("ellipse:2,1", 0.0).unwrap();
        assert_eq!(ellipse.dimension, 2);
        assert_eq!(kind("ellipsoid:1,1,2", 0.0).unwrap().dimension, 3);
        for name in ["ellipse:2", "ellipsoid:1,2", "ellipse:a,b", "ellipse:0,1"] {
            assert!(kind(name, 0.0).is_err(), "{name}");
        }
        assert!(kind("ellipse:2,1", 0.1).is_err());
    }
}
