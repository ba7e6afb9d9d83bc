//! Weighted averages over all frames, their errors, and where they cross one half.
//!
//! At another concentration of bodies the same bodies are in a box of another volume V'. Where clusters
//! do not feel each other, each has the whole box to itself, and the weight of a state with n clusters
//! grows as Vⁿ: frames are weighted with (V'/V)ⁿ besides. This is mass action, for all clusters at once.

use super::answer::{ConcentrationCurve, CurvePoint, HalfSaltEstimate};
use super::samples::{Frame, Samples};
use crate::stability::sweep::half_salt::{FractionAt, crossing_molar};
use anyhow::{Context, Result};
use protomer_kernel::statistics::jackknife_error;
use protomer_mc::contributions::{Mean, Reweighted};
use protomer_mc::reweighting::Mixture;

/// Least number of effective frames; with fewer there is no half salt.
pub(super) const FEWEST_EFFECTIVE_FRAMES: f64 = 10.0;

/// A concentration of bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) concentration_molar: f64,
    /// ln(V'/V).
    pub(super) ln_dilution: f64,
}

/// The frames without those of one block, weighted.
struct Weighted<'a> {
    samples: &'a Samples,
    frame_numbers: Vec<usize>,
    mixture: Mixture,
}

/// The averages along a curve.
struct Averages {
    contacts_left: Vec<Reweighted>,
    bound_fraction: Vec<Reweighted>,
}

impl<'a> Weighted<'a> {
    fn new(samples: &'a Samples, without: Option<usize>) -> Result<Self> {
        // `None` leaves out nothing.
        let is_kept = |number: &usize| Some(samples.frames[*number].block) != without;
        let frame_numbers: Vec<usize> = (0..samples.frames.len()).filter(is_kept).collect();
        let (mut energies_kt, mut counts) = (Vec::new(), Vec::new());
        for (salt, salt_molar) in samples.simulated_molar.iter().enumerate() {
            // The energy of every frame at every salt, also where it was not drawn.
            let all = samples.energies_kt(*salt_molar);
            energies_kt.push(frame_numbers.iter().map(|number| all[*number]).collect());
            let of_salt = frame_numbers
                .iter()
                .filter(|number| samples.frames[**number].salt == salt);
            counts.push(of_salt.count());
        }
        let mixture = Mixture::solve(&energies_kt, &counts)
            .context("the frames of the sweep cannot be weighted")?;
        Ok(Self {
            samples,
            frame_numbers,
            mixture,
        })
    }

    fn averages(&self, salts: &[f64], target: Target) -> Averages {
        let (mut contacts_left, mut bound_fraction) = (Vec::new(), Vec::new());
        let values = |value: fn(&Frame) -> f64| -> Vec<f64> {
            let frames = self
                .frame_numbers
                .iter()
                .map(|number| &self.samples.frames[*number]);
            frames.map(value).collect()
        };
        let contacts = values(|frame| frame.contacts_left);
        let bound = values(|frame| frame.bound_fraction);
        let clusters = values(|frame| frame.clusters as f64);
        for salt_molar in salts {
            let all = self.samples.energies_kt(*salt_molar);
            let energies_kt = self.frame_numbers.iter().zip(&clusters);
            let energies_kt: Vec<f64> = energies_kt
                // ln of the weight (V'/V)ⁿ joins the energy: exp(-(U - n ln(V'/V))).
                .map(|(number, clusters)| all[*number] - clusters * target.ln_dilution)
                .collect();
            contacts_left.push(self.mixture.average(&energies_kt, &contacts));
            bound_fraction.push(self.mixture.average(&energies_kt, &bound));
        }
        Averages {
            contacts_left,
            bound_fraction,
        }
    }
}

/// All frames of a sweep with their weights, and the same without each block of them.
pub(super) struct Curves<'a> {
    all: Weighted<'a>,
    without_a_block: Vec<Weighted<'a>>,
}

