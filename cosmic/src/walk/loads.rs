//! The loads and the motion of bars in the states of a rollout.

use std::collections::HashSet;
use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::magnitude::{Largest, Magnitude};
use crate::design::Material;
use crate::geometry::{Range, crossings};
use crate::lattice::{Body, EdgeVector, State};
use crate::laws::Pose;
use crate::scene::MaterialSettings;
use crate::world::{Effort, Robot, Span, Trajectory, World};

/// The number of states whose activations are computed together.
const BLOCK: usize = 64;

crate::keys! {
    /// The loads and the motion of a bar over the steps of a rollout.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct BarLoad {
        /// The least and the greatest strain. Strain is the change of length divided by the rest length.
        strains: Range, "two numbers",
            columns ["strain_least", "strain_greatest"] of |bar: &BarLoad| [bar.strains.low, bar.strains.high];
        /// The magnitude of the strain.
        strain: Magnitude, "object",
            columns ["strain_peak", "strain_p99"] of |bar: &BarLoad| [bar.strain.peak, bar.strain.p99];
        /// The magnitude of the force along the bar.
        force: Magnitude, "object", unit "N",
            columns ["force_peak", "force_p99"] decimals 2 of |bar: &BarLoad| [bar.force.peak, bar.force.p99];
        /// The magnitude of the rate at which the length changes: the change in a step divided by its duration. When an end
        /// hits the ground, the rate at a moment may be higher.
        speed: Magnitude, "object", unit "m/s",
            columns ["speed_peak", "speed_p99"] decimals 2 of |bar: &BarLoad| [bar.speed.peak, bar.speed.p99];
        /// The magnitude of the power that the bar gives to its nodes or takes from them: the work of a step divided by
        /// its duration. The work is the change of the length times the mean of the forces before and after it.
        power: Magnitude, "object", unit "W",
            columns ["power_peak", "power_p99"] of |bar: &BarLoad| [bar.power.peak, bar.power.p99];
        /// The mean over all steps of the power that the bar gives to its nodes. While it takes power from them, it counts
        /// as 0.
        given: f64, "number", unit "W";
        /// The mean over all steps of the power that the bar gives to its nodes less the power that it takes from them.
        net: f64, "number", unit "W";
        /// The distance by which the bar grows longer or shorter in a second.
        travel: f64, "number", unit "m/s";
        /// The largest force with which the bar pulls its ends together.
        tension: f64, "number", unit "N";
        /// The largest force with which the bar pushes its ends apart.
        compression: f64, "number", unit "N";
    }
}

crate::keys! {
    /// The loads of a robot over a rollout: the loads of its actuators and the largest compression of a bar.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Loads {
        /// Least and greatest strain of any actuator.
        strains: Range, "two numbers";
        /// Strain (change of length divided by the rest length): the largest `peak` and the largest 99 % quantile `p99`
        /// of any actuator.
        strain: Magnitude, "object",
            columns ["strain_peak", "strain_p99"] of |loads: &Loads| [loads.strain.peak, loads.strain.p99];
        /// Force along an actuator: `peak` and `p99` like those of `strain`.
        force: Magnitude, "object", unit "N", columns ["force_peak"] decimals 2 of |loads: &Loads| loads.force.peak;
        /// Rate at which an actuator's length changes in a step: `peak` and `p99` like those of `strain`.
        speed: Magnitude, "object", unit "m/s", columns ["speed_peak"] decimals 2 of |loads: &Loads| loads.speed.peak;
        /// Power that an actuator gives or takes: `peak` and `p99` like those of `strain`. The peak depends on the time
        /// step.
        power: Magnitude, "object", unit "W", columns ["power_peak"] of |loads: &Loads| loads.power.peak;
        /// Largest strain of a skeleton bar. `null` if there is no skeleton.
        skeleton_strain: Option<f64>, "number or `null`";
        /// The largest force that pushes on a bar.
        compression: f64, "number", unit "N", columns ["compression"] decimals 2;
        /// Smallest Euler safety of a skeleton bar: the force under which the bar buckles, divided by the largest force
        /// that pushes on it. `null` if the scene has plain numbers instead of parts.
        euler_safety: Option<f64>, "number or `null`", columns ["euler_safety"] decimals 2;
        /// Share of the states in `trajectory.json` in which bars pass through each other: they cross, but not at rest.
        tangled: f64, "number", columns ["tangled"];
        /// Mean number of pairs of bars in a state that pass through each other.
        tangles: f64, "number";
        /// Largest number of pairs of bars in a state that pass through each other.
        most_tangles: usize, "whole number", columns ["most_tangles"];
    }
}

