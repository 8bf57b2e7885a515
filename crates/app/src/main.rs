//! `defocus`, the program: the command line and, with the feature "window", the window.

mod cli;
#[cfg(target_os = "linux")]
mod runtime_folder;

fn main() -> std::process::ExitCode {
    #[cfg(target_os = "linux")]
    runtime_folder::ensure();
    cli::main()
}
