//! The experiments of the studies, as built-in scenes with changes.

use cosmic::error::{Error, Result};
use cosmic::scene::{Scene, named};
use serde::Serialize;

/// The kind of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyKind {
    /// The paper's designs and environments, strictly by its algorithm and with the defaults.
    Paper,
    /// All combinations of topology, material and control to design.
    Ablation,
    /// The paper's findings, by one change of the default scene at a time.
    Findings,
    /// Designs in another simulator.
    Transfer,
}

impl StudyKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Paper, Self::Ablation, Self::Findings, Self::Transfer];

    /// Its name, on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            StudyKind::Paper => "paper",
            StudyKind::Ablation => "ablation",
            StudyKind::Findings => "findings",
            StudyKind::Transfer => "transfer",
        }
    }
}

/// One experiment, to be run with every seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Trial {
    /// Its name in files.
    pub(super) name: String,
    /// The table that it belongs to.
    pub(super) table: &'static str,
    /// Its title in documents.
    pub(super) title: &'static str,
    /// The paper's displacement along the ground, m.
    pub(super) paper: Option<f64>,
    /// Its scene.
    #[serde(skip)]
    pub(super) scene: Scene,
}

/// Settings under all of a study's scenes. Without any, both texts are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Base {
    /// The file's name, for messages.
    pub file: String,
    /// Its text, TOML.
    pub text: String,
}

/// The table by the paper's algorithm with no departure.
pub(super) const STRICT: &str = "strict";
/// The table with the defaults.
pub(super) const DEFAULT: &str = "default";

/// Switches every departure off that is on by default.
const WITHOUT_DEPARTURES: &str = "
schedule = { settle = 0.0, snap_trials = 0, polish_trials = 0 }
gradient = { design_memory = 0.0, cotangent_bound = 'off' }
loss.kind = 'final'
selection.kind = 'last'
design.one_piece = false
";

/// The paper's layout for both its baseline and its three-legged start.
const WITHOUT_SHORT_START: &str = "start.layout = 'tall'";

/// The paper's experiments: the built-in scene, the title, the paper's number.
const PAPER: [(&str, &str, Option<f64>); 8] = [
    ("baseline_tall", "a, sequential baseline, tall", Some(1.14)),
    ("baseline_short", "a, sequential baseline, short", None),
    ("stability", "b, stability heuristic", Some(1.90)),
    ("three_legged", "c, three-legged heuristic", Some(1.87)),
    ("uniform", "d, no heuristic", Some(0.98)),
    // 1.36 m across and 0.35 m up.
    ("incline", "incline of 15 degrees", Some(1.404)),
    ("five_by_five", "5x5 nodes", Some(1.10)),
    ("coulomb", "Coulomb friction of 2.5", None),
];

/// The trials of a study over the settings of `base`.
///
/// # Errors
/// The errors of [`Scene::parse`], if the base does not go with the study's own settings.
pub(super) fn trials(kind: StudyKind, base: &Base) -> Result<Vec<Trial>> {
    match kind {
        StudyKind::Paper => paper(base),
        StudyKind::Ablation => ablation(base),
        StudyKind::Findings => changed(base, kind, FINDINGS),
        StudyKind::Transfer => changed(base, kind, TRANSFERRED),
    }
}

impl Base {
    /// A built-in scene over these settings, with changes.
    fn scene(&self, name: &str, changes: &[&str]) -> Result<Scene> {
        let changes_of_builtin = named(name).map_or(String::new(), |builtin| builtin.changes());
        let below = Scene::paper().with(&self.file, &self.text)?;
        let place = format!("changes of {name}");
        let mut changes = changes.iter();
        let scene = below
            .with(name, &changes_of_builtin)
            .and_then(|scene| changes.try_fold(scene, |scene, change| scene.with(&place, change)));
        // The place is in the study's own settings, the cause may be in the others.
        scene.map_err(|error| match &self.file[..] {
            "" => error,
            file => Error::Usage(format!(
                "the settings of {file} do not go with the study's: {}",
                error.within()
            )),
        })
    }
}

fn paper(base: &Base) -> Result<Vec<Trial>> {
    let trial = |(table, (name, title, paper))| {
        let changes: &[&str] = match (table, name) {
            (DEFAULT, _) => &[],
            (_, "three_legged") => &[WITHOUT_DEPARTURES, WITHOUT_SHORT_START],
            _ => &[WITHOUT_DEPARTURES],
        };
        Ok(Trial {
            name: format!("{table}-{name}"),
            table,
            title,
            paper,
            scene: base.scene(name, changes)?,
        })
    };
    let tables = [DEFAULT, STRICT].into_iter();
    let rows = tables.flat_map(|table| PAPER.map(|row| (table, row)));
    rows.map(trial).collect()
}