impl Loads {
    /// Combines the loads of a robot's bars to the loads of the robot, and counts the bars that cross in the states of
    /// `trajectory`.
    pub fn of(
        world: &World,
        layout: &[Material],
        bars: &[Option<BarLoad>],
        trajectory: &Trajectory<f64>,
    ) -> Self {
        let mut loads = Self::default();
        for (edge, (bar, &material)) in bars.iter().zip(layout).enumerate() {
            let Some(bar) = bar else { continue };
            loads.compression = loads.compression.max(bar.compression);
            let safety = bar.euler_safety(
                world.materials(),
                material,
                world.lattice().rest_length[edge],
            );
            let both = loads.euler_safety.into_iter().chain(safety);
            loads.euler_safety = both.reduce(f64::min);
            if material == Material::Skeleton {
                let strain = bar.strain.peak.max(loads.skeleton_strain.unwrap_or(0.0));
                loads.skeleton_strain = Some(strain);
            }
            if material == Material::Actuator {
                loads.strains = loads.strains.with(bar.strains.low).with(bar.strains.high);
                loads.strain = loads.strain.max(bar.strain);
                loads.force = loads.force.max(bar.force);
                loads.speed = loads.speed.max(bar.speed);
                loads.power = loads.power.max(bar.power);
            }
        }
        let tangles = tangles(world, layout, trajectory);
        let states = tangles.len().max(1) as f64;
        loads.tangled = tangles.iter().filter(|pairs| **pairs > 0).count() as f64 / states;
        loads.tangles = tangles.iter().sum::<usize>() as f64 / states;
        loads.most_tangles = tangles.into_iter().max().unwrap_or(0);
        loads
    }

    /// The worse of the loads of two rollouts, each number on its own.
    pub fn worse(&self, other: &Self) -> Self {
        let both = |a: Option<f64>, b: Option<f64>, worse: fn(f64, f64) -> f64| {
            a.into_iter().chain(b).reduce(worse)
        };
        let Range { low, high } = other.strains;
        Self {
            strains: self.strains.with(low).with(high),
            strain: self.strain.max(other.strain),
            force: self.force.max(other.force),
            speed: self.speed.max(other.speed),
            power: self.power.max(other.power),
            skeleton_strain: both(self.skeleton_strain, other.skeleton_strain, f64::max),
            compression: self.compression.max(other.compression),
            euler_safety: both(self.euler_safety, other.euler_safety, f64::min),
            tangled: self.tangled.max(other.tangled),
            tangles: self.tangles.max(other.tangles),
            most_tangles: self.most_tangles.max(other.most_tangles),
        }
    }
}

/// The loads and the motion of all edges of a robot in one state.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeMoments {
    /// The controller's output for each edge, from -1 to 1.
    pub activation: Vec<f64>,
    /// The strain of each edge: the change of length divided by the rest length.
    pub strain: Vec<f64>,
    /// The force with which the bar of each edge pulls its ends together, N.
    pub tension: Vec<f64>,
    /// The rate at which the length of each edge changes, m/s.
    pub rate: Vec<f64>,
    /// The sum of the potential energies of all forces that have one, J.
    pub elastic: f64,
}

/// The loads and the motion of the edges in each state of a trajectory.
///
/// # Panics
/// If activations are given step by step, because the state after the last step has none.
pub fn moments(
    world: &World,
    robot: &Robot<f64>,
    trajectory: &Trajectory<f64>,
) -> Vec<EdgeMoments> {
    let states = trajectory.steps.iter().zip(&trajectory.states);
    let states: Vec<_> = states.map(|(&step, state)| (step, state)).collect();
    let blocks = states.chunks(BLOCK);
    blocks
        .flat_map(|block| moments_of(world, robot, block))
        .collect()
}

/// The loads and the motion of the edges in several states. Each state is given with the number of steps before it.
fn moments_of(
    world: &World,
    robot: &Robot<f64>,
    states: &[(usize, &State<f64>)],
) -> Vec<EdgeMoments> {
    let time = |step: usize| step as f64 * world.physics().dt;
    let moments: Vec<_> = states.iter().map(|&(step, s)| (s, time(step))).collect();
    let activations = world.activations(robot, &moments);
    let both = states.iter().zip(activations);
    both.map(|(&(step, state), activation)| {
        moment(world, &robot.body, state, time(step), activation)
    })
    .collect()
}

/// The loads and the motion of the edges in a state. `time` is the time of the state (s).
fn moment(
    world: &World,
    body: &Body<f64>,
    state: &State<f64>,
    time: f64,
    activation: Vec<f64>,
) -> EdgeMoments {
    let edges = 0..world.lattice().edges.len();
    let forces = &world.mechanics().forces;
    let pose = pose(world, body, state, time, &activation);
    let motion = edges.clone().map(|edge| motion(world, state, edge));
    let (strain, rate) = motion.map(|[strain, rate]| (strain, rate)).unzip();
    EdgeMoments {
        strain,
        tension: edges.map(|edge| pull(world, &pose, edge)).collect(),
        rate,
        elastic: forces.iter().filter_map(|force| force.energy(&pose)).sum(),
        activation,
    }
}

