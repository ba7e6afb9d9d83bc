//! Loads, and their work on the cell.

use super::configuration::{Configuration, strain_axes};
use super::model::Framework;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

protomer_kernel::choices! {
    /// Kind of stress, by the area to which it is referred.
    pub enum StressKind {
        /// Force per undeformed area (first Piola-Kirchhoff).
        Nominal = "nominal",
        /// Force per deformed area.
        Cauchy = "cauchy",
    }
}

/// A tension along an axis, and nothing across it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Index of the axis: y, z or x, y, z.
    pub axis: usize,
    /// Tension, kcal/mol/Å³; negative for compression.
    pub stress_kcal_mol_angstrom3: f64,
    /// Kind of stress.
    pub kind: StressKind,
}

/// The load over strains, kcal/mol.
pub(super) struct CellWork {
    /// w.
    pub work: Vec<f64>,
    /// ∂w/∂ε.
    pub slope: DMatrix<f64>,
}

pub(super) fn cell_work(
    framework: &Framework,
    configuration: &Configuration,
    built: &Configuration,
    load: Option<Load>,
) -> CellWork {
    let strains = framework.strains();
    let mut none = CellWork {
        work: vec![0.0; strains],
        slope: DMatrix::zeros(strains, strains),
    };
    match load {
        None => none,
        Some(load) if load.kind == StressKind::Nominal => {
            none.work = nominal_work(framework, configuration, built, load);
            none
        }
        Some(load) => {
            let work =
                configuration.place(framework).volume_angstrom3() * load.stress_kcal_mol_angstrom3;
            none.work[load.axis] = work;
            for other in 0..framework.dimension() {
                none.slope[(load.axis, other)] = work;
            }
            none
        }
    }
}

/// F = 1 + ε applied to the axis as it is: w = V0 P λ (e e), which changes with ε only through λ.
fn nominal_work(
    framework: &Framework,
    configuration: &Configuration,
    built: &Configuration,
    load: Load,
) -> Vec<f64> {
    let (dimension, axis) = (framework.dimension(), load.axis);
    let volume = built.place(framework).volume_angstrom3();
    let force = volume * load.stress_kcal_mol_angstrom3;
    let built_length = built.cell_angstrom[axis][axis];
    let mut work = vec![0.0; framework.strains()];
    work[axis] = force * configuration.cell_angstrom[axis][axis] / built_length;
    // A shear that turns the axis sees the same force, by half.
    for (index, value) in work.iter_mut().enumerate().skip(dimension) {
        let (i, j) = strain_axes(dimension, index);
        if i == axis || j == axis {
            let other = if i == axis { j } else { i };
            let tilt = configuration.cell_angstrom[axis][other] / built_length;
            *value = 0.5 * force * tilt;
        }
    }
    work
}
