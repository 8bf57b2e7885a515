//! The commands and which options each takes.

use super::options::{
    CacheOptions, DisplayOptions, JsonOption, LensOptions, RunOptions, SceneOptions, ViewOptions, parse_aperture,
    parse_jod, parse_size,
};
use super::stereo::StereoOptions;
use clap::{Args, Parser, Subcommand, ValueEnum};
use defocus::aperture::Aperture;
use defocus::view::Input;
use defocus_study::bench::{PaperTable, Shard};
use glam::UVec2;
use std::path::PathBuf;

/// A depth-of-field instrument: published real-time methods beside a reference, what they
/// cost and how far they are from the truth.
#[derive(Debug, Parser)]
#[command(name = "defocus", version, args_conflicts_with_subcommands = true, max_term_width = 110)]
pub struct Cli {
    /// What to do; without a command the window opens
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What to show in the window: a built-in name, gauntlet:SEED, a .glb or .gltf file, or an image with depth
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
    /// Run time against error over methods, scenes, sizes and blurs; the papers' tables
    Bench(Box<BenchArgs>),
    /// Where the time goes on this adapter: methods, their passes, what they draw and hold
    Profile(Box<ProfileArgs>),
    /// Each method's point spread function beside the lens's own: width, energy, symmetry, MTF
    Psf(Box<PsfArgs>),
    /// Which methods are good enough for a display, over pupils and focus distances, and what they cost
    Advise(Box<AdviseArgs>),
    /// Numerical stability: every method under extreme conditions, the first bad pixel named
    Stress(StressArgs),
    /// Random scenes against the reference: where each method is worst, and how bad
    Gauntlet(GauntletArgs),
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
    /// What is blurred: hdr; clamped[:WHITE], cut at white; or reinhard[:KEY], with tones mapped before the blur
    #[arg(long, value_name = "hdr|clamped|reinhard", default_value = "hdr")]
    pub input: Input,
    /// The image to write: .png as a display shows it, .exr linear with depth Z and CoC C
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["json", "inside"])]
    pub output: Option<PathBuf>,
    /// Folder for the textures that the method makes on its way, an image each, with their scales
    #[arg(long, value_name = "DIR", conflicts_with = "layout")]
    pub inside: Option<PathBuf>,
    #[command(flatten)]
    pub stereo: StereoOptions,
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
    /// What methods blur: hdr; clamped[:WHITE], cut at white; or reinhard[:KEY], with tones mapped before the
    /// blur; the reference is treated so after it
    #[arg(long, value_name = "hdr|clamped|reinhard", default_value = "hdr")]
    pub input: Input,
    /// Lens points of the reference
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: u32,
    /// Timed runs of each method
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Runs of each method before the timed ones
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub warmup: u32,
    /// Name the cheapest method whose quality, as seen on the display, is at least this: 10 is no visible
    /// difference, 9 is one that 75 % of observers see
    #[arg(long, value_name = "JOD", allow_hyphen_values = true, value_parser = parse_jod)]
    pub good_enough: Option<f64>,
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

/// `--side`: where a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PsfSide {
    /// In front of the focus distance
    Front,
    /// Behind it
    Behind,
}

