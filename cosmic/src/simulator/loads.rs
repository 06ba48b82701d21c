//! What bars bear and do in the states of a rollout.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use super::{Simulator, Trajectory};
use crate::controller::Controller;
use crate::design::Material;
use crate::lattice::{Body, State, crossings, length, rate};
use crate::laws::Pose;

/// A magnitude over some states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Magnitude {
    /// The largest.
    pub peak: f64,
    /// The 99 % quantile.
    pub p99: f64,
}

impl Magnitude {
    fn of(mut sample: Vec<f64>) -> Self {
        sample.iter_mut().for_each(|x| *x = x.abs());
        sample.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * sample.len().saturating_sub(1) as f64;
            sample.get(place.round() as usize).copied().unwrap_or(0.0)
        };
        Self {
            peak: at(1.0),
            p99: at(0.99),
        }
    }

    /// The larger peak, and the larger quantile.
    fn max(self, other: Self) -> Self {
        Self {
            peak: self.peak.max(other.peak),
            p99: self.p99.max(other.p99),
        }
    }
}

/// What a bar bears and does in some states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarLoad {
    /// Least and greatest change of length over the length at rest.
    pub strains: [f64; 2],
    /// That change in magnitude.
    pub strain: Magnitude,
    /// The force along the bar, N.
    pub force: Magnitude,
    /// The rate of the length, m/s.
    pub speed: Magnitude,
    /// Force times rate: what the bar gives its nodes, or takes from them, W.
    pub power: Magnitude,
    /// The largest force that pulls, N.
    pub tension: f64,
    /// The largest force that pushes, N.
    pub compression: f64,
}

/// The loads of a robot: of its actuators, and the largest push on a bar.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Least and greatest strain of an actuator.
    pub strains: [f64; 2],
    /// The largest of any actuator.
    pub strain: Magnitude,
    /// The largest of any actuator, N.
    pub force: Magnitude,
    /// The largest of any actuator, m/s.
    pub speed: Magnitude,
    /// The largest of any actuator, W.
    pub power: Magnitude,
    /// The largest force that pushes on a bar, N.
    pub compression: f64,
    /// Share of the states in which bars cross that do not at rest: nothing keeps a robot from passing through
    /// itself.
    pub tangled: f64,
    /// Such pairs of bars in a state, in the mean.
    pub tangles: f64,
}

/// What the edges of a robot do in a state.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeMoments {
    /// The controller's output for each, from -1 to 1.
    pub activation: Vec<f64>,
    /// Change of length over the length at rest.
    pub strain: Vec<f64>,
    /// The force with which its bar pulls its ends together, N.
    pub tension: Vec<f64>,
    /// The rate of its length, m/s.
    pub rate: Vec<f64>,
    /// The energy of all forces that have one, J.
    pub elastic: f64,
}

impl Simulator {
    /// What the edges do in the states of a trajectory, with the controller's activation there.
    pub fn moments(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        trajectory: &Trajectory<f64>,
    ) -> Vec<EdgeMoments> {
        let edges = self.lattice.edges.iter().enumerate();
        let forces = &self.robot.mechanics.forces;
        let moment = |(&step, state): (&usize, &State<f64>)| {
            let time = step as f64 * self.dt;
            let activation = self.activation(body, controller, state, time);
            let pose = Pose {
                lattice: &self.lattice,
                body,
                state,
                activation: &activation,
                time,
            };
            let strain = |(edge, ends): (usize, &[usize; 2])| {
                length(&state.x, *ends) / self.lattice.rest_length[edge] - 1.0
            };
            let pull = |edge| forces.iter().map(|force| force.tension(&pose, edge)).sum();
            EdgeMoments {
                strain: edges.clone().map(strain).collect(),
                tension: edges.clone().map(|(edge, _)| pull(edge)).collect(),
                rate: edges.clone().map(|(_, ends)| rate(state, *ends)).collect(),
                elastic: forces.iter().filter_map(|force| force.energy(&pose)).sum(),
                activation,
            }
        };
        let states = trajectory.steps.iter().zip(&trajectory.states);
        states.map(moment).collect()
    }

    /// The loads of every edge in the states of a trajectory. Between those states nothing is known.
    pub fn loads(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        trajectory: &Trajectory<f64>,
    ) -> Vec<BarLoad> {
        let moments = self.moments(body, controller, trajectory);
        let edges = 0..self.lattice.edges.len();
        edges.map(|edge| BarLoad::of(edge, &moments)).collect()
    }

    /// The loads of a layout's bars.
    pub fn loads_of(
        &self,
        layout: &[Material],
        body: &Body<f64>,
        controller: &Controller<f64>,
        trajectory: &Trajectory<f64>,
    ) -> Loads {
        let bars = self.loads(body, controller, trajectory);
        let mut loads = Loads::default();
        for (bar, &material) in bars.iter().zip(layout) {
            if !material.is_solid() {
                continue;
            }
            loads.compression = loads.compression.max(bar.compression);
            if material == Material::Actuator {
                let [low, high] = bar.strains;
                loads.strains = [loads.strains[0].min(low), loads.strains[1].max(high)];
                loads.strain = loads.strain.max(bar.strain);
                loads.force = loads.force.max(bar.force);
                loads.speed = loads.speed.max(bar.speed);
                loads.power = loads.power.max(bar.power);
            }
        }
        let tangles = self.tangles(layout, trajectory);
        let states = tangles.len().max(1) as f64;
        loads.tangled = tangles.iter().filter(|pairs| **pairs > 0).count() as f64 / states;
        loads.tangles = tangles.iter().sum::<usize>() as f64 / states;
        loads
    }
}

