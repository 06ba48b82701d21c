//! Derivatives of the kernels, emitted from recordings of them: not to be edited. After a change:
//! `EMIT=1 cargo test -p autodiff --test emitted`.

use autodiff::{Adjoint, Mask, Partials, Real};

use super::guarded::{Guarded, Held};
use super::{Bent, Every};

impl Adjoint<2, 3> for Bent {
    #[inline(always)]
    fn vjp_with_results<R: Real>(&self, x: [R; 2], y: [R; 3], y_bar: [R; 3]) -> [R; 2] {
        let [x0, x1] = x;
        let [r0, _, r2] = y;
        let [y0, y1, y2] = y_bar;
        let t5 = R::lit(0.0);
        let t6 = R::lit(self.stiffness);
        let t7 = x0 * t6;
        let t10 = R::lit(1.0);
        let t11 = t10 - r0;
        let t12 = t10 + r0;
        let t13 = t11 * t12;
        let t14 = x0.abs();
        let t15 = x0.lt(t5);
        let t18 = t5.lt(x0);
        let t20 = t14.sqrt();
        let t21 = R::lit(0.5);
        let t22 = t20.recip();
        let t23 = t21 * t22;
        let t25 = r0 + r0;
        let t26 = r0.fma(r0, t10);
        let t27 = t26.recip();
        let t29 = t27 * r2;
        let t30 = -t29;
        let t31 = y2 * t27;
        let t32 = y2 * t30;
        let t34 = t25.fma(t32, y0);
        let t35 = R::chain(t23, t31);
        let t36 = -t35;
        let t37 = R::select(t15, t36, t5);
        let t38 = R::select(t18, t35, t37);
        let t39 = t13 * t34;
        let t40 = x1 * t39;
        let t42 = t7.fma(t39, y1);
        let t44 = t6.fma(t40, t38);
        [t44, t42]
    }
}

impl Partials<2, 3> for Bent {
    #[inline(always)]
    fn partials<R: Real>(&self, x: [R; 2]) -> ([R; 3], [[R; 2]; 3]) {
        let [x0, x1] = x;
        let t2 = R::lit(0.0);
        let t3 = R::lit(self.stiffness);
        let t4 = x0 * t3;
        let t5 = x1 * t4;
        let t6 = t5.tanh();
        let t7 = R::lit(1.0);
        let t8 = t7 - t6;
        let t9 = t7 + t6;
        let t10 = t8 * t9;
        let t11 = x0.abs();
        let t12 = x0.lt(t2);
        let t15 = t2.lt(x0);
        let t17 = t11.sqrt();
        let t18 = R::lit(0.5);
        let t19 = t17.recip();
        let t20 = t18 * t19;
        let t22 = t6 + t6;
        let t23 = t6.fma(t6, t7);
        let t24 = t23.recip();
        let t25 = t17 * t24;
        let t26 = t24 * t25;
        let t27 = -t26;
        let t28 = x1 * t10;
        let t29 = t4 * t10;
        let t30 = t3 * t28;
        let t31 = t22 * t27;
        let t32 = R::chain(t20, t24);
        let t33 = -t32;
        let t34 = R::select(t12, t33, t2);
        let t35 = R::select(t15, t32, t34);
        let t36 = t10 * t31;
        let t37 = x1 * t36;
        let t38 = t4 * t36;
        let t40 = t3.fma(t37, t35);
        ([t6, x1, t25], [[t30, t29], [t2, t7], [t40, t38]])
    }
}

