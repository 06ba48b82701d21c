//! Force laws along bars: the trait [`BarForce`] and the kernels of its laws.

use autodiff::Real;
use autodiff_programs::kernels::vjp_by_duals;
use autodiff_programs::{Compiled, Kernel, Pullback};

use crate::geometry::{Vector, explicit_in};
use crate::lattice::EdgeVector;
use crate::laws::law::Law;
use crate::{Fields, in_both_dimensions, kernel};

/// A bar as a law sees it: the numbers that the tension may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Bar<R> {
    /// Current length, m.
    pub length: R,
    /// Rate at which the length grows, m/s; 0 unless the law [asks for it](BarForce::NEEDS_RATE).
    pub rate: R,
    /// Target length of the spring (D8), m: the length that the actuator sets, or the rest length of a passive bar.
    pub target: R,
    /// Length at rest, m.
    pub rest_length: R,
    /// Stiffness of the bar, N/m, which its materials determine; almost 0 for a void edge.
    pub stiffness: R,
    /// Strain of the target length at full activation: the largest strain of the actuator material, times the share of
    /// that material in the bar. It is 0 for a passive bar and does not depend on the activation.
    pub strain: R,
    /// The largest strain of the actuator material, the same for all bars. It is above 0.
    pub largest_strain: f64,
}

/// The numbers of an edge that forces along bars read.
#[derive(Clone, Copy, Debug, Fields)]
pub struct EdgeNumbers<T> {
    /// The controller's output.
    pub activation: T,
    /// Stiffness, N/m.
    pub stiffness: T,
    /// Rest length, m.
    pub rest_length: T,
    /// Strain at full activation.
    pub strain: T,
}

impl<R: Real> Bar<R> {
    /// Describes a bar by its length, the rate of its length, the numbers of its edge, and the largest strain of the actuator
    /// material.
    #[inline(always)]
    pub(in crate::laws) fn new(
        [length, rate]: [R; 2],
        EdgeNumbers {
            activation,
            stiffness,
            rest_length,
            strain,
        }: EdgeNumbers<R>,
        largest_strain: f64,
    ) -> Self {
        Self {
            length,
            rate,
            // Equation D8.
            target: rest_length * strain.fma(activation, R::one()),
            rest_length,
            stiffness,
            strain,
            largest_strain,
        }
    }

    /// The share of the actuator material in the bar, from 0 to 1.
    #[inline(always)]
    pub fn share_of_actuator(&self) -> R {
        self.strain * R::lit(self.largest_strain).recip()
    }

    /// The tension of the bar's own spring by Hooke's law, N.
    #[inline(always)]
    pub fn spring(&self) -> R {
        self.stiffness * (self.length - self.target)
    }
}

/// A force along every bar, which is *added* to the force of the bar's own spring. The spring follows Hooke's law. A law
/// that replaces the spring subtracts [`Bar::spring`]. The forces of several laws along bars add up.
///
/// To write a law, give it [settings](Law) and [`tension`](BarForce::tension). Derivatives, SIMD lanes and
/// file formats need no further code. [`on_bars`](crate::laws::on_bars) makes it a law that scenes choose by
/// `physics.forces = ["its_name"]`, with its settings in the section `[its_name]`. The law acts on void edges
/// too: scale the force with [`Bar::stiffness`] or [`Bar::strain`] if void edges must not pull.
///
/// The `impl` needs the attribute [`kernel`](macro@crate::kernel), and so do functions that the methods call.
///
/// ```
/// use autodiff::Real;
/// use cosmic::kernel;
/// use cosmic::laws::{Bar, BarForce, Law, on_bars};
/// use cosmic::settings::within;
///
/// cosmic::settings! {
///     /// Bars are prestressed: each bar pulls a little at any length.
///     struct Prestress<R> {
///         /// Tension, relative to the tension that stretches the bar to twice its length.
///         share: R = 0.01, allowed within(0.0, 1.0), source "an example";
///     }
/// }
///
/// impl Law for Prestress {
///     const NAME: &'static str = "prestress";
/// }
///
/// #[kernel]
/// impl BarForce for Prestress {
///     fn tension<R: Real>(prestress: &Prestress<R>, bar: Bar<R>) -> R {
///         prestress.share * bar.stiffness * bar.rest_length
///     }
/// }
///
/// let registry = cosmic::Registry::default().with_law(on_bars::<Prestress>());
/// let scene = registry.parse("own", "physics.forces = ['prestress']\nprestress.share = 0.02")?;
/// let law: Prestress = scene.physics.forces.chosen().expect("the scene has chosen the law");
/// // It adds 0.02 * 400 N/m * 0.1 m to the tension of a skeleton bar that is 0.1 m long.
/// let bar = Bar {
///     length: 0.1, rate: 0.0, target: 0.1, rest_length: 0.1, stiffness: 400.0, strain: 0.0, largest_strain: 0.35,
/// };
/// assert!((Prestress::tension(&law, bar) - 0.8).abs() < 1e-12);
/// # Ok::<(), cosmic::Error>(())
/// ```
pub trait BarForce: Law {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// The noun that messages about this law use for the bar, such as "spring".
    const NOUN: &'static str = Self::NAME;
    /// True if [`tension`](BarForce::tension) reads [`Bar::rate`].
    const NEEDS_RATE: bool = false;

