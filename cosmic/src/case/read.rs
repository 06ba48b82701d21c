//! Reads a case and checks its shapes.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use super::file::{CaseFile, FORMAT, VERSION};
use super::{Case, Frame};
use crate::design::Design;
use crate::error::{Error, Result, fits, some};
use crate::geometry::{Dimension, Vector};
use crate::lattice::{Lattice, Payload, State};
use crate::objective::AugmentedLagrangian;
use crate::policy::blocks_of;
use crate::reading::{from_json, placed, read_whole, text_of};
use crate::registry::{OFF, Registry};
use crate::scene::{GoalKind, JsonSetting, Scene, TrussFile, places};
use serde::Deserialize;

/// The longest rollout of a case, in substeps. The clock is stored for every step, so without a limit a typing error
/// could exhaust the memory or run for ever.
const LONGEST: usize = 10_000_000;

impl Case {
    /// Reads a case from a file.
    ///
    /// # Errors
    /// If the file cannot be read, and the errors of [`parse`](Case::parse).
    pub fn read(path: &Path) -> Result<Self> {
        let (file, bytes) = (path.display().to_string(), read_whole(path)?);
        Self::parse(&file, text_of(&file, &bytes)?)
    }

    /// Reads a case from text; `file` names it in messages.
    ///
    /// # Errors
    /// [`Error::Malformed`], with the place, if a key is unknown, missing or of the wrong type, if sizes do not fit one
    /// another, or if a number has no meaning, such as a negative mass.
    pub fn parse(file: &str, text: &str) -> Result<Self> {
        Self::parse_with(&Registry::default(), file, text)
    }

    /// Like [`parse`](Case::parse). The laws and the policy of the case may also be items of a registry.
    ///
    /// # Errors
    /// The errors of [`parse`](Case::parse).
    pub fn parse_with(registry: &Registry, file: &str, text: &str) -> Result<Self> {
        let raw: CaseFile = from_json(file, 0, text.as_bytes()).or_else(|error| {
            // A case of another version may have other keys, so its version is the better message.
            let stamp: Stamp = from_json(file, 0, text.as_bytes()).unwrap_or_default();
            stamp.check(file).map_err(|says| placed(file, text, says))?;
            Err(error)
        })?;
        let case = Shapes::of(file, &raw).and_then(|shapes| shapes.case(raw, registry));
        case.map_err(|error| placed(file, text, error))
    }
}

/// The keys `format` and `version` of a case file. A case may lack them.
#[derive(Default, Deserialize)]
struct Stamp {
    format: Option<String>,
    version: Option<u32>,
}

impl Stamp {
    fn check(&self, file: &str) -> Result<()> {
        let format = self.format.as_deref().unwrap_or(FORMAT);
        let version = self.version.unwrap_or(1);
        if format == FORMAT && (1..=VERSION).contains(&version) {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "{file}: `format` is {format:?} version {version}, not {FORMAT:?} version 1 or {VERSION}"
        )))
    }
}

/// Checks that the lists of a case file have the right lengths, and that its numbers are possible.
struct Shapes<'a> {
    file: &'a str,
    settings: Vec<JsonSetting>,
    frame: Frame,
}

impl<'a> Shapes<'a> {
    /// Checks the keys `format` and `version`, and finds the settings of the scene.
    fn of(file: &'a str, raw: &CaseFile) -> Result<Self> {
        let refused = |says| Error::Usage(format!("{file}: {says}"));
        let (format, version) = (raw.format.clone(), raw.version);
        Stamp { format, version }.check(file)?;
        let (settings, frame) = raw.settings().map_err(refused)?;
        Ok(Self {
            file,
            settings,
            frame,
        })
    }

