//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::{Reprojection, WeightError};

impl Reprojection {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 15, 2, M>) -> [[R; 15]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13, x14] = x;
        let [_, _] = y;
        let t17 = R::lit(0.0);
        let t18 = x11 - x3;
        let t19 = R::lit(1.0);
        let t21 = x12 - x4;
        let t22 = x13 - x5;
        let t23 = x0 * x0;
        let t24 = x0 + x0;
        let t26 = x1 + x1;
        let t27 = x1.fma(x1, t23);
        let t29 = x2 + x2;
        let t30 = x2.fma(x2, t27);
        let t31 = t30.less_equal(t17);
        let t33 = R::select(t31, t19, t30);
        let t34 = t33.sqrt();
        let t35 = R::lit(0.5);
        let t36 = t34 + t17;
        let t37 = t36.recip();
        let t38 = t35 * t37;
        let t39 = t34.recip();
        let t40 = t39 * t39;
        let t41 = -t40;
        let t42 = x0 * t39;
        let t43 = x1 * t39;
        let t44 = x2 * t39;
        let t45 = t34.sin();
        let t46 = t34.cos();
        let t47 = -t45;
        let t48 = t22 * t43;
        let t50 = (-t21).fma(t44, t48);
        let t51 = t18 * t44;
        let t53 = (-t22).fma(t42, t51);
        let t54 = t21 * t42;
        let t56 = (-t18).fma(t43, t54);
        let t57 = t18 * t42;
        let t59 = t21.fma(t43, t57);
        let t61 = t22.fma(t44, t59);
        let t62 = t19 - t46;
        let t63 = t61 * t62;
        let t64 = x1 * t22;
        let t66 = (-x2).fma(t21, t64);
        let t67 = x2 * t18;
        let t69 = (-x0).fma(t22, t67);
        let t70 = x0 * t21;
        let t72 = (-x1).fma(t18, t70);
        let t73 = t18 * t46;
        let t75 = t45.fma(t50, t73);
        let t77 = t42.fma(t63, t75);
        let t78 = t18 + t66;
        let t79 = R::select(t31, t78, t77);
        let t80 = t21 * t46;
        let t82 = t45.fma(t53, t80);
        let t84 = t43.fma(t63, t82);
        let t85 = t21 + t69;
        let t86 = R::select(t31, t85, t84);
        let t87 = t22 * t46;
        let t89 = t45.fma(t56, t87);
        let t91 = t44.fma(t63, t89);
        let t92 = t22 + t72;
        let t93 = R::select(t31, t92, t91);
        let t94 = t93.recip();
        let t95 = t79 * t94;
        let t96 = t94 * t95;
        let t97 = -t96;
        let t98 = t86 * t94;
        let t99 = t94 * t98;
        let t100 = -t99;
        let t101 = t95 * t95;
        let t102 = t95 + t95;
        let t104 = t98 + t98;
        let t105 = t98.fma(t98, t101);
        let t107 = x10.fma(t105, x9);
        let t109 = t105.fma(t107, t19);
        let t110 = x6 * t109;
        let t112 = t95.fma(t110, x7);
        let t115 = t98.fma(t110, x8);
        let mut x_bar = [[R::zero(); 15]; M];
        for m in 0..M {
            let [y0, y1] = y_bar[m];
            let t117 = R::chain(t115, y1);
            let t118 = x14 * y1;
            let t119 = R::chain(t98, t118);
            let t120 = R::chain(t110, t118);
            let t121 = R::chain(t112, y0);
            let t122 = t117 + t121;
            let t123 = x14 * y0;
            let t124 = R::chain(t95, t123);
            let t125 = t119 + t124;
            let t126 = R::chain(t110, t123);
            let t127 = R::chain(t109, t125);
            let t128 = x6 * t125;
            let t129 = R::chain(t107, t128);
            let t130 = R::chain(t105, t128);
            let t132 = x10.fma(t130, t129);
            let t133 = R::chain(t105, t130);
            let t134 = R::chain(t104, t132);
            let t135 = t120 + t134;
            let t136 = R::chain(t102, t132);
            let t137 = t126 + t136;
            let t138 = R::chain(t94, t135);
            let t139 = R::chain(t100, t135);
            let t140 = R::chain(t94, t137);
            let t141 = R::chain(t97, t137);
            let t142 = t139 + t141;
            let t143 = R::select(t31, t142, t17);
            let t144 = R::select(t31, t17, t142);
            let t145 = R::chain(t63, t144);
            let t146 = R::chain(t44, t144);
            let t147 = R::chain(t45, t144);
            let t148 = R::chain(t56, t144);
            let t149 = R::chain(t46, t144);
            let t150 = t143 + t149;
            let t151 = t22 * t144;
            let t152 = R::select(t31, t138, t17);
            let t153 = R::select(t31, t17, t138);
            let t154 = R::chain(t63, t153);
            let t155 = R::chain(t43, t153);
            let t156 = t146 + t155;
            let t157 = R::chain(t45, t153);
            let t158 = R::chain(t53, t153);
            let t159 = t148 + t158;
            let t160 = R::chain(t46, t153);
            let t161 = t152 + t160;
            let t163 = t21.fma(t153, t151);
            let t164 = R::select(t31, t140, t17);
            let t165 = R::select(t31, t17, t140);
            let t166 = R::chain(t63, t165);
            let t167 = R::chain(t42, t165);
            let t168 = t156 + t167;
            let t169 = R::chain(t45, t165);
            let t170 = R::chain(t50, t165);
            let t171 = t159 + t170;
            let t172 = R::chain(t46, t165);
            let t173 = t164 + t172;
            let t175 = t18.fma(t165, t163);
            let t176 = -t143;
            let t177 = t18 * t176;
            let t179 = x1.fma(t176, t173);
            let t180 = t21 * t143;
            let t182 = x0.fma(t143, t161);
            let t183 = -t152;
            let t185 = t22.fma(t183, t180);
            let t187 = x0.fma(t183, t150);
            let t188 = t18 * t152;
            let t190 = x2.fma(t152, t179);
            let t191 = -t164;
            let t193 = t21.fma(t191, t188);
            let t195 = x2.fma(t191, t182);
            let t197 = t22.fma(t164, t177);
            let t199 = x1.fma(t164, t187);
            let t200 = R::chain(t62, t168);
            let t201 = R::chain(t61, t168);
            let t202 = -t201;
            let t203 = t175 + t202;
            let t205 = t22.fma(t200, t145);
            let t206 = R::chain(t44, t200);
            let t207 = t199 + t206;
            let t209 = t21.fma(t200, t154);
            let t210 = R::chain(t43, t200);
            let t211 = t195 + t210;
            let t213 = t18.fma(t200, t166);
            let t214 = R::chain(t42, t200);
            let t215 = t190 + t214;
            let t216 = -t147;
            let t218 = t18.fma(t216, t209);
            let t219 = R::chain(t43, t216);
            let t220 = t215 + t219;
            let t222 = t21.fma(t147, t213);
            let t223 = R::chain(t42, t147);
            let t224 = t211 + t223;
            let t225 = -t157;
            let t227 = t22.fma(t225, t222);
            let t228 = R::chain(t42, t225);
            let t229 = t207 + t228;
            let t231 = t18.fma(t157, t205);
            let t232 = R::chain(t44, t157);
            let t233 = t220 + t232;
            let t234 = -t169;
            let t236 = t21.fma(t234, t231);
            let t237 = R::chain(t44, t234);
            let t238 = t224 + t237;
            let t240 = t22.fma(t169, t218);
            let t241 = R::chain(t43, t169);
            let t242 = t229 + t241;
            let t243 = R::chain(t47, t203);
            let t244 = R::chain(t46, t171);
            let t245 = t243 + t244;
            let t246 = R::chain(t39, t236);
            let t247 = t193 + t246;
            let t248 = x2 * t236;
            let t249 = R::chain(t39, t240);
            let t250 = t197 + t249;
            let t252 = x1.fma(t240, t248);
            let t253 = R::chain(t39, t227);
            let t254 = t185 + t253;
            let t256 = x0.fma(t227, t252);
            let t257 = R::chain(t41, t256);
            let t258 = t245 + t257;
            let t259 = R::chain(t38, t258);
            let t261 = R::select(t31, t17, t259);
            let t263 = t29.fma(t261, t247);
            let t265 = t26.fma(t261, t250);
            let t267 = t24.fma(t261, t254);
            let t268 = -t242;
            let t269 = -t238;
            let t270 = -t233;
            x_bar[m] = [t267, t265, t263, t270, t269, t268, t127, t123, t118, t130, t133, t233, t238, t242, t122];
        }
        x_bar
    }
}

impl WeightError {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: autodiff::Pullback<R, 1, 1, M>) -> [[R; 1]; M] {
        let autodiff::Pullback { x, y, y_bar } = at;
        let [x0] = x;
        let [_] = y;
        let t5 = x0 + x0;
        let mut x_bar = [[R::zero(); 1]; M];
        for m in 0..M {
            let [y0] = y_bar[m];
            let t8 = -y0;
            let t9 = t5 * t8;
            x_bar[m] = [t9];
        }
        x_bar
    }
}
