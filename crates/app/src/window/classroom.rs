//! The window before a class: hidden panels, full screen, large text, and lessons.

use super::App;
use super::action::Action;
use super::model::{Document, Edit, LESSONS, Lesson, Optics};
use super::ui::panels::{LessonAction, LessonView, StripAction, StripView, lesson_card, strip};
use defocus::camera::Camera;
use defocus::focus::{dioptres, metres};
use defocus::lens::Lens;
use defocus::presets;
use eframe::egui::{Context, Frame, Margin, Panel, Ui, ViewportCommand};

/// A key makes E so many times larger or smaller.
const APERTURE_STEP: f64 = 1.1;

/// E from which a closed aperture is opened, mm.
const LEAST_APERTURE_MM: f64 = 0.05;

/// A key moves the focus by so many dioptres: half of what is seen as blur.
const FOCUS_STEP_D: f64 = 0.1;

/// The lesson that is shown.
#[derive(Default)]
pub struct Lessons {
    at: Option<usize>,
    /// What was shown before the first one.
    before: Option<Box<Document>>,
    /// Whether camera and lens are still to be chosen for the scene that is being opened.
    unprepared: bool,
}

impl Lessons {
    /// Whether a lesson is shown.
    pub fn is_on(&self) -> bool {
        self.at.is_some()
    }

    fn lesson(&self) -> Option<(usize, &'static Lesson)> {
        let index = self.at?;
        Some((index, LESSONS.get(index)?))
    }
}

impl App {
    /// The lesson that is shown, from 0.
    pub fn lesson(&self) -> Option<usize> {
        self.lessons.at
    }

    /// Does what belongs to a class.
    pub(super) fn perform_for_class(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::TogglePanels => self.preferences.panels_hidden = !self.preferences.panels_hidden,
            Action::ToggleFullScreen => {
                let is_full = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!is_full));
            }
            Action::ScaleInterface(scale) => ctx.set_zoom_factor(scale.clamp(0.5, 4.0)),
            Action::NudgeAperture(steps) => self.nudge_aperture(f64::from(steps)),
            Action::NudgeFocus(steps) => self.nudge_focus(f64::from(steps)),
            Action::Lesson(index) => self.start_lesson(index),
            Action::StepLesson(by) => {
                if let Some(at) = self.lessons.at {
                    self.start_lesson(at.saturating_add_signed(by as isize).min(LESSONS.len() - 1));
                }
            }
            Action::EndLesson => self.end_lesson(),
            _ => {}
        }
    }

    fn nudge_aperture(&mut self, steps: f64) {
        let opened = self.document.lens.aperture_diameter_mm.max(LEAST_APERTURE_MM) * APERTURE_STEP.powf(steps);
        self.edit(Edit::ApertureDiameter(if opened < LEAST_APERTURE_MM { 0.0 } else { opened.min(1e4) }));
    }

    fn nudge_focus(&mut self, steps: f64) {
        let lens = &self.document.lens;
        let nearest_d = 0.99 * defocus::lens::MM_PER_M / lens.focal_length_mm.max(1e-3);
        let focus_d = (dioptres(lens.focus_distance_m) + FOCUS_STEP_D * steps).clamp(0.0, nearest_d);
        // The last step goes to infinity, and not to a kilometre.
        let focus_m = metres(if focus_d < 0.01 * FOCUS_STEP_D { 0.0 } else { focus_d });
        self.edit(Edit::FocusDistance(focus_m));
    }

    fn start_lesson(&mut self, index: usize) {
        let Some(lesson) = LESSONS.get(index) else { return };
        if self.lessons.at.is_none() {
            self.lessons.before = Some(Box::new(self.document.clone()));
        }
        self.lessons.at = Some(index);
        self.lessons.unprepared = true;
        self.focus_motion.stop();
        self.viewport.hint = false;
        self.document = lesson.document();
        self.prepare_lesson();
    }

    fn end_lesson(&mut self) {
        if let Some(before) = self.lessons.before.take() {
            self.document = *before;
            self.focus_motion.stop();
        }
        self.lessons = Lessons::default();
    }

    /// Chooses camera and lens of a lesson once its scene is there.
    pub(super) fn prepare_lesson(&mut self) {
        if !self.lessons.unprepared || !self.shows_what_is_named() {
            return;
        }
        let Some((_, lesson)) = self.lessons.lesson() else { return };
        self.lessons.unprepared = false;
        self.choose_camera(0);
        if let (Some(fov_deg), Some(camera)) = (lesson.fov_deg, &mut self.document.camera) {
            *camera = Camera { fov_y: fov_deg.to_radians(), aspect: None, ..*camera };
        }
        let Some(suitable) = self.suitable_lens() else { return };
        let focus_m = lesson.focus_m.unwrap_or(suitable.focus_distance_m);
        let lens = match lesson.optics {
            Optics::MeanCoc(mean_px) => {
                let lens = Lens { focus_distance_m: focus_m, ..suitable };
                let (camera, size) = (self.document.camera, self.eye_size_px());
                self.engine.lens_with_mean_coc(camera, size, &lens, mean_px).unwrap_or(lens)
            }
            Optics::Preset(name, aperture_diameter_mm) => match presets::preset(name) {
                Ok(preset) => Lens { aperture_diameter_mm, focus_distance_m: focus_m, ..preset.lens },
                Err(_) => suitable,
            },
        };
        self.document.lens = lesson.lens(lens);
        self.document.pivot_m = focus_m;
        self.document.automatic_lens = false;
    }

    /// The card of the lesson, and the strip of aperture and focus where panels are hidden.
    pub(super) fn class_bars(&mut self, ui: &mut Ui) {
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(12, 8));
        if let Some((index, lesson)) = self.lessons.lesson() {
            let value = lesson.dragged.value(&self.document);
            let view = LessonView { lesson, index, of: LESSONS.len(), value };
            let shown = Panel::bottom("lesson").frame(frame).show(ui, |ui| lesson_card(ui, &view));
            match shown.inner {
                Some(LessonAction::Go(index)) => self.perform(ui.ctx(), Action::Lesson(index)),
                Some(LessonAction::End) => self.perform(ui.ctx(), Action::EndLesson),
                Some(LessonAction::Drag(value)) => self.edit(Edit::Lesson(lesson.dragged, value)),
                None => {}
            }
        }
        if self.preferences.panels_hidden {
            let view = self.strip_view();
            let shown = Panel::bottom("strip").frame(frame).show(ui, |ui| strip(ui, view));
            self.take_strip(ui.ctx(), shown.inner);
        }
    }

    fn strip_view(&mut self) -> StripView {
        let lens = self.document.lens.clone();
        let depths = self.engine.depths_m(false);
        let mean_coc_px = depths.and_then(|d| lens.coc_statistics(d.iter().copied())).map(|coc| coc.mean_px);
        let acceptable_px = f64::from(self.document.acceptable_coc_px);
        let sharp_m = lens.check().is_ok().then(|| lens.depth_of_field_m(acceptable_px));
        StripView { aperture_mm: lens.aperture_diameter_mm, focus_m: lens.focus_distance_m, mean_coc_px, sharp_m }
    }

    fn take_strip(&mut self, ctx: &Context, action: Option<StripAction>) {
        match action {
            Some(StripAction::Aperture(mm)) => self.edit(Edit::ApertureDiameter(mm)),
            Some(StripAction::Focus(focus_m)) => self.edit(Edit::FocusDistance(focus_m)),
            Some(StripAction::ShowPanels) => self.perform(ctx, Action::TogglePanels),
            None => {}
        }
    }
}
