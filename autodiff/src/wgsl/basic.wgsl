// Elementary functions in single precision. The formulas are those of `math/primitive.rs`, which names their source.
//
// The program declares `Number` (`f32`, or a vector with one number of each lane), and with as many lanes `Whole`, `Bits`
// and `Truth` (signed and unsigned whole numbers, and truth values).

const LARGEST = Number(3.4028235e38f);

// 2^n for a whole number n from -126 to 127.
fn power_of_two(n: Number) -> Number {
    return bitcast<Number>(Bits(Whole(n) + Whole(127)) << Bits(23u));
}

// (e^r - 1, n), where x = n ln 2 + r and |r| <= ln(2)/2.
fn reduced_exp_m1(x: Number) -> array<Number, 2> {
    let n = round(x * Number(1.442695f));
    let r = fma(n, Number(1.9046542e-9f), fma(n, Number(-0.6931472f), x));
    let square = r * r;
    var odd = Number(1.9841270e-4f);
    var even = Number(1.3888889e-3f);
    odd = fma(odd, square, Number(8.333334e-3f));
    even = fma(even, square, Number(4.1666668e-2f));
    odd = fma(odd, square, Number(0.16666667f));
    even = fma(even, square, Number(0.5f));
    return array<Number, 2>(fma(square, fma(odd, r, even), r), n);
}

fn exp_of(x: Number) -> Number {
    let bounded = clamp(x, Number(-87.3f), Number(88.7f));
    let reduced = reduced_exp_m1(bounded);
    let n = reduced[1];
    let half = round(n * Number(0.5f));
    let scaled = (Number(1.0f) + reduced[0]) * power_of_two(half) * power_of_two(n - half);
    let low = select(scaled, Number(0.0f), x < Number(-87.3f));
    return select(low, LARGEST, x > Number(88.72284f));
}

fn tanh_of(x: Number) -> Number {
    let reduced = reduced_exp_m1(Number(2.0f) * min(abs(x), Number(10.0f)));
    let power = power_of_two(reduced[1]);
    let numerator = fma(power, reduced[0], power - Number(1.0f));
    let size = numerator / (numerator + Number(2.0f));
    return select(size, -size, x < Number(0.0f));
}

// (sin x, cos x). Beyond 10 000 rad the reduction loses digits.
fn sin_cos_of(x: Number) -> array<Number, 2> {
    let n = round(x * Number(0.63661975f));
    let r = fma(n, Number(1.7151245e-15f), fma(n, Number(4.371139e-8f), fma(n, Number(-1.5707964f), x)));
    let square = r * r;
    var s = fma(Number(2.7557319e-6f), square, Number(-1.9841270e-4f));
    s = fma(s, square, Number(8.333334e-3f));
    s = fma(s, square, Number(-0.16666667f));
    s = fma(s * square, r, r);
    var c = fma(Number(-2.7557319e-7f), square, Number(2.4801587e-5f));
    c = fma(c, square, Number(-1.3888889e-3f));
    c = fma(c, square, Number(4.1666668e-2f));
    c = fma(c, square, Number(-0.5f));
    c = fma(c, square, Number(1.0f));
    let quadrant = Whole(n) & Whole(3);
    let swapped = (quadrant & Whole(1)) == Whole(1);
    let sine = select(s, c, swapped);
    let cosine = select(c, s, swapped);
    return array<Number, 2>(
        select(sine, -sine, quadrant >= Whole(2)),
        select(cosine, -cosine, (quadrant == Whole(1)) | (quadrant == Whole(2))),
    );
}

fn sin_of(x: Number) -> Number {
    return sin_cos_of(x)[0];
}

fn cos_of(x: Number) -> Number {
    return sin_cos_of(x)[1];
}

fn tan_of(x: Number) -> Number {
    let both = sin_cos_of(x);
    return both[0] / both[1];
}

// The logarithm of x = 2^n m by the series of ln((1 + s) / (1 - s)) with s = (m - 1) / (m + 1).
fn ln_of(x: Number) -> Number {
    let tiny = x < Number(1.1754944e-38f);
    let normal = select(x, x * Number(16777216.0f), tiny);
    let bits = bitcast<Bits>(normal);
    let digits = bits & Bits(0x007fffffu);
    let above = digits > Bits(0x003504f3u);
    let exponent = Number(Whole(bits >> Bits(23u)) - Whole(127));
    let n = exponent + select(Number(0.0f), Number(1.0f), above) - select(Number(0.0f), Number(24.0f), tiny);
    let m = bitcast<Number>(digits | select(Bits(0x3f800000u), Bits(0x3f000000u), above));
    let s = (m - Number(1.0f)) / (m + Number(1.0f));
    let square = s * s;
    var series = fma(square, Number(0.22222222f), Number(0.2857143f));
    series = fma(series, square, Number(0.4f));
    series = fma(series, square, Number(0.6666667f));
    let value = fma(n, Number(0.6931472f), fma(series * square, s, fma(n, Number(-1.9046542e-9f), Number(2.0f) * s)));
    return select(value, -LARGEST, x <= Number(0.0f));
}

// The arc tangent of a number from 0 to 1. A multiple of pi/8 is split off, so that the series is short.
fn arc_tangent(t: Number) -> Number {
    let at_least_one = select(Number(0.0f), Number(1.0f), t > Number(0.19891237f));
    let turns = select(at_least_one, Number(2.0f), t > Number(0.66817864f));
    let split = Number(0.41421357f) * turns + Number(0.17157288f) * max(turns - Number(1.0f), Number(0.0f));
    let rest = (t - split) / fma(t, split, Number(1.0f));
    let square = rest * rest;
    var series = fma(square, Number(0.11111111f), Number(-0.14285715f));
    series = fma(series, square, Number(0.2f));
    series = fma(series, square, Number(-0.33333334f));
    return fma(turns, Number(0.3926991f), fma(series * square, rest, rest));
}

fn atan2_of(y: Number, x: Number) -> Number {
    let larger = max(abs(x), abs(y));
    let angle = arc_tangent(min(abs(x), abs(y)) / max(larger, Number(1.1754944e-38f)));
    let steep = select(angle, Number(1.5707964f) - angle, abs(y) > abs(x));
    let behind = select(steep, Number(3.1415927f) - steep, x < Number(0.0f));
    return select(behind, -behind, y < Number(0.0f));
}

// x^y for x >= 0.
fn powf_of(x: Number, y: Number) -> Number {
    let value = exp_of(y * ln_of(x));
    let one_or_zero = select(Number(0.0f), Number(1.0f), y == Number(0.0f));
    let at_zero = select(one_or_zero, LARGEST, y < Number(0.0f));
    return select(value, at_zero, x == Number(0.0f));
}

fn hypot_of(x: Number, y: Number) -> Number {
    let larger = max(abs(x), abs(y));
    let ratio = min(abs(x), abs(y)) / max(larger, Number(1.1754944e-38f));
    return larger * sqrt(fma(ratio, ratio, Number(1.0f)));
}
