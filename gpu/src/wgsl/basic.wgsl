// Elementary functions in single precision. The formulas are those of `math/primitive.rs`, which names their source.

const LARGEST: f32 = 3.4028235e38f;

// 2^n for a whole number n from -126 to 127.
fn power_of_two(n: f32) -> f32 {
    return bitcast<f32>(u32(i32(n) + 127) << 23u);
}

// (e^r - 1, n), where x = n ln 2 + r and |r| <= ln(2)/2.
fn reduced_exp_m1(x: f32) -> vec2<f32> {
    let n = round(x * 1.442695f);
    let r = fma(n, 1.9046542e-9f, fma(n, -0.6931472f, x));
    let square = r * r;
    var odd = 1.9841270e-4f;
    var even = 1.3888889e-3f;
    odd = fma(odd, square, 8.333334e-3f);
    even = fma(even, square, 4.1666668e-2f);
    odd = fma(odd, square, 0.16666667f);
    even = fma(even, square, 0.5f);
    return vec2<f32>(fma(square, fma(odd, r, even), r), n);
}

fn exp_of(x: f32) -> f32 {
    let bounded = clamp(x, -87.3f, 88.7f);
    let reduced = reduced_exp_m1(bounded);
    let half = round(reduced.y * 0.5f);
    let scaled = (1.0f + reduced.x) * power_of_two(half) * power_of_two(reduced.y - half);
    let low = select(scaled, 0.0f, x < -87.3f);
    return select(low, LARGEST, x > 88.72284f);
}

fn tanh_of(x: f32) -> f32 {
    let reduced = reduced_exp_m1(2.0f * min(abs(x), 10.0f));
    let power = power_of_two(reduced.y);
    let numerator = fma(power, reduced.x, power - 1.0f);
    let size = numerator / (numerator + 2.0f);
    return select(size, -size, x < 0.0f);
}

// (sin x, cos x). Beyond 10 000 rad the reduction loses digits.
fn sin_cos_of(x: f32) -> vec2<f32> {
    let n = round(x * 0.63661975f);
    let r = fma(n, 1.7151245e-15f, fma(n, 4.371139e-8f, fma(n, -1.5707964f, x)));
    let square = r * r;
    var s = fma(2.7557319e-6f, square, -1.9841270e-4f);
    s = fma(s, square, 8.333334e-3f);
    s = fma(s, square, -0.16666667f);
    s = fma(s * square, r, r);
    var c = fma(-2.7557319e-7f, square, 2.4801587e-5f);
    c = fma(c, square, -1.3888889e-3f);
    c = fma(c, square, 4.1666668e-2f);
    c = fma(c, square, -0.5f);
    c = fma(c, square, 1.0f);
    let quadrant = i32(n) & 3;
    let swapped = (quadrant & 1) == 1;
    let sine = select(s, c, swapped);
    let cosine = select(c, s, swapped);
    return vec2<f32>(
        select(sine, -sine, quadrant >= 2),
        select(cosine, -cosine, quadrant == 1 || quadrant == 2),
    );
}

fn sin_of(x: f32) -> f32 {
    return sin_cos_of(x).x;
}

fn cos_of(x: f32) -> f32 {
    return sin_cos_of(x).y;
}

fn tan_of(x: f32) -> f32 {
    let both = sin_cos_of(x);
    return both.x / both.y;
}

// The logarithm of x = 2^n m by the series of ln((1 + s) / (1 - s)) with s = (m - 1) / (m + 1).
fn ln_of(x: f32) -> f32 {
    let tiny = x < 1.1754944e-38f;
    let normal = select(x, x * 16777216.0f, tiny);
    let bits = bitcast<u32>(normal);
    let above = (bits & 0x007fffffu) > 0x003504f3u;
    let n = f32(i32(bits >> 23u) - 127) + select(0.0f, 1.0f, above) - select(0.0f, 24.0f, tiny);
    let m = bitcast<f32>((bits & 0x007fffffu) | select(0x3f800000u, 0x3f000000u, above));
    let s = (m - 1.0f) / (m + 1.0f);
    let square = s * s;
    var series = fma(square, 0.22222222f, 0.2857143f);
    series = fma(series, square, 0.4f);
    series = fma(series, square, 0.6666667f);
    let value = fma(n, 0.6931472f, fma(series * square, s, fma(n, -1.9046542e-9f, 2.0f * s)));
    return select(value, -LARGEST, x <= 0.0f);
}

// The arc tangent of a number from 0 to 1. A multiple of pi/8 is split off, so that the series is short.
fn arc_tangent(t: f32) -> f32 {
    let turns = select(select(0.0f, 1.0f, t > 0.19891237f), 2.0f, t > 0.66817864f);
    let split = 0.41421357f * turns + 0.17157288f * max(turns - 1.0f, 0.0f);
    let rest = (t - split) / fma(t, split, 1.0f);
    let square = rest * rest;
    var series = fma(square, 0.11111111f, -0.14285715f);
    series = fma(series, square, 0.2f);
    series = fma(series, square, -0.33333334f);
    return fma(turns, 0.3926991f, fma(series * square, rest, rest));
}

fn atan2_of(y: f32, x: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    let angle = arc_tangent(min(abs(x), abs(y)) / max(larger, 1.1754944e-38f));
    let steep = select(angle, 1.5707964f - angle, abs(y) > abs(x));
    let behind = select(steep, 3.1415927f - steep, x < 0.0f);
    return select(behind, -behind, y < 0.0f);
}

// x^y for x >= 0.
fn powf_of(x: f32, y: f32) -> f32 {
    let value = exp_of(y * ln_of(x));
    let at_zero = select(select(0.0f, 1.0f, y == 0.0f), LARGEST, y < 0.0f);
    return select(value, at_zero, x == 0.0f);
}

fn hypot_of(x: f32, y: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    let ratio = min(abs(x), abs(y)) / max(larger, 1.1754944e-38f);
    return larger * sqrt(fma(ratio, ratio, 1.0f));
}
