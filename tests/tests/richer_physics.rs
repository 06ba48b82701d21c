//! The scene options beyond the paper's physics: bending stiffness and stiffening springs.

use autodiff::check::{Options, Verdict};
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::scene::Scene;
use cosmic::simulator::{Span, Trajectory};
use cosmic_lab::verify::check_gradients;

/// A small robot in a world with these keys in its `[physics]`.
fn robot(physics: &str) -> Case {
    let text = format!(
        "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n{physics}\n\
         [controller]\nhidden = 4\nclocks = 2\n\
         [schedule]\nhorizon = [48, 48]\n[loss]\nwindow = 16\n"
    );
    let scene = Scene::parse("tiny", &text).expect("the scene is one");
    let mut case = Case::of_scene(&scene, 3).expect("a start");
    // Pulled out of shape, off the ground: bars are bent and stretched from the first step on.
    for (i, x) in case.start.x.iter_mut().enumerate() {
        x[0] += 0.02 * (2.0 * i as f64).sin();
        x[1] += 0.05 + 0.02 * (3.0 * i as f64).cos();
    }
    case
}

/// Its states after these steps.
fn run(case: &Case, steps: &[usize]) -> Trajectory<f64> {
    let (task, design) = (case.task(), case.own_design());
    let span = Span::from_start(steps.to_vec());
    task.rollout(&design, &case.controller, &case.start, &span)
}

const OPTIONS: [&str; 3] = [
    "bending_radius = 0.02",
    "stiffening = 2e3",
    "bending_radius = 0.02\nstiffening = 2e3",
];

#[test]
fn gradients_agree_with_differences_and_forward_mode() {
    for physics in OPTIONS {
        let check = check_gradients(&robot(physics), None, 48, &Options::default());
        for group in &check.groups {
            assert_eq!(group.verdict, Verdict::Smooth, "{physics}:\n{check}");
        }
        let control = check.control.map(|control| control.verdict);
        assert_eq!(control, Some(Verdict::Wrong), "{physics}");
    }
}

#[test]
fn each_option_changes_the_motion_and_zero_is_hooke_s_law_bit_for_bit() {
    let after = |physics: &str| run(&robot(physics), &[32]).states.remove(0);
    let plain = after("");
    for physics in OPTIONS {
        assert_ne!(after(physics), plain, "{physics}");
    }
    assert_eq!(after("bending_radius = 0.0\nstiffening = 0.0"), plain);
}

/// Without forces from outside, bending moves no centre of mass and turns no robot.
#[test]
fn bending_keeps_momentum_and_spin() {
    let physics = "bending_radius = 0.05\ngravity = 0.0\ndamping = 0.0\nground_height = -9.0";
    let case = robot(physics);
    let (mass, seen) = (case.body().mass, run(&case, &[0, 64]));
    let moments = |state: &State<f64>| {
        let nodes = mass.iter().zip(state.x.iter().zip(&state.v));
        nodes.fold([0.0; 3], |[px, py, spin], (m, (x, v))| {
            [
                px + m * v[0],
                py + m * v[1],
                spin + m * (x[0] * v[1] - x[1] * v[0]),
            ]
        })
    };
    let moved = seen.states[1].v.iter().flatten().any(|v| v.abs() > 1e-2);
    assert!(moved);
    let [px, py, spin] = moments(&seen.states[1]);
    // 64 steps of 9 nodes whose impulses, below 0.1 N s, round at 1e-17 each.
    assert!(px.abs() < 1e-14 && py.abs() < 1e-14, "{px} {py}");
    // Softening makes an arm of 0.1 m longer by a share of 5e-11, and the arms differ.
    assert!(spin.abs() < 1e-10, "{spin}");
}
