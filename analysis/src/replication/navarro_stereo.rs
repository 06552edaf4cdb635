//! Chapter 6 of Navarro's thesis (2012): the stereoscopic experiments.

use super::navarro_mono::{ONLY_DRAWN, factor_lines, viewing_angle};
use super::published::find;
use super::table::VoteTable;
use super::{Line, Value};
use crate::error::InputError;

/// Every printed number and conclusion, in the order of the text.
pub fn lines() -> Result<Vec<Line>, InputError> {
    let shutter = VoteTable::new("stereo-shutter", "6.5.2.1")?;
    let samples = VoteTable::new("stereo-sampling", "6.5.2.2")?;
    let both = VoteTable::new("stereo-shutter-sampling", "6.6.2")?;
    Ok([
        overview(),
        test_1(),
        test_2_shutter(&shutter),
        test_2_samples(&samples),
        test_3(&both),
        conclusions(&samples),
    ]
    .concat())
}

/// §6.2 and §6.3: stimuli and people.
fn overview() -> Vec<Line> {
    vec![
        Line::count("6.2.1", "sequences: levels of Table 5.1, 3 · 3 · 5 · 5", 225, 3 * 3 * 5 * 5),
        Line::compared("6.3", "participants of a test", "18 to 32", "16 in test 2 (§6.5.1)", false)
            .noting("32 is reached by counting the two full tests of each of sixteen people."),
        Line::compared("6.3", "2AFC tests repeated", "four", "1 + 2 + 1 (Table 6.1)", true),
        viewing_angle("6.3", [1680.0, 1050.0], false),
    ]
}

/// §6.4: broad comparison.
fn test_1() -> Vec<Line> {
    let drawn =
        |what: &str, printed: &str| Line::unknown("6.4", what, Some(printed.into()), ONLY_DRAWN);
    vec![
        Line::compared(
            "6.4",
            "preferences on all four axes",
            "p ≤ 0.05 (χ²) in all cases",
            "speed \"balanced\", samples \"equally preferable\"",
            false,
        )
        .noting(
            "The section says both. A χ² test with p ≤ 0.05 is not that of a balanced preference.",
        ),
        drawn("noise (M3) beside the monoscopic 67 %", "less than 2 % apart"),
        drawn("medium speed (S2) beside the monoscopic 66 %", "more than 15 % apart, yet similar")
            .noting(
                "At most 51 % then, if balanced. With the 168 monoscopic answers of §5.5.2 and 144 \
                 (18 people, 8 pairs) the difference would have z = 2.7, p = 0.007.",
            ),
        drawn("medium shutter (T3) over long (T5)", "the most defined preference"),
        drawn("samples A3 and A5", "equally preferable"),
    ]
}

/// §6.5.2.1: preference among shutter times.
fn test_2_shutter(table: &VoteTable) -> Vec<Line> {
    let in_all = |item: &str| table.groups().iter().all(|group| group.iter().any(|i| i == item));
    let best: Vec<&str> = table.analysis.items.iter().take(3).map(String::as_str).collect();
    let mut lines = table.lines();
    lines.extend([
        table.range_of_u(31),
        Line::compared(
            "6.5.2.1",
            "most voted: middle shutter times",
            "T4, T3, T2",
            table.ranking(),
            best == ["T4", "T3", "T2"],
        ),
        Line::compared(
            "6.5.2.1",
            "where the two groups overlap",
            "T2",
            Value::Groups(table.groups().to_vec()),
            in_all("T2") && !in_all("T3") && !in_all("T5"),
        ),
        table.pair("6.5.2.1", ["T1", "T5"], "equally weighted", true),
        table.pair("5.6.2", ["T4", "T5"], "distinguishable", false),
    ]);
    lines
}

/// §6.5.2.2: preference among sampling levels.
fn test_2_samples(table: &VoteTable) -> Vec<Line> {
    let mut lines = table.lines();
    lines.push(table.range_of_u(31));
    if let Ok(test) = &table.analysis.score_equality {
        let ours = format!("D = {:.2}, df = {}, {}", test.d, test.df, test.p.equation());
        let (what, printed) = ("equality of all levels", "lack of any clear preference");
        lines.push(Line::compared("6.5.2.2", what, printed, ours, test.p.value() > 0.01).noting(
            "At α = 0.01, as tested. At 0.05 equality is refused; A1 has the fewest votes.",
        ));
    }
    let mono = find("mono-sampling").and_then(|mono| mono.groups).unwrap_or_default();
    let groups = mono.iter().map(|group| group.iter().map(|i| i.to_string()).collect()).collect();
    lines.extend([
        Line::compared(
            "6.5.2.2",
            "monoscopic groups, quoted",
            "three overlapping: A1, A2/A3/A4, A3/A4/A5",
            Value::Groups(groups),
            true,
        )
        .noting("The group of A1 overlaps with none."),
        table.equivalence("all equivalent to the gold standard"),
    ]);
    lines
}

