//! Losses and gradients of a population of robots.

use autodiff::{Tape, Var};
use cosmic::lattice::{Body, Marker, State};
use cosmic::policy::Controller;
use cosmic::simulator::{PrintedRobots, Robots, Trajectory};

use crate::device::{Gpu, GpuError};
use crate::population::{Cotangents, Members, Population, Sweep};

/// Robots on a device.
pub struct RobotsOnGpu<'a> {
    population: Population<'a>,
    printed: PrintedRobots,
    inputs: Vec<f32>,
}

/// The results of a gradient, for each member.
#[derive(Clone, Debug)]
pub struct Gradients {
    /// The losses.
    pub losses: Vec<f64>,
    /// The cotangents of the bodies, if they were wanted when the step was printed.
    pub bodies: Vec<Body<f64>>,
    /// The cotangents of the controllers' numbers, if they were wanted.
    pub controllers: Vec<Vec<f64>>,
    /// The cotangents of the states at the start, as the numbers of the program.
    pub starts: Vec<f32>,
}

impl<'a> RobotsOnGpu<'a> {
    /// Compiles the printed step of robots for a device.
    ///
    /// # Errors
    /// If it is too large for the device, or its driver refuses it.
    pub fn new(gpu: &'a Gpu, printed: PrintedRobots) -> Result<Self, GpuError> {
        Ok(Self {
            population: Population::new(gpu, printed.program.clone())?,
            inputs: printed.inputs.iter().map(|&x| x as f32).collect(),
            printed,
        })
    }

    /// The printed robots.
    pub fn printed(&self) -> &PrintedRobots {
        &self.printed
    }

    /// The program on the device, with its settings.
    pub fn population(&mut self) -> &mut Population<'a> {
        &mut self.population
    }

    /// Runs robots forward and returns the sweep. With `reverses`, it can be followed by a reverse sweep.
    pub fn sweep(&self, robots: &Robots<f64>, starts: &[State<f64>], reverses: bool) -> Sweep<'_> {
        let single =
            |numbers: Vec<f64>| numbers.into_iter().map(|x| x as f32).collect::<Vec<f32>>();
        let numbers = self
            .printed
            .numbers(robots)
            .into_iter()
            .map(single)
            .collect::<Vec<_>>();
        let starts = single(self.printed.starts(starts));
        let observed = &self.printed.span().observed;
        let members = Members {
            starts: &starts,
            parameters: &numbers,
            steps: observed.last().copied().unwrap_or(0),
            inputs: &self.inputs,
            observed,
        };
        let sweep = self.population.prepare(&members, reverses);
        sweep.forward();
        sweep
    }

    /// Simulates robots.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn rollouts(
        &self,
        robots: &Robots<f64>,
        starts: &[State<f64>],
    ) -> Result<Vec<Trajectory<f64>>, GpuError> {
        let seen = self.sweep(robots, starts, false).observed()?;
        let parts = seen.chunks(seen.len() / starts.len());
        let trajectory = |(k, part): (usize, &[f32])| {
            let part: Vec<f64> = part.iter().map(|&x| f64::from(x)).collect();
            let (surroundings, body, _) = of_member(robots, k);
            self.printed
                .trajectory(&part, surroundings, body, &starts[k])
        };
        Ok(parts.enumerate().map(trajectory).collect())
    }

    /// Returns the losses of all members and their gradients. The loss is computed on the processor, from the states that
    /// the span observes, and differentiated there.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn gradients(
        &self,
        robots: &Robots<f64>,
        starts: &[State<f64>],
        loss: impl Fn(&Trajectory<Var<f64>>) -> Var<f64>,
    ) -> Result<Gradients, GpuError> {
        let sweep = self.sweep(robots, starts, true);
        let seen = sweep.observed()?;
        let (mut losses, mut cotangents) = (Vec::new(), Vec::new());
        for (k, part) in seen.chunks(seen.len() / starts.len()).enumerate() {
            let part: Vec<f64> = part.iter().map(|&x| f64::from(x)).collect();
            let (surroundings, body, _) = of_member(robots, k);
            let mut tape = Tape::new();
            let value = tape.record(&part, |seen| {
                let trajectory = self.printed.trajectory(
                    seen,
                    &surroundings.map(Var::constant),
                    &body.map(Var::constant),
                    &starts[k].map(Var::constant),
                );
                loss(&trajectory)
            });
            losses.push(value.value());
            cotangents.extend(tape.pullback(&[value], &[1.0]).iter().map(|&x| x as f32));
        }
        sweep.reverse(&cotangents);
        let bars = sweep.cotangents()?;
        let of_members = (0..starts.len()).map(|k| self.pulled_back(robots, k, &bars));
        let (bodies, controllers) = of_members.unzip();
        Ok(Gradients {
            losses,
            bodies,
            controllers,
            starts: bars.starts,
        })
    }

    /// Pulls the cotangents of a member's parameters back to its body and its controller.
    fn pulled_back(
        &self,
        robots: &Robots<f64>,
        k: usize,
        bars: &Cotangents,
    ) -> (Body<f64>, Vec<f64>) {
        let (surroundings, body, controller) = of_member(robots, k);
        let flat = [&flat(body)[..], controller.numbers()].concat();
        let own = flat.len() - controller.numbers().len();
        let mut tape = Tape::new();
        let numbers = tape.record(&flat, |x| {
            let body = unflat(body, &x[..own]);
            let mut of_policy = controller.map(Var::constant);
            of_policy.numbers_mut().copy_from_slice(&x[own..]);
            self.printed
                .numbers_of_one(&surroundings.map(Var::constant), &body, &of_policy)
        });
        let (mut outputs, mut cotangents) = (Vec::new(), Vec::new());
        for (list, bars) in numbers.into_iter().zip(&bars.parameters) {
            if !bars.is_empty() {
                cotangents.extend(
                    bars[k * list.len()..][..list.len()]
                        .iter()
                        .map(|&x| f64::from(x)),
                );
                outputs.extend(list);
            }
        }
        let gradient = tape.pullback(&outputs, &cotangents);
        (unflat(body, &gradient[..own]), gradient[own..].to_vec())
    }
}

/// The surroundings, the body and the controller of a member.
fn of_member<'a, R>(
    robots: &Robots<'a, R>,
    k: usize,
) -> (
    &'a cosmic::simulator::Surroundings<R>,
    &'a Body<R>,
    &'a Controller<R>,
) {
    let Robots {
        surroundings,
        bodies,
        controllers,
    } = *robots;
    (
        &surroundings[k % surroundings.len()],
        &bodies[k % bodies.len()],
        &controllers[k % controllers.len()],
    )
}

/// All numbers of a body.
fn flat(body: &Body<f64>) -> Vec<f64> {
    [
        &body.stiffness[..],
        &body.strain,
        &body.mass,
        &body.presence,
        &body.marker.weights,
    ]
    .concat()
}

/// The body with these numbers.
fn unflat<R: Copy, S>(of: &Body<S>, numbers: &[R]) -> Body<R> {
    let mut rest = numbers;
    let mut next = |like: &[S]| {
        let (list, others) = rest.split_at(like.len());
        rest = others;
        list.to_vec()
    };
    Body {
        stiffness: next(&of.stiffness),
        strain: next(&of.strain),
        mass: next(&of.mass),
        presence: next(&of.presence),
        marker: Marker {
            payload: of.marker.payload,
            weights: next(&of.marker.weights),
        },
    }
}
