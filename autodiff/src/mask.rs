//! The trait [`Mask`]: the result of a comparison.

use std::fmt::Debug;
use std::ops::{BitAnd, BitOr, Not};

/// The result of a comparison: `bool`, or one boolean for each lane.
///
/// [`any`](Mask::any) and [`all`](Mask::all) allow code to skip work that no lane needs. A lane's result must not
/// depend on their answer, because the answer also depends on the other lanes.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Whether a comparison has one answer and not one for each lane. This is false for lanes, and for the symbols that
    /// recordings use. Code inside `if R::Mask::IS_SINGLE` may branch on comparisons. It is compiled only if the
    /// condition is true.
    const IS_SINGLE: bool = false;
    /// Whether a choice by a mask records both operands, even if all lanes choose the same one. This is true only for
    /// the numbers on which sparsity patterns are traced.
    #[doc(hidden)]
    const KEEPS_BOTH: bool = false;

    /// Returns a mask with the same boolean in every lane.
    fn splat(value: bool) -> Self;
    /// Returns whether the mask is true in any lane.
    fn any(self) -> bool;
    /// Returns whether the mask is true in all lanes.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }
}

impl Mask for bool {
    const IS_SINGLE: bool = true;
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}
