//! Losses written in Python.

use crate::arrays::{array, flattened};
use autodiff::Real;
use autodiff::custom::{Rule, apply};
use cosmic::geometry::Dimension;
use cosmic::objective::Loss;
use cosmic::policy::Goals;
use cosmic::world::{Effort, Trajectory};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The first exception that a loss raised, if any. After an exception, all values of the loss are NaN, and the run
/// abandons its iteration and stops.
#[derive(Clone, Default)]
pub(crate) struct Failure {
    exception: Arc<Mutex<Option<PyErr>>>,
    stop: Arc<AtomicBool>,
}

impl Failure {
    /// The flag that stops the run. The first exception sets it.
    pub(crate) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Returns the value of a result. Keeps its exception, unless there was one already, and asks the run to stop.
    fn noted<T>(&self, result: PyResult<T>) -> Option<T> {
        let note = |error| {
            self.kept().get_or_insert(error);
            self.stop.store(true, Ordering::Relaxed);
        };
        result.map_err(note).ok()
    }

    /// Removes and returns the exception, if there is one.
    pub(crate) fn taken(&self) -> Option<PyErr> {
        self.kept().take()
    }

    fn kept(&self) -> MutexGuard<'_, Option<PyErr>> {
        let kept = self.exception.lock();
        kept.unwrap_or_else(PoisonError::into_inner)
    }
}

/// A loss in Python: an object of the class `cosmic._loss.Loss`.
#[derive(Clone)]
pub(crate) struct PythonLoss {
    object: Arc<Py<PyAny>>,
    /// The names of the arrays that the loss sees besides positions and velocities.
    sees: Vec<String>,
    failure: Failure,
}

impl PythonLoss {
    pub(crate) fn new(object: Py<PyAny>, failure: Failure) -> Self {
        let read = |py: Python| object.getattr(py, "sees")?.extract(py);
        let sees = failure.noted(Python::attach(read)).unwrap_or_default();
        let object = Arc::new(object);
        Self {
            object,
            sees,
            failure,
        }
    }
}

impl Loss for PythonLoss {
    fn observed(&self, steps: usize) -> Vec<usize> {
        let call = |py: Python| {
            let observed = self.object.call_method1(py, "observed", (steps,))?;
            observed.extract(py)
        };
        let observed = self.failure.noted(Python::attach(call));
        // After an exception, the observed states are not used, but the list must still end with the rollout's last
        // step.
        observed.unwrap_or_else(|| vec![steps])
    }

    fn is_far(&self) -> bool {
        let read = |py: Python| self.object.getattr(py, "is_far")?.extract(py);
        let is_far = self.failure.noted(Python::attach(read));
        is_far.unwrap_or_default()
    }

    fn reads_efforts(&self) -> bool {
        !self.sees.is_empty()
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let mut numbers = flattened(std::slice::from_ref(trajectory)).concat();
        let states = trajectory.steps.len();
        let dimension = trajectory.states[0].dimension;
        let axes = dimension.count();
        let shape = vec![states, numbers.len() / (2 * axes) / states, axes];
        let mut shapes = vec![shape.clone(), shape];
        for name in &self.sees {
            let (own, shape) = seen(name, trajectory);
            numbers.extend(own);
            shapes.push(shape);
        }
        let call = Call {
            loss: self.clone(),
            shapes,
            goals: (trajectory.goals.as_ref())
                .map(|goals| goals_at(dimension, goals, &trajectory.steps)),
            gradient: Arc::default(),
        };
        apply(call, &numbers)
    }
}

/// An array that a loss can see by its name, and its shape. The class `cosmic.Loss` describes them.
fn seen<R: Real>(name: &str, trajectory: &Trajectory<R>) -> (Vec<R>, Vec<usize>) {
    let (steps, body) = (&trajectory.steps, trajectory.robot());
    let dt = trajectory
        .efforts
        .as_ref()
        .map_or(0.0, |efforts| efforts.dt);
    let of_states = |list: fn(&Effort<R>) -> &Vec<R>| {
        let lists = steps.iter().map(|&step| list(trajectory.effort(step)));
        let numbers: Vec<R> = lists.flatten().copied().collect();
        let shape = vec![steps.len(), body.stiffness.len()];
        (numbers, shape)
    };
    let of_body = |list: &[R]| (list.to_vec(), vec![list.len()]);
    match name {
        "activation" => of_states(|effort| &effort.activation),
        "tension" => of_states(|effort| &effort.tension),
        "work" => of_states(|effort| &effort.work),
        "net" => of_states(|effort| &effort.net),
        "power" => {
            let (net, shape) = of_states(|effort| &effort.net);
            (powers(&net, steps, dt), shape)
        }
        "stiffness" => of_body(&body.stiffness),
        "strain" => of_body(&body.strain),
        "mass" => of_body(&body.mass),
        "presence" if body.presence.is_empty() => of_body(&vec![R::one(); body.mass.len()]),
        "presence" => of_body(&body.presence),
        "time" => {
            let time = |&step: &usize| R::lit(step as f64 * dt);
            of_body(&steps.iter().map(time).collect::<Vec<R>>())
        }
        _ => panic!("no loss sees {name:?}"),
    }
}

