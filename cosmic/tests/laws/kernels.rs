//! Checks the adjoints of kernels.

use autodiff::check::{Along, Claim, Options, Verdict, check_directions};
use autodiff::{DoubleDouble, Dual, Real};
use autodiff_programs::kernels::Fixed;
use autodiff_programs::{Kernel, Pullback};
use cosmic::kernel;
use cosmic::laws::kernels::{Flying, Surface};
use cosmic::laws::{Contact, Drift, Law};

/// The time step of the tests, s.
pub(super) const DT: f64 = 0.002;

/// Computes the cotangents of a kernel's inputs at `x` from the cotangents `y_bar` of its outputs.
pub(super) fn adjoint<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    y_bar: [f64; O],
) -> [f64; I] {
    let [x_bar] = kernel.vjp(Pullback::new(kernel, x, &[], [y_bar]));
    x_bar
}

/// Compares the adjoint of a kernel with dual numbers and finite differences, for a fixed cotangent. The adjoint is
/// multiplied by `1 + wrong_by`: with `wrong_by` not 0, a test can check that the comparison notices a wrong adjoint.
pub(super) fn verdict<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    wrong_by: f64,
) -> Verdict {
    let y_bar: [f64; O] = std::array::from_fn(|k| 1.0 - 0.4 * k as f64);
    let value = |x: &[DoubleDouble]| {
        let y = kernel.eval::<DoubleDouble>(std::array::from_fn(|i| x[i]), &[]);
        DoubleDouble::dot(&y, &y_bar)
    };
    let forward = |direction: &[f64]| {
        let y = kernel.eval::<Dual<f64, 1>>(
            std::array::from_fn(|i| Dual {
                value: x[i],
                tangent: [direction[i]],
            }),
            &[],
        );
        y.iter().zip(y_bar).map(|(y, bar)| y.tangent[0] * bar).sum()
    };
    let gradient = adjoint(kernel, x, y_bar).map(|bar| bar * (1.0 + wrong_by));
    // A wrong gradient must be noticed by the finite differences alone.
    let forward: Option<Along> = (wrong_by == 0.0).then_some(&forward);
    let claim = Claim {
        x: &x,
        gradient: &gradient,
        forward,
    };
    // The check needs many directions, because slopes differ by factors of thousands: an impulse is divided by a mass
    // of grams.
    let options = Options {
        directions: 16,
        ..Options::default()
    };
    let report = check_directions(value, &claim, &options);
    println!("{report}");
    report.verdict
}

/// Asserts that the adjoint of a kernel is right, and that the comparison would notice a wrong one.
pub(super) fn is_right<K: Kernel<I, O>, const I: usize, const O: usize>(kernel: &K, x: [f64; I]) {
    assert_eq!(verdict(kernel, x, 0.0), Verdict::Smooth);
    assert_eq!(verdict(kernel, x, 0.01), Verdict::Wrong);
}

/// The values of a law's settings.
pub(super) fn values(law: &impl Law) -> Vec<f64> {
    law.inputs().into_iter().map(|(_, value)| value).collect()
}

/// A drift without a push: a kernel that maps the node `[x, y, vx, vy]` to the node after it.
pub(super) struct Drifting<C, G>(Fixed<Flying<C, G>>);

impl<C: Contact, G: Surface> Drifting<C, G> {
    pub(super) fn new(contact: C, ground: G) -> Self {
        Self(Fixed {
            uniforms: [vec![0.0, 0.0, 1.0], values(&contact)].concat(),
            kernel: Flying {
                drift: Drift { dt: DT },
                contact,
                ground,
            },
        })
    }
}

/// The inputs of [`Flying`] for a node that gets no impulse.
fn not_pushed<R: Real>([x, y, vx, vy]: [R; 4]) -> [R; 7] {
    [x, y, vx, vy, R::zero(), R::zero(), R::one()]
}

#[kernel]
impl<C: Contact, G: Surface> Kernel<4, 4> for Drifting<C, G> {
    fn eval<R: Real>(&self, node: [R; 4], _: &[R]) -> [R; 4] {
        self.0.eval(not_pushed(node), &[])
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        let at = Pullback::new(&self.0, not_pushed(at.x), &[], at.y_bar);
        self.0.vjp(at).map(|[x, y, vx, vy, ..]| [x, y, vx, vy])
    }
}
