//! Optimisations that compute on a device. Here the device is the processor, in another way than usual.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use autodiff::{Tape, Var};
use cosmic::Error;
use cosmic::codesign::Record;
use cosmic::population::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use cosmic::record::{RunPlan, history, optimise, optimise_on, resume};
use cosmic::scene::Scene;
use cosmic::simulator::{Trajectory, Wanted};

/// A small scene that goes through every phase.
const SCENE: &str = "
base = 'stability'
lattice = { columns = 3, rows = 2 }
[physics]
steps = 64
[schedule]
iterations = 12
attraction_from = 6
snap_at = 8
horizon = [32, 64]
horizon_over = [2, 5]
snap_trials = 4
polish_trials = 4
[loss]
window = 16
[gradient]
precision = 'f32'
";

/// Simulates one robot after the other.
#[derive(Default)]
struct Processor {
    /// The number of batches of each call.
    calls: Mutex<Vec<usize>>,
    /// The call that fails, counted from 1, and later calls; 0 if all work.
    fails_at: usize,
    count: AtomicUsize,
}

impl Processor {
    fn call(&self, batches: usize) -> Result<(), Refused> {
        self.calls.lock().unwrap().push(batches);
        let call = self.count.fetch_add(1, Ordering::Relaxed) + 1;
        match self.fails_at {
            0 => Ok(()),
            fails_at if call < fails_at => Ok(()),
            _ => Err("it was unplugged".to_owned()),
        }
    }
}

fn of<T>(list: &[T], k: usize) -> &T {
    &list[k % list.len()]
}

fn rolled(batch: &Batch, k: usize) -> Trajectory<f64> {
    let single = |x: f64| x as f32;
    let seen = batch.simulator.rollout_in(
        &of(&batch.surroundings, k).map(single),
        &of(&batch.bodies, k).map(single),
        &of(&batch.controllers, k).map(single),
        &batch.starts[k].map(single),
        &batch.span,
    );
    seen.map(f64::from)
}

/// The gradient by all numbers of the body and the controller, in double precision.
fn differentiated(asked: &GradientBatch, k: usize) -> RobotGradient {
    let batch = &asked.of;
    let (body, controller) = (of(&batch.bodies, k), of(&batch.controllers, k));
    let mut numbers = Vec::new();
    if asked.by.bodies {
        numbers.extend(body.numbers());
    }
    let own = numbers.len();
    if asked.by.controllers {
        numbers.extend(controller.numbers());
    }
    let (mut tape, mut trajectory) = (Tape::new(), None);
    let loss = tape.record(&numbers, |x: &[Var<f64>]| {
        let body = match own {
            0 => body.map(Var::constant),
            _ => body.with_numbers(&x[..own]),
        };
        let mut policy = controller.map(Var::constant);
        if asked.by.controllers {
            policy.numbers_mut().copy_from_slice(&x[own..]);
        }
        let mut seen = batch.simulator.rollout_in(
            &of(&batch.surroundings, k).map(Var::constant),
            &body,
            &policy,
            &batch.starts[k].map(Var::constant),
            &batch.span,
        );
        if let (Some(origin), false) = (asked.origins.get(k), seen.start.is_empty()) {
            seen.start = origin.iter().map(|x| x.map(Var::constant)).collect();
        }
        trajectory = Some(seen.map(|x| x.value()));
        asked.loss.loss_of(&seen)
    });
    let gradient = tape.pullback(&[loss], &[1.0]);
    RobotGradient {
        loss: loss.value(),
        trajectory: trajectory.unwrap(),
        body: match own {
            0 => body.map(|_| 0.0),
            _ => body.with_numbers(&gradient[..own]),
        },
        controller: gradient[own..].to_vec(),
    }
}

impl Populations for Processor {
    fn name(&self) -> String {
        "the processor".to_owned()
    }

    fn check(&self, _: &Batch, _: Option<Wanted>) -> Result<(), Refused> {
        Ok(())
    }

    fn rollouts(&self, asked: &[Batch]) -> Result<Vec<Vec<Trajectory<f64>>>, Refused> {
        self.call(asked.len())?;
        let all = asked.iter().map(|batch| {
            let robots = 0..batch.starts.len();
            robots.map(|k| rolled(batch, k)).collect()
        });
        Ok(all.collect())
    }

    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused> {
        self.call(asked.len())?;
        let all = asked.iter().map(|asked| {
            let robots = 0..asked.of.starts.len();
            robots.map(|k| differentiated(asked, k)).collect()
        });
        Ok(all.collect())
    }
}

