//! The reverse sweep through a rollout: bounds on cotangents, memory that is used again, and stopped rollouts.

use crate::common::largest_difference;
use crate::net::{Loss, NODES};
use crate::steps::{Mapped, Times};
use approx::assert_relative_eq;
use autodiff::{Function, Real, Tape, Var, gradient, value_and_gradient};
use autodiff_programs::{CotangentBound, Kernel, Memory, Rollout, kernel};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

/// Returns the given number of steps, or fewer under Miri, which is slow.
fn steps(all: usize) -> usize {
    if cfg!(miri) { all.min(7) } else { all }
}

#[test]
fn single_precision_gradient_is_single_precise() {
    let loss = Loss::new(steps(20));
    let x = loss.point();
    let (_, double) = value_and_gradient(|x| loss.eval(x), &x);
    let single: Vec<f32> = x.iter().map(|&x| x as f32).collect();
    let single = gradient(|x: &[Var<f32>]| loss.eval(x), &single);
    let single: Vec<f64> = single.into_iter().map(f64::from).collect();
    // The tolerance is for 20 steps with sums of about 20 terms, each rounded to 2^-24.
    assert!(largest_difference(&single, &double) < 1e-5);
}

#[test]
fn constants_get_no_cotangent_and_do_not_disturb_the_rest() {
    let loss = Loss::new(steps(19));
    let x = loss.point();
    let (_, all) = value_and_gradient(|x| loss.eval(x), &x);
    let [k, w, w1, ..] = loss.rollout.model.shapes();
    let weights = 2 * NODES + k + w..2 * NODES + k + w + w1;
    let given = x.clone();
    let only_weights = gradient(
        |part: &[Var<f64>]| {
            let mut whole: Vec<Var<f64>> = given.iter().map(|&x| Var::lit(x)).collect();
            whole[weights.clone()].copy_from_slice(part);
            loss.eval(&whole)
        },
        &x[weights.clone()],
    );
    assert_eq!(only_weights, all[weights.clone()]);
}

/// Returns a bound on the norm of cotangents. The bound is checked every `every` steps.
fn bound(norm: f64, every: usize) -> Option<CotangentBound> {
    Some(CotangentBound { norm, every })
}

#[test]
fn cotangent_bound_holds_back_and_is_off_by_default() {
    let mut loss = Loss::new(steps(30));
    let x = loss.point();
    let (_, exact) = value_and_gradient(|x| loss.eval(x), &x);
    loss.rollout.cotangent_bound = bound(1e9, 3);
    assert_eq!(value_and_gradient(|x| loss.eval(x), &x).1, exact);
    let norm = |gradient: &[f64]| {
        let squares = gradient[..2 * NODES].iter().map(|g| g * g);
        squares.sum::<f64>().sqrt()
    };
    loss.rollout.cotangent_bound = bound(0.5, 1);
    let (_, bounded) = value_and_gradient(|x| loss.eval(x), &x);
    assert_relative_eq!(norm(&bounded), 0.5, max_relative = 1e-12);
    // The bound is checked only at the start. If the norm there is below the bound, nothing must change.
    let free = norm(&exact);
    for limit in [0.9 * free, 1.1 * free] {
        loss.rollout.cotangent_bound = bound(limit, 31);
        let (_, bounded) = value_and_gradient(|x| loss.eval(x), &x);
        assert_relative_eq!(norm(&bounded), free.min(limit), max_relative = 1e-12);
    }
}

/// The norm of an infinite cotangent cannot be computed. The cotangent must then become NaN, and not zero.
#[test]
fn a_cotangent_too_large_to_be_measured_is_told() {
    let mut loss = Loss::new(steps(12));
    let x = loss.point();
    loss.rollout.cotangent_bound = bound(3.0, 4);
    let huge = |x: &[Var<f64>]| loss.eval(x) * Var::lit(f64::INFINITY);
    let gradient = gradient(huge, &x);
    assert!(gradient[..2 * NODES].iter().all(|g| g.is_nan()));
}

/// Returns the cotangents of a batch of starts, given the cotangents of the final states. A bound is checked at the
/// start.
fn bounded<R: Real + Into<f64>>(seeds: &[[f64; 3]], steps: usize, norm: f64) -> Vec<[R; 3]> {
    let rollout = Rollout {
        cotangent_bound: bound(norm, steps + 1),
        ..Rollout::new(Mapped(Times(10.0), 3), steps)
    };
    let gradient = gradient(
        |x: &[Var<R>]| {
            let starts: Vec<&[Var<R>]> = x.chunks(3).collect();
            let seen = rollout.run_batch(&starts, &[]).concat();
            let seeds = seeds.as_flattened().iter();
            let weighted = seen.iter().zip(seeds).map(|(&x, &seed)| x * Var::lit(seed));
            weighted.fold(Var::lit(0.0), |sum, x| sum + x)
        },
        &vec![R::zero(); 3 * seeds.len()],
    );
    gradient.as_chunks().0.to_vec()
}

