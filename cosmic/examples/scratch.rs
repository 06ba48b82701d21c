use autodiff::{Real, Tape, Var};
use cosmic::controller::Controller;
use cosmic::lattice::{Ground, Lattice};
use cosmic::projection::{Body, Projection, mixture};
use cosmic::scene::Scene;
use cosmic::simulator::{Simulator, Span};
use std::time::Instant;

fn main() {
    let scene = Scene::default();
    let ground = Ground::from(&scene.physics);
    let lattice = Lattice::new(&scene.lattice, &ground);
    let sim = Simulator::new(&lattice, &scene.physics, &scene.controller);
    let controller = Controller::xavier(&scene.controller, &lattice, 0);
    let z: Vec<[f64; 3]> = vec![[0.3, 0.35, 0.33]; lattice.edges.len()];
    let steps = 4096;
    let observed: Vec<usize> = (0..=128).map(|k| 2048 + 16 * k).collect();
    fn loss<R: Real>(t: &cosmic::simulator::Trajectory<R>) -> R {
        let v: Vec<R> = t.states.iter().map(|s| -s.x[0][0]).collect();
        R::sum(&v)
    }
    for _ in 0..6 {
        let t = Instant::now();
        let mix = mixture(Projection::Performance, &z, &scene.projection);
        let body = Body::new(&mix, &lattice, &scene.materials, &scene.physics);
        let tr = sim.rollout(
            (&body, &controller),
            &lattice.state_at_rest(),
            &Span::from_start(observed.clone()),
        );
        let f = t.elapsed().as_secs_f64() / steps as f64 * 1e6;
        let plain = loss(&tr);
        let t = Instant::now();
        let mut tape = Tape::<f64>::new();
        let zf: Vec<f64> = z.iter().flatten().copied().collect();
        let (v, g) = vg(&mut tape, &zf, |z: &[Var<f64>]| {
            let z: Vec<[Var<f64>; 3]> = z.as_chunks::<3>().0.to_vec();
            let mix = mixture(Projection::Performance, &z, &scene.projection);
            let body = Body::new(&mix, &lattice, &scene.materials, &scene.physics);
            let tr = sim.rollout(
                (&body, &controller.lift()),
                &lattice.state_at_rest().lift(),
                &Span::from_start(observed.clone()),
            );
            loss(&tr)
        });
        let d = t.elapsed().as_secs_f64() / steps as f64 * 1e6;
        let t = Instant::now();
        let w: Vec<f64> = [
            &controller.w1[..],
            &controller.b1,
            &controller.w2,
            &controller.b2,
        ]
        .concat();
        let mut tape = Tape::<f64>::new();
        let (v2, g2) = vg(&mut tape, &w, |w: &[Var<f64>]| {
            let (w1, r) = w.split_at(controller.w1.len());
            let (b1, r) = r.split_at(controller.b1.len());
            let (w2, b2) = r.split_at(controller.w2.len());
            let c = Controller {
                hidden: controller.hidden,
                inputs: controller.inputs,
                w1: w1.to_vec(),
                b1: b1.to_vec(),
                w2: w2.to_vec(),
                b2: b2.to_vec(),
            };
            let z: Vec<[Var<f64>; 3]> = z.iter().map(|z| z.map(Var::lit)).collect();
            let mix = mixture(Projection::Performance, &z, &scene.projection);
            let body = Body::new(&mix, &lattice, &scene.materials, &scene.physics);
            let tr = sim.rollout(
                (&body, &c),
                &lattice.state_at_rest().lift(),
                &Span::from_start(observed.clone()),
            );
            loss(&tr)
        });
        let c = t.elapsed().as_secs_f64() / steps as f64 * 1e6;
        println!(
            "{f:.3} {d:.3} {c:.3} us/step  {plain} {v} {v2} {} {}",
            g[5], g2[7]
        );
    }
}

fn vg(tape: &mut Tape<f64>, x: &[f64], f: impl FnOnce(&[Var<f64>]) -> Var<f64>) -> (f64, Vec<f64>) {
    let y = tape.record(x, f);
    let g = tape.pullback(&[y], &[1.0])[..x.len()].to_vec();
    (y.value(), g)
}
