//! Small robots for all tests.

use cosmic::Registry;
use cosmic::case::Case;
use cosmic::record::{RunPlan, optimise};
use cosmic::scene::{Scene, StartKind};
use cosmic_lab::report::RunFiles;

/// Makes a small case, whose controller has 2 hidden units. `size` has the numbers of columns and rows; `change` edits
/// the scene.
pub(crate) fn small(size: [usize; 2], change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    [scene.lattice.columns, scene.lattice.rows] = size;
    scene.controller.hidden = 2;
    change(&mut scene);
    Case::of_scene(&scene, 0).expect("the default start fits any lattice")
}

/// Does a run of one iteration with the short three-legged robot of the paper's scene. `change` edits the scene.
pub(crate) fn short_run(change: impl FnOnce(&mut Scene)) -> RunFiles {
    let mut scene = Scene::paper();
    scene.start.kind = StartKind::Layout;
    (scene.schedule.iterations, scene.schedule.snap_at) = (1, 0);
    (scene.schedule.horizon, scene.loss.window) = ([16, 16], 16);
    change(&mut scene);
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    optimise(&run, &RunPlan::new("test", scene, 0), &mut ()).unwrap();
    RunFiles::read(&run, &Registry::default()).unwrap()
}
