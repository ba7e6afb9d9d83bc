//! The pages of a lattice and of a sweep of lattices.

pub mod run;
pub mod sweep;

use super::animation::{Animation, PLAYER, PLAYER_SCRIPT, PLAYER_STYLE};
use super::settings::LatticeSettings;
use super::sweep::axes;
use anyhow::Result;
use protomer_common::page::{Contents, Part, Program, Section, significant};
use std::path::Path;

/// Upper limit for the numbers in an animation, some megabytes of text.
const MOST_NUMBERS: usize = 300_000;
/// Maximum number of frames.
const MOST_FRAMES: usize = 200;

/// The size of the player on this page.
const STAGE_STYLE: &str = include_str!("stage.css");

/// Contents with what the settings say.
fn with_settings(title: &'static str, settings: &LatticeSettings) -> Contents {
    let mut contents = Contents::new(title);
    contents.subtitle = format!(
        "{} × {} rigid squares joined by rigid rods; reduced units",
        settings.rows, settings.columns
    );
    let seeds: Vec<String> = axes(settings).seeds.iter().map(u64::to_string).collect();
    contents.origin.more = vec![("seed", seeds.join(", "))];
    contents
}

/// The player with frames of a run.
fn animation(directory: &Path, settings: &LatticeSettings) -> Result<Section> {
    let numbers = 3 * settings.rows.saturating_mul(settings.columns).max(1);
    let animation = Animation::read(directory, (MOST_NUMBERS / numbers).clamp(20, MOST_FRAMES))?;
    let note = format!(
        "{}; {} frames, evenly spaced over the run.",
        animation.title(),
        animation.len()
    );
    let program = Program {
        html: format!("<div class=\"stage\" tabindex=\"0\">\n{PLAYER}</div>\n"),
        style: PLAYER_STYLE.to_owned() + STAGE_STYLE,
        library: PLAYER_SCRIPT,
        script: format!(
            "{{ const stage = document.querySelector(\".stage\"); playLattice(stage.firstElementChild, stage, {}); }}\n",
            animation.to_json()
        ),
    };
    Ok(Section::new(
        "Animation",
        vec![Part::Program(program), Part::Paragraph(note)],
    ))
}

fn conditions(settings: &LatticeSettings) -> Section {
    let axes = axes(settings);
    let list = |values: &[f64]| {
        values
            .iter()
            .map(|value| significant(*value, 6))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let collisions = match (settings.collisions, settings.paper) {
        (false, _) => "none: squares pass through each other".to_owned(),
        (true, true) => "those of the paper".to_owned(),
        (true, false) => format!(
            "event by event, coefficient of restitution {}",
            settings.restitution
        ),
    };
    let bath = match settings.temperature {
        Some(temperature) => format!("kT = {temperature}, friction {}", settings.friction),
        None if settings.friction > 0.0 => format!("none, friction {}", settings.friction),
        None => "none".into(),
    };
    let rows = vec![
        (
            "squares",
            format!("{} rows of {}", settings.rows, settings.columns),
        ),
        ("length of the rods, r0", list(&axes.r0)),
        ("κ of the coherence potential", list(&axes.kappa)),
        ("edges", format!("{:?}", settings.edges).to_lowercase()),
        (
            "orientation at the start",
            format!("± {} rad", significant(settings.start.angle_rad(), 5)),
        ),
        (
            "velocities at the start",
            format!("{:?}, {}", settings.velocities, settings.speed).to_lowercase(),
        ),
        ("collisions", collisions),
        ("heat bath", bath),
    ];
    let units = "Reduced units: the half-diagonal of a square and its mass are 1.";
    Section::new(
        "Conditions",
        vec![Part::Values(rows), Part::Paragraph(units.into())],
    )
}
