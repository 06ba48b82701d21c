//! Settings of what goes beyond the paper, all of it off by default: other tasks, robust designs,
//! and a search over starts that drops the weak ones early.

use super::Scene;
use serde::Serialize;
use toml::Spanned;
use toml::de::DeValue;

use crate::registry::{OFF, Registry};
use crate::settings;
use crate::settings::{
    DEVIATION, Filled, Limits, SHARE, SettingValue, json, unknown, within, word,
};

settings! {
    /// The task of the robot. Displacement is reported for every task.
    struct ObjectiveSettings {
        /// To get far, to be near a point, to climb, to go back, or to save energy.
        task: TaskKind = TaskKind::Far, since 1,
            read "without an `own_loss`" if Scene::has_task,
            source "paper: far";
        /// A loss in place of the task's, by a name that the program was given.
        own_loss: OwnLoss = OwnLoss::default(), since 1, source "the paper has none";
        /// For "reach": where the payload should be in the states that the loss covers, along the ground from
        /// its origin. The robot passes the target and keeps moving: no task makes a robot stop yet.
        target: f64 = 1.0, allowed within(-1e3, 1e3), unit "m", since 1,
            read "with the task `reach`" if |s: &Scene| s.objective.task == TaskKind::Reach && s.has_task(),
            source "beyond the paper";
        /// For "reach": the time in which a speed at the target counts as a distance.
        settle: f64 = 0.2, allowed within(0.0, 1e3), unit "s", since 1,
            read "with the task `reach`" if |s: &Scene| s.objective.task == TaskKind::Reach && s.has_task(),
            source "beyond the paper";
        /// For "economy": the price, in metres, of a joule per kilogram lost to damping.
        energy_price: f64 = 0.1, allowed within(0.0, 1e6), unit "m kg/J", since 1,
            read "with the task `economy`" if |s: &Scene| s.objective.task == TaskKind::Economy && s.has_task(),
            source "beyond the paper";
    }
}

settings! {
    /// What the robot is to do.
    enum TaskKind {
        /// To get far along the ground.
        Far = "far",
        /// To be near a point, and slow, in the states that the loss covers. Nothing makes the robot stop: it passes
        /// the point and keeps moving.
        Reach = "reach",
        /// To get the payload high.
        Climb = "climb",
        /// To get far the other way.
        Back = "back",
        /// To get far on little energy.
        Economy = "economy",
    }
}

settings! {
    /// Gradients averaged over robots and surroundings drawn around the nominal ones.
    struct RobustSettings {
        /// Draws per gradient, new ones every iteration; 0 designs for the nominal robot.
        samples: usize = 0, allowed within(0.0, 1e4), since 1, source "paper: 0";
        /// How far a coordinate of the start is off at most.
        start: f64 = 0.002, allowed within(0.0, 1.0), unit "m", since 1,
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
        /// Share by which the coefficient of Coulomb friction is off at most.
        friction: f64 = 0.2, allowed DEVIATION, since 1,
            read "with `samples` above 0 and a contact law that slips" if |s: &Scene| s.robust.samples > 0 && s.slips(),
            source "beyond the paper";
        /// Share by which the stiffness of an edge is off at most.
        stiffness: f64 = 0.1, allowed DEVIATION, since 1,
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
        /// Share by which the mass of a node is off at most.
        mass: f64 = 0.1, allowed DEVIATION, since 1,
            read "with `samples` above 0" if |s: &Scene| s.robust.samples > 0,
            source "beyond the paper";
    }
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

settings! {
    /// How `optimize --starts N --search halving` drops weak starts; not read otherwise.
    struct SearchSettings {
        /// Iterations after which starts are dropped, none below the one before it. At the last
        /// iteration and beyond nothing is dropped any more.
        rungs: [usize; 3] = [60, 200, 260], allowed within(1.0, 1e5), since 1, source "beyond the paper";
        /// Share of the starts that goes on after each of them, rounded up.
        keep: [f64; 3] = [0.34, 0.5, 0.5], allowed SHARE, since 1, source "beyond the paper";
        /// Iterations up to a rung over which a start's displacement is judged, by their median.
        window: usize = 10, allowed within(1.0, 1e5), since 1, source "beyond the paper";
    }
}

/// The name of a loss that this process was [given](crate::objective::add), or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OwnLoss(Option<&'static str>);

/// The names of all losses given.
static LOSSES: Registry<()> = Registry::new();

impl OwnLoss {
    /// Makes a name known to the scenes that are read from now on.
    ///
    /// # Panics
    /// If it is known already, or means that there is none.
    pub(crate) fn add(name: &'static str) {
        assert!(name != OFF, "a loss cannot be called {name:?}");
        LOSSES.add("loss", name, ());
    }

    /// The name; `None` for the task's own loss.
    pub fn name(self) -> Option<&'static str> {
        self.0
    }

    fn known() -> impl Iterator<Item = &'static str> {
        LOSSES.all().into_iter().map(|(name, ())| name)
    }
}

impl SettingValue for OwnLoss {
    fn allowed(&self, _: &Limits) -> String {
        let names = [OFF].into_iter().chain(Self::known());
        let names: Vec<String> = names.map(|name| format!("{name:?}")).collect();
        let names = names.join(" or ");
        format!("{names}; another loss needs the program that brings it")
    }

    fn toml(&self) -> String {
        format!("{:?}", self.0.unwrap_or(OFF))
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let word = word(value)?;
        let name = Self::known().find(|name| *name == word);
        if name.is_none() && word != OFF {
            return Err(unknown(value, word, "names an unknown loss:"));
        }
        self.0 = name;
        Ok(())
    }
}
