//! The section on equivalence.

use super::{HOLM, not_known};
use crate::outcome::Outcome;
use crate::paired::equivalence::PairEquivalence;
use crate::report::labels::counted;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{Cell, Column, Figure, Kind, Section, Table};

/// Which stimuli of one group are shown to be interchangeable.
pub fn equivalence(pairs: &Outcome<Vec<PairEquivalence>>) -> Section {
    let heading = "Equivalence within groups";
    let pairs = match pairs {
        Ok(pairs) => pairs,
        Err(reason) => return not_known(heading, reason),
    };
    let Some(any) = pairs.first() else { return not_known(heading, "there are no pairs") };
    let (margin, alpha, level) = (any.test.margin, any.test.alpha, any.test.level);
    let n = counted(pairs.len(), "pair");
    let shown: Vec<String> = pairs
        .iter()
        .filter(|pair| pair.equivalent)
        .map(|pair| format!("{} and {} ({})", pair.item, pair.other, pair.p_holm.equation()))
        .collect();
    let how = format!(
        "two one-sided exact binomial tests against ½ ± {margin}, α = {alpha}, corrected for {n} by Holm"
    );
    let mut sentences = vec![match shown.is_empty() {
        true => format!(
            "no two stimuli of one group are shown to be equivalent within ±{margin} ({how})"
        ),
        false => format!("equivalent within ±{margin} ({how}): {}", shown.join(", ")),
    }];
    let hopeless = pairs.iter().filter(|pair| pair.test.smallest_p.value() > alpha).count();
    if hopeless > 0 {
        sentences.push(format!(
            "{hopeless} of {n} have too few answers: however even, they could not show equivalence within \
             ±{margin} (p = {} at best for n = {})",
            any.test.smallest_p, any.test.trials
        ));
    }
    sentences.push(
        "what is not shown to be equivalent is not shown to be different: the data leave both open"
            .into(),
    );
    Section {
        heading: heading.into(),
        sentences,
        tables: vec![table(pairs, margin, level)],
        figures: vec![Figure {
            name: "equivalence".into(),
            caption: format!(
                "Share of the first stimulus of each pair with Clopper and Pearson's {:.0} % interval. \
                 Before correction a pair is equivalent where the interval lies between the outer lines, \
                 at ½ ± {margin}.",
                100.0 * level
            ),
            svg: figure(pairs, margin),
        }],
        method: vec![
            "That two scores do not differ significantly does not show that the stimuli are \
             interchangeable. For each pair within one group two one-sided tests (Schuirmann 1987) ask \
             whether the share is both above ½ less the margin and below ½ plus it, by exact binomial tests; \
             p is the larger of the two. They reject at α where the exact interval at 1 − 2α lies within \
             the margin. Corrected by Holm (1979)."
                .into(),
        ],
        references: vec![
            HOLM,
            "Schuirmann, D. J. (1987). A comparison of the two one-sided tests procedure and the power \
             approach for assessing the equivalence of average bioavailability. Journal of \
             Pharmacokinetics and Biopharmaceutics 15, 657–680.",
        ],
    }
}

fn table(pairs: &[PairEquivalence], margin: f64, level: f64) -> Table {
    let bound = |name: &str, title: &str, which: &str| {
        let description = format!("{which} bound of the exact {:.0} % interval.", 100.0 * level);
        Column::new(name, title, Kind::Number(3), &description)
    };
    let rows = pairs.iter().map(|pair| {
        vec![
            Cell::from(pair.item.as_str()),
            pair.other.as_str().into(),
            pair.test.chosen.into(),
            pair.test.trials.into(),
            pair.test.interval[0].into(),
            pair.test.interval[1].into(),
            pair.test.p.into(),
            pair.p_holm.into(),
            pair.equivalent.into(),
            pair.test.smallest_margin.into(),
        ]
    });
    Table {
        name: "equivalence".into(),
        caption: format!(
            "Pairs within one group: are their shares within ½ ± {margin}? Corrected for {}.",
            counted(pairs.len(), "pair")
        ),
        columns: vec![
            Column::new("item", "stimulus", Kind::Text, "Id of the stimulus."),
            Column::new("other", "other", Kind::Text, "Id of the other."),
            Column::new("chosen", "chosen", Kind::Integer, "How often item was chosen over other."),
            Column::new("trials", "of", Kind::Integer, "Number of trials."),
            bound("interval_low", "interval", "Lower"),
            bound("interval_high", "to", "Upper"),
            Column::new("p", "p", Kind::P, "Larger p of the two one-sided exact tests."),
            Column::new("p_holm", "p (Holm)", Kind::P, "p corrected by Holm (1979)."),
            Column::new(
                "equivalent",
                "equivalent",
                Kind::Flag,
                "Whether p_holm does not exceed α: shown to be equivalent within the margin.",
            ),
            Column::new(
                "smallest_margin",
                "smallest margin",
                Kind::Number(3),
                "The smallest margin within which these answers would show equivalence at α, uncorrected.",
            ),
        ],
        rows: rows.collect(),
    }
}

fn figure(pairs: &[PairEquivalence], margin: f64) -> String {
    let axis = Axis { title: "share".into(), range: [0.0, 1.0], logarithmic: false };
    let rows: Vec<Dot> = pairs
        .iter()
        .map(|pair| Dot {
            label: format!("{} : {}", pair.item, pair.other),
            value: Some(pair.test.chosen as f64 / pair.test.trials as f64),
            interval: Some(pair.test.interval),
        })
        .collect();
    dots("Equivalence", &axis, &rows, &[0.5 - margin, 0.5, 0.5 + margin])
}
