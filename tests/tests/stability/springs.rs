//! Checks of single edges and chains of edges. The function `tanh`, the softmax and the force have the right values and
//! derivatives for extreme inputs. Oscillators and chains move as the exact formulas for their steps say.

use super::StabilityCase;
use super::lattices::every_step;
use autodiff::{Dual, Real, gradient, jacobian, vjp};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::projection::softmax;
use cosmic::scene::phase_limit;
use cosmic::world::stability::Vibration;
use cosmic_tests::{Bare, assert_near, number, numbers};

pub(super) fn saturates(case: &StabilityCase) {
    let a = case.number("a");
    let forward: Dual<f64, 1> = Dual::variable(a, 0).tanh();
    let reverse = gradient(|a| a[0].tanh(), &[a])[0];
    case.absolute("tanh", forward.value);
    for slope in [forward.tangent[0], reverse] {
        case.absolute("dtanh", slope);
        assert!(slope >= 0.0, "tanh' {a} = {slope}");
    }
}

struct Softmax {
    beta: f64,
}

impl Softmax {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        softmax([x[0], x[1], x[2]], self.beta).to_vec()
    }
}

pub(super) fn projects(case: &StabilityCase) {
    let (z, beta) = (case.numbers("z"), case.number("beta"));
    let function = Softmax { beta };
    for (got, expected) in function.eval(&z).into_iter().zip(case.numbers("p")) {
        assert_near(got, expected, case.of_file("tolerance_abs_p"), &case.case);
    }
    let forward = jacobian(|x| function.eval(x), &z);
    let expected = case.numbers("jacobian_dp_dz");
    for (i, expected) in expected.as_chunks::<3>().0.iter().enumerate() {
        let mut row = [0.0; 3];
        row[i] = 1.0;
        let (_, reverse) = vjp(|x| function.eval(x), &z, &row);
        for k in 0..3 {
            for got in [forward[i][k], reverse[k]] {
                // The bound of the file: shares are rounded at 1e-16, and the sharpness beta multiplies the error.
                assert_near(got, expected[k], 1e-12 * beta, &case.case);
            }
        }
    }
}

/// Checks four results for an edge: its force, the velocity after one step, the derivative of the force, and the factor
/// by which a step amplifies a small displacement across the edge.
pub(super) fn pulls(case: &StabilityCase) {
    let kick = &case.case["kick_v_of_mass"];
    let (mass, dt) = (number(kick, "m"), number(kick, "dt"));
    let mut bare = Bare::new(&[([0, 1], case.number("l0"), case.number("k"))], &[mass; 2]);
    bare.physics.dt = dt;
    let d = case.vector("d");
    let got = force(&bare, d);
    // The bound is the tolerance of the file, plus the error from the difference of two almost equal lengths near the
    // rest length.
    let tolerance = case.of_file("tolerance_rel");
    let lost = 1e-13 * case.number("k") * case.number("l0");
    let (expected, velocity) = (case.vector("force_on_i"), numbers(&kick["v"]));
    let bound = tolerance * expected[0].hypot(expected[1]) + lost;
    for k in 0..2 {
        assert_near(got[k], expected[k], bound, &case.case);
        assert_near(got[k], velocity[k] * mass / dt, bound, &case.case);
    }
    let moving = [0, 1].map(|k| Dual::<f64, 2>::variable(d[k], k));
    let forward = force(&bare, moving).map(|component| component.tangent);
    let reverse = [0, 1].map(|k| {
        let row = gradient(|d| force(&bare, [d[0], d[1]])[k], &d);
        [row[0], row[1]]
    });
    let expected = case.numbers("tangent_dF_dd");
    let size = expected.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let length = d[0].hypot(d[1]);
    let across = match length {
        0.0 => [0.0, 1.0],
        _ => [-d[1] / length, d[0] / length],
    };
    for tangent in [forward, reverse] {
        for (got, expected) in tangent.as_flattened().iter().zip(&expected) {
            assert_near(*got, *expected, tolerance * size, &case.case);
        }
        let by_across = tangent.map(|row| row[0] * across[0] + row[1] * across[1]);
        let force = by_across[0] * across[0] + by_across[1] * across[1];
        let amplification = 1.0 - 2.0 * dt * dt * force / mass;
        case.relative("transverse_amplification_per_step", amplification);
    }
}

