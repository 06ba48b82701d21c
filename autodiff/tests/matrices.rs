//! Elements in nalgebra: comparisons and conversions, rotations, eigenvalues and exponentials. `singular_matrices.rs` has
//! the factorisations.

use crate::common::{assert_close, assert_refused, differences};
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::matrices::{
    Element, NoDerivative, angle, exp, rotation, rotation_vector, singular_values, symmetric_eigen,
    symmetric_eigen_groups,
};
use autodiff::{DoubleDouble, Dual, Function, Real, Var, gradient, hessian, jacobian_reverse};
use nalgebra::{
    ComplexField, DMatrix, DVector, Matrix3, RealField, SimdValue, UnitQuaternion, Vector3,
    convert, try_convert,
};

#[test]
fn what_has_no_solution_is_refused_in_every_number() {
    let saddle = |a: Element<Dual<f64, 1>>| {
        let b = Element::lit(2.0);
        DMatrix::from_row_slice(2, 2, &[a, b, b, a])
    };
    let [soft, stiff] = [1.0, 3.0].map(|a| Element(Dual::variable(a, 0)));
    assert!(saddle(soft).cholesky().is_none());
    assert!(saddle(stiff).cholesky().is_some());
    let zero = DMatrix::from_element(1, 1, Element(Dual::<f64, 1>::variable(0.0, 0)));
    assert!(zero.cholesky().is_none());
}

#[test]
fn cardinal_functions_are_flat_at_zero() {
    let zero = Element(Dual::<f64, 1>::variable(0.0, 0));
    for value in [ComplexField::sinc(zero).0, ComplexField::sinhc(zero).0] {
        assert_eq!((value.value, value.tangent), (1.0, [0.0]));
    }
    assert_eq!(ComplexField::sinc(Element(0.5)).0, Real::sin(0.5) / 0.5);
    // The system's function has an error of an ulp or two.
    let error = ComplexField::sinhc(Element(0.5)).0 - 0.5_f64.sinh() / 0.5;
    assert!(error.abs() < 4.0 * f64::EPSILON);
}

#[test]
fn comparisons_and_signs_look_at_primals() {
    let [small, large] = [1.0, 2.0].map(|x| Element(Dual::<f64, 1>::variable(x, 0)));
    assert!(small < large && small <= Element::lit(1.0) && small >= Element::lit(1.0));
    let other = Element(Dual::<f64, 1>::variable(1.0, 0));
    assert!(small == other && small != large);
    assert!(Element(f64::NAN) != Element(f64::NAN));
    assert!(RealField::is_sign_negative(&Element(-0.0)));
    assert_eq!(RealField::copysign(Element(3.0), Element(-0.0)).0, -3.0);
    approx::assert_relative_eq!(Element(1.0), Element(1.0 + f64::EPSILON));
    approx::assert_ulps_eq!(Element(1.0), Element(1.0 + 3.0 * f64::EPSILON));
    approx::assert_ulps_ne!(Element(1.0), Element(1.0 + 1e-9));
    // These pairs are close in relative terms, and close in absolute terms.
    assert!(approx::relative_eq!(
        Element(1e9),
        Element(1e9 + 1.0),
        max_relative = Element(1e-8)
    ));
    assert!(approx::relative_eq!(
        Element(0.0),
        Element(1e-9),
        epsilon = Element(1e-8)
    ));
    let infinite = Element(f64::INFINITY);
    approx::assert_relative_eq!(infinite, infinite);
    approx::assert_relative_ne!(infinite, Element(1.0));
    approx::assert_ulps_ne!(infinite, -infinite);
    assert!(!ComplexField::is_finite(&infinite));
}

