//! `plan`: what a study can find, before anything is rendered.

use crate::support::{fail, small_stimuli, succeed};
use serde_json::Value;
use std::path::Path;

const SHIPPED: [&str; 15] = [
    "mono1",
    "mono2shutter",
    "mono2samples",
    "mono2preference",
    "mono3",
    "stereo1",
    "stereo2shutter",
    "stereo2samples",
    "stereo3",
    "samedifferent",
    "zhang-r",
    "zhang-lod",
    "zhang-validation",
    "demo",
    "quick",
];

fn plan(args: &[&str]) -> Value {
    let fewer = ["--studies", "20", "--observers", "8,24", "--json"];
    let args = [&["plan"], args, fewer.as_slice()].concat();
    serde_json::from_str(&succeed(Path::new("."), &args)).unwrap()
}

/// Every number is one, every null has its reason.
fn check(name: &str, value: &Value) {
    match value {
        Value::Object(fields) => {
            for (key, field) in fields {
                let optional = ["critical", "smallest_preference", "worths"];
                if field.is_null() && !optional.contains(&key.as_str()) {
                    let reason = fields.get(&format!("{key}_reason"));
                    assert!(reason.is_some_and(Value::is_string), "{name}: {key}");
                }
                check(name, field);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| check(name, item)),
        _ => {}
    }
}

#[test]
fn every_shipped_protocol_can_be_planned() {
    for name in SHIPPED {
        let json = plan(&[name]);
        check(name, &json);
        let text =
            succeed(Path::new("."), &["plan", name, "--studies", "20", "--observers", "8,24"]);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{name}");
        assert!(
            !text.split_whitespace().any(|word| ["NaN", "inf", "-inf"].contains(&word)),
            "{name}"
        );
        let advice = json["plan"]["advice"].as_str().unwrap();
        assert!(advice.contains("observers") && advice.ends_with('.'), "{name}: {advice}");
        // What the task has, and what it has not.
        let has = |part: &str| !json["plan"][part].is_null();
        let (two_afc, matching, rating) = match name {
            "mono2shutter" | "mono2samples" => (false, true, false),
            "samedifferent" | "zhang-r" | "zhang-lod" | "zhang-validation" => (false, false, true),
            _ => (true, false, false),
        };
        let complete = two_afc && !["mono1", "stereo1"].contains(&name);
        assert_eq!(has("pair"), two_afc || matching, "{name}");
        assert_eq!(has("accuracy"), matching || rating, "{name}");
        assert_eq!(has("rating"), rating, "{name}");
        assert_eq!((has("scores"), has("simulated")), (complete, complete), "{name}");
        assert_eq!(has("scale"), two_afc, "{name}");
    }
}

/// Thesis values: R_c at α = 0.01 is 36 for 21 and 33 for 18 observers of nine stimuli; 24 and 30 for 20 and
/// 32 sets of five, which ten and sixteen observers give twice each.
#[test]
fn the_critical_differences_are_the_printed_ones() {
    for (name, observers, r_c) in [
        ("mono3", 21, 36),
        ("stereo3", 18, 33),
        ("mono2preference", 10, 24),
        ("stereo2shutter", 16, 30),
    ] {
        let args =
            ["plan", name, "--observers", &observers.to_string(), "--studies", "1", "--json"];
        let json: Value = serde_json::from_str(&succeed(Path::new("."), &args)).unwrap();
        assert_eq!(json["plan"]["scores"][0]["r_c"], r_c, "{name}");
    }
}

#[test]
fn rendered_stimuli_tell_their_length_and_the_same_plan() {
    let stimuli = small_stimuli().to_str().unwrap();
    let (before, after) = (plan(&["demo"]), plan(&["demo", "--stimuli", stimuli]));
    assert!(after["session"]["seconds"].as_f64() < before["session"]["seconds"].as_f64());
    assert_eq!(before["plan"]["scores"], after["plan"]["scores"]);
    assert_eq!(before["plan"]["simulated"], after["plan"]["simulated"]);
}

#[test]
fn given_worths_are_those_of_simulated_observers() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("worths.csv");
    std::fs::write(&file, "item,worth\nT3,4\nT4,4\nT5,1\n").unwrap();
    let json = plan(&["mono3", "--worths", file.to_str().unwrap()]);
    let worths = json["plan"]["assumptions"]["worths"].as_array().unwrap();
    assert_eq!(worths.len(), 9);
    assert!((worths[0].as_f64().unwrap() - 4_f64.ln()).abs() < 1e-12);
    std::fs::write(&file, "item,worth\nT3,4\nT4,4\n").unwrap();
    let error = fail(Path::new("."), 1, &["plan", "mono3", "--worths", file.to_str().unwrap()]);
    assert!(error.contains("0 items are about M2-S2-T5-A3"), "{error}");
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    for (option, value, said) in [
        ("--alpha", "0", "plan: --alpha: 0: 0.000001 to 0.5"),
        ("--effect", "0.5", "plan: --effect: 0.5: 0.51 to 0.99"),
        ("--observers", "0", "plan: --observers: 0: 1 to 1000"),
        ("--spread", "inf", "plan: --spread: inf: 0 to 5"),
        ("--studies", "0", "plan: --studies: 0: 1 to 1000000"),
    ] {
        let error = fail(Path::new("."), 2, &["plan", "demo", option, value]);
        assert!(error.contains(said), "{error}");
    }
    let error = fail(Path::new("."), 2, &["plan", "dmo"]);
    assert!(error.contains("demo"), "{error}");
}
