//! What simulated observers see: the probability of each answer before anything else than perception
//! has its say. Φ is the standard normal distribution function, z its inverse.
//!
//! Of stimuli with **values**, scale values s [Thurstone1927] or u = ln π [BradleyTerry1952], with Δ their
//! difference:
//!
//! ```text
//! preference        Bradley–Terry: P = 1 / (1 + exp(−Δu)) = π₁ / (π₁ + π₂)
//!                   Thurstone, Case V: P = Φ(Δs / (σ√2))
//! discriminability  d′ = √2 · z(P) of the preferred one; for Thurstone this is |Δs| / σ
//! matching          P(right) = Φ(d′/√2) Φ(d′/√6) + Φ(−d′/√2) Φ(−d′/√6)
//! same-different    P(different) = Φ((d′ − k)/√2) + Φ((−d′ − k)/√2),  k = −√2 · z(f/2)
//! ```
//!
//! Matching and same-different are those of the differencing model ([MacmillanCreelman2005] ch. 9):
//! each of the sequences seen gives a normal sensation of unit variance; the candidate whose sensation
//! is nearer to the reference's is the match; two are different if their sensations are more than the
//! criterion k apart. f is the false-alarm rate: P(different) of identical stimuli.
//!
//! Of stimuli with known **differences** x, by a psychometric function ψ = γ + (1 − γ) F(x)
//! [WichmannHill2001], with γ = ½ in 2AFC and matching; the lapses come later:
//!
//! ```text
//! preference        P = ½ + ½ F(x) of the one that differs less from the best; ½ if neither does
//! matching          P(right) = ½ + ½ F(x)
//! same-different    P(different) = f + (1 − f) F(x)
//! ```

use crate::design::Trial;
use crate::random::Stream;
use shutterlab_data_schema::cohort::Shape;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::Answer;
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// What an observer makes of a set of stimuli.
#[derive(Clone, Debug)]
pub enum Perception {
    /// Nothing.
    Guess,
    /// Each stimulus has a value.
    Values {
        /// The values.
        values: Vec<f64>,
        /// What comes upon their differences.
        noise: Noise,
        /// The criterion k of same-different; infinite without a false-alarm rate.
        criterion: f64,
    },
    /// Each two stimuli have a difference.
    Differences {
        /// The differences.
        between: Arc<Between>,
        /// How well they are seen.
        function: Psychometric,
        /// The best stimulus.
        best: Option<usize>,
    },
}

/// What comes upon the difference of two values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Logistic of scale 1: Bradley and Terry.
    Logistic,
    /// The difference of two normal ones with the standard deviation `sd`: Thurstone, Case V.
    Normal {
        /// The discriminal dispersion.
        sd: f64,
    },
}

/// The differences of every two of some stimuli.
#[derive(Clone, Debug, PartialEq)]
pub struct Between {
    /// How many stimuli there are.
    pub count: usize,
    /// Row by row.
    pub differences: Vec<f64>,
}

/// A psychometric function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Psychometric {
    /// Form F.
    pub shape: Shape,
    /// Threshold α.
    pub threshold: f64,
    /// Slope β.
    pub slope: f64,
    /// f of same-different.
    pub false_alarm_rate: f64,
}

impl Perception {
    /// Stimuli with values, and identical ones called different with the false-alarm rate.
    pub fn values(values: Vec<f64>, noise: Noise, false_alarm_rate: Option<f64>) -> Self {
        let criterion = -SQRT_2 * normal_quantile(0.5 * false_alarm_rate.unwrap_or(0.0));
        Self::Values { values, noise, criterion }
    }

    /// That of one observer among others: values, or the logarithm of the threshold, get a normal
    /// deviation of the standard deviation `spread`.
    pub fn of_one(&self, spread: f64, stream: &mut Stream) -> Self {
        let mut one = self.clone();
        match &mut one {
            Self::Guess => {}
            Self::Values { values, .. } => {
                values.iter_mut().for_each(|value| *value += spread * stream.normal());
            }
            Self::Differences { function, .. } => {
                function.threshold *= (spread * stream.normal()).exp();
            }
        }
        one
    }

