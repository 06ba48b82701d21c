//! `cosmic explain`.

use crate::output::{print, print_json};
use crate::source::{Source, SourceArguments};
use clap::Args;
use cosmic::case::Case;
use cosmic::error::Result;
use cosmic::scene::{Integrator, Named, PhysicsSettings, Scene};
use cosmic::simulator::rounded_down;
use cosmic::simulator::stability::{Vibration, bound_of_any_design, stable_step};
use cosmic_lab::verify::{Plan, Pull, Speed, Term, Times, Voids, measure, peak_memory};
use serde::Serialize;
use serde_json::{Value, json};

/// Show the terms of a rollout, its stable time step and the cost of a step
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: SourceArguments,
    /// Measure microseconds per step over 4096 steps, or as many as the rollout has: processor time
    /// of this thread, the least of several repeats
    #[arg(long)]
    measure: bool,
    /// Write JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let Source { case, scene } = self.robot.read()?;
        let stable = StableStep::of(&case);
        // A reference case has no loss and no horizons; the ones of the paper's scene are used instead.
        let scene = scene.unwrap_or_else(Scene::paper);
        let speed = self.measure.then(|| measure(&case, &scene));
        let plan = if self.measure {
            Plan::measured(&case, &scene.loss)
        } else {
            Plan::of(&case)
        };
        let source = &self.robot.source;
        if !self.json {
            let speed = speed.map_or(String::new(), |speed| speed_text(&speed));
            let voids = plan.voids.as_ref().map_or(String::new(), voids_text);
            let (rollout, plan) = (rollout_text(&case, &stable), plan_text(&plan));
            return print(&format!("{source}\n{rollout}{plan}{voids}{speed}"));
        }
        let rollout = rollout_json(&case, &stable);
        let mut value = json!({ "source": source, "rollout": rollout, "plan": plan_json(&plan) });
        if let Some(voids) = &plan.voids {
            value["void_edges"] = voids_json(voids);
        }
        if let Some(speed) = speed {
            value["measured"] = speed_json(&speed);
        }
        print_json(&value)
    }
}

/// Time steps, s, below which the starting design at rest does not ring.
#[derive(Serialize)]
struct StableStep {
    /// From the largest frequency itself.
    exact: f64,
    /// From a bound on it that is cheap and safe.
    bound: f64,
    /// From a bound on the frequencies of every design of the lattice.
    any_design: f64,
    /// Largest angular frequency, 1/s.
    largest_frequency: f64,
}

impl StableStep {
    fn of(case: &Case) -> Self {
        let (lattice, physics) = (&case.lattice, &case.physics);
        let body = case.body();
        let vibration = Vibration::new(lattice, &body, physics, &case.start.x);
        let largest_frequency = vibration.largest_frequency();
        let stable = |frequency| stable_step(physics, frequency, vibration.damping());
        let of_any_design = bound_of_any_design(lattice, &case.materials, physics);
        Self {
            exact: stable(largest_frequency),
            bound: stable(vibration.edge_bound()),
            any_design: stable(of_any_design),
            largest_frequency,
        }
    }

    fn text(&self, dt: f64) -> String {
        let [exact, bound, any_design] =
            [self.exact, self.bound, self.any_design].map(|dt| rounded_down(dt, 4));
        format!(
            "below {exact} s ({bound} s by the safe bound, {any_design} s whatever the design), \
             largest frequency {:.2} 1/s; this step is {:.0} % of it",
            self.largest_frequency,
            100.0 * dt / self.exact
        )
    }
}

/// The facts about a rollout. `friction` is null unless it is Coulomb's; `controller` has the counts of
/// observed numbers, hidden units and activations; `layout` is true if every edge has exactly one material.
fn rollout_json(case: &Case, stable: &StableStep) -> Value {
    let (lattice, physics, controller) = (&case.lattice, &case.physics, &case.controller);
    let is_coulomb = physics.contact.name() == "coulomb";
    json!({
        "lattice": case.layout.name(),
        "columns": case.layout.columns,
        "rows": case.layout.rows,
        "nodes": lattice.nodes(),
        "edges": lattice.edges.len(),
        "steps": physics.steps,
        "dt": physics.dt,
        "integrator": physics.integrator,
        "substeps": physics.substeps,
        "contact": physics.contact,
        "forces": physics.forces,
        "friction": is_coulomb.then_some(physics.friction),
        "stiffening": physics.stiffening,
        "bending_radius": physics.bending_radius,
        "incline_deg": physics.incline_deg,
        "gravity": physics.gravity,
        "damping": physics.damping,
        "controller": [controller.inputs, controller.hidden, controller.edges()],
        "layout": case.frozen.is_some(),
        "stable_dt": stable,
    })
}

