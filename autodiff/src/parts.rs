//! Sums of many vectors.

use smallvec::SmallVec;

use crate::real::Real;

/// How many vectors are added to one sum.
const MOST: usize = 128;

/// A sum of vectors. Up to 128 vectors are added from first to last. More are added by parts: the sum of 128 vectors
/// is one vector of the next level. So the rounding error hardly grows with the number of vectors, which matters
/// in `f32`.
pub struct SumByParts<R> {
    len: usize,
    /// For each level, how many vectors are in its sum, and the sum.
    levels: SmallVec<[(usize, Vec<R>); 1]>,
}

impl<R: Real> SumByParts<R> {
    /// Returns an empty sum of vectors of this length.
    pub fn new(len: usize) -> Self {
        let levels = SmallVec::new();
        Self { len, levels }
    }

    /// Adds a vector.
    #[inline(always)]
    pub fn add(&mut self, vector: &[R]) {
        let mut free = 0;
        while free < self.levels.len() && self.levels[free].0 == MOST {
            free += 1;
        }
        if free == self.levels.len() {
            self.levels.push((0, vec![R::zero(); self.len]));
        }
        // The sums of full levels move up by one level.
        for level in (1..=free).rev() {
            let (below, above) = self.levels.split_at_mut(level);
            let (count, full) = &mut below[level - 1];
            *count = 0;
            above[0].0 += 1;
            add_to(&mut above[0].1, full);
            full.fill(R::zero());
        }
        let (count, sum) = &mut self.levels[0];
        *count += 1;
        add_to(sum, vector);
    }

    /// Returns the sum of all vectors.
    #[inline(always)]
    pub fn total(mut self) -> Vec<R> {
        for level in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(level);
            add_to(&mut above[0].1, &below[level - 1].1);
        }
        // A closure would not have the registers of the function around it.
        match self.levels.pop() {
            Some((_, sum)) => sum,
            None => vec![R::zero(); self.len],
        }
    }
}

#[inline(always)]
fn add_to<R: Real>(sum: &mut [R], vector: &[R]) {
    for (sum, &number) in sum.iter_mut().zip(vector) {
        *sum += number;
    }
}
