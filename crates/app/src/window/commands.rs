//! Everything that can be done by a name: menus, keys and the command palette share it.

use super::App;
use super::action::{Action, Command};
use super::model::Numbers;
use super::model::{
    Arrangement, FocusMode, Inside, LESSONS, PictureKind, PictureSize, Show, Theme, UI_SCALES, scale_name,
};
use super::ui::panels::preset_label;
use defocus::methods;
use defocus::presets::presets;
use defocus::stereo::Layout;
use defocus_study::builtin;
use eframe::egui::{Key, KeyboardShortcut, Modifiers};

const fn plain(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key))
}

/// Keys of the panes.
pub const NUMBERS: [Key; 6] = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];

impl App {
    /// Everything that can be done now; those with keys first.
    pub fn commands(&self) -> Vec<Command> {
        let a = self.document.a;
        let command = |name: &str, keys, action| Command { name: name.into(), keys, action };
        let coc = if self.document.pane(a).is_some_and(|p| p.show == Show::Coc) { 0 } else { 1 };
        let mut commands = vec![
            command("Open scene, image or state…", ctrl(Key::O), Action::Open),
            command("Save state…", ctrl(Key::S), Action::SaveState),
            command("Save picture as PNG…", ctrl(Key::E), Action::SavePicture(a, PictureKind::Png)),
            command("Save picture as EXR…", ctrl_shift(Key::E), Action::SavePicture(a, PictureKind::Exr)),
            command("Save comparison as HTML…", ctrl(Key::R), Action::SaveReport),
            command("Figures for a paper…", None, Action::FiguresForPaper),
            command("Save figures as CSV…", None, Action::SaveNumbers(Numbers::FiguresCsv)),
            command("Save figures as JSON…", None, Action::SaveNumbers(Numbers::FiguresJson)),
            command("Save CoC against depth as CSV…", None, Action::SaveNumbers(Numbers::Coc)),
            command("Batch: a table of states to run", None, Action::Batch),
            command("Copy image", ctrl(Key::C), Action::CopyImage(a)),
            command("Copy as command", ctrl_shift(Key::K), Action::CopyCommand),
            command("Undo", ctrl(Key::Z), Action::Undo),
            command("Redo", ctrl_shift(Key::Z), Action::Redo),
            command("Command palette", ctrl(Key::P), Action::Palette),
            command("Keys and mouse", None, Action::Help),
            command("Compare with the reference", plain(Key::V), Action::Compare),
            command("Add pane", plain(Key::N), Action::AddPane),
            command("Close pane A", plain(Key::Delete), Action::ClosePane(a)),
            command("Next arrangement: one, wipe, tiles", plain(Key::T), Action::Arrange(self.next_arrangement())),
            command("Swap panes A and B", plain(Key::X), Action::Swap),
            command("Circle of confusion", plain(Key::C), Action::SetShow(a, coc)),
            command("Fit picture or pixel for pixel", plain(Key::Z), Action::ToggleZoom),
            command("Camera as the scene has it", plain(Key::R), Action::ResetCamera),
            command("Figures against the reference", plain(Key::M), Action::Measure),
            command("Story of the pixel under the pointer", plain(Key::I), Action::Story),
            command("Open the aperture", plain(Key::Period), Action::NudgeAperture(1)),
            command("Close the aperture", plain(Key::Comma), Action::NudgeAperture(-1)),
            command("Focus nearer", plain(Key::K), Action::NudgeFocus(1)),
            command("Focus farther", plain(Key::L), Action::NudgeFocus(-1)),
            command("Play or stop the animation", plain(Key::Space), Action::PlayAnimation),
            command("Full screen", plain(Key::F11), Action::ToggleFullScreen),
            command("Hide or show the panels", plain(Key::Tab), Action::TogglePanels),
        ];
        if self.lessons.is_on() {
            commands.push(command("Next lesson", plain(Key::PageDown), Action::StepLesson(1)));
            commands.push(command("Lesson before", plain(Key::PageUp), Action::StepLesson(-1)));
            commands.push(command("End lesson", None, Action::EndLesson));
        }
        for (pane, key) in self.document.panes.iter().zip(NUMBERS) {
            let number = self.document.index_of(pane.id).map_or(0, |i| i + 1);
            let title = pane.method.title();
            commands.push(command(&format!("Pane {number} as A: {title}"), plain(key), Action::ChooseA(pane.id)));
            let shift = Some(KeyboardShortcut::new(Modifiers::SHIFT, key));
            commands.push(command(&format!("Pane {number} as B: {title}"), shift, Action::ChooseB(pane.id)));
        }
        commands.extend(self.further_commands());
        commands
    }

