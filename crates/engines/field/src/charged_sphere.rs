//! Atoms as spheres with a charge at their centre.

use protomer_body::Site;
use protomer_kernel::Vec3;

/// An atom: a sphere with a charge at its centre.
///
/// ```
/// use protomer_body::Site;
/// use protomer_field::ChargedSphere;
/// use protomer_kernel::Vec3;
/// let site = Site {
///     position: Vec3::x(),
///     charge_e: -0.5,
///     radius_angstrom: 1.5,
///     atom_name: "OD1".into(),
///     residue: None,
/// };
/// let sphere = ChargedSphere::from(&site);
/// assert_eq!((sphere.centre, sphere.charge_e, sphere.radius_angstrom), (Vec3::x(), -0.5, 1.5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChargedSphere {
    /// Centre, Å.
    pub centre: Vec3,
    /// Radius, Å.
    pub radius_angstrom: f64,
    /// Charge, e.
    pub charge_e: f64,
}

impl From<&Site> for ChargedSphere {
    fn from(site: &Site) -> Self {
        Self {
            centre: site.position,
            radius_angstrom: site.radius_angstrom,
            charge_e: site.charge_e,
        }
    }
}

/// Lowest and highest corner of the box around spheres, Å.
pub(crate) fn bounds<'a>(spheres: impl IntoIterator<Item = &'a ChargedSphere>) -> (Vec3, Vec3) {
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for sphere in spheres {
        let radius = Vec3::repeat(sphere.radius_angstrom);
        low = low.inf(&(sphere.centre - radius));
        high = high.sup(&(sphere.centre + radius));
    }
    (low, high)
}
