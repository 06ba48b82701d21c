//! The trap of the guard: what is absurd for a single step is seen after the last.

use autodiff::{Adjoint, Kernel, Real};

/// Half the distance (m) and speed (m/s) from which on a state is absurd. The trap takes the length
/// of position and velocity together in the ground's frame, which may be turned against the
/// world's: half is below every absurd number.
pub(super) const TRAP: f64 = 5e5;

/// A node's step with a trap: a node that is too fast after it or was too far before it, by
/// [`TRAP`], or is no number, has no speed from then on, and a step later no place; and so the last
/// state tells of every step, but of its own place. All other nodes get the same bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trapped<K>(pub(super) K);

/// Who looks at every node's step.
pub(super) trait Watch {
    /// The step, looked at.
    fn over<K: Adjoint<7, 4>>(kernel: K) -> impl Adjoint<7, 4>;
}

/// Nobody does.
pub(super) struct Unwatched;

impl Watch for Unwatched {
    fn over<K: Adjoint<7, 4>>(kernel: K) -> impl Adjoint<7, 4> {
        kernel
    }
}

/// A [trap](Trapped) does.
pub(super) struct Watched;

impl Watch for Watched {
    fn over<K: Adjoint<7, 4>>(kernel: K) -> impl Adjoint<7, 4> {
        Trapped(kernel)
    }
}

impl<K: Kernel<7, 4>> Kernel<7, 4> for Trapped<K> {
    #[inline(always)]
    fn eval<R: Real>(&self, node: [R; 7]) -> [R; 4] {
        let [x, y, ..] = node;
        let [new_x, new_y, vx, vy] = self.0.eval(node);
        // The place before, and the speed after: both are there before the new place is, which
        // the whole next step waits for. A guard that it waited for as well cost twice as much.
        let squared = vx.fma(vx, vy.fma(vy, x.fma(x, y * y)));
        // No NaN is less than anything.
        let sane = squared.lt(R::lit(TRAP * TRAP));
        [new_x, new_y, R::select(sane, vx, R::lit(f64::NAN)), vy]
    }
}

impl<K: Adjoint<7, 4>> Adjoint<7, 4> for Trapped<K> {}

#[cfg(test)]
mod tests {
    use autodiff::Kernel;

    use super::super::kernels::{Drift, Flight, Sliding, Sticking};
    use super::{TRAP, Trapped};

    fn flight() -> Flight {
        Flight {
            drift: Drift { dt: 0.002 },
            decay: (-0.04f64).exp(),
            gravity: [-0.003, -0.009],
        }
    }

    #[test]
    fn a_trap_catches_what_is_absurd_and_leaves_the_rest_alone() {
        let node = |speed: f64| [0.3, 0.2, speed, -0.5, 1e-3, 2e-3, 40.0];
        let plain = Sticking(flight());
        let caught = |node: [f64; 7]| Trapped(plain).eval(node)[2].is_nan();
        for speed in [0.4, -0.5] {
            let node = node(speed);
            assert_eq!(Trapped(plain).eval(node), plain.eval(node));
        }
        // The step leaves 96 % of a speed.
        assert!(!caught(node(TRAP)) && caught(node(1.1 * TRAP)) && caught(node(-1e300)));
        assert!(
            [f64::NAN, f64::INFINITY]
                .into_iter()
                .all(|v| caught(node(v)))
        );
        // Out of reach and slow: the place alone is absurd.
        let [_, y, rest @ ..] = node(0.4);
        assert!(caught([
            -2.0 * TRAP,
            y,
            rest[0],
            rest[1],
            rest[2],
            rest[3],
            rest[4]
        ]));
    }

    /// So that the last state tells of all before it.
    #[test]
    fn what_is_not_finite_stays_so() {
        let worst = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX];
        let finite = |state: &[f64; 4]| state.iter().all(|c| c.is_finite());
        for k in 0..6 {
            for (number, height) in worst.into_iter().flat_map(|w| [(w, 0.0), (w, 0.2)]) {
                let mut node = [0.3, height, 0.4, -0.5, 1e-3, 2e-3, 40.0];
                node[k] = number;
                let trapped = Trapped(Sticking(flight()));
                let sliding = Trapped(Sliding {
                    flight: flight(),
                    friction: 2.5,
                });
                let (stuck, slid) = (trapped.eval(node), sliding.eval(node));
                let again = |[x, y, vx, vy]: [f64; 4]| [x, y, vx, vy, 0.0, 0.0, 40.0];
                // What the first step makes finite was stopped by the ground: it is no node's
                // state that was lost, but a push into the ground.
                let lost = !finite(&stuck);
                assert!(
                    !lost || !finite(&trapped.eval(again(stuck))),
                    "{k} {number}"
                );
                let lost = !finite(&slid);
                assert!(!lost || !finite(&sliding.eval(again(slid))), "{k} {number}");
            }
        }
    }
}
