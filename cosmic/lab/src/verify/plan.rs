//! The plan of a rollout: which terms every step computes, and which terms it leaves out. Also the times that these
//! terms cost or save.
//!
//! The plan follows from the scene and the robot before the first step, so that a step need not test flags. The cost of
//! a term is measured by leaving it out of rollouts. The saving of an omitted term is measured by putting it back.

use super::clock::least_times;
use super::speed::Subject;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::Ground;
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::lattice::Body;
use cosmic::laws::ContactLaw;
use cosmic::policy::Network;
use cosmic::scene::{
    ClockKind, ControllerSettings, LossSettings, Named, PhysicsSettings, ProfileKind, Senses,
    VoidEdges,
};
use cosmic::simulator::{Simulator, Span};
use serde::Serialize;
use std::iter::once;

/// The number of steps of a measured rollout.
const STEPS: usize = 1024;
/// The number of rounds of measurements. Of the times of a rollout, the shortest counts, because it is the least
/// disturbed one.
const ROUNDS: usize = 15;
/// A tiny number that replaces a stiffness, a strain or a scale of zero. Steps then compute the term, but the result
/// does not change.
const LEAST: f64 = 1e-150;

/// A term of a rollout. Times are in microseconds per step; a time is `None` if it was not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// The name of the term.
    #[serde(rename = "term")]
    pub name: &'static str,
    /// True if every step computes the term.
    pub kept: bool,
    /// The reason why the term is computed or omitted.
    pub why: String,
    /// The time that steps would save without this term. Only for terms that steps compute.
    pub cost: Option<f64>,
    /// The share of this term in the time of a whole step.
    pub share: Option<f64>,
    /// The time that steps save because they omit this term. Only for terms that steps omit.
    pub saving: Option<f64>,
}

/// The plan of a case's rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The terms in the order of a step; terms of gradients come last.
    pub terms: Vec<Term>,
    /// The time of a whole step in microseconds; `None` if it was not measured.
    pub step: Option<f64>,
}

const HIDDEN: &str = "hidden layer";
const POLICY: &str = "policy without its outputs";
const OUTPUT: &str = "output layer";
const BY_WEIGHTS: &str = "gradient by weights";
const BY_DESIGN: &str = "gradient by the design";

impl Plan {
    /// Makes the plan of a case's rollout, without times.
    pub fn of(case: &Case) -> Self {
        let rows = rows(case, &case.body());
        Self {
            terms: rows.into_iter().map(|row| row.term).collect(),
            step: None,
        }
    }

    /// Makes the plan and measures the times of all terms that can be left out or put in. The gradients of the loss
    /// `loss` are measured too.
    pub fn measured(case: &Case, loss: &LossSettings) -> Self {
        let body = case.body();
        let rows = rows(case, &body);
        let as_planned: &Change = &|_| ();
        let changes = once(as_planned).chain(rows.iter().filter_map(|row| row.other.as_deref()));
        let variants: Vec<_> = changes.map(|change| variant(case, &body, change)).collect();
        let span = Span::from_start(vec![STEPS]);
        let times = least_times(ROUNDS, &variants, |(simulator, body)| {
            simulator.rollout(body, &case.controller, &case.start, &span)
        });
        let mut times = times.into_iter().map(|time| time * 1e6 / STEPS as f64);
        let step = times.next().unwrap_or(f64::NAN);
        let timed = |row: Row| {
            let mut term = row.term;
            let other = row.other.and_then(|_| times.next());
            match term.kept {
                true => term.cost = other.map(|other| (step - other).max(0.0)),
                false => term.saving = other.map(|other| (other - step).max(0.0)),
            }
            term
        };
        let terms = rows.into_iter().map(timed).collect();
        let mut plan = Self {
            terms,
            step: Some(step),
        };
        // Without outputs, a rollout also leaves out the rest of the policy. So the time saved includes that of the
        // output layer, which is subtracted here.
        let output = plan.term(OUTPUT).cost;
        let (name, _) = before_outputs(case);
        let hidden = &mut plan.term(name).cost;
        let both = hidden.zip(output);
        *hidden = both.map(|(both, output)| (both - output).max(0.0));
        plan.add_gradients(case, loss);
        for term in &mut plan.terms {
            term.share = term.cost.map(|cost| cost / step);
        }
        plan
    }

    /// A term by its name.
    fn term(&mut self, name: &str) -> &mut Term {
        let term = self.terms.iter_mut().find(|term| term.name == name);
        term.expect("the plan contains every term")
    }

    /// Adds two savings: an update of the design or of the controller computes only one of the two gradients.
    fn add_gradients(&mut self, case: &Case, loss: &LossSettings) {
        let subject = Subject::new(case, loss);
        let both = [DESIGN, CONTROLLER].concat();
        let blocks = [DESIGN, CONTROLLER, &both];
        let times = least_times(ROUNDS, &blocks, |blocks| subject.gradient::<f64>(blocks));
        for (name, other) in [(BY_WEIGHTS, times[0]), (BY_DESIGN, times[1])] {
            let added = (times[2] - other).max(0.0);
            self.term(name).saving = Some(added * 1e6 / subject.steps() as f64);
        }
    }
}