/// `defocus bench`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArgs {
    /// What to do instead of measuring
    #[command(subcommand)]
    pub action: Option<BenchAction>,
    /// Reproduce a paper's table or figure, such as tvcg-fig14 or siga-fig8; a wrong name lists all
    #[arg(long, value_name = "NAME", conflicts_with_all = ["methods", "scenes", "sizes", "cocs", "sweeps", "as_published"])]
    pub table: Option<PaperTable>,
    /// Fewer and smaller images, fewer runs; a table stops after 4 minutes
    #[arg(long)]
    pub quick: bool,
    /// The methods, separated by commas, or all [default: all but pinhole]
    #[arg(long, value_name = "A,B|all")]
    pub methods: Option<String>,
    /// Methods exactly as their sources published them; tables have them so
    #[arg(long)]
    pub as_published: bool,
    /// Margin drawn around the image, px [default: half the greatest CoC; tables: 0, as in the papers]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub overscan: Option<u32>,
    /// Set a parameter of a method in all its variants (repeatable)
    #[arg(long = "set", value_name = "[ID.]KEY=VALUE")]
    pub settings: Vec<String>,
    /// Try these values of a parameter instead of those that its method suggests (repeatable)
    #[arg(long = "sweep", value_name = "[ID.]KEY=VALUE,...")]
    pub sweeps: Vec<String>,
    /// Built-in scenes or files, separated by commas, or all [default: all; quick: cans,atrium]
    #[arg(long, value_name = "A,B|all")]
    pub scenes: Option<String>,
    /// Image sizes, px [default: 512x384,1024x768,1920x1080,3840x2160; quick: 256x192]
    #[arg(long, value_name = "WxH,...", value_delimiter = ',', value_parser = parse_size)]
    pub sizes: Vec<UVec2>,
    /// Mean CoC diameters, px [default: 4,8,16,32,64,128; quick: 4,16,64]
    #[arg(long = "coc", value_name = "PX,...", value_delimiter = ',')]
    pub cocs: Vec<f64>,
    /// Lens points of the reference [default: 1024; quick: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: Option<u32>,
    /// Timed runs of each variant [default: 9; quick: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: Option<u32>,
    /// Runs of each variant before the timed ones [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub warmup: Option<u32>,
    /// Draw the scene anew for each run, as while the camera moves
    #[arg(long)]
    pub redraw: bool,
    /// Also count the texture reads of each variant, in a run that is not timed
    #[arg(long)]
    pub count_reads: bool,
    /// Stop after this time; the same command later goes on
    #[arg(long, value_name = "MINUTES")]
    pub budget: Option<f64>,
    /// Measure part I of N; put the parts together with `defocus bench merge`
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Folder for results and report; one that holds a part of them is continued
    #[arg(short, long, value_name = "DIR", default_value = "out/bench")]
    pub output: PathBuf,
    #[command(flatten)]
    pub cache: CacheOptions,
    #[command(flatten)]
    pub run: RunOptions,
}

/// What else `defocus bench` does.
#[derive(Debug, Subcommand)]
pub enum BenchAction {
    /// Put the folders of several shards together
    Merge(MergeArgs),
}

/// `defocus bench merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The folders
    #[arg(required = true, value_name = "DIR")]
    pub parts: Vec<PathBuf>,
    /// Folder for the whole
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// What changes between the frames of `defocus profile`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WhileName {
    /// Nothing
    Still,
    /// The focus distance, by a hundredth
    Lens,
    /// The camera: the scene is drawn anew, as the draft that the window shows until it rests
    Camera,
}

/// `defocus profile`.
#[derive(Debug, Args)]
pub struct ProfileArgs {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub lens: LensOptions,
    #[command(flatten)]
    pub view: ViewOptions,
    /// The methods, separated by commas, or all
    #[arg(long, value_name = "A,B|all", default_value = "all")]
    pub methods: String,
    /// Mean CoC diameters, px, one after another [default: the lens as it is]
    #[arg(long = "coc", value_name = "PX,...", value_delimiter = ',', conflicts_with_all = ["mean_coc", "aperture_diameter_mm"])]
    pub cocs: Vec<f64>,
    /// What changes from frame to frame
    #[arg(long = "while", value_name = "WHAT", value_enum, default_value_t = WhileName::Still)]
    pub during: WhileName,
    /// Frames of each kind: timed one by one, recorded, and back to back
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Fewer frames where those of one kind take longer than this
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    pub seconds: f64,
    /// Also count texture reads, in a frame that is not timed
    #[arg(long)]
    pub count_reads: bool,
    #[command(flatten)]
    pub run: RunOptions,
}

