//! The elastic constants of a network, with units, compared with closed formulas where they exist.

use super::curve::Curve;
use super::text::{fixed, rounded};
use super::{axes, strain_names};
use anyhow::{Context, Result};
use nalgebra::DMatrix;
use protomer_linkage::framework::analytic::{AxialModuli, Honeycomb};
use protomer_linkage::framework::elastic::MaxwellCount;
use protomer_linkage::framework::energy::{Configuration, Derivatives, NetworkEnergy};
use protomer_linkage::framework::load::minimise;
use protomer_linkage::framework::moduli::polar;
use protomer_linkage::framework::{
    Elasticity, Framework, Mechanism, Moduli, gpa_per_kcal_mol_angstrom3,
};
use protomer_results::keys::read_json;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Directions over half a turn in [`Report::polar`].
const POLAR_DIRECTIONS: usize = 36;
/// Largest force on a node, kcal/mol/Å, of a network at rest: the stopping criterion of
/// the paper's minimisations.
const REST_FORCE: f64 = 1e-3;
/// Largest number of node coordinates for which the Hessian is printed in full.
const MOST_PRINTED_COORDINATES: usize = 1500;

/// Options of [`analyse`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Value of the Avogadro constant that converts kcal/mol/Å³ to GPa, 1/mol.
    pub avogadro_per_mol: f64,
    /// Relaxation before the analysis, if any.
    pub relax: Option<Relax>,
    /// Whether to report energy, forces and Hessian.
    pub derivatives: bool,
}

/// Ways of relaxing a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relax {
    /// Relaxation of the nodes and the cell.
    FreeCell,
    /// Relaxation of the nodes only.
    FixedCell,
}

/// Name of the file of the report.
pub(super) const FILE: &str = "result.json";

/// A network's elastic constants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name of the builder or file.
    pub network: String,
    /// Dimension: 2 or 3.
    pub dimension: usize,
    /// Names of the components of strain and stress, in the order of all matrices; shear strains
    /// are engineering strains.
    pub strain_order: Vec<String>,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of rods.
    pub rods: usize,
    /// Number of hinges.
    pub hinges: usize,
    /// Number of torsions.
    pub torsions: usize,
    /// Cell vectors, Å.
    pub cell_angstrom: Vec<Vec<f64>>,
    /// Extent along x of a two-dimensional network, Å.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness_angstrom: Option<f64>,
    /// Volume of the cell, Å³.
    pub volume_angstrom3: f64,
    /// The value of the Avogadro constant used, 1/mol.
    pub avogadro_per_mol: f64,
    /// The value of 1 kcal/mol/Å³ in GPa that follows from it.
    pub gpa_per_kcal_mol_angstrom3: f64,
    /// Stiffness with relaxed nodes, GPa.
    pub c_gpa: Vec<Vec<f64>>,
    /// Stiffness with clamped nodes, which follow the strain affinely, GPa.
    pub c_clamped_gpa: Vec<Vec<f64>>,
    /// Moduli `e_y_gpa`, `g_yz_gpa`, `nu_yz`, ...: null where a mechanism makes the modulus zero or
    /// undefined.
    #[serde(flatten, deserialize_with = "moduli")]
    pub moduli: BTreeMap<String, Option<f64>>,
    /// Moduli by closed formulas.
    #[serde(flatten)]
    pub analytic: Option<Analytic>,
    /// Stress of the network in its present state, GPa.
    pub stress_gpa: Vec<f64>,
    /// Energy of the cell in its present state, kcal/mol.
    pub energy_kcal_mol: f64,
    /// Largest component of a force on a node, kcal/mol/Å.
    pub largest_force_kcal_mol_angstrom: f64,
    /// Relaxation before the analysis, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxed: Option<Relax>,
    /// Maxwell count: coordinates against springs.
    pub maxwell: MaxwellCount,
    /// Strains that cost no energy (mechanisms).
    pub mechanisms: Vec<Mechanism>,
    /// Zero-energy motions of the nodes at fixed cell, without translations; null for networks
    /// too large to count them.
    pub internal_mechanisms: Option<usize>,
    /// E and ν against the direction of the load in the plane, from y; empty in three dimensions.
    pub polar: Vec<Direction>,
    /// The network under increasing loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// Energy, forces and Hessian.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub derivatives: Option<PrintedDerivatives>,
}

/// One direction of [`Report::polar`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// Angle between the load and the y axis, degrees.
    pub angle_deg: f64,
    /// Young's modulus E, GPa; null where a mechanism makes it zero.
    pub e_gpa: Option<f64>,
    /// Poisson's ratio ν in the plane; null where it is undefined.
    pub nu: Option<f64>,
}

