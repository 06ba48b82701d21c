//! Makes a law along bars a [`Force`] on the nodes of a lattice.

use std::any::Any;
use std::sync::Arc;

use autodiff::Dual;
use autodiff_programs::{Array, Program};

use super::along_bars::AlongBars;
use super::bar::{Bar, BarForce, MovingTension, Tension};
use super::force::{AnyForce, Force};
use super::law::{StepInput, step_inputs};
use super::pose::{ForceParameters, Step};
use super::slopes::{Slopes, Tensions};
use crate::geometry::Axes;
use crate::in_dimension;
use crate::lattice::Lattice;
use crate::settings::Settings;

/// Makes a law along bars a [`Force`] on the nodes of a lattice.
#[derive(Clone, Debug)]
pub(crate) struct OnBars<L>(pub(crate) L);

impl<L: BarForce> AnyForce for OnBars<L> {
    fn name(&self) -> &'static str {
        L::NAME
    }
    fn settings(&mut self) -> &mut dyn Settings {
        &mut self.0
    }
    fn boxed(&self) -> Box<dyn AnyForce> {
        Box::new(self.clone())
    }
    fn any(&self) -> &dyn Any {
        self
    }
    fn on(&self, _: &Lattice) -> Option<Arc<dyn Force>> {
        Some(Arc::new(self.clone()))
    }
}

impl<L: BarForce> Force for OnBars<L> {
    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(&self.0)
    }

    fn record(&self, p: &mut Program, step: &Step, given: &ForceParameters<Array>) -> Axes<Array> {
        let tension = Tension {
            law: self.0.clone(),
            dt: step.dt,
            softening: step.softening,
            largest_strain: step.largest_strain,
        };
        let edge = step.per_edge();
        in_dimension!(step.dimension(), D => if L::NEEDS_RATE {
            let ends = step.nodes.axes::<{ 2 * D }>();
            let moving = MovingTension(tension);
            p.map_edges::<_, { 2 * D }, { 2 * D + 4 }, D>(step.graph, moving, ends, &edge, &given.inputs).into()
        } else {
            let ends = step.nodes.x.array::<D>();
            p.map_edges::<_, D, { D + 4 }, D>(step.graph, tension, ends, &edge, &given.inputs).into()
        })
    }

    fn along_bars(&self) -> Option<&dyn AlongBars> {
        Some(self)
    }
}

impl<L: BarForce> AlongBars for OnBars<L> {
    fn noun(&self) -> &'static str {
        L::NOUN
    }

    fn tension(&self, bar: Bar<f64>) -> Dual<f64, 2> {
        let constant = Dual::constant;
        let rate = match L::NEEDS_RATE {
            true => Dual::variable(bar.rate, 1),
            false => constant(0.0),
        };
        let bar = Bar {
            length: Dual::variable(bar.length, 0),
            rate,
            target: constant(bar.target),
            rest_length: constant(bar.rest_length),
            stiffness: constant(bar.stiffness),
            strain: constant(bar.strain),
            largest_strain: bar.largest_strain,
        };
        L::tension(&self.0.constant::<Dual<f64, 2>>(), bar)
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        self.0.energy(bar)
    }

    fn record_tensions(
        &self,
        p: &mut Program,
        step: &Step,
        given: &ForceParameters<Array>,
    ) -> Tensions {
        let slopes = Slopes {
            law: self.0.clone(),
            softening: step.softening,
            largest_strain: step.largest_strain,
        };
        let edge = step.per_edge();
        in_dimension!(step.dimension(), D => {
            let ends = step.nodes.axes::<{ 2 * D }>();
            p.map_each_edge::<_, { 2 * D }, { 2 * D + 4 }, 3>(step.graph, slopes, ends, &edge, &given.inputs)
        })
        .into()
    }
}
