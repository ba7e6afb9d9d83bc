//! Up/down arrangements of a ring or a two-ring stack that are different under its symmetry.
//!
//! A pattern of bodies repeats around the ring. The second ring continues the pattern, shifted by
//! one position: where two bodies alternate, each is above one of the other kind. Every body points
//! up or down along the axis. The bodies are chiral, so only proper operations count: rotations
//! about the axis, and half turns about axes in the plane, which turn every body over (and exchange
//! the rings of a stack). The operations that map each kind of body onto itself form the symmetry
//! group of the stack.
//!
//! Two reductions, in this order:
//! 1. Arrangements that an operation of the group maps onto each other count as one. Burnside's
//!    lemma gives their number independently ([`Stack::burnside_count`]).
//! 2. Among those with the requested symmetry ([`Symmetry`]), arrangements with the same multiset
//!    of nearest-neighbour contacts count as one. Neighbours are next to each other in a ring or
//!    above each other in a stack. A contact is defined by the two bodies, their directions, and
//!    which of them is clockwise of or above the other.
//!
//! For two rings of eight alternating bodies, 2¹⁶ = 65 536 arrangements and a group D4 of order 8:
//!
//! | requested symmetry | arrangements | different under D4 | different in their contacts |
//! |---|---|---|---|
//! | none | 65 536 | 8 356 | 543 |
//! | C4 | 16 | 10 | 10 |
//! | D4 | 4 | 4 | 4 |
//!
//! Ramasubramani's thesis (section 3.2.2) assumes that oligomers are highly symmetric, counts
//! nearest-neighbour interactions, and finds four candidates. They are the arrangements with full
//! D4 symmetry: the directions of the two bodies in the lower ring are free, the upper ring
//! follows, and the four differ in which ends meet between the rings.

use super::recipe::{Recipe, RecipeSite};
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A ring or a stack of two rings.
///
/// ```
/// use protomer_body::assembly::Stack;
/// // Two bodies alternate in rings of eight; in a ring of seven they cannot.
/// assert!(Stack::new(8, 2, vec![0, 1]).is_ok());
/// assert!(Stack::new(7, 2, vec![0, 1]).is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stack {
    /// Bodies per ring.
    pub members: usize,
    /// One or two rings.
    pub rings: usize,
    /// Indices of the bodies, repeated around the ring.
    pub pattern: Vec<usize>,
}

protomer_kernel::choices! {
    /// Symmetry required of an arrangement.
    pub enum Symmetry {
        /// No symmetry: every arrangement with distinct contacts.
        None = "none",
        /// All rotations about the axis.
        Cyclic = "cyclic",
        /// The full group, including half turns.
        Dihedral = "dihedral",
    }
}

/// A nearest-neighbour contact, written so that turning the pair over does not change it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Contact {
    /// Whether one body is above the other rather than next to it.
    pub between_rings: bool,
    /// Body and direction (true: up) of the lower or clockwise-first of the two.
    pub first: (usize, bool),
    /// Body and direction of the other one.
    pub second: (usize, bool),
}

/// One arrangement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Arrangement {
    /// Direction of each body (true: up), ring by ring from below.
    pub up: Vec<bool>,
    /// Number of arrangements that the group maps onto this one, itself included.
    pub equivalent: usize,
    /// The contacts and how often each occurs.
    #[serde(skip)]
    pub contacts: BTreeMap<Contact, usize>,
}

/// The outcome of an enumeration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidates {
    /// All arrangements, 2^bodies.
    pub total: usize,
    /// Order of the symmetry group.
    pub group_order: usize,
    /// Arrangements with the requested symmetry.
    pub symmetric: usize,
    /// Number of symmetric arrangements that differ under the group.
    pub distinct: usize,
    /// One arrangement for each different set of contacts.
    pub arrangements: Vec<Arrangement>,
}

/// A permutation of positions that may also turn every body over.
struct Operation {
    image: Vec<usize>,
    turns_over: bool,
}

impl Operation {
    /// The arrangement after the operation; bit k of an arrangement says whether body k is up.
    fn apply(&self, arrangement: u32) -> u32 {
        let mut permuted = 0;
        for (from, to) in self.image.iter().enumerate() {
            permuted |= (arrangement >> from & 1) << to;
        }
        if self.turns_over {
            // Only the bits of bodies: `!` turns the others on, too.
            !permuted & all_ones(self.image.len())
        } else {
            permuted
        }
    }

