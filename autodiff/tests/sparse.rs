//! Compressed Jacobians must agree with dense Jacobians and take as few directions as possible.

use autodiff::implicit::{Residual, root};
use autodiff::sparse::{Pattern, Undecided, sparse_hessian, sparse_jacobian};
use autodiff::{Dense, Dual, Function, Real, Var, custom, hessian, jacobian, lit};

use crate::common::{Sym, formula};

/// A function whose values depend only on the arguments that the pattern allows.
struct Local<'a>(&'a Pattern);

impl Local<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let value = |i: usize| {
            let terms = self.0.row(i).iter().enumerate();
            let terms = terms.map(|(k, &j)| (x[j] * R::lit(1.0 + k as f64)).sin());
            terms.fold(R::lit(1.5), |product, term| product * (term + R::lit(2.0)))
        };
        (0..self.0.rows()).map(value).collect()
    }
}

fn point(len: usize) -> Vec<f64> {
    (0..len).map(|i| (1.0 + i as f64).sqrt().sin()).collect()
}

/// Returns the pattern of cameras that observe points. Each row depends on the numbers of one camera and of one point.
fn observations(cameras: usize, points: usize) -> Pattern {
    let mut rows = Vec::new();
    for camera in 0..cameras {
        for point in (camera % 2..points).step_by(2) {
            let own = 6 * camera..6 * camera + 6;
            let seen = 6 * cameras + 3 * point..6 * cameras + 3 * point + 3;
            rows.extend([
                own.clone().chain(seen.clone()).collect(),
                own.chain(seen).collect(),
            ]);
        }
    }
    Pattern::new(6 * cameras + 3 * points, &rows)
}

fn patterns() -> Vec<(Pattern, usize)> {
    // For these pseudo-random rows only an upper bound on the number of colours is known.
    let scattered = |i: usize| {
        let mut row: Vec<usize> = (0..4).map(|k| (i * i * 7 + k * k * 5 + k) % 23).collect();
        row.sort_unstable();
        row.dedup();
        row
    };
    vec![
        (Pattern::banded(50, 1, 1), 3),
        (Pattern::banded(40, 2, 3), 6),
        (Pattern::banded(3, 5, 5), 3),
        (Pattern::banded(3, usize::MAX, usize::MAX), 3),
        (Pattern::banded(9, 0, 0), 1),
        (Pattern::blocks(&[[2, 3], [4, 1], [1, 5], [3, 3]]), 5),
        (observations(4, 10), 9),
        (
            Pattern::new(23, &(0..30).map(scattered).collect::<Vec<_>>()),
            23,
        ),
        (Pattern::new(4, &[vec![], vec![1, 3], vec![]]), 2),
        (Pattern::new(0, &[]), 0),
    ]
}

#[test]
fn compressed_and_dense_jacobians_are_equal_to_the_bit() {
    for (pattern, _) in patterns() {
        let (function, x) = (Local(&pattern), point(pattern.columns()));
        let entries = sparse_jacobian(|x| function.eval(x), &x, &pattern);
        // The dense Jacobian comes from forward mode, one column at a time. It is bit-identical, because the operations
        // are the same.
        assert_eq!(pattern.to_dense(&entries), dense_by_columns(&function, &x));
    }
}

fn dense_by_columns(function: &Local, x: &[f64]) -> Dense<f64> {
    let column = |j: usize| {
        let mut x: Vec<Dual<f64, 1>> = x.iter().copied().map(Dual::constant).collect();
        x[j].tangent[0] = 1.0;
        function.eval(&x)
    };
    let columns: Vec<_> = (0..x.len()).map(column).collect();
    let rows = columns.first().map_or(0, Vec::len);
    let row = |i: usize| columns.iter().map(move |column| column[i].tangent[0]);
    Dense::new(rows, x.len(), (0..rows).flat_map(row).collect())
}

#[test]
fn few_colors_serve_and_no_two_columns_of_a_row_share_one() {
    for (pattern, colors) in patterns() {
        assert!(
            pattern.colors() <= colors,
            "{} of {colors}",
            pattern.colors()
        );
        let longest = (0..pattern.rows()).map(|i| pattern.row(i).len()).max();
        assert!(pattern.colors() >= longest.unwrap_or(0));
    }
    // For these patterns the smallest number of colours is known and must be reached.
    for (pattern, colors) in &patterns()[..6] {
        assert_eq!(pattern.colors(), *colors);
    }
}

#[test]
fn a_pattern_is_found_by_tracing() {
    for (pattern, _) in patterns() {
        let (function, x) = (Local(&pattern), point(pattern.columns()));
        assert_eq!(Pattern::traced(|x| function.eval(x), &x), pattern);
        // The pattern must also be found where every derivative is zero.
        assert_eq!(
            Pattern::traced(|x| Squares(&pattern).eval(x), &vec![0.0; x.len()]),
            pattern
        );
    }
}

