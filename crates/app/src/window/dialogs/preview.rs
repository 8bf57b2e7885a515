//! What depths an image would have, before it is opened: nearest, median and farthest, and how
//! often each occurs. Read on a thread, of the file and the settings that were asked for last.

use crate::window::model::numbers::significant;
use crate::window::ui::panels::distance_text;
use defocus::histogram::Histogram;
use defocus_study::{DepthArgs, Source};
use eframe::egui::{Color32, Context, Rect, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// How long what is typed must rest before it is read.
const REST: Duration = Duration::from_millis(400);

/// Height of the histogram, points.
const HEIGHT: f32 = 40.0;

/// Bins of the histogram.
const BINS: usize = 96;

/// The depths of an image in numbers.
#[derive(Clone, Debug, PartialEq)]
struct Depths {
    /// Nearest, median and farthest of those that are finite, metres.
    quantiles_m: [f64; 3],
    /// Share that is infinitely far.
    endless: f64,
    /// Height of each bin over equal ratios of depth, from nearest to farthest, up to 1.
    bars: Vec<f32>,
    notes: Vec<String>,
}

impl Depths {
    fn of(spec: &str, args: &DepthArgs) -> Result<Self, String> {
        let source = Source::open(spec, args).map_err(|e| e.to_string())?;
        let Source::Image(image) = &source else { return Err("this is a scene, which needs no depth".into()) };
        let all = &image.depth.pixels;
        let mut finite: Vec<f32> = all.iter().copied().filter(|d| d.is_finite()).collect();
        finite.sort_unstable_by(f32::total_cmp);
        let endless = 1.0 - finite.len() as f64 / all.len().max(1) as f64;
        let (Some(first), Some(last)) = (finite.first(), finite.last()) else {
            return Err("every depth is infinite: check what the numbers are".into());
        };
        let quantiles_m = [*first, finite[finite.len() / 2], *last].map(f64::from);
        let range = quantiles_m[0].ln()..=(quantiles_m[2] * (1.0 + 1e-9)).ln();
        let bars = Histogram::of(finite.iter().map(|d| f64::from(*d).ln()), range, BINS);
        Ok(Self { quantiles_m, endless, bars: bars.heights(), notes: image.notes.clone() })
    }
}

type Key = (String, DepthArgs);

/// The depths of an image, or why it has none.
type Answer = Result<Depths, String>;

/// The preview of what is asked for.
#[derive(Default)]
pub struct Preview {
    wanted: Option<(Key, Instant)>,
    reading: Option<(Key, Receiver<Answer>)>,
    read: Option<(Key, Answer)>,
}

impl Preview {
    /// Shows the depths of an image, read anew where something else is asked for; before one is
    /// named, the place where they will be.
    pub fn show(&mut self, ui: &mut Ui, asked: Option<(&str, &DepthArgs)>) {
        match asked {
            Some((spec, args)) => self.follow(ui.ctx(), (spec.to_owned(), args.clone())),
            None => self.wanted = None,
        }
        let size = vec2(ui.available_width(), HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Depths of the image"));
        ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let text = match &self.read {
            Some((key, Ok(depths))) if self.is_wanted(key) => {
                bars(ui, rect, &depths.bars);
                let notes = depths.notes.join("\n");
                if !notes.is_empty() {
                    response.on_hover_text(notes);
                }
                in_words(depths)
            }
            Some((key, Err(error))) if self.is_wanted(key) => {
                // A line of its own height, with all of it in the tooltip: nothing below moves.
                let line = RichText::new(error).small().color(ui.visuals().error_fg_color);
                ui.add(eframe::egui::Label::new(line).truncate()).on_hover_text(error);
                return;
            }
            _ if asked.is_some() => "reading …".to_owned(),
            _ => "The depths are shown here once their file is named.".to_owned(),
        };
        ui.label(RichText::new(text).small());
    }

    fn is_wanted(&self, key: &Key) -> bool {
        self.wanted.as_ref().is_some_and(|(wanted, _)| wanted == key)
    }

    fn follow(&mut self, ctx: &Context, key: Key) {
        if !self.is_wanted(&key) {
            self.wanted = Some((key, Instant::now()));
        }
        if let Some((key, arrived)) = self.reading.take() {
            match arrived.try_recv() {
                Ok(result) => self.read = Some((key, result)),
                Err(std::sync::mpsc::TryRecvError::Empty) => self.reading = Some((key, arrived)),
                Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                    self.read = Some((key, Err("the file could not be read: the program's log says more".into())));
                }
            }
        }
        let Some((wanted, since)) = &self.wanted else { return };
        if self.reading.is_some() || self.read.as_ref().is_some_and(|(key, _)| key == wanted) {
            return;
        }
        if let Some(wait) = REST.checked_sub(since.elapsed()) {
            return ctx.request_repaint_after(wait);
        }
        let (sender, arrived) = channel();
        let (key, ctx) = (wanted.clone(), ctx.clone());
        self.reading = Some((key.clone(), arrived));
        std::thread::spawn(move || {
            // Nobody listens any more where the dialog was closed meanwhile.
            let _ = sender.send(Depths::of(&key.0, &key.1));
            ctx.request_repaint();
        });
    }
}

fn bars(ui: &Ui, rect: Rect, heights: &[f32]) {
    let width = rect.width() / heights.len().max(1) as f32;
    let color: Color32 = ui.visuals().weak_text_color();
    for (i, height) in heights.iter().enumerate().filter(|(_, height)| **height > 0.0) {
        let left = rect.left() + width * i as f32;
        let top = rect.bottom() - height * rect.height();
        ui.painter().rect_filled(Rect::from_min_max(pos2(left, top), pos2(left + width, rect.bottom())), 0.0, color);
    }
}

fn in_words(depths: &Depths) -> String {
    let [near, median, far] = depths.quantiles_m.map(distance_text);
    let endless = match depths.endless {
        share if share > 0.0 => format!(" · {} % infinitely far", significant(100.0 * share)),
        _ => String::new(),
    };
    format!("nearest {near} · median {median} · farthest {far}{endless}")
}