/// The force of an edge on its first node. The argument `d` is the vector from the first node to the second. The force
/// is half the difference of the nodes' momenta after a step, divided by the time step.
fn force<R: Real>(bare: &Bare, d: [R; 2]) -> [R; 2] {
    let start = State::new([[R::zero(); 2], d], [[R::zero(); 2]; 2]);
    let v = bare.run_to_end(&start, 1).v;
    let per_kick = R::lit(bare.body.mass[0] / bare.physics.dt);
    ((v[0] - v[1]) * R::lit(0.5) * per_kick).in_plane()
}

/// The rest length of an oscillator's spring, m. It is so long that the softening is almost linear, and so short that
/// the rounding errors of positions are small.
const LENGTH: f64 = 4.0;

/// Two nodes of unit mass, one on each side of the origin. The extension of the spring between them oscillates with the
/// frequency of the case.
fn oscillator(case: &StabilityCase) -> Bare {
    let omega = case.number("omega");
    // The relative motion of two masses m has omega^2 = 2 k / m. The softening of the length (D4) changes the rest
    // length and the slope of the force by about 1e-12. The numbers here undo this change.
    let squared = LENGTH * LENGTH + 1e-12;
    let k = 0.5 * omega * omega * squared / (LENGTH * LENGTH);
    let mut bare = Bare::new(&[([0, 1], squared.sqrt(), k)], &[1.0, 1.0]);
    bare.physics.dt = case.number("dt");
    bare.physics.damping = case.world().damping;
    bare
}

/// The state of an oscillator whose extension is `x` and changes at the speed `v`.
fn extended([x, v]: [f64; 2]) -> State<f64> {
    let half = 0.5 * (LENGTH + x);
    State::new(
        [[-half, 0.0], [half, 0.0]],
        [[-0.5 * v, 0.0], [0.5 * v, 0.0]],
    )
}

/// The extension of an oscillator, and its rate of change.
fn extension(state: &State<f64>) -> [f64; 2] {
    let (apart, speed) = (state.x[1] - state.x[0], state.v[1] - state.v[0]);
    [apart.forward() - LENGTH, speed.forward()]
}

pub(super) fn oscillates(case: &StabilityCase) {
    let bare = oscillator(case);
    let (start, omega) = ([case.number("x0"), case.number("v0")], case.number("omega"));
    let rows = case.numbers("trajectory_step_x_v");
    let rows: &[[f64; 3]] = rows.as_chunks().0;
    let steps = rows.iter().map(|row| row[0] as usize).collect();
    let seen = bare.run(&extended(start), steps).states;
    let limit = phase_limit(bare.physics.damping, bare.physics.dt);
    // Both the limit in the file and the computed limit are square roots of sums of order one.
    case.near("limit_dt_omega", limit, 1e-14);
    let stable = bare.physics.dt * omega < limit;
    assert_eq!(case.case["stable"], stable, "{}", case.case);
    // The bound is relative to the largest amplitude and not to the amplitude after the decay, because positions are
    // rounded at 1e-17.
    let peak = rows.iter().fold(start[0], |m, row| m.max(row[1].abs()));
    let bound = case.of_file("tolerance_rel") * peak;
    for (state, [_, x, v]) in seen.iter().zip(rows).filter(|_| stable) {
        let got = extension(state);
        assert_near(got[0], *x, bound, &case.case);
        assert_near(got[1], *v, bound * omega.max(1.0), &case.case);
    }
    if !stable {
        let last = seen.last().expect("a case lists states");
        assert!(extension(last)[0].abs() > 10.0 * start[0], "{}", case.case);
    }
    // The columns of the matrix of a step are the results of two steps. The spectral radius follows from the matrix.
    let amplitude = 1e-3;
    let column = |start| extension(&bare.run_to_end(&extended(start), 1)).map(|c| c / amplitude);
    let ([a, c], [b, d]) = (column([amplitude, 0.0]), column([0.0, amplitude]));
    let (trace, determinant) = (a + d, a * d - b * c);
    let discriminant = 0.25 * trace * trace - determinant;
    let radius = match discriminant < 0.0 {
        true => determinant.sqrt(),
        false => 0.5 * trace.abs() + discriminant.sqrt(),
    };
    // If two eigenvalues are nearly equal, their distance is the root of a small difference of entries. The entries are
    // rounded at 1e-13 of the amplitude, so the root has an error of about 1e-6.
    case.near("spectral_radius", radius, 1e-6);
}