/// nalgebra must treat an element as a SIMD register with one lane.
#[test]
fn an_element_is_a_register_of_one_lane() {
    let mut element = Element(1.0);
    element.replace(0, Element(2.0));
    assert_eq!(element.extract(0).0, 2.0);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn nothing_turns_into_a_float_silently() {
    let moving = Element(Dual::<f64, 1>::variable(2.0, 0));
    assert_refused("for a matrix exponential, call", || {
        try_convert::<_, f64>(moving)
    });
    assert_refused("its derivative would be lost", || {
        try_convert::<_, f32>(moving)
    });
    let constant: Element<Dual<f64, 1>> = convert(2.5_f64);
    assert_eq!((constant.0.value, constant.0.tangent), (2.5, [0.0]));
    let caught = std::panic::catch_unwind(|| nalgebra::convert_unchecked::<_, f64>(moving));
    assert!(caught.is_err());
    let caught = std::panic::catch_unwind(|| nalgebra::convert_unchecked::<_, f32>(moving));
    assert!(caught.is_err());
    let same: Option<Element<Dual<f64, 1>>> = try_convert(moving);
    assert_eq!(same.map(|same| same.0.tangent), Some([1.0]));
}

/// A function that rotates a point and returns its coordinate along a direction. The argument is the rotation vector.
struct Turned;

impl Function for Turned {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let lit = |v: [f64; 3]| Vector3::from(v).map(Element::<R>::lit);
        let [i, j, k] = [0, 1, 2].map(|axis| Element(x[axis]));
        let vector = Vector3::new(i, j, k);
        let turned = rotation(&vector) * lit([1.0, 2.0, -0.5]);
        turned.dot(&lit([0.3, -1.1, 0.7])).0
    }
}

/// The angles range from zero, past the point where the formula changes, to more than a full turn.
#[test]
fn rotations_are_those_of_nalgebra_and_smooth_where_it_has_none() {
    let axis = [0.6, -0.48, 0.64];
    for angle in [0.0, 1e-200, 1e-9, 1e-3, 0.4999, 0.5001, 2.0, 7.0] {
        let x = axis.map(|a| a * angle);
        let vector = Vector3::from(x);
        let [ours, theirs] = [
            rotation(&vector.map(Element)).coords.map(|x| x.0),
            UnitQuaternion::new(vector).coords,
        ];
        // Each side has about ten rounding errors. Below 1e-16 rad nalgebra returns the identity.
        assert!((ours - theirs).norm() < 1e-15, "{angle}");
        let report = check_gradient(&Turned, &x, &Options::default());
        assert_eq!(report.verdict, Verdict::Smooth, "{angle}: {report}");
        // Compares with differences of the gradient, whose truncation error is h^2 times fourth derivatives of about
        // 10.
        for (i, row) in hessian(|x| Turned.eval(x), &x).iter().enumerate() {
            let slopes = differences(|x| gradient(|x| Turned.eval(x), x), &x, i, 1e-5);
            assert_close(row, &slopes, 1e-8);
        }
    }
}

/// The series must be accurate to the last digit of double-double, the number type with the most digits.
#[test]
fn a_rotation_has_31_digits() {
    let of = |angle: f64| {
        let vector = Vector3::new(0.0, 0.0, angle).map(|x| Element(DoubleDouble::from(x)));
        let [half, turned] = [
            DoubleDouble::from(angle) * DoubleDouble::from(0.5),
            rotation(&vector).coords[2].0,
        ];
        (Real::sin(half) - turned).to_f64().abs() / angle
    };
    for angle in [1e-3, 0.1, 0.49] {
        assert!(of(angle) < 1e-30, "{angle}: {:e}", of(angle));
    }
}

/// Returns the largest eigenvalue of `[[1, a, b], [a, 2, c], [b, c, 4]]` as a function of `[a, b, c]`.
fn largest<R: Real>(x: &[R]) -> R {
    let [a, b, c] = [0, 1, 2].map(|k| Element(x[k]));
    let [one, two, four] = [1.0, 2.0, 4.0].map(Element::lit);
    let matrix = DMatrix::from_row_slice(3, 3, &[one, a, b, a, two, c, b, c, four]);
    let pairs = symmetric_eigen(&matrix).expect("three values");
    pairs[2].value.0
}

/// The Hessian must agree with second-order perturbation theory, which gives `4 + b^2 / (4 - 1) + c^2 / (4 - 2)`.
#[test]
fn eigenvalues_of_a_diagonal_matrix_have_their_hessian() {
    let second = hessian(largest, &[0.0; 3]);
    let expected = [0.0, 0.0, 0.0, 0.0, 2.0 / 3.0, 0.0, 0.0, 0.0, 1.0];
    assert_close(second.as_slice(), &expected, 1e-15);
    // Away from zero, the gradient must agree with central differences. With a step of 1e-5 they are off by 1e-10.
    let x = [0.3, -0.2, 0.5];
    for (k, slope) in gradient(largest, &x).into_iter().enumerate() {
        let difference = differences(|x| vec![largest(x)], &x, k, 1e-5);
        assert_close(&[slope], &difference, 1e-9);
    }
}

