//! What the engine is asked for.

use crate::window::model::{Document, MethodChoice, PaneId, PaneState};
use defocus::camera::Camera;
use defocus::combine::Channel;
use defocus::display::Display;
use defocus::lens::Lens;
use defocus::viewing::Viewing;
use glam::UVec2;

/// Everything that a picture depends on, the method aside.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderRequest {
    /// Where the scene is seen from; ignored for an image.
    pub camera: Option<Camera>,
    /// Size to render, px.
    pub size: UVec2,
    /// Margin around it, px.
    pub overscan_px: u32,
    /// The lens.
    pub lens: Lens,
    /// Whether it is replaced soon ([`View::set_draft`](defocus::view::View::set_draft)).
    pub draft: bool,
}

impl RenderRequest {
    /// What `document` asks for in a picture of `size` px through `lens`.
    pub fn of(document: &Document, size: UVec2, lens: Lens) -> Self {
        Self {
            camera: document.camera,
            size: size.max(UVec2::ONE),
            overscan_px: document.overscan_px,
            lens,
            draft: false,
        }
    }

    /// A draft of the same, `divisor` times smaller: lengths in pixels shrink with the picture, so that
    /// the blur covers the same part of it.
    pub(super) fn coarser(&self, divisor: u32) -> Self {
        if divisor <= 1 {
            return self.clone();
        }
        let scale = 1.0 / f64::from(divisor);
        let lens = self.lens.clone();
        Self {
            camera: self.camera,
            size: (self.size.as_dvec2() * scale).round().as_uvec2().max(UVec2::ONE),
            overscan_px: (f64::from(self.overscan_px) * scale).round() as u32,
            lens: Lens { density_px_per_mm: lens.density_px_per_mm * scale, ..lens },
            draft: true,
        }
    }
}

/// How pictures are turned into what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// Exposure and tone map.
    pub display: Display,
    /// Under what angle and in what light differences are judged.
    pub viewing: Viewing,
    /// Which channels of pictures are shown.
    pub channel: Channel,
    /// |c| up to which a point counts as sharp, px at this size.
    pub acceptable_coc_px: f32,
    /// |c| at the ends of the CoC's colour map, px at this size.
    pub coc_scale_px: f32,
}

impl DisplaySettings {
    /// The same for a picture that is `divisor` times smaller.
    pub(super) fn coarser(&self, divisor: u32) -> Self {
        let scale = 1.0 / divisor.max(1) as f32;
        Self { acceptable_coc_px: self.acceptable_coc_px * scale, coc_scale_px: self.coc_scale_px * scale, ..*self }
    }
}

/// Everything that the shown textures depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// What is pictured, and how.
    pub render: RenderRequest,
    /// How it is shown.
    pub display_settings: DisplaySettings,
    /// The panes.
    pub panes: Vec<PaneState>,
    /// Those on the screen.
    pub visible: Vec<PaneId>,
    /// The one that shows the truth, if one does.
    pub reference: Option<PaneId>,
    /// Whether methods are to tell what they did at each pixel.
    pub explain: bool,
    /// The pane whose method is to keep every texture that it makes.
    pub story: Option<PaneId>,
    /// The one that is brought up to date first, where not all can be at once.
    pub first: PaneId,
    /// Whether the person is at mouse or keys: a reference waits where a step of it takes
    /// longer than one notices.
    pub held: bool,
    /// Whether something is being dragged or moves by itself: what takes long is drawn
    /// smaller until it rests.
    pub is_moving: bool,
}

impl Request {
    /// What `document` asks for in a picture of `size` px.
    pub fn new(document: &Document, size: UVec2, first: PaneId) -> Self {
        let mut panes = document.panes.clone();
        let mut reference = document.reference();
        if reference.is_none() && document.measure {
            panes.push(PaneState::new(PaneId::HIDDEN, MethodChoice::reference()));
            reference = Some(PaneId::HIDDEN);
        }
        Self {
            render: RenderRequest::of(document, size, document.lens.clone()),
            display_settings: DisplaySettings {
                display: document.display,
                viewing: document.viewing(),
                channel: document.channel,
                acceptable_coc_px: document.acceptable_coc_px,
                coc_scale_px: document.coc_scale_px,
            },
            panes,
            visible: document.visible(),
            reference,
            explain: false,
            story: None,
            first,
            held: false,
            is_moving: false,
        }
    }

    /// The pane of that number.
    pub(super) fn pane(&self, id: PaneId) -> Option<&PaneState> {
        self.panes.iter().find(|p| p.id == id)
    }

    /// The panes that have to be rendered: those on the screen, those they are compared
    /// with, and the truth.
    pub(super) fn needed(&self) -> Vec<PaneId> {
        let against = self.visible.iter().filter_map(|id| self.pane(*id)?.show.against());
        let wanted: Vec<PaneId> = self.visible.iter().copied().chain(against).chain(self.reference).collect();
        self.panes.iter().map(|p| p.id).filter(|id| wanted.contains(id)).collect()
    }
}
