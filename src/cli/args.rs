//! The commands and which options each takes.

use super::options::{CacheOptions, DisplayOptions, JsonOption, LensOptions, RunOptions, SceneOptions, ViewOptions};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// A depth-of-field instrument: published real-time methods beside a reference, what they
/// cost and how far they are from the truth.
#[derive(Debug, Parser)]
#[command(name = "defocus", version, args_conflicts_with_subcommands = true, max_term_width = 110)]
pub struct Cli {
    /// What to do; without a command the window opens
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What to show in the window: a built-in name, a .glb or .gltf file, or an image with depth
    pub scene: Option<String>,
    /// Graphics adapter for the window, by a part of its name
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Saves the whole window as a PNG once the picture is there, and ends
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one image with one method
    Render(Box<RenderArgs>),
    /// Compare methods with a reference: a table, and images with a report
    Compare(Box<CompareArgs>),
    /// Metrics of two images of the same size
    Diff(DiffArgs),
    /// List the methods with their parameters
    Methods(ListArgs),
    /// List the built-in scenes
    Scenes(ListArgs),
    /// List the lens presets
    Lenses(ListArgs),
    /// List the graphics adapters of this machine
    Adapters(ListArgs),
}

/// `defocus render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub lens: LensOptions,
    #[command(flatten)]
    pub view: ViewOptions,
    /// The method, as `defocus methods` lists them; also `raytrace`, the reference on the CPU
    #[arg(long, value_name = "ID", default_value = "mipmap")]
    pub method: String,
    /// Lens points of accumulation and raytrace [default: the method's own; 1024 for raytrace]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: Option<u32>,
    /// The image to write: .png as a display shows it, .exr linear with depth Z and CoC C
    #[arg(short, long, value_name = "FILE", required_unless_present = "json")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub display: DisplayOptions,
    #[command(flatten)]
    pub run: RunOptions,
}

/// `defocus compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub lens: LensOptions,
    #[command(flatten)]
    pub view: ViewOptions,
    /// The methods, separated by commas, or all
    #[arg(long, value_name = "A,B|all", default_value = "all")]
    pub methods: String,
    /// The truth to compare with: accumulation, raytrace or any other method [default:
    /// accumulation; none for an image with depth]
    #[arg(long, value_name = "ID")]
    pub reference: Option<String>,
    /// Lens points of the reference
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: u32,
    /// Timed runs of each method
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Runs of each method before the timed ones
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub warmup: u32,
    /// Folder for the images, the report and the numbers
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub cache: CacheOptions,
    #[command(flatten)]
    pub display: DisplayOptions,
    #[command(flatten)]
    pub run: RunOptions,
}

/// `defocus diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The image to judge
    pub image: PathBuf,
    /// The image to judge it by
    pub reference: PathBuf,
    #[command(flatten)]
    pub display: DisplayOptions,
    #[command(flatten)]
    pub json: JsonOption,
}

/// The listing commands.
#[derive(Clone, Copy, Debug, Args)]
pub struct ListArgs {
    /// As JSON
    #[arg(long)]
    pub json: bool,
}
