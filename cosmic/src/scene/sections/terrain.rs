//! Settings of the ground: the height profile above the ground line.

use crate::scene::Scene;
use toml::Spanned;
use toml::de::DeValue;

use crate::geometry::{MOST_POINTS, Profile, Vector};
use crate::random::{Purpose, stream, symmetric};
use crate::settings;
use crate::settings::{Filled, Limits, SettingValue, above, json, misfit, within, wrong_kind};

settings! {
    /// The height profile of the ground above the ground line. Below the lattice its height is 0, unless it has points
    /// there. The robot is not raised to the height of the profile.
    struct GroundSettings {
        /// The kind of profile on the ground line.
        profile: ProfileKind = ProfileKind::Flat,
            read "with a contact law that has a ground" if |s: &Scene| s.physics.contact.has_ground(),
            source "paper: flat";
        /// For "points": the corners of the profile.
        points: Profile = Profile::default(), allowed within(-1e3, 1e3), unit "m",
            read "with the profile `points`" if |s: &Scene| has_profile(s, &[ProfileKind::Points]),
            source "beyond the paper";
        /// For "steps" and "rough": the place along the ground where they begin.
        from: f64 = 0.7, allowed within(-1e3, 1e3), unit "m",
            read "with the profiles `steps` and `rough`" if |s: &Scene| has_profile(s, &[ProfileKind::Steps, ProfileKind::Rough]),
            source "beyond the paper";
        /// For "steps" and "rough": the number of steps or of drawn heights. Beyond the last one the ground is flat.
        count: usize = 10, allowed within(1.0, 62.0),
            read "with the profiles `steps` and `rough`" if |s: &Scene| has_profile(s, &[ProfileKind::Steps, ProfileKind::Rough]),
            source "beyond the paper";
        /// For "steps" and "rough": the distance from one step or drawn height to the next.
        spacing: f64 = 0.3, allowed above(0.0, 1e3), unit "m",
            read "with the profiles `steps` and `rough`" if |s: &Scene| has_profile(s, &[ProfileKind::Steps, ProfileKind::Rough]),
            source "beyond the paper";
        /// For "steps": the height of a step; negative for steps down. A step rises over a sixtieth of `spacing`.
        rise: f64 = 0.02, allowed within(-1e3, 1e3), unit "m",
            read "with the profile `steps`" if |s: &Scene| has_profile(s, &[ProfileKind::Steps]),
            source "beyond the paper";
        /// For "rough": the largest height above or below the ground line.
        roughness: f64 = 0.02, allowed within(0.0, 1e3), unit "m",
            read "with the profile `rough`" if |s: &Scene| has_profile(s, &[ProfileKind::Rough]),
            source "beyond the paper";
        /// For "rough": the seed of the heights.
        seed: usize = 0, allowed within(0.0, 1e9),
            read "with the profile `rough`" if |s: &Scene| has_profile(s, &[ProfileKind::Rough]),
            source "beyond the paper";
    }
}

settings! {
    /// The kinds of profile on the ground line.
    #[derive(Default)]
    enum ProfileKind {
        /// No profile: the ground is the ground line.
        #[default]
        Flat = "flat",
        /// The corners in `points`.
        Points = "points",
        /// Steps of equal height.
        Steps = "steps",
        /// Heights drawn at random.
        Rough = "rough",
    }
}

/// True if the scene has ground whose profile is of one of the given kinds.
fn has_profile(scene: &Scene, kinds: &[ProfileKind]) -> bool {
    let physics = &scene.physics;
    physics.contact.has_ground() && kinds.contains(&physics.ground.profile)
}

/// The distance from one step to the next, divided by the length over which a step rises. A step 30 cm long rises over 5
/// mm.
const RAMPS: f64 = 60.0;

/// The largest number of steps in a profile. Each step has two corners.
pub(in crate::scene) const MOST_STEPS: usize = MOST_POINTS / 2;

impl GroundSettings {
    /// The profile that the settings describe.
    ///
    /// # Panics
    /// If the settings contradict one another. The reader of scenes refuses such settings.
    pub fn resolved(&self) -> Profile {
        let profile = self.checked();
        profile.unwrap_or_else(|says| panic!("the profile of the ground {says}"))
    }

    /// The profile that the settings describe.
    ///
    /// # Errors
    /// A sentence if the settings contradict one another.
    pub(crate) fn checked(&self) -> Result<Profile, String> {
        let points = match self.profile {
            ProfileKind::Flat => Vec::new(),
            ProfileKind::Points => return Ok(self.points.clone()),
            ProfileKind::Steps => self.steps(),
            ProfileKind::Rough => self.rough(),
        };
        Profile::new(points)
    }

    fn place(&self, number: usize) -> f64 {
        self.from + number as f64 * self.spacing
    }

    fn steps(&self) -> Vec<Vector<f64>> {
        let ramp = self.spacing / RAMPS;
        let step = |k: usize| {
            let [below, above] = [k, k + 1].map(|k| k as f64 * self.rise);
            [[self.place(k), below], [self.place(k) + ramp, above]].map(Vector::from)
        };
        (0..self.count).flat_map(step).collect()
    }

    /// The points of rough ground: random heights at equal distances. The first and the last point are on the ground
    /// line.
    fn rough(&self) -> Vec<Vector<f64>> {
        let mut stream = stream(self.seed as u64, Purpose::Terrain);
        let heights = (0..self.count).map(|_| symmetric(&mut stream, self.roughness));
        let heights = [0.0].into_iter().chain(heights).chain([0.0]);
        let point = |(k, height)| Vector::upright(self.place(k), height);
        heights.enumerate().map(point).collect()
    }
}

impl From<GroundSettings> for Profile {
    fn from(settings: GroundSettings) -> Self {
        settings.resolved()
    }
}

impl From<Profile> for GroundSettings {
    fn from(points: Profile) -> Self {
        let profile = if points.is_flat() {
            ProfileKind::Flat
        } else {
            ProfileKind::Points
        };
        Self {
            profile,
            points,
            ..Self::default()
        }
    }
}

impl SettingValue for Profile {
    fn allowed(&self, limits: &Limits) -> String {
        format!(
            "up to {MOST_POINTS} pairs [along, height] in ascending order of along, each number {limits}; two pairs with \
             the same along are a vertical wall"
        )
    }

    fn toml(&self) -> String {
        format!("{:?}", self.pairs())
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        let entries = value.get_ref().as_array();
        let entries = entries.ok_or_else(|| wrong_kind(value))?;
        if entries.len() > MOST_POINTS {
            return Err(misfit(value, &format!("has {} points:", entries.len())));
        }
        let mut points = Vec::new();
        for entry in entries.iter() {
            let mut point = [0.0; 2];
            point.read(entry, limits)?;
            points.push(Vector::from(point));
            if let Some((_, says)) = Profile::misplaced(&points) {
                return Err(misfit(entry, &format!("{says}:")));
            }
        }
        *self = Profile::new(points).map_err(|says| misfit(value, &says))?;
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        let mut numbers = self.points().iter().flat_map(|point| point.in_plane());
        numbers.all(|x| limits.contain(x))
    }
}
