//! One pane's pictures: the method's own, and what is seen of it.

use super::errand::Errand;
use super::figures::MapKind;
use super::figures::PaneResults;
use super::identity::{Identity, Pairing};
use super::milestone::Milestone;
use super::pace::{Pace, Workload};
use super::progress::{Progressive, passed_power_of_two, progressive};
use super::reading::{Reading, channel_of};
use super::request::{DisplaySettings, RenderRequest, Request};
use super::warm::{FrameTime, WarmTimes};
use crate::window::model::{DifferenceKind, Inside, MethodChoice, PaneId, PaneState, Show};
use defocus::combine;
use defocus::display::Display;
use defocus::gpu::{Frame, Texture};
use defocus::methods::{self, Meaning};
use defocus::present::{self, DifferenceOf, Map, Numbers, Overlay, Place, Slice};
use defocus::view::View;
use glam::UVec2;
use std::time::Instant;

/// Lens points from which on a converging reference is worth comparing with.
pub(super) const LEAST_SAMPLES: u32 = 8;

/// What the engine has of a pane.
pub struct Pane {
    pub(super) state: PaneState,
    /// What the picture was made for; `None` while it has to be made.
    pub(super) made_for: Option<RenderRequest>,
    pub(super) linear: Option<Texture>,
    /// What that is.
    pub(super) identity: Option<Identity>,
    /// Changes with every new picture and is never the same for two.
    pub(super) revision: u64,
    pub(super) run: Option<Progressive>,
    /// The last picture that is worth measuring.
    pub(super) milestone: Option<Milestone>,
    /// The one before, of a picture that converges.
    pub(super) earlier: Option<Milestone>,
    exposed: Vec<(String, Texture)>,
    kept: Kept,
    wanted_kept: Kept,
    explains: &'static [&'static str],
    shown: Option<Texture>,
    shown_for: Option<ShownFor>,
    /// Whether `shown` was made from all that `shown_for` says, and not kept from before.
    is_shown_complete: bool,
    reading: Option<Reading>,
    place: Option<Place>,
    pub(super) error: Option<String>,
    pub(super) ms: Option<f64>,
    times: WarmTimes,
    /// How many times smaller than in full the picture is drawn.
    pub(super) divisor: u32,
    pub(super) pace: Pace,
    /// The picture that is being drawn beside the interface.
    pub(super) errand: Option<Errand>,
    /// Lens points of a picture that came from beside, and how many there were to be.
    pub(super) finished: Option<(u32, u32)>,
    /// Size and margin of the picture whose textures are exposed, px.
    exposed_from: (UVec2, u32),
    pub(super) made_at: Instant,
    pub(super) results: PaneResults,
}

/// What is kept of what a method exposes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kept {
    Nothing,
    /// [`Method::explains`].
    Explained,
    Everything,
}

/// What of a method's textures someone wants to be told of, beside what its pane shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Told {
    /// What it did at each pixel.
    pub explained: bool,
    /// All of them.
    pub everything: bool,
}

fn explains(method: &MethodChoice) -> &'static [&'static str] {
    method.build().map_or(&[], |method| method.explains())
}

/// What a shown texture was made from.
#[derive(Clone, PartialEq)]
struct ShownFor {
    show: Show,
    opacity: f32,
    display_settings: DisplaySettings,
    revision: u64,
    other: Option<u64>,
    map: Option<u64>,
    /// Whether the view was at hand, which overlays need.
    has_view: bool,
}

impl Pane {
    pub(super) fn new(state: &PaneState) -> Self {
        Self {
            state: state.clone(),
            made_for: None,
            linear: None,
            identity: None,
            revision: 0,
            run: None,
            milestone: None,
            earlier: None,
            exposed: Vec::new(),
            kept: Kept::Nothing,
            wanted_kept: Kept::Nothing,
            explains: explains(&state.method),
            shown: None,
            shown_for: None,
            is_shown_complete: false,
            reading: None,
            place: None,
            error: None,
            ms: None,
            times: WarmTimes::default(),
            divisor: 1,
            pace: Pace::default(),
            errand: None,
            finished: None,
            exposed_from: (UVec2::ZERO, 0),
            made_at: Instant::now(),
            results: PaneResults::default(),
        }
    }

