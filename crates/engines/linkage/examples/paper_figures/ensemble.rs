//! Random lattices of 10 x 10, from the open state with angular velocities U(-1, 1) brought onto
//! the rods, 1000 frames: phase differences (preprint, fig. 4), synchronisation (fig. 5), Poisson's
//! ratio (figs. 6 and 7); energy (paper, fig. 5).

use crate::common::{
    self, FRAME, Failure, LENGTHS, Run, Settings, lattice, map, mean, table, time_step,
};
use protomer_linkage::analysis::strain::{
    biot_strain, centres, corners, deformation_gradient, poisson_ratio,
};
use protomer_linkage::analysis::synchronisation::{
    Synchronisation, angles, eigenvalues, staggered,
};
use protomer_linkage::lattice::{CollisionSettings, Network, Start, StartVelocities};
use std::sync::Arc;

const FRAMES: usize = 1000;
/// Squares that are locked together leave a synchronisation matrix without an inverse; see
/// `Synchronisation::partial`.
const RIDGE: f64 = 1e-10;
/// Of which the matrices themselves are written.
const SHOWN: [f64; 4] = [0.02, 3.0 / 22.0, 0.5, 2.0];

/// What one trajectory shows.
pub struct Record {
    /// Root mean square of the differences of staggered angles, and of angles as they are, per
    /// frame.
    pub differences: Vec<[f64; 2]>,
    /// Of staggered angles and of angles as they are.
    pub synchronisation: [Synchronisation; 2],
    /// Increments of strain, ε_xx and ε_yy, per frame.
    pub strains: Vec<[f64; 2]>,
    /// E / E(0) per frame.
    pub energies: Vec<f64>,
    /// Impacts, and contacts with rods.
    pub impacts: [u64; 2],
    /// Frames before the first impact.
    pub free_frames: usize,
    /// Steps with too many impacts.
    pub capped: u64,
    /// The largest error of a rod and the smallest gap.
    pub exactness: [f64; 2],
    /// Why it ended early, if it did.
    pub ended: Option<String>,
}

/// The start of the papers.
pub fn start(seed: u64) -> Start {
    Start {
        velocities: StartVelocities::Uniform {
            largest: 1.0,
            sum_of_squares: None,
        },
        seed,
        ..Start::default()
    }
}

/// Runs and records one trajectory.
pub fn record(
    network: &Arc<Network>,
    replica: usize,
    frames: usize,
    step: f64,
) -> Result<Record, Failure> {
    let state = start(1).build(network, replica as u32)?.state;
    let energy = state.kinetic_energy(network);
    let mut run = Run::new(
        network,
        Vec::new(),
        state,
        step,
        CollisionSettings::default(),
    )?;
    let squares = network.squares.len();
    let mut record = Record {
        differences: Vec::new(),
        synchronisation: [Synchronisation::new(squares), Synchronisation::new(squares)],
        strains: Vec::new(),
        energies: Vec::new(),
        impacts: [0; 2],
        free_frames: 0,
        capped: 0,
        exactness: [0.0; 2],
        ended: None,
    };
    let points = |positions: &[f64]| {
        let mut points = centres(positions);
        points.extend(corners(network, positions));
        points
    };
    let mut before = points(&run.state.positions);
    for _ in 0..frames {
        if let Err(error) = run.advance(FRAME) {
            record.ended = Some(error.to_string());
            break;
        }
        let both = [
            staggered(network, &run.state.positions),
            angles(&run.state.positions),
        ];
        for (index, phases) in record.synchronisation.iter_mut().zip(&both) {
            index.push(phases)?;
        }
        // Of all pairs of N numbers: 2 N/(N - 1) times their variance.
        let scale = (2.0 * squares as f64 / (squares as f64 - 1.0)).sqrt();
        record
            .differences
            .push(both.map(|phases| scale * common::deviation(&phases)));
        let after = points(&run.state.positions);
        let strain = biot_strain(&deformation_gradient(&before, &after)?);
        record.strains.push([strain[(0, 0)], strain[(1, 1)]]);
        before = after;
        record
            .energies
            .push(run.state.kinetic_energy(network) / energy);
        record.free_frames += usize::from(run.engine.statistics().impacts == 0);
    }
    let statistics = run.engine.statistics();
    record.impacts = [statistics.impacts, statistics.rod_contacts];
    record.capped = statistics.capped_steps;
    record.exactness = [
        statistics.largest_rod_violation,
        statistics.smallest_gap.unwrap_or(f64::NAN),
    ];
    Ok(record)
}

