//! `design.json`: the file of a robot, from which other runs can begin. It contains no time and no name of a machine,
//! so that equal robots give equal bytes.

use crate::case::Case;
use crate::design::{Design, Material};
use crate::error::{Error, Result, fits};
use crate::format::{Format, parse_json};
use crate::lattice::Lattice;
use crate::policy::{Controller, Weights, blocks_of};
use crate::reading::read_whole;
use crate::scene::Scene;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;

/// The contents of a design file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignFile {
    /// The two nodes of each edge, in any order. They show whether the design was made for another lattice.
    pub edges: Vec<[usize; 2]>,
    /// The design vectors, one per edge.
    pub z: Vec<[f64; 3]>,
    /// One material per edge: the materials of the layout, or the dominant materials if `z` is not one-hot.
    pub materials: Vec<Material>,
    /// The controller's weights.
    pub controller: Weights,
    /// `format` and `version` are checked by [`parse_json`]; their values are not kept.
    #[serde(rename = "format", skip_serializing)]
    _format: IgnoredAny,
    #[serde(rename = "version", skip_serializing)]
    _version: IgnoredAny,
}

impl DesignFile {
    /// The format of a design file.
    pub const FORMAT: Format = Format::new("cosmic-design", 1);

    /// Makes the design file of a robot. `materials` has the materials of the layout, or the dominant materials of an
    /// undecided design.
    pub fn new(
        lattice: &Lattice,
        design: &Design<[f64; 3]>,
        materials: &[Material],
        controller: &Controller<f64>,
    ) -> Self {
        Self {
            edges: lattice.edges.clone(),
            z: design.vectors().into_owned(),
            materials: materials.to_vec(),
            controller: Weights::from(controller),
            _format: IgnoredAny,
            _version: IgnoredAny,
        }
    }

    /// Reads a design. [`robot`](Self::robot) checks whether it fits a lattice.
    ///
    /// # Errors
    /// [`Error::Read`] for a file that is missing or unreadable; the errors of [`parse`](Self::parse).
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_whole(path)?)
    }

    /// Parses the bytes of a design file; errors name `path`.
    ///
    /// # Errors
    /// [`Error::Malformed`].
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        parse_json(path, bytes, Self::FORMAT)
    }

    /// The text of the design file. Numbers that are written and read back have the same bits.
    pub fn to_json(&self) -> String {
        Self::FORMAT.line(self)
    }

    /// The design: a layout if the design vectors are one-hot.
    pub fn design(&self) -> Design<[f64; 3]> {
        Design::of_vectors(self.z.clone())
    }

    /// Puts the edges of this file into the order of the scene's lattice. The design vectors, the materials and the
    /// controller's numbers for edges move with them. A file with another number of edges is returned as it is, because
    /// [`robot`](Self::robot) refuses it. Errors name `file`.
    ///
    /// # Errors
    /// [`Error::Misfit`] if `z` or `materials` does not have one entry for each edge; [`Error::Usage`] for an edge that the
    /// lattice does not have, for an edge that is given twice, and for a policy whose numbers cannot be sorted.
    pub fn in_order(mut self, scene: &Scene, file: &str) -> Result<Self> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let edges = lattice.edges.len();
        if self.edges == lattice.edges || self.edges.len() != edges {
            // `robot` refuses another number of edges.
            return Ok(self);
        }
        let sorted = |&[i, j]: &[usize; 2]| [i.min(j), i.max(j)];
        let places: HashMap<[usize; 2], usize> =
            lattice.edges.iter().map(sorted).zip(0..).collect();
        let mut order = vec![None; edges];
        for (e, ends) in self.edges.iter().enumerate() {
            let says = match places.get(&sorted(ends)) {
                None => "is not an edge of the scene's lattice",
                Some(&place) if order[place].is_some() => "is given twice",
                Some(&place) => {
                    order[place] = Some(e);
                    continue;
                }
            };
            return Err(Error::Usage(format!(
                "{file}: `edges[{e}]`: {ends:?} {says}"
            )));
        }
        let order: Vec<usize> = order.into_iter().flatten().collect();
        for (what, rows) in [
            ("rows of `z`", self.z.len()),
            ("entries in `materials`", self.materials.len()),
        ] {
            fits(file, what, rows, edges)?;
        }
        self.z = order.iter().map(|&e| self.z[e]).collect();
        self.materials = order.iter().map(|&e| self.materials[e]).collect();
        let blocks = blocks_of(&scene.controller, &lattice);
        let mut smaller = lattice.clone();
        smaller.edges.pop();
        let fewer = blocks_of(&scene.controller, &smaller);
        for (block, fewer) in blocks.iter().zip(&fewer) {
            if block.shape != fewer.shape && !self.controller.sort(block, fewer, &order) {
                return Err(Error::Usage(format!(
                    "{file}: `edges`: the edges are not in the order of the scene's lattice, in which `controller.{}` has \
                     its numbers; list them in the order of {:?}",
                    block.name, lattice.edges
                )));
            }
        }
        self.edges = lattice.edges;
        Ok(self)
    }

    /// Checks that the design fits the scene, with its edges [in order](Self::in_order), and returns its controller.
    /// Errors name `file`.
    ///
    /// # Errors
    /// [`Error::Misfit`] for another number of edges, nodes or hidden units; [`Error::Usage`] for edges between other
    /// nodes, and for materials that contradict a one-hot `z`.
    pub fn robot(&self, scene: &Scene, file: &str) -> Result<Controller<f64>> {
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let edges = lattice.edges.len();
        let fits = |what: &str, found, expected| fits(file, what, found, expected);
        fits("`edges`", self.edges.len(), edges)?;
        if let Some(e) = (0..edges).find(|&e| self.edges[e] != lattice.edges[e]) {
            return Err(Error::Usage(format!(
                "{file}: `edges[{e}]`: expected {:?}, as in the scene's lattice, found {:?}",
                lattice.edges[e], self.edges[e]
            )));
        }
        fits("rows of `z`", self.z.len(), edges)?;
        fits("entries in `materials`", self.materials.len(), edges)?;
        let design = self.design();
        let layout = design.layout().unwrap_or(&self.materials);
        if let Some(e) = (0..edges).find(|&e| self.materials[e] != layout[e]) {
            return Err(Error::Usage(format!(
                "{file}: `materials[{e}]`: expected {} as in `z`, found {}",
                layout[e] as usize, self.materials[e] as usize
            )));
        }
        self.controller.check_hidden(&scene.controller, file)?;
        let blocks = blocks_of(&scene.controller, &lattice);
        self.controller.controller(&blocks, file)
    }

    /// Puts the robot of this file into its scene, and returns a case that can be simulated. Errors name `file`.
    ///
    /// # Errors
    /// Like [`in_order`](Self::in_order) and [`robot`](Self::robot).
    pub fn case(&self, scene: &Scene, file: &str) -> Result<Case> {
        let sorted = self.clone().in_order(scene, file)?;
        let controller = sorted.robot(scene, file)?;
        Ok(Case::of_robot(scene, sorted.design(), controller))
    }
}
