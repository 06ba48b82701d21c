//! The terms that a rollout computes in every step and those that it leaves out, with their costs and
//! savings.
//!
//! Scene and robot decide once, before the first step: a step tests no flag. The cost of a term is
//! measured by leaving it out of rollouts, the saving of an omitted one by putting it back.

use super::clock::least_times;
use super::speed::Subject;
use super::voids::{Voids, keep_all, saving_of_eight};
use cosmic::case::Case;
use cosmic::geometry::Ground;
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::lattice::Body;
use cosmic::laws::ContactLaw;
use cosmic::scene::{
    ControllerSettings, LossSettings, PhysicsSettings, ProfileKind, Senses, VoidEdges,
};
use cosmic::simulator::{Simulator, Span};
use std::iter::once;

/// Steps of a measured rollout.
const STEPS: usize = 1024;
/// Rounds of measurements; the least time counts, as the least disturbed one.
const ROUNDS: usize = 15;
/// The radius of gyration of the section (m) with which bending is put back.
const SOME_BENDING: f64 = 0.01;
/// A scale with which the controller sees numbers that are too small to act on.
const LEAST_SCALE: f64 = 1e-150;

/// A term of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Its name.
    pub name: &'static str,
    /// True if every step computes it.
    pub kept: bool,
    /// The reason.
    pub why: String,
    /// Its cost, or the saving without it, in microseconds per step; `None` if not measured.
    pub time: Option<f64>,
}

/// The plan of a case's rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The terms in the order of a step; terms of gradients come last.
    pub terms: Vec<Term>,
    /// Microseconds per step; `None` if not measured.
    pub step: Option<f64>,
    /// The void edges of a layout; `None` for a mixture.
    pub voids: Option<Voids>,
}

impl Plan {
    /// The plan of a case's rollout.
    pub fn of(case: &Case) -> Self {
        let (facts, voids) = (Facts::new(case), Voids::of(case));
        let rows = facts.rows(voids.as_ref());
        Self {
            terms: rows.into_iter().map(|row| row.term).collect(),
            step: None,
            voids,
        }
    }

    /// The plan with the times of all terms that can be put in or left out. The gradients are of `loss`.
    pub fn measured(case: &Case, loss: &LossSettings) -> Self {
        let (facts, voids) = (Facts::new(case), Voids::of(case));
        let rows = facts.rows(voids.as_ref());
        let others = rows.iter().filter_map(|row| row.other.as_deref());
        let as_planned: &Change = &|_| ();
        let changes = once(as_planned).chain(others);
        let variants: Vec<Variant> = changes.map(|change| facts.variant(change)).collect();
        let span = Span::from_start(vec![STEPS]);
        let times = least_times(ROUNDS, &variants, |(simulator, body)| {
            simulator.rollout(body, &case.controller, &case.start, &span)
        });
        let mut times = times.into_iter().map(|time| time * 1e6 / STEPS as f64);
        let as_planned = times.next().unwrap_or(f64::NAN);
        let timed = |PlannedTerm { mut term, other }| {
            let added = other.and_then(|_| Some(times.next()? - as_planned));
            term.time = added.map(|added| if term.kept { -added } else { added }.max(0.0));
            term
        };
        let mut plan = Self {
            terms: rows.into_iter().map(timed).collect(),
            step: Some(as_planned),
            voids: None,
        };
        plan.split_network();
        plan.add_gradients(case, loss);
        let single = plan.term(VOID_EDGES).time.unwrap_or(0.0);
        plan.voids = voids.map(|voids| {
            let of_eight = saving_of_eight(case, &variants[0].0, [STEPS, ROUNDS]);
            let saving = Some([single, of_eight]);
            Voids { saving, ..voids }
        });
        plan
    }

    /// Without outputs there is no network at all: that saved both layers.
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

    /// Adds the costs of the gradients that an update does not ask for.
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
const VOID_EDGES: &str = "void edges";
const BY_WEIGHTS: &str = "gradient by weights";
const BY_DESIGN: &str = "gradient by the design";

/// A rollout with a term put in or left out.
type Variant = (Simulator, Body<f64>);

/// The settings and the body of a rollout.
struct Parts {
    physics: PhysicsSettings,
    sight: ControllerSettings,
    body: Body<f64>,
}

/// A change of the planned rollout.
type Change<'f> = dyn Fn(&mut Parts) + 'f;

/// A term, and the change that has the rollout compute it if the planned one does not, or the other way
/// round.
struct PlannedTerm<'f> {
    term: Term,
    other: Option<Box<Change<'f>>>,
}

