// ====================================================
// Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
//
// Developed at SunPro, a Sun Microsystems, Inc. business.
// Permission to use, copy, modify, and distribute this
// software is freely granted, provided that this notice
// is preserved.
// ====================================================

//! The exponential, the logarithm, the sine and the cosine that the special functions use: `e_exp.c`, `e_log.c`, `k_sin.c`
//! and `k_cos.c`.

use super::{polynomial, size};

/// The natural logarithm of 2, in two parts. Products of the first with small integers are exact.
const LN_2: [f64; 2] = [0.6931471803691238, 1.9082149292705877e-10];

/// Returns `e^x` for an argument from -800 to 1.
pub(super) fn exp(mut x: f64) -> f64 {
    const P: [f64; 5] = [
        0.16666666666666602,
        -0.0027777777777015593,
        6.613756321437934e-05,
        -1.6533902205465252e-06,
        4.1381367970572385e-08,
    ];
    let (size, sign) = (size(x), i32::from(x.is_sign_negative()));
    if x < -745.133_219_101_941_1 {
        return 0.0;
    }
    let (mut power, mut hi, mut lo) = (0, x, 0.0);
    if size > 0x3fd6_2e42 {
        // More than half of the logarithm of 2.
        power = match size >= 0x3ff0_a2b2 {
            true => (std::f64::consts::LOG2_E * x + 0.5_f64.copysign(x)) as i32,
            false => 1 - sign - sign,
        };
        hi = x - f64::from(power) * LN_2[0];
        lo = f64::from(power) * LN_2[1];
        x = hi - lo;
    } else if size <= 0x3e30_0000 {
        return 1.0 + x;
    }
    let square = x * x;
    let c = x - square * polynomial(square, &P);
    let y = 1.0 + (x * c / (2.0 - c) - lo + hi);
    // A subnormal power is reached in two steps.
    let scale = |power: i32| f64::from_bits(((1023 + power) as u64) << 52);
    match power < -1022 {
        true => y * scale(-969) * scale(power + 969),
        false => y * scale(power),
    }
}

/// Returns the natural logarithm of a positive number.
pub(super) fn ln(x: f64) -> f64 {
    const ODD: [f64; 4] = [
        0.6666666666666735,
        0.2857142874366239,
        0.1818357216161805,
        0.14798198605116586,
    ];
    const EVEN: [f64; 3] = [0.3999999999940942, 0.22222198432149784, 0.15313837699209373];
    if x == 1.0 {
        return 0.0;
    }
    // A subnormal number is scaled up.
    let (x, shift) = match x < f64::MIN_POSITIVE {
        true => (x * 2f64.powi(54), 54),
        false => (x, 0),
    };
    let bits = x.to_bits();
    // The mantissa between the square roots of 1/2 and of 2.
    let high = (bits >> 32) as u32 + (0x3ff0_0000 - 0x3fe6_a09e);
    let power = f64::from((high >> 20) as i32 - 0x3ff - shift);
    let high = (high & 0x000f_ffff) + 0x3fe6_a09e;
    let f = f64::from_bits(u64::from(high) << 32 | bits & 0xffff_ffff) - 1.0;
    let (half, s) = (0.5 * f * f, f / (2.0 + f));
    let square = s * s;
    let fourth = square * square;
    let even = fourth * polynomial(fourth, &EVEN);
    let rest = square * polynomial(fourth, &ODD) + even;
    s * (half + rest) + power * LN_2[1] - half + f + power * LN_2[0]
}

/// Returns the sine of an angle of at most a quarter of pi.
pub(super) fn sin(x: f64) -> f64 {
    let (z, cube) = (x * x, x * x * x);
    let w = z * z;
    let r = 0.00833333333332249
        + z * (-0.0001984126982985795 + z * 2.7557313707070068e-06)
        + z * w * (-2.5050760253406863e-08 + z * 1.58969099521155e-10);
    x + cube * (-0.16666666666666632 + z * r)
}

/// Returns the cosine of an angle of at most a quarter of pi.
pub(super) fn cos(x: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let near = polynomial(
        z,
        &[
            0.0416666666666666,
            -0.001388888888887411,
            2.480158728947673e-05,
        ],
    );
    let r = z * near
        + w * w
            * polynomial(
                z,
                &[
                    -2.7557314351390663e-07,
                    2.087572321298175e-09,
                    -1.1359647557788195e-11,
                ],
            );
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + z * r)
}
