//! Rollouts from one or several starts (initial states), in SIMD lanes.
//!
//! The starts are divided into groups. A group has one start for each lane of a register, or two starts, or one. The
//! starts of a group run interleaved in one [`Program`](crate::Program).

use std::borrow::Cow;
use std::ops::Range;

use autodiff::internal::lanes;
use autodiff::{Fused, Real};

use super::settings::{Given, Model, Rollout};
use super::sweep::{ForwardRun, Starts};

impl<M: Model + Clone> Rollout<M> {
    /// Runs all steps from one start. Returns the observed states one after the other, or only the chosen
    /// [`entries`](Rollout::entries) of each.
    ///
    /// `start` is the initial state: its parts in the order in which the model declares them. `parameters` has one
    /// slice for each parameter, in the order of declaration. A slice holds an array, a matrix in row-major order, or
    /// the values of a [control](crate::Program::control) step by step.
    ///
    /// On the tape the whole rollout is one fused call, and each observed number is an entry.
    ///
    /// # Panics
    /// - If a length differs from the model's declaration, or there are too few inputs for all steps.
    /// - If an observed step or an entry is out of range, or the observed steps are not in ascending order.
    /// - If a bound is negative or NaN, or [`CotangentBound::every`](crate::CotangentBound::every) is 0.
    /// - On a tape, if the [`Memory`](crate::Memory) budget is too small for a step.
    /// - If the model does not advance a part of its state, or a method of [`Program`](crate::Program) panics.
    #[track_caller]
    pub fn run<R: Real>(&self, start: &[R], parameters: &[&[R]]) -> Vec<R> {
        let inputs: Vec<&[R]> = [&[start], parameters].concat();
        R::fused(Batch::new(self, 1, vec![false; parameters.len()]), &inputs)
    }

    /// Runs a batch of starts. All starts share the matrices; each may have its own values of the other parameters. The
    /// results are bit-identical to those of [`run`](Rollout::run), but faster: starts run together, one per lane, and
    /// share each weight that is read.
    ///
    /// On the tape a batch is also one fused call. The cotangents of the starts and of [`Given::Each`] parameters are
    /// bit-identical to those of `run`. The cotangents of shared parameters are summed over steps and starts in a
    /// different order, so they differ by rounding from a sum over calls of `run`.
    ///
    /// ```
    /// use autodiff::{Real, Var, gradient};
    /// use autodiff_programs::{Given, Kernel, Model, Program, Rollout, kernel};
    ///
    /// /// A mass on a spring, in steps of 0.1 s.
    /// #[derive(Clone, Copy)]
    /// struct Spring;
    ///
    /// #[kernel]
    /// impl Kernel<3, 2> for Spring {
    ///     fn eval<R: Real>(&self, [x, v, stiffness]: [R; 3], _: &[R]) -> [R; 2] {
    ///         let v = v - R::lit(0.1) * stiffness * x;
    ///         [x + R::lit(0.1) * v, v]
    ///     }
    /// }
    ///
    /// impl Model for Spring {
    ///     fn record(&self, program: &mut Program) {
    ///         let stiffness = program.parameter(1);
    ///         let (x, v) = (program.state(1), program.state(1));
    ///         let [x_next, v_next] = program.map(Spring, [x, v, stiffness], &[]);
    ///         program.advance(x, x_next);
    ///         program.advance(v, v_next);
    ///     }
    /// }
    ///
    /// let rollout = Rollout::new(Spring, 8);
    /// let start: &[f64] = &[1.0, 0.0];
    /// let both = rollout.run_batch(&[start; 2], &[Given::Each(&[&[1.0], &[4.0]])]);
    /// let [soft, stiff] = [1.0, 4.0].map(|stiffness| rollout.run(start, &[&[stiffness]]));
    /// assert_eq!(both, [soft, stiff]);
    /// // The sum of both positions, differentiated with respect to a shared stiffness.
    /// let sum = |stiffness: &[Var<f64>]| {
    ///     let [low, high] = [1.0, 2.0].map(|x| [Var::lit(x), Var::lit(0.0)]);
    ///     let ends = rollout.run_batch(&[&low, &high], &[Given::Shared(stiffness)]);
    ///     ends[0][0] + ends[1][0]
    /// };
    /// assert!(gradient(sum, &[1.0])[0] < 0.0);
    /// ```
    ///
    /// # Panics
    /// Like [`run`](Rollout::run). Also if a [`Given::Each`] belongs to a matrix or does not have one slice for each
    /// start.
    #[track_caller]
    pub fn run_batch<R: Real>(&self, starts: &[&[R]], parameters: &[Given<R>]) -> Vec<Vec<R>> {
        if starts.is_empty() {
            return Vec::new();
        }
        let (inputs, own) = flattened(starts, parameters);
        let seen = R::fused(Batch::new(self, starts.len(), own), &inputs);
        let len = seen.len() / starts.len();
        (0..starts.len())
            .map(|start| seen[start * len..][..len].to_vec())
            .collect()
    }
}

