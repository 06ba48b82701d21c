//! Settings of what goes beyond the paper, all of it off by default: other tasks, robust designs,
//! and a search over starts that drops the weak ones early.

use super::field::Named;
use serde::Serialize;

/// What the robot is to do; what is reported is the displacement, whatever the task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectiveSettings {
    /// To get far (paper), to reach a point and stop, to climb, to go back, or to save energy.
    pub task: TaskKind,
    /// For "reach": where to, along the ground from its origin, m.
    pub target: f64,
    /// For "reach": the time in which a speed at the target counts as a distance, s.
    pub settle: f64,
    /// For "economy": metres that a joule per kilogram lost to damping is worth, m kg/J.
    pub energy_price: f64,
}

impl Default for ObjectiveSettings {
    fn default() -> Self {
        Self {
            task: TaskKind::Far,
            target: 1.0,
            settle: 0.2,
            energy_price: 0.1,
        }
    }
}

/// What the robot is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    /// To get far along the ground.
    Far,
    /// To reach a point and stop there.
    Reach,
    /// To get the payload high.
    Climb,
    /// To get far the other way.
    Back,
    /// To get far on little energy.
    Economy,
}

impl Named for TaskKind {
    const ALL: &'static [(&'static str, Self)] = &[
        ("far", TaskKind::Far),
        ("reach", TaskKind::Reach),
        ("climb", TaskKind::Climb),
        ("back", TaskKind::Back),
        ("economy", TaskKind::Economy),
    ];
}

/// Gradients averaged over robots and surroundings drawn around the nominal ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobustSettings {
    /// Draws per gradient, new ones every iteration; 0 designs for the nominal robot (paper: 0).
    pub samples: usize,
    /// How far a coordinate of the start is off at most, m.
    pub start: f64,
    /// Share by which the coefficient of Coulomb friction is off at most.
    pub friction: f64,
    /// Share by which the stiffness of an edge is off at most.
    pub stiffness: f64,
    /// Share by which the mass of a node is off at most.
    pub mass: f64,
}

impl RobustSettings {
    /// How many times as fast a drawn robot may vibrate as the nominal one: its edges as stiff, its
    /// nodes as light as any. 1 where none is drawn.
    pub fn faster(&self) -> f64 {
        match self.samples {
            0 => 1.0,
            _ => ((1.0 + self.stiffness) / (1.0 - self.mass)).sqrt(),
        }
    }
}

impl Default for RobustSettings {
    fn default() -> Self {
        Self {
            samples: 0,
            start: 0.002,
            friction: 0.2,
            stiffness: 0.1,
            mass: 0.1,
        }
    }
}

/// How `optimize --starts N --search halving` drops weak starts; not read otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchSettings {
    /// Iterations after which starts are dropped, none below the one before it. At the last
    /// iteration and beyond nothing is dropped any more.
    pub rungs: [usize; 3],
    /// Share of the starts that goes on after each of them, rounded up.
    pub keep: [f64; 3],
    /// Iterations up to a rung over which a start's displacement is judged, by their median.
    pub window: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            rungs: [60, 200, 260],
            keep: [0.34, 0.5, 0.5],
            window: 10,
        }
    }
}
