//! Domain randomisation of gradients: means over robots drawn around the nominal one.

use rayon::prelude::*;

use super::begin::CoDesign;
use super::progress::Progress;
use super::schedule::Schedule;
use super::slope::{At, Slope};
use crate::domain::{Domain, draw};
use crate::inputs::Inputs;
use crate::random::{Purpose, stream_of};
use crate::task::Task;

impl CoDesign {
    /// The domains of an iteration's gradients; none if the scene asks for the nominal robot. Every
    /// iteration has its own, by its number, so that a resumed run draws the same domains.
    pub(super) fn domains(&self, progress: &Progress, now: &Schedule) -> Vec<Domain<'_>> {
        let settings = &self.scene.robust;
        let number = now.iteration as u64;
        let mut stream = stream_of(progress.seed, Purpose::DomainRandomisation, number);
        let domain = |_| draw(&self.task, settings, &mut stream);
        (0..settings.samples).map(domain).collect()
    }

    /// The point of an iteration's gradients.
    pub(super) fn point(&self, progress: &Progress, now: &Schedule) -> At<'_> {
        At {
            domains: self.domains(progress, now),
            inputs: self.inputs(progress),
            horizon: self.horizon(now),
        }
    }

    /// The inputs of the present robot's rollout from the unperturbed start.
    pub fn inputs(&self, progress: &Progress) -> Inputs<f64> {
        Inputs {
            z: progress.design.vectors().into_owned(),
            controller: progress.controller.clone(),
            start: self.start.clone(),
        }
    }

    /// The means of gradients over the domains, or without any the gradients of the nominal task.
    pub(super) fn means<const N: usize>(
        &self,
        at: &At,
        slopes: impl Fn(&Task, &Inputs<f64>) -> [Slope; N] + Sync,
    ) -> [Slope; N] {
        if at.domains.is_empty() {
            return slopes(&self.task, &at.inputs);
        }
        let in_domain = |domain: &Domain| {
            let start = domain.start.clone();
            let inputs = Inputs {
                start,
                ..at.inputs.clone()
            };
            slopes(&domain.task, &inputs)
        };
        // Collected in order: the sum does not depend on the number of threads.
        let of_domains: Vec<[Slope; N]> = at.domains.par_iter().map(in_domain).collect();
        std::array::from_fn(|k| Slope::mean(of_domains.iter().map(|slopes| &slopes[k])))
    }
}

#[cfg(test)]
mod tests {
    use crate::codesign::schedule::Schedule;
    use crate::codesign::tests::tiny;
    use crate::codesign::{CoDesign, Progress};
    use crate::simulator::stability::Vibration;
    use crate::task::Task;

    /// The largest frequency of a task's robot, 1/s.
    fn frequency(codesign: &CoDesign, progress: &Progress, task: &Task) -> f64 {
        let body = task.body(&codesign.design(progress));
        let rest = &task.lattice.positions;
        Vibration::new(&task.lattice, &body, &task.physics, rest).largest_frequency()
    }

    #[test]
    fn time_steps_are_held_against_the_robots_that_are_drawn() {
        let mut scene = tiny();
        let alone = CoDesign::new(&scene).unwrap();
        let progress = alone.begin(0).unwrap();
        let nominal = (
            alone.step_check(&progress),
            frequency(&alone, &progress, &alone.task),
        );
        (scene.robust.samples, scene.robust.stiffness) = (32, 0.4);
        let drawing = CoDesign::new(&scene).unwrap();
        let progress = drawing.begin(0).unwrap();
        let check = drawing.step_check(&progress);
        let drawn = drawing.domains(&progress, &Schedule::at(&scene, 1));
        let drawn = drawn
            .iter()
            .map(|w| frequency(&drawing, &progress, &w.task));
        let fastest = drawn.fold(0.0, f64::max);
        let faster = scene.robust.faster();
        assert!(nominal.1 < fastest && fastest < faster * nominal.1);
        // Products and quotients of the same numbers, in another order.
        let is = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
        assert!(is(
            check.bound.frequency,
            faster * nominal.0.bound.frequency
        ));
        let [any, any_drawn] = [nominal.0, check].map(|check| check.any_design.unwrap());
        // Symplectic Euler's damped limit is all but inverse to the frequency.
        assert!(any_drawn < any / (0.97 * faster), "{any_drawn} of {any}");
    }
}
