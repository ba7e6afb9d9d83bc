//! Methods compiled for several instruction sets.
//!
//! The vector instructions do the same operations in the same order as the portable code, so every
//! machine finds the same bits.

/// A method that is compiled once for each instruction set and chosen at run time.
///
/// ```
/// use protomer_kernel::vectorised;
///
/// struct Numbers(Vec<f32>);
///
/// impl Numbers {
///     vectorised!(
///         /// The largest square.
///         fn largest, largest_any, largest_avx512, largest_avx2, (start: f32) -> f32
///     );
///
///     #[inline(always)]
///     fn largest_any(&self, start: f32) -> f32 {
///         self.0.iter().fold(start, |largest, x| largest.max(x * x))
///     }
/// }
///
/// assert_eq!(Numbers(vec![1.0, -3.0, 2.0]).largest(0.0), 9.0);
/// ```
#[macro_export]
macro_rules! vectorised {
    ($(#[$doc:meta])* $visible:vis fn $name:ident, $any:ident, $avx512:ident, $avx2:ident, ($($argument:ident: $type:ty),*) -> $out:ty) => {
        $(#[$doc])*
        $visible fn $name(&self, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            {
                if ::std::is_x86_feature_detected!("avx512f") && ::std::is_x86_feature_detected!("avx512dq") {
                    // SAFETY: the processor has the features that the function is compiled for.
                    return unsafe { self.$avx512($($argument),*) };
                }
                if ::std::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has the feature that the function is compiled for.
                    return unsafe { self.$avx2($($argument),*) };
                }
            }
            self.$any($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512dq")]
        fn $avx512(&self, $($argument: $type),*) -> $out {
            self.$any($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        fn $avx2(&self, $($argument: $type),*) -> $out {
            self.$any($($argument),*)
        }
    };
}
