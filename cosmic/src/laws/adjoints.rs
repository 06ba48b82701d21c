//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic-codesign --lib adjoints_are_fresh`.

use autodiff::Real;

use super::bar::Tension;
use super::bending::{Bend, Total};
use super::contact::{Drifting, Flying};
use super::coulomb::Coulomb;
use super::force::Sum;
use super::hooke::Hooke;
use super::no_ground::NoGround;
use super::stiffening::Stiffening;
use super::sticking::Sticking;

impl Flying<NoGround> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 7, 4, M>, _uniforms: &autodiff::arrays::Uniforms<R>) -> [[R; 7]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, _, _, _, x4, x5, x6] = x;
        let [_, _, _, _] = y;
        let t17 = R::lit(self.flight.decay);
        let t20 = R::lit(self.flight.drift.dt);
        let mut x_bar = [[R::zero(); 7]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t24 = y1.fma(t20, y3);
            let t26 = y0.fma(t20, y2);
            let t27 = t17 * t24;
            let t28 = t17 * t26;
            let t29 = x5 * t24;
            let t30 = x6 * t24;
            let t32 = x4.fma(t26, t29);
            let t33 = x6 * t26;
            x_bar[m] = [y0, y1, t28, t27, t33, t30, t32];
        }
        x_bar
    }
}

impl Drifting<NoGround> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, _, _, _] = x;
        let [_, _, _, _] = y;
        let t9 = R::lit(self.drift.dt);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t14 = y1.fma(t9, y3);
            let t16 = y0.fma(t9, y2);
            x_bar[m] = [y0, y1, t16, t14];
        }
        x_bar
    }
}

impl Flying<Sticking> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 7, 4, M>, uniforms: &autodiff::arrays::Uniforms<R>) -> [[R; 7]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, x1, x2, x3, x4, x5, x6] = x;
        let [_, _, _, _] = y;
        let t11 = R::lit(0.0);
        let t12 = uniforms[0];
        let t13 = uniforms[1];
        let t14 = x6.fma(x4, t12);
        let t16 = x6.fma(x5, t13);
        let t17 = R::lit(self.flight.decay);
        let t18 = t17.fma(x2, t14);
        let t19 = t17.fma(x3, t16);
        let t20 = R::lit(self.flight.drift.dt);
        let t21 = t20.fma(t19, x1);
        let t22 = t21.less(t11);
        let t23 = t19.less(t11);
        let t24 = t22 & t23;
        let t25 = R::lit(-1.0);
        let t27 = R::select(t24, t19, t25);
        let t28 = -x1;
        let t29 = t27.recip();
        let t30 = t28 * t29;
        let t31 = t29 * t30;
        let t32 = -t31;
        let t33 = t30.less_equal(t11);
        let t35 = R::select(t33, t11, t30);
        let t36 = t20.less_equal(t35);
        let mut x_bar = [[R::zero(); 7]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t45 = R::select(t24, t11, y3);
            let t47 = R::select(t24, t11, y2);
            let t48 = y1 * t19;
            let t49 = y1 * t20;
            let t50 = R::chain(t30, y1);
            let t51 = R::select(t33, t11, t50);
            let t52 = R::select(t36, t49, t51);
            let t53 = R::select(t24, t52, t49);
            let t54 = t45 + t53;
            let t56 = y0.fma(t18, t48);
            let t57 = y0 * t20;
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
            let t71 = -t69;
            let t72 = y1 + t71;
            let t73 = R::select(t24, t70, t11);
            let t75 = t54 + t73;
            let t76 = t17 * t75;
            let t77 = t17 * t62;
            let t78 = x5 * t75;
            let t79 = x6 * t75;
            let t81 = x4.fma(t62, t78);
            let t82 = x6 * t62;
            x_bar[m] = [y0, t72, t77, t76, t82, t79, t81];
        }
        x_bar
    }
}