/// Closed-form moduli of a honeycomb.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analytic {
    /// Moduli with hinging and stretching together, exact.
    pub analytic: AnalyticModuli,
    /// Moduli with rods of fixed length.
    pub analytic_hinging: AnalyticModuli,
    /// Moduli with hinges of fixed angle.
    pub analytic_stretching: AnalyticModuli,
}

/// Closed-form moduli.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnalyticModuli {
    /// Moduli along the axes.
    #[serde(flatten)]
    pub axial: AxialModuli,
    /// Stiffness, GPa; null where it is infinite.
    pub c_gpa: Option<[[f64; 3]; 3]>,
}

/// Energy and its derivatives with respect to the node coordinates, node by node, in the order of
/// the axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrintedDerivatives {
    /// Node positions, Å.
    pub nodes_angstrom: Vec<f64>,
    /// Energy, kcal/mol.
    pub energy_kcal_mol: f64,
    /// Forces, minus the gradient, kcal/mol/Å.
    pub forces_kcal_mol_angstrom: Vec<f64>,
    /// Hessian, kcal/mol/Å².
    pub hessian_kcal_mol_angstrom2: Vec<Vec<f64>>,
    /// Derivatives of the energy with respect to the strain components, kcal/mol.
    pub strain_gradient_kcal_mol: Vec<f64>,
}

/// Analyses a network. Returns the analysed network (relaxed if requested, with explicit rest
/// lengths) and its constants.
///
/// # Errors
/// If the network is invalid, or not at a minimum of its energy.
///
/// ```
/// use protomer_linkage_verbs::frameworks::report::{Settings, analyse};
/// use protomer_linkage::framework::build::face_centred_cubic;
/// let network = face_centred_cubic(3.0, 7.0)?;
/// let settings = Settings { avogadro_per_mol: 6.02214076e23, relax: None, derivatives: false };
/// let (_, report) = analyse(&network, "fcc", &settings)?;
/// // A cubic crystal of central forces: c12 = c44.
/// assert!((report.c_gpa[0][1] - report.c_gpa[3][3]).abs() < 1e-9 * report.c_gpa[0][0]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn analyse(
    network: &Framework,
    name: &str,
    settings: &Settings,
) -> Result<(Framework, Report)> {
    let gpa = gpa_per_kcal_mol_angstrom3(settings.avogadro_per_mol);
    let energy = NetworkEnergy::new(network)?;
    let fixed = energy.with_rests(network);
    let built = Configuration::built(network);
    let configuration = match settings.relax {
        None => built,
        Some(Relax::FixedCell) => minimise(&fixed, false, None)?.configuration,
        Some(Relax::FreeCell) => minimise(&fixed, true, None)?
            .configuration
            .without_rotation(&built),
    };
    let placed = configuration.place(&fixed);
    let derivatives = energy.derivatives(&configuration);
    let hint = if settings.relax.is_none() {
        "elastic constants are defined for a network at rest only; add --relax"
    } else {
        "the relaxed network has no elastic constants"
    };
    let elasticity =
        Elasticity::from_configuration(network, &energy, &configuration).context(hint)?;
    let dimension = placed.dimension();
    let printed = match settings.derivatives {
        true => Some(print_derivatives(&energy, &configuration, &derivatives)?),
        false => None,
    };
    let mut directions = Vec::with_capacity(POLAR_DIRECTIONS);
    for direction in polar(&elasticity, gpa, POLAR_DIRECTIONS) {
        directions.push(Direction {
            angle_deg: direction.angle_deg,
            e_gpa: direction.youngs_gpa,
            nu: direction.poissons,
        });
    }
    let mut largest_force = 0.0_f64;
    for component in &derivatives.gradient {
        largest_force = largest_force.max(component.abs());
    }
    let report = Report {
        network: name.to_owned(),
        dimension,
        strain_order: strain_names(dimension)
            .iter()
            .map(|name| (*name).to_owned())
            .collect(),
        nodes: placed.nodes_angstrom.len(),
        rods: placed.rods.len(),
        hinges: placed.hinges.len(),
        torsions: placed.torsions.len(),
        cell_angstrom: placed.cell_angstrom.clone(),
        thickness_angstrom: (dimension == 2).then_some(placed.thickness_angstrom),
        volume_angstrom3: placed.volume_angstrom3(),
        avogadro_per_mol: settings.avogadro_per_mol,
        gpa_per_kcal_mol_angstrom3: gpa,
        c_gpa: rows(&(&elasticity.stiffness * gpa)),
        c_clamped_gpa: rows(&(&elasticity.clamped_stiffness * gpa)),
        moduli: named_moduli(&Moduli::new(&elasticity, gpa), dimension),
        analytic: None,
        stress_gpa: elasticity.stress.iter().map(|s| s * gpa).collect(),
        energy_kcal_mol: derivatives.energy,
        largest_force_kcal_mol_angstrom: largest_force,
        relaxed: settings.relax,
        maxwell: elasticity.maxwell,
        mechanisms: elasticity.mechanisms.clone(),
        internal_mechanisms: elasticity.internal_mechanisms,
        polar: directions,
        curve: None,
        derivatives: printed,
    };
    Ok((placed, report))
}

