//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic --lib adjoints_are_fresh`.

use autodiff::{Adjoint, Real};

use super::kernels::{Drift, Flight, Sliding, SlidingDrift, Spring, Sticking, StickingDrift};
use super::trap::Trapped;

impl Adjoint<6, 2> for Spring {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 6], y_bar: [R; 2]) -> [R; 6] {
        let [x0, x1, x2, x3, x4, x5] = x;
        let [y0, y1] = y_bar;
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
        [t49, t51, t46, t39, t43, t45]
    }
}

impl Adjoint<7, 4> for Flight {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        let [_, _, _, _, x4, x5, x6] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t15 = R::lit(self.decay);
        let t20 = R::lit(self.drift.dt);
        let t24 = y1.fma(t20, y3);
        let t26 = y0.fma(t20, y2);
        let t27 = t15 * t24;
        let t28 = x6 * t24;
        let t29 = x5 * t24;
        let t30 = t15 * t26;
        let t31 = x6 * t26;
        let t33 = x4.fma(t26, t29);
        [y0, y1, t30, t27, t31, t28, t33]
    }
}

impl Adjoint<7, 4> for Sticking {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        let [_, x1, x2, x3, x4, x5, x6] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t11 = R::lit(0.0);
        let t12 = R::lit(self.0.gravity[0]);
        let t13 = x4.fma(x6, t12);
        let t15 = R::lit(self.0.decay);
        let t16 = t15.fma(x2, t13);
        let t17 = R::lit(self.0.gravity[1]);
        let t18 = x5.fma(x6, t17);
        let t19 = t15.fma(x3, t18);
        let t20 = R::lit(self.0.drift.dt);
        let t21 = t20.fma(t19, x1);
        let t22 = t21.lt(t11);
        let t23 = t19.lt(t11);
        let t24 = t22 & t23;
        let t25 = R::lit(-1.0);
        let t27 = R::select(t24, t19, t25);
        let t30 = -x1;
        let t31 = t27.recip();
        let t32 = t30 * t31;
        let t33 = t31 * t32;
        let t34 = -t33;
        let t35 = t32.le(t11);
        let t37 = R::select(t35, t11, t32);
        let t40 = t20.le(t37);
        let t50 = R::select(t24, t11, y3);
        let t51 = R::select(t24, t11, y2);
        let t52 = y1 * t19;
        let t53 = y1 * t20;
        let t54 = R::chain(t32, y1);
        let t55 = R::select(t35, t11, t54);
        let t56 = R::select(t40, t53, t55);
        let t57 = R::select(t24, t56, t53);
        let t58 = t50 + t57;
        let t60 = y0.fma(t16, t52);
        let t61 = y0 * t20;
        let t62 = R::chain(t32, y0);
        let t63 = R::select(t35, t11, t62);
        let t64 = R::select(t40, t61, t63);
        let t65 = R::select(t24, t64, t61);
        let t66 = t51 + t65;
        let t67 = R::select(t24, t60, t11);
        let t68 = R::select(t40, t11, t67);
        let t69 = R::select(t35, t11, t68);
        let t70 = R::chain(t31, t69);
        let t71 = R::chain(t34, t69);
        let t72 = -t70;
        let t73 = y1 + t72;
        let t74 = R::select(t24, t71, t11);
        let t75 = t58 + t74;
        let t76 = t15 * t75;
        let t77 = x6 * t75;
        let t78 = x5 * t75;
        let t79 = t15 * t66;
        let t80 = x6 * t66;
        let t82 = x4.fma(t66, t78);
        [y0, t73, t79, t76, t80, t77, t82]
    }
}

