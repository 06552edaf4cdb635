//! Properties of designs: completeness, balance, and that everything follows from the seed.

use super::*;
use crate::protocols;
use std::collections::{BTreeMap, BTreeSet};

/// The protocol `demo` with another design.
fn protocol(change: impl FnOnce(&mut Protocol)) -> Protocol {
    let mut protocol = protocols::load("demo").unwrap();
    protocol.practice.clear();
    change(&mut protocol);
    protocol
}

/// All combinations of so many levels per axis.
fn pool(levels: &[usize]) -> Pool {
    let mut all = vec![IndexMap::new()];
    for (axis, &count) in levels.iter().enumerate() {
        all = all
            .iter()
            .flat_map(|cell: &IndexMap<String, String>| {
                (0..count).map(move |level| {
                    let mut cell = cell.clone();
                    cell.insert(format!("axis{axis}"), format!("L{level}"));
                    cell
                })
            })
            .collect();
    }
    Pool { levels: all, ..Pool::default() }
}

fn trials(protocol: &Protocol, pool: &Pool, seed: u64) -> Vec<Trial> {
    plan(protocol, pool, seed, 1).unwrap()
}

fn pairs(trials: &[Trial]) -> BTreeMap<(usize, usize), usize> {
    let mut pairs = BTreeMap::new();
    for trial in trials {
        *pairs.entry((trial.a, trial.b)).or_default() += 1;
    }
    pairs
}

/// How often each stimulus is first, and how often second.
fn places(trials: &[Trial], stimuli: usize) -> Vec<(usize, usize)> {
    let count = |item: usize, side: fn(&Trial) -> Side| {
        trials.iter().filter(|t| t.stimulus(side(t)) == item).count()
    };
    (0..stimuli).map(|item| (count(item, |t| t.first), count(item, |t| t.first.other()))).collect()
}

#[test]
fn every_pair_comes_once_per_repetition_whatever_the_sequence() {
    for sequence in [Sequence::Random, Sequence::RoundRobin, Sequence::LatinSquare] {
        for n in [2, 3, 9, 10] {
            let protocol = protocol(|p| {
                p.design.repetitions = 2;
                p.design.sequence = sequence;
            });
            let trials = trials(&protocol, &pool(&[n]), 5);
            assert_eq!(trials.len(), n * (n - 1));
            let pairs = pairs(&trials);
            assert!(pairs.len() == n * (n - 1) / 2 && pairs.values().all(|times| *times == 2));
            assert!(pairs.keys().all(|(a, b)| a < b && *b < n));
            for repetition in [1, 2] {
                let count = trials.iter().filter(|t| t.repetition == repetition).count();
                assert_eq!(count, n * (n - 1) / 2);
            }
        }
    }
}

#[test]
fn each_stimulus_is_first_as_often_as_second() {
    for (levels, one_axis) in
        [(vec![7], false), (vec![8], false), (vec![2, 2, 2, 2], true), (vec![3, 4], true)]
    {
        let protocol = protocol(|p| {
            p.design.pairs = if one_axis { Pairs::OneAxis } else { Pairs::All };
        });
        let pool = pool(&levels);
        for seed in 0..20 {
            let trials = trials(&protocol, &pool, seed);
            for (first, second) in places(&trials, pool.levels.len()) {
                let odd = (first + second) % 2;
                assert_eq!(first.abs_diff(second), odd, "{levels:?}, seed {seed}");
            }
        }
    }
}

/// The thesis's first test: 16 stimuli, 32 pairs that differ in one of four axes (120 in all).
#[test]
fn one_axis_pairs_are_those_that_differ_in_one_axis() {
    let protocol = protocol(|p| p.design.pairs = Pairs::OneAxis);
    let of_two = pool(&[2, 2, 2, 2]);
    let trials = trials(&protocol, &of_two, 1);
    assert_eq!((trials.len(), pairs(&trials).len()), (32, 32));
    for trial in trials {
        let (a, b) = (&of_two.levels[trial.a], &of_two.levels[trial.b]);
        assert_eq!(a.iter().filter(|(axis, level)| b[*axis] != **level).count(), 1);
    }
    let alone = plan(&protocol, &pool(&[1]), 1, 1).unwrap_err().to_string();
    assert!(alone.contains("design.pairs: one-axis"), "{alone}");
}

#[test]
fn both_orders_ask_each_pair_twice_the_second_time_turned_round() {
    let protocol = protocol(|p| p.design.orders = Orders::Both);
    let trials = trials(&protocol, &pool(&[5]), 3);
    assert_eq!(trials.len(), 20);
    for (a, b) in pairs(&trials).into_keys() {
        let of: Vec<&Trial> = trials.iter().filter(|t| (t.a, t.b) == (a, b)).collect();
        assert_eq!([of[0].repetition, of[1].repetition], [1, 2]);
        assert_eq!(of[0].first, of[1].first.other());
    }
}

