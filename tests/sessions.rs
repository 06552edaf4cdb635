//! Sessions that are killed and go on, at one station or several, and what is left when something fails.

use crate::support::{
    Row, answers_of, copy_stimuli, fail, guess, read_table, run_in, shutterlab, succeed, table,
    tree, whole_lines,
};
use serde_json::{Value, json};
use shutterlab_data_schema::study::StudyKind;
use shutterlab_experiments::protocols;
use shutterlab_experiments::random::Stream;
use shutterlab_experiments::record::heartbeat::station_name;
use shutterlab_experiments::record::study::Study;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Trials of a session of the shipped protocol: 2 of practice, 36 pairs of 9 stimuli.
const TRIALS: usize = 38;

/// A study in a folder of its own.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// Where the answers of simulated observers lie.
    fn study(&self) -> PathBuf {
        StudyKind::Simulated.folder(&self.folder.path().join("study"))
    }

    /// The study as this process sees it, posing as the computer called `station`.
    fn open(&self, station: &str) -> Study {
        let (folder, protocol) =
            (self.folder.path().join("study"), protocols::load("demo").unwrap());
        Study::open(&folder, &protocol, StudyKind::Simulated).unwrap().at_station(station)
    }

    /// What `status` says about the simulated sessions, each under its code.
    fn status(&self) -> BTreeMap<String, Value> {
        let sections: Value =
            serde_json::from_str(&self.succeed(&["status", "study", "--json"])).unwrap();
        let section = &sections.as_array().unwrap()[0];
        assert_eq!((&section["kind"], &section["faults"]), (&"simulated".into(), &json!([])));
        let sessions = section["sessions"].as_array().unwrap().iter();
        sessions.map(|s| (s["subject"].as_str().unwrap().to_string(), s.clone())).collect()
    }

    fn succeed(&self, args: &[&str]) -> String {
        succeed(self.folder.path(), args)
    }

    /// The session of `code`, left alone; returns what it printed.
    fn run(&self, code: &str) -> String {
        self.succeed(&guess("study", code))
    }

    /// Starts the session of `code` and kills it after `delay`, unless it is over by then.
    fn run_and_kill(&self, code: &str, delay: Duration) -> Output {
        let mut command = shutterlab();
        command.current_dir(self.folder.path()).args(guess("study", code));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(delay);
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        // What is killed says at most what it will ask; what ends by itself must not have failed.
        let stderr = String::from_utf8_lossy(&output.stderr);
        let is_plan = |line: &str| line.starts_with("demo: 9 stimuli, 36 pairs");
        assert!(stderr.lines().all(is_plan), "{code} after {delay:?}: {stderr}");
        output
    }

    /// The file with the answers of `code` as it is; empty if it is not there.
    fn answers(&self, code: &str) -> Vec<u8> {
        std::fs::read(answers_of(&self.study(), code)).unwrap_or_default()
    }

    /// The events in the log of `code` and their details.
    fn log(&self, code: &str) -> Vec<(String, String)> {
        let name = format!("log/study-demo_subject-{code}_session-1_task-2afc.log");
        let text = std::fs::read_to_string(self.study().join(name)).unwrap_or_default();
        text.lines()
            .map(|line| match line.split('\t').collect::<Vec<_>>()[..] {
                [_, event, detail] => (event.to_string(), detail.to_string()),
                _ => panic!("{line:?}"),
            })
            .collect()
    }

    fn analysis(&self) -> Value {
        serde_json::from_str(&self.succeed(&["analyze", "study/simulated", "--json"])).unwrap()
    }
}

/// The rows without what differs between a session left alone and one that was resumed: calendar
/// time, places in the session's own time, which begins anew, and the attempt.
fn timeless(file: &Path) -> Vec<Row> {
    let mut rows = read_table(file);
    for row in &mut rows {
        for column in ["answered_at", "onset_a_s", "onset_b_s", "attempt"] {
            row.remove(column).unwrap();
        }
        // A difference of two times on a clock that ticks in sixtieths of a second.
        let time = row.get_mut("response_time_s").unwrap();
        *time = format!("{:.3}", time.parse::<f64>().unwrap());
    }
    rows
}

fn assert_whole(file: &Path) {
    let trials: Vec<String> = read_table(file).iter().map(|row| row["trial"].clone()).collect();
    let each_once: Vec<String> = (1..=TRIALS).map(|number| number.to_string()).collect();
    assert_eq!(trials, each_once, "{}", file.display());
}

