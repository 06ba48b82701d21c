//! The counted works: those of the other benches.

use std::hint::black_box;
use std::path::Path;

use autodiff::Real;
use benches::adbench::{self, Case};
use benches::machine::built_in;
use benches::objectives::Problem;
use benches::tapes::step::SpringLattice;
use benches::tapes::{Gradient, inputs, kernels, on_tape, plain};
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic_lab::verify::{MEASURED_STEPS, Subject, TwoMatvecs};

/// Work to be counted. Its setup is done anew in every process, whatever the repetitions.
pub(crate) struct CountedWork {
    /// Sets up, and repeats the work so many times.
    pub(crate) run: Box<dyn Fn(u64)>,
    /// Repetitions that are counted: one where it has thousands of steps.
    pub(crate) repeats: u64,
    /// Units of a repetition, such as time steps.
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

/// The figure that counts are compared to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ComparedTo {
    /// The first figure of the table.
    Table,
    /// The first figure of each row.
    Row,
}

/// A table of works.
pub(crate) struct CountTable {
    pub(crate) title: &'static str,
    pub(crate) about: &'static str,
    /// The names of the columns, that of the rows first.
    pub(crate) columns: &'static [&'static str],
    pub(crate) rows: Vec<(String, Vec<CountedWork>)>,
    pub(crate) base: ComparedTo,
}

impl CountTable {
    /// All works, row by row.
    pub(crate) fn works(&self) -> impl Iterator<Item = &CountedWork> {
        self.rows.iter().flat_map(|(_, works)| works)
    }
}

/// All tables.
pub(crate) fn tables() -> Vec<CountTable> {
    vec![robot(), one_piece(), scalar_tapes(), problems()]
}

fn robot() -> CountTable {
    let (mixture, one_hot) = ("stability", "baseline_tall");
    let row = |name: &str, works| (name.to_owned(), works);
    CountTable {
        title: "The robot's rollout",
        about: "6x6 nodes, 110 edges, 32 hidden units: instructions a step of 4096, with their share \
                of what a rollout does at its beginning and end. In brackets: times the two bare \
                mat-vecs of the controller in f64.",
        columns: &[
            "design",
            "rollout",
            "value and design gradient",
            "value and controller gradient",
        ],
        rows: vec![
            row("nothing but two mat-vecs, f64", vec![matvecs(mixture)]),
            row("mixture, f64", in_type::<f64>(mixture)),
            row("mixture, f32", in_type::<f32>(mixture)),
            row("one-hot, f64", in_type::<f64>(one_hot)),
            row("one-hot, f32", in_type::<f32>(one_hot)),
        ],
        base: ComparedTo::Table,
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

/// Work on a rollout of a scene's robot, whose setting `design.one_piece` may be another one.
fn rollout(
    scene: &'static str,
    one_piece: Option<bool>,
    work: impl Fn(&Subject<'_>) + 'static,
) -> CountedWork {
    let run = move |repeats| {
        let (scene, mut case) = built_in(scene);
        case.rules.one_piece = one_piece.unwrap_or(case.rules.one_piece);
        let subject = Subject::new(&case, &scene.loss);
        for _ in 0..repeats {
            work(&subject);
        }
    };
    CountedWork::new(1, MEASURED_STEPS, run)
}

fn in_type<R: Real>(scene: &'static str) -> Vec<CountedWork> {
    let gradient = |blocks| {
        rollout(scene, None, move |subject| {
            black_box(subject.gradient::<R>(blocks));
        })
    };
    let plain = rollout(scene, None, |subject| {
        black_box(subject.rollout::<R>());
    });
    vec![plain, gradient(DESIGN), gradient(CONTROLLER)]
}

fn one_piece() -> CountTable {
    fn row<R: Real>(name: &str, scene: &'static str) -> (String, Vec<CountedWork>) {
        let gradient = |one_piece| {
            rollout(scene, Some(one_piece), |subject| {
                black_box(subject.gradient::<R>(DESIGN));
            })
        };
        (name.to_owned(), vec![gradient(false), gradient(true)])
    }
    CountTable {
        title: "Design gradients with `one_piece`",
        about: "Value and design gradient, instructions a step. In brackets: times the gradient without \
                `design.one_piece`.",
        columns: &["design", "without", "with `one_piece`"],
        rows: vec![
            row::<f64>("mixture, f64", "stability"),
            row::<f32>("mixture, f32", "stability"),
            row::<f64>("one-hot, f64", "baseline_tall"),
            row::<f32>("one-hot, f32", "baseline_tall"),
        ],
        base: ComparedTo::Row,
    }
}

/// Steps of the rollouts that kernels are counted in.
const STEPS: usize = 256;

fn scalar_tapes() -> CountTable {
    let row = |name: &str, work| (name.to_owned(), vec![work]);
    let value = || kernels::value(&SpringLattice::default(), STEPS);
    let gradient = || kernels::gradient(&SpringLattice::default(), STEPS);
    let rows = vec![
        row("primal, scalar f64", spring_step(1, plain)),
        row("`Tape`", spring_step(1, on_tape)),
        row("primal, kernels in lanes", spring_step(STEPS, value)),
        row("kernels", spring_step(STEPS, gradient)),
    ];
    CountTable {
        title: "Scalar tapes",
        about: "The gradient of one step of springs. In brackets: times the primal.",
        columns: &["one step", "instructions"],
        rows,
        base: ComparedTo::Table,
    }
}

fn spring_step(steps: usize, gradient: impl Fn() -> Gradient + 'static) -> CountedWork {
    let run = move |repeats| {
        let (lattice, inputs, mut gradient) = (SpringLattice::default(), inputs(), gradient());
        for _ in 0..repeats {
            black_box(gradient(&lattice, black_box(&inputs)));
        }
    };
    CountedWork::new(16, steps, run)
}

fn problems() -> CountTable {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/adbench");
    let cases = adbench::cases(&folder).expect("the problems of this workspace are readable");
    let row = |case: Case| {
        let objective = problem(case.clone(), |problem| problem.objective());
        let derivative = problem(case.clone(), |problem| problem.derivative());
        (case.name, vec![objective, derivative])
    };
    CountTable {
        title: "ADBench",
        about: "In brackets: times the objective.",
        columns: &["case", "objective", "objective and derivative"],
        rows: cases.into_iter().map(row).collect(),
        base: ComparedTo::Row,
    }
}

fn problem(case: Case, work: impl Fn(&mut dyn Problem) + 'static) -> CountedWork {
    let run = move |repeats| {
        let mut problem = case.open().expect("it was read before");
        for _ in 0..repeats {
            work(&mut *problem);
        }
    };
    CountedWork::new(2, 1, run)
}
