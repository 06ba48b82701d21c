//! What a rollout computes in every step and what it leaves out, with what each costs or saves.
//!
//! The choice is made once, before the first step, by the scene and by the robot: a step holds no
//! flag. What a term costs is measured by leaving it out of rollouts, and what is saved by a term
//! that is left out by putting it back.

use super::clock::least_times;
use super::speed::Subject;
use super::voids::{Voids, keep_all, saving_of_eight};
use cosmic::case::Case;
use cosmic::ground::Ground;
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::projection::Body;
use cosmic::scene::{Contact, ControllerSettings, LossSettings, PhysicsSettings, VoidEdges};
use cosmic::simulator::{Simulator, Span};

/// Steps of a measured rollout.
const STEPS: usize = 1024;
/// Times that each is measured, in turns; the least counts, as the one least disturbed.
const ROUNDS: usize = 15;
/// The section's radius of gyration (m) with which bending is put back.
const SOME_BENDING: f64 = 0.01;
/// A scale with which the controller sees something, and too little of it to act on.
const LEAST_SCALE: f64 = 1e-150;

/// A term of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What it is.
    pub name: &'static str,
    /// Whether it is computed in every step.
    pub kept: bool,
    /// Why, or why not.
    pub why: String,
    /// Microseconds a step that it costs, or that are saved without it; where it was measured.
    pub time: Option<f64>,
}

/// What a rollout of a case computes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The terms, in the order of a step; those of gradients last.
    pub terms: Vec<Term>,
    /// Microseconds a step, where they were measured.
    pub step: Option<f64>,
    /// What is to be said of the void edges of a layout; `None` for a mixture.
    pub voids: Option<Voids>,
}

/// What is known of a case's rollout, as far as terms depend on it.
struct Facts<'a> {
    case: &'a Case,
    body: Body<f64>,
    /// Edges that strain, and edges in all.
    outputs: [usize; 2],
    /// Whether the controller sees positions, and velocities.
    senses: [bool; 2],
}

impl Plan {
    /// The plan of a case's rollout.
    pub fn of(case: &Case) -> Self {
        let voids = Voids::of(case);
        Self {
            terms: Facts::new(case).terms(voids.as_ref()),
            step: None,
            voids,
        }
    }

    /// The plan, every term timed that can be put in or left out; the losses are for the gradients.
    pub fn measured(case: &Case, loss: &LossSettings) -> Self {
        let (facts, mut plan) = (Facts::new(case), Self::of(case));
        let variants = facts.variants(plan.voids.as_ref());
        let span = Span::from_start(vec![STEPS]);
        let times = least_times(ROUNDS, &variants, |variant| {
            let Variant {
                simulator, body, ..
            } = variant;
            simulator.rollout(body, &case.controller, &case.start, &span)
        });
        let per_step = |time: f64| time * 1e6 / STEPS as f64;
        let as_planned = per_step(times[0]);
        for (variant, &time) in variants.iter().zip(&times).skip(1) {
            let term = plan.term(variant.term);
            let added = per_step(time) - as_planned;
            term.time = Some(if term.kept { -added } else { added }.max(0.0));
        }
        plan.split_network();
        plan.add_saving(&facts);
        plan.add_gradients(case, loss);
        plan.step = Some(as_planned);
        plan
    }

    /// Without outputs there is no network at all: what that saved is both layers.
    fn split_network(&mut self) {
        let output = self.term(OUTPUT).time;
        let hidden = &mut self.term(HIDDEN).time;
        let times = hidden.zip(output);
        *hidden = times.map(|(both, output)| (both - output).max(0.0));
    }

    /// A term by its name.
    fn term(&mut self, name: &str) -> &mut Term {
        let term = self.terms.iter_mut().find(|term| term.name == name);
        term.expect("a plan has every term")
    }

    /// What a step without void edges saves, alone and with others.
    fn add_saving(&mut self, facts: &Facts) {
        let single = self.term(VOID_EDGES).time.unwrap_or(0.0);
        let Some(voids) = &mut self.voids else { return };
        let simulator = facts.simulator(|_, _| ());
        let of_eight = saving_of_eight(facts.case, &simulator, [STEPS, ROUNDS]);
        voids.saving = Some([single, of_eight]);
    }

