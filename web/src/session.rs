//! The requests of the page on an optimisation in progress, and on the robot that it delivers.

use crate::evolve::Evolution;
use crate::gains;
use crate::work::{PageRobot, Whole, Work, clearance, nothing, solid_nodes};
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::error::Error;
use cosmic::geometry::Vector;
use cosmic::outcome::DesignFile;
use cosmic::scene::{GoalKind, Scene};
use cosmic::search::CoDesign;
use cosmic::shop::{self, Piece};
use serde_json::{Value, json};

type Answer = cosmic::Result<Value>;

/// The state that the library keeps between the requests of the page.
#[derive(Default)]
pub(crate) struct Session {
    /// The optimisation; `None` before it has begun.
    work: Option<Work>,
    /// The evolution of robots for its scene; `None` before its first try.
    evolution: Option<Evolution>,
}

impl Session {
    /// Begins a design in a scene. Returns the world and the robot before the first iteration.
    pub(crate) fn begin(&mut self, scene: &Scene, seed: u64) -> Answer {
        let codesign = CoDesign::new(scene)?;
        let progress = codesign.begin(seed)?;
        let mut begun = Work::of(codesign, progress);
        let first = begun.present();
        let answer = json!({ "world": begun.view(), "first": first });
        *self = Self::of(begun);
        Ok(answer)
    }

    /// Does one iteration. If `shown`, the answer includes the robot with its rollout.
    pub(crate) fn iterate(&mut self, shown: bool) -> Answer {
        let work = self.work()?;
        let record = work.codesign.iterate(&mut work.progress);
        let check = work.codesign.step_check(&work.progress);
        check.accept(&work.codesign.scene().physics)?;
        let robot = if shown { work.present() } else { Value::Null };
        let done = work.codesign.is_done(&work.progress);
        Ok(json!({ "record": record, "robot": robot, "done": done }))
    }

    /// The gradient of the robot's distance after the last iteration: how many metres farther it gets for each share of
    /// solid material that a bar has more. `tried` asks for a rollout with such a bar.
    pub(crate) fn gains(&mut self, tried: Option<(usize, f64)>) -> Answer {
        let work = self.work()?;
        gains::gains(&work.codesign, &work.progress, tried)
    }

    /// Tries `tries` more robots of an evolution for the scene of the design. Returns the best robot if it is a new one. The
    /// evolution takes the place of the design.
    pub(crate) fn evolve(&mut self, tries: usize) -> Answer {
        let work = self.work.as_mut().ok_or_else(nothing)?;
        let evolution = self.evolution.get_or_insert_with(|| Evolution::new(work));
        let mut is_better = false;
        for _ in 0..tries {
            is_better |= evolution.attempt(work);
        }
        let shown = is_better.then(|| evolution.present(work));
        Ok(json!({ "tries": evolution.tries(), "robot": shown }))
    }

    /// Chooses the robot to deliver and measures it. If `packed`, the robot is the one that a link holds: its policy is in
    /// open loop, and its weights are rounded. Robots that do not fit into a link stay as they are.
    pub(crate) fn deliver(&mut self, packed: bool) -> Answer {
        let mut entrants = Vec::new();
        if packed && let Some(packed) = self.work()?.packed()? {
            *self = Self::of(packed.work);
            entrants = packed.entrants;
        }
        let work = self.work()?;
        let delivery = work.deliver(&work.progress);
        let measured = work.measured(&work.progress, &delivery);
        let is_chosen = |(robot, _): &(PageRobot, Whole)| robot.controller == delivery.controller;
        let robot = match entrants.into_iter().find(is_chosen) {
            Some((robot, whole)) => {
                work.whole = Some(whole);
                robot
            }
            None => PageRobot {
                design: delivery.design,
                projected: work.codesign.design(&work.progress),
                controller: delivery.controller,
                bytes: None,
            },
        };
        let shown = work.show(&robot);
        work.delivered = Some(robot);
        work.edited = None;
        Ok(json!({ "measured": measured, "robot": shown }))
    }

    /// Gives the delivered robot other materials. `None`, and the materials of the delivered robot, restore that robot.
    pub(crate) fn edit(&mut self, materials: Option<Vec<Material>>) -> Answer {
        let work = self.work()?;
        let delivered = work.delivered.clone().ok_or_else(nothing)?;
        let is_other = |materials: &Vec<Material>| *materials != delivered.projected.materials();
        let Some(materials) = materials.filter(is_other) else {
            work.edited = None;
            return Ok(json!({ "robot": work.show(&delivered) }));
        };
        let (found, edges) = (materials.len(), delivered.design.edges());
        if found != edges {
            let says = format!("expected {edges} materials, found {found}");
            return Err(Error::Usage(says));
        }
        let robot = match (&work.whole, &delivered.bytes) {
            (Some(whole), Some(_)) => work.unpack(work.pack(whole, &materials)?)?,
            _ => PageRobot {
                design: Design::Layout(materials.clone()),
                projected: Design::Layout(materials),
                ..delivered
            },
        };
        let shown = work.show(&robot);
        work.edited = Some(robot);
        Ok(json!({ "robot": shown }))
    }

