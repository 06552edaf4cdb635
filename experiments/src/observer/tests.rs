//! Formulas against simulations of what they stand for, answers against formulas.

use super::*;
use crate::design::{Part, Trial, plan};
use crate::random::Stream;
use crate::test_support::{protocol, rendered};
use shutterlab_data_schema::Cohort;
use shutterlab_data_schema::response::{Answer, Side};
use statrs::distribution::{ContinuousCDF, Normal};
use std::fs;
use tempfile::TempDir;

/// 30 observers, 36 pairs: 1080 votes.
fn votes() -> Votes {
    let text = "item,votes\nA5T3,190\nA4T3,170\nA3T3,150\nT4A5,140\nA4T4,120\nA3T4,110\n\
                A5T5,90\nA4T5,70\nA3T5,40\n";
    Votes::parse(text, "test").unwrap()
}

fn set() -> StimulusSet {
    StimulusSet::open(&protocol(), rendered().path()).unwrap()
}

fn protocol_of(task: Task) -> Protocol {
    Protocol { task, ..protocol() }
}

/// A sort of observers with `keys`, among them the model.
fn sort(keys: &str) -> Observers {
    let head = "schema = 1\nseed = 1\n[[observers]]\nname = \"test\"\ncount = 1\n";
    let text = format!("{head}code_prefix = \"S\"\n{keys}\n");
    Cohort::parse(&text, "test").unwrap().observers.remove(0)
}

/// A folder with the file `name`.
fn folder_with(name: &str, text: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    folder
}

/// Stimuli 0 and 1 with the scale values 1.2 and 0; the others, which no trial here is about, with 5.
fn scale_values() -> TempDir {
    let set = set();
    let value = |index| if index == 0 { 1.2 } else { f64::from(u8::from(index > 1)) * 5.0 };
    let row = |index| format!("{},{}\n", set.stimulus(index).id, value(index));
    let rows: String = (0..set.compared).map(row).collect();
    folder_with("s.csv", &format!("item,scale_value\n{rows}"))
}

const THURSTONE: &str =
    "model = { kind = \"thurstone\", scale_values = \"s.csv\", sd = 1.5, false_alarm_rate = 0.2 }";

fn instructed(keys: &str, folder: &Path, protocol: &Protocol) -> Instructed {
    let observer = SimulatedObserver::from_cohort(&sort(keys), folder).unwrap();
    observer.instruct(&set(), protocol).unwrap()
}

fn thurstone(keys: &str, protocol: &Protocol) -> Instructed {
    instructed(&format!("{keys}\n{THURSTONE}"), scale_values().path(), protocol)
}

/// Trial `number` about the stimuli 0 and 1, the first or reference on the left.
fn trial(number: u32) -> Trial {
    Trial {
        number,
        block: 1,
        repetition: 1,
        part: Part::Test,
        a: 0,
        b: 1,
        first: Side::A,
        reference: Some(Side::A),
        right: None,
    }
}

fn judge(sort: &Instructed, number: u32, trials: u32) -> Judge {
    sort.judge(3, &format!("S{number}").parse().unwrap(), 1, trials)
}

/// How often each answer is given by `observers` of a sort in `trial`, of `trials`.
fn shares(
    sort: &Instructed,
    observers: u32,
    trial: &Trial,
    trials: u32,
) -> impl Fn(Answer) -> f64 + use<> {
    let answer = |number| judge(sort, number, trials).answer(trial).0;
    let answers: Vec<Answer> = (0..observers).map(answer).collect();
    move |wanted| {
        answers.iter().filter(|answer| **answer == wanted).count() as f64 / answers.len() as f64
    }
}

/// Within five standard deviations of a share of `n` draws with the probability `p`.
fn assert_share(found: f64, p: f64, n: u32) {
    let bound = 5.0 * (p * (1.0 - p) / f64::from(n)).sqrt() + 1e-12;
    assert!((found - p).abs() <= bound, "{found} of {n}, expected {p} ± {bound}");
}

