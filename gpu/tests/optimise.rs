//! Optimisations whose rollouts and gradients are computed on a device.

mod device;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use cosmic::Error;
use cosmic::codesign::{CoDesign, Record};
use cosmic::population::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use cosmic::record::{Observer, Run, RunPlan, Summary, history, optimise_on, resume, resume_on};
use cosmic::scene::Scene;
use cosmic::simulator::{Trajectory, Wanted};
use cosmic_gpu::{Gpu, OnGpu};
use device::gpu;

/// Nine nodes, and 20 iterations that go through every phase.
const SCENE: &str = "
base = 'stability'
lattice = { columns = 3, rows = 3 }
[physics]
steps = 96
[schedule]
iterations = 20
attraction_from = 8
snap_at = 12
horizon = [48, 96]
horizon_over = [2, 5]
polish_trials = 4
[loss]
window = 16
[gradient]
precision = 'f32'
";

fn scene(more: &str) -> Scene {
    Scene::parse("tiny", &format!("{SCENE}{more}")).unwrap()
}

fn plan(scene: Scene, starts: usize) -> RunPlan {
    RunPlan {
        starts: starts.try_into().unwrap(),
        ..RunPlan::new("tiny", scene, 0)
    }
}

fn on(gpu: &Gpu) -> Option<Arc<dyn Populations>> {
    Some(Arc::new(OnGpu::new(gpu.clone(), None).unwrap()))
}

/// The records of a start in a search.
fn records(folder: &Path, seed: u64, plan: &RunPlan) -> Vec<Record> {
    let folder = folder.join("starts").join(seed.to_string());
    history::read(&folder, plan.last_iteration()).unwrap()
}

/// The medians of all starts.
fn medians(summary: &Summary) -> Vec<f64> {
    let starts = summary.starts.iter();
    starts
        .map(|start| start.displacement_robust_p50.expect("it walks"))
        .collect()
}

/// The mean, and its standard error.
fn mean(of: &[f64]) -> [f64; 2] {
    let count = of.len() as f64;
    let mean = of.iter().sum::<f64>() / count;
    let squares = of.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    [mean, (squares / (count - 1.0) / count).sqrt()]
}

#[test]
fn a_search_goes_like_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let plan = plan(scene(""), 8);
    let begun = std::time::Instant::now();
    let there = optimise_on(on(&gpu), &path("gpu"), &plan, &mut ()).unwrap();
    println!(
        "on {}: {:.1} s",
        gpu.adapter().name,
        begun.elapsed().as_secs_f64()
    );
    let here = optimise_on(None, &path("cpu"), &plan, &mut ()).unwrap();
    for seed in 0..8 {
        let [there, here] = ["gpu", "cpu"].map(|name| records(&path(name), seed, &plan));
        let pairs = there.iter().zip(&here);
        let apart: Vec<f64> = pairs
            .filter_map(|(there, here)| {
                let [there, here] = [there.loss_horizon?, here.loss_horizon?];
                Some((there - here).abs() / here.abs().max(1e-3))
            })
            .collect();
        let shown: Vec<String> = apart.iter().map(|x| format!("{x:.1e}")).collect();
        println!("seed {seed}: losses differ by {}", shown.join(" "));
        // The first robot is the same, and differs by the rounding of 48 steps. Each update and each contact then
        // multiplies the difference.
        assert!(apart[0] < 1e-4, "seed {seed}: {apart:?}");
        assert!(
            apart[..4].iter().all(|x| *x < 1e-2),
            "seed {seed}: {apart:?}"
        );
    }
    let [[there, of_there], [here, of_here]] = [&there, &here].map(|of| mean(&medians(of)));
    println!("medians: {there:.4} +- {of_there:.4} m there, {here:.4} +- {of_here:.4} m here");
    assert!((there - here).abs() < of_there.hypot(of_here));
}

/// Interrupts each run after an iteration.
struct StopAfter(usize);

