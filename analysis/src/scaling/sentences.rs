//! Scaling in words: scale values, tests and what does not follow.

use super::study::{Fitted, Scaling};

/// The results in the field's reporting style.
pub(super) fn sentences(scaling: &Scaling) -> Vec<String> {
    let t = scaling.items.len();
    let mut lines = vec![format!(
        "Places of t = {t} items on one scale from {} answers to {} of {} pairs{}.",
        scaling.trials,
        scaling.pairs,
        t * (t - 1) / 2,
        match &scaling.observers {
            Ok(observers) => format!(" by n = {observers} observers"),
            Err(_) => String::new(),
        },
    )];
    if let Some(reason) = &scaling.separation {
        lines.push(format!(
            "There are no maximum-likelihood scale values: {reason}. All values are bias-reduced \
             (Firth 1993)."
        ));
    }
    if scaling.ties > 0.0 {
        lines.push(format!(
            "{} of {} answers chose neither; each counts as half a win for both, which makes \
             standard errors a little too large and p-values approximate.",
            scaling.ties, scaling.trials
        ));
    }
    lines.push(ends(&scaling.bradley_terry));
    for fitted in scaling.both() {
        lines.push(equal_worth(fitted));
        lines.push(goodness(fitted));
        lines.push(simulated(fitted));
        lines.push(resampling(fitted));
        if let Err(reason) = &fitted.profile_95 {
            let model = fitted.scale.model.name();
            lines.push(format!("{model}, profile intervals: none, {reason}."));
        }
    }
    lines.push(distinct(&scaling.bradley_terry));
    lines.push(ties(scaling));
    lines
}

fn ends(fitted: &Fitted) -> String {
    let (scale, worths) = (&fitted.scale, fitted.scale.worths());
    let order = scale.best_first();
    let [best, worst] = [order[0], order[order.len() - 1]];
    let estimate = scale.difference(best, worst);
    let [low, high] = estimate.wald_95();
    format!(
        "{}: {} is best (worth {:.3}), {} worst (worth {:.3}; worths sum to 1); they differ by {:.2} \
         {}s (SE {:.2}, 95 % interval {low:.2} to {high:.2}, Wald).",
        scale.model.name(),
        scale.items[best],
        worths[best],
        scale.items[worst],
        worths[worst],
        estimate.value,
        scale.model.unit(),
        estimate.se,
    )
}

fn equal_worth(fitted: &Fitted) -> String {
    let test = &fitted.goodness_of_fit.equal_worth;
    let model = fitted.scale.model.name();
    let (Some(chi2), Some(p)) = (test.chi2, test.p) else {
        let reason = test.p_reason.unwrap_or_default();
        return format!("{model}, equality of all scale values: no test, {reason}.");
    };
    format!(
        "{model}, equality of all scale values: likelihood-ratio χ² = {chi2:.3}, df = {}, {} (upper tail, \
         χ² approximation, no correction; answers taken as independent).",
        test.df,
        p.equation()
    )
}

fn goodness(fitted: &Fitted) -> String {
    let fit = &fitted.goodness_of_fit;
    let model = fitted.scale.model.name();
    let (Some(p), Some(p_pearson)) = (fit.p, fit.p_pearson) else {
        let reason = fit.p_reason.as_deref().unwrap_or_default();
        return format!("{model}, goodness of fit: no test, {reason}.");
    };
    let cells = 2 * (fit.df + fitted.scale.items.len() - 1);
    let warning = match fit.small_expected {
        0 => String::new(),
        small => format!(
            " {small} of {cells} expected counts are below 5, the smallest is {:.2}: these p-values \
             are rough.",
            fit.smallest_expected
        ),
    };
    format!(
        "{model}, goodness of fit: deviance = {:.3}, df = {}, {}; Pearson χ² = {:.3}, {} (upper tails, \
         χ² approximation, no correction).{warning}",
        fit.deviance,
        fit.df,
        p.equation(),
        fit.pearson,
        p_pearson.equation()
    )
}

fn simulated(fitted: &Fitted) -> String {
    let model = fitted.scale.model.name();
    match &fitted.simulated_fit {
        Ok(fit) => format!(
            "{model}, goodness of fit by simulation: {} ({} studies simulated from the scale, seed {}; \
             upper tail of the deviance).",
            fit.p.equation(),
            fit.studies,
            fit.seed
        ),
        Err(reason) => format!("{model}, goodness of fit by simulation: none, {reason}."),
    }
}

fn resampling(fitted: &Fitted) -> String {
    let model = fitted.scale.model.name();
    let drawn = match &fitted.bootstrap {
        Ok(drawn) => drawn,
        Err(reason) => return format!("{model}, bootstrap intervals: none, {reason}."),
    };
    let unconnected = match drawn.unconnected {
        0 => String::new(),
        left_out => format!("; {left_out} lacked pairs that connect the items and were left out"),
    };
    format!(
        "{model}, bootstrap: {} replicates of n = {} observers, seed {}; in {} of them groups of items \
         are separated{unconnected}.",
        drawn.replicates, drawn.observers, drawn.seed, drawn.separated
    )
}

fn distinct(fitted: &Fitted) -> String {
    let all = &fitted.differences;
    let distinct = all.iter().filter(|difference| difference.p_holm.value() < 0.05).count();
    format!(
        "{}: {distinct} of {} differences between items are significant at 0.05 (Wald's test, \
         two-sided, approximate, Holm's correction for {} tests).",
        fitted.scale.model.name(),
        all.len(),
        all.len()
    )
}

fn ties(scaling: &Scaling) -> String {
    match &scaling.davidson {
        Ok(davidson) => {
            let p = davidson.p.map_or("no test".into(), |p| {
                format!("{} (upper tail, χ² approximation, no correction)", p.equation())
            });
            format!(
                "Davidson's model of ties: threshold ν = {:.3} (SE {:.3}), so equal items tie in \
                 {:.1} % of answers; deviance = {:.3}, df = {}, {p}.",
                davidson.nu.value,
                davidson.nu.se,
                100.0 * davidson.nu.value / (2.0 + davidson.nu.value),
                davidson.deviance,
                davidson.df
            )
        }
        Err(reason) => format!("Davidson's model of ties: none, {reason}."),
    }
}
