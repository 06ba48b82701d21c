//! Reports about code: loops, nesting, recordings, rules and methods of num-traits. Each test names its reports.

use ::nalgebra::DMatrix;
use autodiff::custom::{Rule, apply};
use autodiff::{Dual, Element, Function, Real, Tape, Var, gradient, hessian};
use num_traits::Float;

use crate::common::{Sym, assert_gradient, formula, formulas, forward_gradient, hessian_rows};

/// The remainder with the sign of the first argument. It is linear in both arguments between its jumps.
struct Remainder;

impl Function for Remainder {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        (Element(x[0]) % Element(x[1])).0
    }
}

/// shader-slang/slang#10071, jax-ml/jax#11466: the slope by the divisor was 0, or off by one for a negative number.
#[test]
fn the_remainder_moves_with_its_divisor() {
    for (x, value) in [([5.5, 2.0], 1.5), ([-19.0, 3.0], -1.0), ([19.0, -3.0], 1.0)] {
        assert_eq!(Remainder.eval(&x), value);
        // Small steps do not reach a jump, and in a linear function differences are exact for steps of powers of two.
        let step = 2f64.powi(-10);
        let slope = |x: [f64; 2]| (Remainder.eval(&x) - value) / step;
        let slopes = [slope([x[0] + step, x[1]]), slope([x[0], x[1] + step])];
        assert_gradient(&Remainder, &x, &slopes);
    }
}

/// HIPS/autograd#566: rounded numbers are flat. stan-dev/stan#857: `floor` of NaN is NaN.
#[test]
fn rounding_is_flat_and_passes_a_nan_on() {
    for (x, slope) in [(2.3, 0.0), (-0.7, 0.0)] {
        let x = Element(Dual::<f64, 1>::variable(x, 0));
        for rounded in [x.round(), x.floor(), x.ceil(), x.trunc()] {
            assert_eq!(rounded.0.tangent, [slope]);
        }
        assert_eq!(x.fract().0.tangent, [1.0]);
    }
    assert!(Element(f64::NAN).floor().0.is_nan());
}

/// JuliaDiff/ForwardDiff.jl#83 and #313, JuliaDiff/ReverseDiff.jl#45: `d/dx (x d/dy (x y) at 1)` at 4 is `2 x`.
#[test]
fn inner_and_outer_derivatives_are_not_confused() {
    struct Inner<R>(R);
    impl<R: Real> Inner<R> {
        fn by_forward(&self) -> R {
            let product = Dual::<R, 1>::constant(self.0) * Dual::variable(R::one(), 0);
            product.tangent[0]
        }
        fn by_reverse(&self) -> R {
            gradient(|y| Var::constant(self.0) * y[0], &[R::one()])[0]
        }
    }
    let x = Dual::<f64, 1>::variable(4.0, 0);
    assert_eq!((x * Inner(x).by_forward()).tangent, [8.0]);
    assert_eq!((x * Inner(x).by_reverse()).tangent, [8.0]);
    assert_eq!(gradient(|x| x[0] * Inner(x[0]).by_forward(), &[4.0]), [8.0]);
    assert_eq!(gradient(|x| x[0] * Inner(x[0]).by_reverse(), &[4.0]), [8.0]);
}

/// vgvassilev/clad#277, #440 and #710, NVIDIA/warp#1293, taichi-dev/taichi#2505: variables that loops declare or
/// overwrite.
#[test]
fn loops_accumulate_what_they_add() {
    let sums = formulas(2, |x| {
        let mut skipped = x[0] * Sym::lit(11.0);
        let mut filled = [Sym::lit(0.0); 5];
        for i in 0..3 {
            let local = x[0] * Sym::lit(i.into());
            skipped += local;
            if i < 3 {
                continue;
            }
            skipped = local;
        }
        for entry in &mut filled {
            let reference = entry;
            *reference = x[0];
        }
        let mut nested = x[1];
        for i in 0..3 {
            for _ in 0..i {
                nested *= x[0];
            }
        }
        vec![skipped, Sym::sum_of(&filled), nested]
    });
    let power = formula(2, |x| x[1] * x[0].powi(3));
    let x = [2.0, 5.0];
    // The first two gradients are those of the reports.
    let expected = [
        vec![14.0, 0.0],
        vec![5.0, 0.0],
        forward_gradient(&power, &x),
    ];
    for (k, expected) in expected.iter().enumerate() {
        let one = formula(2, |x| sums.values(x)[k]);
        assert_gradient(&one, &x, expected);
    }
}

