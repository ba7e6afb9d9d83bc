//! The kinds of results.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// A kind of result. In JSON it is a word, such as `"lattice run"`.
///
/// ```
/// use protomer_results::ResultKind;
/// let kind: ResultKind = serde_json::from_str("\"lattice run\"").unwrap();
/// assert_eq!(kind, ResultKind::LatticeRun);
/// assert_eq!(format!("this directory holds {kind}"), "this directory holds a lattice run");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum ResultKind {
    /// Simulations of an assembly at several salt concentrations, or at one.
    Sweep,
    /// One simulation of a sweep.
    Simulation,
    /// The thermodynamics of two bodies over salt and pH.
    Pair,
    /// Two bodies at one salt and pH.
    PairCondition,
    /// A run of many hard convex bodies.
    HardBodies,
    /// Many runs of hard convex bodies.
    HardBodySweep,
    /// The free energy of a crystal of hard bodies.
    FreeEnergy,
    /// A lattice of rigid squares followed through time.
    LatticeRun,
    /// Many lattice runs.
    LatticeSweep,
    /// Elastic constants of a network of rods and hinges.
    ElasticConstants,
    /// The tables of a paper on such networks.
    FrameworkTables,
    /// A trained network.
    Training,
    /// A search for the settings of a training.
    Search,
    /// Structures as sparse voxel grids.
    VoxelSet,
    /// Convex bodies in motion.
    DynamicsRun,
    /// Any other kind, by its word: of a newer version, or of another program.
    Other(Cow<'static, str>),
}

/// Each kind, its word in JSON, and its name in a sentence.
const KINDS: &[(ResultKind, &str, &str)] = &[
    (ResultKind::Sweep, "sweep", "a sweep"),
    (
        ResultKind::Simulation,
        "simulation",
        "one simulation of a sweep",
    ),
    (ResultKind::Pair, "pair", "the thermodynamics of two bodies"),
    (
        ResultKind::PairCondition,
        "pair condition",
        "two bodies at one salt and pH",
    ),
    (
        ResultKind::HardBodies,
        "hard bodies",
        "a run of hard bodies",
    ),
    (
        ResultKind::HardBodySweep,
        "hard bodies sweep",
        "a sweep of hard bodies",
    ),
    (
        ResultKind::FreeEnergy,
        "free energy",
        "the free energy of a crystal",
    ),
    (ResultKind::LatticeRun, "lattice run", "a lattice run"),
    (ResultKind::LatticeSweep, "lattice sweep", "a lattice sweep"),
    (
        ResultKind::ElasticConstants,
        "elastic constants",
        "elastic constants of a network",
    ),
    (
        ResultKind::FrameworkTables,
        "framework tables",
        "the tables of a paper",
    ),
    (ResultKind::Training, "training", "a training run"),
    (ResultKind::Search, "search", "a search for settings"),
    (ResultKind::VoxelSet, "voxel set", "a voxel set"),
    (
        ResultKind::DynamicsRun,
        "dynamics run",
        "a run of contact dynamics",
    ),
];

impl ResultKind {
    /// The word in JSON.
    pub fn word(&self) -> &str {
        match self {
            Self::Other(word) => word,
            known => KINDS
                .iter()
                .find(|(kind, ..)| kind == known)
                .map_or("", |(_, word, _)| word),
        }
    }
}

impl fmt::Display for ResultKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match KINDS.iter().find(|(kind, ..)| kind == self) {
            Some((.., name)) => formatter.write_str(name),
            None => write!(formatter, "results of the kind '{}'", self.word()),
        }
    }
}

impl From<String> for ResultKind {
    fn from(word: String) -> Self {
        match KINDS.iter().find(|(_, known, _)| *known == word) {
            Some((kind, ..)) => kind.clone(),
            None => Self::Other(word.into()),
        }
    }
}

impl From<ResultKind> for String {
    fn from(kind: ResultKind) -> Self {
        kind.word().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_one_word_and_reads_back() {
        for (kind, word, name) in KINDS {
            let json = serde_json::to_string(&kind).unwrap();
            assert_eq!(json, format!("\"{word}\""));
            assert_eq!(serde_json::from_str::<ResultKind>(&json).unwrap(), *kind);
            assert_eq!(kind.to_string(), *name);
        }
        let newer: ResultKind = serde_json::from_str("\"pair free energy\"").unwrap();
        assert_eq!(newer, ResultKind::Other("pair free energy".into()));
        assert_eq!(newer.to_string(), "results of the kind 'pair free energy'");
    }
}