impl Drifting<Sticking> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, x1, x2, x3] = x;
        let [_, _, _, _] = y;
        let t8 = R::lit(0.0);
        let t9 = R::lit(self.drift.dt);
        let t10 = t9.fma(x3, x1);
        let t12 = t10.less(t8);
        let t13 = x3.less(t8);
        let t14 = t12 & t13;
        let t15 = R::lit(-1.0);
        let t17 = R::select(t14, x3, t15);
        let t18 = -x1;
        let t19 = t17.recip();
        let t20 = t18 * t19;
        let t21 = t19 * t20;
        let t22 = -t21;
        let t23 = t20.less_equal(t8);
        let t25 = R::select(t23, t8, t20);
        let t26 = t9.less_equal(t25);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t35 = R::select(t14, t8, y3);
            let t37 = R::select(t14, t8, y2);
            let t38 = x3 * y1;
            let t39 = y1 * t9;
            let t40 = R::chain(t20, y1);
            let t41 = R::select(t23, t8, t40);
            let t42 = R::select(t26, t39, t41);
            let t43 = R::select(t14, t42, t39);
            let t44 = t35 + t43;
            let t46 = x2.fma(y0, t38);
            let t47 = y0 * t9;
            let t48 = R::chain(t20, y0);
            let t49 = R::select(t23, t8, t48);
            let t50 = R::select(t26, t47, t49);
            let t51 = R::select(t14, t50, t47);
            let t52 = t37 + t51;
            let t53 = R::select(t14, t46, t8);
            let t56 = R::select(t26, t8, t53);
            let t58 = R::select(t23, t8, t56);
            let t59 = R::chain(t19, t58);
            let t60 = R::chain(t22, t58);
            let t61 = -t59;
            let t62 = y1 + t61;
            let t63 = R::select(t14, t60, t8);
            let t65 = t44 + t63;
            x_bar[m] = [y0, t62, t52, t65];
        }
        x_bar
    }
}

