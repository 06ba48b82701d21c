//! Structures of parameters: their names, their order, and derivatives in their own shape.

use crate::common::assert_refused;
use autodiff::{Dual, Element, Function, Parameters, Real, gradient, hessian, parameters};
use nalgebra::{DMatrix, DVector, Matrix2, SMatrix};

#[derive(Clone, Debug, PartialEq, Parameters)]
struct Layer<R: Real> {
    w: DMatrix<Element<R>>,
    b: DVector<Element<R>>,
}

#[derive(Clone, Debug, PartialEq, Parameters)]
struct Spring<R>([R; 2], usize);

#[derive(Clone, Debug, PartialEq, Parameters)]
struct Robot<R: Real> {
    layers: Vec<Layer<R>>,
    springs: Vec<Vec<Spring<R>>>,
    frame: SMatrix<Element<R>, 2, 2>,
    name: String,
    clock: R,
}

fn robot() -> Robot<f64> {
    let spring = |k: f64| Spring([k, -k], 7);
    Robot {
        layers: vec![Layer {
            w: DMatrix::from_fn(2, 3, |i, j| Element((3 * i + j) as f64)),
            b: DVector::from_element(2, Element(0.5)),
        }],
        springs: vec![vec![spring(10.0)], vec![], vec![spring(20.0), spring(30.0)]],
        frame: Matrix2::new(1.0, 2.0, 3.0, 4.0).map(Element),
        name: "walker".into(),
        clock: 6.25,
    }
}

/// Each number squared, times its place.
fn energy<R: Real>(robot: &Robot<R>) -> R {
    let terms = robot.flatten().into_iter().enumerate();
    terms.map(|(place, x)| x * x * R::lit(place as f64)).sum()
}

#[test]
fn numbers_have_names_and_an_order() {
    let (robot, names) = (robot(), robot().names());
    let numbers = robot.flatten();
    assert_eq!((names.len(), numbers.len()), (19, 19));
    let at = |name: &str| numbers[names.iter().position(|n| n == name).expect(name)];
    assert_eq!(at("layers[0].w[1][2]"), 5.0);
    assert_eq!(at("layers[0].b[1]"), 0.5);
    assert_eq!(at("springs[2][1].0[1]"), -30.0);
    assert_eq!(at("frame[0][1]"), 2.0);
    assert_eq!((names[18].as_str(), at("clock")), ("clock", 6.25));
    assert_eq!(robot.with(&numbers), robot);
}

#[test]
fn a_gradient_has_the_shape_of_its_structure() {
    let robot = robot();
    let (value, slope) = parameters::value_and_gradient(energy, &robot);
    let numbers = robot.flatten();
    let expected: Vec<f64> = (0..19).map(|k| 2.0 * k as f64 * numbers[k]).collect();
    assert_eq!(value, energy(&robot));
    assert_eq!(slope.flatten(), expected);
    assert_eq!(slope.springs[2][1], Spring([expected[12], expected[13]], 7));
    assert_eq!(slope.name, "walker");
    // The structure as a function of a slice, in any mode.
    struct Energy(Robot<f64>);
    impl Function for Energy {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            energy(&self.0.with(x))
        }
    }
    let energy = Energy(robot);
    assert_eq!(gradient(&energy, &numbers), expected);
    assert_eq!(hessian(&energy, &numbers)[3][3], 6.0);
    let moving: Robot<Dual<f64, 1>> = energy.0.with(
        &numbers
            .iter()
            .map(|&x| Dual::variable(x, 0))
            .collect::<Vec<_>>(),
    );
    assert_eq!(moving.clock.tangent, [1.0]);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn numbers_that_do_not_fit_are_refused() {
    let spring = Spring([1.0, 2.0], 0);
    assert_refused("1 numbers end before `0[1]`", || spring.with(&[1.0]));
    assert_refused("1 of 3 numbers are left over", || spring.with(&[1.0; 3]));
}
