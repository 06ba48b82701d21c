use cosmic::design::{Design, Material};
use cosmic::geometry::{Range, Vector};
use cosmic::lattice::{Lattice, State};
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::walk::{self, BarLoad, Largest, Loads, Magnitude};
use cosmic::world::{Trajectory, World};

#[test]
fn a_magnitude_has_the_peak_and_the_99_percent_quantile() {
    let of = |sample: &[f64]| {
        let mut largest = Largest::of(sample.len());
        sample.iter().for_each(|x| largest.see(*x));
        // The list holds less than twice the needed values. Those are a hundredth of the series, rounded up, plus
        // one.
        assert!(largest.values.len() <= sample.len() / 50 + 4);
        largest.magnitude()
    };
    let (peak, p99) = (100.0, 99.0);
    let falling: Vec<f64> = (0..=100).map(|k| f64::from(k) - 100.0).collect();
    assert_eq!(of(&falling), Magnitude { peak, p99 });
    assert_eq!(of(&[]), Magnitude::default());
    assert_eq!(
        of(&[-2.0]),
        Magnitude {
            peak: 2.0,
            p99: 2.0
        }
    );
    // The collected magnitude must be that of the whole series, which is sorted here.
    for count in [2, 51, 149, 150, 151, 1000, 8193] {
        let sample: Vec<f64> = (0..count).map(|k| (1.7 * k as f64).sin()).collect();
        let mut sorted: Vec<f64> = sample.iter().map(|x| x.abs()).collect();
        sorted.sort_by(f64::total_cmp);
        let place = (0.99 * (count - 1) as f64).round() as usize;
        let (peak, p99) = (sorted[count - 1], sorted[place]);
        assert_eq!(of(&sample), Magnitude { peak, p99 }, "{count}");
    }
}

/// The loads of a stretched lattice agree with Hooke's law. The lattice is 10 % longer along x than at rest, and
/// its length grows by 1 m/s per metre.
#[test]
fn loads_are_those_of_hooke_s_bars() {
    let scene = Scene::paper();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let layout = vec![Material::Skeleton; lattice.edges.len()];
    let design = Design::Layout(layout.clone());
    let controller = Controller::xavier(&scene.controller, &lattice, 1);
    let (world, rest) = (World::new(lattice.clone(), &scene), lattice.state_at_rest());
    let robot = world.robot(world.body(&design), controller, &rest);
    let stretched = State::new(
        rest.x.iter().map(|x| *x + x.along() * 0.1),
        rest.x.iter().map(|x| x.along() * 1.1),
    );
    let trajectory = Trajectory::new(vec![0, 16], vec![rest, stretched]);
    let moments = walk::moments(&world, &robot, &trajectory);
    let edges = 0..lattice.edges.len();
    let loads: Vec<BarLoad> = edges.map(|edge| BarLoad::of(edge, &moments)).collect();
    for (load, &[i, j]) in loads.iter().zip(&lattice.edges) {
        let [dx, dy] = lattice.direction([i, j]).map(f64::abs).in_plane();
        if dy == 0.0 {
            // The extension of 10 mm times 400 N/m is the tension; the speed is 0.11 m/s. The softening changes
            // lengths by a fraction of 5e-11.
            assert!((load.strain.peak - 0.1).abs() < 1e-9, "{load:?}");
            assert!((load.tension - 4.0).abs() < 1e-7 && load.compression < 1e-7);
            assert!((load.speed.peak - 0.11).abs() < 1e-9);
            assert!((load.power.peak - 0.44).abs() < 1e-7);
        } else if dx == 0.0 {
            assert!(load.force.peak < 1e-7 && load.speed.peak < 1e-9);
        }
    }
    let bars: Vec<_> = loads.into_iter().map(Some).collect();
    let all = Loads::of(&world, &layout, &bars, &trajectory);
    assert_eq!(all.strains, Range::default());
    assert_eq!((all.tangled, all.tangles), (0.0, 0.0));
    // In one of two states, half of the robot is folded over the other half.
    let mut folded = trajectory.clone();
    let middle = 0.25;
    let fold = |x: &mut Vector<f64>| {
        *x = Vector::from([middle + 0.37 * (x.forward() - middle).abs(), x.up()]);
    };
    folded.states[1].x.iter_mut().for_each(fold);
    folded.states[1]
        .x
        .iter_mut()
        .enumerate()
        .for_each(|(k, x)| *x += Vector::upright(0.0, 1e-3 * k as f64));
    let all = Loads::of(&world, &layout, &bars, &folded);
    assert!(all.tangled == 0.5 && all.tangles > 1.0, "{all:?}");
}
