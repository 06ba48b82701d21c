use crate::small::lattice;
use cosmic::design::Material::{Actuator, Skeleton, Void};
use cosmic::design::{
    LayoutRules, Material, Mixture, VolumeBounds, alternatives, flips, snap,
    solid_and_actuators as counts,
};
use cosmic::geometry::{Range, Vector};
use cosmic::lattice::{EdgeRules, Lattice, Payload};
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::scene::{DesignSettings, VolumeSettings};

/// The layout rules for a chain of edges: the given rules for its edges, and no other requirements.
fn ruled(rules: &EdgeRules, edges: usize) -> LayoutRules {
    let nodes = (0..=edges).map(|k| Vector::from([k as f64, 0.0])).collect();
    let mut chain = Lattice::between(nodes, (0..edges).map(|k| [k, k + 1]).collect());
    chain.rules = rules.clone();
    LayoutRules::new(&chain, &LOOSE)
}

const ONE_PIECE: DesignSettings = DesignSettings {
    one_piece: true,
    free_ends: true,
    crossings: true,
    feet: 0,
};

const LOOSE: DesignSettings = DesignSettings {
    one_piece: false,
    ..ONE_PIECE
};

fn free(edges: usize) -> LayoutRules {
    ruled(&EdgeRules::default(), edges)
}

const HALF: VolumeBounds = bounds([0.5, 0.5], [0.25, 0.25]);

const fn bounds(solid: [f64; 2], actuator: [f64; 2]) -> VolumeBounds {
    VolumeBounds {
        solid: Range::new(solid[0], solid[1]),
        actuator: Range::new(actuator[0], actuator[1]),
    }
}

/// If the dominant materials are within the bounds, nothing is flipped.
#[test]
fn the_least_confident_edge_is_flipped_if_the_bounds_require_it() {
    for (second, flipped) in [([0.4, 0.3, 0.3], 0), ([0.3, 0.4, 0.3], 1)] {
        let mixture = [[0.8, 0.1, 0.1], second, [0.1, 0.5, 0.4], [0.0, 0.4, 0.6]].map(Mixture);
        let snapped = snap(&mixture, &HALF, &free(4));
        assert_eq!(snapped, [Void, Void, Skeleton, Actuator]);
        assert_eq!(flips(&mixture, &snapped), flipped);
    }
}

#[test]
fn bounds_between_two_whole_numbers_take_the_nearest() {
    for (solid, edges) in [([0.5, 0.5], 2), ([0.36, 0.36], 2), ([0.56, 0.58], 3)] {
        let bounds = bounds(solid, [0.0, 1.0]);
        let materials = snap(&[Mixture([0.0, 1.0, 0.0]); 5], &bounds, &free(5));
        assert_eq!(counts(&materials)[0], edges, "{solid:?} of 5 edges");
    }
}

#[test]
fn alternatives_change_one_edge_the_least_confident_first() {
    let mixture = [
        [0.1, 0.9, 0.0],
        [0.6, 0.35, 0.05],
        [0.02, 0.0, 0.98],
        [0.7, 0.2, 0.1],
    ]
    .map(Mixture);
    let layout = [Skeleton, Void, Actuator, Void];
    let wide = bounds([0.25, 0.75], [0.25, 0.25]);
    let all = |mixture: &[_; 4], bounds| alternatives(mixture, &layout, bounds, &free(4), 100);
    let layouts = all(&mixture, &wide);
    let differs = |other: &Vec<Material>| {
        let pairs = other.iter().zip(&layout).enumerate();
        let changed: Vec<_> = pairs.filter(|(_, (a, b))| a != b).collect();
        assert_eq!(changed.len(), 1);
        (changed[0].0, *changed[0].1.0)
    };
    let found: Vec<_> = layouts.iter().map(differs).collect();
    // The bounds require exactly one actuator, so no flip adds or removes an actuator.
    assert_eq!(found, [(1, Skeleton), (3, Skeleton), (0, Void)]);
    assert_eq!(all(&mixture, &HALF).len(), 0);
    assert_eq!(
        alternatives(&mixture, &layout, &wide, &free(4), 2),
        layouts[..2]
    );
    // Void is no alternative for an edge in whose mixture it has no share.
    let mut held = mixture;
    held[0] = Mixture([1e-9, 1.0 - 1e-9, 0.0]);
    let found: Vec<_> = all(&held, &wide).iter().map(differs).collect();
    assert_eq!(found, [(1, Skeleton), (3, Skeleton)]);
}

