//! The rigid body: mesh, charges, hydropathy, mass. Immutable; simulations share it behind an
//! `Arc`.

use crate::chemistry::residue_names::mass_in_chain_g_per_mol;
use crate::chemistry::titration::BodyTitration;
use protomer_kernel::mesh::MassProperties;
use protomer_kernel::{TriangleMesh, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// A rigid body in its own frame.
///
/// ```
/// use protomer_body::{Source, SurfaceSettings, build_body_of_points};
/// use protomer_kernel::PointRecord;
/// let ball = PointRecord { radius_angstrom: 3.0, charge_e: -2.0, ..PointRecord::default() };
/// let source = Source { file: "ball.pqr", sha256: "" };
/// let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
/// assert_eq!((body.sites.len(), body.net_charge_e()), (1, -2.0));
/// assert!((body.mass_properties.volume_angstrom3 - 36.0 * std::f64::consts::PI).abs() < 0.1);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Name, as it appears in assemblies and tables.
    pub name: String,
    /// Solvent-excluded surface: closed, 2-manifold, outward.
    pub mesh: TriangleMesh,
    /// Hard core, which no other body may enter, where it is not the solid inside `mesh`; a mesh of
    /// the same kind.
    pub core: Option<TriangleMesh>,
    /// Charge sites, one per atom.
    pub sites: Vec<Site>,
    /// Capacitance of each site, e²: the fall of its mean charge per kT/e of potential, by groups that
    /// gain or lose protons. Empty for a body whose charges do not respond.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub capacitances_e2: Vec<f64>,
    /// Titratable groups, for simulations that change their protons; `None` for a body without them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub titration: Option<BodyTitration>,
    /// Residues, in the order of the structure file; empty for a body made from a bare mesh and
    /// charges.
    pub residues: Vec<Residue>,
    /// Volume, centroid and inertia of the solid inside the mesh.
    pub mass_properties: MassProperties,
    /// Provenance of the body.
    pub provenance: Provenance,
}

/// One atom of a body, or one bare point charge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Site {
    /// Position in the body's frame, Å.
    pub position: Vec3,
    /// Partial charge, e.
    pub charge_e: f64,
    /// Radius used for the surface, Å; zero for a bare point charge.
    pub radius_angstrom: f64,
    /// Atom name as in the structure file, trimmed; empty for a bare point charge.
    pub atom_name: String,
    /// Index into [`Body::residues`].
    pub residue: Option<u32>,
}

impl Site {
    /// Whether this is a hydrogen, by its name: H... or, in old files, 1H....
    ///
    /// ```
    /// use protomer_body::Site;
    /// use protomer_kernel::Vec3;
    /// let named = |atom_name: &str| Site {
    ///     position: Vec3::zeros(),
    ///     charge_e: 0.0,
    ///     radius_angstrom: 1.1,
    ///     atom_name: atom_name.into(),
    ///     residue: None,
    /// };
    /// assert!(named("HB2").is_hydrogen() && named("1HB").is_hydrogen() && !named("CB").is_hydrogen());
    /// ```
    pub fn is_hydrogen(&self) -> bool {
        let letters = self
            .atom_name
            .trim_start_matches(|c: char| c.is_ascii_digit());
        letters.starts_with(['H', 'D'])
    }
}

/// One residue of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Residue {
    /// Chain identifier (author's).
    pub chain: String,
    /// Residue number (author's).
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
    /// Residue name as in the file, three letters or more.
    pub name: String,
    /// Net charge at the body's pH, e.
    pub charge_e: f64,
    /// Hydropathy index ([`hydropathy`](crate::chemistry::hydropathy)); `None` where the scale has
    /// no value.
    pub hydropathy: Option<f64>,
}

/// Provenance of a body, in enough detail to make it again.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// The input file as the user named it.
    pub source: String,
    /// SHA-256 of the input file's bytes, in hexadecimal.
    pub source_sha256: String,
    /// The body frame's origin in the coordinates of the input file, Å.
    pub origin_angstrom: Vec3,
    /// Every setting that affects the body (pH, probe, density, selection, mutations ...), by name.
    pub settings: BTreeMap<String, String>,
}

impl Body {
    /// A body of a mesh, about its origin, and of sites, without residues and protons.
    ///
    /// ```
    /// use protomer_body::Body;
    /// use protomer_kernel::TriangleMesh;
    /// let body = Body::of_mesh("tetrahedron", TriangleMesh::tetrahedron(1.0), Vec::new())?;
    /// assert!((body.mass_properties.volume_angstrom3 - 8.0 / 3.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// If the mesh does not enclose a volume.
    pub fn of_mesh(
        name: &str,
        mesh: TriangleMesh,
        sites: Vec<Site>,
    ) -> protomer_kernel::Result<Self> {
        Ok(Self {
            name: name.to_owned(),
            mass_properties: mesh.mass_properties()?,
            mesh,
            core: None,
            sites,
            capacitances_e2: Vec::new(),
            titration: None,
            residues: Vec::new(),
            provenance: Provenance::default(),
        })
    }

