//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::{Add, Cell, Change, Gate, Hidden, Prediction, Product};

impl Gate {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 3], y: [R; 1], y_bar: [R; 1]) -> [R; 3] {
        let [x0, x1, _] = x;
        let [r0] = y;
        let [y0] = y_bar;
        let t5 = R::lit(0.5);
        let t7 = R::lit(1.0);
        let t10 = r0.abs();
        let t11 = t10.lt(t5);
        let t13 = (-r0).fma(r0, t7);
        let t14 = t7 - r0;
        let t15 = t7 + r0;
        let t16 = t14 * t15;
        let t17 = R::select(t11, t13, t16);
        let t18 = y0 * t17;
        let t19 = t5 * t18;
        let t20 = x1 * t19;
        let t21 = x0 * t19;
        [t20, t21, t19]
    }
}

impl Change {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 3], y: [R; 1], y_bar: [R; 1]) -> [R; 3] {
        let [x0, x1, _] = x;
        let [r0] = y;
        let [y0] = y_bar;
        let t6 = R::lit(1.0);
        let t8 = r0.abs();
        let t9 = R::lit(0.5);
        let t10 = t8.lt(t9);
        let t12 = (-r0).fma(r0, t6);
        let t13 = t6 - r0;
        let t14 = t6 + r0;
        let t15 = t13 * t14;
        let t16 = R::select(t10, t12, t15);
        let t17 = y0 * t16;
        let t18 = x1 * t17;
        let t19 = x0 * t17;
        [t18, t19, t17]
    }
}

impl Cell {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 4], y: [R; 2], y_bar: [R; 2]) -> [R; 4] {
        let [x0, x1, x2, x3] = x;
        let [_, r1] = y;
        let [y0, y1] = y_bar;
        let t7 = R::lit(0.5);
        let t8 = t7.fma(x1, t7);
        let t9 = R::lit(1.0);
        let t10 = t7.fma(x2, t7);
        let t14 = r1.abs();
        let t15 = t14.lt(t7);
        let t17 = (-r1).fma(r1, t9);
        let t18 = t9 - r1;
        let t19 = t9 + r1;
        let t20 = t18 * t19;
        let t21 = R::select(t15, t17, t20);
        let t23 = y1.fma(t21, y0);
        let t24 = t8 * t23;
        let t25 = x0 * t23;
        let t26 = x3 * t23;
        let t27 = t10 * t23;
        let t28 = t7 * t26;
        let t29 = t7 * t25;
        [t24, t29, t28, t27]
    }
}

impl Hidden {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 2], y: [R; 1], y_bar: [R; 1]) -> [R; 2] {
        let [x0, x1] = x;
        let [_] = y;
        let [y0] = y_bar;
        let t4 = R::lit(0.5);
        let t5 = t4.fma(x0, t4);
        let t8 = x1 * y0;
        let t9 = y0 * t5;
        let t10 = t4 * t8;
        [t10, t9]
    }
}

impl Product {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 2], y: [R; 1], y_bar: [R; 1]) -> [R; 2] {
        let [x0, x1] = x;
        let [_] = y;
        let [y0] = y_bar;
        let t5 = x1 * y0;
        let t6 = x0 * y0;
        [t5, t6]
    }
}

impl Prediction {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 4], y: [R; 2], y_bar: [R; 2]) -> [R; 4] {
        let [x0, x1, x2, x3] = x;
        let [r0, _] = y;
        let [y0, y1] = y_bar;
        let t7 = x0.fma(x1, x2);
        let t12 = y1 * t7;
        let t13 = R::chain(r0, y0);
        let t14 = x3.fma(y1, t13);
        let t15 = x1 * t14;
        let t16 = x0 * t14;
        [t15, t16, t14, t12]
    }
}

impl Add {
    #[inline(always)]
    pub(crate) fn emitted_vjp_with_results<R: Real>(&self, x: [R; 4], y: [R; 1], y_bar: [R; 1]) -> [R; 4] {
        let [_, _, x2, x3] = x;
        let [_] = y;
        let [y0] = y_bar;
        let t5 = R::lit(0.0);
        let t8 = x2.ln();
        let t9 = x2 + t5;
        let t10 = t9.recip();
        let t11 = x2.lt(t5);
        let t12 = R::select(t11, t8, t10);
        let t16 = -y0;
        let t17 = R::chain(t8, t16);
        let t18 = x3 * t16;
        let t19 = R::chain(t12, t18);
        [y0, y0, t19, t17]
    }
}
