//! `pyramid`: sub-images with disocclusion, each blurred by a pyramid.
//!
//! Kraus and Strengert, "Depth-of-Field Rendering by Pyramidal Image Processing"
//! (Eurographics 2007), as Kraus 2011 and Lee, Kim and Choi (TVCG 2009) describe it. Blurred
//! edges of near sub-images become transparent, so what they hide must be made up:
//!
//! 1. culling: pixels in front of the sub-image are dropped;
//! 2. disocclusion: colour and depth of the dropped are filled by pull-push, from the pixels
//!    kept around them; beyond the image's border they are extrapolated the same way;
//! 3. matte by omega_i, blur by a pyramid of |i| levels (`subimages.rs`);
//! 4. blending with "over".
//!
//! It differs from `opaque` in steps 1 and 2, in the place of the glow.
//!
//! The rising ramp of omega_i is the culling's weight and the falling one the matte's: a
//! pixel that is half in front of a sub-image is half replaced, and nothing pops as the
//! focus moves.
//!
//! **Brightness.** TVCG 2009, section 7.1, finds this method's images too bright "from the
//! repeated inclusion of identical pixels into multiple layers". Here colours are divided by
//! the opacity reached, so that flat colours stay what they are; `repeated_inclusion` brings
//! the excess back.

use super::subimages::{self, Spacing, SubImages, Wanted, box_groups, image_blocks};
use super::{About, Apertures, Meaning, Method, MethodError, Param};
use crate::gpu::{Frame, Pass, Shader, Texture};
use crate::lens::Lens;
use crate::view::{Layer, View};
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/pyramid");

/// Levels of pull-push beyond the one at which half the image is a texel: by then every
/// texel has met a known one.
const LEVELS_TO_MEET: u32 = 2;

/// Texels of a level, of one layer, that a single workgroup fills with all coarser levels in about
/// the time that a dispatch takes to start: 16 for each of its invocations.
const FEW_TEXELS: u32 = 4096;

uniform! {
    struct Filling {
        finest: u32,
        coarsest: u32,
        texels: u32,
        first_stored: u32,
    }
}

/// Sub-images with disocclusion.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    /// Where sub-images lie.
    pub spacing: Spacing,
    /// Share, 0 to 1, of the light behind a sub-image that is added although covered; 0 is
    /// correct.
    pub repeated_inclusion: f32,
}

impl Method for Pyramid {
    fn about(&self) -> About {
        About {
            id: "pyramid",
            title: "Pyramidal sub-images",
            paper: "Kraus and Strengert, Depth-of-Field Rendering by Pyramidal Image Processing, Eurographics 2007",
            summary: "Blurs sub-images by depth with pyramids, after filling what nearer ones hide from the pixels around.",
            limits: "What is filled in is smooth. Pixels lie in several sub-images, so that blurred objects are a little too wide and opaque, and what is in focus shows up to 4 px beyond its edge over what is blurred behind it (Kraus 2011, Fig. 2). Round apertures only. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Round,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        let mut params = self.spacing.params();
        params.push(Param::float(
            "repeated_inclusion",
            "Repeated inclusion",
            "",
            &mut self.repeated_inclusion,
            (0.0, 1.0),
            "Share of the light behind a sub-image that is added although covered: images too bright, as TVCG 2009 reports. 0 counts light once.",
        ).as_published("1"));
        params
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let repeated_inclusion = self.repeated_inclusion;
        let wanted = Wanted { glow: false, transparent_border: false, repeated_inclusion };
        let sub_images = SubImages::new(frame, view, lens, &self.spacing, &wanted);

        let pulled = disocclude(frame, &sub_images, &pinhole);

        // Level 1 filled is read again in focus only; all of it is there to be looked at.
        let stored = if frame.keeps_intermediates() { sub_images.count() } else { 1 };
        let filling = Filling { first_stored: sub_images.count() - stored, ..Default::default() };
        let filled = Known::new(frame, &sub_images, 1, stored);
        let matted = sub_images.matte(frame);
        let groups = matted.size().map(|side| side.div_ceil(MATTED));
        let pass = sub_images.bind(frame.pass(&SHADER, "matte_and_reduce"), &pinhole).uniform("filling", &filling);
        let pass = pulled.coarser.fill(pulled.known.read(pass.buffer("occupied", &sub_images.occupied)));
        filled.write(pass).texture("coarser", &matted).dispatch_groups(groups.x, groups.y, 1);
        frame.expose("disoccluded sub-images", &filled.color);

        let blurred = sub_images.blur(frame, matted);

        let result = frame.color_texture("pyramid", view.size());
        let pass = sub_images.bind(frame.pass(&SHADER, "blur_and_blend"), &pinhole).uniform("filling", &filling);
        filled
            .fill(pass.buffer("occupied", &sub_images.occupied))
            .texture("analysis", &blurred.analysis)
            .texture("blur", &blurred.blur)
            .texture("result", &result)
            .dispatch(image_blocks(result.size()));
        Ok(result)
    }

    fn explains(&self) -> &'static [&'static str] {
        subimages::EXPLAINS
    }

