//! Bootstrap replicates of what is more than one number, or drawn from a model: resampled observers,
//! binomial answers, and the interval of each number.

use crate::maths::bootstrap::{expanded_tail, quantile};
use crate::maths::random::stream;
use crate::outcome::Outcome;
use rand::{Rng, RngExt};
use rand_distr::{Binomial, Distribution};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::Serialize;

/// An interval may leave out at most this part of its replicates: what cannot be computed is not a
/// random part of them.
const MOST_FAILED: f64 = 0.05;

/// A bootstrap interval of one number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bootstrap {
    /// The 95 % interval.
    pub interval_95: [f64; 2],
    /// Standard deviation of the replicates.
    pub sd: f64,
    /// How many replicates were drawn.
    pub replicates: usize,
    /// How many of them gave no number.
    pub failed: usize,
}

impl Bootstrap {
    /// The percentile interval (Efron 1979) of the numbers of `replicates`, of which some may be missing.
    /// Where so many `observers` were drawn with replacement it is expanded, as in
    /// [`by_observer`](crate::maths::bootstrap::by_observer).
    ///
    /// # Errors
    /// Says so if more than one replicate in twenty gave no number.
    pub fn percentile(replicates: &[Option<f64>], observers: Option<usize>) -> Outcome<Self> {
        let mut values: Vec<f64> = replicates.iter().copied().flatten().collect();
        let failed = replicates.len() - values.len();
        if values.len() < 2 || failed as f64 > MOST_FAILED * replicates.len() as f64 {
            return Err(format!(
                "{failed} of {} resamples give no number, and at most one in twenty may be left out",
                replicates.len()
            ));
        }
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let tail = observers.map_or(0.025, expanded_tail);
        Ok(Self {
            interval_95: [quantile(&values, tail), quantile(&values, 1.0 - tail)],
            sd: libm::sqrt(squares / (n - 1.0)),
            replicates: replicates.len(),
            failed,
        })
    }
}

/// The results of `replicates` runs, each with random numbers of its own, in order; they do not depend
/// on the number of threads.
pub fn replicates<T: Send>(
    replicates: usize,
    seed: u64,
    run: impl Fn(&mut Pcg64) -> T + Sync,
) -> Vec<T> {
    (0..replicates as u64).into_par_iter().map(|index| run(&mut stream(seed, index))).collect()
}

/// How often each of `observers` is drawn when as many are drawn with replacement.
pub fn drawn(observers: usize, random: &mut impl Rng) -> Vec<u64> {
    let mut times = vec![0; observers];
    for _ in 0..observers {
        times[random.random_range(0..observers)] += 1;
    }
    times
}

/// A number of successes in `trials` of chance `p`; `p` is taken into 0 to 1.
pub fn binomial(trials: u64, p: f64, random: &mut impl Rng) -> u64 {
    // With p between 0 and 1 every number of trials is allowed.
    Binomial::new(trials, p.clamp(0.0, 1.0)).map_or(0, |law| law.sample(random))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_drawn_as_there_are() {
        let mut random = stream(1, 0);
        for n in [1, 2, 30] {
            assert_eq!(drawn(n, &mut random).iter().sum::<u64>(), n as u64);
        }
        assert_eq!(binomial(7, 1.2, &mut random), 7);
    }

    #[test]
    fn too_many_missing_replicates_are_refused() {
        let mut values: Vec<Option<f64>> = (0..100).map(|i| Some(f64::from(i))).collect();
        values[..5].fill(None);
        assert_eq!(Bootstrap::percentile(&values, None).unwrap().failed, 5);
        values[5] = None;
        assert!(
            Bootstrap::percentile(&values, None).unwrap_err().starts_with("6 of 100 resamples")
        );
        assert!(Bootstrap::percentile(&[], None).is_err());
    }

    #[test]
    fn few_observers_widen_the_interval() {
        let values: Vec<Option<f64>> = (0..=1000).map(|i| Some(f64::from(i))).collect();
        let of = |units| Bootstrap::percentile(&values, units).unwrap().interval_95;
        assert_eq!(of(None), [25.0, 975.0]);
        // pnorm(-sqrt(5/4)·qt(.975, 4)) = 0.000954 by R 4.2.2.
        assert!((of(Some(5))[0] - 0.954).abs() < 1e-3);
        assert!(of(Some(1000))[0] > 24.5);
    }
}
