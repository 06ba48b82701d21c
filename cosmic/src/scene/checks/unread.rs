//! Finds settings of a scene that have no effect.

use crate::laws::FRICTION;
use crate::scene::{Finding, GoalKind, LossKind, Scene, Setting, StartKind, TaskKind};

impl Scene {
    /// The settings whose values differ from those of the scene's base.
    pub fn changed(&self) -> Vec<Setting> {
        let base = self.base.scene().settings();
        let mut settings = self.settings();
        settings.retain(|setting| !base.contains(setting));
        settings
    }

    /// A warning for every setting that differs from the base although the scene does not read it.
    pub(super) fn unread(&self) -> Vec<Finding> {
        let remark = |Setting { key, .. }: Setting| {
            let when = self.clone().when_read(&key, self)?;
            let says = format!("this setting has no effect: it is read only {when}");
            Some(Finding::new(self, &[&key], says, String::new()))
        };
        let mut changed = self.changed();
        // A truss sets aside what its base says about a generated lattice; a scene with a truss must have these values.
        let set_aside = ["lattice.kind", "lattice.payload"];
        changed.retain(|setting| !self.lattice.is_truss() || !set_aside.contains(&&*setting.key));
        changed.into_iter().filter_map(remark).collect()
    }

    /// Returns the condition under which scenes read the key at `path`, as a phrase, if this scene does not read it.
    /// `None` if this scene reads the key.
    pub(in crate::scene) fn when_read(
        &mut self,
        path: &str,
        scene: &Scene,
    ) -> Option<&'static str> {
        let (section, _) = path.split_once('.')?;
        let (when, is_read) = scene.section_is_read(section);
        if !is_read {
            return Some(when);
        }
        let field = self.field(path)?;
        (!(field.is_read)(scene)).then_some(field.when)
    }

    /// True if the design is optimised: the start is not a layout.
    pub(in crate::scene) fn designs(&self) -> bool {
        self.start.kind != StartKind::Layout
    }

    /// True if the loss is that of the task, and not a loss that a program adds.
    pub(in crate::scene) fn has_task(&self) -> bool {
        self.objective.own_loss.is_default()
    }

    /// True if the loss is the distance from a fixed goal.
    pub(in crate::scene) fn reaches(&self) -> bool {
        self.has_task() && self.objective.task == TaskKind::Reach
    }

    /// True if the loss depends on more states than the last one.
    pub(in crate::scene) fn sees_several_states(&self) -> bool {
        self.loss.kind == LossKind::Mean
    }

    /// True if the loss may be cut into windows: that of a task, without goals that are given, of which it is a share.
    pub(in crate::scene) fn can_be_cut(&self) -> bool {
        self.has_task() && self.controller.goals == GoalKind::Fixed
    }

    /// True if controllers learn in windows after the snap, and not over the horizon.
    pub(crate) fn learns_in_windows(&self) -> bool {
        self.schedule.window.is_some() && self.can_be_cut()
    }

    /// True if the lattice is generated from columns and rows.
    pub(in crate::scene) fn is_generated(&self) -> bool {
        !self.lattice.is_truss()
    }

    /// True if the contact law reads the coefficient of friction.
    pub(crate) fn slips(&self) -> bool {
        let inputs = self.physics.contact.law().inputs();
        inputs.iter().any(|input| input.name == FRICTION)
    }
}
