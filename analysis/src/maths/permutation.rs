//! Permutation tests of groups: could the values of the members be spread like this over groups that mean
//! nothing?

use super::random::stream;
use rand::seq::SliceRandom;
use rayon::prelude::*;

/// Up to this number of ways to form the groups, all are looked at.
const MOST_EXACT: f64 = 50_000.0;
/// Otherwise so many are drawn.
const DRAWN: u64 = 19_999;
/// Statistics that differ by no more than this part count as equal.
const EQUAL: f64 = 1e-9;

/// How the groups were formed anew.
#[derive(Clone, Debug, PartialEq)]
pub struct Permutations {
    /// p of each column of values: the share of the ways whose statistic is at least the one observed.
    pub p: Vec<f64>,
    /// p of the sum of the columns' statistics.
    pub p_overall: f64,
    /// Whether all ways were looked at.
    pub exact: bool,
    /// How many were looked at.
    pub ways: u64,
    /// The smallest p there could be: groups of one size can be exchanged without any change.
    pub smallest_p: f64,
}

/// Tests whether the groups 0, 1, … given by `labels` differ in their means of each column of `values` (one
/// row per member), and in the `overall` first columns together.
///
/// # Formula
/// ```text
/// S = Σ_g n_g (mean_g − mean)² per column; p = #{S* ≥ S}/ways, or (1 + #{S* ≥ S})/(1 + ways) if drawn
/// ```
/// All groupings with the same sizes are as likely if the groups mean nothing (Fisher 1935; Pitman 1937).
/// For two groups S orders the groupings as the difference of the means does.
pub fn permutation_test(
    labels: &[usize],
    values: &[Vec<f64>],
    overall: usize,
    seed: u64,
) -> Permutations {
    let groups = labels.iter().max().map_or(0, |most| most + 1);
    let columns = values.first().map_or(0, Vec::len);
    let means: Vec<f64> = (0..columns)
        .map(|c| values.iter().map(|row| row[c]).sum::<f64>() / values.len() as f64)
        .collect();
    let statistics = |labels: &[usize]| -> Vec<f64> {
        let mut sums = vec![vec![0.0; columns]; groups];
        let mut sizes = vec![0.0; groups];
        for (label, row) in labels.iter().zip(values) {
            sizes[*label] += 1.0;
            for (sum, (value, mean)) in sums[*label].iter_mut().zip(row.iter().zip(&means)) {
                *sum += value - mean;
            }
        }
        let mut statistics: Vec<f64> = (0..columns)
            .map(|c| (0..groups).map(|g| sums[g][c] * sums[g][c] / sizes[g]).sum())
            .collect();
        statistics.push(statistics[..overall].iter().sum());
        statistics
    };
    let observed = statistics(labels);
    let reached = |labels: &[usize]| -> Vec<u64> {
        let found = statistics(labels);
        let pairs = found.iter().zip(&observed);
        pairs.map(|(s, o)| u64::from(*s >= o * (1.0 - EQUAL) - EQUAL)).collect()
    };
    let add = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let exact = ways(labels, groups) <= MOST_EXACT;
    let (counts, ways): (Vec<u64>, u64) = if exact {
        let mut way = labels.to_vec();
        way.sort_unstable();
        let (mut counts, mut ways) = (reached(&way), 1);
        while next(&mut way) {
            counts = add(counts, reached(&way));
            ways += 1;
        }
        (counts, ways)
    } else {
        let draw = |index| {
            let mut way = labels.to_vec();
            way.shuffle(&mut stream(seed, index));
            reached(&way)
        };
        let counts = (0..DRAWN).into_par_iter().map(draw).reduce(|| vec![0; columns + 1], add);
        (counts, DRAWN)
    };
    let also = u64::from(!exact);
    let mut p: Vec<f64> =
        counts.iter().map(|count| (count + also) as f64 / (ways + also) as f64).collect();
    let p_overall = p.pop().unwrap_or(1.0);
    let smallest_p = match exact {
        true => exchanges(labels, groups) / ways as f64,
        false => 1.0 / (ways as f64 + 1.0),
    };
    Permutations { p, p_overall, exact, ways, smallest_p }
}

/// In how many ways groups of these sizes can be formed.
fn ways(labels: &[usize], groups: usize) -> f64 {
    let mut left = labels.len();
    let mut ways = 1.0;
    for group in 0..groups {
        let size = labels.iter().filter(|label| **label == group).count();
        ways *= statrs::function::factorial::binomial(left as u64, size as u64);
        left -= size;
    }
    ways
}

/// In how many ways groups of one size can be exchanged.
fn exchanges(labels: &[usize], groups: usize) -> f64 {
    let size = |group: usize| labels.iter().filter(|label| **label == group).count();
    // The k-th group of its size has k places to go to.
    (0..groups).map(|g| (0..=g).filter(|other| size(*other) == size(g)).count() as f64).product()
}

/// Turns `labels` into the next arrangement in lexicographic order, if there is one.
fn next(labels: &mut [usize]) -> bool {
    let Some(pivot) = labels.windows(2).rposition(|pair| pair[0] < pair[1]) else { return false };
    let Some(larger) = labels.iter().rposition(|label| *label > labels[pivot]) else {
        return false;
    };
    labels.swap(pivot, larger);
    labels[pivot + 1..].reverse();
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_are_those_of_counting() {
        // Of the C(5, 2) = 10 ways, only {1, 2} | {3, 4, 5} and {4, 5} | {1, 2, 3} are as far apart.
        let values: Vec<Vec<f64>> = [1.0, 2.0, 3.0, 4.0, 5.0].map(|v| vec![v]).to_vec();
        let found = permutation_test(&[0, 0, 1, 1, 1], &values, 1, 1);
        assert_eq!((found.exact, found.ways), (true, 10));
        assert!((found.p[0] - 0.2).abs() < 1e-12 && (found.p_overall - 0.2).abs() < 1e-12);
        let three = permutation_test(&[0, 1, 2, 1, 0], &values, 1, 1);
        assert_eq!(three.ways, 30);
        assert!((found.smallest_p - 0.1).abs() < 1e-12);
        assert!((three.smallest_p - 2.0 / 30.0).abs() < 1e-12);
    }

    #[test]
    fn drawn_ways_approach_all_ways() {
        let values: Vec<Vec<f64>> =
            (0..30).map(|i| vec![f64::from(i % 7), f64::from((i * i) % 5)]).collect();
        let labels: Vec<usize> = (0..30).map(|i| usize::from(i % 3 == 0)).collect();
        let found = permutation_test(&labels, &values, 2, 1);
        assert!(!found.exact && found.ways == DRAWN);
        assert_eq!(permutation_test(&labels, &values, 2, 1), found);
        let other = permutation_test(&labels, &values, 2, 2);
        assert!((found.p[0] - other.p[0]).abs() < 0.02);
    }

    #[test]
    fn values_that_are_all_equal_give_one() {
        let found = permutation_test(&[0, 0, 1, 1], &vec![vec![0.3]; 4], 1, 1);
        assert_eq!(found.p, [1.0]);
    }
}
