//! Randomly drawn programs must agree with the same steps written out in plain code.

mod draw;
mod weighted;
mod step;

use crate::steps::{Mapped, STEPS, Step, Times, assert_same};
use autodiff::{Dual, Real, Tape, Var, gradient};
use autodiff_programs::{CotangentBound, Given, Memory, Rollout};
use step::{Drawn, Kind, Operation};

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
    let shapes: [(&str, Shape); 11] = [
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
        ("a parameter differs from step to step", |drawn| {
            drawn
                .parameters
                .iter()
                .any(|(kind, _)| *kind == Kind::Control)
        }),
        ("a state becomes a uniform input", |drawn| {
            let states = drawn.states();
            drawn.uniforms().any(|uniform| states.contains(&uniform))
        }),
        ("each start has its own uniform input", |drawn| {
            drawn.is_parameter(0) && drawn.uniforms().any(|uniform| uniform == 0)
        }),
        ("edges have more than four directions", |drawn| {
            let far = |&([tail, head], _): &([usize; 2], bool)| head - tail > 4;
            drawn.edges.iter().any(far) && drawn.has(|o| matches!(o, Operation::Tug { .. }))
        }),
        ("arrays are weighted", |drawn| {
            drawn.has(|o| matches!(o, Operation::Weighted { .. }))
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
type Start<'a, R> = (&'a [R], &'a [R]);

/// Rollouts of a program from several starts. If the program has array parameters, each start has its own values for
/// the first one.
#[derive(Clone)]
struct Rollouts {
    rollout: Rollout<Drawn>,
    starts: usize,
    /// True if the starts run in one batch.
    together: bool,
    /// The entries that are chosen from each state.
    chosen: Option<Vec<usize>>,
}

impl Rollouts {
    fn new(seed: usize, drawn: Drawn, observed: Vec<usize>) -> Self {
        Self {
            rollout: Rollout {
                inputs: drawn.inputs().repeat(STEPS).into(),
                observed,
                ..Rollout::new(drawn, STEPS)
            },
            starts: [1, 2, 3, 9][seed % 4],
            together: false,
            chosen: None,
        }
    }

    /// Splits the numbers of all starts.
    fn split<'a, R>(&self, x: &'a [R]) -> Vec<Start<'a, R>> {
        let starts = (0..self.starts).map(|k| &x[k * x.len() / self.starts..]);
        let each = starts.map(|x_and_rest| &x_and_rest[..x.len() / self.starts]);
        each.map(|x| x.split_at(self.rollout.model.state_len()))
            .collect()
    }

    /// The numbers of all starts.
    fn point(&self) -> Vec<f64> {
        let drawn = &self.rollout.model;
        let own = drawn.parameters.first().map_or(0, |_| drawn.shapes()[1]);
        let count = self.starts * (drawn.state_len() + own);
        (0..count).map(number).collect()
    }

    /// Returns what is observed of each start.
    fn seen<R: Real>(&self, x: &[R]) -> Vec<Vec<R>> {
        let (drawn, starts) = (&self.rollout.model, self.split(x));
        let has_own = usize::from(!drawn.parameters.is_empty());
        let constants = |&len: &usize| (0..len).map(|i| R::lit(0.2 * number(i))).collect();
        let shared: Vec<Vec<R>> = drawn
            .shapes()
            .iter()
            .skip(1 + has_own)
            .map(constants)
            .collect();
        let given = starts.iter().map(|&(_, own)| {
            let own = [own].into_iter().take(has_own);
            let given: Vec<_> = own.chain(shared.iter().map(Vec::as_slice)).collect();
            drawn.parameters(&given)
        });
        let given: Vec<Vec<Vec<R>>> = given.collect();
        if !self.together {
            let alone = |(&(start, _), given): (&Start<R>, &Vec<Vec<R>>)| {
                let given: Vec<&[R]> = given.iter().map(Vec::as_slice).collect();
                self.rollout.run(start, &given)
            };
            return starts.iter().zip(&given).map(alone).collect();
        }
        let owns: Vec<&[R]> = given
            .iter()
            .flatten()
            .step_by(given[0].len().max(1))
            .map(Vec::as_slice)
            .collect();
        let own = [Given::Each(&owns)].into_iter().take(has_own);
        let all = own.chain(given[0].iter().skip(has_own).map(|p| Given::Shared(p)));
        let starts: Vec<_> = starts.iter().map(|&(start, _)| start).collect();
        self.rollout.run_batch(&starts, &all.collect::<Vec<_>>())
    }

    /// Returns the chosen numbers. Also returns the gradient of a weighted sum of them with respect to the starts and
    /// to the starts' own parameters.
    fn seen_and_gradient(&self) -> (Vec<f64>, Vec<f64>) {
        let state = self.rollout.model.state_len();
        let mut values = Vec::new();
        let weighted = |x: &[Var<f64>]| {
            let mut seen = self.seen(x).concat();
            if let Some(entries) = &self.chosen {
                let states = seen.chunks(state.max(1));
                seen = states
                    .flat_map(|state| entries.iter().map(|&k| state[k]))
                    .collect();
            }
            values = seen.iter().map(|y| y.value()).collect();
            let weights: Vec<f64> = (0..seen.len()).map(|i| number(3 * i)).collect();
            Var::dot(&seen, &weights)
        };
        let slopes = gradient(weighted, &self.point());
        (values, slopes)
    }
}

/// Fills the memory of this thread's last rollout with NaN. The next rollout reuses this memory, and must not see it:
/// not behind the end of an array, and not where a gather leaves out a number.
fn leave_nan() {
    Tape::new().record(&[f64::NAN; 1 << 12], |x| {
        Rollout::new(Mapped(Times(0.5), 1 << 12), 3).run(x, &[]);
    });
}

#[test]
fn drawn_programs_have_the_same_bits_however_they_are_run() {
    let mut clipped = 0;
    for (seed, drawn) in programs() {
        let entries: Vec<usize> = (0..drawn.state_len()).step_by(3).collect();
        let rollouts = Rollouts::new(seed, drawn, vec![0, STEPS / 2, STEPS]);
        let run = |together, memory, change: &dyn Fn(&mut Rollouts)| {
            let mut rollouts = rollouts.clone();
            (rollouts.together, rollouts.rollout.memory) = (together, memory);
            change(&mut rollouts);
            leave_nan();
            rollouts.seen_and_gradient()
        };
        let plain = run(false, Memory::All, &|_| ());
        assert!(plain.1.iter().all(|g| g.is_finite()));
        let least = Memory::Bytes(0);
        assert_eq!(run(true, Memory::All, &|_| ()), plain);
        let chosen = run(false, Memory::All, &|all| {
            all.chosen = Some(entries.clone())
        });
        for together in [true, false] {
            // No state reaches this bound.
            let bounded = run(together, least, &|all| all.rollout.state_bound = Some(1e9));
            assert_eq!(bounded, plain, "{together}");
            let some = run(together, least, &|all| {
                all.rollout.entries = Some(entries.clone())
            });
            assert_eq!(some, chosen, "{together}");
        }
        // The cotangent of each start is clipped separately. In units twice as large, all numbers are half as large.
        let clip = |all: &mut Rollouts, norm| {
            all.rollout.cotangent_bound = Some(CotangentBound { norm, every: 2 });
        };
        let alone = run(false, Memory::All, &|all| clip(all, 0.5));
        let together = run(true, least, &|all| {
            clip(all, 0.25);
            let state = all.rollout.model.state_len();
            all.rollout.cotangent_units = Some(vec![2.0; state].into());
        });
        assert_eq!(together, alone);
        clipped += usize::from(alone != plain);
        // Other numbers replay recordings.
        let duals: Vec<_> = rollouts
            .point()
            .iter()
            .map(|&x| Dual::<f64, 1>::variable(x, 0))
            .collect();
        let seen = Rollouts {
            together: true,
            ..rollouts.clone()
        }
        .seen(&duals);
        for (a, b) in seen.concat().iter().zip(rollouts.seen(&duals).concat()) {
            assert_eq!((a.value, a.tangent), (b.value, b.tangent));
        }
    }
    assert!(clipped >= 20, "{clipped} of {PROGRAMS}");
}

/// The bound is the largest number that one of the starts reaches. Starts that reach this number or a larger one must
/// return NaN. All others must have the bits of runs without a bound.
#[test]
fn drawn_programs_give_nan_where_a_state_is_not_below_its_bound() {
    let programs = programs().filter(|(_, drawn)| drawn.state_len() > 0);
    for (seed, drawn) in programs.take(100) {
        let all = Rollouts::new(seed, drawn.clone(), (1..=STEPS).collect());
        let x = all.point();
        let most = |seen: &Vec<f64>| seen.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let largest: Vec<f64> = all.seen(&x).iter().map(most).collect();
        let mut ends = Rollouts::new(seed, drawn, vec![0, STEPS]);
        let plain = ends.seen(&x);
        for together in [true, false] {
            (ends.together, ends.rollout.state_bound) = (together, Some(largest[0]));
            for ((seen, plain), &largest_here) in ends.seen(&x).iter().zip(&plain).zip(&largest) {
                let expected = match largest_here < largest[0] {
                    true => seen == plain,
                    false => seen.iter().all(|x| x.is_nan()),
                };
                assert!(expected, "{seen:?}, {plain:?}");
            }
        }
    }
}
