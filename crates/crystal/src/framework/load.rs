//! Networks under load: the minimum of energy less work.
//!
//! Nodes x and strain ε are found together by Newton's method with the Hessian of
//! [`energy`](super::energy),
//!
//! (K_xx K_xε; K_xεᵀ K_εε - ∂w/∂ε) (δx; δε) = -(g_x; g_ε - w),
//!
//! shifted towards steepest descent while it is not positive (Levenberg and Marquardt) and applied
//! to the cell as it then is. w is the load on the cell: V0 Pᵀ F for a nominal stress P (force per
//! area of the unloaded cell), V σ for a Cauchy stress σ (force per area as loaded). Under tens of
//! GPa the two differ by some per cent, so the kind is always named.

use super::energy::{Configuration, Derivatives, NetworkEnergy, strain_axes};
use super::model::Framework;
use crate::{CrystalError, Result};
use nalgebra::{DMatrix, DVector};
use protomer_kernel::sparse::LdlFactor;
use serde::{Deserialize, Serialize};

/// Newton steps after which a minimisation gives up.
const MOST_STEPS: usize = 500;
/// Largest strain and largest displacement (in cell edges) of one step.
const LONGEST_STEP: f64 = 0.05;

/// What a stress is referred to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StressKind {
    /// Force per area before loading (first Piola-Kirchhoff).
    Nominal,
    /// Force per area under load.
    Cauchy,
}

/// A tension along an axis, and nothing across it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Index of the axis: y, z or x, y, z.
    pub axis: usize,
    /// Tension, kcal/mol/Å³; negative for compression.
    pub stress_kcal_mol_angstrom3: f64,
    /// What it is referred to.
    pub kind: StressKind,
}

/// A network at rest under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// Where it is.
    pub configuration: Configuration,
    /// Lengths of the cell along the axes over those at the start, less one: engineering strains of
    /// stretch.
    pub stretch: Vec<f64>,
    /// Energy, kcal/mol.
    pub energy_kcal_mol: f64,
    /// Newton steps made.
    pub steps: usize,
    /// Largest force left on a node, kcal/mol/Å.
    pub largest_force_kcal_mol_angstrom: f64,
}

/// The minimum of a network's energy from where it stands: at fixed cell, or with the cell free and
/// under a load.
///
/// # Errors
/// As [`Framework::check`]; [`CrystalError::NoMinimum`] if the minimum is not reached: a load that
/// the network cannot bear, or a mechanism that it drives without end.
pub fn minimise(framework: &Framework, free_cell: bool, load: Option<Load>) -> Result<Loaded> {
    let energy = NetworkEnergy::new(framework)?;
    minimise_from(
        framework,
        &energy,
        Configuration::built(framework),
        free_cell,
        load,
    )
}

/// The curve of a network under a growing load: each minimisation starts from the one before.
///
/// # Errors
/// As [`minimise`].
pub fn stretch_curve(framework: &Framework, loads: &[Load]) -> Result<Vec<Loaded>> {
    let energy = NetworkEnergy::new(framework)?;
    let mut curve: Vec<Loaded> = Vec::new();
    for load in loads {
        let start = curve.last().map_or_else(
            || Configuration::built(framework),
            |last| last.configuration.clone(),
        );
        curve.push(minimise_from(framework, &energy, start, true, Some(*load))?);
    }
    Ok(curve)
}