impl Flying<Coulomb> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 7, 4, M>, uniforms: &autodiff::arrays::Uniforms<R>) -> [[R; 7]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, x1, x2, x3, x4, x5, x6] = x;
        let [_, _, _, _] = y;
        let t11 = R::lit(0.0);
        let t12 = uniforms[0];
        let t13 = uniforms[1];
        let t14 = uniforms[2];
        let t15 = x6.fma(x4, t12);
        let t16 = R::lit(1.0);
        let t17 = x6.fma(x5, t13);
        let t18 = R::lit(self.flight.decay);
        let t19 = t18.fma(x2, t15);
        let t20 = t18.fma(x3, t17);
        let t21 = R::lit(self.flight.drift.dt);
        let t22 = t21.fma(t20, x1);
        let t23 = t22.less(t11);
        let t24 = t20.less(t11);
        let t25 = t23 & t24;
        let t26 = R::lit(-1.0);
        let t28 = R::select(t25, t20, t26);
        let t29 = -x1;
        let t30 = t28.recip();
        let t31 = t29 * t30;
        let t32 = t30 * t31;
        let t33 = -t32;
        let t34 = t31.less_equal(t11);
        let t36 = R::select(t34, t11, t31);
        let t37 = t21.less_equal(t36);
        let t39 = R::select(t37, t21, t36);
        let t40 = R::select(t25, t39, t21);
        let t41 = t21 - t40;
        let t42 = t20.abs();
        let t45 = t11.less(t20);
        let t48 = t19.abs();
        let t49 = t19.less(t11);
        let t51 = R::select(t49, t26, t11);
        let t52 = t11.less(t19);
        let t53 = R::select(t52, t16, t51);
        let t54 = (-t14).fma(t42, t48);
        let t55 = t54.less_equal(t11);
        let t57 = R::select(t55, t11, t54);
        let t58 = t53 * t57;
        let t59 = t11.less(t14);
        let t61 = R::select(t59, t58, t19);
        let mut x_bar = [[R::zero(); 7]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t70 = R::select(t25, t11, y3);
            let t71 = R::select(t25, y2, t11);
            let t72 = R::select(t25, t11, y2);
            let t73 = y1 * t20;
            let t74 = y1 * t21;
            let t75 = R::chain(t31, y1);
            let t76 = R::select(t34, t11, t75);
            let t77 = R::select(t37, t74, t76);
            let t78 = R::select(t25, t77, t74);
            let t79 = t70 + t78;
            let t81 = y0.fma(t19, t73);
            let t82 = y0 * t21;
            let t83 = R::chain(t31, y0);
            let t84 = R::select(t34, t11, t83);
            let t85 = R::select(t37, t82, t84);
            let t86 = R::select(t25, t85, t82);
            let t87 = t72 + t86;
            let t88 = R::select(t25, y0, t11);
            let t90 = t61 * t88;
            let t91 = R::chain(t41, t88);
            let t92 = t71 + t91;
            let t93 = R::select(t59, t92, t11);
            let t94 = R::select(t59, t11, t92);
            let t95 = t87 + t94;
            let t96 = -t93;
            let t97 = R::select(t49, t96, t11);
            let t98 = R::select(t52, t93, t97);
            let t100 = R::select(t55, t11, t98);
            let t101 = -t100;
            let t102 = R::select(t49, t101, t11);
            let t103 = R::select(t52, t100, t102);
            let t104 = t95 + t103;
            let t105 = t14 * t101;
            let t106 = -t105;
            let t107 = R::select(t24, t106, t11);
            let t108 = R::select(t45, t105, t107);
            let t109 = t79 + t108;
            let t110 = -t90;
            let t111 = t81 + t110;
            let t112 = R::select(t25, t111, t11);
            let t115 = R::select(t37, t11, t112);
            let t117 = R::select(t34, t11, t115);
            let t118 = R::chain(t30, t117);
            let t119 = R::chain(t33, t117);
            let t120 = -t118;
            let t121 = y1 + t120;
            let t122 = R::select(t25, t119, t11);
            let t124 = t109 + t122;
            let t125 = t18 * t124;
            let t126 = t18 * t104;
            let t127 = x5 * t124;
            let t128 = x6 * t124;
            let t130 = x4.fma(t104, t127);
            let t131 = x6 * t104;
            x_bar[m] = [y0, t121, t126, t125, t131, t128, t130];
        }
        x_bar
    }
}

