//! The numbers in the settings of a law, as inputs of a step.

use autodiff::Real;

use super::value::Named;

/// Settings whose numbers are inputs of a step. A rollout can be differentiated with respect to these numbers, and
/// robots that are simulated together may have different numbers. [`settings!`](crate::settings!) implements this
/// trait: the numbers of `struct Mud<R>` are its fields of type `R`.
pub trait StepInputs: Sized {
    /// The type of the settings if their numbers have the type `R`.
    type Of<R: Real>;
    /// The number of inputs that the settings have.
    const COUNT: usize;

    /// The key and the value of each input. If the setting belongs to another section, its key begins with that
    /// section: `physics.friction`.
    fn inputs(&self) -> Vec<(String, f64)>;

    /// A copy of the settings whose inputs are `numbers`, in the order of [`inputs`](StepInputs::inputs).
    fn of<R: Real>(&self, numbers: &[R]) -> Self::Of<R>;

    /// A copy of the settings whose inputs are constants of the number type `R`.
    fn constant<R: Real>(&self) -> Self::Of<R> {
        let numbers = self.inputs().into_iter();
        self.of(&numbers.map(|(_, x)| R::lit(x)).collect::<Vec<_>>())
    }
}

/// The type of a field in the settings of a law. `N` is the type of the settings' numbers; `Out` is then the type of
/// the field.
#[doc(hidden)]
pub trait InputField<N, Out> {
    /// The number of inputs in the field; 0 for a field without inputs.
    const COUNT: usize = 0;
    /// The key and the value of each input in the field.
    fn inputs(&self, _key: &str) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// This field with new inputs, which are removed from the front of `numbers`.
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
