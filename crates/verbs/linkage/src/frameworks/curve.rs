//! A network under increasing loads along one axis.

use super::answer::LoadSettings;
use super::axes;
use super::text::rounded;
use anyhow::{Result, bail};
use protomer_common::range::Range;
use protomer_io::csv::{Cell, Table};
use protomer_linkage::framework::load::{Loaded, stretch_curve};
use protomer_linkage::framework::{Framework, Load, StressKind};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Range of stresses, far beyond what any network bears.
const STRESS: Range = Range::new(-1e6, 1e6, "GPa");

/// Equilibria of a film, at least.
const FRAMES: usize = 12;
/// Larger networks are not filmed.
const MOST_FILMED_RODS: usize = 4000;

/// Strain against stress.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// The axis along which the load pulls.
    pub axis: String,
    /// The reference area of the requested stresses.
    pub stress_kind: StressKind,
    /// Points of the curve, one per stress.
    pub points: Vec<CurvePoint>,
}

/// The equilibrium of the network under one stress.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Nominal stress: force per undeformed area, GPa.
    pub nominal_gpa: f64,
    /// Cauchy stress: force per deformed area, GPa.
    pub cauchy_gpa: f64,
    /// Strains `strain_y`, ...: the relative changes of length.
    #[serde(flatten, deserialize_with = "strains")]
    pub strains: BTreeMap<String, f64>,
    /// Poisson's ratios `nu_yz`, ...: minus the ratio of transverse to axial strain, both finite.
    #[serde(flatten, deserialize_with = "ratios")]
    pub ratios: BTreeMap<String, f64>,
    /// Energy of the cell, kcal/mol.
    pub energy_kcal_mol: f64,
    /// Volume of the cell, Å³.
    pub volume_angstrom3: f64,
    /// Cell vectors, Å.
    pub cell_angstrom: Vec<Vec<f64>>,
    /// Number of Newton steps.
    pub steps: usize,
    /// Largest residual force component on a node, kcal/mol/Å.
    pub largest_force_kcal_mol_angstrom: f64,
}

/// The strains among the keys of a point.
fn strains<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, f64>, D::Error> {
    named(deserializer, "strain_")
}

/// Poisson's ratios among the keys of a point.
fn ratios<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, f64>, D::Error> {
    named(deserializer, "nu_")
}

/// The numbers whose names begin like this.
fn named<'de, D: Deserializer<'de>>(
    deserializer: D,
    beginning: &str,
) -> Result<BTreeMap<String, f64>, D::Error> {
    let entries = BTreeMap::<String, Value>::deserialize(deserializer)?;
    let entries = entries
        .into_iter()
        .filter(|(key, _)| key.starts_with(beginning));
    let number = |value: Value| value.as_f64().unwrap_or(f64::NAN);
    Ok(entries.map(|(key, value)| (key, number(value))).collect())
}

/// Stresses in GPa from a list such as `1GPa,2GPa,-500MPa`; a bare number is in GPa.
///
/// # Errors
/// Names the item that cannot be parsed.
///
/// ```
/// assert_eq!(protomer_linkage_verbs::frameworks::curve::stresses_gpa("1GPa, -500MPa,2")?, vec![1.0, -0.5, 2.0]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn stresses_gpa(text: &str) -> Result<Vec<f64>> {
    let one = |item: &str| -> Result<f64> {
        let item = item.trim();
        // Divided, not multiplied by 0.001, so that 500 MPa is exactly 0.5 GPa.
        let (number, divisor) = match (item.strip_suffix("MPa"), item.strip_suffix("GPa")) {
            (Some(number), _) => (number, 1000.0),
            (_, Some(number)) => (number, 1.0),
            _ => (item, 1.0),
        };
        match number.trim().parse::<f64>() {
            Ok(value) => {
                let gpa = value / divisor;
                STRESS.require("a stress in --stress", gpa)?;
                Ok(gpa)
            }
            Err(_) => bail!("'{item}' is not a stress; write a list like 1GPa,2GPa or -500MPa"),
        }
    };
    text.split(',').map(one).collect()
}

/// Loads a network step by step; returns the curve and the network under the last load.
///
/// # Errors
/// If the network has no such axis, or no equilibrium under a load.
pub fn load(
    network: &Framework,
    axis: &str,
    stresses_gpa: &[f64],
    kind: StressKind,
    gpa: f64,
) -> Result<(Curve, Framework)> {
    let names = axes(network.dimension());
    let Some(index) = names.iter().position(|name| *name == axis) else {
        bail!(
            "--load is {axis}; the network has the axes {}",
            names.join(", ")
        );
    };
    let mut loads = Vec::with_capacity(stresses_gpa.len());
    for stress in stresses_gpa {
        loads.push(Load {
            axis: index,
            stress_kcal_mol_angstrom3: stress / gpa,
            kind,
        });
    }
    // The loads in the order given: each begins at the equilibrium of the one before.
    let loaded = stretch_curve(network, &loads)?;
    let mut points = Vec::with_capacity(loaded.len());
    for (equilibrium, stress) in loaded.iter().zip(stresses_gpa) {
        points.push(point(network, equilibrium, index, *stress, kind));
    }
    // Without a load the network stays as it is.
    let last = match loaded.last() {
        Some(equilibrium) => equilibrium.configuration.place(network),
        None => network.clone(),
    };
    let curve = Curve {
        axis: names[index].to_owned(),
        stress_kind: kind,
        points,
    };
    Ok((curve, last))
}

