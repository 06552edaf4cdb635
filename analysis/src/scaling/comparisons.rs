//! What scale values are made from: how often one of each pair was chosen over the other, and how
//! often neither was. Counts may differ between pairs, and pairs may be missing.

use crate::input::preferences::{Choice, WinMatrix};
use crate::outcome::Outcome;
use shutterlab_data_schema::response::Side;
use std::collections::BTreeMap;

/// The answers to one pair of items.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Place of the first item.
    pub i: usize,
    /// Place of the second, above `i`.
    pub j: usize,
    /// How often `i` was chosen over `j`, and `j` over `i`.
    pub wins: [f64; 2],
    /// How often neither was chosen ("not sure").
    pub ties: f64,
}

/// The answers to all pairs of t items that were compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparisons {
    items: Vec<String>,
    pairs: Vec<Pair>,
}

impl Comparisons {
    /// The counts of a square matrix: `wins[i][j]` times was item i chosen over item j. Counts need not
    /// be whole, so that a tie can be half a win for each.
    ///
    /// # Errors
    /// In words: the matrix has not one row and one column for each of two or more items, or holds what
    /// is no count.
    pub fn of_matrix(items: &[String], wins: &[Vec<f64>]) -> Outcome<Self> {
        let t = items.len();
        if t < 2 {
            return Err(format!("at least two items are needed for a scale, not {t}"));
        }
        if wins.len() != t || wins.iter().any(|row| row.len() != t) {
            return Err(format!("{t} items need {t} rows of {t} counts"));
        }
        if (0..t).any(|i| wins[i][i] != 0.0) {
            return Err("no item can be chosen over itself".into());
        }
        let places = (0..t).flat_map(|i| (i + 1..t).map(move |j| (i, j)));
        let pairs = places.map(|(i, j)| Pair { i, j, wins: [wins[i][j], wins[j][i]], ties: 0.0 });
        Self::of_pairs(items, pairs.collect())
    }

    /// The counts of `pairs` among `items`, with ties.
    ///
    /// # Errors
    /// In words: a pair comes twice, is none of two items in their order, or holds what is no count.
    pub fn of_pairs(items: &[String], mut pairs: Vec<Pair>) -> Outcome<Self> {
        let counts = |pair: &Pair| [pair.wins[0], pair.wins[1], pair.ties];
        let mut every = pairs.iter().flat_map(counts);
        if let Some(count) = every.find(|count| !count.is_finite() || *count < 0.0) {
            return Err(format!("{count} is no count: a number from 0 is needed"));
        }
        if pairs.iter().any(|pair| pair.i >= pair.j || pair.j >= items.len()) {
            return Err("a pair needs the places of two items, the smaller first".into());
        }
        pairs.retain(|pair| pair.trials() > 0.0);
        pairs.sort_by_key(|pair| (pair.i, pair.j));
        if pairs.windows(2).any(|two| (two[0].i, two[0].j) == (two[1].i, two[1].j)) {
            return Err("a pair comes twice".into());
        }
        Ok(Self { items: items.to_vec(), pairs })
    }

    /// The choices of `observers` among `items`, of each observer by itself.
    pub fn of_choices(items: &[String], observers: usize, choices: &[Choice]) -> Vec<Self> {
        let mut pairs: Vec<BTreeMap<(usize, usize), Pair>> = vec![BTreeMap::new(); observers];
        for choice in choices {
            let (i, j) = (choice.a.min(choice.b), choice.a.max(choice.b));
            let empty = Pair { i, j, wins: [0.0; 2], ties: 0.0 };
            let pair = pairs[choice.observer].entry((i, j)).or_insert(empty);
            match choice.chosen {
                Some(Side::A) => pair.wins[usize::from(choice.a == j)] += 1.0,
                Some(Side::B) => pair.wins[usize::from(choice.b == j)] += 1.0,
                None => pair.ties += 1.0,
            }
        }
        let of_one = |pairs: BTreeMap<_, Pair>| Self {
            items: items.to_vec(),
            pairs: pairs.into_values().collect(),
        };
        pairs.into_iter().map(of_one).collect()
    }