fn plan(more: &str, starts: usize) -> RunPlan {
    let scene = Scene::parse("tiny", &format!("{SCENE}{more}")).unwrap();
    RunPlan {
        starts: starts.try_into().unwrap(),
        ..RunPlan::new("tiny", scene, 0)
    }
}

fn records(folder: &Path, seed: u64) -> Vec<Record> {
    let start = folder.join("starts").join(seed.to_string());
    history::read(&start, usize::MAX).unwrap()
}

/// The losses, the norms of the gradients and the displacements of an iteration.
fn numbers(record: &Record) -> Vec<f64> {
    let of_pass = [
        record.loss_horizon,
        record.displacement_horizon,
        record.merit_horizon,
        record.design_gradient[0],
        record.design_gradient[1],
        record.controller_gradient,
        record.displacement,
    ];
    of_pass.into_iter().flatten().collect()
}

/// A device computes the losses and gradients of the processor, in scenes with random domains, given goals, two goals, a
/// horizon at the end of the rollout, and a loss that reads efforts or the centre of mass.
#[test]
fn a_device_optimises_like_the_processor() {
    for more in [
        "",
        "[robust]\nsamples = 2\nspread = 2.0\nfriction = 0.1\n[selection]\nkind = 'robust'",
        "[controller]\ngoals = 'two'",
        "[objective]\nbody = 'mass'\n[design]\none_piece = true",
        "[objective]\ntask = 'economy'",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let [there, here] = ["there", "here"].map(|name| folder.path().join(name));
        let mut plan = plan(more, 2);
        if more.contains("mass") {
            plan.scene = plan
                .scene
                .set(&["schedule.horizon_mode=tail".to_owned()])
                .unwrap();
        }
        let device = Arc::new(Processor::default());
        optimise_on(Some(device), &there, &plan, &mut ()).unwrap();
        optimise(&here, &plan, &mut ()).unwrap();
        for seed in 0..2 {
            let pairs = records(&there, seed).into_iter().zip(records(&here, seed));
            // A pass of each kind. One update makes of the rounding of single precision, 1e-7 in 64 steps, up to 1e-4; an
            // error in a formula is far above the tolerance.
            for (there, here) in pairs.take(2) {
                let [a, b] = [numbers(&there), numbers(&here)];
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * b.abs() + 1e-6;
                assert!(
                    a.len() == b.len() && a.iter().zip(&b).all(|(&a, &b)| near(a, b)),
                    "{more}: iteration {}: {a:?} instead of {b:?}",
                    here.iteration
                );
            }
        }
    }
}

/// All starts wait for one another, so that a call has the batches of all of them.
#[test]
fn starts_advance_together_on_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let device = Arc::new(Processor::default());
    let mut plan = plan("", 3);
    plan.iterations = 4.try_into().ok();
    let on = Some(Arc::clone(&device) as Arc<dyn Populations>);
    optimise_on(on, &folder.path().join("run"), &plan, &mut ()).unwrap();
    let calls = device.calls.lock().unwrap();
    assert!(calls.iter().all(|batches| *batches == 3), "{calls:?}");
}

#[test]
fn a_run_whose_device_fails_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let plan = plan("", 2);
    let device = Arc::new(Processor {
        fails_at: 6,
        ..Processor::default()
    });
    let error = optimise_on(Some(device), &run, &plan, &mut ()).unwrap_err();
    assert!(matches!(error, Error::DeviceFailed { .. }), "{error}");
    assert_eq!(error.exit_code(), 75);
    let said = error.to_string();
    let resume_command = format!("cosmic resume {}", run.display());
    for words in ["it was unplugged", &*resume_command, "--device gpu"] {
        assert!(said.contains(words), "{said}");
    }
    // What the failed iteration computed does not count.
    let saved = records(&run, 0);
    assert!(!saved.is_empty() && saved.iter().all(|row| row.skipped == 0));
    let summary = resume(&run, plan.scene.registry(), &mut ()).unwrap();
    assert_eq!(summary.iterations, 12);
}

#[test]
fn gradients_in_double_precision_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut plan = plan("", 2);
    plan.scene = plan
        .scene
        .set(&["gradient.precision=f64".to_owned()])
        .unwrap();
    let run = folder.path().join("run");
    let device = Arc::new(Processor::default());
    let error = optimise_on(Some(device), &run, &plan, &mut ()).unwrap_err();
    assert!(
        error.to_string().contains("--set gradient.precision=f32"),
        "{error}"
    );
    assert!(!run.exists());
}
