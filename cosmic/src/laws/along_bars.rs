//! Forces along bars: what follows from the tension of a single bar.

use autodiff::Dual;
use autodiff_programs::{Array, Program};

use super::bar::Bar;
use super::pose::{ForceParameters, Pose, Pull, Step};
use super::slopes::{BESIDE, Tensions};
use super::stiffness::{BarStiffness, Stiffness};

/// A factor slightly above 1. A stroke multiplied by this factor ends beyond the stop in spite of rounding errors.
const BEYOND: f64 = 1.0 + 1e-9;

/// A force along every bar. The tension that it adds to a bar depends on this bar alone.
pub trait AlongBars {
    /// The noun for the bar in messages, such as "spring".
    fn noun(&self) -> &'static str;

    /// The tension that this force adds to a bar, N, with its derivatives with respect to the length (N/m) and to the rate
    /// of the length (N s/m).
    fn tension(&self, bar: Bar<f64>) -> Dual<f64, 2>;

    /// The potential energy of a bar, J; `None` if the force has none.
    fn energy(&self, bar: Bar<f64>) -> Option<f64>;

    /// Records [`tension`](AlongBars::tension) for every bar.
    fn record_tensions(
        &self,
        p: &mut Program,
        step: &Step,
        given: &ForceParameters<Array>,
    ) -> Tensions;
}

/// A bar whose target is its rest length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RestingBar {
    /// The stiffness of the bar's material, N/m.
    pub(crate) stiffness: f64,
    /// The rest length, m.
    pub(crate) rest_length: f64,
    /// The length minus the target length, m.
    pub(crate) off: f64,
    /// The largest strain of the actuator material.
    pub(crate) largest_strain: f64,
}

impl dyn AlongBars + '_ {
    /// The largest derivatives of the tension of a bar that is longer or shorter than at rest by slightly more than its
    /// stroke, or nearly at rest: with respect to the length (N/m) and to its rate (N s/m).
    pub(crate) fn largest_slopes(&self, bar: RestingBar) -> [f64; 2] {
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
        let slopes = bars.map(|bar| self.tension(bar).tangent);
        slopes.fold([f64::NEG_INFINITY; 2], |[length, rate], slopes| {
            [length.max(slopes[0]), rate.max(slopes[1])]
        })
    }

    /// The stiffness of each bar at a length just outside the range of its actuator, so that the stiffness of stops is
    /// included. A bar whose stiffness grows as other forces stretch it even further would be stiffer.
    pub(super) fn stiffness(&self, pose: &Pose) -> Stiffness {
        let mut stiffness = Stiffness::none(pose);
        for edge in 0..pose.lattice.edges.len() {
            let bar = pose.bar(edge);
            let [along, damping] = self.largest_slopes(RestingBar {
                stiffness: bar.stiffness,
                rest_length: bar.rest_length,
                off: bar.strain * bar.rest_length,
                largest_strain: bar.largest_strain,
            });
            // A tension at rest, such as that of prestressed rubber, resists displacements across the bar too.
            let across = (along * (1.0 - bar.rest_length / bar.length))
                .max(self.tension(bar).value / bar.length);
            stiffness.bars[edge] = BarStiffness { along, across };
            stiffness.bar_damping[edge] = damping;
        }
        stiffness
    }

    /// The force of each bar on a node, without those of bars that have no stiffness.
    pub(super) fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let edges = pose.lattice.edges.iter().enumerate();
        let here = edges.filter(|(e, ends)| ends.contains(&node) && pose.body.stiffness[*e] != 0.0);
        let pull = |(edge, &[i, j]): (usize, &[usize; 2])| {
            let bar = pose.bar(edge);
            let per_length = self.tension(bar).value / bar.length;
            let other = if i == node { j } else { i };
            let x = &pose.state.x;
            Pull {
                part: format!("the {} of edge {edge} [{i}, {j}]", self.noun()),
                force: (x[other] - x[node]) * per_length,
            }
        };
        here.map(pull).collect()
    }

    /// The potential energy of all bars, J; `None` if the force has none.
    pub(super) fn energy_of_all(&self, pose: &Pose) -> Option<f64> {
        let edges = 0..pose.lattice.edges.len();
        edges.map(|edge| self.energy(pose.bar(edge))).sum()
    }
}
