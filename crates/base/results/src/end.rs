//! How interruptible work ends.

/// End of a piece of work.
///
/// ```
/// use protomer_results::End;
/// let end: End<u32> = End::Finished(3);
/// assert_eq!(end.map(|steps| 2 * steps).finished(), Some(6));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End<T> {
    /// Work that is complete.
    Finished(T),
    /// Work that was stopped on request; the same command continues it.
    Stopped,
}

impl<T> End<T> {
    /// The result, unless the work was stopped.
    ///
    /// ```
    /// use protomer_results::End;
    /// let parts = [End::Finished(1), End::Stopped, End::Finished(3)];
    /// let all: End<Vec<i32>> = parts.into_iter().collect();
    /// assert_eq!(all.finished(), None, "one part was stopped");
    /// ```
    pub fn finished(self) -> Option<T> {
        match self {
            End::Finished(result) => Some(result),
            End::Stopped => None,
        }
    }

    /// Applies a function to the result.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> End<U> {
        match self {
            End::Finished(result) => End::Finished(change(result)),
            End::Stopped => End::Stopped,
        }
    }
}

/// Collects the ends of all parts: finished if every part is.
impl<T> FromIterator<End<T>> for End<Vec<T>> {
    fn from_iter<I: IntoIterator<Item = End<T>>>(parts: I) -> Self {
        let results: Option<Vec<T>> = parts.into_iter().map(End::finished).collect();
        results.map_or(End::Stopped, End::Finished)
    }
}