impl Adjoint<7, 4> for Sliding {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 4]) -> [R; 7] {
        let [_, x1, x2, x3, x4, x5, x6] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t11 = R::lit(0.0);
        let t12 = R::lit(self.flight.gravity[0]);
        let t13 = x4.fma(x6, t12);
        let t14 = R::lit(1.0);
        let t15 = R::lit(self.flight.decay);
        let t16 = t15.fma(x2, t13);
        let t17 = R::lit(self.flight.gravity[1]);
        let t18 = x5.fma(x6, t17);
        let t19 = t15.fma(x3, t18);
        let t20 = R::lit(self.flight.drift.dt);
        let t21 = t20.fma(t19, x1);
        let t22 = t21.lt(t11);
        let t23 = t19.lt(t11);
        let t24 = t22 & t23;
        let t25 = R::lit(-1.0);
        let t27 = R::select(t24, t19, t25);
        let t30 = -x1;
        let t31 = t27.recip();
        let t32 = t30 * t31;
        let t33 = t31 * t32;
        let t34 = -t33;
        let t35 = t32.le(t11);
        let t37 = R::select(t35, t11, t32);
        let t40 = t20.le(t37);
        let t42 = R::select(t40, t20, t37);
        let t45 = R::select(t24, t42, t20);
        let t46 = t16.abs();
        let t47 = t16.lt(t11);
        let t48 = R::select(t47, t25, t11);
        let t49 = t11.lt(t16);
        let t50 = R::select(t49, t14, t48);
        let t51 = R::lit(self.friction);
        let t52 = t19.abs();
        let t54 = t11.lt(t19);
        let t57 = (-t51).fma(t52, t46);
        let t58 = t57.le(t11);
        let t60 = R::select(t58, t11, t57);
        let t63 = t50 * t60;
        let t64 = t20 - t45;
        let t72 = R::select(t24, t11, y3);
        let t73 = R::select(t24, y2, t11);
        let t74 = R::select(t24, t11, y2);
        let t75 = y1 * t19;
        let t76 = y1 * t20;
        let t77 = R::chain(t32, y1);
        let t78 = R::select(t35, t11, t77);
        let t79 = R::select(t40, t76, t78);
        let t80 = R::select(t24, t79, t76);
        let t81 = t72 + t80;
        let t82 = R::select(t24, y0, t11);
        let t83 = t63 * t82;
        let t84 = R::chain(t64, t82);
        let t85 = t73 + t84;
        let t87 = y0.fma(t16, t75);
        let t88 = y0 * t20;
        let t89 = R::chain(t32, y0);
        let t90 = R::select(t35, t11, t89);
        let t91 = R::select(t40, t88, t90);
        let t92 = R::select(t24, t91, t88);
        let t93 = t74 + t92;
        let t94 = -t83;
        let t95 = t87 + t94;
        let t96 = -t85;
        let t97 = R::select(t47, t96, t11);
        let t98 = R::select(t49, t85, t97);
        let t99 = R::select(t58, t11, t98);
        let t100 = -t99;
        let t101 = t51 * t100;
        let t102 = -t101;
        let t103 = R::select(t23, t102, t11);
        let t104 = R::select(t54, t101, t103);
        let t105 = t81 + t104;
        let t106 = R::select(t47, t100, t11);
        let t107 = R::select(t49, t99, t106);
        let t108 = t93 + t107;
        let t109 = R::select(t24, t95, t11);
        let t110 = R::select(t40, t11, t109);
        let t111 = R::select(t35, t11, t110);
        let t112 = R::chain(t31, t111);
        let t113 = R::chain(t34, t111);
        let t114 = -t112;
        let t115 = y1 + t114;
        let t116 = R::select(t24, t113, t11);
        let t117 = t105 + t116;
        let t118 = t15 * t117;
        let t119 = x6 * t117;
        let t120 = x5 * t117;
        let t121 = t15 * t108;
        let t122 = x6 * t108;
        let t124 = x4.fma(t108, t120);
        [y0, t115, t121, t118, t122, t119, t124]
    }
}

impl Adjoint<4, 4> for Drift {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        let [_, _, _, _] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t9 = R::lit(self.dt);
        let t14 = y1.fma(t9, y3);
        let t16 = y0.fma(t9, y2);
        [y0, y1, t16, t14]
    }
}

impl Adjoint<4, 4> for StickingDrift {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        let [_, x1, x2, x3] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t8 = R::lit(0.0);
        let t9 = R::lit(self.0.dt);
        let t10 = t9.fma(x3, x1);
        let t12 = t10.lt(t8);
        let t13 = x3.lt(t8);
        let t14 = t12 & t13;
        let t15 = R::lit(-1.0);
        let t17 = R::select(t14, x3, t15);
        let t20 = -x1;
        let t21 = t17.recip();
        let t22 = t20 * t21;
        let t23 = t21 * t22;
        let t24 = -t23;
        let t25 = t22.le(t8);
        let t27 = R::select(t25, t8, t22);
        let t30 = t9.le(t27);
        let t40 = R::select(t14, t8, y3);
        let t41 = R::select(t14, t8, y2);
        let t42 = x3 * y1;
        let t43 = y1 * t9;
        let t44 = R::chain(t22, y1);
        let t45 = R::select(t25, t8, t44);
        let t46 = R::select(t30, t43, t45);
        let t47 = R::select(t14, t46, t43);
        let t48 = t40 + t47;
        let t50 = x2.fma(y0, t42);
        let t51 = y0 * t9;
        let t52 = R::chain(t22, y0);
        let t53 = R::select(t25, t8, t52);
        let t54 = R::select(t30, t51, t53);
        let t55 = R::select(t14, t54, t51);
        let t56 = t41 + t55;
        let t57 = R::select(t14, t50, t8);
        let t58 = R::select(t30, t8, t57);
        let t59 = R::select(t25, t8, t58);
        let t60 = R::chain(t21, t59);
        let t61 = R::chain(t24, t59);
        let t62 = -t60;
        let t63 = y1 + t62;
        let t64 = R::select(t14, t61, t8);
        let t65 = t48 + t64;
        [y0, t63, t56, t65]
    }
}

