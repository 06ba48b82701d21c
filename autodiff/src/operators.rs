//! The operators of number types.

/// Implements `+ - * /`, negation and the assigning operators for a number type:
///
/// ```text
/// operators! {
///     #[inline] impl[R: Real] Number<R>:
///     a + b => Number(a.0 + b.0),
///     a - b => Number(a.0 - b.0),
///     a * b => Number(a.0 * b.0),
///     a / b => Number(a.0 / b.0),
///     -a => Number(-a.0),
/// }
/// ```
///
/// Attributes given first go to every method. The assigning operators follow from the others.
macro_rules! operators {
    (
        $(#[$attribute:meta])*
        impl[$($generics:tt)*] $number:ty:
        $a:ident + $b:ident => $sum:expr,
        $c:ident - $d:ident => $difference:expr,
        $e:ident * $f:ident => $product:expr,
        $g:ident / $h:ident => $quotient:expr,
        -$i:ident => $negative:expr $(,)?
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

pub(crate) use {operator, operators};