    /// Takes over a changed state; the picture stays until there is another.
    pub(super) fn follow(&mut self, state: &PaneState, told: Told, size: UVec2) {
        if self.pace.follow(&Workload { method: state.method.clone(), size }) {
            self.times = WarmTimes::default();
        }
        if self.state.method != state.method {
            self.made_for = None;
            self.ms = None;
            self.explains = explains(&state.method);
        }
        self.wanted_kept = match state.show {
            Show::Inside(_) => Kept::Everything,
            _ if told.everything => Kept::Everything,
            _ if told.explained && !self.explains.is_empty() => Kept::Explained,
            _ => Kept::Nothing,
        };
        if self.wanted_kept > self.kept {
            self.made_for = None;
        } else if self.wanted_kept < self.kept {
            let exposed = std::mem::take(&mut self.exposed);
            self.keep(exposed);
        }
        self.state = state.clone();
    }

    /// Whether the method is to expose what is inside it.
    pub(super) fn wants_intermediates(&self) -> bool {
        self.wanted_kept > Kept::Nothing
    }

    /// Whether every texture of the method is to be looked at, which only what is drawn here
    /// has.
    pub(super) fn wants_everything(&self) -> bool {
        self.wanted_kept == Kept::Everything
    }

    /// Takes in how long a picture took: `ms` of the GPU, `waited_ms` in all.
    pub(super) fn learn(&mut self, divisor: u32, ms: f64, waited_ms: f64, blur_px: f64) {
        self.ms = Some(ms);
        self.times.take(divisor, ms);
        self.pace.learn(divisor, waited_ms, blur_px);
    }

    /// How many times smaller than in full the shown picture is drawn: 1 is in full.
    pub fn divisor(&self) -> u32 {
        self.divisor
    }

    /// Whether the full picture is being drawn beside the interface.
    pub fn is_drawn_beside(&self) -> bool {
        self.errand.is_some()
    }

    /// Keeps what is wanted of what the method exposed of a picture of that size and margin.
    pub(super) fn keep_of(&mut self, exposed: Vec<(String, Texture)>, size: UVec2, margin_px: u32) {
        self.exposed_from = (size, margin_px);
        self.keep(exposed);
    }

    fn keep(&mut self, mut exposed: Vec<(String, Texture)>) {
        match self.wanted_kept {
            Kept::Nothing => exposed.clear(),
            Kept::Explained => exposed.retain(|(name, _)| self.explains.contains(&name.as_str())),
            Kept::Everything => {}
        }
        (self.exposed, self.kept) = (exposed, self.wanted_kept);
    }

