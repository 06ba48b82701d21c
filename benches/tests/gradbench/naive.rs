//! The objectives once more, number by number, as functions of a flat list of variables.

use autodiff::{Dual, Real, VectorFunction};
use serde_json::Value;

/// All numbers of a value, in order.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// A count of an input.
pub(crate) fn count(value: &Value) -> usize {
    value.as_u64().expect("a count") as usize
}

/// The columns of a Jacobian, one forward pass for each.
pub(crate) fn columns(function: &impl VectorFunction, x: &[f64]) -> Vec<Vec<f64>> {
    let column = |i: usize| {
        let mut moving: Vec<Dual<f64, 1>> = x.iter().map(|&x| Dual::constant(x)).collect();
        moving[i] = Dual::variable(x[i], 0);
        let y = function.eval(&moving);
        y.into_iter().map(|y| y.tangent[0]).collect()
    };
    (0..x.len()).map(column).collect()
}

/// The gradient of a function with one value.
pub(crate) fn gradient(function: &impl VectorFunction, x: &[f64]) -> Vec<f64> {
    columns(function, x).concat()
}

pub(crate) struct Square;

impl VectorFunction for Square {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        vec![x[0] * x[0]]
    }
}

/// Fits a polynomial to so many points.
pub(crate) struct LeastSquares(pub(crate) usize);

impl VectorFunction for LeastSquares {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let mut sum = R::zero();
        for i in 0..self.0 {
            let t = -1.0 + 2.0 * i as f64 / (self.0 as f64 - 1.0);
            let sign = if t == 0.0 { 0.0 } else { t.signum() };
            let mut gap = R::lit(sign);
            for (j, &x) in x.iter().enumerate() {
                gap -= x * R::lit(t.powi(j as i32));
            }
            sum += gap * gap;
        }
        vec![sum / R::lit(2.0)]
    }
}

/// Without taking the largest out: for small numbers.
pub(crate) struct LogSumExp;

impl VectorFunction for LogSumExp {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let mut sum = R::zero();
        for x in x {
            sum += x.exp();
        }
        vec![sum.ln()]
    }
}

/// By all permutations.
pub(crate) struct Determinant(pub(crate) usize);

impl VectorFunction for Determinant {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let mut sum = R::zero();
        self.permutations(x, &mut Vec::new(), R::one(), &mut sum);
        vec![sum]
    }
}

impl Determinant {
    fn permutations<R: Real>(&self, x: &[R], taken: &mut Vec<usize>, product: R, sum: &mut R) {
        let row = taken.len();
        if row == self.0 {
            *sum += product;
            return;
        }
        for column in 0..self.0 {
            if taken.contains(&column) {
                continue;
            }
            // An earlier row with a later column is an inversion.
            let inversions = taken.iter().filter(|&&before| before > column).count();
            let sign = if inversions % 2 == 0 { 1.0 } else { -1.0 };
            let product = product * R::lit(sign) * x[row * self.0 + column];
            taken.push(column);
            self.permutations(x, taken, product, sum);
            taken.pop();
        }
    }
}

/// All of `y` after so many steps.
pub(crate) struct Ode(pub(crate) usize);

impl Ode {
    fn slope<R: Real>(x: &[R], y: &[R]) -> Vec<R> {
        let mut slope = vec![x[0]];
        for i in 1..x.len() {
            slope.push(x[i] * y[i - 1]);
        }
        slope
    }
}

impl VectorFunction for Ode {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let h = R::lit(2.0 / self.0 as f64);
        let mut y = vec![R::zero(); x.len()];
        let along = |y: &[R], slope: &[R], part: f64| -> Vec<R> {
            let pairs = y.iter().zip(slope);
            pairs.map(|(&y, &k)| y + h * R::lit(part) * k).collect()
        };
        for _ in 0..self.0 {
            let k1 = Self::slope(x, &y);
            let k2 = Self::slope(x, &along(&y, &k1, 0.5));
            let k3 = Self::slope(x, &along(&y, &k2, 0.5));
            let k4 = Self::slope(x, &along(&y, &k3, 1.0));
            for (slope, part) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                y = along(&y, &slope, part / 6.0);
            }
        }
        y
    }
}

/// Only the last number of a function.
pub(crate) struct Last<F>(pub(crate) F);

impl<F: VectorFunction> VectorFunction for Last<F> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        self.0.eval(x).split_off(x.len() - 1)
    }
}

pub(crate) struct KMeans {
    pub(crate) points: Vec<f64>,
    pub(crate) dimension: usize,
}

impl VectorFunction for KMeans {
    fn eval<R: Real>(&self, centroids: &[R]) -> Vec<R> {
        let mut cost = R::zero();
        for point in self.points.chunks(self.dimension) {
            let mut least = R::lit(f64::INFINITY);
            for centroid in centroids.chunks(self.dimension) {
                let mut distance = R::zero();
                for (&p, &c) in point.iter().zip(centroid) {
                    distance += (R::lit(p) - c) * (R::lit(p) - c);
                }
                least = least.min(distance);
            }
            cost += least;
        }
        vec![cost]
    }
}

/// The gradient by the diagonal of the Hessian, by two nested forward passes a number.
pub(crate) fn newton(function: &impl VectorFunction, x: &[f64]) -> Vec<f64> {
    let quotient = |i: usize| {
        let lift = |&x: &f64| Dual::constant(Dual::constant(x));
        let mut moving: Vec<Dual<Dual<f64, 1>, 1>> = x.iter().map(lift).collect();
        moving[i] = Dual::variable(Dual::variable(x[i], 0), 0);
        let slope = function.eval(&moving)[0].tangent[0];
        slope.value / slope.tangent[0]
    };
    (0..x.len()).map(quotient).collect()
}
