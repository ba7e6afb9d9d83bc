//! The numbers of tensors on the processor, and sums of many of them.

use candle_core::{CpuStorage, Error, Layout, Result, Storage, Tensor};
use std::sync::RwLockReadGuard;

/// The numbers of a tensor, held for reading.
pub(crate) struct Numbers<'a> {
    storage: RwLockReadGuard<'a, Storage>,
    layout: &'a Layout,
}

impl<'a> Numbers<'a> {
    pub(crate) fn from_tensor(tensor: &'a Tensor) -> Self {
        let (storage, layout) = tensor.storage_and_layout();
        Self { storage, layout }
    }

    /// # Errors
    /// If they are not contiguous f32 on the processor.
    pub(crate) fn slice(&self) -> Result<&[f32]> {
        match &*self.storage {
            Storage::Cpu(storage) => contiguous(storage, self.layout),
            _ => Err(wrong_storage()),
        }
    }
}

/// The numbers of a contiguous layout.
///
/// # Errors
/// If it is not contiguous, or not f32.
pub(crate) fn contiguous<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    let (start, end) = layout.contiguous_offsets().ok_or_else(wrong_storage)?;
    let numbers = storage.as_slice::<f32>()?;
    numbers.get(start..end).ok_or_else(wrong_storage)
}

/// An error of the tensor library for storage of the wrong kind.
pub(crate) fn wrong_storage() -> Error {
    Error::Msg("grids on the processor must be contiguous f32".into())
}

/// Values of one sample, where each sample has `length` of them.
pub(crate) fn of_sample<T>(all: &[T], sample: usize, length: usize) -> &[T] {
    all.get(sample * length..(sample + 1) * length)
        .unwrap_or_default()
}

/// The sum in f32: 32 partial sums, then the rest one by one. The order is fixed, so the result
/// does not depend on the processor.
pub(crate) fn sum_in_lanes(numbers: &[f32], term: impl Fn(f32) -> f32) -> f32 {
    // Thirty-two sums that do not wait for each other fill the vector units on
    // every processor; the compiler may not split one sum of floats on its own.
    let mut lanes = [0.0f32; 32];
    let parts = numbers.chunks_exact(lanes.len());
    let remainder = parts.remainder();
    for part in parts {
        for (lane, value) in lanes.iter_mut().zip(part) {
            *lane += term(*value);
        }
    }
    let mut sums = [0.0f32; 8];
    // A fixed tree: it is part of the result's bits.
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = (lanes[i] + lanes[i + 8]) + (lanes[i + 16] + lanes[i + 24]);
    }
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| sums[i] + sums[i + 4]);
    let mut total = (a + b) + (c + d);
    for value in remainder {
        total += term(*value);
    }
    total
}

/// The sum, to the precision of the numbers.
pub(crate) fn sum(numbers: &[f32]) -> f64 {
    sum_of(numbers, |value| value)
}

/// The sum of a function of the numbers, to their precision: f32 in lanes over short parts, f64
/// over these.
#[inline(always)]
pub(crate) fn sum_of(numbers: &[f32], term: impl Fn(f32) -> f32) -> f64 {
    const PART: usize = 1024;
    const LANES: usize = 64;
    // 1024 numbers in 64 lanes are 16 additions for each lane: the error in f32
    // stays at a few units of the last digit, and f64 takes over before it grows.
    let mut total = 0.0;
    for part in numbers.chunks(PART) {
        let mut lanes = [0.0f32; LANES];
        let mut pieces = part.chunks_exact(LANES);
        for piece in &mut pieces {
            for (lane, value) in lanes.iter_mut().zip(piece) {
                *lane += term(*value);
            }
        }
        for value in pieces.remainder() {
            total += f64::from(term(*value));
        }
        for lane in lanes {
            total += f64::from(lane);
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn sums_are_those_in_f64() {
        let mut random = CounterRng::new(1, 0, 0);
        for count in [0, 1, 31, 32, 33, 100, 5000] {
            let numbers: Vec<f32> = (0..count).map(|_| random.uniform() as f32).collect();
            let exact: f64 = numbers.iter().map(|value| f64::from(*value)).sum();
            let squares: f64 = numbers.iter().map(|value| f64::from(value * value)).sum();
            let in_lanes = f64::from(sum_in_lanes(&numbers, |value| value));
            assert!((in_lanes - exact).abs() <= 1e-6 * exact, "{count}");
            let of_squares = f64::from(sum_in_lanes(&numbers, |value| value * value));
            assert!((of_squares - squares).abs() <= 1e-6 * squares, "{count}");
            assert!((sum(&numbers) - exact).abs() <= 1e-6 * exact, "{count}");
        }
    }
}
