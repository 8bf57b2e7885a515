//! What the inspector is told: values under the pointer, read back while it is open.

use super::App;
use super::engine::Story;
use super::model::PaneId;
use super::model::numbers::quantity_text;
use super::ui::panels::{Inspection, PaneValue, image_histogram, inspector_panel, neighbourhood, story_panel};
use defocus::display::Display;
use defocus::focus::pixel;
use defocus::histogram::Histogram;
use defocus::image::ColorImage;
use eframe::egui::Ui;
use std::sync::Arc;

/// Pixels around the one under the pointer, in each direction.
const RADIUS_PX: u32 = 7;

/// What was inspected last: it stays while the pointer is elsewhere.
#[derive(Default)]
pub struct Inspector {
    open: bool,
    last: Option<Inspection>,
    histogram: Option<(Arc<ColorImage>, Display, Histogram)>,
    /// Whether every texture of the pane under the pointer is told of.
    tells_story: bool,
    /// The pane whose story it is.
    story_of: Option<PaneId>,
    story: Option<(PaneId, Story)>,
    /// Whether the panel is to be unfolded and brought into sight.
    reveal: bool,
}

impl Inspector {
    /// Whether it was looked at in this frame: then methods tell what they did.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// The pane whose method is to keep all of its textures.
    pub fn story_of(&self) -> Option<PaneId> {
        self.story_of.filter(|_| self.open && self.tells_story)
    }

    /// Begins to tell the story, in sight of the person, or stops.
    pub fn toggle_story(&mut self) {
        let is_told = self.open && self.tells_story;
        (self.tells_story, self.reveal) = (!is_told, !is_told);
    }

    /// Whether the panel is to be brought into sight, once.
    pub fn take_reveal(&mut self) -> bool {
        std::mem::take(&mut self.reveal)
    }

    /// Nobody looks at it, until it is shown.
    pub fn close(&mut self) {
        self.open = false;
    }
}

impl App {
    /// The inspector's panel.
    pub(super) fn inspector(&mut self, ui: &mut Ui) {
        self.inspector.open = true;
        self.follow_story();
        self.inspect();
        let help = "Every texture that the method makes, read under the pointer: keeps all of them in memory";
        ui.checkbox(&mut self.inspector.tells_story, "Story of the pixel").on_hover_text(help);
        if self.inspector.tells_story {
            let known = self.inspector.story.as_ref();
            let title =
                known.and_then(|(id, _)| self.document.pane(*id)).map_or_else(String::new, |p| p.method.title());
            story_panel(ui, &title, known.map(|(_, story)| story));
        }
        let inspector = &self.inspector;
        let depths_m = self.engine.depths_m(false);
        let (lens, display) = (&self.document.lens, &self.document.display);
        let histogram = inspector.histogram.as_ref().map(|(.., histogram)| histogram);
        inspector_panel(ui, inspector.last.as_ref(), lens, display, histogram, depths_m);
    }

    /// The story is that of the pane under the pointer, and of pane A before there was one.
    fn follow_story(&mut self) {
        let (a, hovered) = (self.document.a, self.viewport.hovered());
        let inspector = &mut self.inspector;
        let is_there = |id: &PaneId| self.document.pane(*id).is_some();
        inspector.story_of = hovered.or(inspector.story_of).filter(is_there).or(Some(a));
        inspector.story = inspector.story.take().filter(|(id, _)| is_there(id));
    }

    /// Reads what lies under the pointer, and counts the picture of pane A once it is done.
    fn inspect(&mut self) {
        // While pictures change, reading each of them back would hold up the next.
        let at_rest = self.engine.wants_update_in().is_none_or(|pause| pause.as_millis() > 10);
        if !at_rest {
            return;
        }
        let (a, display) = (self.document.a, self.document.display);
        if let Some(picture) = self.engine.color(a).filter(|p| p.size.min_element() > 0) {
            let known = self.inspector.histogram.as_ref();
            if known.is_none_or(|(of, shown, _)| !Arc::ptr_eq(of, &picture) || *shown != display) {
                let histogram = image_histogram(&picture, &display);
                self.inspector.histogram = Some((picture, display, histogram));
            }
        }
        let Some(at) = self.viewport.cursor() else { return };
        let ids: Vec<_> = self.document.visible();
        let names = self.document.panes.iter().enumerate().filter(|(_, p)| ids.contains(&p.id));
        let names: Vec<_> = names.map(|(i, p)| (p.id, format!("{} {}", i + 1, p.method.title()))).collect();
        let hovered = self.viewport.hovered().unwrap_or(a);
        let story_of = self.inspector.story_of().filter(|id| *id == hovered);
        let (engine, own) = self.eye_of(at);
        let pictures: Vec<_> = names.into_iter().filter_map(|(id, name)| Some((id, name, engine.color(id)?))).collect();
        let Some((.., picture)) = pictures.iter().find(|(id, ..)| *id == hovered).or(pictures.first()) else { return };
        if picture.size.min_element() == 0 {
            return;
        }
        let at_px = pixel(picture.size, own);
        let Some(depth_m) = engine.depth_at_m(own) else { return };
        let story = story_of.and_then(|id| Some((id, engine.story_at(id, own)?)));
        let same_size = pictures.iter().filter(|(.., p)| p.size == picture.size);
        let engine = &*engine;
        let numbers = |id| {
            let shown = engine.inside_at(id, own).map(|(reading, value)| (reading.quantity.clone(), value));
            let mut numbers: Vec<(String, String)> = Vec::new();
            for (quantity, value) in shown.into_iter().chain(engine.explained_at(id, own)) {
                if numbers.iter().all(|(name, _)| name != quantity.name) {
                    numbers.push((quantity.name.to_owned(), quantity_text(&quantity, value)));
                }
            }
            numbers
        };
        self.inspector.last = Some(Inspection {
            pixel: at_px,
            depth_m,
            panes: same_size
                .map(|(id, name, p)| PaneValue {
                    name: name.clone(),
                    color: p.at(at_px.x, at_px.y),
                    numbers: numbers(*id),
                    divisor: engine.exposed_divisor(*id),
                })
                .collect(),
            neighbourhood: neighbourhood(picture, at_px, RADIUS_PX),
        });
        if story.is_some() {
            self.inspector.story = story;
        }
    }
}
