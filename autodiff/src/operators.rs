//! The operators and identities of number types.

/// Implements `+ - * /`, negation, the assigning operators, `Zero`, `One` and `Sum` for a number type:
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
/// Attributes given first go to every operator. The assigning operators and the sum, which is term by term,
/// follow from the others.
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
        $crate::operators::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Add add AddAssign add_assign, $a $b $sum
        }
        $crate::operators::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Sub sub SubAssign sub_assign, $c $d $difference
        }
        $crate::operators::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Mul mul MulAssign mul_assign, $e $f $product
        }
        $crate::operators::operator! {
            [$(#[$attribute])*] [$($generics)*] $number, Div div DivAssign div_assign, $g $h $quotient
        }
        impl<$($generics)*> std::ops::Neg for $number {
            type Output = Self;
            $(#[$attribute])*
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
        impl<$($generics)*> std::iter::Sum for $number {
            fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
                terms.fold(num_traits::Zero::zero(), |sum, term| sum + term)
            }
        }
    };
}

/// One binary operator and the assigning one.
macro_rules! operator {
    (
        [$($attribute:tt)*] [$($generics:tt)*] $number:ty,
        $trait:ident $method:ident $assign_trait:ident $assign:ident,
        $a:ident $b:ident $result:expr
    ) => {
        impl<$($generics)*> std::ops::$trait for $number {
            type Output = Self;
            $($attribute)*
            fn $method(self, $b: Self) -> Self {
                let $a = self;
                $result
            }
        }
        impl<$($generics)*> std::ops::$assign_trait for $number {
            $($attribute)*
            fn $assign(&mut self, other: Self) {
                *self = std::ops::$trait::$method(*self, other);
            }
        }
    };
}

/// Makes constants of a number type from integers and floats, by way of f64.
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

/// Compares and displays numbers over `R` by their primal, the field `value`.
macro_rules! by_primal {
    ([$($generics:tt)*] $number:ty) => {
        impl<R: PartialEq $($generics)*> PartialEq for $number {
            #[inline(always)]
            fn eq(&self, other: &Self) -> bool {
                self.value == other.value
            }
        }
        impl<R: PartialOrd $($generics)*> PartialOrd for $number {
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

pub(crate) use {by_primal, constants_by_f64, operator, operators};
