//! d′ from a share of right answers: m-alternative forced choice, and ABX without bias.

use super::discrimination::{LOG_LINEAR, MAX_D_PRIME, NO_SE, Strategy, abx_errors};
use crate::maths::distributions::{bisect, clopper_pearson_95, normal_density, normal_tail};
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;

/// A task in which only the share of right answers counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "task", content = "with")]
pub enum ForcedChoice {
    /// So many stimuli, at least 2, one of them with the signal: which?
    Alternatives(u32),
    /// ABX by an observer without preference for one of the candidates.
    Abx(Strategy),
}

/// Sensitivity from a share of right answers.
#[derive(Clone, Debug, PartialEq)]
pub struct ForcedChoiceDPrime {
    /// The task.
    pub task: ForcedChoice,
    /// Right answers.
    pub correct: u64,
    /// Answers.
    pub trials: u64,
    /// How the share was kept from 0 and 1, if it was.
    pub correction: Option<&'static str>,
    /// Sensitivity.
    pub d_prime: f64,
    /// 95 % interval: d′ at the ends of Clopper and Pearson's interval of the share, so exact; none for an
    /// end that the answers do not set.
    pub interval_95: [Option<f64>; 2],
    /// Standard error of d′ by the delta method.
    pub se: Outcome<f64>,
}

serialize_outcomes!(
    ForcedChoiceDPrime,
    [task, correct, trials, correction, d_prime, interval_95],
    [se]
);

impl ForcedChoice {
    /// The share right that sensitivity `d` gives.
    ///
    /// # Formula
    /// ```text
    /// m alternatives: P = ∫ φ(x − d) Φ(x)^(m−1) dx  (Green and Swets 1966)
    /// ABX: as P_max of Model
    /// ```
    pub fn share_right(self, d: f64) -> f64 {
        match self {
            Self::Alternatives(m) => {
                // The trapezoidal rule is exact to rounding for an integrand that vanishes at both ends.
                const STEP: f64 = 1.0 / 16.0;
                let integrand =
                    |x: f64| normal_density(x) * libm::pow(normal_tail(-x - d), f64::from(m) - 1.0);
                STEP * (-160..=160).map(|i| integrand(STEP * f64::from(i))).sum::<f64>()
            }
            Self::Abx(strategy) => 1.0 - abx_errors(d, strategy),
        }
    }

    /// The d′ that gives the share `share`; none beyond the range of d′.
    pub(super) fn solve(self, share: f64) -> Option<f64> {
        let low = if matches!(self, Self::Abx(_)) { 0.0 } else { -MAX_D_PRIME };
        let reached = |d: f64| self.share_right(d) >= share;
        match (reached(low), reached(MAX_D_PRIME)) {
            (true, _) if low == 0.0 => Some(0.0),
            (false, true) => Some(bisect(low, MAX_D_PRIME, reached)),
            _ => None,
        }
    }

    /// d′ of `correct` answers in `trials`.
    ///
    /// # Errors
    /// In words: no answers, or numbers that cannot be.
    pub fn d_prime(self, correct: u64, trials: u64) -> Outcome<ForcedChoiceDPrime> {
        if trials == 0 {
            return Err("there are no answers".into());
        }
        if correct > trials || matches!(self, Self::Alternatives(m) if m < 2) {
            return Err(
                "d′ needs at least two alternatives and no more right answers than answers".into(),
            );
        }
        let (share, correction) = share(correct, trials);
        let d_prime = self.solve(share).ok_or("d′ is beyond the range that can be told")?;
        const STEP: f64 = 1e-5;
        let slope =
            (self.share_right(d_prime + STEP) - self.share_right(d_prime - STEP)) / (2.0 * STEP);
        let se = libm::sqrt(share * (1.0 - share) / trials as f64) / slope;
        let flat = d_prime == 0.0 && matches!(self, Self::Abx(_));
        let ends = clopper_pearson_95(correct, trials);
        Ok(ForcedChoiceDPrime {
            task: self,
            correct,
            trials,
            correction,
            d_prime,
            interval_95: ends.map(|end| self.solve(end)),
            se: if !flat && se.is_finite() { Ok(se) } else { Err(NO_SE.into()) },
        })
    }
}

/// The share of right answers, with the log-linear correction if it is 0 or 1.
pub(super) fn share(correct: u64, trials: u64) -> (f64, Option<&'static str>) {
    match correct == 0 || correct == trials {
        true => ((correct as f64 + 0.5) / (trials as f64 + 1.0), Some(LOG_LINEAR)),
        false => (correct as f64 / trials as f64, None),
    }
}
