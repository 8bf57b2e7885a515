//! The passes of `gather`.

use super::super::sprites::{SpriteTable, SpritesUniform, sum_format};
use super::super::tile_lists::SKIPPED;
use super::grid::{Grid, Scope};
use super::params::{Gather, Params};
use crate::gpu::{Blend, Buffer, Frame, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::shader;
use crate::view::{Layer, View};
use glam::UVec2;

const REDUCE: Shader = shader!("methods/gather_reduce");
const RINGS: Shader = shader!("methods/gather");
const COMBINE: Shader = shader!("methods/gather_combine");

/// Names of what is exposed.
pub(super) const EXPLAINED: &str = "layers of each pixel";

const IMAGE: &str = "gathered image";
const FRONT: &str = "in front";
const BASE: &str = "at and behind";
const LIGHT: &str = "light of sprites";

/// Those that have the gathered image's texels.
pub(super) const ON_THE_GRID: [&str; 5] = [IMAGE, FRONT, BASE, LIGHT, EXPLAINED];

/// Classes of tiles: constants in `shaders/lib/gather.wgsl`.
pub(super) const TILE_CLASSES: [(f32, &str); 3] =
    [(0.0, "in focus: no taps"), (1.0, "one blur: no comparisons"), (2.0, "mixed")];

/// Levels of the gathered image: `LEVELS` there.
const LEVELS: u32 = 4;

/// Bytes of `Tile` and `Sprite` there.
const TILE_BYTES: u64 = 16;
const SPRITE_BYTES: u64 = 16;

/// Bytes of the arguments of an indirect draw.
const DRAW_BYTES: u64 = 16;

/// CoC diameter, px, of foreground that reaches no pixel but its own.
const SINGLE_PIXEL_PX: f64 = 1.0;

impl Scope {
    fn of(method: &Gather, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Self {
        let [near_px, far_px] = view.coc_bounds_px(frame, lens);
        let has_foreground = -near_px > SINGLE_PIXEL_PX;
        if method.near && !has_foreground {
            frame.skip("no foreground: no near field");
        }
        let has_sprites = method.sprites && view.brightest(frame) > method.sprite_threshold;
        if method.sprites && !has_sprites {
            frame.skip("no highlights: no sprites");
        }
        let greatest_radius_px = 0.5 * lens.aperture.radius() * near_px.abs().max(far_px.abs());
        Self { overscan_px: view.overscan_px(), greatest_radius_px, has_foreground, has_sprites }
    }
}

/// One frame's gathering.
struct Gathering {
    grid: Grid,
    params: Params,
    pinhole: Layer,
    /// Colour, and the CoC in alpha.
    image: Texture,
    /// Of each tile, then of what reaches it.
    tiles: [Buffer; 2],
    sprites: Option<Sprites>,
    sums: Texture,
    points: Buffer,
    sprites_uniform: SpritesUniform,
}

/// Bright texels, and the draw of as many as there are.
struct Sprites {
    list: Buffer,
    draw: Buffer,
}

/// The blurred picture.
pub(super) fn record(method: &Gather, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Texture {
    let scope = Scope::of(method, frame, view, lens);
    let pinhole = view.pinhole(frame);
    let grid = Grid::new(pinhole.color.size(), method.step());
    let params = method.uniform(lens, view.lens_uniform(lens), &grid, &scope);
    let gpu = frame.gpu();
    let key = TextureKey { size: grid.size, levels: LEVELS, layers: 1, format: frame.precision.format() };
    let tile_count = u64::from(grid.tiles().element_product());
    let texels = u64::from(grid.size.element_product());
    let rings = method.rings;
    let gathering = Gathering {
        image: gpu.texture_of(IMAGE, key),
        tiles: ["tiles", "tiles with what reaches them"].map(|label| gpu.scratch(label, TILE_BYTES * tile_count)),
        sprites: scope.has_sprites.then(|| Sprites {
            list: gpu.scratch("sprites", SPRITE_BYTES * texels),
            draw: gpu.indirect_buffer("sprite draw", DRAW_BYTES),
        }),
        sums: SpriteTable::texture_of(&lens.aperture, gpu),
        points: (*gpu.memo().get(&(RingPoints, rings), || gpu.buffer_of("ring points", &Gather::ring_points(rings))))
            .clone(),
        sprites_uniform: SpriteTable::of(&lens.aperture).uniform_on(grid.size),
        grid,
        params,
        pinhole,
    };
    gathering.reduce(frame);
    gathering.spread_tiles(frame);
    let mut layers = gathering.gather(frame);
    if method.post_filter != 0 {
        layers = gathering.filter(frame, &layers);
    }
    let light = gathering.draw_sprites(frame, &layers);
    gathering.expose(frame, &layers, light.as_ref());
    gathering.combine(frame, view.size(), &layers, light.as_ref())
}

/// The ring points' place among what is kept.
#[derive(Clone, PartialEq)]
struct RingPoints;

/// What the rings make: in front (premultiplied), and at and behind the texel's surface with
/// the surface's own share in alpha.
struct Layers {
    front: Texture,
    base: Texture,
}

impl Gathering {
    fn layers(&self, frame: &Frame<'_>, labels: [&str; 2]) -> Layers {
        let [front, base] = labels.map(|label| frame.color_texture(label, self.grid.size));
        Layers { front, base }
    }

    /// The image with its levels, the tiles' bounds and the list of bright texels.
    fn reduce(&self, frame: &mut Frame<'_>) {
        let entry = if self.sprites.is_some() { "reduce_and_list" } else { "reduce" };
        let mut pass = frame
            .pass(&REDUCE, entry)
            .uniform("params", &self.params)
            .texture("color", &self.pinhole.color)
            .texture("depth", &self.pinhole.depth)
            .level("image_0", &self.image, 0)
            .level("image_1", &self.image, 1)
            .level("image_2", &self.image, 2)
            .level("image_3", &self.image, 3)
            .buffer("new_tiles", &self.tiles[0]);
        if let Some(sprites) = &self.sprites {
            pass = pass.buffer("new_sprites", &sprites.list).buffer("sprite_draw", &sprites.draw);
        }
        pass.dispatch(self.grid.size);
        frame.expose(IMAGE, &self.image);
    }

    fn spread_tiles(&self, frame: &mut Frame<'_>) {
        frame
            .pass(&REDUCE, "spread_tiles")
            .uniform("params", &self.params)
            .buffer("tiles", &self.tiles[0])
            .buffer("new_tiles", &self.tiles[1])
            .dispatch(self.grid.tiles());
    }

    fn gather(&self, frame: &mut Frame<'_>) -> Layers {
        let layers = self.layers(frame, [FRONT, BASE]);
        frame
            .pass(&RINGS, "gather")
            .uniform("params", &self.params)
            .uniform("sprites", &self.sprites_uniform)
            .texture("image", &self.image)
            .texture("idf_sums", &self.sums)
            .buffer("tiles", &self.tiles[1])
            .buffer("points", &self.points)
            .texture("front", &layers.front)
            .texture("base", &layers.base)
            .dispatch(self.grid.size);
        layers
    }

    fn filter(&self, frame: &mut Frame<'_>, layers: &Layers) -> Layers {
        let filtered = self.layers(frame, ["in front, filtered", "at and behind, filtered"]);
        frame
            .pass(&RINGS, "filter_layers")
            .uniform("params", &self.params)
            .texture("image", &self.image)
            .texture("gathered_front", &layers.front)
            .texture("gathered_base", &layers.base)
            .texture("front", &filtered.front)
            .texture("base", &filtered.base)
            .dispatch(self.grid.size);
        filtered
    }

    /// Light of sprites, premultiplied by its share.
    fn draw_sprites(&self, frame: &mut Frame<'_>, layers: &Layers) -> Option<Texture> {
        let sprites = self.sprites.as_ref()?;
        let light = frame.texture(LIGHT, self.grid.size, sum_format(frame.gpu(), 1));
        frame
            .draw(&COMBINE, "vs_sprite", "fs_sprite")
            .strips()
            .target(&light, Blend::Add, Some([0.0; 4]))
            .uniform("params", &self.params)
            .uniform("sprites", &self.sprites_uniform)
            .buffer("sprite_list", &sprites.list)
            .texture("image", &self.image)
            .texture("front", &layers.front)
            .texture("base", &layers.base)
            .texture("idf_sums", &self.sums)
            .vertices_indirect(&sprites.draw, 0);
        Some(light)
    }

    fn combine(&self, frame: &mut Frame<'_>, size: UVec2, layers: &Layers, light: Option<&Texture>) -> Texture {
        let result = frame.color_texture("gather", size);
        let entry = if light.is_some() { "combine_with_sprites" } else { "combine" };
        let pass = frame
            .pass(&COMBINE, entry)
            .uniform("params", &self.params)
            .texture("color", &self.pinhole.color)
            .texture("depth", &self.pinhole.depth)
            .texture("image", &self.image)
            .texture("front", &layers.front)
            .texture("base", &layers.base)
            .texture("result", &result);
        let pass = if let Some(light) = light { pass.texture("light", light) } else { pass };
        pass.dispatch(size);
        result
    }

    /// Offers what was made on the way.
    fn expose(&self, frame: &mut Frame<'_>, layers: &Layers, light: Option<&Texture>) {
        if !frame.keeps_intermediates() {
            return;
        }
        frame.expose(FRONT, &layers.front);
        frame.expose(BASE, &layers.base);
        if let Some(light) = light {
            frame.expose(LIGHT, light);
        }
        let classes = frame.texture(SKIPPED, self.grid.tiles(), wgpu::TextureFormat::R32Float);
        frame
            .pass(&RINGS, "show_classes")
            .uniform("params", &self.params)
            .buffer("tiles", &self.tiles[1])
            .texture("classes", &classes)
            .dispatch(self.grid.tiles());
        frame.expose(SKIPPED, &classes);
        let explained = frame.texture(EXPLAINED, self.grid.size, wgpu::TextureFormat::Rgba16Float);
        let entry = if light.is_some() { "explain_with_sprites" } else { "explain" };
        let pass = frame
            .pass(&COMBINE, entry)
            .texture("image", &self.image)
            .texture("front", &layers.front)
            .texture("base", &layers.base)
            .texture("explained", &explained);
        let pass = if let Some(light) = light { pass.texture("light", light) } else { pass };
        pass.dispatch(self.grid.size);
        frame.expose(EXPLAINED, &explained);
    }
}
