//! Losses written in Python.

use crate::arrays::flattened;
use crate::errors::refused;
use autodiff::Real;
use autodiff::custom::{Rule, apply};
use cosmic::objective::Loss;
use cosmic::policy::Goals;
use cosmic::simulator::Trajectory;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception that a loss raised, if any. After an exception, all values of the loss are NaN, and the run
/// abandons its iteration.
#[derive(Clone, Default)]
pub(crate) struct Failure {
    exception: Arc<Mutex<Option<PyErr>>>,
    stop: Arc<AtomicBool>,
}

impl Failure {
    /// No exception so far. The first one will set the flag `stop`, which stops the run.
    pub(crate) fn that_stops(stop: &Arc<AtomicBool>) -> Self {
        Self {
            exception: Arc::default(),
            stop: Arc::clone(stop),
        }
    }

    /// Keeps an exception unless there was one already, and asks the run to stop.
    fn note(&self, error: PyErr) {
        let mut kept = self
            .exception
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert(error);
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Removes and returns the exception, if there is one.
    pub(crate) fn taken(&self) -> Option<PyErr> {
        let mut kept = self
            .exception
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        kept.take()
    }
}

/// A loss in Python: an object of the class `cosmic._loss.Loss`.
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

/// Returns the value of a result. If the result is an exception, keeps it in `failure` and returns `None`.
fn noted<T>(failure: &Failure, result: PyResult<T>) -> Option<T> {
    result.map_err(|error| failure.note(error)).ok()
}

impl Loss for PythonLoss {
    fn observed(&self, steps: usize) -> Vec<usize> {
        let call = |py: Python| {
            self.object
                .call_method1(py, "observed", (steps,))?
                .extract(py)
        };
        // After an exception, the observed states are not used, but the list must still end with the rollout's last
        // step.
        noted(&self.failure, Python::attach(call)).unwrap_or_else(|| vec![steps])
    }

    fn is_far(&self) -> bool {
        let read = |py: Python| self.object.getattr(py, "is_far")?.extract(py);
        noted(&self.failure, Python::attach(read)).unwrap_or_default()
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let seen = flattened(std::slice::from_ref(trajectory));
        let numbers = [seen.x, seen.v].concat();
        let call = Call {
            object: Arc::clone(&self.object),
            failure: self.failure.clone(),
            steps: trajectory.steps.clone(),
            goals: (trajectory.goals.as_ref()).map(|goals| goals_at(goals, &trajectory.steps)),
            gradient: Arc::default(),
        };
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
    object: Arc<Py<PyAny>>,
    failure: Failure,
    steps: Vec<usize>,
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
            let (x, v) = numbers.split_at(numbers.len() / 2);
            let shape = [self.steps.len(), x.len() / 2 / self.steps.len().max(1), 2];
            let array = |part: &[f64]| part.to_vec().into_pyarray(py).reshape(shape);
            let steps = self.steps.clone().into_bound_py_any(py)?;
            let mut arguments = vec![steps, array(x)?.into_any(), array(v)?.into_any()];
            if let Some(goals) = &self.goals {
                let goals = goals.clone().into_pyarray(py);
                arguments.push(goals.reshape([self.steps.len(), 2])?.into_any());
            }
            let arguments = PyTuple::new(py, arguments)?;
            let answer = self
                .object
                .call_method1(py, "value_and_gradient", arguments)?;
            let (value, gradient): (f64, Bound<PyArray1<f64>>) = answer.extract(py)?;
            let gradient: PyReadonlyArray1<f64> = gradient.readonly();
            let gradient = gradient.as_slice()?.to_vec();
            if gradient.len() != numbers.len() {
                let (expected, found) = (numbers.len(), gradient.len());
                return Err(refused(format!(
                    "the loss: expected a gradient of {expected} numbers, found {found}"
                )));
            }
            Ok((value, gradient))
        })
    }
}

impl Rule for Call {
    fn value<R: Real>(&self, x: &[R]) -> R {
        let numbers: Vec<f64> = x.iter().map(|x| x.primal()).collect();
        let lost = || (f64::NAN, vec![f64::NAN; numbers.len()]);
        // Python is not asked about states that diverged. The library reports them itself.
        let is_finite = numbers.iter().all(|x| x.is_finite());
        let asked = is_finite
            .then(|| noted(&self.failure, self.ask(&numbers)))
            .flatten();
        let (value, gradient) = asked.unwrap_or_else(lost);
        *self.gradient.lock().unwrap_or_else(PoisonError::into_inner) = gradient;
        R::lit(value)
    }

    fn partials<R: Real>(&self, _: &[R], _: R) -> Vec<R> {
        R::lits(&self.gradient.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
