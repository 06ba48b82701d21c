//! Macros that implement operators and related traits for number types.

/// Implements `+ - * /`, negation, the assigning operators, `Zero`, `One`, `Sum` and `Product` for a number type:
///
/// ```text
/// operators! {
///     #[inline] impl[R: Real] Number<R>:
///     a + b => Number(a.0 + b.0),
///     a - b => Number(a.0 - b.0),
///     a * b => Number(a.0 * b.0),
///     a / b => Number(a.0 / b.0),
///     -a => Number(-a.0),
///     0 => Number(R::zero()),
///     1 => Number(R::one()),
///     a == 0 => a.0.is_zero(),
/// }
/// ```
///
/// The attributes before `impl` are added to every operator. Assigning operators, sums and products are derived from
/// the other operators. Every operator is `#[track_caller]`, so that panics and traces name the line of the caller.
#[doc(hidden)]
#[macro_export]
macro_rules! operators {
    (
        $(#[$attribute:meta])*
        impl[$($generics:tt)*] $number:ty:
        $a:ident + $b:ident => $sum:expr,
        $c:ident - $d:ident => $difference:expr,
        $e:ident * $f:ident => $product:expr,
        $g:ident / $h:ident => $quotient:expr,
        -$i:ident => $negative:expr,
        0 => $zero:expr,
        1 => $one:expr,
        $j:ident == 0 => $is_zero:expr $(,)?
    ) => {
        $crate::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Add add AddAssign add_assign, $a $b $sum
        }
        $crate::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Sub sub SubAssign sub_assign, $c $d $difference
        }
        $crate::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Mul mul MulAssign mul_assign, $e $f $product
        }
        $crate::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Div div DivAssign div_assign, $g $h $quotient
        }
        impl<$($generics)*> std::ops::Neg for $number {
            type Output = Self;
            $(#[$attribute])*
            #[track_caller]
            fn neg(self) -> Self {
                let $i = self;
                $negative
            }
        }
        impl<$($generics)*> num_traits::Zero for $number {
            #[inline(always)]
            fn zero() -> Self {
                $zero
            }
            #[inline(always)]
            fn is_zero(&self) -> bool {
                let $j = *self;
                $is_zero
            }
        }
        impl<$($generics)*> num_traits::One for $number {
            #[inline(always)]
            fn one() -> Self {
                $one
            }
        }
        $crate::folds! { [$($generics)*] $number }
    };
}

/// Implements the operators whose right operand is a literal: `number op literal`. Multiplication may have a separate
/// expression, because a literal has no tangents to multiply. The number type also accepts floats as arguments of its
/// methods; with `@operators`, which is for f64, it gets only the operators.
#[doc(hidden)]
#[macro_export]
macro_rules! literal_operators {
    ($generics:tt $number:ty) => {
        $crate::literal_operators! { $generics $number, |a, b| a * <$number>::lit(b) }
    };
    ([$($generics:tt)*] $number:ty, |$a:ident, $b:ident| $product:expr) => {
        #[diagnostic::do_not_recommend]
        impl<$($generics)*> $crate::internal::Accepts<f64> for $number {
            #[inline(always)]
            fn accept(argument: f64) -> Self {
                Self::lit(argument)
            }
        }
        $crate::literal_operators! {
            @operators [$($generics)*] $number, |$a, $b| $product
        }
    };
    (@operators $generics:tt $number:ty, |$a:ident, $b:ident| $product:expr) => {
        $crate::right_operand! {
            $generics $number, Add add $crate::internal::Literal, |a, b| a + <$number>::lit(b.0)
        }
        $crate::right_operand! {
            $generics $number, Sub sub $crate::internal::Literal, |a, b| a - <$number>::lit(b.0)
        }
        $crate::right_operand! {
            $generics $number, Mul mul $crate::internal::Literal, |$a, b| {
                let $b = b.0;
                $product
            }
        }
        $crate::right_operand! {
            $generics $number, Div div $crate::internal::Literal, |a, b| a / <$number>::lit(b.0)
        }
        $crate::literal_operators! {
            @assign $generics $number,
            Add add AddAssign add_assign, Sub sub SubAssign sub_assign,
            Mul mul MulAssign mul_assign, Div div DivAssign div_assign
        }
    };
    (
        @assign $generics:tt $number:ty,
        $($trait:ident $method:ident $assign_trait:ident $assign:ident),*
    ) => {
        $($crate::assigning! {
            $generics $number, $trait $method $assign_trait $assign $crate::internal::Literal
        })*
    };
}

