//! Nested sampling: the integral of a Boltzmann factor over states that can be drawn from a prior.
//!
//! ```text
//! Z = ∫ exp(-U) dX over the volume X of the prior
//! ```
//!
//! A deep well holds 10⁻¹⁰ of the volume, in places that nobody knows beforehand. Nested sampling (Skilling,
//! Bayesian Anal. 1, 833 (2006)) closes in on it: of N live states it replaces the one of highest energy by
//! one below, drawn from the prior, so that the volume shrinks by a factor 1 - 1/N at a time, on average. It
//! needs no temperature and no guess of the form of the well, and hard surfaces do not disturb it.
//!
//! A new state comes from a walk that starts at another live state. Its steps are differences of live states
//! (ter Braak, Stat. Comput. 16, 239 (2006)), which have the shape of what is left. Equal energies are told
//! apart by a random mark. The error is √(H/N), with the information H in nats.

use protomer_kernel::random::CounterRng;

/// States with a prior that can be drawn, and an energy.
pub(crate) trait Space: Sync {
    /// One state.
    type State: Clone;

    /// Volume of the prior, Å³ to the power of the number of bodies that move less one.
    fn volume(&self) -> f64;

    /// A state drawn from the prior, with its energy in kT; `None` at overlap.
    fn draw(&self, rng: &mut CounterRng) -> Option<(Self::State, f64)>;