/// Leading eigenvalues of |R| and |P|, of staggered angles and of angles as they are, and the
/// mean |R| and |P| of neighbours and of all others.
pub fn coherence(
    network: &Network,
    records: &[&Record],
    ridge: f64,
) -> Result<[[f64; 6]; 2], Failure> {
    let mut result = [[f64::NAN; 6]; 2];
    for (which, result) in result.iter_mut().enumerate() {
        let mut whole = Synchronisation::new(network.squares.len());
        for record in records {
            whole.merge(&record.synchronisation[which])?;
        }
        for (number, matrix) in [whole.index()?, whole.partial(ridge)?].iter().enumerate() {
            let magnitudes = matrix.map(|x| (x * x.conj()).re.sqrt().into());
            result[number] = eigenvalues(&magnitudes)
                .first()
                .copied()
                .unwrap_or(f64::NAN);
            let (mut near, mut far) = ([0.0, 0.0], [0.0, 0.0]);
            for a in 0..network.squares.len() {
                for b in 0..a {
                    let rows = (a / network.columns).abs_diff(b / network.columns);
                    let columns = (a % network.columns).abs_diff(b % network.columns);
                    let sums = if rows + columns == 1 {
                        &mut near
                    } else {
                        &mut far
                    };
                    sums[0] += magnitudes[(a, b)].re;
                    sums[1] += 1.0;
                }
            }
            result[2 + 2 * number] = near[0] / near[1];
            result[3 + 2 * number] = far[0] / far[1];
        }
    }
    Ok(result)
}

