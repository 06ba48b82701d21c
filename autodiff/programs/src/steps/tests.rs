//! Compares rollouts on all instruction sets of the machine. Builds of tests have the widest registers only here. Also
//! tests what no public function shows: how far operations reach, guarded products, and the buffers that a thread keeps.

use std::array::from_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};

use autodiff::internal::pool::{MOST_BYTES, Pooled};
use autodiff::internal::{Cotangents, Product, Strided, at_most, lanes, pool};
use autodiff::simd::{Level, level};
use autodiff::{Real, Tape, Var, gradient};

use super::instance::Instance;
use crate::arrays::{Bars, StepValues};
use crate::record::replay::{Plan, PointInputs, Points, Wanted};
use crate::{Compiled, Graph, Kernel, Model, Program, Rollout, kernel};

/// More nodes than two of the widest registers have lanes, and not a multiple of any number of lanes.
const NODES: usize = 37;
const HIDDEN: usize = 27;

/// A chain of springs whose rest lengths a network drives.
#[derive(Clone)]
struct Driven(Graph);

#[derive(Clone, Copy)]
struct Spring;

#[kernel]
impl Kernel<2, 1> for Spring {
    fn eval<R: Real>(&self, [d, u]: [R; 2], _: &[R]) -> [R; 1] {
        let length = (d * d + R::lit(1e-3)).sqrt();
        [(length - R::lit(0.1) * (R::one() + u)) * d / length]
    }
}

/// A spring whose registers have at most 256 bits.
#[derive(Clone, Copy)]
struct NarrowSpring;

#[kernel]
impl Kernel<2, 1> for NarrowSpring {
    const COMPILED: Compiled = Compiled::Narrow;
    fn eval<R: Real>(&self, x: [R; 2], uniforms: &[R]) -> [R; 1] {
        Spring.eval(x, uniforms)
    }
}

#[derive(Clone, Copy)]
struct Move;

#[kernel]
impl Kernel<4, 2> for Move {
    fn eval<R: Real>(&self, [x, v, force, other]: [R; 4], _: &[R]) -> [R; 2] {
        let v = v * R::lit(0.99) + (force + other) * R::lit(0.05);
        let v = R::select(x.less(-0.5), v.max(R::zero()), v);
        [x + R::lit(0.05) * v, v]
    }
}

impl Model for Driven {
    fn record(&self, p: &mut Program) {
        let (graph, slots) = (&self.0, self.0.slots());
        let (inner, bias) = (p.matrix(HIDDEN, NODES), p.parameter(HIDDEN));
        let (outer, none) = (p.matrix(slots, HIDDEN), p.parameter(slots));
        let [x, v] = [(); 2].map(|()| p.state(NODES));
        let hidden = p.dense_tanh(inner, &[x], bias);
        let driven = p.dense(outer, &[hidden], none);
        let [other] = p.map_edges(graph, NarrowSpring, [x], &[driven], &[]);
        let [force] = p.map_edges(graph, Spring, [x], &[driven], &[]);
        let turned: Vec<_> = (0..NODES).map(|i| Some((i + 5) % NODES)).collect();
        let force = p.gather(force, &turned);
        let [next_x, next_v] = p.map(Move, [x, v, force, other], &[]);
        p.advance(x, next_x);
        p.advance(v, next_v);
    }
}

/// Irregular numbers of order one.
fn numbers<R: Real>(count: usize, by: f64) -> Vec<R> {
    let number = |i: usize| R::lit(0.4 * (by * (i * i) as f64 + by).sin());
    (0..count).map(number).collect()
}

