//! Maps a kernel over the elements of arrays.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use autodiff::Real;
use autodiff::internal::Unchecked;
use autodiff::simd::Lane;

use super::array::Array;
use super::kernel::{Kernel, MOST_UNIFORMS, Pullback};
use super::operation::LaneOperation;
use super::row::{BarPointers, Bars, Reach, StepValues, add, load};
use super::uniform::UniformInputs;

pub(crate) struct Map<K, const I: usize, const O: usize> {
    kernel: K,
    inputs: [Array; I],
    uniforms: UniformInputs,
    /// The output arrays, adjacent in memory.
    outputs: [Array; O],
    active: [bool; I],
    reach: Reach,
}

impl<K: Kernel<I, O>, const I: usize, const O: usize> Map<K, I, O> {
    pub(crate) fn new(
        kernel: K,
        inputs: [Array; I],
        uniforms: &[Array],
        outputs: [Array; O],
    ) -> Self {
        let len = outputs[0].len;
        Self {
            kernel,
            inputs,
            uniforms: UniformInputs::new(uniforms),
            outputs,
            active: [true; I],
            reach: Reach::new(inputs.iter().chain(&outputs).map(|&array| (array, len))),
        }
    }

    /// Returns the numbers of each input.
    ///
    /// # Safety
    /// The caller must have checked `reach` for these values.
    #[inline(always)]
    unsafe fn sources<'a, R: Copy>(&self, values: StepValues<'a, R>) -> [&'a [R]; I] {
        let mut sources = [values.row; I];
        for k in 0..I {
            // SAFETY: guaranteed by the caller.
            sources[k] = unsafe { values.reached(self.inputs[k], self.outputs[0].len) };
        }
        sources
    }
}

impl<R: Real, K: Kernel<I, O>, const I: usize, const O: usize> LaneOperation<R> for Map<K, I, O> {
    const HAS_SCALARS: bool = false;
    const HAS_512: bool = K::COMPILED.has_512();
    fn outputs(&self) -> Vec<Array> {
        self.outputs.to_vec()
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        for k in 0..I {
            self.active[k] = arrays[self.inputs[k].id];
        }
        self.active.contains(&true)
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        self.reach.check(parameters, row);
        let len = self.outputs[0].len;
        let (values, y) = StepValues::and_outputs(parameters, row, &self.outputs);
        // SAFETY: `reach` was checked. An operation's inputs lie before its outputs, which are adjacent.
        unsafe {
            let mut lanes = ForwardLanes::<_, _, L, I, O> {
                kernel: &self.kernel,
                x: self.sources(values),
                inputs: &self.uniforms,
                values,
                uniforms: self.uniforms.load(K::UNIFORMS, values),
                y,
                len,
            };
            lanes.lanes::<true>(len);
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        self.reach.check(values.parameters, values.row);
        self.reach.check(bars.parameters, bars.row);
        let Array { start, len, .. } = self.outputs[0];
        let pointers = BarPointers::new(bars);
        // SAFETY: `reach` was checked.
        unsafe {
            let mut lanes = ReverseLanes::<_, _, L, I, O> {
                kernel: &self.kernel,
                x: self.sources(values),
                inputs: &self.uniforms,
                values,
                uniforms: self.uniforms.load(K::UNIFORMS, values),
                y: &values.row[start..start + O * len],
                y_bar: pointers.of(self.outputs[0]),
                len,
                x_bar: pointers.of_active(&self.inputs, &self.active),
            };
            lanes.lanes::<false>(len);
        }
    }
}

/// Work on several arrays of equal length, one register at a time.
trait Lanes<R, L: Lane<R>> {
    /// Processes the `n` elements that begin at index `at`.
    ///
    /// # Safety
    /// All arrays must have these elements, and `n` must be at most `N`.
    unsafe fn lane(&mut self, at: usize, n: usize);

