//! The partition function of a part from windows.
//!
//! The frames of all windows together are weighted for two states (MBAR, `crate::reweighting`): the part with its last body
//! within the limit, and the last body far away without any energy, whose integral is known:
//!
//! ```text
//! q_S+j / q_S = Z_bound / Z_free · ∫_free d³R_j dΩ_j/8π²
//! ```
//!
//! The last integral is the volume between two displacements, less what the other bodies fill.

use super::configuration::{BodyEnergies, Configuration, Flexible};
use super::growth::{
    Attachment, GrowthSettings, MOST_RUNS, NEAR_LIMIT, PartSamples, ROUNDS, Run, SAMPLES, Summary,
    attached, near,
};
use super::pulled::{Frame, Pulled, Simulated};
use super::windows::{WindowSettings, Windows, WindowsFound};
use super::{Arrangement, PartKind};
use crate::pair::region::Region;
use crate::reweighting::Mixture;
use crate::{McError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::jackknife_error;
use rayon::prelude::*;

/// Radius of a body, relative to the radius of gyration of its volume: 1.3 for a ball, 1.73 for a cube.
const RADIUS: f64 = 1.8;
/// Room beyond contact from which on a body is free, Å.
const BEYOND_CONTACT_ANGSTROM: f64 = 10.0;
/// Outer end of the range in which a body is free, relative to the inner one.
const FREE_RANGE: f64 = 1.25;
/// Poses that are drawn to see how much of that range other bodies fill.
const DRAWS: usize = 2000;
/// Least share of that range that must be free.
const LEAST_FREE: f64 = 0.5;
/// Energy of a frame beyond the wall of a window, kT: MBAR needs a finite one.
const FORBIDDEN_KT: f64 = 1e6;
/// Blocks of frames; errors come from leaving each of them out.
const BLOCKS: usize = 5;

/// Attaches the last body of a part as [`super::attach`] does, by windows in the place of nested sampling.
///
/// # Errors
/// For settings out of range, and for windows that have nothing in common.
pub(super) fn attach_by_windows(
    arrangement: &Arrangement,
    (number, part): (u32, &PartKind),
    smaller: &PartSamples,
    energies: &dyn BodyEnergies,
    (settings, windows): (&GrowthSettings, &WindowSettings),
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Option<PartSamples>> {
    let new = Attachment::new(arrangement, part, settings.limit_angstrom);
    let without = PartKind {
        bodies: part.bodies[..part.bodies.len() - 1].to_vec(),
        ..part.clone()
    };
    let mut regions = smaller.regions.clone();
    regions.push(new.region.clone());
    let flexible = Flexible::new(&without, &smaller.regions, energies);
    let whole = Flexible::new(part, &regions, energies);
    let free_angstrom = free_angstrom(arrangement, part);
    let ladder = Windows::new(settings.limit_angstrom, free_angstrom, windows.windows);
    let one = |(run_number, before): (usize, &Run)| -> Result<Option<Separated>> {
        let pulled = Pulled {
            part,
            without: &flexible,
            whole: &whole,
            region: &new.region,
            near: near(arrangement, part),
            windows: &ladder,
            before: &before.configurations,
            sweeps: windows.sweeps,
        };
        let stream = |step: u64| {
            let stream = number * MOST_RUNS + run_number as u32;
            CounterRng::for_purpose(settings.seed, stream, step, Purpose::PartWindows)
        };
        let ln_room = ln_room(&pulled, &mut stream(u64::MAX))?;
        let simulated = pulled.simulated(run_number % 2 == 0, &stream, goes_on)?;
        let Some(simulated) = simulated else {
            return Ok(None);
        };
        require_exchanges(&simulated, &ladder)?;
        let weighing = Weighing::new(&simulated.frames, &ladder, &new.region)?;
        let mut rng = stream(u64::MAX - 1);
        let mut configurations = weighing.resampled(rng.uniform());
        whole.relax(&mut configurations, ROUNDS, &mut rng);
        let run = Run {
            ln_partition: before.ln_partition + weighing.ln_ratio() + ln_room,
            variance: before.variance
                + error_without_blocks(&simulated, &ladder, &new.region)?.powi(2),
            configurations,
        };
        Ok(Some(Separated {
            run,
            summary: weighing.summary(simulated.evaluations),
            found: weighing.found(&simulated, &ladder),
        }))
    };
    let runs: Vec<Result<Option<Separated>>> =
        smaller.runs.par_iter().enumerate().map(one).collect();
    let runs: Result<Option<Vec<Separated>>> = runs.into_iter().collect();
    let in_part = |error| match error {
        McError::BadSystem(cause) => {
            McError::BadSystem(format!("the part of bodies {:?}: {cause}", part.bodies))
        }
        error => error,
    };
    Ok(runs.map_err(in_part)?.map(|separated| {
        let windows_found = together(&separated);
        let (runs, summaries): (Vec<Run>, Vec<Summary>) = separated
            .into_iter()
            .map(|one| (one.run, one.summary))
            .unzip();
        let mut attached = attached(&runs, &summaries, settings.limit_angstrom);
        attached.windows = Some(windows_found);
        PartSamples {
            runs,
            regions,
            attached,
        }
    }))
}

/// Result of one run.
struct Separated {
    run: Run,
    summary: Summary,
    found: WindowsFound,
}

/// Windows of all runs.
fn together(runs: &[Separated]) -> WindowsFound {
    let mut all = runs[0].found;
    for Separated { found, .. } in &runs[1..] {
        if found.least_exchanged < all.least_exchanged {
            all.least_exchanged = found.least_exchanged;
            all.least_exchanged_angstrom = found.least_exchanged_angstrom;
        }
        all.round_trips += found.round_trips;
        all.bound_frames += found.bound_frames;
        all.free_frames += found.free_frames;
    }
    all
}

/// Displacements of the last body between which it is beyond contact with all others, Å.
fn free_angstrom(arrangement: &Arrangement, part: &PartKind) -> [f64; 2] {
    let last = &arrangement.bodies[part.bodies[part.bodies.len() - 1]];
    let gyration = |square: f64| square.sqrt();
    let own = gyration(last.square_of_gyration_angstrom2);
    let others = part.bodies[..part.bodies.len() - 1]
        .iter()
        .map(|body| &arrangement.bodies[*body]);
    let farthest = others
        .map(|other| {
            let apart = (other.pose.position - last.pose.position).norm();
            apart + RADIUS * (own + gyration(other.square_of_gyration_angstrom2))
        })
        .fold(0.0, f64::max);
    let shift = farthest + BEYOND_CONTACT_ANGSTROM;
    // A turn alone displaces the points of a body by √(8/3) of its radius of gyration at most.
    let inner = (shift.powi(2) + 8.0 / 3.0 * own.powi(2)).sqrt();
    [inner, FREE_RANGE * inner]
}

/// ln of the volume in which the last body is free, in Å³.
fn ln_room(pulled: &Pulled<'_>, rng: &mut CounterRng) -> Result<f64> {
    let [inner, outer] = pulled.windows.free_angstrom;
    let within = |limit_angstrom| Region {
        limit_angstrom,
        ..pulled.region.clone()
    };
    let (smaller, larger) = (within(inner), within(outer));
    let (mut drawn, mut free) = (0, 0);
    while drawn < DRAWS {
        let place = larger.draw(rng);
        if smaller.holds(&place) {
            continue;
        }
        drawn += 1;
        free += usize::from(pulled.is_free(&place, rng));
    }
    let share = free as f64 / DRAWS as f64;
    if share < LEAST_FREE {
        return Err(McError::BadSystem(format!(
            "{:.0} % of the places {inner:.0} to {outer:.0} Å away, at which a body should be free of its part, overlap \
             others: the bodies are too elongated for windows; use mass action without them",
            100.0 * (1.0 - share)
        )));
    }
    let volume = larger.volume_angstrom3() - smaller.volume_angstrom3();
    Ok((volume * share).ln())
}

/// Refuses windows between which no exchanges lead from the bound part to the free body.
fn require_exchanges(simulated: &Simulated, windows: &Windows) -> Result<()> {
    let narrowest = windows.narrowest_link(&simulated.exchanged);
    if simulated.exchanged[narrowest] > 0.0 {
        return Ok(());
    }
    let [first, second] = windows.links[narrowest].map(|window| windows.name(window));
    Err(McError::BadSystem(format!(
        "the windows at {first} and at {second} have no states in common: none of their exchanges was accepted; give more \
         windows (--windows) or more sweeps (--sweeps)"
    )))
}

/// Standard error of the logarithm of a ratio, from leaving out one block of the frames at a time.
fn error_without_blocks(simulated: &Simulated, windows: &Windows, region: &Region) -> Result<f64> {
    let mut ratios = Vec::with_capacity(BLOCKS);
    for block in 0..BLOCKS {
        let rest = |frames: &Vec<Frame>| {
            let numbered = frames.iter().enumerate();
            let kept = numbered.filter(|(number, _)| number * BLOCKS / frames.len() != block);
            kept.map(|(_, frame)| Frame {
                configuration: None,
                ..frame.clone()
            })
            .collect()
        };
        let frames: Vec<Vec<Frame>> = simulated.frames.iter().map(rest).collect();
        ratios.push(Weighing::new(&frames, windows, region)?.ln_ratio());
    }
    Ok(jackknife_error(&ratios).unwrap_or(f64::INFINITY))
}

/// Frames of all windows with their weights.
struct Weighing<'a> {
    frames: Vec<&'a Frame>,
    mixture: Mixture,
    bound_kt: Vec<f64>,
    free_kt: Vec<f64>,
    limit_angstrom: f64,
}

impl<'a> Weighing<'a> {
    fn new(by_window: &'a [Vec<Frame>], windows: &Windows, region: &Region) -> Result<Self> {
        let counts: Vec<usize> = by_window.iter().map(Vec::len).collect();
        let frames: Vec<&Frame> = by_window.iter().flatten().collect();
        // All windows share the energies of the bodies before the last one.
        let energies = |window: usize| -> Vec<f64> {
            let energy_kt = |frame: &&Frame| {
                let kt = windows.energy_kt(window, frame.displacement_angstrom, frame.meeting_kt);
                kt.min(FORBIDDEN_KT)
            };
            frames.iter().map(energy_kt).collect()
        };
        let energies_kt: Vec<Vec<f64>> = (0..windows.count()).map(energies).collect();
        let mixture = Mixture::solve(&energies_kt, &counts)?;
        let only = |is_in: bool, kt: f64| if is_in { kt } else { f64::INFINITY };
        let limit_angstrom = region.limit_angstrom;
        let bound = |frame: &&Frame| {
            let is_bound = frame.displacement_angstrom < limit_angstrom;
            only(is_bound, frame.meeting_kt)
        };
        let free = |frame: &&Frame| {
            let is_free = frame.displacement_angstrom >= windows.free_angstrom[0];
            only(is_free, 0.0)
        };
        let weighing = Self {
            bound_kt: frames.iter().map(bound).collect(),
            free_kt: frames.iter().map(free).collect(),
            frames,
            mixture,
            limit_angstrom,
        };
        weighing.require_both_ends()?;
        Ok(weighing)
    }

    /// Refuses frames that are all at one end.
    fn require_both_ends(&self) -> Result<()> {
        let has = |ends_kt: &[f64]| ends_kt.iter().any(|kt| kt.is_finite());
        let missing = match (has(&self.bound_kt), has(&self.free_kt)) {
            (true, true) => return Ok(()),
            (false, _) => format!(
                "no window has its last body within {:.1} Å of its place: the other bodies leave no room there, or their well \
                 lies elsewhere. Nested sampling (without --way biased) tells which",
                self.limit_angstrom
            ),
            (true, false) => "no window has its last body far away; give more windows (--windows) or more sweeps (--sweeps)".into(),
        };
        Err(McError::BadSystem(missing))
    }

    /// ln Z_bound/Z_free.
    fn ln_ratio(&self) -> f64 {
        self.mixture.free_energy_kt(&self.free_kt) - self.mixture.free_energy_kt(&self.bound_kt)
    }

    fn mean_bound(&self, value: impl Fn(&Frame) -> f64) -> (f64, f64) {
        let values: Vec<f64> = self.frames.iter().map(|frame| value(frame)).collect();
        let average = self.mixture.average(&self.bound_kt, &values);
        (average.mean, average.effective_frames)
    }

    fn summary(&self, evaluations: u64) -> Summary {
        let near_limit = NEAR_LIMIT * self.limit_angstrom;
        let is_near = |frame: &Frame| f64::from(u8::from(frame.displacement_angstrom > near_limit));
        Summary {
            mean_square_displacement_angstrom2: self
                .mean_bound(|frame| frame.displacement_angstrom.powi(2))
                .0,
            share_at_limit: self.mean_bound(is_near).0,
            evaluations,
        }
    }

    fn found(&self, simulated: &Simulated, windows: &Windows) -> WindowsFound {
        let narrowest = windows.narrowest_link(&simulated.exchanged);
        let ones = vec![1.0; self.frames.len()];
        WindowsFound {
            least_exchanged: simulated.exchanged[narrowest],
            least_exchanged_angstrom: windows.displacement_angstrom(windows.links[narrowest][0]),
            round_trips: simulated.round_trips,
            bound_frames: self.mean_bound(|_| 1.0).1,
            free_frames: self.mixture.average(&self.free_kt, &ones).effective_frames,
        }
    }

    /// Configurations of the bound part in proportion to their weights, by equal steps from a random start.
    fn resampled(&self, start: f64) -> Vec<Configuration> {
        let kept = self.frames.iter().zip(&self.bound_kt);
        let bound_kt: Vec<f64> = kept
            .map(|(frame, kt)| match frame.configuration {
                Some(_) => *kt,
                None => f64::INFINITY,
            })
            .collect();
        let all = self.mixture.free_energy_kt(&bound_kt);
        let (mut samples, mut passed) = (Vec::with_capacity(SAMPLES), 0.0);
        for (frame, ln_weight) in self.frames.iter().zip(self.mixture.ln_weights(&bound_kt)) {
            passed += (ln_weight + all).exp() * SAMPLES as f64;
            while samples.len() as f64 + start < passed && samples.len() < SAMPLES {
                samples.extend(frame.configuration.clone());
            }
        }
        samples
    }
}
