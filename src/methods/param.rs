//! Parameters of methods as plain data: sliders, command-line options, sweeps and tests
//! all come from one list.

/// One parameter of a method, borrowed for reading or changing.
#[derive(Debug)]
pub struct Param<'a> {
    /// Name on the command line, such as "samples".
    pub key: &'static str,
    /// Name for people.
    pub label: &'static str,
    /// What it does and where it comes from.
    pub help: &'static str,
    /// The value with its range.
    pub value: Value<'a>,
    /// Values, as text, between which quality is traded for time: what a benchmark tries.
    /// Empty for a parameter that is no such trade.
    pub trade: &'static [&'static str],
    /// The value, as text, that the method's source published, where the default is another.
    pub published: Option<&'static str>,
}

/// A borrowed value with its range.
#[derive(Debug)]
pub enum Value<'a> {
    /// A real number.
    Float {
        /// The value.
        value: &'a mut f32,
        /// Bounds, both included.
        range: (f32, f32),
        /// Unit, such as "px"; empty for none.
        unit: &'static str,
    },
    /// A whole number.
    Int {
        /// The value.
        value: &'a mut u32,
        /// Bounds, both included.
        range: (u32, u32),
        /// Unit; empty for none.
        unit: &'static str,
    },
    /// On or off.
    Switch(&'a mut bool),
    /// One of a few named alternatives.
    Choice {
        /// Index of the chosen one.
        value: &'a mut usize,
        /// Their names.
        names: &'static [&'static str],
    },
}

/// Why a parameter cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamError {
    /// The method has no such parameter.
    #[error("{method} has no parameter '{}'; it has: {known}", key.escape_debug())]
    Unknown {
        /// The method's id.
        method: &'static str,
        /// The key given.
        key: String,
        /// Keys that there are.
        known: String,
    },
    /// The text is not a value of the parameter's kind, or out of range.
    #[error("{method}.{key} cannot be '{}': it must be {expected}", given.escape_debug())]
    Invalid {
        /// The method's id.
        method: &'static str,
        /// The parameter's key.
        key: &'static str,
        /// The text given.
        given: String,
        /// What would be accepted.
        expected: String,
    },
}

impl<'a> Param<'a> {
    /// A real number in `range`.
    pub fn float(
        key: &'static str,
        label: &'static str,
        unit: &'static str,
        value: &'a mut f32,
        range: (f32, f32),
        help: &'static str,
    ) -> Self {
        Self { key, label, help, value: Value::Float { value, range, unit }, trade: &[], published: None }
    }

    /// A whole number in `range`.
    pub fn int(
        key: &'static str,
        label: &'static str,
        unit: &'static str,
        value: &'a mut u32,
        range: (u32, u32),
        help: &'static str,
    ) -> Self {
        Self { key, label, help, value: Value::Int { value, range, unit }, trade: &[], published: None }
    }

    /// On or off.
    pub fn switch(key: &'static str, label: &'static str, value: &'a mut bool, help: &'static str) -> Self {
        Self { key, label, help, value: Value::Switch(value), trade: &[], published: None }
    }

    /// One of `names`.
    pub fn choice(
        key: &'static str,
        label: &'static str,
        value: &'a mut usize,
        names: &'static [&'static str],
        help: &'static str,
    ) -> Self {
        Self { key, label, help, value: Value::Choice { value, names }, trade: &[], published: None }
    }

    /// Sets [`Param::trade`].
    pub fn trading(self, values: &'static [&'static str]) -> Self {
        Self { trade: values, ..self }
    }

    /// Sets [`Param::published`].
    pub fn as_published(self, value: &'static str) -> Self {
        Self { published: Some(value), ..self }
    }

    /// What it does, and what was published where the default is another.
    pub fn full_help(&self) -> String {
        match self.published {
            Some(value) => format!("{} As published: {value}.", self.help),
            None => self.help.to_owned(),
        }
    }

    /// What values are accepted, in words.
    pub fn expected(&self) -> String {
        match &self.value {
            Value::Float { range, unit, .. } => format!("a number from {} to {} {unit}", range.0, range.1),
            Value::Int { range, unit, .. } => format!("a whole number from {} to {} {unit}", range.0, range.1),
            Value::Switch(_) => "on or off".into(),
            Value::Choice { names, .. } => format!("one of {}", names.join(", ")),
        }
        .trim_end()
        .to_owned()
    }

    /// The value as text that [`Param::set`] accepts.
    pub fn text(&self) -> String {
        match &self.value {
            Value::Float { value, .. } => value.to_string(),
            Value::Int { value, .. } => value.to_string(),
            Value::Switch(value) => if **value { "on" } else { "off" }.into(),
            Value::Choice { value, names } => names[**value].into(),
        }
    }

    /// The value for JSON.
    pub fn json(&self) -> serde_json::Value {
        match &self.value {
            // By way of text: as f64, 0.1 would become 0.10000000149011612.
            Value::Float { value, .. } => {
                serde_json::json!(value.to_string().parse::<f64>().unwrap_or(f64::from(**value)))
            }
            Value::Int { value, .. } => serde_json::json!(**value),
            Value::Switch(value) => serde_json::json!(**value),
            Value::Choice { value, names } => serde_json::json!(names[**value]),
        }
    }

    /// Sets the value from text; on failure says what would be accepted.
    pub fn set(&mut self, text: &str) -> Result<(), String> {
        let expected = self.expected();
        let fail = || expected.clone();
        match &mut self.value {
            Value::Float { value, range, .. } => {
                let new: f32 = text.parse().map_err(|_| fail())?;
                **value = Some(new).filter(|v| (range.0..=range.1).contains(v)).ok_or_else(fail)?;
            }
            Value::Int { value, range, .. } => {
                let new: u32 = text.parse().map_err(|_| fail())?;
                **value = Some(new).filter(|v| (range.0..=range.1).contains(v)).ok_or_else(fail)?;
            }
            Value::Switch(value) => {
                **value = match text {
                    "on" | "true" | "1" | "yes" => true,
                    "off" | "false" | "0" | "no" => false,
                    _ => return Err(fail()),
                }
            }
            Value::Choice { value, names } => {
                **value = names.iter().position(|n| *n == text).ok_or_else(fail)?;
            }
        }
        Ok(())
    }
}
