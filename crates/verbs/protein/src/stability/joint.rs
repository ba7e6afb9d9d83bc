//! The potential of the angle between two copies of a body that are tied at their corners, for a lattice
//! of squares.
//!
//! The opening of a joint is φ = 90° + b with the bend b of [`tied`]: 90° where the arms point at each
//! other (open), 0 and 180° where sides meet (closed).

use super::effective::range::LEAST_GAP_ANGSTROM;
use super::effective::{EffectiveStore, SoluteModel};
use super::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_common::answer::Answer;
use protomer_common::range::Range;
use protomer_io::csv::Table;
use protomer_mc::BodyType;
use protomer_mc::charges::ChargeCloud;
use protomer_mc::pair::tied::{self, Tie, TiedPoint};
use protomer_mc::pair::{BodyPair, Charged, Core, Terms};
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Range of the length of a rod.
const ROD: Range = Range::new(0.0, 1e4, "Å");
/// Numbers of openings and of directions that are allowed.
const COUNTS: std::ops::RangeInclusive<usize> = 8..=100_000;

/// Geometry and medium of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSettings {
    /// Axis of the body, a unit vector in its frame.
    pub axis: [f64; 3],
    /// Direction from the centre of the body to its corner, a unit vector.
    pub corner: [f64; 3],
    /// Distance from the centre to the corner, Å.
    pub half_diagonal_angstrom: f64,
    /// Length of the rod, Å.
    pub rod_angstrom: f64,
    /// Whether neighbours face opposite ways.
    pub is_turned_over: bool,
    /// Number of openings from 0 to 180°.
    pub openings: usize,
    /// Number of directions of the rod.
    pub directions: usize,
    /// The medium.
    pub interaction: ScreenedCoulomb,
    /// Whether the charges are effective ones: those that give the potential around bodies of low permittivity
    /// that salt does not enter.
    pub is_effective: bool,
}

/// The mean force at one opening.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct JointPoint {
    /// Opening φ, degrees.
    pub angle_deg: f64,
    /// Share of the directions of the rod at which the bodies do not overlap.
    pub free_share: f64,
    /// Potential of mean force of the charges, kT; null where the bodies overlap in every direction.
    pub energy_kt: Option<f64>,
    /// Change of the potential with half of the directions, kT.
    pub error_kt: Option<f64>,
    /// Lowest energy of any direction, kT.
    pub lowest_kt: Option<f64>,
}

/// The potential of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointAnswer {
    /// Name of the body.
    pub body: String,
    /// Debye length, Å.
    pub debye_length_angstrom: f64,
    /// Distance from the centre of the body to the corner, Å.
    pub half_diagonal_angstrom: f64,
    /// Length of the rod, Å.
    pub rod_angstrom: f64,
    /// Length of the rod in half-diagonals: r0 of the lattice.
    pub r0: f64,
    /// Whether neighbours face opposite ways.
    pub is_turned_over: bool,
    /// Whether the charges are effective ones.
    pub is_effective: bool,
    /// Points in the order of the openings.
    pub points: Vec<JointPoint>,
}

