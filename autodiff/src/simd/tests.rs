//! Tests that the results of every lane type are bit-identical to those of scalars.

#[cfg(lanes = "neon")]
use super::aarch64::{F32x4, F64x2};
#[cfg(lanes = "simd128")]
use super::wasm::{F32x4, F64x2};
use super::{Lane, Vectorized, WIDEST};
use crate::elementary::Elementary;
use crate::real::{Mask, Real};
use crate::simd::kernel;

/// The number of tested functions.
const FUNCTIONS: usize = 29;

#[inline(always)]
fn functions<S: Real, R: Lane<S>>(x: R) -> [R; FUNCTIONS] {
    let small = x.less(R::lit(0.5)) & R::lit(-0.5).less_equal(x);
    let large = !(x.abs().less(R::lit(3.0)) | R::lit(1e3).less(x));
    [
        x.exp(),
        x.tanh(),
        R::tanh_each([x * x, -x, x])[1],
        x.sin(),
        x.cos(),
        x.abs().sqrt(),
        x.abs().rsqrt(),
        x.abs().ln(),
        x.atan2(R::lit(2.0)),
        x.abs().powf(R::lit(0.3)),
        x.powi(3),
        x.powi(-8),
        x.powi(11),
        x.elementary(Elementary::Asin),
        x.elementary(Elementary::Acos),
        x.elementary(Elementary::Sinh),
        x.elementary(Elementary::Cosh),
        x.elementary(Elementary::Asinh),
        x.elementary(Elementary::Acosh),
        x.elementary(Elementary::Atanh),
        x.elementary(Elementary::ExpM1),
        x.elementary(Elementary::Ln1p),
        x.elementary(Elementary::Log2),
        x.elementary(Elementary::Log10),
        x.elementary(Elementary::Cbrt),
        R::select(small, x.signum(), x.max(R::lit(1.0))),
        R::select(large, x.clamp(R::lit(-5.0), R::lit(5.0)), -x),
        R::chain(x.recip(), x - x.abs()),
        (x - R::lit(0.25)) * x / R::lit(3.0) + R::select(x.finite(), x, R::one()),
    ]
}

/// Applies all functions to all numbers. The last register is only partly filled.
struct All<'a, S>(&'a [S], &'a mut [Vec<S>; FUNCTIONS]);

#[kernel]
impl<S: Real> Vectorized<S> for All<'_, S> {
    type Output = usize;
    fn run<L: Lane<S>>(self) -> usize {
        let mut place = 0;
        while place < self.0.len() {
            let y = functions(L::load_up_to(&self.0[place..]));
            for k in 0..FUNCTIONS {
                y[k].store_up_to(&mut self.1[k][place..]);
            }
            place += L::N;
        }
        L::N
    }
}

/// Returns the arguments: numbers of all sizes and both signs, and special values. The number of arguments is prime, so
/// it is not a multiple of any register width.
fn arguments() -> Vec<f64> {
    let spread = (0..4000).map(|k| 750.0 * (f64::from(k) / 2000.0 - 1.0) + 0.37e-3);
    let small = (0..4000).map(|k| 1e-30_f64.powf(f64::from(k) / 4000.0) * f64::from(1 - k % 2 * 2));
    let special = [
        f64::NAN,
        0.0,
        -0.0,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e-320,
        0.5,
        -0.5,
        1.0,
    ];
    spread.chain(small).chain(special).collect()
}

fn check<S: Real>(enter: impl FnOnce(All<S>) -> usize, bits: impl Fn(S) -> u64) {
    let x: Vec<S> = arguments().into_iter().map(S::lit).collect();
    let mut wide: [Vec<S>; FUNCTIONS] = std::array::from_fn(|_| vec![S::zero(); x.len()]);
    let mut narrow = wide.clone();
    let lanes = enter(All(&x, &mut wide));
    assert!(
        !x.len().is_multiple_of(lanes),
        "the last register must be partly filled"
    );
    All(&x, &mut narrow).run::<S>();
    for k in 0..FUNCTIONS {
        for (place, (w, n)) in wide[k].iter().zip(&narrow[k]).enumerate() {
            let nan = !(w.less_equal(*w).any() | n.less_equal(*n).any());
            let (x, same) = (x[place], nan || bits(*w) == bits(*n));
            assert!(
                same,
                "function {k} at {x:?}: {w:?} in {lanes} lanes, {n:?} as a scalar"
            );
        }
    }
}

fn single_bits(x: f32) -> u64 {
    x.to_bits().into()
}

#[cfg(lanes = "x86")]
#[test]
fn every_register_has_the_bits_of_scalars() {
    #![allow(unsafe_code)]
    use super::enter::{f32_avx2, f32_avx512, f64_avx2, f64_avx512};
    // SAFETY: the test checks that the processor has the instructions.
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        check(|all| unsafe { f64_avx2(all) }, f64::to_bits);
        check(|all| unsafe { f32_avx2(all) }, single_bits);
    }
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
        check(|all| unsafe { f64_avx512(all) }, f64::to_bits);
        check(|all| unsafe { f32_avx512(all) }, single_bits);
    }
}

#[cfg(any(lanes = "neon", lanes = "simd128"))]
#[test]
fn every_register_has_the_bits_of_scalars() {
    check(|all| all.run::<F64x2>(), f64::to_bits);
    check(|all| all.run::<F32x4>(), single_bits);
}

/// Masks the numbers 1, 2, ... with every combination of mask bits, interleaves them, and checks each result.
struct MoveLanes;

#[kernel]
impl<S: Real> Vectorized<S> for MoveLanes {
    type Output = usize;
    fn run<L: Lane<S>>(self) -> usize {
        let numbers: Vec<S> = (1..=L::N).map(|k| S::lit(k as f64)).collect();
        let lane = L::load(&numbers);
        let zipped = lane.zip(lane + L::lit(100.0));
        for (half, zipped) in zipped.into_iter().enumerate() {
            let mut by_turns = vec![S::zero(); L::N];
            zipped.store(&mut by_turns);
            for (k, number) in (half * L::N..).zip(by_turns) {
                let more = if k % 2 == 0 { 0.0 } else { 100.0 };
                assert!(is(number, numbers[k / 2] + S::lit(more)));
            }
        }
        let mut masked = vec![S::zero(); L::N];
        for bits in 0..=u16::MAX >> (WIDEST - L::N) {
            L::select(L::mask(bits), lane, L::zero()).store(&mut masked);
            for k in 0..L::N {
                let is_set = bits >> k & 1 == 1;
                assert!(is(masked[k], if is_set { numbers[k] } else { S::zero() }));
            }
        }
        L::N
    }
}

#[inline(always)]
fn is<S: Real>(number: S, expected: S) -> bool {
    (number.less_equal(expected) & expected.less_equal(number)).all()
}

#[test]
fn lanes_are_masked_and_interleaved() {
    #![allow(unsafe_code)]
    assert_eq!(MoveLanes.run::<f64>(), 1);
    // SAFETY: the test checks that the processor has the instructions.
    #[cfg(lanes = "x86")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        assert_eq!(unsafe { super::enter::f64_avx2(MoveLanes) }, 4);
        assert_eq!(unsafe { super::enter::f32_avx2(MoveLanes) }, 8);
    }
    #[cfg(any(lanes = "neon", lanes = "simd128"))]
    assert_eq!(
        [
            Vectorized::<f64>::run::<F64x2>(MoveLanes),
            Vectorized::<f32>::run::<F32x4>(MoveLanes)
        ],
        [2, 4]
    );
    f64::vectorize(MoveLanes);
    f32::vectorize(MoveLanes);
}