impl Adjoint<3, 14> for Every {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 3], y_bar: [R; 14]) -> [R; 3] {
        let [x0, x1, x2] = x;
        let [y0, y1, y2, y3, y4, y5, y6, y7, y8, y9, y10, y11, y12, y13] = y_bar;
        let t17 = R::lit(0.0);
        let t18 = R::lit(self.width);
        let t19 = x0 + x1;
        let t20 = R::lit(1.0);
        let t21 = x2 * x2;
        let t22 = x2 + x2;
        let t23 = t19 - t21;
        let t25 = x0 * t23;
        let t27 = x1 + x1;
        let t28 = x1.fma(x1, t20);
        let t29 = t28.recip();
        let t30 = t25 * t29;
        let t31 = t29 * t30;
        let t32 = -t31;
        let t33 = x0.lt(x1);
        let t34 = x1.le(x2);
        let t35 = !t34;
        let t36 = t33 & t35;
        let t37 = x2.abs();
        let t38 = R::lit(f64::INFINITY);
        let t39 = t37.lt(t38);
        let t40 = x0.lt(x2);
        let t41 = t39 & t40;
        let t42 = t36 | t41;
        let t43 = x0.exp();
        let t44 = x1.sin();
        let t45 = x1.cos();
        let t46 = x2.cos();
        let t47 = x2.sin();
        let t48 = -t47;
        let t51 = t45.recip();
        let t52 = t44 * t51;
        let t54 = t52.fma(t52, t20);
        let t55 = x0.tanh();
        let t56 = t20 - t55;
        let t57 = t20 + t55;
        let t58 = t56 * t57;
        let t61 = x0.abs();
        let t62 = x1.abs();
        let t63 = t61.le(t62);
        let t65 = t62.detach();
        let t66 = t61.detach();
        let t67 = R::select(t63, t65, t66);
        let t68 = t67.recip();
        let t69 = x0 * t68;
        let t70 = x1 * t68;
        let t71 = t70 * t70;
        let t73 = t69.fma(t69, t71);
        let t74 = t67 * t73;
        let t75 = t67.le(t17);
        let t76 = t74.recip();
        let t77 = t70 * t76;
        let t79 = t69 * t76;
        let t80 = -t79;
        let t82 = R::lit(3.0);
        let t83 = x0.powi(2);
        let t84 = t82 * t83;
        let t86 = R::lit(-2.0);
        let t87 = x1.powi(-3);
        let t88 = t86 * t87;
        let t93 = x0.lt(t17);
        let t95 = t17.lt(x0);
        let t97 = t61.powf(x1);
        let t98 = x1 - t20;
        let t99 = t61.powf(t98);
        let t100 = R::chain(t99, x1);
        let t101 = t61.le(t17);
        let t102 = t17.le(t61);
        let t103 = t101 & t102;
        let t104 = t61.ln();
        let t105 = t97 * t104;
        let t107 = t61.recip();
        let t108 = t61.lt(t17);
        let t109 = R::select(t108, t104, t107);
        let t110 = x2.recip();
        let t111 = t110 * t110;
        let t112 = -t111;
        let t114 = x0 * x0;
        let t115 = t114 + t21;
        let t116 = t115.le(t17);
        let t117 = t115.sqrt();
        let t118 = R::select(t116, t17, t117);
        let t119 = t118.le(t17);
        let t120 = t118.recip();
        let t121 = x0 * t120;
        let t123 = x2 * t120;
        let t125 = x1.lt(t17);
        let t127 = t17.lt(x1);
        let t129 = t62.sqrt();
        let t130 = t129.recip();
        let t131 = R::lit(-0.5);
        let t132 = t130 * t131;
        let t133 = t130 * t132;
        let t134 = t130 * t133;
        let t135 = x0 + x0;
        let t136 = t114 + t18;
        let t137 = t136.sqrt();
        let t138 = R::lit(0.5);
        let t139 = t137.recip();
        let t140 = t138 * t139;
        let t143 = x0.le(x2);
        let t149 = x2.le(x1);
        let t155 = R::lit(-self.width);
        let t156 = x2.le(t155);
        let t158 = R::select(t156, t155, x2);
        let t161 = t18.le(t158);
        let t163 = R::select(t161, t18, t158);
        let t166 = x0.recip();
        let t167 = t163 * t166;
        let t168 = t166 * t167;
        let t169 = -t168;
        let t170 = -x2;
        let t171 = x0 * t170;
        let t179 = <R::Mask as Mask>::splat(true);
        let t187 = x2.detach();
        let t196 = x1 * y13;
        let t198 = y13.fma(t30, y12);
        let t199 = y13 + y12;
        let t201 = x2.fma(y12, y12);
        let t202 = x0 * y12;
        let t203 = t198 + t202;
        let t205 = y12.fma(t18, t199);
        let t206 = t205 + t202;
        let t208 = x1.fma(y12, t201);
        let t210 = y11.fma(t187, t208);
        let t212 = x2.fma(y11, t203);
        let t214 = x1.fma(y11, t206);
        let t215 = R::select(t179, t17, y10);
        let t216 = t210 + t215;
        let t217 = R::select(t42, y10, t17);
        let t218 = R::select(t42, t17, y10);
        let t219 = -t218;
        let t220 = t214 + t219;
        let t222 = x1.fma(t217, t216);
        let t224 = x0.fma(t217, t212);
        let t225 = x1 * y9;
        let t227 = y9.fma(t171, t224);
        let t228 = x0 * t225;
        let t230 = t170.fma(t225, t222);
        let t231 = -t228;
        let t232 = t220 + t231;
        let t233 = R::chain(t166, y9);
        let t234 = R::chain(t169, y9);
        let t235 = t230 + t234;
        let t236 = R::select(t161, t17, t233);
        let t237 = R::select(t156, t17, t236);
        let t238 = t232 + t237;
        let t239 = -y8;
        let t240 = R::select(t149, t239, t17);
        let t241 = t238 + t240;
        let t242 = R::select(t149, t17, t239);
        let t243 = t227 + t242;
        let t244 = R::select(t143, y8, t17);
        let t245 = t241 + t244;
        let t246 = R::select(t143, t17, y8);
        let t247 = t235 + t246;
        let t248 = R::select(t93, t239, t17);
        let t249 = R::select(t95, y8, t248);
        let t250 = t243 + t249;
        let t251 = y7 * t140;
        let t253 = t135.fma(t251, t247);
        let t254 = R::chain(t134, y7);
        let t255 = -t254;
        let t256 = R::select(t125, t255, t17);
        let t257 = R::select(t127, t254, t256);
        let t258 = t250 + t257;
        let t259 = R::chain(t121, y6);
        let t260 = R::select(t119, t17, t259);
        let t261 = t253 + t260;
        let t262 = R::chain(t123, y6);
        let t263 = R::select(t119, t17, t262);
        let t264 = t245 + t263;
        let t265 = R::chain(t110, y5);
        let t266 = R::chain(t104, y5);
        let t267 = R::chain(t112, t266);
        let t268 = t264 + t267;
        let t269 = R::chain(t109, t265);
        let t270 = -t269;
        let t271 = R::select(t93, t270, t17);
        let t272 = R::select(t95, t269, t271);
        let t273 = t261 + t272;
        let t274 = R::chain(t100, y4);
        let t275 = R::chain(t105, y4);
        let t276 = R::select(t103, t17, t275);
        let t277 = t258 + t276;
        let t278 = -t274;
        let t279 = R::select(t93, t278, t17);
        let t280 = R::select(t95, t274, t279);
        let t281 = t273 + t280;
        let t283 = R::chain(t88, y3);
        let t284 = t277 + t283;
        let t285 = R::chain(t84, y3);
        let t286 = t281 + t285;
        let t287 = R::chain(t77, y2);
        let t288 = R::select(t75, t17, t287);
        let t289 = t286 + t288;
        let t290 = R::chain(t80, y2);
        let t291 = R::select(t75, t17, t290);
        let t292 = t284 + t291;
        let t294 = y1.fma(t58, t289);
        let t295 = R::chain(t54, y1);
        let t296 = t292 + t295;
        let t297 = -y0;
        let t298 = t46 * t297;
        let t299 = t44 * t297;
        let t301 = t48.fma(t299, t268);
        let t303 = t45.fma(t298, t296);
        let t305 = y0.fma(t43, t294);
        let t306 = t29 * t196;
        let t307 = t32 * t196;
        let t309 = t27.fma(t307, t303);
        let t310 = x0 * t306;
        let t312 = t23.fma(t306, t305);
        let t313 = -t310;
        let t315 = t22.fma(t313, t301);
        let t316 = t312 + t310;
        let t317 = t309 + t310;
        [t316, t317, t315]
    }
}

