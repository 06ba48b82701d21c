//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib adjoints_are_fresh`.

use autodiff::Real;

use super::kernels::{Flight, Spring};

impl Spring {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 2, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3] = x;
        let [_, _] = y;
        let t7 = R::lit(1e-12);
        let t8 = x1.fma(x1, t7);
        let t10 = x1 + x1;
        let t11 = x0.fma(x0, t8);
        let t12 = x0 + x0;
        let t13 = t11.sqrt();
        let t14 = R::lit(0.5);
        let t15 = t13.recip();
        let t16 = t14 * t15;
        let t17 = t13 - x3;
        let t19 = x2 * t17;
        let t20 = R::lit(0.002);
        let t21 = t19 * t20;
        let t22 = t15 * t21;
        let t23 = t15 * t22;
        let t24 = -t23;
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t27 = x1 * y1;
            let t28 = y1 * t22;
            let t30 = x0.fma(y0, t27);
            let t31 = y0 * t22;
            let t32 = t15 * t30;
            let t34 = t20 * t32;
            let t35 = t17 * t34;
            let t36 = x2 * t34;
            let t37 = t24.fma(t30, t36);
            let t38 = -t36;
            let t39 = t16 * t37;
            let t41 = t12.fma(t39, t31);
            let t43 = t10.fma(t39, t28);
            x_bar[m] = [t41, t43, t35, t38];
        }
        x_bar
    }
}

impl Flight {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 7, 4, M>) -> [[R; 7]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, x1, x2, x3, x4, x5, x6] = x;
        let [_, _, _, _] = y;
        let t11 = R::lit(0.0);
        let t12 = R::lit(0.002);
        let t13 = R::lit(0.9607894391523232);
        let t14 = x2 * t13;
        let t15 = x4.fma(x6, t14);
        let t18 = R::lit(-0.0096);
        let t19 = x3.fma(t13, t18);
        let t20 = x5.fma(x6, t19);
        let t21 = t12.fma(t20, x1);
        let t22 = t21.less(t11);
        let t23 = t20.less(t11);
        let t24 = t22 & t23;
        let t25 = -x1;
        let t26 = R::lit(-1.0);
        let t28 = R::select(t24, t20, t26);
        let t29 = t28.recip();
        let t30 = t25 * t29;
        let t31 = t29 * t30;
        let t32 = -t31;
        let t33 = t30.less_equal(t11);
        let t35 = R::select(t33, t11, t30);
        let t36 = t12.less_equal(t35);
        let mut x_bar = [[R::zero(); 7]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t45 = R::select(t24, t11, y3);
            let t47 = R::select(t24, t11, y2);
            let t48 = y1 * t20;
            let t49 = y1 * t12;
            let t50 = R::chain(t30, y1);
            let t51 = R::select(t33, t11, t50);
            let t52 = R::select(t36, t49, t51);
            let t53 = R::select(t24, t52, t49);
            let t54 = t45 + t53;
            let t56 = y0.fma(t15, t48);
            let t57 = y0 * t12;
            let t58 = R::chain(t30, y0);
            let t59 = R::select(t33, t11, t58);
            let t60 = R::select(t36, t57, t59);
            let t61 = R::select(t24, t60, t57);
            let t62 = t47 + t61;
            let t63 = R::select(t24, t56, t11);
            let t66 = R::select(t36, t11, t63);
            let t68 = R::select(t33, t11, t66);
            let t69 = R::chain(t29, t68);
            let t70 = R::chain(t32, t68);
            let t71 = R::select(t24, t70, t11);
            let t73 = t54 + t71;
            let t74 = -t69;
            let t75 = y1 + t74;
            let t76 = x6 * t73;
            let t77 = x5 * t73;
            let t78 = t13 * t73;
            let t79 = x6 * t62;
            let t81 = x4.fma(t62, t77);
            let t82 = t13 * t62;
            x_bar[m] = [y0, t75, t82, t78, t79, t76, t81];
        }
        x_bar
    }
}
