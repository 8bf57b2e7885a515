//! Everything that can be done by a name: menus, keys and the command palette share it.

use super::App;
use super::classroom::{UI_SCALES, scale_name};
use super::dialogs::Numbers;
use super::model::FocusMode;
use super::model::LESSONS;
use super::model::PictureKind;
use super::model::PictureSize;
use super::model::Theme;
use super::model::state;
use super::model::{Arrangement, Inside, MethodChoice, PaneId, Show};
use super::ui::panels::preset_label;
use defocus::presets::presets;
use defocus::stereo::{Layout, Stereo};
use defocus::{lens::Lens, methods};
use defocus_study::builtin;
use eframe::egui::{Context, Event, FocusDirection, Key, KeyboardShortcut, Modifiers};

/// Something to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Ask for a scene, an image or a state.
    Open,
    /// Open what this names.
    OpenNamed(String),
    /// Ask for a file to keep the state in.
    SaveState,
    /// Ask for a file for a pane's picture.
    SavePicture(PaneId, PictureKind),
    /// Ask for a file for the comparison of all panes.
    SaveReport,
    /// A pane's picture to the clipboard.
    CopyImage(PaneId),
    /// The command line that makes this picture to the clipboard.
    CopyCommand,
    /// Take back the last change.
    Undo,
    /// Make it again.
    Redo,
    /// Show or hide the command palette.
    Palette,
    /// Show or hide the sheet of keys.
    Help,
    /// One more pane.
    AddPane,
    /// A copy of a pane.
    Duplicate(PaneId),
    /// Take a pane away.
    ClosePane(PaneId),
    /// Two panes side by side: another one and the truth.
    Compare,
    /// How panes lie.
    Arrange(Arrangement),
    /// All panes side by side and the same size.
    ResetPanes,
    /// Make a pane A.
    ChooseA(PaneId),
    /// Make a pane B.
    ChooseB(PaneId),
    /// Exchange A and B.
    Swap,
    /// Give a pane a method.
    SetMethod(PaneId, String),
    /// All parameters of a pane's method as they were.
    ResetParams(PaneId),
    /// What a pane shows, by its place in the list.
    SetShow(PaneId, usize),
    /// Show what a pane's method tells of each pixel.
    LookInside(PaneId, Inside),
    /// Time the passes of pane A's method.
    TimePasses,
    /// Figures also without a pane that shows the reference.
    Measure,
    /// The whole picture, or pixel for pixel.
    ToggleZoom,
    /// This magnification.
    ZoomTo(f32),
    /// How large the picture is.
    SetSize(PictureSize),
    /// The camera as the scene has it.
    ResetCamera,
    /// A lens by its preset's name.
    SetLens(String),
    /// A lens that suits the scene.
    SuitLens,
    /// What decides where the lens is focused.
    SetFocusMode(FocusMode),
    /// Two eyes' pictures shown this way; one eye without.
    SetStereo(Option<Layout>),
    /// Light, dark, or as the system has it.
    SetTheme(Theme),
    /// Read shaders again whenever one is saved.
    WatchShaders,
    /// Ask what goes into figures for a paper.
    FiguresForPaper,
    /// Ask for a file for numbers.
    SaveNumbers(Numbers),
    /// Tell what every texture of the method under the pointer holds, or stop.
    Story,
    /// Show or hide the batch.
    Batch,
    /// Read the scene's file with so many metres a unit of length.
    ScaleScene(f64),
    /// A pane beside another that is drawn with the shaders as the program was built.
    CompareBuilds(PaneId),
    /// The picture alone with a strip of aperture and focus, or everything.
    TogglePanels,
    /// The window over the whole screen, or not.
    ToggleFullScreen,
    /// The interface so many times as large as it normally is.
    ScaleInterface(f32),
    /// Open the aperture by so many steps; close it by negative ones.
    NudgeAperture(i8),
    /// Focus nearer by so many steps, or farther by negative ones.
    NudgeFocus(i8),
    /// Begin the lesson of that place, from 0.
    Lesson(usize),
    /// Go on in the lessons by so many.
    StepLesson(i8),
    /// Back to what was shown before the lessons.
    EndLesson,
}

