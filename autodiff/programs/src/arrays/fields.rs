//! Numbers of a kernel with names in place of positions.

/// A struct whose fields are numbers: the inputs or the results of a [`Kernel`](crate::Kernel), by name. `T` is a number
/// while the kernel is evaluated, and an [`Array`](crate::Array) while a step is recorded.
///
/// Derive it for a struct whose first type parameter is `T` and which has no other type parameters. A field is a `T`, an
/// array `[T; N]`, or another struct with this trait. The declaration is the only place that has the order of the numbers.
///
/// An `impl` of `Kernel` then says `_` in place of the numbers of inputs and results, and the attribute
/// [`kernel`](macro@crate::kernel) counts them. They are what `eval` takes and returns: such a struct, a single number or an
/// array of numbers. To everybody else, the kernel is one of arrays of numbers. So its caller passes the
/// [`array`](Self::array) of the struct, and reads the results by [`of`](Self::of).
///
/// ```
/// use autodiff::{Real, Var, gradient};
/// use autodiff_programs::{Array, Fields, Kernel, Model, Program, Rollout, kernel};
///
/// #[derive(Clone, Copy, Fields)]
/// struct Motion<T> {
///     /// The position, m.
///     x: T,
///     /// The velocity, m/s.
///     v: T,
/// }
///
/// #[derive(Clone, Copy, Fields)]
/// struct Pulled<T> {
///     motion: Motion<T>,
///     /// The stiffness per mass, 1/s^2.
///     stiffness: T,
/// }
///
/// /// A step of 0.01 s of an oscillator.
/// struct Spring;
///
/// #[kernel]
/// impl Kernel<_, _> for Spring {
///     fn eval<R: Real>(&self, given: Pulled<R>, _: &[R]) -> Motion<R> {
///         let Motion { x, v } = given.motion;
///         let v = v - R::lit(0.01) * given.stiffness * x;
///         Motion { x: x + R::lit(0.01) * v, v }
///     }
/// }
///
/// #[derive(Clone)]
/// struct Oscillator;
///
/// impl Model for Oscillator {
///     fn record(&self, program: &mut Program) {
///         let stiffness = program.parameter(1);
///         let motion = Motion { x: program.state(1), v: program.state(1) };
///         let given = Pulled { motion, stiffness };
///         let next = Motion::of(program.map(Spring, given.array(), &[]));
///         program.advance(motion.x, next.x);
///         program.advance(motion.v, next.v);
///     }
/// }
///
/// let rollout = Rollout::new(Oscillator, 100);
/// let place = |k: &[Var<f64>]| rollout.run(&[Var::lit(1.0), Var::lit(0.0)], &[k])[0];
/// // The place after one second is about cos(sqrt(k)).
/// let slope = gradient(place, &[4.0])[0];
/// assert!((slope + 2.0_f64.sin() / 4.0).abs() < 0.01);
/// ```
///
/// A [`Kernel::vjp`](crate::Kernel::vjp) of your own says `_` too: `fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _,
/// M>) -> [[R; _]; M]`.
///
/// Like `#[derive(Parameters)]`, the macros find the name of the dependency `cosmic-autodiff-programs` in the manifest; below
/// either of them, `#[autodiff(crate = "path")]` names another path.
pub trait Fields<T: Copy>: Sized {
    /// The number of numbers.
    const COUNT: usize;

    /// Takes the numbers from the beginning of a list.
    ///
    /// # Panics
    /// If the list has fewer numbers.
    fn first_of(numbers: &[T]) -> Self;

    /// Writes the numbers to the beginning of a list.
    ///
    /// # Panics
    /// If the list has fewer numbers.
    fn write(self, numbers: &mut [T]);

    /// Any of the numbers, with which [`array`](Self::array) fills the array that it writes to.
    #[doc(hidden)]
    fn any(&self) -> T;

    /// The struct with these numbers. Another length than [`COUNT`](Self::COUNT) does not compile.
    #[inline(always)]
    fn of<const N: usize>(numbers: [T; N]) -> Self {
        const { assert!(N == Self::COUNT, "one number for each field") };
        Self::first_of(&numbers)
    }

    /// The numbers. Another length than [`COUNT`](Self::COUNT) does not compile.
    #[inline(always)]
    fn array<const N: usize>(self) -> [T; N] {
        const { assert!(N == Self::COUNT, "one number for each field") };
        let mut numbers = [self.any(); N];
        self.write(&mut numbers);
        numbers
    }

    /// The numbers as a list.
    fn list(self) -> Vec<T> {
        let mut numbers = vec![self.any(); Self::COUNT];
        self.write(&mut numbers);
        numbers
    }
}

impl<T: Copy> Fields<T> for T {
    const COUNT: usize = 1;

    #[inline(always)]
    fn first_of(numbers: &[T]) -> T {
        numbers[0]
    }

    #[inline(always)]
    fn write(self, numbers: &mut [T]) {
        numbers[0] = self;
    }

    #[inline(always)]
    fn any(&self) -> T {
        *self
    }
}

// Loops, because closures and `copy_from_slice` might be compiled without the caller's instruction set.
impl<T: Copy, const N: usize> Fields<T> for [T; N] {
    const COUNT: usize = N;

    #[inline(always)]
    #[expect(clippy::manual_memcpy, reason = "loops are inlined")]
    fn first_of(numbers: &[T]) -> Self {
        let mut own = [numbers[0]; N];
        for k in 0..N {
            own[k] = numbers[k];
        }
        own
    }

    #[inline(always)]
    #[expect(clippy::manual_memcpy, reason = "loops are inlined")]
    fn write(self, numbers: &mut [T]) {
        for k in 0..N {
            numbers[k] = self[k];
        }
    }

    #[inline(always)]
    fn any(&self) -> T {
        self[0]
    }
}
