//! Vectors of f32 as the processor at hand has them, chosen when the program runs.
//!
//! A kernel is written once, over [`Lanes`], as a [`Work`]; [`Level::run`] compiles it for each
//! instruction set. All of a kernel must be inlined into one function, so everything it calls is
//! `#[inline(always)]`.

use protomer_kernel::instructions;
use std::sync::OnceLock;

/// Operations on one vector register.
///
/// # Safety
/// Every function may only run on a processor that has the instruction set of the type.
pub trait Lanes: Copy {
    /// The register.
    type Vector: Copy;
    /// Numbers in it; divides 16.
    const WIDTH: usize;
    /// Whether there are thirty-two registers, not sixteen.
    const MANY: bool;

    /// All zeros.
    ///
    /// # Safety
    /// See [`Lanes`].
    unsafe fn zero() -> Self::Vector;

    /// The number at the pointer in every lane.
    ///
    /// # Safety
    /// See [`Lanes`]; the pointer must be valid for a read of one number.
    unsafe fn splat(from: *const f32) -> Self::Vector;

    /// The numbers from the pointer on.
    ///
    /// # Safety
    /// See [`Lanes`]; the pointer must be valid for a read of `WIDTH` numbers.
    unsafe fn load(from: *const f32) -> Self::Vector;

    /// Writes the numbers from the pointer on.
    ///
    /// # Safety
    /// See [`Lanes`]; the pointer must be valid for a write of `WIDTH` numbers.
    unsafe fn store(to: *mut f32, vector: Self::Vector);

    /// a b + c.
    ///
    /// # Safety
    /// See [`Lanes`].
    unsafe fn multiply_add(a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
}

/// Any processor.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

impl Lanes for Portable {
    type Vector = [f32; 8];
    const WIDTH: usize = 8;
    const MANY: bool = false;

    #[inline(always)]
    unsafe fn zero() -> [f32; 8] {
        [0.0; 8]
    }

    #[inline(always)]
    unsafe fn splat(from: *const f32) -> [f32; 8] {
        // SAFETY: the caller's promise.
        [unsafe { from.read() }; 8]
    }

    #[inline(always)]
    unsafe fn load(from: *const f32) -> [f32; 8] {
        // SAFETY: the caller's promise; an array of numbers may lie wherever a number may.
        unsafe { from.cast::<[f32; 8]>().read() }
    }

    #[inline(always)]
    unsafe fn store(to: *mut f32, vector: [f32; 8]) {
        // SAFETY: the caller's promise; an array of numbers may lie wherever a number may.
        unsafe { to.cast::<[f32; 8]>().write(vector) }
    }

