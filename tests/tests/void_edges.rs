//! The void edges of a layout, which the simulation keeps or drops, as the scene says.

use autodiff::{Dual, Real};
use cosmic::case::Case;
use cosmic::design::Material::{self, Void};
use cosmic::design::{Design, Mixture};
use cosmic::inputs::{CONTROLLER, DESIGN, Inputs};
use cosmic::lattice::Body;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::objective::{Displacement, loss_of};
use cosmic::scene::{PhysicsSettings, Scene, VoidEdges};
use cosmic::walk;
use cosmic::world::stability::Vibration;
use cosmic::world::{Span, Variation, World};
use cosmic_tests::{laws, states};
use std::sync::Arc;

const STEPS: usize = 256;

fn case(scene: &str, void_edges: VoidEdges) -> Case {
    let mut scene = Scene::load(scene).unwrap();
    (scene.physics.steps, scene.physics.void_edges) = (STEPS, void_edges);
    // With this setting, nodes without a bar move too.
    scene.design.one_piece = false;
    Case::of_scene(&scene, 3).unwrap()
}

/// The robot of a case in physics that `change` changes.
fn with(case: &Case, change: impl FnOnce(&mut PhysicsSettings)) -> Case {
    let mut case = case.clone();
    change(&mut case.scene.physics);
    case
}

/// Three robots of 6x6 nodes. The first walks on three legs. The second is the same robot with void edges from the
/// fourth row up. The third has only void edges.
fn layouts(void_edges: VoidEdges) -> [Case; 3] {
    let tall = case("baseline_tall", void_edges);
    let cut = |from: usize| {
        let layout = tall.design.layout().unwrap();
        let pairs = tall.lattice.edges.iter().zip(layout);
        let material = |(edge, &own): (&[usize; 2], &Material)| match edge[1] < from {
            true => own,
            false => Void,
        };
        Case {
            design: Design::Layout(pairs.map(material).collect()),
            ..tall.clone()
        }
    };
    [tall.clone(), cut(24), cut(0)]
}

/// Like [`states`], but without leaving out any edge. Edges without stiffness get the smallest number above zero as
/// their stiffness, whose product with a time step is rounded to zero.
fn states_with_all_edges(case: &Case) -> Vec<State<f64>> {
    let mut body = case.body();
    let least = f64::from_bits(1);
    body.stiffness.iter_mut().for_each(|k| *k = k.max(least));
    let world = case.world();
    let robot = world.robot(body, case.controller.clone(), &case.start);
    let span = Span::from_start((0..=STEPS).collect());
    world.run_one(&robot, &span).states
}

#[test]
fn void_edges_are_kept_unless_a_scene_drops_them() {
    assert_eq!(Scene::paper().physics.void_edges, VoidEdges::Keep);
    for case in layouts(VoidEdges::Keep) {
        let void = case.scene.materials.stiffness[0];
        assert!(case.body().stiffness.iter().all(|k| *k >= void));
        assert_eq!(states(&case), states_with_all_edges(&case));
    }
}

/// A rollout without the void edges has the same bits as a rollout in which they have no stiffness. The sums have the
/// same terms in the same order, except for terms that are zero.
#[test]
fn dropped_edges_are_edges_without_stiffness_to_the_bit() {
    let worlds: [fn(&mut PhysicsSettings); 4] = [
        |_| (),
        |p| p.forces = laws::forces("physics.forces = ['bending']"),
        |p| {
            p.forces = laws::forces("physics.forces = ['stiffening']");
            p.contact = ContactLaw::coulomb();
        },
        |p| (p.substeps, p.incline_deg) = (2, 10.0),
    ];
    for (layout, world) in layouts(VoidEdges::Drop)
        .iter()
        .flat_map(|layout| worlds.map(|world| (layout, world)))
    {
        let dropped = with(layout, world);
        let mut slack = with(&dropped, |p| p.void_edges = VoidEdges::Keep);
        slack.scene.materials.stiffness[0] = 0.0;
        let all = states_with_all_edges(&slack);
        assert_eq!(all, states(&slack));
        assert_eq!(all, states(&dropped));
        // A guarded rollout and rollouts in a batch have the same bits.
        let (world, robot) = (dropped.world(), dropped.robot());
        let span = Span::of_steps(STEPS);
        let guarded = walk::guarded(&world, &robot, &span);
        assert_eq!(guarded.divergence, None);
        let together = world.run(&vec![robot; 9], &span);
        for seen in [guarded.trajectory].iter().chain(&together) {
            assert_eq!(seen.states[0], all[STEPS]);
        }
    }
}

/// The loss of the first half of the rollout.
fn loss_at_half<R: Real>(world: &World, design: &Design<Mixture<R>>, inputs: &Inputs<R>) -> R {
    let loss = Displacement::at_end(world.ground());
    assert!(world.physics().steps == STEPS);
    let span = Span::of_steps(STEPS / 2);
    loss_of(world, &inputs.robot(world, design), &loss, &span)
}