/// Tied edges change together, and a forbidden flip does not happen even if it is the cheapest.
#[test]
fn flips_obey_the_rules_of_edges() {
    let rules = EdgeRules {
        keep: vec![0],
        forbid: vec![1],
        tie: vec![vec![2, 3]],
        ..EdgeRules::default()
    };
    let mixture = [
        [0.49, 0.51, 0.0],
        [0.51, 0.49, 0.0],
        [0.1, 0.9, 0.0],
        [0.1, 0.9, 0.0],
    ]
    .map(Mixture);
    let (ruled, free) = (ruled(&rules, 4), free(4));
    let quarter = bounds([0.25, 0.25], [0.0, 0.0]);
    let layout = [Skeleton, Void, Void, Void];
    assert_eq!(
        snap(&mixture, &quarter, &free),
        [Void, Void, Void, Skeleton]
    );
    assert_eq!(snap(&mixture, &quarter, &ruled), layout);
    let found = |rules| {
        alternatives(
            &mixture,
            &layout,
            &bounds([0.0, 1.0], [0.0, 0.0]),
            rules,
            100,
        )
    };
    assert_eq!(found(&ruled), [[Skeleton, Void, Skeleton, Skeleton]]);
    assert_eq!(found(&free).len(), 4);
}

/// Random mixtures snap to layouts that are in one piece and within the bounds. The same holds for the alternatives
/// of these layouts.
#[test]
fn any_mixture_snaps_to_one_piece_within_the_bounds() {
    let lattice = lattice(6, 6, 0.0);
    let rules = LayoutRules::new(&lattice, &ONE_PIECE);
    let bounds = VolumeBounds::widened(&VolumeSettings::default(), 0.03);
    let mut draws = stream(7, Purpose::Judgement);
    let mut torn = 0;
    for solid in [0.3, 0.5, 0.7] {
        for _ in 0..20 {
            let mut row = || {
                let mut draw = || 0.5 + symmetric(&mut draws, 0.5);
                let (void, split) = (draw() + 0.5 - solid, draw());
                let void = void.clamp(0.0, 1.0);
                Mixture([void, (1.0 - void) * split, (1.0 - void) * (1.0 - split)])
            };
            let mixture: Vec<_> = lattice.edges.iter().map(|_| row()).collect();
            let dominant: Vec<_> = mixture.iter().map(Mixture::dominant).collect();
            torn += usize::from(rules.faults(&dominant) > 0);
            let snapped = snap(&mixture, &bounds, &rules);
            let [solid, actuators] = counts(&snapped).map(|n| n as f64 / 110.0);
            assert_eq!(rules.faults(&snapped), 0);
            assert!((0.47..=0.53).contains(&solid) && (0.17..=0.25).contains(&actuators));
            let others = alternatives(&mixture, &snapped, &bounds, &rules, 50);
            assert!(!others.is_empty() && others.iter().all(|other| rules.faults(other) == 0));
        }
    }
    assert!(torn > 30, "{torn} of 60 mixtures need it");
}

