//! Programs printed as WGSL: which ones are refused. The package `cosmic-gpu` parses the texts and compares the numbers on
//! a device.

use autodiff_programs::wgsl::{Options, print};
use autodiff_programs::{Graph, Model, Program};

use crate::steps::Pushed;

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

#[test]
fn what_cannot_be_printed_is_refused() {
    let refused = print(&Implicit, &Options::default()).unwrap_err();
    assert!(
        refused.to_string().contains("solves linear equations"),
        "{refused}"
    );
    let refused = print(&Pushed, &Options::default()).unwrap_err();
    assert!(refused.to_string().contains("has a control"), "{refused}");
}
