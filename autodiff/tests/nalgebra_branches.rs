//! nalgebra's own code where it asks whether a number is zero, or compares it: factors of 0, interpolation at its ends,
//! rotations at the identity, and columns of zeros. What loses derivatives is in the list of `autodiff::matrices`.

use crate::common::{assert_refused, forward_gradient};
use autodiff::matrices::Element;
use autodiff::{Function, Real, gradient};
use nalgebra::linalg::givens::GivensRotation;
use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Point3, Quaternion, Reflection, Rotation2, Rotation3,
    Similarity3, Translation3, Unit, UnitComplex, UnitDualQuaternion, UnitQuaternion, Vector2,
    Vector3,
};

fn vector<R: Real>(numbers: [f64; 3]) -> Vector3<Element<R>> {
    Vector3::from(numbers).map(Element::lit)
}

fn matrix<R: Real>(seed: usize) -> Matrix3<Element<R>> {
    Matrix3::from_fn(|i, j| Element::lit(((i * seed + j * j + 1) % 5) as f64 - 1.3))
}

/// Calls in which the variable is the factor of the numbers that are overwritten.
const FACTORS: [&str; 20] = [
    "axpy",
    "axcpy",
    "gemv",
    "gemv_tr",
    "gemv_ad",
    "sygemv",
    "hegemv",
    "cmpy",
    "cdpy",
    "ger",
    "gerc",
    "syger",
    "hegerc",
    "gemm",
    "gemm_tr",
    "gemm_ad",
    "quadform",
    "quadform_tr",
    "lerp",
    "reflection",
];

fn scaled<R: Real>(name: &str, factor: Element<R>) -> Vec<Element<R>> {
    let two = Element::lit(2.0);
    let [a, b] = [vector([0.5, -1.0, 3.0]), vector([2.0, 0.3, 0.7])];
    let [m, n] = [matrix(2), matrix(3)];
    let (mut y, mut z) = (vector([1.0, 2.0, -0.5]), matrix(4));
    match name {
        "axpy" => y.axpy(two, &a, factor),
        "axcpy" => y.axcpy(two, &a, two, factor),
        "gemv" => y.gemv(two, &m, &a, factor),
        "gemv_tr" => y.gemv_tr(two, &m, &a, factor),
        "gemv_ad" => y.gemv_ad(two, &m, &a, factor),
        "sygemv" => y.sygemv(two, &m, &a, factor),
        "hegemv" => y.hegemv(two, &m, &a, factor),
        "cmpy" => y.cmpy(two, &a, &b, factor),
        "cdpy" => y.cdpy(two, &a, &b, factor),
        "ger" => z.ger(two, &a, &b, factor),
        "gerc" => z.gerc(two, &a, &b, factor),
        "syger" => z.syger(two, &a, &b, factor),
        "hegerc" => z.hegerc(two, &a, &b, factor),
        "gemm" => z.gemm(two, &m, &n, factor),
        "gemm_tr" => z.gemm_tr(two, &m, &n, factor),
        "gemm_ad" => z.gemm_ad(two, &m, &n, factor),
        "quadform" => z.quadform(two, &m, &n, factor),
        "quadform_tr" => z.quadform_tr(two, &m, &n, factor),
        "lerp" => y = y.lerp(&a, factor),
        "reflection" => Reflection::new(Unit::new_normalize(a), factor).reflect(&mut y),
        _ => panic!("no call is called {name}"),
    }
    y.iter().chain(z.iter()).copied().collect()
}

/// Calls in which the variable is an angle or a component that is 0, or the time of an interpolation.
const ANGLES: [&str; 10] = [
    "cancel_y",
    "cancel_x",
    "givens",
    "from_axis_angle",
    "rotation3",
    "rotation2",
    "powf",
    "complex",
    "slerp",
    "lerp_slerp",
];

