//! The file of a case: its keys, in the order in which they are written.

use std::collections::BTreeMap;

use serde::de::value::StringDeserializer;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use super::{Case, Frame};
use crate::design::Material;
use crate::error::{self, Error};
use crate::geometry::{Dimension, Profile, Row, Vector};
use crate::lattice::{EdgeRules, Lattice, Payload};
use crate::laws::{ContactLaw, ForceLaws, LawFile};
use crate::policy::Weights;
use crate::projection::Projection;
use crate::scene::{
    ClockKind, GoalKind, GroundSettings, Integrator, ItemName, LatticeKind, LatticeSettings,
    MovedBody, PartsSettings, Scene, VoidEdges,
};
use crate::settings::{Field, Settings, read_json};
use crate::world::Divergence;

/// The key `format` of the cases that the program writes.
pub(super) const FORMAT: &str = "cosmic-case";
/// The key `version` of the cases that the program writes.
pub(super) const VERSION: u32 = 1;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[expect(
    dead_code,
    reason = "the last fields belong to the format but are not read"
)]
pub(super) struct CaseFile {
    pub(super) format: Option<String>,
    pub(super) version: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<Value>,
    pub(super) scene: CaseScene,
    pub(super) edges: Vec<[usize; 2]>,
    /// The payload and the edge rules of a truss. Present only in cases with a truss.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) truss: Option<TrussExtras>,
    pub(super) l0: Vec<f64>,
    /// The scale of the lattice, m. A case without this key has the scale of the paper's lattice.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub(super) scale: f64,
    pub(super) x0: Vec<Row>,
    pub(super) v0: Vec<Row>,
    pub(super) z: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) materials: Option<Vec<Material>>,
    pub(super) controller: Weights,
    pub(super) steps: usize,
    #[serde(deserialize_with = "word")]
    pub(super) projection: Projection,
    pub(super) al: Lagrangian,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) results: Option<Results>,
    // The keys below describe the origin and the tolerances of a case. Nothing is computed from them.
    #[serde(default, skip_serializing)]
    tolerance: IgnoredAny,
    #[serde(default, skip_serializing)]
    sensitivity: IgnoredAny,
    #[serde(default, skip_serializing)]
    coverage: IgnoredAny,
    #[serde(default, skip_serializing)]
    name: IgnoredAny,
}

impl From<&Case> for CaseFile {
    fn from(case: &Case) -> Self {
        let Case { scene, lattice, .. } = case;
        Self {
            format: Some(FORMAT.to_owned()),
            version: Some(VERSION),
            note: None,
            scene: CaseScene::of(scene),
            edges: lattice.edges.clone(),
            truss: TrussExtras::of(&scene.lattice, lattice),
            l0: lattice.rest_length.clone(),
            scale: lattice.scale,
            x0: lattice.dimension.rows(&case.start.x),
            v0: lattice.dimension.rows(&case.start.v),
            z: case.design.vectors().into_owned(),
            materials: case.design.layout().map(<[_]>::to_vec),
            controller: Weights::from(&case.controller),
            steps: scene.physics.steps,
            projection: case.projection,
            al: Lagrangian {
                lambda: case.lagrangian.multiplier,
                tau: case.lagrangian.penalty,
                thresholds: case.thresholds,
            },
            results: None,
            tolerance: IgnoredAny,
            sensitivity: IgnoredAny,
            coverage: IgnoredAny,
            name: IgnoredAny,
        }
    }
}

impl Case {
    /// The text of a case file that holds all inputs of this case, but no results. The file is in the world's frame,
    /// whatever the [frame](Case::frame) of this case is.
    pub fn to_json(&self) -> String {
        CaseFile::from(self).text()
    }

    /// The text of a case file that reproduces a divergence: this case, cut after the step that diverges. Its results
    /// are the last states of the rollout. Numbers that are not finite are written as `null`.
    pub fn diverged_json(&self, divergence: &Divergence) -> String {
        let (step, node) = (divergence.step, divergence.node);
        let note = format!(
            "step {step} diverged at node {node}, {}; the last states are in `results`",
            divergence.term
        );
        let last = &divergence.last;
        let states = last.states.iter().map(|state| json!(state));
        let mut file = CaseFile::from(self);
        file.note = Some(note.into());
        file.steps = step + 1;
        file.results = Some(Results {
            trajectory: last.steps.iter().copied().zip(states).collect(),
        });
        file.text()
    }
}

