//! Differentiates through an integrator that chooses its own step lengths. The derivatives are those of a pendulum's
//! final angle with respect to its initial angle and its damping.
use autodiff::{Real, gradient, lit};

fn rates<R: Real>([angle, speed]: [R; 2], damping: R) -> [R; 2] {
    [speed, -angle.sin() - damping * speed]
}

fn axpy<R: Real>(x: [R; 2], h: f64, k: [R; 2]) -> [R; 2] {
    [x[0] + lit(h) * k[0], x[1] + lit(h) * k[1]]
}

/// Returns the pendulum's angle after 10 s. It starts at rest. Each step uses the midpoint rule, and its difference
/// from Euler's rule estimates the error.
fn angle<R: Real>(p: &[R]) -> R {
    let (mut x, mut t, mut h) = ([p[0], R::zero()], 0.0, 0.1);
    while t < 10.0 {
        let a = rates(x, p[1]);
        let b = rates(axpy(x, 0.5 * h, a), p[1]);
        let error = h * (a[0] - b[0]).hypot(a[1] - b[1]).primal();
        if error < 1e-7 {
            (t, x) = (t + h, axpy(x, h, b));
        }
        h = (0.9 * h * (1e-7 / error).sqrt()).min(2.0 * h).min(10.0 - t);
    }
    x[0]
}

fn main() {
    let p = [2.5, 0.1];
    println!("{} {:?}", angle(&p), gradient(angle, &p));
    for (i, slope) in gradient(angle, &p).into_iter().enumerate() {
        let [mut above, mut below] = [p; 2];
        above[i] += 1e-4;
        below[i] -= 1e-4;
        let difference = (angle(&above) - angle(&below)) / 2e-4;
        println!("{slope} {difference}");
        assert!((slope - difference).abs() < 1e-5 * slope.abs());
    }
}
