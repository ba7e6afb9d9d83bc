//! Up/down arrangements of a ring or a two-ring stack that are different under its symmetry.
//!
//! Bodies are given by a pattern repeated around the ring; the second ring continues it one
//! position on, so that of two alternating bodies each stands above the other. Every body points up
//! or down along the axis. The bodies are chiral, so only proper operations count: rotations about
//! the axis, and half turns about axes in the plane, which turn every body over (and exchange the
//! rings of a stack). Those that map each kind of body onto itself are the stack's own symmetry
//! group.
//!
//! Two reductions, in this order:
//! 1. arrangements that an operation of the group maps onto each other are one; their number
//!    follows also from Burnside's lemma ([`Stack::burnside_count`]);
//! 2. of those that are invariant under the symmetry asked for ([`Symmetry`]), arrangements with
//!    the same multiset of nearest-neighbour contacts are one. Neighbours are next to each other in
//!    a ring or above each other in a stack; a contact is told by the two bodies, their directions,
//!    and which stands clockwise of or above the other.
//!
//! For two rings of eight alternating bodies, 2¹⁶ = 65 536 arrangements and a group D4 of order 8:
//!
//! | asked for | arrangements | different under D4 | different in their contacts |
//! |---|---|---|---|
//! | nothing | 65 536 | 8 356 | 543 |
//! | C4 | 16 | 10 | 10 |
//! | D4 | 4 | 4 | 4 |
//!
//! The four of Ramasubramani's thesis (section 3.2.2), which assumes that oligomers are highly
//! symmetric and counts nearest-neighbour interactions, are the arrangements of full D4 symmetry:
//! the two directions of the lower ring's bodies are free, the upper ring follows, and the four
//! differ in which ends meet between the rings.

use super::recipe::{Recipe, RecipeSite};
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A ring or a stack of two rings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stack {
    /// Bodies per ring.
    pub members: usize,
    /// One or two rings.
    pub rings: usize,
    /// Indices of the bodies, repeated around the ring.
    pub pattern: Vec<usize>,
}

/// The symmetry asked of an arrangement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Symmetry {
    /// None.
    None,
    /// All rotations of the group about the axis.
    Cyclic,
    /// The whole group.
    Dihedral,
}

/// A nearest-neighbour contact, written so that turning the pair over does not change it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Contact {
    /// Whether the two stand above each other rather than side by side.
    pub between_rings: bool,
    /// Body and direction (true: up) of the lower or clockwise-first of the two.
    pub first: (usize, bool),
    /// Body and direction of the other.
    pub second: (usize, bool),
}

/// One arrangement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Arrangement {
    /// Direction of each body (true: up), ring by ring from below.
    pub up: Vec<bool>,
    /// How many arrangements the group maps onto this one, itself included.
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
    /// Arrangements of the symmetry asked for.
    pub symmetric: usize,
    /// Of those, different under the group.
    pub distinct: usize,
    /// Of those, different in their contacts: one arrangement each.
    pub arrangements: Vec<Arrangement>,
}

/// A permutation of positions that perhaps turns every body over.
struct Operation {
    image: Vec<usize>,
    turns_over: bool,
}

impl Operation {
    fn apply(&self, arrangement: u32) -> u32 {
        let moved = self.image.iter().enumerate().fold(0, |moved, (from, to)| {
            moved | ((arrangement >> from & 1) << to)
        });
        if self.turns_over {
            !moved & all_ones(self.image.len())
        } else {
            moved
        }
    }
}

fn all_ones(bits: usize) -> u32 {
    (1_u32 << bits) - 1
}

impl Stack {
    /// The most bodies an enumeration takes.
    pub const MOST_BODIES: usize = 20;

    /// A ring or stack.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a number of rings other than one or two, a pattern that does not
    /// fit the ring a whole number of times, and more than [`Stack::MOST_BODIES`] bodies.
    pub fn new(members: usize, rings: usize, pattern: Vec<usize>) -> Result<Self> {
        let invalid = |cause: String, remedy: &str| {
            Err(BodyError::Invalid {
                cause,
                remedy: remedy.into(),
            })
        };
        if !(1..=2).contains(&rings) || members == 0 {
            return invalid(
                format!("{rings} rings of {members}"),
                "give one or two rings of at least one body",
            );
        }
        if pattern.is_empty() || !members.is_multiple_of(pattern.len()) {
            let cause = format!(
                "{} bodies do not alternate evenly in a ring of {members}",
                pattern.len()
            );
            return invalid(
                cause,
                "choose a ring size that the number of bodies divides",
            );
        }
        if members.saturating_mul(rings) > Self::MOST_BODIES {
            let cause = format!("{rings} rings of {members} have too many arrangements");
            return invalid(cause, "enumerate stacks of at most 20 bodies");
        }
        Ok(Self {
            members,
            rings,
            pattern,
        })
    }

