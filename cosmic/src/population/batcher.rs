//! [`Batcher`], which joins what several threads ask for at the same time.

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use crate::parallel::Crew;
use crate::simulator::{Trajectory, Wanted};

/// After this time without a new request, those that wait are answered, even if some threads compute something else. It
/// is longer than the work between two requests of an optimisation, except at its end.
const PATIENCE: Duration = Duration::from_millis(500);

/// Joins the requests of several threads to one population. A thread that asks waits until all threads with a
/// [`Client`] have asked too; the last one asks the device for all. A result does not depend on which threads were joined.
pub struct Batcher {
    device: Arc<dyn Populations>,
    state: Mutex<Waiting>,
    changed: Condvar,
}

/// The requests that wait, and the answers that were not taken yet.
struct Waiting {
    /// The number of threads that may ask.
    seats: usize,
    /// True while a thread asks the device.
    is_busy: bool,
    /// The number of the next request.
    next: usize,
    asked: Vec<(usize, Question)>,
    last: Instant,
    answers: HashMap<usize, Result<Answer, Refused>>,
}

enum Question {
    Rollouts(Vec<Batch>),
    Slopes(Vec<GradientBatch>),
}

enum Answer {
    Rollouts(Vec<Vec<Trajectory<f64>>>),
    Slopes(Vec<Vec<RobotGradient>>),
}

/// The place of a thread in a batcher. The others no longer wait for the thread after it is dropped.
pub struct Client(Arc<Batcher>);

impl Batcher {
    fn new(device: Arc<dyn Populations>, seats: usize) -> Arc<Self> {
        let state = Waiting {
            seats,
            is_busy: false,
            next: 0,
            asked: Vec::new(),
            last: Instant::now(),
            answers: HashMap::new(),
        };
        Arc::new(Self {
            device,
            state: Mutex::new(state),
            changed: Condvar::new(),
        })
    }

    /// A batcher with a seat for each job that this crew does at the same time; `None` without a device.
    pub fn of(device: &Option<Arc<dyn Populations>>, crew: Crew) -> Option<Arc<Self>> {
        Some(Self::new(device.clone()?, crew.at_work))
    }

    /// The seat of job number `job` of this crew. The first jobs take the seats that are there; each later job brings
    /// its own.
    pub fn client(
        batcher: &Option<Arc<Self>>,
        job: usize,
        crew: Crew,
    ) -> Option<Arc<dyn Populations>> {
        let batcher = batcher.as_ref()?;
        if job >= crew.at_work {
            batcher.state().seats += 1;
        }
        Some(Arc::new(Client(Arc::clone(batcher))))
    }

    fn leave(&self) {
        let mut state = self.state();
        state.seats = state.seats.saturating_sub(1);
        self.changed.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, Waiting> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks and waits for the answer.
    fn ask(&self, question: Question) -> Result<Answer, Refused> {
        let mut state = self.state();
        let own = state.next;
        state.next += 1;
        state.asked.push((own, question));
        state.last = Instant::now();
        loop {
            if let Some(answer) = state.answers.remove(&own) {
                return answer;
            }
            let waits = state.asked.len();
            let is_due = waits >= state.seats || state.last.elapsed() >= PATIENCE;
            if !state.is_busy && waits > 0 && is_due {
                state.is_busy = true;
                let asked = std::mem::take(&mut state.asked);
                drop(state);
                let answers = self.answers(asked);
                state = self.state();
                state.is_busy = false;
                // The others get time to ask again, so that all are joined again.
                state.last = Instant::now();
                state.answers.extend(answers);
                self.changed.notify_all();
                continue;
            }
            let waited = self.changed.wait_timeout(state, PATIENCE);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Asks the device for all rollouts, and for all slopes.
    fn answers(&self, asked: Vec<(usize, Question)>) -> Vec<(usize, Result<Answer, Refused>)> {
        let numbers: Vec<usize> = asked.iter().map(|(number, _)| *number).collect();
        // On a thread of its own: a thread of a pool that waits for the device could take up work of its pool, which would
        // then wait for this answer.
        let answers = thread::scope(|scope| scope.spawn(|| self.answered(asked)).join());
        // The others must not wait for ever if the device panics.
        let panicked = |_| {
            let says = "it stopped with an error of its own".to_owned();
            let refused = |number| (number, Err(says.clone()));
            numbers.into_iter().map(refused).collect()
        };
        answers.unwrap_or_else(panicked)
    }

    fn answered(&self, asked: Vec<(usize, Question)>) -> Vec<(usize, Result<Answer, Refused>)> {
        let (mut rollouts, mut slopes) = (Joined::default(), Joined::default());
        for (number, question) in asked {
            match question {
                Question::Rollouts(asked) => rollouts.add(number, asked),
                Question::Slopes(asked) => slopes.add(number, asked),
            }
        }
        let mut answers = rollouts.answered(|asked| self.device.rollouts(asked), Answer::Rollouts);
        answers.extend(slopes.answered(|asked| self.device.gradients(asked), Answer::Slopes));
        answers
    }
}

/// Requests of one kind, with the number and the length of each.
struct Joined<T> {
    asked: Vec<T>,
    parts: Vec<(usize, usize)>,
}

impl<T> Default for Joined<T> {
    fn default() -> Self {
        Self {
            asked: Vec::new(),
            parts: Vec::new(),
        }
    }
}

impl<T> Joined<T> {
    fn add(&mut self, number: usize, asked: Vec<T>) {
        self.parts.push((number, asked.len()));
        self.asked.extend(asked);
    }

    /// Answers all requests with one call.
    fn answered<A>(
        self,
        ask: impl FnOnce(&[T]) -> Result<Vec<A>, Refused>,
        answer: impl Fn(Vec<A>) -> Answer,
    ) -> Vec<(usize, Result<Answer, Refused>)> {
        if self.parts.is_empty() {
            return Vec::new();
        }
        let parts = self.parts.into_iter();
        match ask(&self.asked) {
            Ok(all) => {
                let mut all = all.into_iter();
                let part = |(number, len)| {
                    let own = all.by_ref().take(len).collect();
                    (number, Ok(answer(own)))
                };
                parts.map(part).collect()
            }
            Err(error) => parts
                .map(|(number, _)| (number, Err(error.clone())))
                .collect(),
        }
    }
}

impl Populations for Client {
    fn name(&self) -> String {
        self.0.device.name()
    }

    fn check(&self, asked: &Batch, by: Option<Wanted>) -> Result<(), Refused> {
        self.0.device.check(asked, by)
    }

    fn rollouts(&self, asked: &[Batch]) -> Result<Vec<Vec<Trajectory<f64>>>, Refused> {
        match self.0.ask(Question::Rollouts(asked.to_vec()))? {
            Answer::Rollouts(all) => Ok(all),
            Answer::Slopes(_) => unreachable!("an answer is of the kind of its question"),
        }
    }

    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused> {
        match self.0.ask(Question::Slopes(asked.to_vec()))? {
            Answer::Slopes(all) => Ok(all),
            Answer::Rollouts(_) => unreachable!("an answer is of the kind of its question"),
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.0.leave();
    }
}