/// The pose of a robot in a state. `time` is the time of the state (s).
fn pose<'a>(
    world: &'a World,
    body: &'a Body<f64>,
    state: &State<f64>,
    time: f64,
    activation: &'a [f64],
) -> Pose<'a> {
    Pose {
        activation,
        time,
        ..Pose::idle(world.lattice(), body, state, &world.ground())
    }
}

/// The force with which the bar of an edge pulls its ends together, N.
fn pull(world: &World, pose: &Pose, edge: usize) -> f64 {
    let forces = world.mechanics().forces.iter();
    let along = forces.filter_map(|force| force.along_bars());
    along.map(|force| force.tension(pose, edge)).sum()
}

/// Simulates the steps of a span that begins at time 0 and returns the loads of the bars. Strains are those of all states;
/// forces are those of the [steps](Effort). The speed is the mean over a step, because a node that hits the ground changes
/// its velocity at once: for less than a step, the rate of a bar may then be a multiple of it. The work of a step is that of
/// the mean of the forces at its start and at its end. There is an entry for each edge of the layout, which is `None` for a
/// void edge. Only about 1 % of the values are kept in memory.
pub fn bar_loads(
    world: &World,
    layout: &[Material],
    robot: &Robot<f64>,
    span: &Span,
) -> Vec<Option<BarLoad>> {
    let (body, start, steps) = (&robot.body, &robot.start, span.steps());
    let gathered = |m: &Material| m.is_solid().then(|| Gathered::over(steps + 1, steps));
    let mut bars: Vec<Option<Gathered>> = layout.iter().map(gathered).collect();
    let of_all = |bars: &mut [Option<Gathered>], see: &dyn Fn(&mut Gathered, usize)| {
        for (edge, bar) in bars.iter_mut().enumerate() {
            if let Some(bar) = bar {
                see(bar, edge);
            }
        }
    };
    of_all(&mut bars, &|bar, edge| {
        bar.see_state(strain(world, start, edge));
    });
    let is_implicit = world.mechanics().is_implicit();
    let see_end = |bars: &mut [Option<Gathered>], step: usize, state: &State<f64>| {
        let ends = moments_of(world, robot, &[(step, state)]).remove(0).tension;
        of_all(bars, &|bar, edge| bar.see_end(ends[edge]));
    };
    if is_implicit {
        see_end(&mut bars, 0, start);
    }
    let mut before = start.clone();
    let show = |step: usize, state: State<f64>, effort: Option<Effort<f64>>| {
        let effort = effort.expect("the steps are metered");
        if !is_implicit {
            let time = (step - 1) as f64 * world.physics().dt;
            let pose = pose(world, body, &before, time, &effort.activation);
            of_all(&mut bars, &|bar, edge| {
                bar.see_end(pull(world, &pose, edge))
            });
        }
        of_all(&mut bars, &|bar, edge| {
            if let Some(change) = bar.see_state(strain(world, &state, edge)) {
                bar.see_speed(change);
            }
            bar.see_force(effort.tension[edge]);
            if is_implicit {
                bar.see_end(effort.tension[edge]);
            }
        });
        before = state;
        ControlFlow::Continue(())
    };
    let metered = Span {
        metered: true,
        ..span.clone()
    };
    world.each_state(robot, &metered, show);
    if !is_implicit {
        see_end(&mut bars, steps, &before);
    }
    let seconds = steps as f64 * world.physics().dt;
    let bars = bars.into_iter().zip(&world.lattice().rest_length);
    bars.map(|(bar, length)| {
        bar.map(|bar| bar.load([length / seconds, length / world.physics().dt]))
    })
    .collect()
}

/// The strain of an edge in a state.
fn strain(world: &World, state: &State<f64>, edge: usize) -> f64 {
    let [strain, _] = motion(world, state, edge);
    strain
}

/// The strain of an edge in a state, and the rate of its length (m/s).
fn motion(world: &World, state: &State<f64>, edge: usize) -> [f64; 2] {
    let vector = EdgeVector::of(state, world.lattice().edges[edge]);
    let length = vector.length(world.lattice().softening());
    let strain = length / world.lattice().rest_length[edge] - 1.0;
    [strain, vector.rate(length)]
}

/// For each state, the number of pairs of bars that cross but do not cross at rest.
fn tangles(world: &World, layout: &[Material], trajectory: &Trajectory<f64>) -> Vec<usize> {
    let bars = (world.lattice().edges.iter().zip(layout)).filter(|(_, m)| m.is_solid());
    let bars: Vec<[usize; 2]> = bars.map(|(ends, _)| *ends).collect();
    let at_rest = crossings(world.lattice().dimension, &world.lattice().places, &bars);
    let at_rest: HashSet<[usize; 2]> = at_rest.into_iter().collect();
    let count = |state: &State<f64>| {
        let crossed = crossings(state.dimension, &state.x, &bars);
        crossed
            .iter()
            .filter(|pair| !at_rest.contains(*pair))
            .count()
    };
    trajectory.states.iter().map(count).collect()
}