impl Observer for StopAfter {
    fn iteration(&mut self, _: &Run, record: &Record) -> ControlFlow<()> {
        match record.iteration >= self.0 {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

#[test]
fn an_interrupted_run_ends_with_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let plan = plan(scene(""), 2);
    let whole = optimise_on(on(&gpu), &path("whole"), &plan, &mut ()).unwrap();
    let registry = plan.scene.registry();
    let stopped = optimise_on(on(&gpu), &path("parts"), &plan, &mut StopAfter(7));
    assert!(matches!(stopped, Err(Error::Interrupted { .. })));
    let parts = resume_on(on(&gpu), &path("parts"), registry, &mut ()).unwrap();
    let text = |name: &str| fs::read_to_string(path(name).join("design.json")).unwrap();
    assert_eq!(text("whole"), text("parts"));
    assert_eq!(medians(&whole), medians(&parts));
    // A run of the device goes on on the processor.
    let stopped = optimise_on(on(&gpu), &path("other"), &plan, &mut StopAfter(7));
    assert!(matches!(stopped, Err(Error::Interrupted { .. })));
    let other = resume(&path("other"), registry, &mut ()).unwrap();
    assert_eq!(other.iterations, 20);
}

/// A device that is lost at the call with this number.
struct Lost {
    device: OnGpu,
    left: AtomicUsize,
}

impl Lost {
    fn call(&self) {
        if self.left.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.device.gpu().give_up();
        }
    }
}

impl Populations for Lost {
    fn name(&self) -> String {
        self.device.name()
    }
    fn check(&self, asked: &Batch, by: Option<Wanted>) -> Result<(), Refused> {
        self.device.check(asked, by)
    }
    fn rollouts(&self, asked: &[Batch]) -> Result<Vec<Vec<Trajectory<f64>>>, Refused> {
        self.call();
        self.device.rollouts(asked)
    }
    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused> {
        self.call();
        self.device.gradients(asked)
    }
}

#[test]
fn a_run_goes_on_after_its_device_is_lost() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let plan = plan(scene(""), 2);
    let device = Lost {
        device: OnGpu::new(gpu, None).unwrap(),
        left: AtomicUsize::new(10),
    };
    let lost = optimise_on(Some(Arc::new(device)), &run, &plan, &mut ()).unwrap_err();
    println!("{lost}");
    assert_eq!(lost.exit_code(), 75);
    let says = lost.to_string();
    for words in ["the GPU stopped working", "cosmic resume", "--device gpu"] {
        assert!(says.contains(words), "{says}");
    }
    let registry = plan.scene.registry();
    let begun = history::read(&run.join("starts/0"), 1).unwrap();
    assert!(!begun.is_empty(), "nothing was saved");
    assert_eq!(resume(&run, registry, &mut ()).unwrap().iterations, 20);
}

/// A population that does not fit is divided. Its results stay the same, because members do not depend on one another.
#[test]
fn a_large_population_is_divided() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut plan = plan(scene(""), 4);
    plan.iterations = 4.try_into().ok();
    // 36 numbers of a state, in 96 / 10 + 12 slots, are 3 kB. So two or three members fit.
    let small = gpu.clone().with_memory(40_000);
    let parts = optimise_on(on(&small), &path("parts"), &plan, &mut ()).unwrap();
    let whole = optimise_on(on(&gpu), &path("whole"), &plan, &mut ()).unwrap();
    assert_eq!(medians(&parts), medians(&whole));
}

#[test]
fn what_a_device_cannot_run_is_refused_before_the_run() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (setting, words) in [
        ("gradient.precision=f64", "double precision"),
        ("physics.integrator=implicit", "solves linear equations"),
    ] {
        let scene = scene("").set(&[setting.to_owned()]).unwrap();
        let run = folder.path().join("run");
        let refused = optimise_on(on(&gpu), &run, &plan(scene.clone(), 2), &mut ()).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
        assert_eq!(refused.exit_code(), 2);
        assert!(!run.exists(), "a refused run has written");
        CoDesign::new(&scene).unwrap();
    }
}
