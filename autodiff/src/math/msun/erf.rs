// ====================================================
// Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
//
// Developed at SunPro, a Sun Microsystems, Inc. business.
// Permission to use, copy, modify, and distribute this
// software is freely granted, provided that this notice
// is preserved.
// ====================================================

//! The error function: `s_erf.c`.

use super::basic::exp;
use super::{polynomial, size};

/// The error function near 1, in few bits.
const NEAR_ONE: f64 = 0.8450629115104675;

/// Returns `erf(x) / x - 1` for a size below 0.84375.
fn small(x: f64) -> f64 {
    const P: [f64; 5] = [
        0.12837916709551256,
        -0.3250421072470015,
        -0.02848174957559851,
        -0.005770270296489442,
        -2.3763016656650163e-05,
    ];
    const Q: [f64; 6] = [
        1.0,
        0.39791722395915535,
        0.0650222499887673,
        0.005081306281875766,
        0.00013249473800432164,
        -3.960228278775368e-06,
    ];
    polynomial(x * x, &P) / polynomial(x * x, &Q)
}

/// Returns `erfc(|x|)` for a size from 0.84375 to 28.
fn large(x: f64) -> f64 {
    const PA: [f64; 7] = [
        -0.0023621185607526594,
        0.41485611868374833,
        -0.3722078760357013,
        0.31834661990116175,
        -0.11089469428239668,
        0.035478304325618236,
        -0.002166375594868791,
    ];
    const QA: [f64; 7] = [
        1.0,
        0.10642088040084423,
        0.540397917702171,
        0.07182865441419627,
        0.12617121980876164,
        0.01363708391202905,
        0.011984499846799107,
    ];
    const RA: [f64; 8] = [
        -0.009864944034847148,
        -0.6938585727071818,
        -10.558626225323291,
        -62.375332450326006,
        -162.39666946257347,
        -184.60509290671104,
        -81.2874355063066,
        -9.814329344169145,
    ];
    const SA: [f64; 9] = [
        1.0,
        19.651271667439257,
        137.65775414351904,
        434.56587747522923,
        645.3872717332679,
        429.00814002756783,
        108.63500554177944,
        6.570249770319282,
        -0.0604244152148581,
    ];
    const RB: [f64; 7] = [
        -0.0098649429247001,
        -0.799283237680523,
        -17.757954917754752,
        -160.63638485582192,
        -637.5664433683896,
        -1025.0951316110772,
        -483.5191916086514,
    ];
    const SB: [f64; 8] = [
        1.0,
        30.33806074348246,
        325.7925129965739,
        1536.729586084437,
        3199.8582195085955,
        2553.0504064331644,
        474.52854120695537,
        -22.44095244658582,
    ];
    let x = x.abs();
    if x < 1.25 {
        let s = x - 1.0;
        return 1.0 - NEAR_ONE - polynomial(s, &PA) / polynomial(s, &QA);
    }
    let s = 1.0 / (x * x);
    let ratio = match size(x) < 0x4006_db6d {
        true => polynomial(s, &RA) / polynomial(s, &SA),
        false => polynomial(s, &RB) / polynomial(s, &SB),
    };
    // The square of the upper half of the number is exact.
    let z = f64::from_bits(x.to_bits() >> 32 << 32);
    exp(-z * z - 0.5625) * exp((z - x) * (z + x) + ratio) / x
}

/// The error function.
pub(crate) fn erf(x: f64) -> f64 {
    let size = size(x);
    if size >= 0x7ff0_0000 {
        return 1.0_f64.copysign(x) + 1.0 / x;
    }
    if size < 0x3e30_0000 {
        return 0.125 * (8.0 * x + 1.0270333367641007 * x);
    }
    if size < 0x3feb_0000 {
        return x + x * small(x);
    }
    let y = 1.0
        - if size < 0x4018_0000 {
            large(x)
        } else {
            f64::MIN_POSITIVE
        };
    y.copysign(x)
}

/// `1 - erf(x)`.
pub(crate) fn erfc(x: f64) -> f64 {
    let (size, negative) = (size(x), x.is_sign_negative());
    if size >= 0x7ff0_0000 {
        return if negative { 2.0 } else { 0.0 } + 1.0 / x;
    }
    if size < 0x3c70_0000 {
        return 1.0 - x;
    }
    if size < 0x3feb_0000 {
        return match x < 0.25 {
            true => 1.0 - (x + x * small(x)),
            false => 0.5 - (x - 0.5 + x * small(x)),
        };
    }
    let rest = if size < 0x403c_0000 { large(x) } else { 0.0 };
    if negative { 2.0 - rest } else { rest }
}
