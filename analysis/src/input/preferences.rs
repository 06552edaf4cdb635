//! What is analysed: who preferred what to what, as far as it is known.

use crate::error::InputError;
use crate::input::data_quality::DataQuality;
use shutterlab_data_schema::Votes;
use shutterlab_data_schema::response::Side;
use std::collections::BTreeMap;

/// The most observers that counts are kept for; beyond it sums of squares would overflow.
const MAX_OBSERVERS: u64 = 1_000_000;
/// The most items; a table of more is a mistake, and its matrix would not fit into memory.
const MAX_ITEMS: usize = 1000;

/// How often each of t stimuli was chosen over each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WinMatrix {
    t: usize,
    wins: Vec<u64>,
}

impl WinMatrix {
    /// No choices yet among `t` stimuli.
    pub fn new(t: usize) -> Self {
        Self { t, wins: vec![0; t * t] }
    }

    /// How often `i` was chosen over `j`.
    pub fn get(&self, i: usize, j: usize) -> u64 {
        self.wins[i * self.t + j]
    }

    /// Adds `count` choices of `i` over `j`.
    pub fn add(&mut self, i: usize, j: usize, count: u64) {
        self.wins[i * self.t + j] += count;
    }

    /// How often the pair of `i` and `j` was judged.
    pub fn trials(&self, i: usize, j: usize) -> u64 {
        self.get(i, j) + self.get(j, i)
    }

    /// How often each stimulus was chosen over another.
    pub fn scores(&self) -> Vec<u64> {
        (0..self.t).map(|i| (0..self.t).map(|j| self.get(i, j)).sum()).collect()
    }

    /// In how many trials each stimulus was.
    pub fn trials_per_item(&self) -> Vec<u64> {
        (0..self.t).map(|i| (0..self.t).map(|j| self.trials(i, j)).sum()).collect()
    }

    /// All pairs (i, j) with i < j.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let t = self.t;
        (0..t).flat_map(move |i| (i + 1..t).map(move |j| (i, j)))
    }

    /// The rows, each stimulus over every other.
    pub fn rows(&self) -> Vec<Vec<u64>> {
        self.wins.chunks(self.t).map(<[u64]>::to_vec).collect()
    }

    /// The same choices with stimulus `order[k]` in place k.
    pub(crate) fn reordered(&self, order: &[usize]) -> Self {
        let wins = order.iter().flat_map(|i| order.iter().map(|j| self.get(*i, *j))).collect();
        Self { t: self.t, wins }
    }
}

/// One answer to one pair, whether or not its set is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Place of who answered among the observers.
    pub observer: usize,
    /// Place of stimulus A among the items.
    pub a: usize,
    /// Place of stimulus B.
    pub b: usize,
    /// What was chosen: A, B, or neither ("not sure").
    pub chosen: Option<Side>,
    /// Which of the two was shown first, where that is known.
    pub first: Option<Side>,
}

/// One person who answered, or one simulated observer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Observer {
    /// The participant's code.
    pub code: String,
    /// What is known of them: the protocol's questions and their answers (`experience`: `naive`), and
    /// what was the same in all their trials (`stereo_mode`, `study`).
    pub traits: BTreeMap<String, String>,
}

/// One complete set of pairs, each judged once by one person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judge {
    /// The participant's code.
    pub subject: String,
    /// The participant's sitting, from 1.
    pub session: u32,
    /// Which of the sitting's sets it is, from 1.
    pub repetition: u32,
    /// The choices: 1 or 0 for each ordered pair.
    pub wins: WinMatrix,
}

/// The choices, as far as the input tells them.
#[derive(Clone, Debug, PartialEq)]
pub enum Judgements {
    /// The choices of each judge with a complete set of pairs; maybe there is none.
    Judges(Vec<Judge>),
    /// The choices of all judges together.
    Pooled {
        /// Judges who chose row over column.
        wins: WinMatrix,
        /// How many judges there were.
        observers: u64,
    },
    /// The total of each stimulus.
    Votes {
        /// How often each was chosen over another.
        votes: Vec<u64>,
        /// How many judges there were.
        observers: u64,
    },
}

