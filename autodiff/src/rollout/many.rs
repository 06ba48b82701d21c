//! Rollouts from several starts at once, in lanes.
//!
//! As many starts as a register holds run side by side in one [`Program`](crate::Program); what
//! is left over runs alone.

use std::ops::Range;

use super::sweep::Recorded;
use super::{Model, Rollout};
use crate::fused::Fused;
use crate::program::lanes;
use crate::real::Real;

/// A rollout from so many starts, which share all parameters. The inputs are the starts, then the
/// parameters; the outputs the observed states of one start after the other.
#[derive(Clone)]
pub(super) struct Many<M> {
    pub(super) rollout: Rollout<M>,
    pub(super) starts: usize,
}

/// Starts that run side by side, one a lane: a register's, or one alone. Lanes left over repeat
/// the last start.
#[derive(Clone)]
pub(super) struct Group {
    pub(super) starts: Range<usize>,
    pub(super) lanes: usize,
}

impl Group {
    /// What all lanes have, side by side; nothing is zeros.
    fn joined<'a, R: Real>(&self, of_lane: impl Fn(usize) -> &'a [R]) -> Vec<R> {
        let mut joined = vec![R::zero(); of_lane(0).len() * self.lanes];
        for lane in 0..self.lanes {
            let places = joined[lane..].iter_mut().step_by(self.lanes);
            for (place, &number) in places.zip(of_lane(lane)) {
                *place = number;
            }
        }
        joined
    }

    /// The numbers of each start, of those side by side.
    fn parted<R: Real>(&self, side_by_side: &[R]) -> Vec<Vec<R>> {
        let of_lane = |lane: usize| side_by_side[lane..].iter().step_by(self.lanes).copied();
        (0..self.starts.len())
            .map(|lane| of_lane(lane).collect())
            .collect()
    }
}

impl<M: Model> Many<M> {
    /// Half a register's starts cost about as much together as alone.
    pub(super) fn groups<R: Real>(&self) -> Vec<Group> {
        let (mut groups, mut first) = (Vec::new(), 0);
        while first < self.starts {
            let left = self.starts - first;
            let lanes = if 2 * left > lanes::<R>() {
                lanes::<R>()
            } else {
                1
            };
            let starts = first..first + lanes.min(left);
            first = starts.end;
            groups.push(Group { starts, lanes });
        }
        groups
    }

    /// Runs a group's starts with the parameters.
    fn with_inputs<R: Real, T>(
        &self,
        group: &Group,
        inputs: &[&[R]],
        run: impl FnOnce(&[&[R]]) -> T,
    ) -> T {
        let (starts, parameters) = inputs.split_at(self.starts);
        let starts = &starts[group.starts.clone()];
        let len = starts[0].len();
        assert!(
            starts.iter().all(|start| start.len() == len),
            "the starts of a rollout differ in length"
        );
        let start = group.joined(|lane| starts[lane.min(starts.len() - 1)]);
        let inputs = std::iter::once(&start[..]).chain(parameters.iter().copied());
        run(&inputs.collect::<Vec<_>>())
    }
}

impl<M: Model> Fused for Many<M> {
    type Saved<R: Real> = Vec<(Group, Recorded<R>)>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        let mut seen = Vec::new();
        for group in self.groups::<R>() {
            let forward = |inputs: &[&[R]]| self.rollout.forward(group.lanes, inputs);
            let of_group = self.with_inputs(&group, inputs, forward);
            seen.extend(group.parted(&of_group).concat());
        }
        seen
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>) {
        let (mut seen, mut saved) = (Vec::new(), Vec::new());
        for group in self.groups::<R>() {
            let record = |inputs: &[&[R]]| self.rollout.recorded(group.lanes, inputs);
            let (of_group, recorded) = self.with_inputs(&group, inputs, record);
            seen.extend(group.parted(&of_group).concat());
            saved.push((group, recorded));
        }
        (seen, saved)
    }

    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let len = y_bar.len() / self.starts;
        let (mut start_bars, mut parameter_bars) = (Vec::new(), Vec::<Vec<R>>::new());
        for (group, recorded) in saved {
            let seed = |lane: usize| match lane < group.starts.len() {
                true => &y_bar[(group.starts.start + lane) * len..][..len],
                false => &[],
            };
            let seeds = group.joined(seed);
            let back = self
                .rollout
                .back((group.lanes, recorded), &seeds, &wanted[self.starts..]);
            let (start_bar, bars) = back.split_first().expect("a rollout has a start");
            start_bars.extend(group.parted(start_bar));
            match parameter_bars.is_empty() {
                true => parameter_bars = bars.to_vec(),
                false => add(&mut parameter_bars, bars),
            }
        }
        start_bars.extend(parameter_bars);
        start_bars
    }
}

fn add<R: Real>(sums: &mut [Vec<R>], bars: &[Vec<R>]) {
    for (sum, &bar) in sums.iter_mut().flatten().zip(bars.iter().flatten()) {
        *sum += bar;
    }
}
