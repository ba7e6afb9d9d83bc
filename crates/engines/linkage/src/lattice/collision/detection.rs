//! The first contact in a step.
//!
//! The step is taken to follow a `Path` that ends where the drift ends. On it
//! [`march`](super::march) finds the first contact of every pair that is near enough; the earliest
//! is then brought to the true sub-step, which keeps the rods exactly, by Newton steps on the gap.
//!
//! Most pairs need no look in most steps. A pair with separation g when last seen cannot meet before
//! the fastest square has travelled g/2 since, corners included: it is `due` only then.

use super::march::{End, ROOT};
use super::path::Path;
use super::watch::Watch;
use crate::lattice::contact::candidates::Candidates;
use crate::lattice::contact::{Contact, TOUCHING};
use crate::lattice::network::{Network, Rod};
use crate::lattice::{Dynamics, State};
use crate::{CrystalError, Result};
use std::f64::consts::SQRT_2;

/// Extra width of the candidate list, in half-diagonals.
const SKIN: f64 = 0.5;
/// Width of the list for fast squares, in the farthest travel of a step.
const SKIN_PER_TRAVEL: f64 = 2.5;
/// Largest number of Newton steps towards the time of a contact.
const MOST_NEWTON_STEPS: usize = 40;
/// Rods longer than this, in half-diagonals, are obstacles by default. On random 10 x 10 lattices
/// no corner met a rod up to r0 = 0.7 in 2000 steps of 0.005, and some did at 1.
const BLOCKING_LENGTH: f64 = 0.5;

/// Finds contacts, and remembers which pairs are not due yet.
#[derive(Debug, Clone)]
pub struct Detector {
    candidates: Candidates,
    skin: f64,
    rods_block: bool,
    stops: Vec<Watch>,
    /// Value of `travelled` at which each pair, and then each stop, needs a look.
    due: Vec<f64>,
    /// Twice the farthest travel of a square or an image since the list was made.
    travelled: f64,
    /// Watches whose gaps can have closed in the last step looked at.
    hot: Vec<Hot>,
    /// Contacts found on their paths.
    roots: Vec<Root>,
    free: Vec<f64>,
    total: Vec<f64>,
}

/// A watch whose gap can close in a step, and whether its bodies touched at the start.
#[derive(Debug, Clone, Copy)]
struct Hot {
    watch: Watch,
    touched: bool,
}

/// A contact on the path: its time, and the rate at which the gap closes.
#[derive(Debug, Clone, Copy)]
struct Root {
    watch: Watch,
    time: f64,
    rate: f64,
}

/// First contact in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Time since the start of the step.
    pub time: f64,
    /// Bodies that meet.
    pub watch: Watch,
}

impl Detector {
    /// A detector for a network at these positions. With `rods_block`, rods are obstacles for
    /// corners and for the squares on which they hang.
    pub fn new(network: &Network, positions: &[f64], rods_block: bool) -> Self {
        let mut half_diagonal = 0.0_f64;
        for square in &network.squares {
            half_diagonal = half_diagonal.max(square.half_diagonal);
        }
        let skin = SKIN * half_diagonal;
        let candidates = Candidates::new(network, positions, skin, rods_block);
        let stops = if rods_block {
            stops(network)
        } else {
            Vec::new()
        };
        Self {
            skin,
            rods_block,
            due: vec![0.0; candidates.pairs().len() + stops.len()],
            candidates,
            stops,
            travelled: 0.0,
            hot: Vec::new(),
            roots: Vec::new(),
            free: vec![0.0; positions.len()],
            total: vec![0.0; positions.len()],
        }
    }

    /// Whether rods are obstacles.
    pub fn rods_block(&self) -> bool {
        self.rods_block
    }

    /// Number of times the list of near pairs was made.
    pub fn lists(&self) -> u64 {
        self.candidates.rebuilds()
    }

