//! The keys of a case file, before the lengths of arrays are checked. Arrays are read as lists of any length, so that
//! the error for a wrong length can state the expected length.

use std::collections::BTreeMap;

use serde::de::value::StringDeserializer;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};

use crate::design::Material;
use crate::error::{self, Error, fits};
use crate::geometry::Profile;
use crate::lattice::{EdgeRules, Lattice, Payload};
use crate::laws::{ContactLaw, ForceLaws, LawFile};
use crate::policy::Weights;
use crate::projection::Projection;
use crate::scene::{
    Chosen, ClockKind, GoalKind, GroundSettings, Integrator, LatticeKind, LatticeSettings,
    MovedBody, PartsSettings, Scene, VoidEdges,
};
use crate::settings::{Field, Settings, read_json};

/// The key `format` of the cases that the program writes.
pub(super) const FORMAT: &str = "cosmic-case";
/// The key `version` of the cases that the program writes.
pub(super) const VERSION: u32 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    dead_code,
    reason = "the last fields belong to the format but are not read"
)]
pub(super) struct RawCase {
    pub(super) format: Option<String>,
    pub(super) version: Option<u32>,
    pub(super) scene: RawScene,
    pub(super) edges: Vec<Vec<usize>>,
    /// The payload and the edge rules of a truss. Present only in cases with a truss.
    pub(super) truss: Option<RawMarks>,
    pub(super) l0: Vec<f64>,
    /// The scale of the lattice, m. A case without this key has the scale of the paper's lattice.
    #[serde(default = "one")]
    pub(super) scale: f64,
    pub(super) x0: Vec<Vec<f64>>,
    pub(super) v0: Vec<Vec<f64>>,
    pub(super) z: Vec<Vec<f64>>,
    pub(super) materials: Option<Vec<Material>>,
    pub(super) controller: Weights,
    pub(super) steps: usize,
    #[serde(deserialize_with = "word")]
    pub(super) projection: Projection,
    pub(super) al: RawLagrangian,
    pub(super) results: Option<RawResults>,
    // The keys below describe the origin and the tolerances of a case. Nothing is computed from them.
    tolerance: Option<IgnoredAny>,
    sensitivity: Option<IgnoredAny>,
    coverage: Option<IgnoredAny>,
    name: Option<IgnoredAny>,
    note: Option<IgnoredAny>,
}

