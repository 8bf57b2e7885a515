//! Changes of single parts of the document, as panels and the pointer ask for them.

use super::batch::{BatchRow, MOST_BATCH_ROWS};
use super::document::{Document, Zoom};
use super::focus::FocusSettings;
use super::kernel::KernelChoice;
use super::lens::same_but_focus;
use super::lessons::Dragged;
use super::method::MethodChoice;
use super::moment::Moment;
use super::pane_id::PaneId;
use super::pane_tree::PaneTree;
use super::show::Show;
use defocus::aperture::Aperture;
use defocus::camera::Camera;
use defocus::combine::Channel;
use defocus::display::Display;
use defocus::eye::Pupil;
use defocus::lens::Lens;
use defocus::presets::presets;
use defocus::stereo::Stereo;
use defocus::viewing::Screen;
use glam::UVec2;

/// A change of one part of the document.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Another lens, which follows the scene no more.
    Lens(Lens),
    /// Distance that is focused on, metres.
    FocusDistance(f64),
    /// Shape of the aperture.
    Aperture(Aperture),
    /// E set by hand, mm.
    ApertureDiameter(f64),
    /// The eye and the display before it.
    Eye(Box<EyeSettings>),
    /// How focus is chosen.
    Focus(FocusSettings),
    /// The camera's horizontal field of view, radians, in a picture of so many pixels.
    FieldOfView(UVec2, f64),
    /// Where the scene is seen from, and how far away the point is that the camera orbits, metres.
    Camera(Camera, f64),
    /// The moment of an animation; the scene at rest without one.
    Moment(Option<Moment>),
    /// How two eyes see the scene.
    Stereo(Option<Stereo>),
    /// A pane's method with its parameters.
    Method(PaneId, MethodChoice),
    /// What a pane shows.
    Show(PaneId, Show),
    /// How much a pane's overlay hides, from 0 to 1.
    Opacity(PaneId, f32),
    /// How pictures are shown.
    View(ViewSettings),
    /// The exposure that the picture's light asks for, EV, which is that of scenes to come too.
    MeteredExposure(f32),
    /// How the panes are tiled.
    Tiles(PaneTree),
    /// Where the divider stands, from 0 (left) to 1.
    Divider(f32),
    /// Which part of the picture is shown.
    Zoom(Zoom),
    /// Of which point the point spread function is measured.
    Kernel(KernelChoice),
    /// The one thing to drag in a lesson.
    Lesson(Dragged, f64),
    /// A row of the batch, by its place.
    BatchRow(usize, BatchRow),
    /// Takes the row of that place away.
    RemoveBatchRow(usize),
    /// Takes all rows of the batch away.
    ClearBatch,
    /// Adds rows with the present lens, one for each method.
    AddToBatch(Vec<MethodChoice>),
}

/// The eye and the display before it.
#[derive(Clone, Debug, PartialEq)]
pub struct EyeSettings {
    /// The lens, whose eye it is.
    pub lens: Lens,
    /// Light and age that E follows, if it does.
    pub pupil: Option<Pupil>,
    /// Age, years, that limits the accommodation, if it does.
    pub age_years: Option<f64>,
    /// The display's light.
    pub screen: Screen,
    /// Pixels per degree at which differences are judged, where not the lens's.
    pub ppd: Option<f64>,
}

/// How pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// Exposure and tone map.
    pub display: Display,
    /// Which channels of pictures are shown.
    pub channel: Channel,
    /// |c| up to which a point counts as sharp, px.
    pub acceptable_coc_px: f32,
    /// Whether the CoC's colour map reaches as far as the picture's CoC does.
    pub coc_scale_fits: bool,
    /// |c| at the ends of the CoC's colour map where that is fixed, px.
    pub coc_scale_px: f32,
    /// Margin drawn around the picture, px.
    pub overscan_px: u32,
}

impl Document {
    /// The eye and the display before it.
    pub fn eye_settings(&self) -> EyeSettings {
        let Self { lens, pupil, age_years, screen, ppd, .. } = self;
        EyeSettings { lens: lens.clone(), pupil: *pupil, age_years: *age_years, screen: *screen, ppd: *ppd }
    }

