//! How well two stimuli are told apart, apart from what observers prefer to answer: d′ and criterion from
//! hits and false alarms (Green and Swets 1966; Macmillan and Creelman 2005).

use super::likelihood_interval::likelihood_interval_95;
use crate::maths::distributions::{bisect, normal_tail};
use crate::maths::normal_quantile::normal_quantile;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;
use std::f64::consts::SQRT_2;

/// The largest d′ that is told from a still larger one; its errors are fewer than one in a million.
pub const MAX_D_PRIME: f64 = 10.0;

/// Answers to two kinds of trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Counts {
    /// "Yes" to trials with a signal: "different" to different stimuli, or "the first" where the
    /// reference was the first.
    pub hits: u64,
    /// Trials with a signal.
    pub signals: u64,
    /// "Yes" to the other trials.
    pub false_alarms: u64,
    /// The other trials.
    pub noises: u64,
}

/// How sensations are compared where there is more than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Each sensation is judged by itself against a criterion: the best there is where two stimuli are
    /// compared again and again.
    IndependentObservations,
    /// Differences of sensations are judged: what is left where trials change between many stimuli, as
    /// they do here.
    Differencing,
}

impl Strategy {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::IndependentObservations => "independent observations",
            Self::Differencing => "differencing",
        }
    }
}

/// A task with two kinds of trials and two answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "task", content = "strategy")]
pub enum Model {
    /// One stimulus: was the signal there?
    YesNo,
    /// Two stimuli: are they the same?
    SameDifferent(Strategy),
    /// A reference X and the two candidates A and B: which of them is X? Matching is this task.
    Abx(Strategy),
}

/// Sensitivity and criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct DPrime {
    /// The task, and how sensations are taken to be compared.
    pub model: Model,
    /// The answers.
    pub counts: Counts,
    /// Share of hits, as used.
    pub hit_rate: f64,
    /// Share of false alarms, as used.
    pub false_alarm_rate: f64,
    /// How the shares were kept from 0 and 1, if one was.
    pub correction: Option<&'static str>,
    /// Sensitivity: the distance of the two stimuli in standard deviations of one sensation.
    pub d_prime: f64,
    /// 95 % interval of d′ by the profile likelihood of the answers, taken as independent; none for an end
    /// that the answers do not set.
    pub interval_95: [Option<f64>; 2],
    /// Criterion: in yes/no, ABX and same/different by independent observations c = −½(z(H) + z(F)), 0
    /// without bias, negative for more "yes" ("different", "the first"). In same/different by
    /// differencing the difference k, in the unit of d′, from which on two stimuli are called different.
    pub criterion: f64,
    /// Logarithm of the ratio of the likelihoods of the two kinds of trials at the criterion.
    pub ln_beta: f64,
    /// Standard error of d′ by the delta method.
    pub se: Outcome<f64>,
}

serialize_outcomes!(
    DPrime,
    [
        model,
        counts,
        hit_rate,
        false_alarm_rate,
        correction,
        d_prime,
        interval_95,
        criterion,
        ln_beta
    ],
    [se]
);

pub(super) const NO_SE: &str =
    "the delta method gives no standard error at the end of the range of d′";
const ALIKE: &str = "all answers were alike, which says nothing about d′";
pub(super) const LOG_LINEAR: &str =
    "log-linear: ½ added to the hits and false alarms and 1 to the trials (Hautus 1995)";

impl Counts {
    /// The answers of both.
    pub fn and(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            signals: self.signals + other.signals,
            false_alarms: self.false_alarms + other.false_alarms,
            noises: self.noises + other.noises,
        }
    }

    /// Adds the answer to one trial.
    pub fn add(&mut self, signal: bool, yes: bool) {
        let (trials, answers) = match signal {
            true => (&mut self.signals, &mut self.hits),
            false => (&mut self.noises, &mut self.false_alarms),
        };
        *trials += 1;
        *answers += u64::from(yes);
    }

    /// Whether all answers were "yes", or all "no". The log-linear correction would make a d′ of unequal
    /// numbers of trials alone.
    fn are_alike(self) -> bool {
        let yes = self.hits + self.false_alarms;
        yes == 0 || yes == self.signals + self.noises
    }

    /// The two shares, with the log-linear correction if one is 0 or 1.
    fn rates(self) -> ([f64; 2], Option<&'static str>) {
        let share =
            |yes: u64, trials: u64, add: f64| (yes as f64 + add) / (trials as f64 + 2.0 * add);
        let rates =
            |add| [share(self.hits, self.signals, add), share(self.false_alarms, self.noises, add)];
        match rates(0.0).iter().all(|rate| *rate > 0.0 && *rate < 1.0) {
            true => (rates(0.0), None),
            false => (rates(0.5), Some(LOG_LINEAR)),
        }
    }
}

