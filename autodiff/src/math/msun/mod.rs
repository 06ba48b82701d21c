//! Special functions of floats, as in FreeBSD's library `msun` and in the crate `libm`, which has its functions in Rust. Tests
//! compare the bits. That crate takes as long to compile as this one.

mod basic;
mod erf;
mod ln_gamma;

pub(crate) use erf::{erf, erfc};
pub(crate) use ln_gamma::ln_gamma;

/// The upper half of the bits of a number, without the sign.
fn size(x: f64) -> u32 {
    (x.to_bits() >> 32) as u32 & 0x7fff_ffff
}

/// Returns `c[0] + c[1] x + c[2] x^2 + …`.
fn polynomial<const N: usize>(x: f64, c: &[f64; N]) -> f64 {
    let mut sum = c[N - 1];
    for &c in c[..N - 1].iter().rev() {
        sum = c + x * sum;
    }
    sum
}