/// The alternatives of random layouts are the flips that a count of all faults and volumes finds to be no worse, whatever the
/// scene requires of a layout.
#[test]
fn flips_are_judged_as_by_counting_everything_again() {
    let mut lattice = lattice(4, 3, 0.0);
    lattice.payload.push(Payload {
        node: 7,
        mass: None,
    });
    let any = bounds([0.3, 0.6], [0.1, 0.3]);
    let edges = lattice.edges.len();
    let excess = |layout: &[Material]| {
        let share = |n: usize| n as f64 / edges as f64;
        let outside = |n: usize, range: Range| {
            let below = (0..edges).filter(|k| *k >= n && share(*k) < range.low - 1e-9);
            let above = (0..=edges).filter(|k| *k <= n && share(*k) > range.high + 1e-9);
            below.count() + above.count()
        };
        let [solid, actuators] = counts(layout);
        outside(solid, any.solid) + outside(actuators, any.actuator)
    };
    let mut draws = stream(3, Purpose::Judgement);
    let mut found = 0;
    for number in 0..120 {
        let bit = |k: u32| number >> k & 1 == 1;
        let asked = DesignSettings {
            one_piece: bit(0),
            free_ends: bit(1),
            crossings: bit(2),
            feet: if bit(3) { 3 } else { 0 },
        };
        let rules = LayoutRules::new(&lattice, &asked);
        let mut draw = || 0.5 + symmetric(&mut draws, 0.5);
        let material = |x: f64| Material::ALL[(3.0 * x * 0.999) as usize];
        let layout: Vec<_> = (0..edges).map(|_| material(draw())).collect();
        let mixtures = vec![Mixture([1.0 / 3.0; 3]); edges];
        let no_worse = |flipped: &[Material]| {
            rules.faults(flipped) <= rules.faults(&layout) && excess(flipped) <= excess(&layout)
        };
        let flip = |edge: usize, to: Material| {
            let mut flipped = layout.clone();
            flipped[edge] = to;
            flipped
        };
        let all = (0..edges).flat_map(|edge| Material::ALL.map(|to| flip(edge, to)));
        let expected: Vec<_> = all
            .filter(|other| *other != layout && no_worse(other))
            .collect();
        // Equal costs keep the order of the edges.
        assert_eq!(
            alternatives(&mixtures, &layout, &any, &rules, usize::MAX),
            expected,
            "{asked:?}"
        );
        found += expected.len();
    }
    assert!(found > 1000, "{found}");
}

/// An edge that must be kept, far from the payload, is connected to the payload by as few edges as possible,
/// although the mixtures of these edges are nearly void.
#[test]
fn kept_bars_are_bridged() {
    let mut lattice = lattice(6, 2, 0.0);
    let kept = lattice.edges.len() - 1;
    assert!(!lattice.edges[kept].contains(&lattice.payload[0].node));
    lattice.rules.keep = vec![kept];
    let rules = LayoutRules::new(&lattice, &ONE_PIECE);
    let any = bounds([0.0, 1.0], [0.0, 1.0]);
    let mut mixture = vec![Mixture([0.98, 0.01, 0.01]); kept];
    mixture.push(Mixture([0.0, 0.4, 0.6]));
    let snapped = snap(&mixture, &any, &rules);
    assert_eq!(rules.faults(&snapped), 0);
    assert_eq!(snapped[kept], Actuator);
    assert!(counts(&snapped)[0] <= 6);
}

/// Where most edges are void, removing one free end makes another one. Bars are added then, instead of removing all of them.
#[test]
fn free_ends_do_not_eat_the_whole_robot() {
    let lattice = lattice(4, 4, 0.0);
    let asked = DesignSettings {
        free_ends: false,
        ..ONE_PIECE
    };
    let rules = LayoutRules::new(&lattice, &asked);
    let half = bounds([0.45, 0.55], [0.1, 0.3]);
    let mut draws = stream(5, Purpose::Judgement);
    for _ in 0..20 {
        let mut draw = || symmetric(&mut draws, 0.05);
        let mut mixture = || Mixture([0.4, 0.3 + draw(), 0.3 + draw()]);
        let mixtures: Vec<_> = lattice.edges.iter().map(|_| mixture()).collect();
        let snapped = snap(&mixtures, &half, &rules);
        let edges = lattice.edges.len() as f64;
        let [solid, actuators] = counts(&snapped).map(|n| n as f64 / edges);
        assert_eq!(rules.faults(&snapped), 0);
        assert!((0.45..=0.55).contains(&solid), "{solid}");
        assert!((0.1..=0.3).contains(&actuators), "{actuators}");
    }
}
