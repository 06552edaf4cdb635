//! What to do, in one sentence.

use super::Plan;
use super::rating::{RatingRow, TRUTHS, trials_needed};
use super::scores::{POWER, ScoreRow, log_odds};
use super::separability::separation;
use super::share::ShareTest;
use crate::paired::score_groups::critical_difference;
use shutterlab_data_schema::protocol::Task;

/// More observers than this are not looked for.
const MOST: u64 = 1000;

/// The smallest number of observers in `plan` that finds the assumed effect with probability 0.8, or how
/// many more it takes.
pub(super) fn advice(plan: &Plan) -> String {
    let fewest = plan
        .levels
        .as_ref()
        .ok()
        .and_then(|levels| levels.iter().min_by_key(|(_, test)| test.answers_per_observer));
    match (&plan.scores, &plan.rating, fewest, &plan.pair) {
        (Ok(rows), ..) => by_scores(plan, rows),
        (_, Ok(rows), ..) => by_rating(plan, rows),
        (.., Some((comparisons, test)), _) => {
            let ([one, other], axis) = (&comparisons[0].levels, &comparisons[0].axis);
            let what = format!("between two levels of an axis, such as {axis} {one} and {other}");
            by_share(plan, test, &what)
        }
        (.., Ok(test)) => by_share(plan, test, "in a single pair"),
        (.., Err(reason)) => format!("No number of observers can be advised: {reason}."),
    }
}

fn by_scores(plan: &Plan, rows: &[ScoreRow]) -> String {
    let (alpha, effect) = (plan.assumptions.alpha, plan.assumptions.effect);
    let (t, times) = (plan.design.stimuli.len(), plan.design.times().unwrap_or(1));
    let power = |observers: u64| {
        let sets = observers * times;
        separation(sets, t, critical_difference(sets, t, alpha), log_odds(effect))
    };
    let simulated = plan.simulated.as_ref().ok();
    let found: Vec<(u64, f64, String)> = rows
        .iter()
        .enumerate()
        .map(|(place, row)| {
            let differ = simulated.and_then(|simulated| simulated.effect_differ.get(place));
            let differ = differ.filter(|_| plan.assumptions.spread > 0.0).map(|found| {
                let spread = plan.assumptions.spread;
                format!(" ({:.2} if people differ by an SD of {spread} in ln π)", found.ends.value)
            });
            (row.observers, row.power, differ.unwrap_or_default())
        })
        .collect();
    let what = format!(
        "tell two stimuli apart by R_c (α = {alpha}) if one is preferred to the other in {:.0} % of the \
         answers and the rest stand between them",
        100.0 * effect
    );
    sentence(plan, &found, power, &what)
}

fn by_rating(plan: &Plan, rows: &[RatingRow]) -> String {
    let times = plan.design.times().unwrap_or(1);
    let needed = TRUTHS.map(|truth| trials_needed(truth, POWER).map(|n| n.div_ceil(times)));
    let [first, second] = needed.map(|n| n.map_or("more than 5000".into(), |n| n.to_string()));
    let known = rows.last().map_or(String::new(), |row| {
        format!("; {} show the former with {:.2}", people(row.observers), row.clears[0])
    });
    format!(
        "{first} observers{} show with probability {POWER} that the rating of a pair exceeds 0.8 if the true one \
         is {}, {second} if it is {}{known}.",
        needed[0].map_or(String::new(), |n| duration(plan, n)),
        TRUTHS[0],
        TRUTHS[1],
    )
}

fn by_share(plan: &Plan, test: &ShareTest, what: &str) -> String {
    let (alpha, effect) = (plan.assumptions.alpha, plan.assumptions.effect);
    let ShareTest { answers_per_observer: answers, sides, log_odds_sd: sd, .. } = *test;
    let differ = match answers > 1 && sd > 0.0 {
        true => format!(", if people differ by an SD of {sd:.2} in log-odds,"),
        false => String::new(),
    };
    let percent = 100.0 * effect;
    let aim = match plan.design.task {
        Task::TwoAfc => format!("find{differ} a preference of {percent:.0} % {what}"),
        _ => format!("show{differ} {percent:.0} % right answers {what} to be better than chance"),
    };
    let each = if answers == 1 { "1 answer".into() } else { format!("{answers} answers") };
    let aim = format!("{aim} (exact binomial test, {each} each, α = {alpha})");
    let place = test.shares.iter().position(|share| *share == effect).unwrap_or(0);
    let found: Vec<(u64, f64, String)> = test
        .rows
        .iter()
        .map(|row| (row.observers, row.power_if_people_differ[place], String::new()))
        .collect();
    let power = |observers: u64| {
        let one = ShareTest::new(&[observers], answers, alpha, &[effect], sides, sd);
        one.rows[0].power_if_people_differ[0]
    };
    sentence(plan, &found, power, &aim)
}

/// The first number of observers in `found` (with its power and a remark) that is enough for `what`, or the
/// number that would be.
fn sentence(
    plan: &Plan,
    found: &[(u64, f64, String)],
    power: impl Fn(u64) -> f64,
    what: &str,
) -> String {
    let enough = found.iter().position(|(_, power, _)| *power >= POWER);
    let Some((observers, reached, remark)) = enough.map_or(found.last(), |place| found.get(place))
    else {
        return "No number of observers was given.".into();
    };
    let beside = match enough {
        Some(0) => String::new(),
        Some(place) => format!("; {} do so with {:.2}", found[place - 1].0, found[place - 1].1),
        None => {
            // Steps of a tenth are near enough for advice.
            let more = std::iter::successors(Some(observers + 1), |n| Some(n + n.div_ceil(10)));
            match more.take_while(|n| *n <= MOST).find(|n| power(*n) >= POWER) {
                Some(n) => format!(" only; about {n} would with {POWER}"),
                None => format!(" only; not even {MOST} would with {POWER}"),
            }
        }
    };
    let duration = duration(plan, *observers);
    let who = people(*observers);
    format!("{who}{duration} {what} with probability {reached:.2}{remark}{beside}.")
}

fn people(observers: u64) -> String {
    format!("{observers} observer{}", if observers == 1 { "" } else { "s" })
}

fn duration(plan: &Plan, observers: u64) -> String {
    let minutes = plan.design.minutes;
    let hours = observers as f64 * minutes / 60.0;
    format!(" (about {minutes:.0} minutes each, {hours:.1} hours in all)")
}
