//! The scene options beyond the paper's physics: bending stiffness and stiffening springs.

use autodiff::check::{Claim, Options, Verdict, check_directions};
use autodiff::{Dual, Real};
use cosmic::codesign::CoDesign;
use cosmic::inputs::{ALL, Inputs};
use cosmic::lattice::State;
use cosmic::objective::Displacement;
use cosmic::projection::Projection;
use cosmic::scene::Scene;
use cosmic::simulator::Span;
use cosmic::task::Horizon;

/// A small robot in a world with these keys in its `[physics]`.
fn scene(physics: &str) -> Scene {
    let text = format!(
        "[lattice]\ncolumns = 3\nrows = 3\n[physics]\nsteps = 64\n{physics}\n\
         [controller]\nhidden = 4\nclocks = 2\n\
         [schedule]\nhorizon = [48, 48]\n[loss]\nwindow = 16\n"
    );
    Scene::parse("tiny", &text).expect("the scene is one")
}

fn inputs(codesign: &CoDesign) -> Inputs<f64> {
    let begun = codesign.begin(3).expect("a start");
    let mut start = codesign.task().lattice.state_at_rest();
    // Pulled out of shape, off the ground: bars are bent and stretched from the first step on.
    for (i, x) in start.x.iter_mut().enumerate() {
        x[0] += 0.02 * (2.0 * i as f64).sin();
        x[1] += 0.05 + 0.02 * (3.0 * i as f64).cos();
    }
    Inputs {
        z: begun.z,
        controller: begun.controller,
        start,
    }
}

/// The displacement after 48 steps, from everything that it depends on.
fn loss<R: Real>(codesign: &CoDesign, inputs: &Inputs<R>) -> R {
    let task = codesign.task();
    let mixture = task.mixture(Projection::Performance, &inputs.z);
    let objective = Displacement::at_end(task.ground());
    task.loss(&mixture, inputs, &objective, &Horizon::head(48))
}

fn verdict(physics: &str, wrong_by: f64) -> Verdict {
    let codesign = CoDesign::new(&scene(physics)).expect("a plan");
    let at = inputs(&codesign);
    let x = at.get(ALL);
    let moved = |x: &[f64]| {
        let mut inputs = at.clone();
        inputs.set(ALL, x);
        inputs
    };
    let (_, mut gradient) = at.differentiate(ALL, |inputs| loss(&codesign, inputs));
    gradient.iter_mut().for_each(|g| *g *= 1.0 + wrong_by);
    let forward = |direction: &[f64]| {
        let pairs = x.iter().zip(direction);
        let numbers: Vec<Dual<f64, 1>> = pairs
            .map(|(&value, &d)| Dual {
                value,
                tangent: [d],
            })
            .collect();
        let mut inputs = at.lift();
        inputs.set(ALL, &numbers);
        loss(&codesign, &inputs).tangent[0]
    };
    let forward: Option<autodiff::check::Along> = match wrong_by {
        0.0 => Some(&forward),
        // The differences alone must notice.
        _ => None,
    };
    let claim = Claim {
        x: &x,
        gradient: &gradient,
        forward,
    };
    let options = Options {
        directions: 4,
        ..Options::default()
    };
    let report = check_directions(|x| loss(&codesign, &moved(x)), &claim, &options);
    println!("{report}");
    report.verdict
}

const OPTIONS: [&str; 3] = [
    "bending_radius = 0.02",
    "stiffening = 2e3",
    "bending_radius = 0.02\nstiffening = 2e3",
];

#[test]
fn gradients_agree_with_differences_and_forward_mode() {
    for physics in OPTIONS {
        assert_eq!(verdict(physics, 0.0), Verdict::Smooth, "{physics}");
        assert_eq!(verdict(physics, 0.01), Verdict::Wrong, "{physics}");
    }
}

fn after(physics: &str, steps: usize) -> State<f64> {
    let codesign = CoDesign::new(&scene(physics)).expect("a plan");
    let at = inputs(&codesign);
    let task = codesign.task();
    let mixture = task.mixture(Projection::Performance, &at.z);
    let end = Span::from_start(vec![steps]);
    let seen = task.rollout(&mixture, &at.controller, &at.start, &end);
    seen.states[0].clone()
}

#[test]
fn each_option_changes_the_motion_and_zero_is_hooke_s_law_bit_for_bit() {
    let plain = after("", 32);
    for physics in OPTIONS {
        assert_ne!(after(physics, 32), plain, "{physics}");
    }
    assert_eq!(after("bending_radius = 0.0\nstiffening = 0.0", 32), plain);
}

/// Nothing outside pulls: what bars do to each other moves no centre and turns no robot.
#[test]
fn bending_keeps_momentum_and_spin() {
    let physics = "bending_radius = 0.05\ngravity = 0.0\ndamping = 0.0\nground_height = -9.0";
    let codesign = CoDesign::new(&scene(physics)).expect("a plan");
    let at = inputs(&codesign);
    let task = codesign.task();
    let mixture = task.mixture(Projection::Performance, &at.z);
    let mass = task.body(&mixture).mass;
    let span = Span::from_start(vec![0, 64]);
    let seen = task.rollout(&mixture, &at.controller, &at.start, &span);
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