/// Implements the traits `Sum` and `Product` for iterators over numbers and over references to numbers.
#[doc(hidden)]
#[macro_export]
macro_rules! folds {
    ([$($generics:tt)*] $number:ty) => {
        impl<$($generics)*> std::iter::Sum for $number {
            #[inline(always)]
            #[track_caller]
            fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
                let mut sum = <Self as num_traits::Zero>::zero();
                for term in terms {
                    sum += term;
                }
                sum
            }
        }
        impl<$($generics)*> std::iter::Product for $number {
            #[inline(always)]
            #[track_caller]
            fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
                let mut product = <Self as num_traits::One>::one();
                for factor in factors {
                    product *= factor;
                }
                product
            }
        }
        impl<'a, $($generics)*> std::iter::Sum<&'a Self> for $number {
            #[inline(always)]
            #[track_caller]
            fn sum<I: Iterator<Item = &'a Self>>(terms: I) -> Self {
                terms.copied().sum()
            }
        }
        impl<'a, $($generics)*> std::iter::Product<&'a Self> for $number {
            #[inline(always)]
            #[track_caller]
            fn product<I: Iterator<Item = &'a Self>>(factors: I) -> Self {
                factors.copied().product()
            }
        }
    };
}

/// Implements more operators for one concrete number type, so that formulas in closures are easy to read: operators
/// with a float or a reference on either side, and comparisons with floats.
macro_rules! closure_operators {
    ([$($generics:tt)*] $number:ty) => {
        $crate::operators::closure_operators! {
            @each [$($generics)*] $number,
            Add add AddAssign add_assign |a, b| <$number>::lit(a) + b,
            Sub sub SubAssign sub_assign |a, b| <$number>::lit(a) - b,
            Mul mul MulAssign mul_assign |a, b| b * a,
            Div div DivAssign div_assign |a, b| <$number>::lit(a) / b
        }
        impl<$($generics)*> PartialEq<f64> for $number
        where
            Self: PartialEq,
        {
            fn eq(&self, other: &f64) -> bool {
                *self == Self::lit(*other)
            }
        }
        impl<$($generics)*> PartialOrd<f64> for $number
        where
            Self: PartialOrd,
        {
            fn partial_cmp(&self, other: &f64) -> Option<std::cmp::Ordering> {
                self.partial_cmp(&Self::lit(*other))
            }
        }
        impl<'a, $($generics)*> std::ops::Neg for &'a $number {
            type Output = $number;
            #[inline(always)]
            #[track_caller]
            fn neg(self) -> $number {
                -*self
            }
        }
    };
    (
        @each $generics:tt $number:ty,
        $(
            $trait:ident $method:ident $assign_trait:ident $assign:ident
            |$a:ident, $b:ident| $float_first:expr
        ),*
    ) => {
        $($crate::operators::closure_operator! {
            $generics $number, $trait $method $assign_trait $assign |$a, $b| $float_first
        })*
    };
}

