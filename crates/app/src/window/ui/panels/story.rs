//! The story of a pixel as a list: each texture that the method makes, and what it holds there.

use crate::window::engine::{Story, StoryLine};
use crate::window::model::numbers::{quantity_text, significant};
use defocus::methods::{Meaning, Quantity};
use eframe::egui::{Label, RichText, ScrollArea, Ui};

/// Height of the list, points; longer ones scroll.
const HEIGHT: f32 = 260.0;

/// Shows the story of the pixel that was pointed at last in the pane called `title`.
pub fn story_panel(ui: &mut Ui, title: &str, story: Option<&Story>) {
    let Some(story) = story else {
        ui.weak("Point at a picture: every texture that its method makes is read there.");
        return;
    };
    ui.label(RichText::new(format!("On its way through {title}")).small().strong());
    if story.divisor > 1 {
        let text =
            format!("Of the picture drawn at 1/{}: the whole takes longer than the interface can wait.", story.divisor);
        ui.add(Label::new(RichText::new(text).small().color(ui.visuals().warn_fg_color)).wrap());
    }
    if story.lines.is_empty() {
        ui.weak("Nothing inside: everything is in focus, or the method has no steps.");
        return;
    }
    let list = ScrollArea::vertical().id_salt("story").max_height(HEIGHT).min_scrolled_height(HEIGHT);
    list.auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        let mut before: Option<&str> = None;
        for line in &story.lines {
            if before != Some(line.texture.as_str()) {
                ui.add_space(4.0);
                ui.add(Label::new(RichText::new(&line.texture).small().strong()).wrap());
            }
            before = Some(&line.texture);
            ui.add(Label::new(RichText::new(place_text(line)).small().weak()).wrap());
            ui.add(Label::new(RichText::new(values_text(line)).small().monospace()).wrap());
        }
    });
}

/// Which texel of which slice it is: "level 2, layer 1, tile 12, 7 of 16 px".
pub fn place_text(line: &StoryLine) -> String {
    let slice = [("level", line.level), ("layer", line.layer)];
    let mut parts: Vec<String> =
        slice.into_iter().filter_map(|(what, index)| Some(format!("{what} {}", index?))).collect();
    let (x, y) = (line.texel.x, line.texel.y);
    parts.push(match line.texel_px > 1.01 {
        true => format!("tile {x}, {y} of {} px", significant(f64::from(line.texel_px))),
        false => format!("texel {x}, {y}"),
    });
    parts.join(", ")
}

/// The numbers by their names where they have some.
pub fn values_text(line: &StoryLine) -> String {
    let number = |v: &f32| quantity_text(&Quantity::default(), *v);
    match &line.meaning {
        Meaning::Numbers(quantities) if !quantities.is_empty() => {
            let named = quantities.iter().zip(line.values);
            let told = named.map(|(quantity, value)| format!("{} {}", quantity.name, quantity_text(quantity, value)));
            told.collect::<Vec<_>>().join(" · ")
        }
        _ => {
            let count = (line.channels as usize).clamp(1, 4);
            let names = ["r", "g", "b", "a"];
            let told = line.values.iter().take(count).zip(names);
            let told = told.map(|(v, name)| if count == 1 { number(v) } else { format!("{name} {}", number(v)) });
            told.collect::<Vec<_>>().join("  ")
        }
    }
}
