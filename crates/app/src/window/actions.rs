//! Does what is chosen in menus, by keys and in the command palette.

use super::App;
use super::action::{Action, Command};
use super::commands::NUMBERS;
use super::model::state;
use super::model::{Arrangement, Document, Edit, FocusSettings, Inside, MethodChoice, PaneId, Show};
use defocus::lens::Lens;
use defocus::presets::presets;
use defocus::stereo::Stereo;
use eframe::egui::{Context, Event, FocusDirection, Key, KeyboardShortcut, Modifiers};

impl App {
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
            Action::Kernel => self.show_kernel(),
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
            Action::PlayAnimation => self.toggle_animation(),
            Action::Edit(edit) => self.edit(edit),
            Action::Prefer(preference) => self.preferences.apply(preference),
            Action::OpenAperture => self.dialogs.open_aperture(ctx),
            Action::SetTheme(theme) => self.preferences.theme = theme,
            Action::WatchShaders => self.preferences.reload_shaders = !self.preferences.reload_shaders,
            Action::TimePasses => self.engine.time_passes(self.document.a),
            Action::SetSize(size) => self.resize_picture(size),
            Action::ResetCamera => self.choose_camera(self.document.camera_index),
            Action::SetLens(name) => self.set_lens(&name),
            Action::SuitLens => self.suit_lens(),
            Action::SetFocusMode(mode) => self.edit(Edit::Focus(FocusSettings { mode, ..self.document.focus })),
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

    /// Changes one part of what is shown, as a panel or the pointer asks for it.
    pub(super) fn edit(&mut self, edit: Edit) {
        let mode = self.document.focus.mode;
        // A focus that is set by hand goes nowhere by itself.
        let is_refocused = matches!(edit, Edit::FocusDistance(_) | Edit::Lesson(..));
        self.document.apply(edit);
        if is_refocused || self.document.focus.mode != mode {
            self.focus_motion.stop();
        }
    }

    /// Does all that was asked for, in its order.
    pub(super) fn perform_all(&mut self, ctx: &Context, actions: impl IntoIterator<Item = Action>) {
        actions.into_iter().for_each(|action| self.perform(ctx, action));
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
        let other = |document: &Document| {
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
            let Lens { focus_distance_m, aperture, .. } = self.document.lens.clone();
            self.edit(Edit::Lens(Lens { focus_distance_m, aperture, ..preset.lens }));
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
