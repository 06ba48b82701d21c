//! Settings that are each in range and yet do not fit one another.

use super::field::Named;
use super::layout::LAYOUT_SIDE;
use super::{Layout, LossKind, Scene, StartKind, TaskKind};

/// Settings at odds.
pub(super) struct Conflict {
    /// Their keys, the one to point at first; the same key twice where its own entries are at odds.
    pub(super) keys: [&'static str; 2],
    /// What is wrong, with the numbers.
    pub(super) says: String,
}

/// Every conflict of a scene.
pub(super) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let checks = [
        phases, horizons, losses, starts, layouts, volumes, spans, asymptotes, rungs, tilts, goals,
    ];
    checks.iter().flat_map(|check| check(scene)).collect()
}

/// A conflict where `holds` is false.
fn require(holds: bool, keys: [&'static str; 2], says: String) -> Option<Conflict> {
    (!holds).then_some(Conflict { keys, says })
}

/// Phases follow one another. Without a snap there is no attraction either.
fn phases(scene: &Scene) -> Vec<Conflict> {
    let schedule = &scene.schedule;
    let (first, snap, last) = (
        schedule.attraction_from,
        schedule.snap_at,
        schedule.iterations,
    );
    let late_snap = require(
        snap <= last,
        ["schedule.snap_at", "schedule.iterations"],
        format!("the snap (iteration {snap}) comes after the last iteration ({last})"),
    );
    let late_attraction = require(
        first <= snap || snap == 0,
        ["schedule.attraction_from", "schedule.snap_at"],
        format!("the attraction begins (iteration {first}) after the snap (iteration {snap})"),
    );
    late_snap.into_iter().chain(late_attraction).collect()
}

/// The steps that carry the gradient are steps of the rollout.
fn horizons(scene: &Scene) -> Vec<Conflict> {
    let [first, last] = scene.schedule.horizon;
    let (longest, steps) = (first.max(last), scene.physics.steps);
    let keys = ["schedule.horizon", "physics.steps"];
    let says = format!("the horizon ({longest} steps) is longer than the rollout ({steps} steps)");
    require(longest <= steps, keys, says).into_iter().collect()
}

/// What a mean loss averages lies within every horizon.
fn losses(scene: &Scene) -> Vec<Conflict> {
    let (window, every) = (scene.loss.window, scene.loss.every);
    let [first, last] = scene.schedule.horizon;
    let shortest = first.min(last);
    if scene.loss.kind == LossKind::Final {
        return Vec::new();
    }
    let wide = require(
        window <= shortest,
        ["loss.window", "schedule.horizon"],
        format!(
            "the loss averages {window} steps, more than the shortest horizon has ({shortest})"
        ),
    );
    let sparse = require(
        every <= window,
        ["loss.every", "loss.window"],
        format!("the loss takes every {every}th step, of only {window}"),
    );
    wide.into_iter().chain(sparse).collect()
}

/// A layout is one-hot from the start; everything else has to be snapped.
fn starts(scene: &Scene) -> Vec<Conflict> {
    let snap = scene.schedule.snap_at;
    let says = match (scene.start.kind, snap) {
        (StartKind::Layout, 0) => return Vec::new(),
        (StartKind::Layout, _) => {
            format!("a layout has nothing to snap at iteration {snap}: set snap_at = 0")
        }
        (_, 0) => "without a snap (snap_at = 0) the start must be a layout".to_string(),
        _ => return Vec::new(),
    };
    vec![Conflict {
        keys: ["schedule.snap_at", "start.kind"],
        says,
    }]
}

/// The layouts belong to one lattice.
fn layouts(scene: &Scene) -> Vec<Conflict> {
    let (columns, rows) = (scene.lattice.columns, scene.lattice.rows);
    let fits = columns == LAYOUT_SIDE && rows == LAYOUT_SIDE;
    let side = if columns == LAYOUT_SIDE {
        "lattice.rows"
    } else {
        "lattice.columns"
    };
    let needed = matches!(scene.start.kind, StartKind::ThreeLegged | StartKind::Layout)
        && scene.start.layout != Layout::Filled;
    let says =
        format!("the three-legged layouts belong to a lattice of 6x6 nodes, not {columns}x{rows}");
    require(fits || !needed, [side, "start.kind"], says)
        .into_iter()
        .collect()
}

/// Actuators are solid.
fn volumes(scene: &Scene) -> Vec<Conflict> {
    let (least, most) = (scene.volume.actuator[0], scene.volume.solid[1]);
    let keys = ["volume.actuator", "volume.solid"];
    let says =
        format!("the least share of actuators ({least}) is above the most of solids ({most})");
    require(least <= most, keys, says).into_iter().collect()
}

/// Pairs whose first entry is the lower one.
fn spans(scene: &Scene) -> Vec<Conflict> {
    let iterations = |span: [usize; 2]| span.map(|iteration| iteration as f64);
    let pairs = [
        ("volume.solid", scene.volume.solid),
        ("volume.actuator", scene.volume.actuator),
        (
            "volume.widening_over",
            iterations(scene.volume.widening_over),
        ),
        (
            "schedule.horizon_over",
            iterations(scene.schedule.horizon_over),
        ),
        (
            "binarisation.threshold_over",
            iterations(scene.binarisation.threshold_over),
        ),
    ];
    let check = |(key, [first, last]): (&'static str, [f64; 2])| {
        let says = format!("`{key}`: the first entry ({first}) is above the second ({last})");
        require(first <= last, [key, key], says)
    };
    pairs.into_iter().filter_map(check).collect()
}

fn asymptotes(scene: &Scene) -> Vec<Conflict> {
    let (least, most) = (scene.mma.asymin, scene.mma.asymax);
    let keys = ["mma.asymin", "mma.asymax"];
    let says =
        format!("the least distance of the asymptotes ({least}) is above the largest ({most})");
    require(least <= most, keys, says).into_iter().collect()
}

/// Starts are dropped at one iteration after the other.
fn rungs(scene: &Scene) -> Vec<Conflict> {
    let rungs = scene.search.rungs;
    let says =
        format!("`search.rungs`: {rungs:?} do not ascend: none may be below the one before it");
    let keys = ["search.rungs"; 2];
    require(rungs.is_sorted(), keys, says).into_iter().collect()
}

/// A layout is what it is.
fn tilts(scene: &Scene) -> Vec<Conflict> {
    let fits = scene.start.kind != StartKind::Layout || scene.start.tilt == 0.0;
    let says = format!("a layout cannot be tilted (by {})", scene.start.tilt);
    require(fits, ["start.tilt", "start.kind"], says)
        .into_iter()
        .collect()
}

/// Of two goals one is pursued by the negative of the other's loss: that is to get far back, and
/// would be to spend energy, to keep away from a target, or to run away from both goals.
fn goals(scene: &Scene) -> Vec<Conflict> {
    let task = scene.objective.task;
    let far = task == TaskKind::Far;
    let says = format!("two goals are there for the task far, not {}", task.name());
    let keys = ["controller.two_goals", "objective.task"];
    require(far || !scene.controller.two_goals, keys, says)
        .into_iter()
        .collect()
}
