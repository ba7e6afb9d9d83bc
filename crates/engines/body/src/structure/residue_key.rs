//! What identifies a residue.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Chain, number and insertion code of a residue. Written `A:45`, or `A:45B` with insertion code B.
///
/// ```
/// use protomer_body::structure::ResidueKey;
/// let key = ResidueKey { chain: "A".into(), number: 45, insertion_code: "B".into() };
/// assert_eq!(key.to_string(), "A:45B");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ResidueKey {
    /// Chain identifier (author's).
    pub chain: Arc<str>,
    /// Residue number (author's).
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: Arc<str>,
}

impl fmt::Display for ResidueKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}{}", self.chain, self.number, self.insertion_code)
    }
}