fn minimise_from(
    framework: &Framework,
    energy: &NetworkEnergy,
    mut at: Configuration,
    free_cell: bool,
    load: Option<Load>,
) -> Result<Loaded> {
    let dimension = energy.dimension();
    if let Some(load) =
        load.filter(|load| load.axis >= dimension || !load.stress_kcal_mol_angstrom3.is_finite())
    {
        return Err(CrystalError::BadNetwork(format!(
            "a load of {load:?} on {dimension} dimensions makes no sense"
        )));
    }
    let built = Configuration::built(framework);
    let mut factor = newton_factor(energy, &at);
    let mut shift = 0.0;
    for steps in 0..MOST_STEPS {
        let d = energy.derivatives(&at);
        let scale = d.hessian.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let (work, work_slope) = cell_work(framework, &at, &built, load);
        let strain_force: Vec<f64> = d
            .strain_gradient
            .iter()
            .zip(&work)
            .map(|(g, w)| g - w)
            .collect();
        let edge = at.cell_angstrom[0]
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt();
        let force = d.gradient.iter().fold(0.0_f64, |most, g| most.max(g.abs()));
        let stress = if free_cell {
            strain_force
                .iter()
                .fold(0.0_f64, |most, g| most.max(g.abs()))
        } else {
            0.0
        };
        // At rest where what is left is rounding.
        if force <= 1e-12 * scale * edge && stress <= 1e-12 * scale * edge * edge {
            let lengths = |c: &Configuration| -> Vec<f64> {
                (0..dimension).map(|i| c.cell_angstrom[i][i]).collect()
            };
            let stretch = lengths(&at)
                .iter()
                .zip(lengths(&built))
                .map(|(now, before)| now / before - 1.0)
                .collect();
            return Ok(Loaded {
                configuration: at,
                stretch,
                energy_kcal_mol: d.energy,
                steps,
                largest_force_kcal_mol_angstrom: force,
            });
        }
        let strain_force = if free_cell {
            strain_force
        } else {
            vec![0.0; strain_force.len()]
        };
        let objective = |residual: &Derivatives, work: &[f64]| -> f64 {
            let nodes: f64 = residual.gradient.iter().map(|g| g * g).sum();
            let cell: f64 = residual
                .strain_gradient
                .iter()
                .zip(work)
                .map(|(g, w)| (g - w) * (g - w))
                .sum();
            nodes + if free_cell { cell / (edge * edge) } else { 0.0 }
        };
        let now = objective(&d, &work);
        // Shift until the matrix is positive and the step goes down.
        loop {
            let step = newton_step(
                energy,
                &mut factor,
                &d,
                &work_slope,
                &strain_force,
                free_cell,
                shift * scale,
            );
            let accepted = step.and_then(|(dx, de)| {
                let long = dx.amax().max(edge * de.amax()) / (LONGEST_STEP * edge);
                let limit = if long > 1.0 { 1.0 / long } else { 1.0 };
                let mut trial = at.clone();
                trial
                    .nodes_angstrom
                    .iter_mut()
                    .zip(dx.iter())
                    .for_each(|(x, step)| *x += limit * step);
                if free_cell {
                    trial.strain(dimension, (de * limit).as_slice());
                }
                let next = energy.derivatives(&trial);
                let (work, _) = cell_work(framework, &trial, &built, load);
                let then = objective(&next, &work);
                // Far from the minimum forces may grow on the way; a drop in energy is as good for
                // nodes alone.
                (then < now || (load.is_none() && next.energy < d.energy)).then_some(trial)
            });
            match accepted {
                Some(trial) => {
                    at = trial;
                    shift = if shift < 1e-9 { 0.0 } else { 0.2 * shift };
                    break;
                }
                None if shift > 1e6 => {
                    return Err(CrystalError::NoMinimum(format!(
                        "no minimum is found: a force of {force:.2e} kcal/mol/Å and {stress:.2e} kcal/mol on the cell remain; \
                         load the network in smaller steps, or see whether a mechanism gives way"
                    )));
                }
                None => shift = if shift == 0.0 { 1e-9 } else { 10.0 * shift },
            }
        }
    }
    Err(CrystalError::NoMinimum(format!(
        "no minimum is found in {MOST_STEPS} steps; load the network in smaller steps, or see whether a mechanism gives way"
    )))
}