    /// Sum of the site charges, e.
    ///
    /// ```
    /// # use protomer_body::{BodySettings, Source, build_body};
    /// # let text = "ATOM      1  ND1 HIS A   7      11.104   6.134  -6.504  1.00 10.00           N";
    /// # let source = Source { file: "histidine.pdb", sha256: "" };
    /// let body = build_body("histidine", source, text.as_bytes(), &BodySettings::default())?.body;
    /// assert!(body.net_charge_e() > 0.0 && body.net_charge_e() < 1.0);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn net_charge_e(&self) -> f64 {
        net_charge_e(&self.sites)
    }

    /// Molar mass of the chains of amino acids in this body, g/mol: the residues, each with its own
    /// modification, the caps, and a water for each chain. `None` without residues, or if one of them
    /// is of unknown mass ([`Self::residues_of_unknown_mass`]).
    ///
    /// ```
    /// # use protomer_body::{BodySettings, Source, build_body};
    /// # let text = "ATOM      1  CA  SEP A   7      11.104   6.134  -6.504  1.00 10.00           C";
    /// # let source = Source { file: "phosphoserine.pdb", sha256: "" };
    /// let body = build_body("sep", source, text.as_bytes(), &BodySettings::default())?.body;
    /// let mass = body.molar_mass_g_per_mol().unwrap_or(f64::NAN);
    /// assert!((mass - 185.07).abs() < 0.01); // C3 H8 N O6 P
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn molar_mass_g_per_mol(&self) -> Option<f64> {
        const WATER_G_PER_MOL: f64 = 18.015;
        let mut chains = BTreeSet::new();
        let mut sum = 0.0;
        for residue in &self.residues {
            sum += mass_in_chain_g_per_mol(&residue.name)?;
            chains.insert(&residue.chain);
        }
        let waters = chains.len() as f64;
        (waters > 0.0).then_some(sum + waters * WATER_G_PER_MOL)
    }

    /// Names of the residues whose mass is not known, each once: ligands, nucleotides, ions, and
    /// modified residues in no table.
    ///
    /// ```
    /// # use protomer_body::{BodySettings, Source, build_body};
    /// # let text = "\
    /// # ATOM      1  N   XYZ A   7      11.104   6.134  -6.504  1.00 10.00           N
    /// # ATOM      2  CA  XYZ A   7      11.639   6.071  -5.147  1.00 10.00           C
    /// # ATOM      3  C   XYZ A   7      13.120   6.071  -5.147  1.00 10.00           C";
    /// # let source = Source { file: "xyz.pdb", sha256: "" };
    /// let body = build_body("xyz", source, text.as_bytes(), &BodySettings::default())?.body;
    /// assert!(body.residues_of_unknown_mass().contains("XYZ"));
    /// assert_eq!(body.molar_mass_g_per_mol(), None);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn residues_of_unknown_mass(&self) -> BTreeSet<&str> {
        let names = self.residues.iter().map(|residue| residue.name.as_str());
        names
            .filter(|name| mass_in_chain_g_per_mol(name).is_none())
            .collect()
    }

    /// The mesh that decides whether bodies overlap: that of the hard core, or of the surface.
    pub fn hard_mesh(&self) -> &TriangleMesh {
        self.core.as_ref().unwrap_or(&self.mesh)
    }

    /// Radius of the sphere about the body's origin that holds the mesh, Å.
    ///
    /// ```
    /// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
    /// # use protomer_kernel::PointRecord;
    /// # let ball = PointRecord { radius_angstrom: 3.0, ..PointRecord::default() };
    /// # let source = Source { file: "ball.xyzr", sha256: "" };
    /// let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
    /// assert!((body.mesh_radius_angstrom() - 3.0).abs() < 0.2);
    /// assert_eq!(body.charge_radius_angstrom(), 0.0, "its only charge is in the centre");
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn mesh_radius_angstrom(&self) -> f64 {
        self.mesh.radius_about_origin_angstrom()
    }

    /// Radius of the sphere about the body's origin that holds every charge, Å.
    pub fn charge_radius_angstrom(&self) -> f64 {
        self.sites
            .iter()
            .map(|site| site.position.norm_squared())
            .fold(0.0, f64::max)
            .sqrt()
    }
}

/// Sum of charges, e. Zero without charges, although the sum of an empty iterator is -0.
pub(crate) fn net_charge_e(sites: &[Site]) -> f64 {
    let mut sum = 0.0;
    for site in sites {
        sum += site.charge_e;
    }
    sum
}
