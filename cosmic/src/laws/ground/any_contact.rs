//! Contact laws as trait objects: they record the kernels of a law.

use std::fmt::Debug;

use autodiff_programs::{Array, Fields, Program};

use super::contact::{Contact, Flat, Flying, PushedNode};
use super::hold::{Grip, Landing};
use super::pass::NodeContacts;
use super::terrain::Terrain;
use crate::geometry::{Axes, Dimension};
use crate::laws::law::{StepInput, step_inputs};
use crate::laws::motion::{Drift, Motion, Particle};
use crate::settings::Settings;

/// A [`Contact`] as a trait object, for use without knowing its type.
pub(crate) trait AnyContact: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn has_ground(&self) -> bool;
    fn settings(&mut self) -> &mut dyn Settings;
    fn inputs(&self) -> Vec<StepInput>;
    fn boxed(&self) -> Box<dyn AnyContact>;
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
    /// nodes with the velocity in the step.
    fn land(
        &self,
        p: &mut Program,
        dt: f64,
        terrain: Option<&Terrain>,
        moving: Motion,
        contacts: &NodeContacts<Array>,
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
    /// The numbers of a [`Push`](crate::laws::kernels::Push), then the settings of the contact law, in arrays of one number.
    pub(crate) uniforms: &'a [Array],
}

impl FlightInputs<'_> {
    /// The inputs, by name.
    fn node<const D: usize>(&self) -> PushedNode<Array, D> {
        PushedNode {
            node: self.nodes.particle(),
            impulse: self.impulses.vector(),
            inverse_mass: self.inverse_mass,
        }
    }
}

/// Why a robot in space has no terrain.
const NO_TERRAIN: &str = "the ground of a robot in space is a plane";

/// Records a kernel for the ground of this law: flat, or with the profile of a terrain. `$ground` is the name of the ground
/// in the expression of the kernel.
macro_rules! map_over {
    ($p:ident, $terrain:ident, |$ground:ident| $kernel:expr, $node:expr, $settings:expr) => {
        match $terrain.cloned() {
            // The condition is constant, so that no kernel without ground is compiled for terrain.
            Some($ground) if const { C::HAS_GROUND } => $p.map($kernel, $node, $settings),
            _ => {
                let $ground = Flat;
                $p.map($kernel, $node, $settings)
            }
        }
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
    fn fly(
        &self,
        p: &mut Program,
        drift: Drift,
        terrain: Option<&Terrain>,
        pushed: FlightInputs,
    ) -> Motion {
        let contact = self.clone();
        if pushed.nodes.dimension() == Dimension::Space {
            assert!(terrain.is_none(), "{}", NO_TERRAIN);
            let flying = Flying::<_, _, 3> {
                drift,
                contact,
                ground: Flat,
            };
            let node = pushed.node::<3>().array();
            return Particle::<_, 3>::of(p.map(flying, node, pushed.uniforms)).into();
        }
        let node = pushed.node::<2>().array();
        let after = map_over!(
            p,
            terrain,
            |ground| Flying::<_, _, 2> {
                drift,
                contact,
                ground
            },
            node,
            pushed.uniforms
        );
        Particle::<_, 2>::of(after).into()
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
        contacts: &NodeContacts<Array>,
        settings: &[Array],
    ) -> Motion {
        // The condition is constant, so that no kernel is compiled.
        if const { !C::HAS_GROUND } {
            return moving;
        }
        let contact = self.clone();
        if moving.dimension() == Dimension::Space {
            assert!(terrain.is_none(), "{}", NO_TERRAIN);
            let (node, ground) = (contacts.landing::<3>(moving), Flat);
            let landing = Landing::<_, _, 3> {
                contact,
                ground,
                dt,
            };
            return Particle::<_, 3>::of(p.map(landing, node.array(), settings)).into();
        }
        let node = contacts.landing::<2>(moving).array();
        let after = map_over!(
            p,
            terrain,
            |ground| Landing::<_, _, 2> {
                contact,
                ground,
                dt
            },
            node,
            settings
        );
        Particle::<_, 2>::of(after).into()
    }
}