    /// All watches on the list, with those of rods and stops.
    pub fn watches(&self) -> impl Iterator<Item = Watch> + '_ {
        let pairs = self.candidates.pairs().iter().copied();
        pairs.map(Watch::Pair).chain(self.stops.iter().copied())
    }

    /// Watches whose gaps may be closed in the step last looked at.
    pub fn hot(&self) -> impl Iterator<Item = &Watch> {
        self.hot.iter().map(|hot| &hot.watch)
    }

    /// Makes the list again and forgets what is due: for positions that did not come from a step.
    pub fn reset(&mut self, network: &Network, positions: &[f64]) {
        self.candidates.rebuild(network, positions);
        let watched = self.candidates.pairs().len() + self.stops.len();
        self.due.clear();
        self.due.resize(watched, 0.0);
        self.travelled = 0.0;
    }

    /// Refuses positions at which bodies overlap by more than 1e-9.
    ///
    /// # Errors
    /// [`CrystalError::Overlap`] names the first two bodies that do.
    pub fn check_no_overlap(&self, network: &Network, positions: &[f64], time: f64) -> Result<()> {
        for watch in self.watches() {
            let gap = watch.gap(network, positions);
            if gap.is_nan() || gap < -TOUCHING {
                return Err(watch.overlap(network, -gap, time));
            }
        }
        Ok(())
    }

    /// Contacts of everything that touches at these positions, among what the last step looked at.
    /// Corners head on are listed from either side.
    pub fn touching(&self, network: &Network, positions: &[f64]) -> Vec<Contact> {
        let mut contacts = Vec::new();
        for watch in self.hot() {
            if watch.gap(network, positions) <= TOUCHING {
                watch.contacts(network, positions, &mut contacts);
            }
        }
        contacts
    }

    /// The first contact in the drift of length `step` from a prepared state. `positions` are those
    /// at its end, or at the contact, and the drift to there is the last one made.
    ///
    /// # Errors
    /// Those of [`Dynamics::drift`], [`CrystalError::NotFinite`], and [`CrystalError::Overlap`] if
    /// bodies overlap at the start.
    pub fn first_meeting(
        &mut self,
        dynamics: &mut Dynamics,
        state: &State,
        step: f64,
        positions: &mut [f64],
    ) -> Result<Option<Meeting>> {
        dynamics.drift(state, step, positions)?;
        let network = dynamics.network().clone();
        self.scan(&network, state, positions, step)?;
        let earliest = self.roots.iter().min_by(|a, b| a.time.total_cmp(&b.time));
        let Some(&Root { watch, time, rate }) = earliest else {
            return Ok(None);
        };
        // The contact is where the step begins.
        if time == 0.0 {
            positions.copy_from_slice(&state.positions);
            return Ok(Some(Meeting { time, watch }));
        }
        // The path of third order deviates from the drift only in the fourth.
        dynamics.accelerations_into(&mut self.free, &mut self.total);
        let path = Path::new(&network, state, positions, step);
        let time = path.refine(&watch, &self.total, time, rate);
        let root = Root { watch, time, rate };
        let meeting = self.on_the_drift(dynamics, state, step, root, positions)?;
        Ok(Some(meeting))
    }

    /// Finds what closes on the path from this state to `next`: fills `hot` and `roots`.
    fn scan(&mut self, network: &Network, state: &State, next: &[f64], step: f64) -> Result<()> {
        let path = Path::new(network, state, next, step);
        let travel = path.travel(self.candidates.listed_images());
        if !travel.is_finite() {
            let is_wrong = |number: &f64| !number.is_finite();
            return Err(CrystalError::NotFinite {
                square: next.iter().position(is_wrong).unwrap_or(0) / 3,
                time: state.time,
            });
        }
        // The list was made for bodies that move less: it must hold to the end of this step.
        if !self.candidates.holds(network, &state.positions, travel) {
            // Free squares may be fast: the list then reaches farther.
            let skin = self.skin.max(SKIN_PER_TRAVEL * travel);
            self.candidates.set_skin(skin);
            self.reset(network, &state.positions);
        }
        self.hot.clear();
        self.roots.clear();
        let now = self.travelled;
        // Two bodies approach by at most twice the farthest travel.
        self.travelled += 2.0 * travel;
        for index in 0..self.due.len() {
            // Not due: its gap cannot have closed yet, whatever happened since it was seen.
            if self.due[index] > self.travelled {
                continue;
            }
            let (watch, lever) = self.watch_and_lever(network, index);
            let gap = watch.gap(network, &state.positions);
            // Seen now with this gap: due when the travel could have closed it.
            self.due[index] = now + gap / lever;
            if self.due[index] <= self.travelled {
                let touched = gap <= TOUCHING;
                self.hot.push(Hot { watch, touched });
                self.look(network, state, &path, watch)?;
            }
        }
        Ok(())
    }

    /// The watch of this index, and how fast its gap can change per travel of a square: the line of
    /// a side turns with the square, and its height over a far end changes by the lever.
    fn watch_and_lever(&self, network: &Network, index: usize) -> (Watch, f64) {
        let pairs = self.candidates.pairs();
        match pairs.get(index) {
            Some(pair) => (Watch::Pair(*pair), 1.0),
            None => {
                let watch = self.stops[index - pairs.len()];
                let length = match watch {
                    Watch::Stop { rod, .. } => network.rods[rod].length,
                    Watch::Pair(_) => 0.0,
                };
                // The far end of the rod is that much farther from the axis that turns.
                (watch, 1.0 + length)
            }
        }
    }

    fn look(&mut self, network: &Network, state: &State, path: &Path, watch: Watch) -> Result<()> {
        match path.march(&watch) {
            End::Free => Ok(()),
            End::Root { time, rate } => {
                self.roots.push(Root { watch, time, rate });
                Ok(())
            }
            End::Overlapping { depth } => Err(watch.overlap(network, depth, state.time)),
        }
    }

    /// Brings a contact on the path to the true drift: everything that is near counts as one gap.
    fn on_the_drift(
        &self,
        dynamics: &mut Dynamics,
        state: &State,
        step: f64,
        root: Root,
        positions: &mut [f64],
    ) -> Result<Meeting> {
        let network = dynamics.network().clone();
        let mut watch = root.watch;
        let mut search = RootSearch::new(root.time, root.rate, step);
        // Drifts keep the rods exactly; each costs a few corrections.
        for newton_step in 0..=MOST_NEWTON_STEPS {
            dynamics.drift(state, search.time, positions)?;
            let mut gap = f64::INFINITY;
            // The smallest gap of all that is near: another pair may meet a little earlier.
            for hot in &self.hot {
                let value = hot.watch.gap(&network, positions);
                if value < gap && self.counts(hot, value, search.time) {
                    (gap, watch) = (value, hot.watch);
                }
            }
            let has_converged = gap.abs() <= ROOT || newton_step == MOST_NEWTON_STEPS;
            if has_converged || !search.advance(gap) {
                break;
            }
        }
        Ok(Meeting {
            time: search.time,
            watch,
        })
    }

    /// Whether a gap at this time may be a contact. What touched at the start and parts is none; it
    /// may come back, or the path may have been wrong.
    fn counts(&self, hot: &Hot, gap: f64, time: f64) -> bool {
        let comes_back = |root: &Root| root.watch == hot.watch && time >= 0.5 * root.time;
        // What touched and parts is none, unless its path said that it comes back.
        !hot.touched || gap < -2.0 * ROOT || self.roots.iter().any(comes_back)
    }
}

