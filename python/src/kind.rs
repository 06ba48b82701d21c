//! How the arrays of a robot become a robot.

use crate::arrays::{Number, Others, Row, Sizes};
use crate::errors::InputError;
use autodiff::Real;
use cosmic::design::{Design, Material};
use cosmic::lattice::{Body, SCALABLE};
use cosmic::policy::Controller;
use cosmic::projection::Projection;
use cosmic::scene::ControllerSettings;
use cosmic::world::{Surroundings, World};
use pyo3::prelude::*;
use std::sync::{Arc, OnceLock};

/// How the rows of the array `z` become the body of a robot.
pub(crate) enum Mixing {
    /// The rows are design vectors, which this projection turns into mixtures.
    By(Projection),
    /// The rows already are mixtures.
    AsGiven,
    /// The rows are the shares of the materials in the edges of a finished robot with this layout.
    Layout(Vec<Material>),
}

/// The robots that a simulator takes: their world, the sizes of their arrays, and what their rows of `z` are.
#[derive(Clone)]
pub(crate) struct Kind {
    pub(crate) world: World,
    pub(crate) sizes: Sizes,
    /// Whether rollouts run on the GPU.
    pub(crate) on_gpu: bool,
    /// Whether the first robots choose the projection.
    is_automatic: bool,
    projection: Arc<OnceLock<String>>,
}

impl Kind {
    /// Robots with controllers. The first ones choose the projection if it is `"auto"`.
    pub(crate) fn new(
        world: World,
        controller: &ControllerSettings,
        on_gpu: bool,
        projection: String,
    ) -> Self {
        Self {
            sizes: Sizes::of(world.lattice(), controller),
            world,
            on_gpu,
            is_automatic: projection == "auto",
            projection: Arc::new(match &*projection {
                "auto" => OnceLock::new(),
                _ => OnceLock::from(projection),
            }),
        }
    }

    /// These robots with further arrays. If activations are given, the robots have no controllers. `changes` are the numbers
    /// of steps at which goals change, `None` if goals are not among the arrays.
    pub(crate) fn with_others(
        &self,
        driven: Option<usize>,
        changes: Option<Vec<usize>>,
        physics: Vec<(String, usize)>,
    ) -> Self {
        let mut sizes = self.sizes.clone();
        if driven.is_some() {
            sizes.blocks.clear();
        }
        let axes = sizes.dimension.count();
        let goals = changes
            .as_ref()
            .map_or(0, |changes| axes * (1 + changes.len()));
        sizes.changes = changes.or(sizes.changes);
        sizes.others = Others {
            driven,
            goals,
            physics,
        };
        Self {
            sizes,
            ..self.clone()
        }
    }

    /// How rows of `z` become a robot; `"auto"` until the first robot decides.
    pub(crate) fn projection(&self) -> &str {
        self.projection.get().map_or("auto", String::as_str)
    }

    /// Decides the projection, unless it is decided.
    pub(crate) fn decide(&self, projection: String) {
        self.projection.get_or_init(|| projection);
    }

    /// The projection of robots with these rows of `z`, which all robots may share. The first call decides what `"auto"`
    /// is. The robots that are `lost` do not count, because their inputs are not finite.
    pub(crate) fn projection_of<R: Number>(&self, z: &[[R; 3]], lost: &[bool]) -> PyResult<&str> {
        let rows: Vec<[f64; 3]> = z.iter().map(|row| row.map(Into::into)).collect();
        let is_chosen = |row: &[f64; 3]| {
            row.iter().all(|&share| share == 0.0 || share == 1.0) && row.iter().sum::<f64>() == 1.0
        };
        if self.is_automatic {
            let robots = rows.chunks(self.sizes.edges);
            let finished: Vec<bool> = robots.map(|rows| rows.iter().all(is_chosen)).collect();
            let counted = (0..lost.len()).filter(|&robot| !lost[robot]);
            let counted: Vec<bool> = counted
                .map(|robot| finished[robot % finished.len()])
                .collect();
            let Some(&is_finished) = counted.first() else {
                return Ok(self.projection.get().map_or("performance", String::as_str));
            };
            if counted.contains(&!is_finished) {
                return Err(InputError::new_err(
                    "z: the batch has finished robots, whose rows are zeros and ones, and others; simulate them with \
                     two simulators",
                ));
            }
            let own = if is_finished { "layout" } else { "performance" };
            let projection = self.projection.get_or_init(|| own.to_owned());
            if is_finished && projection != "layout" {
                return Err(InputError::new_err(
                    "z: this is a finished robot, and the first robots of this simulator were design vectors; use \
                     another simulator, or choose the projection, for example Simulator(scene, \"layout\")",
                ));
            }
        }
        let projection = self.projection();
        let is_vague = |row: &&[f64; 3]| !row.iter().any(|&share| share > 0.5);
        match rows.iter().find(is_vague) {
            Some(row) if projection == "layout" => Err(InputError::new_err(format!(
                "z: a row is {row:?}; this simulator is for finished robots (projection=\"layout\"), so one number of \
                 every row must be above 0.5; use another Simulator for other designs"
            ))),
            _ => Ok(projection),
        }
    }

    /// The body of a robot.
    pub(crate) fn body<R: Real>(&self, mixing: &Mixing, row: &Row<R>) -> Body<R> {
        let (world, z) = (&self.world, row.z);
        let mut body = match mixing {
            Mixing::By(projection) => world.body(&Design::Undecided(
                world.projector().mixtures(*projection, z),
            )),
            Mixing::AsGiven => world.body(&Design::of_shares(z)),
            Mixing::Layout(layout) => world.body_near(layout, z),
        };
        for (name, factors) in &row.physics {
            body.scale(name, factors, &world.lattice().rest_length);
        }
        body
    }

    /// The controller of a robot, or its given activations.
    pub(crate) fn controller<R: Real>(&self, row: &Row<R>) -> Controller<R> {
        match self.sizes.others.driven {
            Some(_) => Controller::given(row.activations.to_vec()),
            None => Controller::new(&self.sizes.blocks, row.controller.to_vec()),
        }
    }

    /// The surroundings of a robot.
    pub(crate) fn surroundings<R: Real>(&self, row: &Row<R>) -> Surroundings<R> {
        let scene = self.world.surroundings();
        let with_goals = match row.goals {
            [] => scene,
            goals => scene.with_goals(self.sizes.goals(goals)),
        };
        let numbers = row.physics.iter();
        let numbers = numbers.filter(|(name, _)| !SCALABLE.contains(name));
        numbers.fold(with_goals, |surroundings, (name, numbers)| {
            surroundings.with(name, numbers[0])
        })
    }
}

impl Mixing {
    /// Reads the argument `projection`, which Python has checked, for a robot with these rows of `z`.
    pub(crate) fn new<R: Number>(projection: &str, z: &[[R; 3]]) -> Self {
        match projection {
            "performance" => Self::By(Projection::Performance),
            "stability" => Self::By(Projection::Stability),
            "layout" => {
                let rows = z.iter().map(|row| Material::dominant(&row.map(Into::into)));
                Self::Layout(rows.collect())
            }
            _ => Self::AsGiven,
        }
    }
}