/// Cotangents of any size must be bounded correctly, even if their squares over- or underflow.
#[test]
fn cotangents_of_any_size_are_bounded() {
    fn check<R: Real + PartialEq + Into<f64>>(sizes: &[f64], digits: f64) {
        for &size in sizes {
            // In units of `size`, the norms are 13, 13 and 0. The fourth cotangent has an ordinary size, so its squares
            // can be computed.
            let seeds = [[3.0, 4.0, 12.0], [-12.0, 3.0, -4.0], [0.0; 3]];
            let mut seeds = seeds.map(|seed| seed.map(|s| s * size)).to_vec();
            seeds.push([0.1; 3]);
            for relative in [1e-3, 1.0] {
                let norm = relative * size;
                for (k, bar) in bounded::<R>(&seeds, 0, norm).iter().enumerate() {
                    let free: f64 = [13.0 * size, 13.0 * size, 0.0, 0.03f64.sqrt()][k];
                    for (&bar, seed) in bar.iter().zip(seeds[k]) {
                        let expected = seed * (norm / free.max(norm));
                        let off = (bar.into() - expected).abs();
                        // The tolerance is for a few roundings.
                        assert!(
                            off <= 4.0 * digits * expected.abs(),
                            "{k} of {size}: {bar:?}"
                        );
                    }
                }
            }
            for (bar, seed) in bounded::<R>(&seeds, 0, 1e3 * size + 1.0).iter().zip(&seeds) {
                assert!(*bar == seed.map(R::lit), "{size}: {bar:?} is held back");
            }
        }
    }
    check::<f64>(&[1e-300, 1e-160, 1.0, 1e100, 1e155, 1e300], f64::EPSILON);
    check::<f32>(&[1e-30, 1e-25, 1.0, 1e15, 1e25, 1e34], f32::EPSILON.into());
    let grown = |bars: Vec<[f64; 3]>| (bars[0][0] - 1.0).abs() < 4.0 * f64::EPSILON;
    assert!(grown(bounded::<f64>(&[[1.0, 0.0, 0.0]], 160, 1.0)));
    let single = bounded::<f32>(&[[1.0, 0.0, 0.0]], 25, 1.0);
    assert!((single[0][0] - 1.0).abs() < 4.0 * f32::EPSILON);
}

/// The bound must act only at the steps where it is checked. Here the cotangent shrinks during the sweep.
#[test]
fn a_cotangent_is_checked_after_so_many_steps() {
    for (every, expected) in [(1, 0.5), (2, 0.5), (3, 1.0), (4, 0.5), (5, 4.0)] {
        let rollout = Rollout {
            cotangent_bound: bound(8.0, every),
            ..Rollout::new(Mapped(Times(0.5), 3), 4)
        };
        let gradient = gradient(|x| rollout.run(x, &[])[0] * Var::lit(64.0), &[1.0; 3]);
        // The numbers are exact, because they are powers of two.
        assert_eq!(gradient, [expected, 0.0, 0.0], "every {every} steps");
    }
}

#[test]
#[should_panic(
    expected = "steps do not fit into memory; set the rollout's `memory` to a smaller budget"
)]
fn more_steps_than_any_memory_keeps_are_refused() {
    let rollout = Rollout::new(Mapped(Times(1.0), 3), 1 << (usize::BITS - 2));
    gradient(|x| rollout.run(x, &[])[0], &[1.0; 3]);
}

/// If no steps or no entries are observed, nothing must be returned, for one start and for several.
#[test]
fn nothing_may_be_observed() {
    let starts = [[1.0, 2.0, 3.0]; 5];
    let starts = starts.each_ref().map(|start| &start[..]);
    let steps = Rollout {
        observed: Vec::new(),
        ..Rollout::new(Mapped(Times(10.0), 3), 3)
    };
    let entries = Rollout {
        entries: Some(Vec::new()),
        ..Rollout::new(Mapped(Times(10.0), 3), 3)
    };
    for rollout in [steps, entries] {
        assert!(rollout.run(starts[0], &[]).is_empty());
        for count in 1..=5 {
            let seen = rollout.run_batch(&starts[..count], &[]);
            assert_eq!(seen, vec![Vec::<f64>::new(); count]);
        }
        let none = |x: &[Var<f64>]| Var::sum_of(&rollout.run_batch(&[x, x, x], &[]).concat());
        assert_eq!(gradient(none, starts[0]), [0.0; 3]);
    }
}