/// Declares an object in a case file. Each key has two declarations: the type of its value in the file, and the setting
/// of a scene that it stands for. The macro makes the struct and its conversions from and to a scene. A nested object
/// follows after the semicolon.
macro_rules! keys {
    (
        $Keys:ident, $path:literal,
        $($(#[$attribute:meta])* $key:ident: $form:ty = $section:ident.$setting:ident,)+
        $(; $part:ident: $Part:ty)?
    ) => {
        #[derive(Deserialize, Serialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $Keys {
            $($(#[$attribute])* pub(super) $key: $form,)+
            $(pub(super) $part: $Part,)?
        }

        impl $Keys {
            pub(super) fn of(scene: &Scene) -> Self {
                Self {
                    $($key: scene.$section.$setting.clone().into(),)+
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
pub(super) struct RawMarks {
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

impl RawMarks {
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
    RawScene, "scene",
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    kind: LatticeKind = lattice.kind,
    columns: usize = lattice.columns,
    rows: usize = lattice.rows,
    spacing: f64 = lattice.spacing,
    origin_x: f64 = lattice.origin_x,
    drop: f64 = lattice.drop,
    #[serde(default, skip_serializing_if = "is_default")]
    payload: usize = lattice.payload,
    #[serde(default, skip_serializing_if = "is_default")]
    mirror: bool = lattice.mirror,
    ground_height: f64 = physics.ground_height,
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
    goal: Vec<f64> = controller.goal,
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
    parts: RawParts = materials.parts,
    #[serde(default, skip_serializing_if = "is_default")]
    hold_materials: f64 = projection.hold_materials,
    #[serde(default, skip_serializing_if = "is_default")]
    one_piece: bool = design.one_piece,
    #[serde(default, deserialize_with = "word", skip_serializing_if = "is_default")]
    body: MovedBody = objective.body,
    ; library: RawLibrary
}

keys! {
    RawLibrary, "scene.library",
    k: Vec<f64> = materials.stiffness,
    rho: Vec<f64> = materials.density,
    a_max: Vec<f64> = materials.max_strain,
}

/// The settings of parts in a case file, by their keys. Empty if they are those of the paper's scene.
#[derive(Default, Deserialize, Serialize)]
pub(super) struct RawParts(BTreeMap<String, serde_json::Value>);

impl From<PartsSettings> for RawParts {
    fn from(mut parts: PartsSettings) -> Self {
        if parts == PartsSettings::default() {
            return Self::default();
        }
        let fields = parts.fields().into_iter();
        let pair = |field: Field| (field.key.to_owned(), field.value.json());
        Self(fields.map(pair).collect())
    }
}

fn is_empty(parts: &RawParts) -> bool {
    parts.0.is_empty()
}

impl Form<PartsSettings> for RawParts {
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
trait Form<T> {
    /// Copies this value to the setting. Errors name the file and the key of the value.
    fn set(&self, setting: &mut T, file: &str, key: &str) -> error::Result<()>;
}

impl<T: Clone> Form<T> for T {
    fn set(&self, setting: &mut T, _: &str, _: &str) -> error::Result<()> {
        setting.clone_from(self);
        Ok(())
    }
}

impl Form<GroundSettings> for Profile {
    fn set(&self, setting: &mut GroundSettings, _: &str, _: &str) -> error::Result<()> {
        *setting = self.clone().into();
        Ok(())
    }
}

impl<const N: usize> Form<[f64; N]> for Vec<f64> {
    fn set(&self, setting: &mut [f64; N], file: &str, key: &str) -> error::Result<()> {
        *setting = array(file, key, self)?;
        Ok(())
    }
}

impl Form<ContactLaw> for LawFile {
    fn set(&self, setting: &mut ContactLaw, file: &str, key: &str) -> error::Result<()> {
        setting.read_file(self).map_err(refused(file, key))
    }
}

impl Form<ForceLaws> for Vec<LawFile> {
    fn set(&self, setting: &mut ForceLaws, file: &str, key: &str) -> error::Result<()> {
        setting.read_files(self).map_err(refused(file, key))
    }
}

impl Form<Chosen> for String {
    fn set(&self, setting: &mut Chosen, file: &str, key: &str) -> error::Result<()> {
        setting.choose(self).map_err(refused(file, key))
    }
}

/// Returns a function for `map_err`. It makes an error from a sentence about the value of `key`.
fn refused(file: &str, key: &str) -> impl FnOnce(String) -> Error {
    move |says| Error::Usage(format!("{file}: `{key}`: {says}"))
}

/// Converts the list at `key` to an array. The list must have `N` entries.
pub(super) fn array<T: Copy, const N: usize>(
    file: &str,
    key: &str,
    numbers: &[T],
) -> error::Result<[T; N]> {
    fits(file, &format!("entries in `{key}`"), numbers.len(), N)?;
    Ok(std::array::from_fn(|k| numbers[k]))
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

fn is_two(option: &usize) -> bool {
    *option == two()
}

fn mlp() -> String {
    Chosen::POLICIES[0].to_owned()
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
pub(super) struct RawLagrangian {
    pub(super) lambda: Vec<f64>,
    pub(super) tau: Vec<f64>,
    pub(super) thresholds: Vec<f64>,
}

/// The results in a case file. Only the step numbers of the recorded states are read.
#[derive(Deserialize)]
pub(super) struct RawResults {
    #[serde(default)]
    pub(super) trajectory: BTreeMap<usize, IgnoredAny>,
}
