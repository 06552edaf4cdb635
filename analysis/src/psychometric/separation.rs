//! Answers whose likelihood has no top: separated, all alike, or no better than guessing.

use super::scoring::{Level, term};
use crate::outcome::Outcome;
use std::cmp::Ordering;

/// Refuses data whose likelihood rises without end: those that a function of infinite slope, with one
/// level on the step and any chance there, fits as well as the best finite one. A function that is
/// nowhere above guessing, or everywhere at its top, is such a step beyond all levels.
pub(super) fn refuse_step(
    levels: &[Level],
    [guess_low, guess_high]: [f64; 2],
    [lapse_low, lapse_high]: [f64; 2],
    best: f64,
) -> Outcome<()> {
    let of = |side: &mut dyn Iterator<Item = &Level>, low: f64, high: f64| {
        let (chosen, trials) =
            side.fold((0, 0), |(k, n), level| (k + level.chosen, n + level.trials));
        let share = if trials == 0 { low } else { chosen as f64 / trials as f64 };
        let chance = share.clamp(low, high);
        term(chosen, chance) + term(trials - chosen, 1.0 - chance)
    };
    let bottom = |side: &mut dyn Iterator<Item = &Level>| of(side, guess_low, guess_high);
    let top = |side: &mut dyn Iterator<Item = &Level>| of(side, 1.0 - lapse_high, 1.0 - lapse_low);
    let fits = |log_likelihood: f64| log_likelihood >= best - 1e-8;
    let chosen: u64 = levels.iter().map(|level| level.chosen).sum();
    let trials: u64 = levels.iter().map(|level| level.trials).sum();
    if chosen == 0 || chosen == trials {
        let answer = if chosen == 0 { "never" } else { "always" };
        return Err(format!("all answers are alike: it was {answer} chosen, at every level"));
    }
    if fits(bottom(&mut levels.iter())) {
        return Err(format!(
            "the answers are nowhere above guessing ({chosen} of {trials}, guess rate {guess_high})"
        ));
    }
    if fits(top(&mut levels.iter())) {
        return Err(format!(
            "the answers are nowhere below the top ({chosen} of {trials}, lapse rate {lapse_high})"
        ));
    }
    // Which level it is at is not said: levels may be logarithms of what the reader knows.
    for step in levels.iter().map(|level| level.level) {
        let side =
            |order: Ordering| levels.iter().filter(move |l| l.level.total_cmp(&step) == order);
        let on = of(&mut side(Ordering::Equal), guess_low, 1.0 - lapse_low);
        let rising = bottom(&mut side(Ordering::Less)) + top(&mut side(Ordering::Greater));
        let falling = top(&mut side(Ordering::Less)) + bottom(&mut side(Ordering::Greater));
        if fits(on + rising.max(falling)) {
            return Err(
                "the answers are separated: a step at one of the levels fits them as well as any \
                        slope, so the slope is not determined"
                    .into(),
            );
        }
    }
    Ok(())
}
