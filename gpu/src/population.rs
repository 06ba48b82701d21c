//! Runs a printed program for many members at once.

use rayon::prelude::*;
use wgpu::{BindGroup, Buffer, ComputePipeline};

use crate::device::{Gpu, GpuError};
use crate::wgsl::{GROUPS_IN_A_ROW, Placed, Printed};

/// A printed program on a device.
pub struct Population {
    gpu: Gpu,
    printed: Printed,
    forward: ComputePipeline,
    reverse: Option<ComputePipeline>,
    /// How many steps one dispatch takes. A driver ends a dispatch that takes seconds.
    pub steps_at_once: usize,
    /// How much memory the states may take, in bytes.
    pub memory: u64,
}

/// The members of a population and their surroundings.
#[derive(Clone, Debug)]
pub struct Members<'a> {
    /// The state of each member at the start, one after the other.
    pub starts: &'a [f32],
    /// The parameters in their order of declaration. A parameter that all members share has its numbers once, the others
    /// have the numbers of each member, one after the other.
    pub parameters: &'a [Vec<f32>],
    /// The number of steps.
    pub steps: usize,
    /// The inputs of all steps, one step after the other.
    pub inputs: &'a [f32],
    /// The numbers of steps, from 1 on, after which the state is observed, ascending.
    pub observed: &'a [usize],
}

/// Members on the device, with the states that a forward sweep stores for a reverse sweep.
pub struct Sweep<'a> {
    population: &'a Population,
    members: usize,
    steps: usize,
    /// The number of observed states.
    count: usize,
    /// A state is stored after every so many steps; 0 if none is.
    every: usize,
    bound: BindGroup,
    plan: Buffer,
    carried: Buffer,
    bars: Buffer,
    seen: Buffer,
}

/// The cotangents that a reverse sweep returns.
#[derive(Clone, Debug)]
pub struct Cotangents {
    /// For each parameter whose cotangents are wanted, those of each member, one after the other; empty for the others.
    pub parameters: Vec<Vec<f32>>,
    /// The cotangents of the states at the start, in the order of the starts.
    pub starts: Vec<f32>,
}

impl Population {
    /// Compiles a program for a device. Unless it `reverses`, only the forward sweep is compiled, which takes less of a
    /// workgroup's memory.
    ///
    /// # Errors
    /// If the program is too large for the device, or its driver refuses it.
    pub fn new(gpu: &Gpu, printed: Printed, reverses: bool) -> Result<Self, GpuError> {
        let count = if reverses { 2 } else { 1 };
        let mut pipelines = gpu.compile(&printed, count)?.into_iter();
        Ok(Self {
            gpu: gpu.clone(),
            printed,
            forward: pipelines.next().expect("the first entry point"),
            reverse: pipelines.next(),
            steps_at_once: gpu.steps_at_once(),
            memory: gpu.memory(),
        })
    }

    /// The largest number of members whose buffers fit the device and the budget of memory. It is at least 1.
    pub fn room(&self, steps: usize, observed: usize, reverses: bool) -> usize {
        let printed = &self.printed;
        let (budget, largest) = (self.memory, self.gpu.largest_buffer());
        let spread = ((steps as f64).sqrt().ceil() as usize).max(2);
        let slots = match reverses {
            true => (steps.div_ceil(spread) + 2 + spread).min(steps + 1),
            false => 1,
        };
        let [own, _, bars] = printed.lengths();
        let buffers = [
            own,
            slots * printed.state(),
            observed * printed.entries(),
            printed.state(),
            if reverses { bars } else { 0 },
            printed.spilled(),
        ];
        let bytes = buffers.map(|numbers| 4 * numbers.max(1) as u64);
        let largest_part = bytes.iter().copied().max().unwrap_or(4);
        let in_a_row = GROUPS_IN_A_ROW as u64 * u64::from(u16::MAX);
        let members = (budget / bytes.iter().sum::<u64>()).min(largest / largest_part);
        members.clamp(1, in_a_row) as usize
    }

    /// The program.
    pub fn printed(&self) -> &Printed {
        &self.printed
    }