/// Checks that `v^2 + omega^2 x^2 - dt omega^2 x v` of an oscillator is constant. This implies a band for the energy.
/// Checks that the energy stays in this band and reaches both of its ends.
pub(super) fn keeps_its_invariant(case: &StabilityCase) {
    let (omega, dt) = (case.number("omega"), case.number("dt"));
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let mut furthest: f64 = 0.0;
    let amplitude = 1e-3;
    let at_start = (omega * amplitude).powi(2);
    every_step(
        &oscillator(case),
        extended([amplitude, 0.0]),
        1_000_000,
        |state| {
            let [x, v] = extension(state);
            let energy = v * v + omega * omega * x * x;
            let invariant = energy - dt * omega * omega * x * v;
            furthest = furthest.max((invariant / at_start - 1.0).abs());
            (least, most) = (least.min(energy), most.max(energy));
        },
    );
    // An extension of 1e-3 is rounded at 4e-16 in each of a million steps. These random errors add up to about 1e-9 of
    // the extension.
    assert!(furthest < 1e-8, "the invariant is off by {furthest:e}");
    let (band, seen) = (case.number("relative_band_max_over_min"), most / least);
    assert!(seen <= band * (1.0 + 1e-8), "{seen} above {band}");
    // Almost all phases of the oscillation occur, so the energy also reaches both ends of the band.
    assert!(seen > 1.0 + 0.99 * (band - 1.0));
}

/// Checks chains of nodes along the x axis with extreme stiffness and mass: the limit of the time step, and the motion
/// with time steps below and above the limit.
pub(super) fn vibrates(case: &StabilityCase) {
    let (k, rest, mass) = (case.numbers("k"), case.numbers("rest"), case.numbers("m"));
    let springs: Vec<_> = (0..k.len()).map(|e| ([e, e + 1], rest[e], k[e])).collect();
    let mut bare = Bare::new(&springs, &mass);
    (bare.physics.dt, bare.physics.damping) = (case.number("dt"), case.number("gamma"));
    let on_axis = |xs: Vec<f64>| {
        xs.into_iter()
            .map(|x| Vector::from([x, 0.0]))
            .collect::<Vec<_>>()
    };
    // At these positions, every spring is at rest.
    let places = (0..mass.len()).map(|node| rest[..node].iter().sum());
    let at_rest = on_axis(places.collect());
    let vibration = Vibration::new(&bare.lattice, &bare.body, &bare.physics, &at_rest);
    // The tolerance is for the softening, which adds 1e-12 to squared lengths of 1e-2.
    let fastest = case.number("omega_max");
    case.near("omega_max", vibration.fastest().0, 1e-9 * fastest);
    // The limit in the file assumes the damping of a step with the time step of the case.
    let limit = phase_limit(case.number("gamma"), case.number("dt")) / fastest;
    case.near("limit_dt", limit, 1e-14 * limit);

    let apart = |a: &[Vector<f64>], b: &[Vector<f64>]| {
        let pairs = a.iter().zip(b);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((*a - *b).forward().abs()))
    };
    let start = State::new(on_axis(case.numbers("x0")), on_axis(case.numbers("v0")));
    let perturbation = apart(&start.x, &at_rest);
    if case.number("dt_over_limit") > 1.0 {
        let end = bare.run_to_end(&start, case.number("steps") as usize);
        assert!(
            apart(&end.x, &at_rest) > 1e3 * perturbation,
            "{}",
            case.case
        );
        return;
    }
    let bound = case.of_file("tolerance_rel_of_perturbation") * perturbation;
    for state in case.case["states"]
        .as_array()
        .expect("a chain lists states")
    {
        let got = bare.run_to_end(&start, number(state, "step") as usize);
        let [x, v] = ["x", "v"].map(|key| on_axis(numbers(&state[key])));
        assert_near(apart(&got.x, &x), 0.0, bound, &state["step"]);
        // The velocity of the fastest vibration has the same relative error.
        assert_near(apart(&got.v, &v), 0.0, bound * fastest, &state["step"]);
    }
}
