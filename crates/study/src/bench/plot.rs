//! Plots as SVG: points and lines over axes that may be logarithmic.

use std::fmt::Write;

/// Width of a plot, px.
const WIDTH: f64 = 760.0;
/// Height of a plot, px.
const HEIGHT: f64 = 420.0;
/// Room for the vertical axis, px.
const LEFT: f64 = 64.0;
/// Room above, px.
const TOP: f64 = 18.0;
/// Room for the legend, px.
const RIGHT: f64 = 190.0;
/// Room for the horizontal axis, px.
const BOTTOM: f64 = 48.0;

/// How far the axes reach beyond the data, as a share of its range.
const MARGIN: f64 = 0.06;

/// An axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// What it shows, with the unit.
    pub title: &'a str,
    /// Whether equal ratios are equal lengths.
    pub logarithmic: bool,
}

/// A point, with an interval for y if there is one.
#[derive(Clone, Debug)]
pub struct Point {
    /// Where.
    pub x: f64,
    /// Where.
    pub y: f64,
    /// Ends of an interval in the direction of y.
    pub interval: Option<[f64; 2]>,
    /// What the point stands for, shown when it is pointed at.
    pub label: String,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Which of the colours and shapes: the same kind has the same everywhere.
    pub style: usize,
    /// Its points, in the order in which they are joined.
    pub points: Vec<Point>,
    /// Whether each point has a mark; a curve has none.
    pub markers: bool,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    /// The horizontal axis.
    pub x: Axis<'a>,
    /// The vertical axis.
    pub y: Axis<'a>,
    /// What it shows.
    pub series: Vec<Series>,
    /// Draw the front of the points that nothing else beats both in x (less is better) and
    /// in y (more is better).
    pub front: bool,
}

/// Colours that are told apart in light and dark, and by most colour-blind people; shapes
/// tell apart what they do not.
const COLORS: [&str; 12] = [
    "#3a76c4", "#e07b1f", "#2f9e6b", "#c8423d", "#8a63c9", "#8c6d4f", "#d46fb3", "#7d8590", "#a59a16", "#1ea3b8",
    "#e3b505", "#5c6f2b",
];

/// Range of an axis in its own (possibly logarithmic) measure.
#[derive(Clone, Copy)]
struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
    from_px: f64,
    to_px: f64,
}

impl Scale {
    fn new(axis: Axis<'_>, values: impl Iterator<Item = f64>, [from_px, to_px]: [f64; 2]) -> Self {
        let measured = values.map(|v| if axis.logarithmic { v.log10() } else { v }).filter(|v| v.is_finite());
        let [low, high] = measured.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        // Nothing, or a single value, still needs a range.
        let [low, high] = if low <= high { [low, high] } else { [0.0, 1.0] };
        let margin = if high > low { MARGIN * (high - low) } else { 0.5 };
        Self { low: low - margin, high: high + margin, logarithmic: axis.logarithmic, from_px, to_px }
    }

    fn px(&self, value: f64) -> f64 {
        let measured = if self.logarithmic { value.log10() } else { value };
        let share = (measured - self.low) / (self.high - self.low);
        self.from_px + share.clamp(0.0, 1.0) * (self.to_px - self.from_px)
    }

    /// Values to mark: round ones, 4 to 10 of them.
    fn ticks(&self) -> Vec<f64> {
        if !self.logarithmic {
            return linear_ticks(self.low, self.high);
        }
        let decades = self.high - self.low;
        let within = |v: &f64| (self.low..=self.high).contains(&v.log10());
        for steps in [&[1.0][..], &[1.0, 3.0], &[1.0, 2.0, 5.0]] {
            let exponents = self.low.floor() as i32..=self.high.ceil() as i32;
            let ticks = exponents.flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)));
            let ticks: Vec<f64> = ticks.filter(within).collect();
            if ticks.len() >= 4 || (decades > 2.0 && ticks.len() >= 3) {
                return ticks;
            }
        }
        linear_ticks(10f64.powf(self.low), 10f64.powf(self.high))
    }
}

fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| *s >= rough).unwrap_or(power);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A number as short as it can be said.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 1e6 {
        return format!("{}M", number(value / 1e6));
    }
    let decimals = if magnitude == 0.0 { 0 } else { (2 - magnitude.log10().floor() as i32).clamp(0, 4) as usize };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// The points that none other beats: no other has at most their x and at least their y.
