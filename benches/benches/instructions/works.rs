//! The counted works: those of the other benches.

use std::hint::black_box;
use std::path::Path;

use autodiff::Real;
use benches::adbench::{self, Problem};
use benches::machine::built_in;
use benches::tapes::rivals::{Gradient, plain, tapes};
use benches::tapes::step::SpringLattice;
use benches::tapes::{inputs, kernels};
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
    vec![robot(), scalar_tapes(), problems()]
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

/// Work on a rollout of a scene's robot.
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

/// Steps of the rollouts that kernels are counted in.
const STEPS: usize = 256;

fn scalar_tapes() -> CountTable {
    let row = |name: &str, work| (name.to_owned(), vec![work]);
    let mut rows = vec![row("primal, scalar f64", spring_step(1, plain))];
    rows.extend(
        tapes()
            .into_iter()
            .map(|(name, tape)| row(name, spring_step(1, tape))),
    );
    rows.extend([
        row(
            "primal, kernels in lanes",
            spring_step(STEPS, || kernels::value(&SpringLattice::default(), STEPS)),
        ),
        row(
            "kernels of this crate",
            spring_step(STEPS, || {
                kernels::gradient(&SpringLattice::default(), STEPS)
            }),
        ),
    ]);
    CountTable {
        title: "Scalar tapes",
        about: "The gradient of one step of springs, as in [speed.md](speed.md). In brackets: \
                times the primal.",
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
    let row = |case: adbench::DataFile| {
        let objective = problem(case.clone(), |problem| problem.objective());
        let derivative = problem(case.clone(), |problem| problem.derivative());
        (case.name, vec![objective, derivative])
    };
    CountTable {
        title: "ADBench",
        about: "Objectives and derivatives of [adbench.md](adbench.md). In brackets: times the \
                objective.",
        columns: &["case", "objective", "objective and derivative"],
        rows: cases.into_iter().map(row).collect(),
        base: ComparedTo::Row,
    }
}

fn problem(case: adbench::DataFile, work: impl Fn(&mut dyn Problem) + 'static) -> CountedWork {
    let run = move |repeats| {
        let mut problem = adbench::open(case.kind, &case.file, None).expect("it was read before");
        for _ in 0..repeats {
            work(&mut *problem);
        }
    };
    CountedWork::new(2, 1, run)
}
