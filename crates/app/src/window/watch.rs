//! Reading files again when they were saved. A thread looks at their times once a second:
//! the interface itself sleeps meanwhile.

use defocus_study::DepthArgs;
use eframe::egui::Context;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_secs(1);

type Time = Option<SystemTime>;

fn time(file: &Path) -> Time {
    std::fs::metadata(file).and_then(|m| m.modified()).ok()
}

/// Files that are watched until this is dropped.
#[derive(Default)]
pub struct Watched {
    changed: Arc<Mutex<Vec<PathBuf>>>,
    alive: Option<Arc<AtomicBool>>,
}

impl Watched {
    /// Watches `files` and nothing else from now on.
    pub fn watch(&mut self, files: Vec<PathBuf>, ctx: &Context) {
        self.stop();
        if files.is_empty() {
            return;
        }
        let alive = Arc::new(AtomicBool::new(true));
        self.alive = Some(alive.clone());
        let (changed, ctx) = (self.changed.clone(), ctx.clone());
        std::thread::spawn(move || {
            let mut times: Vec<Time> = files.iter().map(|f| time(f)).collect();
            while alive.load(Ordering::Relaxed) {
                std::thread::sleep(INTERVAL);
                for (file, before) in files.iter().zip(&mut times) {
                    let now = time(file);
                    // A file that is being replaced is away for a moment.
                    if now.is_some() && now != *before {
                        *before = now;
                        if let Ok(mut changed) = changed.lock() {
                            changed.push(file.clone());
                        }
                        ctx.request_repaint();
                    }
                }
            }
        });
    }

    /// Watches the files that a scene or image was read from; none of a built-in one.
    pub fn follow(&mut self, spec: &str, depth: &DepthArgs, ctx: &Context) {
        let files = [Some(PathBuf::from(spec)), depth.file.clone()];
        self.watch(files.into_iter().flatten().filter(|f| f.is_file()).collect(), ctx);
    }

    /// The files that were saved since the last call.
    pub fn take(&mut self) -> Vec<PathBuf> {
        let mut files = self.changed.lock().map(|mut files| std::mem::take(&mut *files)).unwrap_or_default();
        files.dedup();
        files
    }

    /// Watches nothing any more.
    pub fn stop(&mut self) {
        if let Some(alive) = self.alive.take() {
            alive.store(false, Ordering::Relaxed);
        }
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.stop();
    }
}
