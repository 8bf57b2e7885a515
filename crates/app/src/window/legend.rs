//! What the colours of a pane mean.

use super::App;
use super::engine::Reading;
use super::model::numbers::{quantity_text, significant};
use super::model::{DifferenceKind, PaneId, Show};
use defocus::methods::Scale;
use defocus::present::{DIFFERENCE_FULL_SCALE, Map, RELATIVE_FULL_SCALE};

/// A colour scale with its ends.
pub struct Legend {
    /// The colours.
    pub map: Map,
    /// What they stand for.
    pub title: String,
    /// At the left end.
    pub low: String,
    /// At the right end.
    pub high: String,
    /// Places on the map, from 0 to 1, that have names, in place of a continuous scale.
    pub names: Vec<(f32, String)>,
}

/// Whole numbers that have a name each; more of them are shown as a scale.
const MOST_NAMES: f32 = 16.0;

/// The legend of what a pane shows; `None` for a picture. It says so where that is of an
/// earlier picture than the one asked for.
pub fn of(app: &App, id: PaneId) -> Option<Legend> {
    let mut legend = of_show(app, id)?;
    if app.engine().pane(id).is_some_and(|pane| !pane.is_shown_complete()) {
        legend.title += ", of the picture before";
    }
    Some(legend)
}

fn of_show(app: &App, id: PaneId) -> Option<Legend> {
    let document = app.document();
    let legend = |map, title: &str, low: String, high: String| {
        Some(Legend { map, title: title.into(), low, high, names: Vec::new() })
    };
    match &document.pane(id)?.show {
        Show::Picture => None,
        Show::Coc => {
            let px = significant(f64::from(app.viewport.coc_scale_px));
            legend(Map::Diverging, "Signed CoC", format!("−{px} px, in front"), format!("{px} px, behind"))
        }
        Show::Depth => legend(Map::Sequential, "Reciprocal depth", "∞".into(), "nearest".into()),
        Show::Zone => {
            let px = significant(f64::from(document.acceptable_coc_px));
            legend(Map::Diverging, "Depth of field", "in front".into(), format!("behind · colours: CoC ≤ {px} px"))
        }
        Show::Difference(difference) => {
            let gain = difference.gain();
            let percent = |v: f32| format!("{} %", significant(f64::from(v * 100.0 / gain)));
            let full = percent(DIFFERENCE_FULL_SCALE);
            match difference.kind {
                DifferenceKind::Absolute => {
                    legend(Map::Error, "Difference of display values", "0".into(), format!("{full} and more"))
                }
                DifferenceKind::Signed => {
                    legend(Map::Diverging, "Signed difference", format!("−{full}, darker"), format!("{full}, brighter"))
                }
                DifferenceKind::Relative => legend(
                    Map::Error,
                    "Difference over linear value",
                    "0".into(),
                    format!("{} and more", percent(RELATIVE_FULL_SCALE)),
                ),
                DifferenceKind::Flip => {
                    let more = if gain > 1.0 { " and more" } else { "" };
                    legend(Map::Error, "FLIP", "0".into(), format!("{}{more}", significant(f64::from(1.0 / gain))))
                }
                DifferenceKind::Jod => {
                    let lost = significant(f64::from(10.0 * difference.map_end()));
                    legend(Map::Error, "Quality lost, as seen", "0 JOD".into(), format!("{lost} JOD and more"))
                }
            }
        }
        Show::Inside(_) => Some(of_reading(app.engine().pane(id)?.reading()?)),
    }
}

/// The legend of numbers from inside a method.
fn of_reading(reading: &Reading) -> Legend {
    let [low, high] = reading.ends;
    let names = match reading.quantity.scale {
        Scale::Classes(classes) => classes.iter().map(|(value, name)| (*value, (*name).to_owned())).collect(),
        Scale::Whole if high - low < MOST_NAMES => {
            (low as i32..=high as i32).map(|i| (i as f32, i.to_string().replace('-', "−"))).collect()
        }
        _ => Vec::new(),
    };
    Legend {
        map: reading.map,
        title: reading.quantity.name.into(),
        low: quantity_text(&reading.quantity, low),
        high: quantity_text(&reading.quantity, high),
        names: names.into_iter().map(|(value, name): (f32, String)| (reading.place(value), name)).collect(),
    }
}
