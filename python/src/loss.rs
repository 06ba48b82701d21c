//! Losses written in Python.

use crate::arrays::{array, flattened};
use autodiff::Real;
use autodiff::custom::{Rule, apply};
use cosmic::objective::Loss;
use cosmic::policy::Goals;
use cosmic::simulator::Trajectory;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
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
    failure: Failure,
}

impl PythonLoss {
    pub(crate) fn new(object: Py<PyAny>, failure: Failure) -> Self {
        let object = Arc::new(object);
        Self { object, failure }
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

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let call = Call {
            loss: self.clone(),
            states: trajectory.steps.len(),
            goals: (trajectory.goals.as_ref()).map(|goals| goals_at(goals, &trajectory.steps)),
            gradient: Arc::default(),
        };
        let numbers = flattened(std::slice::from_ref(trajectory)).concat();
        apply(call, &numbers)
    }
}

/// The goals to which a robot goes before it is in the states after these numbers of steps.
fn goals_at<R: Real>(goals: &Goals<R>, steps: &[usize]) -> Vec<f64> {
    let points: Vec<_> = goals.iter().collect();
    let goal = |&step: &usize| points[goals.place(step.saturating_sub(1))].map(|x| x.primal());
    steps.iter().flat_map(goal).collect()
}

/// The loss as a function of one list of numbers: the positions of all observed states, then their velocities. The
/// optimisation takes only first derivatives of it, so Python only sees floats.
#[derive(Clone)]
struct Call {
    loss: PythonLoss,
    states: usize,
    /// Two numbers for each state; `None` if goals are not inputs of a rollout.
    goals: Option<Vec<f64>>,
    /// The gradient of the last call of `value`, which gets it from Python together with the value. `partials` returns
    /// it.
    gradient: Arc<Mutex<Vec<f64>>>,
}

impl Call {
    /// Calls Python, which returns the value and the gradient.
    fn ask(&self, numbers: &[f64]) -> PyResult<(f64, Vec<f64>)> {
        Python::attach(|py| {
            let nodes = numbers.len() / 4 / self.states;
            let (x, v) = numbers.split_at(numbers.len() / 2);
            let shape = [self.states, nodes, 2];
            let mut arguments = vec![
                array(py, x.to_vec(), &shape)?,
                array(py, v.to_vec(), &shape)?,
            ];
            if let Some(goals) = &self.goals {
                arguments.push(array(py, goals.clone(), &[self.states, 2])?);
            }
            let arguments = PyTuple::new(py, arguments)?;
            let object = &self.loss.object;
            let answer = object.call_method1(py, "value_and_gradient", arguments)?;
            let (value, gradient): (f64, PyReadonlyArray1<f64>) = answer.extract(py)?;
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