    /// How pictures are shown.
    pub fn view_settings(&self) -> ViewSettings {
        ViewSettings {
            display: self.display,
            channel: self.channel,
            acceptable_coc_px: self.acceptable_coc_px,
            coc_scale_fits: self.coc_scale_fits,
            coc_scale_px: self.coc_scale_px,
            overscan_px: self.overscan_px,
        }
    }

    /// Changes what `edit` names. What names a pane or row that is not there changes nothing.
    pub fn apply(&mut self, edit: Edit) {
        match edit {
            Edit::Lens(lens) => self.set_lens(lens),
            Edit::FocusDistance(distance_m) => self.lens.focus_distance_m = distance_m,
            Edit::Aperture(aperture) => self.lens.aperture = aperture,
            Edit::ApertureDiameter(diameter_mm) => {
                self.lens.aperture_diameter_mm = diameter_mm;
                (self.automatic_lens, self.pupil) = (false, None);
            }
            Edit::Eye(settings) => {
                let EyeSettings { lens, pupil, age_years, screen, ppd } = *settings;
                self.automatic_lens &= lens == self.lens;
                (self.lens, self.pupil, self.age_years) = (lens, pupil, age_years);
                (self.screen, self.ppd) = (screen, ppd);
            }
            Edit::Focus(focus) => self.focus = focus.repaired(),
            Edit::FieldOfView(size, fov_x) => self.camera = self.camera.map(|camera| camera.with_fov_x(size, fov_x)),
            Edit::Camera(camera, pivot_m) => (self.camera, self.pivot_m) = (Some(camera), pivot_m),
            Edit::Moment(moment) => self.moment = moment.map(Moment::repaired),
            Edit::Stereo(stereo) => self.stereo = stereo.map(Stereo::repaired),
            Edit::View(view) => self.set_view(view),
            Edit::MeteredExposure(ev) => {
                (self.display.exposure_ev, self.automatic_exposure) = (ev, true);
            }
            Edit::Tiles(tree) => self.tiles = Some(tree),
            Edit::Divider(share) if !share.is_nan() => self.divider = share.clamp(0.0, 1.0),
            Edit::Divider(_) => {}
            Edit::Zoom(zoom) => self.zoom = zoom.repaired(),
            Edit::Kernel(choice) => self.kernel = choice.repaired(),
            Edit::Lesson(dragged, value) => dragged.set(self, value),
            Edit::Method(id, _) | Edit::Show(id, _) | Edit::Opacity(id, _) => self.edit_pane(id, edit),
            Edit::BatchRow(..) | Edit::RemoveBatchRow(_) | Edit::ClearBatch | Edit::AddToBatch(_) => {
                self.edit_batch(edit);
            }
        }
    }

    fn edit_pane(&mut self, id: PaneId, edit: Edit) {
        let Some(pane) = self.pane_mut(id) else { return };
        match edit {
            Edit::Method(_, method) => pane.method = method,
            Edit::Show(_, show) => pane.show = show,
            Edit::Opacity(_, share) if !share.is_nan() => pane.opacity = share.clamp(0.0, 1.0),
            _ => {}
        }
    }

    fn edit_batch(&mut self, edit: Edit) {
        match edit {
            Edit::BatchRow(index, row) => {
                if let Some(known) = self.batch.get_mut(index) {
                    *known = row.repaired();
                }
            }
            Edit::RemoveBatchRow(index) if index < self.batch.len() => drop(self.batch.remove(index)),
            Edit::ClearBatch => self.batch.clear(),
            Edit::AddToBatch(methods) => self.add_to_batch(methods),
            _ => {}
        }
    }

    /// Adds the present aperture and focus with each of `methods`, unless a row has them.
    fn add_to_batch(&mut self, methods: Vec<MethodChoice>) {
        let Lens { aperture_diameter_mm: aperture_mm, focus_distance_m: focus_m, .. } = self.lens;
        for method in methods {
            let row = BatchRow { aperture_mm, focus_m, method };
            if self.batch.len() < MOST_BATCH_ROWS && !self.batch.contains(&row) {
                self.batch.push(row);
            }
        }
    }

