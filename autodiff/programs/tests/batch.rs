//! Sums of one function over many data: reverse mode, which replays a recording, must agree with forward mode.

use crate::common::{
    Formula, Sym, Truth, formula, forward_gradient, hessian_rows, largest_difference,
};
use autodiff::custom::{Rule, apply};
use autodiff::{Function, Mask, Real, gradient};
use autodiff_programs::data::{Sum, Summand};
use num_traits::{One, Zero};

/// Uses every operation that can be recorded, kinks and selections included.
fn everything(shared: &[Sym], datum: &[Sym]) -> Sym {
    let [a, b, c] = [shared[0], shared[1], shared[2]];
    let [x, y] = [datum[0], datum[1]];
    let mut scratch = [Sym::zero(); 6];
    scratch[0] = (a * x + b).sin() - (b - y).cos() * (Sym::lit(0.3) * x).tan();
    scratch[1] = (a - x).tanh() + (-(b * b)).exp() / (Sym::lit(2.0) + y * y);
    scratch[1] += (b * x).asinh() * y.cosh();
    scratch[2] = (c * c + y * y).sqrt() * (Sym::one() + x * x).rsqrt() + c.recip();
    scratch[3] = a.hypot(y).ln() + (b + x).atan2(c) + c.powf(a) + x.powi(2) * b.powi(3);
    scratch[4] = (a * y).abs() + (b * x).max(c * y).min(Sym::lit(3.0)) - y.signum() * a;
    scratch[5] = a.straight_through(b * x) * b.detach() + Sym::chain(b, x.fma(c, a));
    let (inside, outside) = (
        x.less(y) & !c.less_equal(x),
        a.less_equal(x) | Truth::splat(false),
    );
    scratch[0] += Sym::select(inside, a * b, c * x) * Sym::select(outside, y, b);
    // Each dot product has another combination of adjacent operands: shared and own numbers, own and own, own and
    // shared. In the last one the operands are not adjacent.
    let dots = Sym::dot(shared, &scratch[1..4]) + Sym::dot(&scratch[2..], &scratch[2..]);
    let dots = dots + Sym::dot(datum, &shared[..2]) + Sym::dot(&[b, x], &[y, a]);
    // These dot products mix shared and own numbers. The second one is not selected for all data.
    let dots = dots + Sym::dot(&shared[..2], datum);
    let dots = dots + Sym::select(inside, Sym::dot(&shared[1..], datum), x);
    dots + Sym::sum_of(datum) * Sym::sum_of(&[a, y, c]) + Sym::sum_of(&scratch)
}

/// Records a term that has the given number of shared parameters and the given length of a datum.
fn term(function: fn(&[Sym], &[Sym]) -> Sym, shared: usize, datum: usize) -> Formula {
    formula(shared + datum, |all| {
        function(&all[..shared], &all[shared..])
    })
}

struct Total<S>(Sum<S>);

impl<S: Summand> Function for Total<S> {
    fn eval<R: Real>(&self, shared: &[R]) -> R {
        self.0.run(shared)
    }
}

/// Makes data so that both sides of every choice occur.
fn data(count: usize) -> Vec<[f64; 2]> {
    let number = |i: usize, step: f64| (step * (i as f64 + 1.0)).fract() * 3.0 - 1.4;
    (0..count)
        .map(|i| [number(i, 0.618_033_988), number(i, 0.414_213_562)])
        .collect()
}

/// Makes `count` data. They repeat the whole numbers below `numbers` in turn.
fn by_turns(count: u8, numbers: u8) -> Vec<[f64; 1]> {
    (0..count).map(|i| [f64::from(i % numbers)]).collect()
}

const AT: [f64; 3] = [0.7, -0.4, 1.2];

fn assert_close(got: &[f64], expected: &[f64], what: &str) {
    // The two results add hundreds of equal terms in a different order.
    let close = got == expected || largest_difference(got, expected) <= 1e-13;
    assert!(close, "{what}: {got:?} and {expected:?}");
}

/// Asserts that the gradient is that of forward mode, which replays no recording.
fn assert_modes_agree<S: Summand>(summand: S, data: &[impl AsRef<[f64]>], at: &[f64]) {
    let total = Total(Sum::new(summand, data));
    let (reverse, forward) = (
        gradient(|x| total.eval(x), at),
        forward_gradient(&total, at),
    );
    assert_close(&reverse, &forward, &format!("{} data", data.len()));
}