impl CaseFile {
    fn text(&self) -> String {
        serde_json::to_string(self).expect("numbers with string keys can be written as JSON")
    }
}

/// Declares an object in a case file. Each key has two declarations: the type of its value in the file, and the setting
/// of a scene that it stands for. The macro makes the struct and its conversions from and to a scene. Keys in brackets
/// stand for no setting, and have their default if the object is made from a scene. A nested object follows after the
/// semicolon.
macro_rules! keys {
    (
        $Keys:ident, $path:literal,
        $($(#[$attribute:meta])* $key:ident: $form:ty = $section:ident.$setting:ident,)+
        $([$($(#[$mark:meta])* $own:ident: $Own:ty,)+])?
        $(; $part:ident: $Part:ty)?
    ) => {
        #[derive(Deserialize, Serialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $Keys {
            $($(#[$attribute])* pub(super) $key: $form,)+
            $($($(#[$mark])* pub(super) $own: $Own,)+)?
            $(pub(super) $part: $Part,)?
        }

        impl $Keys {
            pub(super) fn of(scene: &Scene) -> Self {
                Self {
                    $($key: scene.$section.$setting.clone().into(),)+
                    $($($own: Default::default(),)+)?
                    $($part: <$Part>::of(scene),)?
                }
            }

            /// Copies the values of all keys to the settings of a scene. Errors name `file`.
            pub(super) fn set(&self, scene: &mut Scene, file: &str) -> error::Result<()> {
                $(
                    let key = concat!($path, ".", stringify!($key));
                    self.$key.set(&mut scene.$section.$setting, file, key)?;
                )+
                $(self.$part.set(scene, file)?;)?
                Ok(())
            }
        }
    };
}

/// What a truss has in addition to its nodes, edges and rest lengths: the payload, which edges are restricted or tied,
/// and the stiffnesses of bars.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrussExtras {
    pub(super) payload: Vec<Payload>,
    keep: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    skeleton: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    actuator: Vec<usize>,
    forbid: Vec<usize>,
    tie: Vec<Vec<usize>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) stiffness: Vec<f64>,
}

impl TrussExtras {
    /// The payload and the edge rules of `lattice`; `None` if the lattice is generated.
    pub(super) fn of(layout: &LatticeSettings, lattice: &Lattice) -> Option<Self> {
        layout.file.truss()?;
        let rules = lattice.rules.clone();
        Some(Self {
            payload: lattice.payload.clone(),
            keep: rules.keep,
            skeleton: rules.skeleton,
            actuator: rules.actuator,
            forbid: rules.forbid,
            tie: rules.tie,
            stiffness: lattice.stiffness.clone(),
        })
    }

    pub(super) fn rules(&self) -> EdgeRules {
        EdgeRules {
            keep: self.keep.clone(),
            skeleton: self.skeleton.clone(),
            actuator: self.actuator.clone(),
            forbid: self.forbid.clone(),
            tie: self.tie.clone(),
        }
    }
}

keys! {
    CaseScene, "scene",
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    kind: LatticeKind = lattice.kind,
    #[serde(default, skip_serializing_if = "is_default")]
    dimension: Dimension = lattice.kind,
    columns: usize = lattice.columns,
    #[serde(default = "three", skip_serializing_if = "is_three")]
    depth: usize = lattice.depth,
    #[serde(default, skip_serializing_if = "is_default")]
    body_diagonals: bool = lattice.body_diagonals,
    rows: usize = lattice.rows,
    spacing: f64 = lattice.spacing,
    drop: f64 = lattice.drop,
    #[serde(default, skip_serializing_if = "is_default")]
    payload: usize = lattice.payload,
    #[serde(default, skip_serializing_if = "is_default")]
    mirror: bool = lattice.mirror,
    alpha_deg: f64 = physics.incline_deg,
    #[serde(default, skip_serializing_if = "is_default")]
    profile: Profile = physics.ground,
    gravity: f64 = physics.gravity,
    gamma: f64 = physics.damping,
    m_eps: f64 = physics.node_mass,
    payload_mass: f64 = physics.payload_mass,
    dt: f64 = physics.dt,
    // This key is written only if it differs from the paper's value, so that older programs can read cases with the
    // paper's value.
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    integrator: Integrator = physics.integrator,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    substeps: usize = physics.substeps,
    #[serde(default = "two", skip_serializing_if = "is_two")]
    passes: usize = physics.passes,
    contact: LawFile = physics.contact,
    mu: f64 = physics.friction,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    forces: Vec<LawFile> = physics.forces,
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    void_edges: VoidEdges = physics.void_edges,
    // A case without this key has no bound on speeds; the scene's default does not apply.
    #[serde(default, skip_serializing_if = "is_default")]
    speed_bound: Option<f64> = physics.speed_bound,
    #[serde(default = "mlp", skip_serializing_if = "is_mlp")]
    policy: String = controller.policy,
    omega: f64 = controller.omega,
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    clock: ClockKind = controller.clock,
    n_cpg: usize = controller.clocks,
    goal: GoalPoint = controller.goal,
    #[serde(default = "one")]
    goal_scale: f64 = controller.goal_scale,
    #[serde(default)]
    goal_relative: bool = controller.goal_relative,
    #[serde(default, deserialize_with = "word", skip_serializing_if = "are_not_given")]
    goals: GoalKind = controller.goals,
    offset_scale: f64 = controller.offset_scale,
    velocity_scale: f64 = controller.velocity_scale,
    beta: f64 = projection.beta,
    beta_stab: f64 = projection.beta_stability,
    beta_ste: f64 = projection.beta_straight_through,
    delta: f64 = projection.delta,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    penalisation: usize = materials.penalisation,
    #[serde(default, skip_serializing_if = "is_empty")]
    parts: Parts = materials.parts,
    #[serde(default, skip_serializing_if = "is_default")]
    hold_materials: f64 = projection.hold_materials,
    #[serde(default, skip_serializing_if = "is_default")]
    one_piece: bool = design.one_piece,
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    body: MovedBody = objective.body,
    [
        #[serde(default, skip_serializing_if = "is_default")]
        ground_height: Frame,
        // Where D1 puts the first nodes. Nothing is computed from it, because `x0` has the positions.
        #[serde(default, skip_serializing_if = "is_default")]
        origin_x: f64,
        #[serde(default, skip_serializing_if = "is_default")]
        origin_y: f64,
    ]
    ; library: Library
}

keys! {
    Library, "scene.library",
    k: [f64; 3] = materials.stiffness,
    rho: [f64; 3] = materials.density,
    a_max: [f64; 3] = materials.max_strain,
}

/// The settings of parts in a case file, by their keys. Empty if they are those of the paper's scene.
#[derive(Default, Deserialize, Serialize)]
pub(super) struct Parts(BTreeMap<String, Value>);

impl From<PartsSettings> for Parts {
    fn from(mut parts: PartsSettings) -> Self {
        if parts == PartsSettings::default() {
            return Self::default();
        }
        let fields = parts.fields().into_iter();
        let pair = |field: Field| (field.key.to_owned(), field.value.json());
        Self(fields.map(pair).collect())
    }
}

fn is_empty(parts: &Parts) -> bool {
    parts.0.is_empty()
}

impl StoredForm<PartsSettings> for Parts {
    fn set(&self, setting: &mut PartsSettings, file: &str, key: &str) -> error::Result<()> {
        for (name, value) in &self.0 {
            let field = setting.fields().into_iter().find(|field| field.key == name);
            let unknown = || format!("there is no setting `{name}`");
            let read = field.ok_or_else(unknown);
            let read = read.and_then(|field| read_json(field, value));
            read.map_err(refused(file, key))?;
        }
        setting.check().map_err(refused(file, key))
    }
}

/// A type of JSON value in a case file, from which a setting of type `T` is read.
trait StoredForm<T> {
    /// Copies this value to the setting. Errors name the file and the key of the value.
    fn set(&self, setting: &mut T, file: &str, key: &str) -> error::Result<()>;
}

impl<T: Clone> StoredForm<T> for T {
    fn set(&self, setting: &mut T, _: &str, _: &str) -> error::Result<()> {
        setting.clone_from(self);
        Ok(())
    }
}

impl StoredForm<GroundSettings> for Profile {
    fn set(&self, setting: &mut GroundSettings, _: &str, _: &str) -> error::Result<()> {
        *setting = self.clone().into();
        Ok(())
    }
}

impl StoredForm<ContactLaw> for LawFile {
    fn set(&self, setting: &mut ContactLaw, file: &str, key: &str) -> error::Result<()> {
        setting.read_file(self).map_err(refused(file, key))
    }
}

impl StoredForm<ForceLaws> for Vec<LawFile> {
    fn set(&self, setting: &mut ForceLaws, file: &str, key: &str) -> error::Result<()> {
        setting.read_files(self).map_err(refused(file, key))
    }
}

impl StoredForm<ItemName> for String {
    fn set(&self, setting: &mut ItemName, file: &str, key: &str) -> error::Result<()> {
        setting.choose(self).map_err(refused(file, key))
    }
}

impl StoredForm<LatticeKind> for Dimension {
    fn set(&self, setting: &mut LatticeKind, _: &str, _: &str) -> error::Result<()> {
        if *self == Self::Space {
            *setting = LatticeKind::Cubic;
        }
        Ok(())
    }
}

/// A goal in a case file: `[along, above]` or `[along, across, above]`.
#[derive(Deserialize, Serialize)]
pub(super) struct GoalPoint(Row);

impl From<Vector<f64>> for GoalPoint {
    fn from(goal: Vector<f64>) -> Self {
        Self(goal.dimension().components(goal).collect())
    }
}

impl StoredForm<Vector<f64>> for GoalPoint {
    fn set(&self, setting: &mut Vector<f64>, file: &str, key: &str) -> error::Result<()> {
        let dimension = Dimension::of_rows([&self.0]).map_err(refused(file, key))?;
        *setting = dimension.vector(&self.0);
        Ok(())
    }
}

/// Returns a function for `map_err`. It makes an error from a sentence about the value of `key`.
fn refused(file: &str, key: &str) -> impl FnOnce(String) -> Error {
    move |says| Error::Usage(format!("{file}: `{key}`: {says}"))
}

/// Reads a string that must be one of a few words. It is read as a string first, because the JSON parser's error for
/// any other type would only say that it expected a value.
fn word<'de, T: DeserializeOwned, D: Deserializer<'de>>(given: D) -> Result<T, D::Error> {
    T::deserialize(StringDeserializer::new(String::deserialize(given)?))
}

fn one<T: From<u8>>() -> T {
    T::from(1)
}

fn two() -> usize {
    2
}

fn three() -> usize {
    3
}

fn is_three(option: &usize) -> bool {
    *option == three()
}

fn is_two(option: &usize) -> bool {
    *option == two()
}

fn mlp() -> String {
    ItemName::POLICIES[0].to_owned()
}

fn is_mlp(policy: &str) -> bool {
    policy == mlp()
}

fn is_one<T: From<u8> + PartialEq>(option: &T) -> bool {
    *option == one()
}

fn are_not_given(goals: &GoalKind) -> bool {
    *goals != GoalKind::Given
}

/// True if an option has its default value. Options that the first version of the format does not have are left out of
/// a case file if this is true.
fn is_default<T: Default + PartialEq>(option: &T) -> bool {
    *option == T::default()
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lagrangian {
    pub(super) lambda: [f64; 4],
    pub(super) tau: [f64; 4],
    pub(super) thresholds: [f64; 4],
}

/// The results in a case file. Only the step numbers of the recorded states are read.
#[derive(Deserialize, Serialize)]
pub(super) struct Results {
    #[serde(default, deserialize_with = "steps_only")]
    pub(super) trajectory: BTreeMap<usize, Value>,
}

/// Reads the numbers of steps without keeping the states, which may be long.
fn steps_only<'de, D: Deserializer<'de>>(given: D) -> Result<BTreeMap<usize, Value>, D::Error> {
    let states = BTreeMap::<usize, IgnoredAny>::deserialize(given)?;
    Ok(states.into_keys().map(|step| (step, Value::Null)).collect())
}
