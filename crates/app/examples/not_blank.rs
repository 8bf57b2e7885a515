//! `not_blank PICTURE`: fails unless a PNG shows something: many colours, and light and
//! dark in its middle. Used to check the screenshot of the window.

use std::collections::HashSet;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: not_blank PICTURE")?;
    let image = image::open(&path)?.to_rgb8();
    let (width, height) = image.dimensions();
    let middle = image::imageops::crop_imm(&image, width / 4, height / 4, width / 2, height / 2).to_image();
    let colors: HashSet<[u8; 3]> = middle.pixels().map(|p| p.0).collect();
    let luma = |p: &image::Rgb<u8>| p.0.iter().map(|c| u32::from(*c)).sum::<u32>() / 3;
    let (darkest, lightest) = middle.pixels().map(luma).fold((255, 0), |(low, high), l| (low.min(l), high.max(l)));
    println!("{path}: {width}x{height}, {} colours in the middle, luma {darkest} to {lightest}", colors.len());
    if colors.len() < 1000 || lightest - darkest < 100 {
        return Err("the picture is blank: no scene shows in its middle".into());
    }
    Ok(())
}