    fn leaves(&self, arrangement: u32) -> bool {
        self.apply(arrangement) == arrangement
    }
}

fn all_ones(bits: usize) -> u32 {
    (1_u32 << bits) - 1
}

impl Stack {
    /// The largest number of bodies an enumeration accepts.
    pub const MOST_BODIES: usize = 20;

    /// A ring or stack.
    ///
    /// ```
    /// use protomer_body::assembly::Stack;
    /// assert!(Stack::new(8, 2, vec![0, 1]).is_ok());
    /// assert!(Stack::new(7, 2, vec![0, 1]).is_err(), "two bodies do not alternate around seven");
    /// ```
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a number of rings other than one or two, a pattern that does not
    /// fit the ring a whole number of times, and more than [`Stack::MOST_BODIES`] bodies.
    pub fn new(members: usize, rings: usize, pattern: Vec<usize>) -> Result<Self> {
        let bodies = pattern.len();
        let (cause, remedy) = if !(1..=2).contains(&rings) || members == 0 {
            (
                format!("{rings} rings of {members}"),
                "give one or two rings of at least one body",
            )
        } else if pattern.is_empty() || !members.is_multiple_of(bodies) {
            (
                format!("{bodies} bodies do not alternate evenly in a ring of {members}"),
                "choose a ring size that the number of bodies divides",
            )
        } else if members.saturating_mul(rings) > Self::MOST_BODIES {
            (
                format!("{rings} rings of {members} have too many arrangements"),
                "enumerate stacks of at most 20 bodies",
            )
        } else {
            return Ok(Self {
                members,
                rings,
                pattern,
            });
        };
        Err(BodyError::Invalid {
            cause,
            remedy: remedy.into(),
        })
    }

    fn size(&self) -> usize {
        self.members * self.rings
    }

    /// The body at a position of a ring.
    fn body(&self, ring: usize, position: usize) -> usize {
        // The second ring is shifted by one.
        self.pattern[(position + ring) % self.pattern.len()]
    }

    fn index(&self, ring: usize, position: usize) -> usize {
        ring * self.members + position % self.members
    }

    /// Ring and position of every body, in the order of their indices.
    fn positions(&self) -> Vec<(usize, usize)> {
        let mut positions = Vec::with_capacity(self.size());
        for ring in 0..self.rings {
            for position in 0..self.members {
                positions.push((ring, position));
            }
        }
        positions
    }

    /// The proper operations that map each kind of body onto itself.
    fn group(&self) -> Vec<Operation> {
        let n = self.members;
        let mut group = Vec::new();
        for shift in 0..n {
            group.extend(self.operation(false, |ring, position| (ring, (position + shift) % n)));
        }
        // A half turn about an axis in the plane: position
        // p goes to sum - p, and the rings change places.
        for sum in 0..n {
            group.extend(self.operation(true, |ring, position| {
                (self.rings - 1 - ring, (sum + n - position) % n)
            }));
        }
        group
    }

    /// The operation, if it keeps the kinds of bodies.
    fn operation(
        &self,
        turns_over: bool,
        map: impl Fn(usize, usize) -> (usize, usize),
    ) -> Option<Operation> {
        let mut image = Vec::with_capacity(self.size());
        for (ring, position) in self.positions() {
            let (to_ring, to_position) = map(ring, position);
            if self.body(ring, position) != self.body(to_ring, to_position) {
                return None;
            }
            image.push(self.index(to_ring, to_position));
        }
        Some(Operation { image, turns_over })
    }

