//! Functions compiled for several instruction sets.
//!
//! A set of instructions is written down once, in [`instructions!`](crate::instructions): what a
//! function is compiled for is what the processor is checked for before the function is called.
//! Nothing else in the workspace names processor features.
//!
//! Two lists would drift apart. A function compiled for more than was checked would stop with an
//! illegal instruction on machines, also virtual ones, that mask features.

/// The sets of vector instructions: whether this processor has one, and a function compiled for it.
///
/// | set | for |
/// |---|---|
/// | `wide`, `narrow` | the portable operations in the same order: every machine finds the same bits |
/// | `wide_fused`, `narrow_fused` | the same with multiply-add as one instruction |
/// | `narrow_bits` | `narrow_fused` with the counting of bits and of zeros |
///
/// A processor of another architecture has none of them, and nothing is compiled for it.
///
/// ```
/// use protomer_kernel::instructions;
///
/// instructions!(narrow: compiled {
///     fn doubled(values: &mut [f32]) {
///         values.iter_mut().for_each(|value| *value *= 2.0);
///     }
/// });
///
/// let mut values = [1.5];
/// #[cfg(target_arch = "x86_64")]
/// if instructions!(narrow: detected) {
///     // SAFETY: the set is the one that the function is compiled for.
///     unsafe { doubled(&mut values) };
///     assert_eq!(values, [3.0]);
/// }
/// ```
#[macro_export]
macro_rules! instructions {
    (wide: $($next:tt)*) => {
        $crate::instructions! { @ ["avx512f", "avx512dq"] $($next)* }
    };
    (narrow: $($next:tt)*) => {
        $crate::instructions! { @ ["avx2"] $($next)* }
    };
    (wide_fused: $($next:tt)*) => {
        $crate::instructions! {
            @ ["avx512f", "avx512dq", "avx512vl", "avx512bw", "avx2", "fma"] $($next)*
        }
    };
    (narrow_fused: $($next:tt)*) => {
        $crate::instructions! { @ ["avx2", "fma"] $($next)* }
    };
    (narrow_bits: $($next:tt)*) => {
        $crate::instructions! {
            @ ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"] $($next)*
        }
    };
    (@ [$($feature:tt),+] detected) => {
        {
            #[cfg(target_arch = "x86_64")]
            {
                true $(&& ::std::is_x86_feature_detected!($feature))+
            }
            #[cfg(not(target_arch = "x86_64"))]
            {
                false
            }
        }
    };
    (@ [$($feature:tt),+] compiled { $($function:tt)* }) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature($(enable = $feature),+)]
        $($function)*
    };
}

/// A function or a method that is compiled once for each set of instructions and chosen at run time.
///
/// The names in brackets are those of the compiled forms, widest vectors first; the last is the
/// `#[inline(always)]` body that all of them share. Without a word before it, a function is compiled
/// for `wide` and `narrow`. After `fused` it is a method compiled for `wide_fused` and
/// `narrow_fused`, whose body has the constant `FUSED`: where multiply-add is one instruction. After
/// the name of a set it is a method compiled for this set alone. See
/// [`instructions!`](crate::instructions).
///
/// ```
/// use protomer_kernel::vectorised;
///
/// struct Numbers(Vec<f32>);
///
/// impl Numbers {
///     vectorised!(
///         /// The largest square.
///         fn largest[largest_avx512, largest_avx2, largest_any](self: &Self, start: f32) -> f32
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
    (
        fused
        $(#[$doc:meta])*
        $visible:vis fn $name:ident[$avx512:ident, $avx2:ident, $any:ident]
        $(<$generic:ident: $bound:path>)?
        (self: $receiver:ty $(, $argument:ident: $type:ty)* $(,)?) $(-> $out:ty)?
    ) => {
        $crate::vectorised!(
            @ [$(#[$doc])* $visible] $name [Self::] [$(<$generic: $bound>)?]
            [self: $receiver $(, $argument: $type)*] [$($out)?]
            [wide_fused $avx512, narrow_fused $avx2]
            $any [::<$($generic,)? true>] [::<$($generic,)? false>]
        );
    };
    (
        $(#[$doc:meta])*
        $visible:vis fn $name:ident[$avx512:ident, $avx2:ident, $any:ident]
        (self: $receiver:ty $(, $argument:ident: $type:ty)* $(,)?) $(-> $out:ty)?
    ) => {
        $crate::vectorised!(
            @ [$(#[$doc])* $visible] $name [Self::] []
            [self: $receiver $(, $argument: $type)*] [$($out)?]
            [wide $avx512, narrow $avx2] $any [] []
        );
    };
    (
        $(#[$doc:meta])*
        $visible:vis fn $name:ident[$avx512:ident, $avx2:ident, $any:ident]
        ($($argument:ident: $type:ty),* $(,)?) $(-> $out:ty)?
    ) => {
        $crate::vectorised!(
            @ [$(#[$doc])* $visible] $name [] [] [$($argument: $type),*] [$($out)?]
            [wide $avx512, narrow $avx2] $any [] []
        );
    };
    (
        $set:ident
        $(#[$doc:meta])*
        $visible:vis fn $name:ident[$compiled:ident, $any:ident]
        (self: $receiver:ty $(, $argument:ident: $type:ty)* $(,)?) $(-> $out:ty)?
    ) => {
        $crate::vectorised!(
            @ [$(#[$doc])* $visible] $name [Self::] []
            [self: $receiver $(, $argument: $type)*] [$($out)?]
            [$set $compiled] $any [] []
        );
    };
    // Hands the signature on as one token tree, for every compiled form to repeat.
    (
        @ [$($front:tt)*] $name:ident [$($path:tt)*] [$($generics:tt)*]
        [$($argument:ident: $type:ty),*] [$($out:ty)?]
        [$($set:ident $compiled:ident),+] $any:ident [$($vector:tt)*] [$($portable:tt)*]
    ) => {
        $($front)* fn $name $($generics)* ($($argument: $type),*) $(-> $out)? {
            // Widest first: each form returns, so the portable
            // body is reached only if none is available.
            $crate::vectorised!(@call [$($path)*] ($($argument),*) $($set $compiled),+);
            $($path)* $any $($portable)* ($($argument),*)
        }
        $crate::vectorised!(
            @forms {$($generics)* ($($argument: $type),*) $(-> $out)?}
            {$($path)* $any $($vector)* ($($argument),*)} $($set $compiled),+
        );
    };
    (@call $path:tt $arguments:tt $set:ident $compiled:ident, $($rest:tt)+) => {
        $crate::vectorised!(@call $path $arguments $set $compiled);
        $crate::vectorised!(@call $path $arguments $($rest)+);
    };
    (@call [$($path:tt)*] $arguments:tt $set:ident $compiled:ident) => {
        #[cfg(target_arch = "x86_64")]
        // The macro keeps the result of the question in an atomic; asking again costs a load.
        if $crate::instructions!($set: detected) {
            // SAFETY: the processor has the set of instructions that the function is compiled for.
            return unsafe { $($path)* $compiled $arguments };
        }
    };
    (@forms $signature:tt $body:tt $set:ident $compiled:ident, $($rest:tt)+) => {
        $crate::vectorised!(@forms $signature $body $set $compiled);
        $crate::vectorised!(@forms $signature $body $($rest)+);
    };
    (@forms {$($signature:tt)*} $body:tt $set:ident $compiled:ident) => {
        $crate::instructions!($set: compiled { fn $compiled $($signature)* $body });
    };
}