/// The network without a load, and on the way to each stress of a load one after another, for a film;
/// nothing for large networks.
///
/// # Errors
/// As [`load`].
pub fn states(network: &Framework, settings: &LoadSettings, gpa: f64) -> Result<Vec<Framework>> {
    let names = axes(network.dimension());
    let Some(axis) = names.iter().position(|name| *name == settings.axis) else {
        return Ok(Vec::new());
    };
    if network.rods.len() > MOST_FILMED_RODS {
        return Ok(Vec::new());
    }
    let parts = FRAMES.div_ceil(settings.stresses_gpa.len().max(1));
    let (mut loads, mut before) = (Vec::new(), 0.0);
    for stress in &settings.stresses_gpa {
        for part in 1..=parts {
            let now = before + (stress - before) * part as f64 / parts as f64;
            loads.push(Load {
                axis,
                stress_kcal_mol_angstrom3: now / gpa,
                kind: settings.kind,
            });
        }
        before = *stress;
    }
    let mut states = vec![network.clone()];
    for equilibrium in stretch_curve(network, &loads)? {
        states.push(equilibrium.configuration.place(network));
    }
    Ok(states)
}

fn point(
    network: &Framework,
    equilibrium: &Loaded,
    axis: usize,
    stress_gpa: f64,
    kind: StressKind,
) -> CurvePoint {
    let placed = equilibrium.configuration.place(network);
    let names = axes(network.dimension());
    // P A0 = σ A, with A = V/(length along the load).
    let area =
        placed.volume_angstrom3() / network.volume_angstrom3() / (1.0 + equilibrium.stretch[axis]);
    let (nominal_gpa, cauchy_gpa) = match kind {
        StressKind::Nominal => (stress_gpa, stress_gpa / area),
        StressKind::Cauchy => (stress_gpa * area, stress_gpa),
    };
    let (mut strains, mut ratios) = (BTreeMap::new(), BTreeMap::new());
    for (index, (name, strain)) in names.iter().zip(&equilibrium.stretch).enumerate() {
        strains.insert(format!("strain_{name}"), *strain);
        if index != axis {
            // Both finite, not rates: ν = -ε_transverse / ε_axial.
            let ratio = -strain / equilibrium.stretch[axis];
            ratios.insert(format!("nu_{}{name}", names[axis]), ratio);
        }
    }
    CurvePoint {
        nominal_gpa,
        cauchy_gpa,
        strains,
        ratios,
        energy_kcal_mol: equilibrium.energy_kcal_mol,
        volume_angstrom3: placed.volume_angstrom3(),
        cell_angstrom: placed.cell_angstrom,
        steps: equilibrium.steps,
        largest_force_kcal_mol_angstrom: equilibrium.largest_force_kcal_mol_angstrom,
    }
}

impl Curve {
    /// The curve as a table: the two stresses, strains, ratios, energy and volume.
    ///
    /// # Errors
    /// Never for the rows built here, which all have the same length.
    pub fn table(&self) -> Result<Table> {
        let mut columns = vec!["nominal_gpa".to_owned(), "cauchy_gpa".to_owned()];
        if let Some(point) = self.points.first() {
            columns.extend(point.strains.keys().cloned());
            columns.extend(point.ratios.keys().cloned());
        }
        columns.extend(["energy_kcal_mol", "volume_angstrom3"].map(str::to_owned));
        let mut table = Table::new(columns);
        for point in &self.points {
            let mut row = vec![point.nominal_gpa, point.cauchy_gpa];
            row.extend(point.strains.values());
            row.extend(point.ratios.values());
            row.extend([point.energy_kcal_mol, point.volume_angstrom3]);
            table.push(row.into_iter().map(Cell::from))?;
        }
        Ok(table)
    }

    /// Formatted rows, the heading first.
    pub fn rows(&self) -> Result<Vec<Vec<String>>> {
        let table = self.table()?;
        let mut rows = vec![table.columns().to_vec()];
        for cells in table.rows() {
            let mut row = Vec::with_capacity(cells.len());
            for cell in cells {
                row.push(match cell {
                    Cell::Number(value) => rounded(*value, 5),
                    _ => String::new(),
                });
            }
            rows.push(row);
        }
        Ok(rows)
    }
}
