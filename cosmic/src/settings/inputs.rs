//! The settings of a law as inputs of a step.

use autodiff::Real;

use super::value::Named;

/// Settings whose numbers are inputs of a step: a rollout can be differentiated by them, and robots of one batch may
/// differ in them. [`settings!`](crate::settings!) implements it: the numbers of `struct Mud<R>` are its fields of
/// type `R`.
pub trait Inputs: Sized {
    /// These settings with numbers of type `R`.
    type Of<R: Real>;
    /// How many numbers are inputs.
    const COUNT: usize;

    /// The key and value of each input. A key with a point names its section too: `physics.friction`.
    fn inputs(&self) -> Vec<(String, f64)>;

    /// These settings with other numbers, in the order of [`inputs`](Inputs::inputs).
    fn of<R: Real>(&self, numbers: &[R]) -> Self::Of<R>;

    /// These settings with their own numbers as constants.
    fn constant<R: Real>(&self) -> Self::Of<R> {
        let numbers = self.inputs().into_iter();
        self.of(&numbers.map(|(_, x)| R::lit(x)).collect::<Vec<_>>())
    }
}

/// A field of settings that become an `Out` if their numbers become an `N`.
#[doc(hidden)]
pub trait InputField<N, Out> {
    /// How many numbers it has; 0 for a field that stays.
    const COUNT: usize = 0;
    /// The key and value of each number.
    fn inputs(&self, _key: &str) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// The field with the next of some numbers.
    fn of(&self, numbers: &mut &[N]) -> Out;
}

impl<N: Real> InputField<N, N> for f64 {
    const COUNT: usize = 1;
    fn inputs(&self, key: &str) -> Vec<(String, f64)> {
        vec![(key.to_owned(), *self)]
    }
    #[inline(always)]
    fn of(&self, numbers: &mut &[N]) -> N {
        let number = numbers[0];
        *numbers = &numbers[1..];
        number
    }
}

impl<N: Real, const K: usize> InputField<N, [N; K]> for [f64; K] {
    const COUNT: usize = K;
    fn inputs(&self, key: &str) -> Vec<(String, f64)> {
        let numbers = self.iter().enumerate();
        numbers
            .map(|(k, &number)| (format!("{key}[{k}]"), number))
            .collect()
    }
    #[inline(always)]
    fn of(&self, numbers: &mut &[N]) -> [N; K] {
        let mut own = [N::zero(); K];
        own.copy_from_slice(&numbers[..K]);
        *numbers = &numbers[K..];
        own
    }
}

macro_rules! stays {
    ($($Type:ty)*) => {
        $(impl<N> InputField<N, $Type> for $Type {
            #[inline(always)]
            fn of(&self, _: &mut &[N]) -> $Type {
                *self
            }
        })*
    };
}
stays! { bool usize Option<f64> }

impl<N, T: Named + Copy> InputField<N, T> for T {
    #[inline(always)]
    fn of(&self, _: &mut &[N]) -> T {
        *self
    }
}