impl BarLoad {
    /// The loads of the bar of an edge in several states. Its power is the force times the rate of the length, and its
    /// travel is not known.
    pub fn of(edge: usize, moments: &[EdgeMoments]) -> Self {
        let mut bar = Gathered::over(moments.len(), moments.len());
        for moment in moments {
            let (tension, rate) = (moment.tension[edge], moment.rate[edge]);
            bar.see_state(moment.strain[edge]);
            bar.see_speed(rate);
            // A bar that pulls gives power while it grows shorter.
            bar.see_force(tension);
            bar.see_work(-tension * rate);
        }
        bar.load([0.0, 1.0])
    }

    /// The force under which a skeleton bar of this rest length (m) [buckles](MaterialSettings::euler_load), divided by the
    /// largest force that pushes on it. `None` for other materials, if that force is not known, or if nothing pushes on the
    /// bar.
    pub fn euler_safety(
        &self,
        materials: &MaterialSettings,
        material: Material,
        length: f64,
    ) -> Option<f64> {
        let load = materials.euler_load(length)?;
        let is_pushed = material == Material::Skeleton && self.compression > 0.0;
        is_pushed.then(|| load / self.compression)
    }
}

/// The loads and motion of a bar, collected state by state and step by step.
#[derive(Clone, Debug)]
struct Gathered {
    /// The number of steps.
    steps: usize,
    strains: Range,
    /// The strain in the last state.
    last: Option<f64>,
    /// The sum of the absolute changes of the strain.
    travel: f64,
    /// The force and the strain at the end of the last step.
    end: Option<(f64, f64)>,
    /// The sum of the works of all steps in which the bar gave work. The units of works and speeds are chosen by the caller
    /// of [`see_work`](Self::see_work) and [`see_speed`](Self::see_speed).
    given: f64,
    /// The sum of the works of all steps.
    net: f64,
    tension: f64,
    compression: f64,
    /// The largest values of strain, force, speed and work, in this order.
    series: [Largest; 4],
}

impl Gathered {
    /// Prepares to collect the motion in a number of states and the loads in a number of steps.
    fn over(states: usize, steps: usize) -> Self {
        Self {
            steps,
            strains: Range::default(),
            last: None,
            travel: 0.0,
            end: None,
            given: 0.0,
            net: 0.0,
            tension: 0.0,
            compression: 0.0,
            series: [states, steps, steps, steps].map(Largest::of),
        }
    }

    /// Sees the strain in a state, and returns its change since the state before.
    fn see_state(&mut self, strain: f64) -> Option<f64> {
        self.strains = self.strains.with(strain);
        self.series[0].see(strain);
        let last = self.last.replace(strain)?;
        self.travel += (strain - last).abs();
        Some(strain - last)
    }

    /// Sees the rate of the length.
    fn see_speed(&mut self, rate: f64) {
        self.series[2].see(rate);
    }

    /// Sees the force of the bar in a step.
    fn see_force(&mut self, tension: f64) {
        self.tension = self.tension.max(tension);
        self.compression = self.compression.max(-tension);
        self.series[1].see(tension);
    }

    /// Sees the force in the last state, which ends a step and begins the next one.
    fn see_end(&mut self, tension: f64) {
        let strain = self.last.expect("the state has been seen");
        if let Some((tension_before, strain_before)) = self.end.replace((tension, strain)) {
            let mean = 0.5 * (tension_before + tension);
            self.see_work(-mean * (strain - strain_before));
        }
    }

    /// Sees the work that the bar gave in a step.
    fn see_work(&mut self, work: f64) {
        self.given += work.max(0.0);
        self.net += work;
        self.series[3].see(work);
    }

    /// The loads. `pace` is the rest length divided by the duration of all steps, m/s. `unit` is the speed (m/s) and the
    /// power (W) of a step whose speed and work are 1.
    fn load(self, [pace, unit]: [f64; 2]) -> BarLoad {
        let in_units = |Magnitude { peak, p99 }| Magnitude {
            peak: peak * unit,
            p99: p99 * unit,
        };
        let steps = self.steps.max(1) as f64;
        let [strain, force, speed, work] = self.series.map(Largest::magnitude);
        BarLoad {
            strains: self.strains,
            tension: self.tension,
            compression: self.compression,
            strain,
            force,
            speed: in_units(speed),
            power: in_units(work),
            given: self.given * unit / steps,
            net: self.net * unit / steps,
            travel: self.travel * pace,
        }
    }
}