/// The loss and its gradient with respect to the design have the same bits whether or not a scene drops void edges.
#[test]
fn nothing_is_dropped_in_a_design_gradient() {
    let [kept, dropped] = [VoidEdges::Keep, VoidEdges::Drop].map(|choice| {
        let case = case("baseline_tall", choice);
        let (inputs, world) = (case.inputs(), case.world());
        let reverse = inputs.differentiate(DESIGN, |inputs| {
            let design = Design::of_shares(&inputs.z);
            loss_at_half(&world, &design, inputs)
        });
        let mut moved = inputs.lift::<Dual<f64, 1>>();
        moved.z[40][0].tangent[0] = 1.0;
        let design = Design::of_shares(&moved.z);
        let forward = loss_at_half(&world, &design, &moved);
        (reverse, (forward.value, forward.tangent))
    });
    assert_eq!(kept, dropped);
    let ((_, gradient), (_, tangent)) = kept;
    assert!(gradient.iter().any(|g| *g != 0.0) && tangent != [0.0]);
}

/// If a scene drops void edges, the gradient with respect to the controller's weights is the gradient for a robot that
/// does not have these edges.
#[test]
fn the_gradient_by_weights_belongs_to_the_robot_that_runs() {
    let [kept, dropped] = [VoidEdges::Keep, VoidEdges::Drop].map(|choice| {
        let case = case("baseline_tall", choice);
        let (inputs, world) = (case.inputs(), case.world());
        let (value, gradient) = inputs.differentiate(CONTROLLER, |inputs: &Inputs<_>| {
            let design = case.projected(case.projection, &inputs.z);
            loss_at_half(&world, &design, inputs)
        });
        let design = case.own_design();
        assert_eq!(value, loss_at_half(&world, &design, &inputs));
        (value, gradient)
    });
    assert!(kept.0 != dropped.0, "nothing is dropped");
    let length = |g: &[f64]| g.iter().map(|g| g * g).sum::<f64>().sqrt();
    let off: Vec<f64> = kept.1.iter().zip(&dropped.1).map(|(a, b)| a - b).collect();
    // If void edges are kept, they change positions by about 1e-7 m, in robots whose cells have 0.1 m.
    assert!(length(&off) < 1e-4 * length(&kept.1));
}

/// Edges of a design with mixtures are never dropped. The equal mixtures of a start are not a layout, and neither are
/// the mixtures that the softmax gives for one-hot design vectors.
#[test]
fn mixtures_drop_nothing() {
    let mut sharp = case("baseline_tall", VoidEdges::Drop);
    sharp.design = Design::Undecided(sharp.design.vectors().into_owned());
    for dropped in [case("stability", VoidEdges::Drop), sharp] {
        let kept = with(&dropped, |p| p.void_edges = VoidEdges::Keep);
        assert_eq!(kept.body(), dropped.body());
        assert_eq!(states(&kept), states(&dropped));
    }
}

/// Dropped edges have no effect on vibrations, but nodes keep their masses. If the stiffness of a robot's edges varies
/// at random, dropped edges stay dropped.
#[test]
fn stable_steps_and_robots_as_built_have_no_dropped_edges() {
    let pairs = layouts(VoidEdges::Keep)
        .into_iter()
        .zip(layouts(VoidEdges::Drop));
    for (kept, dropped) in pairs {
        let [with_void, without] = [&kept, &dropped].map(Case::body);
        assert_eq!(with_void.mass, without.mass);
        let vibration =
            |body| Vibration::new(&kept.lattice, body, &kept.scene.physics, &kept.start.x);
        let [before, after] = [&with_void, &without].map(|body| {
            let vibration = vibration(body);
            let (bound, fastest) = (vibration.edge_bound().0, vibration.fastest().0);
            assert!(fastest <= bound);
            [bound, fastest]
        });
        assert!(after[0] <= before[0]);
        // Eight edges of 1e-7 N/m at two nodes of 1e-4 kg change a squared frequency by at most this number.
        let most = 2.0 * 8.0 * kept.scene.materials.stiffness[0] / kept.scene.physics.node_mass;
        // The square of the largest frequency has a relative error of 1e-12.
        let rounding = 2e-12 * before[1].powi(2);
        assert!((before[1].powi(2) - after[1].powi(2)).abs() < most + rounding);
        let world = dropped.world();
        let variation = Variation {
            stiffness: vec![1.1; with_void.stiffness.len()],
            mass: vec![0.9; with_void.mass.len()],
            ..world.nominal(&dropped.start)
        };
        let controller = Arc::new(dropped.controller.clone());
        let as_built = world.varied(&dropped.own_design(), &controller, &variation);
        let zeros = |body: &Body<f64>| body.stiffness.iter().filter(|k| **k == 0.0).count();
        let layout = kept.design.layout().expect("a layout");
        assert_eq!(
            zeros(&without),
            layout.iter().filter(|m| **m == Void).count()
        );
        assert_eq!(zeros(&as_built.body), zeros(&without));
    }
}
