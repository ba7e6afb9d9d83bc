//! Trial changes of the box at constant pressure.
//!
//! A change deforms space: x → E x with an upper triangular E. It acts on the edges of the box, h → E h, and on
//! the centres of the bodies alike, and leaves orientations as they are. It is refused if bodies overlap then.
//!
//! **What is sampled.** Boxes h = N diag(L) have lengths L and tilt factors n, the entries of N (see
//! [`periodic_box`](protomer_kernel::periodic_box)). Places in parts of the edges make a state of N bodies
//! weigh V^N exp(-βPV), and boxes are weighed by
//!
//! ```text
//! V ∏ d(ln L_k) ∏ dn_kj = dV · (a measure on shapes)
//! ```
//!
//! This is the measure on shapes that depends neither on how the box is turned nor on which edges describe
//! the lattice of its images: the right Haar measure of the upper triangular matrices, the part of dh/V^D
//! that is left when rotations are taken out. The volume of an ideal gas then has the density V^N exp(-βPV),
//! as in a cube.
//!
//! **Detailed balance.** A change and its inverse are equally likely, so a change is accepted with
//! min(1, J π'/π), where π = V^(N+1) exp(-βPV) is the density in ln L and n, and J the factor by which the
//! change enlarges ∏ d(ln L) ∏ dn (Green, Biometrika 82, 711 (1995)):
//!
//! | change | E | ln(J π'/π) |
//! |---|---|---|
//! | volume | e^(g/D) | (N + 1) g - βP(V' - V) (Wood, J. Chem. Phys. 48, 415 (1968)) |
//! | length along an axis, angles stay right | 1, but e^g there | the same |
//! | stretch along i, and j is shorter | 1, but e^g at i, e^-g at j | 2 (j - i) g |
//! | shear | 1, and s in row i, column j > i | 0 |
//!
//! The factor e^g at i multiplies the D - i tilt factors in row i by e^g and the i - 1 in column i by e^-g, so a
//! stretch has J = e^((D + 1 - 2i) g - (D + 1 - 2j) g). Without tilt there are none of these, and J = 1. A shear
//! adds s times row j of N to row i, which changes no volume in n.
//!
//! **Other edges.** E acts from the left, a change of edges h → h M with a matrix M of integers from the right, so
//! it does not matter whether it comes before or after: edges that overhang far may be reduced at any time.
//!
//! **Bounds.** In a fluid no shape is better than another, so shapes would wander off. A stretch or a change of one
//! length is refused if a length, at equal volume, would become more than twice or less than half of what it was at the
//! start. With tilt, the same lattice of images can occur within these bounds with several sets of edges.
//!
//! **Depletants.** A state weighs V^N exp(-βΠV - z V_covered) then, so the pressure Π is the osmotic one, by which the
//! bodies' side of a membrane exceeds the reservoir of the depletants. V_covered is never computed: depletants are drawn around
//! the bodies, M of them, and move with the space. Bodies and depletants together weigh V^(N+M) exp(-(βΠ + z) V), which
//! adds M g - z (V' - V) to ln(J π'/π), and a depletant that is covered after the change forbids it.
//!
//! **Small boxes.** Two bodies may meet at several images, but none may meet an image of itself. A change that only
//! this forbids is an error: a run that refused it would measure the smallest box instead of the pressure.

use crate::reservoir::Depletant;
use crate::system::{Counts, Deformation, System};
use crate::{Error, Result};
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::dot;
use serde::{Deserialize, Serialize};

/// Acceptance that the steps are tuned to.
const ACCEPTANCE: f64 = 0.3;
/// Smallest number of changes for tuning; fewer say little about their acceptance.
const ENOUGH: u64 = 40;
/// The largest step at first.
const FIRST_STEP: f64 = 0.01;
/// The largest step that tuning may reach.
const LARGEST_STEP: f64 = 1.0;
/// A length of the box at equal volume stays within this factor of the first.
const WIDEST: f64 = 2.0;

