//! Ratings in words, tables and figures.

use super::analysis::RatingAnalysis;
use super::law::PUBLISHED_R;
use super::level_of_detail::Rule;
use super::rating::{Share, THRESHOLD};
use super::section_figures::figures;
use super::section_tables as tables;
use crate::outcome::Outcome;
use crate::report::labels::significant;
use crate::report::section::Section;
use crate::report::section::ZHANG;

/// What sentences about simulated answers begin with.
const SIMULATED: &str =
    "The answers are simulated: what follows checks the tool and is no finding.";

/// What is said where a table does not say that.
pub(crate) const WHO_IS_UNKNOWN: &str =
    "The table does not say whether people or simulated observers answered.";

/// The sentence on who answered, if there is one to say.
pub(super) fn who(simulated: Option<bool>) -> Option<String> {
    match simulated {
        Some(true) => Some(SIMULATED.into()),
        Some(false) => None,
        None => Some(WHO_IS_UNKNOWN.into()),
    }
}

/// The sentence on answers that are no ratings, if there are any.
pub(super) fn left_out(unnamed: usize) -> Option<String> {
    (unnamed > 0).then(|| {
        format!(
            "{unnamed} answers have no model, r or level_of_detail and are left out, while others have \
             them."
        )
    })
}

/// The section on ratings.
pub fn section(analysis: &RatingAnalysis) -> Section {
    Section {
        heading: "Ratings of simplified models".into(),
        sentences: sentences(analysis),
        tables: vec![
            tables::ratings(analysis),
            tables::histogram(analysis),
            tables::levels(analysis),
        ],
        figures: figures(analysis),
        method: vec![
            "The human rating of an image is u₁/(u₁ + u₂), the share of those who say that it \
             looks the same as the image of the original model; from 0.8 on, Zhang et al. (2014, \
             Appendix A) take the two for visually equivalent. That is a rule about the point: \
             beside it stand Wilson's (1927) and Clopper and Pearson's (1934) 95 % intervals, \
             whether they lie above 0.8, and exact binomial tests against 0.8, corrected by Holm \
             (1979) for the number of images."
                .into(),
            "The histogram for r counts the images of each r whose rating is 0.8 or more. \
             Observers (or, where they are not told apart, the answers to each image) were \
             resampled; an r is chosen if it has the largest share in 95 % of the resamples."
                .into(),
            "The coarsest level of detail is found by the rule of Zhang et al. (2014), the \
             coarsest level tested whose rating is 0.8 or more, which can only name levels \
             tested and so is on the fine side; and as the level at which a logistic function of \
             ln level, fitted by binomial maximum likelihood to all ratings of the model at the \
             speed, is 0.8, with its profile-likelihood interval."
                .into(),
        ],
        references: vec![
            CLOPPER,
            "Holm, S. (1979). A simple sequentially rejective multiple test procedure. \
             Scandinavian Journal of Statistics 6, 65–70.",
            WILSON,
            ZHANG,
        ],
    }
}

const WILSON: &str = "Wilson, E. B. (1927). Probable inference, the law of succession, and \
     statistical inference. Journal of the American Statistical Association 22, 209–212.";
const CLOPPER: &str = "Clopper, C. J. & Pearson, E. S. (1934). The use of confidence or fiducial \
     limits illustrated in the case of the binomial. Biometrika 26, 404–413.";

fn sentences(analysis: &RatingAnalysis) -> Vec<String> {
    let RatingAnalysis { ratings, observers, .. } = analysis;
    let who = match observers {
        Some(1) => "1 observer".to_string(),
        Some(observers) => format!("{observers} observers"),
        None => "observers who are not told apart".into(),
    };
    let answers: u64 = ratings.iter().map(|rating| rating.same + rating.different).sum();
    let mut lines: Vec<String> = self::who(analysis.simulated).into_iter().collect();
    lines.push(format!(
        "{answers} answers by {who} to {} images; speeds are in {}.",
        ratings.len(),
        analysis.speed_unit.symbol()
    ));
    lines.extend(left_out(analysis.unnamed));
    let not_sure: u64 = ratings.iter().map(|rating| rating.not_sure).sum();
    if not_sure > 0 {
        lines.push(format!("{not_sure} answers “not sure” are in no rating."));
    }
    let unrated = ratings.iter().filter(|rating| rating.share.is_none()).count();
    if unrated > 0 {
        lines.push(format!("{unrated} images have no rating: nobody answered same or different."));
    }
    if analysis.repeated {
        lines.push(
            "Some observers answered to an image more than once. Intervals and tests of single \
             images take all answers as independent and are then too sure."
                .into(),
        );
    }
    let shares: Vec<_> = ratings.iter().filter_map(|rating| rating.share.as_ref()).collect();
    let count = |of: &dyn Fn(&Share) -> bool| shares.iter().filter(|s| of(s)).count();
    lines.push(format!(
        "{} of {} images reach a rating of {THRESHOLD} (the rule of Zhang et al. 2014). Wilson's \
         95 % interval lies above it for {}, Clopper and Pearson's for {}; the exact binomial \
         test puts {} above it (upper tail, p ≤ 0.05 with Holm's correction for {} images).",
        count(&|share| share.reaches),
        shares.len(),
        count(&|share| share.wilson_clears),
        count(&|share| share.clopper_pearson_clears),
        count(&|share| share.p_above_holm.value() <= 0.05),
        shares.len(),
    ));
    let published = format!("Zhang et al. (2014) take r = {PUBLISHED_R}");
    lines.push(match &analysis.histogram.chosen {
        Ok(r) => format!(
            "r = {r}: most images reach {THRESHOLD} with it, in 95 % or more of {} resamples. \
             {published}; the difference is {}.",
            analysis.histogram.replicates,
            r - PUBLISHED_R
        ),
        Err(reason) => format!("r is not chosen: {reason}. {published}."),
    });
    for (rule, name) in
        [(Rule::Point, "By the rule of Zhang et al."), (Rule::Smoothed, "By the function")]
    {
        let found =
            analysis.coarsest.iter().filter(|coarsest| coarsest.level(rule).is_ok()).count();
        lines.push(format!(
            "{name} the coarsest level of detail is known for {found} of {} models, r and speeds{}",
            analysis.coarsest.len(),
            if found < analysis.coarsest.len() {
                "; the table says why not for the others."
            } else {
                "."
            }
        ));
    }
    let uneven = analysis.coarsest.iter().filter(|c| !c.finer_below.is_empty()).count();
    if uneven > 0 {
        lines.push(format!(
            "For {uneven} of them a level finer than the coarsest that reaches {THRESHOLD} falls \
             short of it."
        ));
    }
    lines
}

/// An interval in words.
pub(super) fn interval(bounds: [f64; 2]) -> String {
    format!("[{}, {}]", significant(bounds[0]), significant(bounds[1]))
}

/// The value, or that it is not known and why.
pub(super) fn known<T>(outcome: &Outcome<T>, say: impl Fn(&T) -> String) -> String {
    match outcome {
        Ok(value) => say(value),
        Err(reason) => format!("not known ({reason})"),
    }
}
