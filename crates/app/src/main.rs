//! `defocus`, the program: the command line and, with the feature "app", the window.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