impl<'a> Curves<'a> {
    pub(super) fn new(samples: &'a Samples) -> Result<Self> {
        let without = |block| Weighted::new(samples, Some(block));
        Ok(Self {
            all: Weighted::new(samples, None)?,
            // The weights are found again without each
            // block: the jackknife must include their error.
            without_a_block: (0..samples.blocks).map(without).collect::<Result<_>>()?,
        })
    }

    /// -ln of the partition function at each simulated salt, kT, that of the first being zero.
    pub(super) fn free_energies_kt(&self) -> Vec<f64> {
        self.all.mixture.free_energies_kt().to_vec()
    }

    /// The curves at one concentration of bodies. Errors come from leaving out one block of frames at
    /// a time (jackknife), with the weights found again.
    pub(super) fn curve(&self, salts: &[f64], target: Target) -> ConcentrationCurve {
        let averages = self.all.averages(salts, target);
        let without = self.without_a_block.iter();
        let left_out: Vec<Averages> = without
            .map(|weighted| weighted.averages(salts, target))
            .collect();
        let mut points = Vec::with_capacity(salts.len());
        for (place, salt_molar) in salts.iter().enumerate() {
            let estimate = |quantity: Quantity| Mean {
                mean: quantity(&averages)[place].mean,
                error: jackknife_error(&mean_at(&left_out, quantity, place)),
            };
            points.push(CurvePoint {
                salt_molar: *salt_molar,
                contacts_left: Some(estimate(CONTACTS))
                    .filter(|contacts| contacts.mean.is_finite()),
                bound_fraction: estimate(BOUND),
                effective_frames: averages.bound_fraction[place].effective_frames,
            });
        }
        ConcentrationCurve {
            concentration_molar: target.concentration_molar,
            half_salt: half_salt(salts, &averages, &left_out, CONTACTS),
            half_bound_salt: half_salt(salts, &averages, &left_out, BOUND),
            points,
        }
    }
}

/// One of the averages along a curve.
type Quantity = fn(&Averages) -> &[Reweighted];
const CONTACTS: Quantity = |averages| &averages.contacts_left;
const BOUND: Quantity = |averages| &averages.bound_fraction;

fn mean_at(left_out: &[Averages], quantity: Quantity, place: usize) -> Vec<f64> {
    let means = left_out
        .iter()
        .map(|averages| quantity(averages)[place].mean);
    means.collect()
}

/// Salt at which a curve crosses one half; `None` if it does not, or rests on too few frames there.
fn half_salt(
    salts: &[f64],
    averages: &Averages,
    left_out: &[Averages],
    quantity: Quantity,
) -> Option<HalfSaltEstimate> {
    let crossing = |averages: &Averages| {
        let points = salts.iter().zip(quantity(averages));
        let points: Vec<FractionAt> = points
            .map(|(salt_molar, average)| FractionAt {
                salt_molar: *salt_molar,
                fraction: average.mean,
                error: 0.0,
            })
            .collect();
        crossing_molar(&points)
    };
    let salt_molar = crossing(averages)?;
    let above = salts.iter().position(|salt| *salt >= salt_molar)?;
    // The two salts between which the curve crosses; frames at others do not carry it.
    let neighbours = &quantity(averages)[above.saturating_sub(1)..=above];
    let fewest = neighbours.iter().map(|average| average.effective_frames);
    let effective_frames = fewest.fold(f64::INFINITY, f64::min);
    if effective_frames < FEWEST_EFFECTIVE_FRAMES {
        return None;
    }
    // All or none: a curve without a crossing would make the error too small.
    let logarithms: Option<Vec<f64>> = left_out
        .iter()
        .map(|averages| crossing(averages).map(f64::ln))
        .collect();
    let error = logarithms.and_then(|logarithms| jackknife_error(&logarithms));
    Some(HalfSaltEstimate {
        salt_molar,
        // 95 %, in the logarithm of the salt.
        interval_molar: error.map(|error| [-1.96, 1.96].map(|z| salt_molar * (z * error).exp())),
        effective_frames,
    })
}
