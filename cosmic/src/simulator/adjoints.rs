//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic --lib adjoints_are_fresh`.

use autodiff::{Adjoint, Real};

use super::kernels::{
    Bend, Flight, FreeDrift, Sliding, SlidingDrift, Spring, Sticking, StickingDrift, Stiffening, Total,
};

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
        let t14 = R::lit(1.0);
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
        let t28 = R::select(t24, t14, t11);
        let t29 = -x1;
        let t30 = t27.recip();
        let t31 = t29 * t30;
        let t32 = t30 * t31;
        let t33 = -t32;
        let t34 = t31.le(t11);
        let t36 = R::select(t34, t11, t31);
        let t37 = R::select(t34, t14, t11);
        let t38 = t20.le(t36);
        let t41 = R::select(t38, t14, t11);
        let t47 = t11.lt(t28);
        let t48 = !t47;
        let t49 = R::select(t48, y3, t11);
        let t50 = R::select(t48, y2, t11);
        let t51 = y1 * t19;
        let t52 = y1 * t20;
        let t53 = R::chain(t31, y1);
        let t54 = R::select(t34, t11, t53);
        let t55 = R::select(t38, t52, t54);
        let t56 = R::select(t24, t55, t52);
        let t57 = t49 + t56;
        let t59 = y0.fma(t16, t51);
        let t60 = y0 * t20;
        let t61 = R::chain(t31, y0);
        let t62 = R::select(t34, t11, t61);
        let t63 = R::select(t38, t60, t62);
        let t64 = R::select(t24, t63, t60);
        let t65 = t50 + t64;
        let t66 = R::select(t47, t59, t11);
        let t67 = t11.lt(t41);
        let t68 = !t67;
        let t69 = R::select(t68, t66, t11);
        let t70 = t11.lt(t37);
        let t71 = !t70;
        let t72 = R::select(t71, t69, t11);
        let t73 = R::chain(t30, t72);
        let t74 = R::chain(t33, t72);
        let t75 = -t73;
        let t76 = y1 + t75;
        let t77 = R::select(t47, t74, t11);
        let t78 = t57 + t77;
        let t79 = t15 * t78;
        let t80 = x6 * t78;
        let t81 = x5 * t78;
        let t82 = t15 * t65;
        let t83 = x6 * t65;
        let t85 = x4.fma(t65, t81);
        [y0, t76, t82, t79, t83, t80, t85]
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
        let t28 = R::select(t24, t14, t11);
        let t29 = -x1;
        let t30 = t27.recip();
        let t31 = t29 * t30;
        let t32 = t30 * t31;
        let t33 = -t32;
        let t34 = t31.le(t11);
        let t36 = R::select(t34, t11, t31);
        let t37 = R::select(t34, t14, t11);
        let t38 = t20.le(t36);
        let t40 = R::select(t38, t20, t36);
        let t41 = R::select(t38, t14, t11);
        let t42 = R::select(t24, t40, t20);
        let t43 = t16.abs();
        let t44 = t16.lt(t11);
        let t45 = R::select(t44, t25, t11);
        let t46 = t11.lt(t16);
        let t47 = R::select(t46, t14, t45);
        let t48 = R::lit(self.friction);
        let t49 = t19.abs();
        let t51 = t11.lt(t19);
        let t54 = (-t48).fma(t49, t43);
        let t55 = t54.le(t11);
        let t57 = R::select(t55, t11, t54);
        let t58 = R::select(t55, t14, t11);
        let t59 = t47 * t57;
        let t60 = t20 - t42;
        let t68 = t11.lt(t28);
        let t69 = !t68;
        let t70 = R::select(t69, y3, t11);
        let t71 = R::select(t68, y2, t11);
        let t72 = R::select(t69, y2, t11);
        let t73 = y1 * t19;
        let t74 = y1 * t20;
        let t75 = R::chain(t31, y1);
        let t76 = R::select(t34, t11, t75);
        let t77 = R::select(t38, t74, t76);
        let t78 = R::select(t24, t77, t74);
        let t79 = t70 + t78;
        let t80 = R::select(t68, y0, t11);
        let t81 = t59 * t80;
        let t82 = R::chain(t60, t80);
        let t83 = t71 + t82;
        let t85 = y0.fma(t16, t73);
        let t86 = y0 * t20;
        let t87 = R::chain(t31, y0);
        let t88 = R::select(t34, t11, t87);
        let t89 = R::select(t38, t86, t88);
        let t90 = R::select(t24, t89, t86);
        let t91 = t72 + t90;
        let t92 = -t81;
        let t93 = t85 + t92;
        let t94 = -t83;
        let t95 = R::select(t44, t94, t11);
        let t96 = R::select(t46, t83, t95);
        let t97 = t11.lt(t58);
        let t98 = !t97;
        let t99 = R::select(t98, t96, t11);
        let t100 = -t99;
        let t101 = t48 * t100;
        let t102 = -t101;
        let t103 = R::select(t23, t102, t11);
        let t104 = R::select(t51, t101, t103);
        let t105 = t79 + t104;
        let t106 = R::select(t44, t100, t11);
        let t107 = R::select(t46, t99, t106);
        let t108 = t91 + t107;
        let t109 = R::select(t68, t93, t11);
        let t110 = t11.lt(t41);
        let t111 = !t110;
        let t112 = R::select(t111, t109, t11);
        let t113 = t11.lt(t37);
        let t114 = !t113;
        let t115 = R::select(t114, t112, t11);
        let t116 = R::chain(t30, t115);
        let t117 = R::chain(t33, t115);
        let t118 = -t116;
        let t119 = y1 + t118;
        let t120 = R::select(t68, t117, t11);
        let t121 = t105 + t120;
        let t122 = t15 * t121;
        let t123 = x6 * t121;
        let t124 = x5 * t121;
        let t125 = t15 * t108;
        let t126 = x6 * t108;
        let t128 = x4.fma(t108, t124);
        [y0, t119, t125, t122, t126, t123, t128]
    }
}

