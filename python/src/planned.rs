//! Rollouts that JAX has compiled.

use crate::arrays::{Arrays, Number};
use crate::asked::Asked;
use crate::errors::{InputError, caught};
use crate::simulator::Simulator;
use cosmic::world::Span;
use pyo3::prelude::*;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A rollout that JAX can compile. As long as this object exists, and a while longer, XLA finds it by its number.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Planned {
    /// The number of the rollout in this process.
    #[pyo3(get)]
    id: i32,
}

struct Plan {
    simulator: Py<Simulator>,
    span: Span,
    bounded: bool,
    /// The names of the arrays, and the number of axes that they have for one robot.
    arrays: Vec<(String, usize)>,
}

/// The plans of this process by their numbers, and the numbers of those whose objects no longer exist. Calls that XLA has
/// scheduled may begin after the end of the compiled function and so of the object. XLA schedules up to 32.
struct Plans {
    all: BTreeMap<i32, Arc<Plan>>,
    ended: VecDeque<i32>,
}

/// The number of plans that are kept after the end of their objects.
const KEPT: usize = 100;

static PLANS: Mutex<Plans> = Mutex::new(Plans {
    all: BTreeMap::new(),
    ended: VecDeque::new(),
});
static NEXT: AtomicI32 = AtomicI32::new(0);

fn plans() -> MutexGuard<'static, Plans> {
    PLANS.lock().unwrap_or_else(PoisonError::into_inner)
}

#[pymethods]
impl Planned {
    #[new]
    fn new(
        simulator: Py<Simulator>,
        observed: Vec<usize>,
        bounded: bool,
        arrays: Vec<(String, usize)>,
    ) -> PyResult<Self> {
        caught(|| {
            let id = NEXT.fetch_add(1, Ordering::Relaxed);
            let plan = Plan {
                simulator,
                span: Span::from_start(observed),
                bounded,
                arrays,
            };
            plans().all.insert(id, Arc::new(plan));
            Ok(Self { id })
        })
    }
}

impl Drop for Planned {
    fn drop(&mut self) {
        let mut plans = plans();
        plans.ended.push_back(self.id);
        if plans.ended.len() > KEPT {
            let oldest = plans.ended.pop_front();
            let _plan = oldest.and_then(|id| plans.all.remove(&id));
            // The lock is released before the plan is dropped.
            drop(plans);
        }
    }
}

/// An array from XLA. If each robot has its own numbers, an axis of robots is in front.
pub(crate) struct Array<'a, R> {
    pub(crate) numbers: &'a [R],
    pub(crate) axes: &'a [i64],
}

impl<R> Array<'_, R> {
    /// The number of robots, if the array has an axis for them.
    fn robots(&self, rank: usize) -> Option<usize> {
        (self.axes.len() > rank).then(|| self.axes[0] as usize)
    }
}

/// The mode in which a call computes states.
pub(crate) const STATES: i32 = 0;
/// The mode in which a call computes derivatives of states in a direction.
pub(crate) const PUSHED: i32 = 1;
/// The mode in which a call computes gradients of states times cotangents.
pub(crate) const PULLED: i32 = 2;

/// Runs the rollouts of a plan or their derivatives, and writes the results into the arrays `made`. The arrays `given` are
/// those of the plan and the number of earlier steps, then in mode [`PUSHED`] their tangents, and in mode [`PULLED`] the
/// cotangents. `by` chooses the gradients, as in [`Asked::pulled`]. The thread must not have the interpreter's lock.
pub(crate) fn rollouts<R: Number>(
    [plan, mode, by]: [i32; 3],
    given: &[Array<R>],
    made: &mut [&mut [R]],
) -> Result<(), String> {
    let plan = plans().all.get(&plan).cloned();
    let plan = plan.ok_or("the simulator of this compiled function no longer exists; keep it")?;
    let says = |error: PyErr| {
        Python::try_attach(|_| error.to_string()).unwrap_or_else(|| "Python has ended".to_owned())
    };
    plan.run(mode, by as u32, given, made).map_err(says)
}

