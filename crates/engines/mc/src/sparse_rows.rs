//! Sparse storage for values of pairs of bodies, with a few partners per body.

/// A sparse table: each row holds a value for some columns, ascending.
#[derive(Debug, Clone)]
pub(crate) struct SparseRows<T> {
    rows: Vec<Vec<(u32, T)>>,
}

impl<T: Clone> SparseRows<T> {
    pub(crate) fn new(rows: usize) -> Self {
        Self {
            rows: vec![Vec::new(); rows],
        }
    }

    pub(crate) fn get(&self, row: usize, column: usize) -> Option<T> {
        let row = &self.rows[row];
        row.binary_search_by_key(&(column as u32), |entry| entry.0)
            .ok()
            .map(|place| row[place].1.clone())
    }

    pub(crate) fn set(&mut self, row: usize, column: usize, value: T) {
        let row = &mut self.rows[row];
        match row.binary_search_by_key(&(column as u32), |entry| entry.0) {
            Ok(place) => row[place].1 = value,
            Err(place) => row.insert(place, (column as u32, value)),
        }
    }

    pub(crate) fn remove(&mut self, row: usize, column: usize) {
        let row = &mut self.rows[row];
        if let Ok(place) = row.binary_search_by_key(&(column as u32), |entry| entry.0) {
            row.remove(place);
        }
    }

    pub(crate) fn row(&self, row: usize) -> impl Iterator<Item = (usize, &T)> + Clone {
        let entries = self.rows[row].iter();
        entries.map(|(column, value)| (*column as usize, value))
    }
}

/// Values of unordered pairs, kept in both rows so that a body finds its partners at once.
#[derive(Debug, Clone)]
pub(crate) struct PairTable<T>(SparseRows<T>);

impl<T: Clone> PairTable<T> {
    pub(crate) fn new(bodies: usize) -> Self {
        Self(SparseRows::new(bodies))
    }

    pub(crate) fn get(&self, first: usize, second: usize) -> Option<T> {
        self.0.get(first, second)
    }

    pub(crate) fn set(&mut self, first: usize, second: usize, value: T) {
        self.0.set(first, second, value.clone());
        self.0.set(second, first, value);
    }

    pub(crate) fn remove(&mut self, first: usize, second: usize) {
        self.0.remove(first, second);
        self.0.remove(second, first);
    }

    /// Takes over the move of `bodies` (ascending) as one: pairs between them and the rest take the
    /// proposed values, or are removed if none is proposed; all other pairs are unchanged.
    pub(crate) fn take_over(
        &mut self,
        bodies: &[usize],
        proposed: impl Iterator<Item = (usize, usize, T)>,
    ) {
        let has_moved = |body: usize| bodies.binary_search(&body).is_ok();
        let mut stay = Vec::new();
        for (first, second, value) in proposed {
            if has_moved(first) != has_moved(second) {
                self.set(first, second, value);
                stay.push((first, second));
            }
        }
        stay.sort_unstable();
        let is_left = |pair: (usize, usize)| stay.binary_search(&pair).is_err();
        for &body in bodies {
            let partners = self.row(body).map(|entry| entry.0);
            let stale_partners: Vec<usize> = partners
                .filter(|partner| !has_moved(*partner))
                .filter(|partner| is_left((body.min(*partner), body.max(*partner))))
                .collect();
            for partner in stale_partners {
                self.remove(body, partner);
            }
        }
    }

    /// The partners of a body, ascending, with their values.
    pub(crate) fn row(&self, body: usize) -> impl Iterator<Item = (usize, &T)> + Clone {
        self.0.row(body)
    }

    /// Every pair once, ascending.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        (0..self.0.rows.len()).flat_map(move |first| {
            self.row(first)
                .filter(move |(second, _)| first < *second)
                .map(move |(second, value)| (first, second, value.clone()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_come_back_in_order_whatever_the_history() {
        let mut table = PairTable::new(4);
        for (i, j) in [(3, 1), (0, 2), (2, 1), (0, 1)] {
            table.set(i, j, 10 * i.min(j) + i.max(j));
        }
        table.remove(1, 2);
        table.set(1, 0, 7);
        assert_eq!(
            table.pairs().collect::<Vec<_>>(),
            [(0, 1, 7), (0, 2, 2), (1, 3, 13)]
        );
        assert_eq!(table.row(1).map(|(j, _)| j).collect::<Vec<_>>(), [0, 3]);
        assert_eq!((table.get(2, 0), table.get(1, 2)), (Some(2), None));
    }

    #[test]
    fn pairs_of_bodies_that_moved_together_stay() {
        let mut table = PairTable::new(4);
        for (i, j) in [(0, 1), (0, 2), (1, 3), (2, 3)] {
            table.set(i, j, 0);
        }
        table.take_over(&[0, 1], [(0, 1, 9), (1, 2, 5), (2, 3, 9)].into_iter());
        assert_eq!(
            table.pairs().collect::<Vec<_>>(),
            [(0, 1, 0), (1, 2, 5), (2, 3, 0)]
        );
    }
}