fn row<'f>(name: &'static str, kept: bool, why: impl Into<String>) -> PlannedTerm<'f> {
    let term = Term {
        name,
        kept,
        why: why.into(),
        time: None,
    };
    PlannedTerm { term, other: None }
}

impl<'f> PlannedTerm<'f> {
    /// Adds the change, if the condition holds.
    fn or(mut self, holds: bool, other: impl Fn(&mut Parts) + 'f) -> Self {
        if holds {
            self.other = Some(Box::new(other));
        }
        self
    }
}

/// The facts about a rollout on which the terms depend.
struct Facts<'a> {
    case: &'a Case,
    body: Body<f64>,
    /// Edges that strain, and edges in all.
    outputs: [usize; 2],
}

impl<'a> Facts<'a> {
    fn new(case: &'a Case) -> Self {
        let body = case.body();
        // An edge without stiffness pulls on nothing, strained or not.
        let edges = body.strain.iter().zip(&body.stiffness);
        let strains = edges.filter(|(strain, stiffness)| **strain != 0.0 && **stiffness != 0.0);
        Self {
            outputs: [strains.count(), body.strain.len()],
            case,
            body,
        }
    }

    /// The rollout of [`STEPS`] steps with a change.
    fn variant(&self, change: &Change) -> Variant {
        let case = self.case;
        let mut parts = Parts {
            physics: case.physics.clone(),
            sight: case.observation.clone(),
            body: self.body.clone(),
        };
        parts.physics.steps = STEPS;
        change(&mut parts);
        let simulator = Simulator::new(&case.lattice, &parts.physics, &parts.sight);
        (simulator, parts.body)
    }

    fn rows<'f>(&'f self, voids: Option<&'f Voids>) -> Vec<PlannedTerm<'f>> {
        let physics = &self.case.physics;
        let (cubic, radius) = (physics.stiffening, physics.bending_radius);
        let by_weights =
            "not in updates of the design, which ask for the gradient by the design alone";
        let by_design = match self.case.frozen {
            Some(_) => "the layout is frozen",
            None => "not in updates of the controller",
        };
        let other = |number: f64, on: f64| if number > 0.0 { 0.0 } else { on };
        let (stiffer, bent) = (other(cubic, 1.0), other(radius, SOME_BENDING));
        let stiffening = format!("physics.stiffening is {cubic}");
        let bending = format!("physics.bending_radius is {radius} m");
        let mut rows = self.controller_rows();
        rows.extend([
            row("springs", true, self.springs()),
            self.void_edges(voids),
            row("stiffening springs", cubic > 0.0, stiffening)
                .or(true, move |parts| parts.physics.stiffening = stiffer),
            row("bending of bars", radius > 0.0, bending)
                .or(true, move |parts| parts.physics.bending_radius = bent),
        ]);
        rows.extend(physics.forces.about().into_iter().map(|(name, about)| {
            row(name, true, about).or(true, move |parts| {
                parts.physics.forces = parts.physics.forces.without(name);
            })
        }));
        rows.extend(self.ground_rows());
        rows.push(row(BY_WEIGHTS, false, by_weights));
        rows.push(row(BY_DESIGN, false, by_design));
        rows
    }