/// As [`coherence`], with jackknife errors over trajectories; then |R| and |P| from half of the
/// trajectories, and with a larger ridge.
pub fn coherence_with_errors(network: &Network, records: &[Record]) -> Result<Vec<f64>, Failure> {
    let all: Vec<&Record> = records.iter().collect();
    let value = coherence(network, &all, RIDGE)?;
    let without = (0..records.len())
        .map(|left| {
            let others: Vec<&Record> = records
                .iter()
                .enumerate()
                .filter(|(k, _)| *k != left)
                .map(|(_, r)| r)
                .collect();
            coherence(network, &others, RIDGE)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let count = records.len() as f64;
    let mut row = Vec::new();
    for (which, values) in value.iter().enumerate() {
        for (place, value) in values.iter().enumerate() {
            let numbers: Vec<f64> = without.iter().map(|others| others[which][place]).collect();
            row.extend([*value, common::deviation(&numbers) * (count - 1.0).sqrt()]);
        }
    }
    // What less data, and another ridge, would say.
    let half = coherence(network, &all[..all.len().div_ceil(2)], RIDGE)?;
    let ridged = coherence(network, &all, 1e-6)?;
    for other in [half, ridged] {
        row.extend([other[0][0], other[0][1], other[0][4], other[0][5]]);
    }
    Ok(row)
}

/// The matrices |R| and |P| of staggered angles, row by row, in thousandths.
pub fn write_matrices(
    settings: &Settings,
    name: &str,
    network: &Network,
    records: &[Record],
) -> Result<(), Failure> {
    let mut whole = Synchronisation::new(network.squares.len());
    for record in records {
        whole.merge(&record.synchronisation[0])?;
    }
    let (index, partial) = (whole.index()?, whole.partial(RIDGE)?);
    // P above the diagonal, R below it.
    let rows: Vec<Vec<f64>> = (0..network.squares.len())
        .map(|a| {
            (0..network.squares.len())
                .map(|b| if b > a { &partial } else { &index }[(a, b)])
                .map(|x| (1e3 * (x * x.conj()).re.sqrt()).round())
                .collect()
        })
        .collect();
    table(
        settings,
        name,
        "# 1000 |R| on and below the diagonal, 1000 |P| above it",
        &rows,
    )
}

/// Head of the columns of [`coherence_with_errors`].
pub const COHERENCE_HEAD: &str = "R_eigenvalue,R_eigenvalue_error,P_eigenvalue,P_eigenvalue_error,R_near,R_near_error,\
    R_far,R_far_error,P_near,P_near_error,P_far,P_far_error,plain_R_eigenvalue,plain_R_eigenvalue_error,\
    plain_P_eigenvalue,plain_P_eigenvalue_error,plain_R_near,plain_R_near_error,plain_R_far,plain_R_far_error,\
    plain_P_near,plain_P_near_error,plain_P_far,plain_P_far_error,half_R_eigenvalue,half_P_eigenvalue,half_P_near,\
    half_P_far,ridge_R_eigenvalue,ridge_P_eigenvalue,ridge_P_near,ridge_P_far";

/// ν and r² of all trajectories of a set together, with errors over trajectories, and of single
/// ones.
pub fn strain_row(records: &[Record]) -> Result<Vec<f64>, Failure> {
    let together: Vec<[f64; 2]> = records
        .iter()
        .flat_map(|record| record.strains.clone())
        .collect();
    let all = poisson_ratio(&together, records.len())?;
    let singles = records
        .iter()
        .map(|record| poisson_ratio(&record.strains, 10))
        .collect::<Result<Vec<_>, _>>()?;
    let column = |quantity: fn(&protomer_linkage::analysis::strain::PoissonRatio) -> f64| {
        singles.iter().map(quantity).collect()
    };
    let (ratios, r_squared): (Vec<f64>, Vec<f64>) = (column(|x| x.xy), column(|x| x.r_squared));
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [r, r_error] = mean(&r_squared);
    Ok(vec![
        all.xy,
        all.xy_error,
        all.r_squared,
        r,
        r_error,
        least,
        largest,
    ])
}

/// Head of the columns of [`strain_row`].
pub const STRAIN_HEAD: &str = "nu_xy,nu_xy_error,r_squared_together,r_squared,r_squared_error,\
    smallest_single,largest_single";

/// Differences per tenth frame: mean over trajectories and its error, staggered and as they are.
pub fn difference_rows(rod_length: f64, records: &[Record]) -> Vec<Vec<f64>> {
    let frames = records
        .iter()
        .map(|record| record.differences.len())
        .min()
        .unwrap_or(0);
    (9..frames)
        .step_by(10)
        .map(|frame| {
            let column = |which: usize| -> Vec<f64> {
                records
                    .iter()
                    .map(|r| r.differences[frame][which])
                    .collect()
            };
            let ([a, a_error], [b, b_error]) = (mean(&column(0)), mean(&column(1)));
            vec![
                rod_length,
                FRAME * (frame + 1) as f64,
                a,
                a_error,
                b,
                b_error,
            ]
        })
        .collect()
}

/// Writes the tables.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let (mut differences, mut coherent, mut strains, mut cloud) = (vec![], vec![], vec![], vec![]);
    let (mut energies, mut runs) = (vec![], vec![]);
    for rod_length in LENGTHS {
        let network = lattice(10, rod_length)?;
        let step = time_step(rod_length);
        let records = map(settings.jobs, settings.random, |replica| {
            record(&network, replica, FRAMES, step)
        })?;
        // The step of the papers, where it works.
        let coarse = map(settings.jobs, settings.random.min(3), |replica| {
            record(&network, replica, FRAMES, FRAME)
        })?;
        for (kind, set) in [(step, &records), (FRAME, &coarse)] {
            for record in set {
                if let Some(reason) = &record.ended {
                    println!(
                        "r0 = {rod_length}, step {kind}: ended at frame {}: {reason}",
                        record.energies.len()
                    );
                }
            }
            let largest = |record: &Record| {
                record
                    .energies
                    .iter()
                    .fold(0.0_f64, |most, e| most.max((e - 1.0).abs()))
            };
            let column = |quantity: &dyn Fn(&Record) -> f64| {
                mean(&set.iter().map(quantity).collect::<Vec<f64>>())
            };
            let [error, error_error] = column(&largest);
            let most = set.iter().map(largest).fold(0.0, f64::max);
            let [last, _] = column(&|r| r.energies.last().map_or(f64::NAN, |e| e - 1.0));
            let [impacts, impacts_error] = column(&|r| r.impacts[0] as f64);
            let [rods, _] = column(&|r| r.impacts[1] as f64);
            let [free, _] = column(&|r| r.free_frames as f64);
            let [frames, _] = column(&|r| r.energies.len() as f64);
            let ended = set.iter().filter(|r| r.ended.is_some()).count() as f64;
            let capped = set.iter().map(|r| r.capped as f64).sum::<f64>();
            let rod_error = set.iter().map(|r| r.exactness[0]).fold(0.0, f64::max);
            let gap = set
                .iter()
                .map(|r| r.exactness[1])
                .fold(f64::INFINITY, f64::min);
            runs.push(vec![
                rod_length,
                kind,
                set.len() as f64,
                frames,
                ended,
                impacts,
                impacts_error,
                rods,
                free,
                capped,
                error,
                error_error,
                most,
                last,
                rod_error,
                gap,
            ]);
            if let Some(record) = set.first() {
                for (frame, energy) in record.energies.iter().enumerate().skip(4).step_by(5) {
                    energies.push(vec![rod_length, kind, FRAME * (frame + 1) as f64, *energy]);
                }
            }
        }
        differences.extend(difference_rows(rod_length, &records));
        let mut row = vec![rod_length];
        row.extend(coherence_with_errors(&network, &records)?);
        coherent.push(row);
        if SHOWN.contains(&rod_length) {
            write_matrices(
                settings,
                &format!("synchronisation_{rod_length:.2}"),
                &network,
                &records,
            )?;
        }
        let mut row = vec![rod_length];
        row.extend(strain_row(&records)?);
        strains.push(row);
        for [x, y] in records
            .iter()
            .flat_map(|record| record.strains.iter().step_by(20))
        {
            cloud.push(vec![rod_length, *x, *y]);
        }
    }
    let head = "r0,time,staggered,staggered_error,plain,plain_error";
    table(settings, "phase_differences", head, &differences)?;
    table(
        settings,
        "synchronisation",
        &format!("r0,{COHERENCE_HEAD}"),
        &coherent,
    )?;
    table(settings, "poisson", &format!("r0,{STRAIN_HEAD}"), &strains)?;
    table(settings, "strains", "r0,xx,yy", &cloud)?;
    table(
        settings,
        "energies",
        "r0,step,time,relative_energy",
        &energies,
    )?;
    let head = "r0,step,trajectories,frames,ended_early,impacts,impacts_error,rod_contacts,frames_before_first_impact,\
                capped_steps,largest_energy_error,largest_energy_error_error,worst_energy_error,final_energy_error,\
                largest_rod_error,smallest_gap";
    table(settings, "runs", head, &runs)
}
