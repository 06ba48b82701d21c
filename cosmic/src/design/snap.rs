//! The hard snap: one material per edge, within the volume bounds.

use super::{Material, dominant};
use crate::lattice::EdgeRules;
use crate::scene::VolumeSettings;

/// Bounds on the volume fractions, each `[least, most]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBounds {
    /// On the share of solid edges, skeleton and actuator.
    pub solid: [f64; 2],
    /// On the share of actuators.
    pub actuator: [f64; 2],
}

impl VolumeBounds {
    /// The bounds of a scene, each limit moved outwards by `slack`.
    pub fn widened(settings: &VolumeSettings, slack: f64) -> Self {
        let widen = |[least, most]: [f64; 2]| [least - slack, most + slack];
        Self {
            solid: widen(settings.solid),
            actuator: widen(settings.actuator),
        }
    }
}

/// Gives every edge the material of its largest entry; then, while the volumes are out of bounds,
/// flips the edge that is least confident among those whose flip brings them nearer. Tied edges
/// are flipped together, and no edge to what the rules do not allow: then the volumes may stay out
/// of bounds.
///
/// Volumes of a one-hot layout are whole numbers of edges: where no whole number is within the
/// bounds, the nearest one to their middle is taken.
pub fn snap(mixture: &[[f64; 3]], bounds: &VolumeBounds, rules: &EdgeRules) -> Vec<Material> {
    let mut materials: Vec<Material> = mixture.iter().map(dominant).collect();
    let counts = Counts::new(bounds, mixture.len());
    let groups = rules.groups(mixture.len());
    loop {
        let present = solid_and_actuators(&materials);
        let is_nearer = |flip: &Flip| counts.excess(flip.counted(present)) < counts.excess(present);
        let cost = |edge: usize, from: Material, to: Material| {
            Some(mixture[edge][from as usize] - mixture[edge][to as usize])
        };
        let flips = flips_of(&groups, &materials, rules, &cost);
        let flip = flips
            .into_iter()
            .filter(is_nearer)
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(flip) = flip else { return materials };
        materials = flip.on(&materials);
    }
}

/// A change of one edge, or of edges that are tied together.
struct Flip<'g> {
    group: &'g [usize],
    from: Material,
    to: Material,
    cost: f64,
}

impl Flip<'_> {
    /// A layout after the change.
    fn on(&self, layout: &[Material]) -> Vec<Material> {
        let mut layout = layout.to_vec();
        self.group.iter().for_each(|&edge| layout[edge] = self.to);
        layout
    }

    /// The numbers of solid edges and of actuators after the change.
    fn counted(&self, [solid, actuators]: [usize; 2]) -> [usize; 2] {
        let many = |is: bool| if is { self.group.len() } else { 0 };
        let is_actuator = |m| many(m == Material::Actuator);
        [
            solid + many(self.to.is_solid()) - many(self.from.is_solid()),
            actuators + is_actuator(self.to) - is_actuator(self.from),
        ]
    }
}

/// Every change of a layout that the rules allow and that has a cost. The cost of a group is that of all
/// of its edges, which are of one material.
fn flips_of<'g>(
    groups: &'g [Vec<usize>],
    layout: &[Material],
    rules: &EdgeRules,
    cost: &impl Fn(usize, Material, Material) -> Option<f64>,
) -> Vec<Flip<'g>> {
    let flip = |group: &'g [usize], to: Material| {
        let from = layout[group[0]];
        let may = from != to && rules.allow(group[0], to.is_solid());
        let costs = || group.iter().map(|&edge| cost(edge, from, to));
        let cost = costs().reduce(|a, b| Some(a? + b?)).flatten();
        let cost = cost.filter(|_| may)?;
        Some(Flip {
            group,
            from,
            to,
            cost,
        })
    };
    let of_group = |group: &'g Vec<usize>| Material::ALL.map(|to| flip(group, to));
    groups.iter().flat_map(of_group).flatten().collect()
}

/// The number of edges whose material is not that of their largest entry.
pub fn flips(mixture: &[[f64; 3]], materials: &[Material]) -> usize {
    let flipped = |(m, row): &(&Material, &[f64; 3])| **m != dominant(row);
    materials.iter().zip(mixture).filter(flipped).count()
}

/// Least share of an edge's mixture that makes a material an alternative there. One that is held
/// down (`projection.hold_materials`) has some 1e-9.
const LEAST_SHARE: f64 = 1e-3;

