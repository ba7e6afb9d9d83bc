//! The networks that `protomer framework` can build, each with its own flags.

use anyhow::{Result, bail};
use clap::{ArgGroup, Args, Subcommand};
use protomer_common::quantity::length_angstrom;
use protomer_common::range::Range;
use protomer_linkage::framework::analytic::Honeycomb;
use protomer_linkage::framework::build::MissingRib;
use protomer_linkage::framework::{Framework, build};

/// Lengths of networks.
const LENGTH: Range = Range::new(1e-6, 1e6, "Å");

/// A length in Å, with or without a unit.
fn length(text: &str) -> Result<f64, String> {
    let length = length_angstrom(text).map_err(|error| error.to_string())?;
    let checked = LENGTH.require("the length", length);
    checked.map_err(|error| error.to_string())?;
    Ok(length)
}

/// Parameters that are numbers, by their names.
macro_rules! numbers {
    ($parameters:ident: $($field:ident),*) => {
        vec![$((stringify!($field), &mut $parameters.$field)),*]
    };
}

#[derive(Debug, Clone, Subcommand)]
pub enum Builder {
    Honeycomb(HoneycombArgs),
    /// Squares that share corners and rotate alternately.
    RotatingSquares(PolygonArgs),
    /// Equilateral triangles that share corners and rotate alternately.
    RotatingTriangles(PolygonArgs),
    Arrowhead(ArrowheadArgs),
    MissingRib(MissingRibArgs),
    Stars(StarsArgs),
    Chiral(ChiralArgs),
    RodLattice(RodLatticeArgs),
    Fcc(FccArgs),
    Diamond(DiamondArgs),
    AlphaCristobalite(AlphaCristobaliteArgs),
    /// Tables 2 to 4 of Grima et al., Mol. Simul. 31, 925 (2005), printed and recomputed.
    #[command(group = ArgGroup::new("Result"))]
    Tables,
}

/// Hexagonal honeycomb: ribs h along z, ribs l at the angle theta to them; re-entrant below 90
/// degrees.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct HoneycombArgs {
    /// Length of the ribs along z, Å.
    #[arg(long, default_value = "2A", value_parser = length, allow_hyphen_values = true)]
    h: f64,
    /// Length of the inclined ribs, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    l: f64,
    /// Angle between the two kinds of ribs, degrees.
    #[arg(long)]
    theta: f64,
    /// Stiffness of each hinge between an h and an l rib, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
    /// Stiffness of each rib, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct PolygonArgs {
    /// Side of a polygon, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    side: f64,
    /// Rotation of each polygon from the open position, degrees.
    #[arg(long)]
    angle: f64,
    /// Stiffness of the rods that make a polygon rigid, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// K_h: stiffness of the hinge between two polygons, one at every shared corner, as in the
    /// published formulas, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// Arrowheads: long ribs at the outer and short ribs at the inner angle to z.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct ArrowheadArgs {
    /// Extent of a cell along y, Å.
    #[arg(long, default_value = "2A", value_parser = length, allow_hyphen_values = true)]
    width: f64,
    /// Angle of the long ribs to z, degrees.
    #[arg(long)]
    outer: f64,
    /// Angle of the short ribs to z, degrees.
    #[arg(long)]
    inner: f64,
    /// Stiffness of each rib, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge, one between any two adjacent ribs at a node, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// Missing-rib foam: crosses turned out of the axes, whose arms are joined by ribs at elbows.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct MissingRibArgs {
    /// Length of the arms of a cross, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    arm: f64,
    /// Length of the ribs between the arms of two crosses, Å.
    #[arg(long, default_value = "2A", value_parser = length, allow_hyphen_values = true)]
    rib: f64,
    /// Rotation of the crosses out of the axes, degrees.
    #[arg(long)]
    angle: f64,
    /// Stiffness of each arm and rib, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge at an elbow, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
    /// Stiffness of each hinge between neighbouring arms of a cross, kcal/mol/rad² [default: that of
    /// the elbows].
    #[arg(long)]
    cross_kh: Option<f64>,
}

