//! The design: which stimuli are compared, in which order, and which of the two comes first.
//!
//! All of it follows from the protocol and a seed. Every repetition asks each pair once, in an order
//! of its own. Order within the pairs is balanced: the stimuli are put on a circle in random order,
//! and each comes before the ones that follow it on the shorter way round. So with n stimuli each is
//! first in (n − 1)/2 of its pairs (n odd) or in n/2 or n/2 − 1 (n even), the best there is. Every
//! second repetition turns all pairs round.

use crate::random::Stream;
use shutterlab_data_schema::protocol::{Design, Pairs};
use shutterlab_data_schema::response::{Answer, Side};

/// One question of a session. Stimuli are indices into a [`StimulusSet`](crate::stimuli_set::StimulusSet).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Place in the session, from 1, practice included.
    pub number: u32,
    /// Run of trials between two breaks, from 1; 0 for practice.
    pub block: u32,
    /// How often this pair has been asked in the session, from 1.
    pub repetition: u32,
    /// Stimulus A: the one of the two that comes first in the set.
    pub a: usize,
    /// Stimulus B.
    pub b: usize,
    /// Which of the two is shown first.
    pub first: Side,
    /// In practice, the one that anybody would choose; none in a trial that counts.
    pub better: Option<Side>,
}

impl Trial {
    /// Whether this is a practice trial.
    pub fn is_practice(&self) -> bool {
        self.better.is_some()
    }

    /// The side that `answer` means: which of A and B was shown in that interval.
    pub fn side(&self, answer: Answer) -> Side {
        match (self.first, answer) {
            (first, Answer::First) => first,
            (Side::A, Answer::Second) => Side::B,
            (Side::B, Answer::Second) => Side::A,
        }
    }

    /// The stimulus on `side`.
    pub fn stimulus(&self, side: Side) -> usize {
        match side {
            Side::A => self.a,
            Side::B => self.b,
        }
    }
}

/// The trials of a session over the stimuli 0..`stimuli`, practice (pairs of better and worse) first.
pub fn plan(design: &Design, stimuli: usize, practice: &[(usize, usize)], seed: u64) -> Vec<Trial> {
    let mut stream = Stream::new(seed);
    let mut trials = Vec::new();
    for &(better, worse) in practice {
        trials.push(Trial {
            number: 0,
            block: 0,
            repetition: 1,
            a: better.min(worse),
            b: better.max(worse),
            first: if stream.below(2) == 0 { Side::A } else { Side::B },
            better: Some(if better < worse { Side::A } else { Side::B }),
        });
    }
    let Pairs::All = design.pairs;
    let pairs = balanced_pairs(stimuli, &mut stream);
    let mut counting: u32 = 0;
    for repetition in 1..=design.repetitions {
        let mut pass = pairs.clone();
        stream.shuffle(&mut pass);
        for (a, b, first) in pass {
            let first = if repetition % 2 == 1 { first } else { other(first) };
            let block = design.trials_between_breaks.map_or(1, |length| 1 + counting / length);
            trials.push(Trial { number: 0, block, repetition, a, b, first, better: None });
            counting += 1;
        }
    }
    for (number, trial) in (1..).zip(&mut trials) {
        trial.number = number;
    }
    trials
}

/// Every pair a < b of 0..n, and which comes first.
fn balanced_pairs(n: usize, stream: &mut Stream) -> Vec<(usize, usize, Side)> {
    let mut place: Vec<usize> = (0..n).collect();
    stream.shuffle(&mut place);
    let mut pairs = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            let way_from_a_to_b = (place[b] + n - place[a]) % n;
            let a_first = match (2 * way_from_a_to_b).cmp(&n) {
                std::cmp::Ordering::Less => true,
                std::cmp::Ordering::Greater => false,
                // Opposite places, n even: the first half of the circle comes first.
                std::cmp::Ordering::Equal => place[a] < place[b],
            };
            pairs.push((a, b, if a_first { Side::A } else { Side::B }));
        }
    }
    pairs
}

fn other(side: Side) -> Side {
    match side {
        Side::A => Side::B,
        Side::B => Side::A,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn design(repetitions: u32) -> Design {
        Design { pairs: Pairs::All, repetitions, trials_between_breaks: Some(12), gap_s: 0.5 }
    }

    #[test]
    fn every_pair_comes_once_per_repetition() {
        for n in [2, 3, 9, 10] {
            let trials = plan(&design(2), n, &[], 5);
            assert_eq!(trials.len(), n * (n - 1));
            for repetition in [1, 2] {
                let pairs: BTreeSet<(usize, usize)> = trials
                    .iter()
                    .filter(|t| t.repetition == repetition)
                    .map(|t| (t.a, t.b))
                    .collect();
                assert_eq!(pairs.len(), n * (n - 1) / 2);
                assert!(pairs.iter().all(|(a, b)| a < b && *b < n));
            }
        }
    }

    #[test]
    fn each_stimulus_is_first_equally_often() {
        for n in 2..12 {
            let trials = plan(&design(1), n, &[], 77);
            for item in 0..n {
                let first = trials.iter().filter(|t| t.stimulus(t.first) == item).count();
                assert!((n - 1) / 2 <= first && first <= n / 2, "n {n}, item {item}: {first}");
            }
        }
    }

    #[test]
    fn the_second_repetition_turns_every_pair_round() {
        let trials = plan(&design(2), 5, &[], 3);
        for (a, b) in (0..5).flat_map(|a| (a + 1..5).map(move |b| (a, b))) {
            let sides: Vec<Side> =
                trials.iter().filter(|t| (t.a, t.b) == (a, b)).map(|t| t.first).collect();
            assert_ne!(sides[0], sides[1]);
        }
    }

    #[test]
    fn one_seed_gives_one_order_and_another_gives_another() {
        assert_eq!(plan(&design(1), 9, &[(0, 8)], 1), plan(&design(1), 9, &[(0, 8)], 1));
        assert_ne!(plan(&design(1), 9, &[(0, 8)], 1), plan(&design(1), 9, &[(0, 8)], 2));
    }

    #[test]
    fn practice_comes_first_and_blocks_are_counted_without_it() {
        let trials = plan(&design(1), 9, &[(8, 0), (1, 2)], 1);
        assert_eq!(trials[0].better, Some(Side::B));
        assert_eq!((trials[0].a, trials[0].b, trials[0].block), (0, 8, 0));
        let numbers: Vec<u32> = trials.iter().map(|t| t.number).collect();
        assert_eq!(numbers, (1..=38).collect::<Vec<u32>>());
        let blocks: Vec<u32> = trials[2..].iter().map(|t| t.block).collect();
        assert_eq!(blocks, [[1; 12], [2; 12], [3; 12]].concat());
    }

    #[test]
    fn answers_point_at_the_right_stimulus() {
        let mut trial = plan(&design(1), 2, &[], 1).remove(0);
        trial.first = Side::B;
        assert_eq!(trial.side(Answer::First), Side::B);
        assert_eq!(trial.side(Answer::Second), Side::A);
    }
}