#[test]
fn a_repeated_eigenvalue_is_refused() {
    let diagonal = [1.0, 4.0, 3.0, 3.0].map(Element);
    let twice = DMatrix::from_diagonal(&DVector::from_row_slice(&diagonal));
    let refused = symmetric_eigen(&twice).unwrap_err();
    assert_eq!(refused, NoDerivative::RepeatedEigenvalue(3.0));
    assert_eq!(
        refused.to_string(),
        "the eigenvalue 3 is repeated, to within rounding, so it has no derivatives; \
         call `symmetric_eigen_groups` with a `distance` that puts equal eigenvalues into one group"
    );
    // Each group needs a distance from the next.
    let refused = symmetric_eigen_groups(&twice, -1.0).unwrap_err();
    assert_eq!(refused, NoDerivative::RepeatedEigenvalue(3.0));
    assert_eq!(symmetric_eigen_groups(&twice, 0.0).unwrap().len(), 3);
    for repeated in [0.0, 4.0] {
        let diagonal = [1.0, repeated, 4.0].map(Element);
        let matrix = DMatrix::from_diagonal(&DVector::from_row_slice(&diagonal));
        let refused = singular_values(&matrix).unwrap_err();
        let NoDerivative::RepeatedSingularValue(value) = refused else {
            panic!("{refused}");
        };
        // nalgebra's value is off by a few roundings of 4.
        assert_close(&[value], &[repeated], 1e-14);
    }
}

/// Symmetric functions of the eigenvalues of a matrix, by groups of eigenvalues. Where all eigenvalues are in one group,
/// the functions follow from the matrix itself.
struct OfGroups {
    distance: f64,
}

impl OfGroups {
    fn matrix<R: Real>(x: &[R]) -> DMatrix<Element<R>> {
        let [a, b, c] = [0, 1, 2].map(|k| Element(x[k]));
        let [two, five] = [2.0, 5.0].map(Element::lit);
        DMatrix::from_row_slice(
            3,
            3,
            &[two + a, b, c, b, two - a * b, c * c, c, c * c, five + b],
        )
    }
}

impl Function for OfGroups {
    /// The product of the determinants, plus the sum of the squares of all eigenvalues.
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let groups = symmetric_eigen_groups(&Self::matrix(x), self.distance).expect("groups");
        let blocks = || groups.iter().map(|group| &group.block);
        let product = blocks().fold(R::one(), |product, block| product * block.determinant().0);
        blocks().fold(product, |sum, block| sum + (block * block).trace().0)
    }
}

/// The eigenvalues are 2, 2 and 5 at the origin. The determinant and the squared entries of the whole matrix are the same
/// functions without eigenvalues.
#[test]
fn groups_of_repeated_eigenvalues_have_derivatives_of_every_order() {
    fn whole<R: Real>(x: &[R]) -> R {
        let matrix = OfGroups::matrix(x);
        matrix.determinant().0 + matrix.norm_squared().0
    }
    for x in [[0.0; 3], [1e-9, 0.0, 0.0], [0.02, -0.01, 0.03]] {
        for distance in [1.0, 4.0] {
            let ours = OfGroups { distance };
            let second = hessian(|x| ours.eval(x), &x);
            // Sums and products of numbers up to 25, with the roundings of one factorisation.
            assert_close(&[ours.eval(&x)], &[whole(&x)], 1e-13);
            assert_close(&gradient(|x| ours.eval(x), &x), &gradient(whole, &x), 1e-12);
            assert_close(second.as_slice(), hessian(whole, &x).as_slice(), 1e-11);
        }
    }
    let groups = symmetric_eigen_groups(&OfGroups::matrix(&[0.0; 3]), 1.0).expect("two groups");
    assert_close(
        &[groups[0].mean().0, groups[1].mean().0],
        &[2.0, 5.0],
        1e-15,
    );
}

