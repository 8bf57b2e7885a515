//! All that is shown and how, in one value: what is saved, restored and undone.
//!
//! What belongs to the person and not to the picture is in [`super::Preferences`];
//! everything else the window has is computed from the two and can be thrown away.

use super::batch::{BatchRow, MOST_BATCH_ROWS};
use super::focus::FocusSettings;
use super::kernel::KernelChoice;
use super::method::MethodChoice;
use super::moment::Moment;
use super::pane::{DEFAULT_OPACITY, PaneState};
use super::pane_id::PaneId;
use super::pane_tree::PaneTree;
use super::show::Show;
use super::size::PictureSize;
use defocus::camera::Camera;
use defocus::combine;
use defocus::display::Display;
use defocus::eye::Pupil;
use defocus::lens::Lens;
use defocus::methods;
use defocus::stereo::Stereo;
use defocus::viewing::{PX_PER_DEGREE, Screen, Viewing};
use defocus_study::DepthArgs;

/// Most panes shown at once.
pub const MAX_PANES: usize = 6;

/// What the user has chosen to see; plain data.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Document {
    /// A built-in name or a file, as [`defocus_study::Source::open`] takes it.
    pub scene: String,
    /// Where the depth of an image comes from and what its numbers mean.
    pub depth: DepthArgs,
    /// Which of the scene's cameras was chosen last.
    pub camera_index: usize,
    /// The camera as it was moved since; `None` until a scene is there, and for images.
    pub camera: Option<Camera>,
    /// Distance from the camera of the point it orbits, metres.
    pub pivot_m: f64,
    /// The moment of an animation that is shown; the scene at rest without it.
    pub moment: Option<Moment>,
    /// How large the picture of one eye is.
    pub size: PictureSize,
    /// The lens.
    pub lens: Lens,
    /// What decides where it is focused.
    pub focus: FocusSettings,
    /// How two eyes see the scene; one sees it without.
    pub stereo: Option<Stereo>,
    /// Whether E, F, dr, ds and DPI follow each newly opened scene, which is so until the
    /// user sets one of them.
    pub automatic_lens: bool,
    /// The panes, 1 to [`MAX_PANES`], in the order of their numbers.
    pub panes: Vec<PaneState>,
    /// How they lie beside each other.
    pub arrangement: Arrangement,
    /// The tiles of [`Arrangement::Tiles`]; an even grid without it.
    pub tiles: Option<PaneTree>,
    /// The pane that the panel is about, that lies left of the divider and stands alone in
    /// [`Arrangement::One`].
    pub a: PaneId,
    /// The pane right of the divider, and the one that blinks.
    pub b: PaneId,
    /// Where the divider stands, from 0 (left) to 1.
    pub divider: f32,
    /// Part of the picture that is shown, the same in all panes.
    pub zoom: Zoom,
    /// Whether figures are wanted also where no pane shows the reference, which then
    /// converges unseen.
    pub measure: bool,
    /// Exposure and tone map.
    pub display: Display,
    /// Whether the exposure follows the light of each newly opened scene that asks for one, which is
    /// so until it is set by hand.
    pub automatic_exposure: bool,
    /// The display's light.
    pub screen: Screen,
    /// Light and age that the lens's E follows, if it does.
    pub pupil: Option<Pupil>,
    /// Age, years, that limits the eye's accommodation, if it does.
    pub age_years: Option<f64>,
    /// Pixels per degree at which differences are judged, where not those of the lens.
    pub ppd: Option<f64>,
    /// Which channels of pictures are shown.
    pub channel: combine::Channel,
    /// |c| up to which a point counts as sharp, px.
    pub acceptable_coc_px: f32,
    /// Whether the CoC's colour map reaches as far as the picture's CoC does.
    pub coc_scale_fits: bool,
    /// |c| at the ends of the CoC's colour map where that is fixed, px.
    pub coc_scale_px: f32,
    /// Margin drawn around the picture so that blur can come in from outside, px.
    pub overscan_px: u32,
    /// States to be run one after the other.
    pub batch: Vec<BatchRow>,
    /// The point whose spread is measured.
    pub kernel: KernelChoice,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            scene: "cans".into(),
            depth: DepthArgs::default(),
            camera_index: 0,
            camera: None,
            pivot_m: 1.0,
            moment: None,
            size: PictureSize::default(),
            lens: Lens::PINHOLE,
            focus: FocusSettings::default(),
            stereo: None,
            automatic_lens: true,
            panes: vec![PaneState::new(PaneId(1), MethodChoice::new("mipmap"))],
            arrangement: Arrangement::Tiles,
            tiles: None,
            a: PaneId(1),
            b: PaneId(1),
            divider: 0.5,
            zoom: Zoom::default(),
            measure: false,
            display: Display::default(),
            automatic_exposure: true,
            screen: Screen::default(),
            pupil: None,
            age_years: None,
            ppd: None,
            channel: combine::Channel::All,
            acceptable_coc_px: 2.0,
            coc_scale_fits: true,
            coc_scale_px: 32.0,
            overscan_px: 32,
            batch: Vec::new(),
            kernel: KernelChoice::default(),
        }
    }
}