/// A probability and its complement, each with all its digits.
pub type Split = [f64; 2];

impl Model {
    /// P(yes) and P(no) in trials with a signal and in the others, for sensitivity `d` and a criterion.
    ///
    /// # Formula
    /// ```text
    /// yes/no, ABX, same/different by independent observations:
    ///     H = Φ(Δ/2 − c),  F = Φ(−Δ/2 − c),  Δ = 2 z(P_max)
    /// P_max, the share right of an observer without bias:
    ///     yes/no                                   Φ(d/2)
    ///     same/different, independent observations Φ(d/2)² + Φ(−d/2)²
    ///     ABX, independent observations            Φ(d/√2) Φ(d/2) + Φ(−d/√2) Φ(−d/2)
    ///     ABX, differencing                        Φ(d/√2) Φ(d/√6) + Φ(−d/√2) Φ(−d/√6)
    /// same/different by differencing:
    ///     H = Φ((d − k)/√2) + Φ((−d − k)/√2),  F = 2 Φ(−k/√2)
    /// ```
    /// (Macmillan and Creelman 2005, ch. 9; Noreen 1981; Kaplan, Macmillan and Creelman 1978).
    pub fn probabilities(self, d: f64, criterion: f64) -> [Split; 2] {
        if self == Self::SameDifferent(Strategy::Differencing) {
            let (k, d) = (criterion / SQRT_2, d / SQRT_2);
            let hit =
                [normal_tail(k - d) + normal_tail(k + d), normal_tail(d - k) - normal_tail(d + k)];
            return [hit, [2.0 * normal_tail(k), libm::erf(k / SQRT_2)]];
        }
        let half = 0.5 * self.distance(d);
        [half, -half].map(|mean| [normal_tail(criterion - mean), normal_tail(mean - criterion)])
    }

    /// Δ = z(H) − z(F) that sensitivity `d` ≥ 0 gives (in yes/no, any).
    fn distance(self, d: f64) -> f64 {
        match self {
            Self::YesNo => d,
            Self::SameDifferent(_) => {
                -2.0 * normal_quantile(2.0 * normal_tail(d / 2.0) * normal_tail(-d / 2.0))
            }
            Self::Abx(strategy) => -2.0 * normal_quantile(abx_errors(d, strategy)),
        }
    }

    /// The smallest d′ of the model; only in yes/no can a signal look like less of one.
    pub(super) fn min_d_prime(self) -> f64 {
        if self == Self::YesNo { -MAX_D_PRIME } else { 0.0 }
    }

    /// Criteria beyond which no answers are left.
    pub(super) fn criteria(self) -> [f64; 2] {
        match self {
            Self::SameDifferent(Strategy::Differencing) => [0.0, 20.0],
            _ => [-12.0, 12.0],
        }
    }

    /// Sensitivity and criterion that give these shares of hits and false alarms, both between 0 and 1.
    /// Where hits are no more than false alarms, d′ is 0, the least that the model knows.
    pub(super) fn solve(self, [hits, false_alarms]: [f64; 2]) -> (f64, f64) {
        if self == Self::SameDifferent(Strategy::Differencing) {
            let criterion = -SQRT_2 * normal_quantile(0.5 * false_alarms);
            let reached = |d: f64| self.probabilities(d, criterion)[0][0] >= hits;
            let d = if reached(0.0) { 0.0 } else { bisect(0.0, MAX_D_PRIME, reached) };
            return (d, criterion);
        }
        let (z_hits, z_false_alarms) = (normal_quantile(hits), normal_quantile(false_alarms));
        let distance = z_hits - z_false_alarms;
        let d = match self {
            Self::YesNo => distance,
            _ if distance <= 0.0 => 0.0,
            _ => bisect(0.0, MAX_D_PRIME, |d| self.distance(d) >= distance),
        };
        (d, -0.5 * (z_hits + z_false_alarms))
    }

    /// ln β: in same/different by differencing ln{[φ((k − d)/√2) + φ((k + d)/√2)]/[2 φ(k/√2)]}, else cΔ.
    fn ln_beta(self, d: f64, criterion: f64) -> f64 {
        match self {
            Self::SameDifferent(Strategy::Differencing) => {
                // ln cosh x without overflow.
                let x = 0.5 * criterion * d;
                let ln_cosh =
                    x.abs() + libm::log1p(libm::exp(-2.0 * x.abs())) - std::f64::consts::LN_2;
                ln_cosh - 0.25 * d * d
            }
            _ => criterion * self.distance(d),
        }
    }