/// §6.6.2: shutter and samples together.
fn test_3(table: &VoteTable) -> Vec<Line> {
    let group = |number: usize| table.groups().get(number).cloned().unwrap_or_default();
    let has = |items: &[String], level: &str| items.iter().any(|item| item.ends_with(level));
    let shared = group(1).iter().filter(|item| group(2).contains(item)).count();
    let of =
        |name: &str| find(name).map_or((0.0, 0.0), |t| (t.zeta.unwrap_or(0.0), t.u.unwrap_or(0.0)));
    let ((zeta, u), (low_zeta, low_u), (high_zeta, high_u)) =
        (of("stereo-shutter-sampling"), of("stereo-sampling"), of("stereo-shutter"));
    let mut lines = vec![
        Line::compared(
            "6.6.1",
            "material, as was preferred before",
            "checker (M2)",
            "noise (M3), in §5.5.2 and §6.4",
            false,
        ),
        Line::count("6.6.1", "pairs of 9 films, 9 · 8/2", 36, 9 * 8 / 2),
    ];
    lines.extend(table.lines());
    lines.extend([
        table.range_of_u(35).noting("35 is the number of pairs less one; there are 18 judges."),
        Line::compared(
            "6.6.2",
            "group 1",
            "T3 and T4",
            Value::Groups(vec![group(0)]),
            !has(&group(0), "T5") && group(0).len() == 6,
        ),
        Line::compared(
            "6.6.2",
            "groups 2 and 3",
            "T4 and T5",
            Value::Groups(vec![group(1), group(2)]),
            !has(&group(1), "T3") && !has(&group(2), "T3"),
        )
        .noting(
            "A3T3, with the short shutter, is in group 2: it is 31 votes from A4T5, less than R_c.",
        ),
        Line::compared(
            "6.6.2",
            "groups 2 and 3 overlap",
            "almost completely",
            format!("{shared} of {} and {}", group(1).len(), group(2).len()),
            shared + 1 >= group(1).len().max(group(2).len()),
        ),
    ]);
    lines.extend(factor_lines("6.6.2", table));
    let levels_alike = ["T3", "T4", "T5"].into_iter().all(|shutter| {
        let votes = ["A3", "A4", "A5"].map(|samples| table.votes(&format!("{samples}{shutter}")));
        let most = votes.iter().max().copied().unwrap_or(0);
        most - votes.iter().min().copied().unwrap_or(0) < table.r_c()
    });
    lines.extend([
        Line::compared(
            "6.6.2",
            "samples with one shutter time",
            "no difference found",
            if levels_alike { "none of 9 reaches R_c" } else { "some reach R_c" },
            levels_alike,
        ),
        Line::compared(
            "6.6.2",
            "ζ between those of the two single axes",
            format!("{zeta}"),
            format!("{low_zeta} to {high_zeta}"),
            (low_zeta..=high_zeta).contains(&zeta),
        )
        .noting("By chance ζ is 0.5 with five stimuli and 0.3 with nine: they are not one scale."),
        Line::compared(
            "6.6.2",
            "u between those of the two single axes",
            format!("{u}"),
            format!("{low_u} to {high_u}"),
            (low_u..=high_u).contains(&u),
        ),
        table.equivalence("perceptually equivalent"),
    ]);
    lines
}

/// §6.7 and §7.3.
fn conclusions(samples: &VoteTable) -> Vec<Line> {
    vec![
        Line::compared(
            "6.7",
            "the pair of Figure 6.9",
            "different shutter times",
            "T5A1 and T5A5 (its caption)",
            false,
        )
        .noting("Text and caption disagree. A1 with T5 was in no test of which votes are printed."),
        Line::unknown(
            "6.7",
            "sampling levels, stereo",
            Some("cannot be differentiated".into()),
            "no difference shown at α = 0.01 is not equality, which was not tested",
        ),
        Line::count("7.3", "groups of sampling levels", 1, samples.groups().len() as u64),
    ]
}
