//! Checks the gradient of a user's contact law.
//!
//! `cargo run -p cosmic-autodiff --example contact_law`

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real};

/// Returns the force on a ball whose surface is `depth` deep in the ground and sinks at `speed`. The exponent 1.5
/// gives Hunt and Crossley's law, and the exponent 1 a linear spring.
fn force<R: Real>(depth: R, speed: R, [stiffness, damping]: [R; 2], exponent: f64) -> R {
    let pressed = depth.max(R::zero());
    let elastic = stiffness * pressed.powf(R::lit(exponent));
    // The ground never pulls.
    (elastic * (R::one() + damping * speed)).max(R::zero())
}

/// The height of a bouncing ball after one second, as a function of `[height, velocity, stiffness, damping]`.
struct Bounce {
    exponent: f64,
}

impl Function for Bounce {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (mut height, mut velocity, law) = (x[0], x[1], [x[2], x[3]]);
        let (step, gravity) = (R::lit(1e-3), R::lit(9.81));
        for _ in 0..1000 {
            let push = force(-height, -velocity, law, self.exponent);
            velocity += (push - gravity) * step;
            height += velocity * step;
        }
        height
    }
}

fn main() {
    let bouncing = [0.5, 0.0, 2e4, 0.1];
    let report = check_gradient(&Bounce { exponent: 1.5 }, &bouncing, &Options::default());
    println!("a smooth law, bouncing\n{report}\n");
    assert_eq!(report.verdict, Verdict::Smooth);

    // The force of the linear law at the moment of first contact, as a function of the depth. It has a kink there.
    struct Touch;
    impl Function for Touch {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            force(x[0], R::zero(), [R::lit(2e4), R::zero()], 1.0)
        }
    }
    let report = check_gradient(&Touch, &[0.0], &Options::default());
    println!("a linear law, just touching\n{report}");
    assert_eq!(report.verdict, Verdict::Kink);
}
