//! How the window looks: sizes and distances, for light and dark alike.

use eframe::egui::{self, Color32, CornerRadius, FontId, Margin, TextStyle, vec2};

/// Width of the panel with the controls, points.
pub const PANEL_WIDTH: f32 = 340.0;

/// Space between the rows of that panel, points: one screen of 720 points has what is always used.
pub const PANEL_SPACING: f32 = 3.0;

/// Space left and right of what stands in a pane's head and foot, points.
pub const PANE_MARGIN: f32 = 6.0;

/// Width of the names left of the controls, points.
pub const NAME_WIDTH: f32 = 100.0;

/// Colours of text on the panels of a theme.
struct TextColors {
    text: Color32,
    weak: Color32,
    warning: Color32,
    error: Color32,
}

/// On dark panels.
const ON_DARK: TextColors = TextColors {
    text: Color32::from_gray(190),
    weak: Color32::from_gray(150),
    warning: Color32::from_rgb(255, 160, 40),
    error: Color32::from_rgb(255, 110, 100),
};

/// On light panels.
const ON_LIGHT: TextColors = TextColors {
    text: Color32::from_gray(50),
    weak: Color32::from_gray(95),
    warning: Color32::from_rgb(160, 70, 0),
    error: Color32::from_rgb(185, 20, 10),
};

fn color_text(ctx: &egui::Context) {
    for (theme, colors) in [(egui::Theme::Dark, ON_DARK), (egui::Theme::Light, ON_LIGHT)] {
        ctx.style_mut_of(theme, |style| {
            let visuals = &mut style.visuals;
            visuals.widgets.noninteractive.fg_stroke.color = colors.text;
            visuals.weak_text_color = Some(colors.weak);
            visuals.warn_fg_color = colors.warning;
            visuals.error_fg_color = colors.error;
        });
    }
}

/// Least contrast of text against what is behind it (WCAG 2, level AA).
pub const LEAST_CONTRAST: f64 = 4.5;

/// Relative luminance as WCAG 2 defines it.
fn luminance(color: Color32) -> f64 {
    let linear = |v: u8| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
}

/// Contrast of two opaque colours, from 1 to 21 (WCAG 2).
pub fn contrast(a: Color32, b: Color32) -> f64 {
    let [a, b] = [a, b].map(luminance);
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// A colour that means something, brought as near to black or white as text on `ground` needs to
/// be read, and no nearer.
pub fn readable(color: Color32, ground: Color32) -> Color32 {
    const STEPS: u32 = 32;
    let end = if luminance(ground) > 0.18 { Color32::BLACK } else { Color32::WHITE };
    let steps = (0..=STEPS).map(|step| color.lerp_to_gamma(end, step as f32 / STEPS as f32));
    let mut readable = steps.filter(|mixed| contrast(*mixed, ground) >= LEAST_CONTRAST);
    readable.next().unwrap_or(end)
}

/// Sets up a context; to be called once, before anything is shown.
pub fn apply(ctx: &egui::Context) {
    color_text(ctx);
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size = vec2(36.0, 22.0);
        style.spacing.window_margin = Margin::same(12);
        style.spacing.combo_width = 110.0;
        // A list that goes on below its edge shows a bar also where no pointer is.
        style.spacing.scroll.floating_allocated_width = style.spacing.scroll.bar_width;
        style.spacing.scroll.dormant_background_opacity = 0.3;
        style.spacing.scroll.dormant_handle_opacity = 0.6;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_can_be_read_on_every_ground() {
        let ctx = egui::Context::default();
        apply(&ctx);
        for theme in [egui::Theme::Dark, egui::Theme::Light] {
            let visuals = ctx.style_of(theme).visuals.clone();
            let texts = [
                ("text", visuals.text_color()),
                ("weak text", visuals.weak_text_color()),
                ("strong text", visuals.strong_text_color()),
                ("a warning", visuals.warn_fg_color),
                ("an error", visuals.error_fg_color),
            ];
            for (ground, fill) in [
                ("a panel", visuals.panel_fill),
                ("a window", visuals.window_fill),
                ("a plot", visuals.extreme_bg_color),
            ] {
                for (name, color) in texts {
                    let ratio = contrast(color, fill);
                    assert!(ratio >= 4.5, "{theme:?}: {name} on {ground} has {ratio:.2}:1");
                }
            }
            let selection = contrast(visuals.selection.stroke.color, visuals.selection.bg_fill);
            assert!(selection >= LEAST_CONTRAST, "{theme:?}: what is chosen has {selection:.2}:1");
            let striped = visuals.panel_fill.blend(visuals.faint_bg_color);
            for (name, color) in texts {
                let ratio = contrast(color, striped);
                assert!(ratio >= LEAST_CONTRAST, "{theme:?}: {name} in a striped row has {ratio:.2}:1");
            }
            for visibility in defocus_study::metrics::Visibility::ALL {
                let [r, g, b] = visibility.srgb8();
                let ratio = contrast(readable(Color32::from_rgb(r, g, b), visuals.panel_fill), visuals.panel_fill);
                assert!(ratio >= LEAST_CONTRAST, "{theme:?}: {} has {ratio:.2}:1", visibility.word());
            }
            let widgets = &visuals.widgets;
            for widget in [&widgets.inactive, &widgets.hovered, &widgets.active, &widgets.open] {
                let ratio = contrast(widget.fg_stroke.color, widget.weak_bg_fill);
                assert!(ratio >= 4.5, "{theme:?}: a button has {ratio:.2}:1");
            }
        }
    }
}