/// The mean power (W) of every edge between each observed state and the one before, or the start of the rollout. `net`
/// has the net energies (J) that the edges gave from the start to each state. In the start itself the power is 0.
fn powers<R: Real>(net: &[R], steps: &[usize], dt: f64) -> Vec<R> {
    let edges = net.len() / steps.len();
    let power = |k: usize| {
        let (state, edge) = (k / edges, k % edges);
        let before = state.checked_sub(1);
        let begin = before.map_or(0, |before| steps[before]);
        let given = before.map_or(net[k], |before| net[k] - net[before * edges + edge]);
        match steps[state] - begin {
            0 => R::zero(),
            lasts => given * R::lit(1.0 / (lasts as f64 * dt)),
        }
    };
    (0..net.len()).map(power).collect()
}

/// The goals to which a robot goes before it is in the states after these numbers of steps.
fn goals_at<R: Real>(dimension: Dimension, goals: &Goals<R>, steps: &[usize]) -> Vec<f64> {
    let points: Vec<_> = goals.iter().collect();
    let goal = |&step: &usize| points[goals.place(step.saturating_sub(1))];
    let goals = steps
        .iter()
        .flat_map(|step| dimension.components(goal(step)));
    goals.map(|x| x.primal()).collect()
}

/// The loss as a function of one list of numbers: the positions of all observed states, then their velocities, then the
/// other arrays that it sees. The optimisation takes only first derivatives of it, so Python only sees floats.
#[derive(Clone)]
struct Call {
    loss: PythonLoss,
    /// The shape of each array.
    shapes: Vec<Vec<usize>>,
    /// The components of the goal for each state; `None` if goals are not inputs of a rollout.
    goals: Option<Vec<f64>>,
    /// The gradient of the last call of `value`, which gets it from Python together with the value. `partials` returns
    /// it.
    gradient: Arc<Mutex<Vec<f64>>>,
}

impl Call {
    /// Calls Python, which returns the value and the gradient.
    fn ask(&self, numbers: &[f64]) -> PyResult<(f64, Vec<f64>)> {
        Python::attach(|py| {
            let mut rest = numbers;
            let arrays = self.shapes.iter().map(|shape| {
                let (own, later) = rest.split_at(shape.iter().product());
                rest = later;
                array(py, own.to_vec(), shape)
            });
            let mut arguments = arrays.collect::<PyResult<Vec<_>>>()?;
            let seen = PyDict::new(py);
            for (name, array) in self.loss.sees.iter().zip(arguments.split_off(2)) {
                seen.set_item(name, array)?;
            }
            if let Some(goals) = &self.goals {
                let (states, axes) = (self.shapes[0][0], self.shapes[0][2]);
                arguments.push(array(py, goals.clone(), &[states, axes])?);
            }
            let arguments = PyTuple::new(py, arguments)?;
            let object = self.loss.object.bind(py);
            let answer = object.call_method("value_and_gradient", arguments, Some(&seen))?;
            let (value, gradient): (f64, PyReadonlyArray1<f64>) = answer.extract()?;
            Ok((value, gradient.as_slice()?.to_vec()))
        })
    }
}

impl Rule for Call {
    fn value<R: Real>(&self, x: &[R]) -> R {
        let numbers: Vec<f64> = x.iter().map(|x| x.primal()).collect();
        let lost = || (f64::NAN, vec![f64::NAN; numbers.len()]);
        // Python is not asked about states that diverged. The library reports them itself.
        let is_finite = numbers.iter().all(|x| x.is_finite());
        let asked = is_finite.then(|| self.loss.failure.noted(self.ask(&numbers)));
        let (value, gradient) = asked.flatten().unwrap_or_else(lost);
        *self.gradient.lock().unwrap_or_else(PoisonError::into_inner) = gradient;
        R::lit(value)
    }

    fn partials<R: Real>(&self, _: &[R], _: R) -> Vec<R> {
        R::lits(&self.gradient.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
