//! `cosmic explain`.

use crate::output::{print, print_json};
use crate::source::{Source, SourceArguments};
use clap::Args;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::error::Result;
use cosmic::policy::{self, Network};
use cosmic::scene::{AnyDesign, Integrator, PhysicsSettings, Scene, stable_step};
use cosmic::simulator::rounded_down;
use cosmic_lab::verify::{Plan, Speed, Term, frequencies, measure, peak_memory, step_off_bars};
use serde::Serialize;
use serde_json::{Value, json};

/// Show which terms a step computes and skips, the stable time step, and with --measure the cost of a step
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: SourceArguments,
    /// Measure the processor time of a step in microseconds: the minimum of several repeats of 4096 steps, or of
    /// all steps if the rollout is shorter
    #[arg(long)]
    measure: bool,
    /// Write JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let Source { case, scene } = self.robot.read(registry)?;
        let stable = StableStep::of(&case);
        // A reference case has no loss and no horizons, so those of the paper's scene are used.
        let scene = scene.unwrap_or_else(Scene::paper);
        let speed = self.measure.then(|| measure(&case, &scene.loss));
        let plan = if self.measure {
            Plan::measured(&case, &scene.loss)
        } else {
            Plan::of(&case)
        };
        let source = &self.robot.source;
        if !self.json {
            let speed = speed.map_or(String::new(), |speed| speed_text(&speed));
            let (rollout, plan) = (rollout_text(&case, &stable), plan_text(&plan));
            return print(&format!("{source}\n{rollout}{plan}{speed}"));
        }
        let rollout = rollout_json(&case, &stable);
        let mut value = json!({ "source": source, "rollout": rollout, "plan": plan.terms });
        if let Some(speed) = speed {
            value["measured"] = speed_json(&speed);
        }
        print_json(&value)
    }
}

/// The largest stable time steps of the starting design at rest, s.
#[derive(Serialize)]
struct StableStep {
    /// The limit for the starting design. It follows from the design's largest frequency.
    exact: f64,
    /// A lower limit for the starting design. It follows from an upper bound on the frequency, which is cheap to
    /// compute.
    bound: f64,
    /// The limit for any design: below it, every design of the lattice is stable.
    any_design: f64,
    /// The largest angular frequency of the starting design, in 1/s.
    largest_frequency: f64,
}

impl StableStep {
    fn of(case: &Case) -> Self {
        let [largest_frequency, bound, damping] = frequencies(case, &case.start.x);
        let any = AnyDesign::new(&case.lattice, &case.materials, &case.physics);
        let off_bars = step_off_bars(case, &case.physics, &case.start.x);
        let stable = |frequency| stable_step(&case.physics, frequency, damping).min(off_bars);
        Self {
            exact: stable(largest_frequency),
            bound: stable(bound),
            any_design: any.stable_step(1.0),
            largest_frequency,
        }
    }

    fn text(&self, dt: f64) -> String {
        let [exact, bound, any_design] =
            [self.exact, self.bound, self.any_design].map(|dt| rounded_down(dt, 4));
        format!(
            "below {exact} s ({bound} s by the safe bound, {any_design} s for any design), \
             largest frequency {:.2} 1/s; dt is {:.0} % of the limit",
            self.largest_frequency,
            100.0 * dt / self.exact
        )
    }
}

/// The sizes of a controller: the number of observed numbers, of hidden units (`None` if it is not a network), and of
/// activations.
fn controller_sizes(case: &Case) -> (usize, Option<usize>, usize) {
    let (settings, lattice) = (&case.observation, &case.lattice);
    let sight = policy::of_settings(settings).observe();
    let inputs = sight.length(settings, lattice.nodes());
    let network = Network::of(&case.controller, &case.lattice);
    let hidden = network.map(|network| network.first.biases.len());
    (inputs, hidden, lattice.edges.len())
}

/// Describes a rollout as JSON. `friction` is null unless the contact law is Coulomb's. `controller` has three sizes:
/// the number of observed numbers, of hidden units (null if it is not a network) and of activations. `layout` is true
/// if every edge has exactly one material.
fn rollout_json(case: &Case, stable: &StableStep) -> Value {
    let (lattice, physics) = (&case.lattice, &case.physics);
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
        "incline_deg": physics.incline_deg,
        "gravity": physics.gravity,
        "damping": physics.damping,
        "controller": controller_sizes(case),
        "layout": case.design.layout().is_some(),
        "stable_dt": stable,
    })
}