/// A bit for what a trial of the ablation designs: which edges exist.
pub(super) const TOPOLOGY: u8 = 0b100;
/// A bit for what a trial designs: which edges are actuators.
pub(super) const MATERIAL: u8 = 0b010;
/// A bit for what a trial designs: the controller's weights.
pub(super) const CONTROL: u8 = 0b001;

/// The trials of the ablation in the order of the paper's figure: name, title, the paper's number, the
/// bits of what it designs.
pub(super) const ABLATION: [(&str, &str, Option<f64>, u8); 8] = [
    ("none", "a, nothing", None, 0),
    ("control", "b, control", None, CONTROL),
    ("topology", "c, topology", None, TOPOLOGY),
    ("topology-control", "d, topology and control", None, 0b101),
    ("material", "e, material", None, MATERIAL),
    ("material-control", "f, material and control", None, 0b011),
    (
        "topology-material",
        "g, topology and material",
        Some(1.02),
        0b110,
    ),
    ("all", "h, all three", Some(1.91), 0b111),
];

/// The paper holds materials by lowering those that are not dominant. No design vector can overcome an
/// offset as wide as the range of the design vectors.
const HELD_MATERIALS: &str = "projection.hold_materials = 1.0";

/// The paper holds the topology by its volume alone.
const HELD_TOPOLOGY: &str = "
start = { kind = 'filled', void = 0.05 }
volume.solid = [0.9, 1.0]
";

/// Nothing to design: the filled layout as it is, its controller trained as the baseline's.
const HELD_LAYOUT: &str = "
start = { kind = 'layout', layout = 'filled' }
schedule = { iterations = 200, snap_at = 0 }
adam.fine_rate = 0.006
";

/// The controller keeps its first weights.
const HELD_CONTROL: &str = "adam = { rate = 0.0, fine_rate = 0.0 }";

/// If nothing is designed, one iteration is enough.
const HELD_ALL: &str = "schedule.iterations = 1";

fn ablation(base: &Base) -> Result<Vec<Trial>> {
    let trial = |(name, title, paper, designs): (&str, _, _, u8)| {
        let mut changes = match (designs & TOPOLOGY > 0, designs & MATERIAL > 0) {
            (true, true) => vec![],
            (true, false) => vec![HELD_MATERIALS],
            (false, true) => vec![HELD_TOPOLOGY],
            (false, false) => vec![HELD_LAYOUT],
        };
        if designs & CONTROL == 0 {
            changes.push(HELD_CONTROL);
        }
        if designs == 0 {
            changes.push(HELD_ALL);
        }
        Ok(Trial {
            name: name.to_owned(),
            table: "ablation",
            title,
            paper,
            scene: base.scene("stability", &changes)?,
        })
    };
    ABLATION.into_iter().map(trial).collect()
}

/// The trial that the others of the findings are compared with.
pub(super) const REFERENCE: &str = "stability";

/// Changes of a built-in scene: the trial's name, the scene, the title, the change.
///
/// `two-goals` needs a larger goal scale: as an input of 0.1, the controller could not tell two goals apart.
/// It delivers the last iterate, because a choice by the goal ahead would bias the sample.
const FINDINGS: &str = "
stability           | stability    | the default |
simp                | stability    | stiffness penalised as in SIMP, exponent 3 | materials.penalisation = 3
constraints         | stability    | binarisation by strict constraints | binarisation.method = 'constraints'
no-stability-pass   | stability    | no stability pass | schedule.stability_share = 0.0
clocks-20           | stability    | 20 clocks | controller.clocks = 20
clocks-40           | stability    | 40 clocks | controller.clocks = 40
two-goals           | stability    | trained for two goals, goal scale 0.5, last | \
    controller = { two_goals = true, goal_scale = 0.5 }; selection.kind = 'last'
