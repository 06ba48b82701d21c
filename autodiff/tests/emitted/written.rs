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

impl Adjoint<3, 15> for Every {
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 3], y_bar: [R; 15]) -> [R; 3] {
        let [x0, x1, x2] = x;
        let [y0, y1, y2, y3, y4, y5, y6, y7, y8, y9, y10, y11, y12, y13, y14] = y_bar;
        let t18 = R::lit(0.0);
        let t19 = R::lit(self.width);
        let t20 = x0 + x1;
        let t21 = R::lit(1.0);
        let t23 = x2 + x2;
        let t24 = (-x2).fma(x2, t20);
        let t26 = x0 * t24;
        let t28 = x1 + x1;
        let t29 = x1.fma(x1, t21);
        let t30 = t29.recip();
        let t31 = t26 * t30;
        let t32 = t30 * t31;
        let t33 = -t32;
        let t34 = x0.lt(x1);
        let t35 = x1.le(x2);
        let t36 = !t35;
        let t37 = t34 & t36;
        let t38 = x2.abs();
        let t39 = R::lit(f64::INFINITY);
        let t40 = t38.lt(t39);
        let t41 = x0.lt(x2);
        let t42 = t40 & t41;
        let t43 = t37 | t42;
        let t44 = x0.exp();
        let t45 = x1.sin();
        let t46 = x1.cos();
        let t47 = x2.cos();
        let t48 = x2.sin();
        let t49 = -t48;
        let t52 = t46.recip();
        let t53 = t45 * t52;
        let t55 = t53.fma(t53, t21);
        let t56 = x0.tanh();
        let t57 = t21 - t56;
        let t58 = t21 + t56;
        let t59 = t57 * t58;
        let t62 = x0.abs();
        let t63 = x1.abs();
        let t64 = t62.le(t63);
        let t66 = t63.detach();
        let t67 = t62.detach();
        let t68 = R::select(t64, t66, t67);
        let t69 = t18.lt(t68);
        let t70 = t68.lt(t39);
        let t71 = t69 & t70;
        let t72 = t68.recip();
        let t73 = x0 * t72;
        let t74 = x1 * t72;
        let t75 = t74 * t74;
        let t77 = t73.fma(t73, t75);
        let t78 = t68 * t77;
        let t80 = t78.recip();
        let t81 = t74 * t80;
        let t83 = t73 * t80;
        let t84 = -t83;
        let t86 = R::lit(3.0);
        let t87 = x0.powi(2);
        let t88 = t86 * t87;
        let t90 = R::lit(-2.0);
        let t91 = x1.powi(-3);
        let t92 = t90 * t91;
        let t97 = x0.lt(t18);
        let t99 = t18.lt(x0);
        let t101 = t62.powf(x1);
        let t102 = x1 - t21;
        let t103 = t62.powf(t102);
        let t104 = R::chain(t103, x1);
        let t105 = t62.le(t18);
        let t106 = t18.le(t62);
        let t107 = t105 & t106;
        let t108 = t62.ln();
        let t109 = t101 * t108;
        let t111 = t62.recip();
        let t112 = t62.lt(t18);
        let t113 = R::select(t112, t108, t111);
        let t114 = x2.recip();
        let t115 = t114 * t114;
        let t116 = -t115;
        let t118 = t62.le(t38);
        let t119 = R::select(t118, t38, t62);
        let t120 = t119.recip();
        let t121 = t62 * t120;
        let t122 = t38 * t120;
        let t123 = t121 * t121;
        let t125 = t122.fma(t122, t123);
        let t126 = t125.sqrt();
        let t127 = t119 * t126;
        let t128 = t18.lt(t119);
        let t129 = t119.lt(t39);
        let t130 = t128 & t129;
        let t131 = t62 + t38;
        let t132 = R::select(t130, t127, t131);
        let t133 = t132.le(t18);
        let t134 = t132.recip();
        let t135 = x0 * t134;
        let t137 = x2 * t134;
        let t139 = x1.lt(t18);
        let t141 = t18.lt(x1);
        let t143 = t63.sqrt();
        let t144 = t143.recip();
        let t145 = R::lit(-0.5);
        let t146 = t144 * t145;
        let t147 = t144 * t146;
        let t148 = t144 * t147;
        let t149 = x0 * x0;
        let t150 = x0 + x0;
        let t151 = t149 + t19;
        let t152 = t151.sqrt();
        let t153 = R::lit(0.5);
        let t154 = t152.recip();
        let t155 = t153 * t154;
        let t158 = x0.le(x2);
        let t162 = x2.le(x1);
        let t166 = R::lit(-self.width);
        let t167 = x2.le(t166);
        let t169 = R::select(t167, t166, x2);
        let t170 = t19.le(t169);
        let t172 = R::select(t170, t19, t169);
        let t173 = x0.recip();
        let t174 = t172 * t173;
        let t175 = t173 * t174;
        let t176 = -t175;
        let t177 = -x2;
        let t178 = x0 * t177;
        let t184 = <R::Mask as Mask>::splat(true);
        let t190 = x2.detach();
        let t200 = t21 + t149;
        let t201 = t200.sqrt();
        let t202 = t201.recip();
        let t203 = t149.lt(t39);
        let t204 = R::select(t203, t202, t111);
        let t205 = x1.elementary(autodiff::element::Elementary::Sinh);
        let t206 = x1.elementary(autodiff::element::Elementary::Cosh);
        let t207 = x2.elementary(autodiff::element::Elementary::Cbrt);
        let t208 = t86 * t207;
        let t209 = t207 * t208;
        let t210 = t209.recip();
        let t213 = -y14;
        let t214 = R::chain(t207, t213);
        let t215 = R::chain(t205, t213);
        let t216 = R::chain(t210, t215);
        let t217 = R::chain(t206, t214);
        let t218 = R::chain(t204, y14);
        let t219 = t216 + y13;
        let t220 = x1 * y13;
        let t222 = y13.fma(t31, t217);
        let t223 = t218 + y12;
        let t224 = t222 + y12;
        let t225 = t219 + y12;
        let t227 = x2.fma(y12, t223);
        let t228 = x0 * y12;
        let t229 = t224 + t228;
        let t231 = y12.fma(t19, t225);
        let t232 = t231 + t228;
        let t234 = x1.fma(y12, t227);
        let t236 = y11.fma(t190, t234);
        let t238 = x2.fma(y11, t229);
        let t240 = x1.fma(y11, t232);
        let t242 = R::select(t184, t18, y10);
        let t243 = t236 + t242;
        let t244 = R::select(t43, y10, t18);
        let t245 = R::select(t43, t18, y10);
        let t246 = -t245;
        let t247 = t240 + t246;
        let t249 = x1.fma(t244, t243);
        let t251 = x0.fma(t244, t238);
        let t252 = x1 * y9;
        let t254 = y9.fma(t178, t251);
        let t255 = x0 * t252;
        let t257 = t177.fma(t252, t249);
        let t258 = -t255;
        let t259 = t247 + t258;
        let t260 = R::chain(t173, y9);
        let t261 = R::chain(t176, y9);
        let t262 = t257 + t261;
        let t264 = R::select(t170, t18, t260);
        let t266 = R::select(t167, t18, t264);
        let t267 = t259 + t266;
        let t268 = -y8;
        let t269 = R::select(t162, t268, t18);
        let t270 = R::select(t162, t18, t268);
        let t271 = t267 + t269;
        let t272 = t254 + t270;
        let t273 = R::select(t158, y8, t18);
        let t274 = R::select(t158, t18, y8);
        let t275 = t271 + t273;
        let t276 = t262 + t274;
        let t277 = R::select(t97, t268, t18);
        let t278 = R::select(t99, y8, t277);
        let t279 = t272 + t278;
        let t280 = y7 * t155;
        let t282 = t150.fma(t280, t276);
        let t283 = R::chain(t148, y7);
        let t284 = -t283;
        let t285 = R::select(t139, t284, t18);
        let t286 = R::select(t141, t283, t285);
        let t287 = t279 + t286;
        let t288 = R::chain(t135, y6);
        let t289 = R::select(t133, t18, t288);
        let t290 = t282 + t289;
        let t291 = R::chain(t137, y6);
        let t292 = R::select(t133, t18, t291);
        let t293 = t275 + t292;
        let t294 = R::chain(t114, y5);
        let t295 = R::chain(t108, y5);
        let t296 = R::chain(t116, t295);
        let t297 = t293 + t296;
        let t298 = R::chain(t113, t294);
        let t299 = -t298;
        let t300 = R::select(t97, t299, t18);
        let t301 = R::select(t99, t298, t300);
        let t302 = t290 + t301;
        let t303 = R::chain(t104, y4);
        let t304 = R::chain(t109, y4);
        let t305 = R::select(t107, t18, t304);
        let t306 = t287 + t305;
        let t307 = -t303;
        let t308 = R::select(t97, t307, t18);
        let t309 = R::select(t99, t303, t308);
        let t310 = t302 + t309;
        let t312 = R::chain(t92, y3);
        let t313 = t306 + t312;
        let t314 = R::chain(t88, y3);
        let t315 = t310 + t314;
        let t316 = R::chain(t81, y2);
        let t317 = R::select(t71, t316, t18);
        let t318 = t315 + t317;
        let t319 = R::chain(t84, y2);
        let t320 = R::select(t71, t319, t18);
        let t321 = t313 + t320;
        let t323 = y1.fma(t59, t318);
        let t324 = R::chain(t55, y1);
        let t325 = t321 + t324;
        let t326 = -y0;
        let t327 = t47 * t326;
        let t328 = t45 * t326;
        let t330 = t49.fma(t328, t297);
        let t332 = t46.fma(t327, t325);
        let t334 = y0.fma(t44, t323);
        let t335 = t30 * t220;
        let t336 = t33 * t220;
        let t338 = t28.fma(t336, t332);
        let t339 = x0 * t335;
        let t341 = t24.fma(t335, t334);
        let t342 = -t339;
        let t344 = t23.fma(t342, t330);
        let t345 = t341 + t339;
        let t346 = t338 + t339;
        [t345, t346, t344]
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
        let t15 = x0.detach();
        let t16 = R::select(t11, t15, t12);
        let t18 = t10.sin();
        let t19 = t10.cos();
        let t22 = x0 * t16;
        let t24 = t22.cos();
        let t25 = -t18;
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
        let t43 = t7.fma(t39, t34);
        let t44 = x0 * t39;
        let t46 = t8.fma(t44, t43);
        [t46, t41]
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
        let t12 = x0.detach();
        let t13 = R::select(t8, t12, t9);
        let t15 = t7.sin();
        let t16 = t7.cos();
        let t17 = x1.fma(t12, t15);
        let t18 = x1 * t7;
        let t19 = x0 * t13;
        let t20 = t19.sin();
        let t21 = t19.cos();
        let t22 = -t15;
        let t24 = t7.fma(t16, t20);
        let t25 = t4 * t16;
        let t26 = x0 * t16;
        let t28 = t5.fma(t26, t25);
        let t29 = x1 * t4;
        let t31 = t3.fma(t5, t29);
        let t33 = t7.fma(t22, t16);
        let t34 = t12 * t21;
        let t35 = R::select(t8, t34, t21);
        let t37 = t4.fma(t33, t35);
        let t38 = x0 * t33;
        let t40 = t5.fma(t38, t37);
        ([t17, t18, t24], [[t28, t12], [t31, t7], [t40, t2]])
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
        let t13 = x0 * y1;
        let t15 = R::select(t5, y0, t4);
        let t17 = R::chain(t9, t15);
        let t18 = x1.fma(y1, t17);
        [t18, t13]
    }
}
