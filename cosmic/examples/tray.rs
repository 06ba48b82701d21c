//! An objective of the user, written without an adjoint: `cargo run --release -p cosmic-codesign --example tray`

use autodiff::Real;
use cosmic::design::Design;
use cosmic::inputs::CONTROLLER;
use cosmic::objective::{Loss, loss_of};
use cosmic::projection::Projection;
use cosmic::scene::Scene;
use cosmic::search::CoDesign;
use cosmic::world::{Span, Trajectory};

/// The mean square of the difference in height of two nodes.
struct Level([usize; 2]);

impl Loss for Level {
    fn observed(&self, steps: usize) -> Vec<usize> {
        (0..=steps).step_by(8).collect()
    }
    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let states = trajectory.states.iter();
        let slopes = states.map(|s| (s.x[self.0[0]] - s.x[self.0[1]]).up());
        let squares: Vec<R> = slopes.map(|s| s * s).collect();
        R::sum_of(&squares) * R::lit(1.0 / squares.len() as f64)
    }
}

fn main() -> Result<(), cosmic::Error> {
    let scene = Scene::parse("small", "[lattice]\ncolumns = 3\nrows = 3")?;
    let codesign = CoDesign::new(&scene)?;
    let (world, first) = (codesign.world(), codesign.begin(1)?);
    let mut inputs = codesign.inputs(&first);
    let mut losses = [0.0; 20];
    for value in &mut losses {
        let (loss, gradient) = inputs.differentiate(CONTROLLER, |inputs| {
            let projector = world.projector();
            let mixtures = projector.mixtures(Projection::Performance, &inputs.z);
            let robot = inputs.robot(world, &Design::Undecided(mixtures));
            loss_of(world, &robot, &Level([6, 8]), &Span::of_steps(128))
        });
        let mut weights = inputs.get(CONTROLLER);
        (weights.iter_mut().zip(gradient)).for_each(|(w, g)| *w -= 100.0 * g);
        inputs.set(CONTROLLER, &weights);
        *value = loss;
    }
    println!("mean square slopes, m^2: {losses:?}");
    assert!(losses[19] < 0.5 * losses[0]);
    Ok(())
}

#[test]
fn the_top_comes_level() {
    main().unwrap();
}
