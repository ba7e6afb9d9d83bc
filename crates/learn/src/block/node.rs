//! The convolution as a node of the graph: forward, and backward sample by sample.

use super::convolution::Convolution;
use super::gradients::{Sample, ThreeGradients};
use crate::numbers::{Numbers, contiguous, of_sample};
use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, bail};

impl CustomOp3 for Convolution {
    fn name(&self) -> &'static str {
        "convolution-bias-relu-pool"
    }

    fn cpu_fwd(
        &self,
        input: &CpuStorage,
        input_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        bias: &CpuStorage,
        bias_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let input = contiguous(input, input_layout)?;
        let weight = contiguous(weight, weight_layout)?;
        let bias = contiguous(bias, bias_layout)?;
        let (out, kept) = self.forward(input, weight, bias);
        if self.tracked && self.kept.set(kept).is_err() {
            bail!("a node of the graph was run twice");
        }
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let [depth, height, width] = self.out_edges();
        let shape = Shape::from((samples, self.geometry.outputs, depth, height, width));
        Ok((CpuStorage::F32(out), shape))
    }

    fn bwd(
        &self,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        result: &Tensor,
        gradient: &Tensor,
    ) -> Result<ThreeGradients> {
        let Some(kept) = self.kept.get() else {
            bail!("a gradient was asked for, but nothing was tracked")
        };
        let gradient = gradient.contiguous()?;
        let (gradient, result) = (Numbers::of(&gradient), Numbers::of(result));
        let (gradient, result) = (gradient.slice()?, result.slice()?);
        let to = self.out_length();
        self.gradients(input, weight, bias, |i, input, weights, input_gradient| {
            let kept = kept.get(i);
            let sample = Sample {
                input,
                result: of_sample(result, i, to),
                gradient: of_sample(gradient, i, to),
                codes: kept.map_or(&[], |kept| &kept.codes),
                occupied: kept.and_then(|kept| kept.occupied.as_ref()),
            };
            self.backward(sample, weights, input_gradient)
        })
    }
}
