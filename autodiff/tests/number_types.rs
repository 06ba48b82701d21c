//! Creates tapes of more number types than a process supports. This test is a separate binary, because the types are
//! counted for the whole process.

use std::panic::catch_unwind;

use autodiff::{Dual, Real, Tape};

/// Creates tapes of a number type, and of dual types that are built on it.
trait Tapes {
    fn of<R: Real>();
}

struct Nothing;

impl Tapes for Nothing {
    fn of<R: Real>() {}
}

/// Creates a tape of the number type itself. Then `T` creates tapes for two dual types that are built on it.
struct Doubled<T>(T);

impl<T: Tapes> Tapes for Doubled<T> {
    fn of<R: Real>() {
        Tape::<R>::new();
        T::of::<Dual<R, 1>>();
        T::of::<Dual<R, 2>>();
    }
}

/// Creates tapes of 1 + 2 + 4 + ... + 128 = 255 number types.
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
        "this process has recorded on tapes of 255 number types, which is the maximum; \
         use fewer number types, for example fewer widths of `Dual` and fewer nestings"
    );
    // Number types that already have a tape must still work after another type was refused.
    AsManyAsFit::of::<f64>();
    let x = Dual::<f64, 2>::constant(3.0);
    let mut tape = Tape::new();
    let y = tape.record(&[x], |x| x[0] * x[0]);
    assert_eq!(tape.pullback(&[y], &[x])[0].value, 18.0);
}