fn phi(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

#[test]
fn items_are_matched_to_stimuli_by_their_levels_or_their_id() {
    let observer = SimulatedObserver::from_votes("test", &votes(), 30).unwrap();
    let set = set();
    let Basis::Items { values, .. } = &observer.basis else { panic!("no items") };
    let values = observer.values(values, &set).unwrap();
    let best = (0..9).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
    assert_eq!(set.stimulus(best).id, "M2-S2-T3-A5");
    assert!(is_about("M2-S2-T3-A5", &set.stimulus(best).id, &set.stimulus(best).levels));
    assert!(!is_about("M2-S2-T3-A4", &set.stimulus(best).id, &set.stimulus(best).levels));
}

#[test]
fn a_stimulus_without_its_item_is_named() {
    let two = Votes::parse("item,votes\nA3T3,2\nA3,1\n", "test").unwrap();
    let observer = SimulatedObserver::from_votes("two", &two, 3).unwrap();
    let error = observer.instruct(&set(), &protocol()).unwrap_err().to_string();
    assert!(error.starts_with("simulated:two: stimulus M2-S2-T3-A3: 2 of the items"), "{error}");
}

#[test]
fn votes_without_a_model_name_the_observer() {
    let none = Votes::parse("item,votes\nA3,3\nA4,0\n", "test").unwrap();
    let error = SimulatedObserver::from_votes("none", &none, 3).unwrap_err().to_string();
    assert!(error.starts_with("simulated:none: votes: A4: "), "{error}");
}

/// 1200 simulated observers give votes in the proportions of the 30 they are modelled on.
#[test]
fn simulated_votes_agree_with_the_table() {
    const COHORT: u32 = 1200;
    let (votes, set, protocol) = (votes(), set(), protocol());
    let observer = SimulatedObserver::from_votes("test", &votes, 30).unwrap();
    let instructed = observer.instruct(&set, &protocol).unwrap();
    let mut counts = [0_u32; 9];
    for number in 0..COHORT {
        let judge = judge(&instructed, number, 37);
        let trials = plan(&protocol, &set.pool(), u64::from(number), 1).unwrap();
        for trial in trials.iter().filter(|trial| trial.part == Part::Test) {
            let (answer, seconds) = judge.answer(trial);
            assert!(seconds > 0.0);
            counts[trial.stimulus(trial.selected(answer).unwrap())] += 1;
        }
    }
    for (index, count) in counts.into_iter().enumerate() {
        let row = votes
            .rows
            .iter()
            .find(|row| is_about(&row.item, &set.stimulus(index).id, &set.stimulus(index).levels));
        let expected = row.unwrap().votes as f64 * f64::from(COHORT) / 30.0;
        // At most 8 · ¼ · COHORT is the variance; five standard deviations.
        let bound = 5.0 * (2.0 * f64::from(COHORT)).sqrt();
        assert!((f64::from(count) - expected).abs() < bound, "{index}: {count} {expected}");
    }
}

/// Worths and the votes that are expected of them make the same observer.
#[test]
fn preferences_follow_worths_and_scale_values() {
    let set = set();
    let rows = |number: fn(usize) -> f64| -> String {
        let row = |index| format!("{},{}\n", set.stimulus(index).id, number(index));
        (0..set.compared).map(row).collect()
    };
    let folder = folder_with("w.csv", &format!("item,worth\n{}", rows(|i| (i + 1) as f64)));
    let worths = "model = { kind = \"bradley-terry\", worths = \"w.csv\" }";
    let bradley_terry = instructed(worths, folder.path(), &protocol());
    let [first, second] = judge(&bradley_terry, 1, 1).probabilities(&trial(1));
    assert!((first - 1.0 / 3.0).abs() < 1e-12 && (second - 2.0 / 3.0).abs() < 1e-12);

    let thurstone = thurstone("", &protocol());
    let p = phi(1.2 / (1.5 * 2_f64.sqrt()));
    for (first, expected) in [(Side::A, p), (Side::B, 1.0 - p)] {
        let trial = Trial { first, ..trial(1) };
        assert!((judge(&thurstone, 1, 1).probabilities(&trial)[0] - expected).abs() < 1e-9);
        assert_share(shares(&thurstone, 4000, &trial, 1)(Answer::First), expected, 4000);
    }
}

/// The differencing model, played: normal sensations of the dispersion σ, the nearer one is the match,
/// and what is further apart than the criterion is different.
#[test]
fn matching_and_same_different_are_the_differencing_model() {
    const DRAWS: u32 = 200_000;
    let (matching, pairs) = (protocol_of(Task::Matching), protocol_of(Task::SameDifferent));
    let (finder, teller) = (thurstone("", &matching), thurstone("", &pairs));
    let right = Trial { right: Some(Answer::Second), ..trial(1) };
    let found = 1.0 - judge(&finder, 1, 1).probabilities(&right)[0];
    let different = |b| judge(&teller, 1, 1).probabilities(&Trial { b, ..trial(1) })[1];
    assert!((different(0) - 0.2).abs() < 1e-9, "the false-alarm rate is that of the file");

    let mut stream = Stream::new(5);
    let mut sense = |value: f64| value + 1.5 * stream.normal();
    let criterion = -1.5 * 2_f64.sqrt() * Normal::standard().inverse_cdf(0.1);
    let (mut matched, mut told) = (0, 0);
    for _ in 0..DRAWS {
        let (reference, same, other) = (sense(1.2), sense(1.2), sense(0.0));
        matched += u32::from((same - reference).abs() < (other - reference).abs());
        told += u32::from((reference - other).abs() > criterion);
    }
    let share = |count: u32| f64::from(count) / f64::from(DRAWS);
    assert_share(share(matched), found, DRAWS);
    assert_share(share(told), different(1), DRAWS);

    let answers = shares(&teller, 4000, &trial(1), 1);
    assert_share(answers(Answer::Different), different(1), 4000);
    assert_eq!(answers(Answer::Same) + answers(Answer::Different), 1.0);
    assert_share(shares(&finder, 4000, &right, 1)(Answer::Second), found, 4000);
}

/// d′ of Bradley–Terry worths is that of the normal observer with the same preferences.
#[test]
fn worths_discriminate_as_the_scale_values_of_equal_preference_do() {
    let trial = Trial { right: Some(Answer::First), ..trial(1) };
    let first = |perception: &Perception, task| perception.first_answer(task, &trial);
    for u in [0.0_f64, 0.3, 2.0, 30.0] {
        let scale = 2_f64.sqrt() * Normal::standard().inverse_cdf(1.0 / (1.0 + (-u).exp()));
        let worths = Perception::values(vec![u, 0.0], Noise::Logistic, Some(0.1));
        let noise = Noise::Normal { sd: 1.0 };
        let values = Perception::values(vec![scale, 0.0], noise, Some(0.1));
        for task in [Task::TwoAfc, Task::Matching, Task::SameDifferent] {
            let (p, q) = (first(&worths, task), first(&values, task));
            assert!((p - q).abs() < 1e-6, "{u} {task:?}: {p} {q}");
        }
    }
}

#[test]
fn lapses_grow_with_fatigue_and_come_up_half_each() {
    let tired = thurstone("lapse_rate = 0.1\nfatigue = 0.4", &protocol());
    let p = phi(1.2 / (1.5 * 2_f64.sqrt()));
    for (number, lapse) in [(1, 0.1), (6, 0.3), (11, 0.5)] {
        let expected = lapse / 2.0 + (1.0 - lapse) * p;
        assert_share(shares(&tired, 8000, &trial(number), 11)(Answer::First), expected, 8000);
    }
    // A catch trial is answered wrongly by half the lapses, one of practice never.
    let catch = Trial { part: Part::Catch, right: Some(Answer::Second), ..trial(11) };
    assert_share(shares(&tired, 8000, &catch, 11)(Answer::First), 0.25, 8000);
    let practice = Trial { part: Part::Practice, ..catch };
    assert_eq!(shares(&tired, 100, &practice, 11)(Answer::Second), 1.0);
}

#[test]
fn a_bias_is_the_share_of_answers_that_nothing_shown_changes() {
    let p = phi(1.2 / (1.5 * 2_f64.sqrt()));
    for (bias, expected) in [(0.4, 0.4 + 0.6 * p), (-0.4, 0.6 * p), (1.0, 1.0), (-1.0, 0.0)] {
        let biased = thurstone(&format!("side_bias = {bias:?}"), &protocol());
        assert_share(shares(&biased, 8000, &trial(1), 1)(Answer::First), expected, 8000);
    }
    // Side by side, both sides are asked about at once.
    let pairs = protocol_of(Task::SameDifferent);
    let [biased, fair] = ["side_bias = 1.0", ""]
        .map(|keys| judge(&thurstone(keys, &pairs), 1, 1).probabilities(&trial(1)));
    assert_eq!(biased, fair);
}

/// Rao and Kupper (1967): P(i) = πᵢ / (πᵢ + θ πⱼ).
#[test]
fn who_is_not_sure_says_so_only_where_that_is_offered() {
    let mut offered = protocol();
    offered.not_sure = Some("cannot tell".into());
    let keys = "not_sure_band = 0.5";
    let set = set();
    let row = |index| format!("{},{}\n", set.stimulus(index).id, index + 1);
    let rows: String = (0..set.compared).map(row).collect();
    let folder = folder_with("w.csv", &format!("item,worth\n{rows}"));
    let worths = format!("{keys}\nmodel = {{ kind = \"bradley-terry\", worths = \"w.csv\" }}");
    let unsure = instructed(&worths, folder.path(), &offered);
    let theta = 0.5_f64.exp();
    let (first, second) = (1.0 / (1.0 + theta * 2.0), 2.0 / (2.0 + theta));
    let found = shares(&unsure, 8000, &trial(1), 1);
    assert_share(found(Answer::First), first, 8000);
    assert_share(found(Answer::Second), second, 8000);
    assert_share(found(Answer::NotSure), 1.0 - first - second, 8000);

    let forced = instructed(&worths, folder.path(), &protocol());
    assert_eq!(shares(&forced, 500, &trial(1), 1)(Answer::NotSure), 0.0);
}

/// A `screen.csv` about the stimuli: `jod(a, b)` of every two.
fn screened(jod: impl Fn(usize, usize) -> f64) -> TempDir {
    let set = set();
    let mut text =
        String::from("reference,test,reference_sha256,test_sha256,cvvdp_jod,flip_mean,psnr_db\n");
    let hash = |index: usize| set.sequences[index].manifest.sha256.as_str();
    for (a, b) in (0..9).flat_map(|a| (a + 1..9).map(move |b| (a, b))) {
        // In either order, as the names of folders have it.
        let (a, b) = if a % 2 == 0 { (a, b) } else { (b, a) };
        let value = jod(a.min(b), a.max(b));
        text += &format!("x,y,{},{},{value},0.5,20\n", hash(a), hash(b));
    }
    folder_with("screen.csv", &text)
}

fn psychometric(shape: &str, measure: &str) -> String {
    format!(
        "model = {{ kind = \"psychometric\", differences = \"screen.csv\", measure = \"{measure}\", \
         shape = \"{shape}\", threshold = 0.75, slope = 2.0, best = \"M2-S2-T3-A5\", \
         false_alarm_rate = 0.1 }}"
    )
}

/// At the threshold the function is where it is defined to be; identical stimuli give false alarms.
#[test]
fn the_psychometric_function_is_at_its_threshold_where_it_says() {
    let folder = screened(|_, _| 9.25);
    for (shape, at_threshold, at_zero) in [
        ("logistic", 0.5, 1.0 / (1.0 + 1.5_f64.exp())),
        ("probit", 0.5, phi(-1.5)),
        ("weibull", 1.0 - (-1.0_f64).exp(), 0.0),
    ] {
        let keys = psychometric(shape, "cvvdp_jod");
        let teller = instructed(&keys, folder.path(), &protocol_of(Task::SameDifferent));
        for (b, seen) in [(1, at_threshold), (0, at_zero)] {
            let trial = Trial { b, ..trial(1) };
            let found = shares(&teller, 4000, &trial, 1)(Answer::Different);
            assert_share(found, 0.1 + 0.9 * seen, 4000);
        }
        let finder = instructed(&keys, folder.path(), &protocol_of(Task::Matching));
        let right = Trial { right: Some(Answer::Second), ..trial(1) };
        let found = shares(&finder, 4000, &right, 1)(Answer::Second);
        assert_share(found, 0.5 + 0.5 * at_threshold, 4000);
    }
}

/// Of two, the one that differs less from the best is preferred, the more the two differ.
#[test]
fn preferences_by_difference_are_for_what_is_nearer_to_the_best() {
    let set = set();
    let best = (0..9).find(|&index| set.stimulus(index).id == "M2-S2-T3-A5").unwrap();
    let other = (0..9).find(|&index| index != best && index > 1).unwrap();
    // 0 is one unit from the best, all others are two; of one another, three quarters.
    let folder = screened(move |a, b| match (a == best || b == best, a == 0) {
        (true, true) => 9.0,
        (true, false) => 8.0,
        (false, _) => 9.25,
    });
    let chooser = instructed(&psychometric("logistic", "cvvdp_jod"), folder.path(), &protocol());
    let p = |a, b| judge(&chooser, 1, 1).probabilities(&Trial { a, b, ..trial(1) })[0];
    assert!((p(0, 1) - 0.75).abs() < 1e-12);
    assert!((p(1, 0) - 0.25).abs() < 1e-12);
    assert_eq!(p(1, other), 0.5);
    let f = 1.0 / (1.0 + (-2.0 * (2.0 - 0.75_f64)).exp());
    assert!((p(best, 1) - (0.5 + 0.5 * f)).abs() < 1e-12);
}

/// PSNR of 20 dB is a root mean square difference of a tenth; FLIP is taken as it is.
#[test]
fn measures_become_differences() {
    let folder = screened(|_, _| 9.25);
    for (measure, x) in [("cvvdp_jod", 0.75), ("flip_mean", 0.5), ("psnr_db", 0.1)] {
        let keys = psychometric("weibull", measure);
        let finder = instructed(&keys, folder.path(), &protocol_of(Task::Matching));
        let seen = 1.0 - (-(x / 0.75_f64).powi(2)).exp();
        let found = judge(&finder, 1, 1).probabilities(&trial(1))[0];
        assert!((found - (0.5 + 0.5 * seen)).abs() < 1e-12, "{measure}: {found}");
    }
}

/// Two values, each with a deviation of its own, differ with twice the variance.
#[test]
fn observers_differ_by_the_spread() {
    let folder = scale_values();
    let keys = "model = { kind = \"thurstone\", scale_values = \"s.csv\", spread = 0.5 }";
    let sort = instructed(keys, folder.path(), &protocol());
    let z = |number| {
        let [first, _] = judge(&sort, number, 1).probabilities(&trial(1));
        Normal::standard().inverse_cdf(first) * 2_f64.sqrt()
    };
    let differences: Vec<f64> = (0..4000).map(z).collect();
    let mean = differences.iter().sum::<f64>() / 4000.0;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 3999.0;
    // Five standard errors of the mean and of the variance.
    assert!((mean - 1.2).abs() < 5.0 * (0.5_f64 / 4000.0).sqrt(), "{mean}");
    assert!((variance - 0.5).abs() < 5.0 * 0.5 * (2.0_f64 / 4000.0).sqrt(), "{variance}");
    // One person is the same in every session.
    let p = |session| {
        let judge = sort.judge(3, &"S1".parse().unwrap(), session, 1);
        (judge.probabilities(&trial(1)), judge.answer(&trial(1)).1)
    };
    assert_eq!(p(1).0, p(2).0);
    assert_ne!(p(1).1, p(2).1);
}

#[test]
fn response_times_are_log_normal() {
    let keys = "response_s = { median = 2.0, log_sd = 0.5 }\nmodel = { kind = \"guess\" }";
    let sort = instructed(keys, Path::new("."), &protocol());
    let logs: Vec<f64> =
        (0..4000).map(|number| judge(&sort, number, 1).answer(&trial(1)).1.ln()).collect();
    let mean = logs.iter().sum::<f64>() / 4000.0;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / 3999.0;
    assert!((mean - 2_f64.ln()).abs() < 5.0 * 0.5 / 4000_f64.sqrt(), "{mean}");
    assert!((variance - 0.25).abs() < 5.0 * 0.25 * (2.0_f64 / 4000.0).sqrt(), "{variance}");
}

#[test]
fn who_guesses_guesses_everywhere_and_every_answer_comes_again() {
    let (set, protocol) = (set(), protocol());
    let guess = SimulatedObserver::guess().instruct(&set, &protocol).unwrap();
    let practice = Trial { part: Part::Practice, right: Some(Answer::First), ..trial(1) };
    assert_share(shares(&guess, 4000, &practice, 1)(Answer::First), 0.5, 4000);
    let trials = plan(&protocol, &set.pool(), 4, 1).unwrap();
    let (judge, again) = (judge(&guess, 1, 37), judge(&guess, 1, 37));
    assert!(trials.iter().rev().all(|trial| judge.answer(trial) == again.answer(trial)));
}

#[test]
fn what_an_observer_lacks_is_named_with_its_file() {
    let error = |keys: &str, folder: &Path, task| {
        let sort = sort(keys);
        let observer = SimulatedObserver::from_cohort(&sort, folder);
        let protocol = protocol_of(task);
        observer.and_then(|o| o.instruct(&set(), &protocol)).unwrap_err().to_string()
    };
    let empty = tempfile::tempdir().unwrap();
    let worths = "model = { kind = \"bradley-terry\", worths = \"w.csv\" }";
    let scale = "model = { kind = \"thurstone\", scale_values = \"s.csv\" }";
    let screen = psychometric("probit", "cvvdp_jod");
    for (keys, file) in [(worths, "w.csv"), (scale, "s.csv"), (&screen, "screen.csv")] {
        let error = error(keys, empty.path(), Task::TwoAfc);
        assert!(error.starts_with("simulated:test: ") && error.contains(file), "{error}");
    }
    let zero = folder_with("w.csv", "item,worth\nA3,1\nA4,0\n");
    let refused = error(worths, zero.path(), Task::TwoAfc);
    assert!(refused.ends_with("w.csv: line 3: worth of `A4`: `0`: a number above 0 is needed"));

    let refused = error(scale, scale_values().path(), Task::SameDifferent);
    let lacks = "simulated:test: model.false_alarm_rate: none: the task same-different needs it";
    assert_eq!(refused, lacks);

    let folder = screened(|_, _| 9.25);
    let no_best = screen.replace("best = \"M2-S2-T3-A5\", ", "");
    let refused = error(&no_best, folder.path(), Task::TwoAfc);
    assert_eq!(refused, "simulated:test: model.best: none: the task 2afc needs it");
    let refused = error(&screen.replace("T3-A5", "T9-A5"), folder.path(), Task::TwoAfc);
    assert!(refused.starts_with("simulated:test: model.best: M2-S2-T9-A5: none of the compared"));

    let file = folder.path().join("screen.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace(",9.25,", ",10.25,")).unwrap();
    let refused = error(&screen, folder.path(), Task::TwoAfc);
    assert!(refused.contains("screen.csv: line 2: cvvdp_jod: 10.25: a number up to 10"));
    fs::write(&file, text.lines().next().unwrap()).unwrap();
    let refused = error(&screen, folder.path(), Task::TwoAfc);
    assert!(refused.contains("M2-S2-T3-A3, M2-S2-T3-A4: there is no row"), "{refused}");
    fs::write(&file, "reference,test\n").unwrap();
    let refused = error(&screen, folder.path(), Task::TwoAfc);
    assert!(refused.contains("column `reference_sha256` is missing"), "{refused}");
}
