//! `defocus methods | scenes | lenses | adapters`: what there is.

use super::output::{print, print_json};
use comfy_table::{ContentArrangement, Table, presets as styles};
use defocus::gpu::{Gpu, GpuError};
use defocus::methods::{self, About, Value};
use defocus::presets;
use defocus_study::builtin;
use defocus_study::results::LensJson;
use serde::Serialize;

#[derive(Serialize)]
struct MethodJson {
    #[serde(flatten)]
    about: About,
    params: Vec<ParamJson>,
}

#[derive(Serialize)]
struct ParamJson {
    key: &'static str,
    label: &'static str,
    help: String,
    default: serde_json::Value,
    /// What the source published, where the default is another.
    as_published: Option<serde_json::Value>,
    unit: &'static str,
    /// Both bounds included; null for switches and choices.
    range: Option<[serde_json::Value; 2]>,
    choices: &'static [&'static str],
    expected: String,
}

impl ParamJson {
    /// Of a parameter with its default value; sets it to the published one.
    fn of(param: &mut methods::Param<'_>) -> Self {
        let (unit, range, choices): (_, _, &[&str]) = match &param.value {
            Value::Float { range, unit, .. } => (*unit, Some([range.0.into(), range.1.into()]), &[]),
            Value::Int { range, unit, .. } => (*unit, Some([range.0.into(), range.1.into()]), &[]),
            Value::Switch(_) => ("", None, &[]),
            Value::Choice { names, .. } => ("", None, names),
        };
        let (default, expected, help) = (param.json(), param.expected(), param.full_help());
        let as_published = param.published.map(|value| {
            // Every method's are tried by a test.
            let _ = param.set(value);
            param.json()
        });
        Self { key: param.key, label: param.label, help, default, as_published, unit, range, choices, expected }
    }
}

/// `defocus methods`.
pub fn methods(json: bool) -> anyhow::Result<()> {
    let describe = |mut method: Box<dyn methods::Method>| MethodJson {
        about: method.about(),
        params: method.params().iter_mut().map(ParamJson::of).collect(),
    };
    let all: Vec<MethodJson> = methods::all().into_iter().map(describe).collect();
    if json {
        return print_json(&all);
    }
    let mut table = table(["method", "what it does", "parameters"]);
    for method in &all {
        let bare = |value: &serde_json::Value| value.to_string().replace('"', "");
        let param = |p: &ParamJson| {
            let published = p.as_published.as_ref().map(|value| format!(" (published: {})", bare(value)));
            format!("{} = {}{}: {}", p.key, bare(&p.default), published.unwrap_or_default(), p.expected)
        };
        let params = method.params.iter().map(param).collect::<Vec<_>>().join("\n");
        table.add_row([method.about.id, method.about.summary, &params]);
    }
    print(&table.to_string())
}

#[derive(Serialize)]
struct SceneJson {
    name: &'static str,
    about: &'static str,
    triangles: u64,
    cameras: Vec<String>,
    focus_hint_m: Option<f64>,
}

/// `defocus scenes`.
pub fn scenes(json: bool) -> anyhow::Result<()> {
    if !json {
        let mut table = table(["scene", "what there is to see"]);
        for scene in builtin::all() {
            table.add_row([scene.name, scene.about]);
        }
        for picture in builtin::pictures() {
            table.add_row([picture.name, picture.about]);
        }
        return print(&table.to_string());
    }
    let mut all = Vec::new();
    for builtin in builtin::all() {
        let scene = builtin.load()?;
        all.push(SceneJson {
            name: builtin.name,
            about: builtin.about,
            triangles: scene.triangle_count(),
            cameras: scene.cameras.iter().map(|c| c.name.clone()).collect(),
            focus_hint_m: scene.focus_hint_m,
        });
    }
    for picture in builtin::pictures() {
        let (cameras, focus_hint_m) = (vec!["picture".to_owned()], None);
        all.push(SceneJson { name: picture.name, about: picture.about, triangles: 0, cameras, focus_hint_m });
    }
    print_json(&all)
}

#[derive(Serialize)]
struct PresetJson {
    name: String,
    title: String,
    source: String,
    lens: LensJson,
}

/// `defocus lenses`.
pub fn lenses(json: bool) -> anyhow::Result<()> {
    let all: Vec<PresetJson> = presets::presets()
        .into_iter()
        .map(|p| PresetJson { lens: (&p.lens).into(), name: p.name, title: p.title, source: p.source })
        .collect();
    if json {
        return print_json(&all);
    }
    let mut table = table(["lens", "what it stands for", "parts"]);
    for preset in &all {
        let l = &preset.lens;
        let focus = l.focus_m.map_or("inf".into(), |m| m.to_string());
        let parts = format!(
            "-E {} -F {} --dr {} --ds {} --dpi {} --focus {focus}",
            l.aperture_diameter_mm, l.focal_length_mm, l.image_distance_mm, l.screen_distance_mm, l.density_px_per_mm
        );
        table.add_row([&preset.name, &preset.title, &parts]);
    }
    print(&table.to_string())
}

/// `defocus adapters`.
pub fn adapters(json: bool) -> anyhow::Result<()> {
    let all = Gpu::adapters();
    if json {
        return print_json(&all);
    }
    if all.is_empty() {
        return Err(GpuError::NoAdapter.into());
    }
    let mut table = table(["adapter", "kind", "back end", "driver"]);
    for adapter in &all {
        table.add_row([&adapter.name, adapter.kind, &adapter.backend, &adapter.driver]);
    }
    print(&table.to_string())
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(styles::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(header);
    table
}
