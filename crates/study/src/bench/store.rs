//! The folder of a benchmark: its plan, and a file for each cell that is done, so that an
//! interrupted one goes on and parts from several machines can be put together.

use super::plan::Plan;
use super::results::{BenchResults, CellResult};
use defocus::image::Image;
use defocus::image_io::{self, ImageError};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file or folder that cannot be read or written.
    #[error("{path}: {source}; check that it is there and may be read and written")]
    Io {
        /// Which.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that is not what this program writes.
    #[error("{path}: is not a benchmark's file ({source}); remove it to measure again")]
    Damaged {
        /// Which.
        path: PathBuf,
        /// Where it stops making sense.
        source: serde_json::Error,
    },
    /// Another plan is there already.
    #[error("{folder}: holds another benchmark; give another folder, or remove this one")]
    OtherPlan {
        /// The folder.
        folder: PathBuf,
    },
    /// Parts of different plans.
    #[error("{second}: measures other things than {first}; only parts of one benchmark can be merged")]
    NotOfOnePlan {
        /// A folder.
        first: PathBuf,
        /// One with another plan.
        second: PathBuf,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] ImageError),
}

/// A benchmark's folder.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

const PLAN: &str = "plan.json";
const CELLS: &str = "cells";
const MAPS: &str = "maps";

impl Store {
    /// The folder for `plan`: made if it is not there, continued if it holds the same plan.
    ///
    /// # Errors
    ///
    /// Another plan in it, a folder that cannot be made.
    pub fn open(folder: &Path, plan: &Plan) -> Result<Self, StoreError> {
        let store = Self { folder: folder.to_owned() };
        match store.plan() {
            Ok(there) if there == *plan => {}
            Ok(_) => return Err(StoreError::OtherPlan { folder: folder.to_owned() }),
            Err(StoreError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
                for path in [CELLS, MAPS].map(|part| folder.join(part)) {
                    std::fs::create_dir_all(&path).map_err(|source| StoreError::Io { path, source })?;
                }
                store.write_json(PLAN, plan)?;
            }
            Err(error) => return Err(error),
        }
        Ok(store)
    }

    /// Puts the parts of one plan together in `folder`. Where two have a cell, the first
    /// one's counts.
    ///
    /// # Errors
    ///
    /// A part that is no benchmark or one of another plan.
    pub fn merge(parts: &[PathBuf], folder: &Path) -> Result<(Self, Plan), StoreError> {
        let [first, rest @ ..] = parts else {
            let source = std::io::Error::other("no parts were given");
            return Err(StoreError::Io { path: folder.to_owned(), source });
        };
        let plan = Self { folder: first.clone() }.plan()?;
        for second in rest {
            let other = Self { folder: second.clone() };
            if other.plan()? != plan {
                return Err(StoreError::NotOfOnePlan { first: first.clone(), second: second.clone() });
            }
        }
        let merged = Self::open(folder, &plan)?;
        for part in parts {
            for kind in [CELLS, MAPS] {
                copy_new(&part.join(kind), &folder.join(kind))?;
            }
        }
        Ok((merged, plan))
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn plan(&self) -> Result<Plan, StoreError> {
        read_json(&self.folder.join(PLAN))
    }

    /// The result of a cell; `None` if it is not there yet.
    ///
    /// # Errors
    ///
    /// A file that is damaged.
    pub fn cell(&self, index: usize) -> Result<Option<CellResult>, StoreError> {
        match read_json(&self.folder.join(cell_file(index))) {
            Ok(result) => Ok(Some(result)),
            Err(StoreError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Adds a cell.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn add(&self, result: &CellResult) -> Result<(), StoreError> {
        self.write_json(&cell_file(result.cell.index), result)
    }

    /// Adds an error map and returns its name in the folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn add_map(&self, cell: usize, variant: &str, map: &Image<[u8; 3]>) -> Result<String, StoreError> {
        let name = format!("{MAPS}/{cell:04}-{variant}.png");
        image_io::write_png_rgb(&self.folder.join(&name), map)?;
        Ok(name)
    }

    /// All that was measured so far.
    ///
    /// # Errors
    ///
    /// A file that is damaged.
    pub fn results(&self, plan: &Plan) -> Result<BenchResults, StoreError> {
        let wanted = plan.cells();
        let cells = wanted.iter().map(|cell| self.cell(cell.index)).collect::<Result<Vec<_>, _>>()?;
        let cells = cells.into_iter().flatten().collect();
        Ok(BenchResults { plan: plan.clone(), cells_wanted: wanted.len(), cells })
    }

    /// Writes a file of the folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        Ok(image_io::write_atomically(&self.folder.join(name), |file| file.write_all(bytes))?)
    }

    fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), StoreError> {
        let path = self.folder.join(name);
        let text = serde_json::to_vec_pretty(value).map_err(|source| StoreError::Damaged { path, source })?;
        self.write(name, &text)
    }
}

fn cell_file(index: usize) -> String {
    format!("{CELLS}/{index:04}.json")
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, StoreError> {
    let text = std::fs::read(path).map_err(|source| StoreError::Io { path: path.to_owned(), source })?;
    serde_json::from_slice(&text).map_err(|source| StoreError::Damaged { path: path.to_owned(), source })
}

/// Copies files that are not in `to` yet.
fn copy_new(from: &Path, to: &Path) -> Result<(), StoreError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| StoreError::Io { path, source }
    };
    for file in std::fs::read_dir(from).map_err(io(from))? {
        let file = file.map_err(io(from))?;
        let target = to.join(file.file_name());
        if !target.exists() {
            std::fs::copy(file.path(), &target).map_err(io(&target))?;
        }
    }
    Ok(())
}
