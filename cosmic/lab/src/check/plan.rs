//! The plan of a rollout: which terms every step computes, which terms it leaves out, and the stable time step.
//!
//! The plan follows from the scene and the robot before the first step, so that a step need not test flags.

use super::probe::step_limits;
use crate::report::sheet::Section;
use crate::table::Table;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::geometry::Ground;
use cosmic::judge::verdict::{Item, Level};
use cosmic::lattice::Body;
use cosmic::numbers::rounded;
use cosmic::policy::Network;
use cosmic::scene::{AnyDesign, ClockKind, Named, Senses, VoidEdges};
use cosmic::world::rounded_down;

/// A term of a rollout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Term {
    /// The name of the term.
    pub name: &'static str,
    /// True if every step computes the term.
    pub kept: bool,
    /// The reason why the term is computed or left out.
    pub why: String,
}

fn term(name: &'static str, kept: bool, why: impl Into<String>) -> Term {
    Term {
        name,
        kept,
        why: why.into(),
    }
}

/// Shows what a step of a case computes and leaves out, and its stable time step. Checks that the time step of the case is
/// stable at the start.
pub fn plan(case: &Case) -> Section {
    let terms = terms(case);
    let word = |term: &Term| if term.kept { "yes" } else { "no" };
    let table = Table::of("plan", "Terms of a step", &terms)
        .column("term", "a term of a step", |term| term.name)
        .column("computed", "whether every step computes the term", word)
        .column("why", "the reason", |term| term.why.clone())
        .done();
    let (is_stable, answer) = time_step(case);
    let mut section = Section {
        title: "Plan".to_owned(),
        text: text(&terms),
        answers: vec![answer],
        tables: vec![table],
        ..Section::default()
    };
    section.check(is_stable, "the time step is above the largest stable one");
    section
}

fn text(terms: &[Term]) -> String {
    let rows = |kept: bool| -> String {
        let terms = terms.iter().filter(|term| term.kept == kept);
        terms
            .map(|Term { name, why, .. }| format!("  {name:<26} {why}\n"))
            .collect()
    };
    format!(
        "computed in every step\n{}left out\n{}",
        rows(true),
        rows(false)
    )
}

/// Compares the time step of a case with the largest stable ones. True if it is stable.
fn time_step(case: &Case) -> (bool, Item) {
    let [exact, bound] = step_limits(case, &case.start.x).map(|limit| limit.step());
    let any =
        AnyDesign::new(&case.lattice, &case.scene.materials, &case.scene.physics).stable_step(1.0);
    let [limit, bound, any] = [exact, bound, any].map(|limit| rounded_down(limit, 3));
    let dt = case.scene.physics.dt;
    // If the limit is NaN, the comparison is false, so no time step counts as stable.
    let is_stable = dt < exact;
    let level = if is_stable { Level::Good } else { Level::Bad };
    let says = format!(
        "The time step of {} s is {:.0} % of the stable one, {limit} s ({bound} s by the safe bound, {any} s for any \
         design)",
        rounded(dt, 5),
        100.0 * dt / exact
    );
    (is_stable, Item::limit(says, level))
}

/// The terms of a case's rollout in the order of a step.
pub fn terms(case: &Case) -> Vec<Term> {
    let body = case.body();
    let mut terms = controller_terms(case, &body);
    let edges = body.stiffness.iter().filter(|k| **k != 0.0).count();
    let springs = match case.scene.physics.substeps {
        1 => format!("{edges} edges, in SIMD lanes"),
        substeps => format!("{edges} edges, {substeps} times in each step"),
    };
    terms.extend([term("springs", true, springs), void_edges(case)]);
    let forces = case.scene.physics.forces.about().into_iter();
    terms.extend(forces.map(|(name, about)| term(name, true, about)));
    terms.extend(ground_terms(case));
    terms
}

fn controller_terms(case: &Case, body: &Body<f64>) -> Vec<Term> {
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
    let Senses { x, v } = case.scene.controller.senses();
    let (why_x, why_v) = (sight(x, "offset_scale"), sight(v, "velocity_scale"));
    let why_idle = match all - some {
        0 => "every edge has a stroke".to_owned(),
        idle => format!("{idle} edges have no stroke or no stiffness"),
    };
    let is_learned = case.scene.controller.clock == ClockKind::Learned;
    let why_turned = match is_learned {
        true => "the frequency of the clock is learned",
        false => "the frequency of the clock is fixed",
    };
    let (before_outputs, why_before) = before_outputs(case);
    let output = format!("{some} edges have a stroke");
    vec![
        term("making of observations", false, folded),
        term(before_outputs, strains, why_before),
        term("presence of nodes", weighed, why_weighed),
        term("sight of positions", x && strains, why_x),
        term("sight of velocities", v && strains, why_v),
        term("output layer", strains, output),
        term("idle outputs", some == all, why_idle),
        term("turn of the clock", strains && is_learned, why_turned),
    ]
}

/// The name and a description of the part of a policy that comes before its output layer.
fn before_outputs(case: &Case) -> (&'static str, String) {
    match Network::of(&case.controller, &case.scene.controller, &case.lattice) {
        Some(network) => {
            let units = network.first.biases.len();
            (
                "hidden layer",
                format!("{units} units that read the observation"),
            )
        }
        None => {
            let (name, count) = (
                case.scene.controller.policy.name(),
                case.controller.weights(),
            );
            (
                "policy without its outputs",
                format!("`{name}` has {count} parameters"),
            )
        }
    }
}

/// Says what happens to void edges. Steps leave out void edges if the design is a layout and either the scene drops its
/// void edges or void has no stiffness.
fn void_edges(case: &Case) -> Term {
    let Some(materials) = case.design.layout() else {
        return term("void edges", true, "no edge of a mixture is void");
    };
    let no_stiffness = Material::Void.of(&case.scene.materials.stiffness) == 0.0;
    let (kept, why) = match case.scene.physics.void_edges {
        VoidEdges::Drop => (false, "physics.void_edges is \"drop\""),
        VoidEdges::Keep if no_stiffness => (false, "void has no stiffness"),
        VoidEdges::Keep => (true, "physics.void_edges is \"keep\""),
    };
    let void = materials.iter().filter(|m| **m == Material::Void).count();
    term(
        "void edges",
        kept,
        format!("{void} of {}: {why}", materials.len()),
    )
}

fn ground_terms(case: &Case) -> [Term; 4] {
    let physics = &case.scene.physics;
    let rotation = match Ground::from(physics).is_flat() {
        true => "the ground is flat".to_owned(),
        false => format!(
            "a rollout is computed in the frame of the ground, which is inclined by {} degrees",
            physics.incline_deg
        ),
    };
    let corners = physics.ground.resolved().points().len();
    let profile = match corners {
        0 => "the ground is a line".to_owned(),
        _ => format!("{corners} corners ({})", physics.ground.profile.name()),
    };
    let law = &physics.contact;
    let (is_there, is_coulomb) = (law.has_ground(), law.name() == "coulomb");
    let nodes = format!("{} nodes", case.lattice.nodes());
    let coulomb = format!("coefficient {}", physics.friction);
    let why = |holds: bool, why: String| if holds { why } else { law.about().to_owned() };
    [
        term("contact with the ground", is_there, why(is_there, nodes)),
        term("Coulomb friction", is_coulomb, why(is_coulomb, coulomb)),
        term("rotation of an incline", false, rotation),
        term("profile of the ground", is_there && corners > 0, profile),
    ]
}
