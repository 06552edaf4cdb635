//! `replicate`: the thesis's numbers beside what its votes give.

use crate::support::{fail, succeed};
use serde_json::Value;
use std::path::Path;

#[test]
fn each_chapter_is_told_line_by_line() {
    for (name, conflict) in [("navarro-mono", "§5.8"), ("navarro-stereo", "[−1/17, 1]")] {
        let text = succeed(Path::new("."), &["replicate", name]);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{name}");
        assert!(text.contains("CONFLICT") && text.contains(conflict), "{name}");
        let json = succeed(Path::new("."), &["replicate", name, "--json"]);
        let json: Value = serde_json::from_str(&json).unwrap();
        let lines = json["lines"].as_array().unwrap();
        let zeta: Vec<&Value> = lines.iter().filter(|line| line["what"] == "ζ").collect();
        assert!(!zeta.is_empty(), "{name}");
        for line in zeta {
            assert!(line["ours"].is_null(), "{line}");
            assert!(line["ours_reason"].as_str().unwrap().contains("votes"), "{line}");
        }
        assert!(lines.iter().any(|line| line["verdict"] == "conflict"), "{name}");
    }
}

#[test]
fn an_unknown_name_lists_the_known_ones() {
    let error = fail(Path::new("."), 2, &["replicate", "navarro"]);
    assert!(error.contains("navarro-mono, navarro-stereo"), "{error}");
}
