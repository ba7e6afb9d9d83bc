//! The loss: cross entropy.

use crate::{LearnError, Result};
use candle_core::{D, Tensor};

/// The logarithms of the softmax of each row: x - log Σ exp x, with the largest of the row taken
/// off first.
///
/// # Errors
/// [`LearnError::Tensor`] if the tensor operations fail.
pub fn log_softmax(logits: &Tensor) -> Result<Tensor> {
    let shifted = logits.broadcast_sub(&logits.detach().max_keepdim(D::Minus1)?)?;
    Ok(shifted.broadcast_sub(&shifted.exp()?.sum_keepdim(D::Minus1)?.log()?)?)
}

/// Weighted mean of the cross entropies, nats: -Σ_i w_i log p_i\[label_i\] / Σ_i w_i, a scalar
/// tensor.
///
/// `logits` is (B, classes); `labels` and `weights` hold one number per sample.
///
/// # Errors
/// [`LearnError::Settings`] if the lengths differ, a label is no class, or the weights do not sum
/// to more than 0.
pub fn cross_entropy(logits: &Tensor, labels: &[u32], weights: &[f32]) -> Result<Tensor> {
    let (samples, classes) = logits.dims2()?;
    let total: f32 = weights.iter().sum();
    if labels.len() != samples || weights.len() != samples {
        return Err(LearnError::Settings(format!(
            "{samples} rows of logits, {} labels and {} weights: give one of each per sample",
            labels.len(),
            weights.len()
        )));
    }
    if let Some(label) = labels.iter().find(|label| **label as usize >= classes) {
        return Err(LearnError::Settings(format!(
            "label {label} among {classes} classes: labels count from 0"
        )));
    }
    if !(total > 0.0 && total.is_finite()) || weights.iter().any(|weight| *weight < 0.0) {
        return Err(LearnError::Settings(format!(
            "the weights of the samples sum to {total}: they must not be negative nor all 0"
        )));
    }
    let device = logits.device();
    let labels = Tensor::from_slice(labels, (samples, 1), device)?;
    let shares: Vec<f32> = weights.iter().map(|weight| weight / total).collect();
    let chosen = log_softmax(logits)?.gather(&labels, 1)?.squeeze(1)?;
    Ok((chosen * Tensor::new(shares, device)?)?.sum_all()?.neg()?)
}

/// Logits with `strength` times the logarithms of the classes' shares added (Menon et al., ICLR
/// 2021): trained through this, the plain logits favour rare classes as if all classes were equally
/// common.
///
/// # Errors
/// [`LearnError::Settings`] if there is not one share per class.
pub fn adjust_logits(logits: &Tensor, log_prior: &[f32], strength: f64) -> Result<Tensor> {
    let (_, classes) = logits.dims2()?;
    if log_prior.len() != classes {
        return Err(LearnError::Settings(format!(
            "{} shares for {classes} classes: give one each",
            log_prior.len()
        )));
    }
    let shift = (Tensor::new(log_prior, logits.device())? * strength)?;
    Ok(logits.broadcast_add(&shift)?)
}
