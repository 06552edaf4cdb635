//! The figures, as SVG inside the page. Lengths are in CSS pixels.

use super::labels::letter;
use crate::analysis::{Analysis, Consistency};
use maud::{Markup, html};

const BLUE: [f64; 3] = [33.0, 94.0, 138.0];
const ORANGE: [f64; 3] = [190.0, 92.0, 25.0];
const WHITE: [f64; 3] = [255.0, 255.0, 255.0];
const INK: &str = "#1c2126";
const RULE: &str = "#c9d0d6";
/// Room for one character of a label.
const CHARACTER: f64 = 7.2;

/// Votes per stimulus as bars, and the groups as brackets beside them.
pub fn votes(analysis: &Analysis, labels: &[String]) -> Markup {
    const ROW: f64 = 26.0;
    const BAR: f64 = 16.0;
    const TOP: f64 = 22.0;
    const WIDTH: f64 = 420.0;
    const BRACKET: f64 = 22.0;
    let rows = labels.len() as f64;
    let left = label_width(labels) + 12.0;
    let groups = analysis.grouping.as_ref().map_or(&[][..], |grouping| &grouping.groups);
    let right = left + WIDTH + 24.0;
    let scale = votes_scale(analysis);
    let most = scale.last().copied().unwrap_or(1);
    let x = |votes: f64| left + WIDTH * votes / most as f64;
    let bottom = TOP + rows * ROW;
    let (width, height) = (right + groups.len() as f64 * BRACKET + 8.0, bottom + 62.0);
    html! {
        svg viewBox=(view_box(width, height)) width=(px(width)) height=(px(height)) role="img"
            aria-label="Votes per stimulus, and groups" {
            @for votes in &scale {
                line x1=(px(x(*votes as f64))) x2=(px(x(*votes as f64)))
                    y1=(px(TOP)) y2=(px(bottom)) stroke=(RULE) {}
                text x=(px(x(*votes as f64))) y=(px(bottom + 16.0)) text-anchor="middle" class="faint" {
                    (votes)
                }
            }
            @for (row, (label, votes)) in labels.iter().zip(&analysis.votes).enumerate() {
                @let middle = TOP + (row as f64 + 0.5) * ROW;
                text x=(px(left - 8.0)) y=(px(middle + 4.0)) text-anchor="end" { (label) }
                rect x=(px(left)) y=(px(middle - BAR / 2.0))
                    width=(px(x(*votes as f64) - left)) height=(px(BAR)) fill=(rgb(BLUE)) {}
                // Inside the bar where there is room, else just outside it.
                @if x(*votes as f64) - left > 34.0 {
                    text x=(px(x(*votes as f64) - 6.0)) y=(px(middle + 4.0)) text-anchor="end"
                        class="light" { (votes) }
                } @else {
                    text x=(px(x(*votes as f64) + 5.0)) y=(px(middle + 4.0)) { (votes) }
                }
            }
            line x1=(px(left)) x2=(px(left)) y1=(px(TOP)) y2=(px(bottom)) stroke=(INK) {}
            text x=(px(left + WIDTH / 2.0)) y=(px(bottom + 33.0)) text-anchor="middle"
                class="faint" { "votes" }
            @if let Some(grouping) = &analysis.grouping {
                @let (start, end, y) = (x(0.0), x(grouping.r_c as f64), bottom + 46.0);
                path d=(format!("M{start:.1} {:.1}v8m0 -4H{end:.1}m0 -4v8", y - 4.0))
                    stroke=(INK) fill="none" {}
                text x=(px(end + 6.0)) y=(px(y + 4.0)) {
                    "R" tspan dy="3" font-size="9" { "c" } tspan dy="-3" { " = " (grouping.r_c) }
                }
            }
            @for (index, group) in groups.iter().enumerate() {
                @let x = right + (index as f64 + 0.5) * BRACKET;
                @let first = analysis.items.iter().position(|item| Some(item) == group.first());
                @let first = first.unwrap_or(0);
                @let from = TOP + first as f64 * ROW + 4.0;
                @let to = TOP + (first + group.len()) as f64 * ROW - 4.0;
                path d=(format!("M{:.1} {from:.1}h6V{to:.1}h-6", x - 3.0))
                    stroke=(INK) stroke-width="2" fill="none" {}
                text x=(px(x)) y=(px(TOP - 8.0)) text-anchor="middle" { (letter(index)) }
            }
        }
    }
}

