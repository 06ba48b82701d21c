// ====================================================
// Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
//
// Developed at SunPro, a Sun Microsystems, Inc. business.
// Permission to use, copy, modify, and distribute this
// software is freely granted, provided that this notice
// is preserved.
// ====================================================

//! The logarithm of the gamma function: `e_lgamma_r.c`.

use std::f64::consts::PI;

use super::basic::{cos, ln, sin};
use super::{polynomial, size};

/// Where the gamma function is least.
const LEAST: f64 = 1.4616321449683622;

/// Returns `sin(pi x)`. At integers the sign is arbitrary.
fn sin_pi(x: f64) -> f64 {
    let x = 2.0 * (x * 0.5 - (x * 0.5).floor());
    let quarter = ((x * 4.0) as i32 + 1) / 2;
    let angle = (x - f64::from(quarter) * 0.5) * PI;
    match quarter {
        1 => cos(angle),
        2 => sin(-angle),
        3 => -cos(angle),
        _ => sin(angle),
    }
}

/// Returns the function of `2 - y`.
fn below_two(y: f64) -> f64 {
    const EVEN: [f64; 6] = [
        0.07721566490153287,
        0.06735230105312927,
        0.007385550860814029,
        0.0011927076318336207,
        0.00022086279071390839,
        2.5214456545125733e-05,
    ];
    const ODD: [f64; 6] = [
        0.3224670334241136,
        0.020580808432516733,
        0.0028905138367341563,
        0.0005100697921535113,
        0.00010801156724758394,
        4.4864094961891516e-05,
    ];
    let z = y * y;
    y * polynomial(z, &EVEN) + z * polynomial(z, &ODD) - 0.5 * y
}

/// Returns the function of `LEAST + y`.
fn near_least(y: f64) -> f64 {
    const T0: [f64; 5] = [
        0.48383612272381005,
        -0.032788541075985965,
        0.006100538702462913,
        -0.0014034646998923284,
        0.00031563207090362595,
    ];
    const T1: [f64; 5] = [
        -0.1475877229945939,
        0.01797067508118204,
        -0.0036845201678113826,
        0.000881081882437654,
        -0.00031275416837512086,
    ];
    const T2: [f64; 5] = [
        0.06462494023913339,
        -0.010314224129834144,
        0.0022596478090061247,
        -0.0005385953053567405,
        0.0003355291926355191,
    ];
    // The value at the minimum, in two parts.
    const VALUE: [f64; 2] = [-0.12148629053584961, -3.638676997039505e-18];
    let (z, w) = (y * y, y * y * y);
    let rest = polynomial(w, &T1) + y * polynomial(w, &T2);
    VALUE[0] + (z * polynomial(w, &T0) - (VALUE[1] - w * rest))
}

/// Returns the function of `1 + y`.
fn above_one(y: f64) -> f64 {
    const U: [f64; 6] = [
        -0.07721566490153287,
        0.6328270640250934,
        1.4549225013723477,
        0.9777175279633727,
        0.22896372806469245,
        0.013381091853678766,
    ];
    const V: [f64; 6] = [
        1.0,
        2.4559779371304113,
        2.128489763798934,
        0.7692851504566728,
        0.10422264559336913,
        0.003217092422824239,
    ];
    -0.5 * y + y * polynomial(y, &U) / polynomial(y, &V)
}

/// Returns the function of a number from 2 to 8.
fn moderate(x: f64) -> f64 {
    const S: [f64; 7] = [
        -0.07721566490153287,
        0.21498241596060885,
        0.325778796408931,
        0.14635047265246445,
        0.02664227030336386,
        0.0018402845140733772,
        3.194753265841009e-05,
    ];
    const R: [f64; 7] = [
        1.0,
        1.3920053346762105,
        0.7219355475671381,
        0.17193386563280308,
        0.01864591917156529,
        0.0007779424963818936,
        7.326684307446256e-06,
    ];
    let whole = x.floor();
    let y = x - whole;
    let r = 0.5 * y + y * polynomial(y, &S) / polynomial(y, &R);
    let (mut product, mut k) = (1.0, whole - 1.0);
    while k >= 2.0 {
        product *= y + k;
        k -= 1.0;
    }
    if whole >= 3.0 { r + ln(product) } else { r }
}

/// Returns the function of a positive number that is not tiny.
fn of_positive(x: f64) -> f64 {
    const W: [f64; 7] = [
        0.4189385332046727,
        0.08333333333333297,
        -0.0027777777772877554,
        0.0007936505586430196,
        -0.00059518755745034,
        0.0008363399189962821,
        -0.0016309293409657527,
    ];
    let size = size(x);
    if x == 1.0 || x == 2.0 {
        return 0.0;
    }
    if size <= 0x3fec_cccc {
        // The function of the next number, minus the logarithm.
        let next = match size {
            0x3fe7_6944.. => below_two(1.0 - x),
            0x3fcd_a661..0x3fe7_6944 => near_least(x - (LEAST - 1.0)),
            _ => above_one(x),
        };
        return -ln(x) + next;
    }
    match size {
        ..0x3ff3_b4c4 => above_one(x - 1.0),
        0x3ff3_b4c4..0x3ffb_b4c3 => near_least(x - LEAST),
        0x3ffb_b4c3..0x4000_0000 => below_two(2.0 - x),
        0x4000_0000..0x4020_0000 => moderate(x),
        0x4020_0000..0x4390_0000 => {
            let inverse = 1.0 / x;
            let y = inverse * inverse;
            let w = W[0] + inverse * polynomial(y, &[W[1], W[2], W[3], W[4], W[5], W[6]]);
            (x - 0.5) * (ln(x) - 1.0) + w
        }
        _ => x * (ln(x) - 1.0),
    }
}

/// The logarithm of the absolute value of the gamma function.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    let size = size(x);
    if size >= 0x7ff0_0000 {
        return x * x;
    }
    if size < (0x3ff - 70) << 20 {
        return if x == 0.0 {
            f64::INFINITY
        } else {
            -ln(x.abs())
        };
    }
    if x > 0.0 {
        return of_positive(x);
    }
    let t = sin_pi(-x).abs();
    if t == 0.0 {
        return f64::INFINITY;
    }
    ln(PI / (t * -x)) - of_positive(-x)
}