#[test]
fn replayed_gradients_are_those_of_forward_mode() {
    // The counts cover fewer data than lanes, whole blocks, and a partial block.
    for count in [1, 7, 8, 32, 33, 100] {
        assert_modes_agree(term(everything, 3, 2), &data(count), &AT);
    }
}

/// A term that skips work if no lane needs it. A recording for one datum would make the same choice for all other data.
#[derive(Clone)]
struct Skips;

impl Summand for Skips {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let (a, x) = (shared[0], datum[0]);
        let positive = R::zero().less(x);
        let mut term = R::lit(3.0) * a * x;
        if positive.any() {
            term = R::select(positive, a * a * x, term);
        }
        term
    }
}

#[derive(Clone)]
struct ChoosesByZero;

impl Summand for ChoosesByZero {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let (a, x) = (shared[0], datum[0]);
        if x.is_zero() { a } else { a * a * x }
    }
}

/// Terms that branch must not be replayed. Each datum must take its own branch, in whatever order the data are.
#[test]
fn a_replay_does_not_take_the_branch_of_another_datum() {
    let data = [-1.0, 2.0, 0.0, -3.0, 0.5].map(|x| [x]);
    let turned: Vec<[f64; 1]> = data.iter().rev().copied().collect();
    for data in [&data[..], &turned] {
        assert_modes_agree(Skips, data, &[2.0]);
        assert_modes_agree(ChoosesByZero, data, &[2.0]);
    }
    // The term is 3 x where it is not positive, and 2 a x where it is.
    let skips = Total(Sum::new(Skips, &data));
    assert_eq!(gradient(|x| skips.eval(x), &[2.0]), [-12.0 + 4.0 * 2.5]);
}

#[test]
fn no_data_sum_to_zero() {
    let total = Total(Sum::new(term(everything, 3, 2), &data(0)));
    assert_eq!(Function::eval(&total, &AT), 0.0);
    assert_eq!(gradient(|x| total.eval(x), &AT), [0.0; 3]);
}

/// A gradient hands its working memory to the next gradient, which may have another number type or length. The results
/// must not depend on this.
#[test]
fn reused_memory_does_not_change_results() {
    for count in [5, 70] {
        let total = Total(Sum::new(term(everything, 3, 2), &data(count)));
        let first = gradient(|x| total.eval(x), &AT);
        hessian_rows(&total, &AT);
        let other = AT.map(|x| x + 0.3);
        assert_ne!(gradient(|x| total.eval(x), &other), first);
        assert_eq!(gradient(|x| total.eval(x), &AT), first);
    }
}

/// The sum of the terms in plain code, as a reference.
struct Terms<S, const N: usize>(S, Vec<[f64; N]>);

impl<S: Summand, const N: usize> Function for Terms<S, N> {
    fn eval<R: Real>(&self, shared: &[R]) -> R {
        let term = |datum: &[f64; N]| self.0.eval(shared, &datum.map(R::lit));
        R::sum_of(&self.1.iter().map(term).collect::<Vec<R>>())
    }
}

/// The Hessian must replay the recording on duals. Its reference is plain code, not differences, because in differences
/// detached numbers would change too.
#[test]
fn sums_nest() {
    fn check<const N: usize>(term: Formula, data: Vec<[f64; N]>, at: &[f64]) {
        let total = Total(Sum::new(term.clone(), &data));
        let plain = Terms(term, data);
        let (value, slopes) = autodiff::value_and_gradient(|x| total.eval(x), at);
        assert_close(&[value, total.eval(at)], &[plain.eval(at); 2], "value");
        assert_close(&slopes, &gradient(|x| plain.eval(x), at), "gradient");
        let [got, expected] = [hessian_rows(&total, at), hessian_rows(&plain, at)];
        assert_close(&got.concat(), &expected.concat(), "hessian");
    }
    check(term(everything, 3, 2), data(45), &AT);
    check(term(apart, 2, 1), vec![[2.0]], &[0.5, 0.2]);
}

/// A rule that rounds to zero or one, with the derivative of a smooth function.
#[derive(Clone)]
struct Softened;

impl Rule for Softened {
    fn value<R: Real>(&self, x: &[R]) -> R {
        R::select(x[0].less(R::lit(0.5)), R::zero(), R::one())
    }
    fn partials<R: Real>(&self, x: &[R], _value: R) -> Vec<R> {
        vec![x[0].cos()]
    }
}

