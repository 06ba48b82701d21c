//! Steers a charged particle to the origin. The minimised function is a simulation in which the forces are derivatives
//! of a potential.

use autodiff::{Mask, Real};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::descent::{Mode, Objective, argmin};
use super::work::{Prepared, read, work};

#[derive(Deserialize)]
struct Input {
    w: f64,
}

/// The length of a time step.
const DT: f64 = 0.1;

/// The potential at a point `x`, of charges at (10, 10 - w) and (10, 0). The number `w` is given.
struct Potential;

impl Objective for Potential {
    fn eval<R: Real>(&self, w: &[R], place: &[R]) -> R {
        let ten = R::lit(10.0);
        let charges = [[ten, ten - w[0]], [ten, R::zero()]];
        let inverse = |[x, y]: [R; 2]| {
            let gap = [place[0] - x, place[1] - y];
            R::dot(&gap, &gap).rsqrt()
        };
        inverse(charges[0]) + inverse(charges[1])
    }
}

/// The squared distance from the origin at which the particle crosses the line `y = 0`. The forces are computed in the
/// given mode.
struct Miss(Mode);

impl Objective for Miss {
    fn eval<R: Real>(&self, _: &[R], w: &[R]) -> R {
        let dt = R::lit(DT);
        let mut place = [R::zero(), R::lit(8.0)];
        let mut velocity = [R::lit(0.75), R::zero()];
        loop {
            let slope = self.0.gradient(&Potential, w, &place);
            for i in 0..2 {
                place[i] += dt * velocity[i];
            }
            if place[1].less_equal(R::zero()).any() {
                break;
            }
            for i in 0..2 {
                velocity[i] -= dt * slope[i];
            }
        }
        let back = -place[1] / velocity[1];
        let crossing = place[0] + back * velocity[0];
        crossing * crossing
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { w } = read(input)?;
    let [outer, inner] = Mode::pair(function)?;
    work(move || argmin(outer, &Miss(inner), &[], &[w])[0])
}
