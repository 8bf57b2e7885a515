//! The command line: it does what the window does, without one.

mod advise;
mod args;
mod bench;
mod compare;
mod diff;
mod gauntlet;
mod inside;
mod list;
mod options;
mod output;
mod profile;
mod progress;
mod psf;
mod render;
#[cfg(all(test, feature = "window"))]
mod round_trip;
mod select;
mod setup;
mod stereo;
mod stress;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Runs the program: 0 for success, 1 for an error (one line on standard error), 2 for
/// wrong usage, 130 for an interruption.
pub fn main() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("off")).init();
    let cli = Cli::parse();
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) if progress::interrupted() => ExitCode::from(progress::EXIT_INTERRUPTED),
        Err(error) => fail(&error),
    }
}

fn run(cli: Cli) -> anyhow::Result<()> {
    match &cli.command {
        None => window(cli),
        Some(Command::Render(args)) => render::run(args),
        Some(Command::Compare(args)) => compare::run(args),
        Some(Command::Diff(args)) => diff::run(args),
        Some(Command::Bench(args)) => bench::run(args),
        Some(Command::Profile(args)) => profile::run(args),
        Some(Command::Psf(args)) => psf::run(args),
        Some(Command::Advise(args)) => advise::run(args),
        Some(Command::Stress(args)) => stress::run(args),
        Some(Command::Gauntlet(args)) => gauntlet::run(args),
        Some(Command::Methods(args)) => list::methods(args.json),
        Some(Command::Scenes(args)) => list::scenes(args.json),
        Some(Command::Lenses(args)) => list::lenses(args.json),
        Some(Command::Adapters(args)) => list::adapters(args.json),
    }
}

#[cfg(feature = "window")]
fn window(cli: Cli) -> anyhow::Result<()> {
    let Cli { scene, adapter, screenshot, command: _ } = cli;
    defocus_app::window::run(defocus_app::window::AppOptions { scene, adapter, screenshot, ..Default::default() })
}

#[cfg(not(feature = "window"))]
fn window(cli: Cli) -> anyhow::Result<()> {
    let scene = cli.scene.as_deref().unwrap_or("cans");
    anyhow::bail!(
        "this build has no window; use the command line: defocus render {scene} -o out.png, or defocus --help"
    )
}

/// One line that names cause and remedy.
fn fail(error: &anyhow::Error) -> ExitCode {
    let line = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    eprintln!("defocus: {line}");
    ExitCode::FAILURE
}
