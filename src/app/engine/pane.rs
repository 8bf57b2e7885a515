//! One pane's pictures: the method's own, and what is seen of it.

use super::figures::{Judged, Pair};
use super::inside::{Reading, channel_of};
use super::request::{Development, Exposure, Request};
use crate::app::document::{DifferenceKind, Inside, MethodChoice, PaneId, PaneState, Show};
use crate::combine;
use crate::display::Display;
use crate::gpu::{Frame, Texture};
use crate::lens::Lens;
use crate::methods::{self, Converging, IN_FOCUS_COC_PX, Meaning, Method};
use crate::present::{self, DifferenceOf, Map, Numbers, Overlay, Place, Slice};
use crate::view::View;
use glam::UVec2;
use std::time::Instant;

/// Lens points from which on a converging reference is worth comparing with.
const LEAST_SAMPLES: u32 = 8;

/// What the engine has of a pane.
pub struct Pane {
    pub(super) state: PaneState,
    /// What the picture was made for; `None` while it has to be made.
    pub(super) made_for: Option<Exposure>,
    pub(super) linear: Option<Texture>,
    /// Changes with every new picture and is never the same for two.
    pub(super) revision: u64,
    pub(super) run: Option<Progressive>,
    /// The last picture that is worth measuring.
    pub(super) milestone: Option<Milestone>,
    exposed: Vec<(String, Texture)>,
    kept: Kept,
    wanted_kept: Kept,
    explains: &'static [&'static str],
    shown: Option<Texture>,
    shown_for: Option<ShownFor>,
    reading: Option<Reading>,
    place: Option<Place>,
    pub(super) error: Option<String>,
    pub(super) ms: Option<f64>,
    pub(super) made_at: Instant,
    pub(super) judged: Judged,
}

/// What is kept of what a method exposes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kept {
    Nothing,
    /// [`Method::explains`].
    Explained,
    Everything,
}

fn explains(method: &MethodChoice) -> &'static [&'static str] {
    method.build().map_or(&[], |method| method.explains())
}

/// A run with its goal.
pub(super) struct Progressive {
    pub run: Box<dyn Converging>,
    pub samples: u32,
}

/// A picture that is worth measuring.
#[derive(Clone)]
pub(super) struct Milestone {
    pub texture: Texture,
    pub revision: u64,
    /// Lens points, of a reference.
    pub samples: Option<u32>,
}

/// What a shown texture was made from.
#[derive(Clone, PartialEq)]
struct ShownFor {
    show: Show,
    opacity: f32,
    development: Development,
    revision: u64,
    other: Option<u64>,
    map: Option<Pair>,
}

impl Pane {
    pub(super) fn new(state: &PaneState) -> Self {
        Self {
            state: state.clone(),
            made_for: None,
            linear: None,
            revision: 0,
            run: None,
            milestone: None,
            exposed: Vec::new(),
            kept: Kept::Nothing,
            wanted_kept: Kept::Nothing,
            explains: explains(&state.method),
            shown: None,
            shown_for: None,
            reading: None,
            place: None,
            error: None,
            ms: None,
            made_at: Instant::now(),
            judged: Judged::default(),
        }
    }

