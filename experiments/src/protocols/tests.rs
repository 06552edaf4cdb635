//! Every shipped protocol is complete: it makes the design that its source describes, over stimuli that
//! its grid has and its head tells how to render.

use super::*;
use crate::design::{DesignReport, Part, Pool, plan};
use shutterlab_data_schema::protocol::{ObviousPair, Task, Words};
use shutterlab_data_schema::response::{Answer, Side};
use shutterlab_stimuli::{Grid, Selection, Stimulus};

fn names() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, _)| *name)
}

fn text(name: &str) -> &'static str {
    SHIPPED.iter().find(|(shipped, _)| *shipped == name).unwrap().1
}

/// The comment at the head of a protocol, as one line.
fn head(name: &str) -> String {
    let comment = text(name).lines().map_while(|line| line.strip_prefix('#'));
    comment.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// What follows each `word` in a head.
fn after<'a>(head: &'a str, word: &str) -> Vec<&'a str> {
    let words: Vec<&str> = head.split(' ').collect();
    words.windows(2).filter(|two| two[0] == word).map(|two| two[1]).collect()
}

/// The stimuli that the head's command renders.
fn rendered(name: &str) -> Vec<Stimulus> {
    let head = head(name);
    let grid = Grid::load(after(&head, "render")[0]).unwrap();
    let selection = Selection::parse(&after(&head, "--select"), &grid).unwrap();
    grid.stimuli(&selection).unwrap()
}

/// What a session finds among the rendered stimuli: the compared ones in the order of the grid, then
/// those of practice and catch pairs.
fn pool(protocol: &Protocol, stimuli: &[Stimulus]) -> Pool {
    let is_compared = |s: &&Stimulus| {
        let has_one_of = |(axis, levels): (&String, &Vec<String>)| {
            s.levels.get(axis).is_none_or(|level| levels.contains(level))
        };
        protocol.stimuli.iter().all(has_one_of)
    };
    let compared: Vec<&Stimulus> = stimuli.iter().filter(is_compared).collect();
    let mut ids: Vec<&str> = compared.iter().map(|s| s.id.as_str()).collect();
    ids.extend(stimuli.iter().filter(|s| !is_compared(s)).map(|s| s.id.as_str()));
    let index = |id: &String| {
        let there = ids.iter().position(|there| there == id);
        there.unwrap_or_else(|| panic!("{}: {id} is not rendered", protocol.name))
    };
    let indices = |pairs: &[ObviousPair]| {
        pairs.iter().map(|pair| (index(&pair.better), index(&pair.worse))).collect()
    };
    Pool {
        levels: compared.iter().map(|s| s.levels.clone()).collect(),
        practice: indices(&protocol.practice),
        catch: indices(&protocol.catch),
    }
}

fn report(name: &str) -> DesignReport {
    let (protocol, stimuli) = (load(name).unwrap(), rendered(name));
    let trials = plan(&protocol, &pool(&protocol, &stimuli), protocol.seed, 1).unwrap();
    let image = &stimuli[0].image;
    DesignReport::new(&protocol, &trials, f64::from(image.frames) / image.fps)
}

#[test]
fn every_shipped_protocol_loads_under_its_own_name() {
    for name in names() {
        // A study's name has no hyphen.
        assert_eq!(load(name).unwrap().name, name.replace('-', ""));
    }
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/protocols")).unwrap();
    assert_eq!(folder.count(), names().count());
}

/// Navarro (2012): stimuli, pairs and trials of §5.5, §5.6.1 (twice), §5.6.3, §5.7, §6.4, §6.5.1 (twice)
/// and §6.6.
#[test]
fn the_designs_are_those_of_the_thesis() {
    for (name, task, counts) in [
        ("mono1", Task::TwoAfc, [16, 32, 32]),
        ("mono2shutter", Task::Matching, [5, 10, 10]),
        ("mono2samples", Task::Matching, [5, 10, 10]),
        ("mono2preference", Task::TwoAfc, [5, 10, 20]),
        ("mono3", Task::TwoAfc, [9, 36, 36]),
        ("stereo1", Task::TwoAfc, [16, 32, 32]),
        ("stereo2shutter", Task::TwoAfc, [5, 10, 20]),
        ("stereo2samples", Task::TwoAfc, [5, 10, 20]),
        ("stereo3", Task::TwoAfc, [9, 36, 36]),
    ] {
        let report = report(name);
        assert_eq!(load(name).unwrap().task, task, "{name}");
        assert_eq!([report.stimuli, report.pairs, report.trials], counts, "{name}");
        let [least, most] = report.first;
        assert!(task == Task::Matching || least == most, "{name}: {least} to {most} times first");
        let is_stereo = rendered(name)[0].stereo.is_some();
        assert_eq!(is_stereo, name.starts_with("stereo"), "{name}");
    }
}

/// What a protocol names is what is rendered for it. Those about models leave open which, and tell of one.
#[test]
fn a_design_is_known_before_anything_is_rendered() {
    for name in names().filter(|name| name.starts_with("zhang")) {
        let protocol = load(name).unwrap();
        let of_one = Pool::named_by(&protocol).levels.len();
        let rendered = rendered(name);
        let models: std::collections::BTreeSet<&str> =
            rendered.iter().map(|stimulus| stimulus.levels["model"].as_str()).collect();
        assert_eq!(of_one * models.len(), rendered.len(), "{name}");
        assert!(plan(&protocol, &Pool::named_by(&protocol), protocol.seed, 1).is_ok(), "{name}");
    }
    for name in names().filter(|name| !name.starts_with("zhang")) {
        let protocol = load(name).unwrap();
        let trials = plan(&protocol, &Pool::named_by(&protocol), protocol.seed, 1).unwrap();
        let sequence_s = {
            let image = &rendered(name)[0].image;
            f64::from(image.frames) / image.fps
        };
        let (before, after) = (DesignReport::new(&protocol, &trials, sequence_s), report(name));
        assert_eq!(DesignReport { first: after.first, ..before }, after, "{name}");
    }
}

