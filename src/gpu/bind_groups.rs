//! A cache of bind groups.

use super::arena::Piece;
use rustc_hash::{FxHashMap, FxHasher};
use std::hash::{Hash, Hasher};
use std::sync::{Mutex, PoisonError};

/// Something bound to a name. Two are equal if binding one for the other changes no bind
/// group: the offset of a uniform is given when the group is set.
#[derive(Clone)]
pub(crate) enum Resource {
    View(wgpu::TextureView),
    Buffer(wgpu::Buffer),
    Sampler(wgpu::Sampler),
    /// A part of the given length, bytes.
    Uniform(Piece, u32),
}

impl PartialEq for Resource {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::View(a), Self::View(b)) => a == b,
            (Self::Buffer(a), Self::Buffer(b)) => a == b,
            (Self::Sampler(a), Self::Sampler(b)) => a == b,
            (Self::Uniform(a, length), Self::Uniform(b, other)) => a.buffer == b.buffer && length == other,
            _ => false,
        }
    }
}

impl Hash for Resource {
    fn hash<H: Hasher>(&self, state: &mut H) {
        match self {
            Self::View(view) => view.hash(state),
            Self::Buffer(buffer) | Self::Uniform(Piece { buffer, .. }, _) => buffer.hash(state),
            Self::Sampler(sampler) => sampler.hash(state),
        }
    }
}

impl Resource {
    /// Where a uniform begins, bytes; 0 for all else.
    pub(crate) fn offset(&self) -> u32 {
        if let Self::Uniform(piece, _) = self { piece.offset } else { 0 }
    }

    fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::View(view) => wgpu::BindingResource::TextureView(view),
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            Self::Uniform(piece, length) => {
                let size = wgpu::BufferSize::new(u64::from(*length));
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &piece.buffer, offset: 0, size })
            }
        }
    }
}

struct Made {
    layout: wgpu::BindGroupLayout,
    resources: Box<[Resource]>,
    bind_group: wgpu::BindGroup,
    /// The frame that used it last.
    used: u64,
}

/// Bind groups by the hash of what they bind.
#[derive(Default)]
pub(super) struct BindGroups(Mutex<FxHashMap<u64, Made>>);

impl BindGroups {
    /// The group of `layout` that binds these, made unless that was done lately.
    pub(super) fn get<'a>(
        &self,
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        bindings: impl Iterator<Item = (u32, &'a Resource)> + Clone,
        frame: u64,
    ) -> wgpu::BindGroup {
        let mut hasher = FxHasher::default();
        layout.hash(&mut hasher);
        bindings.clone().for_each(|(_, resource)| resource.hash(&mut hasher));
        let hash = hasher.finish();
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |made: &Made| made.layout == *layout && made.resources.iter().eq(bindings.clone().map(|b| b.1));
        if let Some(known) = all.get_mut(&hash).filter(|made| same(made)) {
            known.used = frame;
            return known.bind_group.clone();
        }
        let entry =
            |(binding, resource): (u32, &'a Resource)| wgpu::BindGroupEntry { binding, resource: resource.binding() };
        let entries: Vec<_> = bindings.clone().map(entry).collect();
        let bind_group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let resources = bindings.map(|(_, resource)| resource.clone()).collect();
        let made = Made { layout: layout.clone(), resources, bind_group: bind_group.clone(), used: frame };
        all.insert(hash, made);
        bind_group
    }

    /// Forgets those that no frame after `frame` has used: they keep textures alive.
    pub(super) fn forget(&self, frame: u64) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|_, made| made.used > frame);
    }
}
