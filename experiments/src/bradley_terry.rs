//! The Bradley–Terry model (1952) from scores: strengths π whose expected votes are given.
//!
//! ```text
//! P(i is chosen over j) = πᵢ / (πᵢ + πⱼ)        vᵢ = N · Σ_{j≠i} πᵢ / (πᵢ + πⱼ)
//! ```
//!
//! N: observers, each of whom compares every pair once; vᵢ: votes of item i. The votes are sufficient
//! for π, and Zermelo's iteration (1929; an MM algorithm, Hunter 2004) finds it:
//! πᵢ ← vᵢ / (N · Σ_{j≠i} 1/(πᵢ + πⱼ)).
//!
//! A solution exists if and only if every k items won votes against the others, that is, if the k
//! lowest scores add up to more than N·k(k − 1)/2, for all k below the number of items.

use shutterlab_data_schema::Votes;

/// No strengths give these votes.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// No observers.
    #[error("observers: 0: at least one is needed")]
    NoObservers,
    /// The votes are not those of all pairs.
    #[error(
        "votes: {sum} in all: {observers} observers who compare every pair of {items} items once give {expected}"
    )]
    Sum {
        /// Sum of the votes.
        sum: u128,
        /// What it must be.
        expected: u128,
        /// Number of observers.
        observers: u32,
        /// Number of items.
        items: usize,
    },
    /// Some items never won against the others, so the model has no finite strengths.
    #[error(
        "votes: {}: chosen over none of the other items by anybody, which no Bradley–Terry model expects; leave them out of table and design", items.join(", ")
    )]
    Separated {
        /// The items.
        items: Vec<String>,
    },
    /// The iteration did not come near enough.
    #[error("votes: so uneven that the strengths were not found in {0} iterations")]
    NotFound(u32),
}

/// Largest difference between expected and given votes, per observer, at which strengths are found.
const TOLERANCE: f64 = 1e-10;

/// Iterations after which to give up: some seconds of work for 25 items. Tables of real experiments
/// take hundreds.
const MAX_ITERATIONS: u32 = 2_000_000;

/// Strengths, in the order of the table and adding up to 1, whose expected votes are `votes` when
/// each of `observers` compares every pair once.
///
/// # Errors
/// See [`FitError`].
pub fn strengths(votes: &Votes, observers: u32) -> Result<Vec<f64>, FitError> {
    let items = votes.rows.len();
    if observers == 0 {
        return Err(FitError::NoObservers);
    }
    let pairs = |count: usize| count as u128 * (count as u128 - 1) / 2;
    let sum: u128 = votes.rows.iter().map(|row| u128::from(row.votes)).sum();
    let expected = u128::from(observers) * pairs(items);
    if sum != expected {
        return Err(FitError::Sum { sum, expected, observers, items });
    }
    let mut ranked: Vec<_> = votes.rows.iter().collect();
    ranked.sort_by_key(|row| row.votes);
    let mut lowest_sum = 0;
    for count in 1..items {
        lowest_sum += u128::from(ranked[count - 1].votes);
        if lowest_sum <= u128::from(observers) * pairs(count) {
            let items = ranked[..count].iter().map(|row| row.item.clone()).collect();
            return Err(FitError::Separated { items });
        }
    }

    let rates: Vec<f64> =
        votes.rows.iter().map(|row| row.votes as f64 / f64::from(observers)).collect();
    let mut strengths = vec![1.0 / items as f64; items];
    for _ in 0..MAX_ITERATIONS {
        let expected = expected_votes(&strengths);
        let error = expected.iter().zip(&rates).map(|(e, v)| (e - v).abs()).fold(0.0, f64::max);
        if error < TOLERANCE {
            return Ok(strengths);
        }
        // πᵢ/eᵢ is the reciprocal of Σ 1/(πᵢ + πⱼ).
        for ((strength, rate), expected) in strengths.iter_mut().zip(&rates).zip(expected) {
            *strength *= rate / expected;
        }
        let sum: f64 = strengths.iter().sum();
        strengths.iter_mut().for_each(|strength| *strength /= sum);
    }
    Err(FitError::NotFound(MAX_ITERATIONS))
}

/// Votes that one observer who compares every pair once is expected to give each item.
pub fn expected_votes(strengths: &[f64]) -> Vec<f64> {
    let expected = |i: usize| {
        let others = strengths.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, other)| strengths[i] / (strengths[i] + other)).sum()
    };
    (0..strengths.len()).map(expected).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn votes(rows: &[(&str, u64)]) -> Votes {
        let mut text = String::from("item,votes\n");
        rows.iter().for_each(|(item, votes)| text += &format!("{item},{votes}\n"));
        Votes::parse(&text, "test").unwrap()
    }

    /// Each of 25 observers compares the 36 pairs: 900 votes.
    #[test]
    fn expected_votes_are_the_given_ones() {
        let given = [150, 140, 131, 120, 100, 89, 70, 60, 40];
        let names = ["a", "b", "c", "d", "e", "f", "g", "h", "i"];
        let rows: Vec<(&str, u64)> = names.into_iter().zip(given).collect();
        let strengths = strengths(&votes(&rows), 25).unwrap();
        for (expected, given) in expected_votes(&strengths).iter().zip(given) {
            assert!((25.0 * expected - given as f64).abs() < 1e-6, "{expected} {given}");
        }
    }

    /// Two items: the strengths are the votes' shares.
    #[test]
    fn two_items_have_a_closed_form() {
        let found = strengths(&votes(&[("a", 3), ("b", 1)]), 4).unwrap();
        assert!((found[0] - 0.75).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_has_no_solution_is_refused_by_name() {
        for (rows, observers, expect) in [
            (&[("a", 4), ("b", 0)][..], 4, "votes: b: chosen over none"),
            (&[("a", 8), ("b", 3), ("c", 1)], 4, "votes: c, b: chosen over none"),
            (&[("a", 4), ("b", 1)], 4, "votes: 5 in all: 4 observers"),
            (&[("a", 0), ("b", 0)], 0, "observers: 0"),
        ] {
            let error = strengths(&votes(rows), observers).unwrap_err().to_string();
            assert!(error.starts_with(expect), "{error}");
        }
    }
}
