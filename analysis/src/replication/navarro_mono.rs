//! Chapter 5 of Navarro's thesis (2012): the monoscopic experiments.

use super::factors::factor_effect;
use super::table::VoteTable;
use super::{Line, Value, shares};
use crate::error::InputError;

/// Why what was drawn cannot be checked.
pub const ONLY_DRAWN: &str = "the numbers are only drawn in a figure, which is not at hand";
/// Why means of times cannot be compared.
pub const NO_SPREAD: &str = "a mean without its spread cannot be tested";

/// Every printed number and conclusion, in the order of the text.
pub fn lines() -> Result<Vec<Line>, InputError> {
    Ok([stimuli(), test_1(), test_2_matching(), test_2_preference()?, test_3()?].concat())
}

/// §5.3 and §5.4: stimuli and people.
fn stimuli() -> Vec<Line> {
    vec![
        Line::count("5.3", "sequences: levels of Table 5.1, 3 · 3 · 5 · 5", 225, 3 * 3 * 5 * 5),
        Line::compared(
            "5.3",
            "samples of the noiseless level",
            "255",
            "512 (A5 of Table 5.1)",
            false,
        )
        .noting("Text and table disagree; Table 6.2 has 512 as well."),
        Line::compared("5.4", "participants", "21: 16 + 5, 9 + 12", "16 + 5 = 9 + 12 = 21", true),
        viewing_angle("5.4", [1600.0, 900.0], true),
    ]
}

/// The visual angle of 640 pixels of a 17.3-inch display at 60 cm.
pub fn viewing_angle(section: &'static str, [width, height]: [f64; 2], agrees: bool) -> Line {
    let diagonal = libm::sqrt(width * width + height * height);
    let image_cm = 640.0 * 17.3 * 2.54 / diagonal;
    let degrees = 2.0 * libm::atan(0.5 * image_cm / 60.0).to_degrees();
    let distance = 0.5 * image_cm / libm::tan(7.2_f64.to_radians());
    let what = format!("visual angle of 640 px, 17.3\" {width}×{height}, about 60 cm");
    Line::compared(section, &what, "14.4°", format!("{degrees:.1}°"), agrees)
        .noting(format!("14.4° are seen from {distance:.1} cm."))
}

/// §5.5: broad comparison.
fn test_1() -> Vec<Line> {
    const FEWEST: u64 = 21 * 8;
    let preferred = |what, percent| {
        let printed = format!("{percent} %: p ≤ 0.05 (χ²)");
        shares::of_at_least("5.5.2", what, &printed, (percent, 0), true, FEWEST)
    };
    vec![
        Line::compared(
            "5.5.1",
            "pairs of 16 films that were asked",
            "all combinations",
            "120 pairs are 16 min of film",
            false,
        )
        .noting("Participants were done in 8:28 to 11:23 minutes on average (§5.5.2)."),
        preferred("noise (M3) over checker (M2)", 67.0),
        preferred("medium speed (S2) over fast (S3)", 66.0),
        preferred("medium shutter (T3) over long (T5)", 70.0),
        // "5 % more votes": 52.5 against 47.5 %.
        shares::of_at_least(
            "5.5.2",
            "samples A5 over A3",
            "just 5 % more votes: no clear preference",
            (52.5, 0),
            false,
            FEWEST,
        ),
        Line::unknown(
            "5.5.2",
            "experienced and naive people",
            Some("no significant difference".into()),
            ONLY_DRAWN,
        ),
        Line::unknown(
            "5.5.2",
            "time of experienced and naive people",
            Some("11:23 and 8:28 min".into()),
            NO_SPREAD,
        )
        .noting("Nine experienced and twelve naive people make 9:43 minutes on average."),
    ]
}

/// §5.6.1 and §5.6.2: matching.
fn test_2_matching() -> Vec<Line> {
    const TRIALS: u64 = 16 * 10;
    let drawn =
        |what: &str, printed: &str| Line::unknown("5.6.2", what, Some(printed.into()), ONLY_DRAWN);
    let of = |what, percent| shares::of_trials("5.6.2", what, percent, 2, TRIALS, 16);
    let mut lines = of("shutter times matched", 86.25);
    lines.extend(of("sampling levels matched", 63.75));
    lines.extend([
        shares::difference(
            "5.6.2",
            "sampling levels beside shutter times",
            "more challenging",
            [138, 102],
            TRIALS,
        ),
        drawn("T1, T2 and T3", "visually equivalent"),
        drawn("T4 and T5", "distinguishable"),
        drawn("A4 and A5", "near chance, indistinguishable").noting(
            "Each pair was matched by 16 people: 8 right ones leave 28 to 72 % (Wilson, 95 %), so chance \
             is not told from much.",
        ),
        Line::unknown(
            "5.6.2",
            "time of shutter and sampling task",
            Some("6:12 and 7:49 min".into()),
            NO_SPREAD,
        ),
        Line::unknown(
            "5.6.3",
            "experienced people match better by",
            Some("11 % (shutter), 4 % (samples)".into()),
            "how many of the sixteen were experienced is not printed",
        ),
    ]);
    lines
}

