//! The kinds of figures that the parts of an analysis draw, as SVG. Lengths are in CSS pixels; colours
//! and fonts are attributes, so that a figure looks the same on the page and in a file of its own.

use maud::{Markup, html};

pub(crate) const BLUE: [f64; 3] = [33.0, 94.0, 138.0];
pub(crate) const ORANGE: [f64; 3] = [190.0, 92.0, 25.0];
const WHITE: [f64; 3] = [255.0, 255.0, 255.0];
/// Colours of series, told apart by lightness as well, so that they survive a grey print.
const SERIES: [&str; 6] = ["#215e8a", "#be5c19", "#4b8f5c", "#8a4d8f", "#56616b", "#b0982e"];
pub(crate) const INK: &str = "#1c2126";
pub(crate) const FAINT: &str = "#56616b";
pub(crate) const RULE: &str = "#c9d0d6";
/// Room for one character of a label.
pub(crate) const CHARACTER: f64 = 7.2;

/// An axis of a [`Plot`].
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it measures, with its unit.
    pub title: String,
    /// The smallest and the largest value shown; above 0 if `logarithmic`.
    pub range: [f64; 2],
    /// Whether equal distances are equal ratios.
    pub logarithmic: bool,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    Line,
    /// A dashed line through the points.
    Dashed,
    /// A dot at each point, with its interval if there is one.
    Points,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the key; empty for none.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// The points (x, y).
    pub points: Vec<[f64; 2]>,
    /// The interval of each point's y; empty for none. Beside a line they are drawn as a band.
    pub intervals: Vec<[f64; 2]>,
}

/// A figure with two axes of numbers.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What it is, for readers who do not see it.
    pub label: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, first to last; series of one name have one colour.
    pub series: Vec<Series>,
    /// Horizontal lines at values that matter, with their names.
    pub rules: Vec<(f64, String)>,
}

impl Axis {
    /// An axis that holds all `values` that are finite, with even steps.
    pub fn of(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|value| value.is_finite());
        let [low, high] =
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let range = match (low < high, low.is_finite()) {
            (true, _) => {
                let step = step(low, high);
                [(low / step).floor() * step, (high / step).ceil() * step]
            }
            (false, true) => [low - 0.5, low + 0.5],
            (false, false) => [0.0, 1.0],
        };
        Self { title: title.into(), range, logarithmic: false }
    }

    /// An axis of `range`, above 0, on which equal distances are equal ratios.
    pub fn logarithmic(title: &str, range: [f64; 2]) -> Self {
        Self { title: title.into(), range, logarithmic: true }
    }

    /// Where `value` is on the axis: 0 at its beginning, 1 at its end.
    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.logarithmic {
            false => (value - low) / (high - low),
            true => libm::log(value / low) / libm::log(high / low),
        }
    }

    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.range;
        if !self.logarithmic {
            let step = step(low, high);
            let (first, last) = ((low / step).ceil() as i64, (high / step + 1e-9).floor() as i64);
            return (first..=last).map(|k| k as f64 * step).collect();
        }
        let decades = (libm::log10(low).floor() as i32)..=(libm::log10(high).ceil() as i32);
        let wide = libm::log10(high / low) > 3.0;
        let steps: &[f64] = if wide { &[1.0] } else { &[1.0, 2.0, 5.0] };
        decades
            .flat_map(|decade| steps.iter().map(move |k| k * libm::pow(10.0, f64::from(decade))))
            .filter(|tick| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(tick))
            .collect()
    }
}

