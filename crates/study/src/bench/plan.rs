//! What a benchmark measures: every variant of every method in every cell.

use defocus::methods::{self, Method, ParamError, UnknownMethod, set_param};
use defocus::view::Input;
use serde::{Deserialize, Serialize};

/// Mean CoC diameters, px, over which the papers compare.
pub const MEAN_COCS_PX: [f64; 6] = [4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// What is measured, all of it: two benchmarks of one plan can be merged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Built-in names or files, as [`Source::open`](crate::Source::open) takes them.
    pub scenes: Vec<String>,
    /// Image sizes, px.
    pub sizes: Vec<[u32; 2]>,
    /// How much is blurred.
    pub blurs: Vec<Blur>,
    /// Methods with their parameters.
    pub variants: Vec<Variant>,
    /// Lens points of the reference; `None` for times only.
    pub reference_samples: Option<u32>,
    /// The only blur for which there is a reference, if not for all: it takes far longer
    /// than what is measured.
    pub reference_only_at: Option<Blur>,
    /// Runs of each variant before the timed ones.
    pub warmup: u32,
    /// Timed runs of each variant.
    pub runs: u32,
    /// Whether the view is drawn anew for each run, as while the camera moves.
    pub redraw: bool,
    /// Whether texture reads are counted, in a run that is not timed.
    pub count_reads: bool,
    /// Whether error maps of the first variant of each method are kept.
    pub error_maps: bool,
    /// Margin drawn around the image, px; `None`: half the greatest CoC in view.
    #[serde(default)]
    pub overscan_px: Option<u32>,
    /// Whether the reference shades from each point of the lens.
    #[serde(default)]
    pub view_dependent: bool,
    /// What methods are given of the light; the reference is treated so after its blur.
    #[serde(default)]
    pub input: Input,
}

/// How far the aperture is opened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Blur {
    /// Until the mean CoC diameter over the image is this, px.
    MeanCocPx(f64),
    /// Until the greatest is this, px.
    GreatestCocPx(f64),
}

impl Blur {
    /// The CoC diameter, px.
    pub fn px(self) -> f64 {
        match self {
            Self::MeanCocPx(px) | Self::GreatestCocPx(px) => px,
        }
    }
}

impl std::fmt::Display for Blur {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::MeanCocPx(px) => write!(f, "mean CoC {px} px"),
            Self::GreatestCocPx(px) => write!(f, "greatest CoC {px} px"),
        }
    }
}

/// A method with some of its parameters set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// The method's id.
    pub method: String,
    /// Parameters that are set, by key, as [`set_param`] takes them.
    pub settings: Vec<(String, String)>,
    /// The only blur for which it is wanted, if not all.
    pub only_at: Option<Blur>,
    /// Whether it is as published where nothing else is set ([`methods::set_as_published`]).
    #[serde(default)]
    pub as_published: bool,
}

/// Why a plan cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A method that does not exist.
    #[error(transparent)]
    Method(#[from] UnknownMethod),
    /// A parameter that cannot be set.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// Values for a parameter that no chosen method has.
    #[error("no chosen method has a parameter '{key}'; `defocus methods` lists the parameters of each")]
    NoSuchParam {
        /// What was given.
        key: String,
    },
}

impl Variant {
    /// A method with its default parameters.
    pub fn of(method: &str) -> Self {
        Self { method: method.into(), settings: Vec::new(), only_at: None, as_published: false }
    }

    /// A method as its source published it.
    pub fn published(method: &str) -> Self {
        Self { as_published: true, ..Self::of(method) }
    }

    /// With a parameter set.
    pub fn with(mut self, key: &str, value: impl ToString) -> Self {
        self.settings.push((key.into(), value.to_string()));
        self
    }

    /// Wanted for one blur only.
    pub fn only_at(self, blur: Blur) -> Self {
        Self { only_at: Some(blur), ..self }
    }

    /// The method, ready to render.
    ///
    /// # Errors
    ///
    /// An unknown method or parameter, a value out of range.
    pub fn method(&self) -> Result<Box<dyn Method>, PlanError> {
        let mut method = methods::by_id(&self.method)?;
        if self.as_published {
            methods::set_as_published(method.as_mut());
        }
        for (key, value) in &self.settings {
            set_param(method.as_mut(), key, value)?;
        }
        Ok(method)
    }

    /// Method and settings in words.
    pub fn label(&self) -> String {
        let settings = self.settings.iter().map(|(key, value)| format!(" {key}={value}"));
        self.method.clone() + &settings.collect::<String>()
    }
}

