//! Forces that are formulas in the scene. Other laws are compiled; the kernels of these are replayed.

use autodiff::Real;
use autodiff_programs::Compiled;

use super::bars::{Bar, BarForce};
use super::forces::{Node, NodeForce};
use super::law::Law;
use crate::geometry::Vector;
use crate::kernel;
use crate::settings::Expression;

/// The names of the numbers of a bar, as in [`Bar`], and of the settings.
const OF_BARS: &[&str] = &[
    "length",
    "rate",
    "target",
    "rest_length",
    "stiffness",
    "strain",
    "actuator",
    "a",
    "b",
    "c",
    "d",
];

/// The names of the numbers of a node, as in [`Node`], and of the settings.
const OF_NODES: &[&str] = &[
    "x", "y", "z", "vx", "vy", "vz", "mass", "time", "a", "b", "c", "d",
];

crate::settings! {
    /// A force along bars that is a formula.
    struct BarFormula<R> {
        /// Tension of a bar in addition to its spring; positive if the bar pulls. The numbers of a bar are its `length` (m),
        /// the `rate` of its length (m/s), its `target` length and `rest_length` (m), its `stiffness` (N/m), the `strain` of
        /// its target at full activation, and its share of `actuator`. In `max(p, q)` and `min(p, q)`, the derivative of
        /// equal numbers is that of `q`.
        tension: Expression = Expression::zero(OF_BARS), unit "N", source "beyond the paper";
        /// The number `a` in the formula. A rollout has derivatives with respect to `a`, `b`, `c` and `d`.
        a: R = 0.0, source "beyond the paper";
        /// The number `b` in the formula.
        b: R = 0.0, source "beyond the paper";
        /// The number `c` in the formula.
        c: R = 0.0, source "beyond the paper";
        /// The number `d` in the formula.
        d: R = 0.0, source "beyond the paper";
    }
}

impl Law for BarFormula {
    const NAME: &'static str = "bar_formula";
    const COMPILED: Compiled = Compiled::Never; // the formula is a setting
}

#[kernel]
impl BarForce for BarFormula {
    const NEEDS_RATE: bool = true;

    fn tension<R: Real>(law: &BarFormula<R>, bar: Bar<R>) -> R {
        law.tension.eval(&[
            bar.length,
            bar.rate,
            bar.target,
            bar.rest_length,
            bar.stiffness,
            bar.strain,
            bar.share_of_actuator(),
            law.a,
            law.b,
            law.c,
            law.d,
        ])
    }
}

crate::settings! {
    /// A force on every node that is a formula.
    struct NodeFormula<R> {
        /// Force along the ground. The numbers of a node are its position `x` along the ground, `y` across and `z` out of it
        /// (m), its velocity `vx`, `vy` and `vz` (m/s), its `mass` (kg), and the `time` (s).
        force_x: Expression = Expression::zero(OF_NODES), unit "N", source "beyond the paper";
        /// Force across. It has no effect on planar robots, whose `y` and `vy` are 0.
        force_y: Expression = Expression::zero(OF_NODES), unit "N", source "beyond the paper";
        /// Force out of the ground.
        force_z: Expression = Expression::zero(OF_NODES), unit "N", source "beyond the paper";
        /// The number `a` in the formulas. A rollout has derivatives with respect to `a`, `b`, `c` and `d`.
        a: R = 0.0, source "beyond the paper";
        /// The number `b` in the formulas.
        b: R = 0.0, source "beyond the paper";
        /// The number `c` in the formulas.
        c: R = 0.0, source "beyond the paper";
        /// The number `d` in the formulas.
        d: R = 0.0, source "beyond the paper";
    }
}

impl Law for NodeFormula {
    const NAME: &'static str = "node_formula";
    const COMPILED: Compiled = Compiled::Never; // the formula is a setting
}

#[kernel]
impl NodeForce for NodeFormula {
    const NEEDS_TIME: bool = true;

    fn force<R: Real, const D: usize>(law: &NodeFormula<R>, node: Node<R, D>) -> Vector<R, D> {
        let numbers = [
            node.x.forward(),
            node.x.sideways(),
            node.x.up(),
            node.v.forward(),
            node.v.sideways(),
            node.v.up(),
            node.mass,
            node.time,
            law.a,
            law.b,
            law.c,
            law.d,
        ];
        let [x, y, z] =
            [&law.force_x, &law.force_y, &law.force_z].map(|force| force.eval(&numbers));
        Vector::upright(x, z).with_sideways(y)
    }
}