/// Layouts that differ from a snapped one in one edge, those of the least confidence first; none
/// that is further out of bounds, and none of a material that has no share in its edge.
pub fn alternatives<'a>(
    mixture: &[[f64; 3]],
    materials: &'a [Material],
    bounds: &VolumeBounds,
    rules: &EdgeRules,
) -> impl Iterator<Item = Vec<Material>> + 'a {
    flipped(materials, bounds, rules, |edge, from, to| {
        let [from, to] = [from, to].map(|m| mixture[edge][m as usize]);
        (to >= LEAST_SHARE).then_some(from - to)
    })
}

/// Layouts that differ from another in one edge, or in edges that are tied together, and are no further
/// out of bounds, those of the least cost first. `cost` is asked what it costs to change an edge from
/// its material to another one; where it gives none, that change is ruled out.
pub fn flipped<'a>(
    materials: &'a [Material],
    bounds: &VolumeBounds,
    rules: &EdgeRules,
    cost: impl Fn(usize, Material, Material) -> Option<f64>,
) -> impl Iterator<Item = Vec<Material>> + 'a {
    let counts = Counts::new(bounds, materials.len());
    let present = solid_and_actuators(materials);
    let is_no_further =
        |flip: &Flip| counts.excess(flip.counted(present)) <= counts.excess(present);
    let groups = rules.groups(materials.len());
    let flips = flips_of(&groups, materials, rules, &cost);
    let mut flips: Vec<_> = flips.into_iter().filter(is_no_further).collect();
    flips.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let changes: Vec<_> = (flips.iter().map(|flip| (flip.group.to_vec(), flip.to))).collect();
    changes.into_iter().map(|(group, to)| {
        let mut layout = materials.to_vec();
        group.into_iter().for_each(|edge| layout[edge] = to);
        layout
    })
}

/// How many edges of a layout are solid, and how many are actuators.
fn solid_and_actuators(layout: &[Material]) -> [usize; 2] {
    let count = |is: fn(Material) -> bool| layout.iter().filter(|&&m| is(m)).count();
    [
        count(Material::is_solid),
        count(|m| m == Material::Actuator),
    ]
}

/// The volume bounds in whole edges.
struct Counts {
    solid: [usize; 2],
    actuator: [usize; 2],
}

impl Counts {
    fn new(bounds: &VolumeBounds, edges: usize) -> Self {
        let whole = |bounds: [f64; 2]| {
            // 0.03 * 100 is not 3: a bound that a whole number meets to rounding is met.
            let slack = 1e-9;
            let [least, most] = bounds.map(|share| share * edges as f64);
            let inside =
                [(least - slack).ceil(), (most + slack).floor()].map(|n| n.max(0.0) as usize);
            if inside[0] <= inside[1] {
                inside
            } else {
                [(0.5 * (least + most) - 0.5).ceil().max(0.0) as usize; 2]
            }
        };
        Self {
            solid: whole(bounds.solid),
            actuator: whole(bounds.actuator),
        }
    }

    /// How many edges too many or too few there are, solid and actuators together.
    fn excess(&self, [solid, actuators]: [usize; 2]) -> usize {
        let outside =
            |n: usize, [least, most]: [usize; 2]| least.saturating_sub(n) + n.saturating_sub(most);
        outside(solid, self.solid) + outside(actuators, self.actuator)
    }
}

#[cfg(test)]
mod tests {
    use super::{VolumeBounds, alternatives, flips, snap};
    use crate::design::Material::{self, Actuator, Skeleton, Void};
    use crate::lattice::EdgeRules;
    use crate::scene::VolumeSettings;

    const FREE: EdgeRules = EdgeRules {
        keep: Vec::new(),
        forbid: Vec::new(),
        tie: Vec::new(),
    };
    const HALF: VolumeBounds = VolumeBounds {
        solid: [0.5, 0.5],
        actuator: [0.25, 0.25],
    };

    /// Within the bounds the largest entry decides.
    #[test]
    fn the_least_confident_edge_is_flipped_if_the_bounds_ask_for_it() {
        for (second, flipped) in [([0.4, 0.3, 0.3], 0), ([0.3, 0.4, 0.3], 1)] {
            let mixture = [[0.8, 0.1, 0.1], second, [0.1, 0.5, 0.4], [0.0, 0.4, 0.6]];
            let snapped = snap(&mixture, &HALF, &FREE);
            assert_eq!(snapped, [Void, Void, Skeleton, Actuator]);
            assert_eq!(flips(&mixture, &snapped), flipped);
        }
    }