fn turned<R: Real>(name: &str, x: Element<R>) -> Vec<Element<R>> {
    let three = Element::lit(3.0);
    let (point, plane) = (
        vector([1.0, 2.0, -0.5]),
        Vector2::new(three, Element::lit(2.0)),
    );
    let axis = Unit::new_normalize(vector([0.5, -1.0, 3.0]));
    let other = UnitQuaternion::from_axis_angle(&axis, Element::lit(0.7));
    let of_givens =
        |(turn, norm): (GivensRotation<Element<R>>, Element<R>)| vec![turn.c(), turn.s(), norm];
    let of_point = |p: Vector3<Element<R>>| p.iter().copied().collect();
    let of_plane = |p: Vector2<Element<R>>| p.iter().copied().collect();
    match name {
        "cancel_y" => of_givens(GivensRotation::cancel_y(&Vector2::new(three, x)).expect("a turn")),
        "cancel_x" => of_givens(GivensRotation::cancel_x(&Vector2::new(x, three)).expect("a turn")),
        "givens" => of_givens(GivensRotation::new(three, x)),
        "from_axis_angle" => of_point(UnitQuaternion::from_axis_angle(&axis, x) * point),
        "rotation3" => of_point(Rotation3::from_axis_angle(&axis, x) * point),
        "rotation2" => of_plane(Rotation2::new(x) * plane),
        "powf" => of_plane(Rotation2::new(x).powf(Element::lit(0.3)) * plane),
        "complex" => of_plane(UnitComplex::identity().slerp(&UnitComplex::new(x), three) * plane),
        "slerp" => of_point(UnitQuaternion::identity().slerp(&other, x) * point),
        "lerp_slerp" => {
            let end = Isometry3::from_parts(Translation3::from(point), other);
            of_point((Isometry3::identity().lerp_slerp(&end, x) * Point3::from(point)).coords)
        }
        _ => panic!("no call is called {name}"),
    }
}

/// Calls at the rotation by the vector `x`, near the identity.
const AT_IDENTITY: [&str; 22] = [
    "quaternion new",
    "quaternion from_scaled_axis",
    "quaternion scaled_axis",
    "quaternion ln",
    "quaternion powf",
    "quaternion slerp",
    "quaternion rotation_between",
    "quaternion scaled_rotation_between",
    "quaternion from_matrix",
    "exp",
    "sinh",
    "rotation3 scaled_axis",
    "rotation3 powf",
    "rotation3 slerp",
    "rotation3 rotation_between",
    "rotation3 from_matrix",
    "isometry3 new",
    "isometry3 lerp_slerp",
    "similarity3 new",
    "sclerp",
    "vector slerp",
    "rotation2 from_matrix",
];

fn near_identity<R: Real>(name: &str, x: &[Element<R>]) -> Vec<Element<R>> {
    let (one, half) = (Element::lit(1.0), Element::lit(0.5));
    let (point, turn) = (vector([1.0, 2.0, -0.5]), Vector3::new(x[0], x[1], x[2]));
    let plain = Quaternion::new(half, x[0], x[1], x[2]);
    let quaternion = UnitQuaternion::new_normalize(Quaternion::new(one, x[0], x[1], x[2]));
    let rotation = quaternion.to_rotation_matrix();
    let (aside, still) = (point + turn, UnitQuaternion::identity());
    let end = Isometry3::from_parts(Translation3::from(point), quaternion);
    let turned = match name {
        "quaternion new" => UnitQuaternion::new(turn) * point,
        "quaternion from_scaled_axis" => UnitQuaternion::from_scaled_axis(turn) * point,
        "quaternion scaled_axis" => quaternion.scaled_axis(),
        "quaternion ln" => quaternion.ln().imag(),
        "quaternion powf" => quaternion.powf(half) * point,
        "quaternion slerp" => still.slerp(&quaternion, half) * point,
        "quaternion rotation_between" => {
            UnitQuaternion::rotation_between(&point, &aside).expect("a turn") * Vector3::x()
        }
        "quaternion scaled_rotation_between" => {
            let turn = UnitQuaternion::scaled_rotation_between(&point, &aside, half);
            turn.expect("a turn") * Vector3::x()
        }
        "quaternion from_matrix" => UnitQuaternion::from_matrix(rotation.matrix()) * point,
        "exp" => plain.exp().imag(),
        "sinh" => plain.sinh().imag(),
        "rotation3 scaled_axis" => rotation.scaled_axis(),
        "rotation3 powf" => rotation.powf(half) * point,
        "rotation3 slerp" => Rotation3::identity().slerp(&rotation, half) * point,
        "rotation3 rotation_between" => {
            Rotation3::rotation_between(&point, &aside).expect("a turn") * Vector3::x()
        }
        "rotation3 from_matrix" => Rotation3::from_matrix(rotation.matrix()) * point,
        "isometry3 new" => Isometry3::new(point, turn) * point,
        "isometry3 lerp_slerp" => Isometry3::identity().lerp_slerp(&end, half) * point,
        "similarity3 new" => Similarity3::new(point, turn, half) * point,
        "sclerp" => {
            let [from, to] =
                [Isometry3::identity(), end].map(|i| UnitDualQuaternion::from_isometry(&i));
            from.sclerp(&to, half) * point
        }
        "vector slerp" => point.slerp(&aside, half),
        "rotation2 from_matrix" => {
            let turned = Rotation2::from_matrix(Rotation2::new(x[0]).matrix()) * point.xy();
            turned.push(half)
        }
        "rotation3 new" => Rotation3::new(turn) * point,
        _ => panic!("no call is called {name}"),
    };
    turned.iter().copied().collect()
}

