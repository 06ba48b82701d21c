//! Implements [`Lane`] for every number type, as a register with a single lane, and counts the lanes of a number type.

use crate::real::{Lane, Mask, Real, Vectorized};

/// The largest number of lanes that a register of any type has.
pub const WIDEST: usize = 16;

/// Every number is a register of one lane.
impl<R: Real> Lane<R> for R {
    const N: usize = 1;
    #[inline(always)]
    fn splat(value: R) -> R {
        value
    }
    #[inline(always)]
    fn load(from: &[R]) -> R {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[0] = self;
    }
    #[inline(always)]
    fn load_part(from: &[R]) -> R {
        assert!(
            from.is_empty(),
            "`load_part` needs fewer than 1 number, found {}",
            from.len()
        );
        R::zero()
    }
    #[inline(always)]
    fn store_part(self, to: &mut [R]) {
        assert!(
            to.is_empty(),
            "`store_part` needs fewer than 1 number, found {}",
            to.len()
        );
    }
    #[inline(always)]
    fn mask(bits: u16) -> R::Mask {
        R::Mask::splat(bits & 1 == 1)
    }
    #[inline(always)]
    fn zip(self, other: R) -> [R; 2] {
        [self, other]
    }
}

struct LaneCount<const HAS_512: bool>;

impl<R: Real, const HAS_512: bool> Vectorized<R> for LaneCount<HAS_512> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = usize;
    const HAS_512: bool = HAS_512;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> usize {
        L::N
    }
}

/// The number of lanes in a register of the number type `R` on this machine.
pub fn lanes<R: Real>() -> usize {
    checked(R::vectorize(LaneCount::<true>))
}

/// The number of lanes for work that [has registers of 512 bits](Vectorized::HAS_512) or not.
pub fn lanes_with<R: Real>(has_512: bool) -> usize {
    match has_512 {
        true => lanes::<R>(),
        false => checked(R::vectorize(LaneCount::<false>)),
    }
}

fn checked(lanes: usize) -> usize {
    let fits = lanes.is_power_of_two() && lanes <= WIDEST;
    assert!(
        fits,
        "a number type has {lanes} lanes; the number of lanes must be a power of two, at most {WIDEST}"
    );
    lanes
}
