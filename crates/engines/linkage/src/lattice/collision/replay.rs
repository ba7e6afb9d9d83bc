//! First contact and response of single states.

use super::detection::Detector;
use super::response::{check_restitution, impact};
use crate::error::{CrystalError, Result, require_positive};
use crate::lattice::cell::Cell;
use crate::lattice::contact::{Contact, TOUCHING, without_repetitions};
use crate::lattice::network::{Corner, Network};
use crate::lattice::rods::RodSystem;
use crate::lattice::{Dynamics, State};

/// Time left to a goal counts as none below this share of a step.
const REACHED: f64 = 1e-12;

/// The first contact of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstContact {
    /// Time of the contact.
    pub time: f64,
    /// The state at contact, before any impact.
    pub state: State,
    /// All contacts at that time; corners head on are listed from either side.
    pub contacts: Vec<Contact>,
}

impl FirstContact {
    /// Contacts of squares as [striker, corner 1 to 4, target].
    pub fn listed(&self) -> Vec<[usize; 3]> {
        listed(&self.contacts)
    }
}

fn listed(contacts: &[Contact]) -> Vec<[usize; 3]> {
    let mut list = Vec::new();
    for contact in contacts {
        let (striker, target) = match *contact {
            Contact::VertexSide {
                striker, target, ..
            } => (striker, target),
            Contact::VertexVertex {
                striker, target, ..
            } => (striker, target.square),
            Contact::RodCorner { .. } | Contact::RodStop { .. } => continue,
        };
        list.push([striker.square, usize::from(striker.vertex), target]);
    }
    list
}

/// Contacts of squares in a state, as [striker, corner 1 to 4, target]; corners head on from either
/// side.
///
/// ```
/// use protomer_linkage::lattice::collision::replay::touching;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(1, 2, 0.5, Square::default(), Edges::Open, 0.0)?;
/// let mut state = State::coherent(&network, 0.0);
/// assert!(touching(&network, &state).is_empty());
/// // Side against side: two corners of each square touch the other.
/// state.positions[0] += 0.5;
/// assert_eq!(touching(&network, &state).len(), 4);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub fn touching(network: &Network, state: &State) -> Vec<[usize; 3]> {
    let detector = Detector::new(network, &state.positions, false);
    let mut contacts = Vec::new();
    for watch in detector.watches() {
        if watch.gap(network, &state.positions) <= TOUCHING {
            watch.contacts(network, &state.positions, &mut contacts);
        }
    }
    listed(&contacts)
}

/// Continues from a prepared state in steps of `step` to the first contact of squares (and of rods,
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
    require_positive("step", step)?;
    let network = dynamics.network().clone();
    let mut detector = Detector::new(&network, &state.positions, rods_block);
    detector.check_no_overlap(&network, &state.positions, state.time)?;
    let mut positions = state.positions.clone();
    let begin = state.time;
    for index in 1_u64.. {
        // From the beginning, not added up: goals do not collect rounding.
        let goal = (begin + index as f64 * step).min(until);
        let remaining_time = goal - state.time;
        if remaining_time <= REACHED * step {
            break;
        }
        let meeting = detector.first_meeting(dynamics, state, remaining_time, &mut positions)?;
        let length = meeting.map_or(remaining_time, |meeting| meeting.time);
        if length > 0.0 {
            dynamics.arrive(state, length, &positions)?;
        }
        // A meeting of the path that was none: the step goes on.
        if meeting.is_none() {
            continue;
        }
        let contacts = detector.touching(&network, &state.positions);
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

/// The velocities after an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Velocities after the impact.
    pub velocities_after: Vec<f64>,
    /// Contacts; corners that meet head on are listed once.
    pub contacts: Vec<Contact>,
    /// Impulse of each contact.
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
    let mut state = State {
        time: 0.0,
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
    };
    state.check(network)?;
    check_restitution(restitution)?;
    let mut touches = Vec::with_capacity(contacts.len());
    for contact in contacts {
        touches.push(touch(network, positions, *contact)?);
    }
    // Head-on corners are listed from both sides and count once.
    let contacts = without_repetitions(&touches);
    let mut rows = Vec::with_capacity(contacts.len());
    for contact in &contacts {
        rows.push(contact.row(network, positions));
    }
    // The rods transmit the impulse, so they are linearised where it happens.
    let mut rods = RodSystem::new(network);
    rods.linearize(positions, state.time)?;
    let velocities = &mut state.velocities;
    let impact = impact(network, &mut rods, velocities, &rows, restitution, None);
    Ok(Response {
        velocities_after: state.velocities,
        contacts,
        impulses: impact.impulses,
    })
}

/// The touch that a contact of a list describes.
fn touch(
    network: &Network,
    positions: &[f64],
    [striker, vertex, target]: [usize; 3],
) -> Result<Contact> {
    let squares = network.squares.len();
    if striker >= squares || target >= squares || !(1..=4).contains(&vertex) {
        return Err(CrystalError::BadState(format!(
            "contact [{striker}, {vertex}, {target}]: squares are 0 to {}, corners 1 to 4",
            squares - 1
        )));
    }
    let image = nearest_image(network, positions, striker, target);
    let striker = Corner {
        square: striker,
        vertex: vertex as u8,
    };
    Ok(Contact::of_corner(
        network, positions, striker, target, image,
    ))
}

/// The image of the target that is nearest to the striker.
fn nearest_image(network: &Network, positions: &[f64], striker: usize, target: usize) -> [i32; 2] {
    if network.cell.is_none() {
        return [0; 2];
    }
    let cell = Cell::read(network, positions);
    let [x, y] = [0, 1].map(|axis| positions[3 * striker + axis] - positions[3 * target + axis]);
    let up = (y / cell.yy).round();
    let right = ((x - up * cell.xy) / cell.xx).round();
    [right as i32, up as i32]
}