fn newton_factor(energy: &NetworkEnergy, at: &Configuration) -> LdlFactor {
    let dimension = energy.dimension();
    let places: Vec<[f64; 3]> = (0..energy.coordinates())
        .map(|row| {
            let node = row / dimension * dimension;
            std::array::from_fn(|i| {
                if i < dimension {
                    at.nodes_angstrom[node + i]
                } else {
                    0.0
                }
            })
        })
        .collect();
    LdlFactor::new(energy.coordinates(), energy.entries(), &places)
}

/// δx and δε; `None` if the shifted matrix is not positive.
fn newton_step(
    energy: &NetworkEnergy,
    factor: &mut LdlFactor,
    d: &Derivatives,
    work_slope: &DMatrix<f64>,
    strain_force: &[f64],
    free_cell: bool,
    shift: f64,
) -> Option<(DVector<f64>, DVector<f64>)> {
    let largest = d.hessian.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // Translations cost nothing: a little shift is always there, and the forces do no work on them.
    let shift = shift + 1e-10 * largest;
    let shifted: Vec<f64> = energy
        .entries()
        .iter()
        .zip(&d.hessian)
        .map(|((i, j), x)| if i == j { x + shift } else { *x })
        .collect();
    factor.factor(&shifted).ok()?;
    let mut base: Vec<f64> = d.gradient.iter().map(|g| -g).collect();
    factor.solve(&mut base);
    let mut dx = DVector::from_vec(base);
    let strains = strain_force.len();
    let mut de = DVector::zeros(strains);
    if free_cell {
        let mut response = d.mixed.clone();
        for mut column in response.column_iter_mut() {
            let mut b = column.as_slice().to_vec();
            factor.solve(&mut b);
            column.copy_from_slice(&b);
        }
        // Schur complement for the strains.
        let volume_shift = shift * d.strain_hessian.amax() / largest.max(f64::MIN_POSITIVE);
        let schur = &d.strain_hessian - work_slope - d.mixed.transpose() * &response
            + DMatrix::identity(strains, strains) * volume_shift;
        let right = -DVector::from_column_slice(strain_force) - d.mixed.transpose() * &dx;
        de = schur.lu().solve(&right)?;
        dx -= response * &de;
    }
    (dx.iter().all(|x| x.is_finite()) && de.iter().all(|x| x.is_finite())).then_some((dx, de))
}

/// w and ∂w/∂ε.
fn cell_work(
    framework: &Framework,
    at: &Configuration,
    built: &Configuration,
    load: Option<Load>,
) -> (Vec<f64>, DMatrix<f64>) {
    let (dimension, strains) = (framework.dimension(), framework.strains());
    let (mut work, mut slope) = (vec![0.0; strains], DMatrix::zeros(strains, strains));
    let Some(load) = load else {
        return (work, slope);
    };
    let axis = load.axis;
    let now = at.place(framework).volume_angstrom3();
    match load.kind {
        // F = 1 + ε applied to the axis as it is: w = V0 P λ (e e), which does not change with ε
        // but through λ.
        StressKind::Nominal => {
            let along = |c: &Configuration| c.cell_angstrom[axis][axis];
            let stretched = built.place(framework).volume_angstrom3()
                * load.stress_kcal_mol_angstrom3
                * along(at)
                / along(built);
            work[axis] = stretched;
            // The shear that turns the axis sees the same force, by half.
            for (index, value) in work.iter_mut().enumerate().skip(dimension) {
                let (i, j) = strain_axes(dimension, index);
                let other = if i == axis { j } else { i };
                if i == axis || j == axis {
                    let tilt = at.cell_angstrom[axis][other] / along(built);
                    *value = 0.5
                        * built.place(framework).volume_angstrom3()
                        * load.stress_kcal_mol_angstrom3
                        * tilt;
                }
            }
        }
        StressKind::Cauchy => {
            work[axis] = now * load.stress_kcal_mol_angstrom3;
            for other in 0..dimension {
                slope[(axis, other)] = now * load.stress_kcal_mol_angstrom3;
            }
        }
    }
    (work, slope)
}
