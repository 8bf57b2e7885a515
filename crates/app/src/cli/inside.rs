//! `render --inside`: what a method makes on its way, an image each.

use super::output::print;
use super::progress::check_interrupt;
use anyhow::Context;
use defocus::image_io::write_png_rgb;
use defocus::methods::{Quantity, Scale};
use defocus_study::InsideImage;
use std::path::Path;

/// Writes the images into `folder`, which is made if it is not there, and says, unless
/// `quiet`, what each holds.
pub fn write(folder: &Path, images: &[InsideImage], quiet: bool) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot make this folder", folder.display()))?;
    for image in images {
        check_interrupt()?;
        let file = folder.join(file_name(image));
        write_png_rgb(&file, &image.image)?;
        if !quiet {
            print(&format!("{}: {}", file.display(), content(image)))?;
        }
    }
    Ok(())
}

/// The texture's number and name, then layer and channel where there are several.
fn file_name(image: &InsideImage) -> String {
    let layer = image.layer.map_or(String::new(), |layer| format!(" layer {layer}"));
    let quantity = image.numbers.as_ref().filter(|_| image.channel.is_some());
    let quantity = quantity.map_or(String::new(), |(quantity, _)| format!(" {}", quantity.name));
    let text = format!("{:02} {}{layer}{quantity}", image.index, image.texture);
    let words: Vec<&str> = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    words.join("-") + ".png"
}

fn content(image: &InsideImage) -> String {
    let Some((quantity, [low, high])) = &image.numbers else { return "a picture".into() };
    if let Scale::Classes(classes) = quantity.scale {
        let names: Vec<&str> = classes.iter().map(|(_, name)| *name).collect();
        return format!("{}: {}", quantity.name, names.join("; "));
    }
    let value = |Quantity { one, unit, .. }: &Quantity, stored: f32| format!("{}{unit}", stored * one);
    format!("{}: {} to {}", quantity.name, value(quantity, *low), value(quantity, *high))
}
