//! Buffers that are used again: fresh pages from the system take a quarter of the time of a small
//! network.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Largest number of buffers that wait for use.
const KEPT: usize = 64;

static WAITING: Mutex<Vec<Vec<f32>>> = Mutex::new(Vec::new());

/// Numbers whose memory goes back to the waiting buffers when they are dropped.
#[derive(Debug, Default)]
pub struct Buffer(Vec<f32>);

impl Buffer {
    /// A buffer of this length, with stale numbers in it.
    pub fn stale(length: usize) -> Self {
        let mut numbers = take_waiting(length).unwrap_or_default();
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

/// The smallest waiting buffer that is large enough, else the largest.
fn take_waiting(length: usize) -> Option<Vec<f32>> {
    // A panic elsewhere leaves the list usable: it holds only memory.
    let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    // The tightest fit first; without any, the largest, which grows least when it is enlarged.
    let best = (0..waiting.len()).min_by_key(|i| {
        let capacity = waiting[*i].capacity();
        if capacity >= length {
            (0, capacity)
        } else {
            (1, usize::MAX - capacity)
        }
    });
    best.map(|i| waiting.swap_remove(i))
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
        // Beyond this number memory goes back to the system,
        // so an odd shape does not hold it for ever.
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
