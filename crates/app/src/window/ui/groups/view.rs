//! How large the picture is and how it is shown.

use crate::window::action::Action;
use crate::window::model::{
    DEFAULT_OPACITY, Document, Edit, GREATEST_SIDE_PX, LEAST_SIDE_PX, Navigation, PaneState, PictureSize, Preference,
    Preferences, Show, ViewSettings,
};
use crate::window::ui::panels::{Field, fit_slider};
use crate::window::ui::style::NAME_WIDTH;
use crate::window::ui::widgets::{self, choice};
use defocus::combine::Channel;
use defocus::display::ToneMap;
use eframe::egui::{self, RichText, Ui};
use glam::UVec2;
use std::ops::RangeInclusive;

/// What the group is told.
pub struct PanelView<'a> {
    /// What is shown.
    pub document: &'a Document,
    /// What belongs to the person.
    pub preferences: &'a Preferences,
    /// Size of one eye's picture, px; 0 before there is one.
    pub size_px: UVec2,
    /// Exposure that the scene's light asks for, EV, where it asks for one.
    pub metered_ev: Option<f32>,
}

/// Shows the group; what is to be done.
pub fn view_group(ui: &mut Ui, view: &PanelView<'_>) -> Vec<Action> {
    let PanelView { document, preferences, size_px, metered_ev } = view;
    let mut actions = Vec::new();
    // Before there is something to see it has no size.
    if size_px.min_element() > 0 {
        actions.extend(size_rows(ui, document.size, *size_px).map(Action::SetSize));
    }
    let mut settings = document.view_settings();
    exposure_row(ui, &mut settings);
    actions.extend(metered_row(ui, document, *metered_ev).map(Action::from));
    brightness_rows(ui, &mut settings);
    coc_rows(ui, &document.panes, &mut settings);
    let a = document.pane(document.a);
    let has_overlay = |pane: &&PaneState| matches!(pane.show, Show::Coc | Show::Depth | Show::Inside(_));
    if let Some(pane) = a.filter(has_overlay) {
        let mut opacity = pane.opacity;
        overlay_opacity(ui, &mut opacity);
        actions.extend((opacity != pane.opacity).then(|| Edit::Opacity(pane.id, opacity).into()));
    }
    actions.extend(person_rows(ui, preferences).into_iter().map(Action::Prefer));
    let help = "Margin drawn around the picture, from which blur comes in over the border.";
    widgets::row(ui, "Overscan", help, |ui| {
        fit_slider(ui);
        ui.add(egui::Slider::new(&mut settings.overscan_px, 0..=96).suffix(" px"))
    });
    if settings != document.view_settings() {
        actions.push(Edit::View(settings).into());
    }
    actions
}

/// What the scene's light asks for, in a place of its own also where it asks for nothing.
fn metered_row(ui: &mut Ui, document: &Document, metered_ev: Option<f32>) -> Option<Edit> {
    let ev = document.display.exposure_ev;
    let (text, asked) = match metered_ev {
        Some(asked) if asked == ev => (format!("metered: {asked:+.1} EV by the picture's light"), None),
        Some(asked) => (format!("set by hand; the light asks for {asked:+.1} EV"), Some(asked)),
        None => ("the scene's light needs no metering".to_owned(), None),
    };
    let help = "A file whose light would make the picture white or black is exposed by the log average of its pinhole image, the same for all methods and the reference.";
    let mut edit = None;
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).small().weak()).on_hover_text(help);
        let button = ui.add_enabled(asked.is_some(), egui::Button::new("Meter").small());
        if button.on_hover_text("Sets the exposure that the light asks for.").clicked() {
            edit = asked.map(Edit::MeteredExposure);
        }
    });
    edit
}

fn exposure_row(ui: &mut Ui, settings: &mut ViewSettings) {
    let mut exposure = f64::from(settings.display.exposure_ev);
    let field = Field {
        name: "Exposure",
        help: "Brightness, as a power of two.",
        unit: " EV",
        range: -6.0..=6.0,
        log: None,
        reset: Some(0.0),
    };
    if field.show(ui, &mut exposure) {
        settings.display.exposure_ev = exposure.clamp(-64.0, 64.0) as f32;
    }
}

fn brightness_rows(ui: &mut Ui, settings: &mut ViewSettings) {
    let mut tone_map = ToneMap::ALL.iter().position(|t| *t == settings.display.tone_map).unwrap_or(0);
    let names = ["None", "Reinhard", "AgX"];
    if choice(ui, "Tone map", "How bright light is brought into the display's range.", &mut tone_map, &names) {
        settings.display.tone_map = ToneMap::ALL[tone_map];
    }
    let names = Channel::ALL.map(|(_, name)| name);
    let mut channel = Channel::ALL.iter().position(|(c, _)| *c == settings.channel).unwrap_or(0);
    if choice(ui, "Channel", "Which channels of pictures are shown, each as grey.", &mut channel, &names) {
        settings.channel = Channel::ALL[channel].0;
    }
}