/// Implements one binary operator of `closure_operators` and its assigning operator.
macro_rules! closure_operator {
    (
        [$($generics:tt)*] $number:ty,
        $trait:ident $method:ident $assign_trait:ident $assign:ident
        |$a:ident, $b:ident| $float_first:expr
    ) => {
        $crate::right_operand! {
            [$($generics)*] $number, $trait $method f64,
            |a, b| std::ops::$trait::$method(a, $crate::internal::Literal(b))
        }
        $crate::right_operand! {
            ['a, $($generics)*] $number, $trait $method &'a $number,
            |a, b| std::ops::$trait::$method(a, *b)
        }
        impl<$($generics)*> std::ops::$trait<$number> for f64 {
            type Output = $number;
            #[inline(always)]
            #[track_caller]
            fn $method(self, $b: $number) -> $number {
                let $a = self;
                $float_first
            }
        }
        impl<'a, $($generics)*> std::ops::$trait<&'a $number> for f64 {
            type Output = $number;
            #[inline(always)]
            #[track_caller]
            fn $method(self, other: &'a $number) -> $number {
                std::ops::$trait::$method(self, *other)
            }
        }
        impl<'a, T, $($generics)*> std::ops::$trait<T> for &'a $number
        where
            $number: std::ops::$trait<T, Output = $number>,
        {
            type Output = $number;
            #[inline(always)]
            #[track_caller]
            fn $method(self, other: T) -> $number {
                std::ops::$trait::$method(*self, other)
            }
        }
        $crate::assigning! {
            [$($generics)*] $number, $trait $method $assign_trait $assign f64
        }
        $crate::assigning! {
            ['a, $($generics)*] $number, $trait $method $assign_trait $assign &'a $number
        }
    };
}

/// Implements a binary operator for one type of the right operand: `number op operand`.
#[doc(hidden)]
#[macro_export]
macro_rules! right_operand {
    (
        [$($generics:tt)*] $number:ty, $trait:ident $method:ident $operand:ty,
        |$a:ident, $b:ident| $result:expr
    ) => {
        impl<$($generics)*> std::ops::$trait<$operand> for $number {
            type Output = Self;
            #[inline(always)]
            #[track_caller]
            fn $method(self, $b: $operand) -> Self {
                let $a = self;
                $result
            }
        }
    };
}

/// Implements an assigning operator: `number op= operand`.
#[doc(hidden)]
#[macro_export]
macro_rules! assigning {
    (
        [$($generics:tt)*] $number:ty,
        $trait:ident $method:ident $assign_trait:ident $assign:ident $operand:ty
    ) => {
        impl<$($generics)*> std::ops::$assign_trait<$operand> for $number {
            #[inline(always)]
            #[track_caller]
            fn $assign(&mut self, other: $operand) {
                *self = std::ops::$trait::$method(*self, other);
            }
        }
    };
}

/// Implements a binary operator and its assigning operator.
#[doc(hidden)]
#[macro_export]
macro_rules! operator {
    (
        [$($attribute:tt)*] [$($generics:tt)*] $number:ty,
        $trait:ident $method:ident $assign_trait:ident $assign:ident,
        $a:ident $b:ident $result:expr
    ) => {
        impl<$($generics)*> std::ops::$trait for $number {
            type Output = Self;
            $($attribute)*
            #[track_caller]
            fn $method(self, $b: Self) -> Self {
                let $a = self;
                $result
            }
        }
        impl<$($generics)*> std::ops::$assign_trait for $number {
            $($attribute)*
            #[track_caller]
            fn $assign(&mut self, other: Self) {
                *self = std::ops::$trait::$method(*self, other);
            }
        }
    };
}

/// Implements the conversion of integers and floats to constants of a number type. They are first converted to f64.
macro_rules! constants_by_f64 {
    ([$($generics:tt)*] $number:ty) => {
        impl<$($generics)*> num_traits::FromPrimitive for $number {
            fn from_i64(value: i64) -> Option<Self> {
                Self::from_f64(value as f64)
            }
            fn from_u64(value: u64) -> Option<Self> {
                Self::from_f64(value as f64)
            }
            fn from_f64(value: f64) -> Option<Self> {
                Some(Self::lit(value))
            }
        }
    };
}

/// Implements comparison and display for a number type over `R`. Both use the primal, which is the field `value`.
/// Equality also asks the expression, which says whether a number carries a derivative: such a number never equals a
/// constant.
macro_rules! by_primal {
    ([$($generics:tt)*] $number:ty, |$x:ident| $carries:expr) => {
        impl<R: PartialEq + num_traits::Zero $($generics)*> PartialEq for $number {
            #[inline(always)]
            fn eq(&self, other: &Self) -> bool {
                let carries = |$x: &Self| $carries;
                self.value == other.value && carries(self) == carries(other)
            }
        }
        impl<R: PartialOrd + num_traits::Zero $($generics)*> PartialOrd for $number {
            #[inline(always)]
            fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
                self.value.partial_cmp(&other.value)
            }
        }
        impl<R: std::fmt::Display $($generics)*> std::fmt::Display for $number {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.value.fmt(formatter)
            }
        }
    };
}

pub(crate) use {
    by_primal, closure_operator, closure_operators, constants_by_f64, literal_operators, operator,
    operators,
};