    fn controller_rows(&self) -> Vec<PlannedTerm<'_>> {
        let ([some, all], hidden) = (self.outputs, self.case.controller.hidden);
        let strains = some > 0;
        let folded = "mean, scales, goal, clocks of one frequency and rotation are folded into the \
                      weights once";
        let sight = |sees: bool, scale: &str| match (sees, strains) {
            (false, _) => format!("controller.{scale} is 0"),
            (true, false) => "there is no controller: no edge strains".to_owned(),
            (true, true) => "the controller sees them".to_owned(),
        };
        let Senses { x, v } = self.case.observation.senses();
        let (why_x, why_v) = (sight(x, "offset_scale"), sight(v, "velocity_scale"));
        let why_idle = match all - some {
            0 => "there are none: every edge strains a little".to_owned(),
            idle => format!("{idle} edges do not strain, or have no stiffness"),
        };
        let units = format!("{hidden} units, of what the controller sees");
        vec![
            row("making of observations", false, folded),
            row(HIDDEN, strains, units).or(strains, |parts| parts.body.strain.fill(0.0)),
            row("sight of positions", x && strains, why_x).or(strains && !x, |parts| {
                parts.sight.offset_scale = LEAST_SCALE
            }),
            row("sight of velocities", v && strains, why_v).or(strains && !v, |parts| {
                parts.sight.velocity_scale = LEAST_SCALE
            }),
            row(OUTPUT, strains, format!("{some} edges strain"))
                .or(strains, |parts| keep_first(&mut parts.body.strain)),
            row("idle outputs", some == all, why_idle).or(strains && some < all, |parts| {
                keep_all(&mut parts.body.strain)
            }),
        ]
    }

    fn springs(&self) -> String {
        let edges = self.body.stiffness.iter().filter(|k| **k != 0.0).count();
        match self.case.physics.substeps {
            1 => format!("{edges} edges, in whole lanes"),
            substeps => format!("{edges} edges, {substeps} times a step"),
        }
    }

    fn void_edges<'f>(&'f self, voids: Option<&'f Voids>) -> PlannedTerm<'f> {
        let Some(voids) = voids else {
            return row(VOID_EDGES, true, "no edge of a mixture is void");
        };
        let (edges, [all, without]) = (voids.edges, voids.registers);
        let why = match (self.case.physics.void_edges, voids.dropped) {
            (VoidEdges::Drop, _) => "physics.void_edges is \"drop\"",
            (VoidEdges::Keep, true) => "void has no stiffness",
            (VoidEdges::Keep, false) => "physics.void_edges is \"keep\"",
        };
        let (of, registers) = (self.case.lattice.edges.len(), all - without);
        let mut why = format!(
            "{edges} of {of}: {why}; {registers} of {all} registers of edges hold no other edge"
        );
        if voids.dropped {
            why += " and are skipped";
        }
        row(VOID_EDGES, !voids.dropped, why)
            .or(true, |parts| parts.body = voids.other_body(self.case))
    }

    fn ground_rows(&self) -> [PlannedTerm<'_>; 4] {
        let physics = &self.case.physics;
        let rotation = if Ground::from(physics).is_flat() {
            "the ground is flat"
        } else {
            "all is computed in the ground's frame; gravity and weights are turned once"
        };
        let nodes = format!("{} nodes", self.case.lattice.nodes());
        let corners = physics.ground.resolved().points().len();
        let (profile, other) = match corners {
            0 => ("the ground is a line".to_owned(), ProfileKind::Steps),
            _ => (format!("{corners} corners"), ProfileKind::Flat),
        };
        let (is_there, law) = (physics.contact.has_ground(), &physics.contact);
        let is_coulomb = law.name() == "coulomb";
        let coulomb = format!("coefficient {}", physics.friction);
        let why_contact = if is_there { &nodes } else { law.about() };
        let why_friction = if is_coulomb { &coulomb } else { law.about() };
        let sticking_or = |sticks: bool, other: fn() -> ContactLaw| {
            if sticks {
                ContactLaw::infinite()
            } else {
                other()
            }
        };
        [
            row("contact with the ground", is_there, why_contact).or(true, move |parts| {
                parts.physics.contact = sticking_or(!is_there, ContactLaw::none);
            }),
            row("Coulomb friction", is_coulomb, why_friction).or(true, move |parts| {
                parts.physics.contact = sticking_or(is_coulomb, ContactLaw::coulomb);
            }),
            row("rotation of an incline", false, rotation),
            row("profile of the ground", is_there && corners > 0, profile)
                .or(is_there, move |parts| parts.physics.ground.profile = other),
        ]
    }
}

/// Keeps the first edge that strains, and no other.
fn keep_first(strains: &mut [f64]) {
    let first = strains.iter().position(|strain| *strain != 0.0);
    for (edge, strain) in strains.iter_mut().enumerate() {
        if Some(edge) != first {
            *strain = 0.0;
        }
    }
}
