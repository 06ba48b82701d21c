//! [`Batcher`], which joins the requests of several threads.

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use crate::parallel::Crew;
use crate::simulator::{Trajectory, Wanted};

/// If no request comes for this time, the waiting requests are answered, even if some threads are busy with other work.
/// It is longer than the work of an optimisation between two requests, except at its end.
const PATIENCE: Duration = Duration::from_millis(500);

/// Joins the requests of several threads, so that the device gets all of their robots at once. A thread that makes a
/// request waits until every thread that has a [`Client`] has made one. The results do not depend on which requests were
/// joined.
pub struct Batcher {
    device: Arc<dyn Populations>,
    state: Mutex<Waiting>,
    changed: Condvar,
}

/// The waiting requests, and the answers that their threads have not taken yet.
struct Waiting {
    /// The number of threads that may make requests.
    clients: usize,
    /// True while a thread asks the device.
    is_busy: bool,
    /// The number of the next request.
    next: usize,
    /// The requests with their numbers.
    asked: Vec<(usize, Request)>,
    /// When the last request came, or when the device gave its last answer.
    last: Instant,
    answers: HashMap<usize, Result<Answer, Refused>>,
}

enum Request {
    Rollouts(Vec<Batch>),
    Gradients(Vec<GradientBatch>),
}

enum Answer {
    Rollouts(Vec<Vec<Trajectory<f64>>>),
    Gradients(Vec<Vec<RobotGradient>>),
}

/// A device whose requests go through a [`Batcher`]. Dropping it tells the batcher that its thread makes no more requests.
pub struct Client(Arc<Batcher>);

impl Batcher {
    fn new(device: Arc<dyn Populations>, clients: usize) -> Arc<Self> {
        let state = Waiting {
            clients,
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

    /// Makes a batcher for the jobs that this crew does at the same time; `None` without a device.
    pub fn of(device: &Option<Arc<dyn Populations>>, crew: Crew) -> Option<Arc<Self>> {
        Some(Self::new(device.clone()?, crew.at_work))
    }

    /// Returns the device for job number `job` of this crew. [`of`](Self::of) has already counted the jobs that begin at
    /// once; later jobs are counted here.
    pub fn client(
        batcher: &Option<Arc<Self>>,
        job: usize,
        crew: Crew,
    ) -> Option<Arc<dyn Populations>> {
        let batcher = batcher.as_ref()?;
        if job >= crew.at_work {
            batcher.state().clients += 1;
        }
        Some(Arc::new(Client(Arc::clone(batcher))))
    }

    fn leave(&self) {
        let mut state = self.state();
        state.clients = state.clients.saturating_sub(1);
        self.changed.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, Waiting> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a request and waits for the answer.
    fn ask(&self, request: Request) -> Result<Answer, Refused> {
        let mut state = self.state();
        let own = state.next;
        state.next += 1;
        state.asked.push((own, request));
        state.last = Instant::now();
        loop {
            if let Some(answer) = state.answers.remove(&own) {
                return answer;
            }
            let waits = state.asked.len();
            let is_due = waits >= state.clients || state.last.elapsed() >= PATIENCE;
            if !state.is_busy && waits > 0 && is_due {
                state.is_busy = true;
                let asked = std::mem::take(&mut state.asked);
                drop(state);
                let answers = self.answers(asked);
                state = self.state();
                state.is_busy = false;
                // Gives the answered threads time to join the threads that made requests in the meantime.
                state.last = Instant::now();
                state.answers.extend(answers);
                self.changed.notify_all();
                continue;
            }
            let waited = self.changed.wait_timeout(state, PATIENCE);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Lets the device compute all requested rollouts, and all requested gradients.
    fn answers(&self, asked: Vec<(usize, Request)>) -> Vec<(usize, Result<Answer, Refused>)> {
        let numbers: Vec<usize> = asked.iter().map(|(number, _)| *number).collect();
        // A new thread is needed: while a thread of a pool waits for another pool, it runs jobs of its own pool. Such a job
        // could make a request and wait for this answer, which would never come.
        let answers = thread::scope(|scope| scope.spawn(|| self.answered(asked)).join());
        // If the device panics, the other threads must not wait for ever.
        let panicked = |_| {
            let says = "it stopped with an error of its own".to_owned();
            let refused = |number| (number, Err(says.clone()));
            numbers.into_iter().map(refused).collect()
        };
        answers.unwrap_or_else(panicked)
    }

    fn answered(&self, asked: Vec<(usize, Request)>) -> Vec<(usize, Result<Answer, Refused>)> {
        let (mut rollouts, mut slopes) = (Joined::default(), Joined::default());
        for (number, request) in asked {
            match request {
                Request::Rollouts(asked) => rollouts.add(number, asked),
                Request::Gradients(asked) => slopes.add(number, asked),
            }
        }
        let mut answers = rollouts.answered(|asked| self.device.rollouts(asked), Answer::Rollouts);
        answers.extend(slopes.answered(|asked| self.device.gradients(asked), Answer::Gradients));
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
        match self.0.ask(Request::Rollouts(asked.to_vec()))? {
            Answer::Rollouts(all) => Ok(all),
            Answer::Gradients(_) => unreachable!("an answer is of the kind of its request"),
        }
    }

    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused> {
        match self.0.ask(Request::Gradients(asked.to_vec()))? {
            Answer::Gradients(all) => Ok(all),
            Answer::Rollouts(_) => unreachable!("an answer is of the kind of its request"),
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.0.leave();
    }
}
