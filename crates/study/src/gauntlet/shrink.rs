//! Makes a scene that shows a fault smaller and simpler, as long as it still shows it.

use super::maker::rounded_to;
use super::spec::{Pattern, QuadSpec, SceneSpec};
use crate::StudyError;
use glam::{DVec2, UVec2, dvec2, uvec2};

/// Least side of a frame, px: metrics and methods want some pixels around what is wrong.
const LEAST_SIDE_PX: u32 = 32;

/// A scene made smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Shrunk {
    /// The smallest that still shows the fault.
    pub spec: SceneSpec,
    /// Scenes tried.
    pub tries: u32,
    /// Whether nothing simpler is left to be tried.
    pub complete: bool,
}

/// Makes `spec` simpler, step by step, each of which must leave a scene that `shows` the
/// fault: fewer quads, a smaller frame, smaller quads, plain ones, rounder numbers. Ends
/// when no step does, or after `most_tries` scenes.
///
/// # Errors
///
/// Those of `shows`.
pub fn shrink(
    spec: &SceneSpec,
    most_tries: u32,
    mut shows: impl FnMut(&SceneSpec) -> Result<bool, StudyError>,
) -> Result<Shrunk, StudyError> {
    let mut shrunk = Shrunk { spec: spec.clone(), tries: 0, complete: false };
    while shrunk.tries < most_tries {
        let before = shrunk.spec.clone();
        for step in [fewer_quads, smaller_frame, smaller_quads, plainer, rounder] {
            let mut index = 0;
            while shrunk.tries < most_tries {
                let Some(candidate) = step(&shrunk.spec).into_iter().nth(index) else { break };
                if candidate == shrunk.spec || candidate.check().is_err() {
                    index += 1;
                    continue;
                }
                shrunk.tries += 1;
                // After a success the list is another one, with something else at this place.
                match shows(&candidate)? {
                    true => shrunk.spec = candidate,
                    false => index += 1,
                }
            }
        }
        if shrunk.spec == before {
            shrunk.complete = true;
            break;
        }
    }
    Ok(shrunk)
}

/// How large a scene is: its quads, its pixels, then the digits of its numbers.
pub fn size_of(spec: &SceneSpec) -> (usize, u32, usize) {
    (spec.quads.len(), spec.size_px[0] * spec.size_px[1], spec.to_text().len())
}

/// Without half of the quads, a quarter, ... one.
fn fewer_quads(spec: &SceneSpec) -> Vec<SceneSpec> {
    let count = spec.quads.len();
    let mut sizes = Vec::new();
    let mut size = count.div_ceil(2);
    while size > 0 {
        sizes.push(size);
        size = if size == 1 { 0 } else { size.div_ceil(2) };
    }
    let without = |first: usize, size: usize| {
        let quads = spec.quads.iter().enumerate().filter(|(i, _)| !(first..first + size).contains(i));
        SceneSpec { quads: quads.map(|(_, quad)| quad.clone()).collect(), ..spec.clone() }
    };
    sizes.into_iter().flat_map(|size| (0..count).step_by(size).map(move |first| without(first, size))).collect()
}

/// Its middle half, or one of its quarters: what is seen there stays as it is.
fn smaller_frame(spec: &SceneSpec) -> Vec<SceneSpec> {
    let size = spec.size();
    let half = size / 2;
    if half.min_element() < LEAST_SIDE_PX {
        return Vec::new();
    }
    let corners = [half / 2, UVec2::ZERO, uvec2(half.x, 0), uvec2(0, half.y), half];
    corners.map(|origin| cropped(spec, origin, half)).to_vec()
}

fn cropped(spec: &SceneSpec, origin: UVec2, size: UVec2) -> SceneSpec {
    let focal_px = spec.camera().projection(spec.size(), 0).focal_px;
    let shift_px: DVec2 = spec.size().as_dvec2() * 0.5 - (origin.as_dvec2() + size.as_dvec2() * 0.5);
    // What lies at the middle of the new frame comes onto the axis.
    let moved = |[x, y, depth]: [f64; 3]| {
        let shift_m = dvec2(shift_px.x, -shift_px.y) * depth / focal_px;
        [rounded_to(x + shift_m.x, 6), rounded_to(y + shift_m.y, 6), depth]
    };
    let fov_y_deg = 2.0 * (0.5 * f64::from(size.y) / focal_px).atan().to_degrees();
    let quads = spec.quads.iter().map(|quad| QuadSpec { corners_m: quad.corners_m.map(moved), ..quad.clone() });
    SceneSpec { size_px: size.to_array(), fov_y_deg, quads: quads.collect(), ..spec.clone() }
}

