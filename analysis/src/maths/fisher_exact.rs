//! Fisher's exact test of a table with two columns: do rows share one chance?

use super::p_value::PValue;
use crate::outcome::Outcome;
use statrs::function::factorial::ln_binomial;

/// Tables whose probabilities differ by no more than this part count as equally likely, as in R's
/// `fisher.test`.
const EQUALLY_LIKELY: f64 = 1e-7;
/// The most tables that are looked at (a second on one core).
const MOST_TABLES: f64 = 2e7;

/// Two-sided exact test of whether the rows `[successes, failures]` share one chance of success (Fisher
/// 1935; Freeman and Halton 1951 for more than two rows). A table without successes, without failures
/// or with fewer than two rows has p = 1.
///
/// # Formula
/// ```text
/// p = Σ P(table) over all tables with the same margins and P(table) ≤ P(observed)
/// P(table) = Π C(nᵢ, kᵢ) / C(Σ nᵢ, Σ kᵢ), kᵢ successes of nᵢ in row i
/// ```
///
/// # Errors
/// In words: there are too many tables to look at.
pub fn fisher_exact(rows: &[[u64; 2]]) -> Outcome<f64> {
    let sizes: Vec<u64> = rows.iter().map(|[k, rest]| k + rest).collect();
    let (successes, trials) = (rows.iter().map(|[k, _]| k).sum(), sizes.iter().sum());
    let free = sizes.iter().skip(1);
    let tables: f64 = free.map(|n| (*n).min(successes) as f64 + 1.0).product();
    if tables > MOST_TABLES {
        return Err(format!(
            "Fisher's exact test would look at {tables:.0} tables, at most {MOST_TABLES:.0} are \
             looked at"
        ));
    }
    let ln_row: Vec<Vec<f64>> = sizes
        .iter()
        .map(|n| (0..=(*n).min(successes)).map(|k| ln_binomial(*n, k)).collect())
        .collect();
    let limit = ln_probability(rows) + EQUALLY_LIKELY;
    Ok(no_likelier(&ln_row, successes, -ln_binomial(trials, successes), limit).min(1.0))
}

/// Whether the share of `(k, n)`, k of n, is larger than that of `other`: exact, upper tail.
///
/// # Formula
/// ```text
/// P(X ≥ k), X ~ Hypergeometric: C(n, x) C(n′, k + k′ − x)/C(n + n′, k + k′)
/// ```
/// (Fisher 1935).
///
/// # Errors
/// In words: one of the two has no trials, or more successes than trials.
pub fn fisher_upper((k, n): (u64, u64), (other_k, other_n): (u64, u64)) -> Outcome<PValue> {
    if n == 0 || other_n == 0 {
        return Err("a test of two shares needs answers of both kinds".into());
    }
    if k > n || other_k > other_n {
        return Err("there are more successes than trials".into());
    }
    let all = k + other_k;
    let probability =
        |x: u64| libm::exp(ln_probability(&[[x, n - x], [all - x, other_n + x - all]]));
    Ok(PValue::new((k..=n.min(all)).rev().map(probability).sum::<f64>().min(1.0)))
}

/// Logarithm of the probability of the table `rows` among all with its margins: the hypergeometric law.
fn ln_probability(rows: &[[u64; 2]]) -> f64 {
    let [successes, failures] =
        rows.iter().fold([0, 0], |[k, rest], row| [k + row[0], rest + row[1]]);
    let ways: f64 = rows.iter().map(|[k, rest]| ln_binomial(k + rest, *k)).sum();
    ways - ln_binomial(successes + failures, successes)
}

/// Probability of the tables whose remaining rows have these logarithms of C(n, k) and share
/// `successes`, with `ln_p` for the rows before, that are no likelier than `limit`.
fn no_likelier(ln_rows: &[Vec<f64>], successes: u64, ln_p: f64, limit: f64) -> f64 {
    match ln_rows {
        [] if successes == 0 && ln_p <= limit => libm::exp(ln_p),
        [] => 0.0,
        [last] => match last.get(successes as usize) {
            Some(ln_last) => no_likelier(&[], 0, ln_p + ln_last, limit),
            None => 0.0,
        },
        [row, rest @ ..] => (0..=successes)
            .zip(row)
            .map(|(k, ln_row)| no_likelier(rest, successes - k, ln_p + ln_row, limit))
            .sum(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_is_that_of_r() {
        // R 4.2.2: fisher.test(matrix(c(3, 1, 1, 3), 2)) and so on.
        for (rows, p) in [
            (vec![[3, 1], [1, 3]], 0.485714285714286),
            (vec![[10, 2], [3, 15]], 0.000536724119143436),
            (vec![[9, 0], [5, 7]], 0.00712074303405571),
            (vec![[8, 2], [3, 7], [5, 5]], 0.106120005012973),
            (vec![[4, 1], [0, 6], [3, 3], [7, 2]], 0.0120995682201765),
            (vec![[2, 0], [3, 0]], 1.0),
        ] {
            let found = fisher_exact(&rows).unwrap();
            assert!((found / p - 1.0).abs() < 1e-10, "{rows:?}: {found}");
        }
        assert_eq!(fisher_exact(&[]), Ok(1.0));
        assert!(fisher_exact(&[[500, 500]; 4]).unwrap_err().starts_with("Fisher's exact test"));
    }

    #[test]
    fn neither_the_order_of_the_rows_nor_that_of_the_columns_matters() {
        let p = fisher_exact(&[[8, 2], [3, 7], [5, 9]]).unwrap();
        for rows in [[[3, 7], [5, 9], [8, 2]], [[2, 8], [7, 3], [9, 5]]] {
            assert!((fisher_exact(&rows).unwrap() - p).abs() < 1e-13);
        }
    }

    #[test]
    fn the_upper_tail_is_that_of_r() {
        // R 4.2.2: fisher.test(matrix(c(9, 11, 3, 17), 2), alternative = "greater").
        let p = fisher_upper((9, 20), (3, 20)).unwrap().value();
        assert!((p / 0.0411793885097555 - 1.0).abs() < 1e-10, "{p}");
    }

    #[test]
    fn more_successes_of_one_are_more_failures_of_the_other() {
        let successes = fisher_upper((5, 8), (2, 9)).unwrap().value();
        let failures = fisher_upper((7, 9), (3, 8)).unwrap().value();
        assert!((successes - failures).abs() < 1e-12);
        assert!((fisher_upper((0, 4), (3, 4)).unwrap().value() - 1.0).abs() < 1e-12);
        assert!(fisher_upper((0, 0), (3, 4)).is_err() && fisher_upper((5, 4), (0, 1)).is_err());
    }
}
