//! Prefetching: a hint to load memory into the cache.

/// Prefetches `len` numbers from the pointer `first` on, because they will be read or written soon. The pointer need
/// not be valid.
#[inline(always)]
pub fn prefetch<T>(first: *const T, len: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..(len * size_of::<T>()).div_ceil(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        #[allow(unsafe_code)]
        // Saves a fifth of a gradient's time.
        // SAFETY: this is a hint to the cache; it reads nothing that the program can observe.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(first.cast::<i8>().wrapping_add(64 * line));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (first, len);
}
