//! The settings of a law as inputs of a step.

use autodiff::Real;

use super::value::Named;

/// Settings whose numbers are inputs of a step: a rollout can be differentiated with respect to them, and robots of one
/// batch may differ in them. [`settings!`](crate::settings!) implements it: the numbers of `struct Mud<R>` are its
/// fields of type `R`.
pub trait Inputs: Sized {
    /// These settings with numbers of type `R`.
    type Of<R: Real>;
    /// The number of inputs.
    const COUNT: usize;

    /// The key and value of each input. A key with a point names its section too: `physics.friction`.
    fn inputs(&self) -> Vec<(String, f64)>;

    /// These settings with other numbers, in the order of [`inputs`](Inputs::inputs).
    fn of<R: Real>(&self, numbers: &[R]) -> Self::Of<R>;

    /// These settings with their numbers as constants of type `R`.
    fn constant<R: Real>(&self) -> Self::Of<R> {
        let numbers = self.inputs().into_iter();
        self.of(&numbers.map(|(_, x)| R::lit(x)).collect::<Vec<_>>())
    }
}

/// The type of a field of settings. If the numbers of the settings get the type `N`, the field gets the type `Out`.
#[doc(hidden)]
pub trait InputField<N, Out> {
    /// The number of inputs in the field; 0 for a field without inputs.
    const COUNT: usize = 0;
    /// The key and value of each input in the field.
    fn inputs(&self, _key: &str) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// The field with its inputs taken from the front of `numbers`.
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
