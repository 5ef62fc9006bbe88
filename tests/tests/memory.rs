//! Resident storage is what memory holds: counted by the allocator, not by a formula. Alone in its process, so that no other
//! test allocates meanwhile.

use prt_harness::registry::registry;
use prt_tests::*;
use prt_transfer::io::prt;
use prt_transfer::{LightBasis, TransferMatrix};
use rand::RngExt;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

struct Counting;
static HELD: AtomicIsize = AtomicIsize::new(0);

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        HELD.fetch_add(layout.size() as isize, Relaxed);
        // SAFETY: as the caller promised us.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as isize, Relaxed);
        // SAFETY: as the caller promised us.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn memory_held_after_loading_is_the_resident_size() {
    let registry = registry();
    let basis = LightBasis::Cubemap { resolution: 16 };
    let mut rng = random(1);
    let element = |i: usize| if (i / 64).is_multiple_of(5) { rng.random_range(1..5) as f32 / 4.0 } else { 0.0 };
    let values: Vec<f32> = (0..400 * basis.lights()).map(element).collect();
    let dense = TransferMatrix::from_dense(values, 400, 1, basis).unwrap();
    for matrix in [sparse(&dense), dense] {
        for label in labels(&registry) {
            let bytes = prt::to_bytes(&encode(&registry, &label, &matrix).unwrap()).unwrap();
            drop(prt::from_bytes(&bytes, &registry).unwrap()); // whatever is made once per process exists now
            let before = HELD.load(Relaxed);
            let reloaded = prt::from_bytes(&bytes, &registry).unwrap();
            let held = (HELD.load(Relaxed) - before) as f64;
            let resident = reloaded.resident_bytes() as f64;
            // Labels, names and boxes come on top.
            assert!(held <= 1.02 * resident + 4096.0, "{label}: {held} bytes held, {resident} written");
            assert!(held >= 0.98 * resident - 4096.0, "{label}: {held} bytes held, {resident} written");
        }
    }
}
