//! Kernels whose inputs and results have names.

use autodiff::Real;
use autodiff_programs::emit::adjoint;
use autodiff_programs::kernels::Fixed;
use autodiff_programs::{Fields, Kernel, Pullback, kernel};

#[derive(Clone, Copy, Debug, PartialEq, Fields)]
struct Point<T, const D: usize>([T; D]);

/// The ends of a spring, with a number between them.
#[derive(Clone, Copy, Debug, PartialEq, Fields)]
#[autodiff(crate = "autodiff_programs")]
struct Spring<T, const D: usize> {
    tail: Point<T, D>,
    stiffness: T,
    head: Point<T, D>,
}

#[derive(Clone, Copy, Debug, PartialEq, Fields)]
struct Pulled<T> {
    energy: T,
    forces: [T; 2],
}

#[test]
fn numbers_are_in_the_order_of_the_fields() {
    let numbers = [1, 2, 3, 4, 5];
    let spring = Spring {
        tail: Point([1, 2]),
        stiffness: 3,
        head: Point([4, 5]),
    };
    assert_eq!(Spring::of(numbers), spring);
    assert_eq!(Fields::<i32>::array(spring), numbers);
    assert_eq!(Fields::<i32>::list(spring), numbers);
    // The numbers after the last field are not read.
    let all = [1, 2, 3, 4, 5, 6];
    assert_eq!(Spring::first_of(&all), spring);
    assert_eq!(<Spring<f32, 3> as Fields<f32>>::COUNT, 7);
}

struct Named;

#[kernel]
impl Kernel<_, _> for Named {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, spring: Spring<R, 2>, given: &[R]) -> Pulled<R> {
        let Spring {
            tail: Point([x0, y0]),
            stiffness,
            head: Point([x1, y1]),
        } = spring;
        let (dx, dy) = (x1 - x0, y1 - y0);
        Pulled {
            energy: stiffness * dx.hypot(dy),
            forces: [stiffness * dx * given[0], stiffness * dy],
        }
    }
}

/// The same kernel by position.
struct Listed;

#[kernel]
impl Kernel<5, 3> for Listed {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [x0, y0, stiffness, x1, y1]: [R; 5], given: &[R]) -> [R; 3] {
        let (dx, dy) = (x1 - x0, y1 - y0);
        let energy = stiffness * dx.hypot(dy);
        [energy, stiffness * dx * given[0], stiffness * dy]
    }
}

#[test]
fn names_cost_no_operation() {
    let named = adjoint("K", &["at.uniforms[0]"], |v| Fixed {
        kernel: Named,
        uniforms: v.to_vec(),
    });
    let listed = adjoint("K", &["at.uniforms[0]"], |v| Fixed {
        kernel: Listed,
        uniforms: v.to_vec(),
    });
    assert!(named.contains("Pullback<R, 5, 3, M>"), "{named}");
    assert_eq!(named, listed);
}

/// A difference, and a reverse of its own, which says that every slope is 7.
struct Sevens;

#[kernel]
impl Kernel<_, _> for Sevens {
    fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> R {
        a - b
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        at.y_bar.map(|[bar]| [bar * R::lit(7.0); 2])
    }
}

#[test]
fn a_reverse_of_its_own_is_counted_too() {
    let at = Pullback::new(&Sevens, [3.0, 1.0], &[], [[1.0], [2.0]]);
    assert_eq!(at.y, [2.0]);
    assert_eq!(Sevens.vjp(at), [[7.0; 2], [14.0; 2]]);
}