final-loss          | stability    | without loss.kind | loss.kind = 'final'
exact-gradient      | stability    | without gradient.cotangent_bound | gradient.cotangent_bound = 'off'
last-iterate        | stability    | without selection.kind | selection.kind = 'last'
single-precision    | stability    | rollouts in f32 | gradient.precision = 'f32'
c                   | three_legged | c as by default |
c-no-stability-pass | three_legged | c, no stability pass | schedule.stability_share = 0.0
c-tall              | three_legged | c, without start.layout | start.layout = 'tall'
d                   | uniform      | d as by default |
d-no-memory         | uniform      | d, without gradient.design_memory | gradient.design_memory = 0.0
d-no-trials         | uniform      | d, without schedule.snap_trials | schedule.snap_trials = 0
d-no-polish         | uniform      | d, without schedule.polish_trials | schedule.polish_trials = 0
d-no-settling       | uniform      | d, without schedule.settle | schedule.settle = 0.0
loose               | stability    | without design.one_piece | design.one_piece = false
no-free-ends        | stability    | no bar with a free end | design.free_ends = false
no-crossings        | stability    | no bars that cross | design.crossings = false
feet                | stability    | at least four feet | design.feet = 4
stops               | stability    | end stops of 400 N/m | physics.forces = ['stops']
";

/// The lines of a table as text, each with four cells between bars.
///
/// # Panics
/// If a line has another number of cells: the tables are constants.
pub(super) fn lines(table: &'static str) -> impl Iterator<Item = [&'static str; 4]> {
    let cells = |line: &'static str| line.split('|').map(str::trim).collect::<Vec<_>>();
    let lines = table.lines().filter(|line| !line.is_empty());
    lines.map(move |line| cells(line).try_into().expect(line))
}

/// The trials whose designs are tried in another simulator, in the form of [`FINDINGS`]. On slippery ground a faster
/// clock and a tighter bound on the cotangent get farther.
const TRANSFERRED: &str = "
stability | stability | `stability` |
coulomb   | coulomb   | `coulomb`, friction 2.5 |
incline   | incline   | `incline`, 15 degrees |
friction  | stability | `stability`, friction 1 | physics = { contact = 'coulomb', friction = 1.0 }; \
    controller.omega = 13.0; gradient.cotangent_bound = 1.0
scattered | stability | `stability`, friction 0.8 scattered by 0.4 | physics = { contact = 'coulomb', friction = 0.8 }; \
    robust = { samples = 2, friction = 0.4 }; controller.omega = 13.0; gradient.cotangent_bound = 1.0
heavy     | stability | `stability`, gravity 9.81, friction 1, robust | \
    physics = { gravity = 9.81, contact = 'coulomb', friction = 1.0 }; robust.samples = 2
earth     | earth     | `earth` |
";

/// The trials of a table of changes, by the study's name.
fn changed(base: &Base, study: StudyKind, table: &'static str) -> Result<Vec<Trial>> {
    let trial = |[name, builtin, title, change]: [&'static str; 4]| {
        Ok(Trial {
            name: name.to_owned(),
            table: study.name(),
            title,
            paper: None,
            scene: base.scene(builtin, &[&change.replace("; ", "\n")])?,
        })
    };
    lines(table).map(trial).collect()
}

#[cfg(test)]
mod tests {
    use super::{Base, STRICT, StudyKind, Trial, trials};
    use cosmic::codesign::CoDesign;
    use cosmic::scene::Scene;

    #[test]
    fn the_strict_table_departs_in_nothing_and_the_other_is_the_built_in_scenes() {
        for trial in trials(StudyKind::Paper, &Base::default()).unwrap() {
            let departures = trial.scene.departures();
            assert_eq!(
                departures.is_empty(),
                trial.table == STRICT,
                "{departures:?}"
            );
            if let Some(name) = trial.name.strip_prefix("default-") {
                assert_eq!(trial.scene, Scene::load(name).unwrap());
            }
        }
    }

    /// So the eight trials of the ablation are all combinations.
    #[test]
    fn every_trial_can_begin_and_is_not_another() {
        for kind in StudyKind::ALL {
            let trials = trials(kind, &Base::default()).unwrap();
            for (k, trial) in trials.iter().enumerate() {
                CoDesign::new(&trial.scene).unwrap().begin(0).unwrap();
                let same = |other: &Trial| other.scene == trial.scene;
                assert!(!trials[..k].iter().any(same), "{}", trial.name);
            }
        }
    }

    #[test]
    fn a_base_lies_under_every_scene() {
        let base = |text: &str| Base {
            file: "base.toml".to_owned(),
            text: text.to_owned(),
        };
        let heavier = base("[physics]\ngravity = 1.5\n");
        for trial in trials(StudyKind::Ablation, &heavier).unwrap() {
            assert_eq!(trial.scene.physics.gravity, 1.5);
        }
        let wrong = base("[physics]\ngravty = 1");
        let error = trials(StudyKind::Paper, &wrong).unwrap_err().to_string();
        assert!(error.contains("base.toml:2:1"), "{error}");
    }
}