/// `kill -9` at fifty random moments (`SHUTTERLAB_KILLS` says how many) of sessions under way: no answer is
/// missing, doubled or another one than without the kills, and `status` tells each.
#[test]
fn kills_lose_no_answer_and_double_none() {
    let kills: usize = std::env::var("SHUTTERLAB_KILLS").map_or(50, |text| text.parse().unwrap());
    // Kills that came after answers of the process itself, not while it was still starting.
    let least_gains = kills / 5;
    let (alone, killed) = (Place::new(), Place::new());
    let mut random = Stream::new(20121);
    let (mut hits, mut gains, mut participants) = (0, 0, 0);
    while hits < kills || gains < least_gains {
        participants += 1;
        assert!(participants <= 2 * kills, "{hits} kills hit a session, {gains} after answers");
        let code = format!("K{participants}");
        let start = Instant::now();
        alone.run(&code);
        let duration = start.elapsed();

        let mut seen = vec![];
        for attempt in 1.. {
            assert!(attempt <= 100, "{code} makes no progress");
            let logged = killed.log(&code).len();
            // On a busy machine a start alone may take longer than the whole run that was measured.
            let spread = duration.mul_f64(1.0 + 0.1 * f64::from(attempt));
            let output = killed.run_and_kill(&code, spread.mul_f64(random.uniform()));
            let now = killed.answers(&code);
            assert!(now.starts_with(&seen), "{code}: rows that were there are gone or changed");
            let gained = whole_lines(&now).len() > seen.len();
            seen = whole_lines(&now).to_vec();
            if output.status.success() {
                break;
            }
            let answered = table(&String::from_utf8(seen.clone()).unwrap()).len();
            let log = killed.log(&code);
            // A trial begins when the one before has been answered.
            let begun = log.iter().rfind(|(event, _)| event == "trial-begun");
            let begun = begun.map_or(1, |(_, trial)| trial.parse().unwrap());
            assert!(answered + 1 >= begun, "{code}: trial {begun} was begun after {answered} rows");
            // Hit: this very process had opened the session and left it unfinished.
            if log.len() > logged && answered < TRIALS {
                hits += 1;
                gains += usize::from(gained && answered > 0);
                let session = &killed.status()[&code];
                assert_eq!(
                    (&session["state"], &session["answered"]),
                    (&"crashed".into(), &answered.into())
                );
            }
        }

        let file = answers_of(&killed.study(), &code);
        assert_whole(&file);
        assert_eq!(timeless(&file), timeless(&answers_of(&alone.study(), &code)), "{code}");
        let crashes = killed.log(&code).iter().filter(|(event, _)| event == "crashed").count();
        let session = &killed.status()[&code];
        assert_eq!((&session["state"], &session["crashes"]), (&"finished".into(), &crashes.into()));
        // Every time that a trial was begun is counted, and nothing is begun once it is answered.
        let log = killed.log(&code);
        for row in read_table(&file) {
            let begun = ("trial-begun".to_string(), row["trial"].clone());
            let count = log.iter().filter(|event| **event == begun).count();
            assert_eq!(row["attempt"], count.to_string(), "{code}: trial {}", row["trial"]);
        }
    }

    let (expected, found) = (alone.analysis(), killed.analysis());
    for key in ["items", "votes", "observers", "matrix"] {
        assert_eq!(found[key], expected[key], "{key}");
    }
    assert_eq!(found["observers"], participants);
    assert_eq!(read_table(&killed.study().join("participants.csv")).len(), participants);
}

/// A power cut can leave half a row: it is cut off, kept in the log, and its trial is asked again.
#[test]
fn a_torn_row_is_asked_again() {
    let (alone, torn) = (Place::new(), Place::new());
    for place in [&alone, &torn] {
        place.run("P1");
    }
    let file = answers_of(&torn.study(), "P1");
    let bytes = torn.answers("P1");
    let last_row = whole_lines(&bytes[..bytes.len() - 1]).len();
    for length in [bytes.len() - 1, bytes.len() - 40, last_row + 1] {
        std::fs::write(&file, &bytes[..length]).unwrap();
        let said = torn.run("P1");
        assert!(said.starts_with("P1: finished; 1 answers now, 37 before"), "{said}");
        assert_eq!(torn.answers("P1")[..last_row], bytes[..last_row]);
        assert_whole(&file);
        assert_eq!(timeless(&file), timeless(&answers_of(&alone.study(), "P1")));
        let half = String::from_utf8_lossy(&bytes[last_row..length]).replace('\n', "\\n");
        assert!(torn.log("P1").contains(&("torn-row".into(), half)));
    }
}

