//! Checks whether settings contradict one another.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::geometry::Dimension;
use crate::lattice::Lattice;
use crate::scene::sections::LAYOUT_SIDE;
use crate::scene::sections::MOST_STEPS;
use crate::scene::{
    ActuatorPart, GoalKind, GroundSettings, LatticeKind, Layout, LossKind, Named, ProfileKind,
    Scene, StartKind, TaskKind, VolumeSettings,
};

impl Scene {
    /// Checks the values of all settings. A scene that was read from a file always passes. A scene whose fields were
    /// changed by a program may fail.
    ///
    /// # Errors
    /// [`Error::Usage`] with all settings that are out of range, or else with all settings that contradict one another.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        self.clone().of_sections(|section, settings| {
            for field in settings.fields() {
                if !field.value.fits(&field.limits) {
                    let (key, value, allowed) = (field.key, field.value.toml(), field.allowed());
                    let says = format!("`{section}.{key}` is out of range: {value}");
                    faults.push(format!("{says}; allowed: {allowed}"));
                }
            }
        });
        if faults.is_empty() {
            faults.extend(conflicts(self).into_iter().map(|conflict| conflict.says));
        }
        match faults.is_empty() {
            true => Ok(()),
            false => Err(Error::Usage(format!("the scene: {}", faults.join("; ")))),
        }
    }
}

/// Two settings that contradict each other.
pub(in crate::scene) struct Conflict {
    /// The keys of the two settings. The message points at the first one. If the entries of one setting contradict each
    /// other, both keys are the key of this setting.
    pub(in crate::scene) keys: [&'static str; 2],
    /// The conflict in a sentence, with the values of the settings.
    pub(in crate::scene) says: String,
}

/// The largest number of nodes of a generated lattice.
const MOST_NODES: usize = 4096;

/// Finds the lattice too large, if it is. The settings that follow from a lattice take too long for a larger one.
pub(in crate::scene) fn size(scene: &Scene) -> Option<Conflict> {
    let (lattice, nodes) = (&scene.lattice, scene.lattice.nodes());
    (!lattice.is_truss() && nodes > MOST_NODES).then(|| Conflict {
        keys: ["lattice.depth", "lattice.columns"],
        says: format!(
            "a lattice of {} has {nodes} nodes; at most {MOST_NODES} are allowed",
            lattice.name()
        ),
    })
}

/// Finds every conflict between the settings of a scene.
pub(in crate::scene) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let mut found = Conflicts(size(scene).into_iter().collect());
    if !found.0.is_empty() {
        return found.0;
    }
    for rule in [
        phases, horizons, starts, volumes, trusses, payloads, mirrors, spans, goals, terrain,
        parts, space,
    ] {
        rule(scene, &mut found);
    }
    found.0
}

/// The conflicts found so far.
struct Conflicts(Vec<Conflict>);