    /// What has no keys of its own.
    fn further_commands(&self) -> Vec<Command> {
        let a = self.document.a;
        let command = |name: String, action| Command { name, keys: None, action };
        let mut commands = vec![
            command("Even panes".into(), Action::ResetPanes),
            command("Duplicate pane A".into(), Action::Duplicate(a)),
            command("Default parameters of pane A".into(), Action::ResetParams(a)),
            command("Lens that suits the scene".into(), Action::SuitLens),
            command("Reload shaders on save".into(), Action::WatchShaders),
            command("Compare pane A with its shaders as built".into(), Action::CompareBuilds(a)),
            command("Time the passes of pane A".into(), Action::TimePasses),
            command("Point spread function of pane A".into(), Action::Kernel),
        ];
        let units = [("metres", 1.0), ("centimetres", 0.01), ("millimetres", 0.001), ("inches", 0.0254)];
        commands.extend(units.map(|(name, m)| command(format!("Scene's file in {name}"), Action::ScaleScene(m))));
        let lessons = LESSONS.iter().enumerate();
        let lessons = lessons.map(|(i, lesson)| (format!("Lesson {}: {}", i + 1, lesson.title), Action::Lesson(i)));
        commands.extend(lessons.map(|(name, action)| command(name, action)));
        commands.extend(UI_SCALES.map(|scale| command(scale_name(scale), Action::ScaleInterface(scale))));
        let arrangements = Arrangement::ALL.iter();
        commands
            .extend(arrangements.map(|(to, name, _)| command(format!("Arrangement: {name}"), Action::Arrange(*to))));
        let zooms = [1.0, 2.0, 4.0, 8.0, 16.0];
        commands.extend(zooms.map(|zoom| command(format!("Zoom {}00 %", zoom as u32), Action::ZoomTo(zoom))));
        let sizes = PictureSize::offered().into_iter();
        commands.extend(sizes.map(|(name, size)| command(format!("Picture size: {name}"), Action::SetSize(size))));
        // The circle of confusion has an entry of its own, with a key.
        let shows = Show::NAMES.iter().enumerate().filter(|(i, _)| *i != 1);
        commands.extend(shows.map(|(i, name)| command(format!("Show: {name}"), Action::SetShow(a, i))));
        let overlays = self.document.pane(a).map_or_else(Vec::new, |pane| Inside::overlays(&pane.method));
        let overlay = |(name, inside)| command(format!("Overlay: {name}"), Action::LookInside(a, inside));
        commands.extend(overlays.into_iter().map(overlay));
        let about = methods::all().into_iter().map(|m| m.about());
        commands.extend(about.map(|m| command(format!("Method: {}", m.title), Action::SetMethod(a, m.id.into()))));
        let scenes = builtin::all().iter().map(|b| b.name).chain(builtin::pictures().iter().map(|p| p.name));
        commands.extend(scenes.map(|name| command(format!("Scene: {name}"), Action::OpenNamed(name.into()))));
        let lenses = presets().into_iter().chain(self.preferences.own_lenses.iter().cloned());
        commands.extend(
            lenses.map(|p| command(format!("Lens: {}, {}", preset_label(&p), p.title), Action::SetLens(p.name))),
        );
        let modes = FocusMode::ALL.iter();
        commands.extend(modes.map(|(mode, name, _)| command(format!("Focus: {name}"), Action::SetFocusMode(*mode))));
        let layouts = Layout::ALL.iter().map(|(layout, name)| (format!("Stereo: {name}"), Some(*layout)));
        let layouts = layouts.chain([("Stereo: off".to_owned(), None)]);
        commands.extend(layouts.map(|(name, layout)| command(name, Action::SetStereo(layout))));
        let recent = self.preferences.recent.iter().map(|file| file.to_string_lossy().into_owned());
        commands.extend(recent.map(|file| command(format!("Recent: {file}"), Action::OpenNamed(file))));
        let themes = [("as the system has it", Theme::System), ("light", Theme::Light), ("dark", Theme::Dark)];
        commands.extend(themes.map(|(name, theme)| command(format!("Theme: {name}"), Action::SetTheme(theme))));
        commands
    }

    fn next_arrangement(&self) -> Arrangement {
        match self.document.arrangement {
            Arrangement::One => Arrangement::Wipe,
            Arrangement::Wipe => Arrangement::Tiles,
            Arrangement::Tiles => Arrangement::One,
        }
    }
}