/// Quantities of the box that change at constant pressure.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Freedom {
    /// The volume; the shape stays.
    #[default]
    Volume,
    /// Each length on its own; right angles stay right.
    Lengths,
    /// Volume, lengths and tilts.
    Shape,
}

/// A constant pressure.
///
/// ```
/// use protomer_hpmc::box_moves::{Freedom, Pressure};
/// let pressure = Pressure { kt_per_volume: 8.0, freedom: Freedom::Shape, changes_per_sweep: None };
/// assert_eq!(pressure.changes(), 8);
/// assert_eq!(Pressure { changes_per_sweep: Some(1), ..pressure }.changes(), 1);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// βP, kT per volume; in a plane, per area.
    pub kt_per_volume: f64,
    /// Quantities of the box that change.
    #[serde(default)]
    pub freedom: Freedom,
    /// Trial changes of the box in a sweep; `None` for as many as suit the freedom.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub changes_per_sweep: Option<u32>,
}

impl Pressure {
    /// Trial changes of the box in a sweep. By default four, or eight where the shape changes: most end at the
    /// first overlap, after a small part of a sweep.
    pub fn changes(&self) -> u32 {
        self.changes_per_sweep.unwrap_or(match self.freedom {
            Freedom::Volume | Freedom::Lengths => 4,
            Freedom::Shape => 8,
        })
    }
}

/// A largest step and how changes with it were accepted since it was tuned last.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxStep {
    /// The largest g or s.
    pub largest: f64,
    /// Changes since the last tuning.
    pub counts: Counts,
}

impl Default for BoxStep {
    fn default() -> Self {
        Self {
            largest: FIRST_STEP,
            counts: Counts::default(),
        }
    }
}

impl BoxStep {
    fn tune(&mut self) {
        if self.counts.trials >= ENOUGH {
            // Within a factor, so that a short count cannot throw the step far off.
            let factor = (self.counts.acceptance() / ACCEPTANCE).clamp(0.5, 1.5);
            self.largest = (self.largest * factor).min(LARGEST_STEP);
            self.counts = Counts::default();
        }
    }
}

/// The steps of all changes, and the shape at the start.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxMoves {
    /// Step of the volume, or of one length.
    pub volume: BoxStep,
    /// Step of a stretch.
    pub stretch: BoxStep,
    /// Step of a shear.
    pub shear: BoxStep,
    /// Lengths of the box at the start, at a volume of one.
    pub first_shape: Vec<f64>,
}

/// A deformation of space.
#[derive(Debug, Clone, Copy)]
enum Change {
    /// Change of the volume, by the logarithm of a factor.
    Volume(f64),
    /// Change of the length along an axis, counted from zero, by the logarithm of a factor.
    Length(usize, f64),
    /// Stretch of the first axis by the logarithm of a factor, and of the second by its inverse.
    Stretch([usize; 2], f64),
    /// Shear of the first axis, by a part of the coordinate along the second.
    Shear([usize; 2], f64),
}

impl BoxMoves {
    /// Steps of a run that begins in this box.
    pub(crate) fn new<const D: usize>(space: &PeriodicBox<D>) -> Self {
        Self {
            first_shape: shape(space).to_vec(),
            ..Self::default()
        }
    }

    /// The accepted part of all changes, since their steps were tuned last.
    pub(crate) fn acceptance(&self) -> f64 {
        let (mut trials, mut accepted) = (0, 0);
        for step in [&self.volume, &self.stretch, &self.shear] {
            trials += step.counts.trials;
            accepted += step.counts.accepted;
        }
        Counts { trials, accepted }.acceptance()
    }

    pub(crate) fn tune(&mut self) {
        for step in [&mut self.volume, &mut self.stretch, &mut self.shear] {
            step.tune();
        }
    }

