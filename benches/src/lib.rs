//! What the benchmarks share: a matrix that needs no scene, and memory traffic to hold a kernel's time against.
//!
//! `cargo bench -p prt-benches` runs everything; `cargo bench -p prt-benches -- one_channel` a group, and
//! `cargo bench -p prt-benches -- 'one_channel/copy|one_channel/csr'` the two that are compared. Criterion prints
//! `[low estimate high]` of the time of one relighting and of two throughputs. How to read them:
//!
//! - Compare within one run only. `copy/csr bytes` moves as many bytes (read and written together) as `csr` holds and
//!   writes: a `csr` that takes 1.25 times as long relights at 80 % of the memory bandwidth. `read/csr bytes` only reads
//!   them: no kernel can be faster than that on a matrix beyond the caches.
//! - `GiB/s` counts the bytes that each method itself holds: of two methods the faster is the one with the shorter time.
//! - `1` and `2` at the end of a name are threads. What `copy` gains by the second is what a kernel can gain.
//! - `csr, light in 2 KiB` has the rows of `csr` on 512 light coefficients: what it gains over `csr` is the cost of reading
//!   the light from beyond the first-level cache. `csr, in cache` has 8000 of the rows, again and again: what it gains per
//!   element is the cost of the matrix coming from memory, and what is left is the arithmetic's own.
//!
//! `benches/peers/csr_scipy.py` times SciPy's product on the same matrix.

use prt_transfer::{LightBasis, Result, TransferMatrix};

/// Rows of the matrix that the biclustering paper's signal has on a scene of 1,839 vertices: 64 directions each.
pub const ROWS: usize = 117_696;

/// Light coefficients of a cubemap of 6 x 32 x 32.
pub const LIGHTS: usize = 6144;

/// A sparse matrix shaped as supersampled visibility is: each row has 0 to 11 runs of 3 to 13 consecutive columns, 32 columns
/// apart (scanlines of a cubemap's face); elements are 1, and 1/4, 1/2 or 3/4 at both ends of a run. 44 elements a row.
///
/// Columns wrap around `lights`, which must be at least 512 for the elements of a row to stay apart. Row r is drawn from the
/// bits of [`mix`]`(r)` alone, so that another language can draw the same.
pub fn synthetic(rows: usize, lights: usize) -> Result<TransferMatrix> {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..rows {
        let bits = mix(row as u64);
        let (runs, width) = (bits % 12, 3 + (bits >> 8) % 11);
        let start = (bits >> 16) % (LIGHTS - 384) as u64;
        let mut elements = Vec::new();
        for run in 0..runs {
            let ends = [1 + (bits >> (40 + run)) % 3, 1 + (bits >> (50 + run)) % 3];
            for i in 0..width {
                let quarters = if i == 0 {
                    ends[0]
                } else if i + 1 == width {
                    ends[1]
                } else {
                    4
                };
                elements.push((((start + 32 * run + i) % lights as u64) as u32, quarters as f32 / 4.0));
            }
        }
        elements.sort_unstable_by_key(|e| e.0);
        columns.extend(elements.iter().map(|e| e.0));
        values.extend(elements.iter().map(|e| e.1));
        offsets.push(columns.len());
    }
    TransferMatrix::from_csr(offsets, columns, values, 1, LightBasis::Plain { lights })
}

/// SplitMix64's output function: 64 well-mixed bits of a counter.
pub fn mix(counter: u64) -> u64 {
    let mut z = counter.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
