//! What a step of the robot costs: rollouts of 6x6 nodes over 4096 steps in f64 and f32, plain
//! and with gradients. Criterion's throughput is steps per second; `two_matvecs` is the yardstick.

use std::hint::black_box;
use std::time::Duration;

use autodiff::Real;
use cosmic::case::Case;
use cosmic::gradient::{CONTROLLER, DESIGN};
use cosmic::scene::Scene;
use cosmic::verify::{Subject, TwoMatvecs};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};

/// A mixture of all materials on every edge, and a layout that is one-hot: its gradient by the
/// design is the one by the mixture.
const SCENES: [(&str, &str); 2] = [("mixture", "stability"), ("one_hot", "baseline_tall")];

fn rollouts(criterion: &mut Criterion) {
    for (name, scene) in SCENES {
        let scene = Scene::load(scene).expect("the scene is built in");
        let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
        let subject = Subject::new(&case, &scene.loss);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(subject.steps() as u64));
        in_type::<f64>(&mut group, "", &subject);
        in_type::<f32>(&mut group, "f32_", &subject);
        let matvecs = TwoMatvecs::new(&case);
        let steps = subject.steps();
        group.bench_function("two_matvecs", |b| b.iter(|| black_box(matvecs.run(steps))));
        group.finish();
    }
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
