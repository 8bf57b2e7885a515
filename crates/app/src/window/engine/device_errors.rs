//! What the driver complains about, collected instead of ending the program.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Complaints that are kept: a broken pass repeats itself in every frame.
const MAX_KEPT: usize = 8;

/// Errors that wgpu could not return from the call that caused them.
pub struct DeviceErrors {
    texts: Arc<Mutex<Vec<String>>>,
    lost: Arc<AtomicBool>,
}

impl DeviceErrors {
    /// Listens to `device` from now on.
    pub fn watch(device: &wgpu::Device) -> Self {
        let device_errors = Self { texts: Arc::default(), lost: Arc::default() };
        let texts = device_errors.texts.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let remedy = match error {
                wgpu::Error::OutOfMemory { .. } => "make the window smaller or close panes",
                _ => "undo the last change; if it comes back, please report it",
            };
            keep(&texts, format!("the graphics driver refused something ({error}): {remedy}"));
        }));
        let (texts, lost) = (device_errors.texts.clone(), device_errors.lost.clone());
        device.set_device_lost_callback(move |reason, message| {
            // Also when the window closes, after which nobody asks.
            lost.store(true, Ordering::Release);
            let what = "the graphics device was lost; save the state (Ctrl+S) and start the program again";
            keep(&texts, format!("{what}: {message} ({reason:?})"));
        });
        device_errors
    }

    /// Whether the device is gone.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }

    /// The complaints since the last call.
    pub fn take(&self) -> Vec<String> {
        self.texts.lock().map(|mut texts| std::mem::take(&mut *texts)).unwrap_or_default()
    }
}

fn keep(texts: &Mutex<Vec<String>>, text: String) {
    // A poisoned list loses a complaint; the program goes on.
    if let Ok(mut texts) = texts.lock()
        && texts.len() < MAX_KEPT
    {
        texts.push(text);
    }
}