    /// Takes over a changed state; the picture stays until there is another. `explain`: what
    /// the method did at each pixel is wanted too.
    pub(super) fn follow(&mut self, state: &PaneState, explain: bool) {
        if self.state.method != state.method {
            self.made_for = None;
            self.explains = explains(&state.method);
        }
        self.wanted_kept = match state.show {
            Show::Inside(_) => Kept::Everything,
            _ if explain && !self.explains.is_empty() => Kept::Explained,
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

    /// Keeps what is wanted of what the method exposed.
    pub(super) fn keep(&mut self, mut exposed: Vec<(String, Texture)>) {
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

    /// Lens points that a reference has and will have.
    pub fn progress(&self) -> Option<(u32, u32)> {
        self.run.as_ref().map(|p| (p.run.count(), p.samples))
    }

    /// What differs from the truth, if that was measured.
    pub fn figures(&self) -> &Judged {
        &self.judged
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

    /// Where a texture that the method exposes under `name` lies on a picture of `inner` px
    /// with a margin.
    pub(super) fn place_of(&self, name: &str, texture: &Texture, inner: UVec2, margin_px: u32) -> Place {
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

    /// Makes the picture anew.
    pub(super) fn restart(&mut self, exposure: &Exposure) {
        self.made_for = Some(exposure.clone());
        self.made_at = Instant::now();
        self.run = None;
        self.error = None;
        self.milestone = None;
    }

    /// Records the picture, or `views` more lens points of it.
    pub(super) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        view: &mut View,
        lens: &Lens,
        views: u32,
        revision: u64,
    ) -> Result<(), String> {
        self.revision = revision;
        if self.run.is_none() {
            let method = self.state.method.build()?;
            match progressive(method.as_ref(), frame, view, lens) {
                Some(progressive) => self.run = Some(progressive),
                None => {
                    let linear = methods::record(method.as_ref(), frame, view, lens).map_err(|e| e.to_string())?;
                    self.milestone = Some(Milestone { texture: linear.clone(), revision, samples: None });
                    self.linear = Some(linear);
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
        if count == *samples || (count >= LEAST_SAMPLES && passed_power_of_two(self.milestone.as_ref(), count)) {
            self.milestone = Some(Milestone { texture: mean.clone(), revision, samples: Some(count) });
        }
        self.linear = Some(mean);
        Ok(())
    }

    fn wanted(&self, request: &Request, other: Option<&Milestone>) -> ShownFor {
        ShownFor {
            show: self.state.show.clone(),
            opacity: self.state.opacity,
            development: request.development,
            revision: self.revision,
            other: other.map(|o| o.revision),
            map: self.judged.map_pair(),
        }
    }

    /// Whether what is seen is out of date.
    pub(super) fn wants_presenting(&self, request: &Request, other: Option<&Milestone>) -> bool {
        self.linear.is_some() && self.shown_for.as_ref() != Some(&self.wanted(request, other))
    }

    /// Brings what is seen up to date. `other` is the picture that a difference is taken
    /// from.
    pub(super) fn present(
        &mut self,
        frame: &mut Frame<'_>,
        view: &mut View,
        request: &Request,
        other: Option<&Milestone>,
    ) {
        if !self.wants_presenting(request, other) {
            return;
        }
        let Some(linear) = self.linear.clone() else { return };
        let wanted = self.wanted(request, other);
        frame.set_prefix("present/");
        let Development { display, channel, acceptable_coc_px, coc_scale_px } = request.development;
        // The lens of the picture, not the one asked for meanwhile: they belong together.
        let lens = self.made_for.as_ref().map_or(&request.exposure.lens, |e| &e.lens).clone();
        let mut overlay = |overlay| {
            // While the size changes, a pane waits for its new picture.
            (linear.size() == view.size()).then(|| present::overlay(frame, view, &linear, &lens, &display, overlay))
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
                    .filter(|other| other.texture.size() == linear.size())
                    .map(|other| present::difference(frame, &linear, &other.texture, &display, of)),
                None => self.judged.map().map(|map| {
                    let slice = Slice { texture: map, level: 0, layer: 0 };
                    Numbers { slice, channel: 0, map: Map::Error, ends: [0.0, 1.0] }.alone(frame)
                }),
            },
            Show::Inside(inside) => self.present_inside(frame, view, &inside, &display),
        };
        if shown.is_some() {
            self.shown = shown;
        }
        self.shown_for = Some(wanted);
    }

    fn present_inside(
        &mut self,
        frame: &mut Frame<'_>,
        view: &View,
        inside: &Inside,
        display: &Display,
    ) -> Option<Texture> {
        let (name, texture) = self.exposed_as(inside)?;
        let place = self.place_of(name, texture, view.size(), view.overscan_px());
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
        let picture = self.linear.as_ref().filter(|linear| self.state.opacity < 1.0 && linear.size() == view.size());
        let Some(picture) = picture else {
            self.place = Some(place);
            return Some(numbers.alone(frame));
        };
        Some(numbers.over(frame, picture, display, place, self.state.opacity))
    }

    /// The picture that another pane's difference is taken from.
    pub(super) fn to_compare(&self) -> Option<Milestone> {
        self.linear.clone().map(|texture| Milestone { texture, revision: self.revision, samples: None })
    }

    /// The pane that a FLIP map is wanted against.
    pub(super) fn wants_flip_against(&self) -> Option<PaneId> {
        match self.state.show {
            Show::Difference(difference) if difference.kind == DifferenceKind::Flip => Some(difference.against),
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
        DifferenceKind::Flip => None,
    }
}

/// Whether a power of two lies between the last milestone and `count`.
fn passed_power_of_two(last: Option<&Milestone>, count: u32) -> bool {
    last.and_then(|m| m.samples).is_none_or(|before| before.ilog2() < count.ilog2())
}

/// A run for the method that converges over many frames, where there is blur to converge.
fn progressive(method: &dyn Method, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Option<Progressive> {
    let (run, samples) = method.converging()?;
    let [low, high] = view.coc_bounds_px(frame, lens);
    (low.abs().max(high.abs()) >= IN_FOCUS_COC_PX).then_some(Progressive { run, samples })
}
