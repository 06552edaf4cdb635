//! Windows that are killed at any moment: no answer is missing or doubled.

use super::*;
use shutterlab_experiments::random::Stream;

/// `kill -9` at random moments (`SHUTTERLAB_WINDOW_KILLS` says how many) of windows: during the check and
/// the form, films and questions, between and right after keys. No answer is missing or doubled.
#[test]
fn kills_over_a_window_lose_no_answer_and_double_none() {
    let kills = std::env::var("SHUTTERLAB_WINDOW_KILLS").map_or(2, |text| text.parse().unwrap());
    let Some(screen) = Screen::open() else { return };
    let mut random = Stream::new(20122);
    // Kills in all, and while a trial was being asked.
    let (mut hits, mut in_trials) = (0, 0);
    while hits < kills || 5 * in_trials < kills {
        let folder = tempfile::tempdir().unwrap();
        let field = "[[participant]]\nkey = \"eye\"\nlabel = \"Which eye?\"\noptions = [\"left\", \"right\"]";
        let protocol = PROTOCOL.replace("[text]", &format!("{field}\n\n[text]"));
        let protocol_file = folder.path().join("protocol.toml");
        std::fs::write(&protocol_file, protocol).unwrap();
        let session = "study-three_subject-K_session-1_task-2afc";
        let data_file = folder.path().join(format!("study/data/{session}_data.csv"));
        let journal = folder.path().join(format!("study/log/{session}.log"));
        let answers = || std::fs::read(&data_file).unwrap_or_default();
        let rows = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte == b'\n').count();

        let mut seen = vec![];
        for start in 1.. {
            assert!(start <= 50, "no progress");
            // The kill comes some time after the window is open and so many rows are there.
            let enough = rows(&seen) + random.below(2);
            let mut moment = None;
            let mut command = run(&screen, &protocol_file, folder.path());
            let mut program = command.args(["--participant", "K"]).spawn().unwrap();
            let mut is_open = false;
            let status = loop {
                if let Some(status) = program.try_wait().unwrap() {
                    break Some(status);
                }
                if moment.is_none() && is_open && rows(&answers()) >= enough {
                    moment = Some(Instant::now() + Duration::from_secs_f64(4.0 * random.uniform()));
                }
                let left = moment.map(|at| at.saturating_duration_since(Instant::now()));
                if left.is_some_and(|left| left.is_zero()) {
                    program.kill().unwrap();
                    program.wait().unwrap();
                    break None;
                }
                // In the form they choose, on a page they go on, at a question they answer.
                let side = ["Left", "Right"][random.below(2)];
                let found = screen.xdotool(&["search", "--onlyvisible", "--name", "^Shutterlab"]);
                if let Some(window) = found.lines().next() {
                    is_open = true;
                    screen.xdotool(&["windowfocus", window, "key", side, "Return"]);
                }
                let pause = Duration::from_secs_f64(0.3 * random.uniform());
                std::thread::sleep(left.map_or(pause, |left| pause.min(left)));
            };
            let now = answers();
            assert!(now.starts_with(&seen), "rows that were there are gone or changed");
            seen = whole_lines(&now).to_vec();
            if let Some(status) = status {
                let stderr = std::fs::read_to_string(folder.path().join("stderr")).unwrap();
                assert!(status.success(), "{stderr}");
                break;
            }
            hits += 1;
            let journal = std::fs::read_to_string(&journal).unwrap_or_default();
            let last = journal.lines().last().unwrap_or_default();
            let is_asked = format!("\ttrial-begun\t{}", rows(&seen).max(1));
            in_trials += usize::from(last.ends_with(&is_asked));
        }

        let rows = read_table(&data_file);
        let trials: Vec<&str> = rows.iter().map(|row| row["trial"].as_str()).collect();
        assert_eq!(trials, ["1", "2", "3", "4"]);
        // Every time that a trial was begun is counted.
        let journal = std::fs::read_to_string(journal).unwrap();
        for row in &rows {
            let begun = format!("\ttrial-begun\t{}", row["trial"]);
            let count = journal.lines().filter(|line| line.ends_with(&begun)).count();
            assert_eq!(row["attempt"], count.to_string(), "trial {}", row["trial"]);
        }
        assert_eq!(read_table(&folder.path().join("study/participants.csv")).len(), 1);
    }
}
