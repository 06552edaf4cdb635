//! Whole cohorts: the same files for any number of threads, and what is there is left.

use super::*;
use crate::test_support::{rendered, small_protocol};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::{Pairs, Task};
use shutterlab_data_schema::response::Answer;
use shutterlab_data_schema::study::data_files;
use std::collections::BTreeMap;
use std::path::Path;

const COHORT: &str = "schema = 1\nseed = 5\n\
    [[observers]]\nname = \"keen\"\ncount = 4\ncode_prefix = \"K\"\nlapse_rate = 0.1\n\
    model = { kind = \"thurstone\", scale_values = \"s.csv\", spread = 0.5, \
    false_alarm_rate = 0.1 }\n\
    [[observers]]\nname = \"coin\"\ncount = 3\ncode_prefix = \"C\"\n\
    model = { kind = \"guess\" }\n";

fn request(stimuli: &Path, study: &Path) -> CohortRequest {
    std::fs::create_dir_all(study).unwrap();
    std::fs::write(study.join("s.csv"), "item,scale_value\nT3,1\nT4,0.5\nT5,0\n").unwrap();
    CohortRequest {
        protocol: small_protocol(),
        stimuli: stimuli.into(),
        study: study.join("study"),
        cohort: Cohort::parse(COHORT, "cohort.toml").unwrap(),
        tables: study.into(),
    }
}

/// The data files of a study and their bytes.
fn data(study: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = data_files(study).unwrap().into_iter();
    files.map(|file| (file.file_name().unwrap().into(), std::fs::read(&file).unwrap())).collect()
}

fn rows(study: &Path) -> Vec<Response> {
    let read = |file| csv::Reader::from_path(file).unwrap().into_deserialize();
    data_files(study).unwrap().into_iter().flat_map(read).map(Result::unwrap).collect()
}

#[test]
fn the_files_are_the_same_for_any_number_of_threads() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let run = |threads: usize| {
        let request = request(stimuli.path(), &folder.path().join(threads.to_string()));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let outcome = pool.install(|| run_cohort(&request)).unwrap();
        assert_eq!(outcome.study, request.study.join("simulated"));
        assert_eq!((outcome.sessions_now, outcome.sessions_before), (7, 0));
        assert_eq!(outcome.answers_now, 7 * 4);
        data(&outcome.study)
    };
    let one = run(1);
    assert_eq!(one.len(), 7);
    assert!(one == run(2) && one == run(5));
}

#[test]
fn a_cohort_goes_on_with_the_sessions_that_are_missing() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let request = request(stimuli.path(), folder.path());
    let outcome = run_cohort(&request).unwrap();
    let whole = data(&outcome.study);
    for file in whole.keys().skip(2).take(3) {
        std::fs::remove_file(outcome.study.join("data").join(file)).unwrap();
    }
    let again = run_cohort(&request).unwrap();
    assert_eq!((again.sessions_now, again.sessions_before, again.answers_now), (3, 4, 3 * 4));
    assert!(data(&outcome.study) == whole);
    let third = run_cohort(&request).unwrap();
    assert_eq!((third.sessions_now, third.sessions_before), (0, 7));
}

#[test]
fn observers_get_their_own_orders_and_every_task_its_answers() {
    let stimuli = rendered();
    for (task, allowed) in [
        (Task::TwoAfc, [Answer::First, Answer::Second]),
        (Task::Matching, [Answer::First, Answer::Second]),
        (Task::SameDifferent, [Answer::Same, Answer::Different]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut request = request(stimuli.path(), folder.path());
        request.protocol.task = task;
        let rows = rows(&run_cohort(&request).unwrap().study);
        assert!(rows.iter().all(|row| allowed.contains(&row.answer)), "{task:?}");
        let names: Vec<&str> = rows.iter().map(|row| row.observer.as_str()).collect();
        assert_eq!(names[0], "simulated:coin");
        assert_eq!(names[12], "simulated:keen");
        let order = |code: &str| -> Vec<String> {
            let own = rows.iter().filter(|row| row.subject.to_string() == code);
            own.map(|row| format!("{} {}", row.stimulus_a, row.stimulus_b)).collect()
        };
        let orders = ["K0001", "K0002", "K0003", "K0004"].map(order);
        assert!(orders.iter().any(|order| *order != orders[0]), "{orders:?}");
    }
}

/// Who takes longer than the question waits is told so, and answers in time when it comes again.
#[test]
fn a_session_ends_even_if_every_answer_is_too_slow() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let mut request = request(stimuli.path(), folder.path());
    request.protocol.timeline.response_window_s = Some(0.1);
    let outcome = run_cohort(&request).unwrap();
    let rows = rows(&outcome.study);
    assert_eq!(rows.len(), 7 * 4);
    assert!(rows.iter().all(|row| row.attempt == 2 && row.response_time_s < 0.1));
}