/// The parts of a rollout that the measurement of a term may change: settings and body.
struct Parts {
    physics: PhysicsSettings,
    sight: ControllerSettings,
    body: Body<f64>,
}

/// A change of the planned rollout: it adds one term or removes one.
type Change<'f> = dyn Fn(&mut Parts) + 'f;

/// Makes a rollout of [`STEPS`] steps: the planned rollout after a change.
fn variant(case: &Case, body: &Body<f64>, change: &Change) -> (Simulator, Body<f64>) {
    let mut parts = Parts {
        physics: case.physics.clone(),
        sight: case.observation.clone(),
        body: body.clone(),
    };
    parts.physics.steps = STEPS;
    change(&mut parts);
    let simulator = Simulator::new(&case.lattice, &parts.physics, &parts.sight);
    (simulator, parts.body)
}

/// A term, and a change of the rollout that reverses the plan's decision. If the plan computes the term, the change
/// removes the term; otherwise the change adds it.
struct Row<'f> {
    term: Term,
    other: Option<Box<Change<'f>>>,
}

fn row<'f>(name: &'static str, kept: bool, why: impl Into<String>) -> Row<'f> {
    let term = Term {
        name,
        kept,
        why: why.into(),
        cost: None,
        share: None,
        saving: None,
    };
    Row { term, other: None }
}

impl<'f> Row<'f> {
    /// Gives the row the change `other`, if `holds` is true.
    fn or(mut self, holds: bool, other: impl Fn(&mut Parts) + 'f) -> Self {
        if holds {
            self.other = Some(Box::new(other));
        }
        self
    }
}

/// The terms of a case's rollout, as rows.
fn rows<'f>(case: &'f Case, body: &Body<f64>) -> Vec<Row<'f>> {
    let mut rows = controller_rows(case, body);
    rows.extend(force_rows(case, body));
    rows.extend(ground_rows(case));
    let why = "not computed in updates of the design, which only need the gradient with respect to the design";
    rows.push(row(BY_WEIGHTS, false, why));
    let why = match case.design {
        Design::Layout(_) => "the layout does not change",
        Design::Undecided(_) => "not computed in updates of the controller",
    };
    rows.push(row(BY_DESIGN, false, why));
    rows
}

/// The name and a description of the part of a policy that comes before its output layer.
fn before_outputs(case: &Case) -> (&'static str, String) {
    match Network::of(&case.controller, &case.lattice) {
        Some(network) => {
            let units = network.first.biases.len();
            (HIDDEN, format!("{units} units that read the observation"))
        }
        None => {
            let (name, count) = (case.observation.policy.name(), case.controller.weights());
            (POLICY, format!("`{name}` has {count} parameters"))
        }
    }
}

fn controller_rows<'f>(case: &'f Case, body: &Body<f64>) -> Vec<Row<'f>> {
    // If an edge has no stiffness, it does not pull, so its strain has no effect.
    let edges = body.strain.iter().zip(&body.stiffness);
    let straining = edges.filter(|(strain, stiffness)| **strain != 0.0 && **stiffness != 0.0);
    let (some, all) = (straining.count(), body.strain.len());
    let strains = some > 0;
    let weighed = strains && !body.presence.is_empty();
    let (folded, why_weighed) = match weighed {
        true => (
            "scales, goal, clocks and rotation are folded into the weights before the first step",
            "each node is weighted by how solid its edges are",
        ),
        false => (
            "mean, scales, goal, clocks and rotation are folded into the weights before the first step",
            "all nodes have equal weights",
        ),
    };
    let sight = |sees: bool, scale: &str| match (sees, strains) {
        (false, _) => format!("controller.{scale} is 0"),
        (true, false) => "no edge has a stroke, so there is no controller".to_owned(),
        (true, true) => "the controller observes them".to_owned(),
    };
    let Senses { x, v } = case.observation.senses();
    let (why_x, why_v) = (sight(x, "offset_scale"), sight(v, "velocity_scale"));
    let why_idle = match all - some {
        0 => "every edge has a stroke".to_owned(),
        idle => format!("{idle} edges have no stroke or no stiffness"),
    };
    let (before_outputs, why_before) = before_outputs(case);
    let is_learned = case.observation.clock == ClockKind::Learned;
    let why_turned = match is_learned {
        true => "the frequency of the clock is learned",
        false => "the frequency of the clock is fixed",
    };
    vec![
        row("making of observations", false, folded),
        row(before_outputs, strains, why_before).or(strains, |parts| parts.body.strain.fill(0.0)),
        row("presence of nodes", weighed, why_weighed)
            .or(weighed, |parts| parts.body.presence.clear()),
        row("sight of positions", x && strains, why_x)
            .or(strains && !x, |parts| parts.sight.offset_scale = LEAST),
        row("sight of velocities", v && strains, why_v)
            .or(strains && !v, |parts| parts.sight.velocity_scale = LEAST),
        row(OUTPUT, strains, format!("{some} edges have a stroke"))
            .or(strains, |parts| keep_first(&mut parts.body.strain)),
        row("idle outputs", some == all, why_idle).or(strains && some < all, |parts| {
            keep_all(&mut parts.body.strain)
        }),
        row("turn of the clock", strains && is_learned, why_turned),
    ]
}