/// The preference matrix as a heat map with numbers: row chosen over column.
pub fn matrix(matrix: &[Vec<u64>], labels: &[String]) -> Markup {
    let digits = matrix.iter().flatten().max().map_or(1, |most| most.to_string().len());
    let cell = (CHARACTER * digits as f64 + 14.0).max(34.0);
    let header = label_width(labels);
    // Column labels lie flat where they fit into their cells.
    let upright = header > cell;
    let (left, top) = (header + 12.0, if upright { header + 12.0 } else { 24.0 });
    let size = cell * labels.len() as f64;
    let (width, height) = (left + size + 1.0, top + size + 1.0);
    html! {
        svg viewBox=(view_box(width, height)) width=(px(width)) height=(px(height)) role="img"
            aria-label="Preference matrix" {
            @for (i, label) in labels.iter().enumerate() {
                @let middle = (i as f64 + 0.5) * cell;
                text x=(px(left - 8.0)) y=(px(top + middle + 4.0)) text-anchor="end" { (label) }
                @if upright {
                    text transform=(upwards(left + middle + 4.0, top - 7.0)) { (label) }
                } @else {
                    text x=(px(left + middle)) y=(px(top - 7.0)) text-anchor="middle" { (label) }
                }
            }
            @for (i, row) in matrix.iter().enumerate() {
                @let own = (left + i as f64 * cell, top + i as f64 * cell);
                rect x=(px(own.0)) y=(px(own.1)) width=(px(cell)) height=(px(cell)) fill=(RULE)
                    stroke="#fff" {}
                @for (j, wins) in row.iter().enumerate().filter(|(j, _)| *j != i) {
                    @let trials = wins + matrix[j][i];
                    @let share = if trials == 0 { 0.5 } else { *wins as f64 / trials as f64 };
                    @let (x, y) = (left + j as f64 * cell, top + i as f64 * cell);
                    rect x=(px(x)) y=(px(y)) width=(px(cell)) height=(px(cell))
                        fill=(diverging(share)) stroke="#fff" {}
                    text x=(px(x + cell / 2.0)) y=(px(y + cell / 2.0 + 4.0)) text-anchor="middle"
                        class=(if (share - 0.5).abs() > 0.35 { "light" } else { "" }) {
                        @if trials == 0 { "–" } @else { (wins) }
                    }
                }
            }
        }
    }
}

/// ζ of every observer, and the pooled ζ as a line.
pub fn zeta(consistency: &Consistency) -> Markup {
    const LEFT: f64 = 44.0;
    const TOP: f64 = 12.0;
    const HEIGHT: f64 = 170.0;
    let names: Vec<String> = consistency
        .per_observer
        .iter()
        .map(|o| {
            let several = |same: &dyn Fn(&crate::analysis::ObserverConsistency) -> bool| {
                consistency.per_observer.iter().filter(|other| same(other)).count() > 1
            };
            match several(&|other| other.subject == o.subject) {
                true => format!("{} {}.{}", o.subject, o.session, o.repetition),
                false => o.subject.clone(),
            }
        })
        .collect();
    let observers = names.len() as f64;
    let step = (600.0 / observers).clamp(14.0, 40.0);
    let right = LEFT + step * observers;
    let bottom = TOP + HEIGHT;
    let y = |zeta: f64| bottom - HEIGHT * zeta;
    let pooled = y(consistency.zeta);
    let (width, height) = (right + 100.0, bottom + label_width(&names) + 16.0);
    html! {
        svg viewBox=(view_box(width, height)) width=(px(width)) height=(px(height)) role="img"
            aria-label="Coefficient of consistency per observer" {
            @for tick in [0.0, 0.25, 0.5, 0.75, 1.0] {
                line x1=(px(LEFT)) x2=(px(right)) y1=(px(y(tick))) y2=(px(y(tick)))
                    stroke=(RULE) {}
                text x=(px(LEFT - 6.0)) y=(px(y(tick) + 4.0)) text-anchor="end" class="faint" {
                    (tick)
                }
            }
            line x1=(px(LEFT)) x2=(px(right)) y1=(px(pooled)) y2=(px(pooled))
                stroke=(rgb(ORANGE)) stroke-width="1.5" {}
            text x=(px(right + 6.0)) y=(px(pooled + 4.0)) {
                "pooled " (format!("{:.3}", consistency.zeta))
            }
            @for (i, (name, observer)) in names.iter().zip(&consistency.per_observer).enumerate() {
                @let x = LEFT + (i as f64 + 0.5) * step;
                line x1=(px(x)) x2=(px(x)) y1=(px(bottom)) y2=(px(y(observer.zeta))) stroke=(RULE) {}
                circle cx=(px(x)) cy=(px(y(observer.zeta))) r="4" fill=(rgb(BLUE)) {}
                text transform=(upwards(x + 4.0, bottom + 8.0)) text-anchor="end" { (name) }
            }
        }
    }
}

/// Round numbers of votes from 0 to at least the most that one stimulus has.
fn votes_scale(analysis: &Analysis) -> Vec<u64> {
    let most = analysis.votes.iter().copied().max().unwrap_or(0).max(1);
    let most = most.max(analysis.grouping.as_ref().map_or(0, |grouping| grouping.r_c));
    let powers = (0..18).map(|power| 10_u64.pow(power));
    let step = powers.flat_map(|power| [power, 2 * power, 5 * power]).find(|step| most / step < 6);
    let step = step.unwrap_or(most);
    (0..=most.div_ceil(step)).map(|tick| tick * step).collect()
}

fn label_width(labels: &[String]) -> f64 {
    CHARACTER * labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64
}

/// White at ½, blue towards 1, orange towards 0.
fn diverging(share: f64) -> String {
    let (end, amount) =
        if share >= 0.5 { (BLUE, 2.0 * share - 1.0) } else { (ORANGE, 1.0 - 2.0 * share) };
    let mix = |channel: usize| WHITE[channel] + amount * (end[channel] - WHITE[channel]);
    rgb([mix(0), mix(1), mix(2)])
}

fn rgb([r, g, b]: [f64; 3]) -> String {
    format!("rgb({r:.0},{g:.0},{b:.0})")
}

fn view_box(width: f64, height: f64) -> String {
    format!("0 0 {width:.1} {height:.1}")
}

/// Moves a text to (x, y) and turns it to read upwards.
fn upwards(x: f64, y: f64) -> String {
    format!("translate({x:.1} {y:.1}) rotate(-90)")
}

fn px(length: f64) -> String {
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
}
