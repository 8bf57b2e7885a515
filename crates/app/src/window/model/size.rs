//! How large the picture is: a part of the experiment, and none of the window's business.

use defocus::presets::presets;
use defocus_study::Source;
use glam::{UVec2, uvec2};

/// Least side of a picture, px: a smaller one shows nothing worth measuring.
pub const LEAST_SIDE_PX: u32 = 16;

/// Greatest side that can be asked for, px: twice that of the widest headset's eye. An
/// adapter may have a lower limit, which it tells.
pub const GREATEST_SIDE_PX: u32 = 8192;

/// Sizes that are offered, px: those of the papers' figures and of displays.
const COMMON_PX: [(u32, u32); 6] = [(640, 480), (800, 600), (1024, 768), (1280, 720), (1920, 1080), (2560, 1440)];

/// How large the picture of one eye is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum PictureSize {
    /// As the scene or image has it: what the command line draws without `--size`.
    #[default]
    Own,
    /// As large as the largest pane: it changes with the window and with what stands in it.
    Window,
    /// Width and height, px.
    Pixels(u32, u32),
}

impl PictureSize {
    /// All that are offered, with their names: the source's own first, then that of the
    /// window, common ones, and those of an eye of each headset that is known.
    pub fn offered() -> Vec<(String, Self)> {
        let common = COMMON_PX.map(|(w, h)| (format!("{w} x {h}"), Self::Pixels(w, h)));
        let headsets = presets().into_iter().filter_map(|preset| Some((preset.name, preset.headset?.eye_px)));
        let headsets = headsets.map(|(name, (w, h))| (format!("{name}: {w} x {h} an eye"), Self::Pixels(w, h)));
        let first = [("As the scene has it".to_owned(), Self::Own), ("As the window".to_owned(), Self::Window)];
        first.into_iter().chain(common).chain(headsets).collect()
    }

    /// The same with what a file could have wrong put right.
    pub fn repaired(self) -> Self {
        match self {
            Self::Pixels(width, height) => {
                let [w, h] = [width, height].map(|side| side.clamp(LEAST_SIDE_PX, GREATEST_SIDE_PX));
                Self::Pixels(w, h)
            }
            other => other,
        }
    }

    /// The size, px, of a picture of `source` by its camera of that number, where the
    /// window has room for `window` px; an image keeps its shape and is never enlarged.
    pub fn resolved(self, source: &Source, camera: usize, window: UVec2) -> UVec2 {
        match self {
            Self::Own => source.default_size(camera),
            Self::Window => source.fitted_size(window),
            Self::Pixels(width, height) => source.fitted_size(uvec2(width, height)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use defocus_study::DepthArgs;

    #[test]
    fn only_the_windows_size_is_the_windows() {
        let scene = Source::open("fence", &DepthArgs::default()).expect("a built-in scene");
        for (name, size) in PictureSize::offered() {
            let [a, b] = [uvec2(300, 200), uvec2(900, 700)].map(|window| size.resolved(&scene, 0, window));
            assert_eq!(a == b, size != PictureSize::Window, "{name}");
        }
        assert_eq!(PictureSize::Own.resolved(&scene, 0, UVec2::ZERO), scene.default_size(0));
    }

    #[test]
    fn an_image_keeps_its_shape() {
        let image = Source::open("forest", &DepthArgs::default()).expect("a built-in image");
        let own = PictureSize::Own.resolved(&image, 0, UVec2::ZERO);
        let half = PictureSize::Pixels(own.x / 2, own.y).resolved(&image, 0, UVec2::ZERO);
        assert_eq!(half, uvec2(own.x / 2, own.y / 2));
        assert_eq!(PictureSize::Pixels(10 * own.x, 10 * own.y).resolved(&image, 0, UVec2::ZERO), own);
    }

    #[test]
    fn absurd_sizes_are_put_right() {
        assert_eq!(PictureSize::Pixels(0, u32::MAX).repaired(), PictureSize::Pixels(16, 8192));
    }
}
