//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::{Add, Cell, Change, Gate, Hidden, Prediction, Product};

impl Gate {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 3, 1, M>) -> [[R; 3]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2] = x;
        let [r0] = y;
        let t4 = R::lit(0.0);
        let t5 = R::lit(0.5);
        let t6 = x0.fma(x1, x2);
        let t7 = R::lit(1.0);
        let t8 = t5 * t6;
        let t10 = t8 + t8;
        let t11 = t8.less(t4);
        let t12 = -t10;
        let t13 = R::select(t11, t10, t12);
        let t14 = t13.exp();
        let t15 = R::lit(2.0);
        let t16 = t7 + t14;
        let t17 = t16.recip();
        let t18 = t15 * t17;
        let t19 = t8.abs();
        let t20 = t19.less(t5);
        let t22 = (-r0).fma(r0, t7);
        let t23 = t14 * t18;
        let t24 = t18 * t23;
        let t25 = R::select(t20, t22, t24);
        let mut x_bar = [[R::zero(); 3]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t26 = R::chain(t25, y0);
            let t27 = t5 * t26;
            let t28 = x1 * t27;
            let t29 = x0 * t27;
            x_bar[m] = [t28, t29, t27];
        }
        x_bar
    }
}

impl Change {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 3, 1, M>) -> [[R; 3]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2] = x;
        let [r0] = y;
        let t4 = R::lit(0.0);
        let t5 = x0.fma(x1, x2);
        let t6 = R::lit(1.0);
        let t8 = t5 + t5;
        let t9 = t5.less(t4);
        let t10 = -t8;
        let t11 = R::select(t9, t8, t10);
        let t12 = t11.exp();
        let t13 = R::lit(2.0);
        let t14 = t6 + t12;
        let t15 = t14.recip();
        let t16 = t13 * t15;
        let t17 = t5.abs();
        let t18 = R::lit(0.5);
        let t19 = t17.less(t18);
        let t21 = (-r0).fma(r0, t6);
        let t22 = t12 * t16;
        let t23 = t16 * t22;
        let t24 = R::select(t19, t21, t23);
        let mut x_bar = [[R::zero(); 3]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t25 = R::chain(t24, y0);
            let t26 = x1 * t25;
            let t27 = x0 * t25;
            x_bar[m] = [t26, t27, t25];
        }
        x_bar
    }
}

impl Cell {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 2, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3] = x;
        let [r0, r1] = y;
        let t6 = R::lit(0.0);
        let t7 = R::lit(0.5);
        let t8 = t7.fma(x1, t7);
        let t9 = R::lit(1.0);
        let t10 = t7.fma(x2, t7);
        let t14 = r0 + r0;
        let t15 = r0.less(t6);
        let t16 = -t14;
        let t17 = R::select(t15, t14, t16);
        let t18 = t17.exp();
        let t19 = R::lit(2.0);
        let t20 = t9 + t18;
        let t21 = t20.recip();
        let t22 = t19 * t21;
        let t23 = r0.abs();
        let t24 = t23.less(t7);
        let t26 = (-r1).fma(r1, t9);
        let t27 = t18 * t22;
        let t28 = t22 * t27;
        let t29 = R::select(t24, t26, t28);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t30 = R::chain(t29, y1);
            let t31 = y0 + t30;
            let t32 = t8 * t31;
            let t33 = x0 * t31;
            let t34 = x3 * t31;
            let t35 = t10 * t31;
            let t36 = t7 * t34;
            let t37 = t7 * t33;
            x_bar[m] = [t32, t37, t36, t35];
        }
        x_bar
    }
}

impl Hidden {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 1, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1] = x;
        let [_] = y;
        let t4 = R::lit(0.5);
        let t5 = t4.fma(x0, t4);
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t8 = x1 * y0;
            let t9 = y0 * t5;
            let t10 = t4 * t8;
            x_bar[m] = [t10, t9];
        }
        x_bar
    }
}

impl Product {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 1, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1] = x;
        let [_] = y;
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t5 = x1 * y0;
            let t6 = x0 * y0;
            x_bar[m] = [t5, t6];
        }
        x_bar
    }
}

impl Prediction {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 2, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3] = x;
        let [r0, _] = y;
        let t7 = x0.fma(x1, x2);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t12 = y1 * t7;
            let t13 = R::chain(r0, y0);
            let t14 = x3.fma(y1, t13);
            let t15 = x1 * t14;
            let t16 = x0 * t14;
            x_bar[m] = [t15, t16, t14, t12];
        }
        x_bar
    }
}

impl Add {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 1, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, _, x2, x3] = x;
        let [_] = y;
        let t5 = R::lit(0.0);
        let t8 = x2.ln();
        let t9 = x2 + t5;
        let t10 = t9.recip();
        let t11 = x2.less(t5);
        let t12 = R::select(t11, t8, t10);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t16 = -y0;
            let t17 = R::chain(t8, t16);
            let t18 = x3 * t16;
            let t19 = R::chain(t12, t18);
            x_bar[m] = [y0, y0, t19, t17];
        }
        x_bar
    }
}