    /// The end of a step that leaves the prior as it is.
    fn step(&self, step: &Step<'_, Self::State>, rng: &mut CounterRng) -> Stepped<Self::State>;

    /// Energies from this one on are those of overlaps that a space orders itself, kT: they count for nothing.
    fn least_overlap_kt(&self) -> f64 {
        f64::INFINITY
    }

    /// Accepted steps that a walk should have.
    fn wanted_steps(&self) -> f64 {
        WANTED_STEPS
    }
}

/// A step of a walk.
pub(crate) struct Step<'a, S> {
    /// Start of the step.
    pub from: &'a S,
    /// Two live states; their difference gives the step its direction and length.
    pub between: [&'a S; 2],
    /// Length in units of that difference, negative for the opposite direction.
    pub scale: f64,
    /// Even random number that decides on densities of the prior.
    pub uniform: f64,
}

/// The end of a step.
pub(crate) enum Stepped<S> {
    /// The prior refused the step; no energy was computed.
    Refused,
    /// Bodies overlap.
    Overlap,
    /// A state and its energy, kT.
    Free(S, f64),
}

/// A state of a run.
#[derive(Debug, Clone)]
pub(crate) struct Live<S> {
    /// The state.
    pub state: S,
    /// Energy of the state, kT.
    pub energy_kt: f64,
    /// Random mark that tells equal energies apart.
    mark: f64,
}

impl<S> Live<S> {
    fn is_below(&self, energy_kt: f64, mark: f64) -> bool {
        self.energy_kt < energy_kt || (self.energy_kt == energy_kt && self.mark < mark)
    }
}

/// Result of one run.
pub(crate) struct Nested<S> {
    /// States with the logarithms of their weights in the integral.
    pub states: Vec<(Live<S>, f64)>,
    /// Logarithm of the integral.
    pub ln_integral: f64,
    /// Variance of that logarithm.
    pub variance: f64,
    /// Energies that were computed.
    pub evaluations: u64,
}

/// Share of the integral that may be left when a run ends.
const LEFT: f64 = 1e-3;
/// Shrinkage of the volume, in nats, in which all states may overlap; less is no room.
const MOST_OVERLAPPING: u64 = 40;
/// States that are tried for the first live ones, for each of them.
const MOST_TRIES: u64 = 2000;
/// Accepted steps that a walk of one body should have.
pub(crate) const WANTED_STEPS: f64 = 12.0;
/// Shortest step of a walk, in differences of live states; the longest is one. Shorter ones mix too slowly: with 0.05 the
/// integral of a harmonic well comes out 28 % too large.
const SHORTEST: f64 = 0.25;
/// Fewest and most steps of a walk, in wanted accepted ones.
const STEPS: (f64, f64) = (16.0 / WANTED_STEPS, 160.0 / WANTED_STEPS);

/// One run with this many live states; `None` without room, or if the work was ended. `stream` has the random
/// numbers of each step; `goes_on` is asked after each step and ends the work early with `false`.
pub(crate) fn nested<S: Space>(
    space: &S,
    live_states: usize,
    stream: &dyn Fn(u64) -> CounterRng,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<Nested<S::State>> {
    let (mut live, share, mut evaluations) =
        first_states(space, live_states, &mut stream(0), goes_on)?;
    let mut ln_volume = (space.volume() * share).ln();
    let mut states = Vec::new();
    let mut ln_integral = f64::NEG_INFINITY;
    // A guess: twice the wanted steps, as if half of them were accepted; it adapts.
    let mut steps = space.wanted_steps() * 2.0;
    for step in 1.. {
        if !goes_on() {
            return None;
        }
        let (highest, lowest_kt) = ends(&live);
        let removed_kt = live[highest].energy_kt;
        // Each removal shrinks the volume by 1 - 1/N on average, in logarithms.
        let ln_next = ln_volume + (-1.0 / live_states as f64).ln_1p();
        let ln_weight = ln_difference(ln_volume, ln_next) - removed_kt;
        let is_free = lowest_kt < space.least_overlap_kt();
        // All live states at the lowest energy could add no more than this part: enough.
        if is_free && ln_next - lowest_kt < ln_integral + LEFT.ln() {
            break;
        }
        if !is_free && step > MOST_OVERLAPPING * live_states as u64 {
            return None;
        }
        ln_integral = ln_sum(ln_integral, ln_weight);
        ln_volume = ln_next;
        let mut rng = stream(step);
        let walk = walk(space, &live, highest, steps as u32, &mut rng);
        // The removed state's place is filled by a walk
        // from one of the others, below the same energy.
        evaluations += walk.evaluations;
        steps = walk.next_steps(steps, space.wanted_steps());
        states.push((std::mem::replace(&mut live[highest], walk.end), ln_weight));
    }
    // What is left of the volume, shared by the live states.
    for left in live {
        let ln_weight = ln_volume - (live_states as f64).ln() - left.energy_kt;
        ln_integral = ln_sum(ln_integral, ln_weight);
        states.push((left, ln_weight));
    }
    let information = information(&states, ln_integral, space.volume() * share);
    // H/N of the shrinkage, and the error of the share without overlap.
    let variance = (information.max(0.0) + (1.0 - share)) / live_states as f64;
    Some(Nested {
        states,
        ln_integral,
        variance,
        evaluations,
    })
}

impl<S> Nested<S> {
    /// States in proportion to their weights, by equal steps from a random start between zero and one.
    pub fn resampled(&self, wanted: usize, start: f64) -> Vec<&S> {
        let mut samples = Vec::with_capacity(wanted);
        let mut sum = 0.0;
        for (live, ln_weight) in &self.states {
            sum += (ln_weight - self.ln_integral).exp() * wanted as f64;
            while (samples.len() as f64 + start) < sum && samples.len() < wanted {
                samples.push(&live.state);
            }
        }
        samples
    }
}

/// Length of a step in differences of live states, with its sign.
pub(crate) fn step_scale(rng: &mut CounterRng) -> f64 {
    // Lengths over a range of scales: the live states
    // may lie in a ridge or in several places.
    SHORTEST.powf(rng.uniform()) * (if rng.uniform() < 0.5 { 1.0 } else { -1.0 })
}

/// Live states, the share of states without overlap in the prior, and the number of states tried.
type FirstStates<S> = (Vec<Live<S>>, f64, u64);

/// Live states without overlap, the share of such states in the prior, and the number of states tried.
fn first_states<S: Space>(
    space: &S,
    count: usize,
    rng: &mut CounterRng,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<FirstStates<S::State>> {
    let mut live = Vec::with_capacity(count);
    let mut tries = 0;
    while live.len() < count {
        // No room within the prior, or asked to stop.
        if tries > MOST_TRIES * count as u64 || !goes_on() {
            return None;
        }
        tries += 1;
        if let Some((state, energy_kt)) = space.draw(rng) {
            let mark = rng.uniform();
            live.push(Live {
                state,
                energy_kt,
                mark,
            });
        }
    }
    // The last try is a success by construction; without it the share has no bias.
    let share = match tries {
        1 => 1.0,
        tries => (count - 1) as f64 / (tries - 1) as f64,
    };
    Some((live, share, tries))
}

/// A walk and how it went.
struct Walk<S> {
    end: Live<S>,
    accepted: u32,
    steps: u32,
    evaluations: u64,
}

impl<S> Walk<S> {
    /// Steps of the next walk: enough for the wanted accepted ones, changed slowly.
    fn next_steps(&self, present: f64, wanted_steps: f64) -> f64 {
        // Half a step more, so that a walk without success does not divide by zero.
        let rate = (f64::from(self.accepted) + 0.5) / f64::from(self.steps);
        let wanted = (wanted_steps / rate).clamp(STEPS.0 * wanted_steps, STEPS.1 * wanted_steps);
        // One part in twenty per walk: the length follows
        // the shrinking volume, not the luck of a walk.
        present + 0.05 * (wanted - present)
    }
}

/// A walk below the highest of the live states, from one of the others.
fn walk<S: Space>(
    space: &S,
    live: &[Live<S::State>],
    highest: usize,
    steps: u32,
    rng: &mut CounterRng,
) -> Walk<S::State> {
    // Any live state but the highest, without a loop of rejections.
    let other = |rng: &mut CounterRng| (highest + 1 + rng.index(live.len() - 1)) % live.len();
    let limit = &live[highest];
    let mut walk = Walk {
        end: live[other(rng)].clone(),
        accepted: 0,
        steps,
        evaluations: 0,
    };
    for _ in 0..steps {
        let (a, b) = (other(rng), other(rng));
        let scale = step_scale(rng);
        // Drawn before any test: how many numbers a step takes must not depend on its outcome.
        let (mark, uniform) = (rng.uniform(), rng.uniform());
        // No difference is no step.
        if a == b {
            continue;
        }
        let step = Step {
            from: &walk.end.state,
            between: [&live[a].state, &live[b].state],
            scale,
            uniform,
        };
        let (state, energy_kt) = match space.step(&step, rng) {
            Stepped::Refused => continue,
            // An overlap is infinite energy: never below.
            Stepped::Overlap => {
                walk.evaluations += 1;
                continue;
            }
            Stepped::Free(state, energy_kt) => (state, energy_kt),
        };
        walk.evaluations += 1;
        let moved = Live {
            state,
            energy_kt,
            mark,
        };
        // Energies only need to be below the limit: within
        // it the walk is even, without a temperature.
        if moved.is_below(limit.energy_kt, limit.mark) {
            walk.end = moved;
            walk.accepted += 1;
        }
    }
    walk
}

/// The live state of highest energy, and the lowest energy, kT.
fn ends<S>(live: &[Live<S>]) -> (usize, f64) {
    let (mut highest, mut lowest_kt) = (0, f64::INFINITY);
    for (number, state) in live.iter().enumerate() {
        if live[highest].is_below(state.energy_kt, state.mark) {
            highest = number;
        }
        lowest_kt = lowest_kt.min(state.energy_kt);
    }
    (highest, lowest_kt)
}

/// H = ∫ P ln(P/π): how far the states are from the prior, in nats.
fn information<S>(states: &[(Live<S>, f64)], ln_integral: f64, volume: f64) -> f64 {
    let mean =
        |(live, ln_weight): &(Live<S>, f64)| -(ln_weight - ln_integral).exp() * live.energy_kt;
    states.iter().map(mean).sum::<f64>() - ln_integral + volume.ln()
}

/// ln(exp a + exp b).
pub(crate) fn ln_sum(a: f64, b: f64) -> f64 {
    let (large, small) = (a.max(b), a.min(b));
    // -∞ less -∞ would be no number.
    match large == f64::NEG_INFINITY {
        true => large,
        false => large + (small - large).exp().ln_1p(),
    }
}

/// ln(exp a - exp b) for a > b.
fn ln_difference(a: f64, b: f64) -> f64 {
    a + (-(b - a).exp()).ln_1p()
}
