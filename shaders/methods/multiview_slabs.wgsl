// multiview: slabs of the scene as arrays that rays can be traced in
// (src/methods/multiview/slabs.rs and nbuffer.rs).
//
// Lee, Eisemann and Seidel, SIGGRAPH Asia 2009, sections 4.2 to 4.4. One array layer for
// each slab, in a frame padded to whole texels of the coarsest mipmap level:
//
//   slab_color   linear radiance towards the lens's centre, times coverage, and coverage
//                (1 or 0 at level 0)
//   slab_base    base colour and roughness, times coverage
//   slab_normal  normal and metalness, times coverage
//   slab_depth   stored depth z = near / d of the surface, EMPTY_Z where there is none
//   n_buffer     greatest z (nearest surface) over a square window of blocks of texels

#import color

const EMPTY_Z = -1.0;

struct Gather {
    /// Bounds of the slab, both included.
    z_near: f32,
    z_far: f32,
    slab: u32,
    /// 1: what the image's border shows goes on beyond it.
    stretched: u32,
    /// Texels left of and above the image in the arrays.
    padding: vec2i,
}

@group(0) @binding(0) var<uniform> gather: Gather;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var slab_color: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(4) var slab_depth: texture_storage_2d_array<r32float, write>;
/// For each slab: bits of the greatest z plus 1 (0 while nothing was found), of the least.
@group(0) @binding(5) var<storage, read_write> content: array<atomic<u32>>;

var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;

fn finite_or_zero(x: f32) -> f32 {
    return select(0.0, x, is_finite(vec3f(x)));
}

/// A texel of a drawn layer: radiance and 1, or 0 where it is not in the slab.
struct Texel {
    surface: vec4f,
    /// EMPTY_Z where it is not in the slab.
    z: f32,
}

fn texel_of(at: vec2i) -> Texel {
    let here = textureLoad(color, at, 0);
    // Not below 0: an empty texel may hold -0, whose bits would be the greatest.
    let z = max(finite_or_zero(textureLoad(depth, at, 0).r), 0.0);
    if here.a > 0.0 && z >= gather.z_far && z <= gather.z_near {
        return Texel(vec4f(finite_or_zero(here.r), finite_or_zero(here.g), finite_or_zero(here.b), 1.0), z);
    }
    return Texel(vec4f(0.0), EMPTY_Z);
}

/// What the padding beside the image has of the border that goes on there: colour for the
/// mipmap, which else would cover the border itself in part, and no surface to hit.
fn padding_of(at: vec2i) -> vec4f {
    return texel_of(clamp(at, vec2i(0), vec2i(textureDimensions(depth)) - 1)).surface;
}

fn is_in_image(at: vec2i) -> bool {
    return all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(depth)));
}

fn forget_content(index: u32) {
    if index == 0u {
        atomicStore(&nearest, 0u);
        atomicStore(&farthest, 0xffffffffu);
    }
    workgroupBarrier();
}

fn note_depth(z: f32) {
    if z >= 0.0 {
        atomicMax(&nearest, bitcast<u32>(z) + 1u);
        atomicMin(&farthest, bitcast<u32>(z));
    }
}

fn note_content(index: u32, slab: u32) {
    workgroupBarrier();
    if index == 0u {
        atomicMax(&content[2u * slab], atomicLoad(&nearest));
        atomicMin(&content[2u * slab + 1u], atomicLoad(&farthest));
    }
}

/// Puts one drawn slab (or the slab's part of an image) into the arrays and notes which
/// depths it really holds.
@compute @workgroup_size(16, 16)
fn gather_slab(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    forget_content(index);
    let at = vec2i(id.xy) - gather.padding;
    var texel = Texel(vec4f(0.0), EMPTY_Z);
    if is_in_image(at) {
        texel = texel_of(at);
        note_depth(texel.z);
    } else if gather.stretched != 0u {
        texel.surface = padding_of(at);
    }
    if all(id.xy < textureDimensions(slab_color)) {
        textureStore(slab_color, id.xy, gather.slab, texel.surface);
        textureStore(slab_depth, id.xy, gather.slab, vec4f(texel.z, 0.0, 0.0, 0.0));
    }
    note_content(index, gather.slab);
}

/// Of the pinhole image.
@group(0) @binding(16) var visible_depth: texture_2d<f32>;

/// Puts what an image hides into its slab, where the image shows nothing of that.
@compute @workgroup_size(16, 16)
fn gather_hidden(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    forget_content(index);
    let at = vec2i(id.xy) - gather.padding;
    if is_in_image(at) {
        let visible_z = textureLoad(visible_depth, at, 0).r;
        let is_seen = visible_z >= gather.z_far && visible_z <= gather.z_near;
        let texel = texel_of(at);
        if texel.z >= 0.0 && !is_seen {
            note_depth(texel.z);
            textureStore(slab_color, id.xy, gather.slab, texel.surface);
            textureStore(slab_depth, id.xy, gather.slab, vec4f(texel.z, 0.0, 0.0, 0.0));
        }
    } else if all(id.xy < textureDimensions(slab_color)) {
        let border = clamp(at, vec2i(0), vec2i(textureDimensions(depth)) - 1);
        let visible_z = textureLoad(visible_depth, border, 0).r;
        let surface = padding_of(at);
        if surface.a > 0.0 && !(visible_z >= gather.z_far && visible_z <= gather.z_near) {
            textureStore(slab_color, id.xy, gather.slab, surface);
        }
    }
    note_content(index, gather.slab);
}

