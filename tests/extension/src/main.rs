//! `gravcal` with the models of this crate.

use std::process::ExitCode;

/// That of gravcal's own program: problems are made of many small pieces.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    gravcal_cli::main(std::env::args_os(), &gravcal_extension::registry()).into()
}