/// Newton's method on a gap, with the secant for a slope and a bracket for safety.
struct RootSearch {
    time: f64,
    rate: f64,
    /// The last time at which the gap was open, and the first at which it was closed.
    open: f64,
    closed: f64,
    step: f64,
    /// Time and gap of the guess before.
    before: Option<(f64, f64)>,
}

impl RootSearch {
    fn new(time: f64, rate: f64, step: f64) -> Self {
        Self {
            time,
            rate,
            open: 0.0,
            closed: f64::INFINITY,
            step,
            before: None,
        }
    }

    /// Goes from a gap at the present time to the next guess; false if there is none in the step.
    fn advance(&mut self, gap: f64) -> bool {
        if gap > 0.0 {
            self.open = self.open.max(self.time);
        } else {
            self.closed = self.closed.min(self.time);
        }
        // The secant corrects the rate, which was that of the path.
        if let Some((time, value)) = self.before {
            let secant = (gap - value) / (self.time - time);
            if secant < 0.0 {
                self.rate = secant;
            }
        }
        self.before = Some((self.time, gap));
        let guess = self.guess(gap);
        if guess == self.time || guess >= self.step {
            return false;
        }
        self.time = guess;
        true
    }

    fn guess(&self, gap: f64) -> f64 {
        if self.rate < 0.0 {
            let newton = self.time - gap / self.rate;
            // Newton's guess only within the bracket; otherwise halve it.
            if newton > self.open && newton < self.closed {
                return newton;
            }
        }
        if self.closed.is_finite() {
            0.5 * (self.open + self.closed)
        } else {
            0.5 * (self.open + self.step)
        }
    }
}

/// Ends of rods that can fold flat on a side of their square. A shorter rod's far end meets the side
/// itself.
fn stops(network: &Network) -> Vec<Watch> {
    let mut stops = Vec::new();
    for (rod, ends) in network.rods.iter().enumerate() {
        for end in [0, 1] {
            let square = network.squares[ends.corner_at(end).square];
            // A shorter rod's far end meets the side itself, which the squares settle.
            if ends.length > SQRT_2 * square.half_diagonal {
                stops.push(Watch::Stop { rod, end });
            }
        }
    }
    stops
}

/// Whether any rod is long enough for corners to come between its ends.
pub(crate) fn rods_block_by_default(network: &Network) -> bool {
    let is_long = |rod: &Rod| {
        [rod.from, rod.to].iter().any(|corner| {
            rod.length > BLOCKING_LENGTH * network.squares[corner.square].half_diagonal
        })
    };
    network.rods.iter().any(is_long)
}
