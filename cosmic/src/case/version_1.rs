//! The `scene` of case files of version 1: the reference cases are such files. The program only reads them.

use serde_json::{Map, Value};

use super::Frame;
use crate::scene::JsonSetting;

/// The keys that no file may lack, each with the key of a scene that it stands for. `library.k` is the key `k` of the object
/// `library`. [`Converted::add`] says what those without a key of a scene stand for.
const NEEDED: [(&str, &str); 25] = [
    ("columns", "lattice.columns"),
    ("rows", "lattice.rows"),
    ("spacing", "lattice.spacing"),
    ("drop", "lattice.drop"),
    ("alpha_deg", "physics.incline_deg"),
    ("gravity", "physics.gravity"),
    ("gamma", "physics.damping"),
    ("m_eps", "physics.node_mass"),
    ("payload_mass", "physics.payload_mass"),
    ("dt", "physics.dt"),
    ("contact", ""),
    ("mu", "physics.friction"),
    ("omega", "controller.omega"),
    ("n_cpg", "controller.clocks"),
    ("goal", "controller.goal"),
    ("offset_scale", "controller.offset_scale"),
    ("velocity_scale", "controller.velocity_scale"),
    ("beta", "projection.beta"),
    ("beta_stab", "projection.beta_stability"),
    ("beta_ste", "projection.beta_straight_through"),
    ("delta", "projection.delta"),
    ("library", ""),
    ("library.k", "materials.stiffness"),
    ("library.rho", "materials.density"),
    ("library.a_max", "materials.max_strain"),
];

/// The keys that have the value of the paper's scene if a file lacks them.
const OPTIONAL: [(&str, &str); 23] = [
    ("kind", "lattice.kind"),
    ("dimension", ""),
    ("depth", "lattice.depth"),
    ("body_diagonals", "lattice.body_diagonals"),
    ("payload", "lattice.payload"),
    ("mirror", "lattice.mirror"),
    ("profile", ""),
    ("integrator", "physics.integrator"),
    ("substeps", "physics.substeps"),
    ("passes", "physics.passes"),
    ("forces", ""),
    ("parts", ""),
    ("void_edges", "physics.void_edges"),
    ("policy", "controller.policy"),
    ("clock", "controller.clock"),
    ("goal_relative", "controller.goal_relative"),
    ("goals", "controller.goals"),
    ("penalisation", "materials.penalisation"),
    ("hold_materials", "projection.hold_materials"),
    ("body", "objective.body"),
    ("ground_height", ""),
    ("origin_x", ""),
    ("origin_y", ""),
];

/// The keys that have another value than that of the paper's scene if a file lacks them: this value, in JSON.
const OTHER: [(&str, &str, &str); 3] = [
    ("goal_scale", "controller.goal_scale", "1.0"),
    ("one_piece", "design.one_piece", "false"),
    ("speed_bound", "physics.speed_bound", "null"),
];

/// The settings of a `scene` of version 1, and the frame of the file.
///
/// # Errors
/// A sentence about an unknown or missing key, or about a value of the wrong form.
pub(super) fn converted(scene: &Map<String, Value>) -> Result<(Vec<JsonSetting>, Frame), String> {
    let (mut converted, mut keys) = (Converted::default(), Vec::new());
    for (key, value) in scene {
        keys.push(key.clone());
        converted.add(key, value)?;
        if let ("library" | "parts", Value::Object(inner)) = (&key[..], value) {
            for (own, value) in inner {
                let key = format!("{key}.{own}");
                converted.add(&key, value)?;
                keys.push(key);
            }
        }
    }
    let lacks = |key: &str| keys.iter().all(|own| own != key);
    if let Some((key, _)) = NEEDED.iter().find(|(key, _)| lacks(key)) {
        return Err(format!("`scene`: missing field `{}`", last(key)));
    }
    for (key, own, absent) in OTHER.iter().filter(|(key, ..)| lacks(key)) {
        let value = serde_json::from_str(absent).map_err(|error| error.to_string())?;
        converted.give(&format!("scene.{key}"), own, value);
    }
    Ok((converted.given, converted.frame))
}

