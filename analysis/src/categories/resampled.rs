//! d′ with its bootstrap interval by observer.

use super::discrimination::{Counts, DPrime, Model};
use super::forced_choice::{ForcedChoice, ForcedChoiceDPrime, share};
use crate::maths::bootstrap::by_observer;
use crate::outcome::{Outcome, serialize_outcomes};

/// What the draws follow from.
const SEED: u64 = 0xd_9417e;

/// An estimate with its bootstrap interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled<T> {
    /// The estimate from all answers.
    pub estimate: T,
    /// 95 % interval by observer, which holds when observers differ.
    pub bootstrap_95: Outcome<[f64; 2]>,
}

serialize_outcomes!(Resampled<DPrime>, [estimate], [bootstrap_95]);
serialize_outcomes!(Resampled<ForcedChoiceDPrime>, [estimate], [bootstrap_95]);

/// d′ from each observer's counts, all of one task.
///
/// # Errors
/// As [`Model::d_prime`].
pub fn d_prime(model: Model, by: &[Counts]) -> Outcome<Resampled<DPrime>> {
    let pooled =
        |counts: &mut dyn Iterator<Item = Counts>| counts.fold(Counts::default(), Counts::and);
    let estimate = model.d_prime(pooled(&mut by.iter().copied()))?;
    let mut answered: Vec<Counts> =
        by.iter().copied().filter(|counts| counts.signals + counts.noises > 0).collect();
    // Draws do not depend on the order in which observers are listed.
    answered.sort_unstable();
    let bootstrap_95 = resample(estimate.correction, &answered, |drawn| {
        model.sensitivity(pooled(&mut drawn.iter().map(|i| answered[*i])))
    });
    Ok(Resampled { estimate, bootstrap_95 })
}

/// d′ from each observer's right answers and answers.
///
/// # Errors
/// As [`ForcedChoice::d_prime`].
pub fn forced_choice(
    task: ForcedChoice,
    by: &[(u64, u64)],
) -> Outcome<Resampled<ForcedChoiceDPrime>> {
    let add = |(a, b): (u64, u64), (k, n): (u64, u64)| (a + k, b + n);
    let (correct, trials) = by.iter().copied().fold((0, 0), add);
    let estimate = task.d_prime(correct, trials)?;
    let mut answered: Vec<(u64, u64)> = by.iter().copied().filter(|(_, n)| *n > 0).collect();
    answered.sort_unstable();
    let shares = resample(estimate.correction, &answered, |drawn| {
        let (correct, trials) = drawn.iter().map(|i| answered[*i]).fold((0, 0), add);
        Some(share(correct, trials).0)
    });
    // d′ rises with the share, so its quantiles are at those of the share.
    let bootstrap_95 = shares.and_then(|ends| match ends.map(|end| task.solve(end)) {
        [Some(low), Some(high)] => Ok([low, high]),
        _ => Err("the interval by observer reaches beyond the range of d′".into()),
    });
    Ok(Resampled { estimate, bootstrap_95 })
}

/// The bootstrap interval, unless a share was corrected: one of 0 or 1 is the same in every resampled
/// study, which shows nothing of what is not known.
fn resample<T>(
    correction: Option<&str>,
    answered: &[T],
    statistic: impl Fn(&[usize]) -> Option<f64> + Sync,
) -> Outcome<[f64; 2]> {
    match correction {
        Some(_) => Err("a share of 0 or 1 does not vary between resampled observers".into()),
        None => by_observer(answered.len(), SEED, statistic),
    }
}