    /// Probability of the first of the task's two answers: "first", or "same".
    pub fn first_answer(&self, task: Task, trial: &Trial) -> f64 {
        let right_is_first = |right: f64| match trial.right {
            Some(Answer::Second) => 1.0 - right,
            _ => right,
        };
        match task {
            Task::TwoAfc => {
                let (first, second) =
                    (trial.stimulus(trial.first), trial.stimulus(trial.first.other()));
                self.preference(first, second)
            }
            Task::Matching => right_is_first(self.match_found(trial.a, trial.b)),
            Task::SameDifferent => 1.0 - self.called_different(trial.a, trial.b),
        }
    }

    /// Probability that stimulus `a` is preferred to `b`.
    fn preference(&self, a: usize, b: usize) -> f64 {
        match self {
            Self::Guess => 0.5,
            Self::Values { values, noise, .. } => noise.preference(values[a] - values[b]),
            Self::Differences { between, function, best } => {
                let from_best = |index| best.map_or(0.0, |best| between.of(best, index));
                let half = 0.5 * function.seen(between.of(a, b));
                match from_best(a).total_cmp(&from_best(b)) {
                    std::cmp::Ordering::Less => 0.5 + half,
                    std::cmp::Ordering::Equal => 0.5,
                    std::cmp::Ordering::Greater => 0.5 - half,
                }
            }
        }
    }

    /// Probability that the one of `a` and `b` that is shown as the reference is found again.
    fn match_found(&self, a: usize, b: usize) -> f64 {
        match self {
            Self::Guess => 0.5,
            Self::Values { values, noise, .. } => {
                let d = noise.d_prime(values[a] - values[b]);
                let (x, y) = (normal(d / SQRT_2), normal(d / 6_f64.sqrt()));
                x * y + (1.0 - x) * (1.0 - y)
            }
            Self::Differences { between, function, .. } => {
                0.5 + 0.5 * function.seen(between.of(a, b))
            }
        }
    }

    /// Probability that `a` and `b` side by side are called different.
    fn called_different(&self, a: usize, b: usize) -> f64 {
        match self {
            Self::Guess => 0.5,
            Self::Values { values, noise, criterion } => {
                let d = noise.d_prime(values[a] - values[b]);
                normal((d - criterion) / SQRT_2) + normal((-d - criterion) / SQRT_2)
            }
            Self::Differences { between, function, .. } => {
                let rate = function.false_alarm_rate;
                rate + (1.0 - rate) * function.seen(between.of(a, b))
            }
        }
    }
}

impl Noise {
    /// Probability that a value is preferred to one that is less by `difference`.
    fn preference(self, difference: f64) -> f64 {
        match self {
            Self::Logistic => logistic(difference),
            Self::Normal { sd } => normal(difference / (sd * SQRT_2)),
        }
    }

    fn d_prime(self, difference: f64) -> f64 {
        match self {
            // From the tail that is near 0, where it is exact.
            Self::Logistic => -SQRT_2 * normal_quantile(logistic(-difference.abs())),
            Self::Normal { sd } => difference.abs() / sd,
        }
    }
}

impl Between {
    fn of(&self, a: usize, b: usize) -> f64 {
        self.differences[a * self.count + b]
    }
}

impl Psychometric {
    /// F at the difference `x`.
    fn seen(&self, x: f64) -> f64 {
        match self.shape {
            Shape::Logistic => logistic(self.slope * (x - self.threshold)),
            Shape::Probit => normal(self.slope * (x - self.threshold)),
            Shape::Weibull => -(-(x / self.threshold).powf(self.slope)).exp_m1(),
        }
    }
}

/// The logistic distribution function.
pub(super) fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// The standard normal distribution function Φ.
fn normal(x: f64) -> f64 {
    0.5 * erfc(-x / SQRT_2)
}

/// Its inverse z.
fn normal_quantile(p: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * p)
}
