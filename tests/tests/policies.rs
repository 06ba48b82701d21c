//! The gradients of policies are right in every mode, and policies observe what the documentation says.

use autodiff::Real;
use autodiff::check::Verdict;
use autodiff_programs::{Array, Kernel};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::laws::{Motion, Particle};
use cosmic::objective::Displacement;
use cosmic::policy::{Block, Network, Policy, PolicyStep, Sizes, observation};
use cosmic::walk;
use cosmic::world::{Span, Trajectory};
use cosmic::{Fields, kernel};
use cosmic_lab::check::{check_gradients_of, terms};
use cosmic_tests::few_directions;

/// The policies to test: three from the model, one that is defined in this file, the policy `gaits` of a robot that is its
/// own mirror image, `mlp` and `gaits` of a robot in space that is, and `gaits` of one that is not.
const POLICIES: [&str; 8] = [
    "mlp", "clock", "reflex", "gaits", "mirrored", "sides", "steers", "turns",
];

/// A policy with three parts: a hidden layer that reads the observation, a rhythm, and what the bars feel. The rhythm is
/// the same for all edges, multiplied by a factor for each edge.
#[derive(Debug)]
struct Reflex;

#[derive(Clone)]
struct Mixed;

#[kernel]
impl Kernel<5, 1> for Mixed {
    fn eval<R: Real>(&self, [sin, cos, factor, reflex, felt]: [R; 5], _: &[R]) -> [R; 1] {
        [(factor * (sin + cos + R::lit(30.0) * felt) + reflex).tanh()]
    }
}

/// Both ends of a bar.
#[derive(Clone, Copy, Fields)]
struct Ends<T> {
    tail: Particle<T, 2>,
    head: Particle<T, 2>,
    /// The rest length.
    rest: T,
}

/// A number that depends on the positions and velocities of both ends of a bar and on its rest length, each in another
/// way.
#[derive(Clone)]
struct Felt;

#[kernel]
impl Kernel<_, _> for Felt {
    fn eval<R: Real>(&self, Ends { tail, head, rest }: Ends<R>, _: &[R]) -> R {
        let ([x0, y0], [u0, v0]) = (tail.x.array(), tail.v.array());
        let ([x1, y1], [u1, v1]) = (head.x.array(), head.v.array());
        let length = (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0);
        length - rest * rest + y0 * y1 + R::lit(0.1) * (u0 * v1 - v0 * u1)
    }
}

fn felt(step: &mut PolicyStep) -> Array {
    let [tail, head] = step.ends().map(Motion::particle);
    let rest = step.rest_lengths();
    let ends = Ends { tail, head, rest };
    step.program().map(Felt, ends.array(), &[])[0]
}

impl Policy for Reflex {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        let observation = robot.observation(self.observe());
        vec![
            Block::weights("senses", 5, observation, 2.0),
            Block::biases("rest", 5),
            Block::weights("nerves", 3, 5, 1.0),
            Block::biases("calm", 3),
            Block::weights("muscles", robot.edges, 3, 1.0),
            Block::biases("tone", robot.edges),
            Block::drawn("factor", robot.edges, 1.0),
        ]
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        let hidden = step.observed_layer("senses", "rest");
        let hidden = step.layer("nerves", "calm", hidden);
        let reflex = step.output_layer("muscles", "tone", hidden);
        let clock = step.clock();
        let [sin, cos] = [0, 1].map(|k| step.for_every_edge(clock, k));
        let factor = step.per_edge("factor");
        let felt = felt(step);
        step.program()
            .map(Mixed, [sin, cos, factor, reflex, felt], &[])[0]
    }
}

/// The case of a small robot with the policy `name`.
fn robot(name: &str, settings: &str) -> Case {
    robot_with(name, settings, false)
}

