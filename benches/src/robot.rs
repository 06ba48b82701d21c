//! Rollouts and gradients of a robot, and the memory that they take.

use std::fs;
use std::hint::black_box;

use autodiff::{Memory, Model, Program, Real, Rollout, Var};
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::inputs::{Block, DESIGN, Inputs};
use cosmic::objective::{Displacement, Loss};
use cosmic::projection::Projection;
use cosmic::scene::LossSettings;
use cosmic::task::{Horizon, Task};

/// The number of steps of a measured rollout, unless the case has fewer.
pub const MEASURED_STEPS: usize = 4096;

/// A case prepared for benchmarks: a rollout and its gradients.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    case: &'a Case,
    task: Task,
    inputs: Inputs<f64>,
    loss: Displacement,
    horizon: Horizon,
}

impl<'a> Subject<'a> {
    /// Prepares rollouts of a case. They have [`MEASURED_STEPS`] steps, or fewer if the case has fewer.
    pub fn new(case: &'a Case, loss: &LossSettings) -> Self {
        let task = case.task();
        Self {
            loss: Displacement {
                ground: task.ground(),
                settings: loss.clone(),
            },
            horizon: Horizon::of_steps(MEASURED_STEPS.min(case.scene.physics.steps)),
            inputs: case.inputs(),
            task,
            case,
        }
    }

    /// Returns this case with another memory budget for gradients.
    #[must_use]
    pub fn with_memory(&self, memory: Memory) -> Self {
        let mut other = self.clone();
        other.task = other.task.with_memory(memory);
        other
    }

    /// Computes the loss without its gradient.
    pub fn rollout<R: Real>(&self) -> R {
        let inputs = self.inputs.lift::<R>();
        let design = self.case.projected(self.case.projection, &inputs.z);
        self.task.loss(&design, &inputs, &self.loss, &self.horizon)
    }

    /// Computes the loss and its gradient with respect to some blocks of the inputs, such as [`DESIGN`] or
    /// [`CONTROLLER`](cosmic::inputs::CONTROLLER). A layout has no design vectors; instead, the gradient is with respect
    /// to its mixtures.
    pub fn gradient<R: Real>(&self, blocks: &[Block]) -> (R, Vec<R>) {
        let inputs = self.inputs.lift::<R>();
        inputs.differentiate(blocks, |inputs| {
            let design = self.design(blocks, inputs);
            (self.task).loss(&design, inputs, &self.loss, &self.horizon)
        })
    }

    /// Computes the loss in the performance projection and in the stability projection, each with its gradient with
    /// respect to the design vectors. The two are computed together, as in an optimisation on one thread.
    pub fn two_gradients(&self) -> [(f64, Vec<f64>); 2] {
        let Self { case, task, .. } = self;
        (self.inputs).differentiate_copies(DESIGN, |copies: &[_; 2]| {
            let projections = [Projection::Performance, Projection::Stability];
            let design = |k: usize| case.projected(projections[k], &copies[k].z);
            let designs = [design(0), design(1)];
            let seen = task.over_horizon(&designs, &copies[0], &self.loss, &self.horizon);
            [0, 1].map(|k| self.loss.loss(&seen[k]))
        })
    }

    /// Returns the design for a rollout that is differentiated with respect to some blocks. A layout has no design
    /// vectors, so its mixtures are used instead.
    fn design<R: Real>(
        &self,
        blocks: &[Block],
        inputs: &Inputs<Var<R>>,
    ) -> Design<Mixture<Var<R>>> {
        match self.case.design {
            Design::Layout(_) if blocks.contains(&Block::Z) => Design::of_shares(&inputs.z),
            _ => self.case.projected(self.case.projection, &inputs.z),
        }
    }
}

/// The two products `W2 (W1 x)` with the shapes of a controller: from all positions and velocities to hidden units, and
/// from there to edges.
#[derive(Clone, Copy, Debug)]
pub struct TwoMatvecs {
    inputs: usize,
    hidden: usize,
    edges: usize,
}

impl TwoMatvecs {
    /// Prepares the two matrix-vector products with the shapes of a case's controller.
    pub fn new(case: &Case) -> Self {
        Self {
            inputs: 4 * case.lattice.nodes(),
            hidden: case.scene.controller.hidden,
            edges: case.lattice.edges.len(),
        }
    }

    /// Computes the two matrix-vector products `steps` times. Returns the input vector.
    pub fn run(self, steps: usize) -> Vec<f64> {
        let (inputs, hidden, edges) = (self.inputs, self.hidden, self.edges);
        let rollout = Rollout::new(self, steps);
        let numbers = |count: usize| vec![0.1; count];
        let parameters = [hidden * inputs, hidden, edges * hidden, edges].map(numbers);
        rollout.run(&numbers(inputs), &parameters.each_ref().map(Vec::as_slice))
    }
}

impl Model for TwoMatvecs {
    fn record(&self, p: &mut Program) {
        let (first, biases) = (p.matrix(self.hidden, self.inputs), p.parameter(self.hidden));
        let (second, outputs) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let x = p.state(self.inputs);
        let hidden = p.dense(first, &[x], biases);
        p.dense(second, &[hidden], outputs);
        p.advance(x, x);
    }
}

/// Does a piece of work. Returns the largest amount of additional memory that the process held meanwhile, in bytes, if the
/// system tells. Do not trust sizes below a MiB: the system counts whole pages, and with a delay.
pub fn memory_of<T: Send>(work: impl FnOnce() -> T + Send) -> Option<u64> {
    let measure = || {
        let _ballast = ballast();
        let before = memory("VmRSS:").filter(|_| forget_peak());
        black_box(work());
        before.and_then(|before| Some(memory("VmHWM:")?.saturating_sub(before)))
    };
    // A new thread has no spare buffers from earlier work.
    std::thread::scope(|scope| {
        let done = scope.spawn(measure).join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Fills the memory that the allocator has kept from earlier work, by allocating blocks. The system already counts that
/// memory for this process. If the measured work used that memory, the work would seem to need less than it does.
fn ballast() -> Vec<Vec<u8>> {
    /// The size of a block. Blocks must be small, because the allocator keeps only small blocks.
    const BLOCK: usize = 64 << 10;
    /// The number of blocks that are allocated in one round. The system updates its count of memory with a delay; after
    /// this many blocks the count is nearly right.
    const BLOCKS: usize = 32;
    /// The largest number of rounds. All rounds together allocate 256 MiB, which is more than allocators keep.
    const ROUNDS: usize = 128;
    let mut blocks = Vec::new();
    for _ in 0..ROUNDS {
        let before = memory("VmRSS:").unwrap_or(0);
        blocks.extend((0..BLOCKS).map(|_| black_box(vec![1u8; BLOCK])));
        let risen = memory("VmRSS:").unwrap_or(u64::MAX).saturating_sub(before);
        // Most of this round's memory came fresh from the system, so the kept memory is used up.
        if risen as usize > BLOCK * BLOCKS / 5 * 4 {
            break;
        }
    }
    blocks
}

/// Reads the size that the system reports for this process under `key`, in bytes; `None` if it reports none.
fn memory(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// Resets the peak memory that the system reports. Returns true on success.
fn forget_peak() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}