/// The turns are as large as their norm, which decides how often the exponential is squared.
#[test]
fn the_exponential_of_a_matrix_follows_from_its_equations() {
    // The exponential of a skew matrix is the rotation about its vector.
    for angle in [0.0, 1e-9, 0.3, 2.0, 40.0] {
        let by_exponential = |x: &[Var<f64>]| {
            let [i, j, k] = [0, 1, 2].map(|axis| Element(x[axis]));
            let [zero, i, j, k] = [Element::lit(0.0), i, j, k];
            let skew = Matrix3::new(zero, -k, j, k, zero, -i, -j, i, zero);
            exp(&DMatrix::from_row_slice(3, 3, skew.transpose().as_slice()))
                .iter()
                .map(|x| x.0)
                .collect()
        };
        let by_rotation = |x: &[Var<f64>]| {
            let [i, j, k] = [0, 1, 2].map(|axis| Element(x[axis]));
            let turned = rotation(&Vector3::new(i, j, k)).to_rotation_matrix();
            turned.matrix().iter().map(|x| x.0).collect()
        };
        let x = [0.6, -0.48, 0.64].map(|a| a * angle);
        let [ours, expected] = [
            jacobian_reverse(by_exponential, &x),
            jacobian_reverse(by_rotation, &x),
        ];
        // Every squaring doubles the rounding error; there are up to seven.
        assert_close(ours.as_slice(), expected.as_slice(), 1e-13);
    }
    let wide = exp(&DMatrix::from_element(
        1,
        1,
        Element(DoubleDouble::from(3.0)),
    ));
    let error = (wide[(0, 0)].0 - DoubleDouble::from(3.0).exp()).to_f64();
    assert!(f64::abs(error) < 1e-28, "{error:e}");
}

/// A coordinate of a rotation vector that becomes a rotation and a vector again.
struct There;

impl Function for There {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [i, j, k] = [0, 1, 2].map(|axis| Element(x[axis]));
        let back = rotation_vector(&rotation(&Vector3::new(i, j, k)));
        back[0].0 + back[1].0 * R::lit(2.0) + back[2].0 * R::lit(4.0)
    }
}

/// The vector of a rotation is that of nalgebra, and composed with `rotation` it is the identity, to second order.
#[test]
fn a_rotation_has_its_vector_back() {
    let axis = [0.6, -0.48, 0.64];
    for angle in [0.0, 1e-200, 1e-9, 1e-3, 0.4899, 0.4901, 2.0, 3.1] {
        let x = axis.map(|a| a * angle);
        // The half angle's sine and cosine have rounding errors of a unit. Near a half turn they are multiplied by
        // the condition number 1.
        assert_close(&[There.eval(&x)], &[x[0] + 2.0 * x[1] + 4.0 * x[2]], 1e-14);
        assert_close(&gradient(|x| There.eval(x), &x), &[1.0, 2.0, 4.0], 1e-14);
        assert_close(hessian(|x| There.eval(x), &x).as_slice(), &[0.0; 9], 1e-13);
    }
    // Beyond a half turn, it is the shorter way round.
    let turn = rotation(&Vector3::new(0.0, 0.0, 4.0).map(Element));
    let shorter = 4.0 - 2.0 * std::f64::consts::PI;
    assert_close(&[rotation_vector(&turn)[2].0], &[shorter], 1e-15);
    let wide = Vector3::new(0.0, 0.0, 0.4).map(|x| Element(DoubleDouble::from(x)));
    let error = (rotation_vector(&rotation(&wide))[2].0 - wide[2].0).to_f64();
    assert!(f64::abs(error) < 1e-31, "{error:e}");
}

/// The angle between `(1, 0, 0)` and a vector.
struct Between;

impl Function for Between {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let first = Vector3::new(1.0, 0.0, 0.0).map(Element::<R>::lit);
        let [i, j, k] = [0, 1, 2].map(|axis| Element(x[axis]));
        angle(&first, &Vector3::new(i, j, k)).0
    }
}

#[test]
fn angles_between_vectors_are_smooth_but_for_parallel_ones() {
    for x in [
        [1.0, 1e-9, 0.0],
        [3.0, -2.0, 0.5],
        [0.0, 0.0, 7.0],
        [-2.0, 1e-7, 1e-7],
    ] {
        let across = f64::hypot(x[1], x[2]);
        assert_close(&[Between.eval(&x)], &[across.atan2(x[0])], 1e-15);
        // The slopes of `atan2(hypot(y, z), x)`, which has no cancellation.
        let expected = gradient(|x| x[1].hypot(x[2]).atan2(x[0]), &x);
        // The difference of the sides is at least 1e-9 long, with a rounding error of 1e-16.
        assert_close(&gradient(|x| Between.eval(x), &x), &expected, 1e-6);
        let report = check_gradient(&Between, &[3.0, -2.0, 0.5], &Options::default());
        assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    }
    for parallel in [[2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]] {
        assert_eq!(gradient(|x| Between.eval(x), &parallel), [0.0; 3]);
    }
}