    fn size(&self) -> usize {
        self.members * self.rings
    }

    /// The body at a position of a ring.
    fn body(&self, ring: usize, position: usize) -> usize {
        self.pattern[(position + ring) % self.pattern.len()]
    }

    fn index(&self, ring: usize, position: usize) -> usize {
        ring * self.members + position % self.members
    }

    fn positions(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.rings).flat_map(|ring| (0..self.members).map(move |position| (ring, position)))
    }

    /// The proper operations that map each kind of body onto itself.
    fn group(&self) -> Vec<Operation> {
        let n = self.members;
        let rotations = (0..n)
            .map(|shift| self.operation(false, |ring, position| (ring, (position + shift) % n)));
        let half_turns = (0..n).map(|sum| {
            self.operation(true, |ring, position| {
                (self.rings - 1 - ring, (sum + n - position) % n)
            })
        });
        rotations.chain(half_turns).flatten().collect()
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

    /// The number of arrangements different under the group by Burnside's lemma: the mean number of
    /// arrangements that an operation leaves as they are. One that turns over leaves none if it has
    /// a cycle of odd length, and otherwise 2 per cycle, as the others.
    pub fn burnside_count(&self) -> usize {
        let group = self.group();
        let unchanged = |operation: &Operation| {
            let lengths = cycle_lengths(&operation.image);
            let impossible = operation.turns_over && lengths.iter().any(|length| length % 2 == 1);
            if impossible {
                0
            } else {
                1_usize << lengths.len()
            }
        };
        group.iter().map(unchanged).sum::<usize>() / group.len()
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
        let required = |operation: &&Operation| match symmetry {
            Symmetry::None => false,
            Symmetry::Cyclic => !operation.turns_over,
            Symmetry::Dihedral => true,
        };
        let required: Vec<&Operation> = group.iter().filter(required).collect();
        let total = 1_usize << self.size();
        let (mut symmetric, mut distinct) = (0, 0);
        let mut by_contacts: BTreeMap<Vec<(Contact, usize)>, Arrangement> = BTreeMap::new();
        for arrangement in 0..=all_ones(self.size()) {
            if required
                .iter()
                .any(|operation| operation.apply(arrangement) != arrangement)
            {
                continue;
            }
            symmetric += 1;
            if group
                .iter()
                .any(|operation| operation.apply(arrangement) < arrangement)
            {
                continue;
            }
            distinct += 1;
            let contacts = self.contacts(arrangement);
            if let Entry::Vacant(entry) = by_contacts.entry(contacts.clone().into_iter().collect())
            {
                let fixing = group
                    .iter()
                    .filter(|operation| operation.apply(arrangement) == arrangement)
                    .count();
                let up = (0..self.size())
                    .map(|bit| arrangement >> bit & 1 == 1)
                    .collect();
                entry.insert(Arrangement {
                    up,
                    equivalent: group.len() / fixing,
                    contacts,
                });
            }
        }
        let arrangements = by_contacts.into_values().collect();
        Candidates {
            total,
            group_order: group.len(),
            symmetric,
            distinct,
            arrangements,
        }
    }

    fn contacts(&self, arrangement: u32) -> BTreeMap<Contact, usize> {
        let at = |ring: usize, position: usize| {
            let position = position % self.members;
            (
                self.body(ring, position),
                arrangement >> self.index(ring, position) & 1 == 1,
            )
        };
        let mut contacts = BTreeMap::new();
        for (ring, position) in self.positions() {
            if self.members > 1 {
                let contact = Contact::new(false, at(ring, position), at(ring, position + 1));
                *contacts.entry(contact).or_default() += 1;
            }
            if ring + 1 < self.rings {
                let contact = Contact::new(true, at(ring, position), at(ring + 1, position));
                *contacts.entry(contact).or_default() += 1;
            }
        }
        contacts
    }

    /// The recipe of an arrangement, to be closed to contact.
    pub fn recipe(&self, arrangement: &Arrangement) -> Recipe {
        let site = |ring: usize, position: usize| RecipeSite {
            up: arrangement
                .up
                .get(self.index(ring, position))
                .copied()
                .unwrap_or(true),
            ..RecipeSite::upright(self.body(ring, position))
        };
        let rings = (0..self.rings).map(|ring| {
            (0..self.members)
                .map(|position| site(ring, position))
                .collect()
        });
        Recipe {
            rings: rings.collect(),
            stagger: 0.0,
        }
    }
}

impl Contact {
    /// Turning a pair over exchanges the two and their directions; the smaller of both readings
    /// stands for the contact.
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
    let mut seen = vec![false; image.len()];
    let mut lengths = Vec::new();
    for start in 0..image.len() {
        let (mut current, mut length) = (start, 0);
        while !seen[current] {
            seen[current] = true;
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
