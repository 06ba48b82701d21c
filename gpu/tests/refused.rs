//! What cannot be printed is refused, and wrong options panic.

#[allow(dead_code)] // The tests of `cosmic-autodiff` need more.
#[path = "../../autodiff/tests/common/refusal.rs"]
mod refusal;

use autodiff::Real;
use autodiff_programs::{CotangentBound, Graph, Kernel, Model, Program};
use cosmic::kernel;
use cosmic_gpu::wgsl::{Options, print};

use refusal::assert_named;

/// A rod in which heat flows in implicit steps.
#[derive(Clone)]
struct Implicit;

impl Model for Implicit {
    fn record(&self, p: &mut Program) {
        let graph = Graph::new(3, &[[0, 1], [1, 2]]);
        let (capacity, conductance) = (p.parameter(3), p.parameter(graph.slots()));
        let x = p.state(3);
        let [next] = p.solve(&graph, &[capacity], &[conductance], &[], [x]);
        p.advance(x, next);
    }
}

/// A model whose new state is given.
#[derive(Clone)]
struct Pushed;

impl Model for Pushed {
    fn record(&self, program: &mut Program) {
        let (x, push) = (program.state(2), program.control(2));
        program.advance(x, push);
    }
}

#[test]
fn what_cannot_be_printed_is_refused() {
    let refused = print(&Implicit, &Options::default()).unwrap_err();
    refusal::Refusal(refused.to_string()).says("solves linear equations");
    let refused = print(&Pushed, &Options::default()).unwrap_err();
    refusal::Refusal(refused.to_string()).says("has a control");
}

/// `x -> x * factor`, in every step.
#[derive(Clone)]
struct Scaled;

#[kernel]
impl Kernel<2, 1> for Scaled {
    fn eval<R: Real>(&self, [x, factor]: [R; 2], _: &[R]) -> [R; 1] {
        [x * factor]
    }
}

impl Model for Scaled {
    fn record(&self, program: &mut Program) {
        let (x, factor) = (program.state(1), program.parameter(1));
        let [next] = program.map(Scaled, [x, factor], &[]);
        program.advance(x, next);
    }
}

/// A model that forgets to advance its state.
#[derive(Clone)]
struct Stuck;

impl Model for Stuck {
    fn record(&self, program: &mut Program) {
        program.state(1);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn the_printer_names_the_line_of_its_caller() {
    let with = |change: fn(&mut Options)| {
        let mut options = Options::default();
        change(&mut options);
        options
    };
    assert!(print(&Scaled, &Options::default()).is_ok());
    assert_named(|| print(&Stuck, &Options::default()));
    assert_named(|| print(&Scaled, &with(|options| options.common = vec![1])));
    assert_named(|| print(&Scaled, &with(|options| options.wanted = vec![1])));
    assert_named(|| print(&Scaled, &with(|options| options.entries = Some(vec![1]))));
    assert_named(|| print(&Scaled, &with(|options| options.workgroup = 0)));
    assert_named(|| print(&Scaled, &with(|options| options.kept = 0)));
    assert_named(|| print(&Scaled, &with(|options| options.state_bound = Some(-1.0))));
    let endless = CotangentBound {
        norm: 1.0,
        every: 0,
    };
    let endless = Options {
        cotangent_bound: Some(endless),
        ..Options::default()
    };
    assert_named(|| print(&Scaled, &endless));
    let none = with(|options| options.cotangent_units = Some([].into()));
    assert_named(|| print(&Scaled, &none));
}
