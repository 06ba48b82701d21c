//! Formulas that read as on paper. In closures they use float constants, references and native comparisons; generic
//! code uses `lit`.

use autodiff::{
    Dual, Real, Tape, Var, gradient, gradient_forward, hessian, hessian_vector, jacobian, lit,
    value_and_gradient_array, value_and_jacobian_array,
};

/// Uses every operator with a float or a reference on either side.
macro_rules! formula {
    ($number:ty, $x:expr) => {{
        let (x, y) = (&$x[0], $x[1]);
        let mut z = 2.0 * x + y * 3.0 - 1.0;
        z += 0.5;
        z -= x;
        z *= 1.5;
        z /= &y;
        z *= &y;
        z /= 0.75;
        let scaled = (1.0 - x) / (4.0 - &y) + 1.0 / x * &(x / 2.0) + -x * x;
        let pairs = [*x, y, z, scaled];
        let sums = pairs.iter().sum::<$number>() + pairs.iter().map(|p| p * p).sum::<$number>();
        let z = sums * pairs.iter().product::<$number>();
        if z > 0.0 && y != 7.0 { z.powi(2) } else { -&z }
    }};
}

/// The same formula in generic code.
fn generic<R: Real>(x: &[R]) -> R {
    let (x, y) = (x[0], x[1]);
    let mut z = lit(2.0) * x + y * lit(3.0) - lit(1.0);
    z += R::lit(0.5);
    z -= x;
    z *= R::lit(1.5);
    z /= y;
    z *= y;
    z /= R::lit(0.75);
    let scaled = (lit(1.0) - x) / (lit(4.0) - y) + lit(1.0) / x * (x / lit(2.0)) - x * x;
    let pairs = [x, y, z, scaled];
    let sums = pairs.iter().sum::<R>() + pairs.iter().map(|&p| p * p).sum::<R>();
    let z = sums * pairs.iter().product::<R>();
    R::select(R::zero().less(z), z.powi(2), -z)
}

#[test]
fn closures_take_floats_and_references_as_generic_code_takes_literals() {
    for x in [[0.5, 1.25], [-0.5, 0.75], [2.0, 7.0]] {
        // The numbers are halves and quarters, so only quotients are rounded. Both forms of the formula compute the
        // same quotients.
        let expected = gradient(generic, &x);
        if x[1] != 7.0 {
            assert_eq!(gradient(|x| formula!(Var<f64>, x), &x), expected);
            let moving = x.map(|x| Dual::<f64, 1>::variable(x, 0));
            assert_eq!(formula!(Dual<f64, 1>, moving), generic(&moving));
            assert_eq!(
                formula!(Dual<f64, 1>, moving).tangent,
                generic(&moving).tangent
            );
        }
        let along = Dual::<f64, 1>::variable(x[0], 0);
        assert_eq!((2.0 * along).tangent, [2.0]);
    }
    // Constants must not be recorded, on either side of an operator.
    assert_eq!(gradient(|x| 3.0 - x[0] * 0.0, &[5.0]), [-0.0]);
}

/// Drivers must accept closures that consume what they capture. The Jacobian of a function without arguments must have
/// empty rows.
#[test]
fn drivers_take_any_closure() {
    let owned = Box::new(4.0);
    let (slope, product) = hessian_vector(move |x| *owned * x[0].powi(3), &[2.0], &[1.0]);
    assert_eq!((slope, product), (vec![48.0], vec![48.0]));
    let empty = jacobian(|_: &[Dual<f64, 8>]| vec![Dual::lit(1.0); 3], &[]);
    assert_eq!((empty.rows(), empty.columns()), (3, 0));
}

