//! What a step of the robot costs: rollouts of 6x6 nodes over 4096 steps in f64 and f32, plain
//! and with gradients. Criterion's throughput is steps per second, of all rollouts where there are
//! eight; `two_matvecs` is the yardstick, and `matvecs_of_eight_controllers` what would be left of
//! it if the eight had a controller each.

use std::hint::black_box;
use std::time::Duration;

use autodiff::Real;
use autodiff::simd::{Lane, Vectorized};
use cosmic::case::Case;
use cosmic::inputs::{CONTROLLER, DESIGN};
use cosmic::scene::Scene;
use cosmic_lab::verify::{Subject, TwoMatvecs};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};

/// A mixture of all materials on every edge, and a layout that is one-hot: its gradient by the
/// design is the one by the mixture.
const SCENES: [(&str, &str); 2] = [("mixture", "stability"), ("one_hot", "baseline_tall")];

/// Weights and inputs of eight controllers' two matrices, side by side.
struct EightControllers {
    weights: Vec<f64>,
    inputs: Vec<f64>,
}

/// Numbers of a controller's matrices, and of the longer of its vectors.
const WEIGHTS: usize = 32 * 146 + 110 * 32;
const INPUTS: usize = 146;

/// All products, as sums over eight weights: every one is read for one multiplication.
impl Vectorized<f64> for &EightControllers {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> f64 {
        let mut sums = [L::zero(); 8];
        for (weights, x) in
            (self.weights.chunks_exact(8 * 8)).zip(self.inputs.chunks_exact(8).cycle())
        {
            for k in 0..8 {
                for lane in (0..8).step_by(L::N) {
                    sums[k] = L::load(&weights[k * 8 + lane..]).fma(L::load(&x[lane..]), sums[k]);
                }
            }
        }
        let mut total = [0.0; 8];
        L::sum(&sums).store(&mut total);
        total[0]
    }
}

fn rollouts(criterion: &mut Criterion) {
    for (name, scene) in SCENES {
        let scene = Scene::load(scene).expect("the scene is built in");
        let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
        let subject = Subject::new(&case, &scene.loss);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(subject.steps() as u64));
        in_type::<f64>(&mut group, "", &subject);
        in_type::<f32>(&mut group, "f32_", &subject);
        if case.frozen.is_some() {
            group.bench_function("value_and_own_gradient", |b| {
                b.iter(|| black_box(subject.own_gradient::<f64>()));
            });
        }
        group.throughput(Throughput::Elements(8 * subject.steps() as u64));
        group.bench_function("eight_starts", |b| b.iter(|| black_box(subject.rollouts())));
        group.throughput(Throughput::Elements(subject.steps() as u64));
        let matvecs = TwoMatvecs::new(&case);
        let steps = subject.steps();
        group.bench_function("two_matvecs", |b| b.iter(|| black_box(matvecs.run(steps))));
        group.finish();
    }
    let eight = EightControllers {
        weights: vec![0.1; 8 * WEIGHTS],
        inputs: vec![0.1; 8 * INPUTS],
    };
    let mut group = criterion.benchmark_group("products");
    group.throughput(Throughput::Elements(8));
    group.bench_function("matvecs_of_eight_controllers", |b| {
        b.iter(|| f64::vectorize(black_box(&eight)));
    });
    group.finish();
}

/// The rollout and its gradients in one number type.
fn in_type<R: Real>(group: &mut BenchmarkGroup<WallTime>, prefix: &str, subject: &Subject) {
    group.bench_function(format!("{prefix}rollout"), |b| {
        b.iter(|| black_box(subject.rollout::<R>()));
    });
    for (block, wanted) in [("controller", CONTROLLER), ("design", DESIGN)] {
        group.bench_function(format!("{prefix}value_and_{block}_gradient"), |b| {
            b.iter(|| black_box(subject.gradient::<R>(wanted)));
        });
    }
}

fn settings() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(4))
        .sample_size(30)
}

criterion_group! {
    name = benches;
    config = settings();
    targets = rollouts
}
criterion_main!(benches);
