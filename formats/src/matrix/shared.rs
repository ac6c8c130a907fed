//! Slices that several threads write to at once, each place by one of them.
//!
//! Relaxed stores are plain stores on every processor we know; what they buy is that a mistake gives a wrong number, not undefined
//! behaviour.

use std::sync::atomic::{AtomicU32, AtomicU64};

const _: () = assert!(align_of::<AtomicU32>() == align_of::<u32>());
const _: () = assert!(align_of::<AtomicU64>() == align_of::<f64>());

/// Indices as atomics.
pub(super) fn shared_indices(indices: &mut [u32]) -> &[AtomicU32] {
    // SAFETY: same size, bit validity and (checked above) alignment; borrowed mutably, so there is no other access meanwhile.
    unsafe { &*(std::ptr::from_mut(indices) as *const [AtomicU32]) }
}

/// Reals as atomics that hold their bits.
pub(super) fn shared_reals(reals: &mut [f64]) -> &[AtomicU64] {
    // SAFETY: same size, bit validity and (checked above) alignment; borrowed mutably, so there is no other access meanwhile.
    unsafe { &*(std::ptr::from_mut(reals) as *const [AtomicU64]) }
}
