//! Properties that hold for every design: of projections, of measures, and of the snap, which gives every edge one
//! material.

use cosmic::design::{LayoutRules, Material, Mixture, Structure, VolumeBounds, snap};
use cosmic::lattice::Lattice;
use cosmic::objective::measures;
use cosmic::projection::{MixtureLimits, Projection, mixtures};
use cosmic::scene::{DesignSettings, ProjectionSettings, Scene, VolumeSettings};
use proptest::prelude::*;

fn vectors(entries: std::ops::Range<f64>) -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(prop::array::uniform3(entries), 1..40)
}

const BOTH: [Projection; 2] = [Projection::Performance, Projection::Stability];

/// The largest absolute difference between the shares of corresponding mixtures in two lists.
fn largest_change(a: &[Mixture<f64>], b: &[Mixture<f64>]) -> f64 {
    let shares = |of: &[Mixture<f64>]| of.iter().flat_map(|m| m.0).collect::<Vec<_>>();
    let pairs = shares(a).into_iter().zip(shares(b));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The three shares of a mixture add up to one, even for design vectors far outside the optimiser's range.
    #[test]
    fn the_shares_of_a_mixture_add_up_to_one(z in prop_oneof![vectors(0.0..1.0), vectors(-1e6..1e6)]) {
        for projection in BOTH {
            for Mixture(row) in mixtures(projection, &z, &ProjectionSettings::default(), &MixtureLimits::default()) {
                prop_assert!(row.iter().all(|m| (0.0..=1.0).contains(m)), "{:?}", row);
                // The sum has the rounding errors of three quotients and two additions.
                prop_assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{:?}", row);
            }
        }
    }

    /// The performance projection depends only on differences between the entries of the same edge: adding a number to
    /// all entries of an edge has no effect. The stability projection depends only on differences between edges: adding
    /// a vector to the entries of all edges has no effect.
    #[test]
    fn common_shifts_have_no_effect(
        z in vectors(0.0..1.0),
        shift in -1.0..1.0,
        column in prop::array::uniform3(-1.0..1.0),
    ) {
        let settings = ProjectionSettings::default();
        let shifted: Vec<[f64; 3]> = z.iter().map(|z| z.map(|z| z + shift)).collect();
        let [a, b] = [&z, &shifted].map(|z| mixtures(Projection::Performance, z, &settings, &MixtureLimits::default()));
        // Shifted entries near 2 are rounded at 2e-16, and a sharpness of 20 multiplies the error.
        prop_assert!(largest_change(&a, &b) < 1e-14);
        let moved = |z: &[f64; 3]| [0, 1, 2].map(|k| z[k] + column[k]);
        let shifted: Vec<[f64; 3]> = z.iter().map(moved).collect();
        let [a, b] = [&z, &shifted].map(|z| mixtures(Projection::Stability, z, &settings, &MixtureLimits::default()));
        // The means of 40 numbers have errors of about 1e-15, and a sharpness of 500 multiplies them.
        prop_assert!(largest_change(&a, &b) < 1e-11);
    }

    #[test]
    fn volumes_and_measures_keep_their_ranges(z in vectors(0.0..1.0)) {
        let settings = ProjectionSettings::default();
        for projection in BOTH {
            let found = measures(&mixtures(projection, &z, &settings, &MixtureLimits::default()), settings.delta);
            let rounding = 1e-14;
            let within = |x: f64, most: f64| (-rounding..=most + rounding).contains(&x);
            prop_assert!(within(found.volume, 1.0) && within(found.actuator_volume, 1.0));
            prop_assert!(found.actuator_volume <= found.volume + rounding);
            // The binarisation measure is largest for three equal shares, the overlap for two equal shares.
            prop_assert!(within(found.binarisation, 1.0 - (1.0f64 / 3.0).sqrt()));
            prop_assert!(found.overlap.iter().all(|&g| within(g, 0.5)));
        }
    }

    /// After a snap every edge has one material, the volumes are within the bounds, and the robot is in one piece if
    /// the scene requires it.
    #[test]
    fn a_snap_meets_the_volumes(
        z in prop::collection::vec(prop::array::uniform3(0.0..1.0), 110),
        one_piece in prop::bool::ANY,
    ) {
        let settings = ProjectionSettings::default();
        let scene = Scene::paper();
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let asked = DesignSettings { one_piece, ..scene.design };
        let rules = LayoutRules::new(&lattice, &asked);
        let bounds = VolumeBounds::widened(&VolumeSettings::default(), 0.03);
        let found = snap(&mixtures(Projection::Performance, &z, &settings, &MixtureLimits::default()), &bounds, &rules);
        let edges = z.len() as f64;
        let share = |is: fn(Material) -> bool| {
            found.iter().filter(|m| is(**m)).count() as f64 / edges
        };
        prop_assert_eq!(found.len(), z.len());
        if one_piece {
            prop_assert_eq!(Structure::new(&lattice, &found).pieces, 1);
        }
        prop_assert!(bounds.solid.widened(1e-9).contains(share(Material::is_solid)));
        prop_assert!(bounds.actuator.widened(1e-9).contains(share(|m| m == Material::Actuator)));
    }
}