impl Plan {
    fn run<R: Number>(
        &self,
        mode: i32,
        by: u32,
        given: &[Array<R>],
        made: &mut [&mut [R]],
    ) -> PyResult<()> {
        let simulator = self.simulator.get();
        let Some((inputs, [first, directions @ ..])) = given.split_at_checked(self.arrays.len())
        else {
            return Err(misfit());
        };
        // Positions and velocities have axes for states, nodes and directions.
        let rank = |k: usize| if mode == PULLED { 3 } else { self.arrays[k].1 };
        let own: Vec<_> = (inputs.iter().zip(&self.arrays))
            .map(|(array, (_, rank))| array.robots(*rank))
            .collect();
        let directions_own: Vec<_> = (directions.iter().take(self.arrays.len()).enumerate())
            .map(|(k, array)| array.robots(rank(k)))
            .collect();
        let robots = own.iter().chain(&directions_own).flatten().copied();
        let robots = robots.chain(first.robots(0)).max().unwrap_or(1);
        if robots == 0 {
            return Ok(());
        }
        let arrays = |given: &[Array<R>], own: &[Option<usize>]| {
            let arrays = given.iter().zip(own);
            Arrays::new(arrays.map(|(array, own)| (array.numbers.to_vec(), own.unwrap_or(1))))
        };
        let span = Span {
            first: self.first(first.numbers)?,
            ..self.span.clone()
        };
        let span = match mode {
            PULLED => simulator.backwards(span, self.bounded),
            _ => span,
        };
        let asked = Asked::new(&simulator.kind, arrays(inputs, &own), robots, span)?;
        let products = match (mode, directions, &mut *made) {
            (STATES, [], [x, v]) => {
                if let (_, Some(interrupt)) = asked.filled([x, v])? {
                    return Err(interrupt);
                }
                return Ok(());
            }
            (PUSHED, [tangents @ .., _], [_, _]) if tangents.len() == inputs.len() => {
                asked.pushed(&arrays(tangents, &directions_own))?
            }
            (PULLED, [x, v], [.., by_first]) => {
                by_first.fill(R::zero());
                asked.pulled([x.numbers, v.numbers], by)?
            }
            _ => return Err(misfit()),
        };
        let made = &mut made[..match mode {
            PULLED => inputs.len(),
            _ => 2,
        }];
        for (robot, (is_absurd, numbers)) in products.iter().enumerate() {
            // The results are the last numbers: derivatives follow the states.
            let mut numbers = &numbers[..];
            for array in made.iter_mut().rev() {
                let length = array.len() / robots;
                let (before, own) = numbers.split_at(numbers.len() - length);
                let place = &mut array[robot * length..][..length];
                match *is_absurd || asked.lost[robot] {
                    true => place.fill(R::lit(f64::NAN)),
                    false => place.copy_from_slice(own),
                }
                numbers = before;
            }
        }
        Ok(())
    }

    /// The number of earlier steps, which is the same for all robots.
    fn first<R: Number>(&self, numbers: &[R]) -> PyResult<usize> {
        let first: f64 = numbers[0].into();
        let is_other = |&number: &R| Into::<f64>::into(number) != first;
        let steps = self.simulator.get().scene.physics.steps;
        let most = steps - self.span.observed.last().copied().unwrap_or(0);
        if numbers.iter().any(is_other) {
            let says = "first: all robots of a batch must have the same number of earlier steps";
            return Err(InputError::new_err(says));
        }
        if !(0.0..=most as f64).contains(&first) {
            let says = format!("first: {first}: expected a whole number, 0 to {most}");
            return Err(InputError::new_err(says));
        }
        Ok(first as usize)
    }
}

fn misfit() -> PyErr {
    InputError::new_err("the arrays of a rollout do not fit its plan")
}