/// What was converted so far.
#[derive(Default)]
struct Converted {
    given: Vec<JsonSetting>,
    frame: Frame,
}

impl Converted {
    fn give(&mut self, place: &str, key: &str, value: Value) {
        let (key, place) = (key.to_owned(), place.to_owned());
        self.given.push(JsonSetting { key, place, value });
    }

    /// Converts the value of a key of `scene`. `parts.outer` is the key `outer` of the object `parts`.
    fn add(&mut self, key: &str, value: &Value) -> Result<(), String> {
        let place = &format!("scene.{key}");
        match key {
            "library" | "parts" if value.is_object() => {}
            "library" | "parts" => return Err(wrong(place, value, "an object")),
            // They say where the first nodes stand. Nothing is computed from them, because `x0` has the positions.
            "origin_x" | "origin_y" => drop(number(place, value)?),
            "ground_height" => self.frame.ground_height = number(place, value)?,
            "dimension" => match value.as_u64() {
                Some(2) => {}
                Some(3) => self.give(place, "lattice.kind", "cubic".into()),
                _ => return Err(wrong(place, value, "2 or 3")),
            },
            "profile" => {
                let is_flat = value.as_array().is_some_and(Vec::is_empty);
                let kind = if is_flat { "flat" } else { "points" };
                self.give(place, "ground.profile", kind.into());
                self.give(place, "ground.points", value.clone());
            }
            "contact" => {
                let law = self.law(place, value)?;
                self.give(place, "physics.contact", law.into());
            }
            "forces" => {
                let laws = value
                    .as_array()
                    .ok_or_else(|| wrong(place, value, "a list"))?;
                let laws = laws.iter().enumerate();
                let names = laws.map(|(k, law)| self.law(&format!("{place}[{k}]"), law));
                let names = names.collect::<Result<Value, _>>()?;
                self.give(place, "physics.forces", names);
            }
            _ if key.starts_with("parts.") => self.give(place, key, value.clone()),
            _ => {
                let (_, own) = keys()
                    .find(|(known, _)| *known == key)
                    .ok_or_else(|| unknown(key))?;
                self.give(place, own, value.clone());
            }
        }
        Ok(())
    }

    /// Converts the settings of a law, which is its name or an object that maps its name to its settings. Returns its name.
    fn law<'v>(&mut self, place: &str, value: &'v Value) -> Result<&'v str, String> {
        if let Some(name) = value.as_str() {
            return Ok(name);
        }
        let laws: Vec<_> = value.as_object().into_iter().flatten().collect();
        let [(name, Value::Object(settings))] = laws[..] else {
            let law = "the name of a law, or an object {\"name\": {settings}}";
            return Err(wrong(place, value, law));
        };
        for (key, value) in settings {
            let own = format!("{name}.{key}");
            self.give(&format!("{place}.{own}"), &own, value.clone());
        }
        Ok(name)
    }
}

/// All keys, each with the key of a scene that it stands for.
fn keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    let other = OTHER.iter().map(|&(key, own, _)| (key, own));
    NEEDED.into_iter().chain(OPTIONAL).chain(other)
}

/// The part of a key after its last dot.
fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

fn number(place: &str, value: &Value) -> Result<f64, String> {
    value
        .as_f64()
        .ok_or_else(|| wrong(place, value, "a number"))
}

fn wrong(place: &str, value: &Value, expected: &str) -> String {
    format!("`{place}`: found {value}, expected {expected}")
}

fn unknown(key: &str) -> String {
    let object = key.split_once('.').map_or("", |(object, _)| object);
    let known = keys().filter_map(|(key, _)| match key.split_once('.') {
        Some((own, key)) => (own == object).then_some(key),
        None => object.is_empty().then_some(key),
    });
    let known: Vec<String> = known.map(|key| format!("`{key}`")).collect();
    format!(
        "`scene.{key}`: unknown field `{}`, expected one of {}",
        last(key),
        known.join(", ")
    )
}