impl Drifting<Coulomb> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 4, 4, M>, uniforms: &autodiff::arrays::Uniforms<R>) -> [[R; 4]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, x1, x2, x3] = x;
        let [_, _, _, _] = y;
        let t8 = R::lit(0.0);
        let t9 = uniforms[0];
        let t10 = R::lit(self.drift.dt);
        let t11 = t10.fma(x3, x1);
        let t12 = R::lit(1.0);
        let t13 = t11.less(t8);
        let t14 = x3.less(t8);
        let t15 = t13 & t14;
        let t16 = R::lit(-1.0);
        let t18 = R::select(t15, x3, t16);
        let t19 = -x1;
        let t20 = t18.recip();
        let t21 = t19 * t20;
        let t22 = t20 * t21;
        let t23 = -t22;
        let t24 = t21.less_equal(t8);
        let t26 = R::select(t24, t8, t21);
        let t27 = t10.less_equal(t26);
        let t29 = R::select(t27, t10, t26);
        let t30 = R::select(t15, t29, t10);
        let t31 = t10 - t30;
        let t32 = x3.abs();
        let t35 = t8.less(x3);
        let t38 = x2.abs();
        let t39 = x2.less(t8);
        let t41 = R::select(t39, t16, t8);
        let t42 = t8.less(x2);
        let t43 = R::select(t42, t12, t41);
        let t44 = (-t9).fma(t32, t38);
        let t45 = t44.less_equal(t8);
        let t47 = R::select(t45, t8, t44);
        let t48 = t43 * t47;
        let t49 = t8.less(t9);
        let t51 = R::select(t49, t48, x2);
        let mut x_bar = [[R::zero(); 4]; M];
        for m in 0..M {
            let [y0, y1, y2, y3] = y_bar[m];
            let t60 = R::select(t15, t8, y3);
            let t61 = R::select(t15, y2, t8);
            let t62 = R::select(t15, t8, y2);
            let t63 = x3 * y1;
            let t64 = y1 * t10;
            let t65 = R::chain(t21, y1);
            let t66 = R::select(t24, t8, t65);
            let t67 = R::select(t27, t64, t66);
            let t68 = R::select(t15, t67, t64);
            let t69 = t60 + t68;
            let t71 = x2.fma(y0, t63);
            let t72 = y0 * t10;
            let t73 = R::chain(t21, y0);
            let t74 = R::select(t24, t8, t73);
            let t75 = R::select(t27, t72, t74);
            let t76 = R::select(t15, t75, t72);
            let t77 = t62 + t76;
            let t78 = R::select(t15, y0, t8);
            let t80 = t51 * t78;
            let t81 = R::chain(t31, t78);
            let t82 = t61 + t81;
            let t83 = R::select(t49, t82, t8);
            let t84 = R::select(t49, t8, t82);
            let t85 = t77 + t84;
            let t86 = -t83;
            let t87 = R::select(t39, t86, t8);
            let t88 = R::select(t42, t83, t87);
            let t90 = R::select(t45, t8, t88);
            let t91 = -t90;
            let t92 = R::select(t39, t91, t8);
            let t93 = R::select(t42, t90, t92);
            let t94 = t85 + t93;
            let t95 = t9 * t91;
            let t96 = -t95;
            let t97 = R::select(t14, t96, t8);
            let t98 = R::select(t35, t95, t97);
            let t99 = t69 + t98;
            let t100 = -t80;
            let t101 = t71 + t100;
            let t102 = R::select(t15, t101, t8);
            let t105 = R::select(t27, t8, t102);
            let t107 = R::select(t24, t8, t105);
            let t108 = R::chain(t20, t107);
            let t109 = R::chain(t23, t107);
            let t110 = -t108;
            let t111 = y1 + t110;
            let t112 = R::select(t15, t109, t8);
            let t114 = t99 + t112;
            x_bar[m] = [y0, t111, t94, t114];
        }
        x_bar
    }
}

impl Tension<Hooke> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 6, 2, M>) -> [[R; 6]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3, x4, x5] = x;
        let [_, _] = y;
        let t9 = R::lit(1e-12);
        let t10 = x1.fma(x1, t9);
        let t11 = R::lit(1.0);
        let t12 = x1 + x1;
        let t13 = x0.fma(x0, t10);
        let t14 = x0 + x0;
        let t15 = t13.sqrt();
        let t16 = R::lit(0.5);
        let t17 = t15.recip();
        let t18 = t16 * t17;
        let t19 = x5.fma(x2, t11);
        let t21 = (-x4).fma(t19, t15);
        let t23 = x3 * t21;
        let t24 = R::lit(self.dt);
        let t25 = t23 * t24;
        let t26 = t17 * t25;
        let t27 = t17 * t26;
        let t28 = -t27;
        let mut x_bar = [[R::zero(); 6]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t31 = x1 * y1;
            let t32 = y1 * t26;
            let t34 = x0.fma(y0, t31);
            let t35 = y0 * t26;
            let t36 = t17 * t34;
            let t38 = t24 * t36;
            let t39 = t21 * t38;
            let t40 = x3 * t38;
            let t41 = t28.fma(t34, t40);
            let t42 = -t40;
            let t43 = t19 * t42;
            let t44 = x4 * t42;
            let t45 = x2 * t44;
            let t46 = x5 * t44;
            let t47 = t18 * t41;
            let t49 = t14.fma(t47, t35);
            let t51 = t12.fma(t47, t32);
            x_bar[m] = [t49, t51, t46, t39, t43, t45];
        }
        x_bar
    }
}

