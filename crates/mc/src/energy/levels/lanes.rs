//! Arithmetic on sixteen numbers at once, as vector units like it.

/// Points evaluated together.
pub(super) const BLOCK: usize = 16;

/// Asks for a value that will be read soon.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..size_of::<T>().div_ceil(LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        // SAFETY: a hint, which reads nothing and fails for no address; every x86-64 processor has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) };
    }
}

/// Bytes that come from memory together.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// The sum, by halves.
#[inline(always)]
pub(super) fn sum_of_lanes(lanes: &[f32; BLOCK]) -> f32 {
    let mut eight = [0.0; BLOCK / 2];
    for lane in 0..BLOCK / 2 {
        eight[lane] = lanes[lane] + lanes[lane + BLOCK / 2];
    }
    let mut four = [0.0; BLOCK / 4];
    for lane in 0..BLOCK / 4 {
        four[lane] = eight[lane] + eight[lane + BLOCK / 4];
    }
    (four[0] + four[1]) + (four[2] + four[3])
}

/// A method that is compiled once for each instruction set and chosen at run time; `FUSED` in its
/// body: where multiply-add is one instruction. Both vector forms find the same bits.
macro_rules! vectorised {
    (
        $(#[$doc:meta])*
        $visible:vis fn $name:ident[$avx512:ident, $avx2:ident, $any:ident]
        $(<$generic:ident: $bound:path>)?($self:ident: $receiver:ty $(, $argument:ident: $type:ty)*) -> $out:ty
    ) => {
        $(#[$doc])*
        $visible fn $name$(<$generic: $bound>)?($self: $receiver $(, $argument: $type)*) -> $out {
            #[cfg(target_arch = "x86_64")]
            {
                use $crate::energy::levels::{has_avx2, has_avx512};
                if has_avx512() {
                    // SAFETY: the processor has the features that the function is compiled for.
                    return unsafe { $self.$avx512($($argument),*) };
                }
                if has_avx2() {
                    // SAFETY: the processor has the features that the function is compiled for.
                    return unsafe { $self.$avx2($($argument),*) };
                }
            }
            $self.$any::<$($generic,)? false>($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma")]
        fn $avx512$(<$generic: $bound>)?($self: $receiver $(, $argument: $type)*) -> $out {
            $self.$any::<$($generic,)? true>($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,fma")]
        fn $avx2$(<$generic: $bound>)?($self: $receiver $(, $argument: $type)*) -> $out {
            $self.$any::<$($generic,)? true>($($argument),*)
        }
    };
}
pub(in crate::energy) use vectorised;

/// Whether the processor has the widest vectors that methods are [`vectorised`] for.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(in crate::energy) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("fma")
}

/// Whether the processor has the next widest.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(in crate::energy) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}