impl Plot {
    /// The figure.
    pub fn svg(&self) -> String {
        const LEFT: f64 = 64.0;
        const TOP: f64 = 14.0;
        const WIDTH: f64 = 460.0;
        const HEIGHT: f64 = 270.0;
        let (right, bottom) = (LEFT + WIDTH, TOP + HEIGHT);
        let x = |value: f64| LEFT + WIDTH * self.x.place(value).clamp(-0.02, 1.02);
        let y = |value: f64| bottom - HEIGHT * self.y.place(value).clamp(-0.02, 1.02);
        let mut names: Vec<&str> = Vec::new();
        for series in &self.series {
            if !names.contains(&series.name.as_str()) {
                names.push(&series.name);
            }
        }
        let colour =
            |name: &str| SERIES[names.iter().position(|n| *n == name).unwrap_or(0) % SERIES.len()];
        let key: Vec<&str> = names.iter().copied().filter(|name| !name.is_empty()).collect();
        let longest = key.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        let rules = self.rules.iter().map(|(_, n)| n.chars().count()).max().unwrap_or(0);
        let margin = 16.0 + CHARACTER * longest.max(rules) as f64 + 20.0;
        let body = html! {
            @for tick in self.x.ticks() {
                line x1=(px(x(tick))) x2=(px(x(tick))) y1=(px(TOP)) y2=(px(bottom)) stroke=(RULE) {}
                text x=(px(x(tick))) y=(px(bottom + 16.0)) text-anchor="middle" fill=(FAINT) {
                    (number(tick)) }
            }
            @for tick in self.y.ticks() {
                line x1=(px(LEFT)) x2=(px(right)) y1=(px(y(tick))) y2=(px(y(tick))) stroke=(RULE) {}
                text x=(px(LEFT - 6.0)) y=(px(y(tick) + 4.0)) text-anchor="end" fill=(FAINT) {
                    (number(tick)) }
            }
            text x=(px(LEFT + WIDTH / 2.0)) y=(px(bottom + 36.0)) text-anchor="middle" { (self.x.title) }
            text transform=(upwards(14.0, TOP + HEIGHT / 2.0)) text-anchor="middle" { (self.y.title) }
            @for (value, name) in &self.rules {
                line x1=(px(LEFT)) x2=(px(right)) y1=(px(y(*value))) y2=(px(y(*value)))
                    stroke=(INK) stroke-dasharray="2 3" {}
                text x=(px(right + 6.0)) y=(px(y(*value) + 4.0)) { (name) }
            }
            @for series in &self.series { (draw(series, colour(&series.name), &x, &y)) }
            @for (row, name) in key.iter().enumerate() {
                @let y = TOP + 8.0 + 18.0 * row as f64;
                circle cx=(px(right + 14.0)) cy=(px(y)) r="4" fill=(colour(name)) {}
                text x=(px(right + 24.0)) y=(px(y + 4.0)) { (name) }
            }
        };
        svg(right + margin, bottom + 46.0, &self.label, &body)
    }
}

fn draw(series: &Series, colour: &str, x: &dyn Fn(f64) -> f64, y: &dyn Fn(f64) -> f64) -> Markup {
    let path = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let steps: Vec<String> =
            points.map(|(at, value)| format!("{:.1} {:.1}", x(at), y(value))).collect();
        format!("M{}", steps.join("L"))
    };
    let xs = || series.points.iter().map(|[x, _]| *x);
    let line = series.style != Style::Points;
    let dashes = (series.style == Style::Dashed).then_some("6 4");
    let bounds = |bound: usize| series.intervals.iter().map(move |interval| interval[bound]);
    html! {
        @if line && !series.points.is_empty() {
            @if series.intervals.len() == series.points.len() {
                path d=(path(&mut xs().zip(bounds(0)).chain(xs().zip(bounds(1)).rev())))
                    fill=(colour) fill-opacity="0.16" stroke="none" {}
            }
            path d=(path(&mut series.points.iter().map(|[x, y]| (*x, *y)))) fill="none"
                stroke=(colour) stroke-width="1.8" stroke-dasharray=[dashes] {}
        } @else {
            @for ([at, _], [low, high]) in series.points.iter().zip(&series.intervals) {
                line x1=(px(x(*at))) x2=(px(x(*at))) y1=(px(y(*low))) y2=(px(y(*high)))
                    stroke=(colour) stroke-width="1.4" {}
            }
            @for [at, value] in &series.points {
                circle cx=(px(x(*at))) cy=(px(y(*value))) r="3.6" fill=(colour) {}
            }
        }
    }
}