impl Tension<Stiffening> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 6, 2, M>, uniforms: &autodiff::arrays::Uniforms<R>) -> [[R; 6]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3, x4, x5] = x;
        let [_, _] = y;
        let t9 = uniforms[0];
        let t10 = R::lit(1e-12);
        let t11 = x1.fma(x1, t10);
        let t12 = R::lit(1.0);
        let t13 = x1 + x1;
        let t14 = x0.fma(x0, t11);
        let t15 = x0 + x0;
        let t16 = t14.sqrt();
        let t17 = R::lit(0.5);
        let t18 = t16.recip();
        let t19 = t17 * t18;
        let t20 = x5.fma(x2, t12);
        let t22 = (-x4).fma(t20, t16);
        let t24 = t9 * t22;
        let t25 = t24.fma(t22, t12);
        let t26 = x3 * t22;
        let t27 = t25 * t26;
        let t28 = R::lit(self.dt);
        let t29 = t27 * t28;
        let t30 = t18 * t29;
        let t31 = t18 * t30;
        let t32 = -t31;
        let mut x_bar = [[R::zero(); 6]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t35 = x1 * y1;
            let t36 = y1 * t30;
            let t38 = x0.fma(y0, t35);
            let t39 = y0 * t30;
            let t40 = t18 * t38;
            let t42 = t28 * t40;
            let t43 = t25 * t42;
            let t44 = t26 * t42;
            let t45 = t22 * t43;
            let t46 = x3 * t43;
            let t47 = t22 * t44;
            let t49 = t24.fma(t44, t46);
            let t51 = t9.fma(t47, t49);
            let t52 = t32.fma(t38, t51);
            let t53 = -t51;
            let t54 = t20 * t53;
            let t55 = x4 * t53;
            let t56 = x2 * t55;
            let t57 = x5 * t55;
            let t58 = t19 * t52;
            let t60 = t15.fma(t58, t39);
            let t62 = t13.fma(t58, t36);
            x_bar[m] = [t60, t62, t57, t45, t54, t56];
        }
        x_bar
    }
}