/// A term that calls a custom rule. A recording of its operations would not contain the rule's derivative.
#[derive(Clone)]
struct WithRule;

impl Summand for WithRule {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        apply(Softened, &[shared[0] * datum[0]]) * shared[1]
    }
}

#[test]
fn a_custom_rule_inside_keeps_its_derivative() {
    let total = Total(Sum::new(WithRule, &data(40)));
    let at = [0.9, 1.7];
    assert_modes_agree(WithRule, &data(40), &at);
    let (value, by_shared) = autodiff::value_and_gradient(|x| total.eval(x), &at);
    assert_close(&[value], &[Function::eval(&total, &at)], "value");
    // Without the rule, the derivative of the rounded value would be zero almost everywhere.
    assert!(by_shared[0].abs() > 1.0);
}

/// A term with infinite partials for data that do not select it.
fn guarded(shared: &[Sym], datum: &[Sym]) -> Sym {
    let root = (shared[0] * datum[0]).sqrt();
    let used = Sym::lit(0.5).less(datum[0]);
    Sym::select(used, Sym::dot(&[root], &[root * shared[0]]), Sym::zero())
}

#[test]
fn a_term_that_is_not_selected_passes_no_infinity() {
    assert_modes_agree(term(guarded, 1, 1), &by_turns(50, 3), &[2.0]);
}

/// A term that multiplies several rows of parameters with the same numbers. The reverse sweep takes two such rows at a
/// time. Here they have equal lengths, or the second is shorter or longer, or uses the result of the first, or numbers
/// are multiplied with themselves, or rows multiply only the datum.
fn rows(shared: &[Sym], datum: &[Sym]) -> Sym {
    let own = [datum[0], datum[1], datum[1] * datum[0]];
    let mut scratch = [Sym::zero(); 4];
    for i in 0..3 {
        scratch[i] = own[i] - shared[i];
    }
    scratch[3] = Sym::dot(&shared[..3], &scratch[..3]);
    let with_the_one_before = Sym::dot(&shared[1..5], &scratch);
    let elsewhere = Sym::dot(&shared[..2], &scratch[1..3]);
    let then_shorter = Sym::dot(&shared[3..], &scratch[..3]);
    let shorter = Sym::dot(&shared[2..4], &scratch[..2]);
    let no_row = Sym::dot(&scratch[1..3], &scratch[..2]);
    let alone = Sym::dot(&shared[1..3], &scratch[..2]);
    let then_longer = Sym::dot(&shared[..2], &scratch[..2]);
    let overlapping = Sym::dot(&shared[1..4], &scratch[..3]);
    let equal = Sym::dot(&shared[4..], &scratch[..2]);
    let also_equal = Sym::dot(&shared[1..3], &scratch[..2]);
    let of_datum = Sym::dot(&shared[..2], datum);
    let also_of_datum = Sym::dot(&shared[2..4], datum);
    let with_that_row = Sym::dot(&shared[1..3], &[datum[0], of_datum]);
    scratch[3] * with_the_one_before
        + then_shorter * shorter * elsewhere
        + then_longer * overlapping.cos()
        + equal.sin() * also_equal
        + no_row * alone
        + with_that_row * of_datum
        + also_of_datum.sin()
        + Sym::dot(&scratch[..3], &scratch[..3]) * Sym::dot(shared, shared)
}

#[test]
fn rows_with_the_same_numbers_are_reversed_together() {
    let at = [0.7, -0.4, 1.2, 0.3, -0.9, 0.5];
    for count in [5, 70] {
        assert_modes_agree(term(rows, 6, 2), &data(count), &at);
    }
}

/// A term that computes the gradient of another sum. This gradient is a constant for the outer derivative.
#[derive(Clone)]
struct Inner;

impl Summand for Inner {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        shared[0] * datum[0]
    }
}

#[derive(Clone)]
struct Outer;

impl Summand for Outer {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let before = shared[0] * datum[0];
        let constant = gradient(|x| Total(Sum::new(Inner, &[[2.0], [3.0]])).eval(x), &[4.0]);
        before.sin() * R::lit(constant[0]) + before
    }
}

#[test]
fn a_sum_s_gradient_may_be_taken_within_a_term() {
    assert_modes_agree(Outer, &[[0.3], [-0.7], [1.1]], &[0.5]);
}