#[test]
fn drivers_of_arrays_have_the_results_of_slices() {
    fn values<R: Real>(x: &[R]) -> Vec<R> {
        let value = |i: usize| {
            x.iter()
                .fold(R::one(), |a, &x| a * (x + R::lit(i as f64)).sin())
        };
        (0..3).map(value).collect()
    }
    let point: [f64; 19] = std::array::from_fn(|i| 0.9 + 0.05 * i as f64);
    let as_arrays = value_and_jacobian_array(|x| [0, 1, 2].map(|i| values(x)[i]), point);
    assert_eq!(jacobian(values, &point), as_arrays.1);
    assert_eq!(values(&point), as_arrays.0);
    let (value, slopes) = value_and_gradient_array(|x| values(x)[2], point);
    assert_eq!((value, slopes), (as_arrays.0[2], as_arrays.1[2]));
    assert_eq!(gradient_forward(|x| values(x)[2], &point), slopes);
}

#[test]
fn a_primal_is_plain_in_every_number() {
    let seen = gradient(|x| Var::lit((2.0 * x[0]).primal()) * x[0], &[3.0]);
    assert_eq!(seen, [6.0]);
    assert_eq!(hessian(|x| x[0].primal() * x[0], &[3.0]), [[0.0]]);
    assert_eq!(0.5f32.primal(), 0.5);
}

/// Every method of two numbers, with constants of each kind that generic code can pass.
fn of_floats<R: Real>(x: &[R]) -> R {
    let (x, y) = (x[0], x[1]);
    let powers = x.max(0.25).powf(2.5) + y.min(-0.5).atan2(1.0) + x.hypot(3.0);
    let clamped = (x * lit(4.0)).clamp(-1.0, 1.5) * y.clamp(R::lit(-2.0), lit(2.0));
    let chosen = R::select(x.less(0.5) | y.less_equal(-4.0), x, y);
    powers + clamped + chosen + R::dot(&[x, y, x * y], &[2.0, -3.0, 0.5])
}

fn of_numbers<R: Real>(x: &[R]) -> R {
    let (x, y, c) = (x[0], x[1], R::lit);
    let powers = x.max(c(0.25)).powf(c(2.5)) + y.min(c(-0.5)).atan2(c(1.0)) + x.hypot(c(3.0));
    let clamped = (x * c(4.0)).clamp(c(-1.0), c(1.5)) * y.clamp(c(-2.0), c(2.0));
    let chosen = R::select(x.less(c(0.5)) | y.less_equal(c(-4.0)), x, y);
    powers + clamped + chosen + R::dot(&[x, y, x * y], &[2.0, -3.0, 0.5].map(c))
}

#[test]
fn an_argument_that_is_a_float_is_that_constant() {
    for x in [[0.125, -1.0], [0.75, 0.5], [-2.0, -8.0]] {
        assert_eq!(of_floats(&x), of_numbers(&x));
        assert_eq!(
            of_floats(&x.map(|x| x as f32)),
            of_numbers(&x.map(|x| x as f32))
        );
        assert_eq!(gradient(of_floats, &x), gradient(of_numbers, &x));
        type Of = fn(&[Var<Dual<f64, 1>>]) -> Var<Dual<f64, 1>>;
        let product = |function: Of| hessian_vector(function, &x, &[1.0, 0.5]);
        assert_eq!(product(of_floats), product(of_numbers));
    }
    let mut tape = Tape::new();
    tape.record(&[2.0, 3.0], |x| x[0].max(0.0).clamp(-9.0, 9.0));
    assert_eq!(tape.len(), 2, "constants and choices record nothing");
    tape.record(&[2.0, 3.0], |x| Var::dot(x, &[4.0, 5.0]));
    assert_eq!(tape.len(), 3, "a dot product with floats is one entry");
}

#[test]
fn closures_pass_floats_to_methods() {
    let slope = gradient(
        |x| x[0].max(0.0) + x[1].clamp(-1.0, 1.0) * x[0].powf(2.0),
        &[3.0, 0.5],
    );
    assert_eq!(slope, [4.0, 9.0]);
    let slope = gradient_forward(|x| Dual::dot(x, &[2.0, 5.0]) + x[0].atan2(1.0), &[0.0, 1.0]);
    assert_eq!(slope, [3.0, 5.0]);
}