/// Calls with a square matrix, row by row, whose zeros carry derivatives.
fn factored<R: Real>(name: &str, x: &[Element<R>]) -> Vec<Element<R>> {
    let size = x.len().isqrt();
    let (matrix, load) = (
        DMatrix::from_row_slice(size, size, x),
        DVector::from_fn(size, |i, _| Element::lit(1.0 + i as f64)),
    );
    let of_matrix = |m: DMatrix<Element<R>>| m.iter().copied().collect();
    match name {
        "lu" => vec![matrix.lu().determinant()],
        "col_piv_qr" => vec![matrix.col_piv_qr().determinant()],
        "qr" => {
            let (q, r) = matrix.qr().unpack();
            of_matrix(q * r)
        }
        "eigenvalues" => matrix
            .eigenvalues()
            .expect("real values")
            .iter()
            .copied()
            .collect(),
        "schur" => of_matrix(matrix.schur().unpack().1),
        "bidiagonalize" => {
            let (u, d, v) = matrix.bidiagonalize().unpack();
            of_matrix(u * d * v)
        }
        "symmetric_tridiagonalize" => of_matrix(matrix.symmetric_tridiagonalize().recompose()),
        "symmetric_eigen" => of_matrix(matrix.symmetric_eigen().eigenvectors),
        "pseudo_inverse" => of_matrix(matrix.pseudo_inverse(Element::lit(1e-9)).expect("small")),
        "svd solve" => {
            let solution = matrix.svd(true, true).solve(&load, Element::lit(1e-9));
            solution.expect("it has vectors").iter().copied().collect()
        }
        _ => panic!("no call is called {name}"),
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Scaled,
    Turned,
    NearIdentity,
    Factored,
}

/// A sum of the results of a call, with different weights.
struct Call(Kind, &'static str);

impl Function for Call {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let x: Vec<Element<R>> = x.iter().copied().map(Element).collect();
        let results = match self.0 {
            Kind::Scaled => scaled(self.1, x[0]),
            Kind::Turned => turned(self.1, x[0]),
            Kind::NearIdentity => near_identity(self.1, &x),
            Kind::Factored => factored(self.1, &x),
        };
        let weighted = results.iter().enumerate();
        weighted.fold(R::zero(), |sum, (k, y)| {
            sum + y.0 * R::lit(1.0 + 0.7 * (k * k) as f64)
        })
    }
}

fn differences(call: &Call, x: &[f64]) -> Vec<f64> {
    let along = |k| crate::common::differences(|x| vec![call.eval(x)], x, k, 1e-5)[0];
    (0..x.len()).map(along).collect()
}

/// The gradient by forward and by reverse mode.
fn modes(call: &Call, x: &[f64]) -> [Vec<f64>; 2] {
    [forward_gradient(call, x), gradient(|x| call.eval(x), x)]
}

/// Whether a slope agrees with a difference over 1e-5, whose truncation error is 1e-10 times third derivatives.
fn agrees(slope: f64, difference: f64) -> bool {
    (slope - difference).abs() <= 1e-6 * (1.0 + difference.abs())
}

#[test]
fn a_factor_of_zero_the_ends_of_an_interpolation_and_an_angle_of_zero_keep_their_slopes() {
    let factors = FACTORS.map(|name| Call(Kind::Scaled, name));
    let calls = factors
        .into_iter()
        .chain(ANGLES.map(|name| Call(Kind::Turned, name)));
    let mut wrong = Vec::new();
    for call in calls {
        for x in [0.0, -0.0, 1.0] {
            let expected = differences(&call, &[x])[0];
            let [forward, reverse] = modes(&call, &[x]).map(|slopes| slopes[0]);
            if !agrees(forward, expected) || !agrees(reverse, expected) {
                let name = call.1;
                wrong.push(format!(
                    "{name} at {x}: {forward}, {reverse}, not {expected}"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// nalgebra compares a length or an angle with a tolerance and returns the identity, which is a constant. If this test
/// fails, nalgebra has changed, and the list of `autodiff::matrices` must change too.
#[test]
fn what_nalgebra_loses_at_the_identity_is_pinned() {
    let mut changed = Vec::new();
    for call in AT_IDENTITY.map(|name| Call(Kind::NearIdentity, name)) {
        let x = [0.0; 3];
        let right = differences(&call, &x);
        let modes = modes(&call, &x);
        // A product with a translation may round a zero.
        let flat = modes.iter().flatten().all(|slope| slope.abs() < 1e-15);
        if !flat || right.iter().all(|slope| slope.abs() < 1e-3) {
            changed.push(format!("{}: {modes:?}, right is {right:?}", call.1));
        }
    }
    let by_vector = modes(&Call(Kind::NearIdentity, "rotation3 new"), &[0.0; 3]);
    if by_vector[0] != [0.0; 3] || by_vector[1].iter().any(|slope| slope.is_finite()) {
        changed.push(format!("Rotation3::new: {by_vector:?}"));
    }
    // Where both components are 0, the rotation is the identity.
    let none = |x: &[autodiff::Var<f64>]| GivensRotation::new(Element(x[0]), Element(x[1])).0.s().0;
    if gradient(none, &[0.0, 0.0]) != [0.0, 0.0] {
        changed.push("GivensRotation::new".into());
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

/// Zero columns of `[[1, 1, 1], [0, 2, 1], [0, 0, 4]]`, of a diagonal matrix, and of a singular matrix.
const TRIANGULAR: &[f64] = &[1.0, 1.0, 1.0, 0.0, 2.0, 1.0, 0.0, 0.0, 4.0];
const DIAGONAL: &[f64] = &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0];
const SINGULAR: &[f64] = &[0.0, 1.0, 0.0, 2.0];

/// A factorisation, a matrix, an entry, and the slope by that entry in forward mode.
const LOST: [(&str, &[f64], usize); 10] = [
    ("lu", SINGULAR, 2),
    ("col_piv_qr", SINGULAR, 2),
    ("qr", SINGULAR, 2),
    ("eigenvalues", TRIANGULAR, 3),
    ("schur", TRIANGULAR, 3),
    ("bidiagonalize", DIAGONAL, 1),
    ("symmetric_tridiagonalize", DIAGONAL, 3),
    ("symmetric_eigen", DIAGONAL, 3),
    ("pseudo_inverse", DIAGONAL, 1),
    ("svd solve", DIAGONAL, 1),
];

/// A Householder reflection of zeros is left out where the squared length carries no tangent: in forward mode always,
/// on a tape never. If this test fails, nalgebra has changed, and the list of `autodiff::matrices` must change too.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn what_nalgebra_loses_at_columns_of_zeros_is_pinned_in_forward_mode_and_not_finite_on_a_tape() {
    let mut changed = Vec::new();
    for (name, x, entry) in LOST {
        let call = Call(Kind::Factored, name);
        let (right, lost) = (differences(&call, x), forward_gradient(&call, x)[entry]);
        if lost != 0.0 || right[entry].abs() < 1e-3 {
            changed.push(format!(
                "{name} in forward mode: {lost}, right is {right:?}"
            ));
        }
        let wrong = |(slope, right): (&f64, &f64)| slope.is_finite() && !agrees(*slope, *right);
        if let Ok(slopes) = std::panic::catch_unwind(|| gradient(|x| call.eval(x), x))
            && (slopes.iter().zip(&right).any(wrong) || slopes[entry].is_finite())
        {
            changed.push(format!("{name} on a tape: {slopes:?}, right is {right:?}"));
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

/// The iterations of nalgebra would never end with NaN.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn an_iteration_that_meets_nan_panics() {
    let nan = DMatrix::from_element(4, 4, Element(f64::NAN));
    assert_refused("nalgebra's factorisation met NaN", || {
        nan.clone().svd(true, true)
    });
    assert_refused("nalgebra's factorisation met NaN", || nan.clone().schur());
}