/// Like [`robot`]. Only cases can have a goal that is relative to the robot.
fn robot_with(name: &str, settings: &str, goal_relative: bool) -> Case {
    let registry = Registry::default().with_policy("reflex", Reflex);
    let task = "\n[objective]\ntask = \"reach\"";
    let [goals, task] = match name {
        "gaits" | "mirrored" => [
            "goals = \"given\"\ngoal = [0.3, 0.1]\ngoal_scale = 3.0\n",
            task,
        ],
        "steers" | "turns" => [
            "goals = \"given\"\ngoal = [0.3, -0.4, 0.1]\ngoal_scale = 3.0\n",
            task,
        ],
        _ => [""; 2],
    };
    let (name, lattice) = match name {
        "mirrored" => ("gaits", "mirror = true\npayload = 1\n"),
        "sides" => (
            "mlp",
            "mirror = true\npayload = 3\nkind = \"cubic\"\ndepth = 3\n",
        ),
        "steers" => (
            "gaits",
            "mirror = true\npayload = 3\nkind = \"cubic\"\ndepth = 3\n",
        ),
        "turns" => ("gaits", "kind = \"cubic\"\ndepth = 2\n"),
        _ => (name, ""),
    };
    let text = format!(
        "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.01\n{lattice}[controller]\nhidden = 6\n\
         policy = \"{name}\"\n{goals}{settings}{task}"
    );
    let mut scene = registry.parse("small", &text).unwrap();
    scene.controller.goal_relative = goal_relative;
    let mut case = Case::of_scene(&scene, 1).unwrap();
    // No bias may be zero; otherwise the test would not notice a missing bias.
    let numbers = case.controller.numbers_mut().iter_mut().enumerate();
    numbers.for_each(|(k, number)| *number += 0.1 * (k as f64).sin());
    case
}

/// The gradients of policies are right for two kinds of robots. In robots in one piece, every step weights the nodes.
/// In other robots, the mean of the nodes is folded into the weights of the network.
#[test]
fn gradients_are_right_in_every_mode() {
    for name in POLICIES {
        for (settings, goal_relative) in [
            ("", true),
            ("[design]\none_piece = false", true),
            ("offset_scale = 0.0", false),
            ("velocity_scale = 0.0", false),
            ("clock = \"learned\"", false),
        ] {
            let case = robot_with(name, settings, goal_relative);
            let loss = Displacement::at_end(case.world().ground());
            let check = check_gradients_of(&loss, &case, 48, &few_directions());
            for group in &check.groups {
                let is_right = group.verdict == Verdict::Smooth;
                assert!(
                    is_right,
                    "{name}, {settings}: {}, {}",
                    group.name, group.report
                );
            }
        }
    }
}

/// A learned clock adds a block to the controller, whose name a policy cannot use.
#[test]
#[should_panic(expected = "the policy `hasty` has a block `tempo`")]
fn a_policy_cannot_have_the_block_of_a_learned_clock() {
    #[derive(Debug)]
    struct Hasty;
    impl Policy for Hasty {
        fn parameters(&self, robot: &Sizes) -> Vec<Block> {
            vec![Block::biases("tempo", robot.edges)]
        }
        fn record(&self, step: &mut PolicyStep) -> Array {
            step.per_edge("tempo")
        }
    }
    let registry = Registry::default().with_policy("hasty", Hasty);
    let text = "[controller]\npolicy = \"hasty\"\nclock = \"learned\"";
    _ = Case::of_scene(&registry.parse("hasty", text).unwrap(), 1);
}

/// The first activations of a rollout agree with the definition of the observation, even if nodes are only partly
/// present.
#[test]
fn a_step_uses_the_observation() {
    let given =
        "goals = \"given\"\ngoal = [0.3, 0.2]\ngoal_scale = 2.0\n[objective]\ntask = \"reach\"";
    let on_a_slope = "[design]\none_piece = false\n[physics]\nincline_deg = 12.0";
    let given_on_a_slope = format!("{given}\n{on_a_slope}");
    for (policy, settings, goal_relative) in [
        ("mlp", "", true),
        ("mlp", "offset_scale = 0.7\ngoal_scale = 0.3", false),
        ("mlp", "[design]\none_piece = false", false),
        ("mlp", "[physics]\nincline_deg = 12.0", true),
        ("mlp", given, false),
        ("mlp", &given_on_a_slope, false),
        ("gaits", "", false),
        ("mirrored", "", false),
        ("mirrored", "[design]\none_piece = false", false),
        ("gaits", on_a_slope, false),
        ("sides", "", true),
        ("sides", on_a_slope, false),
        ("steers", "", false),
        ("steers", on_a_slope, false),
        ("turns", "", false),
    ] {
        let case = robot_with(policy, settings, goal_relative);
        let (robot, ground) = (case.robot(), case.world().ground());
        let seen = observation(
            &case.scene.controller,
            0.0,
            &case.start,
            &robot.body.presence,
            &ground,
        );
        let network = Network::of(&case.controller, &case.scene.controller, &case.lattice).unwrap();
        let dimension = case.lattice.dimension;
        let goal = &seen[case.scene.controller.clocks..][..dimension.count()];
        let goal = dimension.vector(goal);
        let expected = network.activation(&seen, [goal.forward(), goal.sideways()]);
        let start = Trajectory::new(vec![0], vec![case.start.clone()]);
        let moments = walk::moments(&case.world(), &robot, &start);
        let found = &moments[0].activation;
        for (a, b) in found.iter().zip(&expected) {
            // The tolerance is for sums of some forty terms of order one.
            assert!((a - b).abs() < 1e-13, "{policy}, {settings}: {a} {b}");
        }
    }
}

