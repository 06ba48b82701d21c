//! Prepares the gait of a robot for a page: when its nodes touch the ground, the target strains and
//! strains of its actuators, the loads of its bars, and its energies. All of this is computed from the states of the
//! trajectory file, except the loads: the run recorded them in every step.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::files::RunFiles;
use super::motion::{DrawnMotion, TOUCHES};
use crate::table::Table;
use cosmic::Result;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::geometry::Range;
use cosmic::lattice::State;
use cosmic::numbers::{fixed, rounded};
use cosmic::record::run::DESIGN;
use cosmic::walk::{self, BarLoad, EdgeMoments};
use cosmic::world::Trajectory;

/// How many periods of the clock a page shows: the last ones of the rollout.
const PERIODS: f64 = 3.0;
/// The largest number of states for which energies are computed.
const MOST_STATES: usize = 600;

/// The final robot of a run, with the strains and forces of its edges in the states of the trajectory file.
pub struct Gait<'r> {
    run: &'r RunFiles,
    /// The case of the delivered robot.
    pub case: Case,
    moments: Vec<EdgeMoments>,
    /// The loads of every edge over all steps of the rollout. Those of an undecided design cover only the states in the
    /// trajectory file.
    pub loads: Vec<BarLoad>,
}

impl<'r> Gait<'r> {
    /// Computes the strains and forces of a run's final robot from the states of the run's trajectory.
    ///
    /// # Errors
    /// If the design does not fit its scene.
    pub fn new(run: &'r RunFiles) -> Result<Self> {
        let path = run.folder.join(DESIGN);
        let case = run.robot.case(&path)?;
        let kept = &run.trajectory;
        let trajectory = Trajectory::new(kept.steps.clone(), kept.states.clone());
        let moments = walk::moments(&case.world(), &case.robot(), &trajectory);
        let kept = &run.trajectory.bars;
        let load = |edge: usize| match kept.get(edge) {
            Some(bar) => bar.unwrap_or_default(),
            None => BarLoad::of(edge, &moments),
        };
        let loads = (0..case.lattice.edges.len()).map(load).collect();
        Ok(Self {
            run,
            case,
            moments,
            loads,
        })
    }

    /// Returns the end of a sentence about loads: which states the loads cover.
    pub fn loads_over(&self) -> String {
        let states = self.run.trajectory.states.len();
        if self.run.trajectory.bars.is_empty() {
            format!("in the {states} states of trajectory.json")
        } else {
            "over all steps of the rollout".to_owned()
        }
    }

    /// Returns a sentence that compares the largest strains of the actuators with the largest target strain.
    pub(super) fn peaks(&self, actuators: &[usize], limit: f64) -> String {
        let loads = &self.loads;
        let percent = |strain: f64| fixed(100.0 * strain, 1) + " %";
        let peak = |edge: &&usize| loads[**edge].strain.peak;
        let Some(&most) = actuators.iter().max_by(|a, b| peak(a).total_cmp(&peak(b))) else {
            return "No edge is an actuator.".to_owned();
        };
        let largest = percent(loads[most].strain.peak);
        let (beyond, all) = (
            actuators.iter().filter(|edge| peak(edge) > limit).count(),
            actuators.len(),
        );
        let limit = percent(limit);
        if beyond == 0 {
            return format!(
                "No actuator is strained beyond \u{b1}{limit}, the largest target strain; the largest strain is {largest} (edge {most})."
            );
        }
        format!(
            "<b class=\"beyond\">{beyond} of {all} actuators are strained beyond \u{b1}{limit}</b>, the largest target strain; the largest strain is {largest} (edge {most})."
        )
    }

    /// Returns the table of the loads of all actuators, hidden until the reader opens it.
    pub(super) fn table(&self, actuators: &[usize]) -> String {
        if actuators.is_empty() {
            return String::new();
        }
        let table = Table::of("", "", actuators)
            .column("edge", "number in design.json", |edge| *edge)
            .keyed(|edge| Some(&self.loads[*edge]));
        let table = table.done().to_html();
        format!(
            "<details><summary>Strain, force, speed and power of every actuator</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Loads of actuators\">{table}</div></details>\n"
        )
    }