    /// The delta method: the covariance of the two shares, carried over to d′ by the inverse of the
    /// derivatives of the shares.
    fn se(self, d: f64, criterion: f64, rates: [f64; 2], counts: &Counts) -> Outcome<f64> {
        const STEP: f64 = 1e-5;
        let yes = |d: f64, criterion: f64| self.probabilities(d, criterion).map(|[yes, _]| yes);
        let slope =
            |above: [f64; 2], below: [f64; 2]| [0, 1].map(|i| (above[i] - below[i]) / (2.0 * STEP));
        let by_d = slope(yes(d + STEP, criterion), yes(d - STEP, criterion));
        let by_criterion = slope(yes(d, criterion + STEP), yes(d, criterion - STEP));
        let determinant = by_d[0] * by_criterion[1] - by_d[1] * by_criterion[0];
        let trials = [counts.signals as f64, counts.noises as f64];
        let variance = |i: usize| rates[i] * (1.0 - rates[i]) / trials[i];
        let weighted = by_criterion[1] * by_criterion[1] * variance(0)
            + by_criterion[0] * by_criterion[0] * variance(1);
        let se = libm::sqrt(weighted) / determinant.abs();
        // At d′ = 0 all but yes/no are flat.
        match (self == Self::YesNo || d > 0.0) && se.is_finite() {
            true => Ok(se),
            false => Err(NO_SE.into()),
        }
    }

    /// d′, criterion and their precision.
    ///
    /// # Errors
    /// In words: one of the two kinds of trials is missing, or all answers were alike.
    pub fn d_prime(self, counts: Counts) -> Outcome<DPrime> {
        let Counts { hits, signals, false_alarms, noises } = counts;
        if signals == 0 || noises == 0 {
            return Err(self.missing(signals == 0).into());
        }
        if hits > signals || false_alarms > noises {
            return Err("there are more answers \"yes\" than trials".into());
        }
        if counts.are_alike() {
            return Err(ALIKE.into());
        }
        let (rates, correction) = counts.rates();
        let (d_prime, criterion) = self.solve(rates);
        Ok(DPrime {
            model: self,
            counts,
            hit_rate: rates[0],
            false_alarm_rate: rates[1],
            correction,
            d_prime,
            interval_95: likelihood_interval_95(self, &counts, d_prime),
            criterion,
            ln_beta: self.ln_beta(d_prime, criterion),
            se: self.se(d_prime, criterion, rates, &counts),
        })
    }

    /// d′ alone, for resampled counts.
    pub(super) fn sensitivity(self, counts: Counts) -> Option<f64> {
        let has_both = counts.signals > 0 && counts.noises > 0;
        (has_both && !counts.are_alike()).then(|| self.solve(counts.rates().0).0)
    }

    /// Why d′ is not known without trials that have, or have not, a signal.
    fn missing(self, signals: bool) -> &'static str {
        match (self, signals) {
            (Self::YesNo, true) => "there are no trials with a signal",
            (Self::YesNo, false) => "there are no trials without a signal",
            (Self::SameDifferent(_), true) => "there are no pairs of different stimuli",
            (Self::SameDifferent(_), false) => {
                "there are no pairs of identical stimuli, so nobody can tell seeing a \
                 difference from always saying so"
            }
            (Self::Abx(_), true) => "the reference was never the first candidate",
            (Self::Abx(_), false) => "the reference was never the second candidate",
        }
    }
}

/// The share of errors of an observer without bias in ABX.
pub(super) fn abx_errors(d: f64, strategy: Strategy) -> f64 {
    let x = d / SQRT_2;
    let y = match strategy {
        Strategy::IndependentObservations => d / 2.0,
        Strategy::Differencing => d / libm::sqrt(6.0),
    };
    normal_tail(-x) * normal_tail(y) + normal_tail(x) * normal_tail(-y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_that_are_all_alike_give_no_d_prime() {
        for yes in [0, 1] {
            let counts = Counts { hits: yes * 20, signals: 20, false_alarms: yes * 5, noises: 5 };
            assert_eq!(Model::YesNo.d_prime(counts), Err(ALIKE.into()));
            assert_eq!(Model::YesNo.sensitivity(counts), None);
        }
    }
}