/// Every simplified model is beside its original at its speed, whatever its r, and each original beside itself as often
/// as the head of the protocol says; which answer is right is known.
#[test]
fn simplified_models_are_beside_their_originals() {
    for (name, counts, identical) in [
        ("zhang-r", [1056, 1056, 1280], 8),
        ("zhang-lod", [512, 512, 704], 4),
        ("zhang-validation", [180, 180, 240], 4),
    ] {
        let report = report(name);
        assert_eq!([report.stimuli, report.pairs, report.trials], counts, "{name}");
        let (protocol, stimuli) = (load(name).unwrap(), rendered(name));
        let trials = plan(&protocol, &pool(&protocol, &stimuli), 7, 1).unwrap();
        for trial in &trials {
            let [a, b] = [trial.a, trial.b].map(|k| &stimuli[k]);
            let Some(Side::A | Side::B) = trial.reference else { panic!("{name}: no truth") };
            let truth = if trial.reference == Some(Side::A) { a } else { b };
            assert!(truth.simplification.is_none(), "{}", truth.id);
            for axis in ["model", "speed"] {
                assert_eq!(a.levels[axis], b.levels[axis]);
            }
            let right = if a.id == b.id { Answer::Same } else { Answer::Different };
            assert_eq!(trial.right, Some(right));
        }
        let with_itself = |k: usize| trials.iter().filter(|t| (t.a, t.b) == (k, k)).count();
        let original = stimuli.iter().position(|s| s.simplification.is_none()).unwrap();
        assert_eq!(with_itself(original), identical, "{name}");
    }
}

/// §5.6.3 and §6.5.1 count the two judgements of a participant as two: neither may favour a place.
#[test]
fn repeated_pairs_come_in_both_orders() {
    for name in ["mono2preference", "stereo2shutter", "stereo2samples"] {
        let protocol = load(name).unwrap();
        let trials = plan(&protocol, &pool(&protocol, &rendered(name)), 7, 1).unwrap();
        for one in trials.iter().filter(|t| t.part == Part::Test && t.repetition == 1) {
            let same = |t: &&crate::design::Trial| {
                t.part == Part::Test && t.repetition == 2 && (t.a, t.b) == (one.a, one.b)
            };
            assert_eq!(trials.iter().find(same).unwrap().first, one.first.other(), "{name}");
        }
    }
}

#[test]
fn heads_say_what_the_design_comes_to() {
    for name in names() {
        let DesignReport { stimuli, pairs, trials, practice, catch, seconds, .. } = report(name);
        let minutes = (seconds / 60.0).round();
        let said = format!(
            "Design: {stimuli} stimuli, {pairs} pairs; {trials} trials, {practice} of practice, \
             {catch} to catch; about {minutes} minutes."
        );
        assert!(head(name).contains(&said), "{name}: {said}");
    }
}

#[test]
fn the_guide_tells_every_word_and_every_shipped_protocol() {
    let guide = include_str!("../../../docs/guide/protocols.md");
    let words = serde_json::to_value(Words::default()).unwrap();
    for (key, word) in words.as_object().unwrap() {
        let row = format!("| `{key}` | {} |", word.as_str().unwrap());
        assert!(guide.contains(&row), "{row}");
    }
    for name in names() {
        let DesignReport { stimuli, trials, practice, catch, seconds, .. } = report(name);
        let row = guide.lines().find(|line| line.starts_with(&format!("| `{name}` |"))).unwrap();
        let minutes = (seconds / 60.0).round();
        let end = format!("| {trials} + {practice} + {catch} | {minutes} |");
        assert!(row.contains(&format!("| {stimuli}: ")) && row.ends_with(&end), "{row}");
    }
}

/// Nobody practises on what counts, and what catches does not count either. Which models there are to practise on the
/// protocols about models leave open.
#[test]
fn practice_and_catch_pairs_are_not_asked_as_trials() {
    for name in
        names().filter(|name| !["demo", "quick"].contains(name) && !name.starts_with("zhang"))
    {
        let protocol = load(name).unwrap();
        let pool = pool(&protocol, &rendered(name));
        assert!(!pool.practice.is_empty() && !pool.catch.is_empty(), "{name}");
        for (a, b) in pool.practice {
            assert!(a.min(b) >= pool.levels.len(), "{name}");
        }
        for (a, b) in pool.catch {
            assert!(a.max(b) >= pool.levels.len(), "{name}");
        }
    }
}

/// As many identical pairs as different ones: who always says the same is right half of the time.
#[test]
fn the_same_and_the_different_are_asked_equally_often() {
    let protocol = load("samedifferent").unwrap();
    let trials = plan(&protocol, &pool(&protocol, &rendered("samedifferent")), 3, 1).unwrap();
    let tests = || trials.iter().filter(|t| t.part == Part::Test);
    assert_eq!(tests().filter(|t| t.a == t.b).count() * 2, tests().count());
}

#[test]
fn an_unknown_name_lists_the_shipped_ones() {
    let error = load("dmo").unwrap_err().to_string();
    assert!(error.contains("dmo: neither a file nor one of the shipped protocols: mono1, "));
}

#[test]
fn a_protocol_file_is_found_by_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, text("demo")).unwrap();
    assert_eq!(load(path.to_str().unwrap()).unwrap(), load("demo").unwrap());
}
