//! What can be laid over a picture from inside methods, by its name: each is there, is
//! called so, and has values that a scene of three depths must have.

mod common;

use common::{front_camera, gpu, quad, scene, unlit};
use defocus::gpu::{Texture, download, download_depth};
use defocus::lens::Lens;
use defocus::methods::{self, Method, Mipmap, MipmapFilter, Quantity, Scale};
use defocus::present::{Place, Slice, slice_range};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DVec2, UVec2, Vec3, dvec2, uvec2, vec2};

const SIZE: UVec2 = uvec2(96, 64);
const OVERSCAN_PX: u32 = 8;

/// Points of the picture with the depths of what they show, metres: in front of the focus,
/// in focus and behind it, each well inside its surface.
const FRONT: (DVec2, f64) = (dvec2(0.9, 0.5), 1.0);
const FOCUS: (DVec2, f64) = (dvec2(0.1, 0.5), 2.0);
const BEHIND: (DVec2, f64) = (dvec2(0.6, 0.5), 8.0);

/// Surfaces at 1 m have c = -8 px, those at 8 m 6 px.
fn lens() -> Lens {
    common::lens(8.0, FOCUS.1)
}

fn view() -> View {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 2);
    let left = quad(2.0, vec2(-4.0, -4.0), vec2(-0.3, 4.0), 1);
    let right = quad(1.0, vec2(0.4, -2.0), vec2(2.0, 2.0), 0);
    let scene = scene(vec![wall, left, right], vec![unlit(Vec3::X), unlit(Vec3::Y), unlit(Vec3::Z)]);
    let surfaces = GpuScene::new(gpu(), &scene, SurfaceOptions::default());
    View::of_scene(surfaces, front_camera(), SIZE, OVERSCAN_PX).expect("a small scene can be drawn")
}

/// The values of one quantity of a texture that a method exposes, as the window reads them.
struct Shown {
    what: String,
    quantity: Quantity,
    texture: Texture,
    channel: usize,
    place: Place,
    range: [f32; 2],
}

impl Shown {
    fn of(method: &str, texture: &str, quantity: &str) -> Self {
        Self::by(methods::by_id(method).expect("the method is known"), texture, quantity)
    }

    fn by(method: Box<dyn Method>, texture: &str, quantity: &str) -> Self {
        let what = format!("{quantity} of {}", method.about().id);
        let mut view = view();
        let mut frame = gpu().frame();
        frame.keep_intermediates();
        methods::record(method.as_ref(), &mut frame, &mut view, &lens()).expect("it can be rendered");
        let exposed = frame.finish().exposed;
        let names: Vec<&str> = exposed.iter().map(|(name, _)| name.as_str()).collect();
        let at = names.iter().position(|name| *name == texture);
        let found = exposed[at.unwrap_or_else(|| panic!("{what}: no '{texture}' among {names:?}"))].1.clone();
        let meaning = methods::meaning(method.as_ref(), texture);
        let channel = meaning.quantities().iter().position(|q| q.name == quantity);
        let channel = channel.unwrap_or_else(|| panic!("{what}: not among {:?}", meaning.quantities()));
        let slice = Slice { texture: &found, level: 0, layer: 0 };
        let mut frame = gpu().frame();
        let range = slice_range(&mut frame, slice, channel as u32).expect("there are values");
        Self {
            what,
            quantity: meaning.quantities()[channel].clone(),
            place: Place::of(found.size(), SIZE, OVERSCAN_PX, method.texel_px(texture)),
            texture: found,
            channel,
            range,
        }
    }

    /// All values, row by row; of one of the first three channels.
    fn values(&self) -> Vec<f32> {
        match self.texture.format() {
            wgpu::TextureFormat::R32Float => download_depth(gpu(), &self.texture).pixels,
            _ => download(gpu(), &self.texture).pixels.iter().map(|p| p[self.channel]).collect(),
        }
    }

    /// The value that lies over a point of the picture.
    fn at(&self, (point, _): (DVec2, f64)) -> f32 {
        let size = self.texture.size();
        let texel = self.place.texel(size, SIZE, point).expect("the texture covers the picture");
        self.values()[(texel.y * size.x + texel.x) as usize]
    }

    fn is_within(&self, low: f32, high: f32) {
        let [least, greatest] = self.range;
        assert!(low <= least && greatest <= high, "{}: {:?} is not in {low} to {high}", self.what, self.range);
        assert!(least < greatest, "{}: three depths have one value, {least}", self.what);
    }

    fn is_whole(&self) {
        assert_eq!(self.quantity.scale, Scale::Whole, "{}", self.what);
        assert!(self.values().iter().all(|v| v.fract() == 0.0), "{}", self.what);
    }

    /// The name of the class at a point; every value must have one.
    fn class_at(&self, at: (DVec2, f64)) -> &'static str {
        let Scale::Classes(classes) = self.quantity.scale else { panic!("{} has no classes", self.what) };
        let name = |value: f32| classes.iter().find(|(v, _)| *v == value).map(|(_, name)| *name);
        let values = self.values();
        let nameless: Vec<f32> = values.iter().copied().filter(|v| name(*v).is_none()).collect();
        assert!(nameless.is_empty(), "{}: {nameless:?} have no name", self.what);
        name(self.at(at)).expect("all have names")
    }
}

const BLUR: &str = "blur and level of each pixel";