    /// Makes one trial change, with the numbers of a stream; `number` counts the changes of the
    /// run.
    ///
    /// # Errors
    /// If nothing but the size of the box forbids it.
    pub(crate) fn change<const D: usize>(
        &mut self,
        system: &mut System<D>,
        pressure: &Pressure,
        number: u64,
        rng: &mut CounterRng,
    ) -> Result<()> {
        let change = self.propose::<D>(pressure.freedom, number, rng);
        let deformation = change.deformation::<D>();
        let chance = rng.uniform();
        let around = Around::draw(system, rng);
        let weight = change.weight(system, pressure) + around.weight(system, &change);
        // The weight first: it is cheap, and a refused change need not touch the bodies. With a potential the energy
        // decides as well, and that is known afterwards.
        let is_likely = system.potential.is_some() || chance < weight.exp();
        let step = match change {
            Change::Volume(_) | Change::Length(..) => &mut self.volume,
            Change::Stretch(..) => &mut self.stretch,
            Change::Shear(..) => &mut self.shear,
        };
        let is_allowed = match change {
            Change::Stretch(..) | Change::Length(..) => {
                // Bounds are for the new box; volume and shear
                // leave the lengths' ratios as they are.
                is_within(&self.first_shape, &system.space().deformed(&deformation))
            }
            Change::Volume(_) | Change::Shear(..) => true,
        };
        let end = match is_likely && is_allowed {
            true => around.try_deform(system, &deformation, &|change| {
                chance < (weight - change).exp()
            }),
            false => Deformation::Blocked,
        };
        step.counts.note(end == Deformation::Done);
        match end {
            // Refused for size alone: going on would measure the smallest box, not the pressure.
            Deformation::TooSmall => Err(Error::BoxShrinks {
                edge: system.space().deformed(&deformation).smallest_length(),
                least: system.least_edge(),
                bodies: fewest_bodies(&self.first_shape, pressure.freedom, system),
            }),
            Deformation::Done | Deformation::Blocked => Ok(()),
        }
    }

    /// Draws a change: of eight changes of a shape, one is of the volume, three are stretches and
    /// four shears.
    fn propose<const D: usize>(
        &self,
        freedom: Freedom,
        number: u64,
        rng: &mut CounterRng,
    ) -> Change {
        // One number is drawn whatever the change, so that the stream does not depend on it.
        let part = rng.uniform_in(-1.0, 1.0);
        let (growth, stretch) = (self.volume.largest * part, self.stretch.largest * part);
        match (freedom, number % 8) {
            (Freedom::Lengths, _) => Change::Length(rng.index(D), growth),
            (Freedom::Volume, _) | (Freedom::Shape, 0) => Change::Volume(growth),
            _ if D == 1 => Change::Volume(growth),
            (_, 1 | 3 | 5) => Change::Stretch(pair::<D>(rng), stretch),
            _ => Change::Shear(pair::<D>(rng), self.shear.largest * part),
        }
    }
}

/// Depletants around the bodies of a state, in parts of the edges of the box.
struct Around<const D: usize> {
    kinds: Vec<(Depletant, Vec<[f64; D]>)>,
}

impl<const D: usize> Around<D> {
    fn draw(system: &System<D>, rng: &mut CounterRng) -> Self {
        let kinds = system
            .depletants()
            .iter()
            .filter(|kind| kind.fugacity > 0.0);
        let kinds = kinds.map(|kind| (*kind, system.draw_depletants(kind, rng)));
        Self {
            kinds: kinds.collect(),
        }
    }

    /// Part of ln(J π'/π) that the depletants add.
    fn weight(&self, system: &System<D>, change: &Change) -> f64 {
        let (Change::Volume(growth) | Change::Length(_, growth)) = *change else {
            return 0.0;
        };
        let more = system.volume() * (growth.exp() - 1.0);
        let of_kind = |(kind, points): &(Depletant, Vec<[f64; D]>)| {
            points.len() as f64 * growth - kind.fugacity * more
        };
        self.kinds.iter().map(of_kind).sum()
    }