/// A policy gets the ends of every bar in the ground's frame, with heights above the ground, and the rest lengths.
#[test]
fn a_policy_feels_its_bars() {
    #[derive(Debug)]
    struct Feels;
    impl Policy for Feels {
        fn parameters(&self, robot: &Sizes) -> Vec<Block> {
            vec![Block::biases("unused", robot.edges)]
        }
        fn record(&self, step: &mut PolicyStep) -> Array {
            step.per_edge("unused");
            felt(step)
        }
    }
    let registry = Registry::default().with_policy("feels", Feels);
    for physics in ["", "incline_deg = 12.0"] {
        let text = format!(
            "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2\n[controller]\npolicy = \"feels\"\n[physics]\n{physics}"
        );
        let scene = registry.parse("feels", &text).unwrap();
        let mut case = Case::of_scene(&scene, 1).unwrap();
        let moved = case.start.x.iter_mut().chain(&mut case.start.v);
        for (k, vector) in moved.enumerate() {
            *vector += Vector::from([0.1 * (k as f64).sin(), 0.1 * (k as f64).cos()]);
        }
        let (world, ground) = (case.world(), case.world().ground());
        let start = Trajectory::new(vec![0], vec![case.start.clone()]);
        let moments = walk::moments(&world, &case.robot(), &start);
        let end = |node: usize| {
            let x = ground.vector_to_ground(case.start.x[node]).in_plane();
            let v = ground.vector_to_ground(case.start.v[node]).in_plane();
            [x[0], x[1], v[0], v[1]]
        };
        for (edge, &[tail, head]) in case.lattice.edges.iter().enumerate() {
            let ([tail, head], rest) = ([end(tail), end(head)], case.lattice.rest_length[edge]);
            let [x0, y0, u0, v0] = tail;
            let [x1, y1, u1, v1] = head;
            let [expected] = Felt.eval([x0, y0, u0, v0, x1, y1, u1, v1, rest], &[]);
            // The tolerance is for roundings of a few numbers below one.
            let found = moments[0].activation[edge];
            assert!(
                (found - expected).abs() < 1e-14,
                "{edge}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_plan_shows_hidden_units_only_of_networks() {
    let row = |policy: &str| {
        let terms = terms(&robot(policy, ""));
        let term = terms.into_iter().nth(1).unwrap();
        (term.name, term.why)
    };
    let hidden = (
        "hidden layer",
        "6 units that read the observation".to_owned(),
    );
    assert_eq!([row("mlp"), row("clock")], [hidden.clone(), hidden]);
    let (name, why) = row("reflex");
    assert_eq!(name, "policy without its outputs");
    assert!(why.starts_with("`reflex` has "), "{why}");
}

/// The policy `clock` is open loop: the robot's state has no effect on its outputs. The state has an effect on a
/// network, unless the network sees the same state in every step.
#[test]
fn the_clock_is_open_loop() {
    let moved = |name: &str, is_held: bool| {
        let case = robot(name, "offset_scale = 3.0\n[physics]\ncontact = \"none\"");
        let span = Span {
            open_loop: is_held.then(|| case.start.clone()),
            ..Span::of_steps(60)
        };
        let shape = |start: &State<f64>| {
            let seen = (case.world()).run_one(&case.robot().from(start), &span);
            let x = seen.states[0].x.clone();
            x.iter().map(|p| (*p - x[0]).in_plane()).collect::<Vec<_>>()
        };
        // A push gives all nodes the same additional velocity. The shape of the robot changes only if the controller
        // observes this velocity.
        let mut pushed = case.start.clone();
        pushed
            .v
            .iter_mut()
            .for_each(|v| *v += Vector::upright(2.0, 0.0));
        let (still, pushed) = (shape(&case.start), shape(&pushed));
        let pairs = still.as_flattened().iter().zip(pushed.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    // The tolerance is for roundings at 1e-16 in each of 60 steps of a robot without contact.
    assert!(moved("clock", false) < 1e-12);
    assert!(moved("mlp", true) < 1e-12);
    assert!(moved("mlp", false) > 1e-6);
    assert!(moved("reflex", false) > 1e-6);
}
