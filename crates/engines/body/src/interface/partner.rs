//! A body at its place in a complex.

use crate::{Body, Site};
use protomer_kernel::cells::CellList;
use protomer_kernel::{Boundary, Vec3};

/// A body at its place in a complex, with the orientation of its file.
#[derive(Debug, Clone, Copy)]
pub struct Partner<'a> {
    /// The body.
    pub body: &'a Body,
    /// Origin of the body's frame, Å.
    pub origin_angstrom: Vec3,
}

/// An atom at its place in a complex.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedAtom<'a> {
    pub site: &'a Site,
    pub position: Vec3,
}

/// Atoms sorted by place.
pub(super) struct Neighbourhood {
    positions: Vec<Vec3>,
    cells: CellList,
    range_angstrom: f64,
}

impl<'a> Partner<'a> {
    /// A body at its place in the structure file that it was made from.
    pub fn in_file(body: &'a Body) -> Self {
        Self {
            body,
            origin_angstrom: body.provenance.origin_angstrom,
        }
    }

    /// Atoms that have a radius, hydrogens left out.
    pub(super) fn heavy_atoms(&self) -> Vec<PlacedAtom<'a>> {
        self.atoms()
            .filter(|atom| !atom.site.is_hydrogen())
            .collect()
    }

    /// Atoms that have a radius.
    pub(super) fn atoms(&self) -> impl Iterator<Item = PlacedAtom<'a>> {
        let origin = self.origin_angstrom;
        let sites = self.body.sites.iter();
        sites
            .filter(|site| site.radius_angstrom > 0.0)
            .map(move |site| PlacedAtom {
                site,
                position: site.position + origin,
            })
    }
}

impl Neighbourhood {
    /// Sorts positions for searches within a range.
    pub fn new(positions: Vec<Vec3>, range_angstrom: f64) -> Self {
        Self {
            cells: CellList::new(&Boundary::Open, range_angstrom, &positions),
            positions,
            range_angstrom,
        }
    }

    /// Numbers of the positions within the range of a point, in ascending order, into `found`.
    pub fn within(&self, point: &Vec3, found: &mut Vec<usize>) {
        self.cells.candidates(point, found);
        let limit = self.range_angstrom.powi(2);
        found.retain(|index| (self.positions[*index] - point).norm_squared() <= limit);
        found.sort_unstable();
    }
}