    /// Deforms the box with the depletants in it, unless bodies overlap or cover a depletant then, or the change of the
    /// energy (kT) is not allowed.
    fn try_deform(
        &self,
        system: &mut System<D>,
        deformation: &[[f64; D]; D],
        allows: &dyn Fn(f64) -> bool,
    ) -> Deformation {
        if self.kinds.is_empty() && system.potential.is_none() {
            return system.try_deform(deformation);
        }
        let energy = system.potential_energy_kt();
        let before = (system.space, system.positions.clone(), system.grid.clone());
        let edges = system.space;
        let end = system.try_deform(deformation);
        let is_covered = |(kind, points): &(Depletant, Vec<[f64; D]>)| {
            points.iter().any(|parts| {
                // By the edges of before, deformed: those of the new box may be other ones of the same images.
                let place = edges.point(parts);
                let moved = deformation.map(|row| dot(&row, &place));
                system.is_covered(&system.space.wrap(&moved), kind.radius)
            })
        };
        let is_done = end == Deformation::Done;
        let is_refused = || {
            let has_potential = system.potential.is_some();
            has_potential && !allows(system.potential_energy_kt() - energy)
                || self.kinds.iter().any(is_covered)
        };
        if is_done && is_refused() {
            (system.space, system.positions, system.grid) = before;
            return Deformation::Blocked;
        }
        end
    }
}

/// Whether each length, at equal volume, is within its bounds.
fn is_within<const D: usize>(first_shape: &[f64], space: &PeriodicBox<D>) -> bool {
    let lengths = shape(space).into_iter().zip(first_shape);
    let mut factors = lengths.map(|(length, first)| length / first);
    factors.all(|factor| (WIDEST.recip()..=WIDEST).contains(&factor))
}

/// A number of bodies whose box cannot become too small, even if they fill it: its shortest length at a volume of
/// one, which shrinks where the shape changes, is known.
fn fewest_bodies<const D: usize>(
    first_shape: &[f64],
    freedom: Freedom,
    system: &System<D>,
) -> usize {
    let shortest = first_shape.iter().copied().fold(f64::INFINITY, f64::min);
    let shortest = match freedom {
        // Shapes may become as flat as their bounds allow.
        Freedom::Volume => shortest,
        Freedom::Lengths | Freedom::Shape => shortest / WIDEST,
    };
    let volume = (system.least_edge() / shortest).powi(D as i32);
    let mean_volume = system.body_volume() / system.len().max(1) as f64;
    (volume / mean_volume).ceil() as usize
}

/// Two axes, the lower first.
fn pair<const D: usize>(rng: &mut CounterRng) -> [usize; 2] {
    match rng.index(D * (D - 1) / 2) {
        0 => [0, 1],
        1 => [0, 2],
        _ => [1, 2],
    }
}

/// The lengths at a volume of one.
fn shape<const D: usize>(space: &PeriodicBox<D>) -> [f64; D] {
    let unit = space.volume().powf(1.0 / D as f64);
    space.lengths().map(|length| length / unit)
}

impl Change {
    /// E, row by row.
    fn deformation<const D: usize>(&self) -> [[f64; D]; D] {
        let mut deformation = [[0.0; D]; D];
        for (axis, row) in deformation.iter_mut().enumerate() {
            row[axis] = match self {
                Self::Volume(growth) => (growth / D as f64).exp(),
                Self::Length(length_axis, growth) if *length_axis == axis => growth.exp(),
                Self::Stretch([longer_axis, _], growth) if *longer_axis == axis => growth.exp(),
                Self::Stretch([_, shorter_axis], growth) if *shorter_axis == axis => {
                    (-growth).exp()
                }
                _ => 1.0,
            };
        }
        if let Self::Shear([row, column], part) = self {
            deformation[*row][*column] = *part;
        }
        deformation
    }

    /// ln(J π'/π).
    fn weight<const D: usize>(&self, system: &System<D>, pressure: &Pressure) -> f64 {
        match *self {
            Self::Volume(growth) | Self::Length(_, growth) => {
                // V' - V = V (e^g - 1).
                let change = system.volume() * (growth.exp() - 1.0);
                (system.len() as f64 + 1.0) * growth - pressure.kt_per_volume * change
            }
            Self::Stretch([along, across], growth) => 2.0 * (across as f64 - along as f64) * growth,
            Self::Shear(..) => 0.0,
        }
    }
}