impl Analytic {
    /// The formulas for this honeycomb.
    pub fn from_honeycomb(honeycomb: &Honeycomb, gpa: f64) -> Self {
        Self {
            analytic: AnalyticModuli::new(honeycomb.both(gpa)),
            analytic_hinging: AnalyticModuli::new(honeycomb.hinging(gpa)),
            analytic_stretching: AnalyticModuli::new(honeycomb.stretching(gpa)),
        }
    }
}

impl AnalyticModuli {
    fn new(axial: AxialModuli) -> Self {
        let c_gpa = axial.stiffness_gpa();
        Self { axial, c_gpa }
    }
}

fn print_derivatives(
    energy: &NetworkEnergy,
    configuration: &Configuration,
    d: &Derivatives,
) -> Result<PrintedDerivatives> {
    let n = energy.coordinates();
    anyhow::ensure!(
        n <= MOST_PRINTED_COORDINATES,
        "--derivatives prints the Hessian of at most {MOST_PRINTED_COORDINATES} coordinates, and the network has {n}"
    );
    let mut hessian = vec![vec![0.0; n]; n];
    for (&(row, column), value) in energy.entries().iter().zip(&d.hessian) {
        hessian[row][column] = *value;
        hessian[column][row] = *value;
    }
    Ok(PrintedDerivatives {
        nodes_angstrom: configuration.nodes_angstrom.clone(),
        energy_kcal_mol: d.energy,
        forces_kcal_mol_angstrom: d.gradient.iter().map(|g| 0.0 - g).collect(),
        hessian_kcal_mol_angstrom2: hessian,
        strain_gradient_kcal_mol: d.strain_gradient.clone(),
    })
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut rows = Vec::with_capacity(matrix.nrows());
    for row in matrix.row_iter() {
        rows.push(row.iter().copied().collect());
    }
    rows
}

fn named_moduli(moduli: &Moduli, dimension: usize) -> BTreeMap<String, Option<f64>> {
    let axes = axes(dimension);
    let mut named = BTreeMap::new();
    for (i, first) in axes.iter().enumerate() {
        let youngs = moduli.youngs_gpa.get(i).copied().flatten();
        named.insert(format!("e_{first}_gpa"), youngs);
        let Some(ratios) = moduli.poissons.get(i) else {
            continue;
        };
        for (j, (second, ratio)) in axes.iter().zip(ratios).enumerate() {
            if j != i {
                named.insert(format!("nu_{first}{second}"), *ratio);
            }
        }
    }
    let shears = strain_names(dimension).iter().skip(dimension);
    for (name, shear) in shears.zip(&moduli.shear_gpa) {
        named.insert(format!("g_{name}_gpa"), *shear);
    }
    named
}

impl Report {
    /// Reads the report in a directory.
    ///
    /// # Errors
    /// If it is damaged, or there is none.
    pub fn read(directory: &Path) -> protomer_results::Result<Self> {
        read_json(&directory.join(FILE))
    }

    /// Whether every node is free of forces, up to `REST_FORCE`.
    pub fn at_rest(&self) -> bool {
        self.largest_force_kcal_mol_angstrom <= REST_FORCE
    }

    /// The moduli as rows: name, value and, where formulas exist, their values and the deviation;
    /// the first row is the heading.
    pub fn moduli_rows(&self) -> Vec<Vec<String>> {
        let mut rows = vec![vec!["".to_owned(), "network".to_owned()]];
        if self.analytic.is_some() {
            rows[0].extend(
                ["formula", "deviation", "hinging only", "stretching only"].map(str::to_owned),
            );
        }
        for (key, value) in &self.moduli {
            let mut row = vec![label(key), number(*value)];
            if let Some(analytic) = &self.analytic {
                let formula = field(&analytic.analytic.axial, key);
                let deviation = match (value, formula) {
                    // A formula of zero leaves no ratio.
                    (Some(value), Some(formula)) if formula != 0.0 => {
                        percent(value / formula - 1.0)
                    }
                    _ => "-".into(),
                };
                row.push(number(formula));
                row.push(deviation);
                row.push(number(field(&analytic.analytic_hinging.axial, key)));
                row.push(number(field(&analytic.analytic_stretching.axial, key)));
            }
            rows.push(row);
        }
        rows
    }