/// Returns the states of `starts` starts after some steps, and their gradient with respect to the starts and the shared
/// parameters. If `together` is true, the starts run as a batch.
fn states_and_gradient<R: Real>(steps: usize, starts: usize, together: bool) -> [Vec<R>; 2] {
    let edges: Vec<[usize; 2]> = (1..NODES).map(|i| [i - 1, i]).collect();
    let graph = Graph::new(NODES, &edges);
    let slots = graph.slots();
    let shapes = [HIDDEN * NODES, HIDDEN, slots * HIDDEN, slots];
    let rollout = Rollout::new(Driven(graph), steps);
    let of_starts = 2 * NODES * starts;
    let x = [numbers(of_starts, 0.7), numbers(shapes.iter().sum(), 0.3)].concat();
    let mut tape = Tape::new();
    let seen = tape.record(&x, |x: &[Var<R>]| {
        let (starts, mut rest) = x.split_at(of_starts);
        let starts: Vec<&[Var<R>]> = starts.chunks(2 * NODES).collect();
        let parameters: [&[Var<R>]; 4] =
            from_fn(|k| rest.split_off(..shapes[k]).expect("as long as its parts"));
        if together {
            let shared = parameters.map(crate::Given::Shared);
            return rollout.run_batch(&starts, &shared).concat();
        }
        let alone = starts
            .iter()
            .flat_map(|start| rollout.run(start, &parameters));
        alone.collect()
    });
    let values = seen.iter().map(|x| x.value()).collect();
    let bars = numbers(seen.len(), 1.1);
    [values, tape.pullback(&seen, &bars).to_vec()]
}

/// On every instruction set, a batch must have the states and the cotangents of each start alone, to the bit, and the
/// states and gradients must be those of scalars except for rounding.
#[test]
fn all_registers_agree() {
    fn check<R: Real + PartialEq + Into<f64>>(tolerance: f64) {
        let scalars = at_most(Level::Baseline, || states_and_gradient::<R>(19, 17, false));
        for cap in [Level::Baseline, Level::Avx2, level()] {
            for starts in [1, 2, 3, 17] {
                let [together, alone] = [true, false].map(|together| {
                    at_most(cap, || states_and_gradient::<R>(19, starts, together))
                });
                let of_starts = ..2 * NODES * starts;
                assert!(together[0] == alone[0], "{starts} starts, {cap:?}");
                assert!(
                    together[1][of_starts] == alone[1][of_starts],
                    "{starts}, {cap:?}"
                );
                if starts < 17 {
                    continue;
                }
                for (found, expected) in together.iter().zip(&scalars) {
                    let size = |x: &R| (*x).into().abs();
                    let most = expected.iter().map(size).fold(0.0, f64::max);
                    for (&a, &b) in found.iter().zip(expected) {
                        let off: f64 = (a - b).into();
                        assert!(
                            off.abs() <= tolerance * most,
                            "{a:?} {b:?} of {most}, {cap:?}"
                        );
                    }
                }
            }
        }
    }
    // Each derivative is a sum of hundreds of terms, some of which may be larger than the sum.
    check::<f64>(1e-12);
    check::<f32>(1e-4);
}

/// Kernels over nodes and edges whose registers have at most 256 bits, with a uniform input.
#[derive(Clone, Copy)]
struct NarrowPush;

#[kernel]
impl Kernel<1, 1> for NarrowPush {
    const COMPILED: Compiled = Compiled::Narrow;
    const UNIFORMS: usize = 1;
    fn eval<R: Real>(&self, [x]: [R; 1], uniforms: &[R]) -> [R; 1] {
        [uniforms[0] * x * x]
    }
}

/// The state after a step and its gradient with respect to the state before, for every start. Each start has its own
/// uniform input.
fn of_narrow_kernels(starts: usize, lanes: usize, first: usize) -> [Vec<f64>; 2] {
    let graph = Graph::new(NODES, &from_fn::<_, { NODES - 1 }, _>(|i| [i, i + 1]));
    let mut program = Program::side_by_side(starts, lanes);
    let (factor, x) = (program.parameter(1), program.state(NODES));
    let [pushed] = program.map(NarrowPush, [x], &[factor]);
    let [next] = program.map_edges(&graph, NarrowPush, [pushed], &[], &[factor]);
    program.advance(x, next);
    let mut program = Instance::new(program);
    let mut parameters = program.parameters();
    let of_start = |k: usize| 1.0 + (first + k) as f64;
    let factors: Vec<f64> = (0..starts).map(of_start).collect();
    program.load(&mut parameters, &[&factors], &[true], 1);
    program.set_active(&[false]);
    let mut row = vec![0.0; program.row_len()];
    let state = numbers::<f64>(NODES, 0.7).into_iter();
    let state: Vec<f64> = state.flat_map(|x| vec![x; starts]).collect();
    program.set_state(&mut row, &state);
    program.step(&parameters, &mut row, None);
    let mut next = Vec::new();
    let stride = program.stride();
    program.push_state(&row[stride..], &mut next);
    let (mut bars, mut bar) = (program.bars(), vec![1.0; NODES * starts]);
    program.reverse_step(&parameters, &row, &mut bars, &mut bar, row.as_ptr());
    [next, bar]
}