    /// Copies all members to the device. With `reverses`, states will be stored for [`Sweep::reverse`].
    ///
    /// # Panics
    /// If a length does not fit the program.
    pub fn prepare(&self, of: &Members, reverses: bool) -> Sweep<'_> {
        let (gpu, printed, state) = (&self.gpu, &self.printed, self.printed.state());
        let members = of.starts.len() / state;
        assert_eq!(
            of.starts.len(),
            members * state,
            "the starts are not whole states"
        );
        let [own, common] = self.packed(of, members);
        let every = if reverses {
            self.every(members, of.steps)
        } else {
            0
        };
        let slots = match every {
            0 => 1,
            1 => of.steps + 1,
            // Behind the stored states, there is room for those of a stretch of steps.
            _ => of.steps.div_ceil(every) + 2 + every,
        };
        let bars = gpu.buffer(if reverses {
            members * printed.lengths()[2]
        } else {
            0
        });
        let carried = gpu.buffer(members * state);
        let spilled = gpu.buffer(members * printed.spilled());
        let seen = gpu.buffer(members * of.observed.len() * printed.entries());
        let plan = gpu.plan();
        let [own, common] = [&own, &common].map(|numbers| gpu.filled(numbers));
        let (inputs, table) = (gpu.filled(&self.inputs(of)), gpu.filled(printed.table()));
        let states = gpu.buffer(members * slots * state);
        gpu.write(&states, 0, of.starts);
        let buffers = [
            &plan, &inputs, &table, &own, &common, &states, &carried, &bars, &seen, &spilled,
        ];
        Sweep {
            population: self,
            members,
            steps: of.steps,
            count: of.observed.len(),
            every,
            bound: gpu.bind(buffers),
            plan,
            carried,
            bars,
            seen,
        }
    }

    /// After how many steps a state is stored.
    fn every(&self, members: usize, steps: usize) -> usize {
        let of_state = 4 * (members * self.printed.state()) as u64;
        let most = self.memory.min(self.gpu.largest_buffer()) / of_state.max(1);
        if (steps as u64) < most {
            return 1;
        }
        ((steps as f64).sqrt().ceil() as usize).max(2)
    }

    /// The inputs of every step, each followed by the number of the state that is observed after it.
    fn inputs(&self, of: &Members) -> Vec<f32> {
        let width = self.printed.inputs();
        let mut inputs = Vec::with_capacity(of.steps * (width + 1));
        let mut seen = of.observed.iter().enumerate().peekable();
        for step in 0..of.steps {
            inputs.extend_from_slice(&of.inputs[step * width..][..width]);
            let is_seen = seen.next_if(|(_, after)| **after == step + 1);
            inputs.push(is_seen.map_or(0.0, |(number, _)| (number + 1) as f32));
        }
        assert!(
            seen.next().is_none(),
            "the observed steps must be ascending, from 1 to the number of steps"
        );
        inputs
    }

    /// The numbers of the buffers `own` and `common`.
    fn packed(&self, of: &Members, members: usize) -> [Vec<f32>; 2] {
        let [own, common, _] = self.printed.lengths();
        let (mut each, mut all) = (vec![0.0; members * own], vec![0.0; common]);
        assert_eq!(
            of.parameters.len(),
            self.printed.parameters().len(),
            "the number of parameters"
        );
        let pairs = || self.printed.parameters().iter().zip(of.parameters);
        let mut own_places = Vec::new();
        for (placed, numbers) in pairs() {
            let count = if placed.is_common { 1 } else { members };
            assert_eq!(
                numbers.len(),
                count * placed.len,
                "the numbers of a parameter"
            );
            let copies: [Vec<usize>; 2] =
                [placed.places().collect(), placed.places_of_copy().collect()];
            for places in copies {
                match placed.is_common {
                    true => fill(&mut all, &places, numbers),
                    false => own_places.push((places, placed.len, numbers)),
                }
            }
        }
        // The members take most of the time of a large population.
        let fill_member = |(member, part): (usize, &mut [f32])| {
            for (places, len, numbers) in &own_places {
                fill(part, places, &numbers[member * len..]);
            }
        };
        let parts = each.par_chunks_mut(own.max(1)).enumerate();
        parts.for_each(fill_member);
        [each, all]
    }
}

