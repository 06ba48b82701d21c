//! Minimises the Rosenbrock function of 20 variables by argmin's L-BFGS.
use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::{linesearch::MoreThuenteLineSearch, quasinewton::LBFGS};
use autodiff::{Function, Real, gradient, lit};

struct Rosenbrock;

impl Function for Rosenbrock {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let valley = |x: &[R]| lit(100.0) * (x[1] - x[0].powi(2)).powi(2);
        let slope = |x: &[R]| (lit(1.0) - x[0]).powi(2);
        x.windows(2).map(|x| valley(x) + slope(x)).sum()
    }
}

impl CostFunction for Rosenbrock {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.eval(x))
    }
}

impl Gradient for Rosenbrock {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(gradient(|x| self.eval(x), x))
    }
}

fn main() -> Result<(), Error> {
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 8);
    let run = Executor::new(Rosenbrock, solver).configure(|at| at.param(vec![-0.5; 20]));
    let found = run.run()?.state;
    println!("cost {:.1e} after {}", found.best_cost, found.get_iter());
    let x = found.best_param.unwrap();
    assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-6));
    Ok(())
}