fn rollout_text(case: &Case, stable: &StableStep) -> String {
    let (lattice, physics, controller) = (&case.lattice, &case.physics, &case.controller);
    let (name, nodes) = (case.layout.name(), lattice.nodes());
    let design = match case.frozen {
        Some(_) => "a layout, one material per edge",
        None => "a mixture of materials per edge",
    };
    let (inputs, hidden, outputs) = (controller.inputs, controller.hidden, controller.edges());
    let (steps, dt) = (physics.steps, physics.dt);
    format!(
        "  lattice      {name}, {nodes} nodes, {} edges
  design       {design}
  controller   {inputs} observed numbers, {hidden} hidden units, {outputs} activations
  world        gravity {} m/s2, damping {} 1/s
  springs      {}
  ground       {}
  contact      {}
  steps        {steps} of {dt} s, {} s in all
  integrator   {}
  stable step  {}
",
        lattice.edges.len(),
        physics.gravity,
        physics.damping,
        springs_text(physics),
        ground_text(physics),
        contact_text(physics),
        steps as f64 * dt,
        integrator_text(physics),
        stable.text(dt),
    )
}

fn springs_text(physics: &PhysicsSettings) -> String {
    let law = match physics.stiffening {
        0.0 => "Hooke's law".to_owned(),
        cubic => {
            format!("k (e + {cubic} e^3); the stable step has them off by their actuators' strokes")
        }
    };
    let bending = match physics.bending_radius {
        0.0 => "bars bend freely at nodes".to_owned(),
        radius => format!("bars in line resist bending, radius of gyration {radius} m"),
    };
    let others = physics.forces.about();
    let others = others
        .iter()
        .map(|(name, about)| format!("{name}: {}", within_a_sentence(about)));
    [law, bending]
        .into_iter()
        .chain(others)
        .collect::<Vec<_>>()
        .join("; ")
}

fn ground_text(physics: &PhysicsSettings) -> String {
    let line = match physics.incline_deg {
        0.0 => "flat".to_owned(),
        angle => format!("inclined by {angle} degrees; all is computed in its frame"),
    };
    let ground = &physics.ground;
    match ground.resolved().points() {
        [] => line,
        corners => {
            let (kind, count) = (ground.profile.name(), corners.len());
            format!("{line}, with a profile of {count} corners ({kind})")
        }
    }
}

fn contact_text(physics: &PhysicsSettings) -> String {
    let law = within_a_sentence(physics.contact.about());
    match physics.contact.name() {
        "coulomb" => format!("{law}, coefficient {}", physics.friction),
        _ => law,
    }
}

/// A sentence as part of another.
fn within_a_sentence(sentence: &str) -> String {
    let mut rest = sentence.trim_end_matches('.').chars();
    let first = rest.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + rest.as_str()
}

fn integrator_text(physics: &PhysicsSettings) -> String {
    let name = match physics.integrator {
        Integrator::SymplecticEuler => "symplectic Euler",
        Integrator::Leapfrog => "leapfrog",
    };
    match physics.substeps {
        1 => name.to_owned(),
        substeps => format!("{name}, {substeps} substeps"),
    }
}

/// The terms: first those that a step computes, then those that it leaves out.
fn plan_text(plan: &Plan) -> String {
    let row = |term: &Term| {
        let time = match (term.time, plan.step) {
            (Some(time), Some(step)) if term.kept => {
                format!("{time:.3} us, {:.0} %", 100.0 * time / step)
            }
            (Some(time), _) => format!("saves {time:.3} us"),
            _ => String::new(),
        };
        format!("    {:<24} {:<16} {}\n", term.name, time, term.why)
    };
    let rows = |kept: bool| -> String {
        let terms = plan.terms.iter().filter(|term| term.kept == kept);
        terms.map(row).collect()
    };
    let measured = plan.step.map_or(String::new(), |step| {
        format!(" ({step:.3} us; what a term costs is what its leaving out saves)")
    });
    format!(
        "  computed in every step{measured}\n{}  left out of it\n{}",
        rows(true),
        rows(false)
    )
}

/// Times are microseconds a step: the costs of the terms that are kept, and the savings by leaving out the
/// others. They are null if not measured, or if the rollout cannot be run the other way.
fn plan_json(plan: &Plan) -> Value {
    let term = |term: &Term| {
        let cost = term.time.filter(|_| term.kept);
        let saving = term.time.filter(|_| !term.kept);
        json!({
            "term": term.name,
            "kept": term.kept,
            "why": term.why,
            "cost": cost,
            "share": cost.zip(plan.step).map(|(cost, step)| cost / step),
            "saving": saving,
        })
    };
    plan.terms.iter().map(term).collect()
}

