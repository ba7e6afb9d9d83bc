//! What several tests need.

/// Cases of a property: `PROPTEST_CASES` where it is set, for long runs by hand.
pub fn cases(usual: u32) -> u32 {
    std::env::var("PROPTEST_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok())
        .unwrap_or(usual)
}

/// Message of an error.
pub fn message<T, E: ToString>(refused: Result<T, E>) -> String {
    refused.err().unwrap().to_string()
}
