//! The answer of a sweep: where an assembly falls apart, and whether that is an equilibrium.

use super::half_salt::{FractionAt, HalfSalt, half_salt};
use super::table::ReplicaResult;
use crate::stability::run::{RunSettings, Start};
use protomer_common::page::Verdict;
use protomer_kernel::statistics::Summary;
use serde::{Deserialize, Serialize};

/// Starts agree if the means of each [`Observable`] differ by less than this many standard errors, or
/// by less than matters.
const STANDARD_ERRORS: f64 = 3.0;
/// Smallest difference of fractions of bodies or contacts that matters.
const LEAST_FRACTION: f64 = 0.05;
/// Smallest difference of the size of the largest cluster that matters, bodies.
const LEAST_BODIES: f64 = 0.5;
/// Smallest difference of the energy that matters, kT.
const LEAST_KT: f64 = 1.0;

/// Reason why a run without a box has no half salt.
const OPEN_SPACE: &str = "no equilibrium: the assembly has no box, and bodies that come apart drift away for ever; contacts \
                          are those that lasted as many sweeps, and R_g measures how far the bodies have drifted";

/// Salts at which an assembly falls apart, and whether its runs are equilibrated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// The salt at which half of the contacts of the assembly are left, mol/L; `None` if that is
    /// at no salt of the sweep, or if the runs are not equilibrated.
    pub half_salt_molar: Option<f64>,
    /// Interval of 95 % of `half_salt_molar`, mol/L.
    pub half_salt_interval_molar: Option<[Option<f64>; 2]>,
    /// The salt at which half of the bodies touch another, mol/L.
    pub half_bound_salt_molar: Option<f64>,
    /// Interval of 95 % of `half_bound_salt_molar`, mol/L.
    pub half_bound_salt_interval_molar: Option<[Option<f64>; 2]>,
    /// Contacts that count for the half salt.
    #[serde(default)]
    pub half_salt_contacts: CountedContacts,
    /// Whether runs from the assembly and from the fluid agree; `None` if all start alike.
    pub equilibrated: Option<bool>,
    /// Agreement of the runs, in words.
    #[serde(default = "not_compared")]
    pub equilibration: String,
    /// Number of contacts of the assembly.
    #[serde(skip)]
    native: usize,
    /// The part of the contacts left at the lowest and the highest salt.
    #[serde(skip)]
    contacts_at_ends: Option<[f64; 2]>,
}

/// Contacts that are compared with those of the assembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CountedContacts {
    /// Contacts between the bodies that touch in the assembly.
    #[default]
    Native,
    /// All contacts, by their number: bodies of a kind are alike.
    Any,
}

impl CountedContacts {
    /// The part of `native` contacts of an assembly that a replica has left.
    fn left(self, replica: &ReplicaResult, native: usize) -> Option<Summary> {
        match self {
            CountedContacts::Native => replica.averages.native_contacts,
            CountedContacts::Any => {
                let contacts = replica.averages.contacts;
                contacts.map(|summary| scaled(&summary, native))
            }
        }
    }
}

/// Agreement of the runs in results of earlier versions, in words.
fn not_compared() -> String {
    "an earlier version, which did not compare starts, ran this".into()
}

impl Stability {
    /// Finds the half salts from the replicas at each salt concentration. `native`: contacts of the
    /// assembly; `is_open`: whether it has neither box nor wall.
    pub fn new(
        settings: &RunSettings,
        replicas: &[Vec<ReplicaResult>],
        native: usize,
        is_open: bool,
    ) -> Self {
        let (equilibrated, equilibration) = match is_open {
            // In open space there is no equilibrium, whatever the runs say.
            true => (Some(false), OPEN_SPACE.into()),
            false => equilibration(settings, replicas, native),
        };
        // At equilibrium bodies change places.
        let counted = match settings.exchange_every == 0 && settings.is_from_assembly() {
            true => CountedContacts::Native,
            false => CountedContacts::Any,
        };
        let curve = points(settings, replicas, |replica| counted.left(replica, native));
        let bound = points(settings, replicas, |replica| {
            replica.averages.bound_fraction
        });
        // Of runs that disagree no curve is that of an equilibrium.
        let half = |points: &[FractionAt]| match equilibrated {
            Some(false) => None,
            _ => half_salt(points, settings.seed),
        };
        let (half_contacts, half_bound) = (half(&curve), half(&bound));
        let molar = |half: &Option<HalfSalt>| half.map(|half| half.salt_molar);
        let interval = |half: &Option<HalfSalt>| half.map(|half| half.interval_molar);
        Self {
            half_salt_molar: molar(&half_contacts),
            half_salt_interval_molar: interval(&half_contacts),
            half_bound_salt_molar: molar(&half_bound),
            half_bound_salt_interval_molar: interval(&half_bound),
            half_salt_contacts: counted,
            equilibrated,
            equilibration,
            native,
            contacts_at_ends: ends(&curve),
        }
    }

