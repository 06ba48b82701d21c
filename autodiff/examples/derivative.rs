//! Computes the slope, the gradient and the Hessian of one function, whose code is written only once.
//!
//! `cargo run -p cosmic-autodiff --example derivative`

use autodiff::{Dual, Real, gradient, hessian};

/// The potential of a particle on a spring in a periodic field. The struct's fields are constants.
struct Potential {
    stiffness: f64,
    wave_number: f64,
}

impl Potential {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let spring = R::lit(0.5 * self.stiffness) * R::dot(x, x);
        let field = (R::lit(self.wave_number) * x[0]).sin() * x[1];
        spring + field
    }
}

fn main() {
    let potential = Potential {
        stiffness: 2.0,
        wave_number: 3.0,
    };
    let x = [0.5, 1.0];
    println!("value    {:.6}", potential.eval(&x));

    // Forward mode: a dual number carries the derivative along a direction, here along x[0].
    let moving = [Dual::<f64, 1>::variable(x[0], 0), Dual::constant(x[1])];
    let slope = potential.eval(&moving).tangent[0];
    println!("slope    {slope:.6} with respect to x[0]");

    // Reverse mode: all components of the gradient for the cost of a few evaluations.
    let gradient = gradient(|x| potential.eval(x), &x);
    println!("gradient {gradient:.6?}");
    assert_eq!(gradient[0], slope);

    // The Hessian is computed by forward mode over reverse mode.
    let hessian = hessian(|x| potential.eval(x), &x);
    println!("hessian  {hessian:.6?}");
}
