//! The `prt` program. Everything it does is in the library.

fn main() -> std::process::ExitCode {
    prt_harness::cli::main()
}