/// An action with its name for people.
pub struct Command {
    /// What it is called.
    pub name: String,
    /// The keys that do it.
    pub keys: Option<KeyboardShortcut>,
    /// What it does.
    pub action: Action,
}

const fn plain(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key))
}

const NUMBERS: [Key; 6] = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];

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

    /// Does it.
    pub fn perform(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::Open => self.dialogs.open(ctx),
            Action::OpenNamed(name) => self.open_anything(ctx, &name),
            Action::SaveState => self.dialogs.save_state(ctx, &self.document),
            Action::SavePicture(id, kind) => {
                let size = self.size_to_enlarge(id);
                self.dialogs.save_picture(ctx, &self.document, (id, kind), size);
            }
            Action::ScaleScene(metres) => self.scale_scene(ctx, metres),
            Action::SaveReport => self.dialogs.save_report(ctx, &self.document),
            Action::FiguresForPaper => self.ask_for_paper(),
            Action::SaveNumbers(numbers) => self.dialogs.save_numbers(ctx, &self.document, numbers),
            Action::Batch => self.toggle_batch(),
            Action::Story => {
                self.preferences.panels_hidden = false;
                self.inspector.toggle_story();
            }
            Action::CopyImage(id) => self.copy_image(ctx, id),
            Action::CopyCommand => {
                ctx.copy_text(state::command_text(&self.document, self.eye_size_px()));
                let missing = state::left_out(&self.document).join(", ");
                let missing = if missing.is_empty() { missing } else { format!(" It leaves out {missing}.") };
                self.messages.note(ctx, &format!("The command line is on the clipboard.{missing}"));
            }
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
            Action::Palette => self.palette.toggle(),
            Action::Help => self.help = !self.help,
            Action::SetTheme(theme) => self.preferences.theme = theme,
            Action::WatchShaders => self.preferences.reload_shaders = !self.preferences.reload_shaders,
            Action::TimePasses => self.engine.time_passes(self.document.a),
            Action::SetSize(size) => self.resize_picture(size),
            Action::ResetCamera => self.choose_camera(self.document.camera_index),
            Action::SetLens(name) => self.set_lens(&name),
            Action::SuitLens => self.suit_lens(),
            Action::SetFocusMode(mode) => self.document.focus.mode = mode,
            Action::SetStereo(layout) => {
                let known = self.document.stereo.unwrap_or_default();
                self.document.stereo = layout.map(|layout| Stereo { layout, ..known });
            }
            Action::TogglePanels
            | Action::ToggleFullScreen
            | Action::ScaleInterface(_)
            | Action::NudgeAperture(_)
            | Action::NudgeFocus(_)
            | Action::Lesson(_)
            | Action::StepLesson(_)
            | Action::EndLesson => self.perform_for_class(ctx, action),
            action => self.change_panes(action),
        }
    }

    fn change_panes(&mut self, action: Action) {
        let is_scene = self.engine.source().is_none_or(|s| s.source().is_scene());
        let document = &mut self.document;
        match action {
            Action::AddPane => {
                document.add_pane(document.method_to_add(is_scene));
                document.arrangement = Arrangement::Tiles;
            }
            Action::Duplicate(id) => {
                if let Some(state) = document.pane(id).cloned()
                    && let Some(copy) = document.add_pane(state.method)
                    && let Some(pane) = document.pane_mut(copy)
                {
                    (pane.show, pane.opacity) = (state.show, state.opacity);
                }
            }
            Action::Compare => {
                if document.panes.len() == 1 || (is_scene && document.reference().is_none()) {
                    document.add_pane(document.method_to_add(is_scene));
                }
                if let Some(reference) = document.reference().filter(|r| *r != document.a) {
                    document.b = reference;
                }
                document.arrangement = Arrangement::Tiles;
            }
            Action::CompareBuilds(id) => {
                if let Some(state) = document.pane(id).cloned()
                    && let Some(copy) = document.add_pane(MethodChoice { as_built: true, ..state.method })
                {
                    (document.a, document.b, document.arrangement) = (id, copy, Arrangement::Tiles);
                    self.preferences.reload_shaders = true;
                }
            }
            Action::ClosePane(id) => document.close_pane(id),
            Action::Arrange(arrangement) => document.arrangement = arrangement,
            Action::ResetPanes => (document.tiles, document.arrangement) = (None, Arrangement::Tiles),
            // Of several keys in one frame, an earlier one may have closed it.
            Action::ChooseA(id) | Action::ChooseB(id) if document.pane(id).is_none() => {}
            Action::ChooseA(id) if id == document.b => std::mem::swap(&mut document.a, &mut document.b),
            Action::ChooseA(id) => document.a = id,
            Action::ChooseB(id) if id == document.a => std::mem::swap(&mut document.a, &mut document.b),
            Action::ChooseB(id) => document.b = id,
            Action::Swap => std::mem::swap(&mut document.a, &mut document.b),
            Action::Measure => document.measure = !document.measure,
            Action::ToggleZoom => document.zoom.scale = if document.zoom.scale.is_none() { Some(1.0) } else { None },
            Action::ZoomTo(scale) => document.zoom.scale = Some(scale),
            Action::SetMethod(id, method) => {
                if let Some(pane) = document.pane_mut(id) {
                    let reference = method == "accumulation";
                    let as_built = pane.method.as_built;
                    pane.method = if reference { MethodChoice::reference() } else { MethodChoice::new(&method) };
                    pane.method.as_built = as_built;
                    // What the new method has too stays in sight.
                    let known = Inside::overlays(&pane.method);
                    if let Show::Inside(inside) = &mut pane.show
                        && known.iter().all(|(_, overlay)| overlay != inside)
                    {
                        *inside = Inside::default();
                    }
                }
            }
            Action::ResetParams(id) => {
                if let Some(pane) = document.pane_mut(id) {
                    pane.method = MethodChoice { as_built: pane.method.as_built, ..MethodChoice::new(&pane.method.id) };
                }
            }
            Action::SetShow(id, index) => self.set_show(id, index, is_scene),
            Action::LookInside(id, inside) => {
                if let Some(pane) = document.pane_mut(id) {
                    pane.show = Show::Inside(inside);
                }
            }
            _ => {}
        }
    }

    fn set_show(&mut self, id: PaneId, index: usize, is_scene: bool) {
        let document = &mut self.document;
        let other = |document: &super::model::Document| {
            let slots = [document.reference(), Some(document.a), Some(document.b)];
            slots.into_iter().flatten().find(|o| *o != id)
        };
        // A difference needs something to differ from.
        if index == 4 && other(document).is_none() {
            document.add_pane(document.method_to_add(is_scene));
        }
        if let Some(show) = Show::of_index(index, other(document))
            && let Some(pane) = document.pane_mut(id)
        {
            pane.show = show;
        }
    }

    fn set_lens(&mut self, name: &str) {
        let own = self.preferences.own_lenses.iter().cloned();
        if let Some(preset) = presets().into_iter().chain(own).find(|p| p.name == name) {
            let focus_distance_m = self.document.lens.focus_distance_m;
            let aperture = self.document.lens.aperture.clone();
            self.document.lens = Lens { focus_distance_m, aperture, ..preset.lens };
            self.document.automatic_lens = false;
        }
    }

    /// Does what the pressed keys stand for.
    pub(super) fn keys(&mut self, ctx: &Context) {
        if ctx.input(|i| i.key_pressed(Key::Escape)) {
            self.escape(ctx);
        }
        // While something is typed, only what is pressed together with Ctrl is for us; what
        // the text field itself takes (copy, undo) stays its own.
        let typing = ctx.egui_wants_keyboard_input();
        let mut commands = self.commands();
        // A shortcut also answers to more modifiers than it has: those with most come first.
        commands.sort_by_key(|c| std::cmp::Reverse(c.keys.map_or(0, |keys| modifiers(&keys))));
        for Command { keys, action, .. } in commands {
            let Some(keys) = keys else { continue };
            let is_texts_own = matches!(action, Action::Undo | Action::Redo | Action::CopyImage(_));
            if typing && (!keys.modifiers.command || is_texts_own) {
                continue;
            }
            if keys.logical_key == Key::Tab {
                self.panels_key(ctx, &keys, action);
            } else if ctx.input_mut(|i| i.consume_shortcut(&keys)) {
                self.perform(ctx, action);
            }
        }
        if !typing {
            self.special_keys(ctx);
        }
        self.viewport.set_blinking(!typing && ctx.input(|i| i.key_down(Key::B) && i.modifiers.is_none()));
    }

    /// Escape ends what is on top: a message, what is being opened, full screen, a lesson.
    fn escape(&mut self, ctx: &Context) {
        let is_asked = self.is_asking() || self.help;
        let is_busy = self.loader.loading().is_some() || self.messages.has_any();
        self.messages.dismiss();
        self.give_up_loading();
        self.help = false;
        if is_asked || is_busy {
            return;
        }
        if ctx.input(|i| i.viewport().fullscreen.unwrap_or(false)) {
            self.perform(ctx, Action::ToggleFullScreen);
        } else if self.lessons.is_on() {
            self.perform(ctx, Action::EndLesson);
        }
    }

    /// Whether something is being asked in a window of its own.
    fn is_asking(&self) -> bool {
        self.dialogs.is_open() || self.palette.is_open() || self.paper.is_open()
    }

    /// Tab goes from field to field where one has the focus; where none has, it hides or shows
    /// the panels.
    fn panels_key(&mut self, ctx: &Context, keys: &KeyboardShortcut, action: Action) {
        let is_free = ctx.memory(|memory| memory.focused().is_none()) && !self.is_asking();
        if is_free && ctx.input_mut(|i| i.consume_shortcut(keys)) {
            // The interface has seen the key before and would give the focus to its first field.
            ctx.memory_mut(|memory| memory.move_focus(FocusDirection::None));
            self.perform(ctx, action);
        }
    }

    /// Keys that arrive in another form than a shortcut.
    fn special_keys(&mut self, ctx: &Context) {
        let events = ctx.input(|i| i.events.clone());
        for event in events {
            match event {
                // Where "?" is typed with shift, the key itself is reported with it.
                Event::Text(text) if text == "?" => self.perform(ctx, Action::Help),
                // Ctrl+C arrives as what it means.
                Event::Copy => self.perform(ctx, Action::CopyImage(self.document.a)),
                // With shift a number key is called after its other sign, on some keyboards.
                Event::Key { key, physical_key: Some(physical), pressed: true, modifiers, .. }
                    if modifiers.shift_only() && key != physical =>
                {
                    let index = NUMBERS.iter().position(|number| *number == physical);
                    if let Some(pane) = index.and_then(|i| self.document.panes.get(i)) {
                        self.perform(ctx, Action::ChooseB(pane.id));
                    }
                }
                _ => {}
            }
        }
        if ctx.input_mut(|i| i.consume_shortcut(&KeyboardShortcut::new(Modifiers::COMMAND, Key::Y))) {
            self.perform(ctx, Action::Redo);
        }
    }
}

fn modifiers(keys: &KeyboardShortcut) -> u8 {
    u8::from(keys.modifiers.command) + u8::from(keys.modifiers.shift)
}
