//! The psychometric function: its shapes, its guess and its lapse rate.

use crate::maths::distributions::{normal_density, normal_tail};
use crate::maths::normal_quantile::normal_quantile;
use crate::outcome::Outcome;
use serde::Serialize;
pub use shutterlab_data_schema::cohort::Shape;

/// The most that a fitted lapse rate may be unless something else is said (Wichmann and Hill 2001).
pub const MOST_LAPSES: f64 = 0.06;

/// A psychometric function whose intercept and slope are to be fitted.
///
/// # Formula
/// ```text
/// ψ(x) = γ + (1 − γ − λ)·F(η),  η = intercept + slope·x
/// logistic: F = 1/(1 + e^(−η))     probit: F = Φ(η)     Weibull: F = 1 − exp(−e^η), x = ln level
/// ```
/// with the guess rate γ and the lapse rate λ. The Weibull function of threshold α and slope β is
/// intercept = −β·ln α, slope = β.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Model {
    /// Form of F.
    pub shape: Shape,
    /// Guess rate γ: the chance of the answer where nothing is sensed.
    pub guess: Rate,
    /// Lapse rate λ: how far the chance stays below 1 where everything is sensed.
    pub lapse: Rate,
}

/// A guess or lapse rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rate {
    /// Known.
    Fixed(f64),
    /// Fitted, between these two.
    Fitted([f64; 2]),
}

impl Rate {
    /// The smallest and the largest it may be.
    pub(super) fn bounds(self) -> [f64; 2] {
        match self {
            Self::Fixed(rate) => [rate, rate],
            Self::Fitted(bounds) => bounds,
        }
    }
}

impl Model {
    /// For a question with yes and no: nothing is guessed, nobody lapses.
    pub fn yes_no(shape: Shape) -> Self {
        Self { shape, guess: Rate::Fixed(0.0), lapse: Rate::Fixed(0.0) }
    }

    /// For a forced choice among so many alternatives, of which one is right: γ = 1/m.
    pub fn forced_choice(shape: Shape, alternatives: u32) -> Self {
        Self { guess: Rate::Fixed(1.0 / f64::from(alternatives)), ..Self::yes_no(shape) }
    }

    /// Refuses rates that leave nothing to fit.
    pub(super) fn check(&self) -> Outcome<()> {
        let [guess, lapse] = [self.guess.bounds(), self.lapse.bounds()];
        let ordered = |[low, high]: [f64; 2]| 0.0 <= low && low <= high;
        match ordered(guess) && ordered(lapse) && guess[1] + lapse[1] < 1.0 {
            true => Ok(()),
            false => Err(format!(
                "a guess rate of {} to {} and a lapse rate of {} to {} are no rates below 1 together",
                guess[0], guess[1], lapse[0], lapse[1]
            )),
        }
    }

    /// Where on the axis of the function a level is: the level, or its logarithm (Weibull).
    pub(super) fn abscissa(&self, level: f64) -> f64 {
        if self.shape == Shape::Weibull { libm::log(level) } else { level }
    }

    /// The level at a place on the axis.
    pub(super) fn level(&self, abscissa: f64) -> f64 {
        if self.shape == Shape::Weibull { libm::exp(abscissa) } else { abscissa }
    }
}

/// F at one η: its value, its complement and its derivative, each with all its digits in both tails.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    pub value: f64,
    pub complement: f64,
    pub derivative: f64,
}

pub(super) fn form(shape: Shape, eta: f64) -> Form {
    let [value, complement, derivative] = match shape {
        Shape::Logistic => {
            let [value, complement] = [eta, -eta].map(|eta| 1.0 / (1.0 + libm::exp(-eta)));
            [value, complement, value * complement]
        }
        Shape::Probit => [normal_tail(-eta), normal_tail(eta), normal_density(eta)],
        Shape::Weibull => {
            let hazard = libm::exp(eta.min(700.0));
            [-libm::expm1(-hazard), libm::exp(-hazard), libm::exp(eta - hazard)]
        }
    };
    Form { value, complement, derivative }
}

/// The η at which F is `value`, 0 < `value` < 1.
pub(super) fn inverse(shape: Shape, value: f64) -> f64 {
    match shape {
        Shape::Logistic => libm::log(value / (1.0 - value)),
        Shape::Probit => normal_quantile(value),
        Shape::Weibull => libm::log(-libm::log1p(-value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 3] = [Shape::Logistic, Shape::Probit, Shape::Weibull];

    #[test]
    fn forms_have_their_complements_derivatives_and_inverses() {
        for shape in SHAPES {
            for eta in [-3.0, -0.4, 0.0, 0.7, 1.2] {
                let here = form(shape, eta);
                assert!((here.value + here.complement - 1.0).abs() < 1e-15);
                let [above, below] = [eta + 1e-6, eta - 1e-6].map(|eta| form(shape, eta).value);
                assert!(((above - below) / 2e-6 - here.derivative).abs() < 1e-9, "{shape:?}");
                assert!((inverse(shape, here.value) - eta).abs() < 1e-12, "{shape:?} {eta}");
            }
            for eta in [-1e9, -800.0, 800.0, 1e9] {
                let far = form(shape, eta);
                assert!([far.value, far.complement, far.derivative].iter().all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn rates_that_leave_nothing_are_refused() {
        let model = Model::forced_choice(Shape::Logistic, 2);
        assert!(model.check().is_ok());
        for (guess, lapse) in [
            (Rate::Fixed(0.5), Rate::Fixed(0.5)),
            (Rate::Fixed(-0.1), Rate::Fixed(0.0)),
            (Rate::Fixed(f64::NAN), Rate::Fixed(0.0)),
            (Rate::Fixed(0.5), Rate::Fitted([0.1, 0.05])),
        ] {
            assert!(Model { guess, lapse, ..model }.check().is_err());
        }
    }
}