/// `defocus psf`.
#[derive(Debug, Args)]
pub struct PsfArgs {
    /// The methods, separated by commas, or all
    #[arg(long, value_name = "A,B|all", default_value = "all")]
    pub methods: String,
    /// CoC diameters, px
    #[arg(long = "coc", value_name = "PX,...", value_delimiter = ',', default_values_t = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0], allow_negative_numbers = true)]
    pub cocs: Vec<f64>,
    /// Intensity over the aperture: disc, polygon:N[:ROT[:ROUNDNESS]], gaussian[:SIGMA_PER_COC] or image:FILE
    #[arg(long, value_name = "SHAPE", value_parser = parse_aperture)]
    pub aperture: Option<Aperture>,
    /// Side of the focus distance that the point lies on
    #[arg(long, value_name = "SIDE", default_value = "behind")]
    pub side: PsfSide,
    /// Set a parameter of a method (repeatable), as `defocus methods` lists them
    #[arg(long = "set", value_name = "[ID.]KEY=VALUE")]
    pub settings: Vec<String>,
    /// Folder for the page, the table and the picture
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// All functions on one sheet as an EXR, linear: rows are methods, columns CoCs
    #[arg(long, value_name = "FILE")]
    pub export: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// `defocus advise`.
#[derive(Debug, Args)]
pub struct AdviseArgs {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub lens: LensOptions,
    #[command(flatten)]
    pub view: ViewOptions,
    /// The methods, separated by commas, or all: all but accumulation, the reference
    #[arg(long, value_name = "A,B|all", default_value = "all")]
    pub methods: String,
    /// Pupils, mm [default: 2,4,6,8]
    #[arg(long, value_name = "MM,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub pupils: Vec<f64>,
    /// Focus distances, metres [default: near, middle and far of what is in view]
    #[arg(long, value_name = "M,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub focus_distances: Vec<f64>,
    /// Least quality that is good enough, JOD: 9 is a difference that 75 % of observers see
    #[arg(long, value_name = "JOD", default_value_t = 9.0, allow_hyphen_values = true, value_parser = parse_jod)]
    pub good_enough: f64,
    /// Lens points of the reference
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub samples: u32,
    /// Timed runs of each method
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Folder for the page and the numbers
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
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

/// A part of `defocus stress`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StressPart {
    /// Every method under every condition
    Cases,
    /// What f16 intermediates cost against f32
    F16,
    /// Memory over a thousand frames
    Soak,
}

/// `defocus stress`.
#[derive(Debug, Args)]
pub struct StressArgs {
    /// Every pair of conditions instead of every triple, and a small scene for f16 against f32
    #[arg(long)]
    pub quick: bool,
    /// The methods, separated by commas, or all
    #[arg(long, value_name = "A,B|all", default_value = "all")]
    pub methods: String,
    /// Seed of the random cases [default: 1; quick: the number of the day, so that each day has others]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// One part alone [default: all three]
    #[arg(long, value_name = "PART")]
    pub only: Option<StressPart>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// `defocus gauntlet`.
#[derive(Debug, Args)]
pub struct GauntletArgs {
    /// 100 scenes unless --scenes says otherwise
    #[arg(long)]
    pub quick: bool,
    /// Seed of the scenes
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of scenes [default: 1000; quick: 100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub scenes: Option<u64>,
    /// Scenes of this family only [default: all families in turn; --families lists them]
    #[arg(long, value_name = "NAME")]
    pub family: Option<String>,
    /// List the families and end
    #[arg(long)]
    pub families: bool,
    /// The methods, separated by commas, or all [default: all but pinhole and accumulation]
    #[arg(long, value_name = "A,B|all")]
    pub methods: Option<String>,
    /// Set a parameter of a method (repeatable), as `defocus methods` lists them
    #[arg(long = "set", value_name = "[ID.]KEY=VALUE")]
    pub settings: Vec<String>,
    /// Size of the scenes' frames, px
    #[arg(long, value_name = "WxH", default_value = "128x96", value_parser = parse_size)]
    pub size: UVec2,
    /// Make the worst scenes of adaptive (or of the first method) as small as still shows what is wrong
    #[arg(long)]
    pub shrink: bool,
    /// End with an error if a method is worse on a family than it is known to be
    #[arg(long)]
    pub check: bool,
    /// Print what --check is to compare with from now on: the scenes of --seed, and as many as --scenes
    /// says of the next seed
    #[arg(long, conflicts_with_all = ["check", "family", "shrink"])]
    pub print_bounds: bool,
    /// Folder for what --shrink finds, a file each
    #[arg(short, long, value_name = "DIR", default_value = "out/gauntlet")]
    pub output: PathBuf,
    #[command(flatten)]
    pub run: RunOptions,
}

/// The listing commands.
#[derive(Clone, Copy, Debug, Args)]
pub struct ListArgs {
    /// As JSON
    #[arg(long)]
    pub json: bool,
}