/// A function whose values are sums of the squares of the arguments in the row. The sum is computed in one of three
/// ways.
struct Squares<'a>(&'a Pattern);

impl Squares<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let value = |i: usize| {
            let row: Vec<R> = self.0.row(i).iter().map(|&j| x[j]).collect();
            match i % 3 {
                0 => R::dot(&row, &row),
                1 => custom::apply(SumOfSquares, &row),
                _ => row.iter().map(|&x| x * x).sum(),
            }
        };
        (0..self.0.rows()).map(value).collect()
    }
}

#[derive(Clone)]
struct SumOfSquares;

impl custom::Rule for SumOfSquares {
    fn value<R: Real>(&self, x: &[R]) -> R {
        R::dot(x, x)
    }
    fn partials<R: Real>(&self, x: &[R], _: R) -> Vec<R> {
        x.iter().map(|&x| x + x).collect()
    }
}

/// The equations `x = p`, whose root is one call on the tape with several outputs.
#[derive(Clone)]
struct Copied;

impl Residual for Copied {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        x.iter().zip(p).map(|(&x, &p)| x - p).collect()
    }
}

/// Outputs of several fused functions, also those after the first, must depend on the inputs of their own function.
#[test]
fn every_output_of_a_fused_function_depends_on_its_inputs() {
    let copied = |p: &[Var<Undecided>]| {
        let x: Vec<_> = p.iter().map(|p| p.detach()).collect();
        root(Copied, &x, p).expect("an exact root")
    };
    let values = |x: &[Var<Undecided>]| {
        let (a, b) = (copied(&x[..2]), copied(&x[2..5]));
        vec![a[1], a[0] * b[2], b[0], x[4]]
    };
    let expected = Pattern::new(5, &[vec![0, 1], (0..5).collect(), vec![2, 3, 4], vec![4]]);
    assert_eq!(Pattern::traced(values, &[1.0; 5]), expected);
}

/// Returns the sum of the squared products of neighbours, plus a linear term in the last argument.
fn neighbours<R: Real>(x: &[R]) -> R {
    let pairs = x.windows(2).map(|x| (x[0] * x[1]).powi(2));
    pairs.sum::<R>() + lit(3.0) * x[x.len() - 1]
}

#[test]
fn sparse_hessians_are_the_dense_ones() {
    let x = point(9);
    let pattern = Pattern::traced_hessian(neighbours, &x);
    assert_eq!(pattern, Pattern::banded(9, 1, 1));
    assert_eq!(pattern.row_starts()[..3], [0, 2, 5]);
    assert_eq!(pattern.column_indices()[..5], [0, 1, 0, 1, 2]);
    let entries = sparse_hessian(neighbours, &x, &pattern);
    let (sparse, dense) = (pattern.to_dense(&entries), hessian(neighbours, &x));
    for (a, b) in sparse.as_slice().iter().zip(dense.as_slice()) {
        // The two entries are sums of the same few products in different orders.
        assert!((a - b).abs() <= 8.0 * f64::EPSILON * b.abs(), "{a} and {b}");
    }
}

/// The forces on balls in a column, given their heights. The lowest ball rests on the ground, and balls closer than 1
/// push each other apart, as the derivative of `energy`.
fn forces<R: Real>(z: &[R]) -> Vec<R> {
    let push = |above: R, below: R| (below + R::one() - above).max(0.0);
    let at = |i: usize| match i {
        0 => push(z[0], -R::one()),
        i => push(z[i], z[i - 1]),
    };
    let above = |i: usize| {
        if i + 1 < z.len() {
            at(i + 1)
        } else {
            R::zero()
        }
    };
    (0..z.len()).map(|i| at(i) - above(i) - lit(0.1)).collect()
}

fn energy<R: Real>(z: &[R]) -> R {
    let gaps = z.windows(2).map(|z| z[1] - z[0] - R::one());
    let above = gaps.chain([z[0]]).map(|gap| gap.min(0.0).powi(2));
    lit(0.5) * above.sum::<R>() + lit(0.1) * R::sum_of(z)
}