/// The pull of a layout's void edges, and the time saved without them.
fn voids_text(voids: &Voids) -> String {
    let pull = |of: &str, pull: Option<Pull>| {
        pull.map_or(String::new(), |pull| {
            format!(
                "    {of:<24} by {:.1e} m/s2, and in the whole rollout by {:.1e} m\n",
                pull.acceleration, pull.displacement
            )
        })
    };
    let saving = voids.saving.map_or(String::new(), |[single, eight]| {
        let says = if voids.dropped { "saves" } else { "would save" };
        format!(
            "    leaving them out {says} {single:.3} us a step, and {eight:.3} us in each of eight \
             starts that run together\n"
        )
    });
    format!(
        "  void edges pull a node with {:.1e} N at most for every metre that they are stretched, \
         which moves\n{}{}    for as long as the motion does not multiply small changes: cosmic \
         verify --accuracy\n{saving}",
        voids.force,
        pull("nodes of the body", voids.body),
        pull("detached nodes", voids.detached),
    )
}

/// Bounds are for every metre that void edges are stretched; times are microseconds a step, null
/// where they were not measured.
fn voids_json(voids: &Voids) -> Value {
    json!({
        "edges": voids.edges,
        "dropped": voids.dropped,
        "registers": voids.registers[0],
        "registers_without": voids.registers[1],
        "force": voids.force,
        "body": voids.body,
        "detached": voids.detached,
        "saving": voids.saving.map(|[single, _]| single),
        "saving_of_eight": voids.saving.map(|[_, eight]| eight),
    })
}

/// The sets of times, each with its name in texts and the prefix of its keys.
fn sets(speed: &Speed) -> [(&'static str, &'static str, Times); 5] {
    [
        ("", "", speed.double),
        ("f32, ", "f32_", speed.single),
        ("one-hot, ", "one_hot_", speed.one_hot_double),
        ("one-hot f32, ", "one_hot_f32_", speed.one_hot_single),
        ("one of eight, ", "eight_starts_", speed.eight_starts),
    ]
}

/// The times of a set by their keys.
fn figures(times: &Times) -> [(&'static str, f64); 3] {
    [
        ("rollout", times.rollout),
        ("value_and_design_gradient", times.value_and_design_gradient),
        (
            "value_and_controller_gradient",
            times.value_and_controller_gradient,
        ),
    ]
}

fn speed_text(speed: &Speed) -> String {
    let row = |name: &str, time: f64| {
        let ratio = time / speed.double.rollout;
        format!("  {name:<43} {time:>8.3} us a step, {ratio:>5.2} rollouts\n")
    };
    let rows = sets(speed).map(|(name, _, times)| {
        figures(&times)
            .map(|(what, time)| row(&format!("{name}{}", what.replace('_', " ")), time))
            .concat()
    });
    let own = ["one-hot", "one-hot f32"]
        .into_iter()
        .zip(speed.own_materials);
    let own = own.map(|(name, time)| row(&format!("{name}, by its own materials"), time));
    let own: Vec<String> = own.collect();
    let errors = speed.single_errors.map(|error| {
        let (steps, design, controller) = (error.steps, error.design, error.controller);
        if !(design.is_finite() && controller.is_finite()) {
            return format!("  f32 gradients over {steps} steps: not all are finite\n");
        }
        format!(
            "  f32 gradients over {steps} steps are off by {design:.1e} (design) and \
             {controller:.1e} (controller) of their length\n"
        )
    });
    let memory = peak_memory().map_or("unknown".to_owned(), |bytes| {
        format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
    });
    [
        format!("measured over {} steps\n", speed.steps),
        rows.concat(),
        own.concat(),
        row("one of two designs, value and gradient", speed.two_designs),
        row("two bare matrix products", speed.two_matvecs),
        errors.concat(),
        format!("  peak memory of the process {memory}\n"),
    ]
    .concat()
}

fn speed_json(speed: &Speed) -> Value {
    let double = speed.double;
    let rollout = double.rollout;
    let mut value = json!({
        "steps": speed.steps,
        "two_matvecs": speed.two_matvecs,
        "one_hot_own_materials": speed.own_materials[0],
        "one_hot_f32_own_materials": speed.own_materials[1],
        "one_of_two_designs": speed.two_designs,
        "design_ratio": double.value_and_design_gradient / rollout,
        "controller_ratio": double.value_and_controller_gradient / rollout,
        "eight_starts_ratio": speed.eight_starts.rollout / rollout,
        "rollout_per_two_matvecs": rollout / speed.two_matvecs,
        "peak_memory_bytes": peak_memory().map_or(json!("unknown"), |bytes| json!(bytes)),
        "f32_gradient_errors": speed.single_errors,
    });
    for (_, prefix, times) in sets(speed) {
        for (key, time) in figures(&times) {
            value[format!("{prefix}{key}")] = json!(time);
        }
    }
    value
}
