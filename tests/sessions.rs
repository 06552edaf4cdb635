//! Sessions that are killed and go on.

use crate::support::{
    Row, answers_of, fail, guess, read_table, run_in, shutterlab, succeed, table, tree,
};
use shutterlab_experiments::protocols;
use shutterlab_experiments::random::Stream;
use shutterlab_experiments::record::study::Study;
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

    fn study(&self) -> PathBuf {
        self.folder.path().join("study")
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
        // What is killed says nothing; what ends by itself must not have failed.
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{code} after {delay:?}");
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

    fn analysis(&self) -> serde_json::Value {
        serde_json::from_str(&self.succeed(&["analyze", "study", "--json"])).unwrap()
    }
}

/// The bytes up to the last line end.
fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    &bytes[..end]
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

/// `kill -9` at fifty random moments of sessions under way: no answer is missing, doubled or another
/// one than without the kills.
#[test]
fn fifty_kills_lose_no_answer_and_double_none() {
    const KILLS: usize = 50;
    // Kills that came after answers of the process itself, not while it was still starting.
    const GAINS: usize = 10;
    let (alone, killed) = (Place::new(), Place::new());
    let mut random = Stream::new(20121);
    let (mut hits, mut gains, mut participants) = (0, 0, 0);
    while hits < KILLS || gains < GAINS {
        participants += 1;
        assert!(participants <= 100, "{hits} kills hit a session, {gains} after answers");
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
            }
        }

        let file = answers_of(&killed.study(), &code);
        assert_whole(&file);
        assert_eq!(timeless(&file), timeless(&answers_of(&alone.study(), &code)), "{code}");
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
        let half = String::from_utf8_lossy(&bytes[last_row..length]).escape_debug().to_string();
        assert!(torn.log("P1").contains(&("torn-row".into(), half)));
    }
}

/// While a session is open, nobody else can run it; then it can be run, and nothing is lost.
#[test]
fn an_open_session_is_refused_to_others() {
    let place = Place::new();
    place.run("P0");
    // This process opens the session of P1, as another station would.
    let study = Study::open(&place.study(), &protocols::load("demo").unwrap(), false).unwrap();
    let (recorder, _) = study.session(&"P1".parse().unwrap(), 1).unwrap();
    let records = || (tree(&place.study().join("data")), place.log("P1"));
    let before = records();
    let error = fail(place.folder.path(), 1, &guess("study", "P1"));
    assert!(error.contains("subject-P1_session-1_task-2afc_data.lock: locked: subject P1 "));
    assert_eq!(records(), before);
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
                assert!(stderr.starts_with("error: ") && stderr.contains(&subject), "{stderr}");
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
    let pilot = place.study().join("pilot");
    let run_pilot =
        |code: &str| place.succeed(&[guess("study", code).as_slice(), &["--pilot"]].concat());
    run_pilot("P1");
    // The pilot came first, and the study itself has not begun.
    let only_pilot: Vec<PathBuf> = tree(&place.study()).into_keys().collect();
    assert!(only_pilot.iter().all(|name| name.starts_with("pilot")), "{only_pilot:?}");
    fail(place.folder.path(), 1, &["analyze", "study"]);

    place.run("P1");
    let outside_pilot = || {
        let mut files = tree(&place.study());
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