/// While a session is open, nobody else can run it; then it can be run, and nothing is lost.
#[test]
fn an_open_session_is_refused_to_others() {
    let place = Place::new();
    place.run("P0");
    // This process opens the session of P1.
    let study = place.open(&station_name());
    let (recorder, _) = study.session(&"P1".parse().unwrap(), 1, 38).unwrap();
    let records = || (tree(&place.study().join("data")), place.log("P1"));
    let before = records();
    let error = fail(place.folder.path(), 1, &guess("study", "P1"));
    assert!(error.contains(".lock: locked: subject P1 is being asked"), "{error}");
    assert_eq!(records(), before);
    assert_eq!(place.status()["P1"]["state"], "running");
    // The others go on as ever.
    place.run("P2");

    drop(recorder);
    let said = place.run("P1");
    assert!(said.starts_with("P1: finished; 38 answers now, 0 before"), "{said}");
    for code in ["P0", "P1", "P2"] {
        assert_whole(&answers_of(&place.study(), code));
    }
}

/// Two processes at once on one session: one runs it, the other is refused or comes too late, and
/// every trial is answered once.
#[test]
fn of_two_at_once_one_answers() {
    let place = Place::new();
    let mut refused = 0;
    for round in 1..=50 {
        let code = format!("R{round}");
        let outputs = std::thread::scope(|scope| {
            let start = || run_in(place.folder.path(), &guess("study", &code));
            [scope.spawn(start), scope.spawn(start)].map(|one| one.join().unwrap())
        });
        let mut answered = 0;
        for Output { status, stdout, stderr } in outputs {
            let (stdout, stderr) =
                (String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap());
            if status.success() {
                answered += usize::from(stdout.contains(": finished; 38 answers now, 0 before"));
            } else {
                let subject = format!("locked: subject {code} is being asked by another");
                let error = stderr.lines().last().unwrap();
                assert!(error.starts_with("error: ") && error.contains(&subject), "{stderr}");
                refused += 1;
            }
        }
        assert_eq!(answered, 1, "{code}");
        assert_whole(&answers_of(&place.study(), &code));
        if refused >= 3 {
            return;
        }
    }
    panic!("the two were never at it at once: {refused} of 50 refused");
}

#[test]
fn a_finished_session_is_left_as_it_is() {
    let place = Place::new();
    assert!(place.run("P1").starts_with("P1: finished; 38 answers now, 0 before, in study"));
    let before = place.answers("P1");
    let said = place.run("P1");
    assert!(said.starts_with("P1: was already finished; 0 answers now, 38 before"), "{said}");
    assert_eq!(place.answers("P1"), before);
}

/// A pilot is a study of its own inside the study: it changes nothing there and is never analysed.
#[test]
fn a_pilot_stays_apart() {
    let place = Place::new();
    let root = place.folder.path().join("study");
    let pilot = root.join("pilot");
    let run_pilot =
        |code: &str| place.succeed(&[guess("study", code).as_slice(), &["--pilot"]].concat());
    run_pilot("P1");
    // The pilot came first, and the study itself has not begun.
    let only_pilot: Vec<PathBuf> = tree(&root).into_keys().collect();
    assert!(only_pilot.iter().all(|name| name.starts_with("pilot")), "{only_pilot:?}");
    fail(place.folder.path(), 1, &["analyze", "study"]);

    place.run("P1");
    let outside_pilot = || {
        let mut files = tree(&root);
        files.retain(|name, _| !name.starts_with("pilot"));
        files
    };
    let before = outside_pilot();
    run_pilot("P2");
    assert_eq!(outside_pilot(), before);
    assert_eq!(place.analysis()["observers"], 1);

    assert_eq!(std::fs::read_dir(place.study().join("data")).unwrap().count(), 1);
    for file in [answers_of(&pilot, "P1"), answers_of(&pilot, "P2")] {
        assert_whole(&file);
        // Simulated answers stay simulated in a pilot: they count even less.
        let kinds = read_table(&file).into_iter().map(|row| row["kind"].clone());
        assert_eq!(
            kinds.collect::<Vec<_>>(),
            [vec!["practice"; 2], vec!["simulated"; TRIALS - 2]].concat()
        );
    }
}

