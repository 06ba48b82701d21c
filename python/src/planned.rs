//! Rollouts that JAX has compiled.

use crate::arrays::Number;
use crate::asked::Asked;
use crate::errors::{InputError, caught};
use crate::simulator::{Simulator, span};
use cosmic::simulator::Span;
use pyo3::prelude::*;
use std::borrow::Cow;
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
        first: usize,
        bounded: bool,
        arrays: Vec<(String, usize)>,
    ) -> PyResult<Self> {
        caught(|| {
            let id = NEXT.fetch_add(1, Ordering::Relaxed);
            let plan = Plan {
                simulator,
                span: span(observed, first),
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

/// Runs the rollouts of a plan (mode 0), their derivatives in a direction (1) or their gradients (2), and writes the results
/// into the arrays `made`. The arrays `given` are those of the plan, and in mode 1 those of the direction, in mode 2 the
/// cotangents. `by` chooses the gradients, as in [`Simulator::pulled`]. The thread must not have the interpreter's
/// lock.
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
        let Some((inputs, others)) = given.split_at_checked(self.arrays.len()) else {
            return Err(misfit());
        };
        // Positions and velocities have axes for states, nodes and directions.
        let rank = |k: usize| if mode == 2 { 3 } else { self.arrays[k].1 };
        let own: Vec<_> = (inputs.iter().zip(&self.arrays))
            .map(|(array, (_, rank))| array.robots(*rank))
            .collect();
        let others_own: Vec<_> = (others.iter().take(self.arrays.len()).enumerate())
            .map(|(k, array)| array.robots(rank(k)))
            .collect();
        let robots = own.iter().chain(&others_own).flatten().copied().max();
        let robots = robots.unwrap_or(1);
        if robots == 0 {
            return Ok(());
        }
        let count = |own: &[Option<usize>]| -> Vec<usize> {
            own.iter().map(|own| own.unwrap_or(1)).collect()
        };
        let (inputs, lost) = self.finite(inputs, &own, robots);
        let numbers: Vec<&[R]> = inputs.iter().map(|array| &**array).collect();
        let z = self.arrays.iter().position(|(name, _)| name == "z");
        let projection = z.map_or(Ok("none"), |z| simulator.projection_of(numbers[z], &lost))?;
        let sizes = &simulator.sizes;
        let span = match mode {
            2 => simulator.backwards(self.span.clone(), self.bounded),
            _ => self.span.clone(),
        };
        let asked = Asked::of(sizes, &numbers, &count(&own), robots, span, projection);
        let products = match (mode, others, &mut *made) {
            (0, [], [x, v]) => {
                if let (_, Some(interrupt)) = simulator.filled(&asked, [x, v])? {
                    return Err(interrupt);
                }
                Vec::new()
            }
            (1, tangents, [_, _]) if tangents.len() == numbers.len() => {
                let numbers: Vec<&[R]> = tangents.iter().map(|array| array.numbers).collect();
                let counts = count(&others_own);
                let along = Asked::of(sizes, &numbers, &counts, robots, self.span.clone(), "none");
                simulator.pushed(&asked, &along)?
            }
            (2, [x, v], _) => simulator.pulled(&asked, [x.numbers, v.numbers], by)?,
            _ => return Err(misfit()),
        };
        for (robot, is_lost) in lost.into_iter().enumerate() {
            let (is_absurd, mut numbers) = match products.get(robot) {
                Some((is_absurd, numbers)) => (*is_absurd, &numbers[..]),
                None => (false, &[][..]),
            };
            // The results are the last numbers: derivatives follow the states.
            for array in made.iter_mut().rev() {
                let length = array.len() / robots;
                let place = &mut array[robot * length..][..length];
                if is_lost || is_absurd {
                    place.fill(R::lit(f64::NAN));
                } else if mode > 0 {
                    let (before, own) = numbers.split_at(numbers.len() - length);
                    place.copy_from_slice(own);
                    numbers = before;
                }
            }
        }
        Ok(())
    }

    /// Replaces numbers that are not finite by 0, and such rows of `z` by void. Returns the numbers of each array, and
    /// which robots are lost, because they had such numbers. `own` has the number of robots of each array.
    fn finite<'a, R: Number>(
        &self,
        arrays: &[Array<'a, R>],
        own: &[Option<usize>],
        robots: usize,
    ) -> (Vec<Cow<'a, [R]>>, Vec<bool>) {
        let is_finite = |number: &R| Into::<f64>::into(*number).is_finite();
        let mut lost = vec![false; robots];
        let mut cleaned = Vec::new();
        for ((array, own), (name, _)) in arrays.iter().zip(own).zip(&self.arrays) {
            let mut numbers = Cow::Borrowed(array.numbers);
            if !array.numbers.iter().all(is_finite) {
                let length = array.numbers.len() / own.unwrap_or(1);
                for (robot, part) in array.numbers.chunks(length).enumerate() {
                    match part.iter().all(is_finite) {
                        true => {}
                        false if own.is_none() => lost.fill(true),
                        false => lost[robot] = true,
                    }
                }
                let numbers = numbers.to_mut();
                if name == "z" {
                    let rows = numbers.as_chunks_mut().0.iter_mut();
                    let rows = rows.filter(|row: &&mut [R; 3]| !row.iter().all(is_finite));
                    rows.for_each(|row| *row = [R::one(), R::zero(), R::zero()]);
                }
                let others = numbers.iter_mut().filter(|number| !is_finite(number));
                others.for_each(|number| *number = R::zero());
            }
            cleaned.push(numbers);
        }
        (cleaned, lost)
    }
}

fn misfit() -> PyErr {
    InputError::new_err("the arrays of a rollout do not fit its plan")
}
