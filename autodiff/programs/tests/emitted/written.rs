//! Derivatives of the kernels, emitted from recordings of them: not to be edited. After a change:
//! `EMIT=1 cargo test -p cosmic-autodiff --test all emitted::`.

use autodiff::Real;

use super::guarded::{Guarded, Held};
use super::Bent;

impl Bent {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff_programs::Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        let autodiff_programs::Pullback { x, y, y_bar, .. } = at;
        let [x0, x1] = x;
        let [r0, _, r2] = y;
        let t5 = R::lit(0.0);
        let t6 = R::lit(self.stiffness);
        let t7 = x0 * t6;
        let t8 = x1 * t7;
        let t10 = R::lit(1.0);
        let t11 = t8 + t8;
        let t12 = t8.less(t5);
        let t13 = -t11;
        let t14 = R::select(t12, t11, t13);
        let t15 = t14.exp();
        let t16 = R::lit(2.0);
        let t17 = t10 + t15;
        let t18 = t17.recip();
        let t19 = t16 * t18;
        let t20 = t8.abs();
        let t21 = R::lit(0.5);
        let t22 = t20.less(t21);
        let t23 = r0 * r0;
        let t24 = t10 - t23;
        let t25 = t15 * t19;
        let t26 = t19 * t25;
        let t27 = R::select(t22, t24, t26);
        let t28 = x0.abs();
        let t29 = x0.less(t5);
        let t33 = t5.less(x0);
        let t35 = t28.sqrt();
        let t36 = t35 + t5;
        let t37 = t36.recip();
        let t38 = t21 * t37;
        let t39 = r0 + r0;
        let t40 = t10 + t23;
        let t41 = t40.recip();
        let t43 = t41 * r2;
        let t44 = -t43;
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0, y1, y2] = y_bar[m];
            let t45 = y2 * t41;
            let t46 = R::chain(t44, y2);
            let t48 = t39.fma(t46, y0);
            let t49 = R::chain(t38, t45);
            let t50 = -t49;
            let t51 = R::select(t29, t50, t5);
            let t52 = R::select(t33, t49, t51);
            let t53 = R::chain(t27, t48);
            let t54 = x1 * t53;
            let t56 = t7.fma(t53, y1);
            let t58 = t6.fma(t54, t52);
            x_bar[m] = [t58, t56];
        }
        x_bar
    }
}

impl Held {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff_programs::Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        let autodiff_programs::Pullback { x, y, y_bar, .. } = at;
        let [x0, x1] = x;
        let [_, _, _] = y;
        let t5 = R::lit(0.0);
        let t6 = x0 * x1;
        let t7 = x0.sin();
        let t8 = x0.cos();
        let t9 = x0 * t7;
        let t10 = t6.straight_through(t9);
        let t11 = x0.less(x1);
        let t12 = R::lit(1.0);
        let t15 = x0.detach();
        let t16 = R::select(t11, t15, t12);
        let t18 = t10.sin();
        let t19 = t10.cos();
        let t22 = x0 * t16;
        let t24 = t22.cos();
        let t25 = -t18;
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0, y1, y2] = y_bar[m];
            let t28 = y2 * t19;
            let t29 = y2 * t10;
            let t31 = t25.fma(t29, t28);
            let t32 = y2 * t24;
            let t33 = t15 * t32;
            let t34 = R::select(t11, t33, t32);
            let t36 = x1.fma(y1, t31);
            let t37 = y1 * t10;
            let t39 = y0.fma(t19, t36);
            let t41 = y0.fma(t15, t37);
            let t42 = t34 + t5;
            let t44 = t7.fma(t39, t42);
            let t45 = x0 * t39;
            let t47 = t8.fma(t45, t44);
            x_bar[m] = [t47, t41];
        }
        x_bar
    }
}

impl Guarded {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff_programs::Pullback<R, 2, 9, M>) -> [[R; 2]; M] {
        let autodiff_programs::Pullback { x, y, y_bar, .. } = at;
        let [x0, x1] = x;
        let [r0, _, _, _, _, _, r6, r7, _] = y;
        let t11 = R::lit(0.0);
        let t12 = t11.less(x0);
        let t13 = R::lit(1e100);
        let t14 = t13.less_equal(x0);
        let t16 = x0.ln();
        let t17 = x0 + t11;
        let t18 = t17.recip();
        let t19 = x0.less(t11);
        let t20 = R::select(t19, t16, t18);
        let t23 = x0.sqrt();
        let t24 = R::lit(0.5);
        let t25 = t23 + t11;
        let t26 = t25.recip();
        let t27 = t24 * t26;
        let t30 = r0 * r0;
        let t31 = r0 + r0;
        let t35 = R::lit(f64::INFINITY);
        let t38 = x0.exp();
        let t41 = t38.recip();
        let t42 = t38.less(t11);
        let t43 = R::select(t42, r6, t41);
        let t45 = x0 + x0;
        let t50 = r7 + t11;
        let t51 = t50.recip();
        let t52 = t24 * t51;
        let t53 = R::lit(f64::NAN);
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0, y1, y2, y3, y4, y5, y6, y7, y8] = y_bar[m];
            let t56 = R::select(t14, y8, t11);
            let t57 = R::select(t14, t11, y8);
            let t58 = R::chain(t53, t57);
            let t59 = R::chain(t52, y7);
            let t61 = t45.fma(t59, t56);
            let t62 = R::chain(t43, y6);
            let t63 = R::chain(t38, t62);
            let t64 = t61 + t63;
            let t65 = x1 * y5;
            let t66 = R::chain(t38, y5);
            let t67 = t58 + t66;
            let t68 = R::chain(t38, t65);
            let t69 = t64 + t68;
            let t70 = R::select(t14, y4, t11);
            let t71 = R::select(t14, t11, y4);
            let t72 = t69 + t70;
            let t73 = R::chain(t35, t71);
            let t74 = t67 + t73;
            let t75 = R::select(t14, y3, t11);
            let t76 = R::select(t14, t11, y3);
            let t77 = t72 + t75;
            let t78 = r0 * t76;
            let t79 = R::chain(t30, t76);
            let t80 = y0 + t79;
            let t82 = t31.fma(t78, t80);
            let t83 = R::select(t12, y2, t11);
            let t85 = R::chain(t23, t83);
            let t86 = t74 + t85;
            let t87 = x1 * t83;
            let t88 = R::chain(t27, t87);
            let t89 = t77 + t88;
            let t90 = R::select(t12, y1, t11);
            let t92 = R::chain(t20, t90);
            let t93 = t89 + t92;
            let t95 = x0.fma(t82, t86);
            let t97 = x1.fma(t82, t93);
            x_bar[m] = [t97, t95];
        }
        x_bar
    }
}
