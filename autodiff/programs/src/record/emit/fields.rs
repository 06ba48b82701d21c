//! Rejects kernels whose structure depends on a field.
//!
//! The printed code is made from one recording, with stand-ins for the fields, and used for all values of the fields.
//! So a field may only appear as a literal. It must not decide a branch, a loop or an exponent. To check this, the
//! kernel is recorded again with other field values. It must do the same operations, with the fields in the same
//! places.

use std::array::from_fn;
use std::f64::consts::E;

use crate::arrays::Kernel;
use crate::record::operation::{Op, Place};
use crate::record::recording::{Recording, record};
use crate::record::symbol::Symbol;

/// The values that the check gives to each field: numbers that code may treat as special, exponents and loop lengths,
/// and very small and very large magnitudes. Moderate values come first, so that the check fails before an enormous
/// value becomes the length of a loop.
const VALUES: [f64; 19] = [
    2.0,
    1.0,
    3.0,
    0.0,
    -1.0,
    -2.5,
    0.5,
    7.3,
    -40.0,
    1e3,
    -1e3,
    1e-9,
    -1e-9,
    1e9,
    -1e9,
    1e300,
    -1e300,
    f64::INFINITY,
    f64::NAN,
];

/// How many times the check changes all fields at once. This detects conditions on several fields.
const MIXTURES: usize = 200;

/// The operations that a kernel does for certain values of its fields.
struct Course {
    ops: Vec<Op>,
    results: Vec<Place>,
}

impl Course {
    fn of<K: Kernel<I, O>, const I: usize, const O: usize>(kernel: &K) -> Self {
        let (results, recording) = record(Recording::verbatim(), || {
            kernel
                .eval(from_fn(Symbol::input), &[])
                .map(|y| y.0)
                .to_vec()
        });
        let ops = recording.ops;
        Self { ops, results }
    }

    /// Compares with the course for other field values. `of` names the fields that differ.
    ///
    /// # Panics
    /// If the operations differ, or a literal that is not plus or minus a field.
    #[track_caller]
    fn compare(&self, other: &Self, [usual, values]: [&[f64]; 2], [name, of]: [&str; 2]) {
        let kind = |op: &Op| match op {
            Op::Constant(_) => Op::Constant(0),
            _ => *op,
        };
        let same = self.results == other.results
            && (self.ops.iter().map(kind)).eq(other.ops.iter().map(kind));
        assert!(
            same,
            "{of} the operations of the kernel {name}: they differ between the field values {usual:?} and \
             {values:?}, but the printed code is the same for all values. A field must not decide a branch, \
             a loop or an exponent: use `Real::select` for a choice, `powf` for an exponent, or a separate \
             kernel for each case"
        );
        let mut pairs = self.ops.iter().zip(&other.ops);
        let follows = |(op, got): (&Op, &Op)| follows(*op, *got, usual, values);
        assert!(
            pairs.all(follows),
            "{of} a literal of the kernel {name}, but the literal is not plus or minus a field, so \
             the printed code cannot compute it; make this number a separate field"
        );
    }
}

/// Checks that a kernel does the same operations for all values of its fields, and that each literal is plus or minus a
/// field or does not depend on the fields.
///
/// # Panics
/// If either check fails.
#[track_caller]
pub(super) fn check<K: Kernel<I, O>, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: &impl Fn(&[f64]) -> K,
) {
    let usual: Vec<f64> = stand_ins(E, fields.len()).collect();
    let expected = Course::of(&build(&usual));
    for (k, field) in fields.iter().enumerate() {
        for value in VALUES {
            let mut values = usual.clone();
            values[k] = value;
            let of = format!("`{field}` decides");
            expected.compare(&Course::of(&build(&values)), [&usual, &values], [name, &of]);
        }
    }
    for mixture in 1..=MIXTURES * usize::from(fields.len() > 1) {
        // Each field steps by a multiple of another irrational number, so that all combinations of values occur.
        let share = |step: f64| (mixture as f64 * step).fract();
        let values = stand_ins(E, fields.len()).map(share);
        let values = values.map(|share| VALUES[(share * VALUES.len() as f64) as usize]);
        let values: Vec<f64> = values.collect();
        let of = "the fields together decide";
        expected.compare(&Course::of(&build(&values)), [&usual, &values], [name, of]);
    }
}

/// Returns whether the operation `got` is the expected one. The fields have changed from the values `usual` to
/// `values`, and `op` is the operation for `usual`.
fn follows(op: Op, got: Op, usual: &[f64], values: &[f64]) -> bool {
    let (Op::Constant(before), Op::Constant(after)) = (op, got) else {
        return op == got;
    };
    let [before, after] = [before, after].map(f64::from_bits);
    let mut fields = usual.iter().zip(values);
    let expected = fields.find_map(|(&field, &value)| match before {
        _ if before == field => Some(value),
        _ if before == -field => Some(-value),
        _ => None,
    });
    let expected = expected.unwrap_or(before);
    after == expected || after.is_nan() && expected.is_nan()
}

/// Returns field values between 0 and 1 that are unlikely to be literals of any kernel.
pub(super) fn stand_ins(seed: f64, count: usize) -> impl Iterator<Item = f64> + Clone {
    (1..=count).map(move |k| (seed + k as f64).sqrt().fract())
}
