//! `gravcal completions` and `gravcal manual`: what shells and `man` want to know of the program, generated from its arguments.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use crate::exit::Exit;
use crate::failure::Failure;
use crate::terminal;

/// Print completions for a shell
///
/// For bash: gravcal completions bash > ~/.local/share/bash-completion/completions/gravcal
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// Which shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Write the manual: a page for the program and one for each command
#[derive(Debug, Args)]
pub struct ManualArguments {
    /// Folder for the pages, such as ~/.local/share/man/man1
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Prints completions of the program.
pub fn complete(arguments: &CompletionsArguments, mut program: Command) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "gravcal", &mut script);
    terminal::print_exactly(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Determined)
}

/// Writes the pages of the manual.
pub fn write_manual(arguments: &ManualArguments, program: Command) -> Result<Exit, Failure> {
    let folder = arguments.folder.as_path();
    let refused = |error: &std::io::Error| Failure::bad_input(error).about(folder.display());
    std::fs::create_dir_all(folder).map_err(|error| refused(&error))?;
    clap_mangen::generate_to(program, folder).map_err(|error| refused(&error))?;
    terminal::print(&format!("Manual in {}\n", folder.display()))?;
    Ok(Exit::Determined)
}
