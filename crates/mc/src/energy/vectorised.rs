//! Methods for the widest vectors that a processor has.

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
                use $crate::energy::vectorised::{has_avx2, has_avx512};
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
pub(super) use vectorised;

/// Whether the processor has the widest vectors that methods are [`vectorised`] for.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("fma")
}

/// Whether the processor has the next widest.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}