/// Returns the inputs of [`Batch`], and for each parameter whether each start has its own values.
#[track_caller]
fn flattened<'a, R: Real>(
    starts: &[&'a [R]],
    parameters: &[Given<'a, R>],
) -> (Vec<&'a [R]>, Vec<bool>) {
    let (mut inputs, mut own) = (starts.to_vec(), Vec::new());
    assert_one_length(starts);
    for parameter in parameters {
        match parameter {
            Given::Shared(given) => inputs.push(given),
            Given::Each(given) => {
                assert_eq!(
                    given.len(),
                    starts.len(),
                    "Given::Each must have one slice for each start"
                );
                assert_one_length(given);
                inputs.extend(*given);
            }
        }
        own.push(matches!(parameter, Given::Each(_)));
    }
    (inputs, own)
}

/// # Panics
/// If the slices of the starts differ in length.
#[track_caller]
fn assert_one_length<R>(of_starts: &[&[R]]) {
    let len = of_starts.first().map_or(0, |first| first.len());
    for own in of_starts {
        assert_eq!(
            own.len(),
            len,
            "all starts of a batch must have the same length, and so must a parameter of which each start has its own \
             values: the first start has {len} numbers, but another has {}",
            own.len()
        );
    }
}

/// A batch of rollouts as a fused function. The inputs are the starts, followed by each parameter: one slice that all
/// starts share, or one slice for each start. The outputs are the observed states, one start after the other.
///
/// It does not know the type of its model, so that its code is not compiled again for every model.
struct Batch {
    model: Box<dyn Model>,
    rollout: Rollout<()>,
    starts: usize,
    /// For each parameter, whether each start (initial state) has its own values for it.
    own: Vec<bool>,
}

impl Fused for Batch {
    const SOURCES: &str = crate::SOURCES;
    type Saved<R: Real> = Vec<(StartGroup, ForwardRun<R>)>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        self.run(inputs, false).0
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>) {
        self.run(inputs, true)
    }

    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        self.pulled_back(saved, y_bar, wanted)
    }
}

/// A group of starts that run interleaved, one in each lane. A group has as many lanes as a register, or two, or one.
/// If there are fewer starts than lanes, the last start is repeated.
#[derive(Clone)]
pub(super) struct StartGroup {
    pub(super) starts: Range<usize>,
    pub(super) lanes: usize,
}

impl StartGroup {
    /// Interleaves the numbers of all lanes. A lane with fewer numbers than the others is filled with zeros.
    fn interleaved<'a, R: Real>(&self, of_lane: impl Fn(usize) -> &'a [R]) -> Vec<R> {
        let mut interleaved = vec![R::zero(); of_lane(0).len() * self.lanes];
        for lane in 0..self.lanes {
            let places = interleaved.iter_mut().skip(lane).step_by(self.lanes);
            for (place, &number) in places.zip(of_lane(lane)) {
                *place = number;
            }
        }
        interleaved
    }

    /// Takes from `of_starts`, which has one slice for each start of the batch, the slices of this group's starts, and
    /// interleaves them.
    fn own<R: Real>(&self, of_starts: &[&[R]]) -> Vec<R> {
        let of_starts = &of_starts[self.starts.clone()];
        self.interleaved(|lane| of_starts[lane.min(of_starts.len() - 1)])
    }

    /// Splits interleaved numbers into one list for each start.
    fn parted<R: Real>(&self, interleaved: &[R]) -> Vec<Vec<R>> {
        let of_lane = |lane| interleaved.iter().skip(lane).step_by(self.lanes).copied();
        (0..self.starts.len())
            .map(|lane| of_lane(lane).collect())
            .collect()
    }
}

