//! How much memory is held, and the most that was: counted by the allocator, not by a formula.
//!
//! The only `unsafe` of the program is here, in the allocator that passes everything on to the system's.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, counting. A program installs it by `#[global_allocator]`; without it nothing is counted.
pub struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// Bytes that the program has asked for and not given back; 0 where [`Counting`] is not installed.
pub fn held() -> usize {
    HELD.load(Relaxed)
}

/// Runs `work` and tells the most bytes that were held meanwhile beyond those held before; `None` where [`Counting`] is not
/// installed. Threads are counted together, so that nothing else should run; one such measurement must not lie inside another.
pub fn peak_of<T>(work: impl FnOnce() -> T) -> (T, Option<u64>) {
    let before = held();
    PEAK.store(before, Relaxed);
    let done = work();
    let peak = PEAK.load(Relaxed);
    // A program cannot run without having asked for anything.
    (done, (peak > 0).then(|| (peak - before) as u64))
}

fn grow(bytes: usize) {
    let held = HELD.fetch_add(bytes, Relaxed) + bytes;
    // Reading is cheaper than writing what every thread reads.
    if held > PEAK.load(Relaxed) {
        PEAK.fetch_max(held, Relaxed);
    }
}

fn shrink(bytes: usize) {
    HELD.fetch_sub(bytes, Relaxed);
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as the caller promised us.
        unsafe { System.alloc(layout) }
    }
    // Not by way of `alloc`: the system has zeroed pages ready, and extends large blocks without copying them.
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as the caller promised us.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        match size.checked_sub(layout.size()) {
            Some(more) => grow(more),
            None => shrink(layout.size() - size),
        }
        // SAFETY: as the caller promised us.
        unsafe { System.realloc(pointer, layout, size) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        shrink(layout.size());
        // SAFETY: as the caller promised us.
        unsafe { System.dealloc(pointer, layout) }
    }
}
