//! Segments that cross.

/// The smallest area of a triangle that does not count as degenerate, relative to the squares of
/// its sides.
const ON_LINE: f64 = 1e-9;

/// Whether two segments cross strictly between their ends.
pub fn cross(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    let side = |[p, q]: [[f64; 2]; 2], r: [f64; 2]| {
        let (d, e) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
        let area = d[0] * e[1] - d[1] * e[0];
        let size = d[0] * d[0] + d[1] * d[1] + e[0] * e[0] + e[1] * e[1];
        if area.abs() < ON_LINE * size {
            0.0
        } else {
            area.signum()
        }
    };
    side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0
}

/// The pairs of edges that [`cross`], for nodes at these places. The pairs are in ascending order, and each
/// has the smaller index first.
///
/// Sweeps along one axis and compares only edges that overlap along it, which are few pairs if the edges
/// are short. An edge with a NaN crosses nothing.
///
/// # Panics
/// If an edge has a node that does not exist.
pub fn crossings(nodes: &[[f64; 2]], edges: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let segments: Vec<[[f64; 2]; 2]> = edges.iter().map(|ends| ends.map(|n| nodes[n])).collect();
    let extent = |&[p, q]: &[[f64; 2]; 2]| {
        let of = |k: usize| [p[k].min(q[k]), p[k].max(q[k])];
        [of(0), of(1)]
    };
    let extents: Vec<[[f64; 2]; 2]> = segments.iter().map(extent).collect();
    let axis = usize::from(crowding(&extents, 1) < crowding(&extents, 0));
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by(|&i, &j| extents[i][axis][0].total_cmp(&extents[j][axis][0]));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let [along, beside] = [extents[i][axis], extents[i][1 - axis]];
        let later = order[k + 1..].iter();
        for &j in later.take_while(|j| extents[**j][axis][0] <= along[1]) {
            let [low, high] = extents[j][1 - axis];
            if low <= beside[1] && beside[0] <= high && cross(segments[i], segments[j]) {
                pairs.push([i.min(j), i.max(j)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// How many edges overlap along an axis, on average.
fn crowding(extents: &[[[f64; 2]; 2]], axis: usize) -> f64 {
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for &[low, high] in extents.iter().map(|extent| &extent[axis]) {
        sum += high - low;
        least = least.min(low);
        most = most.max(high);
    }
    sum / (most - least)
}

#[cfg(test)]
mod tests {
    use super::{cross, crossings};
    use crate::random::{Purpose, stream, symmetric};

    type Segment = [[f64; 2]; 2];

    /// Gives each segment its own two nodes.
    fn swept(segments: &[Segment]) -> Vec<[usize; 2]> {
        let edges: Vec<[usize; 2]> = (0..segments.len()).map(|k| [2 * k, 2 * k + 1]).collect();
        crossings(&segments.concat(), &edges)
    }

    fn of_all_pairs(segments: &[Segment]) -> Vec<[usize; 2]> {
        let later = |i: usize| (i + 1..segments.len()).map(move |j| [i, j]);
        let pairs = (0..segments.len()).flat_map(later);
        pairs
            .filter(|[i, j]| cross(segments[*i], segments[*j]))
            .collect()
    }

    #[test]
    fn a_sweep_finds_the_crossings_of_all_pairs() {
        let mut random = stream(5, Purpose::Verification);
        let mut found = 0;
        for case in 0..60 {
            // Wide, high and square fields; short and long segments; ends on a grid, so that segments meet,
            // overlap and are parallel to the axes.
            let size = [[15.0, 1.0], [1.0, 15.0], [4.0, 4.0]][case % 3];
            let reach = [1.0, 3.0, 30.0][case / 3 % 3];
            let on_grid = case % 2 == 0;
            let segments: Vec<Segment> = (0..150)
                .map(|_| {
                    let mut number = |limit: f64| {
                        let x = symmetric(&mut random, limit);
                        if on_grid { x.round() } else { x }
                    };
                    let p = size.map(&mut number);
                    [p, p.map(|x| x + number(reach))]
                })
                .collect();
            let expected = of_all_pairs(&segments);
            assert_eq!(swept(&segments), expected, "case {case}");
            found += expected.len();
        }
        assert!(found > 1000, "{found} crossings");
        assert!(swept(&[]).is_empty());
    }

    #[test]
    fn a_segment_with_a_nan_crosses_nothing() {
        let (up, down) = ([[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]);
        let lost = [[f64::NAN, 0.0], [1.0, 1.0]];
        assert_eq!(swept(&[lost, up, [[f64::NAN; 2]; 2], down]), [[1, 3]]);
    }
}
