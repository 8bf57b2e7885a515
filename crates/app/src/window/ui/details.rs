//! The second row of a pane's head: which difference, which texture, how opaque.

use crate::window::engine::channel_of;
use crate::window::model::{Channel, Difference, DifferenceKind, Inside, PaneId};
use crate::window::ui::widgets::combo;
use defocus::methods::Meaning;
use eframe::egui::{DragValue, Ui};

/// Which difference, and from which of the other panes.
pub fn difference_row(ui: &mut Ui, id: PaneId, difference: &mut Difference, others: &[(PaneId, String)]) {
    let names: Vec<&str> = DifferenceKind::ALL.iter().map(|(_, name)| *name).collect();
    let mut kind = DifferenceKind::ALL.iter().position(|(k, _)| *k == difference.kind).unwrap_or(0);
    let list = combo(ui, &format!("kind {id}"), &mut kind, &names, 84.0);
    list.accessible_name(format!("Kind of difference in pane {id}"));
    difference.kind = DifferenceKind::ALL[kind].0;
    let gains: Vec<String> = (0..=Difference::GREATEST_GAIN_LOG2).map(|log2| format!("{}x", 1_u32 << log2)).collect();
    let names: Vec<&str> = gains.iter().map(String::as_str).collect();
    let mut gain = usize::from(difference.gain_log2);
    let list = combo(ui, &format!("gain {id}"), &mut gain, &names, 52.0);
    list.accessible_name(format!("Gain of the difference in pane {id}")).on_hover_text("Stretches the colour scale");
    difference.gain_log2 = gain.min(names.len() - 1) as u8;
    ui.weak("from");
    let names: Vec<&str> = others.iter().map(|(_, name)| name.as_str()).collect();
    let mut other = others.iter().position(|(o, _)| *o == difference.against).unwrap_or(others.len());
    let width = (ui.available_width() - 8.0).clamp(40.0, 200.0);
    let list = combo(ui, &format!("against {id}"), &mut other, &names, width);
    list.accessible_name(format!("Difference in pane {id} from"));
    if let Some((against, _)) = others.get(other) {
        difference.against = *against;
    }
}

/// Greatest width of the list of textures, points: the longest name has room.
const TEXTURE_WIDTH: f32 = 260.0;

/// Width of a level's or layer's number with its gap, points.
const SLICE_WIDTH: f32 = 68.0;

/// Width of the opacity with its gap, points.
const OPACITY_WIDTH: f32 = 108.0;

/// Least width of the list of channels with its gaps, points.
const CHANNEL_WIDTH: f32 = 132.0;

/// A texture that a method exposes.
pub struct Exposed {
    /// Its name.
    pub name: String,
    /// Mipmap levels.
    pub levels: u32,
    /// Array layers.
    pub layers: u32,
    /// Channels.
    pub components: u8,
    /// What they mean.
    pub meaning: Meaning,
}

/// Which numbers of which texture.
pub fn inside_row(ui: &mut Ui, id: PaneId, inside: &mut Inside, opacity: &mut f32, exposed: &[Exposed]) {
    if exposed.is_empty() {
        ui.weak("nothing inside: everything is in focus, or the method has no steps");
        return;
    }
    let names: Vec<&str> = exposed.iter().map(|e| e.name.as_str()).collect();
    let before = exposed.iter().position(|e| e.name == inside.name).unwrap_or(0);
    let mut chosen = before;
    let width = (ui.available_width() - beside_texture(&exposed[before])).clamp(50.0, TEXTURE_WIDTH);
    let list = combo(ui, &format!("inside {id}"), &mut chosen, &names, width);
    list.accessible_name(format!("Texture in pane {id}")).on_hover_text("Intermediate textures of the method");
    let texture = &exposed[chosen];
    if chosen != before || inside.name.is_empty() {
        // What was shown of another texture means nothing in this one.
        *inside = Inside { name: texture.name.clone(), ..Inside::default() };
    }
    let number = |ui: &mut Ui, what: &str, value: &mut u32, count: u32| {
        if count > 1 {
            *value = (*value).min(count - 1);
            let drag = DragValue::new(value).range(0..=count - 1).prefix(format!("{what} ")).speed(0.05);
            let name = format!("Texture {what} in pane {id}");
            ui.add(drag).accessible_name(name).on_hover_text(format!("{what}, 0 to {}", count - 1));
        }
    };
    number(ui, "level", &mut inside.level, texture.levels);
    number(ui, "layer", &mut inside.layer, texture.layers);
    if channel_of(&texture.meaning, inside.channel.index(), u32::from(texture.components)).is_some() {
        opacity_drag(ui, id, opacity);
    }
    channel_list(ui, id, &mut inside.channel, texture);
}

/// Room that the inputs right of the list of textures take, points.
fn beside_texture(texture: &Exposed) -> f32 {
    let slices = [texture.levels, texture.layers].into_iter().filter(|count| *count > 1).count();
    SLICE_WIDTH * slices as f32 + OPACITY_WIDTH + CHANNEL_WIDTH
}

/// How much an overlay hides of the picture.
fn opacity_drag(ui: &mut Ui, id: PaneId, opacity: &mut f32) {
    let mut percent = (f64::from(*opacity) * 100.0).round();
    let drag = DragValue::new(&mut percent).range(0.0..=100.0).prefix("opacity ").suffix(" %").speed(1.0);
    let response = ui.add(drag).accessible_name(format!("Opacity in pane {id}"));
    if response.changed() {
        *opacity = (percent / 100.0) as f32;
    }
    response
        .on_hover_text("How much the overlay hides of the picture, which is grey under it; 100 % is the overlay alone");
}

/// Which numbers of the texture are shown, by their names where they have some.
fn channel_list(ui: &mut Ui, id: PaneId, channel: &mut Channel, texture: &Exposed) {
    let quantities = texture.meaning.quantities();
    let offered: Vec<(Channel, &str)> = match (quantities.len(), texture.components) {
        (0, 1) => vec![(Channel::Red, "R")],
        (0, _) => Channel::ALL.to_vec(),
        _ => Channel::ALL.iter().skip(1).zip(quantities).map(|((channel, _), q)| (*channel, q.name)).collect(),
    };
    let names: Vec<&str> = offered.iter().map(|(_, name)| *name).collect();
    let mut chosen = offered.iter().position(|(c, _)| c == channel).unwrap_or(0);
    let width = (ui.available_width() - 4.0).clamp(50.0, 120.0);
    let list = combo(ui, &format!("channel {id}"), &mut chosen, &names, width);
    list.accessible_name(format!("Channel in pane {id}")).on_hover_text("Which numbers of the texture are shown");
    *channel = offered[chosen].0;
}
