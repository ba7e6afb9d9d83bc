//! A cubic grid of voxels about the origin.

use crate::{FieldError, Result};
use protomer_kernel::Vec3;

/// Finest and coarsest voxels, Å. The distance from the surface is known up to 1 Å inside, which is
/// half of the coarsest.
pub const SPACING_RANGE_ANGSTROM: (f64, f64) = (0.25, 2.0);
/// Fewest and most voxels along an edge.
pub const SIZE_RANGE: (usize, usize) = (8, 512);

/// A grid of size³ voxels of edge h centred on the origin. The centre of voxel (x, y, z) is h (x -
/// (size - 1)/2) and so on; its number is (z size + y) size + x.
///
/// ```
/// use protomer_field::voxels::Lattice;
/// let lattice = Lattice::new(64, 1.0)?;
/// assert_eq!(lattice.centre(0).as_slice(), [-31.5; 3]);
/// assert_eq!(lattice.centre(64 * 64 + 2).as_slice(), [-29.5, -31.5, -30.5]);
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    size: usize,
    spacing_angstrom: f64,
}

impl Lattice {
    /// A lattice of this many voxels along each edge, with voxels of this edge in Å.
    ///
    /// ```
    /// use protomer_field::voxels::Lattice;
    /// assert!(Lattice::new(64, 1.0).is_ok());
    /// assert!(Lattice::new(4, 1.0).is_err() && Lattice::new(64, 5.0).is_err());
    /// ```
    ///
    /// # Errors
    /// [`FieldError::BadSetting`] for sizes outside [`SIZE_RANGE`] and spacings outside
    /// [`SPACING_RANGE_ANGSTROM`].
    pub fn new(size: usize, spacing_angstrom: f64) -> Result<Self> {
        if !(SIZE_RANGE.0..=SIZE_RANGE.1).contains(&size) {
            return Err(FieldError::BadSetting {
                setting: "size",
                value: size as f64,
                requirement: "8 to 512 voxels along each edge",
            });
        }
        if !(SPACING_RANGE_ANGSTROM.0..=SPACING_RANGE_ANGSTROM.1).contains(&spacing_angstrom) {
            return Err(FieldError::BadSetting {
                setting: "spacing",
                value: spacing_angstrom,
                requirement: "0.25 to 2 Å",
            });
        }
        Ok(Self {
            size,
            spacing_angstrom,
        })
    }

    /// Voxels along each edge.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Edge of a voxel, Å.
    pub fn spacing_angstrom(&self) -> f64 {
        self.spacing_angstrom
    }

    /// The coordinate of the centres in a layer along any axis, Å.
    ///
    /// ```
    /// use protomer_field::voxels::Lattice;
    /// let lattice = Lattice::new(8, 2.0)?;
    /// assert_eq!((lattice.coordinate(0), lattice.coordinate(7)), (-7.0, 7.0));
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    #[inline]
    pub fn coordinate(&self, layer: usize) -> f64 {
        self.spacing_angstrom * (layer as f64 - 0.5 * (self.size as f64 - 1.0))
    }

    /// The number of the voxel in column x, row y and layer z.
    ///
    /// ```
    /// use protomer_field::voxels::Lattice;
    /// let lattice = Lattice::new(8, 1.0)?;
    /// assert_eq!(lattice.index(3, 2, 1), 3 + 8 * 2 + 64);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    #[inline]
    pub fn index(&self, x: usize, y: usize, z: usize) -> u32 {
        // 512³ < 2³².
        ((z * self.size + y) * self.size + x) as u32
    }

    /// The centre of a voxel, Å.
    #[inline]
    pub fn centre(&self, index: u32) -> Vec3 {
        let index = index as usize;
        let (x, rest) = (index % self.size, index / self.size);
        Vec3::new(
            self.coordinate(x),
            self.coordinate(rest % self.size),
            self.coordinate(rest / self.size),
        )
    }

    /// The largest extent along an axis, Å, of a solid centred on the origin, if all voxels that its
    /// surface passes through are to lie on the lattice: (size - 1) h.
    ///
    /// ```
    /// use protomer_field::voxels::Lattice;
    /// assert_eq!(Lattice::new(64, 1.5)?.room_angstrom(), 94.5);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    pub fn room_angstrom(&self) -> f64 {
        (self.size as f64 - 1.0) * self.spacing_angstrom
    }
}