impl Document {
    /// The default document with one pane for each of `methods` (at most [`MAX_PANES`]).
    pub fn of_methods(methods: impl IntoIterator<Item = MethodChoice>) -> Self {
        let pane = |(i, method)| PaneState::new(PaneId(i as u32 + 1), method);
        let panes = methods.into_iter().enumerate().map(pane).collect();
        Self { panes, b: PaneId(2), ..Self::default() }.repaired()
    }

    /// The same with what a file could have wrong put right: 1 to [`MAX_PANES`] panes with
    /// different numbers, slots and tiles that name them, the divider inside the picture.
    pub fn repaired(mut self) -> Self {
        let mut seen = Vec::new();
        self.panes.retain(|pane| {
            let new = pane.id != PaneId::HIDDEN && !seen.contains(&pane.id);
            seen.push(pane.id);
            new
        });
        self.panes.truncate(MAX_PANES);
        if self.panes.is_empty() {
            self.panes = Self::default().panes;
        }
        self.divider = if self.divider.is_nan() { 0.5 } else { self.divider.clamp(0.0, 1.0) };
        self.zoom = self.zoom.repaired();
        self.moment = self.moment.map(Moment::repaired);
        self.size = self.size.repaired();
        self.kernel = self.kernel.repaired();
        self.focus = self.focus.repaired();
        self.stereo = self.stereo.map(Stereo::repaired);
        self.screen = self.screen.repaired();
        self.pupil = self.pupil.map(Pupil::repaired);
        self.age_years = self.age_years.filter(|age| (0.0..=120.0).contains(age));
        self.ppd = self.ppd.filter(|ppd| PX_PER_DEGREE.contains(ppd));
        self.lens.eye = self.lens.eye.repaired();
        self.acceptable_coc_px = positive_or(self.acceptable_coc_px, Self::default().acceptable_coc_px);
        self.coc_scale_px = positive_or(self.coc_scale_px, Self::default().coc_scale_px);
        self.batch.truncate(MOST_BATCH_ROWS);
        self.batch = self.batch.into_iter().map(BatchRow::repaired).collect();
        for pane in &mut self.panes {
            pane.opacity = if pane.opacity.is_nan() { DEFAULT_OPACITY } else { pane.opacity.clamp(0.0, 1.0) };
        }
        self.mend_references();
        self
    }

    /// Points slots and differences that name no pane at one that is there.
    fn mend_references(&mut self) {
        let ids: Vec<PaneId> = self.panes.iter().map(|p| p.id).collect();
        let known = |id: PaneId| ids.contains(&id);
        if !known(self.a) {
            self.a = ids[0];
        }
        if !known(self.b) || self.b == self.a {
            self.b = ids.iter().copied().find(|id| *id != self.a).unwrap_or(self.a);
        }
        for pane in &mut self.panes {
            if let Show::Difference(difference) = &mut pane.show
                && (!ids.contains(&difference.against) || difference.against == pane.id)
            {
                match ids.iter().copied().find(|id| *id != pane.id) {
                    Some(other) => difference.against = other,
                    None => pane.show = Show::Picture,
                }
            }
        }
    }

    /// The pane of that number.
    pub fn pane(&self, id: PaneId) -> Option<&PaneState> {
        self.panes.iter().find(|p| p.id == id)
    }

    /// The pane of that number, to be changed.
    pub fn pane_mut(&mut self, id: PaneId) -> Option<&mut PaneState> {
        self.panes.iter_mut().find(|p| p.id == id)
    }

    /// Place of a pane in the list, from 0.
    pub fn index_of(&self, id: PaneId) -> Option<usize> {
        self.panes.iter().position(|p| p.id == id)
    }

    /// The panes that are on the screen.
    pub fn visible(&self) -> Vec<PaneId> {
        match self.arrangement {
            _ if self.panes.len() == 1 => vec![self.a],
            Arrangement::One => vec![self.a],
            Arrangement::Wipe => vec![self.a, self.b],
            Arrangement::Tiles => self.panes.iter().map(|p| p.id).collect(),
        }
    }

