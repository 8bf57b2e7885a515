//! How the window looks: sizes and distances, for light and dark alike.

use eframe::egui::{self, CornerRadius, FontId, Margin, TextStyle, vec2};

/// Width of the panel with the controls, points.
pub const PANEL_WIDTH: f32 = 316.0;

/// Space left and right of what stands in a pane's head and foot, points.
pub const PANE_MARGIN: f32 = 6.0;

/// Width of the names left of the controls, points.
pub const NAME_WIDTH: f32 = 106.0;

/// Sets up a context; to be called once, before anything is shown.
pub fn apply(ctx: &egui::Context) {
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size = vec2(36.0, 22.0);
        style.spacing.window_margin = Margin::same(12);
        style.spacing.combo_width = 110.0;
        style.visuals.slider_trailing_fill = true;
        style.visuals.striped = false;
        let corner = CornerRadius::same(4);
        let widgets = &mut style.visuals.widgets;
        for visuals in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open] {
            visuals.corner_radius = corner;
        }
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(15.0));
        style.text_styles.insert(TextStyle::Body, FontId::proportional(13.0));
        style.text_styles.insert(TextStyle::Button, FontId::proportional(13.0));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.0));
        style.text_styles.insert(TextStyle::Small, FontId::proportional(11.0));
    });
}