/// The registers of a narrow kernel may have fewer lanes than there are starts, which have a lane each in the registers of
/// the other operations.
#[test]
fn narrow_kernels_read_the_uniform_inputs_of_every_start() {
    if lanes::<f64>() == 1 {
        return; // Kernels are replayed then.
    }
    let starts = 2 * lanes::<f64>();
    let together = of_narrow_kernels(starts, starts, 0);
    for start in 0..starts {
        let alone = of_narrow_kernels(1, lanes::<f64>(), start);
        for (together, alone) in together.iter().zip(alone) {
            let own = together.iter().skip(start).step_by(starts);
            assert!(own.eq(&alone), "start {start} of {starts}");
        }
    }
}

/// The lanes of a program are planned when it is recorded.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn lanes_that_differ_from_the_plan_panic() {
    let graph = Graph::new(3, &[[0, 1]]);
    let mut program = Program::side_by_side(1, lanes::<f64>());
    let [x, u] = [3, graph.slots()].map(|len| program.state(len));
    let [next] = program.map_edges(&graph, Spring, [x], &[u], &[]);
    program.advance(x, next);
    program.advance(u, u);
    let mut program = Instance::new(program);
    let mut row = vec![0.0_f64; program.row_len()];
    let mut step = || program.step(&[], &mut row, None);
    step();
    let planned = level();
    let done = at_most(Level::Baseline, || catch_unwind(AssertUnwindSafe(step)));
    // On a machine without wider lanes nothing changes and the step must succeed.
    assert_eq!(done.is_err(), planned != Level::Baseline);
}

/// Loads without bounds checks are sound only because each operation first checks how far its arrays reach.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn an_operation_with_too_few_numbers_panics() {
    if lanes::<f64>() == 1 {
        return; // Kernels are replayed then, with bounds checks.
    }
    // As many nodes as fill the widest register with edges.
    let graph = Graph::new(17, &from_fn::<_, 16, _>(|i| [i, i + 1]));
    let mut program = Program::side_by_side(1, lanes::<f64>());
    let u = program.parameter(graph.slots());
    let [x, nodes] = [u.len, 17].map(|len| program.state(len));
    program.map(Spring, [x, u], &[]);
    program.map_edges(&graph, Spring, [nodes], &[u], &[]);
    for operation in program.operations {
        let mut operation = operation.compiled::<f64>();
        let output = *operation.outputs().last().expect("every operation has one");
        // Runs the operation forward, or in reverse if there are cotangents. The numbers are the lengths of the
        // parameters and of the row.
        let mut is_refused = |values: [usize; 2], bars: Option<[usize; 2]>| {
            let numbers = |lens: [usize; 2]| lens.map(|len| vec![1.0; len]);
            let [parameters, mut row] = numbers(values);
            let run = || match bars.map(numbers) {
                None => operation.forward(&parameters, &mut row),
                Some([mut of_parameters, mut of_row]) => {
                    let (parameters, row) = (&parameters[..], &row[..]);
                    let bars = &mut Bars {
                        parameters: &mut of_parameters,
                        row: &mut of_row,
                    };
                    operation.reverse(&StepValues { parameters, row }, bars);
                }
            };
            catch_unwind(AssertUnwindSafe(run)).is_err_and(|panic| {
                let text = panic.downcast_ref::<&str>();
                text.is_some_and(|text| text.starts_with("too few numbers"))
            })
        };
        let enough = [500; 2];
        assert!(!is_refused(enough, None) && !is_refused(enough, Some(enough)));
        for short in [[u.len - 1, 500], [500, output.range().end - 1]] {
            assert!(is_refused(short, None), "{short:?}");
            let in_reverse = [(short, enough), (enough, short)];
            assert!(in_reverse.map(|(values, bars)| is_refused(values, Some(bars))) == [true; 2]);
        }
    }
}

