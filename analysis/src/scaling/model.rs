//! From a difference of scale values to the chance of a choice: Bradley and Terry (1952) and
//! Thurstone's Case V (1927).

use crate::maths::distributions::{normal_density, normal_tail};
use serde::Serialize;

/// How the chance P that item i is chosen over item j follows from their scale values.
///
/// # Formula
/// ```text
/// Bradley–Terry:    P = 1 / (1 + exp(sⱼ − sᵢ)) = πᵢ/(πᵢ + πⱼ), s = ln π in logits
/// Thurstone Case V: P = Φ(sᵢ − sⱼ), s in units of the standard deviation of a difference (probits)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Model {
    /// Bradley and Terry (1952); the unit is the logit.
    BradleyTerry,
    /// Thurstone (1927), Case V; the unit is the probit.
    ThurstoneV,
}

/// What a model says of a difference of scale values.
pub(super) struct Preference {
    /// Chance F of the choice.
    pub chosen: f64,
    /// Chance 1 − F of the opposite, with all its digits.
    pub rejected: f64,
    /// Derivative f of F.
    pub density: f64,
    /// f′/f.
    pub log_slope: f64,
}

impl Model {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::BradleyTerry => "Bradley–Terry",
            Self::ThurstoneV => "Thurstone Case V",
        }
    }

    /// The unit of its scale values.
    pub fn unit(self) -> &'static str {
        match self {
            Self::BradleyTerry => "logit",
            Self::ThurstoneV => "probit",
        }
    }

    /// One just-objectionable difference: the difference of scale values at which 75 % prefer the better
    /// item, ln 3 or Φ⁻¹(0.75).
    pub fn just_objectionable_difference(self) -> f64 {
        match self {
            Self::BradleyTerry => 1.098_612_288_668_109_8,
            Self::ThurstoneV => 0.674_489_750_196_081_7,
        }
    }

    pub(super) fn preference(self, difference: f64) -> Preference {
        match self {
            Self::BradleyTerry => {
                let odds = libm::exp(-difference.abs());
                let (more, less) = (1.0 / (1.0 + odds), odds / (1.0 + odds));
                let (chosen, rejected) =
                    if difference >= 0.0 { (more, less) } else { (less, more) };
                let (density, log_slope) = (chosen * rejected, rejected - chosen);
                Preference { chosen, rejected, density, log_slope }
            }
            Self::ThurstoneV => Preference {
                chosen: normal_tail(-difference),
                rejected: normal_tail(difference),
                density: normal_density(difference),
                log_slope: -difference,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_just_objectionable_difference_is_preferred_by_75_percent() {
        for model in [Model::BradleyTerry, Model::ThurstoneV] {
            let preference = model.preference(model.just_objectionable_difference());
            assert!((preference.chosen - 0.75).abs() < 1e-15, "{model:?}");
            assert!((preference.rejected - 0.25).abs() < 1e-15, "{model:?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_chance() {
        for model in [Model::BradleyTerry, Model::ThurstoneV] {
            for x in [-3.0, -0.4, 0.0, 1.2, 4.0] {
                let (low, high) = (model.preference(x - 1e-5), model.preference(x + 1e-5));
                let here = model.preference(x);
                let slope = (high.chosen - low.chosen) / 2e-5;
                assert!((here.density - slope).abs() < 1e-9, "{model:?} {x}");
                let slope = (libm::log(high.density) - libm::log(low.density)) / 2e-5;
                assert!((here.log_slope - slope).abs() < 1e-8, "{model:?} {x}");
            }
        }
    }
}
