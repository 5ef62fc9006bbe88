//! The `prt` program. Everything it does is in the library.

use prt_harness::memory::Counting;

/// So that the peak of an encode can be told.
#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> std::process::ExitCode {
    prt_harness::cli::main()
}
