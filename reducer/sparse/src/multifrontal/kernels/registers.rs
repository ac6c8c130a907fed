//! Rows of right-hand sides as the machine's registers, and what the loops have in common.

/// Bytes of a cache line.
const LINE: usize = 64;

/// Numbers in a register of the machines that have the most of them, and registers of any kind.
pub(super) const WIDE: usize = 8;
pub(super) const ANY: usize = 0;

/// Whether a row of `N` numbers is so many registers, of so many numbers each.
pub(super) const fn has_registers<S: pulp::Simd, const N: usize>(
    count: usize,
    lanes: usize,
) -> bool {
    N / S::F64_LANES == count && (lanes == ANY || S::F64_LANES == lanes)
}

/// Asks for the cache lines that stand `ahead` bytes behind a row of the factor: the arithmetic is shorter than memory's latency.
#[inline(always)]
pub(super) fn ask_ahead<T>(row: &[T], ahead: isize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = row.as_ptr().cast::<i8>().wrapping_offset(ahead);
        let mut offset = 0;
        while offset < size_of_val(row) {
            // SAFETY: a prefetch of any address, mapped or not, has no effect but on caches.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset)) };
            offset += LINE;
        }
    }
}

/// Rows of right-hand sides, each in `R` registers.
#[inline(always)]
pub(super) fn rows<S: pulp::Simd, const N: usize, const R: usize>(
    w: &mut [[f64; N]],
) -> &mut [[S::f64s; R]] {
    let (registers, _) = S::as_mut_simd_f64s(w.as_flattened_mut());
    registers.as_chunks_mut::<R>().0
}

/// `to -= factor · x`
#[inline(always)]
pub(super) fn subtract_scaled<S: pulp::Simd, const R: usize>(
    simd: S,
    to: &mut [S::f64s; R],
    factor: f64,
    x: &[S::f64s; R],
) {
    let factor = simd.splat_f64s(factor);
    for i in 0..R {
        to[i] = simd.negate_mul_add_f64s(factor, x[i], to[i]);
    }
}

/// `to *= factor`
#[inline(always)]
pub(super) fn scale<S: pulp::Simd, const R: usize>(simd: S, to: &mut [S::f64s; R], factor: f64) {
    let factor = simd.splat_f64s(factor);
    for entry in to {
        *entry = simd.mul_f64s(factor, *entry);
    }
}
