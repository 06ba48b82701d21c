//! Reads a case and checks its shapes.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use super::Case;
use super::file::{CaseFile, CaseScene, FORMAT, VERSION};
use crate::design::Design;
use crate::error::{Error, Result, fits, some};
use crate::geometry::{Dimension, Ground, Vector};
use crate::lattice::{Lattice, Payload, State, Truss};
use crate::objective::AugmentedLagrangian;
use crate::policy::blocks_of;
use crate::reading::{from_json, placed, read_whole, text_of};
use crate::registry::Registry;
use crate::scene::{GoalKind, Scene, TrussFile, UnstableStep, allowed_instead, places};

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
        let raw: CaseFile = from_json(file, 0, text.as_bytes())?;
        let case = Shapes { file }.case(raw, registry);
        case.map_err(|error| placed(file, text, error))
    }
}

/// Checks that the lists of a case file have the right lengths, and that its numbers are possible.
struct Shapes<'a> {
    file: &'a str,
}

impl Shapes<'_> {
    fn case(&self, raw: CaseFile, registry: &Registry) -> Result<Case> {
        self.format(&raw)?;
        let mut scene = registry.blank();
        raw.scene.set(&mut scene, self.file)?;
        self.meaning(&raw.scene)?;
        self.length(raw.steps, raw.scene.substeps)?;
        let lattice = self.mirrored(&raw, self.lattice(&raw, &scene)?)?;
        scene.controller.goal = self.goal(&raw, &scene);
        let (nodes, edges) = (lattice.nodes(), lattice.edges.len());
        self.fits("rows of `v0`", raw.v0.len(), nodes)?;
        self.fits("rows of `z`", raw.z.len(), edges)?;
        if let Some(materials) = &raw.materials {
            self.fits("entries in `materials`", materials.len(), edges)?;
        }
        raw.controller
            .set_hidden(&mut scene.controller, self.file)?;
        if let Some((_, why)) = scene.controller.misfit() {
            return self.refuse(why.to_owned());
        }
        scene.physics.steps = raw.steps;
        // A case is only evaluated, and an evaluation never refuses an unstable time step.
        scene.physics.unstable_step = UnstableStep::Warn;
        if raw.truss.is_some() {
            scene.lattice.file = TrussFile::new("of this case", Arc::new(lattice.truss()));
        }
        let blocks = blocks_of(&scene.controller, &lattice);
        Ok(Case {
            scene,
            frame: raw.scene.ground_height,
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

    /// Checks the keys `format` and `version`. A case may omit them.
    fn format(&self, raw: &CaseFile) -> Result<()> {
        let format = raw.format.as_deref().unwrap_or(FORMAT);
        let version = raw.version.unwrap_or(VERSION);
        if (format, version) == (FORMAT, VERSION) {
            return Ok(());
        }
        self.refuse(format!(
            "`format` is {format:?} version {version}, not {FORMAT:?} version {VERSION}"
        ))
    }

    /// Refuses numbers that have no physical meaning, such as a negative mass. Allowed are the ranges that scenes
    /// allow. Only some keys are checked.
    fn meaning(&self, scene: &CaseScene) -> Result<()> {
        for (section, key, value) in [
            ("physics", "substeps", scene.substeps as f64),
            ("physics", "m_eps", scene.m_eps),
            ("physics", "payload_mass", scene.payload_mass),
            // A case without a bound on speeds has no number to check: 1.0 stands for it, because 1.0 is always
            // allowed.
            ("physics", "speed_bound", scene.speed_bound.unwrap_or(1.0)),
            ("materials", "penalisation", scene.penalisation as f64),
            ("projection", "hold_materials", scene.hold_materials),
        ] {
            let setting = if key == "m_eps" { "node_mass" } else { key };
            if let Some(allowed) = allowed_instead(&format!("{section}.{setting}"), value) {
                return self.refuse(format!("`scene.{key}`: expected {allowed}, found {value}"));
            }
        }
        Ok(())
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
            ("`steps` times `scene.substeps`", steps * substeps)
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
        let nodes = layout.nodes();
        some(self.file, "nodes of `scene` (columns x rows)", nodes)?;
        if !(raw.scale > 0.0 && raw.scale.is_finite()) {
            let scale = raw.scale;
            return self.refuse(format!(
                "`scale`: expected a length above 0 m, found {scale}"
            ));
        }
        if payload >= nodes {
            let says = format!("`scene.payload`: expected a node below {nodes}, found {payload}");
            return self.refuse(says);
        }
        self.fits("rows of `x0`", raw.x0.len(), nodes)?;
        let rows = raw.x0.iter().chain(&raw.v0);
        let dimension = Dimension::of_rows(rows)
            .or_else(|says| self.refuse(format!("`x0` and `v0`: {says}")))?;
        let expected = layout.dimension();
        if dimension != expected && raw.truss.is_none() {
            let (found, expected) = (dimension.count(), expected.count());
            return self.refuse(format!(
                "`x0` has {found} numbers for each point, but the lattice of `scene` needs {expected}; \
                 `scene.dimension` is 2 in the plane, its default, and 3 in space"
            ));
        }
        self.dimension(dimension, scene)?;
        let (frame, points) = (raw.scene.ground_height, raw.x0.iter());
        let positions = points.map(|x| frame.read(dimension.vector(x)));
        let positions: Vec<_> = positions.collect();
        let edges = raw.edges.clone();
        self.fits("entries in `l0`", raw.l0.len(), edges.len())?;
        self.edges(&edges, nodes)?;
        if let Some(truss) = &raw.truss {
            let ground = Ground::from(&scene.physics);
            let to_ground = positions.iter().map(|x| ground.vector_to_ground(*x));
            let truss = Truss {
                dimension,
                nodes: to_ground.collect(),
                edges,
                payload: truss.payload.clone(),
                rules: truss.rules(),
                stiffness: truss.stiffness.clone(),
                ..Truss::default()
            };
            let marks = truss.check_marks();
            marks.or_else(|says| self.refuse(format!("`truss`: {says}")))?;
            return Ok(Lattice {
                rest_length: raw.l0.clone(),
                scale: raw.scale,
                ..Lattice::of_truss(&truss, positions)
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
    fn goal(&self, raw: &CaseFile, scene: &Scene) -> Vector<f64> {
        let settings = &scene.controller;
        let is_place = settings.goal_relative || settings.goals == GoalKind::Given;
        match is_place {
            true => (raw.scene.ground_height).read_goal(settings.goal, &(&scene.physics).into()),
            false => settings.goal,
        }
    }

    /// Refuses what only robots in space can have, or only robots in the plane.
    fn dimension(&self, dimension: Dimension, scene: &Scene) -> Result<()> {
        match dimension {
            Dimension::Plane if scene.controller.goal.sideways() != 0.0 => self.refuse(
                "`scene.goal`: a planar robot cannot reach a goal beside its plane; leave out the second number"
                    .to_owned(),
            ),
            Dimension::Space if !scene.physics.ground.resolved().is_flat() => self.refuse(
                "`scene.profile`: the ground of a robot in space is a plane; leave out `profile`"
                    .to_owned(),
            ),
            _ => Ok(()),
        }
    }

    /// The lattice as the case wants it: as it is, or as its own mirror image.
    fn mirrored(&self, raw: &CaseFile, lattice: Lattice) -> Result<Lattice> {
        if !raw.scene.mirror {
            return Ok(lattice);
        }
        let lattice = lattice.mirrored();
        match lattice.mirror {
            Some(_) => Ok(lattice),
            None => {
                self.refuse("`scene.mirror`: the lattice is not its own mirror image".to_owned())
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