/// Stars with four or six points, joined by ribs from point to point.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct StarsArgs {
    /// Points of a star: 4 or 6.
    #[arg(long, default_value_t = 4)]
    points: usize,
    /// Length of a side of a star, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    side: f64,
    /// Length of the ribs between stars, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    rib: f64,
    /// Angle at a point, between two sides, degrees.
    #[arg(long)]
    angle: f64,
    /// Stiffness of each side and rib, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge, one between any two adjacent rods at a node, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// Chiral honeycomb: rigid wheels, joined by ligaments that touch them.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct ChiralArgs {
    /// Ligaments of a wheel: 4 or 6.
    #[arg(long, default_value_t = 6)]
    spokes: usize,
    /// Radius of a wheel, Å.
    #[arg(long, default_value = "0.5A", value_parser = length, allow_hyphen_values = true)]
    radius: f64,
    /// Length of the ligaments, Å.
    #[arg(long, default_value = "2A", value_parser = length, allow_hyphen_values = true)]
    ligament: f64,
    /// Stiffness of each ligament, and of the rods that make a wheel rigid, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge between a ligament and a wheel, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// Tetrahedra of alpha-cristobalite, from its crystal structure.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct AlphaCristobaliteArgs {
    /// Factor of all lengths of the crystal.
    #[arg(long, default_value_t = 1.0)]
    scale: f64,
    /// Stiffness of the rods that make a tetrahedron rigid, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each of the nine hinges between two tetrahedra, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// The lattice of squares whose corners are joined by rods.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct RodLatticeArgs {
    /// Half-diagonal of a square, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    l: f64,
    /// Length of the rods between squares, Å.
    #[arg(long, value_parser = length, allow_hyphen_values = true)]
    r0: f64,
    /// Rotation of each square, degrees; 45 is open.
    #[arg(long)]
    angle: f64,
    /// Stiffness of the rods that make a square rigid, kcal/mol/Å².
    #[arg(long)]
    square_ks: f64,
    /// Stiffness of the rods between squares, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge, one between any two adjacent rods at a node, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

/// Face-centred cubic net of nearest-neighbour rods.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct FccArgs {
    /// Edge of the cubic cell, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    edge: f64,
    /// Stiffness of each rod, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
}

/// Diamond net of nearest-neighbour rods, hinged between all rods at a node.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub struct DiamondArgs {
    /// Edge of the cubic cell, Å.
    #[arg(long, default_value = "1A", value_parser = length, allow_hyphen_values = true)]
    edge: f64,
    /// Stiffness of each rod, kcal/mol/Å².
    #[arg(long)]
    ks: f64,
    /// Stiffness of each hinge, one between every two rods at a node, kcal/mol/rad².
    #[arg(long)]
    kh: f64,
}

impl HoneycombArgs {
    /// Parameters of the honeycomb.
    pub fn made_of(&self, thickness_angstrom: f64) -> Honeycomb {
        Honeycomb {
            h_angstrom: self.h,
            l_angstrom: self.l,
            theta_rad: self.theta.to_radians(),
            hinge_stiffness_kcal_mol_rad2: self.kh,
            rod_stiffness_kcal_mol_angstrom2: self.ks,
            thickness_angstrom,
        }
    }
}

impl Builder {
    /// The name of the network in results; `None` for the tables.
    pub fn describe(&self) -> Option<String> {
        Some(match self {
            Builder::Honeycomb(a) => {
                format!(
                    "honeycomb, h = {} Å, l = {} Å, θ = {}°, k_h = {}, k_s = {}",
                    a.h, a.l, a.theta, a.kh, a.ks
                )
            }
            Builder::RotatingSquares(a) => {
                format!(
                    "rotating squares, side {} Å, {}°, k_h = {}, k_s = {}",
                    a.side, a.angle, a.kh, a.ks
                )
            }
            Builder::RotatingTriangles(a) => {
                format!(
                    "rotating triangles, side {} Å, {}°, k_h = {}, k_s = {}",
                    a.side, a.angle, a.kh, a.ks
                )
            }
            Builder::Arrowhead(a) => format!(
                "arrowheads, width {} Å, {}° and {}°, k_h = {}, k_s = {}",
                a.width, a.outer, a.inner, a.kh, a.ks
            ),
            Builder::MissingRib(a) => format!(
                "missing-rib foam, arm {} Å, rib {} Å, {}°, k_h = {} ({} in crosses), k_s = {}",
                a.arm,
                a.rib,
                a.angle,
                a.kh,
                a.cross_kh.unwrap_or(a.kh),
                a.ks
            ),
            Builder::Stars(a) => format!(
                "stars with {} points, side {} Å, rib {} Å, {}°, k_h = {}, k_s = {}",
                a.points, a.side, a.rib, a.angle, a.kh, a.ks
            ),
            Builder::Chiral(a) => format!(
                "chiral honeycomb, {} spokes, radius {} Å, ligament {} Å, k_h = {}, k_s = {}",
                a.spokes, a.radius, a.ligament, a.kh, a.ks
            ),
            Builder::AlphaCristobalite(a) => format!(
                "alpha-cristobalite, scale {}, k_h = {}, k_s = {}",
                a.scale, a.kh, a.ks
            ),
            Builder::RodLattice(a) => format!(
                "squares and rods, l = {} Å, r0 = {} Å, {}°, k_h = {}, k_s = {} ({} in squares)",
                a.l, a.r0, a.angle, a.kh, a.ks, a.square_ks
            ),
            Builder::Fcc(a) => format!("face-centred cubic, edge {} Å, k_s = {}", a.edge, a.ks),
            Builder::Diamond(a) => {
                format!("diamond, edge {} Å, k_h = {}, k_s = {}", a.edge, a.kh, a.ks)
            }
            Builder::Tables => return None,
        })
    }