/// The potential of the joint of two copies of a body.
///
/// # Errors
/// For settings out of range, salt without a value, and a body that overlaps its copy at every opening.
pub fn joint(body: &Body, settings: &JointSettings) -> Result<JointAnswer> {
    ROD.require("--rod", settings.rod_angstrom)?;
    for (flag, count) in [
        ("--openings", settings.openings),
        ("--directions", settings.directions),
    ] {
        if !COUNTS.contains(&count) {
            bail!(
                "{flag} is {count}; give {} to {}",
                COUNTS.start(),
                COUNTS.end()
            );
        }
    }
    let kind =
        Arc::new(BodyType::from_body(body).with_context(|| format!("the body {}", body.name))?);
    let yukawa = settings.interaction.yukawa()?;
    let cloud = match settings.is_effective {
        true => {
            let store = EffectiveStore::default();
            let effective = store.charges(body, &settings.interaction, &SoluteModel::default())?;
            ChargeCloud::new(&effective.charges)
        }
        false => kind.charges.clone(),
    };
    let charged = Charged::new(yukawa, &cloud, &cloud)?;
    let pair = BodyPair {
        first: Arc::clone(&kind),
        second: kind,
        potential: Terms(vec![Arc::new(charged.with_tables(true))]),
        core: Core::Surfaces,
        contact_gap_angstrom: protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM,
    };
    let corner: nalgebra::Vector3<f64> = settings.corner.into();
    let tie = Tie {
        axis: settings.axis.into(),
        centre: body.mass_properties.centroid,
        arm: corner * settings.half_diagonal_angstrom,
        rod_angstrom: settings.rod_angstrom,
        is_turned_over: settings.is_turned_over,
    };
    let mut bends = Vec::with_capacity(settings.openings);
    for number in 0..settings.openings {
        let share = number as f64 / (settings.openings - 1) as f64;
        bends.push((2.0 * share - 1.0) * FRAC_PI_2);
    }
    let mean_force = tied::mean_force(&pair, &tie, &bends, settings.directions)?;
    let points: Vec<JointPoint> = mean_force.into_iter().map(point).collect();
    let answer = JointAnswer {
        body: body.name.clone(),
        debye_length_angstrom: yukawa.inverse_debye_length_per_angstrom.recip(),
        is_effective: settings.is_effective,
        half_diagonal_angstrom: settings.half_diagonal_angstrom,
        rod_angstrom: settings.rod_angstrom,
        r0: settings.rod_angstrom / settings.half_diagonal_angstrom,
        is_turned_over: settings.is_turned_over,
        points,
    };
    if answer.energies().count() < 2 {
        bail!(
            "{}: the bodies overlap in every direction at nearly all openings; give a longer --rod, or another --size of \
             the square",
            body.name
        );
    }
    Ok(answer)
}

fn point(point: TiedPoint) -> JointPoint {
    let finite = |value: f64| value.is_finite().then_some(value);
    JointPoint {
        angle_deg: 90.0 + point.bend_rad.to_degrees(),
        free_share: point.free_share,
        energy_kt: finite(point.energy_kt),
        error_kt: finite(point.error_kt),
        lowest_kt: finite(point.lowest_kt),
    }
}

impl JointAnswer {
    /// Angle in degrees, energy and its error in kT where there is an energy.
    fn energies(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let points = self.points.iter();
        points.filter_map(|point| {
            let energy = point.energy_kt?;
            Some((point.angle_deg, energy, point.error_kt.unwrap_or(f64::NAN)))
        })
    }

    /// The warning of effective charges, which do not hold near contact.
    pub fn warning(&self) -> Option<String> {
        self.is_effective.then(|| {
            format!(
                "effective charges hold where surfaces are {LEAST_GAP_ANGSTROM} Å apart or more, and the average has directions \
                 of the rod in which they are nearer; compare with --interaction bare"
            )
        })
    }

    /// The table that `lattice run --angle-potential` reads: angle_deg, energy_kt, error_kt.
    ///
    /// # Errors
    /// Never for text in memory.
    pub fn to_csv(&self) -> Result<String> {
        let mut table = Table::new(["angle_deg", "energy_kt", "error_kt"]);
        for (angle, energy, error) in self.energies() {
            table.push([angle.into(), energy.into(), error.into()])?;
        }
        Ok(table.to_csv()?)
    }
}

impl Answer for JointAnswer {
    fn text(&self) -> String {
        let (mut lowest, mut open) = ((f64::NAN, f64::INFINITY), (f64::INFINITY, f64::NAN));
        let mut error = 0.0_f64;
        for (angle, energy, own) in self.energies() {
            if energy < lowest.1 {
                lowest = (angle, energy);
            }
            if (angle - 90.0).abs() < open.0 {
                open = ((angle - 90.0).abs(), energy);
            }
            error = error.max(own);
        }
        format!(
            "{}, Debye length {:.2} Å, rod {} Å (r0 = {:.4}): lowest at {:.1}° with {:.3} kT, open {:.3} kT, errors at most \
             {error:.1e} kT; {} of {} openings have room",
            self.body,
            self.debye_length_angstrom,
            self.rod_angstrom,
            self.r0,
            lowest.0,
            lowest.1,
            open.1,
            self.energies().count(),
            self.points.len()
        )
    }
}
