//! The tests in words, the same for terminal and page. Beside every p stand n, t, tail, correction
//! and whether it is exact.

use crate::analysis::{Analysis, Consistency};

/// A test: its name and what came out.
pub struct Sentence {
    /// Name of the test.
    pub name: &'static str,
    /// Its result, or why there is none.
    pub results: Vec<String>,
}

/// All tests of `analysis`.
pub fn sentences(analysis: &Analysis) -> Vec<Sentence> {
    let nt = format!("n = {}, t = {}", analysis.observers, analysis.items.len());
    let missing = |reason: &Option<String>| {
        vec![format!("not known: {}", reason.as_deref().unwrap_or("no reason given"))]
    };
    let groups = match &analysis.grouping {
        Some(grouping) => vec![format!(
            "R_c = {} votes at α = {} ({nt}; W = {:.4}, studentized range with infinite degrees of \
             freedom, continuity correction ½): {} group{}",
            grouping.r_c,
            grouping.alpha,
            grouping.w,
            grouping.groups.len(),
            if grouping.groups.len() == 1 { "" } else { "s" },
        )],
        None => missing(&analysis.grouping_reason),
    };
    let equality = match &analysis.score_equality {
        Some(test) => vec![format!(
            "D = {:.3}, df = {}, {} ({nt}; {} tail, χ² approximation, no correction)",
            test.d,
            test.df,
            test.p.equation(),
            test.tail
        )],
        None => missing(&analysis.score_equality_reason),
    };
    let consistency = match &analysis.consistency {
        Some(consistency) => consistency_sentences(consistency, &nt),
        None => missing(&analysis.consistency_reason),
    };
    let agreement = match &analysis.agreement {
        Some(agreement) => {
            let mut lines =
                vec![format!("u = {:.4} (from {:.4} to 1; {nt})", agreement.u, agreement.u_min)];
            match (agreement.chi2, agreement.df, agreement.p) {
                (Some(chi2), Some(df), Some(p)) => lines.push(format!(
                    "χ² = {chi2:.3}, df = {df:.3}, {} ({nt}; upper tail, χ² approximation, no \
                     correction)",
                    p.equation()
                )),
                _ => lines.extend(missing(&agreement.chi2_reason)),
            }
            if let (Some(chi2), Some(df), Some(p)) =
                (agreement.chi2_corrected, agreement.df, agreement.p_corrected)
            {
                lines.push(format!(
                    "χ² = {chi2:.3}, df = {df:.3}, {} ({nt}; upper tail, χ² approximation, \
                     continuity correction: 1 subtracted from Σ)",
                    p.equation()
                ));
            }
            match agreement.p_exact {
                Some(p) => lines.push(format!(
                    "Σ = {}, {} ({nt}; upper tail, exact)",
                    agreement.sigma,
                    p.equation()
                )),
                None => lines.extend(missing(&agreement.p_exact_reason)),
            }
            lines
        }
        None => missing(&analysis.agreement_reason),
    };
    vec![
        Sentence { name: "Score differences", results: groups },
        Sentence { name: "Equality of the scores", results: equality },
        Sentence { name: "Consistency", results: consistency },
        Sentence { name: "Agreement", results: agreement },
    ]
}

fn consistency_sentences(consistency: &Consistency, nt: &str) -> Vec<String> {
    let how = |exact: bool, chi2: Option<f64>, df: Option<f64>| match (exact, chi2, df) {
        (false, Some(chi2), Some(df)) => {
            format!("χ² approximation with χ² = {chi2:.3}, df = {df:.3}, continuity correction −½")
        }
        _ => "exact".into(),
    };
    let mut lines = vec![format!(
        "ζ = {:.4} pooled over all observers ({:.4} as the mean of theirs): {} circular triads of \
         at most {}, {} ({nt}; {}, {})",
        consistency.zeta,
        consistency.zeta_mean,
        consistency.circular_triads,
        consistency.max_circular_triads,
        consistency.p.equation(),
        consistency.tail,
        how(consistency.exact, consistency.chi2, consistency.df),
    )];
    lines.push(match &consistency.per_observer_not_testable {
        Some(reason) => format!("observer by observer {reason}"),
        None => {
            let p = |p: f64| consistency.per_observer.iter().filter(|o| o.p.value() <= p).count();
            format!(
                "observer by observer ({}; {}): {} of {} have p ≤ 0.05, {} have p ≤ 0.01",
                nt.replace(&format!("n = {}", consistency.per_observer.len()), "n = 1"),
                match consistency.exact {
                    true => format!("{}, exact", consistency.tail),
                    false => format!(
                        "{}, χ² approximation with continuity correction −½",
                        consistency.tail
                    ),
                },
                p(0.05),
                consistency.per_observer.len(),
                p(0.01),
            )
        }
    });
    lines
}
