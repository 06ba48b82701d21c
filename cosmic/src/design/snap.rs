//! The snap: gives every edge one material, within the volume bounds.

use super::structure::Faults;
use super::{LayoutRules, Material, Mixture};
use crate::geometry::Range;
use crate::lattice::EdgeRules;
use crate::scene::VolumeSettings;

/// Bounds on the volumes of a design, which are mean shares over all edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBounds {
    /// Bounds on the share of solid material, skeleton and actuator together.
    pub solid: Range,
    /// Bounds on the share of actuators.
    pub actuator: Range,
}

impl VolumeBounds {
    /// The volume bounds of a scene, widened: each lower limit is lowered by `slack`, and each upper limit is raised by
    /// `slack`.
    pub fn widened(settings: &VolumeSettings, slack: f64) -> Self {
        Self {
            solid: Range::from(settings.solid).widened(slack),
            actuator: Range::from(settings.actuator).widened(slack),
        }
    }
}

/// Gives every edge its dominant material, then flips edges (changes their materials) until the layout obeys `rules`
/// and `bounds`.
///
/// A broken rule is called a fault. Edges are flipped one after the other as long as a flip can remove a fault or bring
/// a volume nearer to its bounds. The next flip is always the cheapest of these: the one for which the old material has
/// the least lead over the new one in the edge's mixture. A flip that improves a volume must not add a fault. Tied
/// edges, which must have the same material, are flipped together. An edge never gets a material that the rules forbid
/// for it, so faults may remain and volumes may stay out of bounds. If they do, the volumes are tried first, and the better
/// layout is kept: the one with the smaller number of faults and edges out of bounds.
///
/// The bounds limit how many edges of a layout are solid and how many are actuators. If no whole number of edges is
/// within the bounds, the snap aims at the whole number nearest to the middle of the bounds.
pub fn snap(
    mixtures: &[Mixture<f64>],
    bounds: &VolumeBounds,
    rules: &LayoutRules,
) -> Vec<Material> {
    let counts = Counts::new(bounds, mixtures.len());
    let groups = rules.edges().groups(mixtures.len());
    let cost = |edge: usize, from, to| Some(mixtures[edge][from] - mixtures[edge][to]);
    let dominant: Vec<_> = mixtures.iter().map(Mixture::dominant).collect();
    let obeying = |first: First| {
        let mut materials = dominant.clone();
        // Each bridge connects at least one more piece, so there cannot be more bridges than edges.
        for _ in 0..=mixtures.len() {
            materials = mended(materials, &counts, rules, first, &groups, &cost);
            let bridge = rules.bridge(&materials);
            if bridge.is_empty() {
                break;
            }
            let is_in_bridge = |group: &&Vec<usize>| group.iter().any(|edge| bridge.contains(edge));
            for group in groups.iter().filter(is_in_bridge) {
                let [_, skeleton, actuator] = mixtures[group[0]].0;
                let solid = Material::dominant(&[f64::NEG_INFINITY, skeleton, actuator]);
                group.iter().for_each(|&edge| materials[edge] = solid);
            }
        }
        materials
    };
    let excess = |layout: &[Material]| counts.excess(solid_and_actuators(layout));
    let snapped = obeying(First::Faults);
    if excess(&snapped) == 0 {
        return snapped;
    }
    // Where few edges are solid, each free end that is removed leaves another one, until no bar is left.
    let filled = obeying(First::Volumes);
    let badness = |layout: &[Material]| rules.faults(layout) + excess(layout);
    match badness(&filled) < badness(&snapped) {
        true => filled,
        false => snapped,
    }
}

/// What the snap mends first.
#[derive(Clone, Copy, PartialEq)]
enum First {
    Faults,
    Volumes,
}

