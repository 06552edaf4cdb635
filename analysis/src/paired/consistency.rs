//! Consistency of the observers: circular triads and ζ of each, their mean and all together.

use super::circular_triads::{
    Alternative, ChiSquare, TriadsByChance, circular_triads, consistency, max_circular_triads,
};
use crate::input::preferences::Judge;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;

const NO_CHI_SQUARE: &str = "the χ² approximation needs at least 5 stimuli";

/// Circular triads and the coefficient of consistency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Consistency {
    /// Circular triads of all observers together.
    pub circular_triads: u64,
    /// The most there could be.
    pub max_circular_triads: u64,
    /// Pooled ζ: 1 − `circular_triads` / `max_circular_triads`, the one ζ that studies report.
    pub zeta: f64,
    /// Mean of the observers' ζ; equal to the pooled one, as all judged the same pairs.
    pub zeta_mean: f64,
    /// Tests of the circular triads of all observers together.
    #[serde(flatten)]
    pub test: ConsistencyTest,
    /// Why there is no χ², here and for each observer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi2_reason: Option<String>,
    /// Which tail every p of this object is.
    pub tail: &'static str,
    /// Each observer alone.
    pub per_observer: Vec<ObserverConsistency>,
    /// Why no single observer can be shown to be more consistent than chance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_observer_not_testable: Option<String>,
}

/// One observer's circular triads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObserverConsistency {
    /// The participant's code.
    pub subject: String,
    /// The participant's sitting.
    pub session: u32,
    /// Which of the sitting's sets of pairs.
    pub repetition: u32,
    /// Circular triads.
    pub circular_triads: u64,
    /// Kendall's ζ.
    pub zeta: f64,
    /// Tests of the circular triads.
    #[serde(flatten)]
    pub test: ConsistencyTest,
}

/// Tests for fewer circular triads than chance gives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConsistencyTest {
    /// Probability of so few circular triads by chance: exact, or else `p_chi2`.
    pub p: PValue,
    /// Whether `p` is exact.
    pub exact: bool,
    /// χ² with continuity correction −½.
    pub chi2: Option<f64>,
    /// Its degrees of freedom; not a whole number.
    pub df: Option<f64>,
    /// Upper tail of `chi2`, approximate.
    pub p_chi2: Option<PValue>,
}

impl ConsistencyTest {
    fn new(chance: &TriadsByChance, triads: &[u64]) -> Self {
        let test = chance.test(triads, Alternative::Less);
        let of = |value: fn(ChiSquare) -> f64| test.chi_square_corrected.map(value);
        let p_chi2 = test.chi_square_corrected.map(|test| test.p);
        Self {
            // Below 5 stimuli p is exact, above 10 there is χ².
            p: test.p_exact.or(p_chi2).unwrap_or(PValue::new(1.0)),
            exact: test.p_exact.is_some(),
            chi2: of(|test| test.chi2),
            df: of(|test| test.df),
            p_chi2,
        }
    }
}

/// Consistency of `judges`, each of whom judged every pair of `t` stimuli once; `alpha` is the level
/// at which a single observer is said to be testable.
///
/// # Errors
/// In words: there are fewer than three stimuli, or no judges.
pub fn consistency_of(judges: &[Judge], t: usize, alpha: f64) -> Outcome<Consistency> {
    if t < 3 {
        return Err("circular triads need at least 3 stimuli".into());
    }
    if judges.is_empty() {
        return Err("there are no complete sets of pairs".into());
    }
    let chance = TriadsByChance::new(t);
    let triads: Vec<u64> = judges.iter().map(|j| circular_triads(&j.wins.scores())).collect();
    let per_observer: Vec<ObserverConsistency> = judges
        .iter()
        .zip(&triads)
        .map(|(judge, d)| ObserverConsistency {
            subject: judge.subject.clone(),
            session: judge.session,
            repetition: judge.repetition,
            circular_triads: *d,
            zeta: consistency(*d, 1, t),
            test: ConsistencyTest::new(&chance, &[*d]),
        })
        .collect();
    let total = triads.iter().sum();
    let n = judges.len() as u64;
    let test = ConsistencyTest::new(&chance, &triads);
    let smallest = ConsistencyTest::new(&chance, &[0]).p;
    let per_observer_not_testable = (smallest.value() > alpha).then(|| {
        format!(
            "not testable: with t = {t} even an observer without any circular triad has p = \
             {smallest}, above α = {alpha}"
        )
    });
    Ok(Consistency {
        circular_triads: total,
        max_circular_triads: n * max_circular_triads(t),
        zeta: consistency(total, n, t),
        zeta_mean: per_observer.iter().map(|o| o.zeta).sum::<f64>() / n as f64,
        chi2_reason: test.chi2.is_none().then(|| NO_CHI_SQUARE.into()),
        test,
        tail: "lower tail of the number of circular triads",
        per_observer,
        per_observer_not_testable,
    })
}
