use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real, Var, gradient};
use autodiff_programs::{Given, Kernel, Model, Program, Rollout};
use cosmic::kernel;
use cosmic::policy::Weighted;

/// 9 numbers do not fill registers.
const LEN: usize = 9;

/// Half of a number and half of another.
#[derive(Clone, Copy)]
struct Half;

#[kernel]
impl Kernel<2, 1> for Half {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 1] {
        [R::lit(0.5) * (x + y)]
    }
}

/// Two offsets and a value are weighted, and their halves are added to those of the state. The means, and a number that is
/// appended, are the last parts of the state.
#[derive(Clone)]
struct Observed;

impl Model for Observed {
    fn record(&self, p: &mut Program) {
        let weights = p.parameter(LEN);
        let parts = [(); 3].map(|()| p.state(LEN));
        let (means, other) = (p.state(2), p.state(2));
        let operation = Weighted {
            offsets: 2,
            weighed: 3,
        };
        let inputs = [&[weights], &parts[..], &[means]].concat();
        let outputs = p.operation(operation, &inputs, &[3 * LEN + 2, 2, 1]);
        for (k, part) in parts.into_iter().enumerate() {
            let own: Vec<Option<usize>> = (k * LEN..(k + 1) * LEN).map(Some).collect();
            let own = p.gather(outputs[0], &own);
            let [next] = p.map(Half, [part, own], &[]);
            p.advance(part, next);
        }
        let appended = p.gather(outputs[0], &[Some(3 * LEN), Some(3 * LEN + 1)]);
        p.advance(means, outputs[1]);
        p.advance(other, appended);
    }
}

const STATE: usize = 3 * LEN + 4;

/// A step in plain code.
fn written_out<R: Real>(state: &[R], weights: &[R]) -> Vec<R> {
    let total = R::sum_of(weights);
    let (mut next, mut means) = (Vec::new(), Vec::new());
    for (k, part) in state[..3 * LEN].chunks(LEN).enumerate() {
        let mean = R::dot(part, weights) / total;
        let shift = if k < 2 { mean } else { R::zero() };
        if k < 2 {
            means.push(mean);
        }
        let weighed = part.iter().zip(weights).map(|(&x, &w)| w * (x - shift));
        next.extend(weighed.zip(part).map(|(y, &x)| Half.eval([x, y], &[])[0]));
    }
    next.extend(means);
    next.extend(&state[3 * LEN..3 * LEN + 2]);
    next
}

/// The sum of the squares of the last state.
struct Squares {
    is_plain: bool,
}

impl Function for Squares {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (state, weights) = x.split_at(STATE);
        let end = match self.is_plain {
            true => (0..3).fold(state.to_vec(), |state, _| written_out(&state, weights)),
            false => Rollout::new(Observed, 3).run(state, &[weights]),
        };
        end.iter().fold(R::zero(), |sum, &x| x.fma(x, sum))
    }
}

fn point(salt: f64) -> Vec<f64> {
    let state = (0..STATE).map(|k| (k as f64 + salt).sin());
    state
        .chain((0..LEN).map(|k| 1.5 + (k as f64 * salt).cos()))
        .collect()
}

#[test]
fn weighted_arrays_agree_with_plain_code_and_with_finite_differences() {
    let x = point(0.7);
    let report = check_gradient(&Squares { is_plain: false }, &x, &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
    let [found, expected] = [false, true].map(|is_plain| {
        let function = Squares { is_plain };
        gradient(|x| function.eval(x), &x)
    });
    for (a, b) in found.iter().zip(&expected) {
        // The sums have another order.
        assert!((a - b).abs() < 1e-13, "{a} and {b}");
    }
}

/// A start has the same bits in every batch: alone, in pairs, and in a register.
#[test]
fn weighted_arrays_have_the_same_bits_in_every_batch() {
    let rollout = Rollout::new(Observed, 3);
    let runs: Vec<Vec<f64>> = (0..11).map(|k| point(0.3 + f64::from(k))).collect();
    let seen = |runs: &[Vec<f64>]| {
        let loss = |x: &[Var<f64>]| {
            let runs: Vec<&[Var<f64>]> = x.chunks(STATE + LEN).collect();
            let starts: Vec<_> = runs.iter().map(|x| &x[..STATE]).collect();
            let weights: Vec<_> = runs.iter().map(|x| &x[STATE..]).collect();
            let ends = rollout.run_batch(&starts, &[Given::Each(&weights)]);
            let squares = ends.iter().flatten().map(|&x| x * x);
            squares.fold(Var::lit(0.0), |sum, x| sum + x)
        };
        gradient(loss, &runs.concat())
    };
    let alone: Vec<f64> = runs
        .iter()
        .flat_map(|run| seen(std::slice::from_ref(run)))
        .collect();
    for at_once in [2, 3, 11] {
        let together: Vec<f64> = runs.chunks(at_once).flat_map(seen).collect();
        assert_eq!(together, alone, "{at_once} starts");
    }
}