    /// Names of the textures that tell what the method did at each pixel.
    pub(super) fn explains(&self) -> &'static [&'static str] {
        self.explains
    }

    /// Display values, once there are some.
    pub fn shown(&self) -> Option<&Texture> {
        self.shown.as_ref()
    }

    /// Why there is no picture.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// GPU time of the method's last frame, ms; of a reference, of one lens point.
    pub fn ms(&self) -> Option<f64> {
        self.ms
    }

    /// Median GPU time of the method's last frames of this kind and size, or the time of its
    /// first; of a reference, of one lens point.
    pub fn time(&self) -> Option<FrameTime> {
        self.times.told()
    }

    /// Lens points that a reference has and will have.
    pub fn progress(&self) -> Option<(u32, u32)> {
        let beside = self.errand.as_ref().and_then(|errand| errand.progress).or(self.finished);
        self.run.as_ref().map(|p| (p.run.count(), p.samples)).or(beside)
    }

    /// What the picture is, once there is one.
    pub fn identity(&self) -> Option<&Identity> {
        self.identity.as_ref()
    }

    /// The picture, linear, once there is one.
    pub fn linear(&self) -> Option<&Texture> {
        self.linear.as_ref()
    }

    /// Whether what is shown is of the picture, and not kept from an earlier one until a
    /// difference is there.
    pub fn is_shown_complete(&self) -> bool {
        self.is_shown_complete && self.shown_for.as_ref().is_some_and(|f| f.revision == self.revision)
    }

    /// Names and textures of what the method exposes; empty unless asked for.
    pub fn exposed(&self) -> impl Iterator<Item = (&str, &Texture)> {
        self.exposed.iter().map(|(name, texture)| (name.as_str(), texture))
    }

    /// The exposed texture that `inside` names, or the first.
    pub fn exposed_as(&self, inside: &Inside) -> Option<(&str, &Texture)> {
        let named = self.exposed.iter().find(|(name, _)| *name == inside.name);
        named.or(self.exposed.first()).map(|(name, texture)| (name.as_str(), texture))
    }

    /// What the shown numbers of a texture inside are; `None` for a picture.
    pub fn reading(&self) -> Option<&Reading> {
        self.reading.as_ref()
    }

    /// Where what is shown lies, if it is a texture as large as itself and not the picture.
    pub fn place(&self) -> Option<Place> {
        self.place
    }

    /// Size, px, of the picture whose textures are exposed.
    pub fn exposed_size(&self) -> UVec2 {
        self.exposed_from.0
    }

    /// Where a texture that the method exposes under `name` lies on the picture that it is
    /// of.
    pub(super) fn place_of(&self, name: &str, texture: &Texture) -> Place {
        let (inner, margin_px) = self.exposed_from;
        let texel_px = self.state.method.build().ok().and_then(|method| method.texel_px(name));
        Place::of(texture.size(), inner, margin_px, texel_px)
    }

    /// What a texture that the method exposes under `name` means.
    pub fn meaning(&self, name: &str) -> Meaning {
        self.state.method.build().map_or(Meaning::Picture, |method| methods::meaning(method.as_ref(), name))
    }

    pub(super) fn is_converging(&self) -> bool {
        self.error.is_none() && self.run.as_ref().is_some_and(|p| p.run.count() < p.samples)
    }

    /// Makes the picture anew, `divisor` times smaller than in full.
    pub(super) fn restart(&mut self, render: &RenderRequest, divisor: u32) {
        self.made_for = Some(render.clone());
        self.made_at = Instant::now();
        self.divisor = divisor;
        (self.run, self.error, self.finished) = (None, None, None);
        (self.milestone, self.earlier) = (None, None);
    }

    /// There is no picture for `render`, for a reason.
    pub(super) fn fail(&mut self, error: String, render: &RenderRequest) {
        self.made_for = Some(render.clone());
        self.error = Some(error);
        (self.linear, self.identity, self.run) = (None, None, None);
    }

    /// Records the picture, or `views` more lens points of it.
    pub(super) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        view: &mut View,
        render: &RenderRequest,
        views: u32,
        (revision, world): (u64, u64),
    ) -> Result<(), String> {
        let lens = &render.lens;
        self.revision = revision;
        let identity = |samples| Identity { world, method: self.state.method.clone(), render: render.clone(), samples };
        if self.run.is_none() {
            let method = self.state.method.build()?;
            match progressive(method.as_ref(), frame, view, lens) {
                Some(progressive) => self.run = Some(progressive),
                None => {
                    let linear = methods::record(method.as_ref(), frame, view, lens).map_err(|e| e.to_string())?;
                    self.take(linear, identity(None), true);
                    return Ok(());
                }
            }
        }
        if frame.keeps_intermediates() {
            methods::expose_pinhole(frame, view);
        }
        let Some(Progressive { run, samples }) = &mut self.run else { return Ok(()) };
        frame.set_prefix(format!("{}/", self.state.method.id));
        run.advance(frame, view, lens, views.min(*samples - run.count())).map_err(|e| e.to_string())?;
        let (count, mean) = (run.count(), run.mean(frame));
        let is_worth =
            count == *samples || (count >= LEAST_SAMPLES && passed_power_of_two(self.measured_samples(), count));
        self.take(mean, identity(Some(count)), is_worth);
        Ok(())
    }

    /// Lens points of the last picture that was worth measuring.
    fn measured_samples(&self) -> Option<u32> {
        self.milestone.as_ref()?.identity.samples
    }

    /// Takes over a picture; `is_worth`: it is worth measuring.
    pub(super) fn take(&mut self, linear: Texture, identity: Identity, is_worth: bool) {
        // What is drawn smaller is to be looked at, not to be measured.
        if is_worth && self.divisor == 1 {
            let (texture, revision) = (linear.clone(), self.revision);
            let milestone = Milestone { texture, color: None, identity: identity.clone(), revision };
            self.earlier = self.milestone.replace(milestone).filter(|before| before.identity.is_of(&identity));
        }
        (self.linear, self.identity) = (Some(linear), Some(identity));
    }

    fn wanted(&self, request: &Request, other: Option<&Milestone>, has_view: bool) -> ShownFor {
        ShownFor {
            show: self.state.show.clone(),
            opacity: self.state.opacity,
            display_settings: request.display_settings,
            revision: self.revision,
            other: other.map(|o| o.revision),
            map: self.map(request, other).map(|(_, revision)| revision),
            has_view,
        }
    }

    /// The map of differences of what is shown, with its number.
    fn map(&self, request: &Request, other: Option<&Milestone>) -> Option<(&Texture, u64)> {
        let (_, kind) = self.wants_map_against()?;
        let (picture, truth) = (self.milestone.as_ref()?.identity.clone(), other?.identity.clone());
        let DisplaySettings { display, viewing, .. } = request.display_settings;
        self.results.map_of(&Pairing { picture, truth, display, viewing }, kind)
    }

    /// Whether what is seen is out of date.
    pub(super) fn wants_presenting(&self, request: &Request, other: Option<&Milestone>, has_view: bool) -> bool {
        self.linear.is_some() && self.shown_for.as_ref() != Some(&self.wanted(request, other, has_view))
    }

    /// Brings what is seen up to date. `view` is what the picture was taken from, `other` the
    /// picture that a difference is taken from.
    pub(super) fn present(
        &mut self,
        frame: &mut Frame<'_>,
        mut view: Option<&mut View>,
        request: &Request,
        other: Option<&Milestone>,
    ) {
        if !self.wants_presenting(request, other, view.is_some()) {
            return;
        }
        let Some(linear) = self.linear.clone() else { return };
        let wanted = self.wanted(request, other, view.is_some());
        frame.set_prefix("present/");
        // Lengths in pixels shrink with the picture.
        let display_settings = request.display_settings.coarser(self.divisor);
        let DisplaySettings { display, channel, acceptable_coc_px, coc_scale_px, viewing: _ } = display_settings;
        // The lens of the picture, not the one asked for meanwhile: they belong together.
        let lens = self.made_for.as_ref().map_or(&request.render.lens, |e| &e.lens).clone();
        let mut overlay = |overlay| {
            // While the view changes, a pane waits for its new picture.
            let view = view.as_deref_mut().filter(|view| linear.size() == view.size())?;
            Some(present::overlay(frame, view, &linear, &lens, &display, overlay))
        };
        let opacity = self.state.opacity;
        self.place = None;
        let shown = match self.state.show.clone() {
            Show::Picture => {
                let picture = present::picture(frame, &linear, &display);
                Some(combine::isolated(frame, &picture, channel))
            }
            Show::Coc => overlay(Overlay::Coc { full_scale_px: coc_scale_px, opacity }),
            Show::Depth => overlay(Overlay::Depth { opacity }),
            Show::Zone => overlay(Overlay::Zone { acceptable_px: acceptable_coc_px }),
            Show::Difference(difference) => match of_kind(difference.kind) {
                Some(of) => other
                    .filter(|other| other.texture.size() == linear.size() && self.is_beside(other))
                    .map(|other| present::difference(frame, &linear, &other.texture, &display, of, difference.gain())),
                None => self.map(request, other).map(|(map, _)| {
                    let slice = Slice { texture: map, level: 0, layer: 0 };
                    Numbers { slice, channel: 0, map: Map::Error, ends: [0.0, difference.map_end()] }.alone(frame)
                }),
            },
            Show::Inside(inside) => self.present_inside(frame, &inside, &display),
        };
        self.is_shown_complete = shown.is_some();
        if shown.is_some() {
            self.shown = shown;
        }
        self.shown_for = Some(wanted);
    }

    fn present_inside(&mut self, frame: &mut Frame<'_>, inside: &Inside, display: &Display) -> Option<Texture> {
        let (name, texture) = self.exposed_as(inside)?;
        let place = self.place_of(name, texture);
        let (meaning, texture) = (self.meaning(name), texture.clone());
        let level = inside.level.min(texture.levels() - 1);
        let layer = inside.layer.min(texture.layers() - 1);
        let slice = Slice { texture: &texture, level, layer };
        let wanted = inside.channel.index();
        let Some(channel) = channel_of(&meaning, wanted, u32::from(texture.format().components())) else {
            (self.reading, self.place) = (None, Some(place));
            return Some(present::slice_picture(frame, slice, display));
        };
        let quantity = meaning.quantities().get(channel as usize).cloned();
        let quantity = quantity.unwrap_or_default();
        let numbers = Numbers::on(frame, slice, channel, quantity.scale);
        let Numbers { ends, map, .. } = numbers;
        self.reading = Some(Reading { quantity, ends, map, at: (level, layer, channel) });
        let picture =
            self.linear.as_ref().filter(|linear| self.state.opacity < 1.0 && linear.size() == self.exposed_from.0);
        let Some(picture) = picture else {
            self.place = Some(place);
            return Some(numbers.alone(frame));
        };
        Some(numbers.over(frame, picture, display, place, self.state.opacity))
    }

    /// Whether another picture is of the same view through the same lens: only then does a
    /// difference tell something about the methods.
    fn is_beside(&self, other: &Milestone) -> bool {
        let own = self.identity.as_ref().map(|own| (own.world, &own.render));
        own == Some((other.identity.world, &other.identity.render))
    }

    /// The picture that another pane's difference of that kind is taken from.
    pub(super) fn to_compare(&self, kind: DifferenceKind) -> Option<Milestone> {
        if map_kind(kind).is_some() {
            return self.milestone.clone();
        }
        let (texture, identity) = (self.linear.clone()?, self.identity.clone()?);
        Some(Milestone { texture, color: None, identity, revision: self.revision })
    }

    /// The pane that a map of differences is wanted against, and which map.
    pub(super) fn wants_map_against(&self) -> Option<(PaneId, MapKind)> {
        match self.state.show {
            Show::Difference(difference) => Some((difference.against, map_kind(difference.kind)?)),
            _ => None,
        }
    }

    /// The method.
    pub fn method(&self) -> &MethodChoice {
        &self.state.method
    }
}

fn of_kind(kind: DifferenceKind) -> Option<DifferenceOf> {
    match kind {
        DifferenceKind::Absolute => Some(DifferenceOf::Display),
        DifferenceKind::Signed => Some(DifferenceOf::Signed),
        DifferenceKind::Relative => Some(DifferenceOf::Relative),
        DifferenceKind::Flip | DifferenceKind::Jod => None,
    }
}

/// The map that shows a difference which is not computed on the GPU.
fn map_kind(kind: DifferenceKind) -> Option<MapKind> {
    match kind {
        DifferenceKind::Flip => Some(MapKind::Flip),
        DifferenceKind::Jod => Some(MapKind::Jod),
        DifferenceKind::Absolute | DifferenceKind::Signed | DifferenceKind::Relative => None,
    }
}
