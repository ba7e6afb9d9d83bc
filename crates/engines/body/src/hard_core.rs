//! The hard core of a body: what no other body may enter.
//!
//! Atoms of a native interface lie closer than the sum of their Bondi radii: N and O in hydrogen
//! bonds and salt bridges by up to 0.7 Å, all others by some tenths of an ångström in structures of
//! ordinary resolution. As hard bodies with solvent-excluded surfaces, two proteins overlap in every
//! crystal of their complex. The native core admits such contacts. It is the solvent-excluded surface
//! of smaller atoms ([`core_radius_angstrom`](crate::chemistry::radii::core_radius_angstrom)), moved
//! inward by 0.5 Å: an N or O keeps 0.7 Å, a C 1.2 Å. The probe grows as the atoms shrink, so that the
//! inside of a protein, which no partner can reach, stays filled.
//!
//! Both numbers come from a measurement on 149 crystal complexes (docs/validation/native-contacts.md).

use crate::surface::ExactSurface;
use crate::{BodyError, Result, Site, SurfaceSettings};
use protomer_kernel::TriangleMesh;

protomer_kernel::choices! {
    /// The definition of the hard core of a body.
    ///
    /// ```
    /// use protomer_body::{HardCore, Source, SurfaceSettings, build_body_of_points};
    /// # use protomer_kernel::PointRecord;
    /// # let ball = PointRecord { radius_angstrom: 3.0, ..PointRecord::default() };
    /// # let source = Source { file: "ball.xyzr", sha256: "" };
    /// let surface = SurfaceSettings { core: Some(HardCore::Surface), ..SurfaceSettings::default() };
    /// let body = build_body_of_points("ball", source, &[ball], &surface)?.body;
    /// assert!(body.core.is_none(), "the surface itself is hard");
    /// assert_eq!(body.hard_mesh(), &body.mesh);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub enum HardCore {
        /// A core within the surface that admits the contacts of natural complexes.
        Native = "native",
        /// The solvent-excluded surface itself.
        Surface = "surface",
    }
}

impl HardCore {
    /// Distance by which a native core is moved inward unless the user says otherwise, Å.
    pub const NATIVE_OFFSET_ANGSTROM: f64 = 0.5;
}

/// Radii and offset of a native core.
#[derive(Debug, Clone)]
pub(crate) struct NativeCore {
    /// Radius of each site, Å.
    pub(crate) radii_angstrom: Vec<f64>,
    /// Distance by which the surface of these radii is moved inward, Å.
    pub(crate) inward_offset_angstrom: f64,
}

impl NativeCore {
    /// The mesh of the core, made like that of the surface.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for an offset that leaves nothing of an atom, and a core too large to be
    /// meshed.
    pub(crate) fn mesh(&self, sites: &[Site], surface: &SurfaceSettings) -> Result<TriangleMesh> {
        let offset = self.inward_offset_angstrom;
        let probe_angstrom = surface.probe_radius_angstrom;
        let atoms = sites.iter().zip(&self.radii_angstrom);
        let atoms = atoms.map(|(site, radius)| (site.position, *radius));
        let exact = moved_inward(atoms, offset, probe_angstrom)?;
        Ok(surface.mesh_of(exact)?.mesh)
    }
}