fn coc_rows(ui: &mut Ui, panes: &[PaneState], settings: &mut ViewSettings) {
    let usual = Document::default();
    let px = |name, help, range: RangeInclusive<f64>, reset: f32| {
        let (log, reset) = (Some(*range.start()), Some(f64::from(reset)));
        Field { name, help, unit: " px", range, log, reset }
    };
    let mut acceptable = f64::from(settings.acceptable_coc_px);
    let help = "Greatest circle of confusion that counts as sharp: decides where the depth of field ends.";
    if px("Sharp up to", help, 0.25..=16.0, usual.acceptable_coc_px).show(ui, &mut acceptable) {
        settings.acceptable_coc_px = acceptable.clamp(0.01, 1000.0) as f32;
    }
    if panes.iter().all(|pane| pane.show != Show::Coc) {
        return;
    }
    let help = "The colour map reaches as far as the circle of confusion of the picture; off, as far as is set.";
    widgets::row(ui, "CoC scale fits", help, |ui| ui.checkbox(&mut settings.coc_scale_fits, ""));
    if !settings.coc_scale_fits {
        let mut scale = f64::from(settings.coc_scale_px);
        let help = "Circle of confusion at the ends of the colour map.";
        if px("CoC scale", help, 1.0..=128.0, usual.coc_scale_px).show(ui, &mut scale) {
            settings.coc_scale_px = scale.clamp(0.01, 10_000.0) as f32;
        }
    }
}

/// What belongs to the person and not to the picture.
fn person_rows(ui: &mut Ui, preferences: &Preferences) -> Vec<Preference> {
    let mut preferred = Vec::new();
    let mut navigation = usize::from(preferences.navigation == Navigation::Fly);
    let help = "Orbit: dragging moves around what is seen. Fly: dragging turns on the spot. W A S D Q E fly in both.";
    if choice(ui, "Navigation", help, &mut navigation, &["Orbit", "Fly"]) {
        let chosen = if navigation == 1 { Navigation::Fly } else { Navigation::Orbit };
        preferred.push(Preference::Navigation(chosen));
    }
    let mut is_smooth = preferences.smooth_focus;
    let help = "Focus moves to where one clicks in a quarter of a second, instead of at once.";
    if widgets::row(ui, "Smooth focus", help, |ui| ui.checkbox(&mut is_smooth, "")).changed() {
        preferred.push(Preference::SmoothFocus(is_smooth));
    }
    preferred
}

/// The sizes that are offered, and the pixels of one that is typed; what was chosen.
/// `px`: the size that there is.
fn size_rows(ui: &mut Ui, size: PictureSize, px: UVec2) -> Option<PictureSize> {
    let offered = PictureSize::offered();
    let mut names: Vec<&str> = offered.iter().map(|(name, _)| name.as_str()).collect();
    names.push("Other");
    let before = offered.iter().position(|(_, known)| *known == size).unwrap_or(offered.len());
    let mut chosen = before;
    let help = "Pixels of the picture, of each eye's where there are two. Panes show it fitted in or magnified: how they lie changes neither the picture nor what is measured, unless it is to be as large as the window.";
    choice(ui, "Picture size", help, &mut chosen, &names);
    let (mut width, mut height) = (px.x, px.y);
    let mut is_typed = false;
    ui.horizontal(|ui| {
        let mut side = |ui: &mut Ui, name: &str, side: &mut u32| {
            // What is there stays as it is until it is changed here.
            let drag =
                egui::DragValue::new(side).range(LEAST_SIDE_PX..=GREATEST_SIDE_PX).clamp_existing_to_range(false);
            let drag = ui.add(drag.suffix(" px").update_while_editing(false));
            is_typed |= drag.changed();
            drag.accessible_name(name).on_hover_text(name.to_owned());
        };
        ui.add_space(NAME_WIDTH + ui.spacing().item_spacing.x);
        side(ui, "Picture width", &mut width);
        ui.label("x");
        side(ui, "Picture height", &mut height);
    });
    match offered.get(chosen).filter(|_| chosen != before) {
        Some((_, size)) => Some(*size),
        None if chosen != before || is_typed => Some(PictureSize::Pixels(width, height)),
        None => None,
    }
}

/// How much the overlay of pane A hides of the picture.
fn overlay_opacity(ui: &mut Ui, opacity: &mut f32) {
    let field = Field {
        name: "Overlay opacity",
        help: "How much the overlay of pane A hides of the picture, which is grey under it; 100 % is the overlay alone.",
        unit: " %",
        range: 0.0..=100.0,
        log: None,
        reset: Some(100.0 * f64::from(DEFAULT_OPACITY)),
    };
    let mut percent = 100.0 * f64::from(*opacity);
    if field.show(ui, &mut percent) {
        *opacity = (0.01 * percent).clamp(0.0, 1.0) as f32;
    }
}