/// Divides the starts into groups of one start per lane. If the remaining starts fill more than three quarters of
/// the lanes, they also run as such a group, because this is faster than pairs. Otherwise they run in pairs, and
/// the last one possibly alone.
pub(super) fn groups<R: Real>(all: usize) -> Vec<StartGroup> {
    let (mut groups, mut first) = (Vec::new(), 0);
    let widest = lanes::<R>();
    while first < all {
        let left = all - first;
        let lanes = match left {
            1 => 1,
            _ if 4 * left > 3 * widest => widest,
            _ => 2,
        };
        let starts = first..first + lanes.min(left);
        first = starts.end;
        groups.push(StartGroup { starts, lanes });
    }
    groups
}

impl Batch {
    fn new<M: Model + Clone>(rollout: &Rollout<M>, starts: usize, own: Vec<bool>) -> Self {
        Self {
            model: Box::new(rollout.model.clone()),
            rollout: rollout.without_model(),
            starts,
            own,
        }
    }

    /// Divides a list with one item for each input into parts, one for each parameter. The part of a shared parameter
    /// is one item; the part of any other parameter is one item for each start.
    fn by_parameter<'a, T>(&self, of_inputs: &'a [T]) -> Vec<&'a [T]> {
        let mut rest = &of_inputs[self.starts..];
        let mut take = |&own: &bool| {
            let (here, others) = rest.split_at(if own { self.starts } else { 1 });
            rest = others;
            here
        };
        self.own.iter().map(&mut take).collect()
    }

    /// Returns the inputs of a group of starts: the interleaved starts, then one slice for each parameter.
    fn inputs_of<'a, R: Real>(
        &self,
        group: &StartGroup,
        inputs: &'a [&'a [R]],
    ) -> Vec<Cow<'a, [R]>> {
        let parameters = self.by_parameter(inputs).into_iter().zip(&self.own);
        let parameter = |(given, &own): (&'a [&'a [R]], &bool)| {
            if own {
                Cow::Owned(group.own(given))
            } else {
                Cow::Borrowed(given[0])
            }
        };
        let start = Cow::Owned(group.own(&inputs[..self.starts]));
        std::iter::once(start)
            .chain(parameters.map(parameter))
            .collect()
    }

    /// Runs all groups. Returns the observed states and, if `keeps` is true, what the reverse sweep needs.
    #[track_caller]
    fn run<R: Real>(
        &self,
        inputs: &[&[R]],
        keeps: bool,
    ) -> (Vec<R>, Vec<(StartGroup, ForwardRun<R>)>) {
        let (mut seen, mut saved) = (Vec::new(), Vec::new());
        for group in groups::<R>(self.starts) {
            let inputs = self.inputs_of(&group, inputs);
            let inputs: Vec<&[R]> = inputs.iter().map(|input| &input[..]).collect();
            let starts = Starts {
                count: group.lanes,
                own: &self.own,
            };
            let (of_group, run) = (self.rollout).recorded(&*self.model, starts, &inputs, keeps);
            seen.extend(group.parted(&of_group).concat());
            if keeps {
                saved.push((group, run));
            }
        }
        (seen, saved)
    }

    /// See [`Fused::reverse`].
    fn pulled_back<R: Real>(
        &self,
        saved: &mut [(StartGroup, ForwardRun<R>)],
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let len = y_bar.len() / self.starts;
        let wanted = self.by_parameter(wanted).into_iter();
        let wanted: Vec<bool> = wanted.map(|any| any.contains(&true)).collect();
        let mut start_bars = Vec::new();
        let mut parameter_bars: Vec<Vec<Vec<R>>> = vec![Vec::new(); self.own.len()];
        for (group, run) in saved {
            let seed = |lane: usize| {
                if lane < group.starts.len() {
                    &y_bar[(group.starts.start + lane) * len..][..len]
                } else {
                    &[]
                }
            };
            let seeds = group.interleaved(seed);
            let x_bars = self.rollout.reversed(group.lanes, run, &seeds, &wanted);
            let (start_bar, bars) = x_bars.split_first().expect("input 0 is the initial state");
            start_bars.extend(group.parted(start_bar));
            for ((bars, bar), &own) in parameter_bars.iter_mut().zip(bars).zip(&self.own) {
                match (own, &mut bars[..]) {
                    (true, _) => bars.extend(group.parted(bar)),
                    (false, []) => bars.push(bar.clone()),
                    (false, [sum, ..]) => {
                        sum.iter_mut().zip(bar).for_each(|(sum, &bar)| *sum += bar);
                    }
                }
            }
        }
        start_bars.extend(parameter_bars.into_iter().flatten());
        start_bars
    }
}