    /// What the gradients that an update does not ask for would cost.
    fn add_gradients(&mut self, case: &Case, loss: &LossSettings) {
        let subject = Subject::new(case, loss);
        let both = [DESIGN, CONTROLLER].concat();
        let blocks = [DESIGN, CONTROLLER, &both];
        let times = least_times(ROUNDS, &blocks, |blocks| subject.gradient::<f64>(blocks));
        for (name, other) in [(BY_WEIGHTS, times[0]), (BY_DESIGN, times[1])] {
            let added = (times[2] - other).max(0.0);
            self.term(name).time = Some(added * 1e6 / subject.steps() as f64);
        }
    }
}

const HIDDEN: &str = "hidden layer";
const OUTPUT: &str = "output layer";
const IDLE: &str = "idle outputs";
const POSITIONS: &str = "sight of positions";
const VELOCITIES: &str = "sight of velocities";
const BENDING: &str = "bending of bars";
const VOID_EDGES: &str = "void edges";
const STIFFENING: &str = "stiffening springs";
const GROUND: &str = "contact with the ground";
const FRICTION: &str = "Coulomb friction";
const BY_WEIGHTS: &str = "gradient by weights";
const BY_DESIGN: &str = "gradient by the design";

fn term(name: &'static str, kept: bool, why: impl Into<String>) -> Term {
    Term {
        name,
        kept,
        why: why.into(),
        time: None,
    }
}

impl<'a> Facts<'a> {
    fn new(case: &'a Case) -> Self {
        let body = case.body();
        // An edge without stiffness pulls on nothing, strained or not.
        let edges = body.strain.iter().zip(&body.stiffness);
        let strains = edges.filter(|(strain, stiffness)| **strain != 0.0 && **stiffness != 0.0);
        Self {
            outputs: [strains.count(), body.strain.len()],
            senses: case.observation.senses(),
            case,
            body,
        }
    }

    fn terms(&self, voids: Option<&Voids>) -> Vec<Term> {
        let physics = &self.case.physics;
        let mut terms = self.controller_terms();
        terms.extend([
            term("springs", true, self.springs()),
            self.void_edges(voids),
            term(
                STIFFENING,
                physics.stiffening > 0.0,
                format!("physics.stiffening is {}", physics.stiffening),
            ),
            term(
                BENDING,
                physics.bending_radius > 0.0,
                format!("physics.bending_radius is {} m", physics.bending_radius),
            ),
        ]);
        terms.extend(self.ground_terms());
        terms.extend([
            term(
                BY_WEIGHTS,
                false,
                "not in updates of the design, which ask for the gradient by the design alone",
            ),
            term(
                BY_DESIGN,
                false,
                match self.case.frozen {
                    Some(_) => "the layout is frozen",
                    None => "not in updates of the controller",
                },
            ),
        ]);
        terms
    }

    fn controller_terms(&self) -> Vec<Term> {
        let ([some, all], hidden) = (self.outputs, self.case.controller.hidden);
        let why_blind = |sees: bool, scale: &str| match (sees, some) {
            (false, _) => format!("controller.{scale} is 0"),
            (true, 0) => "there is no controller: no edge strains".to_owned(),
            (true, _) => "the controller sees them".to_owned(),
        };
        let [positions, velocities] = self.senses;
        vec![
            term(
                "making of observations",
                false,
                "mean, scales, goal, clocks of one frequency and rotation are folded into the \
                 weights once",
            ),
            term(
                HIDDEN,
                some > 0,
                format!("{hidden} units, of what the controller sees"),
            ),
            term(
                POSITIONS,
                positions && some > 0,
                why_blind(positions, "offset_scale"),
            ),
            term(
                VELOCITIES,
                velocities && some > 0,
                why_blind(velocities, "velocity_scale"),
            ),
            term(OUTPUT, some > 0, format!("{some} edges strain")),
            match all - some {
                0 => term(IDLE, true, "there are none: every edge strains a little"),
                idle => term(
                    IDLE,
                    false,
                    format!("{idle} edges do not strain, or have no stiffness"),
                ),
            },
        ]
    }

    fn springs(&self) -> String {
        let pulling = self.body.stiffness.iter().filter(|k| **k != 0.0);
        let edges = pulling.count();
        match self.case.physics.substeps {
            1 => format!("{edges} edges, in whole lanes"),
            substeps => format!("{edges} edges, {substeps} times a step"),
        }
    }

    fn void_edges(&self, voids: Option<&Voids>) -> Term {
        let Some(voids) = voids else {
            return term(VOID_EDGES, true, "no edge of a mixture is void");
        };
        let (edges, [all, without]) = (voids.edges, voids.registers);
        let why = match (self.case.physics.void_edges, voids.dropped) {
            (VoidEdges::Drop, _) => "physics.void_edges is \"drop\"",
            (VoidEdges::Keep, true) => "void has no stiffness",
            (VoidEdges::Keep, false) => "physics.void_edges is \"keep\"",
        };
        let (of, registers) = (self.case.lattice.edges.len(), all - without);
        let skipped = if voids.dropped {
            " and are skipped"
        } else {
            ""
        };
        term(
            VOID_EDGES,
            !voids.dropped,
            format!(
                "{edges} of {of}: {why}; {registers} of {all} registers of edges hold no other \
                 edge{skipped}"
            ),
        )
    }