    /// The force, N, with which the bar pulls its ends together in addition to its spring; a negative force pushes them
    /// apart. `law` has the settings as numbers of the type `R`. The method must not branch on a [`Real`]; use
    /// `R::select` instead.
    fn tension<R: Real>(law: &Self::Of<R>, bar: Bar<R>) -> R;

    /// The potential energy of the bar, J. Its derivative with respect to the length is the tension. `None` if the law
    /// has no potential energy.
    fn energy(&self, _bar: Bar<f64>) -> Option<f64> {
        None
    }

    /// The adjoint of the kernel [`Tension`]. The default works for every law; a [generated](autodiff_programs::emit) adjoint is
    /// faster.
    #[doc(hidden)]
    #[inline(always)]
    fn tension_vjp<R: Real, const M: usize>(
        tension: &Tension<Self>,
        at: Pullback<R, 6, 2, M>,
    ) -> [[R; 6]; M] {
        vjp_by_duals(tension, at)
    }

    /// Like [`tension_vjp`](Self::tension_vjp), in space.
    #[doc(hidden)]
    #[inline(always)]
    fn tension_vjp_in_space<R: Real, const M: usize>(
        tension: &Tension<Self, 3>,
        at: Pullback<R, 7, 3, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(tension, at)
    }
}

/// A bar whose ends have no velocity.
#[derive(Clone, Copy, Debug, Fields)]
pub struct StillBar<T, const D: usize> {
    /// The vector along the edge, m.
    pub d: Vector<T, D>,
    /// The numbers of the edge.
    pub numbers: EdgeNumbers<T>,
}

/// A bar whose ends move.
#[derive(Clone, Copy, Debug, Fields)]
pub struct MovingBar<T, const D: usize> {
    /// The vector along the edge, and the velocity of one end relative to the other.
    pub edge: EdgeVector<T, D>,
    /// The numbers of the edge.
    pub numbers: EdgeNumbers<T>,
}

/// The kernel of a law along bars. It computes the impulse (N s) that an edge's bar gives to the first node of the edge
/// during a step, from a [`StillBar`]. The uniform inputs are the law's settings.
#[derive(Clone, Debug)]
pub struct Tension<L, const D: usize = 2> {
    /// The law.
    pub law: L,
    /// The time for which the bar pulls on its nodes, s.
    pub dt: f64,
    /// The [softening](crate::lattice::Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The largest strain of the actuator material.
    pub largest_strain: f64,
}

impl<L: BarForce, const D: usize> Tension<L, D> {
    /// The impulse of a bar whose ends have no velocity.
    #[inline(always)]
    fn still<R: Real>(&self, bar: StillBar<R, D>, settings: &[R]) -> Vector<R, D> {
        let StillBar { d, numbers } = bar;
        let dv = Vector::zero();
        let edge = EdgeVector { d, dv };
        self.impulse(MovingBar { edge, numbers }, settings)
    }

    #[inline(always)]
    fn impulse<R: Real>(&self, bar: MovingBar<R, D>, settings: &[R]) -> Vector<R, D> {
        let MovingBar { edge, numbers } = bar;
        let length = edge.length(self.softening);
        let rate = match L::NEEDS_RATE {
            true => edge.rate(length),
            false => R::zero(),
        };
        let bar = Bar::new([length, rate], numbers, self.largest_strain);
        let per_length = L::tension(&self.law.of(settings), bar) * R::lit(self.dt) / length;
        edge.d * per_length
    }
}

#[kernel]
impl<L: BarForce> Kernel<_, _> for Tension<L> {
    const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(2));
    const UNIFORMS: usize = L::COUNT;

    fn eval<R: Real>(&self, bar: StillBar<R, 2>, settings: &[R]) -> Vector<R, 2> {
        self.still(bar, settings)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        L::tension_vjp(self, at)
    }
}

#[kernel]
impl<L: BarForce> Kernel<_, _> for Tension<L, 3> {
    const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(3));
    const UNIFORMS: usize = L::COUNT;

    fn eval<R: Real>(&self, bar: StillBar<R, 3>, settings: &[R]) -> Vector<R, 3> {
        self.still(bar, settings)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        L::tension_vjp_in_space(self, at)
    }
}

/// Like [`Tension`], for a law with [`BarForce::NEEDS_RATE`]. It reads a [`MovingBar`].
#[derive(Clone, Debug)]
pub struct MovingTension<L, const D: usize = 2>(pub Tension<L, D>);

in_both_dimensions! { D =>
    #[kernel]
    impl<L: BarForce> Kernel<_, _> for MovingTension<L, D> {
        const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(D));
        const UNIFORMS: usize = L::COUNT;

        fn eval<R: Real>(&self, bar: MovingBar<R, D>, settings: &[R]) -> Vector<R, D> {
            self.0.impulse(bar, settings)
        }
    }
}
