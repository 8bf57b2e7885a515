// A lens ray through layers of sheets (src/view/sheets.rs): which it crosses in order, and what of
// it is left behind them. Where no sheet is within reach, bounds are empty and nothing is read.
//
// s = c / 2 is the signed CoC radius in pixels: a ray through pixel p and lens point v is at
// p - v * s.

#import four_layers
#import lens
#import sampling

/// Radiance times coverage, and coverage, of up to four layers, of the outer frame.
@group(3) @binding(0) var sheet_colors: texture_2d_array<f32>;
/// Stored depth of each layer, nearest first, -1 where it is empty.
@group(3) @binding(1) var sheet_depths: texture_2d<f32>;
/// For each tile of the inner frame s of the nearest and the farthest sheet that its rays can
/// meet; the first is greater than the second where there is none.
@group(3) @binding(2) var<storage, read> sheet_bounds: array<vec2f>;

/// Greatest |s|, px: what is blurred more is blurred as much as this.
const GREATEST_SHEET_S = 160.0;

/// s of a layer that is empty: behind everything.
const NO_SHEET_S = 60000.0;

/// How far, px of s, a sheet may be from a ray's step to be looked at.
const SHEET_SLACK_S = 0.25;

/// How far, px of s, a crossing lies behind the last one at least: less than the distance of layers,
/// more than what one sheet varies by between texels.
const SHEETS_APART_S = 0.4;

/// Most steps of a ray, and crossings that are looked at.
const MOST_SHEET_STEPS = 4096u;

/// A ray on its way through sheets.
struct SheetRay {
    /// Position on the outer frame, px, where s = 0.
    p: vec2f,
    v: vec2f,
    /// How far it has come.
    s: f32,
    /// Where there is nothing more.
    end_s: f32,
    /// s of the last crossing.
    last_s: f32,
    /// Share of it that is left.
    left: f32,
}

/// A crossing: radiance times coverage and coverage, times what was left of the ray; 0 for none.
struct SheetCrossing {
    light: vec4f,
    s: f32,
}

/// What a tile's rays can meet. One element is bound where there are no sheets.
fn sheet_bounds_of(tile_index: u32) -> vec2f {
    return sheet_bounds[min(tile_index, arrayLength(&sheet_bounds) - 1u)];
}

fn sheet_ray(p: vec2f, v: vec2f, bounds: vec2f) -> SheetRay {
    return SheetRay(p, v, bounds.x - SHEET_SLACK_S, bounds.y + SHEET_SLACK_S, -1e9, 1.0);
}

fn sheet_texel(at: vec2f) -> vec2i {
    return clamp_to_image(vec2i(floor(at)), textureDimensions(sheet_depths));
}

fn sheets_at(lens: Lens, at: vec2f) -> vec4f {
    let z = textureLoad(sheet_depths, sheet_texel(at), 0);
    let s = clamp(0.5 * lens.slope_px * (lens.focus_z - z), vec4f(-GREATEST_SHEET_S), vec4f(GREATEST_SHEET_S));
    return select(s, vec4f(NO_SHEET_S), z < vec4f(0.0));
}

/// The next sheet that the ray crosses in front of s = `up_to`.
fn next_sheet(ray: ptr<function, SheetRay>, lens: Lens, up_to: f32) -> SheetCrossing {
    let end = min((*ray).end_s, up_to);
    let length_v = max(length((*ray).v), 1e-3);
    for (var i = 0u; i < MOST_SHEET_STEPS && (*ray).s < end; i++) {
        let width = min(1.0 / length_v, end - (*ray).s);
        let there = sheets_at(lens, (*ray).p - (*ray).v * ((*ray).s + 0.5 * width));
        let low = max((*ray).s - SHEET_SLACK_S, (*ray).last_s + SHEETS_APART_S);
        let k = first_within(there, low, (*ray).s + width + SHEET_SLACK_S);
        if k < 0 {
            (*ray).s += width;
            continue;
        }
        // Where the ray meets that depth, the sheet may lie a little nearer or farther, or end.
        let expected = there[k];
        let met_at = (*ray).p - (*ray).v * expected;
        let met = sheets_at(lens, met_at);
        let j = nearest_to(met, expected);
        let s = met[j];
        let is_same = abs(s - expected) <= 0.25 + 0.08 * abs(expected);
        if is_same && s > (*ray).last_s + SHEETS_APART_S && s < up_to {
            (*ray).last_s = s;
            let light = (*ray).left * textureLoad(sheet_colors, sheet_texel(met_at), j, 0);
            (*ray).left -= light.a;
            return SheetCrossing(light, s);
        }
        (*ray).last_s = max(expected, (*ray).last_s);
    }
    return SheetCrossing(vec4f(0.0), end);
}

/// Most crossings of a ray.
const MOST_CROSSINGS = 16u;

/// The share of a ray that is left in front of s = `up_to`.
fn left_by_sheets(p: vec2f, v: vec2f, bounds: vec2f, lens: Lens, up_to: f32) -> f32 {
    var ray = sheet_ray(p, v, bounds);
    for (var i = 0u; i < MOST_CROSSINGS; i++) {
        if next_sheet(&ray, lens, up_to).light.a <= 0.0 {
            break;
        }
    }
    return ray.left;
}
