//! Small scenes and what becomes of them, for all tests.

use autodiff::Real;
use cosmic::geometry::Ground;
use cosmic::lattice::Lattice;
use cosmic::objective::Loss;
use cosmic::record::{Observer, Run};
use cosmic::scene::{LatticeSettings, LossKind, Scene};
use cosmic::search::{CoDesign, Progress, Record};
use cosmic::world::Trajectory;
use std::ops::ControlFlow;

/// A scene with a small robot that moves from the start and can get several layouts. The text ends in `[schedule]`
/// without `iterations`, so that tests can append that setting.
pub(crate) const MOBILE_ROBOT: &str = "
    base = 'stability'
    [lattice]
    columns = 3
    rows = 3
    drop = 0.05
    [physics]
    steps = 256
    [controller]
    gain = [6.0, 6.0]
    [volume]
    solid = [0.3, 0.7]
    actuator = [0.0, 0.42]
    [loss]
    window = 32
    [schedule]
    attraction_from = 4
    snap_at = 7
    horizon = [64, 64]
";

/// A lattice with the spacing of the default scene, on ground with an incline in degrees.
pub(crate) fn lattice(columns: usize, rows: usize, incline_deg: f64) -> Lattice {
    let settings = LatticeSettings {
        columns,
        rows,
        ..LatticeSettings::default()
    };
    Lattice::new(&settings, Ground { incline_deg })
}

/// A user's loss: minus the mean of two heights of the payload, after half of the steps and at the end.
pub(crate) struct Up;

impl Loss for Up {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps / 2, steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let heights = [0, 1].map(|k| -trajectory.payload(k).x.up());
        R::sum_of(&heights) * R::lit(0.5)
    }
}

/// A scene with a robot of two squares, simulated for a few steps.
pub(crate) fn tiny() -> Scene {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    (scene.physics.steps, scene.controller.hidden) = (24, 3);
    scene.schedule.iterations = 12;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (8, 11);
    scene.schedule.horizon = [24, 24];
    scene.loss.kind = LossKind::Final;
    scene
}

/// The optimisation of a scene, and its state before the first iteration.
pub(crate) fn begun(scene: &Scene) -> (CoDesign, Progress) {
    after(scene, 0, 1)
}

/// The optimisation of a seed, and its state after some iterations.
pub(crate) fn after(scene: &Scene, iterations: usize, seed: u64) -> (CoDesign, Progress) {
    let mut codesign = CoDesign::new(scene).unwrap();
    let mut progress = codesign.begin(seed).unwrap();
    while progress.iteration < iterations {
        codesign.iterate(&mut progress);
    }
    (codesign, progress)
}

/// The records of an optimisation.
pub(crate) fn records(scene: &Scene) -> Vec<Record> {
    let mut records = Vec::new();
    let mut codesign = CoDesign::new(scene).unwrap();
    (codesign.optimise(0, |record| records.push(record.clone()))).unwrap();
    records
}

/// Interrupts a run after an iteration.
pub(crate) struct StopAfter(pub(crate) usize);

impl Observer for StopAfter {
    fn iteration(&mut self, _: &Run, record: &Record) -> ControlFlow<()> {
        if record.iteration == self.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