impl Sweep<'_> {
    /// How many steps a dispatch takes.
    fn steps_at_once(&self) -> usize {
        match self.every {
            0 | 1 => self.population.steps_at_once,
            every => every,
        }
    }

    /// Starts the forward sweep. [`Gpu::wait`] and everything that reads results wait for its end.
    pub fn forward(&self) {
        let at_once = self.steps_at_once();
        for first in (0..self.steps).step_by(at_once) {
            let steps = at_once.min(self.steps - first);
            match self.every {
                // The state takes the place of the one before: the slot after the one before the first is the first.
                0 => self.forward_by([first, steps], [0, usize::MAX], steps, true),
                every => self.forward_by([first, steps], [first / every; 2], every, true),
            }
        }
    }

    fn forward_by(&self, stretch: [usize; 2], slots: [usize; 2], every: usize, observes: bool) {
        self.dispatch(&self.population.forward, stretch, slots, every, observes);
    }

    fn dispatch(
        &self,
        pipeline: &ComputePipeline,
        [first, steps]: [usize; 2],
        [read, write]: [usize; 2],
        every: usize,
        observes: bool,
    ) {
        let gpu = &self.population.gpu;
        let plan = [self.members, first, steps, read, write, every, self.count];
        gpu.write(&self.plan, 0, &plan.map(|number| number as u32));
        gpu.write(&self.plan, plan.len(), &[u32::from(observes)]);
        gpu.start(pipeline, &self.bound, self.members);
    }

    /// The observed numbers: for each member, those of each observed state.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn observed(&self) -> Result<Vec<f32>, GpuError> {
        let population = self.population;
        let numbers = self.members * self.count * population.printed.entries();
        population.gpu.read(&self.seen, numbers)
    }

    /// The members of which a number of a state was not below the bound on states, if the program has one. Only the forward
    /// sweep tells.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn exceeded(&self) -> Result<Vec<bool>, GpuError> {
        let state = self.population.printed.state();
        let marks = (self.population.gpu).read(&self.carried, self.members * state)?;
        let marked = |marks: &[f32]| marks.iter().any(|&mark| mark != 0.0);
        Ok(marks.chunks(state).map(marked).collect())
    }

    /// Starts the reverse sweep from the cotangents of the observed numbers, which are in the order of
    /// [`observed`](Self::observed).
    ///
    /// # Panics
    /// If the members were not prepared for a reverse sweep.
    pub fn reverse(&self, cotangents: &[f32]) {
        assert!(
            self.every > 0,
            "these members were not prepared for a reverse sweep, so no states are stored"
        );
        let (population, gpu) = (self.population, &self.population.gpu);
        gpu.write(&self.seen, 0, cotangents);
        gpu.clear(&[&self.carried, &self.bars]);
        let at_once = self.steps_at_once();
        let stretches = self.steps.div_ceil(at_once);
        for first in (0..stretches).rev().map(|k| k * at_once) {
            let steps = at_once.min(self.steps - first);
            let slots = match self.every {
                1 => [first, first],
                every => {
                    // The states of this stretch are computed again, behind the stored ones.
                    let behind = self.steps.div_ceil(every) + 1;
                    let slots = [first / every, behind];
                    self.forward_by([first, steps], slots, 1, false);
                    slots
                }
            };
            let reverse = population.reverse.as_ref();
            let reverse = reverse.expect("the reverse sweep of this program was not compiled");
            self.dispatch(reverse, [first, steps], slots, 1, false);
        }
    }

    /// The cotangents that the reverse sweep has computed.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn cotangents(&self) -> Result<Cotangents, GpuError> {
        let (population, gpu) = (self.population, &self.population.gpu);
        let printed = &population.printed;
        let all = gpu.read(&self.bars, self.members * printed.lengths()[2])?;
        let of_parameter = |placed: &Placed| {
            let bars: Vec<usize> = placed.bars().collect();
            let parts = all.chunks(printed.lengths()[2].max(1));
            let of_member = |part: &[f32]| bars.iter().map(|&at| part[at]).collect::<Vec<f32>>();
            match bars.is_empty() {
                true => Vec::new(),
                false => parts.flat_map(of_member).collect(),
            }
        };
        Ok(Cotangents {
            parameters: printed.parameters().iter().map(of_parameter).collect(),
            starts: gpu.read(&self.carried, self.members * printed.state())?,
        })
    }
}

/// Writes numbers to their places.
fn fill(to: &mut [f32], places: &[usize], numbers: &[f32]) {
    for (&place, &number) in places.iter().zip(numbers) {
        to[place] = number;
    }
}