impl Adjoint<4, 4> for FreeDrift {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 4], y_bar: [R; 4]) -> [R; 4] {
        let [_, _, _, _] = x;
        let [y0, y1, y2, y3] = y_bar;
        let t9 = R::lit(self.0.dt);
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
        let t11 = R::lit(1.0);
        let t12 = t10.lt(t8);
        let t13 = x3.lt(t8);
        let t14 = t12 & t13;
        let t15 = R::lit(-1.0);
        let t17 = R::select(t14, x3, t15);
        let t18 = R::select(t14, t11, t8);
        let t19 = -x1;
        let t20 = t17.recip();
        let t21 = t19 * t20;
        let t22 = t20 * t21;
        let t23 = -t22;
        let t24 = t21.le(t8);
        let t26 = R::select(t24, t8, t21);
        let t27 = R::select(t24, t11, t8);
        let t28 = t9.le(t26);
        let t31 = R::select(t28, t11, t8);
        let t37 = t8.lt(t18);
        let t38 = !t37;
        let t39 = R::select(t38, y3, t8);
        let t40 = R::select(t38, y2, t8);
        let t41 = x3 * y1;
        let t42 = y1 * t9;
        let t43 = R::chain(t21, y1);
        let t44 = R::select(t24, t8, t43);
        let t45 = R::select(t28, t42, t44);
        let t46 = R::select(t14, t45, t42);
        let t47 = t39 + t46;
        let t49 = x2.fma(y0, t41);
        let t50 = y0 * t9;
        let t51 = R::chain(t21, y0);
        let t52 = R::select(t24, t8, t51);
        let t53 = R::select(t28, t50, t52);
        let t54 = R::select(t14, t53, t50);
        let t55 = t40 + t54;
        let t56 = R::select(t37, t49, t8);
        let t57 = t8.lt(t31);
        let t58 = !t57;
        let t59 = R::select(t58, t56, t8);
        let t60 = t8.lt(t27);
        let t61 = !t60;
        let t62 = R::select(t61, t59, t8);
        let t63 = R::chain(t20, t62);
        let t64 = R::chain(t23, t62);
        let t65 = -t63;
        let t66 = y1 + t65;
        let t67 = R::select(t37, t64, t8);
        let t68 = t47 + t67;
        [y0, t66, t55, t68]
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
        let t18 = R::select(t14, t11, t8);
        let t19 = -x1;
        let t20 = t17.recip();
        let t21 = t19 * t20;
        let t22 = t20 * t21;
        let t23 = -t22;
        let t24 = t21.le(t8);
        let t26 = R::select(t24, t8, t21);
        let t27 = R::select(t24, t11, t8);
        let t28 = t9.le(t26);
        let t30 = R::select(t28, t9, t26);
        let t31 = R::select(t28, t11, t8);
        let t32 = R::select(t14, t30, t9);
        let t33 = x2.abs();
        let t34 = x2.lt(t8);
        let t35 = R::select(t34, t15, t8);
        let t36 = t8.lt(x2);
        let t37 = R::select(t36, t11, t35);
        let t38 = R::lit(self.friction);
        let t39 = x3.abs();
        let t41 = t8.lt(x3);
        let t44 = (-t38).fma(t39, t33);
        let t45 = t44.le(t8);
        let t47 = R::select(t45, t8, t44);
        let t48 = R::select(t45, t11, t8);
        let t49 = t37 * t47;
        let t50 = t9 - t32;
        let t58 = t8.lt(t18);
        let t59 = !t58;
        let t60 = R::select(t59, y3, t8);
        let t61 = R::select(t58, y2, t8);
        let t62 = R::select(t59, y2, t8);
        let t63 = x3 * y1;
        let t64 = y1 * t9;
        let t65 = R::chain(t21, y1);
        let t66 = R::select(t24, t8, t65);
        let t67 = R::select(t28, t64, t66);
        let t68 = R::select(t14, t67, t64);
        let t69 = t60 + t68;
        let t70 = R::select(t58, y0, t8);
        let t71 = t49 * t70;
        let t72 = R::chain(t50, t70);
        let t73 = t61 + t72;
        let t75 = x2.fma(y0, t63);
        let t76 = y0 * t9;
        let t77 = R::chain(t21, y0);
        let t78 = R::select(t24, t8, t77);
        let t79 = R::select(t28, t76, t78);
        let t80 = R::select(t14, t79, t76);
        let t81 = t62 + t80;
        let t82 = -t71;
        let t83 = t75 + t82;
        let t84 = -t73;
        let t85 = R::select(t34, t84, t8);
        let t86 = R::select(t36, t73, t85);
        let t87 = t8.lt(t48);
        let t88 = !t87;
        let t89 = R::select(t88, t86, t8);
        let t90 = -t89;
        let t91 = t38 * t90;
        let t92 = -t91;
        let t93 = R::select(t13, t92, t8);
        let t94 = R::select(t41, t91, t93);
        let t95 = t69 + t94;
        let t96 = R::select(t34, t90, t8);
        let t97 = R::select(t36, t89, t96);
        let t98 = t81 + t97;
        let t99 = R::select(t58, t83, t8);
        let t100 = t8.lt(t31);
        let t101 = !t100;
        let t102 = R::select(t101, t99, t8);
        let t103 = t8.lt(t27);
        let t104 = !t103;
        let t105 = R::select(t104, t102, t8);
        let t106 = R::chain(t20, t105);
        let t107 = R::chain(t23, t105);
        let t108 = -t106;
        let t109 = y1 + t108;
        let t110 = R::select(t58, t107, t8);
        let t111 = t95 + t110;
        [y0, t109, t98, t111]
    }
}