/// Repeatedly applies the cheapest flip that removes a fault, or brings the volumes nearer to their bounds without
/// adding a fault; if volumes come first, the cheapest flip that brings the volumes nearer to their bounds, or removes a fault
/// without moving them away. Returns the layout when there is no such flip.
fn mended(
    mut layout: Vec<Material>,
    counts: &Counts,
    rules: &LayoutRules,
    first: First,
    groups: &[Vec<usize>],
    cost: &impl Fn(usize, Material, Material) -> Option<f64>,
) -> Vec<Material> {
    loop {
        let present = Present::new(counts, rules, &layout);
        let flips = flips_of(groups, &layout, rules.edges(), cost).into_iter();
        let mut flips = flips;
        let better = flips.find(|flip| present.is_better(flip, first));
        match better.map(|flip| flip.on(&layout)) {
            Some(better) => layout = better,
            None => return layout,
        }
    }
}

/// How bad a layout is before a flip: the number of faults, then the number of edges by which the volumes are out of bounds.
/// The number of faults is compared first.
struct Present<'a> {
    layout: &'a [Material],
    counts: &'a Counts,
    rules: &'a LayoutRules,
    faults: Faults<'a>,
    /// The numbers of solid edges and of actuators.
    numbers: [usize; 2],
    excess: usize,
}

impl<'a> Present<'a> {
    fn new(counts: &'a Counts, rules: &'a LayoutRules, layout: &'a [Material]) -> Self {
        let numbers = solid_and_actuators(layout);
        Self {
            faults: rules.counted(layout),
            excess: counts.excess(numbers),
            layout,
            counts,
            rules,
            numbers,
        }
    }

    /// True if the layout is less bad after a flip.
    fn is_better(&self, flip: &Flip, first: First) -> bool {
        let excess = self.excess_after(flip);
        let is_worse = match first {
            First::Faults => self.faults.count == 0 && excess >= self.excess,
            First::Volumes => excess > self.excess,
        };
        if is_worse {
            return false;
        }
        let (before, after) = (self.faults.count, self.faults_after(flip));
        match first {
            First::Faults => [after, excess] < [before, self.excess],
            First::Volumes => [excess, after] < [self.excess, before],
        }
    }

    /// True if the layout has no more faults after a flip, and its volumes are no further out of bounds.
    fn is_no_worse(&self, flip: &Flip) -> bool {
        self.excess_after(flip) <= self.excess && self.faults_after(flip) <= self.faults.count
    }

    fn excess_after(&self, flip: &Flip) -> usize {
        let before = flip.group.iter().map(|&edge| self.layout[edge]);
        let [solid, actuators] = solid_and_actuators(&before.collect::<Vec<_>>());
        let size = flip.group.len();
        let after = [
            size * usize::from(flip.to.is_solid()),
            size * usize::from(flip.to == Material::Actuator),
        ];
        let [all_solid, all_actuators] = self.numbers;
        self.counts.excess([
            all_solid + after[0] - solid,
            all_actuators + after[1] - actuators,
        ])
    }

    fn faults_after(&self, flip: &Flip) -> usize {
        match flip.group {
            [edge] => self.faults.after(*edge, flip.to),
            _ => self.rules.faults(&flip.on(self.layout)),
        }
    }
}

/// A flip: the change of one edge, or of a group of tied edges, to another material.
struct Flip<'g> {
    group: &'g [usize],
    to: Material,
    cost: f64,
}

impl Flip<'_> {
    /// The layout after the flip.
    fn on(&self, layout: &[Material]) -> Vec<Material> {
        let mut layout = layout.to_vec();
        self.group.iter().for_each(|&edge| layout[edge] = self.to);
        layout
    }
}

/// Lists the flips of a layout, cheapest first. Flips are left out if the rules forbid them or `cost` is `None`. The
/// edges of a group are tied and have the same material; the cost of flipping a group is the sum of the costs of its
/// edges.
fn flips_of<'g>(
    groups: &'g [Vec<usize>],
    layout: &[Material],
    rules: &EdgeRules,
    cost: &impl Fn(usize, Material, Material) -> Option<f64>,
) -> Vec<Flip<'g>> {
    let flip = |group: &'g [usize], to: Material| {
        let from = layout[group[0]];
        let may = from != to && to.of(&rules.allowed(group[0]));
        let costs = || group.iter().map(|&edge| cost(edge, from, to));
        let cost = costs().reduce(|a, b| Some(a? + b?)).flatten();
        let cost = cost.filter(|_| may)?;
        Some(Flip { group, to, cost })
    };
    let of_group = |group: &'g Vec<usize>| Material::ALL.map(|to| flip(group, to));
    let mut flips: Vec<_> = groups.iter().flat_map(of_group).flatten().collect();
    flips.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    flips
}