    #[test]
    fn any_start_ends_within_the_bounds() {
        let bounds = VolumeBounds::widened(&VolumeSettings::default(), 0.03);
        for material in Material::ALL {
            let mut row = [0.2; 3];
            row[material as usize] = 0.6;
            let materials = snap(&[row; 110], &bounds, &FREE);
            let solid = materials.iter().filter(|m| m.is_solid()).count();
            let actuators = materials.iter().filter(|&&m| m == Actuator).count();
            // 0.47 and 0.53, 0.17 and 0.25 of 110 edges.
            assert!((52..=58).contains(&solid) && (19..=27).contains(&actuators));
            assert!(flips(&[row; 110], &materials) > 0);
        }
    }

    #[test]
    fn bounds_between_two_whole_numbers_take_the_nearest() {
        for (solid, edges) in [([0.5, 0.5], 2), ([0.36, 0.36], 2), ([0.56, 0.58], 3)] {
            let bounds = VolumeBounds {
                solid,
                actuator: [0.0, 1.0],
            };
            let materials = snap(&[[0.0, 1.0, 0.0]; 5], &bounds, &FREE);
            let solids = materials.iter().filter(|m| m.is_solid()).count();
            assert_eq!(solids, edges, "{solid:?} of 5 edges");
        }
    }

    #[test]
    fn alternatives_change_one_edge_the_least_confident_first() {
        let mixture = [
            [0.1, 0.9, 0.0],
            [0.6, 0.35, 0.05],
            [0.02, 0.0, 0.98],
            [0.7, 0.2, 0.1],
        ];
        let layout = [Skeleton, Void, Actuator, Void];
        let wide = VolumeBounds {
            solid: [0.25, 0.75],
            actuator: [0.25, 0.25],
        };
        let layouts: Vec<_> = alternatives(&mixture, &layout, &wide, &FREE).collect();
        let differs = |other: &Vec<Material>| {
            let pairs = other.iter().zip(&layout).enumerate();
            let changed: Vec<_> = pairs.filter(|(_, (a, b))| a != b).collect();
            assert_eq!(changed.len(), 1);
            (changed[0].0, *changed[0].1.0)
        };
        let found: Vec<_> = layouts.iter().map(differs).collect();
        // No flip to or from an actuator: there has to be just one.
        assert_eq!(found, [(1, Skeleton), (3, Skeleton), (0, Void)]);
        assert_eq!(alternatives(&mixture, &layout, &HALF, &FREE).count(), 0);
        // Without a share in its edge, void is no alternative.
        let mut held = mixture;
        held[0] = [1e-9, 1.0 - 1e-9, 0.0];
        let found: Vec<_> = alternatives(&held, &layout, &wide, &FREE)
            .map(|l| differs(&l))
            .collect();
        assert_eq!(found, [(1, Skeleton), (3, Skeleton)]);
    }

    /// Edges that are tied change together, and no edge to what it may not be, however little it costs.
    #[test]
    fn flips_keep_to_the_rules_of_edges() {
        let rules = EdgeRules {
            keep: vec![0],
            forbid: vec![1],
            tie: vec![vec![2, 3]],
        };
        let mixture = [
            [0.49, 0.51, 0.0],
            [0.51, 0.49, 0.0],
            [0.1, 0.9, 0.0],
            [0.1, 0.9, 0.0],
        ];
        let half = VolumeBounds {
            solid: [0.25, 0.25],
            actuator: [0.0, 0.0],
        };
        assert_eq!(snap(&mixture, &half, &FREE), [Void, Void, Void, Skeleton]);
        assert_eq!(snap(&mixture, &half, &rules), [Skeleton, Void, Void, Void]);
        let any = VolumeBounds {
            solid: [0.0, 1.0],
            actuator: [0.0, 0.0],
        };
        let layout = [Skeleton, Void, Void, Void];
        let found: Vec<_> = alternatives(&mixture, &layout, &any, &rules).collect();
        assert_eq!(found, [[Skeleton, Void, Skeleton, Skeleton]]);
        assert_eq!(alternatives(&mixture, &layout, &any, &FREE).count(), 4);
    }
}