    /// Gives the delivered robot the edits of a link to this robot.
    pub(crate) fn restore(&mut self, bytes: Vec<u8>) -> Answer {
        let work = self.work()?;
        let robot = work.unpack(bytes)?;
        let shown = work.show(&robot);
        work.edited = Some(robot);
        Ok(json!({ "robot": shown }))
    }

    /// Lets the robot that was shown last walk on to a goal, from a frame of its walk. Its clock goes on, too. `to` is
    /// the place of the goal along the ground and across (m), counted from the payload at the start.
    pub(crate) fn tell(&mut self, to: [f64; 2], frame: usize) -> Answer {
        let work = self.work()?;
        if work.codesign.scene().controller.goals != GoalKind::Given {
            let says = "only robots with given goals can be told where to go: the scene needs `controller.goals = \"given\"`";
            return Err(Error::Usage(says.to_owned()));
        }
        let (robot, first, start) = work.moment(frame)?;
        Ok(work.go_on(robot, first, &start, to))
    }

    /// Lets the robot that was shown last walk on from a frame of its walk, after a push. `velocity` (along,
    /// across, above) is added to the velocity of every node, m/s; a planar robot ignores the part across.
    pub(crate) fn push(&mut self, velocity: [f64; 3], frame: usize) -> Answer {
        let work = self.work()?;
        let (robot, first, mut start) = work.moment(frame)?;
        for v in &mut start.v {
            *v += start.dimension.onto(Vector::new(velocity));
        }
        let walked = work.walk_on(robot, first, &start, None);
        Ok(json!({ "robot": walked.0 }))
    }

    /// Lets the finished robot walk from the start in a world where some settings of the physics are others, such as gravity
    /// and ground. Later goals and pushes happen in that world.
    pub(crate) fn visit(&mut self, settings: &[String]) -> Answer {
        let work = self.work()?;
        let (robot, own) = (work.finished()?.clone(), work.codesign.world());
        let there = work.world_with(settings)?;
        let mut start = own.lattice().state_at_rest();
        let solid = solid_nodes(&robot, &there);
        let lift = clearance(&start, &solid, own) - clearance(&start, &solid, &there);
        for x in &mut start.x {
            *x += Vector::upright(0.0, lift);
        }
        work.elsewhere = Some(there);
        let shown = work.walk_on(robot, 0, &start, None).0;
        Ok(json!({ "world": work.view(), "robot": shown }))
    }

    /// Measures the finished robot with its edits in the world of the scene a little further, and judges it if nothing is left
    /// to measure.
    pub(crate) fn judge(&mut self) -> Answer {
        Ok(json!({ "measured": self.work()?.judge_further()? }))
    }

    /// The finished robot, with its edits, in bytes for a link.
    pub(crate) fn share(&mut self) -> Answer {
        let bytes = self.work()?.finished()?.bytes.as_ref();
        let bytes =
            bytes.ok_or_else(|| Error::Usage("this robot does not fit into a link".to_owned()))?;
        Ok(json!({ "bytes": bytes }))
    }

    /// Opens a packed robot of a scene. Returns the world, and the robot with its walk.
    pub(crate) fn open(&mut self, scene: &Scene, bytes: Vec<u8>) -> Answer {
        let mut begun = Work::open_loop(scene, &bytes)?;
        let robot = begun.unpack(bytes)?;
        begun.whole = Some(Whole {
            settings: begun.codesign.scene().controller.clone(),
            controller: robot.controller.clone(),
        });
        let shown = begun.show(&robot);
        begun.delivered = Some(robot);
        let answer = json!({ "world": begun.view(), "robot": shown });
        *self = Self::of(begun);
        Ok(answer)
    }

    /// Returns what is needed to build the finished robot, with its edits: the pieces, and the set points of its actuators
    /// over a period (`null` if they do not repeat).
    pub(crate) fn shop(&mut self) -> Answer {
        let work = self.work()?;
        let (scene, robot) = (work.codesign.scene(), work.finished()?);
        let materials = robot.projected.materials();
        let case = Case::of_robot(scene, robot.design.clone(), robot.controller.clone());
        let pieces = shop::pieces(scene, &case.lattice, &materials);
        let piece = |piece: &Piece| json!({ "part": piece.name, "length": piece.length, "mass": piece.mass, "places": piece.places });
        let drive = shop::set_points(&case, &materials);
        let drive = drive.map(|drive| json!({ "every": drive.every, "lengths": drive.lengths }));
        Ok(json!({ "pieces": pieces.iter().map(piece).collect::<Vec<_>>(), "drive": drive }))
    }

    /// Returns the texts of `design.json` and `scene.toml` for the finished robot, with its edits.
    pub(crate) fn design(&mut self) -> Answer {
        let work = self.work()?;
        let robot = work.finished()?;
        let lattice = work.codesign.world().lattice();
        let file = DesignFile::new(
            lattice,
            &robot.design,
            &robot.projected.materials(),
            &robot.controller,
        );
        let scene = work.codesign.scene().to_toml();
        Ok(json!({ "design": file.to_json(), "scene": scene }))
    }

    /// The session of work that has just begun.
    fn of(work: Work) -> Self {
        Self {
            work: Some(work),
            evolution: None,
        }
    }

    fn work(&mut self) -> cosmic::Result<&mut Work> {
        self.work.as_mut().ok_or_else(nothing)
    }
}
