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
    /// The equilibrium of an assembly and its parts over salt and pH.
    Equilibrium,
    /// An assembly and its parts at one salt and pH.
    EquilibriumCondition,
    /// Scores of many complexes.
    Scores,
    /// The pKa values and the titration curve of a structure.
    Titration,
    /// A run of many hard convex bodies.
    HardBodies,
    /// Many runs of hard convex bodies.
    HardBodySweep,
    /// The free energy of a crystal of hard bodies.
    FreeEnergy,
    /// One strength of the springs of a free energy.
    FreeEnergyStrength,
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

/// Words for a kind of result.
struct Words {
    kind: ResultKind,
    /// Word in JSON.
    word: &'static str,
    /// Name in a sentence.
    name: &'static str,
    /// Verbs whose directory holds this kind; none for parts of other results.
    verbs: &'static [&'static str],
}

const fn words(
    kind: ResultKind,
    word: &'static str,
    name: &'static str,
    verbs: &'static [&'static str],
) -> Words {
    Words {
        kind,
        word,
        name,
        verbs,
    }
}

const KINDS: &[Words] = &[
    words(
        ResultKind::Sweep,
        "sweep",
        "a sweep",
        &["simulate", "sweep"],
    ),
    words(
        ResultKind::Simulation,
        "simulation",
        "one simulation of a sweep",
        &[],
    ),
    words(
        ResultKind::Pair,
        "pair",
        "the thermodynamics of two bodies",
        &["pair"],
    ),
    words(
        ResultKind::PairCondition,
        "pair condition",
        "two bodies at one salt and pH",
        &[],
    ),
    words(
        ResultKind::Equilibrium,
        "equilibrium",
        "the equilibrium of an assembly",
        &["stability"],
    ),
    words(
        ResultKind::EquilibriumCondition,
        "equilibrium condition",
        "an assembly at one salt and pH",
        &[],
    ),
    words(
        ResultKind::Scores,
        "scores",
        "scores of complexes",
        &["score"],
    ),
    words(
        ResultKind::Titration,
        "titration",
        "a titration",
        &["titrate"],
    ),
    words(
        ResultKind::HardBodies,
        "hard bodies",
        "a run of hard bodies",
        &["hpmc run"],
    ),
    words(
        ResultKind::HardBodySweep,
        "hard bodies sweep",
        "a sweep of hard bodies",
        &["hpmc sweep"],
    ),
    words(
        ResultKind::FreeEnergy,
        "free energy",
        "the free energy of a crystal",
        &["free-energy"],
    ),
    words(
        ResultKind::FreeEnergyStrength,
        "free energy strength",
        "one strength of a free energy",
        &[],
    ),
    words(
        ResultKind::DynamicsRun,
        "dynamics run",
        "a run of contact dynamics",
        &["md run"],
    ),
    words(
        ResultKind::LatticeRun,
        "lattice run",
        "a lattice run",
        &["lattice run"],
    ),
    words(
        ResultKind::LatticeSweep,
        "lattice sweep",
        "a lattice sweep",
        &["lattice sweep"],
    ),
    words(
        ResultKind::ElasticConstants,
        "elastic constants",
        "elastic constants of a network",
        &["framework"],
    ),
    words(
        ResultKind::FrameworkTables,
        "framework tables",
        "the tables of a paper",
        &["framework tables"],
    ),
    words(
        ResultKind::Training,
        "training",
        "a training run",
        &["train"],
    ),
    words(
        ResultKind::Search,
        "search",
        "a search for settings",
        &["tune"],
    ),
    words(
        ResultKind::VoxelSet,
        "voxel set",
        "a voxel set",
        &["voxelize", "merge"],
    ),
];

impl ResultKind {
    /// Every kind but [`ResultKind::Other`].
    pub fn all() -> impl Iterator<Item = &'static Self> {
        KINDS.iter().map(|words| &words.kind)
    }

    /// The word in JSON.
    ///
    /// ```
    /// use protomer_results::ResultKind;
    /// assert_eq!(ResultKind::HardBodies.word(), "hard bodies");
    /// assert_eq!(ResultKind::Other("walk".into()).word(), "walk");
    /// ```
    pub fn word(&self) -> &str {
        match (self, self.words()) {
            (Self::Other(word), _) => word,
            (_, words) => words.map_or("", |words| words.word),
        }
    }

    /// The verbs whose directory holds this kind; none for parts of other results, and for kinds
    /// that this version does not have.
    ///
    /// ```
    /// use protomer_results::ResultKind;
    /// assert_eq!(ResultKind::VoxelSet.verbs(), ["voxelize", "merge"]);
    /// assert!(ResultKind::Simulation.verbs().is_empty());
    /// ```
    pub fn verbs(&self) -> &'static [&'static str] {
        self.words().map_or(&[], |words| words.verbs)
    }

    fn words(&self) -> Option<&'static Words> {
        KINDS.iter().find(|words| words.kind == *self)
    }
}

impl fmt::Display for ResultKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.words() {
            Some(words) => formatter.write_str(words.name),
            None => write!(formatter, "results of the kind '{}'", self.word()),
        }
    }
}

impl From<String> for ResultKind {
    fn from(word: String) -> Self {
        match KINDS.iter().find(|words| words.word == word) {
            Some(words) => words.kind.clone(),
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
        for Words {
            kind, word, name, ..
        } in KINDS
        {
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
