//! Tapes of more number types than a process supports. This is a separate binary, because the types are counted for
//! the whole process.

use std::panic::catch_unwind;

use autodiff::{Dual, Real, Tape};

/// Creates tapes of a number type, and of types built on it.
trait Tapes {
    fn of<R: Real>();
}

struct Nothing;

impl Tapes for Nothing {
    fn of<R: Real>() {}
}

/// Creates a tape of the type itself, and lets `T` create tapes of two dual types on top of it.
struct Doubled<T>(T);

impl<T: Tapes> Tapes for Doubled<T> {
    fn of<R: Real>() {
        Tape::<R>::new();
        T::of::<Dual<R, 1>>();
        T::of::<Dual<R, 2>>();
    }
}

/// 1 + 2 + 4 + ... + 128 = 255 types.
type AsManyAsFit = Doubled<Doubled<Doubled<Doubled<Doubled<Doubled<Doubled<Doubled<Nothing>>>>>>>>;

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn one_number_type_too_many_is_told() {
    AsManyAsFit::of::<f64>();
    let message = catch_unwind(Tape::<f32>::new).err().expect("a refusal");
    let message = message
        .downcast::<String>()
        .expect("a sentence with numbers");
    assert_eq!(
        *message,
        "this process has recorded on tapes of 255 number types, which is the maximum"
    );
    // Types that already have a tape must still work, even after a refusal.
    AsManyAsFit::of::<f64>();
    let x = Dual::<f64, 2>::constant(3.0);
    let mut tape = Tape::new();
    let y = tape.record(&[x], |x| x[0] * x[0]);
    assert_eq!(tape.pullback(&[y], &[x])[0].value, 18.0);
}