    fn meaning(&self, name: &str) -> Meaning {
        subimages::meaning(name)
    }

    fn texel_px(&self, name: &str) -> Option<u32> {
        subimages::texel_px(name)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// A level of all sub-images, premultiplied with how well a texel is known.
#[derive(Clone)]
struct Known {
    color: Texture,
    depth: Texture,
}

impl Known {
    fn new(frame: &Frame<'_>, sub_images: &SubImages, level: u32, layers: u32) -> Self {
        let color = frame.precision.format();
        let depth = wgpu::TextureFormat::R32Float;
        Self {
            color: sub_images.texture(frame, "pull-push colour", level, layers, color),
            depth: sub_images.texture(frame, "pull-push depth", level, layers, depth),
        }
    }

    fn read<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.texture("known_color", &self.color).texture("known_depth", &self.depth)
    }

    /// Binds it as what completes the finer level.
    fn fill<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.texture("filled_color", &self.color).texture("filled_depth", &self.depth)
    }

    fn write<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.texture("color_out", &self.color).texture("depth_out", &self.depth)
    }
}

/// Texels along a side of which a workgroup makes the matted level 1: the constant of this name
/// in the shader.
const MATTED: u32 = 14;

/// What fills the holes of level 1, where it is read.
struct Pulled {
    /// What is known of level 1.
    known: Known,
    /// Level 2, filled.
    coarser: Known,
}

/// Pull-push, but for filling level 1 itself: that is fused with the matte, which completes pixels
/// from it.
fn disocclude(frame: &mut Frame<'_>, sub_images: &SubImages, pinhole: &Layer) -> Pulled {
    let layers = sub_images.count();
    let coarsest = sub_images.levels_to_one() + LEVELS_TO_MEET;
    let few = |level: &u32| sub_images.level_size(*level).element_product() <= FEW_TEXELS;
    let finest_of_few = (2..coarsest).find(few).unwrap_or(coarsest);

    let known: Vec<Known> = (1..=finest_of_few).map(|level| Known::new(frame, sub_images, level, layers)).collect();
    let groups = box_groups(known[0].color.size());
    let pass = sub_images.bind(frame.pass(&SHADER, "pull_image"), pinhole);
    let pass = pass.buffer("occupied_out", &sub_images.occupied);
    known[0].write(pass).dispatch_groups(groups.x, groups.y, 1);
    for (level, pair) in (2..).zip(known.windows(2)) {
        let groups = box_groups(pair[1].color.size());
        let pass = frame.pass(&SHADER, "pull_level").label(format_args!("pull level {level}"));
        let pass = pair[0].read(pass.buffer("occupied", &sub_images.occupied));
        pair[1].write(pass).dispatch_groups(groups.x, groups.y, layers);
    }

    let mut filled = known[known.len() - 1].clone();
    if finest_of_few < coarsest {
        let finest = Known::new(frame, sub_images, finest_of_few, layers);
        fill_coarse(frame, sub_images, [finest_of_few, coarsest], &filled, &finest);
        filled = finest;
    }
    for (level, known) in (1..finest_of_few).zip(&known).skip(1).rev() {
        let finer = Known::new(frame, sub_images, level, layers);
        let pass = frame.pass(&SHADER, "push_level").label(format_args!("push level {level}"));
        let pass = filled.fill(known.read(pass.buffer("occupied", &sub_images.occupied)));
        finer.write(pass).dispatch_layers(finer.color.size(), layers);
        filled = finer;
    }
    Pulled { known: known[0].clone(), coarser: filled }
}

/// Fills the `finest` of the levels of few texels, of which `known` is what is known: down to the
/// `coarsest` and up again.
fn fill_coarse(
    frame: &mut Frame<'_>,
    sub_images: &SubImages,
    [finest, coarsest]: [u32; 2],
    known: &Known,
    filled: &Known,
) {
    let texels = (finest + 1..=coarsest).map(|level| sub_images.level_size(level).element_product()).sum();
    let scratch = |label, bytes: u64| frame.gpu().scratch(label, bytes * u64::from(texels * sub_images.count()));
    let (colors, depths) = (scratch("coarse pull-push colours", 16), scratch("coarse pull-push depths", 4));
    let pass = frame
        .pass(&SHADER, "fill_coarse")
        .uniform("sub_images", &sub_images.uniform)
        .uniform("filling", &Filling { finest, coarsest, texels, first_stored: 0 })
        .buffer("occupied", &sub_images.occupied)
        .buffer("coarse_color", &colors)
        .buffer("coarse_depth", &depths);
    filled.write(known.read(pass)).dispatch_groups(1, 1, sub_images.count());
}
