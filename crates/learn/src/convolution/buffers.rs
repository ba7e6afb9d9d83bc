//! Buffers that are used again: fresh pages from the system cost a quarter of the time of a small
//! network.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Buffers that wait for use, at most this many.
const KEPT: usize = 64;

static WAITING: Mutex<Vec<Vec<f32>>> = Mutex::new(Vec::new());

/// Numbers that go back to the waiting buffers in the end.
#[derive(Debug, Default)]
pub struct Buffer(Vec<f32>);

impl Buffer {
    /// A buffer of this length with anything in it.
    pub fn stale(length: usize) -> Self {
        let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
        // The smallest that is large enough, else the largest.
        let fits = (0..waiting.len()).min_by_key(|i| {
            let capacity = waiting[*i].capacity();
            if capacity >= length {
                (0, capacity)
            } else {
                (1, usize::MAX - capacity)
            }
        });
        let mut numbers = fits.map(|i| waiting.swap_remove(i)).unwrap_or_default();
        drop(waiting);
        numbers.resize(length, 0.0);
        Self(numbers)
    }

    /// A buffer of zeros of this length.
    pub fn zeros(length: usize) -> Self {
        let mut buffer = Self::stale(length);
        buffer.fill(0.0);
        buffer
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() < KEPT && self.0.capacity() > 0 {
            waiting.push(std::mem::take(&mut self.0));
        }
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.0
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
