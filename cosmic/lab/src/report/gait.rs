//! How a robot walks, for the scripts of a page: which nodes stand when, what its actuators are told and do, what
//! its bars bear, and its energies. All of it is taken from the states of the trajectory.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::files::RunFiles;
use super::motion::Motion;
use cosmic::Result;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::lattice::State;
use cosmic::record::run::DESIGN;
use cosmic::simulator::{BarLoad, EdgeMoments, Trajectory};

/// Periods of the clock that are shown, at the end of the rollout.
const PERIODS: f64 = 3.0;
/// The most states of a rollout that energies are given of.
const MOST_STATES: usize = 600;
/// A node that is less far above the ground stands on it, m: contact puts nodes onto the ground to rounding.
const TOUCHES: f64 = 1e-6;

/// A run's delivered robot, and what its edges do in the states of the trajectory.
pub(super) struct Gait<'r> {
    run: &'r RunFiles,
    case: Case,
    moments: Vec<EdgeMoments>,
}

impl<'r> Gait<'r> {
    /// # Errors
    /// If the design does not fit its scene.
    pub(super) fn new(run: &'r RunFiles) -> Result<Self> {
        let file = run.folder.join(DESIGN).display().to_string();
        let case = run.robot.design.case(&run.robot.scene, &file)?;
        let trajectory = Trajectory {
            steps: run.trajectory.steps.clone(),
            states: run.trajectory.states.clone(),
        };
        let (task, mixture) = (case.task(), case.own_mixture());
        let moments = task.moments(&mixture, &case.controller, &trajectory);
        Ok(Self { run, case, moments })
    }

    /// What every edge bears.
    pub(super) fn loads(&self) -> Vec<BarLoad> {
        let edges = 0..self.case.lattice.edges.len();
        edges.map(|edge| BarLoad::of(edge, &self.moments)).collect()
    }

    /// The last periods of the clock: feet, commands as target strains, strains; and peaks of strains and forces.
    pub(super) fn last_periods(&self, motion: &Motion, loads: &[BarLoad]) -> Value {
        let omega = motion.scene().controller.omega;
        let period = (TAU / omega).min(motion.duration());
        let last = motion.states().len() - 1;
        let from = motion.index_at(motion.duration() - (PERIODS * period).min(motion.duration()));
        let (shown, bars) = (from..=last, self.run.robot.edges_of(Material::is_solid));
        let actuators = self.run.robot.edges_of(|m| m == Material::Actuator);
        let series = |of: &dyn Fn(&EdgeMoments, usize) -> f64| -> Vec<Vec<f64>> {
            let of_edge = |&edge: &usize| {
                let moments = self.moments[shown.clone()].iter();
                moments.map(|moment| brief(of(moment, edge))).collect()
            };
            actuators.iter().map(of_edge).collect()
        };
        let peak = |&edge: &usize| {
            let (load, [low, high]) = (&loads[edge], loads[edge].strains);
            [low, high, load.compression, load.tension].map(brief)
        };
        let body = self.case.body();
        json!({
            "period": period,
            "times": shown.clone().map(|k| brief(motion.time(k))).collect::<Vec<_>>(),
            "feet": self.feet(motion, &motion.states()[shown.clone()]),
            "actuators": actuators,
            "commands": series(&|m, edge| m.activation[edge] * body.strain[edge]),
            "strains": series(&|m, edge| m.strain[edge]),
            "bars": bars,
            "peaks": bars.iter().map(peak).collect::<Vec<_>>(),
        })
    }

    /// The nodes of the robot that stand on the ground in some of these states, each with a letter a state: 1
    /// where it stands.
    fn feet(&self, motion: &Motion, states: &[State<f64>]) -> Vec<(usize, String)> {
        let ground = motion.ground();
        let heights: Vec<Vec<f64>> = states
            .iter()
            .map(|state| {
                let state = state.to_ground(&ground);
                let height =
                    |&node: &usize| state.x[node][1] - motion.profile.height(state.x[node][0]);
                motion.seen.iter().map(height).collect()
            })
            .collect();
        let of_node = |(k, &node): (usize, &usize)| {
            let stands = |heights: &Vec<f64>| if heights[k] < TOUCHES { '1' } else { '0' };
            (node, heights.iter().map(stands).collect::<String>())
        };
        let nodes = motion.seen.iter().enumerate().map(of_node);
        let has_ground = motion.scene().physics.contact.has_ground();
        nodes
            .filter(|(_, stands)| has_ground && stands.contains('1'))
            .collect()
    }

    /// The forces along the bars in some states, rounded to a five-hundredth of the largest.
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

    /// Kinetic energy, that of springs and stops, and that of height above the start, J, over the time.
    pub(super) fn energies(&self, motion: &Motion) -> Value {
        let (states, mass) = (motion.states(), &self.case.body().mass);
        let every = states.len().div_ceil(MOST_STATES);
        let shown: Vec<usize> = (0..states.len()).step_by(every).collect();
        let sum = |k: usize, of: &dyn Fn(&State<f64>, usize) -> f64| -> f64 {
            let nodes = mass.iter().enumerate();
            nodes.map(|(node, mass)| mass * of(&states[k], node)).sum()
        };
        let kinetic = |&k: &usize| {
            let square = |[x, y]: [f64; 2]| 0.5 * (x * x + y * y);
            brief(sum(k, &|state, node| square(state.v[node])))
        };
        let gravity = motion.scene().physics.gravity;
        let height = |&k: &usize| {
            let height = |state: &State<f64>, node: usize| state.x[node][1] - states[0].x[node][1];
            brief(gravity * sum(k, &height))
        };
        let all = |of: &dyn Fn(&usize) -> f64| shown.iter().map(of).collect::<Vec<f64>>();
        json!({
            "times": all(&|&k| brief(motion.time(k))),
            "kinetic": all(&kinetic),
            "elastic": all(&|&k| brief(self.moments[k].elastic)),
            "height": all(&height),
        })
    }
}

/// A number to four digits; they are read in pictures.
pub(super) fn brief(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}
