//! First contact and response for scripts.

use super::detection::Detector;
use super::response::impact;
use crate::lattice::contact::{Contact, Row, without_repetitions};
use crate::lattice::network::{Corner, Network};
use crate::lattice::rods::RodSystem;
use crate::lattice::{Dynamics, State};
use crate::{CrystalError, Result};
use protomer_kernel::sparse::SparseError;

/// The first contact of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstContact {
    /// When.
    pub time: f64,
    /// The state at contact, before any impact.
    pub state: State,
    /// Everything that touches; corners head on from either side.
    pub contacts: Vec<Contact>,
}

impl FirstContact {
    /// Contacts of squares as [striker, corner 1 to 4, target].
    pub fn listed(&self) -> Vec<[usize; 3]> {
        let listed = |contact: &Contact| match *contact {
            Contact::VertexSide {
                striker, target, ..
            } => Some([striker.square, usize::from(striker.vertex), target]),
            Contact::VertexVertex {
                striker, target, ..
            } => Some([striker.square, usize::from(striker.vertex), target.square]),
            Contact::RodCorner { .. } | Contact::RodStop { .. } => None,
        };
        self.contacts.iter().filter_map(listed).collect()
    }
}

/// Goes on from a prepared state in steps of `step` to the first contact of squares (and of rods,
/// with `rods_block`), or to `until`, where the result is `None`. The state is left at the contact,
/// or at `until`.
///
/// # Errors
/// Those of [`Dynamics::step`], and [`CrystalError::Overlap`] if squares overlap at the start.
pub fn first_contact(
    dynamics: &mut Dynamics,
    state: &mut State,
    step: f64,
    until: f64,
    rods_block: bool,
) -> Result<Option<FirstContact>> {
    if !(step.is_finite() && step > 0.0) {
        return Err(CrystalError::BadSetting {
            setting: "step",
            value: step,
            requirement: "positive",
        });
    }
    let network = dynamics.network().clone();
    let mut detector = Detector::new(&network, &state.positions, rods_block);
    detector.check_no_overlap(&network, &state.positions, state.time)?;
    let mut positions = state.positions.clone();
    let begin = state.time;
    for index in 1_u64.. {
        let goal = (begin + index as f64 * step).min(until);
        if goal - state.time <= 1e-12 * step {
            break;
        }
        let meeting = detector.first_meeting(dynamics, state, goal - state.time, &mut positions)?;
        let length = meeting.map_or(goal - state.time, |meeting| meeting.time);
        if length > 0.0 {
            dynamics.arrive(state, length, &positions)?;
        }
        let contacts = if meeting.is_some() {
            detector.touching(&network, &state.positions)
        } else {
            Vec::new()
        };
        if !contacts.is_empty() {
            return Ok(Some(FirstContact {
                time: state.time,
                state: state.clone(),
                contacts,
            }));
        }
    }
    Ok(None)
}

/// What an impact made of the velocities.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Velocities after it.
    pub velocities_after: Vec<f64>,
    /// The touches, corners that meet head on once.
    pub contacts: Vec<Contact>,
    /// Impulse of each.
    pub impulses: Vec<f64>,
}

/// Impact at given contacts, transmitted through the rods. A contact is a striker, its corner (1 to
/// 4), and a target: on a corner of the target where it is one, else on its nearest side, at the
/// nearest image in a periodic cell. Corners head on may be listed once or from either side.
///
/// # Errors
/// [`CrystalError::BadState`] for arrays or contacts that do not fit the network,
/// [`CrystalError::BadSetting`] for a restitution outside 0 to 1,
/// [`CrystalError::OverConstrained`].
pub fn respond(
    network: &Network,
    positions: &[f64],
    velocities: &[f64],
    contacts: &[[usize; 3]],
    restitution: f64,
) -> Result<Response> {
    network.check()?;
    let state = State {
        time: 0.0,
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
    };
    state.check(network)?;
    check_restitution(restitution)?;
    let squares = network.squares.len();
    let mut touches = Vec::with_capacity(contacts.len());
    for &[striker, vertex, target] in contacts {
        if striker >= squares || target >= squares || !(1..=4).contains(&vertex) {
            return Err(CrystalError::BadState(format!(
                "contact [{striker}, {vertex}, {target}]: squares are 0 to {}, corners 1 to 4",
                squares - 1
            )));
        }
        let shift = network.cell.map_or([0.0; 2], |cell| {
            [0, 1].map(|axis| {
                let away = positions[3 * striker + axis] - positions[3 * target + axis];
                (away / cell[axis]).round() * cell[axis]
            })
        });
        let striker = Corner {
            square: striker,
            vertex: vertex as u8,
        };
        touches.push(Contact::of_corner(
            network, positions, striker, target, shift,
        ));
    }
    let contacts = without_repetitions(&touches);
    let rows: Vec<Row> = contacts
        .iter()
        .map(|contact| contact.row(network, positions))
        .collect();
    let mut rods = RodSystem::new(network);
    rods.linearize(positions).map_err(|error| match error {
        SparseError::Dependent { row, .. } => CrystalError::OverConstrained {
            rod: row,
            time: 0.0,
        },
        other => CrystalError::BadNetwork(other.to_string()),
    })?;
    let mut velocities_after = velocities.to_vec();
    let impact = impact(
        network,
        &mut rods,
        &mut velocities_after,
        &rows,
        restitution,
        None,
    );
    Ok(Response {
        velocities_after,
        contacts,
        impulses: impact.impulses,
    })
}

pub(crate) fn check_restitution(value: f64) -> Result<()> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    Err(CrystalError::BadSetting {
        setting: "restitution",
        value,
        requirement: "between 0 and 1",
    })
}