/// By rising x.
pub fn pareto_front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    let mut front: Vec<[f64; 2]> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|best| point[1] > best[1]) {
            front.push(point);
        }
    }
    front
}

impl Plot<'_> {
    /// The plot as an SVG element; text takes the colour of its surroundings.
    pub fn svg(&self) -> String {
        let points = || self.series.iter().flat_map(|s| &s.points);
        let ys = points().flat_map(|p| [p.y].into_iter().chain(p.interval.into_iter().flatten()));
        let x = Scale::new(self.x, points().map(|p| p.x), [LEFT, WIDTH - RIGHT]);
        let y = Scale::new(self.y, ys, [HEIGHT - BOTTOM, TOP]);
        let mut svg = format!(
            r#"<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{} against {}">"#,
            escaped(self.y.title),
            escaped(self.x.title)
        );
        self.draw_axes(&mut svg, x, y);
        if self.front {
            draw_front(&mut svg, points(), x, y);
        }
        for (row, series) in self.series.iter().enumerate() {
            series.draw(&mut svg, x, y);
            series.draw_legend(&mut svg, row);
        }
        svg + "</svg>"
    }

    /// The plot as a file of its own, black on white as paper has it. Its looks are attributes:
    /// not every program that takes SVG reads style sheets.
    pub fn svg_file(&self) -> String {
        let looks = [
            (r#"class="grid""#, r##"stroke="#dddddd""##),
            (r#"class="line""#, r#"fill="none" stroke-width="1.6""#),
            (r#"class="front""#, r##"fill="none" stroke="#555555" stroke-dasharray="5 4""##),
        ];
        let mut svg = self.svg();
        for (class, look) in looks {
            svg = svg.replace(class, look);
        }
        let root = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" "#
        );
        let page = format!(r##"><rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>"##);
        svg.replacen("<svg ", &root, 1).replacen('>', &page, 1) + "\n"
    }

    fn draw_axes(&self, svg: &mut String, x: Scale, y: Scale) {
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
        for tick in x.ticks() {
            let at = x.px(tick);
            let _ = write!(svg, r#"<line class="grid" x1="{at:.1}" y1="{TOP}" x2="{at:.1}" y2="{bottom}"/>"#);
            let text = number(tick);
            let _ = write!(svg, r#"<text x="{at:.1}" y="{}" text-anchor="middle">{text}</text>"#, bottom + 17.0);
        }
        for tick in y.ticks() {
            let at = y.px(tick);
            let _ = write!(svg, r#"<line class="grid" x1="{LEFT}" y1="{at:.1}" x2="{right}" y2="{at:.1}"/>"#);
            let text = number(tick);
            let _ = write!(svg, r#"<text x="{}" y="{:.1}" text-anchor="end">{text}</text>"#, LEFT - 7.0, at + 4.0);
        }
        let _ = write!(
            svg,
            r#"<text class="title" x="{}" y="{}" text-anchor="middle">{}</text><text class="title" transform="translate(15 {}) rotate(-90)" text-anchor="middle">{}</text>"#,
            0.5 * (LEFT + right),
            HEIGHT - 9.0,
            escaped(self.x.title),
            0.5 * (TOP + bottom),
            escaped(self.y.title)
        );
    }
}

fn draw_front<'p>(svg: &mut String, points: impl Iterator<Item = &'p Point>, x: Scale, y: Scale) {
    let all: Vec<[f64; 2]> = points.map(|p| [p.x, p.y]).collect();
    let front = pareto_front(&all);
    let mut path = String::new();
    for (i, [px, py]) in front.iter().map(|p| [x.px(p[0]), y.px(p[1])]).enumerate() {
        // Stairs: what is reached at some time stays reached later.
        let _ = if i == 0 { write!(path, "M{px:.1} {py:.1}") } else { write!(path, "H{px:.1}V{py:.1}") };
    }
    if !front.is_empty() {
        let _ = write!(path, "H{}", WIDTH - RIGHT);
    }
    let _ = write!(svg, r#"<path class="front" d="{path}"/>"#);
}

impl Series {
    fn color(&self) -> &'static str {
        COLORS[self.style % COLORS.len()]
    }

    fn draw(&self, svg: &mut String, x: Scale, y: Scale) {
        let color = self.color();
        let places: Vec<String> = self.points.iter().map(|p| format!("{:.1},{:.1}", x.px(p.x), y.px(p.y))).collect();
        let _ = write!(svg, r#"<polyline class="line" stroke="{color}" points="{}"/>"#, places.join(" "));
        for point in self.points.iter().filter(|_| self.markers) {
            let (px, py) = (x.px(point.x), y.px(point.y));
            if let Some([low, high]) = point.interval.map(|ends| ends.map(|e| y.px(e))) {
                let _ = write!(
                    svg,
                    r#"<line stroke="{color}" stroke-width="1.5" x1="{px:.1}" x2="{px:.1}" y1="{low:.1}" y2="{high:.1}"/>"#
                );
            }
            let _ = write!(svg, "<g>{}<title>{}</title></g>", self.marker(px, py), escaped(&point.label));
        }
    }

    /// Circles, squares, triangles, diamonds: the second ten series repeat the colours.
    fn marker(&self, x: f64, y: f64) -> String {
        let color = self.color();
        let corners = match (self.style / COLORS.len() + self.style) % 4 {
            0 => return format!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="4.5" fill="{color}"/>"#),
            1 => [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]].to_vec(),
            2 => vec![[0.0, -5.2], [5.0, 4.2], [-5.0, 4.2]],
            _ => vec![[0.0, -5.6], [5.6, 0.0], [0.0, 5.6], [-5.6, 0.0]],
        };
        let corners: Vec<String> = corners.iter().map(|c| format!("{:.1},{:.1}", x + c[0], y + c[1])).collect();
        format!(r#"<polygon points="{}" fill="{color}"/>"#, corners.join(" "))
    }

    fn draw_legend(&self, svg: &mut String, row: usize) {
        let (x, y) = (WIDTH - RIGHT + 22.0, TOP + 10.0 + 21.0 * row as f64);
        let color = self.color();
        let mark = match self.markers {
            true => self.marker(x, y),
            false => {
                let (from, to) = (x - 7.0, x + 7.0);
                format!(
                    r#"<line stroke="{color}" stroke-width="2" x1="{from:.1}" x2="{to:.1}" y1="{y:.1}" y2="{y:.1}"/>"#
                )
            }
        };
        let _ = write!(svg, r#"{}<text x="{}" y="{:.1}">{}</text>"#, mark, x + 13.0, y + 4.0, escaped(&self.name));
    }
}

/// Text that may stand in XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [[1.0, 20.0], [2.0, 30.0], [3.0, 25.0], [2.0, 28.0], [9.0, 31.0], [10.0, 31.0]];
        assert_eq!(pareto_front(&points), [[1.0, 20.0], [2.0, 30.0], [9.0, 31.0]]);
        assert!(pareto_front(&[]).is_empty());
    }

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let axis = |logarithmic| Axis { title: "", logarithmic };
        let log = Scale::new(axis(true), [4.0, 128.0].into_iter(), [0.0, 1.0]);
        assert_eq!(log.ticks(), [5.0, 10.0, 20.0, 50.0, 100.0]);
        let linear = Scale::new(axis(false), [21.0, 39.0].into_iter(), [0.0, 1.0]);
        assert_eq!(linear.ticks(), [20.0, 25.0, 30.0, 35.0, 40.0]);
        let single = Scale::new(axis(true), [5.0].into_iter(), [0.0, 1.0]);
        assert!(single.ticks().len() >= 2 && (single.px(5.0) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 0.05, 0.5, 2.0, 20.98, 128.0, 2_500_000.0].map(number);
        assert_eq!(shown, ["0", "0.05", "0.5", "2", "21", "128", "2.5M"]);
    }

    #[test]
    fn names_cannot_break_the_plot() {
        let axis = Axis { title: "<x & y>", logarithmic: false };
        let series = Series { name: "\"a\"".into(), style: 0, points: Vec::new(), markers: true };
        let svg = Plot { x: axis, y: axis, series: vec![series], front: true }.svg();
        assert!(svg.contains("&lt;x &amp; y&gt;") && svg.contains("&quot;a&quot;") && svg.ends_with("</svg>"), "{svg}");
    }
}
