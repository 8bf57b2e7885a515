//! Methods and their parameters by name.

use anyhow::{Context, bail, ensure};
use defocus::methods::{self, Method, set_param};

/// The methods of `--methods`: ids separated by commas, or "all".
pub fn methods(list: &str) -> anyhow::Result<Vec<Box<dyn Method>>> {
    if list == "all" {
        return Ok(methods::all());
    }
    let mut chosen: Vec<Box<dyn Method>> = Vec::new();
    for id in list.split(',').map(str::trim) {
        let method = methods::by_id(id)?;
        ensure!(chosen.iter().all(|m| m.about().id != id), "method '{id}' is named twice in --methods; name it once");
        chosen.push(method);
    }
    Ok(chosen)
}

/// Has every method that can shade from each point of the lens do so, if `wanted`; before
/// [`apply`], so that `--set multiview.view_dependent=off` has the last word.
pub fn shade_by_view(wanted: bool, methods: &mut [Box<dyn Method>]) -> anyhow::Result<()> {
    for method in methods.iter_mut().filter(|m| wanted && has_param(m.as_ref(), "view_dependent")) {
        set_param(method.as_mut(), "view_dependent", "on")?;
    }
    Ok(())
}

/// Sets methods to what their sources published, if `wanted`; before [`apply`].
pub fn as_published(wanted: bool, methods: &mut [Box<dyn Method>]) {
    for method in methods.iter_mut().filter(|_| wanted) {
        methods::set_as_published(method.as_mut());
    }
}

/// Applies every `--set [ID.]KEY=VALUE`; without an id to all methods that have the key.
pub fn apply(settings: &[String], methods: &mut [Box<dyn Method>]) -> anyhow::Result<()> {
    for setting in settings {
        let (name, value) =
            setting.split_once('=').with_context(|| format!("--set {setting}: give [ID.]KEY=VALUE, such as k=0.5"))?;
        match name.split_once('.') {
            Some((id, key)) => apply_to(setting, id, key, value, methods)?,
            None => apply_to_all(name, value, methods)?,
        }
    }
    Ok(())
}

fn apply_to(setting: &str, id: &str, key: &str, value: &str, methods: &mut [Box<dyn Method>]) -> anyhow::Result<()> {
    // A misspelt id deserves the list of ids, not the remark that it was not chosen.
    methods::by_id(id)?;
    let Some(method) = methods.iter_mut().find(|m| m.about().id == id) else {
        bail!("--set {setting}: {id} is not among the chosen methods; choose it with --method or --methods");
    };
    Ok(set_param(method.as_mut(), key, value)?)
}

fn apply_to_all(key: &str, value: &str, methods: &mut [Box<dyn Method>]) -> anyhow::Result<()> {
    if let [method] = methods {
        return Ok(set_param(method.as_mut(), key, value)?);
    }
    let mut owners = methods.iter_mut().filter(|m| has_param(m.as_ref(), key)).peekable();
    ensure!(
        owners.peek().is_some(),
        "no chosen method has a parameter '{key}'; `defocus methods` lists the parameters of each"
    );
    for method in owners {
        set_param(method.as_mut(), key, value)?;
    }
    Ok(())
}

/// Whether a method has the parameter `key`.
pub fn has_param(method: &dyn Method, key: &str) -> bool {
    method.boxed().params().iter().any(|param| param.key == key)
}
