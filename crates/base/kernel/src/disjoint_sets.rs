//! Disjoint sets of numbers, joined pair by pair (Galler and Fisher, Commun. ACM 7, 301 (1964)).
//!
//! A set is a tree whose root is the smallest member. Every search halves its way to the root.

/// Disjoint sets of the numbers below some count.
///
/// ```
/// use protomer_kernel::disjoint_sets::DisjointSets;
/// let mut sets = DisjointSets::new(5);
/// sets.join(3, 1);
/// sets.join(4, 3);
/// assert_eq!(sets.root(4), 1);
/// assert_eq!(sets.into_roots(), [0, 1, 2, 1, 1]);
/// ```
#[derive(Debug, Clone)]
pub struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Sets of one number each.
    ///
    /// ```
    /// use protomer_kernel::disjoint_sets::DisjointSets;
    /// assert_eq!(DisjointSets::new(3).into_roots(), [0, 1, 2], "each number is its own set");
    /// ```
    pub fn new(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
        }
    }

    /// The smallest member of the set of a number.
    ///
    /// ```
    /// use protomer_kernel::disjoint_sets::DisjointSets;
    /// let mut sets = DisjointSets::new(4);
    /// sets.join(3, 2);
    /// assert_eq!((sets.root(3), sets.root(2), sets.root(1)), (2, 2, 1));
    /// ```
    #[inline]
    pub fn root(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            self.parents[number as usize] = self.parents[self.parents[number as usize] as usize];
            number = self.parents[number as usize];
        }
        number
    }

    /// Joins the sets of two numbers.
    ///
    /// ```
    /// use protomer_kernel::disjoint_sets::DisjointSets;
    /// let mut sets = DisjointSets::new(4);
    /// sets.join(0, 1);
    /// sets.join(2, 3);
    /// assert_ne!(sets.root(1), sets.root(3));
    /// sets.join(1, 3);
    /// assert_eq!(sets.root(2), 0, "the sets of both numbers are one");
    /// ```
    #[inline]
    pub fn join(&mut self, first: u32, second: u32) {
        let (a, b) = (self.root(first), self.root(second));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The root of each number.
    ///
    /// ```
    /// use protomer_kernel::disjoint_sets::DisjointSets;
    /// let mut sets = DisjointSets::new(4);
    /// sets.join(2, 3);
    /// let mut roots = sets.into_roots();
    /// roots.dedup();
    /// assert_eq!(roots, [0, 1, 2], "the smallest member of each set");
    /// ```
    pub fn into_roots(mut self) -> Vec<u32> {
        let numbers = 0..self.parents.len() as u32;
        numbers.map(|number| self.root(number)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    #[test]
    fn sets_are_those_of_labels_that_are_replaced_one_by_one() {
        const COUNT: usize = 200;
        let mut rng = CounterRng::new(31, 0, 0);
        let mut sets = DisjointSets::new(COUNT);
        let mut labels: Vec<u32> = (0..COUNT as u32).collect();
        for _ in 0..150 {
            let [first, second] = [rng.index(COUNT), rng.index(COUNT)];
            sets.join(first as u32, second as u32);
            let [old, new] = [labels[first], labels[second]];
            for label in &mut labels {
                if [old, new].contains(label) {
                    *label = old.min(new);
                }
            }
            let place = rng.index(COUNT);
            assert_eq!(sets.root(place as u32), labels[place]);
        }
        assert_eq!(sets.into_roots(), labels);
    }
}