/// §5.6.3: preference among sampling levels.
fn test_2_preference() -> Result<Vec<Line>, InputError> {
    let table = VoteTable::new("mono-sampling", "5.6.3")?;
    let items = &table.analysis.items;
    let mut lines = table.lines();
    lines.extend([
        Line::compared(
            "5.6.3",
            "high over low levels, consistently",
            "A5, A4, A3, A2, A1",
            table.ranking(),
            items.iter().rev().is_sorted(),
        ),
        table.equivalence("indistinguishable"),
    ]);
    Ok(lines)
}

/// §5.7 and §5.8: shutter and samples together.
fn test_3() -> Result<Vec<Line>, InputError> {
    let table = VoteTable::new("mono-shutter-sampling", "5.7.2")?;
    let group = |number: usize| table.groups().get(number).cloned().unwrap_or_default();
    let shutter = |level: &str, items: &[String]| items.iter().all(|item| item.ends_with(level));
    let all_of = |level: &str, items: &[String]| shutter(level, items) && items.len() == 3;
    let is_in_first = |item: &str| group(0).iter().any(|other| other == item);
    let mut lines = vec![
        Line::compared(
            "5.7.1",
            "material, as was preferred before",
            "checker (M2)",
            "noise (M3), 67 % in §5.5.2",
            false,
        ),
        Line::count("5.7.1", "pairs of 9 films, 9 · 8/2", 36, 9 * 8 / 2),
    ];
    lines.extend(table.lines());
    lines.extend([
        table.range_of_u(21),
        Line::compared(
            "5.7.2",
            "group 1",
            "all of T3, and T4 with the lowest sampling levels",
            Value::Groups(vec![group(0)]),
            ["A3T3", "A4T3", "A5T3", "A3T4"].into_iter().all(is_in_first) && !is_in_first("A5T4"),
        )
        .noting(
            "The votes put A5T4 and A4T4, the highest levels, into group 1, and leave A3T4 out. With group 1 \
             as the text has it, the pair of Figure 5.8 (§5.8) would share it; it does not.",
        ),
        Line::compared(
            "5.7.2",
            "group 2",
            "all of T4",
            Value::Groups(vec![group(1)]),
            all_of("T4", &group(1)),
        ),
        Line::compared(
            "5.7.2",
            "group 4",
            "all of T5",
            Value::Groups(vec![group(3)]),
            all_of("T5", &group(3)),
        ),
    ]);
    lines.extend(factor_lines("5.7.2", &table));
    lines.extend([
        table.equivalence("perceptually equivalent"),
        table.pair("5.7.2", ["A3T5", "A5T5"], "equivalent (Figure 5.7)", true),
        table.pair("5.8", ["A5T3", "A3T4"], "indistinguishable (Figure 5.8)", true),
    ]);
    Ok(lines)
}

/// Whether the shutter drives the answers and the samples do not, from the votes of each level.
pub fn factor_lines(section: &'static str, table: &VoteTable) -> Vec<Line> {
    let (items, votes) = (&table.analysis.items, &table.analysis.votes);
    let n = table.published.observers;
    let shutter = factor_effect(items, votes, n, |item| item.get(2..).unwrap_or(item));
    let samples = factor_effect(items, votes, n, |item| item.get(..2).unwrap_or(item));
    let levels = |levels: &[(String, u64)]| {
        levels
            .iter()
            .map(|(level, votes)| format!("{level} {votes}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let test = "df = 2, upper tail, χ² approximation: its part of D.";
    let (drives, follows) = (shutter.p.value() <= 0.01, samples.p.value() > 0.01);
    vec![
        Line::compared(
            section,
            "shutter time",
            "drives the answers",
            format!("χ² = {:.1}, {}", shutter.chi2, shutter.p.equation()),
            drives,
        )
        .noting(format!("Votes: {}; {test}", levels(&shutter.levels))),
        Line::compared(
            section,
            "sampling level",
            "takes a secondary role",
            format!("χ² = {:.2}, {}", samples.chi2, samples.p.equation()),
            drives && follows && samples.chi2 < shutter.chi2,
        )
        .noting(format!("Votes: {}; {test}", levels(&samples.levels))),
    ]
}