    /// The part of the contacts of the assembly that a replica has left; `None` if the assembly has
    /// none, or an earlier version did not count them.
    pub(super) fn contacts_left(&self, replica: &ReplicaResult) -> Option<Summary> {
        match self.native {
            0 => None,
            native => self.half_salt_contacts.left(replica, native),
        }
    }

    /// Salt at which half of the contacts are left, in words.
    pub fn headline(&self) -> Option<String> {
        let half = self.half_salt_molar.zip(self.half_salt_interval_molar);
        Some(match (self.equilibrated, half, self.contacts_at_ends?) {
            (Some(false), ..) => "not equilibrated".into(),
            (_, Some((salt, interval)), _) => {
                let salt = with_interval(salt, interval);
                format!("half of the contacts are left at {salt}")
            }
            (_, None, [_, last]) if last >= 0.5 => {
                "more than half of the contacts are left at every salt".into()
            }
            _ => "less than half of the contacts are left at every salt".into(),
        })
    }

    /// The answer in lines.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.equilibrated != Some(false) {
            lines.extend(self.headline());
        }
        let bound = self
            .half_bound_salt_molar
            .zip(self.half_bound_salt_interval_molar);
        if let Some((salt, interval)) = bound {
            lines.push(format!(
                "half of the bodies touch another at {}",
                with_interval(salt, interval)
            ));
        }
        lines
    }

    /// Whether the runs are those of an equilibrium: `yes`, `no` or `unknown`.
    pub fn equilibrium(&self) -> &'static str {
        match self.equilibrated {
            Some(true) => "yes",
            Some(false) => "no",
            None => "unknown",
        }
    }

    /// The verdict on the equilibrium with its reason, in words.
    pub fn verdict(&self) -> String {
        let verdict = Verdict::equilibrated(self.equilibrated, &self.equilibration);
        format!("equilibrium: {} ({})", self.equilibrium(), verdict.reason)
    }
}

fn scaled(summary: &Summary, native: usize) -> Summary {
    let factor = 1.0 / native.max(1) as f64;
    Summary {
        mean: factor * summary.mean,
        standard_deviation: factor * summary.standard_deviation,
        standard_error: factor * summary.standard_error,
        ..*summary
    }
}

/// A half salt with its interval, in words.
pub(crate) fn with_interval(salt_molar: f64, [low, high]: [Option<f64>; 2]) -> String {
    let rounded = |salt: f64| {
        let digits = (2.0 - (1e3 * salt).log10().floor()).max(0.0) as usize;
        format!("{:.digits$}", 1e3 * salt)
    };
    let range = match (low, high) {
        (Some(low), Some(high)) => format!("{} to {} mM", rounded(low), rounded(high)),
        (Some(low), None) => format!("{} mM and more", rounded(low)),
        (None, Some(high)) => format!("up to {} mM", rounded(high)),
        (None, None) => "open".into(),
    };
    format!("{} mM (95 %: {range})", rounded(salt_molar))
}

/// The fractions at the lowest and the highest salt, if there are several.
fn ends(points: &[FractionAt]) -> Option<[f64; 2]> {
    if points.len() < 2 {
        return None;
    }
    let by_salt = |a: &&FractionAt, b: &&FractionAt| a.salt_molar.total_cmp(&b.salt_molar);
    let (first, last) = (
        points.iter().min_by(by_salt)?,
        points.iter().max_by(by_salt)?,
    );
    let are_known = first.fraction.is_finite() && last.fraction.is_finite();
    are_known.then_some([first.fraction, last.fraction])
}

fn points(
    settings: &RunSettings,
    replicas: &[Vec<ReplicaResult>],
    summary: impl Fn(&ReplicaResult) -> Option<Summary>,
) -> Vec<FractionAt> {
    let mut points = Vec::with_capacity(replicas.len());
    for (salt_molar, replicas) in settings.salt_molar.iter().zip(replicas) {
        let summaries: Vec<Summary> = replicas.iter().filter_map(&summary).collect();
        if summaries.is_empty() {
            continue;
        }
        let (fraction, error) = average_fraction(&summaries);
        points.push(FractionAt {
            salt_molar: *salt_molar,
            fraction,
            error,
        });
    }
    points
}