/// If a tape is pulled back a second time, the results must be bit-identical, for every memory budget of its rollout.
#[test]
fn a_second_pullback_has_the_same_bits() {
    let mut loss = Loss::new(steps(40));
    let x = loss.point();
    for memory in [Memory::All, Memory::States(12)] {
        loss.rollout.memory = memory;
        let mut tape = Tape::new();
        let value = tape.record(&x, |x: &[Var<f64>]| loss.eval(x));
        let first = tape.pullback(&[value], &[1.0]).to_vec();
        assert_eq!(first, tape.pullback(&[value], &[1.0]));
    }
}

/// Counts the steps of [`Stopping`].
static COUNTED: AtomicUsize = AtomicUsize::new(0);
/// The flag that [`Stopping`] sets in its tenth step.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Doubles a number, and asks the rollout to stop in the tenth step.
#[derive(Clone, Copy)]
struct Stopping;

#[kernel]
impl Kernel<1, 1> for Stopping {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        if COUNTED.fetch_add(1, Ordering::Relaxed) >= 10 {
            STOP.store(true, Ordering::Relaxed);
        }
        [x + x]
    }
}

/// Once the flag of a rollout is set, the remaining steps are left out, forward and in reverse, and all results are NaN.
#[test]
fn a_rollout_stops_when_its_flag_is_set() {
    let stopping = Rollout {
        stop: Some(Arc::clone(&STOP)),
        ..Rollout::new(Mapped(Stopping, 1), 1_000_000)
    };
    let end: Vec<f64> = stopping.run(&[1.0], &[]);
    assert!(end[0].is_nan(), "{end:?}");
    let counted = COUNTED.load(Ordering::Relaxed);
    // A step may evaluate its kernel in a whole register of lanes, or twice.
    assert!(counted < 100, "{counted} evaluations");
    assert!(gradient(|x: &[Var<f64>]| stopping.run(x, &[])[0], &[1.0])[0].is_nan());

    // A flag that is set between the run and the reverse sweep stops the sweep. A flag that is not set changes nothing.
    let stop: Arc<AtomicBool> = Arc::default();
    let rollout = Rollout {
        stop: Some(Arc::clone(&stop)),
        ..Rollout::new(Mapped(Times(0.5), 3), 20)
    };
    let free = Rollout::new(Mapped(Times(0.5), 3), 20);
    let of = |rollout: &Rollout<Mapped<Times>>, late: bool| {
        let sum = |x: &[Var<f64>]| {
            let seen = rollout.run(x, &[]);
            stop.store(late, Ordering::Relaxed);
            seen[0]
        };
        value_and_gradient(sum, &[1.0; 3])
    };
    assert_eq!(of(&rollout, false), of(&free, false));
    let (value, gradient) = of(&rollout, true);
    assert_eq!(value, of(&free, false).0);
    assert!(gradient.iter().all(|slope| slope.is_nan()), "{gradient:?}");
}

/// A rollout of a state of this length that never changes.
fn still(numbers: usize, steps: usize, state_bound: Option<f64>) -> Rollout<Mapped<Times>> {
    Rollout {
        state_bound,
        ..Rollout::new(Mapped(Times(1.0), numbers), steps)
    }
}

/// One number that exceeds the bound must give NaN, wherever it is and however short the rollout. The start must not be
/// checked.
#[test]
fn every_number_of_every_state_is_looked_at() {
    // Enough numbers for three pairs of the widest registers, and five more.
    let numbers = 6 * 16 + 5;
    for place in 0..numbers {
        let mut start = vec![0.1f32; numbers];
        start[place] = [2.0, -1.0, f32::NAN][place % 3];
        let seen = |steps| still(numbers, steps, Some(1.0)).run(&start, &[]);
        assert!(seen(1).iter().all(|x| x.is_nan()), "{place}");
        assert_eq!(seen(0).iter().filter(|x| x.is_nan()).count(), place % 3 / 2);
    }
    let small = vec![0.999; numbers];
    assert_eq!(still(numbers, 9, Some(1.0)).run(&small, &[]), small);
}