    /// Processes all elements. If `TWICE` is true, the last register may overlap the one before it, so that some
    /// elements are processed twice. This avoids a masked store, which would delay a later load of the whole register.
    ///
    /// # Safety
    /// All arrays must have at least `len` elements.
    #[inline(always)]
    unsafe fn lanes<const TWICE: bool>(&mut self, len: usize) {
        let whole = match TWICE && L::N <= len {
            true => len,
            false => len - len % L::N,
        };
        let mut i = 0;
        // SAFETY: each register ends within the arrays.
        unsafe {
            while i < whole {
                self.lane(if TWICE { i.min(len - L::N) } else { i }, L::N);
                i += L::N;
            }
            // With `N = 1` no elements remain, but the compiler does not know that.
            if L::N > 1 && i < len {
                self.lane(i, len - i)
            }
        }
    }
}

struct ForwardLanes<'a, K, R, L, const I: usize, const O: usize> {
    kernel: &'a K,
    x: [&'a [R]; I],
    inputs: &'a UniformInputs,
    values: StepValues<'a, R>,
    uniforms: [L; MOST_UNIFORMS],
    /// The output arrays, which lie one after the other; each has `len` numbers.
    y: &'a mut [R],
    len: usize,
}

impl<R: Real, K, L, const I: usize, const O: usize> Lanes<R, L> for ForwardLanes<'_, K, R, L, I, O>
where
    K: Kernel<I, O>,
    L: Lane<R>,
{
    #[inline(always)]
    unsafe fn lane(&mut self, i: usize, n: usize) {
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY, here and below: guaranteed by the caller.
            x[k] = unsafe { L::load_n(self.x[k], i, n) };
        }
        let uniforms = &mut self.uniforms[..K::UNIFORMS];
        if const { !K::COMPILED.has_512() } {
            self.inputs.turn(uniforms, self.values, i);
        }
        let y = self.kernel.eval(x, uniforms);
        for k in 0..O {
            unsafe { y[k].store_n(self.y, k * self.len + i, n) };
        }
    }
}

struct ReverseLanes<'a, K, R, L, const I: usize, const O: usize> {
    kernel: &'a K,
    x: [&'a [R]; I],
    inputs: &'a UniformInputs,
    values: StepValues<'a, R>,
    uniforms: [L; MOST_UNIFORMS],
    /// The output arrays, which lie one after the other; each has `len` numbers. `y_bar` points to their
    /// cotangents.
    y: &'a [R],
    y_bar: *const R,
    len: usize,
    /// For each input, a pointer to its cotangents; null if the input carries no derivative.
    x_bar: [*mut R; I],
}

impl<R: Real, K, L, const I: usize, const O: usize> Lanes<R, L> for ReverseLanes<'_, K, R, L, I, O>
where
    K: Kernel<I, O>,
    L: Lane<R>,
{
    #[inline(always)]
    unsafe fn lane(&mut self, i: usize, n: usize) {
        let (mut x, mut y, mut y_bar) = ([L::zero(); I], [L::zero(); O], [L::zero(); O]);
        for k in 0..I {
            // SAFETY, here and below: guaranteed by the caller; only one slice of cotangents exists at a time.
            x[k] = unsafe { L::load_n(self.x[k], i, n) };
        }
        for k in 0..O {
            let place = k * self.len + i;
            y[k] = unsafe { L::load_n(self.y, place, n) };
            y_bar[k] = unsafe { load(self.y_bar, place, n) };
        }
        let uniforms = &mut self.uniforms[..K::UNIFORMS];
        if const { !K::COMPILED.has_512() } {
            self.inputs.turn(uniforms, self.values, i);
        }
        let at = Pullback {
            x,
            uniforms,
            y,
            y_bar: [y_bar],
        };
        let [x_bar] = self.kernel.vjp(at);
        for k in 0..I {
            unsafe { add(self.x_bar[k], i, n, x_bar[k]) };
        }
    }
}
