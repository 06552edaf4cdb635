//! What the tests share: running the command, small stimuli, temporary folders.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The built command.
pub fn shutterlab() -> Command {
    Command::new(env!("CARGO_BIN_EXE_shutterlab"))
}

/// Runs the command in `folder` with `args`.
pub fn run_in(folder: &Path, args: &[&str]) -> Output {
    shutterlab().current_dir(folder).args(args).output().unwrap()
}

/// Runs the command, which must succeed, and returns its stdout.
pub fn succeed(folder: &Path, args: &[&str]) -> String {
    let output = run_in(folder, args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs the command, which must fail with `status` and one error line on stderr, and returns that line.
pub fn fail(folder: &Path, status: i32, args: &[&str]) -> String {
    let output = run_in(folder, args);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{args:?}: {stderr}");
    // Where there is no Wayland, Mesa says so in words of its own.
    let is_error = |line: &&str| line.starts_with("error: ") && !line.contains("XDG_RUNTIME_DIR");
    let errors: Vec<&str> = stderr.lines().filter(is_error).collect();
    assert!(errors.len() == 1 && stderr.trim_end().ends_with(errors[0]), "{args:?}: {stderr}");
    // Paths are compared as they are written here.
    errors[0].replace('\\', "/")
}

/// The demo grid's nine sequences at 16×9 pixels, rendered once for all tests.
pub fn small_stimuli() -> &'static Path {
    static STIMULI: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = STIMULI.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        succeed(
            folder.path(),
            &["render", "demo", "-o", "stimuli", "--size", "16x9", "--device", "cpu"],
        );
        folder
    });
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| folder.path().join("stimuli"))
}

/// Copies the small demo stimuli to `to`.
pub fn copy_stimuli(to: &Path) {
    for (name, bytes) in tree(small_stimuli()) {
        let path = to.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// Every file below `folder` with its bytes, by relative path.
pub fn tree(folder: &Path) -> std::collections::BTreeMap<PathBuf, Vec<u8>> {
    let mut files = std::collections::BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// The arguments of `run` that let a simulated observer who guesses answer as `code`: the shipped
/// protocol, the small stimuli, and the folder `study`, in which the answers lie in `simulated`.
pub fn guess<'a>(study: &'a str, code: &'a str) -> Vec<&'a str> {
    let stimuli = small_stimuli().to_str().unwrap();
    let folders = ["--stimuli", stimuli, "--study", study];
    let observer = ["--participant", code, "--observer", "simulated:guess"];
    [&["run", "demo"], folders.as_slice(), &observer].concat()
}

/// Where session 1 of the simulated `code` in a study of the shipped protocol keeps its answers.
pub fn answers_of(study: &Path, code: &str) -> PathBuf {
    study.join(format!("data/study-demo_subject-{code}_session-1_task-2afc_data.csv"))
}

/// A row of a CSV, by column.
pub type Row = std::collections::BTreeMap<String, String>;

/// The rows of a CSV (RFC 4180), read without the code that wrote it. What follows the last line end
/// is left out.
pub fn table(text: &str) -> Vec<Row> {
    let (mut records, mut record, mut field) = (vec![], vec![], String::new());
    let (mut quoted, mut characters) = (false, text.chars().peekable());
    while let Some(character) = characters.next() {
        match character {
            '"' if quoted && characters.next_if_eq(&'"').is_some() => field.push('"'),
            '"' => quoted = !quoted,
            ',' if !quoted => record.push(std::mem::take(&mut field)),
            '\n' if !quoted => {
                record.push(std::mem::take(&mut field));
                records.push(std::mem::take(&mut record));
            }
            other => field.push(other),
        }
    }
    let mut records = records.into_iter();
    let names = records.next().unwrap_or_default();
    let row = |record: Vec<String>| {
        assert_eq!(record.len(), names.len(), "{record:?}");
        names.iter().cloned().zip(record).collect()
    };
    records.map(row).collect()
}

/// The rows of the CSV in `file`; see [`table`].
pub fn read_table(file: &Path) -> Vec<Row> {
    table(&std::fs::read_to_string(file).unwrap())
}

/// The bytes up to the last line end.
pub fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    &bytes[..end]
}

/// Skips a test for want of something, and says so; fails where the environment has `variable`, which
/// forbids skipping.
#[expect(clippy::print_stdout, reason = "a test that skips itself has to say so")]
pub fn skip(variable: &str, missing: &str) {
    assert!(std::env::var_os(variable).is_none(), "{variable} is set, and {missing}");
    println!("skipped: {missing}");
}
