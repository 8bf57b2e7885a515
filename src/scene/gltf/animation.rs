//! Animations: where nodes are, and how far meshes are morphed, at a moment (glTF 2.0, section 3.11
//! and appendix C).

use super::super::error::SceneProblem;
use super::accessor::read_vectors;
use super::container::Buffers;
use super::exact::{Exact, ExactAnimation, ExactNode, Sampler};
use super::notes::Notes;
use ::gltf::Document;
use glam::DQuat;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// An animation of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The file's name for it, or its number from 0.
    pub name: String,
    /// Time of its last key, seconds; it begins at 0.
    pub duration_s: f64,
}

/// A moment of an animation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The animation by its name or its number from 0; `None` for the first.
    pub animation: Option<String>,
    /// Seconds from its beginning. Before the first key and behind the last one, a scene stands
    /// still.
    pub time_s: f64,
}

/// The animations that can be shown: one whose samplers cannot be read is left out.
pub(super) fn list(document: &Document, exact: &Exact, buffers: &Buffers) -> Vec<Animation> {
    let animations = exact.animations.iter().enumerate();
    animations
        .filter_map(|(index, value)| {
            let animation = parsed(value)?;
            let duration_s = duration_s(&animation, document, buffers).ok()?;
            let name = animation.name.filter(|name| !name.is_empty()).unwrap_or_else(|| index.to_string());
            Some(Animation { name, duration_s })
        })
        .collect()
}

fn parsed(value: &serde_json::Value) -> Option<ExactAnimation> {
    serde::Deserialize::deserialize(value).ok()
}

fn duration_s(animation: &ExactAnimation, document: &Document, buffers: &Buffers) -> Result<f64, SceneProblem> {
    let mut last = 0.0_f32;
    for sampler in &animation.samplers {
        let times = read::<1>(sampler.input, "an animation's input", document, buffers)?;
        last = times.iter().flatten().copied().filter(|time| time.is_finite()).fold(last, f32::max);
    }
    Ok(f64::from(last))
}

/// Numbers of an accessor, element after element.
type Elements = Arc<Vec<f32>>;

/// The animations of a file with the keys that were read of them, so that the second moment costs
/// no parsing.
#[derive(Default)]
pub(super) struct Keys {
    animations: Vec<Option<ExactAnimation>>,
    /// Numbers of accessors by their index and by how many an element has.
    read: Mutex<HashMap<(usize, usize), Elements>>,
}

impl Keys {
    /// Those of animations as they stand in the file; one that does not follow the schema is told
    /// where it is asked for.
    pub(super) fn of(animations: Vec<serde_json::Value>) -> Self {
        Self { animations: animations.iter().map(parsed).collect(), read: Mutex::default() }
    }

    /// An accessor's elements of `N` numbers.
    fn elements<const N: usize>(
        &self,
        accessor: usize,
        item: &str,
        document: &Document,
        buffers: &Buffers,
    ) -> Result<Elements, SceneProblem> {
        // Of a lock that a panic left behind the content is whole: it is only ever added to.
        let mut known = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(numbers) = known.get(&(accessor, N)) {
            return Ok(numbers.clone());
        }
        let numbers = Arc::new(read::<N>(accessor, item, document, buffers)?.into_flattened());
        known.insert((accessor, N), numbers.clone());
        Ok(numbers)
    }
}

/// Where an animation's keys are read.
#[derive(Clone, Copy)]
struct Source<'a> {
    keys: &'a Keys,
    document: &'a Document,
    buffers: &'a Buffers,
}

impl Source<'_> {
    fn elements<const N: usize>(&self, accessor: usize, item: &str) -> Result<Elements, SceneProblem> {
        self.keys.elements::<N>(accessor, item, self.document, self.buffers)
    }
}

