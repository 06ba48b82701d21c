//! Values that are written to a file and read back have the same bits.

use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Profile, Vector};
use cosmic::lattice::Lattice;
use cosmic::laws::ContactLaw;
use cosmic::outcome::DesignFile;
use cosmic::record::RunPlan;
use cosmic::record::snapshot::SavedScene;
use cosmic::scene::{Integrator, Scene, VoidEdges};
use cosmic::search::{CoDesign, Progress};
use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
use proptest::prelude::*;
use serde_json::Value;
use std::num::NonZeroUsize;

use autodiff::Parameters;

/// Any finite number.
fn numbers() -> impl Strategy<Value = f64> {
    NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
}

fn scene() -> Scene {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    (scene.controller.hidden, scene.controller.clocks) = (2, 3);
    scene.physics.steps = 8;
    scene.schedule.iterations = 4;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 3);
    scene.schedule.horizon = [8, 8];
    (scene.loss.window, scene.loss.every) = (4, 2);
    scene
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn designs(
        z in prop::collection::vec(prop::array::uniform3(numbers()), 6),
        weights in prop::collection::vec(numbers(), 64),
        materials in prop::collection::vec(0..3usize, 6),
    ) {
        let scene = scene();
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let mut controller = cosmic::policy::Controller::xavier(&scene.controller, &lattice, 0);
        let mut weights = weights.into_iter().cycle();
        controller = controller.map(|_| 0.0);
        controller.numbers_mut().iter_mut().zip(&mut weights).for_each(|(w, x)| *w = x);
        let materials: Vec<Material> = materials.iter().map(|m| Material::ALL[*m]).collect();
        let design = DesignFile::new(&lattice, &Design::Undecided(z), &materials, &controller);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("design.json");
        design.write(&file).unwrap();
        let read = DesignFile::read(&file).unwrap();
        prop_assert_eq!(bits(&read.z), bits(&design.z));
        prop_assert_eq!(&read, &design);
        prop_assert_eq!(&read.robot(&scene, "design.json").unwrap(), &controller);
        // A file by hand may list the edges in any order and direction.
        let mut own: Value = serde_json::from_str(&design.to_json()).unwrap();
        for key in ["/edges", "/z", "/materials", "/controller/w2", "/controller/b2"] {
            own.pointer_mut(key).unwrap().as_array_mut().unwrap().reverse();
        }
        for ends in own["edges"].as_array_mut().unwrap() {
            ends.as_array_mut().unwrap().reverse();
        }
        let own = DesignFile::parse(&file, own.to_string().as_bytes()).unwrap();
        prop_assert!(own != design);
        // The blocks of a controller have names, and may be in any order.
        let own = own.in_order(&scene, "design.json").unwrap();
        prop_assert_eq!((&own.edges, bits(&own.z)), (&design.edges, bits(&design.z)));
        prop_assert_eq!(&own.materials, &design.materials);
        prop_assert_eq!(own.robot(&scene, "design.json").unwrap(), controller);
    }

    #[test]
    fn cases(
        seed in any::<u64>(),
        z in prop::collection::vec(prop::array::uniform3(numbers()), 6),
        (dt, gravity, damping, friction) in (1e-9..1.0_f64, -1e3..1e3_f64, 0.0..1e4_f64, 0.0..1e3_f64),
        start in prop::array::uniform4(numbers()),
        layout in any::<bool>(),
        (leapfrog, substeps) in (any::<bool>(), 1..9usize),
        heights in prop::collection::vec(-1e3..1e3_f64, 0..9),
    ) {
        let mut case = Case::of_scene(&scene(), seed).unwrap();
        case.design = if layout {
            Design::Layout(vec![Material::Skeleton; 6])
        } else {
            Design::Undecided(z)
        };
        let physics = &mut case.scene.physics;
        [physics.dt, physics.gravity, physics.damping, physics.friction] =
            [dt, gravity, damping, friction];
        (case.start.x[1], case.start.v[3]) = (
            Vector::from([start[0], start[1]]),
            Vector::from([start[2], start[3]]),
        );
        case.lattice.positions.clone_from(&case.start.x);
        physics.substeps = substeps;
        let points = heights.iter().enumerate().map(|(k, height)| Vector::from([k as f64 / 3.0, *height]));
        physics.ground = Profile::new(points.collect()).unwrap().into();
        if leapfrog {
            (physics.integrator, physics.contact) = (Integrator::Leapfrog, ContactLaw::coulomb());
        }
        if substeps == 2 {
            physics.void_edges = VoidEdges::Drop;
        }
        physics.speed_bound = layout.then_some(7.5);
        case.scene.design.one_piece = layout;
        let read = Case::parse("case.json", &case.to_json()).unwrap();
        prop_assert_eq!(read, case);
    }

    /// A snapshot that is written and read back has the same bits, for any seed and after any number of iterations.
    #[test]
    fn progress_and_plans(seed in any::<u64>(), iterations in 0..4usize, any in numbers()) {
        let mut codesign = CoDesign::new(&scene()).unwrap();
        let mut progress = codesign.begin(seed).unwrap();
        (0..iterations).for_each(|_| drop(codesign.iterate(&mut progress)));
        progress.adam.mean[3] = any;
        let text = serde_json::to_string(&progress).unwrap();
        prop_assert_eq!(serde_json::from_str::<Progress>(&text).unwrap(), progress);
        let plan = RunPlan {
            name: "any".to_owned(),
            scene: scene(),
            seed,
            starts: NonZeroUsize::MIN,
            iterations: NonZeroUsize::new(iterations),
        };
        let text = serde_json::to_string(&plan.saved()).unwrap();
        let read: RunPlan<SavedScene> = serde_json::from_str(&text).unwrap();
        prop_assert_eq!(read.read(&Registry::default()).unwrap(), plan);
    }
}

fn bits(rows: &[[f64; 3]]) -> Vec<u64> {
    rows.as_flattened().iter().map(|x| x.to_bits()).collect()
}