#[test]
fn a_second_repetition_turns_every_pair_round() {
    let protocol = protocol(|p| p.design.repetitions = 2);
    let trials = trials(&protocol, &pool(&[5]), 3);
    for (a, b) in pairs(&trials).into_keys() {
        let sides: Vec<Side> =
            trials.iter().filter(|t| (t.a, t.b) == (a, b)).map(|t| t.first).collect();
        assert_ne!(sides[0], sides[1]);
    }
}

#[test]
fn no_stimulus_comes_twice_in_a_round() {
    for (levels, one_axis, rounds) in [
        (vec![6], false, 5),
        (vec![7], false, 7),
        (vec![2, 2, 2, 2], true, 4),
        (vec![3, 5], true, 8),
    ] {
        let protocol = protocol(|p| {
            p.design.pairs = if one_axis { Pairs::OneAxis } else { Pairs::All };
            p.design.sequence = Sequence::RoundRobin;
            p.design.trials_between_breaks = Some(1);
        });
        let trials = trials(&protocol, &pool(&levels), 11);
        assert_eq!(trials.last().unwrap().block, rounds, "{levels:?}");
        for block in 1..=rounds {
            let of: Vec<&Trial> = trials.iter().filter(|t| t.block == block).collect();
            let stimuli: BTreeSet<usize> = of.iter().flat_map(|t| [t.a, t.b]).collect();
            assert_eq!(stimuli.len(), 2 * of.len(), "{levels:?}, block {block}");
        }
    }
}

#[test]
fn rounds_break_only_where_the_protocol_says_so() {
    for (length, blocks) in [(None, 1), (Some(8), 3)] {
        let protocol = protocol(|p| {
            p.design.sequence = Sequence::RoundRobin;
            p.design.repetitions = 2;
            p.design.trials_between_breaks = length;
        });
        // Two times five rounds of two pairs: blocks of whole rounds, at least as long as asked for.
        let trials = trials(&protocol, &pool(&[5]), 3);
        assert_eq!(trials.last().unwrap().block, blocks, "{length:?}");
    }
}

/// Williams (1949): each condition once in every row and column, and after each other one equally often.
#[test]
fn latin_squares_are_balanced_for_carry_over() {
    for n in 2..9 {
        let rows = if n % 2 == 0 { n } else { 2 * n };
        let square: Vec<Vec<usize>> = (0..rows).map(|row| williams_row(n, row)).collect();
        let mut followed = BTreeMap::new();
        for place in 0..n {
            let mut column: Vec<usize> = square.iter().map(|row| row[place]).collect();
            column.sort_unstable();
            let expected: Vec<usize> =
                (0..n).flat_map(|c| std::iter::repeat_n(c, rows / n)).collect();
            assert_eq!(column, expected, "n {n}, place {place}");
        }
        for row in &square {
            for two in row.windows(2) {
                *followed.entry((two[0], two[1])).or_insert(0) += 1;
            }
        }
        assert_eq!(followed.len(), n * (n - 1), "n {n}");
        assert!(followed.values().all(|times| *times == rows / n), "n {n}: {followed:?}");
        assert_eq!(williams_row(n, rows), williams_row(n, 0));
    }
}

#[test]
fn a_latin_square_gives_each_participant_a_row() {
    let protocol = protocol(|p| {
        p.design.sequence = Sequence::LatinSquare;
        p.design.trials_between_breaks = Some(1);
    });
    let pool = pool(&[4]);
    // Three rounds: six participants see them in six orders.
    let orders: BTreeSet<Vec<(usize, usize)>> = (1..=6)
        .map(|ordinal| {
            let trials = plan(&protocol, &pool, 1, ordinal).unwrap();
            (1..=3)
                .map(|block| {
                    let of = trials.iter().filter(|t| t.block == block);
                    of.map(|t| (t.a, t.b)).min().unwrap()
                })
                .collect()
        })
        .collect();
    assert_eq!(orders.len(), 6);
}

#[test]
fn matching_asks_about_either_member_and_either_place_equally_often() {
    let protocol = protocol(|p| p.task = Task::Matching);
    let pool = pool(&[5]);
    for seed in 0..20 {
        let trials = trials(&protocol, &pool, seed);
        assert_eq!(trials.len(), 10);
        let left = trials.iter().filter(|t| t.right == Some(Answer::First)).count();
        assert_eq!(left, 5);
        for item in 0..5 {
            let reference =
                trials.iter().filter(|t| t.reference.map(|s| t.stimulus(s)) == Some(item)).count();
            assert_eq!(reference, 2);
        }
        for trial in &trials {
            assert_eq!(trial.selected(trial.right.unwrap()), trial.reference);
            let shows = trial.intervals(Task::Matching);
            assert_eq!(shows[0], Shows::Reference(trial.reference.unwrap()));
            assert_eq!(shows[1..], [Shows::Left(trial.first), Shows::Right(trial.first.other())]);
        }
    }
}