/// A value in a row of its own.
#[derive(Clone, Debug)]
pub struct Dot {
    /// Label of the row.
    pub label: String,
    /// The value; none where it is not known.
    pub value: Option<f64>,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
}

/// Values with intervals, one row each, along a horizontal axis; `rules` are vertical lines at values
/// that matter.
pub fn dots(label: &str, axis: &Axis, rows: &[Dot], rules: &[f64]) -> String {
    const ROW: f64 = 22.0;
    const TOP: f64 = 8.0;
    const WIDTH: f64 = 420.0;
    let labels: Vec<String> = rows.iter().map(|row| row.label.clone()).collect();
    let left = label_width(&labels) + 16.0;
    let (right, bottom) = (left + WIDTH, TOP + ROW * rows.len() as f64);
    let x = |value: f64| left + WIDTH * axis.place(value).clamp(-0.01, 1.01);
    let body = html! {
        @for tick in axis.ticks() {
            line x1=(px(x(tick))) x2=(px(x(tick))) y1=(px(TOP)) y2=(px(bottom)) stroke=(RULE) {}
            text x=(px(x(tick))) y=(px(bottom + 16.0)) text-anchor="middle" fill=(FAINT) {
                (number(tick)) }
        }
        @for value in rules {
            line x1=(px(x(*value))) x2=(px(x(*value))) y1=(px(TOP)) y2=(px(bottom)) stroke=(INK)
                stroke-dasharray="2 3" {}
        }
        text x=(px(left + WIDTH / 2.0)) y=(px(bottom + 34.0)) text-anchor="middle" { (axis.title) }
        @for (row, dot) in rows.iter().enumerate() {
            @let y = TOP + (row as f64 + 0.5) * ROW;
            text x=(px(left - 8.0)) y=(px(y + 4.0)) text-anchor="end" { (dot.label) }
            @if let Some([low, high]) = dot.interval {
                line x1=(px(x(low))) x2=(px(x(high))) y1=(px(y)) y2=(px(y)) stroke=(rgb(BLUE))
                    stroke-width="1.6" {}
            }
            @match dot.value {
                Some(value) => circle cx=(px(x(value))) cy=(px(y)) r="4" fill=(rgb(BLUE)) {},
                None => text x=(px(left + 6.0)) y=(px(y + 4.0)) fill=(FAINT) { "not known" },
            }
        }
    };
    svg(right + 24.0, bottom + 42.0, label, &body)
}

/// A table of shares as a heat map with numbers. `cell(row, column)` is the share from 0 (orange)
/// through ½ (white) to 1 (blue), and what is written; none leaves the cell grey.
pub fn heat(
    label: &str,
    rows: &[String],
    columns: &[String],
    cell: impl Fn(usize, usize) -> Option<(f64, String)>,
) -> String {
    let cells: Vec<Vec<Option<(f64, String)>>> =
        (0..rows.len()).map(|i| (0..columns.len()).map(|j| cell(i, j)).collect()).collect();
    let longest =
        cells.iter().flatten().flatten().map(|(_, text)| text.chars().count()).max().unwrap_or(1);
    let side = (CHARACTER * longest as f64 + 14.0).max(34.0);
    let (rows_width, header) = (label_width(rows), label_width(columns));
    // Column labels lie flat where they fit into their cells.
    let upright = header > side;
    let (left, top) = (rows_width + 12.0, if upright { header + 12.0 } else { 24.0 });
    let (width, height) = (side * columns.len() as f64, side * rows.len() as f64);
    let body = html! {
        @for (i, label) in rows.iter().enumerate() {
            text x=(px(left - 8.0)) y=(px(top + (i as f64 + 0.5) * side + 4.0)) text-anchor="end" {
                (label) }
        }
        @for (j, label) in columns.iter().enumerate() {
            @let middle = left + (j as f64 + 0.5) * side;
            @if upright {
                text transform=(upwards(middle + 4.0, top - 7.0)) { (label) }
            } @else {
                text x=(px(middle)) y=(px(top - 7.0)) text-anchor="middle" { (label) }
            }
        }
        @for (i, row) in cells.iter().enumerate() {
            @for (j, cell) in row.iter().enumerate() {
                @let (x, y) = (left + j as f64 * side, top + i as f64 * side);
                @let fill = cell.as_ref().map_or(RULE.to_string(), |(share, _)| diverging(*share));
                rect x=(px(x)) y=(px(y)) width=(px(side)) height=(px(side)) fill=(fill) stroke="#fff" {}
                @if let Some((share, text)) = cell {
                    text x=(px(x + side / 2.0)) y=(px(y + side / 2.0 + 4.0)) text-anchor="middle"
                        fill=(if (share - 0.5).abs() > 0.35 { "#fff" } else { INK }) { (text) }
                }
            }
        }
    };
    svg(left + width + 1.0, top + height + 1.0, label, &body)
}