/// pytorch/pytorch#18619: a second sweep over the same recording gave other second derivatives.
#[test]
fn second_derivatives_are_the_same_in_each_sweep() {
    let product = formula(4, |x| x[0] * x[1] * x[2] * x[3]);
    let mut tape = Tape::new();
    let slopes = tape.record(&[2.0, 3.0, 4.0, 5.0], |x| gradient(|x| product.eval(x), x));
    let expected = hessian_rows(&product, &[2.0, 3.0, 4.0, 5.0]);
    for _ in 0..2 {
        assert_eq!(tape.pullback(&slopes, &[1.0, 0.0, 0.0, 0.0]), expected[0]);
    }
}

/// pytorch/pytorch#58509 and #76185: an intermediate result that a rule keeps must itself be differentiated.
#[test]
fn partials_of_a_rule_are_differentiated() {
    #[derive(Clone)]
    struct SquareOfTwice;
    impl Rule for SquareOfTwice {
        fn value<R: Real>(&self, x: &[R]) -> R {
            let twice = x[0] + x[0];
            twice * twice
        }
        fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
            let twice = x[0] + x[0];
            vec![R::lit(4.0) * twice]
        }
    }
    struct Applied;
    impl Function for Applied {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            apply(SquareOfTwice, x)
        }
    }
    let written = formula(1, |x| (x[0] + x[0]).powi(2));
    assert_gradient(&Applied, &[3.0], &forward_gradient(&written, &[3.0]));
    assert_eq!(
        hessian_rows(&Applied, &[3.0]),
        hessian_rows(&written, &[3.0])
    );
}

/// pytorch/pytorch#5534, FluxML/Flux.jl#509, autodiff/autodiff#314: long chains and sums overflowed the stack.
#[test]
fn a_chain_of_a_million_operations_needs_no_stack() {
    const LENGTH: usize = if cfg!(miri) { 1000 } else { 1_000_000 };
    let chain = |x: &[Var<f64>]| (0..LENGTH).fold(x[0], |y, _| -y);
    assert_eq!(gradient(chain, &[1.0]), [1.0]);
    let sum = |x: &[Var<f64>]| (0..LENGTH).map(|_| x[0]).sum();
    assert_eq!(gradient(sum, &[1.0]), [LENGTH as f64]);
}

/// pytorch/pytorch#192521: second derivatives of a determinant at a matrix with equal singular values. They are those of
/// the sum over permutations.
#[test]
fn the_determinant_of_the_identity_has_second_derivatives() {
    fn by_factors<R: Real>(x: &[R]) -> R {
        DMatrix::from_row_slice(4, 4, &x.iter().copied().map(Element).collect::<Vec<_>>())
            .determinant()
            .0
    }
    /// Expands along the first row.
    fn expanded<R: Real>(x: &[R], size: usize) -> R {
        let minor = |column: usize| -> Vec<R> {
            let keep = |&k: &usize| k >= size && k % size != column;
            (0..x.len()).filter(keep).map(|k| x[k]).collect()
        };
        let term = |column: usize| {
            let sign = [1.0, -1.0][column % 2];
            x[column] * expanded(&minor(column), size - 1) * R::lit(sign)
        };
        if size == 1 {
            x[0]
        } else {
            (0..size).map(term).sum()
        }
    }
    let identity: Vec<f64> = (0..16).map(|k| f64::from(u8::from(k % 5 == 0))).collect();
    let expected = hessian(|x| expanded(x, 4), &identity);
    assert_eq!(
        hessian(by_factors, &identity).as_slice(),
        expected.as_slice()
    );
}