#[test]
fn same_different_compares_everything_with_its_ground_truth() {
    let protocol = protocol(|p| {
        p.task = Task::SameDifferent;
        p.design.pairs = Pairs::GroundTruth;
        p.design.ground_truth = [("axis1".to_string(), "L3".to_string())].into();
        p.design.identical_pairs = 2;
    });
    let pool = pool(&[2, 4]);
    let trials = trials(&protocol, &pool, 4);
    // Two models by three levels below the truth, and each of the two truths twice with itself.
    assert_eq!(trials.len(), 2 * 3 + 2 * 2);
    for trial in &trials {
        let truth = trial.stimulus(trial.reference.unwrap());
        assert_eq!(pool.levels[truth]["axis1"], "L3");
        assert_eq!(pool.levels[trial.a]["axis0"], pool.levels[trial.b]["axis0"]);
        let right = if trial.a == trial.b { Answer::Same } else { Answer::Different };
        assert_eq!(trial.right, Some(right));
    }
    let left = trials.iter().filter(|t| Some(t.first) == t.reference).count();
    assert!((4..=6).contains(&left), "{left}");

    // Asked in both orders, or again: once with the truth on the left and once on the right.
    for change in [(|p: &mut Protocol| p.design.orders = Orders::Both) as fn(&mut Protocol), |p| {
        p.design.repetitions = 2
    }] {
        let mut twice = protocol.clone();
        change(&mut twice);
        let trials = plan(&twice, &pool, 4, 1).unwrap();
        assert_eq!(trials.len(), 20);
        for pair in pairs(&trials).into_keys().filter(|(a, b)| a != b) {
            let of: Vec<&Trial> = trials.iter().filter(|t| (t.a, t.b) == pair).collect();
            assert_eq!(of[0].first, of[1].first.other());
        }
    }

    let mut nowhere = protocol.clone();
    nowhere.design.ground_truth["axis1"] = "L9".into();
    let error = plan(&nowhere, &pool, 1, 1).unwrap_err().to_string();
    assert!(error.contains("design.ground_truth: L0-L9: there is no such stimulus"), "{error}");
}

#[test]
fn catch_trials_are_spread_over_the_session() {
    let protocol = protocol(|p| p.design.trials_between_breaks = Some(12));
    let mut pool = pool(&[9]);
    pool.catch = vec![(0, 8), (8, 1), (2, 7)];
    pool.practice = vec![(8, 0), (1, 2)];
    for seed in 0..50 {
        let trials = trials(&protocol, &pool, seed);
        assert_eq!(trials.len(), 36 + 3 + 2);
        let numbers: Vec<u32> = trials.iter().map(|trial| trial.number).collect();
        assert_eq!(numbers, (1..=41).collect::<Vec<u32>>());
        let at: Vec<usize> = (0..trials.len()).filter(|&i| trials[i].part == Part::Catch).collect();
        assert!(at[0] >= 3 && at[0] <= 16 && at[2] >= 28, "{at:?}");
        assert!(at.windows(2).all(|two| two[1] > two[0]));
        for trial in trials.iter().filter(|t| t.part != Part::Test) {
            let pairs = if trial.part == Part::Catch { &pool.catch } else { &pool.practice };
            let better = trial.stimulus(trial.selected(trial.right.unwrap()).unwrap());
            let worse = trial.a + trial.b - better;
            assert!(pairs.contains(&(better, worse)));
        }
        let blocks: Vec<u32> = trials.iter().map(|trial| trial.block).collect();
        assert_eq!(
            blocks,
            [vec![0; 2], vec![1; 12], vec![2; 12], vec![3; 12], vec![4; 3]].concat()
        );
    }
}

#[test]
fn one_seed_gives_one_order_and_another_gives_another() {
    let (protocol, pool) = (protocol(|_| {}), pool(&[9]));
    assert_eq!(trials(&protocol, &pool, 1), trials(&protocol, &pool, 1));
    assert_ne!(trials(&protocol, &pool, 1), trials(&protocol, &pool, 2));
}

#[test]
fn the_report_says_what_the_design_comes_to() {
    let protocol = protocol(|p| p.design.pairs = Pairs::OneAxis);
    let trials = trials(&protocol, &pool(&[2, 2, 2, 2]), 1);
    let report = DesignReport::new(&protocol, &trials, 4.0);
    assert_eq!((report.stimuli, report.pairs, report.trials), (16, 32, 32));
    assert_eq!(report.first, [2, 2]);
    // Half a second of fixation, two gaps of half a second, two films of four, two to answer.
    assert!((report.seconds - 32.0 * 11.5).abs() < 1e-9);
    assert!(report.to_string().ends_with("first 2 times; about 6 minutes"), "{report}");
}