    #[inline(always)]
    unsafe fn multiply_add(a: [f32; 8], b: [f32; 8], mut c: [f32; 8]) -> [f32; 8] {
        for i in 0..8 {
            c[i] += a[i] * b[i];
        }
        c
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Lanes;
    use std::arch::x86_64::{
        __m256, __m512, _mm256_broadcast_ss, _mm256_fmadd_ps, _mm256_loadu_ps, _mm256_setzero_ps,
        _mm256_storeu_ps, _mm512_fmadd_ps, _mm512_loadu_ps, _mm512_set1_ps, _mm512_setzero_ps,
        _mm512_storeu_ps,
    };

    /// AVX2 and FMA.
    #[derive(Debug, Clone, Copy)]
    pub struct Avx2;

    impl Lanes for Avx2 {
        type Vector = __m256;
        const WIDTH: usize = 8;
        const MANY: bool = false;

        #[inline(always)]
        unsafe fn zero() -> __m256 {
            // SAFETY: the caller has the instructions.
            unsafe { _mm256_setzero_ps() }
        }

        #[inline(always)]
        unsafe fn splat(from: *const f32) -> __m256 {
            // SAFETY: the caller's promise.
            unsafe { _mm256_broadcast_ss(&*from) }
        }

        #[inline(always)]
        unsafe fn load(from: *const f32) -> __m256 {
            // SAFETY: the caller's promise.
            unsafe { _mm256_loadu_ps(from) }
        }

        #[inline(always)]
        unsafe fn store(to: *mut f32, vector: __m256) {
            // SAFETY: the caller's promise.
            unsafe { _mm256_storeu_ps(to, vector) }
        }

        #[inline(always)]
        unsafe fn multiply_add(a: __m256, b: __m256, c: __m256) -> __m256 {
            // SAFETY: the caller has the instructions.
            unsafe { _mm256_fmadd_ps(a, b, c) }
        }
    }

    /// AVX-512 F.
    #[derive(Debug, Clone, Copy)]
    pub struct Avx512;

    impl Lanes for Avx512 {
        type Vector = __m512;
        const WIDTH: usize = 16;
        const MANY: bool = true;

        #[inline(always)]
        unsafe fn zero() -> __m512 {
            // SAFETY: the caller has the instructions.
            unsafe { _mm512_setzero_ps() }
        }

        #[inline(always)]
        unsafe fn splat(from: *const f32) -> __m512 {
            // SAFETY: the caller's promise.
            unsafe { _mm512_set1_ps(from.read()) }
        }

        #[inline(always)]
        unsafe fn load(from: *const f32) -> __m512 {
            // SAFETY: the caller's promise.
            unsafe { _mm512_loadu_ps(from) }
        }

        #[inline(always)]
        unsafe fn store(to: *mut f32, vector: __m512) {
            // SAFETY: the caller's promise.
            unsafe { _mm512_storeu_ps(to, vector) }
        }

        #[inline(always)]
        unsafe fn multiply_add(a: __m512, b: __m512, c: __m512) -> __m512 {
            // SAFETY: the caller has the instructions.
            unsafe { _mm512_fmadd_ps(a, b, c) }
        }
    }
}

#[cfg(target_arch = "x86_64")]
use x86::{Avx2, Avx512};

/// A kernel.
pub trait Work {
    /// Result of the kernel.
    type Output;

    /// Does the work.
    ///
    /// # Safety
    /// Only on a processor that has the instruction set of `S`. Implementations are
    /// `#[inline(always)]`.
    unsafe fn run<S: Lanes>(self) -> Self::Output;
}

/// The instruction sets that kernels are compiled for, slowest first.
///
/// ```
/// use protomer_convolution::Level;
///
/// assert!(Level::Portable.is_available());
/// assert_eq!(Level::available().last(), Some(Level::best()));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Any processor.
    Portable,
    /// AVX2 and FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl Level {
    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Avx2 => instructions!(narrow_fused: detected),
            Self::Avx512 => instructions!(wide_fused: detected),
        }
    }

    /// The levels that this processor has, slowest first.
    pub fn available() -> impl Iterator<Item = Self> {
        [Self::Portable, Self::Avx2, Self::Avx512]
            .into_iter()
            .filter(|level| level.is_available())
    }

    /// The fastest level of this processor.
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Self::available().last().unwrap_or(Self::Portable))
    }

    /// Does the work on this level, or on the portable one if the processor lacks it.
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[cfg(target_arch = "x86_64")]
        if self.is_available() {
            match self {
                // SAFETY: `is_available` has found the instructions.
                Self::Avx512 => return unsafe { run_avx512(work) },
                // SAFETY: `is_available` has found the instructions.
                Self::Avx2 => return unsafe { run_avx2(work) },
                Self::Portable => {}
            }
        }
        // SAFETY: the portable kernels need no special instructions.
        unsafe { work.run::<Portable>() }
    }
}

instructions!(wide_fused: compiled {
    unsafe fn run_avx512<W: Work>(work: W) -> W::Output {
        // SAFETY: the features of this function are those of the type.
        unsafe { work.run::<Avx512>() }
    }
});

instructions!(narrow_fused: compiled {
    unsafe fn run_avx2<W: Work>(work: W) -> W::Output {
        // SAFETY: the features of this function are those of the type.
        unsafe { work.run::<Avx2>() }
    }
});