fn mipmap_as_printed() -> Box<dyn Method> {
    Box::new(Mipmap { filter: MipmapFilter::AsPrinted as usize, ..Mipmap::default() })
}

fn coc_px((_, depth_m): (DVec2, f64)) -> f32 {
    lens().coc_diameter_px(depth_m) as f32
}

/// Half a step of f16's 11 bits, and what stored depth in f32 adds.
fn is_close(value: f32, expected: f32) -> bool {
    (value - expected).abs() <= 1e-3 * expected.abs() + 1e-3
}

#[test]
fn signed_coc_and_degrees_of_blur() {
    let (coc, dob) = (Shown::of("mipmap", BLUR, "CoC"), Shown::of("mipmap", BLUR, "DoB"));
    for at in [FRONT, FOCUS, BEHIND] {
        assert!(is_close(coc.at(at), coc_px(at)), "{} in place of {}", coc.at(at), coc_px(at));
        assert!(is_close(dob.at(at), 0.5 * coc_px(at).abs()), "sigma = C / 2, not {}", dob.at(at));
    }
    dob.is_within(0.0, 0.5 * coc_px(FRONT).abs() + 0.01);
    let covered = Shown::of("mipmap", BLUR, "covered by foreground");
    covered.is_within(0.0, 1.0);
    assert_eq!(covered.at(FOCUS), 0.0, "far from the foreground nothing of it is seen");
    let smoothed = Shown::by(mipmap_as_printed(), BLUR, "smoothed DoB");
    smoothed.is_within(0.0, 0.5 * coc_px(FRONT).abs() + 0.01);
    assert!(is_close(smoothed.at(FOCUS), 0.0), "what is in focus and far from the foreground stays sharp");
    // Beside the foreground, on the wall behind it, the blur is smoothed towards its own.
    let differ = smoothed.values().iter().zip(dob.values()).filter(|(s, d)| (*s - *d).abs() > 0.05).count();
    assert!(differ > 20, "only {differ} pixels are smoothed");
    let neighbourhood = Shown::by(mipmap_as_printed(), "CoC, DoB, DoN", "DoN");
    neighbourhood.is_within(0.0, 0.5 * coc_px(FRONT).abs() + 0.01);
    assert!(is_close(neighbourhood.range[1], 0.5 * coc_px(FRONT).abs()), "at its edge the foreground is a neighbour");
    assert_eq!(neighbourhood.at(FOCUS), 0.0, "far from nearer surfaces there is none");
}

#[test]
fn mipmap_levels() {
    for method in [methods::by_id("mipmap").expect("the method is known"), mipmap_as_printed()] {
        let level = Shown::by(method.clone(), BLUR, "mipmap level");
        let lens = lens();
        let greatest_px = [FRONT, FOCUS, BEHIND].map(|at| f64::from(coc_px(at).abs())).into_iter().fold(0.0, f64::max);
        let levels = Mipmap::default().levels(&lens, greatest_px) + 1;
        // Level 0 is the image, level 1 the pyramid's first.
        level.is_within(0.0, levels as f32);
    }
}

#[test]
fn layers_sub_images_and_slabs() {
    let layers = Shown::of("splat", "layers of each pixel", "layers seen");
    assert_eq!(layers.class_at(FOCUS), "at");
    assert!(layers.values().iter().any(|v| *v > 0.0), "at edges more than one layer is seen");
    Shown::of("adaptive", "mean layer hit, white the fourth", "layer hit").is_within(0.0, 3.0);
    for method in ["pyramid", "opaque"] {
        let sub_image = Shown::of(method, "sub-image of each pixel", "sub-image index");
        sub_image.is_whole();
        sub_image.is_within(-12.0, 12.0);
        assert!(sub_image.at(FRONT) < 0.0 && sub_image.at(BEHIND) > 0.0, "{method}");
        assert_eq!(sub_image.at(FOCUS), 0.0, "{method}");
    }
    let slab = Shown::of("multiview", "slabs of each pixel", "slab index");
    let depths = Shown::of("multiview", "slab depth", "near / depth");
    slab.is_whole();
    slab.is_within(0.0, (depths.texture.layers() - 1) as f32);
    assert!(slab.at(FRONT) < slab.at(FOCUS) && slab.at(FOCUS) < slab.at(BEHIND), "slabs are counted from the front");
}

#[test]
fn tile_classes_say_what_was_skipped() {
    for (method, in_focus, blurred) in [
        ("mipmap", "in focus: copied", "levels alone: image skipped"),
        ("multiview", "in focus: copied, no rays", "traced"),
        ("adaptive", "in focus: copied", "traced"),
    ] {
        let class = Shown::of(method, "tile class: what was skipped", "tile class");
        assert_eq!(class.texture.size(), SIZE / 8, "{method}: a number for each tile of 8 px");
        assert_eq!(class.class_at(FOCUS), in_focus, "{method}");
        // At the foreground's edge, which is blurred by many pixels.
        let edge = (dvec2(0.75, 0.5), 0.0);
        assert_eq!(class.class_at(edge), blurred, "{method}");
    }
}

#[test]
fn what_methods_say_they_explain_they_expose_with_names() {
    for method in methods::all() {
        let id = method.about().id;
        for texture in method.explains() {
            let meaning = methods::meaning(method.as_ref(), texture);
            let quantity = meaning.quantities().first().unwrap_or_else(|| panic!("{id}: '{texture}' has no numbers"));
            // Fails with the names that there are.
            Shown::of(id, texture, quantity.name);
        }
    }
}
