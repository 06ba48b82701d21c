//! Every optimiser converges on every test problem. A run that is saved and resumed ends with the same bits.

use std::marker::PhantomData;

use autodiff::{Real, Var, gradient, jacobian};
use cosmic::objective::AugmentedLagrangian;
use cosmic::optimiser::{Adam, AdamState, Linearisation, Mma, MmaSettings, MmaState};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The lower and the upper bound of both variables.
const BOX: (f64, f64) = (-2.0, 2.0);

/// A test problem: an objective to minimise within bounds, and constraints that must be at most 0.
trait Problem {
    const NAME: &'static str;
    const START: [f64; 2];
    const MINIMISER: [f64; 2];

    fn objective<R: Real>(x: &[R]) -> R;
    fn constraints<R: Real>(_: &[R]) -> Vec<R> {
        vec![]
    }
}

/// A convex quadratic whose unconstrained minimum is outside the bounds, so the solution is at a bound.
struct Quadratic;

impl Problem for Quadratic {
    const NAME: &'static str = "quadratic";
    const START: [f64; 2] = [-1.5, -1.0];
    /// The first variable is at its bound, and the second is at the minimum of the parabola that remains.
    const MINIMISER: [f64; 2] = [2.0, -0.5];

    fn objective<R: Real>(x: &[R]) -> R {
        let (first, second) = (x[0] - R::lit(5.0), x[1] + R::lit(0.5));
        first * first + R::lit(2.0) * second * second
    }
}

/// Rosenbrock's function: a curved valley that is not convex.
struct Rosenbrock;

impl Problem for Rosenbrock {
    const NAME: &'static str = "Rosenbrock";
    const START: [f64; 2] = [-1.0, 0.5];
    const MINIMISER: [f64; 2] = [1.0, 1.0];

    fn objective<R: Real>(x: &[R]) -> R {
        let (across, along) = (x[1] - x[0] * x[0], R::one() - x[0]);
        R::lit(5.0) * across * across + along * along
    }
}

/// The problem of finding the point of a disc that is nearest to a given point outside the disc. The start is outside
/// too.
struct Disc;

impl Problem for Disc {
    const NAME: &'static str = "disc";
    const START: [f64; 2] = [1.8, 0.2];
    /// By symmetry, the solution is on the diagonal. Its distance from the origin is 1.
    const MINIMISER: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2; 2];

    fn objective<R: Real>(x: &[R]) -> R {
        let (first, second) = (x[0] - R::lit(1.5), x[1] - R::lit(1.5));
        first * first + second * second
    }
    fn constraints<R: Real>(x: &[R]) -> Vec<R> {
        vec![x[0] * x[0] + x[1] * x[1] - R::one()]
    }
}

/// An optimiser under test.
trait Optimiser {
    const NAME: &'static str;
    /// The number of updates, which is enough for every problem. After them, the distance from the minimiser must be at
    /// most `TOLERANCE`.
    const UPDATES: usize;
    const TOLERANCE: f64;
    type State: Serialize + DeserializeOwned;

    fn init<P: Problem>() -> Self::State;
    fn update<P: Problem>(state: &mut Self::State, x: &mut [f64]);
}

struct Moving;

impl Moving {
    fn method<P: Problem>() -> Mma {
        let parameters = MmaSettings {
            move_limit: 0.2,
            asyinit: 0.05,
            // If a gradient vanishes, the models do not have the curvature of the function. The method then oscillates
            // about the minimum. The size of the oscillation is the smallest distance of the asymptotes, so this
            // distance must be small.
            asymin: 1e-5,
            ..MmaSettings::default()
        };
        Mma::new(parameters, &[BOX.0; 2], &[BOX.1; 2]).expect("usable settings")
    }
}

impl Optimiser for Moving {
    const NAME: &'static str = "moving asymptotes";
    const UPDATES: usize = 1000;
    /// The tolerance of the minimiser: five times the smallest distance of the asymptotes. This distance is 4 `asymin`,
    /// because the bounds are 4 apart.
    const TOLERANCE: f64 = 2e-4;
    type State = MmaState;

