//! Elementary functions. Their values are computed from additions and multiplications, or composed of other functions.

mod primitive;
#[cfg(lanes)]
mod abreast;
pub(crate) mod exact;
mod power;
pub(crate) mod rounding;
mod special;
mod table;

#[cfg(lanes)]
pub(crate) use abreast::tanh_abreast;
pub(crate) use power::{by_squaring, powi};
pub(crate) use primitive::{Primitive, SIN_RANGE, exp, sin_cos, tanh};