impl Adjoint<2, 3> for Held {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 2], y_bar: [R; 3]) -> [R; 2] {
        let [x0, x1] = x;
        let [y0, y1, y2] = y_bar;
        let t6 = x0 * x1;
        let t7 = x0.sin();
        let t8 = x0.cos();
        let t9 = x0 * t7;
        let t10 = t6.straight_through(t9);
        let t11 = x0.lt(x1);
        let t12 = R::lit(1.0);
        let t17 = x0.detach();
        let t18 = R::select(t11, t17, t12);
        let t20 = t10.sin();
        let t21 = t10.cos();
        let t24 = x0 * t18;
        let t26 = t24.cos();
        let t27 = -t20;
        let t30 = y2 * t21;
        let t31 = y2 * t10;
        let t33 = t27.fma(t31, t30);
        let t34 = y2 * t26;
        let t35 = t17 * t34;
        let t36 = R::select(t11, t35, t34);
        let t38 = x1.fma(y1, t33);
        let t39 = y1 * t10;
        let t41 = y0.fma(t21, t38);
        let t43 = y0.fma(t17, t39);
        let t45 = t7.fma(t41, t36);
        let t46 = x0 * t41;
        let t48 = t8.fma(t46, t45);
        [t48, t43]
    }
}

impl Partials<2, 3> for Held {
    #[inline(always)]
    fn partials<R: Real>(&self, x: [R; 2]) -> ([R; 3], [[R; 2]; 3]) {
        let [x0, x1] = x;
        let t2 = R::lit(0.0);
        let t3 = x0 * x1;
        let t4 = x0.sin();
        let t5 = x0.cos();
        let t6 = x0 * t4;
        let t7 = t3.straight_through(t6);
        let t8 = x0.lt(x1);
        let t9 = R::lit(1.0);
        let t14 = x0.detach();
        let t15 = R::select(t8, t14, t9);
        let t17 = t7.sin();
        let t18 = t7.cos();
        let t19 = x1.fma(t14, t17);
        let t20 = x1 * t7;
        let t21 = x0 * t15;
        let t22 = t21.sin();
        let t23 = t21.cos();
        let t24 = -t17;
        let t26 = t7.fma(t18, t22);
        let t27 = t4 * t18;
        let t28 = x0 * t18;
        let t30 = t5.fma(t28, t27);
        let t31 = x1 * t4;
        let t33 = t3.fma(t5, t31);
        let t35 = t7.fma(t24, t18);
        let t36 = t14 * t23;
        let t37 = R::select(t8, t36, t23);
        let t39 = t4.fma(t35, t37);
        let t40 = x0 * t35;
        let t42 = t5.fma(t40, t39);
        ([t19, t20, t26], [[t30, t14], [t33, t7], [t42, t2]])
    }
}

impl Adjoint<2, 2> for Guarded {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 2], y_bar: [R; 2]) -> [R; 2] {
        let [x0, x1] = x;
        let [y0, y1] = y_bar;
        let t4 = R::lit(0.0);
        let t5 = t4.lt(x0);
        let t6 = x0.ln();
        let t7 = x0.recip();
        let t8 = x0.lt(t4);
        let t9 = R::select(t8, t6, t7);
        let t16 = x0 * y1;
        let t18 = R::select(t5, y0, t4);
        let t19 = R::chain(t9, t18);
        let t20 = x1.fma(y1, t19);
        [t20, t16]
    }
}
