//! What the colours of a pane mean.

use super::App;
use super::document::{DifferenceKind, PaneId, Show};
use super::widgets::significant;
use crate::present::{DIFFERENCE_FULL_SCALE, Map, RELATIVE_FULL_SCALE};

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
}

/// The legend of what a pane shows; `None` for a picture.
pub fn of(app: &App, id: PaneId) -> Option<Legend> {
    let document = app.document();
    let legend = |map, title: &str, low: String, high: String| Some(Legend { map, title: title.into(), low, high });
    match &document.pane(id)?.show {
        Show::Picture => None,
        Show::Coc => {
            let px = significant(f64::from(document.coc_scale_px));
            legend(Map::Diverging, "Signed CoC", format!("−{px} px, in front"), format!("{px} px, behind"))
        }
        Show::Depth => legend(Map::Sequential, "Reciprocal depth", "∞".into(), "nearest".into()),
        Show::Zone => {
            let px = significant(f64::from(document.acceptable_coc_px));
            legend(Map::Diverging, "Depth of field", "in front".into(), format!("behind · colours: CoC ≤ {px} px"))
        }
        Show::Difference(difference) => {
            let percent = |v: f32| format!("{} %", v * 100.0);
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
                DifferenceKind::Flip => legend(Map::Error, "FLIP", "0".into(), "1".into()),
            }
        }
        Show::Inside(inside) => {
            let pane = app.engine().pane(id)?;
            let (name, _) = pane.exposed_as(inside)?;
            let [low, high] = pane.range()?.map(|v| significant(f64::from(v)));
            legend(Map::Sequential, name, low, high)
        }
    }
}
