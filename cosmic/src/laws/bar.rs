//! Force laws along bars: the trait [`BarForce`] and the kernels of its laws.

use autodiff::Real;
use autodiff_programs::kernels::vjp_by_duals;
use autodiff_programs::{Compiled, Kernel, Pullback};

use super::law::Law;
use crate::geometry::{Vector, explicit_in};
use crate::lattice::EdgeVector;
use crate::{in_both_dimensions, kernel};

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

impl<R: Real> Bar<R> {
    /// Describes a bar by its length, the rate of its length, its activation, stiffness, rest length and strain at full
    /// activation, and the largest strain of the actuator material.
    #[inline(always)]
    pub(super) fn new(
        [length, rate]: [R; 2],
        [activation, stiffness, rest_length, strain]: [R; 4],
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
/// file formats need no further code. [`on_bars`](super::on_bars) makes it a law that scenes choose by
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
/// let law: Prestress = scene.physics.forces.along_bars().expect("the scene has chosen the law");
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
    #[inline(always)]
    fn tension_vjp<R: Real, const M: usize>(
        tension: &Tension<Self>,
        at: Pullback<R, 6, 2, M>,
    ) -> [[R; 6]; M] {
        vjp_by_duals(tension, at)
    }

    /// Like [`tension_vjp`](Self::tension_vjp), in space.
    #[inline(always)]
    fn tension_vjp_in_space<R: Real, const M: usize>(
        tension: &Tension<Self>,
        at: Pullback<R, 7, 3, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(tension, at)
    }
}

/// The kernel of a law along bars. It computes the impulse (N s) that an edge's bar gives to the first node of the edge
/// during a step. The inputs are the vector along the edge (m), the activation, the stiffness (N/m), the rest length
/// (m) and the strain at full activation. The uniform inputs are the law's settings.
#[derive(Clone, Debug)]
pub struct Tension<L> {
    /// The law.
    pub law: L,
    /// The time for which the bar pulls on its nodes, s.
    pub dt: f64,
    /// The [softening](crate::lattice::Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The largest strain of the actuator material.
    pub largest_strain: f64,
}

/// The four numbers of a list.
#[inline(always)]
pub(super) fn four<R: Real>(numbers: &[R]) -> [R; 4] {
    [numbers[0], numbers[1], numbers[2], numbers[3]]
}

impl<L: BarForce> Tension<L> {
    /// The impulse of a bar whose ends have no velocity.
    #[inline(always)]
    fn still<R: Real, const D: usize>(&self, x: &[R], settings: &[R]) -> [R; D] {
        let ([d], given) = Vector::split(x);
        let dv = Vector::zero();
        self.impulse(EdgeVector { d, dv }, four(given), settings)
            .array()
    }

    #[inline(always)]
    fn impulse<R: Real, const D: usize>(
        &self,
        edge: EdgeVector<R, D>,
        given: [R; 4],
        settings: &[R],
    ) -> Vector<R, D> {
        let length = edge.length(self.softening);
        let rate = match L::NEEDS_RATE {
            true => edge.rate(length),
            false => R::zero(),
        };
        let bar = Bar::new([length, rate], given, self.largest_strain);
        let per_length = L::tension(&self.law.of(settings), bar) * R::lit(self.dt) / length;
        edge.d * per_length
    }
}

#[kernel]
impl<L: BarForce> Kernel<6, 2> for Tension<L> {
    const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(2));
    const UNIFORMS: usize = L::COUNT;

    fn eval<R: Real>(&self, x: [R; 6], settings: &[R]) -> [R; 2] {
        self.still::<R, 2>(&x, settings)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 6, 2, M>) -> [[R; 6]; M] {
        L::tension_vjp(self, at)
    }
}

#[kernel]
impl<L: BarForce> Kernel<7, 3> for Tension<L> {
    const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(3));
    const UNIFORMS: usize = L::COUNT;

    fn eval<R: Real>(&self, x: [R; 7], settings: &[R]) -> [R; 3] {
        self.still::<R, 3>(&x, settings)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 7, 3, M>) -> [[R; 7]; M] {
        L::tension_vjp_in_space(self, at)
    }
}

/// Like [`Tension`], for a law with [`BarForce::NEEDS_RATE`]. Its second input, after the vector along the edge, is the
/// velocity of one end relative to the other (m/s).
#[derive(Clone, Debug)]
pub struct MovingTension<L>(pub Tension<L>);

in_both_dimensions! { D =>
    #[kernel]
    impl<L: BarForce> Kernel<{ 2 * D + 4 }, D> for MovingTension<L> {
        const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(D));
        const UNIFORMS: usize = L::COUNT;

        fn eval<R: Real>(&self, x: [R; 2 * D + 4], settings: &[R]) -> [R; D] {
            let (edge, given) = EdgeVector::<R, D>::split(&x);
            self.0.impulse(edge, four(given), settings).array()
        }
    }
}