/// Largest standard deviation of a fraction, half of the time 0 and half of the time 1: its error where
/// nothing else is known.
const UNKNOWN_ERROR: f64 = 0.5;

/// The mean of a fraction over replicas, and its error. A replica with fewer than two samples has no error of
/// its own, and counts as unknown.
fn average_fraction(summaries: &[Summary]) -> (f64, f64) {
    let with_error = |summary: &Summary| Summary {
        standard_error: match summary.standard_error.is_finite() {
            true => summary.standard_error,
            false => UNKNOWN_ERROR,
        },
        ..*summary
    };
    let summaries: Vec<Summary> = summaries.iter().map(with_error).collect();
    average(&summaries)
}

/// The mean over replicas, and its error: the larger of that from their spread and that from their
/// own errors.
fn average(summaries: &[Summary]) -> (f64, f64) {
    let number = summaries.len() as f64;
    let mean = summaries.iter().map(|summary| summary.mean).sum::<f64>() / number;
    let deviations = summaries
        .iter()
        .map(|summary| (summary.mean - mean).powi(2));
    // One replica has no spread; its own error is all that is known.
    let spread = match summaries.len() {
        1 => 0.0,
        // Variance of the mean: Σ (x - x̄)² / (n - 1), over n.
        _ => deviations.sum::<f64>() / (number - 1.0) / number,
    };
    let errors = summaries.iter().map(|summary| summary.standard_error);
    let errors = errors.filter(|error| error.is_finite());
    let variance = errors.map(|error| error.powi(2)).sum::<f64>() / number.powi(2);
    // The larger one: replicas that agree by chance, or errors
    // that miss slow changes, do not make the mean look certain.
    (mean, spread.max(variance).sqrt())
}

/// Observable in which runs from both starts must agree.
struct Observable {
    summary: fn(&ReplicaResult) -> Option<Summary>,
    /// Smallest difference that matters.
    least: f64,
    /// Function that states both means in words.
    words: fn(f64, f64) -> String,
}

/// Observables in the order in which a disagreement is named. A bound fraction alone would call a
/// stack and the small groups of a fluid alike.
fn observables(native: usize) -> [Observable; 4] {
    [
        Observable {
            summary: |replica| replica.averages.bound_fraction,
            least: LEAST_FRACTION,
            words: |assembly, fluid| {
                format!(
                    "{assembly:.2} of the bodies touch another in runs from the assembly, and \
                     {fluid:.2} in runs from the fluid"
                )
            },
        },
        Observable {
            summary: |replica| replica.averages.contacts,
            least: LEAST_FRACTION * native.max(1) as f64,
            words: |assembly, fluid| {
                format!(
                    "{assembly:.1} pairs of bodies touch in runs from the assembly, and \
                     {fluid:.1} in runs from the fluid"
                )
            },
        },
        Observable {
            summary: |replica| replica.averages.largest_cluster,
            least: LEAST_BODIES,
            words: |assembly, fluid| {
                format!(
                    "the largest cluster has {assembly:.1} bodies in runs from the assembly, and \
                     {fluid:.1} in runs from the fluid"
                )
            },
        },
        Observable {
            summary: |replica| replica.averages.energy_kt,
            least: LEAST_KT,
            words: |assembly, fluid| {
                format!(
                    "the energy is {assembly:.1} kT in runs from the assembly, and {fluid:.1} kT in \
                     runs from the fluid"
                )
            },
        },
    ]
}

/// Whether both starts lead to the same state at every salt.
fn equilibration(
    settings: &RunSettings,
    replicas: &[Vec<ReplicaResult>],
    native: usize,
) -> (Option<bool>, String) {
    let mut by_start = Vec::with_capacity(replicas.len());
    for (salt_molar, replicas) in settings.salt_molar.iter().zip(replicas) {
        // Compared salt by salt: each has its own equilibrium.
        let starts_there = |replica: &&ReplicaResult| {
            settings.starts.of_replica(replica.replica) == Start::Assembly
        };
        let (assembly, fluid): (Vec<_>, Vec<_>) = replicas.iter().partition(starts_there);
        if !assembly.is_empty() && !fluid.is_empty() {
            by_start.push((*salt_molar, assembly, fluid));
        }
    }
    if by_start.is_empty() {
        // One replica cannot start from both.
        let replicas = match settings.replicas {
            1 => " --replicas 4",
            _ => "",
        };
        let words = format!(
            "whether this is an equilibrium is not known: all runs start alike; --starts both{replicas}, \
             in another directory, begins half of them from a fluid"
        );
        return (None, words);
    }
    // In the order of the observables: the first disagreement is the one that is named.
    for observable in observables(native) {
        let differences = by_start.iter().filter_map(|(salt_molar, assembly, fluid)| {
            let [assembly, fluid] = [assembly, fluid].map(|replicas| {
                let summaries = replicas
                    .iter()
                    .filter_map(|replica| (observable.summary)(replica));
                summaries.collect::<Vec<Summary>>()
            });
            let difference = disagreement(&assembly, &fluid, observable.least)?;
            Some((
                difference,
                *salt_molar,
                average(&assembly).0,
                average(&fluid).0,
            ))
        });
        if let Some((_, salt_molar, assembly, fluid)) =
            // The largest over the salts is named; one suffices.
            differences.max_by(|a, b| a.0.total_cmp(&b.0))
        {
            let words = format!(
                "not equilibrated: at {} mM {}; run longer, or exchange more often \
                 (--exchange-every)",
                1e3 * salt_molar,
                (observable.words)(assembly, fluid)
            );
            return (Some(false), words);
        }
    }
    let words = "runs from the assembly and from the fluid agree at every salt";
    (Some(true), words.into())
}