/// An `svg` element of that size.
pub(crate) fn svg(width: f64, height: f64, label: &str, body: &Markup) -> String {
    let page = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width:.1} {height:.1}"))
            width=(px(width)) height=(px(height)) role="img" aria-label=(label)
            font-family="system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif" font-size="12"
            fill=(INK) { (body) }
    };
    page.into_string()
}

/// A round step that divides a range into about five.
fn step(low: f64, high: f64) -> f64 {
    let rough = (high - low) / 5.0;
    let power = libm::pow(10.0, libm::log10(rough).floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    power * steps.iter().copied().find(|step| step * power >= rough * (1.0 - 1e-9)).unwrap_or(10.0)
}

/// A tick's number, without the noise of its computation.
fn number(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    if rounded == 0.0 { "0".into() } else { format!("{rounded}") }
}

pub(crate) fn label_width(labels: &[String]) -> f64 {
    CHARACTER * labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64
}

/// White at ½, blue towards 1, orange towards 0.
fn diverging(share: f64) -> String {
    let (end, amount) =
        if share >= 0.5 { (BLUE, 2.0 * share - 1.0) } else { (ORANGE, 1.0 - 2.0 * share) };
    let mix = |channel: usize| WHITE[channel] + amount * (end[channel] - WHITE[channel]);
    rgb([mix(0), mix(1), mix(2)])
}

pub(crate) fn rgb([r, g, b]: [f64; 3]) -> String {
    format!("rgb({r:.0},{g:.0},{b:.0})")
}

/// Moves a text to (x, y) and turns it to read upwards.
pub(crate) fn upwards(x: f64, y: f64) -> String {
    format!("translate({x:.1} {y:.1}) rotate(-90)")
}

pub(crate) fn px(length: f64) -> String {
    format!("{length:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_orange_through_white_to_blue() {
        assert_eq!(diverging(0.0), rgb(ORANGE));
        assert_eq!(diverging(0.5), "rgb(255,255,255)");
        assert_eq!(diverging(1.0), rgb(BLUE));
    }

    #[test]
    fn axes_hold_their_values_in_round_steps() {
        let axis = Axis::of("share", [0.13, 0.87, f64::NAN]);
        assert_eq!(axis.range, [0.0, 1.0]);
        assert_eq!(axis.ticks().len(), 6);
        assert_eq!(Axis::of("none", []).range, [0.0, 1.0]);
        assert_eq!(Axis::of("one", [3.0, 3.0]).range, [2.5, 3.5]);
        let logarithmic = Axis::logarithmic("v", [1.0, 100.0]);
        assert_eq!(logarithmic.ticks(), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert!((logarithmic.place(10.0) - 0.5).abs() < 1e-12);
    }
}