@group(0) @binding(11) var base_roughness: texture_2d<f32>;
@group(0) @binding(12) var normal_metallic: texture_2d<f32>;
@group(0) @binding(13) var slab_base: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(14) var slab_normal: texture_storage_2d_array<rgba16float, write>;

/// The same for what the slab's surfaces are made of, which is 0 where there is none.
@compute @workgroup_size(8, 8)
fn gather_surfaces(@builtin(global_invocation_id) id: vec3u) {
    let at = vec2i(id.xy) - gather.padding;
    var base = vec4f(0.0);
    var normal = vec4f(0.0);
    if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(base_roughness))) {
        base = textureLoad(base_roughness, at, 0);
        normal = textureLoad(normal_metallic, at, 0);
    }
    if all(id.xy < textureDimensions(slab_base)) {
        textureStore(slab_base, id.xy, gather.slab, base);
        textureStore(slab_normal, id.xy, gather.slab, normal);
    }
}

// ---- slabs that are drawn at once: `scene.wgsl` ----

/// By slab and texel: bits of the greatest z plus 1, 0 where nothing was found.
@group(0) @binding(15) var<storage, read> found: array<u32>;

/// Puts the depths of slabs into the array, from slab `gather.slab` on, one for each layer of
/// the grid, and notes which each really holds. Colours are emptied; what is not, is drawn.
@compute @workgroup_size(16, 16)
fn gather_depths(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    let slab = gather.slab + id.z;
    forget_content(index);
    let size = textureDimensions(slab_color);
    if all(id.xy < size) {
        let bits = found[(id.z * size.y + id.y) * size.x + id.x];
        let z = select(EMPTY_Z, bitcast<f32>(bits - 1u), bits != 0u);
        note_depth(z);
        textureStore(slab_color, id.xy, slab, vec4f(0.0));
        textureStore(slab_depth, id.xy, slab, vec4f(z, 0.0, 0.0, 0.0));
    }
    note_content(index, slab);
}

/// The same for what surfaces are made of.
@compute @workgroup_size(8, 8)
fn empty_surfaces(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(slab_base)) {
        textureStore(slab_base, id.xy, gather.slab + id.z, vec4f(0.0));
        textureStore(slab_normal, id.xy, gather.slab + id.z, vec4f(0.0));
    }
}

// ---- mipmaps, of what is premultiplied with its coverage ----

@group(0) @binding(6) var finer: texture_2d_array<f32>;
@group(0) @binding(7) var coarser: texture_storage_2d_array<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn reduce_slabs(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarser)) {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(finer, 2u * id.xy + vec2u(i & 1u, i >> 1u), id.z, 0);
    }
    textureStore(coarser, id.xy, id.z, 0.25 * sum);
}

// ---- N-buffer, of blocks of texels ----

struct Level {
    /// Blocks along x and y, their side, px, and slabs.
    blocks: vec2u,
    block_px: u32,
    slab_count: u32,
    /// Level that is made: its windows are 2^level blocks wide.
    level: u32,
}

@group(0) @binding(8) var<uniform> level: Level;
@group(0) @binding(9) var slab_depths: texture_2d_array<f32>;
/// By level, slab and block: greatest z in the window right of and below the block.
@group(0) @binding(10) var<storage, read_write> n_buffer: array<f32>;
@group(0) @binding(17) var shown: texture_storage_2d_array<r32float, write>;

fn n_buffer_index(level_of: u32, slab: u32, block: vec2u) -> u32 {
    return ((level_of * level.slab_count + slab) * level.blocks.y + block.y) * level.blocks.x + block.x;
}

/// Greatest z of each block.
@compute @workgroup_size(8, 8)
fn find_nearest(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= level.blocks) {
        return;
    }
    let first = id.xy * level.block_px;
    let end = min(first + level.block_px, textureDimensions(slab_depths));
    var greatest = EMPTY_Z;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            greatest = max(greatest, textureLoad(slab_depths, vec2u(x, y), id.z, 0).r);
        }
    }
    n_buffer[n_buffer_index(0u, id.z, id.xy)] = greatest;
}

/// Four windows make one of twice the side. Windows that leave the image end there.
@compute @workgroup_size(8, 8)
fn widen_windows(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= level.blocks) {
        return;
    }
    let narrower = level.level - 1u;
    let far = min(id.xy + (1u << narrower), level.blocks - 1u);
    let left = max(
        n_buffer[n_buffer_index(narrower, id.z, id.xy)],
        n_buffer[n_buffer_index(narrower, id.z, vec2u(id.x, far.y))],
    );
    let right = max(
        n_buffer[n_buffer_index(narrower, id.z, vec2u(far.x, id.y))],
        n_buffer[n_buffer_index(narrower, id.z, far)],
    );
    n_buffer[n_buffer_index(level.level, id.z, id.xy)] = max(left, right);
}

/// To look at.
@compute @workgroup_size(8, 8)
fn show_windows(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < level.blocks) {
        textureStore(shown, id.xy, id.z, vec4f(n_buffer[n_buffer_index(level.level, id.z, id.xy)], 0.0, 0.0, 0.0));
    }
}