/// Each quad half as large.
fn smaller_quads(spec: &SceneSpec) -> Vec<SceneSpec> {
    each_quad(spec, |quad| {
        let middle = |axis: usize| quad.corners_m.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25;
        let middle = [0, 1, 2].map(middle);
        let halved = |corner: [f64; 3]| [0, 1, 2].map(|i| rounded_to(0.5 * (corner[i] + middle[i]), 5));
        // Below a thousandth of the focus distance nothing is seen of it.
        let extent = |corner: &[f64; 3]| (corner[0] - middle[0]).abs().max((corner[1] - middle[1]).abs());
        let wide = quad.corners_m.iter().any(|corner| extent(corner) > 0.002 * spec.focus_m);
        wide.then(|| QuadSpec { corners_m: quad.corners_m.map(halved), ..quad.clone() })
    })
}

/// Each quad plain, with fewer cells, without a tint, facing the lens; a black sky.
fn plainer(spec: &SceneSpec) -> Vec<SceneSpec> {
    let mut all = each_quad(spec, |quad| Some(QuadSpec { pattern: Pattern::Plain, ..quad.clone() }));
    all.extend(each_quad(spec, |quad| match &quad.pattern {
        Pattern::Checker { cells, other } if *cells != [1, 1] => {
            let pattern = Pattern::Checker { cells: cells.map(|n| n.div_ceil(2)), other: *other };
            Some(QuadSpec { pattern, ..quad.clone() })
        }
        _ => None,
    }));
    all.extend(each_quad(spec, |quad| Some(QuadSpec { radiance: grey(quad.radiance), ..quad.clone() })));
    all.extend(each_quad(spec, |quad| {
        let depth_m = quad.corners_m.iter().map(|corner| corner[2]).sum::<f64>() * 0.25;
        // The same place in the picture at the mean depth.
        let facing = |[x, y, own]: [f64; 3]| {
            [rounded_to(x * depth_m / own, 5), rounded_to(y * depth_m / own, 5), rounded_to(depth_m, 5)]
        };
        Some(QuadSpec { corners_m: quad.corners_m.map(facing), ..quad.clone() })
    }));
    all.push(SceneSpec { sky: [0.0; 3], ..spec.clone() });
    all
}

fn grey(radiance: [f32; 3]) -> [f32; 3] {
    [radiance.iter().copied().fold(0.0, f32::max); 3]
}

/// Numbers with one digit, then two, then three.
fn rounder(spec: &SceneSpec) -> Vec<SceneSpec> {
    let mut all = Vec::new();
    for digits in 1..=3 {
        let short = |value: f64| rounded_to(value, digits);
        let short_color = |color: [f32; 3]| color.map(|v| rounded_to(f64::from(v), digits) as f32);
        all.push(SceneSpec { k_px: short(spec.k_px), ..spec.clone() });
        all.push(SceneSpec { fov_y_deg: short(spec.fov_y_deg), ..spec.clone() });
        all.push(SceneSpec { sky: short_color(spec.sky), ..spec.clone() });
        all.extend(each_quad(spec, |quad| Some(QuadSpec { radiance: short_color(quad.radiance), ..quad.clone() })));
        all.extend(each_quad(spec, |quad| {
            Some(QuadSpec { corners_m: quad.corners_m.map(|corner| corner.map(short)), ..quad.clone() })
        }));
    }
    all
}

fn each_quad(spec: &SceneSpec, change: impl Fn(&QuadSpec) -> Option<QuadSpec>) -> Vec<SceneSpec> {
    let changed = |index: usize| {
        let mut changed = spec.clone();
        changed.quads[index] = change(&spec.quads[index])?;
        Some(changed)
    };
    (0..spec.quads.len()).filter_map(changed).collect()
}