    fn case(&self, raw: CaseFile, registry: &Registry) -> Result<Case> {
        let mut scene = self.scene(&raw, registry)?;
        self.length(raw.steps, scene.physics.substeps)?;
        let lattice = self.mirrored(&scene, self.lattice(&raw, &scene)?)?;
        scene.controller.goal = self.goal(&scene);
        let (nodes, edges) = (lattice.nodes(), lattice.edges.len());
        self.fits("rows of `v0`", raw.v0.len(), nodes)?;
        self.fits("rows of `z`", raw.z.len(), edges)?;
        if let Some(materials) = &raw.materials {
            self.fits("entries in `materials`", materials.len(), edges)?;
        }
        scene.physics.steps = raw.steps;
        let blocks = blocks_of(&scene.controller, &lattice);
        Ok(Case {
            scene,
            frame: self.frame,
            listed_steps: self.listed_steps(&raw)?,
            controller: raw.controller.controller(&blocks, self.file)?,
            start: State {
                v: raw.v0.iter().map(|v| lattice.dimension.vector(v)).collect(),
                ..lattice.state_at_rest()
            },
            design: match raw.materials {
                None => Design::Undecided(raw.z),
                Some(layout) => Design::Layout(layout),
            },
            projection: raw.projection,
            lagrangian: AugmentedLagrangian {
                multiplier: raw.al.lambda,
                penalty: raw.al.tau,
            },
            thresholds: raw.al.thresholds,
            lattice,
        })
    }

    /// The scene, with its truss.
    fn scene(&self, raw: &CaseFile, registry: &Registry) -> Result<Scene> {
        let refuse = |says| self.refuse(says);
        let mut scene = registry.blank();
        scene.give(&self.settings).or_else(refuse)?;
        match raw.version() {
            1 => (raw.controller).set_hidden(&mut scene.controller, self.file)?,
            _ => {
                scene.complete(&self.settings).or_else(refuse)?;
                (raw.controller).check_hidden(&scene.controller, self.file)?;
            }
        }
        let parts = scene.materials.parts.check();
        parts.or_else(|says| refuse(format!("`scene.parts`: {says}")))?;
        if let Err(says) = scene.physics.ground.checked() {
            return self.refuse(format!("`scene.ground`: the profile of the ground {says}"));
        }
        if let Some((_, why)) = scene.controller.misfit() {
            return self.refuse(why.to_owned());
        }
        match (&raw.truss, scene.lattice.file.path() == OFF) {
            (None, true) => {}
            (Some(truss), false) => {
                scene.lattice.file = TrussFile::new(TrussFile::COPY, Arc::new(truss.clone()));
            }
            (None, false) => {
                return self.refuse(
                    "`scene.lattice.file`: the truss must be in the case, as the key `truss`"
                        .to_owned(),
                );
            }
            (Some(_), true) => {
                return self.refuse(format!(
                    "`truss`: the scene has no truss; set `file` in the section `lattice` to {:?}",
                    TrussFile::COPY
                ));
            }
        }
        Ok(scene)
    }

    /// The place in the file of a key of the scene.
    fn place<'k>(&'k self, key: &'k str) -> &'k str {
        let given = self.settings.iter().find(|given| given.key == key);
        given.map_or(key, |given| &given.place)
    }

    /// Returns an error that begins with the name of the case file and continues with `says`.
    fn refuse<T>(&self, says: String) -> Result<T> {
        Err(Error::Usage(format!("{}: {says}", self.file)))
    }

    /// The numbers of the steps whose states are in the results of the case file.
    fn listed_steps(&self, raw: &CaseFile) -> Result<Vec<usize>> {
        let listed = raw.results.iter().flat_map(|r| r.trajectory.keys());
        let last = raw.steps;
        match listed.clone().find(|step| **step > last) {
            Some(step) => self.refuse(format!(
                "`results.trajectory` has step {step}, but the rollout has only {last} steps"
            )),
            None => Ok(listed.copied().collect()),
        }
    }

    fn length(&self, steps: usize, substeps: usize) -> Result<()> {
        let (what, length) = if steps > LONGEST {
            ("`steps`", steps)
        } else {
            ("`steps` times the substeps", steps * substeps)
        };
        if length <= LONGEST {
            return Ok(());
        }
        self.refuse(format!(
            "{what}: expected at most {LONGEST}, found {length}"
        ))
    }

