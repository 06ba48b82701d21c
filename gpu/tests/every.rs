//! A program with every operation, on a device and on the processor.

use std::sync::Arc;

use crate::device::gpu;
use crate::program::Every;
use autodiff::wgsl::{Options, print};
use autodiff::{CotangentBound, Rollout, Tape, Var};
use cosmic_gpu::{Members, Population};

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
    let (model, steps, members) = (Every::new(), 50, 3);
    let common = vec![4, 5];
    // The bound is below half of the norms that occur, so that it acts in every stretch.
    let bound = CotangentBound {
        norm: 0.05,
        every: 7,
    };
    let units: Arc<[f64]> = (0..10).map(|k| 1.0 + 0.3 * f64::from(k)).collect();
    for (workgroup, kept, memory, bounds) in [
        (64, 4, 1 << 30, (None, None)),
        (4, 3, 1 << 30, (Some(bound), None)),
        (32, 1, 2000, (Some(bound), Some(units))),
    ] {
        let (cotangent_bound, cotangent_units) = bounds;
        let options = Options {
            workgroup,
            kept,
            cotangent_bound,
            cotangent_units: cotangent_units.clone(),
            // No number of a state reaches it.
            state_bound: Some(1e6),
            common: common.clone(),
            wanted: (0..8).collect(),
            ..Options::default()
        };
        let printed = print(&model, &options).unwrap();
        let mut population =
            Population::new(&gpu, printed).unwrap_or_else(|error| panic!("{error}"));
        population.memory = memory;
        population.steps_at_once = 16;
        let starts = numbers(members * 10, 1);
        let inputs = numbers(2 * steps, 2);
        let placed = population.printed().parameters().to_vec();
        let parameters: Vec<Vec<f32>> = placed
            .iter()
            .enumerate()
            .map(|(k, placed)| {
                let count = if placed.is_common { 1 } else { members };
                let mut all = numbers(count * placed.len, 3 + k);
                if k == 3 {
                    all.iter_mut()
                        .for_each(|weight| *weight = weight.abs() + 0.1);
                }
                all
            })
            .collect();
        let observed = [10, 11, 50];
        let of = Members {
            starts: &starts,
            parameters: &parameters,
            steps,
            inputs: &inputs,
            observed: &observed,
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

        assert_eq!(again.exceeded().unwrap(), [false; 3]);

        let rollout = Rollout {
            cotangent_bound,
            cotangent_units: cotangent_units.clone(),
            inputs: inputs.iter().map(|&x| f64::from(x)).collect(),
            observed: observed.to_vec(),
            ..Rollout::new(model.clone(), steps)
        };
        for m in 0..members {
            let part = |k: usize| -> &[f32] {
                let placed = &placed[k];
                let at = if placed.is_common { 0 } else { m };
                &parameters[k][at * placed.len..][..placed.len]
            };
            let x: Vec<f32> = starts[10 * m..][..10]
                .iter()
                .chain((0..8).flat_map(&part))
                .copied()
                .collect();
            let mut tape = Tape::new();
            let y = tape.record(&x, |x: &[Var<f32>]| {
                let mut at = 10;
                let of_robot: Vec<&[Var<f32>]> = placed
                    .iter()
                    .map(|placed| {
                        at += placed.len;
                        &x[at - placed.len..at]
                    })
                    .collect();
                rollout.run(&x[..10], &of_robot)
            });
            let values: Vec<f32> = y.iter().map(|y| y.value()).collect();
            let count = values.len();
            let expected = tape.pullback(&y, &cotangents[count * m..][..count]);
            close("observed", &seen[count * m..][..count], &values);
            // Without the bound, the cotangent of every start is larger.
            let unit = |k: usize| cotangent_units.as_ref().map_or(1.0, |units| units[k]);
            let of_start = bars.starts[10 * m..][..10].iter().enumerate();
            let squares = of_start.map(|(k, &x)| (f64::from(x) / unit(k)).powi(2));
            let norm = squares.sum::<f64>().sqrt();
            assert_eq!(
                norm < 1.001 * bound.norm,
                cotangent_bound.is_some(),
                "{norm}"
            );
            close("starts", &bars.starts[10 * m..][..10], &expected[..10]);
            let mut at = 10;
            for (k, placed) in placed.iter().enumerate() {
                let found = &bars.parameters[k][m * placed.len..][..placed.len];
                close(
                    &format!("parameter {k}"),
                    found,
                    &expected[at..at + placed.len],
                );
                at += placed.len;
            }
        }
    }
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
