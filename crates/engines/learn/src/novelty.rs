//! Which samples of another set are new to a network, so that it may be scored on them.

use std::collections::BTreeSet;

/// The samples from which a network was made.
///
/// ```
/// use protomer_learn::novelty::{Familiar, Seen};
///
/// let mut seen = Seen::default();
/// seen.add("3f2a", "lysozymes");
/// assert_eq!(seen.familiar("3f2a", "others"), Some(Familiar::SameFile));
/// assert_eq!(seen.familiar("77b1", "lysozymes"), Some(Familiar::SameCluster));
/// assert_eq!(seen.familiar("77b1", "others"), None);
/// assert_eq!(seen.familiar("", "others"), Some(Familiar::FileUnknown));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Seen {
    files: BTreeSet<String>,
    clusters: BTreeSet<String>,
}

/// Reason why a sample may not be new to a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Familiar {
    /// The file of the sample was among those seen.
    SameFile,
    /// Other samples of its cluster were among those seen.
    SameCluster,
    /// The file that the sample was made from is not known.
    FileUnknown,
}

impl Seen {
    /// Adds a sample by the SHA-256 of its file and the name of its cluster.
    pub fn add(&mut self, file_sha256: &str, cluster: &str) {
        self.files.insert(file_sha256.to_owned());
        self.clusters.insert(cluster.to_owned());
    }

    /// Reason why a sample may not be new; `None` if it is new.
    ///
    /// Clusters are compared by name. Those of another manifest may mean other structures; then a
    /// sample too many is left out, which is the safe side.
    ///
    /// ```
    /// use protomer_learn::novelty::{Familiar, Seen};
    /// let mut seen = Seen::default();
    /// seen.add("0a1b", "lysozymes");
    /// assert_eq!(seen.familiar("0a1b", "others"), Some(Familiar::SameFile));
    /// assert_eq!(seen.familiar("2c3d", "lysozymes"), Some(Familiar::SameCluster));
    /// assert_eq!(seen.familiar("2c3d", "others"), None);
    /// ```
    pub fn familiar(&self, file_sha256: &str, cluster: &str) -> Option<Familiar> {
        if file_sha256.is_empty() {
            Some(Familiar::FileUnknown)
        } else if self.files.contains(file_sha256) {
            Some(Familiar::SameFile)
        } else if self.clusters.contains(cluster) {
            Some(Familiar::SameCluster)
        } else {
            None
        }
    }
}
