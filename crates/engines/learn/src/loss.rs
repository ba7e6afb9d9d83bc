//! The loss: cross entropy.

use crate::Result;
use crate::error::refuse;
use candle_core::{D, Tensor};

/// The logarithms of the softmax of each row: x - log Σ exp x, with the largest of the row taken
/// off first.
fn log_softmax(logits: &Tensor) -> Result<Tensor> {
    let shifted = logits.broadcast_sub(&logits.detach().max_keepdim(D::Minus1)?)?;
    Ok(shifted.broadcast_sub(&shifted.exp()?.sum_keepdim(D::Minus1)?.log()?)?)
}

/// Weighted mean of the cross entropies, nats: -Σ_i w_i log p_i\[label_i\] / Σ_i w_i, a scalar
/// tensor.
///
/// `logits` is (B, classes); `labels` and `weights` hold one number per sample.
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::cross_entropy;
///
/// let undecided = Tensor::new(&[[0f32, 0.0], [0.0, 0.0]], &Device::Cpu)?;
/// let loss = cross_entropy(&undecided, &[0, 1], &[1.0, 1.0])?;
/// assert_eq!(loss.to_scalar::<f32>()?, 2f32.ln());
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if the lengths differ, a label is not a
/// class, or the weights do not sum to more than 0.
pub fn cross_entropy(logits: &Tensor, labels: &[u32], weights: &[f32]) -> Result<Tensor> {
    let (samples, classes) = logits.dims2()?;
    if labels.len() != samples || weights.len() != samples {
        return refuse(format!(
            "{samples} rows of logits, {} labels and {} weights: give one of each per sample",
            labels.len(),
            weights.len()
        ));
    }
    if let Some(label) = labels.iter().find(|label| **label as usize >= classes) {
        return refuse(format!(
            "label {label} among {classes} classes: labels count from 0"
        ));
    }
    let total: f32 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) || weights.iter().any(|weight| *weight < 0.0) {
        return refuse(format!(
            "the weights of the samples sum to {total}: none may be negative, nor all be 0"
        ));
    }
    let device = logits.device();
    let labels = Tensor::from_slice(labels, (samples, 1), device)?;
    let shares: Vec<f32> = weights.iter().map(|weight| weight / total).collect();
    let chosen = log_softmax(logits)?.gather(&labels, 1)?.squeeze(1)?;
    Ok((chosen * Tensor::new(shares, device)?)?.sum_all()?.neg()?)
}

/// Logits with `strength` times the logarithms of the classes' shares added (Menon et al., ICLR
/// 2021). A network trained through this has plain logits that treat all classes as equally common.
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if there is not one share per class.
pub(crate) fn adjust_logits(logits: &Tensor, log_prior: &[f32], strength: f64) -> Result<Tensor> {
    let (_, classes) = logits.dims2()?;
    let given = log_prior.len();
    if given != classes {
        return refuse(format!(
            "{given} shares for {classes} classes: give one each"
        ));
    }
    let shift = (Tensor::new(log_prior, logits.device())? * strength)?;
    Ok(logits.broadcast_add(&shift)?)
}