/// Difference of two means, if it is more than their errors allow and more than `least`.
fn disagreement(assembly: &[Summary], fluid: &[Summary], least: f64) -> Option<f64> {
    if assembly.is_empty() || fluid.is_empty() {
        return None;
    }
    let ((of_assembly, error), (of_fluid, other)) = (average(assembly), average(fluid));
    let difference = (of_assembly - of_fluid).abs();
    // Both conditions: more than chance, and more than matters.
    let allowed = (STANDARD_ERRORS * error.hypot(other)).max(least);
    (difference > allowed).then_some(difference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::run::{AcceptedFractions, Columns, Starts};

    fn replica(replica: u32, [bound, contacts, cluster, energy]: [f64; 4]) -> ReplicaResult {
        let summary = |mean| Summary {
            mean,
            standard_deviation: 0.0,
            standard_error: 0.01,
            autocorrelation_time: 0.5,
            effective_samples: 100.0,
        };
        ReplicaResult {
            replica,
            averages: Columns {
                largest_cluster: Some(summary(cluster)),
                energy_kt: Some(summary(energy)),
                contacts: Some(summary(contacts)),
                bound_fraction: Some(summary(bound)),
                ..Columns::default()
            },
            accepted: AcceptedFractions {
                translation_acceptance: 0.5,
                rotation_acceptance: 0.5,
            },
            effective_bodies: None,
            warnings: Vec::new(),
        }
    }

    /// One sample says little; it must not make a half salt look certain.
    #[test]
    fn one_sample_of_one_replica_is_not_certain() {
        let mut summary = replica(0, [1.0; 4]).averages.bound_fraction.unwrap();
        assert_eq!(average_fraction(&[summary]), (1.0, 0.01));
        summary.standard_error = f64::NAN;
        assert_eq!(average_fraction(&[summary]), (1.0, UNKNOWN_ERROR));
        // Two that agree are no more certain than two unknown ones.
        let (_, error) = average_fraction(&[summary, summary]);
        assert!(
            (error - UNKNOWN_ERROR / 2.0_f64.sqrt()).abs() < 1e-12,
            "{error}"
        );
    }

    /// The verdict of one run from the assembly and one from a fluid.
    fn verdict(assembly: [f64; 4], fluid: [f64; 4]) -> (Option<bool>, String) {
        let settings = RunSettings {
            salt_molar: vec![0.065],
            starts: Starts::Both,
            ..RunSettings::default()
        };
        let replicas = [vec![replica(0, assembly), replica(1, fluid)]];
        equilibration(&settings, &replicas, 16)
    }

    #[test]
    fn starts_must_agree_in_clusters_and_energies_too() {
        let state = [0.95, 14.0, 5.0, -120.0];
        assert_eq!(verdict(state, state).0, Some(true));
        for (place, there, words) in [
            (0, 0.8, "0.80 of the bodies touch another"),
            (1, 20.0, "20.0 pairs of bodies touch"),
            (2, 15.0, "the largest cluster has 15.0 bodies"),
            (3, -146.0, "the energy is -146.0 kT"),
        ] {
            let mut assembly = state;
            assembly[place] = there;
            let (equilibrated, said) = verdict(assembly, state);
            assert_eq!(equilibrated, Some(false));
            assert!(said.contains(words) && said.contains("65 mM"), "{said}");
        }
        let mut nearly = state;
        nearly[3] += 0.9;
        assert_eq!(verdict(nearly, state).0, Some(true));
    }
}
