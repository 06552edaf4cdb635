//! The section on Friedman's test and Kendall's W.

use super::not_known;
use crate::outcome::Outcome;
use crate::paired::friedman::Friedman;
use crate::report::section::Section;

/// Whether the observers order the stimuli alike.
pub fn concordance(friedman: &Outcome<Friedman>) -> Section {
    let heading = "Concordance of the scores";
    let test = match friedman {
        Ok(test) => test,
        Err(reason) => return not_known(heading, reason),
    };
    Section {
        heading: heading.into(),
        sentences: vec![format!(
            "W = {:.4} (0 without, 1 with perfect concordance), Friedman's χ² = {:.3}, df = {}, {} (n = {}, \
             t = {}; upper tail, χ² approximation, corrected for ties)",
            test.w,
            test.chi2,
            test.df,
            test.p.equation(),
            test.judges,
            test.df + 1
        )],
        method: vec![
            "Each observer's scores (how often each stimulus was chosen) are ranked, equal scores sharing \
             their mean rank. Friedman's (1937) test asks whether the mean ranks differ; Kendall's \
             coefficient of concordance W is its χ² divided by the most it can be (Kendall and Babington \
             Smith 1939)."
                .into(),
        ],
        references: vec![
            "Friedman, M. (1937). The use of ranks to avoid the assumption of normality implicit in the \
             analysis of variance. Journal of the American Statistical Association 32, 675–701.",
            "Kendall, M. G. and Babington Smith, B. (1939). The problem of m rankings. Annals of \
             Mathematical Statistics 10, 275–287.",
        ],
        ..Section::default()
    }
}
