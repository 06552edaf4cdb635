//! The section on the level of the groups by score differences.

use super::not_known;
use crate::outcome::Outcome;
use crate::paired::level_check::LevelCheck;
use crate::report::section::Section;

/// How often simulated studies without differences show one.
pub fn level_check(check: &Outcome<LevelCheck>) -> Section {
    let heading = "Level of the groups";
    let check = match check {
        Ok(check) => check,
        Err(reason) => return not_known(heading, reason),
    };
    let [low, high] = check.interval_95;
    Section {
        heading: heading.into(),
        sentences: vec![format!(
            "the largest score difference reached R_c = {} in {} of {} simulated studies without a \
             difference ({}), that is {:.4} (95 % interval {low:.4} to {high:.4}) for α = {} (n = {}, \
             t = {})",
            check.r_c,
            check.rejections,
            check.studies,
            match check.spread {
                0.0 => "answers by fair coins".to_string(),
                spread => format!("observers with preferences of their own, SD {spread} logits"),
            },
            check.level,
            check.alpha,
            check.observers,
            check.stimuli
        )],
        method: vec![
            "The critical difference rests on a large-sample distribution. For a check of its level, studies \
             are simulated in which no stimulus is better on the whole: with a fair coin for every answer, \
             or with observers who each have normally distributed preferences of their own. The interval is \
             Clopper and Pearson's (1934)."
                .into(),
        ],
        references: vec![
            "Clopper, C. J. and Pearson, E. S. (1934). The use of confidence or fiducial limits \
             illustrated in the case of the binomial. Biometrika 26, 404–413.",
        ],
        ..Section::default()
    }
}