/// Changes nodes to where they are at a moment.
///
/// # Errors
///
/// An animation that the file does not have, a time that is no number, or keys that are damaged.
pub(super) fn pose(
    moment: &Moment,
    document: &Document,
    nodes: &mut [ExactNode],
    (keys, known): (&Keys, &[Animation]),
    buffers: &Buffers,
    notes: &mut Notes,
) -> Result<(), SceneProblem> {
    if !moment.time_s.is_finite() {
        return Err(SceneProblem::NotFinite { item: "the time".to_owned(), detail: format!("{} s", moment.time_s) });
    }
    let index = chosen(moment, &keys.animations, known)?;
    let source = Source { keys, document, buffers };
    let animation = keys.animations[index]
        .as_ref()
        .ok_or_else(|| SceneProblem::invalid(format!("animations[{index}]"), "does not follow the glTF schema"))?;
    for (c, channel) in animation.channels.iter().enumerate() {
        let item = format!("animations[{index}].channels[{c}]");
        let Some(node) = channel.target.node else {
            notes.add("animations of other things than nodes are not played", "");
            continue;
        };
        let sampler = animation.samplers.get(channel.sampler);
        let sampler = sampler.ok_or_else(|| SceneProblem::invalid(&item, "refers to a sampler that is not there"))?;
        let morph_targets = nodes.get(node).map_or(0, |node| targets(node, document));
        let node = nodes.get_mut(node);
        let node = node.ok_or_else(|| SceneProblem::invalid(&item, "refers to a node that is not in the file"))?;
        let time_s = moment.time_s;
        let vector = |exact: Option<[f64; 3]>| -> Result<Option<[f64; 3]>, SceneProblem> {
            let value = sample::<3>(sampler, time_s, Blend::Linear, &item, source)?;
            Ok(value.or(exact))
        };
        match channel.target.path.as_str() {
            "translation" => node.translation = vector(node.translation)?,
            "scale" => node.scale = vector(node.scale)?,
            "rotation" => {
                let value = sample::<4>(sampler, time_s, Blend::Spherical, &item, source)?;
                node.rotation = value.or(node.rotation);
            }
            "weights" => {
                if let Some(weights) = sample_weights(sampler, time_s, morph_targets, &item, source)? {
                    node.weights = Some(weights);
                }
                continue;
            }
            _ => {
                notes.add("animations of other things than nodes are not played", "");
                continue;
            }
        }
        // A matrix would hide what is animated; glTF forbids both.
        node.matrix = None;
    }
    let name = animation.name.clone().unwrap_or_else(|| index.to_string());
    let duration_s = duration_s_of(known, &name);
    notes
        .add(format!("the scene is shown at {} s of its animation", moment.time_s), format!("{name} ({duration_s} s)"));
    Ok(())
}

fn duration_s_of(known: &[Animation], name: &str) -> f64 {
    known.iter().find(|animation| animation.name == name).map_or(0.0, |animation| animation.duration_s)
}

/// Index of the animation that a moment names.
fn chosen(moment: &Moment, animations: &[Option<ExactAnimation>], known: &[Animation]) -> Result<usize, SceneProblem> {
    let shown = || known.iter().map(|animation| animation.name.as_str()).collect::<Vec<_>>().join(", ");
    let is_named = |name: &str, animation: &Option<ExactAnimation>| {
        animation.as_ref().and_then(|animation| animation.name.as_deref()) == Some(name)
    };
    let found = match &moment.animation {
        None => (!animations.is_empty()).then_some(0),
        Some(name) => animations
            .iter()
            .position(|animation| is_named(name, animation))
            .or_else(|| name.parse::<usize>().ok().filter(|&index| index < animations.len())),
    };
    found.ok_or_else(|| SceneProblem::NoAnimation {
        wanted: moment.animation.clone().map(|name| name.escape_debug().to_string()),
        known: shown(),
    })
}

/// Morph targets of a node's mesh.
fn targets(node: &ExactNode, document: &Document) -> usize {
    let mesh = node.mesh.and_then(|mesh| document.meshes().nth(mesh));
    let counts =
        mesh.into_iter().flat_map(|mesh| mesh.primitives().map(|p| p.morph_targets().len()).collect::<Vec<_>>());
    counts.max().unwrap_or(0)
}

/// How values between two keys are found where a sampler is linear.
#[derive(Clone, Copy)]
enum Blend {
    Linear,
    /// Along the shorter arc between quaternions.
    Spherical,
}

/// Where a time lies between two keys.
struct Between {
    from: usize,
    to: usize,
    /// Share of the way, in [0, 1].
    share: f64,
    /// Time between the keys, seconds.
    span_s: f64,
}

impl Between {
    fn of(times: &[f32], time_s: f64) -> Option<Self> {
        let last = times.len().checked_sub(1)?;
        let next = times.partition_point(|time| f64::from(*time) <= time_s);
        let (from, to) = (next.saturating_sub(1).min(last), next.min(last));
        let (start, end) = (f64::from(times[from]), f64::from(times[to]));
        let share = (time_s - start) / (end - start);
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        Some(Self { from, to, share, span_s: end - start })
    }

