//! Structures of parameters: their names, their order, and derivatives in the shape of the structure.

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

/// Returns the sum over all numbers of the squared number times its index.
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
    // Turns the function of a structure into a function of a slice, which can be differentiated in any mode.
    struct Energy(Robot<f64>);
    impl Function for Energy {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            energy(&self.0.with(x))
        }
    }
    let energy = Energy(robot);
    assert_eq!(gradient(|x| energy.eval(x), &numbers), expected);
    assert_eq!(hessian(|x| energy.eval(x), &numbers)[3][3], 6.0);
    let moving: Robot<Dual<f64, 1>> = energy.0.with(
        &numbers
            .iter()
            .map(|&x| Dual::variable(x, 0))
            .collect::<Vec<_>>(),
    );
    assert_eq!(moving.clock.tangent, [1.0]);
}

/// The derived code must work even if the number type, the struct, its fields or constants have names that the derived
/// code uses too.
mod names {
    use autodiff::{Parameters, Real};

    #[derive(Clone, Debug, PartialEq, Parameters)]
    pub(super) struct OfS<S> {
        pub(super) x: S,
    }

    #[derive(Clone, Debug, PartialEq, Parameters)]
    pub(super) struct S<Other>(pub(super) [Other; 2]);

    #[derive(Clone, Debug, PartialEq, Parameters)]
    pub(super) struct Other<Walk: Real> {
        pub(super) walk: Walk,
        pub(super) map: OfS<Walk>,
        pub(super) r#type: S<Walk>,
    }

    #[derive(Clone, Debug, PartialEq, Parameters)]
    pub(super) struct Walk<Real>(pub(super) Real);

    pub(super) mod inner {
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct R(pub(crate) u8);
    }

    /// A type from another module that has the same name as the number type.
    #[derive(Clone, Debug, PartialEq, Parameters)]
    pub(super) struct Tagged<R> {
        pub(super) tag: inner::R,
        pub(super) x: R,
    }
}

/// A struct that has lifetimes, constants, defaults and bounds besides its number type.
#[derive(Clone, Debug, PartialEq, Parameters)]
struct Network<'a, R = f64, const N: usize = 2>
where
    R: Real,
{
    name: &'a str,
    w: [R; N],
}

#[test]
fn a_struct_may_use_any_names() {
    let at = names::Other {
        walk: 1.0,
        map: names::OfS { x: 2.0 },
        r#type: names::S([3.0, 4.0]),
    };
    assert_eq!(at.names(), ["walk", "map.x", "type.0[0]", "type.0[1]"]);
    let product = |x: &names::Other<autodiff::Var<f64>>| x.walk * x.map.x * x.r#type.0[1];
    let gradient = parameters::gradient(product, &at);
    assert_eq!(gradient.flatten(), [8.0, 4.0, 0.0, 2.0]);
    assert_eq!(names::Walk(2.0).with(&[3.0]), names::Walk(3.0));
    let tagged = names::Tagged {
        tag: names::inner::R(7),
        x: 2.0,
    };
    let moved = tagged.with(&[3.0]);
    assert_eq!((moved.tag.0, moved.x), (7, 3.0));
}

#[test]
fn a_struct_may_have_lifetimes_constants_and_conditions() {
    let name = String::from("hip");
    let at: Network<'_, f64, 3> = Network {
        name: &name,
        w: [1.0, 2.0, 3.0],
    };
    let squares = |x: &Network<'_, autodiff::Var<f64>, 3>| x.w.iter().map(|&w| w * w).sum();
    let (value, gradient) = parameters::value_and_gradient(squares, &at);
    assert_eq!((value, gradient.w), (14.0, [2.0, 4.0, 6.0]));
    assert_eq!(gradient.name, "hip");
}

/// This crate under another path, as in the manifest of a user who renames it.
mod renamed {
    pub(super) mod ad {
        pub(crate) use autodiff::{Parameters, Real, parameters};
    }
    use ad::Parameters as _;

    #[derive(Clone, Debug, PartialEq, autodiff::Parameters)]
    #[autodiff(crate = "ad")]
    pub(super) struct Spring<R> {
        pub(super) stiffness: R,
        pub(super) rest: [R; 2],
    }

    pub(super) fn names(spring: &Spring<f64>) -> Vec<String> {
        spring.names()
    }
}

#[test]
fn the_crate_may_have_another_path() {
    let spring = renamed::Spring {
        stiffness: 3.0,
        rest: [1.0, 2.0],
    };
    assert_eq!(renamed::names(&spring), ["stiffness", "rest[0]", "rest[1]"]);
    let product = |at: &renamed::Spring<autodiff::Var<f64>>| at.stiffness * at.rest[1];
    let gradient = parameters::gradient(product, &spring);
    assert_eq!(gradient.flatten(), [2.0, 0.0, 3.0]);
}
