//! What the fuzz targets share: the checks, and the limit of memory.

#![allow(clippy::panic)]

pub mod checks;

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// What a reader may take beside a multiple of its input.
const BASE: usize = 16 << 20;

/// Bytes that a reader may take for each of its input.
const FACTOR: usize = 100;

/// The most that DEFLATE packs into a byte.
const DEFLATED: usize = 1032;

/// Runs a check, and panics if it held more memory than 16 MiB and 100 times its input, decompressed.
pub fn within_memory(data: &[u8], check: fn(&[u8])) {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    check(data);
    let held = ALLOCATOR.peak_usage().saturating_sub(before);
    let packed = data.windows(10).any(|w| w == b"compressor");
    let allowed = BASE + FACTOR * data.len() * if packed { DEFLATED } else { 1 };
    if held > allowed {
        panic!("{held} bytes held for an input of {}, {allowed} allowed", data.len());
    }
}
