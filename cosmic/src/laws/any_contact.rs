//! Contact laws as trait objects: they record the kernels of a law.

use std::fmt::Debug;

use autodiff_programs::{Array, Program};

use super::contact::{Contact, Flat, Flying};
use super::hold::{Grip, Landing};
use super::law::{StepInput, step_inputs};
use super::motion::{Drift, Motion};
use super::terrain::Terrain;
use crate::geometry::{Axes, Dimension, inputs};
use crate::settings::Settings;

/// A [`Contact`] as a trait object, for use without knowing its type.
pub(crate) trait AnyContact: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn has_ground(&self) -> bool;
    fn settings(&mut self) -> &mut dyn Settings;
    fn inputs(&self) -> Vec<StepInput>;
    fn boxed(&self) -> Box<dyn AnyContact>;
    fn with_friction(&self, friction: f64) -> Box<dyn AnyContact>;
    /// Records a step of all nodes with the kernel [`Flying`], and returns the nodes after it.
    fn fly(
        &self,
        p: &mut Program,
        drift: Drift,
        terrain: Option<&Terrain>,
        pushed: FlightInputs,
    ) -> Motion;
    /// Records the largest friction of the law, as an array of one number. `any` is an array of one number.
    fn grip(&self, p: &mut Program, any: Array, settings: &[Array]) -> Array;
    /// Records the end of an implicit step with the kernel [`Landing`], and returns the nodes after it. `moving` are the
    /// nodes with the velocity in the step, and `contacts` are the inputs of the kernel after them.
    fn land(
        &self,
        p: &mut Program,
        dt: f64,
        terrain: Option<&Terrain>,
        moving: Motion,
        contacts: &[Array],
        settings: &[Array],
    ) -> Motion;
}

/// The inputs of the kernel [`Flying`]: all nodes, and the impulses and velocities that a push adds to them.
pub(crate) struct FlightInputs<'a> {
    pub(crate) nodes: Motion,
    /// The impulse on each node, N s.
    pub(crate) impulses: Axes<Array>,
    /// 1 / mass, 1/kg.
    pub(crate) inverse_mass: Array,
    /// The numbers of a [`Push`](super::Push), then the settings of the contact law, in arrays of one number.
    pub(crate) uniforms: &'a [Array],
}

/// Why a robot in space has no terrain.
const NO_TERRAIN: &str = "the ground of a robot in space is a plane";

/// Records a kernel for the ground of this law: flat, or with the profile of a terrain. `$ground` is the name of the ground
/// in the expression of the kernel.
macro_rules! map_over {
    ($p:ident, $terrain:ident, |$ground:ident| $kernel:expr, $node:expr, $settings:expr) => {
        Motion::of(Dimension::Plane, &match $terrain.cloned() {
            // The condition is constant, so that no kernel without ground is compiled for terrain.
            Some($ground) if const { C::HAS_GROUND } => $p.map($kernel, $node, $settings),
            _ => {
                let $ground = Flat;
                $p.map($kernel, $node, $settings)
            }
        })
    };
}

impl<C: Contact> AnyContact for C {
    fn name(&self) -> &'static str {
        C::NAME
    }
    fn has_ground(&self) -> bool {
        C::HAS_GROUND
    }
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }
    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(self)
    }
    fn boxed(&self) -> Box<dyn AnyContact> {
        Box::new(self.clone())
    }
    fn with_friction(&self, friction: f64) -> Box<dyn AnyContact> {
        Box::new(self.clone().with_friction(friction))
    }
    fn fly(
        &self,
        p: &mut Program,
        drift: Drift,
        terrain: Option<&Terrain>,
        pushed: FlightInputs,
    ) -> Motion {
        let vectors = [pushed.nodes.x, pushed.nodes.v, pushed.impulses];
        let contact = self.clone();
        if pushed.nodes.dimension() == Dimension::Space {
            assert!(terrain.is_none(), "{}", NO_TERRAIN);
            let (node, ground) = (inputs::<_, 10>(&vectors, &[pushed.inverse_mass]), Flat);
            let flying = Flying {
                drift,
                contact,
                ground,
            };
            return Motion::of(Dimension::Space, &p.map(flying, node, pushed.uniforms));
        }
        let node = inputs::<_, 7>(&vectors, &[pushed.inverse_mass]);
        map_over!(
            p,
            terrain,
            |ground| Flying {
                drift,
                contact,
                ground
            },
            node,
            pushed.uniforms
        )
    }
    fn grip(&self, p: &mut Program, any: Array, settings: &[Array]) -> Array {
        p.map(Grip(self.clone()), [any], settings)[0]
    }
    fn land(
        &self,
        p: &mut Program,
        dt: f64,
        terrain: Option<&Terrain>,
        moving: Motion,
        contacts: &[Array],
        settings: &[Array],
    ) -> Motion {
        // The condition is constant, so that no kernel is compiled.
        if const { !C::HAS_GROUND } {
            return moving;
        }
        let (vectors, contact) = ([moving.x, moving.v], self.clone());
        if moving.dimension() == Dimension::Space {
            assert!(terrain.is_none(), "{}", NO_TERRAIN);
            let (node, ground) = (inputs::<_, 12>(&vectors, contacts), Flat);
            let landing = Landing {
                contact,
                ground,
                dt,
            };
            return Motion::of(Dimension::Space, &p.map(landing, node, settings));
        }
        let node = inputs::<_, 9>(&vectors, contacts);
        map_over!(
            p,
            terrain,
            |ground| Landing {
                contact,
                ground,
                dt
            },
            node,
            settings
        )
    }
}