    fn lattice(&self, raw: &CaseFile, scene: &Scene) -> Result<Lattice> {
        let (layout, payload) = (&scene.lattice, scene.lattice.payload);
        let truss = layout.file.truss();
        let nodes = truss.map_or(layout.nodes(), |truss| truss.nodes.len());
        some(self.file, "nodes of `scene` (columns x rows)", nodes)?;
        if !(raw.scale > 0.0 && raw.scale.is_finite()) {
            let scale = raw.scale;
            return self.refuse(format!(
                "`scale`: expected a length above 0 m, found {scale}"
            ));
        }
        if payload >= nodes {
            let place = self.place("lattice.payload");
            let says = format!("`{place}`: expected a node below {nodes}, found {payload}");
            return self.refuse(says);
        }
        self.fits("rows of `x0`", raw.x0.len(), nodes)?;
        let rows = raw.x0.iter().chain(&raw.v0);
        let dimension = Dimension::of_rows(rows)
            .or_else(|says| self.refuse(format!("`x0` and `v0`: {says}")))?;
        let expected = layout.dimension();
        if dimension != expected {
            let (found, expected) = (dimension.count(), expected.count());
            return self.refuse(format!(
                "`x0` has {found} numbers for each point, but the lattice of `scene` needs {expected}; a lattice in space \
                 has the `kind` \"cubic\""
            ));
        }
        self.dimension(dimension, scene)?;
        let points = raw.x0.iter();
        let positions = points.map(|x| self.frame.read(dimension.vector(x)));
        let positions: Vec<_> = positions.collect();
        let edges = raw.edges.clone();
        self.fits("entries in `l0`", raw.l0.len(), edges.len())?;
        self.edges(&edges, nodes)?;
        if let Some(truss) = truss {
            if edges != truss.edges {
                return self.refuse("`edges`: expected the edges of `truss`".to_owned());
            }
            return Ok(Lattice {
                rest_length: raw.l0.clone(),
                scale: raw.scale,
                ..Lattice::of_truss(truss, positions)
            });
        }
        Ok(Lattice {
            dimension,
            rest_length: raw.l0.clone(),
            places: places(layout),
            spacing: layout.spacing,
            scale: raw.scale,
            payload: Payload::at(payload),
            ..Lattice::between(positions, edges)
        })
    }

    /// The goal in the world's frame. A goal that the controller observes as it is, is a constant and no place.
    fn goal(&self, scene: &Scene) -> Vector<f64> {
        let settings = &scene.controller;
        let is_place = settings.goal_relative || settings.goals == GoalKind::Given;
        match is_place {
            true => (self.frame).read_goal(settings.goal, &(&scene.physics).into()),
            false => settings.goal,
        }
    }

    /// Refuses what only robots in space can have, or only robots in the plane.
    fn dimension(&self, dimension: Dimension, scene: &Scene) -> Result<()> {
        let (key, says) = match dimension {
            Dimension::Plane if scene.controller.goal.sideways() != 0.0 => (
                "controller.goal",
                "a planar robot cannot reach a goal beside its plane; leave out the second number",
            ),
            Dimension::Space if !scene.physics.ground.resolved().is_flat() => (
                "ground.profile",
                "the ground of a robot in space is a plane",
            ),
            _ => return Ok(()),
        };
        self.refuse(format!("`{}`: {says}", self.place(key)))
    }

    /// The lattice as the case wants it: as it is, or as its own mirror image.
    fn mirrored(&self, scene: &Scene, lattice: Lattice) -> Result<Lattice> {
        if !scene.lattice.mirror {
            return Ok(lattice);
        }
        let lattice = lattice.mirrored();
        match lattice.mirror {
            Some(_) => Ok(lattice),
            None => {
                let place = self.place("lattice.mirror");
                self.refuse(format!(
                    "`{place}`: the lattice is not its own mirror image"
                ))
            }
        }
    }

    /// Checks the edges. There must be at least one. Each edge must join two different existing nodes, in either order.
    /// No two edges may join the same nodes.
    fn edges(&self, edges: &[[usize; 2]], nodes: usize) -> Result<()> {
        some(self.file, "`edges`", edges.len())?;
        let mut seen = HashSet::new();
        for (e, &[i, j]) in edges.iter().enumerate() {
            let expected = if i == j || i.max(j) >= nodes {
                format!("two different nodes below {nodes} (nodes are counted from 0)")
            } else if !seen.insert([i.min(j), i.max(j)]) {
                "an edge that no earlier entry lists".to_owned()
            } else {
                continue;
            };
            return self.refuse(format!(
                "`edges[{e}]`: expected {expected}, found [{i}, {j}]"
            ));
        }
        Ok(())
    }

    fn fits(&self, what: &str, found: usize, expected: usize) -> Result<()> {
        fits(self.file, what, found, expected)
    }
}
