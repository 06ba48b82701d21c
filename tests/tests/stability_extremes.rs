//! The sweep of extremes, on the smallest of scenes.

use cosmic::scene::Scene;
use cosmic::verify::stability::{bound_ratio, extremes};

#[test]
fn every_extreme_ends_as_expected() {
    let mut scene = Scene::default();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    for found in extremes(&scene) {
        println!(
            "{:12} {:50} dt {:.2e} bound {:.2e} limit {:.2e} {:?} growth {:.2e} {}",
            found.group, found.what, found.dt, found.bound, found.limit, found.grade, found.growth,
            match &found.outcome { cosmic::verify::stability::Outcome::Diverged(d) => format!("diverged {} {:?}", d.step, d.term), o => format!("{o:?}") } 
        );
        if !found.is_ok() { println!("   ^^^^^^^^^^^^ BAD"); }
    }
    println!("{:?}", bound_ratio(600));
    panic!();
}