/// A term with two rows that multiply the same number, which may be infinite. The first row is not selected there.
fn guarded_rows(shared: &[Sym], datum: &[Sym]) -> Sym {
    let own = [datum[0].recip()];
    let guarded = Sym::dot(&shared[..1], &own);
    let plain = Sym::dot(&shared[1..], &own);
    Sym::select(Sym::lit(0.5).less(datum[0]), guarded, Sym::zero()) + plain
}

#[test]
fn a_row_that_is_not_selected_passes_no_infinity() {
    let total = Total(Sum::new(term(guarded_rows, 2, 1), &by_turns(50, 3)));
    let by_shared = gradient(|x| total.eval(x), &[2.0, 3.0]);
    // The first row has the slope 1 at 17 data and 1/2 at 16 data. The second row counts everywhere, so its slope is
    // infinite.
    assert_eq!(by_shared, [17.0 + 0.5 * 16.0, f64::INFINITY]);
}

const INPUTS: usize = 9;
const HIDDEN: usize = 11;
const PARAMETERS: usize = HIDDEN * INPUTS + HIDDEN * (INPUTS + HIDDEN) + 2 * HIDDEN;

/// A term that is a network of two layers. Each row has its own activation, and the second layer also reads the datum.
fn network(shared: &[Sym], datum: &[Sym]) -> Sym {
    let (first, rest) = shared.split_at(HIDDEN * INPUTS);
    let (second, biases) = rest.split_at(HIDDEN * (INPUTS + HIDDEN));
    let mut scratch = [Sym::zero(); INPUTS + 2 * HIDDEN];
    let (x, y) = scratch.split_at_mut(INPUTS + HIDDEN);
    x[..INPUTS].copy_from_slice(datum);
    for row in 0..HIDDEN {
        let weights = &first[row * INPUTS..][..INPUTS];
        x[INPUTS + row] = (Sym::dot(weights, datum) + biases[row]).tanh();
    }
    for row in 0..HIDDEN {
        let weights = &second[row * x.len()..][..x.len()];
        y[row] = Sym::dot(x, weights).max(Sym::zero());
    }
    Sym::dot(y, &biases[HIDDEN..]) - Sym::dot(y, &first[..HIDDEN])
}

/// Makes numbers between -1 and 1.
fn numbers(count: usize) -> Vec<f64> {
    let number = |i: usize| (0.618_033_988 * (i as f64 + 1.0)).fract() * 2.0 - 1.0;
    (0..count).map(number).collect()
}

#[test]
fn layers_of_a_network_have_the_gradient_of_their_rows() {
    let at = numbers(PARAMETERS);
    for count in [1, 7, 40] {
        let data = numbers(count * INPUTS);
        let data: Vec<_> = data.chunks_exact(INPUTS).collect();
        assert_modes_agree(term(network, PARAMETERS, INPUTS), &data, &at);
    }
}

/// Returns the sum of a layer of eight rows. `own` computes each of the numbers that the rows multiply. The first row
/// is selected only if the datum is above one half.
fn guarded_layer(weights: &[Sym], own: impl Fn() -> Sym, datum: Sym) -> Sym {
    let mut scratch = [Sym::zero(); 16];
    // Each number is the result of an operation of its own, so that the numbers are not adjacent in memory.
    for place in &mut scratch[..8] {
        *place = own();
    }
    for row in 0..8 {
        scratch[8 + row] = Sym::dot(&weights[row * 8..][..8], &scratch[..8]);
    }
    let sum = Sym::sum_of(&scratch[9..]);
    Sym::select(Sym::lit(0.5).less(datum), scratch[8], Sym::zero()) + sum
}

/// A layer that multiplies the reciprocal of the datum, which is infinite for some data. The first row is not selected
/// for these data.
fn guarded_layer_of_data(shared: &[Sym], datum: &[Sym]) -> Sym {
    guarded_layer(shared, || datum[0].recip(), datum[0])
}

#[test]
fn a_layer_s_row_that_is_not_selected_passes_no_infinity() {
    let total = Total(Sum::new(
        term(guarded_layer_of_data, 64, 1),
        &by_turns(50, 3),
    ));
    let by_shared = gradient(|x| total.eval(x), &[0.5; 64]);
    assert_eq!(by_shared[..8], [17.0 + 0.5 * 16.0; 8]);
    assert_eq!(by_shared[8..], [f64::INFINITY; 56]);
}

