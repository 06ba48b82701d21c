//! A small robot for all tests.

use cosmic::case::Case;
use cosmic::scene::Scene;

/// Makes a small case, whose controller has 2 hidden units. `size` has the numbers of columns and rows; `change` edits
/// the scene.
pub(crate) fn small(size: [usize; 2], change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    [scene.lattice.columns, scene.lattice.rows] = size;
    scene.controller.hidden = 2;
    change(&mut scene);
    Case::of_scene(&scene, 0).expect("the default start fits any lattice")
}
