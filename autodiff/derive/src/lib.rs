//! `#[derive(Parameters)]` for structures of numbers; the trait in `autodiff` has the documentation. `#[derive(Fields)]` for
//! the inputs and results of kernels; the trait in `autodiff_programs` has it. And `#[kernel]` for functions that run in SIMD
//! lanes.

mod tokens;
mod structure;
mod manifest;
mod parameters;
mod fields;
mod counted;
mod kernel;

use proc_macro::TokenStream;

use crate::tokens::Refusal;

/// Implements `autodiff::Parameters` for a struct with one type parameter, the number type. The struct
/// may also have lifetime and constant parameters. Fields whose type does not mention the number type
/// are cloned.
///
/// The code finds the name of the dependency `cosmic-autodiff` in the manifest. `#[autodiff(crate = "path")]` names
/// another path, for example of a crate that exports it.
#[proc_macro_derive(Parameters, attributes(autodiff))]
#[allow(clippy::useless_conversion)] // In unit tests the tokens have another type.
pub fn parameters(input: TokenStream) -> TokenStream {
    parameters::implementation(input.into())
        .unwrap_or_else(Refusal::into_code)
        .into()
}

/// Implements `autodiff_programs::Fields` for a struct with one type parameter, the type of its numbers. The struct may also
/// have constant parameters.
///
/// The code finds the name of the dependency `cosmic-autodiff-programs` in the manifest. `#[autodiff(crate = "path")]` names
/// another path.
#[proc_macro_derive(Fields, attributes(autodiff))]
#[allow(clippy::useless_conversion)] // In unit tests the tokens have another type.
pub fn fields(input: TokenStream) -> TokenStream {
    fields::implementation(input.into())
        .unwrap_or_else(Refusal::into_code)
        .into()
}

/// Marks every function of an `impl` `#[inline(always)]`, or a single function: those that run in SIMD lanes.
///
/// The instruction set of the lanes is chosen at run time, for the loop around a kernel. A function that is not inlined
/// into that loop is compiled without this instruction set, and every operation in it becomes a call: the results stay
/// the same, but the kernel takes some fifty times as long. So the traits of kernels have a hidden constant, which this
/// attribute defines, and an `impl` without it does not compile. Use it also on all functions of yours that a kernel
/// calls, or on their `impl`. In an `impl` of any other trait, mark the functions one by one. Closures cannot be marked,
/// so prefer loops.
///
/// In an `impl Kernel<_, _>`, it also counts the inputs and results of the kernel: see the trait `Fields` of
/// `autodiff_programs`.
#[proc_macro_attribute]
#[allow(clippy::useless_conversion)] // In unit tests the tokens have another type.
pub fn kernel(arguments: TokenStream, item: TokenStream) -> TokenStream {
    kernel::marked(&arguments.into(), item.into())
        .unwrap_or_else(Refusal::into_code)
        .into()
}
