//! The figures of a paired comparison: votes with groups, the matrix of choices, and consistency.
//! Lengths are in CSS pixels.

use super::analysis::PairedComparison;
use super::consistency::{Consistency, ObserverConsistency};
use crate::report::labels::letter;
use crate::report::plot::{
    self, BLUE, FAINT, INK, ORANGE, RULE, label_width, px, rgb, svg, upwards,
};
use maud::html;

/// Votes per stimulus as bars, and the groups as brackets beside them.
pub fn votes(analysis: &PairedComparison, labels: &[String]) -> String {
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
    let body = html! {
            @for votes in &scale {
                line x1=(px(x(*votes as f64))) x2=(px(x(*votes as f64)))
                    y1=(px(TOP)) y2=(px(bottom)) stroke=(RULE) {}
                text x=(px(x(*votes as f64))) y=(px(bottom + 16.0)) text-anchor="middle" fill=(FAINT) {
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
                        fill="#fff" { (votes) }
                } @else {
                    text x=(px(x(*votes as f64) + 5.0)) y=(px(middle + 4.0)) { (votes) }
                }
            }
            line x1=(px(left)) x2=(px(left)) y1=(px(TOP)) y2=(px(bottom)) stroke=(INK) {}
            text x=(px(left + WIDTH / 2.0)) y=(px(bottom + 33.0)) text-anchor="middle"
                fill=(FAINT) { "votes" }
            @if let Ok(grouping) = &analysis.grouping {
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

    };
    svg(width, height, "Votes per stimulus, and groups", &body)
}

/// The preference matrix as a heat map with numbers: row chosen over column.
pub fn matrix(matrix: &[Vec<u64>], labels: &[String]) -> String {
    plot::heat("Preference matrix", labels, labels, |i, j| {
        let (wins, trials) = (matrix[i][j], matrix[i][j] + matrix[j][i]);
        let share = if trials == 0 { 0.5 } else { wins as f64 / trials as f64 };
        let text = if trials == 0 { "–".into() } else { wins.to_string() };
        (i != j).then_some((share, text))
    })
}

/// ζ of every observer, and the pooled ζ as a line.
pub fn zeta(consistency: &Consistency) -> String {
    const LEFT: f64 = 44.0;
    const TOP: f64 = 12.0;
    const HEIGHT: f64 = 170.0;
    let names: Vec<String> = consistency
        .per_observer
        .iter()
        .map(|o| {
            let several = |same: &dyn Fn(&ObserverConsistency) -> bool| {
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
    let body = html! {
            @for tick in [0.0, 0.25, 0.5, 0.75, 1.0] {
                line x1=(px(LEFT)) x2=(px(right)) y1=(px(y(tick))) y2=(px(y(tick)))
                    stroke=(RULE) {}
                text x=(px(LEFT - 6.0)) y=(px(y(tick) + 4.0)) text-anchor="end" fill=(FAINT) {
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

    };
    svg(width, height, "Coefficient of consistency per observer", &body)
}

/// Round numbers of votes from 0 to at least the most that one stimulus has.
fn votes_scale(analysis: &PairedComparison) -> Vec<u64> {
    let most = analysis.votes.iter().copied().max().unwrap_or(0).max(1);
    let most = most.max(analysis.grouping.as_ref().map_or(0, |grouping| grouping.r_c));
    let powers = (0..18).map(|power| 10_u64.pow(power));
    let step = powers.flat_map(|power| [power, 2 * power, 5 * power]).find(|step| most / step < 6);
    let step = step.unwrap_or(most);
    (0..=most.div_ceil(step)).map(|tick| tick * step).collect()
}
