//! Parameters in structures: nested structs, arrays and matrices of numbers instead of one long slice.
//!
//! With the feature `derive`, `#[derive(Parameters)]` implements [`Parameters`] for a struct that is generic over its
//! number type. [`value_and_gradient`] then takes and returns the struct itself, and [`names`](Parameters::names) gives
//! a gradient check the name of each number.
//!
//! - Your `Cargo.toml` may give this crate another name. If it inherits that name from a workspace, or you use the crate
//!   through another one, name the path: `#[autodiff(crate = "other::autodiff")]` below the `derive`.
//! - The struct may also have lifetime and constant parameters, but no other type parameters.
//! - Bounds on the number type must follow from [`Real`].
//! - Fields may be numbers, other structs with `Parameters`, and `Vec`s, arrays, `Option`s and `Arc`s of these. With
//!   the feature `nalgebra` they may be elements, matrices and vectors.
//! - Fields whose type does not mention the number type are copied, also into a gradient.
//!
//! ```
//! # #[cfg(feature = "derive")] {
//! use autodiff::check::{Options, check_gradient};
//! use autodiff::{Function, Parameters, Real, Var, parameters};
//!
//! #[derive(Clone, Debug, PartialEq, Parameters)]
//! struct Layer<R> {
//!     weights: Vec<[R; 2]>,
//!     bias: R,
//! }
//!
//! #[derive(Clone, Debug, PartialEq, Parameters)]
//! struct Network<R> {
//!     hidden: Layer<R>,
//!     output: [R; 2],
//!     steps: usize, // not a number: copied
//! }
//!
//! fn energy<R: Real>(network: &Network<R>) -> R {
//!     let rows = network.hidden.weights.iter().zip(network.output);
//!     rows.map(|(row, gain)| gain * (R::dot(row, &[R::one(); 2]) + network.hidden.bias).tanh()).sum()
//! }
//!
//! let at = Network {
//!     hidden: Layer { weights: vec![[0.5, 0.0], [1.0, -1.0]], bias: 0.25 },
//!     output: [1.0, 2.0],
//!     steps: 3,
//! };
//! let (_, gradient) = parameters::value_and_gradient(energy, &at);
//! assert_eq!(gradient.output, [0.75f64.tanh(), 0.25f64.tanh()]);
//!
//! // As a function of a slice, for every other driver.
//! struct Energy(Network<f64>);
//! impl Function for Energy {
//!     fn eval<R: Real>(&self, x: &[R]) -> R {
//!         energy(&self.0.with(x))
//!     }
//! }
//! assert_eq!(at.names()[3], "hidden.weights[1][1]");
//! let report = check_gradient(&Energy(at.clone()), &at.flatten(), &Options::named(at.names()));
//! assert!(report.to_string().contains("smooth"), "{report}");
//! # }
//! ```

use std::fmt::Write;
use std::sync::Arc;

use crate::drivers;
use crate::real::Real;
use crate::reverse::Var;

#[cfg(feature = "derive")]
pub use autodiff_derive::Parameters;

/// A structure whose numbers have the type `R`. See the [module](self).
pub trait Parameters<R: Real> {
    /// The same structure with numbers of another type.
    type With<S: Real>: Parameters<S>;

    /// Returns the structure with every number replaced by `walk`, in a fixed order. If you implement this method
    /// yourself, call [`Walk::field`] for each part.
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S>;

