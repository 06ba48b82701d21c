//! The code that the register types of all instruction sets share.

/// Defines a lane type that wraps a register. The first arguments name instructions, whose names differ between
/// instruction sets only in a prefix. To understand the expressions that follow, look at how the macro uses them. The
/// macro pastes expressions instead of calling closures: a closure that the compiler did not inline would be compiled
/// without the instruction set.
///
/// # Safety of the instructions
///
/// The types are private to the crate, and only [`enter`](super::enter) names them. It runs code on a type only if the
/// processor has the type's instructions. Below, this is called *entered*. It holds for a function that makes a register
/// as well as for one that takes a register.
macro_rules! define_lanes {
    (
        $name:ident: [$scalar:ident; $n:literal] in $register:ident, mask $mask:ty,
        $splat:ident $load:ident $store:ident
        $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident,
        fma $fma:ident, with one rounding $fused:ident, tanh $tanh:path,
        part $load_part:expr, $store_part:expr,
        $lt:expr, $le:expr, $blend:expr,
        |$tested:ident, $kept:ident| $where_nonzero:expr,
        |$partial:ident, $cotangent:ident, $term:ident| $fma_where_nonzero:expr,
        |$shifted:ident| $exp2:expr, |$signed:ident| $abs:expr, |$size:ident, $sign:ident| $with_sign:expr,
        $and:expr, $or:expr, $not:expr, $bits:expr, $from_bits:expr,
        |$one:ident, $other:ident| $zip:expr
    ) => {
        #[doc = concat!(stringify!($n), " lanes of `", stringify!($scalar), "`.")]
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name($register);

        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                // SAFETY: entered.
                unsafe { $and(self, other) }
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                // SAFETY: entered.
                unsafe { $or(self, other) }
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                // SAFETY: entered.
                unsafe { $not(self) }
            }
        }
        impl Mask for $mask {
            #[inline(always)]
            fn splat(value: bool) -> Self {
                let zero = <$name as Zero>::zero();
                if value {
                    zero.less_equal(zero)
                } else {
                    zero.less(zero)
                }
            }
            #[inline(always)]
            fn any(self) -> bool {
                // SAFETY: entered.
                unsafe { $bits(self) != 0 }
            }
        }

        // SAFETY, four times: entered.
        operators! {
            #[inline(always)]
            impl[] $name:
            a + b => Self(unsafe { $add(a.0, b.0) }),
            a - b => Self(unsafe { $sub(a.0, b.0) }),
            a * b => Self(unsafe { $mul(a.0, b.0) }),
            a / b => Self(unsafe { $div(a.0, b.0) }),
            -a => Self::lit(-0.0) - a,
            0 => Self::lit(0.0),
            1 => Self::lit(1.0),
            a == 0 => (a.less_equal(Self::lit(0.0)) & Self::lit(0.0).less_equal(a)).all(),
        }
        $crate::operators::literal_operators! { [] $name }

        impl Lane<$scalar> for $name {
            const N: usize = $n;
            #[inline(always)]
            fn tanh_each<const K: usize>(x: [Self; K]) -> [Self; K] {
                $tanh(x)
            }
            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                // SAFETY: entered.
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn load(from: &[$scalar]) -> Self {
                let from: &[$scalar; $n] = from[..$n].try_into().expect("the slice has the length of the array");
                // SAFETY: entered, and the reference has one number for each lane.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                let to: &mut [$scalar; $n] =
                    (&mut to[..$n]).try_into().expect("the slice has the length of the array");
                // SAFETY: entered, and the reference has one number for each lane.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn load_part(from: &[$scalar]) -> Self {
                assert!(from.len() < $n, "`load_part` needs fewer than {} numbers, found {}", $n, from.len());
                // SAFETY: entered, and only the lanes of the slice are touched.
                Self(unsafe { $load_part(from) })
            }
            #[inline(always)]
            fn store_part(self, to: &mut [$scalar]) {
                assert!(to.len() < $n, "`store_part` needs fewer than {} numbers, found {}", $n, to.len());
                // SAFETY: entered, and only the lanes of the slice are touched.
                unsafe { $store_part(to, self.0) }
            }
            #[inline(always)]
            fn mask(bits: u16) -> $mask {
                // SAFETY: entered.
                unsafe { $from_bits(bits) }
            }
            #[inline(always)]
            fn zip(self, other: Self) -> [Self; 2] {
                let ($one, $other) = (self.0, other.0);
                // SAFETY: entered.
                let [first, second] = unsafe { $zip };
                [Self(first), Self(second)]
            }
        }

        impl $name {
            /// Calls a scalar function for each lane. This is for functions that have no SIMD version.
            #[inline(always)]
            fn each(self, other: Self, f: impl Fn($scalar, $scalar) -> $scalar) -> Self {
                let (mut a, mut b) = ([0.0; $n], [0.0; $n]);
                self.store(&mut a);
                other.store(&mut b);
                for (a, b) in a.iter_mut().zip(b) {
                    *a = f(*a, b);
                }
                Self::load(&a)
            }
        }

        impl Primitive for $name {
            type Scalar = $scalar;

            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                // SAFETY: entered.
                Self(unsafe { $fused(self.0, a.0, b.0) })
            }
            #[inline(always)]
            fn exp2_integer(self) -> Self {
                let shifted = self + Self::constant(Self::ROUNDING);
                let $shifted = shifted.0;
                // SAFETY: entered.
                Self(unsafe { $exp2 })
            }
            #[inline(always)]
            fn where_less(self, bound: Self, if_less: Self, otherwise: Self) -> Self {
                Self::select(self.less(bound), if_less, otherwise)
            }
            #[inline(always)]
            fn magnitude(self) -> Self {
                let $signed = self.0;
                // SAFETY: entered.
                Self(unsafe { $abs })
            }
            #[inline(always)]
            fn with_sign_of(self, other: Self) -> Self {
                let ($size, $sign) = (self.0, other.0);
                // SAFETY: entered.
                Self(unsafe { $with_sign })
            }
        }

        impl Real for $name {
            type Mask = $mask;

            #[inline(always)]
            fn lit(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[track_caller]
            fn primal(self) -> f64 {
                let mut lanes = [0.0; $n];
                self.store(&mut lanes);
                let one = lanes
                    .iter()
                    .all(|lane| lane.to_bits() == lanes[0].to_bits());
                assert!(one, "`primal` was called on lanes with different values, {lanes:?}; all lanes must be equal");
                lanes[0].into()
            }
            #[inline(always)]
            fn less<T>(self, other: T) -> $mask
            where
                Self: $crate::real::Accepts<T>,
            {
                let other = <Self as $crate::real::Accepts<T>>::accept(other);
                // SAFETY: entered.
                unsafe { $lt(self.0, other.0) }
            }
            #[inline(always)]
            fn less_equal<T>(self, other: T) -> $mask
            where
                Self: $crate::real::Accepts<T>,
            {
                let other = <Self as $crate::real::Accepts<T>>::accept(other);
                // SAFETY: entered.
                unsafe { $le(self.0, other.0) }
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                // SAFETY: entered.
                Self(unsafe { $blend(mask, if_true.0, if_false.0) })
            }
            #[inline(always)]
            fn fma(self, factor: Self, term: Self) -> Self {
                // SAFETY: entered.
                Self(unsafe { $fma(self.0, factor.0, term.0) })
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: entered.
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn exp(self) -> Self {
                math::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.each(self, |x, _| Real::ln(x))
            }
            #[inline(always)]
            fn sin(self) -> Self {
                if self.abs().less_equal(Self::lit(math::SIN_RANGE)).all() {
                    math::sin_cos(self).0
                } else {
                    self.each(self, |x, _| Real::sin(x))
                }
            }
            #[inline(always)]
            fn cos(self) -> Self {
                if self.abs().less_equal(Self::lit(math::SIN_RANGE)).all() {
                    math::sin_cos(self).1
                } else {
                    self.each(self, |x, _| Real::cos(x))
                }
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                let [y] = $tanh([self]);
                y
            }
            #[inline(always)]
            fn atan2<T>(self, x: T) -> Self
            where
                Self: $crate::real::Accepts<T>,
            {
                self.each(<Self as $crate::real::Accepts<T>>::accept(x), |y, x| Real::atan2(y, x))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                // Scalars compute powers in double precision.
                if const { size_of::<$scalar>() == 8 } && exponent.unsigned_abs() <= math::FEW {
                    let power = math::by_squaring(Self::lit(1.0), self, exponent.unsigned_abs());
                    return if exponent < 0 { power.recip() } else { power };
                }
                self.each(self, |x, _| Real::powi(x, exponent))
            }
            #[inline(always)]
            fn powf<T>(self, exponent: T) -> Self
            where
                Self: $crate::real::Accepts<T>,
            {
                self.each(<Self as $crate::real::Accepts<T>>::accept(exponent), |x, y| Real::powf(x, y))
            }
            #[inline(always)]
            fn elementary(self, function: Elementary) -> Self {
                match function.on_floats(self) {
                    $crate::math::OnFloats::Formula(value) => value,
                    $crate::math::OnFloats::Function(_) => self.each(self, |x, _| x.elementary(function)),
                }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.magnitude()
            }
            #[inline(always)]
            fn detach(self) -> Self {
                self
            }
            #[inline(always)]
            fn straight_through(self, _soft: Self) -> Self {
                self
            }
            #[inline(always)]
            fn chain(partial: Self, cotangent: Self) -> Self {
                let product = partial * cotangent;
                let ($tested, $kept) = (cotangent.0, product.0);
                // SAFETY: entered.
                Self(unsafe { $where_nonzero })
            }
            #[inline(always)]
            fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
                let ($partial, $cotangent, $term) = (partial.0, cotangent.0, term.0);
                // SAFETY: entered.
                Self(unsafe { $fma_where_nonzero })
            }
        }
    };
}
