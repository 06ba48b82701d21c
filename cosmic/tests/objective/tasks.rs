use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Body, Marker, State};
use cosmic::objective::{Loss, Objective};
use cosmic::scene::{Named, Scene, TaskKind};
use cosmic::world::{Effort, Efforts, Trajectory};

fn objective(task: TaskKind) -> Objective {
    let text = "
        base = 'stability'
        [controller]
        goal = [1.0, 0.0]
        [objective]
        weight = 2.5
        [loss]
        window = 2
        every = 1
        [physics]
        dt = 0.5
        [materials]
        max_strain = [0.0, 0.0, 0.2]
    ";
    let mut scene = Scene::parse("tasks", text).unwrap();
    scene.objective.task = task;
    Objective::of_scene(&scene)
}

/// The states of a moving payload and a node at rest: at the start and after 1, 2 and 3 steps.
fn walk() -> Trajectory<f64> {
    let state = |(x, v): (f64, f64)| State::new([[x, 0.25 * x], [0.0; 2]], [[v, 0.0], [0.0; 2]]);
    let states = [(0.0, 0.0), (2.0, 4.0), (4.0, 2.0), (2.0, 0.0)].map(state);
    let effort = |[skeleton, mixture]: [f64; 2]| Effort {
        activation: vec![0.0; 2],
        tension: vec![0.0; 2],
        work: vec![skeleton, mixture],
        net: vec![0.0; 2],
    };
    let given = [[0.0, 0.0], [1.0, 2.0], [5.0, 6.0], [7.0, 20.0]].map(effort);
    let body = Body {
        stiffness: vec![400.0; 2],
        strain: vec![0.0, 0.1],
        largest_strain: 0.1,
        rest_length: Vec::new(),
        mass: vec![1.5, 0.5],
        presence: Vec::new(),
        marker: Marker::default(),
    };
    Trajectory {
        efforts: Some(Efforts {
            of_states: given.to_vec(),
            body,
            dt: 0.5,
        }),
        ..Trajectory::new(vec![0, 1, 2, 3], states.to_vec())
    }
}

#[test]
fn each_task_has_its_loss() {
    let loss = |task| objective(task).loss(&walk());
    assert_eq!(loss(TaskKind::Far), -3.0);
    assert_eq!(loss(TaskKind::Back), 3.0);
    assert_eq!(loss(TaskKind::Climb), -0.75);
    // In the first state the payload is 3 m beyond the goal and moves 1 m in 0.5 s. In the second it is 1 m beyond the
    // goal and at rest.
    assert_eq!(loss(TaskKind::Reach), 0.5 * (9.0 + 1.0 + 1.0));
    // The second bar is half an actuator and has given 20 J: the robot of 2 kg spends 5 J/kg, at 0.025 m for each.
    assert_eq!(loss(TaskKind::Economy), -3.0 + 0.125);
}

/// In space, the fixed goal may be beside the robot: this one is 3 m ahead and 4 m to the left, and its height does not count.
#[test]
fn a_fixed_goal_in_space_is_along_and_across() {
    let objective = Objective {
        goal: Vector::new([4.0, 5.0, 7.0]),
        ..objective(TaskKind::Reach)
    };
    let at = |x: [f64; 3], v: [f64; 3]| State {
        dimension: Dimension::Space,
        x: vec![Vector::new(x)],
        v: vec![Vector::new(v)],
    };
    let rest = at([1.0, 1.0, 0.5], [0.0; 3]);
    let seen = |last: State<f64>| Trajectory::new(vec![0, 1], vec![rest.clone(), last]);
    assert_eq!(objective.loss(&seen(rest.clone())), 25.0);
    // The loss reads the last state. A speed of 2 m/s across counts as 1 m in 0.5 s.
    let moved = at([4.0, 1.0, 0.5], [0.0, 2.0, 0.0]);
    assert_eq!(objective.loss(&seen(moved)), 16.0 + 1.0);
}

#[test]
fn tasks_read_only_the_nodes_that_they_name() {
    for &(name, task) in TaskKind::ALL {
        let objective = objective(task);
        let mut seen = walk();
        for State { x, v, .. } in &mut seen.states {
            x.truncate(objective.nodes());
            v.truncate(objective.nodes());
        }
        assert_eq!(objective.loss(&seen), objective.loss(&walk()), "{name}");
    }
}