fn rollout_text(case: &Case, stable: &StableStep) -> String {
    let (lattice, physics) = (&case.lattice, &case.physics);
    let (name, nodes) = (case.layout.name(), lattice.nodes());
    let design = match case.design {
        Design::Layout(_) => "a layout, one material per edge",
        Design::Undecided(_) => "a mixture of materials per edge",
    };
    let (inputs, hidden, outputs) = controller_sizes(case);
    let controller = match hidden {
        Some(hidden) => {
            format!("{inputs} observed numbers, {hidden} hidden units, {outputs} activations")
        }
        None => format!("{}, {outputs} activations", case.observation.policy.name()),
    };
    let (steps, dt) = (physics.steps, physics.dt);
    format!(
        "  lattice      {name}, {nodes} nodes, {} edges
  design       {design}
  controller   {controller}
  world        gravity {} m/s2, damping {} 1/s
  contact      {}
  steps        {steps} of {dt} s, {} s in all
  integrator   {}
  stable step  {}
",
        lattice.edges.len(),
        physics.gravity,
        physics.damping,
        contact_text(physics),
        steps as f64 * dt,
        integrator_text(physics),
        stable.text(dt),
    )
}

fn contact_text(physics: &PhysicsSettings) -> String {
    let law = within_a_sentence(physics.contact.about());
    match physics.contact.name() {
        "coulomb" => format!("{law}, coefficient {}", physics.friction),
        _ => law,
    }
}

/// Converts a sentence for use inside another sentence: without its capital letter and its full stop.
fn within_a_sentence(sentence: &str) -> String {
    let mut rest = sentence.trim_end_matches('.').chars();
    let first = rest.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + rest.as_str()
}

fn integrator_text(physics: &PhysicsSettings) -> String {
    let name = match physics.integrator {
        Integrator::SymplecticEuler => "symplectic Euler",
        Integrator::Leapfrog => "leapfrog",
        Integrator::Implicit => "implicit",
    };
    match physics.substeps {
        1 => name.to_owned(),
        substeps => format!("{name}, {substeps} substeps"),
    }
}

/// Lists the terms that a step computes, then the terms that it skips.
fn plan_text(plan: &Plan) -> String {
    let row = |term: &Term| {
        let percent = 100.0 * term.share.unwrap_or(f64::NAN);
        let time = match (term.cost, term.saving) {
            (Some(cost), _) => format!("{cost:.3} us, {percent:.0} %"),
            (None, Some(saving)) => format!("saves {saving:.3} us"),
            (None, None) => String::new(),
        };
        format!("    {:<24} {time:<16} {}\n", term.name, term.why)
    };
    let rows = |kept: bool| -> String {
        let terms = plan.terms.iter().filter(|term| term.kept == kept);
        terms.map(row).collect()
    };
    let measured = plan.step.map_or(String::new(), |step| {
        format!(" ({step:.3} us; the cost of a term is the time saved without it)")
    });
    format!(
        "  computed in every step{measured}\n{}  left out\n{}",
        rows(true),
        rows(false)
    )
}

fn speed_text(speed: &Speed) -> String {
    let rows = [
        ("rollout", speed.rollout),
        ("value and design gradient", speed.value_and_design_gradient),
        (
            "value and controller gradient",
            speed.value_and_controller_gradient,
        ),
        ("two matvecs", speed.two_matvecs),
    ];
    let rows = rows.map(|(name, time)| {
        let ratio = time / speed.rollout;
        format!("  {name:<43} {time:>8.3} us a step, {ratio:>5.2} rollouts\n")
    });
    let memory = peak_memory().map_or("unknown".to_owned(), |bytes| {
        format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
    });
    format!(
        "measured over {} steps\n{}  peak memory of the process {memory}\n",
        speed.steps,
        rows.concat()
    )
}

/// The measured times as JSON, in microseconds per step.
fn speed_json(speed: &Speed) -> Value {
    let mut value = json!(speed);
    value["design_ratio"] = json!(speed.value_and_design_gradient / speed.rollout);
    value["controller_ratio"] = json!(speed.value_and_controller_gradient / speed.rollout);
    value["rollout_per_two_matvecs"] = json!(speed.rollout / speed.two_matvecs);
    value["peak_memory_bytes"] = peak_memory().map_or(json!("unknown"), |bytes| json!(bytes));
    value
}
