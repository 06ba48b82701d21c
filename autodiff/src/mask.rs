//! The results of comparisons.

use std::fmt::Debug;
use std::ops::{BitAnd, BitOr, Not};

/// The result of a comparison: `bool`, or one boolean for each lane.
///
/// [`any`](Mask::any) and [`all`](Mask::all) are for skipping work that no lane needs. The result of a lane must
/// not depend on them, because other lanes influence the answer.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Whether a comparison has a single answer, because the numbers are neither lanes nor recorded symbols. Code
    /// inside `if R::Mask::IS_SINGLE` may branch on comparisons. It is only compiled if the condition is true.
    const IS_SINGLE: bool = false;

    /// The same boolean in every lane.
    fn splat(value: bool) -> Self;
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Whether all lanes are true.
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