/// The input of an analysis: stimuli and the choices among them, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Preferences {
    pub(crate) items: Vec<String>,
    pub(crate) judgements: Judgements,
    /// Every answer to a pair, where the answers are known one by one.
    pub(crate) choices: Vec<Choice>,
    /// Who gave them.
    pub(crate) observers: Vec<Observer>,
    /// Whether the observers were simulated, where that is known.
    pub(crate) simulated: Option<bool>,
    pub(crate) data_quality: Option<DataQuality>,
    /// What the reader of the data has to tell the reader of the results.
    pub(crate) notes: Vec<String>,
}

impl Preferences {
    /// The stimuli, in the order of the input.
    pub fn items(&self) -> &[String] {
        &self.items
    }

    /// The choices.
    pub fn judgements(&self) -> &Judgements {
        &self.judgements
    }

    /// A table of `votes` by so many `observers`; `file` is what an error calls it.
    ///
    /// # Errors
    /// The votes do not add up to one per pair and observer, or no answers can give them.
    pub fn from_votes(votes: &Votes, observers: u64, file: &str) -> Result<Self, InputError> {
        check_observers(observers, file)?;
        check_items(votes.rows.len(), file)?;
        let t = votes.rows.len() as u64;
        let sum: u128 = votes.rows.iter().map(|row| u128::from(row.votes)).sum();
        let expected = observers * (t * (t - 1) / 2);
        if sum != u128::from(expected) {
            return Err(InputError::value(
                file,
                "votes",
                format!("their sum is {sum}"),
                format!(
                    "{t} items judged in pairs by {observers} observers give n·t(t−1)/2 = {expected}"
                ),
            ));
        }
        // Landau's condition: any k items share at least the votes of the pairs among themselves.
        let mut ascending: Vec<u64> = votes.rows.iter().map(|row| row.votes).collect();
        ascending.sort_unstable();
        let mut shared = 0;
        for (k, votes) in (1_u64..).zip(ascending) {
            shared += votes;
            let least = observers * (k * (k - 1) / 2);
            if shared < least {
                return Err(InputError::value(
                    file,
                    "votes",
                    format!("the {k} least chosen items have {shared} together"),
                    format!("the pairs among themselves alone give them {least}"),
                ));
            }
        }
        Ok(Self {
            items: votes.rows.iter().map(|row| row.item.clone()).collect(),
            judgements: Judgements::Votes {
                votes: votes.rows.iter().map(|row| row.votes).collect(),
                observers,
            },
            choices: Vec::new(),
            observers: Vec::new(),
            simulated: None,
            data_quality: None,
            notes: Vec::new(),
        })
    }

    /// A matrix of choices (row over column) by so many `observers`; `file` is what an error calls
    /// it. A pair may have been judged by fewer: the analysis then says what does not follow.
    ///
    /// # Errors
    /// Fewer than two items; a pair was judged more often than there are observers; an item was
    /// never judged.
    pub fn from_matrix(
        items: Vec<String>,
        wins: WinMatrix,
        observers: u64,
        file: &str,
    ) -> Result<Self, InputError> {
        check_observers(observers, file)?;
        check_items(items.len(), file)?;
        for (i, j) in wins.pairs() {
            if wins.get(i, j).saturating_add(wins.get(j, i)) > observers {
                return Err(InputError::value(
                    file,
                    format!("`{}` and `{}`", items[i], items[j]),
                    format!("{} + {} judgements", wins.get(i, j), wins.get(j, i)),
                    format!("at most one by each of {observers} observers is allowed"),
                ));
            }
        }
        if let Some(never) = wins.trials_per_item().iter().position(|trials| *trials == 0) {
            return Err(InputError::value(
                file,
                format!("`{}`", items[never]),
                "never judged",
                "each item needs at least one judgement; leave it out",
            ));
        }
        let short: Vec<String> = wins
            .pairs()
            .filter(|(i, j)| wins.trials(*i, *j) < observers)
            .map(|(i, j)| format!("{}–{} {}", items[i], items[j], wins.trials(i, j)))
            .collect();
        let mut notes = Vec::new();
        if !short.is_empty() {
            notes.push(format!(
                "The matrix is incomplete: {} of {} pairs were judged by fewer than {observers} observers ({}).",
                short.len(),
                wins.pairs().count(),
                short.join(", ")
            ));
        }
        let judgements = Judgements::Pooled { wins, observers };
        let (choices, observers) = (Vec::new(), Vec::new());
        let (simulated, data_quality) = (None, None);
        Ok(Self { items, judgements, choices, observers, simulated, data_quality, notes })
    }

