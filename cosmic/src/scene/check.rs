//! Settings that are each in range and yet do not fit one another.

use super::layout::LAYOUT_SIDE;
use super::{LossKind, Scene, StartKind};

/// Settings at odds: their keys, the one to point at first, and what they must satisfy.
pub(super) struct Conflict {
    pub(super) keys: [&'static str; 2],
    pub(super) says: String,
}

/// Every conflict of a scene.
pub(super) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let mut conflicts = phases(scene);
    conflicts.extend(horizons(scene));
    conflicts.extend(starts(scene));
    conflicts.extend(bounds(scene));
    conflicts
}

/// Phases follow one another. A layout start has no snap and no attraction.
fn phases(scene: &Scene) -> Vec<Conflict> {
    let schedule = &scene.schedule;
    let (attraction, snap, iterations) = (
        schedule.attraction_from,
        schedule.snap_at,
        schedule.iterations,
    );
    let keys = ["schedule.snap_at", "schedule.iterations"];
    let mut conflicts = Vec::new();
    conflicts.extend(require(snap <= iterations, keys, || {
        format!("the snap (iteration {snap}) comes after the last iteration ({iterations})")
    }));
    let keys = ["schedule.attraction_from", "schedule.snap_at"];
    conflicts.extend(require(attraction <= snap || snap == 0, keys, || {
        format!("the attraction begins (iteration {attraction}) after the snap (iteration {snap})")
    }));
    conflicts
}

/// What carries the gradient is part of the rollout, what the loss averages part of that.
fn horizons(scene: &Scene) -> Vec<Conflict> {
    let [first, last] = scene.schedule.horizon;
    let steps = scene.physics.steps;
    let keys = ["schedule.horizon", "physics.steps"];
    let mut conflicts = Vec::new();
    conflicts.extend(require(first.max(last) <= steps, keys, || {
        format!(
            "the horizon ({}) is longer than the rollout ({steps} steps)",
            first.max(last)
        )
    }));
    let loss = &scene.loss;
    let (window, shortest) = (loss.window, first.min(last));
    let keys = ["loss.window", "schedule.horizon"];
    conflicts.extend(require(window <= shortest || loss.kind == LossKind::Final, keys, || {
        format!("the loss averages over more steps ({window}) than the shortest horizon has ({shortest})")
    }));
    let keys = ["loss.every", "loss.window"];
    conflicts.extend(require(
        loss.every <= window || loss.kind == LossKind::Final,
        keys,
        || {
            format!(
                "the loss skips more steps ({}) than it averages over ({window})",
                loss.every
            )
        },
    ));
    conflicts
}

/// Layouts belong to one lattice, and are one-hot from the start.
fn starts(scene: &Scene) -> Vec<Conflict> {
    let kind = scene.start.kind;
    let lattice = &scene.lattice;
    let fits = lattice.columns == LAYOUT_SIDE && lattice.rows == LAYOUT_SIDE;
    let needs_layout = matches!(kind, StartKind::ThreeLegged | StartKind::Layout);
    let side = if lattice.columns == LAYOUT_SIDE {
        "lattice.rows"
    } else {
        "lattice.columns"
    };
    let mut conflicts = Vec::new();
    conflicts.extend(require(fits || !needs_layout, [side, "start.kind"], || {
        format!(
            "the three-legged layouts belong to a 6x6 lattice, not {}x{}",
            lattice.columns, lattice.rows
        )
    }));
    let snap = scene.schedule.snap_at;
    let keys = ["schedule.snap_at", "start.kind"];
    conflicts.extend(require(snap == 0 || kind != StartKind::Layout, keys, || {
        format!("start.kind = \"layout\" has nothing to snap at iteration {snap}: set schedule.snap_at = 0")
    }));
    conflicts.extend(require(snap > 0 || kind == StartKind::Layout, keys, || {
        "schedule.snap_at = 0 needs a design that is one-hot: start.kind = \"layout\"".to_string()
    }));
    conflicts
}

/// Bounds and spans that must be in order.
fn bounds(scene: &Scene) -> Vec<Conflict> {
    let volume = &scene.volume;
    let ordered = [
        ("volume.solid", volume.solid),
        ("volume.actuator", volume.actuator),
        (
            "volume.widening_over",
            volume.widening_over.map(|n| n as f64),
        ),
        (
            "schedule.horizon_over",
            scene.schedule.horizon_over.map(|n| n as f64),
        ),
        (
            "binarisation.threshold_over",
            scene.binarisation.threshold_over.map(|n| n as f64),
        ),
    ];
    let mut conflicts = Vec::new();
    for (key, [first, last]) in ordered {
        conflicts.extend(require(first <= last, [key, key], || {
            format!("`{key}`: the first ({first}) is above the last ({last})")
        }));
    }
    let (least, most) = (volume.actuator[0], volume.solid[1]);
    let keys = ["volume.actuator", "volume.solid"];
    conflicts.extend(require(least <= most, keys, || {
        format!("the least share of actuators ({least}) is above the most of solids ({most})")
    }));
    let (nearest, farthest) = (scene.mma.asymin, scene.mma.asymax);
    conflicts.extend(require(
        nearest <= farthest,
        ["mma.asymin", "mma.asymax"],
        || {
            format!(
                "the least distance of the asymptotes ({nearest}) is above the largest ({farthest})"
            )
        },
    ));
    conflicts
}

/// A conflict where `holds` is false.
fn require(
    holds: bool,
    keys: [&'static str; 2],
    says: impl FnOnce() -> String,
) -> Option<Conflict> {
    (!holds).then(|| Conflict { keys, says: says() })
}