    /// Another lens; that of a preset brings its display's light with it.
    fn set_lens(&mut self, lens: Lens) {
        self.lens = lens;
        self.automatic_lens = false;
        let shown = presets().into_iter().find(|preset| same_but_focus(&preset.lens, &self.lens));
        let screen = shown.and_then(|preset| preset.screen);
        self.screen = screen.unwrap_or(self.screen);
        match &mut self.pupil {
            // A pupil that follows the light follows that of another display.
            Some(pupil) if screen.is_some() => {
                pupil.luminance_cd_m2 = self.screen.adapting_cd_m2();
                self.lens.aperture_diameter_mm = pupil.diameter_mm();
            }
            // An E that is set by hand does not follow any more.
            Some(pupil) if pupil.diameter_mm() != self.lens.aperture_diameter_mm => self.pupil = None,
            _ => {}
        }
    }

    fn set_view(&mut self, view: ViewSettings) {
        let ViewSettings { display, channel, acceptable_coc_px, coc_scale_fits, coc_scale_px, overscan_px } = view;
        // An exposure that is set by hand is kept for scenes to come.
        self.automatic_exposure &= display.exposure_ev == self.display.exposure_ev;
        (self.display, self.channel, self.overscan_px) = (display, channel, overscan_px);
        (self.acceptable_coc_px, self.coc_scale_fits) = (acceptable_coc_px, coc_scale_fits);
        self.coc_scale_px = coc_scale_px;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::model::PaneState;

    fn document() -> Document {
        let methods = ["mipmap", "separable"].map(MethodChoice::new);
        Document::of_methods(methods)
    }

    #[test]
    fn a_part_that_is_given_back_as_it_is_changes_nothing() {
        let before = document();
        let pane: PaneState = before.panes[0].clone();
        let edits = [
            Edit::FocusDistance(before.lens.focus_distance_m),
            Edit::Aperture(before.lens.aperture.clone()),
            Edit::Eye(Box::new(before.eye_settings())),
            Edit::Focus(before.focus),
            Edit::Stereo(before.stereo),
            Edit::Moment(before.moment.clone()),
            Edit::View(before.view_settings()),
            Edit::Divider(before.divider),
            Edit::Kernel(before.kernel),
            Edit::Zoom(before.zoom),
            Edit::Method(pane.id, pane.method.clone()),
            Edit::Show(pane.id, pane.show.clone()),
            Edit::Opacity(pane.id, pane.opacity),
        ];
        for edit in edits {
            let mut after = before.clone();
            after.apply(edit.clone());
            assert_eq!(after, before, "{edit:?}");
        }
    }

    #[test]
    fn what_is_not_there_is_not_edited() {
        let before = document();
        let absent = PaneId(77);
        let row = BatchRow { aperture_mm: 1.0, focus_m: 1.0, method: MethodChoice::new("pinhole") };
        let edits = [
            Edit::Method(absent, MethodChoice::new("pinhole")),
            Edit::Show(absent, Show::Coc),
            Edit::Opacity(absent, 1.0),
            Edit::BatchRow(3, row),
            Edit::RemoveBatchRow(3),
            Edit::Divider(f32::NAN),
            Edit::FieldOfView(UVec2::ONE, 1.0),
        ];
        for edit in edits {
            let mut after = before.clone();
            after.apply(edit.clone());
            assert_eq!(after, before, "{edit:?}");
        }
    }

    #[test]
    fn a_lens_set_by_hand_follows_neither_scene_nor_light() {
        let mut document = Document { pupil: Some(Pupil::default()), ..document() };
        document.apply(Edit::ApertureDiameter(3.5));
        assert_eq!((document.lens.aperture_diameter_mm, document.pupil), (3.5, None));
        assert!(!document.automatic_lens);
        let preset = presets().into_iter().find(|preset| preset.screen.is_some()).expect("one has a display");
        document.apply(Edit::Lens(preset.lens));
        assert_eq!(Some(document.screen), preset.screen, "the display's light comes with the lens");
    }

    #[test]
    fn rows_of_a_batch_are_added_once() {
        let mut document = document();
        let methods = vec![MethodChoice::new("mipmap"), MethodChoice::new("separable")];
        document.apply(Edit::AddToBatch(methods.clone()));
        document.apply(Edit::AddToBatch(methods));
        assert_eq!(document.batch.len(), 2);
        document.apply(Edit::RemoveBatchRow(0));
        assert_eq!(document.batch.len(), 1);
        document.apply(Edit::ClearBatch);
        assert!(document.batch.is_empty());
    }
}