    /// Whether two panes lie over each other with a divider between them.
    pub fn is_wiping(&self) -> bool {
        self.arrangement == Arrangement::Wipe && self.a != self.b
    }

    /// The pane that shows the truth, if one does: the first with the method `accumulation`.
    pub fn reference(&self) -> Option<PaneId> {
        self.panes.iter().find(|p| p.method.id == "accumulation").map(|p| p.id)
    }

    /// What figures are taken against: the reference of a pane, or the one that converges
    /// unseen where figures are wanted.
    pub fn truth(&self) -> Option<MethodChoice> {
        let shown = self.reference().and_then(|id| self.pane(id)).map(|pane| pane.method.clone());
        shown.or_else(|| self.measure.then(MethodChoice::reference))
    }

    /// A method for a pane to be added: the reference first, then what is
    /// not there yet.
    pub fn method_to_add(&self, is_scene: bool) -> MethodChoice {
        if is_scene && self.reference().is_none() {
            return MethodChoice::reference();
        }
        let shown = |id: &str| self.panes.iter().any(|p| p.method.id == id);
        let other = methods::all().iter().map(|m| m.about()).find(|a| !shown(a.id) && (is_scene || !a.needs_scene));
        MethodChoice::new(other.map_or("pinhole", |about| about.id))
    }

    /// Adds a pane, which becomes slot B; `None` where there is no room for one more.
    pub fn add_pane(&mut self, method: MethodChoice) -> Option<PaneId> {
        if self.panes.len() >= MAX_PANES {
            return None;
        }
        let free = (1..).map(PaneId).find(|id| self.pane(*id).is_none())?;
        self.panes.push(PaneState::new(free, method));
        self.b = free;
        self.tiles = None;
        Some(free)
    }

    /// Takes a pane away, unless it is the last.
    pub fn close_pane(&mut self, id: PaneId) {
        if self.panes.len() > 1 {
            self.panes.retain(|p| p.id != id);
            self.mend_references();
        }
    }

    /// Under what angle and in what light pictures are judged.
    pub fn viewing(&self) -> Viewing {
        Viewing::of(&self.lens, self.screen).with_ppd(self.ppd)
    }

    /// What files about it are called: the scene's name, or its file's.
    pub fn name(&self) -> String {
        let stem = std::path::Path::new(&self.scene).file_stem();
        stem.map_or_else(|| "defocus".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Whether nothing of it was chosen for its scene yet: neither camera nor lens.
    pub fn is_fresh(&self) -> bool {
        self.camera.is_none() && self.lens == Lens::PINHOLE
    }

    /// The same but for what only directs the eye, which undo leaves alone: also the focus
    /// where it moves by itself, and the moment that is shown.
    pub fn without_gaze(&self) -> Self {
        let mut document = Self { zoom: Zoom::default(), divider: 0.5, moment: None, ..self.clone() };
        if self.focus.mode.follows() {
            document.lens.focus_distance_m = f64::INFINITY;
        }
        document
    }
}

fn positive_or(value: f32, other: f32) -> f32 {
    if value > 0.0 && value.is_finite() { value } else { other }
}

/// How the panes lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Arrangement {
    /// Slot A alone.
    One,
    /// Slots A and B over each other, a divider between them.
    Wipe,
    /// All side by side.
    #[default]
    Tiles,
}

impl Arrangement {
    /// All, with their names and what they do.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::One, "One", "One pane fills the window; the number keys choose it."),
        (Self::Wipe, "Wipe", "Panes A and B over each other; the divider can be dragged."),
        (Self::Tiles, "Tiles", "All panes side by side; drag a pane's number to rearrange them."),
    ];
}

/// Which part of the picture is shown, and how large.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Zoom {
    /// Pixels of the display over those of the picture; `None` fits the picture in.
    pub scale: Option<f32>,
    /// What lies in the middle, from (0, 0) at the top left of the picture to (1, 1).
    pub centre: [f32; 2],
}

impl Default for Zoom {
    fn default() -> Self {
        Self { scale: None, centre: [0.5, 0.5] }
    }
}

impl Zoom {
    /// Least and greatest magnification.
    pub const RANGE: std::ops::RangeInclusive<f32> = 0.125..=64.0;

    pub(super) fn repaired(self) -> Self {
        let scale = self.scale.filter(|s| s.is_finite()).map(|s| s.clamp(*Self::RANGE.start(), *Self::RANGE.end()));
        let centre = self.centre.map(|c| if c.is_nan() { 0.5 } else { c.clamp(0.0, 1.0) });
        Self { scale, centre }
    }
}