impl Conflicts {
    /// Adds a conflict unless `holds` is true.
    fn require(&mut self, holds: bool, keys: [&'static str; 2], says: String) {
        if !holds {
            self.0.push(Conflict { keys, says });
        }
    }
}

/// The phases of a run must be in order: the attraction begins before the snap, and the snap is not after the last
/// iteration. A run without a snap has no attraction.
fn phases(scene: &Scene, found: &mut Conflicts) {
    let schedule = &scene.schedule;
    let (snap, last) = (schedule.snap_at, schedule.iterations);
    found.require(
        snap <= last,
        ["schedule.snap_at", "schedule.iterations"],
        format!(
            "the snap (iteration {snap}) comes after the last iteration ({last}); `--iterations` changes \
             both"
        ),
    );
    let first = schedule.attraction_from;
    found.require(
        first <= snap || snap == 0,
        ["schedule.attraction_from", "schedule.snap_at"],
        format!("the attraction begins (iteration {first}) after the snap (iteration {snap})"),
    );
}

/// The horizon is the part of a rollout that carries the gradient. The window of a mean loss must fit into it. A horizon
/// that is longer than the rollout ends with the rollout. It is allowed, because most commands do not read the horizon and
/// must accept a short rollout.
fn horizons(scene: &Scene, found: &mut Conflicts) {
    let [first, last] = scene.schedule.horizon;
    let shortest = first.min(last);
    if scene.loss.kind == LossKind::Final {
        return;
    }
    let (window, every) = (scene.loss.window, scene.loss.every);
    found.require(
        window <= shortest,
        ["loss.window", "schedule.horizon"],
        format!(
            "the loss averages the last {window} steps, but the shortest horizon has only {shortest}"
        ),
    );
    found.require(
        every <= window,
        ["loss.every", "loss.window"],
        format!("the loss takes every {every}th step, but its window has only {window} steps"),
    );
}

/// A start that is a layout has nothing to snap and cannot be tilted. Every other start must be snapped. The
/// three-legged layouts fit only one lattice.
fn starts(scene: &Scene, found: &mut Conflicts) {
    let (start, snap) = (&scene.start, scene.schedule.snap_at);
    let is_layout = start.kind == StartKind::Layout;
    let snapped = ["schedule.snap_at", "start.kind"];
    found.require(
        !is_layout || snap == 0,
        snapped,
        format!("a layout has nothing to snap at iteration {snap}: set snap_at = 0"),
    );
    found.require(
        is_layout || snap > 0,
        snapped,
        "without a snap (snap_at = 0) the start must be a layout".to_owned(),
    );
    let lattice = &scene.lattice;
    let key = if lattice.is_truss() {
        "lattice.file"
    } else if lattice.kind != LatticeKind::Rectangular {
        "lattice.kind"
    } else if lattice.columns == LAYOUT_SIDE {
        "lattice.rows"
    } else {
        "lattice.columns"
    };
    let name = lattice.name();
    let is_of_layouts = name == format!("{LAYOUT_SIDE}x{LAYOUT_SIDE}");
    let has_legs =
        (is_layout || start.kind == StartKind::ThreeLegged) && start.layout != Layout::Filled;
    found.require(
        !has_legs || is_of_layouts,
        [key, "start.kind"],
        format!("the three-legged layouts belong to a lattice of 6x6 nodes, not {name}"),
    );
    found.require(
        !is_layout || start.tilt == 0.0,
        ["start.tilt", "start.kind"],
        format!(
            "a layout cannot be tilted (by {}): set start.tilt = 0",
            start.tilt
        ),
    );
}

/// The smallest share of actuators must not exceed the largest share of solids, because actuators are solid.
fn volumes(scene: &Scene, found: &mut Conflicts) {
    let (least, most) = (scene.volume.actuator[0], scene.volume.solid[1]);
    found.require(
        least <= most,
        ["volume.actuator", "volume.solid"],
        format!("the smallest allowed share of actuators ({least}) is above the largest allowed share of solids ({most})"),
    );
}

/// A truss cannot be combined with `lattice.kind`. The edges that it keeps and forbids must leave room for the bounds
/// on the volumes.
fn trusses(scene: &Scene, found: &mut Conflicts) {
    let Some(truss) = scene.lattice.file.truss() else {
        return;
    };
    found.require(
        scene.lattice.kind == LatticeKind::Rectangular,
        ["lattice.kind", "lattice.file"],
        "a truss has no kind: leave `kind` out".to_owned(),
    );
    let volume = &scene.volume;
    let [least, most] = volume.solid;
    let edges = truss.edges.len() as f64;
    let rules = &truss.rules;
    let share = |lists: &[&Vec<usize>]| {
        let distinct: HashSet<_> = lists.iter().copied().flatten().collect();
        distinct.len() as f64 / edges
    };
    let kept = share(&[&rules.keep, &rules.skeleton, &rules.actuator]);
    let forbidden = share(&[&rules.forbid]);
    let [actuators, passive] = [
        share(&[&rules.actuator]),
        share(&[&rules.skeleton, &rules.forbid]),
    ];
    let [fewest, greatest] = volume.actuator;
    found.require(
        actuators <= greatest + VolumeSettings::WIDENING,
        ["volume.actuator", "lattice.file"],
        format!(
            "the truss makes a share of {actuators:.3} of its edges actuators, but at most {greatest} may be actuators"
        ),
    );
    found.require(
        1.0 - passive >= fewest - VolumeSettings::WIDENING,
        ["volume.actuator", "lattice.file"],
        format!(
            "the truss excludes a share of {passive:.3} of its edges from being actuators, but at least {fewest} must \
             be actuators"
        ),
    );
    found.require(
        kept <= most + VolumeSettings::WIDENING,
        ["volume.solid", "lattice.file"],
        format!(
            "the truss keeps a share of {kept:.3} of its edges, but at most {most} may be solid"
        ),
    );
    found.require(
        1.0 - forbidden >= least - VolumeSettings::WIDENING,
        ["volume.solid", "lattice.file"],
        format!(
            "the truss forbids a share of {forbidden:.3} of its edges, but at least {least} must \
             be solid"
        ),
    );
}

/// The payload is a node of the lattice. A truss names its own payload.
fn payloads(scene: &Scene, found: &mut Conflicts) {
    let (payload, nodes) = (scene.lattice.payload, scene.lattice.nodes());
    if scene.lattice.is_truss() {
        found.require(
            payload == 0,
            ["lattice.payload", "lattice.file"],
            format!("a truss names its own payload in its file: leave `payload` ({payload}) out"),
        );
    } else {
        found.require(
            payload < nodes,
            ["lattice.payload", "lattice.columns"],
            format!(
                "node {payload} does not exist in a lattice of {} nodes; `payload` must be below {nodes}",
                scene.lattice.name()
            ),
        );
    }
}

/// A robot that is its own mirror image needs a lattice that is its own image, with the payload in the middle.
fn mirrors(scene: &Scene, found: &mut Conflicts) {
    if !scene.lattice.mirror {
        return;
    }
    let ties = scene
        .lattice
        .file
        .truss()
        .is_some_and(|truss| !truss.rules.tie.is_empty());
    found.require(
        !ties,
        ["lattice.mirror", "lattice.file"],
        "`mirror` ties edges, and so does the truss file: leave out one of them".to_owned(),
    );
    found.require(
        Lattice::new(&scene.lattice, &scene.physics).mirror.is_some(),
        ["lattice.mirror", if scene.lattice.is_truss() { "lattice.file" } else { "lattice.payload" }],
        "the lattice is not its own mirror image: it needs nodes, edges and the payload at the same places seen from the \
         front and from behind (an odd number of columns, and the payload in the middle column); in space from the left and \
         from the right (an odd `depth`, and the payload in the middle)"
            .to_owned(),
    );
    // In space, an incline does not tell left from right.
    let in_plane = scene.lattice.dimension() == Dimension::Plane;
    found.require(
        !in_plane || scene.physics.incline_deg == 0.0 || scene.controller.policy.name() != "gaits",
        ["lattice.mirror", "physics.incline_deg"],
        "on an incline the gait back is not the mirror image of the gait ahead: leave out `mirror`"
            .to_owned(),
    );
}

/// The first entry of a range must not exceed the second.
fn spans(scene: &Scene, found: &mut Conflicts) {
    let iterations = |span: [usize; 2]| span.map(|iteration| iteration as f64);
    let (volume, schedule) = (&scene.volume, &scene.schedule);
    let thresholds = scene.binarisation.threshold_over;
    for (key, [first, last]) in [
        ("volume.solid", volume.solid),
        ("volume.actuator", volume.actuator),
        ("goals.across", scene.goals.across),
        ("schedule.horizon_over", iterations(schedule.horizon_over)),
        ("binarisation.threshold_over", iterations(thresholds)),
    ] {
        let says = format!("`{key}`: the first entry ({first}) is above the second ({last})");
        found.require(first <= last, [key, key], says);
    }
}

/// Given goals need a policy that observes them, a task that reads them, and room to be apart.
fn goals(scene: &Scene, found: &mut Conflicts) {
    let (controller, goals) = (&scene.controller, &scene.goals);
    let given = |key| [key, "controller.goals"];
    if let Some((key, why)) = controller.misfit() {
        found.require(false, given(key), why.to_owned());
    }
    if controller.goals != GoalKind::Given {
        return;
    }
    let task = scene.objective.task;
    found.require(
        !scene.has_task() || task == TaskKind::Reach,
        given("objective.task"),
        format!(
            "given goals need the task \"reach\", but the task is \"{}\"",
            task.name()
        ),
    );
    let [low, high] = goals.along;
    found.require(
        low < high,
        given("goals.along"),
        format!("goals need a range: its first entry ({low}) must be below the second ({high})"),
    );
}

/// The ground of a robot in space is a plane. A planar robot cannot have goals beside its plane.
fn space(scene: &Scene, found: &mut Conflicts) {
    let (physics, controller) = (&scene.physics, &scene.controller);
    let key = if scene.lattice.is_truss() {
        "lattice.file"
    } else {
        "lattice.kind"
    };
    if scene.lattice.dimension() == Dimension::Plane {
        found.require(
            controller.goal.sideways() == 0.0,
            ["controller.goal", key],
            "a planar robot cannot reach a goal beside its plane: leave out the second of the three numbers".to_owned(),
        );
        let [low, high] = scene.goals.across;
        found.require(
            [low, high] == [0.0, 0.0],
            ["goals.across", key],
            format!("a planar robot cannot reach goals beside its plane (from {low} to {high} m): leave out `across`"),
        );
        return;
    }
    found.require(
        physics.ground.profile == ProfileKind::Flat,
        ["ground.profile", key],
        "the ground of a robot in space is a plane: set ground.profile = \"flat\"".to_owned(),
    );
}

/// A tube has a wall. The longest bar needs at most the stroke of its device.
fn parts(scene: &Scene, found: &mut Conflicts) {
    let parts = &scene.materials.parts;
    if let Err(says) = parts.check() {
        found.require(false, ["parts.inner", "parts.outer"], says);
    }
    if parts.actuator != ActuatorPart::Device {
        return;
    }
    let lengths = Lattice::new(&scene.lattice, &scene.physics).rest_length;
    let longest = lengths.into_iter().fold(0.0, f64::max);
    let strain = scene.materials.actuator_strain();
    let (needed, stroke) = (2.0 * strain * longest, parts.stroke);
    found.require(
        needed <= stroke,
        ["parts.stroke", "materials.max_strain"],
        format!(
            "the longest bar ({longest:.4} m) with the largest actuation strain {strain} needs a stroke of {needed:.4} m, \
             but the actuator has {stroke} m; set the last entry of materials.max_strain to {:.4} or less",
            0.5 * stroke / longest
        ),
    );
}

/// The profile `points` needs at least one point. The number of steps is limited.
fn terrain(scene: &Scene, found: &mut Conflicts) {
    let ground = &scene.physics.ground;
    found.require(
        ground.profile != ProfileKind::Points || !ground.points.is_flat(),
        ["ground.profile", "ground.points"],
        "the profile `points` has no points: set ground.points".to_owned(),
    );
    if ground.profile == ProfileKind::Steps {
        steps(ground, found);
    }
    if let (true, Err(says)) = (found.0.is_empty(), ground.checked()) {
        let says = format!("the profile of the ground {says}");
        found.require(false, ["ground.profile", "ground.spacing"], says);
    }
}

fn steps(ground: &GroundSettings, found: &mut Conflicts) {
    found.require(
        ground.count <= MOST_STEPS,
        ["ground.count", "ground.profile"],
        format!(
            "there are {} steps; at most {MOST_STEPS} are allowed",
            ground.count
        ),
    );
}