    /// Returns the data of the last periods of the clock: which nodes are on the ground, and the target strains and
    /// strains of actuators. Also returns the largest strains and forces of all bars over the whole rollout.
    pub fn last_periods(&self, motion: &DrawnMotion) -> Value {
        let period = (TAU / motion.robot.omega).min(motion.duration());
        let last = motion.states().len() - 1;
        let from = motion.index_at(motion.duration() - (PERIODS * period).min(motion.duration()));
        let (shown, bars) = (from..=last, self.run.robot.edges_of(Material::is_solid));
        let actuators = self.run.robot.edges_of(|m| m == Material::Actuator);
        let series = |of: &dyn Fn(&EdgeMoments, usize) -> f64| -> Vec<Vec<f64>> {
            let of_edge = |&edge: &usize| {
                let moments = self.moments[shown.clone()].iter();
                moments
                    .map(|moment| four_digits(of(moment, edge)))
                    .collect()
            };
            actuators.iter().map(of_edge).collect()
        };
        let peak = |&edge: &usize| {
            let load = &self.loads[edge];
            let Range { low, high } = load.strains;
            [low, high, load.compression, load.tension].map(four_digits)
        };
        let body = self.case.body();
        json!({
            "period": period,
            "times": shown.clone().map(|k| four_digits(motion.time(k))).collect::<Vec<_>>(),
            "feet": self.feet(motion, &motion.states()[shown.clone()]),
            "actuators": actuators,
            "commands": series(&|m, edge| m.activation[edge] * body.strain[edge]),
            "strains": series(&|m, edge| m.strain[edge]),
            "bars": bars,
            "peaks": bars.iter().map(peak).collect::<Vec<_>>(),
        })
    }

    /// Returns the nodes that touch the ground in at least one of `states`. Each node has a text with one character per
    /// state: `1` if the node is on the ground in that state, otherwise `0`.
    fn feet(&self, motion: &DrawnMotion, states: &[State<f64>]) -> Vec<(usize, String)> {
        let ground = motion.ground();
        let heights: Vec<Vec<f64>> = states
            .iter()
            .map(|state| {
                let state = state.to_ground(&ground);
                let height = |&node: &usize| motion.profile.above(state.x[node]);
                motion.seen.iter().map(height).collect()
            })
            .collect();
        let touches = TOUCHES * motion.robot.lattice.scale;
        let of_node = |(k, &node): (usize, &usize)| {
            let stands = |heights: &Vec<f64>| if heights[k] < touches { '1' } else { '0' };
            (node, heights.iter().map(stands).collect::<String>())
        };
        let nodes = motion.seen.iter().enumerate().map(of_node);
        let has_ground = motion.scene().physics.contact.has_ground();
        nodes
            .filter(|(_, stands)| has_ground && stands.contains('1'))
            .collect()
    }

    /// Returns the forces along the bars in the states with the indices `states`, rounded to 1/500 of the largest
    /// force.
    pub(super) fn forces(&self, states: &[usize]) -> Value {
        let bars = self.run.robot.edges_of(Material::is_solid);
        let tensions = |&state: &usize| bars.iter().map(move |&edge| (state, edge));
        let force = |(state, edge): (usize, usize)| self.moments[state].tension[edge];
        let all = states.iter().flat_map(|state| tensions(state).map(force));
        let largest = all.fold(0.0, |most: f64, force| most.max(force.abs()));
        let unit = if largest > 0.0 { largest / 500.0 } else { 1.0 };
        let count = |state: &usize| -> Vec<i64> {
            tensions(state)
                .map(|at| (force(at) / unit).round() as i64)
                .collect()
        };
        json!({ "unit": unit, "counts": states.iter().map(count).collect::<Vec<_>>() })
    }

    /// Returns three energies over time, in joules: the kinetic energy, the energy of springs and stops, and the
    /// potential energy relative to the start.
    pub fn energies(&self, motion: &DrawnMotion) -> Value {
        let (states, mass) = (motion.states(), &self.case.body().mass);
        let every = states.len().div_ceil(MOST_STATES);
        let shown: Vec<usize> = (0..states.len()).step_by(every).collect();
        let sum = |k: usize, of: &dyn Fn(&State<f64>, usize) -> f64| -> f64 {
            let nodes = mass.iter().enumerate();
            nodes.map(|(node, mass)| mass * of(&states[k], node)).sum()
        };
        let kinetic = |&k: &usize| {
            four_digits(sum(k, &|state, node| {
                0.5 * state.v[node].dot(state.v[node])
            }))
        };
        let gravity = motion.scene().physics.gravity;
        let height = |&k: &usize| {
            let height = |state: &State<f64>, node: usize| (state.x[node] - states[0].x[node]).up();
            four_digits(gravity * sum(k, &height))
        };
        let all = |of: &dyn Fn(&usize) -> f64| shown.iter().map(of).collect::<Vec<f64>>();
        json!({
            "times": all(&|&k| four_digits(motion.time(k))),
            "kinetic": all(&kinetic),
            "elastic": all(&|&k| four_digits(self.moments[k].elastic)),
            "height": all(&height),
        })
    }
}

/// Rounds a number to four digits, which are enough for a picture.
pub(super) fn four_digits(x: f64) -> f64 {
    rounded(x, 4)
}