    /// Returns the structure with `f` applied to every number, for example [`Real::lit`] to lift a structure of `f64`.
    fn map<S: Real>(&self, mut f: impl FnMut(R) -> S) -> Self::With<S>
    where
        Self: Sized,
    {
        self.map_numbers(&mut Walk::new(&mut |_: &[Step<'_>], number| f(number)))
    }

    /// Returns all numbers in the order of [`map_numbers`](Self::map_numbers).
    fn flatten(&self) -> Vec<R> {
        let mut numbers = Vec::new();
        let visit = &mut |_: &[Step<'_>], number| {
            numbers.push(number);
            number
        };
        self.map_numbers::<R>(&mut Walk::new(visit));
        numbers
    }

    /// Returns the names of all numbers, for example `hidden.weights[1][0]`.
    fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        let visit = &mut |path: &[Step<'_>], number| {
            names.push(name(path));
            number
        };
        let mut walk = Walk::new(visit);
        walk.is_named = true;
        self.map_numbers::<R>(&mut walk);
        names
    }

    /// Returns the same structure with the given numbers, in the order of [`flatten`](Self::flatten).
    ///
    /// # Panics
    /// If `numbers` has more or fewer entries than the structure has numbers.
    #[track_caller]
    fn with<S: Real>(&self, numbers: &[S]) -> Self::With<S> {
        let (mut rest, mut missing) = (numbers.iter(), false);
        let visit = &mut |_: &[Step<'_>], _| match rest.next() {
            Some(&number) => number,
            None => {
                missing = true;
                S::zero()
            }
        };
        let structure = self.map_numbers(&mut Walk::new(visit));
        let given = numbers.len();
        if missing {
            let first = &self.names()[given];
            panic!("{given} numbers are too few for the structure: none is left for `{first}`");
        }
        let left = rest.len();
        assert!(
            left == 0,
            "{left} of {given} numbers do not fit into the structure; give as many as `flatten` returns"
        );
        structure
    }
}

/// Returns the value and the gradient of a function of a structure, by one reverse sweep. The gradient has the form of
/// the structure.
#[track_caller]
pub fn value_and_gradient<R: Real, P: Parameters<R, With<R> = P>>(
    function: impl FnOnce(&P::With<Var<R>>) -> Var<R>,
    at: &P,
) -> (R, P) {
    let (value, gradient) = drivers::value_and_gradient(|x| function(&at.with(x)), &at.flatten());
    (value, at.with(&gradient))
}

/// Returns the gradient of a function of a structure. The gradient has the form of the structure.
#[track_caller]
pub fn gradient<R: Real, P: Parameters<R, With<R> = P>>(
    function: impl FnOnce(&P::With<Var<R>>) -> Var<R>,
    at: &P,
) -> P {
    value_and_gradient(function, at).1
}

/// One step on the path from the structure to a number: a field or an index.
#[derive(Clone, Copy)]
enum Step<'a> {
    Field(&'a str),
    Index(usize),
}

fn name(path: &[Step<'_>]) -> String {
    let mut name = String::new();
    for step in path {
        // Writing to a string cannot fail.
        let _ = match step {
            Step::Field(field) if name.is_empty() => write!(name, "{field}"),
            Step::Field(field) => write!(name, ".{field}"),
            Step::Index(index) => write!(name, "[{index}]"),
        };
    }
    name
}

/// Walks through a structure of numbers of type `R` and builds the same structure with numbers of type `S`.
pub struct Walk<'a, R, S> {
    path: Vec<Step<'a>>,
    /// Whether the path is kept. It takes longer than the walk.
    is_named: bool,
    visit: &'a mut dyn FnMut(&[Step<'a>], R) -> S,
}

impl<'a, R: Real, S: Real> Walk<'a, R, S> {
    fn new(visit: &'a mut dyn FnMut(&[Step<'a>], R) -> S) -> Self {
        Self {
            path: Vec::new(),
            is_named: false,
            visit,
        }
    }

    /// Returns a field in which each number is replaced. `name` is the name of the field.
    pub fn field<P: Parameters<R>>(&mut self, name: &'a str, part: &P) -> P::With<S> {
        self.part(Step::Field(name), part)
    }

    /// Returns an element of a list in which each number is replaced. `index` is the element's index.
    pub fn element<P: Parameters<R>>(&mut self, index: usize, part: &P) -> P::With<S> {
        self.part(Step::Index(index), part)
    }

    fn part<P: Parameters<R>>(&mut self, step: Step<'a>, part: &P) -> P::With<S> {
        if !self.is_named {
            return part.map_numbers(self);
        }
        self.path.push(step);
        let part = part.map_numbers(self);
        self.path.pop();
        part
    }

    fn number(&mut self, number: R) -> S {
        (self.visit)(&self.path, number)
    }
}

impl<R: Real> Parameters<R> for R {
    type With<S: Real> = S;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> S {
        walk.number(*self)
    }
}

impl<R: Real, P: Parameters<R>> Parameters<R> for Option<P> {
    type With<S: Real> = Option<P::With<S>>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        self.as_ref().map(|part| part.map_numbers(walk))
    }
}

/// Structures that shared a part have a copy of it each afterwards.
impl<R: Real, P: Parameters<R>> Parameters<R> for Arc<P> {
    type With<S: Real> = Arc<P::With<S>>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        Arc::new((**self).map_numbers(walk))
    }
}

impl<R: Real, P: Parameters<R>> Parameters<R> for Vec<P> {
    type With<S: Real> = Vec<P::With<S>>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        let elements = self.iter().enumerate();
        elements
            .map(|(index, part)| walk.element(index, part))
            .collect()
    }
}

impl<R: Real, P: Parameters<R>, const N: usize> Parameters<R> for [P; N] {
    type With<S: Real> = [P::With<S>; N];
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        std::array::from_fn(|index| walk.element(index, &self[index]))
    }
}