/// Two stations: the other one's session is refused while its heart beats, in so many words; a session
/// whose station fell silent is taken over.
#[test]
fn a_session_of_another_station_is_refused_until_that_falls_silent() {
    let place = Place::new();
    place.run("P1");
    let whole = place.answers("P1");
    // Half of the answers, as given at another station, whose program runs.
    let half = whole_lines(&whole[..whole.len() / 2]);
    std::fs::write(answers_of(&place.study(), "P1"), half).unwrap();
    let running = place.open("cellar").session(&"P1".parse().unwrap(), 1, 38).unwrap();
    let error = fail(place.folder.path(), 1, &guess("study", "P1"));
    let expected =
        "locked: subject P1 is being asked by another running session, at station cellar since";
    assert!(error.contains(expected), "{error}");
    let session = &place.status()["P1"];
    assert_eq!((&session["state"], &session["station"]), (&"running".into(), &"cellar".into()));
    assert_eq!(place.answers("P1"), half);

    // As if its power was cut: the last heartbeat says that it runs, and no other comes.
    drop(running);
    let claims = place.study().join("log/claims/study-demo_subject-P1_session-1_task-2afc");
    let last = claims.join("2.json");
    let mut heartbeat: Value = serde_json::from_slice(&std::fs::read(&last).unwrap()).unwrap();
    heartbeat["state"] = "running".into();
    heartbeat["boot"] = "another".into();
    std::fs::write(&last, heartbeat.to_string()).unwrap();
    assert_eq!(place.status()["P1"]["state"], "crashed");
    place.run("P1");
    assert!(place.answers("P1").starts_with(half));
    assert_whole(&answers_of(&place.study(), "P1"));
    let log = place.log("P1");
    let crashed = log.iter().find(|(event, _)| event == "crashed").unwrap();
    assert!(crashed.1.starts_with("cellar, process "), "{crashed:?}");
}

/// A disk that takes no more: the error names the file, whole rows stay, and when there is room the
/// session goes on.
#[test]
#[cfg(unix)]
fn a_full_disk_loses_no_answer() {
    // So long a question that the answers are by far the largest file.
    let protocol = std::fs::read_to_string("experiments/protocols/demo.toml").unwrap();
    let question = format!("question = \"{}", "Which one? ".repeat(300));
    let protocol = protocol.replace("question = \"", &question);
    let (alone, full) = (Place::new(), Place::new());
    let mut run = guess("study", "P1");
    run[1] = "long.toml";
    for place in [&alone, &full] {
        std::fs::write(place.folder.path().join("long.toml"), &protocol).unwrap();
    }
    alone.succeed(&run);
    let room_kb = alone.answers("P1").len() / 1024 / 2;
    let script = format!("trap '' XFSZ; ulimit -f {room_kb}; exec \"$@\"");
    let output = std::process::Command::new("bash")
        .current_dir(full.folder.path())
        .args(["-c", &script, "bash", env!("CARGO_BIN_EXE_shutterlab")])
        .args(&run)
        .output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("subject-P1_session-1_task-2afc_data.csv: File too large"), "{error}");
    let kept = full.answers("P1");
    assert_eq!(whole_lines(&kept), kept);
    let answered = table(&String::from_utf8(kept).unwrap()).len();
    let session = &full.status()["P1"];
    assert_eq!((&session["state"], &session["answered"]), (&"left".into(), &answered.into()));
    let said = full.succeed(&run);
    assert!(said.contains(&format!("{answered} before")), "{said}");
    let file = answers_of(&full.study(), "P1");
    assert_whole(&file);
    assert_eq!(timeless(&file), timeless(&answers_of(&alone.study(), "P1")));
}

/// A stimulus that is gone, or another one than before, is refused before anything is written.
#[test]
fn stimuli_that_changed_in_the_middle_of_a_study_are_refused() {
    let place = Place::new();
    let stimuli = place.folder.path().join("s");
    copy_stimuli(&stimuli);
    let run = |code| {
        let mut args = guess("study", code);
        args[3] = "s";
        args
    };
    place.succeed(&run("P1"));
    let file = answers_of(&place.study(), "P1");
    let whole = place.answers("P1");
    let half = whole_lines(&whole[..whole.len() / 2]);
    std::fs::write(&file, half).unwrap();

    std::fs::rename(stimuli.join("M2-S2-T4-A4"), place.folder.path().join("away")).unwrap();
    let before = tree(&place.study());
    let error = fail(place.folder.path(), 1, &run("P1"));
    assert!(error.contains("are missing: M2-S2-T4-A4"), "{error}");
    assert_eq!(tree(&place.study()), before);

    // The same stimulus, rendered with another seed.
    let grid = std::fs::read_to_string("stimuli/grids/demo.toml").unwrap();
    let seed = grid.lines().find(|line| line.starts_with("seed = ")).unwrap();
    std::fs::write(place.folder.path().join("g.toml"), grid.replace(seed, "seed = 1")).unwrap();
    let size = ["--size", "16x9", "--device", "cpu", "--select", "shutter=T4,samples=A4"];
    place.succeed(&[&["render", "g.toml", "-o", "t"], size.as_slice()].concat());
    std::fs::rename(place.folder.path().join("t/M2-S2-T4-A4"), stimuli.join("M2-S2-T4-A4"))
        .unwrap();
    let error = fail(place.folder.path(), 1, &run("P1"));
    assert!(error.contains("hash_") && error.contains("begun with other stimuli"), "{error}");
    assert_eq!(place.answers("P1"), half);
}