    /// The number of arrangements that differ under the group by Burnside's lemma: the mean number
    /// of arrangements that an operation leaves unchanged. An operation has one free direction for
    /// each of its cycles, so it leaves 2^cycles unchanged; but one that turns bodies over and has
    /// a cycle of odd length leaves none.
    ///
    /// ```
    /// use protomer_body::assembly::{Stack, Symmetry};
    /// let ring = Stack::new(6, 1, vec![0])?;
    /// assert_eq!(ring.burnside_count(), ring.candidates(Symmetry::None).distinct);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn burnside_count(&self) -> usize {
        let group = self.group();
        let mut unchanged = 0;
        for operation in &group {
            let lengths = cycle_lengths(&operation.image);
            let has_odd_cycle = lengths.iter().any(|length| length % 2 == 1);
            // Turned over, a cycle of odd length would have to be up and down at once.
            if !(operation.turns_over && has_odd_cycle) {
                unchanged += 1_usize << lengths.len();
            }
        }
        unchanged / group.len()
    }

    /// Enumerates the arrangements and reduces them.
    ///
    /// ```
    /// use protomer_body::assembly::{Stack, Symmetry};
    /// let stack = Stack::new(8, 2, vec![0, 1])?;
    /// assert_eq!(stack.candidates(Symmetry::Dihedral).arrangements.len(), 4);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn candidates(&self, symmetry: Symmetry) -> Candidates {
        let group = self.group();
        let (mut symmetric, mut distinct) = (0, 0);
        let mut by_contacts: BTreeMap<Vec<(Contact, usize)>, Arrangement> = BTreeMap::new();
        for arrangement in 0..=all_ones(self.size()) {
            if !has_symmetry(&group, symmetry, arrangement) {
                continue;
            }
            symmetric += 1;
            // The smallest of the equivalent arrangements represents them.
            if group
                .iter()
                .any(|other| other.apply(arrangement) < arrangement)
            {
                continue;
            }
            distinct += 1;
            let contacts = self.contacts(arrangement);
            let key = contacts.clone().into_iter().collect();
            if let Entry::Vacant(entry) = by_contacts.entry(key) {
                entry.insert(self.arrangement(&group, arrangement, contacts));
            }
        }
        Candidates {
            total: 1 << self.size(),
            group_order: group.len(),
            symmetric,
            distinct,
            arrangements: by_contacts.into_values().collect(),
        }
    }

    fn arrangement(
        &self,
        group: &[Operation],
        arrangement: u32,
        contacts: BTreeMap<Contact, usize>,
    ) -> Arrangement {
        let mut fixing = 0;
        for operation in group {
            fixing += usize::from(operation.leaves(arrangement));
        }
        let mut up = Vec::with_capacity(self.size());
        for body in 0..self.size() {
            up.push(is_up(arrangement, body));
        }
        Arrangement {
            up,
            // Orbit and stabiliser: their product is the order of the group.
            equivalent: group.len() / fixing,
            contacts,
        }
    }

    fn contacts(&self, arrangement: u32) -> BTreeMap<Contact, usize> {
        let member = |ring: usize, position: usize| {
            let body = self.body(ring, position % self.members);
            (body, is_up(arrangement, self.index(ring, position)))
        };
        let mut contacts = BTreeMap::new();
        for (ring, position) in self.positions() {
            let first = member(ring, position);
            // A ring of one has no neighbour; a ring of two has its one neighbour on both sides.
            if self.members > 1 {
                let contact = Contact::new(false, first, member(ring, position + 1));
                *contacts.entry(contact).or_default() += 1;
            }
            if ring + 1 < self.rings {
                let contact = Contact::new(true, first, member(ring + 1, position));
                *contacts.entry(contact).or_default() += 1;
            }
        }
        contacts
    }

    /// The recipe of an arrangement. Close it to contact to obtain poses.
    ///
    /// ```
    /// use protomer_body::assembly::{Stack, Symmetry};
    /// let stack = Stack::new(4, 2, vec![0])?;
    /// let candidates = stack.candidates(Symmetry::Dihedral);
    /// let recipe = stack.recipe(&candidates.arrangements[0]);
    /// assert_eq!((recipe.rings.len(), recipe.rings[0].len()), (2, 4));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn recipe(&self, arrangement: &Arrangement) -> Recipe {
        let mut rings = vec![Vec::new(); self.rings];
        for (ring, position) in self.positions() {
            let direction = arrangement.up.get(self.index(ring, position));
            rings[ring].push(RecipeSite {
                up: direction.copied().unwrap_or(true),
                ..RecipeSite::upright(self.body(ring, position))
            });
        }
        Recipe {
            rings,
            stagger: 0.0,
            opening_angstrom: 0.0,
        }
    }
}

fn is_up(arrangement: u32, body: usize) -> bool {
    arrangement >> body & 1 == 1
}

