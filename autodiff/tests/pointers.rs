//! Small cases of code that holds raw pointers: recordings. Miri runs them, which takes some thousand times as long as the
//! processor; see `check-heavy.sh`.

use autodiff::{Real, Tape, Var, gradient};

#[test]
fn recordings_that_grow_by_turns() {
    let mut tape = Tape::new();
    let entries = if cfg!(miri) { 50 } else { 1000 };
    let outer = gradient(
        |x| {
            let mut product = x[0];
            let inner = tape.record(&[1.0], |y| {
                let mut inner = y[0];
                for _ in 0..entries {
                    inner = Var::dot(&[inner, y[0]], &[1.0, 1.0]);
                    product = Var::sum_of(&[product, x[0]]);
                }
                inner
            });
            product * Var::constant(inner.value())
        },
        &[1.0],
    );
    let count = f64::from(entries) + 1.0;
    assert_eq!(outer, [count * count]);
    assert_eq!(tape.len(), 1 + entries as usize);
}