impl Simulator {
    /// In each state the pairs of bars that cross and do not at rest.
    fn tangles(&self, layout: &[Material], trajectory: &Trajectory<f64>) -> Vec<usize> {
        let bars = (self.lattice.edges.iter().zip(layout)).filter(|(_, m)| m.is_solid());
        let bars: Vec<[usize; 2]> = bars.map(|(ends, _)| *ends).collect();
        let at_rest = crossings(&self.lattice.places, &bars);
        let at_rest: HashSet<[usize; 2]> = at_rest.into_iter().collect();
        let count = |state: &State<f64>| {
            let crossed = crossings(&state.x, &bars);
            crossed
                .iter()
                .filter(|pair| !at_rest.contains(*pair))
                .count()
        };
        trajectory.states.iter().map(count).collect()
    }
}

impl BarLoad {
    /// Of an edge in some states.
    pub fn of(edge: usize, moments: &[EdgeMoments]) -> Self {
        let series = |of: fn(&EdgeMoments) -> &Vec<f64>| -> Vec<f64> {
            moments.iter().map(|moment| of(moment)[edge]).collect()
        };
        let (strains, tensions) = (series(|m| &m.strain), series(|m| &m.tension));
        let rates = series(|m| &m.rate);
        let most = |sample: &[f64], sign: f64| sample.iter().fold(0.0, |m: f64, x| m.max(sign * x));
        let powers = tensions
            .iter()
            .zip(&rates)
            .map(|(force, rate)| force * rate);
        Self {
            strains: [-most(&strains, -1.0), most(&strains, 1.0)],
            tension: most(&tensions, 1.0),
            compression: most(&tensions, -1.0),
            power: Magnitude::of(powers.collect()),
            strain: Magnitude::of(strains),
            force: Magnitude::of(tensions),
            speed: Magnitude::of(rates),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Loads, Magnitude};
    use crate::controller::Controller;
    use crate::design::Material;
    use crate::lattice::{Body, Lattice, State};
    use crate::projection::one_hot;
    use crate::scene::Scene;
    use crate::simulator::{Simulator, Trajectory};

    #[test]
    fn a_magnitude_is_the_peak_and_nearly_the_peak() {
        let sample = (0..=100).map(|k| -f64::from(k)).collect();
        let (peak, p99) = (100.0, 99.0);
        assert_eq!(Magnitude::of(sample), Magnitude { peak, p99 });
        assert_eq!(Magnitude::of(Vec::new()), Magnitude::default());
    }

    /// The stiffness of a bar is not that of its material, so no radius against buckling follows from it.
    /// Earlier versions wrote one, and their summaries can be read.
    #[test]
    fn loads_tell_no_radius_and_those_of_earlier_versions_are_read() {
        let mut file = serde_json::to_value(Loads::default()).unwrap();
        for gone in ["least_radius", "buckling"] {
            assert_eq!(file.get(gone), None);
        }
        (file["least_radius"], file["compression"]) = (0.064.into(), 7.5.into());
        file["buckling"] = serde_json::json!([3, 8]);
        let read: Loads = serde_json::from_value(file).unwrap();
        let compression = 7.5;
        assert_eq!(
            read,
            Loads {
                compression,
                ..Loads::default()
            }
        );
    }

    /// A lattice that is stretched by a tenth along x and grows on at 1 m/s a metre.
    #[test]
    fn loads_are_those_of_hooke_s_bars() {
        let scene = Scene::paper();
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let layout = vec![Material::Skeleton; lattice.edges.len()];
        let mixture = one_hot::<f64>(&layout);
        let body = Body::new(&mixture, &lattice, &scene.materials, &scene.physics);
        let controller = Controller::xavier(&scene.controller, &lattice, 1);
        let simulator = Simulator::new(&lattice, &scene.physics, &scene.controller);
        let rest = lattice.state_at_rest();
        let stretched = State {
            x: rest.x.iter().map(|[x, y]| [1.1 * x, *y]).collect(),
            v: rest.x.iter().map(|[x, _]| [1.1 * x, 0.0]).collect(),
        };
        let trajectory = Trajectory {
            steps: vec![0, 16],
            states: vec![rest, stretched],
        };
        let loads = simulator.loads(&body, &controller, &trajectory);
        for (load, &[i, j]) in loads.iter().zip(&lattice.edges) {
            let [dx, dy] = lattice.direction([i, j]).map(f64::abs);
            if dy == 0.0 {
                // 400 N/m times 10 mm, at 0.11 m/s; the softening is 5e-11 of a length.
                assert!((load.strain.peak - 0.1).abs() < 1e-9, "{load:?}");
                assert!((load.tension - 4.0).abs() < 1e-7 && load.compression < 1e-7);
                assert!((load.speed.peak - 0.11).abs() < 1e-9);
                assert!((load.power.peak - 0.44).abs() < 1e-7);
            } else if dx == 0.0 {
                assert!(load.force.peak < 1e-7 && load.speed.peak < 1e-9);
            }
        }
        let all = simulator.loads_of(&layout, &body, &controller, &trajectory);
        assert_eq!(all.strains, [0.0; 2]);
        assert_eq!((all.tangled, all.tangles), (0.0, 0.0));
        // Half of the robot is moved across the other half in one of two states.
        let mut folded = trajectory.clone();
        let middle = 0.25;
        let fold = |x: &mut [f64; 2]| x[0] = middle + 0.37 * (x[0] - middle).abs();
        folded.states[1].x.iter_mut().for_each(fold);
        folded.states[1]
            .x
            .iter_mut()
            .enumerate()
            .for_each(|(k, x)| x[1] += 1e-3 * k as f64);
        let all = simulator.loads_of(&layout, &body, &controller, &folded);
        assert!(all.tangled == 0.5 && all.tangles > 1.0, "{all:?}");
    }
}
