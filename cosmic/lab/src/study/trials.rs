//! What the studies run: every experiment of the paper as a scene, by what it changes.

use cosmic::error::{Error, Result};
use cosmic::scene::{BUILTIN, Scene};

/// A study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The paper's designs and environments, strictly by its algorithm and with the defaults.
    Paper,
    /// Topology, material and control, each designed or not.
    Ablation,
    /// What the paper says it found, one change of the default scene at a time.
    Findings,
}

impl Kind {
    /// Its name, on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Paper => "paper",
            Kind::Ablation => "ablation",
            Kind::Findings => "findings",
        }
    }
}

/// One experiment, to be run with every seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its name in files.
    pub name: String,
    /// The table that it belongs to.
    pub table: &'static str,
    /// What a reader calls it.
    pub title: &'static str,
    /// The paper's displacement along the ground, m.
    pub paper: Option<f64>,
    /// Its scene.
    pub scene: Scene,
}

/// Settings under all of a study's scenes: a file's name and its text.
#[derive(Clone, Copy, Debug)]
pub struct Base<'a> {
    /// For messages.
    pub file: &'a str,
    /// TOML.
    pub text: &'a str,
}

/// No settings but the defaults.
pub(super) const NO_BASE: Base<'static> = Base { file: "", text: "" };

/// The table by the paper's algorithm with no departure.
pub(super) const STRICT: &str = "strict";
/// The table with the defaults.
pub(super) const DEFAULT: &str = "default";

/// Takes back every departure that is on by default.
const WITHOUT_DEPARTURES: &str = "
[schedule]
settle = 0.0
snap_trials = 0
polish_trials = 0
[gradient]
design_memory = 0.0
cotangent_bound = \"off\"
[loss]
kind = \"final\"
[selection]
kind = \"last\"
";

/// The paper's layout for both its baseline and its three-legged start.
const WITHOUT_SHORT_START: &str = "
[start]
layout = \"tall\"
";

/// The paper's experiments: the built-in scene, what a reader calls it, the paper's number.
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
/// Those of [`Scene::parse`], for settings that the study's own do not go with.
pub fn trials(kind: Kind, base: &Base) -> Result<Vec<Trial>> {
    match kind {
        Kind::Paper => paper(base),
        Kind::Ablation => ablation(base),
        Kind::Findings => findings(base),
    }
}

/// A built-in scene over the base, with changes.
fn scene(base: &Base, name: &str, changes: &[&str]) -> Result<Scene> {
    let builtin = BUILTIN.iter().find(|builtin| builtin.name == name);
    let text = builtin.map_or("", |builtin| builtin.text);
    let below = Scene::parse(base.file, base.text)?;
    let changes = changes
        .iter()
        .map(|text| (format!("changes of {name}"), *text));
    let mut layers = std::iter::once((name.to_owned(), text)).chain(changes);
    let scene = layers.try_fold(below, |scene, (name, text)| scene.with(&name, text));
    // The place is in the study's own settings, the cause may be in the others.
    scene.map_err(|error| match base.file {
        "" => error,
        file => Error::Usage(format!(
            "the settings of {file} do not go with the study's: {}",
            error.within()
        )),
    })
}

fn paper(base: &Base) -> Result<Vec<Trial>> {
    let trial = |table, (name, title, paper)| {
        let mut changes = Vec::new();
        if table == STRICT {
            changes.push(WITHOUT_DEPARTURES);
            changes.extend((name == "three_legged").then_some(WITHOUT_SHORT_START));
        }
        Ok(Trial {
            name: format!("{table}-{name}"),
            table,
            title,
            paper,
            scene: scene(base, name, &changes)?,
        })
    };
    let tables = [DEFAULT, STRICT].into_iter();
    tables
        .flat_map(|table| PAPER.map(|row| trial(table, row)))
        .collect()
}

/// What a trial of the ablation designs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entities {
    /// Which edges exist.
    pub topology: bool,
    /// Which of them are actuators.
    pub material: bool,
    /// The controller's weights.
    pub control: bool,
}