    /// The choices of row over column in `wins`.
    pub fn of_wins(items: &[String], wins: &WinMatrix) -> Self {
        let pair =
            |(i, j)| Pair { i, j, wins: [wins.get(i, j) as f64, wins.get(j, i) as f64], ties: 0.0 };
        let pairs = wins.pairs().map(pair).filter(|pair| pair.trials() > 0.0).collect();
        Self { items: items.to_vec(), pairs }
    }

    /// The answers of all `observers` together; they have the same items.
    pub fn pooled(observers: &[Self]) -> Self {
        let mut pairs: BTreeMap<(usize, usize), Pair> = BTreeMap::new();
        for pair in observers.iter().flat_map(|observer| &observer.pairs) {
            let sum = pairs.entry((pair.i, pair.j)).or_insert(Pair {
                wins: [0.0; 2],
                ties: 0.0,
                ..*pair
            });
            sum.wins[0] += pair.wins[0];
            sum.wins[1] += pair.wins[1];
            sum.ties += pair.ties;
        }
        let items =
            observers.iter().map(|observer| &observer.items).max_by_key(|items| items.len());
        let items = items.cloned().unwrap_or_default();
        Self { items, pairs: pairs.into_values().collect() }
    }

    /// The items.
    pub fn items(&self) -> &[String] {
        &self.items
    }

    /// The pairs that were compared.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// The places of each pair's items, and the wins of either with half a win for every tie.
    pub(super) fn answers(&self) -> impl Iterator<Item = ((usize, usize), [f64; 2])> {
        self.pairs.iter().map(|pair| ((pair.i, pair.j), pair.wins_and_half_ties()))
    }

    /// The number of answers.
    pub fn trials(&self) -> f64 {
        self.pairs.iter().map(Pair::trials).sum()
    }

    /// The number of answers that chose neither.
    pub fn ties(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.ties).sum()
    }
}

impl Pair {
    /// The number of answers.
    pub fn trials(&self) -> f64 {
        self.wins[0] + self.wins[1] + self.ties
    }

    /// The wins of either side with half a win to each for every tie.
    pub fn wins_and_half_ties(&self) -> [f64; 2] {
        self.wins.map(|wins| wins + 0.5 * self.ties)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(t: usize) -> Vec<String> {
        (1..=t).map(|i| format!("item {i}")).collect()
    }

    #[test]
    fn choices_are_counted_by_pair_whichever_side_they_were_on() {
        let choice =
            |observer, a, b, chosen| Choice { observer, a, b, chosen, first: Some(Side::A) };
        let choices = [
            choice(0, 0, 2, Some(Side::A)),
            choice(0, 2, 0, Some(Side::A)),
            choice(0, 2, 0, Some(Side::B)),
            choice(1, 2, 0, None),
            choice(1, 1, 0, Some(Side::A)),
        ];
        let observers = Comparisons::of_choices(&names(3), 2, &choices);
        assert_eq!(observers[0].pairs, [Pair { i: 0, j: 2, wins: [2.0, 1.0], ties: 0.0 }]);
        let pooled = Comparisons::pooled(&observers);
        assert_eq!(
            pooled.pairs,
            [
                Pair { i: 0, j: 1, wins: [0.0, 1.0], ties: 0.0 },
                Pair { i: 0, j: 2, wins: [2.0, 1.0], ties: 1.0 },
            ]
        );
        assert_eq!((pooled.items().len(), pooled.trials(), pooled.ties()), (3, 5.0, 1.0));
        assert_eq!(pooled.pairs[1].wins_and_half_ties(), [2.5, 1.5]);
    }

    #[test]
    fn what_is_no_matrix_of_counts_is_refused_in_words() {
        for (wins, expect) in [
            (vec![vec![0.0]], "at least two items"),
            (vec![vec![0.0, 1.0], vec![2.0]], "2 items need 2 rows of 2 counts"),
            (vec![vec![0.0, f64::NAN], vec![2.0, 0.0]], "NaN is no count"),
            (vec![vec![0.0, -1.0], vec![2.0, 0.0]], "-1 is no count"),
            (vec![vec![1.0, 1.0], vec![2.0, 0.0]], "no item can be chosen over itself"),
        ] {
            let error = Comparisons::of_matrix(&names(wins.len()), &wins).unwrap_err();
            assert!(error.starts_with(expect), "{error}");
        }
    }
}