    /// A component of a sampler of the kind that `interpolation` names; `at(key, part)` reads it,
    /// where part is 0 and 2 for the tangents in and out of a cubic spline, 1 for values.
    fn value(&self, interpolation: &str, at: impl Fn(usize, usize) -> f64) -> f64 {
        let t = self.share;
        match interpolation {
            "STEP" => at(if t >= 1.0 { self.to } else { self.from }, 1),
            "CUBICSPLINE" => {
                let (t2, t3) = (t * t, t * t * t);
                let (out, into) = (self.span_s * at(self.from, 2), self.span_s * at(self.to, 0));
                (2.0 * t3 - 3.0 * t2 + 1.0) * at(self.from, 1)
                    + (t3 - 2.0 * t2 + t) * out
                    + (3.0 * t2 - 2.0 * t3) * at(self.to, 1)
                    + (t3 - t2) * into
            }
            _ => at(self.from, 1) + (at(self.to, 1) - at(self.from, 1)) * t,
        }
    }
}

/// The value of a sampler at a time; `None` where it has no keys.
fn sample<const N: usize>(
    sampler: &Sampler,
    time_s: f64,
    blend: Blend,
    item: &str,
    source: Source<'_>,
) -> Result<Option<[f64; N]>, SceneProblem> {
    let times = source.elements::<1>(sampler.input, item)?;
    let values = source.elements::<N>(sampler.output, item)?;
    let values = values.as_chunks::<N>().0;
    let Some(between) = Between::of(&times, time_s) else { return Ok(None) };
    let parts = parts(sampler);
    check_count(values.len(), times.len() * parts, item)?;
    let key = |key: usize, part: usize| values[key * parts + if parts == 1 { 0 } else { part }];
    if let (Blend::Spherical, "LINEAR" | "") = (blend, sampler.interpolation.as_str()) {
        let rotation = |index: usize| DQuat::from_slice(&key(index, 1).map(f64::from)).normalize();
        let (from, to) = (rotation(between.from), rotation(between.to));
        let turned = from.slerp(to, between.share).to_array();
        return finite(std::array::from_fn(|k| turned[k]), item).map(Some);
    }
    let component = |k: usize| between.value(&sampler.interpolation, |index, part| f64::from(key(index, part)[k]));
    finite(std::array::from_fn(component), item).map(Some)
}

/// The weights of so many morph targets at a time.
fn sample_weights(
    sampler: &Sampler,
    time_s: f64,
    targets: usize,
    item: &str,
    source: Source<'_>,
) -> Result<Option<Vec<f32>>, SceneProblem> {
    let times = source.elements::<1>(sampler.input, item)?;
    let values = source.elements::<1>(sampler.output, item)?;
    let Some(between) = Between::of(&times, time_s) else { return Ok(None) };
    let parts = parts(sampler);
    check_count(values.len(), times.len().saturating_mul(parts).saturating_mul(targets), item)?;
    let key = |target: usize| {
        let values = &values;
        move |key: usize, part: usize| {
            let part = if parts == 1 { 0 } else { part };
            f64::from(values[(key * parts + part) * targets + target])
        }
    };
    let weights = (0..targets).map(|target| between.value(&sampler.interpolation, key(target)) as f32).collect();
    Ok(Some(weights))
}

/// Values a key: a cubic spline has tangents beside each.
fn parts(sampler: &Sampler) -> usize {
    if sampler.interpolation == "CUBICSPLINE" { 3 } else { 1 }
}

fn check_count(found: usize, needed: usize, item: &str) -> Result<(), SceneProblem> {
    if found >= needed {
        return Ok(());
    }
    Err(SceneProblem::invalid(item, format!("has {found} values where its keys need {needed}")))
}

fn finite<const N: usize>(value: [f64; N], item: &str) -> Result<[f64; N], SceneProblem> {
    if value.iter().all(|component| component.is_finite()) {
        return Ok(value);
    }
    Err(SceneProblem::NotFinite { item: item.to_owned(), detail: format!("{value:?}") })
}

fn read<const N: usize>(
    accessor: usize,
    item: &str,
    document: &Document,
    buffers: &Buffers,
) -> Result<Vec<[f32; N]>, SceneProblem> {
    let missing = || SceneProblem::invalid(item, format!("refers to accessors[{accessor}], which is not in the file"));
    read_vectors::<N>(&document.accessors().nth(accessor).ok_or_else(missing)?, buffers)
}
