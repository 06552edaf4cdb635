//! What was published, beside what its votes give.

use super::close;
use serde_json::{Value, json};
use shutterlab_analysis::replication::{Line, NAMES, Verdict, replicate, section, text};

fn json_of(name: &str) -> Vec<Value> {
    let json = serde_json::to_value(replicate(name).unwrap()).unwrap();
    json["lines"].as_array().unwrap().clone()
}

fn line(name: &str, section: &str, what: &str) -> Line {
    let lines = replicate(name).unwrap().lines;
    let found = lines.into_iter().find(|line| line.section == section && line.what.contains(what));
    found.unwrap_or_else(|| panic!("{name}: §{section}: {what}"))
}

#[test]
fn what_is_null_has_a_reason_and_every_line_a_section() {
    for name in NAMES {
        for line in json_of(name) {
            assert!(line["section"].as_str().unwrap().contains('.'), "{line}");
            for field in ["published", "ours"] {
                let reason = line.get(format!("{field}_reason"));
                assert_eq!(line[field].is_null(), reason.is_some(), "{line}");
            }
            let verdict = line["verdict"].as_str().unwrap();
            assert_eq!(line["ours"].is_null(), verdict == "unknown", "{line}");
            assert_eq!(
                line["published"].is_null() && verdict != "unknown",
                verdict == "not-printed"
            );
        }
    }
}

/// Found by hand from the printed votes: |aᵢ − aⱼ| against R_c, and −1/(m − 1) for the least u of 18 judges.
#[test]
fn known_numbers_agree_and_known_conflicts_are_flagged() {
    for (name, section, what, verdict) in [
        ("navarro-mono", "5.6.3", "R_c, α", Verdict::Agrees),
        ("navarro-mono", "5.6.3", "groups, best first", Verdict::Agrees),
        ("navarro-mono", "5.7.2", "R_c, α", Verdict::Agrees),
        ("navarro-mono", "5.7.2", "number of groups", Verdict::Agrees),
        ("navarro-mono", "5.7.2", "range of u", Verdict::Agrees),
        ("navarro-mono", "5.7.2", "group 1", Verdict::Conflict),
        ("navarro-mono", "5.7.2", "group 4", Verdict::Agrees),
        ("navarro-mono", "5.8", "A5T3 and A3T4", Verdict::Conflict),
        ("navarro-stereo", "6.5.2.1", "groups, best first", Verdict::Agrees),
        ("navarro-stereo", "6.5.2.2", "groups, best first", Verdict::Agrees),
        ("navarro-stereo", "6.6.1", "material", Verdict::Conflict),
        ("navarro-stereo", "6.6.2", "R_c, α", Verdict::Agrees),
        ("navarro-stereo", "6.6.2", "range of u", Verdict::Conflict),
        ("navarro-stereo", "6.6.2", "groups 2 and 3", Verdict::Conflict),
    ] {
        assert_eq!(line(name, section, what).verdict, verdict, "§{section}: {what}");
    }
}

/// The whole numbers behind the printed ζ and u, found by hand: (1 − ζ)·n·d_max and (1 + u)·C(n,2)·C(t,2)/2.
#[test]
fn printed_coefficients_are_those_of_whole_numbers() {
    for (name, section, what) in [
        ("navarro-mono", "5.7.2", "ζ of 221 of 630"),
        ("navarro-mono", "5.7.2", "u of 4836 of 7560"),
        ("navarro-stereo", "6.5.2.1", "ζ of 35 of 160"),
        ("navarro-stereo", "6.5.2.1", "u of 2836 or 2837 or 2838 of 4960"),
        ("navarro-stereo", "6.5.2.2", "ζ of 79 of 160"),
        ("navarro-stereo", "6.5.2.2", "u of 2524 of 4960"),
        ("navarro-stereo", "6.6.2", "ζ of 212 of 540"),
        ("navarro-stereo", "6.6.2", "u of 3067 of 5508"),
    ] {
        assert_eq!(line(name, section, what).verdict, Verdict::Agrees, "{what}");
    }
}

/// R 4.2.2: binom.test(138, 160), binom.test(102, 160); fisher.test of both.
#[test]
fn percentages_are_tested_with_their_counts() {
    let p = |what: &str| {
        let json = serde_json::to_value(line("navarro-mono", "5.6.2", what)).unwrap();
        json["ours"].as_f64().unwrap()
    };
    close(p("shutter times matched: test"), 9.840112302927042e-22, 1e-10, "shutter");
    close(p("sampling levels matched: test"), 0.0006293470747506879, 1e-10, "samples");
    close(p("beside shutter times"), 4.744348404916603e-06, 1e-10, "difference");
}

#[test]
fn the_text_is_as_wide_as_a_terminal_and_the_section_has_every_line() {
    for name in NAMES {
        let replication = replicate(name).unwrap();
        let text = text(&replication);
        assert!(text.lines().all(|line| line.chars().count() <= 100));
        let section = section(&replication);
        assert_eq!(section.tables[0].rows.len(), replication.lines.len());
        assert!(section.tables[0].rows.iter().all(|row| row.len() == 6));
        assert!(!text.contains("NaN") && !json!(replication).to_string().contains("NaN"));
    }
}

#[test]
fn an_unknown_experiment_is_refused_by_name() {
    let error = replicate("navarro").unwrap_err().to_string();
    assert_eq!(error, "replicate: NAME: navarro: navarro-mono and navarro-stereo are known");
}