impl Bend {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 8, 6, M>) -> [[R; 8]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3, x4, x5, x6, x7] = x;
        let [_, _, _, _, _, _] = y;
        let t15 = x2 - x0;
        let t18 = x3 - x1;
        let t19 = R::lit(1e-12);
        let t20 = t18.fma(t18, t19);
        let t21 = t18 + t18;
        let t22 = t15.fma(t15, t20);
        let t23 = t15 + t15;
        let t24 = t22.sqrt();
        let t25 = R::lit(0.5);
        let t26 = t24.recip();
        let t27 = t25 * t26;
        let t28 = t26 * t26;
        let t29 = -t28;
        let t30 = t15 * t26;
        let t31 = t18 * t26;
        let t32 = x4 - x2;
        let t33 = x5 - x3;
        let t34 = t33.fma(t33, t19);
        let t35 = t33 + t33;
        let t36 = t32.fma(t32, t34);
        let t37 = t32 + t32;
        let t38 = t36.sqrt();
        let t39 = t38.recip();
        let t40 = t25 * t39;
        let t41 = t39 * t39;
        let t42 = -t41;
        let t43 = t32 * t39;
        let t44 = t33 * t39;
        let t45 = R::lit(self.section);
        let t46 = x6 * t45;
        let t47 = x7 * t46;
        let t48 = x6 + x7;
        let t49 = t48 + t19;
        let t50 = t49.recip();
        let t51 = t47 * t50;
        let t52 = t50 * t51;
        let t53 = -t52;
        let t54 = R::lit(self.dt);
        let t55 = t51 * t54;
        let t56 = t30 * t44;
        let t57 = t31 * t43;
        let t58 = t56 - t57;
        let t59 = t31 * t58;
        let t60 = -t59;
        let t61 = t30 * t58;
        let t62 = -t60;
        let t63 = -t61;
        let t64 = t26 * t55;
        let t67 = t57 - t56;
        let t68 = t44 * t67;
        let t69 = -t68;
        let t70 = t43 * t67;
        let t71 = t39 * t55;
        let mut x_bar = [[R::zero(); 8]; M];
        for m in 0..M {
            let [y0, y1, y2, y3, y4, y5] = y_bar[m];
            let t78 = -y3;
            let t79 = -y2;
            let t80 = y1 + t78;
            let t81 = y5 + t78;
            let t82 = y0 + t79;
            let t83 = y4 + t79;
            let t84 = t70 * t81;
            let t85 = R::chain(t71, t81);
            let t87 = t69.fma(t83, t84);
            let t88 = R::chain(t71, t83);
            let t89 = t39 * t87;
            let t90 = R::chain(t55, t87);
            let t91 = t43 * t85;
            let t92 = t67 * t85;
            let t93 = -t88;
            let t95 = t44.fma(t93, t91);
            let t96 = t67 * t93;
            let t97 = -t95;
            let t99 = t30.fma(t97, t96);
            let t100 = t44 * t97;
            let t102 = t31.fma(t95, t92);
            let t103 = t43 * t95;
            let t104 = t63 * t80;
            let t105 = R::chain(t64, t80);
            let t107 = t62.fma(t82, t104);
            let t108 = R::chain(t64, t82);
            let t110 = t26.fma(t107, t89);
            let t111 = R::chain(t55, t107);
            let t112 = -t105;
            let t113 = -t108;
            let t114 = t30 * t112;
            let t116 = t58.fma(t112, t100);
            let t117 = -t113;
            let t119 = t31.fma(t117, t114);
            let t121 = t58.fma(t117, t103);
            let t122 = -t119;
            let t124 = t43.fma(t122, t121);
            let t126 = t31.fma(t122, t102);
            let t128 = t44.fma(t119, t116);
            let t130 = t30.fma(t119, t99);
            let t131 = t54 * t110;
            let t132 = R::chain(t50, t131);
            let t133 = R::chain(t53, t131);
            let t134 = x7 * t132;
            let t136 = t46.fma(t132, t133);
            let t138 = t45.fma(t134, t133);
            let t140 = t33.fma(t130, t90);
            let t141 = t39 * t130;
            let t143 = t32.fma(t126, t140);
            let t144 = t39 * t126;
            let t145 = t42 * t143;
            let t146 = t40 * t145;
            let t148 = t37.fma(t146, t144);
            let t150 = t35.fma(t146, t141);
            let t151 = -t150;
            let t152 = -t148;
            let t154 = t18.fma(t124, t111);
            let t155 = t26 * t124;
            let t157 = t15.fma(t128, t154);
            let t158 = t26 * t128;
            let t159 = t29 * t157;
            let t160 = t27 * t159;
            let t162 = t23.fma(t160, t158);
            let t164 = t21.fma(t160, t155);
            let t165 = t151 + t164;
            let t166 = -t164;
            let t167 = t152 + t162;
            let t168 = -t162;
            x_bar[m] = [t168, t166, t167, t165, t148, t150, t138, t136];
        }
        x_bar
    }
}

impl Total {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 5, 1, M>) -> [[R; 5]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, _, _, _, _] = x;
        let [_] = y;
        let mut x_bar = [[R::zero(); 5]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            x_bar[m] = [y0, y0, y0, y0, y0];
        }
        x_bar
    }
}

impl Sum {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 2, 1, M>) -> [[R; 2]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [_, _] = x;
        let [_] = y;
        let mut x_bar = [[R::zero(); 2]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            x_bar[m] = [y0, y0];
        }
        x_bar
    }
}
