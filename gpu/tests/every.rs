//! A program with every operation, on a device and on the processor.

use std::sync::Arc;

use crate::device::gpu;
use crate::program::Every;
use autodiff::{Tape, Var};
use autodiff_programs::{CotangentBound, Rollout};
use cosmic_gpu::wgsl::{Options, Placed, print};
use cosmic_gpu::{Gpu, Members, Population};

const MEMBERS: usize = 3;
const STEPS: usize = 50;
/// The numbers in a state.
const STATE: usize = 10;
/// The number of parameters.
const PARAMETERS: usize = 8;
/// The parameters that all members share.
const COMMON: [usize; 2] = [4, 5];
/// The bound on cotangents is below half of the norms that occur, so that it acts in every stretch.
const NORM: f64 = 0.05;

/// Numbers that are the same in every run, from -1 to 1.
fn numbers(count: usize, salt: usize) -> Vec<f32> {
    (0..count)
        .map(|k| ((k * 37 + salt * 101) as f32 * 0.7).sin())
        .collect()
}

#[test]
fn a_device_computes_what_the_processor_does() {
    let Some(gpu) = gpu() else { return };
    println!("on {}", gpu.adapter().name);
    let bound = Some(CotangentBound {
        norm: NORM,
        every: 7,
    });
    let units: Arc<[f64]> = (0..10).map(|k| 1.0 + 0.3 * f64::from(k)).collect();
    for (workgroup, kept, memory, cotangent_bound, cotangent_units) in [
        (64, 4, 1 << 30, None, None),
        (4, 3, 1 << 30, bound, None),
        (32, 1, 2000, bound, Some(units)),
    ] {
        let rollout = Rollout {
            cotangent_bound,
            cotangent_units: cotangent_units.clone(),
            inputs: numbers(2 * STEPS, 2).into_iter().map(f64::from).collect(),
            observed: vec![10, 11, 50],
            ..Rollout::new(Every::new(), STEPS)
        };
        let options = Options {
            workgroup,
            kept,
            cotangent_bound,
            cotangent_units,
            // No number of a state reaches it.
            state_bound: Some(1e6),
            common: COMMON.to_vec(),
            wanted: (0..PARAMETERS).collect(),
            ..Options::default()
        };
        compare(&gpu, &rollout, &options, memory);
    }
}

/// Compares a rollout on the device, whose states may take this much memory, with the same rollout on the processor.
fn compare(gpu: &Gpu, rollout: &Rollout<Every>, options: &Options, memory: u64) {
    let printed = print(&rollout.model, options).unwrap();
    let compiled = Population::new(gpu, printed, true);
    let mut population = compiled.unwrap_or_else(|error| panic!("{error}"));
    population.memory = memory;
    population.steps_at_once = 16;
    let placed = population.printed().parameters().to_vec();
    let drawn = |(k, placed): (usize, &Placed)| {
        let count = if placed.is_common { 1 } else { MEMBERS };
        let all = numbers(count * placed.len, 3 + k).into_iter();
        // Parameter 3 has weights, which must be positive.
        all.map(|x| if k == 3 { x.abs() + 0.1 } else { x })
            .collect()
    };
    let parameters: Vec<Vec<f32>> = placed.iter().enumerate().map(drawn).collect();
    let starts = numbers(MEMBERS * STATE, 1);
    let of = Members {
        starts: &starts,
        parameters: &parameters,
        steps: STEPS,
        inputs: &numbers(2 * STEPS, 2),
        observed: &rollout.observed,
    };
    let sweep = population.prepare(&of, true);
    sweep.forward();
    let seen = sweep.observed().unwrap();
    let cotangents = numbers(seen.len(), 20);
    sweep.reverse(&cotangents);
    let bars = sweep.cotangents().unwrap();
    // Without a reverse sweep, no states are stored; the numbers stay the same, and so they do in another run.
    let again = population.prepare(&of, false);
    again.forward();
    assert_eq!(again.observed().unwrap(), seen);
    assert_eq!(again.exceeded().unwrap(), [false; MEMBERS]);

    for m in 0..MEMBERS {
        let own = |k: usize| {
            let at = if placed[k].is_common { 0 } else { m };
            &parameters[k][at * placed[k].len..][..placed[k].len]
        };
        let lists: Vec<&[f32]> = (0..PARAMETERS).map(own).collect();
        let start = &starts[STATE * m..][..STATE];
        let count = seen.len() / MEMBERS;
        let (seen, cotangents) = (&seen[count * m..], &cotangents[count * m..][..count]);
        let (values, expected) = on_processor(rollout, start, &lists, cotangents);
        close("observed", &seen[..count], &values);
        let of_start = &bars.starts[STATE * m..][..STATE];
        close("starts", of_start, &expected[0]);
        // Without the bound, the cotangent of every start is larger.
        let unit = |k: usize| rollout.cotangent_units.as_ref().map_or(1.0, |all| all[k]);
        let scaled = of_start.iter().enumerate();
        let squares = scaled.map(|(k, &x)| (f64::from(x) / unit(k)).powi(2));
        let norm = squares.sum::<f64>().sqrt();
        let is_bounded = rollout.cotangent_bound.is_some();
        assert_eq!(norm < 1.001 * NORM, is_bounded, "{norm}");
        for k in 0..PARAMETERS {
            let found = &bars.parameters[k][m * placed[k].len..][..placed[k].len];
            close(&format!("parameter {k}"), found, &expected[1 + k]);
        }
    }
}

/// The observed numbers, and their cotangents pulled back to the start and to the parameters.
fn on_processor(
    rollout: &Rollout<Every>,
    start: &[f32],
    parameters: &[&[f32]],
    cotangents: &[f32],
) -> (Vec<f32>, Vec<Vec<f32>>) {
    let lists = [&[start][..], parameters].concat();
    let mut tape = Tape::new();
    let y = tape.record(&lists.concat(), |mut x: &[Var<f32>]| {
        let parts = lists.iter().map(|list| {
            let (part, rest) = x.split_at(list.len());
            x = rest;
            part
        });
        let parts: Vec<&[Var<f32>]> = parts.collect();
        rollout.run(parts[0], &parts[1..])
    });
    let mut slopes = tape.pullback(&y, cotangents);
    let parts = lists.iter().map(|list| {
        let (part, rest) = slopes.split_at(list.len());
        slopes = rest;
        part.to_vec()
    });
    (y.iter().map(|y| y.value()).collect(), parts.collect())
}

/// Asserts that the numbers differ by at most 1e-5 of the largest: 50 steps of single precision.
fn close(what: &str, found: &[f32], expected: &[f32]) {
    let largest = expected.iter().fold(0.0f32, |most, x| most.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= 1e-5 * largest,
            "{what}: {found:?} instead of {expected:?}"
        );
    }
}
