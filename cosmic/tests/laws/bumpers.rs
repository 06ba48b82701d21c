use cosmic::design::{Design, Material};
use cosmic::geometry::Vector;
use cosmic::lattice::Lattice;
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::world::{Span, World};

/// Throws the horizontal bar [0, 1] at the middle of the upright bar [2, 5], in a world without ground and gravity.
/// Returns the momentum along x before and after (kg m/s), and in how many states the tip of the first bar is beyond the
/// second bar.
fn thrown(physics: &str) -> ([f64; 2], usize) {
    let text = format!(
        "lattice = {{columns = 3, rows = 2}}\nphysics = {{gravity = 0, damping = 0, contact = 'none', dt = 2e-4, {physics}}}"
    );
    let scene = Scene::parse("thrown", &text).unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let layout: Vec<Material> = (lattice.edges.iter())
        .map(|edge| match edge {
            [0, 1] | [2, 5] => Material::Skeleton,
            _ => Material::Void,
        })
        .collect();
    let world = World::new(lattice.clone(), &scene);
    let mut body = world.body(&Design::Layout(layout.clone()));
    for (stiffness, material) in body.stiffness.iter_mut().zip(layout) {
        if material == Material::Void {
            *stiffness = 0.0;
        }
    }
    let mut start = lattice.state_at_rest();
    for node in [0, 1] {
        start.x[node] += Vector::upright(0.0, 0.05);
        start.v[node] = Vector::upright(1.0, 0.0);
    }
    let controller = Controller::xavier(&scene.controller, &lattice, 1);
    let span = Span::from_start((0..=1500).collect());
    let robot = world.robot(body, controller, &start);
    let seen = world.run_one(&robot, &span);
    let momentum = |step: usize| {
        let of_nodes = seen.states[step].v.iter().zip(&robot.body.mass);
        of_nodes.map(|(v, mass)| v.forward() * mass).sum::<f64>()
    };
    let is_beyond = |x: &[Vector<f64>]| x[1].forward() > x[2].forward().max(x[5].forward());
    let beyond = seen.states.iter().filter(|state| is_beyond(&state.x));
    ([momentum(0), momentum(1500)], beyond.count())
}

/// A bar that hits another bar bounces off with bumpers, and without them passes through it. Bumpers keep the momentum.
#[test]
fn a_bar_does_not_pass_through_another_one() {
    for integrator in ["", "integrator = 'implicit', "] {
        let (_, passed) = thrown(integrator);
        let (momentum, beyond) = thrown(&format!("{integrator}forces = ['bumpers']"));
        assert!(passed > 500, "{passed}");
        assert_eq!(beyond, 0);
        // The momentum of 0.02 kg at 1 m/s, after 1500 roundings of 1e-16 of it.
        assert!((momentum[1] - momentum[0]).abs() < 1e-13, "{momentum:?}");
    }
}
