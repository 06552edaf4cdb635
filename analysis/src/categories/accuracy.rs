//! Accuracy: the share of right answers, against chance.

use crate::maths::binomial::upper_tail;
use crate::maths::distributions::{clopper_pearson_95, wilson_95};
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;

/// The share of right answers, with intervals and a test against guessing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// Right answers.
    pub correct: u64,
    /// Answers.
    pub trials: u64,
    /// The share in percent.
    pub percent: f64,
    /// The share, from 0 to 1, that guessing is expected to reach.
    pub chance: f64,
    /// Wilson's 95 % interval of the share, from 0 to 1.
    pub wilson_95: [f64; 2],
    /// Clopper and Pearson's exact 95 % interval of the share, from 0 to 1.
    pub clopper_pearson_95: [f64; 2],
    /// P(X ≥ `correct`) when every answer is a guess: exact, upper tail.
    pub p_above_chance: Option<PValue>,
    /// Why there is no p.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_above_chance_reason: Option<&'static str>,
}

impl Accuracy {
    /// `correct` of `trials` answers, of which guessing gets the share `chance` right: 1/m with m
    /// alternatives.
    ///
    /// # Formula
    /// ```text
    /// P(X ≥ k), X ~ Binomial(n, c)
    /// ```
    ///
    /// # Errors
    /// In words: there are no answers, or the numbers cannot be.
    pub fn new(correct: u64, trials: u64, chance: f64) -> Outcome<Self> {
        if trials == 0 {
            return Err("there are no answers".into());
        }
        if correct > trials || !(chance > 0.0 && chance < 1.0) {
            return Err(format!(
                "{correct} right of {trials} answers, by chance {chance}: no such numbers can be"
            ));
        }
        Ok(Self {
            correct,
            trials,
            percent: 100.0 * correct as f64 / trials as f64,
            chance,
            wilson_95: wilson_95(correct, trials),
            clopper_pearson_95: clopper_pearson_95(correct, trials),
            p_above_chance: Some(PValue::new(upper_tail(correct, trials, chance))),
            p_above_chance_reason: None,
        })
    }

    /// The same without a test against guessing, which `reason` forbids.
    pub(super) fn untested(self, reason: &'static str) -> Self {
        Self { p_above_chance: None, p_above_chance_reason: Some(reason), ..self }
    }

    /// The share, from 0 to 1.
    pub fn share(&self) -> f64 {
        self.correct as f64 / self.trials as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_against_chance_are_those_of_r() {
        // R 4.2.2: binom.test(14, 20, 1/5, alternative = "greater") and against 1/2.
        for (chance, p) in [(0.2, 1.84500572127232e-06), (0.5, 0.0576591491699219)] {
            let found = Accuracy::new(14, 20, chance).unwrap().p_above_chance.unwrap().value();
            assert!((found / p - 1.0).abs() < 1e-12, "{found}");
        }
        assert_eq!(Accuracy::new(0, 5, 0.5).unwrap().p_above_chance.unwrap().value(), 1.0);
    }

    #[test]
    fn impossible_counts_are_refused_in_words() {
        assert_eq!(Accuracy::new(0, 0, 0.5).unwrap_err(), "there are no answers");
        assert!(Accuracy::new(3, 2, 0.5).is_err());
        assert!(Accuracy::new(1, 2, f64::NAN).is_err());
    }
}