/// The number of edges whose material in a layout is not the dominant material of their mixture (the material with the
/// largest share).
pub fn flips(mixtures: &[Mixture<f64>], materials: &[Material]) -> usize {
    let flipped = |(m, own): &(&Material, &Mixture<f64>)| **m != own.dominant();
    materials.iter().zip(mixtures).filter(flipped).count()
}

/// The smallest share of an edge's mixture that a material must have to be an alternative for the edge. A material that
/// is excluded by `projection.hold_materials` has a share of about 1e-9.
const LEAST_SHARE: f64 = 1e-3;

/// At most `most` layouts that differ from a snapped layout in one edge or in tied edges. The list begins with the
/// closest decisions: the edges whose new material has nearly the share of the old one, or more. The layouts have no
/// more faults than the snapped layout, and their volumes are no further out of bounds. In the edge's mixture, the new
/// material has at least the share `LEAST_SHARE`.
pub fn alternatives(
    mixtures: &[Mixture<f64>],
    materials: &[Material],
    bounds: &VolumeBounds,
    rules: &LayoutRules,
    most: usize,
) -> Vec<Vec<Material>> {
    let cost = |edge: usize, from, to| {
        let [from, to] = [from, to].map(|m: Material| mixtures[edge][m]);
        (to >= LEAST_SHARE).then_some(from - to)
    };
    flipped(materials, bounds, rules, most, cost)
}

/// At most `most` layouts that differ from the layout `materials` in one edge or in tied edges, cheapest first. They
/// have no more faults than `materials`, and their volumes are no further out of bounds. `cost` returns the cost of
/// changing an edge from one material to another, or `None` to exclude that change.
pub fn flipped(
    materials: &[Material],
    bounds: &VolumeBounds,
    rules: &LayoutRules,
    most: usize,
    cost: impl Fn(usize, Material, Material) -> Option<f64>,
) -> Vec<Vec<Material>> {
    let counts = Counts::new(bounds, materials.len());
    let present = Present::new(&counts, rules, materials);
    let groups = rules.edges().groups(materials.len());
    let flips = flips_of(&groups, materials, rules.edges(), &cost);
    let flips = flips.iter().filter(|flip| present.is_no_worse(flip));
    flips.take(most).map(|flip| flip.on(materials)).collect()
}

/// The numbers of solid edges and of actuators in a layout.
pub fn solid_and_actuators(layout: &[Material]) -> [usize; 2] {
    let count = |is: fn(Material) -> bool| layout.iter().filter(|&&m| is(m)).count();
    [
        count(Material::is_solid),
        count(|m| m == Material::Actuator),
    ]
}

/// The volume bounds as numbers of edges.
struct Counts {
    solid: [usize; 2],
    actuator: [usize; 2],
}

impl Counts {
    fn new(bounds: &VolumeBounds, edges: usize) -> Self {
        let whole = |bounds: Range| {
            // The slack is needed because of rounding: 0.03 * 100 is not exactly 3.
            let slack = 1e-9;
            let [least, most] = bounds.map(|share| share * edges as f64).into();
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

    /// The number of edges by which the volumes of a layout with these numbers of solid edges and actuators are out of bounds.
    /// Solid edges and actuators are counted separately, both if there are too few and if there are too many.
    fn excess(&self, [solid, actuators]: [usize; 2]) -> usize {
        let outside =
            |n: usize, [least, most]: [usize; 2]| least.saturating_sub(n) + n.saturating_sub(most);
        outside(solid, self.solid) + outside(actuators, self.actuator)
    }
}
