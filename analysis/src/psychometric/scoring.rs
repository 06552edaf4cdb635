//! Binomial maximum likelihood by Fisher scoring, within bounds.

use nalgebra::{Matrix4, Vector4};

/// Answers at one level of the stimulus.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Level {
    /// The level.
    pub level: f64,
    /// How often the answer counted was given.
    pub chosen: u64,
    /// In how many trials.
    pub trials: u64,
}

/// The chance of the answer at one level: its value, its complement, and its derivatives after the four
/// parameters.
pub(super) struct Chance {
    pub value: f64,
    pub complement: f64,
    pub gradient: Vector4<f64>,
}

/// Where the likelihood is largest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Maximum {
    pub parameters: Vector4<f64>,
    /// Logarithm of the likelihood without the binomial coefficients.
    pub log_likelihood: f64,
    /// Expected information; rows and columns of parameters that are not free are those of the unit
    /// matrix.
    pub information: Matrix4<f64>,
    /// Which parameters are neither fixed nor at a bound.
    pub free: [bool; 4],
    pub converged: bool,
}

const MOST_STEPS: usize = 200;
/// Scoring ends when a step promises to raise the log-likelihood by less than this.
const SMALLEST_GAIN: f64 = 1e-13;

/// Maximises the likelihood of `levels` from `start`. A parameter whose two `bounds` agree is fixed.
///
/// # Formula
/// ```text
/// step = I⁻¹·s,  s = Σ (k − nψ)/(ψ(1 − ψ))·∂ψ,  I = Σ n/(ψ(1 − ψ))·∂ψ∂ψᵀ
/// ```
/// halved until the likelihood does not fall. A parameter at a bound that the score pushes outwards
/// waits there.
pub(super) fn maximise(
    levels: &[Level],
    start: Vector4<f64>,
    bounds: &[[f64; 2]; 4],
    chance: impl Fn(&Vector4<f64>, f64) -> Chance,
) -> Maximum {
    let likelihood = |parameters: &Vector4<f64>| {
        let of_level = |level: &Level| {
            let chance = chance(parameters, level.level);
            term(level.chosen, chance.value) + term(level.trials - level.chosen, chance.complement)
        };
        levels.iter().map(of_level).sum::<f64>()
    };
    let mut parameters = start;
    let mut log_likelihood = likelihood(&parameters);
    let mut step_count = 0;
    loop {
        let (mut score, mut information) = (Vector4::zeros(), Matrix4::zeros());
        for level in levels.iter().filter(|level| level.trials > 0) {
            let Chance { value, complement, gradient } = chance(&parameters, level.level);
            let variance = value * complement;
            if variance > 0.0 {
                let (k, n) = (level.chosen as f64, level.trials as f64);
                // k − nψ, without cancellation near both ends.
                score += gradient * ((k * complement - (n - k) * value) / variance);
                information += gradient * gradient.transpose() * (n / variance);
            }
        }
        let free: [bool; 4] = std::array::from_fn(|i| {
            let [low, high] = bounds[i];
            low < high
                && !(parameters[i] <= low && score[i] < 0.0)
                && !(parameters[i] >= high && score[i] > 0.0)
        });
        for i in (0..4).filter(|i| !free[*i]) {
            score[i] = 0.0;
            information.fill_row(i, 0.0);
            information.fill_column(i, 0.0);
            information[(i, i)] = 1.0;
        }
        let step = information.cholesky().map(|factor| factor.solve(&score));
        let gain = step.map_or(f64::NAN, |step| step.dot(&score));
        let finished =
            |converged| Maximum { parameters, log_likelihood, information, free, converged };
        if gain <= SMALLEST_GAIN {
            return finished(true);
        }
        let Some(step) = step.filter(|_| gain.is_finite() && step_count < MOST_STEPS) else {
            return finished(false);
        };
        let moved = (0..50).find_map(|halvings| {
            let mut next = parameters + step * libm::ldexp(1.0, -halvings);
            for (value, [low, high]) in next.iter_mut().zip(bounds) {
                *value = value.clamp(*low, *high);
            }
            let reached = likelihood(&next);
            (reached >= log_likelihood && next != parameters).then_some((next, reached))
        });
        match moved {
            Some((next, reached)) => (parameters, log_likelihood) = (next, reached),
            // No step leads up any more: the rounding error is reached.
            None => return finished(gain < 1e-6),
        }
        step_count += 1;
    }
}

/// `count`·ln `chance`, and 0 for nothing.
pub(super) fn term(count: u64, chance: f64) -> f64 {
    if count == 0 { 0.0 } else { count as f64 * libm::log(chance) }
}