/// The trials of the ablation in the order of the paper's figure.
pub(super) const ABLATION: [(&str, &str, Option<f64>, Entities); 8] = [
    ("none", "a, nothing", None, entities(0b000)),
    ("control", "b, control", None, entities(0b001)),
    ("topology", "c, topology", None, entities(0b100)),
    (
        "topology-control",
        "d, topology and control",
        None,
        entities(0b101),
    ),
    ("material", "e, material", None, entities(0b010)),
    (
        "material-control",
        "f, material and control",
        None,
        entities(0b011),
    ),
    (
        "topology-material",
        "g, topology and material",
        Some(1.02),
        entities(0b110),
    ),
    ("all", "h, all three", Some(1.91), entities(0b111)),
];

/// Topology, material and control from the highest bit down.
const fn entities(bits: u8) -> Entities {
    Entities {
        topology: bits & 0b100 != 0,
        material: bits & 0b010 != 0,
        control: bits & 0b001 != 0,
    }
}

/// The paper holds materials by lowering what is not dominant. An offset as wide as the range of
/// the design vectors cannot be overcome.
const HELD_MATERIALS: &str = "
[projection]
hold_materials = 1.0
";

/// The paper holds the topology by its volume alone.
const HELD_TOPOLOGY: &str = "
[start]
kind = \"filled\"
void = 0.05
[volume]
solid = [0.9, 1.0]
";

/// Nothing to design: the filled layout as it is, its controller trained as the baseline's.
const HELD_LAYOUT: &str = "
[start]
kind = \"layout\"
layout = \"filled\"
[schedule]
iterations = 200
snap_at = 0
[adam]
fine_rate = 0.006
";

/// The controller keeps its first weights.
const HELD_CONTROL: &str = "
[adam]
rate = 0.0
fine_rate = 0.0
";

/// Without anything to design, one iteration is as good as any number.
const HELD_ALL: &str = "
[schedule]
iterations = 1
";

impl Entities {
    fn changes(self) -> Vec<&'static str> {
        let mut changes = match (self.topology, self.material) {
            (true, true) => vec![],
            (true, false) => vec![HELD_MATERIALS],
            (false, true) => vec![HELD_TOPOLOGY],
            (false, false) => vec![HELD_LAYOUT],
        };
        if !self.control {
            changes.push(HELD_CONTROL);
            changes.extend((!self.topology && !self.material).then_some(HELD_ALL));
        }
        changes
    }
}

fn ablation(base: &Base) -> Result<Vec<Trial>> {
    let trial = |(name, title, paper, entities): (&str, _, _, Entities)| {
        Ok(Trial {
            name: name.to_owned(),
            table: "ablation",
            title,
            paper,
            scene: scene(base, "stability", &entities.changes())?,
        })
    };
    ABLATION.into_iter().map(trial).collect()
}

/// The trial that the others of the findings are held against.
pub(super) const REFERENCE: &str = "stability";

/// One controller for a goal ahead and one behind. As an input of 0.1 the goal is too weak to tell
/// them apart by; and what is chosen by the goal ahead would be no fair sample.
const TWO_GOALS: &str = "
[controller]
two_goals = true
goal_scale = 0.5
[selection]
kind = \"last\"
";

