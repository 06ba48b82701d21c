use autodiff::arrays::vjp_by_duals;
use autodiff::{Pullback, Real};

use super::guarded::{Guarded, Held};
use super::{Bent, Every};

impl Bent {
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        vjp_by_duals(self, at)
    }
}

impl Every {
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: Pullback<R, 3, 13, M>) -> [[R; 3]; M] {
        vjp_by_duals(self, at)
    }
}

impl Held {
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        vjp_by_duals(self, at)
    }
}

impl Guarded {
    pub(crate) fn emitted_vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 7, M>) -> [[R; 2]; M] {
        vjp_by_duals(self, at)
    }
}
