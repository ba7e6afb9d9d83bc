//! Bodies from the settings of a run, and how they begin.

use super::settings::DynamicsSettings;
use crate::shapes::read_shape;
use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Boundary, Vec3};
use protomer_md::body::Kind;
use protomer_md::neighbours::Neighbours;
use protomer_md::pair::CONTACT_RATIO;
use protomer_md::start::{free_density, on_a_lattice, set_velocities};
use protomer_md::state::{Bodies, State};
use std::f64::consts::PI;
use std::path::Path;

/// The bodies of a run, how many fit, and where they begin.
#[derive(Debug, Clone)]
pub struct Begun {
    /// The bodies.
    pub bodies: Bodies,
    /// The state at the start.
    pub state: State,
    /// Area or volume of a body with a layer of half of σ_c around it.
    pub volume_with_layer: f64,
    /// By what the box and the centres are multiplied in each step of the compression.
    pub scale_per_step: f64,
    /// Packing fraction at the start.
    pub first_packing_fraction: f64,
    /// SHA-256 of the file of the shape; empty for a name.
    pub shape_sha256: String,
}

/// Reads the shape and places the bodies.
///
/// # Errors
/// Says what is wrong with the shape or the densities.
pub fn begin(settings: &DynamicsSettings) -> Result<Begun> {
    settings.check()?;
    let name = &settings.shape;
    let path = Path::new(name);
    let shape_sha256 = match path.exists() {
        true => sha256_hex(&InputFile::read(path)?.bytes),
        false => String::new(),
    };
    let kind = kind(name)?;
    let kind = match settings.keep_size {
        true => kind,
        false => kind.of_unit_volume()?,
    };
    let volume_with_layer = with_layer(&kind).with_context(|| name.clone())?;
    let bodies = Bodies::of_one_kind(kind, settings.bodies);
    let free = free_density(&bodies) * volume_with_layer;
    let target = settings.packing_fraction;
    let first = settings.compress_from.unwrap_or(free.min(target));
    if first > free * (1.0 + 1e-12) {
        bail!(
            "--compress-from is {first}, where bodies on a lattice may overlap; give at most \
             {free:.4}, or leave it out"
        );
    }
    if target > first && settings.compress_steps == 0 {
        bail!(
            "the bodies begin at a packing fraction of {first:.4} and must be compressed to \
             {target}; give --compress-steps"
        );
    }
    let steps = settings.compress_steps.max(1) as f64;
    let dimension = bodies.dimension() as f64;
    let scale_per_step = match target > first {
        true => (first / target).powf(1.0 / (dimension * steps)),
        false => 1.0,
    };
    let mut state = on_a_lattice(&bodies, first / volume_with_layer, settings.seed)?;
    let compressed = in_smaller_box(&state, (first / target).min(1.0).powf(1.0 / dimension));
    Neighbours::of(&bodies, &compressed).with_context(|| {
        format!(
            "{} bodies at a packing fraction of {target}",
            settings.bodies
        )
    })?;
    set_velocities(&mut state, &bodies, settings.temperature, settings.seed)?;
    Ok(Begun {
        bodies,
        state,
        volume_with_layer,
        scale_per_step,
        first_packing_fraction: first,
        shape_sha256,
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

/// The kind of body of this file or name.
fn kind(file_or_name: &str) -> Result<Kind> {
    match file_or_name {
        "disk" => return Ok(Kind::ball(2, PI.sqrt().recip())?),
        "ball" => return Ok(Kind::ball(3, (0.75 / PI).cbrt())?),
        _ => {}
    }
    let shape = read_shape(file_or_name)
        .context("the shape is the file or the name of a convex shape, or 'disk' or 'ball'")?;
    let polytope = Polytope::of(&shape).with_context(|| file_or_name.to_owned())?;
    Ok(Kind::of(&polytope)?)
}

/// Area or volume of a body with a layer of half of σ_c, the diameter of hard bodies that repel each
/// other at σ_c.
fn with_layer(kind: &Kind) -> Result<f64> {
    let shape = match (kind.is_ball(), kind.dimension) {
        (true, 2) => Shape::flat(&[[0.0; 2]])?,
        (true, _) => Shape::solid(&[Vec3::zeros()])?,
        (false, 2) => {
            let corners: Vec<[f64; 2]> = kind.polytope.corners.iter().map(|x| [x.x, x.y]).collect();
            Shape::flat(&corners)?
        }
        (false, _) => Shape::solid(&kind.polytope.corners)?,
    };
    let layer = CONTACT_RATIO * kind.inradius();
    Ok(Measures::of(&shape, kind.radius + layer)?.volume)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_layer_is_that_of_the_thesis() {
        // A square: 1 + 4·0.075 + π 0.075².
        let square = kind("polygon:4").unwrap();
        let expected = 1.3 + PI * 0.075 * 0.075;
        assert!((with_layer(&square).unwrap() - expected).abs() < 1e-12);
        let disk = kind("disk").unwrap();
        let radius = 1.15 * disk.radius;
        assert!((with_layer(&disk).unwrap() - PI * radius * radius).abs() < 1e-12);
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
}