/// A zero cotangent must stop an infinite partial, whichever factor holds the cotangents. What lies between the rows of
/// a matrix does not count.
#[test]
fn guarded_products_have_no_zero_times_infinity() {
    let check = || {
        for at in 0..57 {
            let mut partials = [1.0; 57];
            partials[at] = [f64::NAN, f64::INFINITY][at % 2];
            let by_rows = Strided::by_rows(&partials, 20);
            let finite = by_rows.all_finite([3, 17]);
            assert_eq!(finite, at % 20 >= 17, "{at}");
            let (zeros, mut row, mut column) = ([0.0; 17], [1.0; 17], [1.0; 3]);
            let product = Product {
                a: Strided::by_rows(&zeros, 3),
                b: &partials,
                b_row: 20,
                to: &mut row,
                to_row: 17,
                rows: 1,
                depth: 3,
                columns: 17,
            };
            product.add_chained(Cotangents::A, finite);
            let product = Product {
                a: by_rows,
                b: &zeros,
                b_row: 1,
                to: &mut column,
                to_row: 1,
                rows: 3,
                depth: 17,
                columns: 1,
            };
            product.add_chained(Cotangents::B, finite);
            assert_eq!((row, column), ([1.0; 17], [1.0; 3]), "{at}");
        }
    };
    for cap in [Level::Baseline, Level::Avx2, level()] {
        at_most(cap, check);
    }
}

/// A buffer that pretends to have this number of bytes. Different values of `TYPE` make different types.
struct Bytes<const TYPE: usize>(usize);

impl<const TYPE: usize> Pooled for Bytes<TYPE> {
    fn bytes(&self) -> usize {
        self.0
    }
}

fn keep<const TYPE: usize>(bytes: usize) {
    pool::keep(Box::new(Bytes::<TYPE>(bytes)));
}

fn is_kept<const TYPE: usize>() -> bool {
    pool::take::<Bytes<TYPE>>().is_some()
}

/// A thread keeps few buffers, which share a bound. Those of tapes, rollouts and sums over data count.
#[test]
fn kept_buffers_share_a_bound() {
    let each = [
        keep::<0>, keep::<1>, keep::<2>, keep::<3>, keep::<4>, keep::<5>, keep::<6>,
    ];
    each.iter().for_each(|keep| keep(1));
    assert!(!is_kept::<0>() && is_kept::<1>() && is_kept::<6>());
    keep::<0>(MOST_BYTES / 2);
    keep::<1>(MOST_BYTES / 2 - 8);
    keep::<2>(MOST_BYTES + 1);
    keep::<3>(9);
    assert!(!is_kept::<0>() && is_kept::<1>() && !is_kept::<2>() && is_kept::<3>());
    let works: [fn(usize); 4] = [
        |n| _ = gradient(|x| (0..n).fold(x[0], |y, _| y * x[0]), &[1.0]),
        |n| _ = gradient(|x| Var::sum_of(&vec![x[0]; n]), &[1.0]),
        |steps| _ = states_and_gradient::<f64>(steps, 1, false),
        |n| {
            let points = Points {
                plan: &Plan::record([1, n], |x, y| vec![x[0] * y[0]]).expect("no branches"),
                shared: &vec![1.0; n],
                count: 2,
                inputs: PointInputs::Data(&[vec![1.0, 2.0]]),
                wanted: Wanted::ByShared,
            };
            assert_eq!(points.replay().by_shared[0], 3.0);
        },
    ];
    // Short work fits into the 20 kB beside the first buffer. Long work takes more.
    for (k, n) in (0..2 * works.len()).map(|k| (k, [1, 2000][k % 2])) {
        keep::<0>(MOST_BYTES); // Drops all other buffers.
        keep::<0>(MOST_BYTES - 20_000);
        works[k / 2](n);
        assert_eq!(is_kept::<0>(), n == 1, "work {} of length {n}", k / 2);
    }
}