impl Adjoint<4, 4> for SlidingDrift {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        let [_, x1, x2, x3] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t8 = R::lit(0.0);
        let t9 = R::lit(self.drift.dt);
        let t10 = t9.fma(x3, x1);
        let t11 = R::lit(1.0);
        let t12 = t10.lt(t8);
        let t13 = x3.lt(t8);
        let t14 = t12 & t13;
        let t15 = R::lit(-1.0);
        let t17 = R::select(t14, x3, t15);
        let t20 = -x1;
        let t21 = t17.recip();
        let t22 = t20 * t21;
        let t23 = t21 * t22;
        let t24 = -t23;
        let t25 = t22.le(t8);
        let t27 = R::select(t25, t8, t22);
        let t30 = t9.le(t27);
        let t32 = R::select(t30, t9, t27);
        let t35 = R::select(t14, t32, t9);
        let t36 = x2.abs();
        let t37 = x2.lt(t8);
        let t38 = R::select(t37, t15, t8);
        let t39 = t8.lt(x2);
        let t40 = R::select(t39, t11, t38);
        let t41 = R::lit(self.friction);
        let t42 = x3.abs();
        let t44 = t8.lt(x3);
        let t47 = (-t41).fma(t42, t36);
        let t48 = t47.le(t8);
        let t50 = R::select(t48, t8, t47);
        let t53 = t40 * t50;
        let t54 = t9 - t35;
        let t62 = R::select(t14, t8, y3);
        let t63 = R::select(t14, y2, t8);
        let t64 = R::select(t14, t8, y2);
        let t65 = x3 * y1;
        let t66 = y1 * t9;
        let t67 = R::chain(t22, y1);
        let t68 = R::select(t25, t8, t67);
        let t69 = R::select(t30, t66, t68);
        let t70 = R::select(t14, t69, t66);
        let t71 = t62 + t70;
        let t72 = R::select(t14, y0, t8);
        let t73 = t53 * t72;
        let t74 = R::chain(t54, t72);
        let t75 = t63 + t74;
        let t77 = x2.fma(y0, t65);
        let t78 = y0 * t9;
        let t79 = R::chain(t22, y0);
        let t80 = R::select(t25, t8, t79);
        let t81 = R::select(t30, t78, t80);
        let t82 = R::select(t14, t81, t78);
        let t83 = t64 + t82;
        let t84 = -t73;
        let t85 = t77 + t84;
        let t86 = -t75;
        let t87 = R::select(t37, t86, t8);
        let t88 = R::select(t39, t75, t87);
        let t89 = R::select(t48, t8, t88);
        let t90 = -t89;
        let t91 = t41 * t90;
        let t92 = -t91;
        let t93 = R::select(t13, t92, t8);
        let t94 = R::select(t44, t91, t93);
        let t95 = t71 + t94;
        let t96 = R::select(t37, t90, t8);
        let t97 = R::select(t39, t89, t96);
        let t98 = t83 + t97;
        let t99 = R::select(t14, t85, t8);
        let t100 = R::select(t30, t8, t99);
        let t101 = R::select(t25, t8, t100);
        let t102 = R::chain(t21, t101);
        let t103 = R::chain(t24, t101);
        let t104 = -t102;
        let t105 = y1 + t104;
        let t106 = R::select(t14, t103, t8);
        let t107 = t95 + t106;
        [y0, t105, t98, t107]
    }
}

impl Adjoint<7, 4> for Trapped<Flight> {}
impl Adjoint<7, 4> for Trapped<Sticking> {}
impl Adjoint<7, 4> for Trapped<Sliding> {}
