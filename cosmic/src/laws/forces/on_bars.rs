//! Makes a law along bars a [`Force`] on the nodes of a lattice.

use std::sync::Arc;

use autodiff::Dual;
use autodiff_programs::{Array, Fields, Program};

use super::force::{
    AlongBars, AnyForce, Force, ForceLaw, ForceParameters, Pose, Pull, RestingBar, Step,
};
use super::stiffness::Stiffness;
use crate::geometry::Axes;
use crate::in_dimension;
use crate::lattice::EdgeVector;
use crate::laws::bars::{
    BESIDE, Bar, BarForce, EdgeNumbers, MovingTension, Slopes, Tension, Tensions,
};
use crate::laws::law::{StepInput, step_inputs};

/// A factor slightly above 1. A stroke multiplied by this factor ends beyond the stop in spite of rounding errors.
const BEYOND: f64 = 1.0 + 1e-9;

/// A law along bars, as a [`Force`] on the nodes of a lattice.
#[derive(Clone, Debug)]
pub(crate) struct OnBars<L>(pub(crate) L);

/// A law for a force along bars.
pub(crate) fn on_bars<L: BarForce>() -> Box<dyn AnyForce> {
    ForceLaw::<L>::boxed(|law, _| Some(Arc::new(OnBars(law.clone()))))
}

impl<L: BarForce> OnBars<L> {
    /// Makes the numbers of an edge's bar in a pose that the tension may depend on.
    fn bar(&self, pose: &Pose, edge: usize) -> Bar<f64> {
        let between = EdgeVector::of(&pose.state, pose.lattice.edges[edge]);
        let numbers = EdgeNumbers {
            activation: pose.activation.get(edge).copied().unwrap_or(0.0),
            stiffness: pose.body.stiffness[edge],
            rest_length: (pose.body.rest_length.get(edge))
                .map_or(pose.lattice.rest_length[edge], |&length| length),
            strain: pose.body.strain[edge],
        };
        let length = between.length(pose.lattice.softening());
        let moving = [length, between.rate(length)];
        Bar::new(moving, numbers, pose.body.largest_strain)
    }

    /// A derivative of the tension: with respect to the rate of the length (N s/m) if `by_rate` is true, otherwise with
    /// respect to the length (N/m).
    fn slope(&self, bar: Bar<f64>, by_rate: bool) -> f64 {
        let constant = Dual::<f64, 1>::constant;
        let mut moving = Bar {
            length: constant(bar.length),
            rate: constant(bar.rate),
            target: constant(bar.target),
            rest_length: constant(bar.rest_length),
            stiffness: constant(bar.stiffness),
            strain: constant(bar.strain),
            largest_strain: bar.largest_strain,
        };
        let by = if by_rate {
            &mut moving.rate
        } else {
            &mut moving.length
        };
        *by = Dual::variable(by.value, 0);
        L::tension(&self.0.constant::<Dual<f64, 1>>(), moving).tangent[0]
    }

    /// The largest [slope](Self::slope) of a bar that is longer or shorter than at rest by slightly more than its stroke,
    /// or nearly at rest.
    fn largest_slope(&self, bar: RestingBar, by_rate: bool) -> f64 {
        let RestingBar {
            stiffness,
            rest_length,
            off,
            largest_strain,
        } = bar;
        let changes = [off * BEYOND, off * BESIDE, -off * BESIDE, -off * BEYOND];
        let bars = changes.into_iter().flat_map(|change| {
            [-BESIDE, 0.0, BESIDE].map(|rate| Bar {
                length: rest_length + change,
                rate,
                target: rest_length,
                rest_length,
                stiffness,
                strain: (off / rest_length).abs(),
                largest_strain,
            })
        });
        let slopes = bars.map(|bar| self.slope(bar, by_rate));
        slopes.fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<L: BarForce> Force for OnBars<L> {
    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(&self.0)
    }

    fn record(&self, p: &mut Program, step: &Step, given: &ForceParameters<Array>) -> Axes<Array> {
        let (graph, numbers) = (step.graph, step.numbers().list());
        in_dimension!(step.dimension(), D => {
            let tension = Tension::<L, D> {
                law: self.0.clone(),
                dt: step.dt,
                softening: step.softening,
                largest_strain: step.largest_strain,
            };
            if L::NEEDS_RATE {
                let ends = step.nodes.particle::<D>().array::<{ 2 * D }>();
                p.map_edges(graph, MovingTension(tension), ends, &numbers, &given.inputs).into()
            } else {
                let ends = step.nodes.x.array::<D>();
                p.map_edges(graph, tension, ends, &numbers, &given.inputs).into()
            }
        })
    }

    fn along_bars(&self) -> Option<&dyn AlongBars> {
        Some(self)
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let edges = pose.lattice.edges.iter().enumerate();
        let here = edges.filter(|(e, ends)| ends.contains(&node) && pose.body.stiffness[*e] != 0.0);
        let pull = |(edge, &[i, j]): (usize, &[usize; 2])| {
            let bar = self.bar(pose, edge);
            let per_length = L::tension(&self.0, bar) / bar.length;
            let other = if i == node { j } else { i };
            let x = &pose.state.x;
            Pull {
                part: format!("the {} of edge {edge} [{i}, {j}]", L::NOUN),
                force: (x[other] - x[node]) * per_length,
            }
        };
        here.map(pull).collect()
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let edges = 0..pose.lattice.edges.len();
        edges.map(|edge| self.0.energy(self.bar(pose, edge))).sum()
    }

    /// Adds the stiffness of each bar at a length just outside the range of its actuator, so that the stiffness of
    /// stops is included. A bar whose stiffness grows as other forces stretch it even further would be stiffer.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for edge in 0..pose.lattice.edges.len() {
            let bar = self.bar(pose, edge);
            let resting = RestingBar {
                stiffness: bar.stiffness,
                rest_length: bar.rest_length,
                off: bar.strain * bar.rest_length,
                largest_strain: bar.largest_strain,
            };
            let k = self.stiffness(resting);
            stiffness.bar(edge, k, k * (1.0 - bar.rest_length / bar.length));
            if L::NEEDS_RATE {
                stiffness.dampen_bar(edge, self.damping(resting));
            }
        }
    }
}

impl<L: BarForce> AlongBars for OnBars<L> {
    fn record_tensions(
        &self,
        p: &mut Program,
        step: &Step,
        given: &ForceParameters<Array>,
    ) -> Tensions {
        let numbers = step.numbers().list();
        in_dimension!(step.dimension(), D => {
            let slopes = Slopes::<L, D> {
                law: self.0.clone(),
                softening: step.softening,
                largest_strain: step.largest_strain,
            };
            let ends = step.nodes.particle::<D>().array::<{ 2 * D }>();
            Tensions::of(p.map_each_edge(step.graph, slopes, ends, &numbers, &given.inputs))
        })
    }

    fn tension(&self, pose: &Pose, edge: usize) -> f64 {
        L::tension(&self.0, self.bar(pose, edge))
    }

    fn stiffness(&self, bar: RestingBar) -> f64 {
        self.largest_slope(bar, false)
    }

    fn damping(&self, bar: RestingBar) -> f64 {
        if !L::NEEDS_RATE {
            return 0.0;
        }
        self.largest_slope(bar, true)
    }
}