#[test]
fn an_infinite_weight_of_a_row_that_is_not_selected_passes_nothing() {
    let mut at = [0.5; 65];
    at[0] = f64::INFINITY;
    let total = Total(Sum::new(term(guarded_layer_of_weights, 65, 1), &[[0.0]; 5]));
    assert_eq!(gradient(|x| total.eval(x), &at)[64], 5.0 * 7.0 * 8.0 * 0.5);
}

/// Like [`guarded_layer_of_data`], but the multiplied numbers depend on a parameter.
fn guarded_layer_of_weights(shared: &[Sym], datum: &[Sym]) -> Sym {
    guarded_layer(shared, || shared[64] + datum[0], datum[0])
}

#[test]
fn f32_has_lanes_too() {
    let total = Total(Sum::new(term(everything, 3, 2), &data(100)));
    let single = gradient(|x| total.eval(x), &AT.map(|x| x as f32));
    for (s, d) in single.iter().zip(gradient(|x| total.eval(x), &AT)) {
        // The tolerance is for a hundred terms in single precision, whose partials are as large as the sum.
        assert!(
            (f64::from(*s) - d).abs() <= 1e-4 * d.abs().max(100.0),
            "{s} and {d}"
        );
    }
}

/// The square root of the excess of a datum over a bound. At the bound, the cotangent of the choice is infinite. Data
/// in other lanes choose the other side and have finite cotangents.
fn above(shared: &[Sym], datum: &[Sym]) -> Sym {
    (datum[0] - shared[0]).max(Sym::zero()).sqrt()
}

#[test]
fn an_infinite_cotangent_passes_only_the_chosen_side() {
    for count in [3, 40] {
        let data = by_turns(count, 5);
        assert_modes_agree(term(above, 1, 1), &data, &[0.5]);
        assert!(
            gradient(
                |x| Total(Sum::new(term(above, 1, 1), &data)).eval(x),
                &[0.5]
            )[0] < 0.0
        );
    }
}

/// A term in which some values have no derivative, and others have the derivative of another function.
fn apart(shared: &[Sym], datum: &[Sym]) -> Sym {
    let (a, b) = (shared[0], shared[1]);
    let soft = (a * a * a).straight_through(a * b);
    a.detach() * b * datum[0] + soft * b
}

const WIDTH: usize = 8;
/// The number of shared parameters: the weights of a layer of eight rows, and a few more.
const SHARED: usize = WIDTH * WIDTH + 7;

/// Returns every kind of number that a term may return: shared parameters, inside and outside the layer's weights,
/// numbers of the datum, a constant, and numbers that the layer reads and computes. If `reads` is true, operations
/// outside the layer read a parameter.
fn any_number(all: &[Sym], reads: bool) -> Vec<Sym> {
    let (shared, datum) = all.split_at(SHARED);
    let read = if reads {
        shared[SHARED - 2]
    } else {
        Sym::lit(1.0)
    };
    let own: Vec<Sym> = datum.iter().map(|&x| (x * read).sin()).collect();
    let rows = shared.chunks_exact(WIDTH).take(WIDTH);
    let rows: Vec<Sym> = rows.map(|weights| Sym::dot(weights, &own)).collect();
    let weight = shared[3 * WIDTH + 1];
    let end = &shared[SHARED - 2..];
    let (last, constant) = (datum[WIDTH - 1], Sym::lit(2.5));
    vec![
        weight,
        end[0],
        end[1],
        datum[0],
        last,
        constant,
        own[2],
        rows[0],
        rows[WIDTH - 1],
    ]
}

#[test]
fn a_term_may_be_any_number_of_its_record() {
    let at = numbers(SHARED);
    for (reads, place) in [true, false]
        .into_iter()
        .flat_map(|reads| (0..9).map(move |k| (reads, k)))
    {
        let term = formula(SHARED + WIDTH, |all| any_number(all, reads)[place]);
        for count in [1, 50] {
            let data = numbers(count * WIDTH);
            let data: Vec<_> = data.chunks_exact(WIDTH).collect();
            println!("number {place}, {count} data");
            let total = Total(Sum::new(term.clone(), &data));
            let (value, _) = autodiff::value_and_gradient(|x| total.eval(x), &at);
            assert_close(&[value], &[Function::eval(&total, &at)], "value");
            assert_modes_agree(term.clone(), &data, &at);
        }
    }
}
