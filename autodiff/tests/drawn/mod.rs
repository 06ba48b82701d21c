//! Randomly drawn programs must agree with the same steps written out in plain code.

mod draw;
mod step;

use crate::steps::{STEPS, Step, assert_same};
use autodiff::{Given, Memory, Real, Rollout, Var, gradient};
use step::Drawn;

/// The number of programs. Miri is slow, so it gets fewer.
const PROGRAMS: u64 = if cfg!(miri) { 4 } else { 400 };

/// Returns the drawn programs with their seeds, which failing tests print.
fn programs() -> impl Iterator<Item = (usize, Drawn)> {
    (0..PROGRAMS).map(|seed| {
        let drawn = Drawn::new(seed);
        println!("seed {seed}: {drawn:?}");
        (seed as usize, drawn)
    })
}

#[test]
fn drawn_programs_are_what_is_written_out() {
    for (_, drawn) in programs() {
        assert_same(drawn);
    }
}

/// A property of a drawn program.
type Shape = fn(&Drawn) -> bool;

/// The drawn programs must include shapes that no other test has.
#[test]
#[cfg_attr(miri, ignore)]
fn programs_of_many_shapes_are_drawn() {
    let shapes: [(&str, Shape); 6] = [
        ("a state becomes another one", |drawn| {
            let states = drawn.states();
            let mut next = states.iter().zip(&drawn.next);
            next.any(|(own, next)| own != next && states.contains(next))
        }),
        ("a state becomes a parameter", |drawn| {
            drawn.next.iter().any(|&next| drawn.is_parameter(next))
        }),
        ("a layer is linear", |drawn| {
            drawn.layers().any(|layer| !layer.tanh)
        }),
        ("a layer sees an array twice", |drawn| {
            drawn.layers().any(|layer| match layer.seen[..] {
                [a, b] => a == b,
                [a, b, c] => a == b || b == c || a == c,
                _ => false,
            })
        }),
        ("a layer adds an array that it sees", |drawn| {
            drawn.layers().any(|layer| layer.seen.contains(&layer.bias))
        }),
        ("a layer sees a parameter and a state", |drawn| {
            let states = drawn.states();
            drawn.layers().any(|layer| {
                let parameter = layer.seen.iter().any(|&array| drawn.is_parameter(array));
                parameter && layer.seen.iter().any(|array| states.contains(array))
            })
        }),
    ];
    let programs: Vec<Drawn> = (0..PROGRAMS).map(Drawn::new).collect();
    for (what, shape) in shapes {
        let count = programs.iter().filter(|drawn| shape(drawn)).count();
        assert!(count >= 20, "{what}: {count} of {PROGRAMS}");
    }
}

fn number(i: usize) -> f64 {
    (0.7 * i as f64 + 0.2).sin()
}

/// The start of a rollout, and the value of the first parameter for this start.
type Start<'a> = (&'a [Var<f64>], &'a [Var<f64>]);

/// Rollouts of a program from several starts. If the program has array parameters, each start has its own values for
/// the first one.
struct Rollouts {
    rollout: Rollout<Drawn>,
    starts: usize,
    /// True if the starts run in one batch.
    together: bool,
}

impl Rollouts {
    /// Returns the observed states.
    fn seen(&self, starts: &[Start]) -> Vec<Var<f64>> {
        let drawn = &self.rollout.model;
        let has_own = !drawn.parameters.is_empty();
        let constants = |&len: &usize| (0..len).map(|i| Var::lit(0.2 * number(i))).collect();
        let lens = drawn.shapes();
        let shared = lens[1 + usize::from(has_own)..].iter();
        let shared: Vec<Vec<Var<f64>>> = shared.map(constants).collect();
        if self.together {
            let (starts, owns): (Vec<_>, Vec<_>) = starts.iter().copied().unzip();
            let own = has_own.then_some(Given::Each(&owns)).into_iter();
            let given: Vec<_> = own.chain(shared.iter().map(|p| Given::Shared(p))).collect();
            return self.rollout.run_batch(&starts, &given).concat();
        }
        let alone = |&(start, own): &Start| {
            let own = has_own.then_some(own).into_iter();
            let given: Vec<_> = own.chain(shared.iter().map(Vec::as_slice)).collect();
            self.rollout.run(start, &given)
        };
        starts.iter().flat_map(alone).collect()
    }

    /// Returns the observed states. Also returns the gradient of a weighted sum of them with respect to the starts and
    /// to the starts' own parameters.
    fn seen_and_gradient(&self) -> (Vec<f64>, Vec<f64>) {
        let drawn = &self.rollout.model;
        let (state, own) = (drawn.state_len(), drawn.parameters.first().copied());
        let len = state + own.unwrap_or(0);
        let x: Vec<f64> = (0..self.starts * len).map(number).collect();
        let mut values = Vec::new();
        let gradient = gradient(
            |x: &[Var<f64>]| {
                let starts = (0..self.starts).map(|k| x[k * len..][..len].split_at(state));
                let seen = self.seen(&starts.collect::<Vec<_>>());
                values = seen.iter().map(|y| y.value()).collect();
                let weights = (0..seen.len()).map(|i| Var::lit(number(3 * i)));
                Var::dot(&weights.collect::<Vec<_>>(), &seen)
            },
            &x,
        );
        (values, gradient)
    }
}

#[test]
fn drawn_programs_have_the_same_bits_however_they_are_run() {
    for (seed, drawn) in programs() {
        // This is more memory than one step of any of these programs takes. For most programs it is less than all steps
        // take together.
        let room = 800 / drawn.state_len().max(1) + 10;
        let run = |together, memory| {
            let rollouts = Rollouts {
                rollout: Rollout {
                    inputs: drawn.inputs().repeat(STEPS).into(),
                    observed: vec![0, STEPS / 2, STEPS],
                    memory,
                    ..Rollout::new(drawn.clone(), STEPS)
                },
                starts: [1, 2, 3, 9][seed % 4],
                together,
            };
            rollouts.seen_and_gradient()
        };
        let plain = run(false, Memory::All);
        assert!(plain.1.iter().all(|g| g.is_finite()));
        for (together, memory) in [
            (true, Memory::All),
            (false, Memory::States(room)),
            (true, Memory::States(room)),
        ] {
            assert_eq!(run(together, memory), plain, "{together} {memory:?}");
        }
    }
}