/// No ball touches another one where the pattern is traced. At touchdown it must have the entries of all contacts.
#[test]
fn a_contact_that_is_traced_in_the_air_is_differentiated_at_touchdown() {
    let air: Vec<f64> = (0..7).map(|i| 10.0 + 3.0 * f64::from(i)).collect();
    let touchdown = [-0.2, 0.7, 1.9, 2.5, 3.4, 9.0, 9.9];
    let [of_forces, of_energy] = [
        Pattern::traced(forces, &air),
        Pattern::traced_hessian(energy, &air),
    ];
    assert_eq!(of_forces, Pattern::banded(7, 1, 1));
    assert_eq!(of_energy, Pattern::banded(7, 1, 1));
    for z in [&air[..], &touchdown] {
        let entries = sparse_jacobian(forces, z, &of_forces);
        assert_eq!(of_forces.to_dense(&entries), jacobian(forces, z));
        let entries = sparse_hessian(energy, z, &of_energy);
        assert_eq!(of_energy.to_dense(&entries), hessian(energy, z));
    }
    // A pattern of the contacts that are closed in all states takes fewer directions.
    let tight = Pattern::new(7, &(0..7).map(|_| vec![]).collect::<Vec<_>>());
    assert!(tight.colors() < of_forces.colors());
    assert_eq!(sparse_jacobian(forces, &air, &tight), [0.0; 0]);
}

/// Products of two arguments, of which a function chooses one, or whose kink is at 0.
#[test]
fn both_operands_of_every_choice_are_traced() {
    type Choice = fn([Sym; 3]) -> Sym;
    let [all, first] = [vec![0, 1, 2], vec![0, 1]];
    let choices: [(&str, Choice, &[usize]); 9] = [
        ("max", |[a, b, c]| (a * b).max(b * c), &all),
        ("min", |[a, b, c]| (a * b).min(b * c), &all),
        ("clamp", |[a, b, c]| b.clamp(a * b, b * c), &all),
        (
            "clamp of a product",
            |[a, b, c]| (a * b).clamp(b * c, lit(9.0)),
            &all,
        ),
        (
            "select",
            |[a, b, c]| Sym::select(a.less(c), a * b, b * c),
            &all,
        ),
        (
            "of constants",
            |[a, b, _]| (a * b).max(0.0).min(lit(1.0)),
            &first,
        ),
        ("abs", |[a, b, _]| a.abs() * b, &first),
        ("a chosen zero", |[a, b, _]| a * b.max(0.0), &first),
        (
            "xlogy",
            |[a, b, _]| a.xlogy(b.abs()) + b * a.powi(0),
            &first,
        ),
    ];
    let points = [
        [3.0, 2.0, 1.0],
        [1.0, 2.0, 3.0],
        [2.0; 3],
        [0.0; 3],
        [-2.0, 0.5, 1.0],
    ];
    for (name, choice, arguments) in choices {
        let f = formula(3, |x| choice([x[0], x[1], x[2]]));
        for x in points {
            let traced = Pattern::traced(|x| vec![f.eval(x)], &x);
            assert_eq!(traced.row(0), arguments, "{name} at {x:?}");
            let second = Pattern::traced_hessian(|x| f.eval(x), &x);
            let has = |i: usize, j: usize| second.row(i).contains(&j);
            assert!(has(0, 1) && has(1, 0), "{name} at {x:?}: {second:?}");
            let of_c = arguments.contains(&2);
            assert_eq!(
                [has(1, 2), has(2, 1)],
                [of_c; 2],
                "{name} at {x:?}: {second:?}"
            );
            assert!(!has(0, 2) && !has(2, 0), "{name} at {x:?}: {second:?}");
        }
    }
}

/// The pattern lacks an entry whose column has the same colour as another column of the row. So the missing entry is
/// added to that column's entry. The test direction must notice this.
#[test]
#[should_panic(expected = "along a test direction")]
fn a_missing_column_whose_color_is_taken_is_noticed() {
    let all = Pattern::banded(8, 1, 1);
    let mut rows: Vec<Vec<usize>> = (0..8).map(|i| all.row(i).to_vec()).collect();
    rows[4] = vec![3, 4];
    let wrong = Pattern::new(8, &rows);
    assert_eq!(wrong.colors(), 3);
    sparse_jacobian(|x| Local(&all).eval(x), &point(8), &wrong);
}

#[test]
fn nested_numbers_pass_through() {
    let pattern = Pattern::banded(5, 1, 1);
    let function = Local(&pattern);
    let x: Vec<Dual<f64, 1>> = point(5).into_iter().map(|x| Dual::variable(x, 0)).collect();
    let second = sparse_jacobian(|x| function.eval(x), &x, &pattern);
    let dense = jacobian(|x| function.eval(x), &x).into_vec();
    let dense: Vec<_> = dense.iter().filter(|entry| entry.value != 0.0).collect();
    assert_eq!(second.len(), dense.len());
    for (a, b) in second.iter().zip(dense) {
        assert_eq!((a.value, a.tangent), (b.value, b.tangent));
    }
}
