//! What a step of the robot costs: rollouts of 6x6 nodes over 4096 steps in f64, plain and with
//! gradients. Criterion's throughput is steps per second; `two_matvecs` is the yardstick.

use std::hint::black_box;
use std::time::Duration;

use cosmic::case::Case;
use cosmic::gradient::{CONTROLLER, DESIGN};
use cosmic::scene::Scene;
use cosmic::verify::{Subject, TwoMatvecs};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A mixture of all materials on every edge, and a layout that is one-hot: frozen, it has no
/// gradient by the design.
const SCENES: [(&str, &str); 2] = [("mixture", "stability"), ("one_hot", "baseline_tall")];

fn rollouts(criterion: &mut Criterion) {
    for (name, scene) in SCENES {
        let scene = Scene::load(scene).expect("the scene is built in");
        let case = Case::of_scene(&scene, 0).expect("a built-in scene is complete");
        let subject = Subject::new(&case, &scene.loss);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(subject.steps() as u64));
        group.bench_function("rollout", |b| b.iter(|| black_box(subject.rollout())));
        let blocks = [("controller", CONTROLLER), ("design", DESIGN)];
        let some = if case.frozen.is_some() { 1 } else { 2 };
        for &(block, wanted) in &blocks[..some] {
            let id = format!("value_and_{block}_gradient");
            group.bench_function(id, |b| b.iter(|| black_box(subject.gradient(wanted))));
        }
        let matvecs = TwoMatvecs::new(&case);
        let steps = subject.steps();
        group.bench_function("two_matvecs", |b| b.iter(|| black_box(matvecs.run(steps))));
        group.finish();
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