/// Φ(1) and Φ(1/√3).
const PHI: [f64; 2] = [0.841_345, 0.718_149];

/// A cohort of 400 normal observers with scale values √2 apart and σ = 1, in a study of `task`.
fn many(task: Task) -> Vec<Response> {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let mut request = request(stimuli.path(), folder.path());
    let values = "item,scale_value\nT3,1.414213562\nT4,0\nT5,0\n";
    std::fs::write(folder.path().join("s.csv"), values).unwrap();
    let text = COHORT.replace("count = 4", "count = 400").replace("lapse_rate = 0.1\n", "");
    request.cohort = Cohort::parse(&text.replace("spread = 0.5, ", ""), "cohort.toml").unwrap();
    request.protocol.task = task;
    if task == Task::SameDifferent {
        request.protocol.design.pairs = Pairs::GroundTruth;
        request.protocol.design.ground_truth = [("shutter".to_string(), "T3".to_string())].into();
        request.protocol.design.identical_pairs = 2;
    }
    let mut rows = rows(&run_cohort(&request).unwrap().study);
    rows.retain(|row| row.kind == TrialKind::Simulated && row.observer == "simulated:keen");
    rows
}

fn assert_share(found: usize, of: usize, p: f64) {
    let (share, bound) = (found as f64 / of as f64, 5.0 * (p * (1.0 - p) / of as f64).sqrt());
    assert!(of >= 400 && (share - p).abs() < bound, "{share} of {of}, expected {p} ± {bound}");
}

/// d′ = √2: P(right) = Φ(1)Φ(1/√3) + Φ(−1)Φ(−1/√3); and ½ where there is nothing to see.
#[test]
fn matches_are_found_as_often_as_the_differencing_model_has_it() {
    let rows = many(Task::Matching);
    let [x, y] = PHI;
    let is_sharpest = |id: &str| id.contains("T3");
    for (sees, p) in [(true, x * y + (1.0 - x) * (1.0 - y)), (false, 0.5)] {
        let asked = || {
            rows.iter().filter(|row| {
                (is_sharpest(&row.stimulus_a) || is_sharpest(&row.stimulus_b)) == sees
            })
        };
        let right = asked().filter(|row| row.correct == Some(true)).count();
        assert_share(right, asked().count(), p);
    }
}

/// Identical pairs give the false-alarm rate f of the file; d′ = √2 the hits Φ(1 + z(f/2)) + Φ(z(f/2) − 1).
#[test]
fn hits_and_false_alarms_are_those_of_the_criterion() {
    let rows = many(Task::SameDifferent);
    // z(0.05) = −1.644854: Φ(−0.644854) and Φ(−2.644854).
    for (identical, p) in [(true, 0.1), (false, 0.259_511 + 0.004_086)] {
        let asked = || rows.iter().filter(|row| (row.stimulus_a == row.stimulus_b) == identical);
        let different = asked().filter(|row| row.answer == Answer::Different).count();
        assert_share(different, asked().count(), p);
    }
}

#[test]
fn a_changed_cohort_is_refused_and_a_larger_one_goes_on() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let mut request = request(stimuli.path(), folder.path());
    run_cohort(&request).unwrap();
    let before = data(&request.study.join("simulated"));

    request.cohort.observers[0].lapse_rate = 0.3;
    let error = run_cohort(&request).unwrap_err().to_string();
    assert!(error.contains("cohort.toml: observers keen: changed"), "{error}");
    request.cohort.observers[0].lapse_rate = 0.1;
    request.cohort.seed = 6;
    let error = run_cohort(&request).unwrap_err().to_string();
    assert!(error.contains("cohort.toml: seed: changed"), "{error}");
    assert!(data(&request.study.join("simulated")) == before);

    request.cohort.seed = 5;
    request.cohort.observers[1].count = 5;
    let outcome = run_cohort(&request).unwrap();
    assert_eq!((outcome.sessions_now, outcome.sessions_before), (2, 7));
}
