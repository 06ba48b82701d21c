//! Derivatives of the kernels, emitted from recordings of them: not to be edited. After a change:
//! `EMIT=1 cargo test -p autodiff --test emitted`.

use autodiff::{Adjoint, Partials, Real};

use super::Bent;

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
