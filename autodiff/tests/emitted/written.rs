//! Derivatives of the kernels, emitted from recordings of them: not to be edited. After a change:
//! `EMIT=1 cargo test -p cosmic-autodiff --test all emitted::`.

use autodiff::Real;

use super::guarded::{Guarded, Held};
use super::Bent;

impl Bent {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar, .. } = at;
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
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar, .. } = at;
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
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 12, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar, .. } = at;
        let [x0, x1] = x;
        let [r0, _, _, _, _, _, _, r7, r8, _, _, _] = y;
        let t14 = R::lit(0.0);
        let t15 = R::lit(1.0);
        let t16 = t14.less(x0);
        let t17 = R::lit(1e100);
        let t18 = t17.less_equal(x0);
        let t20 = x0.ln();
        let t21 = x0 + t14;
        let t22 = t21.recip();
        let t23 = x0.less(t14);
        let t24 = R::select(t23, t20, t22);
        let t27 = x0.sqrt();
        let t28 = R::lit(0.5);
        let t29 = t27 + t14;
        let t30 = t29.recip();
        let t31 = t28 * t30;
        let t34 = R::lit(30.0);
        let t35 = x0.less(t34);
        let t36 = x0.exp();
        let t37 = t15 + t36;
        let t38 = t37.ln();
        let t39 = t37.recip();
        let t40 = t37.less(t14);
        let t41 = R::select(t40, t38, t39);
        let t44 = r0 * r0;
        let t45 = r0 + r0;
        let t46 = r0 * t44;
        let t49 = R::lit(f64::INFINITY);
        let t54 = t36.recip();
        let t55 = t36.less(t14);
        let t56 = R::select(t55, r7, t54);
        let t58 = x0 + x0;
        let t62 = r8 + t14;
        let t63 = t62.recip();
        let t64 = t28 * t63;
        let t65 = R::lit(f64::NEG_INFINITY);
        let t68 = R::lit(f64::NAN);
        let t72 = t46.cos();
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0, y1, y2, y3, y4, y5, y6, y7, y8, y9, y10, y11] = y_bar[m];
            let t74 = R::select(t18, y11, t14);
            let t75 = R::select(t18, t14, y11);
            let t76 = R::chain(t72, t75);
            let t77 = r0 * t76;
            let t78 = R::chain(t44, t76);
            let t79 = y0 + t78;
            let t81 = t45.fma(t77, t79);
            let t82 = R::select(t18, y10, t14);
            let t83 = R::select(t18, t14, y10);
            let t84 = t74 + t82;
            let t85 = R::chain(t68, t83);
            let t86 = R::select(t18, y9, t14);
            let t87 = R::select(t18, t14, y9);
            let t88 = t84 + t86;
            let t89 = R::chain(t65, t87);
            let t90 = t85 + t89;
            let t91 = R::chain(t64, y8);
            let t93 = t58.fma(t91, t88);
            let t94 = R::chain(t56, y7);
            let t95 = R::chain(t36, t94);
            let t96 = t93 + t95;
            let t97 = x1 * y6;
            let t98 = R::chain(t36, y6);
            let t99 = t90 + t98;
            let t100 = R::chain(t36, t97);
            let t101 = t96 + t100;
            let t102 = R::select(t18, y5, t14);
            let t103 = R::select(t18, t14, y5);
            let t104 = t101 + t102;
            let t105 = R::chain(t49, t103);
            let t106 = t99 + t105;
            let t107 = R::select(t18, y4, t14);
            let t108 = R::select(t18, t14, y4);
            let t109 = t104 + t107;
            let t110 = r0 * t108;
            let t111 = R::chain(t44, t108);
            let t112 = t81 + t111;
            let t114 = t45.fma(t110, t112);
            let t115 = R::select(t35, y3, t14);
            let t116 = R::select(t35, t14, y3);
            let t117 = t109 + t116;
            let t118 = R::chain(t41, t115);
            let t119 = R::chain(t36, t118);
            let t120 = t117 + t119;
            let t121 = R::select(t16, y2, t14);
            let t123 = R::chain(t27, t121);
            let t124 = t106 + t123;
            let t125 = x1 * t121;
            let t126 = R::chain(t31, t125);
            let t127 = t120 + t126;
            let t128 = R::select(t16, y1, t14);
            let t130 = R::chain(t24, t128);
            let t131 = t127 + t130;
            let t133 = x0.fma(t114, t124);
            let t135 = x1.fma(t114, t131);
            x_bar[m] = [t135, t133];
        }
        x_bar
    }
}
