//! Sums whose term is not the result of the last recorded operation.

use crate::common::{assert_close, forward_gradient};
use autodiff::data::{Recorded, Sum, Summand};
use autodiff::{Function, Real, value_and_gradient};

/// The number that the term returns. The recording also contains a layer of a network.
#[derive(Clone, Copy, Debug)]
enum Term {
    /// One of the shared parameters.
    Shared(usize),
    /// One of the shared parameters. Operations outside the layer read other parameters one by one.
    SharedAmongRead(usize),
    /// A number of the datum.
    Datum(usize),
    Constant,
    /// A number that the layer reads.
    LayerInput(usize),
    /// A number that the layer computes.
    LayerRow(usize),
}

const WIDTH: usize = 8;
/// The number of shared parameters: the weights of a layer of eight rows, and a few more.
const SHARED: usize = WIDTH * WIDTH + 7;

impl Summand for Term {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let (mut own, mut rows) = ([R::zero(); WIDTH], [R::zero(); WIDTH]);
        for (own, &number) in own.iter_mut().zip(datum) {
            *own = match self {
                // In these cases, operations outside the layer read no parameter.
                Term::Shared(_) | Term::Datum(_) | Term::Constant => number.sin(),
                _ => (number * shared[SHARED - 2]).sin(),
            };
        }
        for (row, weights) in rows.iter_mut().zip(shared.chunks(WIDTH)) {
            *row = R::dot(weights, &own);
        }
        match *self {
            Term::Shared(at) | Term::SharedAmongRead(at) => shared[at],
            Term::Datum(at) => datum[at],
            Term::Constant => R::lit(2.5),
            Term::LayerInput(at) => own[at],
            Term::LayerRow(at) => rows[at],
        }
    }
}

struct Total(Sum<Term>);

impl Function for Total {
    fn eval<R: Real>(&self, shared: &[R]) -> R {
        self.0.run(shared)
    }
}

#[test]
fn a_term_may_be_any_number_of_its_record() {
    let number = |k: usize| (0.618_033_988 * (k as f64 + 1.0)).fract() * 2.0 - 1.0;
    let at: Vec<f64> = (0..SHARED).map(number).collect();
    let weight = 3 * WIDTH + 1;
    let terms = [
        Term::Shared(weight),
        Term::Shared(SHARED - 1),
        Term::SharedAmongRead(weight),
        Term::SharedAmongRead(SHARED - 2),
        Term::SharedAmongRead(SHARED - 1),
        Term::Datum(0),
        Term::Datum(WIDTH - 1),
        Term::Constant,
        Term::LayerInput(2),
        Term::LayerRow(0),
        Term::LayerRow(WIDTH - 1),
    ];
    for term in terms {
        for count in [1, 50] {
            let datum =
                |i: usize| -> Vec<f64> { (0..WIDTH).map(|k| number(i * WIDTH + k)).collect() };
            let data: Vec<Vec<f64>> = (0..count).map(datum).collect();
            let total = Total(Sum::new(term, &data));
            let (value, gradient) = value_and_gradient(|x| total.eval(x), &at);
            // The tolerance is for a few hundred terms of order one that are summed in a different order.
            let tolerance = 1e-13;
            println!("{term:?}, {count} data");
            assert_close(&[value], &[Function::eval(&total, &at)], tolerance);
            assert_close(&gradient, &forward_gradient(&total, &at), tolerance);
        }
    }
}

/// A function that returns a constant, without any operation.
struct Constant;

impl Function for Constant {
    fn eval<R: Real>(&self, _: &[R]) -> R {
        R::lit(2.5)
    }
}

#[test]
fn a_recorded_function_may_be_constant() {
    let recorded = Recorded::new(&Constant, 2).expect("no values");
    let many = recorded.values_and_gradients(&[[1.0, 2.0], [3.0, 4.0]]);
    assert_eq!(many, [(2.5, vec![0.0; 2]), (2.5, vec![0.0; 2])]);
}
