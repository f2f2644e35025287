//! The program `gravcal`.

use std::process::ExitCode;

use gravcal_robot_model::Registry;

/// Studies pose thousands of small problems a second.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    gravcal_cli::main(std::env::args_os(), &Registry::standard()).into()
}
