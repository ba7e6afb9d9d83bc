//! Names as numbers in the same order.

use std::collections::BTreeMap;

/// The rank of each name among the different ones in order, from zero.
///
/// ```
/// assert_eq!(protomer_learn::split::ranks(["P 1", "C 2", "P 1"]), [1, 0, 1]);
/// ```
pub fn ranks<T: Ord>(names: impl IntoIterator<Item = T>) -> Vec<u32> {
    let mut ranks = Ranks::default();
    for name in names {
        ranks.push(name);
    }
    ranks.finish()
}

/// [`ranks`] of names that come one by one. Of equal names one is kept.
///
/// ```
/// use protomer_learn::split::Ranks;
/// let mut ranks = Ranks::default();
/// for name in ["b", "a", "b"] {
///     ranks.push(name);
/// }
/// assert_eq!(ranks.finish(), [1, 0, 1]);
/// ```
#[derive(Debug, Clone)]
pub struct Ranks<T> {
    /// The different names, numbered as they came.
    numbers: BTreeMap<T, u32>,
    /// The number of each name.
    names: Vec<u32>,
}

impl<T> Default for Ranks<T> {
    fn default() -> Self {
        Self {
            numbers: BTreeMap::new(),
            names: Vec::new(),
        }
    }
}

impl<T: Ord> Ranks<T> {
    /// Adds a name.
    pub fn push(&mut self, name: T) {
        let next = self.numbers.len() as u32;
        let number = *self.numbers.entry(name).or_insert(next);
        self.names.push(number);
    }

    /// The rank of each name.
    pub fn finish(self) -> Vec<u32> {
        let mut ranks = vec![0; self.numbers.len()];
        for (rank, number) in (0..).zip(self.numbers.into_values()) {
            ranks[number as usize] = rank;
        }
        let mut names = self.names;
        for name in &mut names {
            *name = ranks[*name as usize];
        }
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The twin: the place of each name in the sorted list of all.
    #[test]
    fn ranks_are_places_in_the_sorted_list() {
        for length in 0..40 {
            let names: Vec<String> = (0..length).map(|n| format!("{}", n * n % 17)).collect();
            let mut sorted = names.clone();
            sorted.sort();
            sorted.dedup();
            let places = names
                .iter()
                .map(|name| sorted.binary_search(name).unwrap() as u32);
            assert_eq!(ranks(&names), places.collect::<Vec<u32>>());
        }
    }
}