    fn init<P: Problem>() -> MmaState {
        Self::method::<P>().init(&P::START)
    }
    fn update<P: Problem>(state: &mut MmaState, x: &mut [f64]) {
        let jacobian = jacobian(|x| Constraints::<P>(PhantomData).eval(x), x);
        let at = Linearisation {
            point: x,
            objective_gradient: &gradient(P::objective, x),
            constraints: &P::constraints(x),
            jacobian: &jacobian.iter().map(<[f64]>::to_vec).collect::<Vec<_>>(),
        };
        let update = Self::method::<P>().update(state, &at);
        x.copy_from_slice(&update.expect("finite input").point);
    }
}

/// Adam with projection onto the bounds, and an augmented Lagrangian for the constraints.
struct Adaptive;

impl Adaptive {
    const PENALTY: f64 = 0.3;
    const PENALTY_GROWTH: f64 = 1.01;
}

impl Optimiser for Adaptive {
    const NAME: &'static str = "Adam with an augmented Lagrangian";
    const UPDATES: usize = 4000;
    /// The tolerance of the minimiser. Two effects cause an error: Adam's steps do not become smaller than its rate,
    /// and multipliers never decrease. The rate decays, and the error decreases with it.
    const TOLERANCE: f64 = 1e-3;
    /// The state of Adam, the state of the augmented Lagrangian, and the violations after the last update.
    type State = (AdamState, AugmentedLagrangian, [f64; 4]);

    fn init<P: Problem>() -> Self::State {
        let lagrangian = AugmentedLagrangian::new(Self::PENALTY);
        (
            Adam::default().init(2),
            lagrangian,
            violations::<P, f64>(&P::START),
        )
    }
    fn update<P: Problem>((adam, augmented, last): &mut Self::State, x: &mut [f64]) {
        let objective =
            |x: &[Var<f64>]| augmented.objective(P::objective(x), violations::<P, _>(x));
        let slopes = gradient(objective, x);
        let done = adam.updates as f64 / Self::UPDATES as f64;
        let rate = 0.02 * (1.0 - done);
        (Adam::default().update(adam, x, &slopes, rate)).expect("a finite gradient");
        x.iter_mut().for_each(|x| *x = x.clamp(BOX.0, BOX.1));
        let violations = violations::<P, f64>(x);
        augmented.update(&violations, last, Self::PENALTY_GROWTH);
        *last = violations;
    }
}

/// The violation of each of four constraints; 0 for constraints that the problem does not have.
fn violations<P: Problem, R: Real>(x: &[R]) -> [R; 4] {
    let constraints = P::constraints(x);
    [0, 1, 2, 3].map(|k| {
        constraints
            .get(k)
            .map_or(R::zero(), |value| value.max(R::zero()))
    })
}

/// The constraints of a problem as a function from a vector to a vector.
struct Constraints<P>(PhantomData<P>);

impl<P: Problem> Constraints<P> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        P::constraints(x)
    }
}

/// Runs an optimiser on a problem and returns the last point. Before each update whose number is in `interruptions`,
/// the run is saved as text and read back.
fn run<O: Optimiser, P: Problem>(interruptions: &[usize]) -> Vec<f64> {
    let (mut state, mut x) = (O::init::<P>(), P::START.to_vec());
    for update in 0..O::UPDATES {
        if interruptions.contains(&update) {
            let saved = serde_json::to_string(&(&state, &x)).expect("plain data");
            (state, x) = serde_json::from_str(&saved).expect("what was written");
        }
        O::update::<P>(&mut state, &mut x);
    }
    x
}

fn check<O: Optimiser, P: Problem>() {
    let end = run::<O, P>(&[]);
    let off = (0..2).map(|j| (end[j] - P::MINIMISER[j]).abs());
    let off = off.fold(0.0, f64::max);
    assert!(
        off <= O::TOLERANCE,
        "{} on {}: ends at {end:?}, {off:e} from the minimiser",
        O::NAME,
        P::NAME
    );
    let resumed = run::<O, P>(&[0, 1, 2, O::UPDATES / 2]);
    assert_eq!(end, resumed, "{} on {}: resumed", O::NAME, P::NAME);
}

fn check_all<O: Optimiser>() {
    check::<O, Quadratic>();
    check::<O, Rosenbrock>();
    check::<O, Disc>();
}

#[test]
fn moving_asymptotes_converge() {
    check_all::<Moving>();
}

#[test]
fn adam_converges() {
    check_all::<Adaptive>();
}
