//! The committed schemas are those that the types give, and the examples are judged as they should be.
//! `SHUTTERLAB_BLESS=1 cargo test -p shutterlab-data-schema` writes the schemas anew.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on should panic")]

use schemars::schema_for;
use serde_json::Value;
use shutterlab_data_schema::protocol::Words;
use shutterlab_data_schema::response::Response;
use shutterlab_data_schema::votes::VoteRow;
use shutterlab_data_schema::{
    Cohort, DisplayProfile, FittedParameters, Protocol, Votes, study, table_schema::table_schema,
};
use std::path::{Path, PathBuf};

fn schemas() -> [(&'static str, Value); 7] {
    [
        ("cohort", schema_for!(Cohort).to_value()),
        ("display", schema_for!(DisplayProfile).to_value()),
        ("fitted", schema_for!(FittedParameters).to_value()),
        ("protocol", schema_for!(Protocol).to_value()),
        ("responses", study::responses_schema()),
        ("participants", study::participants_schema(&[])),
        ("votes", table_schema::<VoteRow>(&["item"])),
    ]
}

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn examples(folder: &str, name: &str) -> Vec<(PathBuf, String)> {
    let mut found: Vec<(PathBuf, String)> = std::fs::read_dir(here().join("examples").join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(name))
        .map(|path| (path.clone(), std::fs::read_to_string(&path).unwrap()))
        .collect();
    found.sort();
    assert!(!found.is_empty(), "no {folder} examples of {name}");
    found
}

/// The error that an invalid example says it has: its first line, after `# error: `.
fn expected_error(text: &str) -> &str {
    text.lines()
        .next()
        .unwrap()
        .strip_prefix("# error: ")
        .expect("an invalid example names its error")
}

#[test]
fn schemas_are_those_of_the_types() {
    for (name, schema) in schemas() {
        let path = here().join(format!("{name}.schema.json"));
        let text = format!("{schema:#}\n");
        if std::env::var_os("SHUTTERLAB_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == text,
            "{} differs from its type; SHUTTERLAB_BLESS=1 writes it anew",
            path.display()
        );
    }
}

#[test]
fn protocols_are_judged() {
    for (path, text) in examples("valid", "protocol") {
        Protocol::parse(&text, "protocol.toml")
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for (path, text) in examples("invalid", "protocol") {
        let error = Protocol::parse(&text, "protocol.toml").unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}

#[test]
fn cohorts_are_judged() {
    for (path, text) in examples("valid", "cohort") {
        Cohort::parse(&text, "cohort.toml")
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for (path, text) in examples("invalid", "cohort") {
        let error = Cohort::parse(&text, "cohort.toml").unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}

#[test]
fn fitted_parameters_are_judged() {
    for (path, text) in examples("valid", "fitted") {
        FittedParameters::parse(&text, "fitted.toml")
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for (path, text) in examples("invalid", "fitted") {
        let error = FittedParameters::parse(&text, "fitted.toml").unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}

#[test]
fn display_profiles_are_judged() {
    for (path, text) in examples("valid", "display") {
        // The table lies beside the profile.
        DisplayProfile::parse(&text, &path.display().to_string())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for (path, text) in examples("invalid", "display") {
        let error = DisplayProfile::parse(&text, "display.toml").unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}

/// The German example translates every word there is: no English is left for the participant.
#[test]
fn every_word_comes_from_the_protocol() {
    let german =
        std::fs::read_to_string(here().join("examples/valid/protocol-german.toml")).unwrap();
    let german = Protocol::parse(&german, "protocol-german.toml").unwrap();
    let words = |words: &Words| serde_json::to_value(words).unwrap();
    let (german, english) = (words(&german.words), words(&Words::default()));
    for (key, word) in english.as_object().unwrap() {
        assert_ne!(german[key], *word, "{key}");
    }
}

#[test]
fn responses_are_judged() {
    let read = |text: &str| -> Result<Vec<Response>, csv::Error> {
        csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_reader(text.as_bytes())
            .deserialize()
            .collect()
    };
    for (path, text) in examples("valid", "responses") {
        let rows = read(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        // Written again, they are the same file.
        let mut writer = csv::Writer::from_writer(vec![]);
        rows.iter().for_each(|row| writer.serialize(row).unwrap());
        assert_eq!(
            String::from_utf8(writer.into_inner().unwrap()).unwrap(),
            text,
            "{}",
            path.display()
        );
    }
    for (path, text) in examples("invalid", "responses") {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}

#[test]
fn votes_are_judged() {
    for (path, text) in examples("valid", "votes") {
        Votes::parse(&text, "votes.csv")
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for (path, text) in examples("invalid", "votes") {
        let error = Votes::parse(&text, "votes.csv").unwrap_err().to_string();
        assert!(error.contains(expected_error(&text)), "{}: {error}", path.display());
    }
}