impl Adjoint<6, 2> for Stiffening {
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
        let t23 = R::lit(self.cubic);
        let t24 = t21 * t23;
        let t25 = t24.fma(t21, t11);
        let t26 = x3 * t21;
        let t27 = t25 * t26;
        let t28 = R::lit(self.spring.dt);
        let t29 = t27 * t28;
        let t30 = t17 * t29;
        let t31 = t17 * t30;
        let t32 = -t31;
        let t35 = x1 * y1;
        let t36 = y1 * t30;
        let t38 = x0.fma(y0, t35);
        let t39 = y0 * t30;
        let t40 = t17 * t38;
        let t42 = t28 * t40;
        let t43 = t25 * t42;
        let t44 = t26 * t42;
        let t45 = t21 * t43;
        let t46 = x3 * t43;
        let t47 = t21 * t44;
        let t49 = t24.fma(t44, t46);
        let t51 = t23.fma(t47, t49);
        let t52 = t32.fma(t38, t51);
        let t53 = -t51;
        let t54 = t19 * t53;
        let t55 = x4 * t53;
        let t56 = x2 * t55;
        let t57 = x5 * t55;
        let t58 = t18 * t52;
        let t60 = t14.fma(t58, t39);
        let t62 = t12.fma(t58, t36);
        [t60, t62, t57, t45, t54, t56]
    }
}

