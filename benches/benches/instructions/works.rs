//! The pieces of work whose instructions are counted.

use std::hint::black_box;

use autodiff::{Kernel, Model, Program, Real, Rollout, gradient};
use benches::machine::built_in;
use benches::robot::{MEASURED_STEPS, Subject, TwoMatvecs};
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::kernel;

/// A piece of work whose instructions are counted. A process sets it up once, and then repeats it.
pub(crate) struct CountedWork {
    /// Sets up the work, and does it as many times as the argument says.
    pub(crate) run: Box<dyn Fn(u64)>,
    /// The number of repetitions that are counted. One is enough if the work has thousands of steps.
    pub(crate) repeats: u64,
    /// The number of units, such as time steps, in one repetition. Counts are given per unit.
    pub(crate) units: f64,
}

impl CountedWork {
    fn new(repeats: u64, units: usize, run: impl Fn(u64) + 'static) -> Self {
        Self {
            run: Box::new(run),
            repeats,
            units: units as f64,
        }
    }
}

/// A table of counted works.
pub(crate) struct CountTable {
    pub(crate) title: &'static str,
    pub(crate) about: &'static str,
    /// The column headings. The first one stands above the names of the rows.
    pub(crate) columns: &'static [&'static str],
    pub(crate) rows: Vec<(String, Vec<CountedWork>)>,
}

impl CountTable {
    /// Returns all works of the table, row by row.
    pub(crate) fn works(&self) -> impl Iterator<Item = &CountedWork> {
        self.rows.iter().flat_map(|(_, works)| works)
    }
}

/// Returns all tables.
pub(crate) fn tables() -> Vec<CountTable> {
    vec![robot(), scalar_tapes()]
}

fn robot() -> CountTable {
    let (mixture, one_hot) = ("stability", "baseline_tall");
    let row = |name: &str, works| (name.to_owned(), works);
    CountTable {
        title: "The robot's rollout",
        about: "6x6 nodes, 110 edges, 32 hidden units: instructions per step, over a rollout of 4096 steps with \
                its beginning and end. In brackets: the ratio to the two matrix-vector products of the \
                controller in f64.",
        columns: &[
            "design",
            "rollout",
            "value and design gradient",
            "value and controller gradient",
        ],
        rows: vec![
            row("only two mat-vecs, f64", vec![matvecs(mixture)]),
            row("mixture, f64", in_type::<f64>(mixture)),
            row("mixture, f32", in_type::<f32>(mixture)),
            row("one-hot, f64", in_type::<f64>(one_hot)),
            row("one-hot, f32", in_type::<f32>(one_hot)),
        ],
    }
}

fn matvecs(scene: &'static str) -> CountedWork {
    let run = move |repeats| {
        let matvecs = TwoMatvecs::new(&built_in(scene).1);
        for _ in 0..repeats {
            black_box(matvecs.run(MEASURED_STEPS));
        }
    };
    CountedWork::new(1, MEASURED_STEPS, run)
}

/// Returns a counted work that runs a rollout of a scene's robot.
fn rollout(scene: &'static str, work: impl Fn(&Subject<'_>) + 'static) -> CountedWork {
    let run = move |repeats| {
        let (scene, case) = built_in(scene);
        let subject = Subject::new(&case, &scene.loss);
        for _ in 0..repeats {
            work(&subject);
        }
    };
    CountedWork::new(1, MEASURED_STEPS, run)
}

fn in_type<R: Real>(scene: &'static str) -> Vec<CountedWork> {
    let gradient = |blocks| {
        rollout(scene, move |subject| {
            black_box(subject.gradient::<R>(blocks));
        })
    };
    let plain = rollout(scene, |subject| {
        black_box(subject.rollout::<R>());
    });
    vec![plain, gradient(DESIGN), gradient(CONTROLLER)]
}

/// The number of steps in a rollout of [`Populations`].
const STEPS: usize = 256;

/// A model of populations of hares and lynxes after Lotka and Volterra. It takes explicit steps and has four rates.
#[derive(Clone)]
struct Populations;

#[kernel]
impl Kernel<6, 2> for Populations {
    fn eval<R: Real>(&self, [x, y, a, b, c, d]: [R; 6], _: &[R]) -> [R; 2] {
        let h = R::lit(0.01);
        [x + h * x * (a - b * y), y + h * y * (c * x - d)]
    }
}

impl Model for Populations {
    fn record(&self, program: &mut Program) {
        let [a, b, c, d] = [(); 4].map(|()| program.parameter(1));
        let [x, y] = [(); 2].map(|()| program.state(1));
        let next = program.map(Populations, [x, y, a, b, c, d], &[]);
        program.advance(x, next[0]);
        program.advance(y, next[1]);
    }
}

fn scalar_tapes() -> CountTable {
    fn end<R: Real>(rates: &[R]) -> R {
        let mut state = [R::lit(3.0), R::one()];
        for _ in 0..STEPS {
            let ([x, y], [a, b, c, d]) = (state, [rates[0], rates[1], rates[2], rates[3]]);
            state = Populations.eval([x, y, a, b, c, d], &[]);
        }
        state[0]
    }
    fn rolled<R: Real>(rates: &[R]) -> R {
        let rollout = Rollout::new(Populations, STEPS);
        rollout.run(
            &[R::lit(3.0), R::one()],
            &rates.chunks(1).collect::<Vec<_>>(),
        )[0]
    }
    const RATES: [f64; 4] = [1.1, 0.4, 0.1, 0.4];
    let row = |name: &str, work: fn(&[f64]) -> f64| {
        let run = move |repeats| (0..repeats).for_each(|_| _ = black_box(work(black_box(&RATES))));
        (name.to_owned(), vec![CountedWork::new(16, STEPS, run)])
    };
    let rows = vec![
        row("primal, scalar f64", end),
        row("`Tape`", |x| gradient(end, x)[0]),
        row("primal, `Rollout`", rolled),
        row("`Rollout`", |x| gradient(rolled, x)[0]),
    ];
    CountTable {
        title: "Scalar tapes",
        about: "The gradient of a model of two populations with respect to its four rates, instructions per \
                step, over 256 steps. In brackets: the ratio to the primal.",
        columns: &["one step", "instructions"],
        rows,
    }
}
