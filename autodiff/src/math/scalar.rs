//! Elementary functions of single floats, with the processor's fused multiply-add if it has one.
//!
//! Builds for x86-64 do not use this instruction by default, because the oldest processors lack it. Then every
//! multiply-add is a call of the system's math library, and an exponential contains fifteen of them. So on x86-64 each
//! function here is compiled twice, and the choice is made at run time, as for SIMD lanes. Both versions round a
//! multiply-add once, so their results have the same bits.

/// Defines functions that use the processor's fused multiply-add if it has one. All code that they call must be marked
/// `#[inline(always)]`; otherwise that code is compiled without the instruction.
macro_rules! with_fma {
    ($(
        $(#[$attribute:meta])*
        fn $name:ident($($x:ident: $argument:ty),*) -> $result:ty $body:block
    )*) => {$(
        $(#[$attribute])*
        #[allow(unsafe_code)] // `fused` may run only on processors with the instruction.
        pub(crate) fn $name($($x: $argument),*) -> $result {
            #[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
            if is_x86_feature_detected!("fma") {
                #[target_feature(enable = "fma")]
                fn fused($($x: $argument),*) -> $result $body
                // SAFETY: the processor has the instruction.
                return unsafe { fused($($x),*) };
            }
            // This function is separate, so that the choice itself needs no stack.
            #[inline(never)]
            fn portable($($x: $argument),*) -> $result $body
            portable($($x),*)
        }
    )*};
}

pub(super) use with_fma;

/// Defines the functions of a float type, in a module.
macro_rules! functions {
    ($module:ident, $float:ident) => {
        pub(crate) mod $module {
            use crate::math::primitive::{self, Primitive, SIN_RANGE};

            with_fma! {
                fn exp(x: $float) -> $float {
                    if x.abs() <= <$float>::EXP_MODERATE as $float {
                        primitive::moderate_exp(x)
                    } else {
                        primitive::exp(x)
                    }
                }
                fn tanh(x: $float) -> $float {
                    primitive::tanh(x)
                }
                fn small_sin_cos(x: $float) -> ($float, $float) {
                    primitive::sin_cos(x)
                }
            }

            /// Returns the sine and the cosine.
            #[inline(always)]
            pub(crate) fn sin_cos(x: $float) -> ($float, $float) {
                if x.abs() <= SIN_RANGE as $float {
                    small_sin_cos(x)
                } else {
                    (x.sin(), x.cos())
                }
            }
        }
    };
}

functions!(double, f64);
functions!(single, f32);