    /// The lines above and below the table of moduli.
    pub fn describe(&self) -> [String; 2] {
        [self.describe_network(), self.describe_elasticity()]
    }

    fn describe_network(&self) -> String {
        let thickness = match self.thickness_angstrom {
            Some(thickness) => format!(" (thickness {thickness} Å)"),
            None => String::new(),
        };
        let mut vectors = Vec::new();
        for vector in &self.cell_angstrom {
            vectors.push(format!("({})", fixed(vector, 4)));
        }
        format!(
            "{}: {} nodes, {} rods, {} hinges, {} torsions\ncell: {} Å, volume {:.4} Å³{thickness}\nN_A: {:e} /mol, 1 \
             kcal/mol/Å³ = {:.7} GPa",
            self.network,
            self.nodes,
            self.rods,
            self.hinges,
            self.torsions,
            vectors.join(" "),
            self.volume_angstrom3,
            self.avogadro_per_mol,
            self.gpa_per_kcal_mol_angstrom3
        )
    }

    fn describe_elasticity(&self) -> String {
        let order = self.strain_order.join(", ");
        let m = &self.maxwell;
        let mut mechanisms = Vec::new();
        for mechanism in &self.mechanisms {
            mechanisms.push(format!("({})", fixed(&mechanism.strain, 4)));
        }
        let mechanisms = match mechanisms.as_slice() {
            [] => "none".to_owned(),
            strains => strains.join(" "),
        };
        let internal = match self.internal_mechanisms {
            Some(count) => format!("{count} floppy motions of the nodes at fixed cell"),
            None => "floppy motions of the nodes not counted".into(),
        };
        format!(
            "C with relaxed nodes, GPa ({order}):\n{}\nC with clamped nodes, GPa:\n{}\nMaxwell: {} freedoms, {} springs, \
             excess {:+}\nzero-energy strains ({order}): {mechanisms}; {internal}",
            matrix(&self.c_gpa),
            matrix(&self.c_clamped_gpa),
            m.freedoms,
            m.springs,
            m.excess
        )
    }
}

/// A matrix as lines of numbers.
fn matrix(rows: &[Vec<f64>]) -> String {
    let mut largest = 0.0_f64;
    for value in rows.iter().flatten() {
        largest = largest.max(value.abs());
    }
    let mut lines = Vec::with_capacity(rows.len());
    for row in rows {
        let mut line = String::new();
        for value in row {
            // Show values that are zero up to rounding as zero.
            let is_zero = value.abs() < 1e-9 * largest;
            let shown = if is_zero { 0.0 } else { *value };
            line += &format!("{:>14}", rounded(shown, 4));
        }
        lines.push(line);
    }
    lines.join("\n")
}

/// The moduli among the keys of a report.
fn moduli<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, Option<f64>>, D::Error> {
    let entries = BTreeMap::<String, Value>::deserialize(deserializer)?;
    let is_modulus = |key: &str| ["e_", "g_", "nu_"].iter().any(|name| key.starts_with(name));
    let entries = entries.into_iter().filter(|(key, _)| is_modulus(key));
    Ok(entries.map(|(key, value)| (key, value.as_f64())).collect())
}

/// The modulus under a key of [`Report::moduli`].
pub fn field(moduli: &AxialModuli, key: &str) -> Option<f64> {
    Some(match key {
        "e_y_gpa" => moduli.e_y_gpa,
        "e_z_gpa" => moduli.e_z_gpa,
        "g_yz_gpa" => moduli.g_yz_gpa,
        "nu_yz" => moduli.nu_yz,
        "nu_zy" => moduli.nu_zy,
        _ => return None,
    })
}

/// Label of a key of [`Report::moduli`]: `e_y_gpa` becomes `E_y (GPa)`.
///
/// ```
/// use protomer_linkage_verbs::frameworks::report::label;
/// assert_eq!(["e_y_gpa", "nu_yz"].map(label), ["E_y (GPa)", "ν_yz"]);
/// ```
pub fn label(key: &str) -> String {
    let unit = if key.ends_with("_gpa") { " (GPa)" } else { "" };
    let name = key
        .trim_end_matches("_gpa")
        .replace("nu_", "ν_")
        .replace("e_", "E_")
        .replace("g_", "G_");
    format!("{name}{unit}")
}

fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(value) if value.abs() < 10.0 => rounded(value, 5),
        Some(value) if value.abs() < 1e7 => format!("{value:.3}"),
        // A modulus without a finite value.
        Some(value) if value.abs() > 1e20 => "unlimited".into(),
        Some(value) => format!("{value:.3e}"),
    }
}

fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if percent.abs() < 5e-5 {
        "0 %".into()
    } else {
        format!("{percent:+.4} %")
    }
}