/// Whether the arrangement is invariant under the operations that the symmetry requires.
fn has_symmetry(group: &[Operation], symmetry: Symmetry, arrangement: u32) -> bool {
    group.iter().all(|operation| {
        let is_required = match symmetry {
            Symmetry::None => false,
            Symmetry::Cyclic => !operation.turns_over,
            Symmetry::Dihedral => true,
        };
        !is_required || operation.leaves(arrangement)
    })
}

impl Contact {
    /// Turning a pair over exchanges the two bodies and inverts their directions. The smaller of
    /// the two descriptions represents the contact.
    fn new(between_rings: bool, first: (usize, bool), second: (usize, bool)) -> Self {
        let contact = Self {
            between_rings,
            first,
            second,
        };
        let turned_over = Self {
            between_rings,
            first: (second.0, !second.1),
            second: (first.0, !first.1),
        };
        contact.min(turned_over)
    }
}

fn cycle_lengths(image: &[usize]) -> Vec<usize> {
    let mut visited = vec![false; image.len()];
    let mut lengths = Vec::new();
    for start in 0..image.len() {
        let (mut current, mut length) = (start, 0);
        while !visited[current] {
            visited[current] = true;
            current = image[current];
            length += 1;
        }
        if length > 0 {
            lengths.push(length);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(stack: &Stack, symmetry: Symmetry) -> (usize, usize, usize) {
        let candidates = stack.candidates(symmetry);
        (
            candidates.symmetric,
            candidates.distinct,
            candidates.arrangements.len(),
        )
    }

    #[test]
    fn the_numbers_of_the_two_ring_stack_of_alternating_bodies() {
        let stack = Stack::new(8, 2, vec![0, 1]).unwrap();
        let all = stack.candidates(Symmetry::None);
        assert_eq!((all.total, all.group_order), (65_536, 8));
        // (2^16 + 2·2^4 + 2^8 + 4·2^8) / 8: identity, quarter turns, half turn about the axis, half
        // turns in the plane.
        assert_eq!(
            stack.burnside_count(),
            (65_536 + 2 * 16 + 256 + 4 * 256) / 8
        );
        assert_eq!(counts(&stack, Symmetry::None), (65_536, 8_356, 543));
        assert_eq!(counts(&stack, Symmetry::Cyclic), (16, 10, 10));
        assert_eq!(counts(&stack, Symmetry::Dihedral), (4, 4, 4));
    }

    #[test]
    fn enumeration_and_burnside_agree() {
        for (members, rings, bodies) in [
            (1, 1, 1),
            (1, 2, 1),
            (2, 1, 2),
            (3, 2, 1),
            (4, 2, 2),
            (6, 1, 3),
            (6, 2, 3),
            (7, 1, 1),
        ] {
            let stack = Stack::new(members, rings, (0..bodies).collect()).unwrap();
            assert_eq!(
                stack.candidates(Symmetry::None).distinct,
                stack.burnside_count(),
                "{stack:?}"
            );
        }
    }

    #[test]
    fn operations_leave_the_contacts_as_they_are() {
        let stack = Stack::new(6, 2, vec![0, 1]).unwrap();
        for operation in stack.group() {
            for arrangement in (0..4096).step_by(37) {
                assert_eq!(
                    stack.contacts(arrangement),
                    stack.contacts(operation.apply(arrangement))
                );
            }
        }
    }

    #[test]
    fn a_dihedral_arrangement_has_the_dihedral_recipe() {
        let stack = Stack::new(8, 2, vec![0, 1]).unwrap();
        for arrangement in stack.candidates(Symmetry::Dihedral).arrangements {
            let recipe = stack.recipe(&arrangement);
            assert_eq!(recipe, Recipe::dihedral(8, &recipe.rings[0][..2]));
            assert_eq!(arrangement.equivalent, 1);
        }
    }

    #[test]
    fn what_does_not_alternate_is_refused() {
        assert!(Stack::new(8, 3, vec![0]).is_err());
        assert!(Stack::new(8, 2, vec![0, 1, 2]).is_err());
        assert!(Stack::new(0, 1, vec![0]).is_err());
        assert!(Stack::new(usize::MAX, 2, vec![0]).is_err());
        assert!(Stack::new(8, 1, vec![]).is_err());
    }
}
