//! Misuse that a tape must refuse, and operations that it must not record.

use std::cell::Cell;

use crate::common::{Sym, assert_refused, panic_message};
use autodiff::real::Accepts;
use autodiff::{Array, Dual, Graph, Kernel, Program, Real, Tape, Var, gradient, kernel};

fn assert_stale<T>(action: impl FnOnce() -> T) {
    assert_refused("its tape is not recording", action);
}

#[test]
fn variables_are_small_and_go_anywhere() {
    fn goes_anywhere<T: Copy + Send + Sync + 'static>() {}
    fn is_send<T: Send>() {}
    goes_anywhere::<Var<f64>>();
    goes_anywhere::<Var<Var<Dual<f32, 3>>>>();
    is_send::<Tape<Dual<f64, 2>>>();
    assert_eq!(size_of::<Var<f64>>(), 16);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_variable_outside_its_closure_is_refused() {
    let x = Tape::new().record(&[1.0], |x| x[0]);
    assert_eq!(x.value(), 1.0);
    assert_stale(move || x + x);
    assert_stale(move || x.sqrt());
    assert_stale(move || Var::sum_of(&[x, x]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_variable_of_an_earlier_recording_is_refused() {
    let mut tape = Tape::new();
    let old = tape.record(&[1.0], |x| x[0]);
    assert_stale(move || Tape::new().record(&[1.0], |_| old + old));
    let message = panic_message(move || {
        tape.record(&[1.0], |_| ());
        tape.pullback(&[old], &[1.0]);
    });
    assert!(
        message.contains("a variable of another tape or of an earlier recording"),
        "{message}"
    );
    assert!(!message.contains("left:"), "{message}");
}

/// If a variable of the running recording is used too, the message must name both possible causes.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_variable_of_an_earlier_recording_is_refused_beside_others() {
    let mut tape = Tape::new();
    let old = tape.record(&[1.0], |x| x[0]);
    type Join = fn(Var<f64>, Var<f64>) -> Var<f64>;
    let joins: [Join; 4] = [
        |x, old| x * old,
        |x, old| old - x,
        |x, old| Var::sum_of(&[x, old]),
        |x, old| Var::dot(&[x], &[old]),
    ];
    for join in joins {
        let message = panic_message(|| tape.record(&[1.0], |x| join(x[0], old)));
        assert!(message.contains("to an earlier recording"), "{message}");
        assert!(message.contains("two tapes"), "{message}");
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_variable_on_another_thread_is_refused() {
    Tape::new().record(&[1.0], |x| {
        let x = x[0];
        let elsewhere = std::thread::spawn(move || assert_stale(move || x * x));
        elsewhere.join().expect("the panic is caught over there");
    });
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn variables_of_two_tapes_do_not_mix() {
    type Join = fn(Var<f64>, Var<f64>) -> Var<f64>;
    for join in [|x, y| x * y, |x, y| Var::sum_of(&[x, y])] as [Join; 2] {
        assert_refused("to nest tapes", || {
            let inner = |x| gradient(|y| join(x, y[0]), &[1.0])[0];
            gradient(|x| Var::constant(inner(x[0])), &[1.0]);
        });
    }
}

#[test]
fn an_outer_tape_of_the_same_type_still_records_inside() {
    let outer = gradient(
        |x| {
            let inner = gradient(|y| y[0] * y[0], &[3.0]);
            let mut product = x[0];
            Tape::new().record(&inner, |_| product *= x[0]);
            product * Var::constant(inner[0])
        },
        &[5.0],
    );
    assert_eq!(outer, [60.0]);
}

thread_local! {
    static HELD: Cell<Var<f64>> = Cell::new(Var::constant(0.0));
}

/// A conversion that records on the tape of the product: it returns the square of the variable that the thread holds.
impl Accepts<Sym> for Var<f64> {
    fn accept(_: Sym) -> Self {
        let x = HELD.get();
        Var::dot(&[x], &[x])
    }
}

#[test]
fn a_conversion_may_record() {
    let cube = |x: &[Var<f64>]| {
        HELD.set(x[0]);
        Var::dot(x, &[Sym::lit(0.0)])
    };
    assert_eq!(gradient(cube, &[3.0]), [27.0]);
}

/// A recording and its sweep must not use the stack for each operation.
#[test]
fn a_chain_of_a_million_operations_needs_no_stack() {
    const LENGTH: usize = if cfg!(miri) { 1000 } else { 1_000_000 };
    let chain = |x: &[Var<f64>]| (0..LENGTH).fold(x[0], |y, _| -y);
    assert_eq!(gradient(chain, &[1.0]), [1.0]);
    let sum = |x: &[Var<f64>]| (0..LENGTH).map(|_| x[0]).sum();
    assert_eq!(gradient(sum, &[1.0]), [LENGTH as f64]);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_panic_inside_leaves_the_outer_recording_current() {
    let gradient = gradient(
        |x| {
            let inner = || gradient(|_| panic!("on purpose"), &[1.0]);
            assert_eq!(panic_message(inner), "on purpose");
            x[0] * x[0]
        },
        &[2.0],
    );
    assert_eq!(gradient, [4.0]);
}

#[test]
#[cfg_attr(target_family = "wasm", ignore = "no threads")]
fn a_tape_moves_between_threads() {
    let mut tape = Tape::new();
    let y = tape.record(&[2.0], |x| x[0] * x[0]);
    let there = std::thread::spawn(move || tape.pullback(&[y], &[1.0]).to_vec());
    assert_eq!(there.join().expect("no panic"), [4.0]);
}

#[test]
fn constants_are_not_recorded() {
    let mut tape = Tape::new();
    let y = tape.record(&[2.0], |x| {
        let constant = Var::lit(3.0).sqrt() * Var::lit(2.0) + x[0].detach();
        let _ = Var::select(x[0].less(constant), x[0], constant);
        let _ = Var::dot(&[constant, constant], &[constant, constant]);
        constant
    });
    assert_eq!(tape.len(), 1, "the input alone");
    assert_eq!(tape.pullback(&[y], &[1.0]), [0.0]);
    tape.record(&[2.0], |x| x[0] * Var::lit(3.0) + Var::lit(1.0));
    assert_eq!(
        tape.len(),
        2,
        "input, product; the sum is the product, moved"
    );
    tape.record(&[2.0], |x| (x[0] - Var::lit(3.0)) * (Var::lit(1.0) + x[0]));
    assert_eq!(tape.len(), 2, "input, product of one parent");
    tape.record(&[2.0, 3.0], |x| Var::dot(&[x[0]; 50], &[x[1]; 50]));
    assert_eq!(tape.len(), 3, "two inputs, one dot product");
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn lengths_are_checked() {
    assert_refused("one cotangent for each output", || {
        let mut tape = Tape::new();
        let y = tape.record(&[1.0], |x| x[0]);
        tape.pullback(&[y], &[]);
    });
    assert_refused("2 directions", || Dual::<f64, 2>::variable(1.0, 2));
}

#[test]
fn an_empty_tape_says_so() {
    let mut tape = Tape::new();
    assert!(tape.is_empty());
    tape.record(&[2.0], |_| ());
    assert!(!tape.is_empty(), "an input is an entry");
    tape.record(&[] as &[f64], |_| ());
    assert!(tape.is_empty(), "the last recording counts");
}

struct Twice;

#[kernel]
impl Kernel<1, 1> for Twice {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x + x]
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn arrays_of_another_program_are_refused() {
    type Use = fn(&mut Program, Array);
    let uses: [Use; 5] = [
        |program, array| _ = program.map(Twice, [array], &[]),
        |program, array| _ = program.gather(array, &[Some(0)]),
        |program, array| {
            let graph = Graph::new(2, &[[0, 1]]);
            _ = program.map_edges(&graph, Twice, [array], &[], &[]);
        },
        |program, array| {
            let (matrix, bias) = (program.matrix(1, 2), program.parameter(1));
            _ = program.dense(matrix, &[array], bias);
        },
        |program, array| {
            let state = program.state(2);
            program.advance(state, array);
        },
    ];
    for of_program in uses {
        let mut other = Program::default();
        let apart = (0..9).map(|_| other.parameter(2)).last();
        let foreign = apart.expect("there are nine");
        let refused = || of_program(&mut Program::default(), foreign);
        assert_refused("belongs to another program", refused);
        of_program(&mut other, foreign);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_matrix_of_another_program_is_refused() {
    let mut other = Program::default();
    let matrices = [(1, 2), (2, 2), (1, 2)].map(|(rows, columns)| other.matrix(rows, columns));
    for matrix in matrices {
        let mut program = Program::default();
        let bias = program.parameter(1);
        program.matrix(1, 1);
        let x = program.state(2);
        assert_refused("belongs to another program", || {
            program.dense(matrix, &[x], bias)
        });
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_state_is_advanced_once() {
    let mut program = Program::default();
    let (x, y) = (program.state(2), program.state(2));
    let [next] = program.map(Twice, [x], &[]);
    program.advance(x, next);
    program.advance(y, next);
    assert_refused("already advanced", || program.advance(x, y));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_function_with_more_values_at_one_time_than_at_another_is_refused() {
    let jacobian = |more: usize| {
        let values = Cell::new(3);
        autodiff::jacobian(
            |x| vec![x[0]; values.replace(values.get() + more)],
            &[1.0; 9],
        )
    };
    let row = [vec![1.0], vec![0.0; 8]].concat();
    assert_eq!(jacobian(0).as_slice(), row.repeat(3));
    assert_refused("number of values must not", || jacobian(1));
}