    /// Choices of all judges together, where they are known.
    pub(crate) fn pooled(&self) -> Option<WinMatrix> {
        match &self.judgements {
            Judgements::Judges(judges) => {
                let mut pooled = WinMatrix::new(self.items.len());
                // Without a complete set, all choices together are what there is.
                let every = if judges.is_empty() { &self.choices[..] } else { &[] };
                for choice in every {
                    match choice.chosen {
                        Some(Side::A) => pooled.add(choice.a, choice.b, 1),
                        Some(Side::B) => pooled.add(choice.b, choice.a, 1),
                        None => (),
                    }
                }
                for judge in judges {
                    for (sum, one) in pooled.wins.iter_mut().zip(&judge.wins.wins) {
                        *sum += one;
                    }
                }
                Some(pooled)
            }
            Judgements::Pooled { wins, .. } => Some(wins.clone()),
            Judgements::Votes { .. } => None,
        }
    }

    /// The number of judges.
    pub fn observers(&self) -> u64 {
        match &self.judgements {
            Judgements::Judges(judges) if judges.is_empty() => self.observers.len() as u64,
            Judgements::Judges(judges) => judges.len() as u64,
            Judgements::Pooled { observers, .. } | Judgements::Votes { observers, .. } => {
                *observers
            }
        }
    }
}

/// Refuses a number of items that cannot be compared.
pub(crate) fn check_items(items: usize, file: &str) -> Result<(), InputError> {
    match items {
        2..=MAX_ITEMS => Ok(()),
        _ => {
            let allowed = format!("2 to {MAX_ITEMS} are allowed");
            Err(InputError::value(file, "items", items, allowed))
        }
    }
}

fn check_observers(observers: u64, file: &str) -> Result<(), InputError> {
    match observers {
        1..=MAX_OBSERVERS => Ok(()),
        _ => Err(InputError::value(
            file,
            "observers",
            observers,
            format!("1 to {MAX_OBSERVERS} are allowed"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn votes_error(text: &str, observers: u64) -> String {
        let votes = Votes::parse(text, "v.csv").unwrap();
        Preferences::from_votes(&votes, observers, "v.csv").unwrap_err().to_string()
    }

    #[test]
    fn impossible_votes_are_refused_by_name() {
        for (text, observers, expect) in [
            ("item,votes\nA,2\nB,1\n", 0, "v.csv: observers: 0: 1 to 1000000 are allowed"),
            (
                "item,votes\nA,2\nB,1\nC,1\n",
                2,
                "v.csv: votes: their sum is 4: 3 items judged in pairs by 2 observers give n·t(t−1)/2 = 6",
            ),
            (
                "item,votes\nA,6\nB,0\nC,0\n",
                2,
                "v.csv: votes: the 2 least chosen items have 0 together: the pairs among themselves alone give them 2",
            ),
            (
                "item,votes\nA,18446744073709551615\nB,1\n",
                2,
                "v.csv: votes: their sum is 18446744073709551616: ",
            ),
        ] {
            let error = votes_error(text, observers);
            assert!(error.starts_with(expect), "{text:?} gave {error}");
        }
    }
}
