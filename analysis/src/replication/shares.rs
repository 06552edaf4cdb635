//! Printed percentages, tested again where their counts can be recovered.

use super::Line;
use super::implied::counts;
use crate::maths::fisher_exact::fisher_exact;
use crate::maths::p_value::PValue;
use crate::maths::proportion::Proportion;

/// The 95 % point of χ² with one degree of freedom.
const CHI2_95: f64 = 3.841_458_820_694_124;

/// A printed percentage of a printed number of trials, and its tests against a fair coin.
pub fn of_trials(
    section: &'static str,
    what: &str,
    printed: f64,
    decimals: usize,
    trials: u64,
    people: u64,
) -> Vec<Line> {
    let published = format!("{printed:.decimals$} %");
    let found = counts(printed, decimals, trials);
    let [count] = found[..] else {
        let ours = format!("{} counts of {trials} answers give it", found.len());
        return vec![Line::compared(section, what, published, ours, false)];
    };
    let share = Proportion::new(count, trials);
    let [low, high] = share.clopper_pearson_95.map(|bound| 100.0 * bound);
    vec![
        Line::compared(section, what, published, format!("{count} of {trials} answers"), true),
        Line::ours(
            section,
            &format!("{what}: 95 % interval"),
            format!("{low:.1} to {high:.1} % (Clopper–Pearson)"),
        ),
        Line::ours(section, &format!("{what}: test against chance"), share.p_binomial).noting(
            format!(
                "n = {trials} answers of {people} people; two-sided, exact binomial against ½; χ² = {:.2}, \
                 df = 1, {}. {}",
                share.chi2,
                share.p_chi2.equation(),
                robustness(&share)
            ),
        ),
    ]
}

/// A printed statement that a share of `percent` differs from a half or not, whose number of trials is not
/// printed, with the fewest `trials` that the text allows.
pub fn of_at_least(
    section: &'static str,
    what: &str,
    printed: &str,
    (percent, decimals): (f64, usize),
    differs: bool,
    trials: u64,
) -> Line {
    // The count nearest to a half speaks least for a difference.
    let count = counts(percent, decimals, trials)
        .into_iter()
        .min_by_key(|count| (2 * count).abs_diff(trials))
        .unwrap_or(trials / 2);
    let share = Proportion::new(count, trials);
    let found = share.p_chi2.value() <= 0.05;
    Line::compared(
        section,
        what,
        printed,
        format!("χ² = {:.2}, {}", share.chi2, share.p_chi2.equation()),
        found == differs,
    )
    .noting(format!(
        "The number of trials is not printed; {count} of {trials} answers are assumed, 21 people and the 8 \
         pairs that differ in nothing else. Had all 120 pairs been asked, there were more. df = 1, \
         two-sided, no correction; exact binomial {}. {}",
        share.p_binomial.equation(),
        if found { robustness(&share) } else { String::new() }
    ))
}

/// Two printed counts out of `trials` each, compared.
pub fn difference(
    section: &'static str,
    what: &str,
    printed: &str,
    [one, other]: [u64; 2],
    trials: u64,
) -> Line {
    match fisher_exact(&[[one, trials - one], [other, trials - other]]).map(PValue::new) {
        Ok(p) => Line::compared(section, what, printed, p, p.value() <= 0.05).noting(format!(
            "{one} and {other} of {trials} answers each; Fisher's exact test, two-sided, answers taken as \
             independent."
        )),
        Err(reason) => Line::unknown(section, what, Some(printed.into()), reason),
    }
}

/// How much more answers of one person may be alike before a test against a half is lost.
fn robustness(share: &Proportion) -> String {
    format!(
        "Answers of one person are not independent: p stays below 0.05 up to a design effect of {:.1}.",
        share.chi2 / CHI2_95
    )
}