    fn ground_terms(&self) -> Vec<Term> {
        let physics = &self.case.physics;
        let rotation = if Ground::from(physics).is_flat() {
            "the ground is flat"
        } else {
            "all is computed in the ground's frame; gravity and weights are turned once"
        };
        let nodes = format!("{} nodes", self.case.lattice.nodes());
        let (contact, friction) = match physics.contact {
            Contact::None => (
                "there is no ground".to_owned(),
                "there is no ground".to_owned(),
            ),
            Contact::Infinite => (
                nodes,
                "friction is infinite: nodes stick where they touch".to_owned(),
            ),
            Contact::Coulomb => (nodes, format!("coefficient {}", physics.friction)),
        };
        let is_coulomb = physics.contact == Contact::Coulomb;
        vec![
            term(GROUND, physics.contact != Contact::None, contact),
            term(FRICTION, is_coulomb, friction),
            term("rotation of an incline", false, rotation),
        ]
    }
}

/// A rollout with a term put in or left out.
struct Variant {
    term: &'static str,
    simulator: Simulator,
    body: Body<f64>,
}

impl Facts<'_> {
    /// The rollout as it is planned, and one for every term that can be turned over.
    fn variants(&self, voids: Option<&Voids>) -> Vec<Variant> {
        let physics = &self.case.physics;
        let as_planned = || self.simulator(|_, _| ());
        let variant = |term, simulator, body| Variant {
            term,
            simulator,
            body,
        };
        let mut variants = vec![variant("", as_planned(), self.body.clone())];
        let [outputs, edges] = self.outputs;
        if outputs > 0 && outputs < edges {
            let mut body = self.body.clone();
            keep_all(&mut body.strain);
            variants.push(variant(IDLE, as_planned(), body));
        }
        let mut add = |term, change: &dyn Fn(&mut PhysicsSettings, &mut ControllerSettings)| {
            variants.push(variant(term, self.simulator(change), self.body.clone()));
        };
        if outputs > 0 && !self.senses[0] {
            add(POSITIONS, &|_, sight| sight.offset_scale = LEAST_SCALE);
        }
        if outputs > 0 && !self.senses[1] {
            add(VELOCITIES, &|_, sight| sight.velocity_scale = LEAST_SCALE);
        }
        let other = |number: f64, on: f64| if number > 0.0 { 0.0 } else { on };
        let bending = other(physics.bending_radius, SOME_BENDING);
        let stiffening = other(physics.stiffening, 1.0);
        let (ground, friction) = match physics.contact {
            Contact::None => (Contact::Infinite, Contact::Coulomb),
            Contact::Infinite => (Contact::None, Contact::Coulomb),
            Contact::Coulomb => (Contact::None, Contact::Infinite),
        };
        add(BENDING, &|p, _| p.bending_radius = bending);
        add(STIFFENING, &|p, _| p.stiffening = stiffening);
        add(GROUND, &|p, _| p.contact = ground);
        add(FRICTION, &|p, _| p.contact = friction);
        variants.extend(voids.map(|voids| {
            let (simulator, body) = voids.turned_over(self.case, as_planned());
            variant(VOID_EDGES, simulator, body)
        }));
        if outputs > 0 {
            let strains = self.body.strain.iter().position(|strain| *strain != 0.0);
            for (term, kept) in [(HIDDEN, None), (OUTPUT, strains)] {
                let mut body = self.body.clone();
                for (edge, strain) in body.strain.iter_mut().enumerate() {
                    *strain = if Some(edge) == kept { *strain } else { 0.0 };
                }
                variants.push(variant(term, as_planned(), body));
            }
        }
        variants
    }

    /// A simulator of [`STEPS`] steps, with some settings changed.
    fn simulator(
        &self,
        change: impl FnOnce(&mut PhysicsSettings, &mut ControllerSettings),
    ) -> Simulator {
        let case = self.case;
        let (mut physics, mut sight) = (case.physics.clone(), case.observation.clone());
        physics.steps = STEPS;
        change(&mut physics, &mut sight);
        Simulator::new(&case.lattice, &physics, &sight)
    }
}