/// A value list for one parameter: of one method, or of all that have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trade {
    /// The method's id.
    pub method: Option<String>,
    /// The parameter's key.
    pub key: String,
    /// Values as text.
    pub values: Vec<String>,
}

/// The variants of `chosen` methods: their defaults, and every value of the parameters with
/// which they trade quality for time, or of those in `trades` instead.
///
/// # Errors
///
/// A trade of a parameter that no chosen method has, a value out of range.
pub fn variants(chosen: &[Box<dyn Method>], trades: &[Trade]) -> Result<Vec<Variant>, PlanError> {
    let mut all = Vec::new();
    let mut used = vec![false; trades.len()];
    for method in chosen {
        let id = method.about().id;
        let mut method = method.boxed();
        let base = Variant { settings: changed(method.as_mut()), ..Variant::of(id) };
        let mut own = vec![base.clone()];
        for param in method.params() {
            let mut values: Vec<String> = param.trade.iter().map(|v| (*v).to_owned()).collect();
            for (trade, used) in trades.iter().zip(&mut used) {
                if trade.key == param.key && trade.method.as_deref().is_none_or(|m| m == id) {
                    values.clone_from(&trade.values);
                    *used = true;
                }
            }
            values.retain(|value| *value != param.text());
            own.extend(values.iter().map(|value| with(&base, param.key, value)));
        }
        for variant in &own {
            variant.method()?;
        }
        all.extend(own);
    }
    match trades.iter().zip(used).find(|(_, used)| !used) {
        Some((trade, _)) => Err(PlanError::NoSuchParam { key: trade.key.clone() }),
        None => Ok(all),
    }
}

fn with(base: &Variant, key: &str, value: &str) -> Variant {
    let mut variant = base.clone();
    variant.settings.retain(|(k, _)| k != key);
    variant.with(key, value)
}

/// Parameters that differ from the method's defaults.
fn changed(method: &mut dyn Method) -> Vec<(String, String)> {
    let Ok(mut default) = methods::by_id(method.about().id) else { return Vec::new() };
    let defaults = default.params();
    let differs = |(ours, default): &(methods::Param<'_>, methods::Param<'_>)| ours.text() != default.text();
    let both = method.params().into_iter().zip(defaults).filter(differs);
    both.map(|(ours, _)| (ours.key.to_owned(), ours.text())).collect()
}

/// One scene at one size with one blur: all variants are timed together there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Its place in [`Plan::cells`].
    pub index: usize,
    /// The scene, as the plan has it.
    pub scene: String,
    /// Image size, px.
    pub size: [u32; 2],
    /// How much is blurred.
    pub blur: Blur,
}

impl Plan {
    /// All cells, so ordered that a sweep that ends early has seen every scene: small
    /// images first.
    pub fn cells(&self) -> Vec<Cell> {
        let mut sizes = self.sizes.clone();
        sizes.sort_by_key(|[width, height]| u64::from(*width) * u64::from(*height));
        let mut cells = Vec::new();
        for size in sizes {
            for blur in &self.blurs {
                for scene in &self.scenes {
                    cells.push(Cell { index: cells.len(), scene: scene.clone(), size, blur: *blur });
                }
            }
        }
        cells
    }

    /// Lens points of the reference for a blur; `None` where there is none.
    pub fn reference_samples_at(&self, blur: Blur) -> Option<u32> {
        self.reference_samples.filter(|_| self.reference_only_at.is_none_or(|only| only == blur))
    }

    /// The variants that are wanted in a cell.
    pub fn variants_at(&self, blur: Blur) -> impl Iterator<Item = &Variant> {
        self.variants.iter().filter(move |v| v.only_at.is_none_or(|only| only == blur))
    }
}

impl Cell {
    /// Scene, size and blur in words.
    pub fn label(&self) -> String {
        let [width, height] = self.size;
        let scene = std::path::Path::new(&self.scene).file_stem().map(|s| s.to_string_lossy().into_owned());
        format!("{} {width}x{height}, {}", scene.unwrap_or_default(), self.blur)
    }
}

/// One of several parts of a plan, to be measured on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    /// Reads a part such as 2/8.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let (number, of) = parts.ok_or("give a part of several, such as 2/8")?;
        if (1..=of).contains(&number) {
            Ok(Self { number, of })
        } else {
            Err(format!("parts are counted from 1 to {of}"))
        }
    }
}

impl Shard {
    /// The whole plan.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Whether a cell belongs to it. Neighbouring cells go to different shards, so that all
    /// have about the same work.
    pub fn has(self, cell: &Cell) -> bool {
        cell.index % self.of == self.number - 1
    }
}
