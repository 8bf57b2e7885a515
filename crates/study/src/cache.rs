//! References on disk: one of a thousand lens points costs minutes in software.
//!
//! An entry is an EXR (32-bit float) beside a small JSON, named by a hash of everything
//! that the image depends on, the code that draws it included (`build.rs` names that). A
//! damaged entry counts as none.

use super::reference::render_reference;
use super::{GpuSource, Progress, Reference, ReferenceRequest, Source, StudyError, Truth};
use defocus::image_io::{self, ImageError};
use defocus::lens::Lens;
use defocus::scene::Scene;
use defocus::view::View;
use std::io::Write;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3Default;

/// Entries kept; the oldest beyond are removed. Enough for a table of nine scenes, four CoCs
/// and two sizes; at 1024x768 they take about a gigabyte.
const MAX_ENTRIES: usize = 128;

/// A folder of references.
#[derive(Clone, Debug)]
pub struct ReferenceCache {
    folder: PathBuf,
}

/// Names an entry: XXH3 of 128 bits, which has a specification. The standard library's hash may change
/// with the compiler, and with it the names of all entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CacheKey(u128);

/// What a key is made of, part by part.
struct Parts(Xxh3Default);

impl Parts {
    /// Adds a part. Its length comes first, so that parts cannot run into each other.
    fn add(&mut self, part: &[u8]) {
        self.0.update(&(part.len() as u64).to_le_bytes());
        self.0.update(part);
    }
}

/// What an entry says besides its pixels.
#[derive(serde::Serialize, serde::Deserialize)]
struct Entry {
    samples: Option<u32>,
    self_psnr_db: Option<f64>,
}

impl CacheKey {
    /// The key of a view's reference.
    pub fn new(source: &GpuSource, view: &View, lens: &Lens, request: &ReferenceRequest) -> Self {
        let mut parts = Parts(Xxh3Default::new());
        parts.add(env!("DEFOCUS_REFERENCE_CODE").as_bytes());
        parts.add(source.gpu().adapter().name.as_bytes());
        if let Source::Scene(scene) = source.source() {
            add_scene(scene, &mut parts);
        }
        // Debug output of floats round-trips, so it tells apart what differs.
        let projection = view.projection();
        let frame = (projection.size, projection.focal_px, projection.axis_px, projection.near_m);
        parts.add(format!("{:?} {frame:?} {lens:?} {:?}", view.camera(), source.options()).as_bytes());
        let convergence = (request.samples, request.view_dependent, request.display);
        parts.add(format!("{} {convergence:?}", request.reference.id()).as_bytes());
        Self(parts.0.digest128())
    }
}

/// All that an image of the scene depends on.
fn add_scene(scene: &Scene, parts: &mut Parts) {
    for mesh in &scene.meshes {
        parts.add(format!("{:?} {}", mesh.material, mesh.vertices.len()).as_bytes());
        parts.add(bytemuck::cast_slice(&mesh.indices));
        for v in &mesh.vertices {
            for floats in [&v.position.to_array()[..], &v.normal.to_array(), &v.tangent.to_array()] {
                parts.add(bytemuck::cast_slice(floats));
            }
            for floats in [&v.uv.to_array()[..], &v.uv1.to_array(), &v.color.to_array()] {
                parts.add(bytemuck::cast_slice(floats));
            }
        }
    }
    for texture in &scene.textures {
        parts.add(format!("{:?} {} {:?}", texture.size, texture.srgb, texture.wrap).as_bytes());
        parts.add(bytemuck::cast_slice(&texture.rgba8));
    }
    let rest = (&scene.instances, &scene.materials, &scene.lights, &scene.environment);
    parts.add(format!("{rest:?}").as_bytes());
}

/// The truth of `view` from `cache` if it is there, else rendered and kept there. With it
/// comes what kept it from being kept, which is no reason to do without it.
///
/// # Errors
///
/// Those of [`render_reference`].
pub fn cached_reference(
    cache: Option<&ReferenceCache>,
    source: &GpuSource,
    view: &mut View,
    lens: &Lens,
    request: &ReferenceRequest,
    progress: &mut Progress<'_>,
) -> Result<(Truth, Option<ImageError>), StudyError> {
    let cache = cache.filter(|_| !matches!(request.reference, Reference::Method(_)));
    let key = CacheKey::new(source, view, lens, request);
    if let Some(truth) = cache.and_then(|cache| cache.load(key, request))
        && truth.color.size == view.size()
    {
        return Ok((truth, None));
    }
    let truth = render_reference(source, view, lens, request, progress)?;
    let problem = cache.and_then(|cache| cache.store(key, &truth).err());
    Ok((truth, problem))
}

impl ReferenceCache {
    /// A cache in `folder`, which is made when first needed.
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The cache in the user's own cache directory; `None` where the system names none.
    pub fn of_user() -> Option<Self> {
        // A relative path counts as none (XDG Base Directory Specification).
        let variable = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let base = if cfg!(windows) {
            variable("LOCALAPPDATA")
        } else if cfg!(target_os = "macos") {
            variable("HOME").map(|home| home.join("Library/Caches"))
        } else {
            variable("XDG_CACHE_HOME").or_else(|| variable("HOME").map(|home| home.join(".cache")))
        };
        base.map(|base| Self::at(base.join("defocus/references")))
    }

    /// The entry of `key` for `request`, if there is one that is whole.
    pub fn load(&self, key: CacheKey, request: &ReferenceRequest) -> Option<Truth> {
        let entry: Entry = serde_json::from_slice(&std::fs::read(self.file(key, "json")).ok()?).ok()?;
        let color = image_io::read_color(&self.file(key, "exr")).ok()?;
        let Entry { samples, self_psnr_db } = entry;
        Some(Truth { method: request.reference.id(), samples, color, self_psnr_db })
    }

    /// Adds an entry and removes the oldest ones beyond the limit.
    ///
    /// # Errors
    ///
    /// A folder that cannot be made or written.
    pub fn store(&self, key: CacheKey, truth: &Truth) -> Result<(), ImageError> {
        let unwritable = |source| ImageError::Unwritable { file: self.folder.clone(), source };
        std::fs::create_dir_all(&self.folder).map_err(unwritable)?;
        image_io::write_exr(&self.file(key, "exr"), &truth.color, None, None)?;
        let entry = Entry { samples: truth.samples, self_psnr_db: truth.self_psnr_db };
        // Last, so that an entry that is found is complete.
        image_io::write_atomically(&self.file(key, "json"), |file| {
            serde_json::to_writer(&mut *file, &entry).map_err(std::io::Error::other)?;
            file.flush()
        })?;
        self.prune().map_err(unwritable)
    }

    fn file(&self, key: CacheKey, extension: &str) -> PathBuf {
        self.folder.join(format!("{:032x}.{extension}", key.0))
    }

    fn prune(&self) -> std::io::Result<()> {
        let is_entry = |path: &Path| path.extension().is_some_and(|e| e == "json");
        let mut entries = Vec::new();
        for item in std::fs::read_dir(&self.folder)? {
            let item = item?;
            if is_entry(&item.path()) {
                entries.push((item.metadata()?.modified()?, item.path()));
            }
        }
        entries.sort();
        let excess = entries.len().saturating_sub(MAX_ENTRIES);
        for (_, json) in &entries[..excess] {
            std::fs::remove_file(json)?;
            std::fs::remove_file(json.with_extension("exr"))?;
        }
        Ok(())
    }
}
