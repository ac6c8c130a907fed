//! Memory in huge pages for large blocks.
//!
//! A reduction streams through blocks of gigabytes. With pages of 4 KiB, address translation alone halves the bandwidth, and touching a
//! new block costs a page fault for each of them. Linux gives huge pages to who asks (`transparent_hugepage` is mostly set to
//! `madvise`); elsewhere this is the system's allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use dcb_formats::out_of_memory::address_space_limit;

/// Blocks from this size on ask for huge pages.
const LARGE: usize = 8 << 20;
/// Bytes of a page of ordinary size.
const PAGE: usize = 4096;

/// Whether the allocator keeps freed memory, and there is no limit that holes would use up.
static KEPT: AtomicBool = AtomicBool::new(false);

/// The system's allocator, with huge pages for large blocks.
pub struct HugePages;

// SAFETY: every call goes to the system's allocator unchanged; the advice changes neither contents nor ownership.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        let block = unsafe { System.alloc(layout) };
        advise(block, layout.size());
        block
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        let block = unsafe { System.alloc_zeroed(layout) };
        advise(block, layout.size());
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the allocator's contract.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        let block = unsafe { System.realloc(block, layout, size) };
        advise(block, size);
        block
    }
}

/// Lets the allocator keep freed memory for the next blocks instead of giving it back: a reduction allocates blocks of the same
/// sizes again and again, and pages fresh from the system are cleared first, or even fetched from a host that had taken them. It
/// leaves holes, a tenth of the peak. For programs, at their start.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: settings of the C library's allocator; one that it doesn't know it ignores.
    unsafe {
        libc::mallopt(libc::M_MMAP_MAX, 0);
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        if address_space_limit().is_none() {
            libc::mallopt(libc::M_TOP_PAD, 64 << 20);
            KEPT.store(true, Ordering::Relaxed);
        }
        libc::mallopt(libc::M_ARENA_MAX, 1);
    }
}

#[cfg(target_os = "linux")]
fn advise(block: *mut u8, size: usize) {
    if size < LARGE || block.is_null() {
        return;
    }
    let start = (block as usize).next_multiple_of(PAGE);
    let end = (block as usize + size) & !(PAGE - 1);
    // SAFETY: whole pages of a block that the allocator has just handed out; the advice is only that.
    unsafe {
        libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE);
    }
}

#[cfg(not(target_os = "linux"))]
fn advise(_: *mut u8, _: usize) {}

/// Touches room for the blocks to come, page by page until it is told to stop, and hands it to the allocator, which keeps it: for a thread that has
/// nothing else to do. Nothing happens where freed memory isn't kept, or may be too little.
pub(crate) fn touch_ahead(bytes: usize, stop: &AtomicBool) {
    let mut room: Vec<u8> = Vec::new();
    if !KEPT.load(Ordering::Relaxed) || room.try_reserve_exact(bytes).is_err() {
        return;
    }
    for page in room.spare_capacity_mut().chunks_mut(PAGE) {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        // SAFETY: the page is the vector's own; volatile, because nobody reads what is written.
        unsafe { page.as_mut_ptr().write_volatile(MaybeUninit::new(0)) };
    }
}
