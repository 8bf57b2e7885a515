//! Tells whoever shows the pictures that something has arrived.

use std::sync::Arc;

/// A call that may come from any thread; nothing happens where nobody wants it.
#[derive(Clone, Default)]
pub struct Wake(Option<Arc<dyn Fn() + Send + Sync>>);

impl Wake {
    /// Calls `told` from now on.
    pub fn with(told: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(told)))
    }

    /// Something has arrived.
    pub fn call(&self) {
        if let Some(told) = &self.0 {
            told();
        }
    }
}
