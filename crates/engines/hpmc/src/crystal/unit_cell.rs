//! Unit cells of any shape, with bodies of one or several kinds on their sites.

use crate::error::require;
use crate::symmetry::Symmetry;
use crate::{Error, Result};
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;

/// Sites nearer to each other than this part of the cell are the same.
pub(super) const SAME: f64 = 1e-6;
/// A site of a unit cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site<const D: usize> {
    /// The place, in parts of the edges.
    pub place: [f64; D],
    /// The orientation of the body on it.
    pub rotation: Rotation,
    /// Number of the kind of the body on it.
    pub kind: u32,
}

/// A unit cell.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::crystal::{Crystal, Site, UnitCell};
/// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
/// let site = |place| Site { place, rotation: Rotation::identity(), kind: 0 };
/// let honeycomb = UnitCell {
///     space: PeriodicBox::with_angles(&[1.0, 1.0], &[60.0])?,
///     sites: vec![site([0.0, 0.0]), site([1.0 / 3.0, 1.0 / 3.0])],
/// };
/// let disk = HardBody::<2>::ball(0.5)?;
/// let crystal = |packing| Crystal::new(&honeycomb, &disk, 32, packing);
/// // Disks of a honeycomb touch at π/(3√3) = 0.6046.
/// assert_eq!(crystal(0.604)?.first_overlap(&disk), None);
/// assert!(crystal(0.605)?.first_overlap(&disk).is_some());
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct UnitCell<const D: usize> {
    /// Shape of the cell; the size does not matter.
    pub space: PeriodicBox<D>,
    /// The sites.
    pub sites: Vec<Site<D>>,
}

impl<const D: usize> UnitCell<D> {
    /// Number of sites of each kind of bodies.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("cscl")?.composition(), [1, 1]);
    /// assert_eq!(UnitCell::<3>::by_name("bcc")?.composition(), [2]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn composition(&self) -> Vec<usize> {
        let kinds = self.sites.iter().map(|site| site.kind as usize + 1).max();
        let count = |kind| {
            self.sites
                .iter()
                .filter(move |site| site.kind as usize == kind)
        };
        (0..kinds.unwrap_or(0))
            .map(|kind| count(kind).count())
            .collect()
    }

    /// The kind of each of so many bodies, as the sites of repeated cells have them.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("cscl")?.kinds_of_bodies(4), [0, 1, 0, 1]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn kinds_of_bodies(&self, bodies: usize) -> Vec<u32> {
        let kinds = self.sites.iter().map(|site| site.kind).cycle();
        kinds.take(bodies).collect()
    }

    /// The same cell with every body turned first, in its own frame.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// use protomer_kernel::{Rotation, Vec3};
    /// let quarter_turn = Rotation::new(std::f64::consts::FRAC_PI_2 * Vec3::z());
    /// let cell = UnitCell::<3>::by_name("bcc")?.with_bodies_turned(&quarter_turn);
    /// assert!(cell.sites.iter().all(|site| site.rotation.angle_to(&quarter_turn) < 1e-12));
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn with_bodies_turned(mut self, rotation: &Rotation) -> Self {
        for site in &mut self.sites {
            // Turned in its own frame: the orientation on the site comes after.
            site.rotation *= rotation;
        }
        self
    }

    /// Whether the cell, moved by the way from its first site to another, looks as before.
    pub(super) fn is_translation(&self, to: &Site<D>, symmetry: &Symmetry) -> bool {
        let first = &self.sites[0];
        self.sites.iter().all(|site| {
            let shifted_place: [f64; D] =
                std::array::from_fn(|axis| site.place[axis] + to.place[axis] - first.place[axis]);
            let lands_on = |other: &Site<D>| {
                is_same_place(&shifted_place, &other.place)
                    && other.kind == site.kind
                    && symmetry.are_alike(&other.rotation, &site.rotation)
            };
            self.sites.iter().any(lands_on)
        })
    }

    pub(super) fn check(&self) -> Result<()> {
        require(
            "the number of sites of the unit cell",
            self.sites.len() as f64,
            "at least 1",
            !self.sites.is_empty(),
        )?;
        let volume = self.space.volume();
        let holds = volume.is_normal();
        require(
            "the volume of the unit cell",
            volume,
            "from 1e-307 to 1e308",
            holds,
        )?;
        let fewest = self.composition().into_iter().min().unwrap_or(0);
        require(
            "the number of sites of a kind in the unit cell",
            fewest as f64,
            "at least 1: number the kinds without gaps",
            fewest > 0,
        )?;
        for (second, site) in self.sites.iter().enumerate() {
            if let Some(first) = self.sites[..second]
                .iter()
                .position(|other| is_same_place(&other.place, &site.place))
            {
                return Err(Error::SameSite {
                    bodies: [first + 1, second + 1],
                });
            }
        }
        Ok(())
    }
}

/// Whether two places, in parts of the edges, are the same or images of each other.
fn is_same_place<const D: usize>(one: &[f64; D], other: &[f64; D]) -> bool {
    let mut apart = one.iter().zip(other).map(|(a, b)| a - b);
    apart.all(|x| (x - x.round()).abs() < SAME)
}