impl Adjoint<7, 6> for Bend {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 7], y_bar: [R; 6]) -> [R; 7] {
        let [x0, x1, x2, x3, x4, x5, x6] = x;
        let [y0, y1, y2, y3, y4, y5] = y_bar;
        let t14 = x2 - x0;
        let t17 = x3 - x1;
        let t18 = R::lit(1e-12);
        let t19 = t17.fma(t17, t18);
        let t20 = t17 + t17;
        let t21 = t14.fma(t14, t19);
        let t22 = t14 + t14;
        let t23 = t21.sqrt();
        let t24 = R::lit(0.5);
        let t25 = t23.recip();
        let t26 = t24 * t25;
        let t27 = t25 * t25;
        let t28 = -t27;
        let t29 = t14 * t25;
        let t30 = t17 * t25;
        let t31 = x4 - x2;
        let t32 = x5 - x3;
        let t33 = t32.fma(t32, t18);
        let t34 = t32 + t32;
        let t35 = t31.fma(t31, t33);
        let t36 = t31 + t31;
        let t37 = t35.sqrt();
        let t38 = t37.recip();
        let t39 = t24 * t38;
        let t40 = t38 * t38;
        let t41 = -t40;
        let t42 = t31 * t38;
        let t43 = t32 * t38;
        let t44 = t29 * t43;
        let t46 = (-t30).fma(t42, t44);
        let t47 = x6 * t46;
        let t48 = R::lit(self.dt);
        let t49 = t47 * t48;
        let t50 = t25 * t49;
        let t51 = t38 * t49;
        let t62 = -y3;
        let t63 = y1 + t62;
        let t64 = y5 + t62;
        let t65 = -y2;
        let t66 = y0 + t65;
        let t67 = y4 + t65;
        let t68 = -t64;
        let t69 = t42 * t68;
        let t70 = t51 * t68;
        let t72 = t43.fma(t67, t69);
        let t73 = t51 * t67;
        let t74 = -t63;
        let t75 = t29 * t74;
        let t76 = t50 * t74;
        let t78 = t30.fma(t66, t75);
        let t79 = t50 * t66;
        let t80 = t38 * t72;
        let t81 = t49 * t72;
        let t83 = t25.fma(t78, t80);
        let t84 = t49 * t78;
        let t85 = t48 * t83;
        let t86 = t46 * t85;
        let t87 = x6 * t85;
        let t88 = -t87;
        let t90 = t42.fma(t88, t79);
        let t92 = t30.fma(t88, t70);
        let t94 = t43.fma(t87, t76);
        let t96 = t29.fma(t87, t73);
        let t97 = t38 * t96;
        let t99 = t32.fma(t96, t81);
        let t100 = t38 * t92;
        let t102 = t31.fma(t92, t99);
        let t103 = t41 * t102;
        let t104 = t39 * t103;
        let t106 = t36.fma(t104, t100);
        let t108 = t34.fma(t104, t97);
        let t109 = -t108;
        let t110 = -t106;
        let t111 = t25 * t90;
        let t113 = t17.fma(t90, t84);
        let t114 = t25 * t94;
        let t116 = t14.fma(t94, t113);
        let t117 = t28 * t116;
        let t118 = t26 * t117;
        let t120 = t22.fma(t118, t114);
        let t122 = t20.fma(t118, t111);
        let t123 = t109 + t122;
        let t124 = -t122;
        let t125 = t110 + t120;
        let t126 = -t120;
        [t126, t124, t125, t123, t106, t108, t86]
    }
}

impl Adjoint<5, 1> for Total {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 5], y_bar: [R; 1]) -> [R; 5] {
        let [_, _, _, _, _] = x;
        let [y0] = y_bar;
        [y0, y0, y0, y0, y0]
    }
}