/// Changes of a built-in scene: the trial's name, what a reader calls it, the scene, the change.
const FINDINGS: [(&str, &str, &str, &str); 19] = [
    (REFERENCE, "the default", "stability", ""),
    (
        "simp",
        "stiffness penalised as in SIMP, exponent 3",
        "stability",
        "[materials]\npenalisation = 3",
    ),
    (
        "constraints",
        "binarisation by strict constraints",
        "stability",
        "[binarisation]\nmethod = \"constraints\"",
    ),
    (
        "no-stability-pass",
        "no stability pass",
        "stability",
        "[schedule]\nstability_share = 0.0",
    ),
    (
        "clocks-20",
        "20 clocks",
        "stability",
        "[controller]\nclocks = 20",
    ),
    (
        "clocks-40",
        "40 clocks",
        "stability",
        "[controller]\nclocks = 40",
    ),
    (
        "two-goals",
        "trained for two goals, goal scale 0.5, last",
        "stability",
        TWO_GOALS,
    ),
    (
        "final-loss",
        "without loss.kind",
        "stability",
        "[loss]\nkind = \"final\"",
    ),
    (
        "exact-gradient",
        "without gradient.cotangent_bound",
        "stability",
        "[gradient]\ncotangent_bound = \"off\"",
    ),
    (
        "last-iterate",
        "without selection.kind",
        "stability",
        "[selection]\nkind = \"last\"",
    ),
    (
        "single-precision",
        "rollouts in f32",
        "stability",
        "[gradient]\nprecision = \"f32\"",
    ),
    ("c", "c as by default", "three_legged", ""),
    (
        "c-no-stability-pass",
        "c, no stability pass",
        "three_legged",
        "[schedule]\nstability_share = 0.0",
    ),
    (
        "c-tall",
        "c, without start.layout",
        "three_legged",
        WITHOUT_SHORT_START,
    ),
    ("d", "d as by default", "uniform", ""),
    (
        "d-no-memory",
        "d, without gradient.design_memory",
        "uniform",
        "[gradient]\ndesign_memory = 0.0",
    ),
    (
        "d-no-trials",
        "d, without schedule.snap_trials",
        "uniform",
        "[schedule]\nsnap_trials = 0",
    ),
    (
        "d-no-polish",
        "d, without schedule.polish_trials",
        "uniform",
        "[schedule]\npolish_trials = 0",
    ),
    (
        "d-no-settling",
        "d, without schedule.settle",
        "uniform",
        "[schedule]\nsettle = 0.0",
    ),
];

fn findings(base: &Base) -> Result<Vec<Trial>> {
    let trial = |(name, title, builtin, change): (&str, _, _, _)| {
        Ok(Trial {
            name: name.to_owned(),
            table: "findings",
            title,
            paper: None,
            scene: scene(base, builtin, &[change])?,
        })
    };
    FINDINGS.into_iter().map(trial).collect()
}

#[cfg(test)]
mod tests {
    use super::{ABLATION, Base, Kind, NO_BASE, STRICT, trials};
    use cosmic::codesign::CoDesign;
    use cosmic::scene::Scene;

    #[test]
    fn the_strict_table_departs_in_nothing() {
        for trial in trials(Kind::Paper, &NO_BASE).unwrap() {
            let departures = trial.scene.departures();
            assert_eq!(
                departures.is_empty(),
                trial.table == STRICT,
                "{departures:?}"
            );
        }
    }

    #[test]
    fn default_trials_are_the_built_in_scenes() {
        for trial in trials(Kind::Paper, &NO_BASE).unwrap() {
            if let Some(name) = trial.name.strip_prefix("default-") {
                assert_eq!(trial.scene, Scene::load(name).unwrap());
            }
        }
    }

    #[test]
    fn every_trial_can_begin_and_is_not_another() {
        for kind in [Kind::Paper, Kind::Ablation, Kind::Findings] {
            let trials = trials(kind, &NO_BASE).unwrap();
            for (k, trial) in trials.iter().enumerate() {
                CoDesign::new(&trial.scene).unwrap().begin(0).unwrap();
                let same = |other: &super::Trial| other.scene == trial.scene;
                assert!(!trials[..k].iter().any(same), "{}", trial.name);
            }
        }
    }

    #[test]
    fn the_ablation_s_trials_are_all_combinations() {
        for (k, (.., entities)) in ABLATION.iter().enumerate() {
            assert!(ABLATION[..k].iter().all(|(.., other)| other != entities));
        }
    }

    #[test]
    fn a_base_lies_under_every_scene() {
        let base = Base {
            file: "base.toml",
            text: "[physics]\ngravity = 1.5\n",
        };
        for trial in trials(Kind::Ablation, &base).unwrap() {
            assert_eq!(trial.scene.physics.gravity, 1.5);
        }
        let wrong = Base {
            text: "[physics]\ngravty = 1",
            ..base
        };
        let error = trials(Kind::Paper, &wrong).unwrap_err().to_string();
        assert!(error.contains("base.toml:2:1"), "{error}");
    }
}