    /// The number of rods that come before the ribs which may flex; `None` where rods make rigid
    /// polygons or the network is in space.
    pub fn rods_before_ribs(&self) -> Option<usize> {
        match self {
            Builder::Honeycomb(_)
            | Builder::Arrowhead(_)
            | Builder::MissingRib(_)
            | Builder::Stars(_) => Some(0),
            Builder::Chiral(a) => Some(a.spokes * (a.spokes - 1) / 2),
            _ => None,
        }
    }

    /// Gives a parameter another value.
    pub fn set(&mut self, name: &str, value: f64) -> Result<()> {
        let mut names = Vec::new();
        // Unlike the others it has no value until it is given.
        if let Builder::MissingRib(foam) = self {
            if name == "cross-kh" {
                foam.cross_kh = Some(value);
                return Ok(());
            }
            names.push("cross-kh".into());
        }
        for (field, place) in self.numbers() {
            let parameter = field.replace('_', "-");
            if parameter == name {
                *place = value;
                return Ok(());
            }
            names.push(parameter);
        }
        bail!("--scan names {name}; this network has {}", names.join(", "))
    }

    /// The parameters that are numbers.
    fn numbers(&mut self) -> Vec<(&'static str, &mut f64)> {
        match self {
            Builder::Honeycomb(a) => numbers!(a: h, l, theta, kh, ks),
            Builder::RotatingSquares(a) | Builder::RotatingTriangles(a) => {
                numbers!(a: side, angle, kh, ks)
            }
            Builder::Arrowhead(a) => numbers!(a: width, outer, inner, kh, ks),
            Builder::MissingRib(a) => numbers!(a: arm, rib, angle, kh, ks),
            Builder::Stars(a) => numbers!(a: side, rib, angle, kh, ks),
            Builder::Chiral(a) => numbers!(a: radius, ligament, kh, ks),
            Builder::RodLattice(a) => numbers!(a: l, r0, angle, square_ks, kh, ks),
            Builder::Fcc(a) => numbers!(a: edge, ks),
            Builder::Diamond(a) => numbers!(a: edge, kh, ks),
            Builder::AlphaCristobalite(a) => numbers!(a: scale, kh, ks),
            Builder::Tables => Vec::new(),
        }
    }

    /// The network of one cell; `None` for the tables.
    pub fn build(&self, thickness_angstrom: f64) -> Result<Option<Framework>> {
        let mut network = match self {
            Builder::Honeycomb(a) => build::honeycomb(&a.made_of(thickness_angstrom))?,
            Builder::RotatingSquares(a) => {
                build::rotating_squares(a.side, a.angle.to_radians(), a.ks, a.kh)?
            }
            Builder::RotatingTriangles(a) => {
                build::rotating_triangles(a.side, a.angle.to_radians(), a.ks, a.kh)?
            }
            Builder::Arrowhead(a) => build::arrowhead(
                a.width,
                a.outer.to_radians(),
                a.inner.to_radians(),
                a.ks,
                a.kh,
            )?,
            Builder::MissingRib(a) => build::missing_rib(&MissingRib {
                arm_angstrom: a.arm,
                rib_angstrom: a.rib,
                angle_rad: a.angle.to_radians(),
                ks: a.ks,
                kh: a.kh,
                cross_kh: a.cross_kh.unwrap_or(a.kh),
            })?,
            Builder::Stars(a) => {
                build::stars(a.points, a.side, a.rib, a.angle.to_radians(), a.ks, a.kh)?
            }
            Builder::Chiral(a) => build::chiral(a.spokes, a.radius, a.ligament, a.ks, a.kh)?,
            Builder::AlphaCristobalite(a) => build::alpha_cristobalite(a.scale, a.ks, a.kh)?,
            Builder::RodLattice(a) => {
                build::rod_lattice(a.l, a.r0, a.angle.to_radians(), a.square_ks, a.ks, a.kh)?
            }
            Builder::Fcc(a) => build::face_centred_cubic(a.edge, a.ks)?,
            Builder::Diamond(a) => build::diamond(a.edge, a.ks, a.kh)?,
            Builder::Tables => return Ok(None),
        };
        network.thickness_angstrom = thickness_angstrom;
        Ok(Some(network))
    }
}
