//! Sizes of the interface.

/// Sizes of the interface that are offered, as multiples of the normal one; the last but one
/// is for a projector.
pub const UI_SCALES: [f32; 6] = [0.8, 1.0, 1.25, 1.5, 1.75, 2.0];

/// The size for a projector: text is as high on the screen as slides have it.
pub const PROJECTOR_SCALE: f32 = 1.75;

/// What an offered size is called.
pub fn scale_name(scale: f32) -> String {
    let projector = if scale == PROJECTOR_SCALE { ", for a projector" } else { "" };
    format!("Size of the interface: {} %{projector}", (100.0 * scale).round())
}