fn force_rows<'f>(case: &'f Case, body: &Body<f64>) -> Vec<Row<'f>> {
    let physics = &case.physics;
    let edges = body.stiffness.iter().filter(|k| **k != 0.0).count();
    let springs = match physics.substeps {
        1 => format!("{edges} edges, in SIMD lanes"),
        substeps => format!("{edges} edges, {substeps} times in each step"),
    };
    let mut rows = vec![row("springs", true, springs), void_row(case)];
    for (name, about) in physics.forces.about() {
        rows.push(row(name, true, about).or(true, move |parts| {
            parts.physics.forces = parts.physics.forces.without(name);
        }));
    }
    rows
}

/// The row of the table that says what happens to void edges. Steps leave out void edges if the design is a layout and
/// either the scene drops its void edges or void has no stiffness.
fn void_row(case: &Case) -> Row<'_> {
    let Some(materials) = case.design.layout() else {
        return row("void edges", true, "no edge of a mixture is void");
    };
    let no_stiffness = Material::Void.of(&case.materials.stiffness) == 0.0;
    let (kept, why) = match case.physics.void_edges {
        VoidEdges::Drop => (false, "physics.void_edges is \"drop\""),
        VoidEdges::Keep if no_stiffness => (false, "void has no stiffness"),
        VoidEdges::Keep => (true, "physics.void_edges is \"keep\""),
    };
    let void = materials.iter().filter(|m| **m == Material::Void).count();
    let why = format!("{void} of {}: {why}", materials.len());
    row("void edges", kept, why).or(true, move |parts| {
        let physics = PhysicsSettings {
            void_edges: if kept {
                VoidEdges::Drop
            } else {
                VoidEdges::Keep
            },
            ..case.physics.clone()
        };
        let design = case.own_design();
        let body = Body::new(&design, &case.lattice, &case.materials, &physics);
        parts.body.stiffness = body.stiffness;
        if !kept {
            keep_all(&mut parts.body.stiffness);
        }
    })
}

fn ground_rows(case: &Case) -> [Row<'_>; 4] {
    let physics = &case.physics;
    let rotation = match Ground::from(physics).is_flat() {
        true => "the ground is flat".to_owned(),
        false => format!(
            "a rollout is computed in the frame of the ground, which is inclined by {} degrees; gravity \
             and weights are rotated before the first step",
            physics.incline_deg
        ),
    };
    let nodes = format!("{} nodes", case.lattice.nodes());
    let corners = physics.ground.resolved().points().len();
    let (profile, other) = match corners {
        0 => ("the ground is a line".to_owned(), ProfileKind::Steps),
        _ => {
            let kind = physics.ground.profile.name();
            (format!("{corners} corners ({kind})"), ProfileKind::Flat)
        }
    };
    let (is_there, law) = (physics.contact.has_ground(), &physics.contact);
    let is_coulomb = law.name() == "coulomb";
    let coulomb = format!("coefficient {}", physics.friction);
    let why = |holds: bool, why: &str| if holds { why } else { law.about() }.to_owned();
    let (why_contact, why_friction) = (why(is_there, &nodes), why(is_coulomb, &coulomb));
    [
        row("contact with the ground", is_there, why_contact).or(true, move |parts| {
            parts.physics.contact = match is_there {
                true => ContactLaw::none(),
                false => ContactLaw::infinite(),
            }
        }),
        row("Coulomb friction", is_coulomb, why_friction).or(true, move |parts| {
            parts.physics.contact = match is_coulomb {
                true => ContactLaw::infinite(),
                false => ContactLaw::coulomb(),
            }
        }),
        row("rotation of an incline", false, rotation),
        row("profile of the ground", is_there && corners > 0, profile)
            .or(is_there, move |parts| parts.physics.ground.profile = other),
    ]
}

/// Replaces zeros by numbers that are too small to change a result. Steps then include all edges.
fn keep_all(numbers: &mut [f64]) {
    for number in numbers.iter_mut().filter(|number| **number == 0.0) {
        *number = LEAST;
    }
}

/// Keeps the first strain that is not zero, and sets all others to zero.
fn keep_first(strains: &mut [f64]) {
    let first = strains.iter().position(|strain| *strain != 0.0);
    for (edge, strain) in strains.iter_mut().enumerate() {
        if Some(edge) != first {
            *strain = 0.0;
        }
    }
}
