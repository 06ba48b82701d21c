//! The weights of a network that sees the mirror image of a robot and moves it, instead of the robot.

use autodiff::Real;

use super::sensing::Parts;
use crate::geometry::Dimension;
use crate::lattice::Mirror;

/// The weights of a layer that sees the image of a robot and of its goal: for every observation, they give the same as
/// `weights` give for the observation of the image. An observation has this number of `inputs`, those of the clocks first. The
/// ground does not tell the sides of the robot apart.
pub(super) fn observed<R: Real>(
    weights: &[R],
    (inputs, clocks): (usize, usize),
    dimension: Dimension,
    mirror: &Mirror,
) -> Vec<R> {
    let axes = dimension.count();
    let turned = |vector: &[R]| {
        let mut turned = vector[..axes].to_vec();
        let component = mirror.sides.component();
        turned[component] = -turned[component];
        turned
    };
    let row = |row: &[R]| {
        let parts = Parts::of(row, clocks, dimension);
        let of_images = |list: &[R]| -> Vec<R> {
            let images = mirror.nodes.iter().filter(|_| !list.is_empty());
            images
                .flat_map(|&node| turned(&list[axes * node..]))
                .collect()
        };
        let [offsets, velocities] = [parts.offsets, parts.velocities].map(of_images);
        [parts.clocks, &turned(parts.goal), &offsets, &velocities].concat()
    };
    weights.chunks_exact(inputs).flat_map(row).collect()
}

/// The weights of a layer that moves these edges, and that reads hidden units of the robot and of its image: after each
/// `part` of a row of `weights` comes the same part of the row that belongs to the image of the edge.
pub(super) fn moved<R: Real>(
    weights: &[R],
    edges: &[usize],
    part: usize,
    mirror: &Mirror,
) -> Vec<R> {
    let row = rows(weights, mirror);
    let of_edge = |&edge: &usize| {
        let image = row(mirror.edges[edge]).chunks_exact(part);
        row(edge).chunks_exact(part).zip(image)
    };
    let parts = edges.iter().flat_map(of_edge);
    parts
        .flat_map(|(own, image)| [own, image].concat())
        .collect()
}

/// The biases of the layer that has the weights [`moved`]: for each edge, the mean of its bias and of the bias of its image.
pub(super) fn biases<R: Real>(biases: &[R], edges: &[usize], mirror: &Mirror) -> Vec<R> {
    let mean = |&edge: &usize| R::lit(0.5) * (biases[edge] + biases[mirror.edges[edge]]);
    edges.iter().map(mean).collect()
}

/// The rows of weights that have one row per edge.
fn rows<'w, R>(weights: &'w [R], mirror: &Mirror) -> impl Fn(usize) -> &'w [R] + use<'w, R> {
    let length = weights.len() / mirror.edges.len();
    move |edge| &weights[edge * length..][..length]
}