/// The solvent-excluded surface of the atoms that have a radius, moved inward: the atoms' radii shrink
/// by the offset and the probe's radius grows by it, so that the centre of the probe reaches the same
/// places as before.
///
/// # Errors
/// [`BodyError::Invalid`] for an offset that is not smaller than every radius.
pub(crate) fn moved_inward(
    atoms: impl Iterator<Item = (protomer_kernel::Vec3, f64)>,
    offset_angstrom: f64,
    probe_radius_angstrom: f64,
) -> Result<ExactSurface> {
    let (mut centres, mut radii) = (Vec::new(), Vec::new());
    let mut smallest_angstrom = f64::INFINITY;
    for (centre, radius_angstrom) in atoms {
        if radius_angstrom > 0.0 {
            centres.push(centre);
            radii.push(radius_angstrom - offset_angstrom);
            smallest_angstrom = smallest_angstrom.min(radius_angstrom);
        }
    }
    if !(offset_angstrom.is_finite() && offset_angstrom < smallest_angstrom) {
        return Err(BodyError::Invalid {
            cause: format!(
                "an inward offset of {offset_angstrom} Å, and the smallest atom has a radius of \
                 {smallest_angstrom} Å"
            ),
            remedy: "give a smaller offset".into(),
        });
    }
    ExactSurface::new(&centres, &radii, probe_radius_angstrom + offset_angstrom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{HardBodies, HardBody};
    use crate::{BodySettings, BuiltBody, Source, build_body};
    use protomer_kernel::{Pose, Vec3};

    /// A carbonyl group or an amide on the axis x that points to the right or to the left.
    fn group(donor: bool, core: HardCore) -> BuiltBody {
        let (tip, side) = if donor { ("N", -1.0) } else { ("O", 1.0) };
        let mut text = String::new();
        for (name, x) in [("CA", -2.5), ("C", -1.2), (tip, 0.0)] {
            let (x, element) = (side * x, &name[..1]);
            text += &format!(
                "ATOM      1  {name:<3} GLY A   1    {x:8.3}{:8.3}{:8.3}  1.00  0.00          {element:>2}\n",
                0.0, 0.0
            );
        }
        let mut settings = BodySettings::default();
        settings.surface.core = Some(core);
        let source = Source {
            file: "group.pdb",
            sha256: "",
        };
        build_body("group", source, text.as_bytes(), &settings).unwrap()
    }

    /// Whether a carbonyl and an amide overlap whose O and N are this far apart.
    fn overlap_at(distance_angstrom: f64, core: HardCore) -> bool {
        let [acceptor, donor] = [false, true].map(|donor| group(donor, core).body);
        let tip = |body: &crate::Body| body.sites[2].position;
        let hard = [&acceptor, &donor].map(|body| HardBody::from_body(body).unwrap());
        let position = tip(&acceptor) + Vec3::new(distance_angstrom, 0.0, 0.0) - tip(&donor);
        let moved = Pose {
            position,
            ..Pose::identity()
        };
        HardBodies::new(hard.into()).any_overlap(&[(0, Pose::identity()), (1, moved)])
    }

    /// The hydrogen bond of a backbone is 2.9 Å long, the sum of the Bondi radii 3.07 Å.
    #[test]
    fn a_native_core_admits_a_hydrogen_bond_and_the_surface_does_not() {
        assert!(overlap_at(2.9, HardCore::Surface));
        assert!(!overlap_at(3.2, HardCore::Surface));
        assert!(!overlap_at(2.4, HardCore::Native));
        // Twice 0.7 Å is what is left of N and O.
        assert!(overlap_at(1.2, HardCore::Native));
        assert!(!overlap_at(1.6, HardCore::Native));
    }

    #[test]
    fn the_surface_is_the_same_with_both_cores_and_a_body_records_which_it_has() {
        let [native, surface] =
            [HardCore::Native, HardCore::Surface].map(|core| group(true, core).body);
        assert_eq!(native.mesh, surface.mesh);
        assert_eq!(surface.hard_mesh(), &surface.mesh);
        assert!(
            native.hard_mesh().volume_angstrom3() < 0.6 * surface.mesh.volume_angstrom3(),
            "{}",
            native.hard_mesh().volume_angstrom3()
        );
        let recorded = |body: &crate::Body| body.provenance.settings["core"].clone();
        assert_eq!(
            (recorded(&native), recorded(&surface)),
            ("native".into(), "surface".into())
        );
    }

    /// The core of a single atom is a ball.
    #[test]
    fn the_offset_sets_how_much_of_an_atom_is_hard() {
        let text = "ATOM      1  CA  GLY A   1       0.000   0.000   0.000  1.00  0.00           C";
        let volume_angstrom3 = |offset: Option<f64>| {
            let mut settings = BodySettings::default();
            settings.surface.inward_offset_angstrom = offset;
            let source = Source {
                file: "atom.pdb",
                sha256: "",
            };
            let body = build_body("atom", source, text.as_bytes(), &settings).unwrap();
            body.body.hard_mesh().volume_angstrom3()
        };
        let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        for (offset, radius) in [(None, 1.2), (Some(0.2), 1.5), (Some(0.0), 1.7)] {
            let found = volume_angstrom3(offset);
            assert!((found / ball(radius) - 1.0).abs() < 1e-3, "{found}");
        }
    }
}
