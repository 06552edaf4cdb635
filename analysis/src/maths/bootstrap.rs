//! Bootstrap intervals by observer: what if other observers of the same kind had answered?

use super::distributions::normal_tail;
use super::random::stream;
use super::student::t_975;
use crate::outcome::Outcome;
use rand::RngExt;
use rayon::prelude::*;

/// How many replicates are drawn.
pub const REPLICATES: u64 = 1999;
/// With fewer observers the resampled studies are too few and too alike.
pub(crate) const MIN_OBSERVERS: usize = 5;

/// The 95 % interval of a statistic of `observers`, from [`REPLICATES`] times as many observers as there
/// are, drawn with replacement. `statistic` is given the places of those drawn; it has no value where
/// they lack what it needs. The result does not depend on the number of threads.
///
/// # Errors
/// In words: too few observers, or resampled studies in which the statistic has no value.
pub fn by_observer(
    observers: usize,
    seed: u64,
    statistic: impl Fn(&[usize]) -> Option<f64> + Sync,
) -> Outcome<[f64; 2]> {
    enough_observers(observers)?;
    let values: Vec<f64> = (0..REPLICATES)
        .into_par_iter()
        .filter_map(|index| {
            let mut random = stream(seed, index);
            let drawn: Vec<usize> =
                (0..observers).map(|_| random.random_range(0..observers)).collect();
            statistic(&drawn).filter(|value| value.is_finite())
        })
        .collect();
    let without = REPLICATES - values.len() as u64;
    if without > REPLICATES / 20 {
        return Err(format!(
            "in {without} of {REPLICATES} studies of resampled observers it is not known"
        ));
    }
    Ok(expanded_percentile_95(values, observers))
}

/// Hesterberg's (2015) expanded percentile interval of one or more `values` of replicates; the plain one
/// (α′ = 0.05) is too narrow with few `observers`.
///
/// # Formula
/// ```text
/// the α′/2 and 1 − α′/2 quantiles of the replicates, α′/2 = Φ(−√(n/(n−1)) · t_{n−1; 0.975})
/// ```
pub(crate) fn expanded_percentile_95(mut values: Vec<f64>, observers: usize) -> [f64; 2] {
    values.sort_unstable_by(f64::total_cmp);
    let tail = expanded_tail(observers);
    [quantile(&values, tail), quantile(&values, 1.0 - tail)]
}

/// Whether so many observers can be resampled.
///
/// # Errors
/// In words: they are too few.
pub(crate) fn enough_observers(observers: usize) -> Outcome<()> {
    match observers {
        MIN_OBSERVERS.. => Ok(()),
        _ => Err(format!(
            "a bootstrap by observer needs at least {MIN_OBSERVERS} observers, here are {observers}"
        )),
    }
}

/// α′/2 of the expanded percentile interval for so many observers.
pub(crate) fn expanded_tail(observers: usize) -> f64 {
    let n = observers as f64;
    normal_tail(libm::sqrt(n / (n - 1.0)) * t_975(n - 1.0))
}

/// The `p` quantile of `sorted` values, by linear interpolation between order statistics.
pub(crate) fn quantile(sorted: &[f64], p: f64) -> f64 {
    let place = p * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_is_about_that_of_t() {
        let values: Vec<f64> = (0..20).map(|i| libm::sin(f64::from(i) * 1.7)).collect();
        let mean = values.iter().sum::<f64>() / 20.0;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 19.0;
        let half = t_975(19.0) * libm::sqrt(variance / 20.0);
        let [low, high] =
            by_observer(20, 1, |drawn| Some(drawn.iter().map(|i| values[*i]).sum::<f64>() / 20.0))
                .unwrap();
        assert!((low - (mean - half)).abs() < 0.1 * half, "{low}");
        assert!((high - (mean + half)).abs() < 0.1 * half, "{high}");
    }

    #[test]
    fn too_little_to_resample_is_said() {
        assert!(by_observer(1, 1, |_| Some(0.0)).unwrap_err().contains("at least 5"));
        assert!(by_observer(9, 1, |_| None).unwrap_err().contains("not known"));
    }
}
