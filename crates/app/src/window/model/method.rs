//! A method with its parameters, as panes, files and command lines name it.

use defocus::methods::{self, Method};
use std::collections::BTreeMap;

/// Lens points that a reference converges to unless its pane says otherwise: with 256 its
/// two halves agree to some 45 dB in the built-in scenes, above what any method reaches.
pub const REFERENCE_SAMPLES: u32 = 256;

/// A method with those of its parameters that differ from their defaults.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct MethodChoice {
    /// [`methods::About::id`].
    pub id: String,
    /// Values by key, as text that [`methods::set_param`] takes.
    #[serde(default)]
    pub params: BTreeMap<String, String>,
    /// Whether it is drawn with the shaders that the program was built with, also where others
    /// were read since.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub as_built: bool,
}

impl MethodChoice {
    /// The method with its default parameters.
    pub fn new(id: &str) -> Self {
        Self { id: id.into(), params: BTreeMap::new(), as_built: false }
    }

    /// The reference: accumulation over [`REFERENCE_SAMPLES`] lens points.
    pub fn reference() -> Self {
        let params = [("samples".to_owned(), REFERENCE_SAMPLES.to_string())];
        Self { id: "accumulation".into(), params: params.into(), as_built: false }
    }

    /// The method itself.
    ///
    /// # Errors
    ///
    /// A sentence, if there is no such method or parameter: documents come from files too.
    pub fn build(&self) -> Result<Box<dyn Method>, String> {
        let mut method = methods::by_id(&self.id).map_err(|e| e.to_string())?;
        for (key, text) in &self.params {
            methods::set_param(method.as_mut(), key, text).map_err(|e| e.to_string())?;
        }
        Ok(method)
    }

    /// Whether a parameter that is a switch, off by default, is on.
    pub fn is_on(&self, key: &str) -> bool {
        self.params.get(key).is_some_and(|text| text == "on")
    }

    /// A parameter that counts something, where it differs from its default.
    pub fn count(&self, key: &str) -> Option<u32> {
        self.params.get(key)?.parse().ok()
    }

    /// Its name for people; the id where there is no such method.
    pub fn title(&self) -> String {
        methods::by_id(&self.id).map_or_else(|_| self.id.clone(), |m| m.about().title.to_owned())
    }
}
