//! Elementary functions. Their values are computed from additions and multiplications, or composed of other functions.

mod primitive;
mod scalar;
#[cfg(lanes)]
mod abreast;
pub(crate) mod exact;
mod digamma;
mod msun;
mod double_double;
mod power;
pub(crate) mod rounding;
mod special;
mod table;
#[cfg(test)]
mod tests;

#[cfg(lanes)]
pub(crate) use abreast::tanh_abreast;
pub use double_double::DoubleDouble;
#[cfg(lanes)]
pub(crate) use power::FEW;
pub use power::by_squaring;
pub(crate) use power::powi;
#[cfg(lanes)]
pub(crate) use primitive::Primitive;
#[cfg(lanes)]
pub(crate) use primitive::{SIN_RANGE, exp, sin_cos};
pub(crate) use scalar::{double, single};
pub(crate) use table::OnFloats;
