use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::objective::{Loss, Objective};
use cosmic::scene::{Named, Scene, TaskKind};
use cosmic::simulator::Trajectory;

fn objective(task: TaskKind) -> Objective {
    objective_every(task, 1)
}

fn objective_every(task: TaskKind, every: usize) -> Objective {
    let text = "
        base = 'stability'
        [objective]
        target = 1.0
        settle = 0.5
        energy_price = 0.25
        [loss]
        window = 2
        every = 1
        [physics]
        dt = 0.5
        damping = 2.0
    ";
    let mut scene = Scene::parse("tasks", text).unwrap();
    (scene.objective.task, scene.loss.every) = (task, every);
    Objective::new(&scene.objective, &scene.loss, &scene.physics)
}

/// The states of a moving payload and a node at rest: at the start and after 1, 2 and 3 steps.
fn walk() -> Trajectory<f64> {
    let state = |(x, v): (f64, f64)| State {
        x: vec![Vector::new([x, 0.25 * x]), Vector::zero()],
        v: vec![Vector::new([v, 0.0]), Vector::zero()],
    };
    Trajectory {
        steps: vec![0, 1, 2, 3],
        states: [(0.0, 0.0), (2.0, 4.0), (4.0, 2.0), (2.0, 0.0)]
            .map(state)
            .to_vec(),
    }
}

#[test]
fn each_task_has_its_loss() {
    let loss = |task| objective(task).loss(&walk());
    assert_eq!(loss(TaskKind::Far), -3.0);
    assert_eq!(loss(TaskKind::Back), 3.0);
    assert_eq!(loss(TaskKind::Climb), -0.75);
    // In the first state the payload is 3 m beyond the target and moves 1 m in the time `settle`. In the second it
    // is 1 m beyond the target and at rest.
    assert_eq!(loss(TaskKind::Reach), 0.5 * (9.0 + 1.0 + 1.0));
    // The energy is (16 + 4) / 2 nodes * 2 / s * 0.5 s = 10 J/kg. Each J/kg has the price of 0.25 m.
    assert_eq!(loss(TaskKind::Economy), -3.0 + 2.5);
}

#[test]
fn tasks_read_only_the_nodes_that_they_name() {
    for &(name, task) in TaskKind::ALL {
        let objective = objective(task);
        let mut seen = walk();
        for State { x, v } in &mut seen.states {
            x.truncate(objective.nodes());
            v.truncate(objective.nodes());
        }
        assert_eq!(objective.loss(&seen), objective.loss(&walk()), "{name}");
    }
}

#[test]
fn energy_is_summed_from_start_to_end() {
    let observed = objective(TaskKind::Economy).observed(3);
    assert_eq!(observed, [0, 1, 2, 3]);
    assert_eq!(objective(TaskKind::Reach).observed(3), [2, 3]);
    // With `every` = 2, the state after step 1 counts for one step and the state after step 3 for two steps. With
    // `every` = 16, the state after step 3 counts for all three steps.
    let energy = |every, walk: &Trajectory<f64>| {
        let [price, far] =
            [TaskKind::Economy, TaskKind::Far].map(|task| objective_every(task, every).loss(walk));
        (price - far) / 0.25
    };
    // With `every` = 2 the energy is 16 / 2 nodes * 2 / s * 0.5 s. With 16 it is zero, because the robot is at rest
    // after three steps.
    assert_eq!([2, 16].map(|every| energy(every, &walk())), [8.0, 0.0]);
    let mut fast = walk();
    fast.states[3].v[0] = Vector::new([2.0, 0.0]);
    // The energy is 4 / 2 nodes * 2 / s * 3 steps of 0.5 s.
    assert_eq!(energy(16, &fast), 6.0);
}