/// Damaged files are named, and the rest is told all the same.
#[test]
fn status_names_what_it_cannot_read() {
    let place = Place::new();
    for code in ["P1", "P2", "P3"] {
        place.run(code);
    }
    place.succeed(&[guess("study", "P1").as_slice(), &["--pilot"]].concat());
    let (damaged, torn) = (answers_of(&place.study(), "P2"), answers_of(&place.study(), "P3"));
    let text = std::fs::read_to_string(&damaged).unwrap();
    std::fs::write(&damaged, text.replacen("demo,P2,1,", "demo,P2,one,", 1)).unwrap();
    let bytes = std::fs::read(&torn).unwrap();
    std::fs::write(&torn, &bytes[..bytes.len() - 9]).unwrap();
    std::fs::write(place.study().join("log/participants/p9.json"), "{").unwrap();

    let sections: Value =
        serde_json::from_str(&place.succeed(&["status", "study", "--json"])).unwrap();
    let kinds: Vec<&Value> = sections.as_array().unwrap().iter().map(|s| &s["kind"]).collect();
    assert_eq!(kinds, ["pilot", "simulated"]);
    let simulated = &sections[1];
    let faults: Vec<&str> =
        simulated["faults"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(
        faults[0].contains("p9.json: line 1: ") && faults[1].contains("subject-P2_"),
        "{faults:?}"
    );
    let answered: Vec<&Value> =
        simulated["sessions"].as_array().unwrap().iter().map(|s| &s["answered"]).collect();
    assert_eq!(answered, [TRIALS, TRIALS - 1]);

    let said = place.succeed(&["status", "study"]);
    for expected in
        ["PILOT, never a result: ", "SIMULATED OBSERVERS, never a finding: ", "cannot be read"]
    {
        assert!(said.contains(expected), "{said}");
    }
    let error = fail(place.folder.path(), 1, &["status", "nowhere"]);
    assert!(error.contains("nowhere: not a study"), "{error}");
}

/// The consistency that `status` shows is the one that the analysis gives.
#[test]
fn status_and_analysis_agree_about_consistency() {
    let place = Place::new();
    place.run("P1");
    let analysis = place.analysis();
    let zeta = &analysis["consistency"]["per_observer"][0]["zeta"];
    assert_eq!(&place.status()["P1"]["zeta"], zeta);
}

/// Withdrawn only when the code is typed once more; then the study is as if nobody had come.
#[test]
fn a_participant_is_withdrawn_when_the_code_is_typed() {
    let place = Place::new();
    let pilot = place.folder.path().join("study/pilot");
    for code in ["P1", "P2"] {
        place.succeed(&[guess("study", code).as_slice(), &["--pilot"]].concat());
    }
    let withdraw = |typed: &str| {
        let mut command = shutterlab();
        command.current_dir(place.folder.path());
        command.args(["withdraw", "P1", "--study", "study", "--pilot"]);
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = piped.spawn().unwrap();
        child.stdin.take().unwrap().write_all(typed.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    let before = tree(&pilot);
    for typed in ["", "P2\n", "yes\n"] {
        assert_eq!(withdraw(typed).status.code(), Some(1));
        assert_eq!(tree(&pilot), before);
    }
    let said = String::from_utf8(withdraw("P1\n").stdout).unwrap();
    assert!(said.starts_with("P1: withdrawn; 38 answers in 4 files removed"), "{said}");
    assert!(!answers_of(&pilot, "P1").exists() && answers_of(&pilot, "P2").exists());
    let again = ["withdraw", "P1", "--study", "study", "--pilot", "--yes"];
    assert!(fail(place.folder.path(), 1, &again).contains("subject P1: withdrawn at "));
    let run = [guess("study", "P1").as_slice(), &["--pilot"]].concat();
    assert!(fail(place.folder.path(), 1, &run).contains("the code is not used again"));
    let said = place.succeed(&["status", "study"]);
    assert!(said.contains("P1 withdrawn 2") && said.contains(", 38 answers"), "{said}");
}
