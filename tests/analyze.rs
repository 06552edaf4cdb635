//! `analyze` on the published vote tables: the R_c and the groups that the printed votes give.

use crate::support::{fail, succeed};
use serde_json::Value;
use std::path::Path;

/// Table, observers, R_c, and the groups, best first (Navarro 2012, §5.6.3, §5.7, §6.5 and §6.6).
const TABLES: [(&str, &str, u64, &[&str]); 5] = [
    ("mono-sampling", "20", 24, &["A5 A4 A3", "A4 A3 A2", "A1"]),
    (
        "mono-shutter-sampling",
        "21",
        36,
        &["A4T3 A3T3 A5T3 A5T4 A4T4", "A5T4 A4T4 A3T4", "A3T4 A5T5", "A5T5 A4T5 A3T5"],
    ),
    ("stereo-shutter", "32", 30, &["T4 T3 T2", "T2 T5 T1"]),
    ("stereo-sampling", "32", 30, &["A3 A4 A5 A2 A1"]),
    (
        "stereo-shutter-sampling",
        "18",
        33,
        &["A4T3 A5T4 A5T3 A3T4 A3T3 A4T4", "A3T3 A4T4 A4T5 A5T5", "A4T4 A4T5 A5T5 A3T5"],
    ),
];

fn analyze(table: &str, observers: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("analysis/published");
    let json = succeed(
        &folder,
        &["analyze", "--votes", &format!("{table}.csv"), "--observers", observers, "--json"],
    );
    serde_json::from_str(&json).unwrap()
}

#[test]
fn published_votes_give_their_groups() {
    for (table, observers, r_c, groups) in TABLES {
        let analysis = analyze(table, observers);
        assert_eq!(analysis["grouping"]["r_c"], r_c, "{table}");
        // Items of equal votes may stand in either order.
        let sorted = |names: Vec<&str>| {
            let mut names = names;
            names.sort_unstable();
            names.join(" ")
        };
        let found: Vec<String> = analysis["grouping"]["groups"]
            .as_array()
            .unwrap()
            .iter()
            .map(|group| {
                sorted(
                    group.as_array().unwrap().iter().map(|item| item.as_str().unwrap()).collect(),
                )
            })
            .collect();
        let expected: Vec<String> =
            groups.iter().map(|group| sorted(group.split(' ').collect())).collect();
        assert_eq!(found, expected, "{table}");
    }
}

/// Vote totals do not tell ζ and u: they are null, with a reason.
#[test]
fn what_does_not_follow_is_null_with_a_reason() {
    let analysis = analyze("mono-sampling", "20");
    for key in ["consistency", "agreement"] {
        assert!(analysis[key].is_null(), "{key}");
        assert!(analysis[format!("{key}_reason")].as_str().unwrap().contains("votes"), "{key}");
    }
}

#[test]
fn a_matrix_gives_what_votes_cannot() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.csv"), ",a,b,c\na,0,9,8\nb,1,0,7\nc,2,3,0\n").unwrap();
    let json = succeed(
        folder.path(),
        &["analyze", "--matrix", "m.csv", "--observers", "10", "--json", "-o", "out"],
    );
    let analysis: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(analysis["items"], serde_json::json!(["a", "b", "c"]));
    // Σ = C(9,2) + C(8,2) + C(7,2) + C(2,2) + C(3,2) = 36 + 28 + 21 + 1 + 3 = 89; u = 2·89/(45·3) − 1.
    let u = analysis["agreement"]["u"].as_f64().unwrap();
    assert!((u - (178.0 / 135.0 - 1.0)).abs() < 1e-12, "{u}");
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("http-equiv") && !page.contains("<script"));
}

#[test]
fn a_level_out_of_range_is_refused() {
    let error = fail(
        Path::new("."),
        2,
        &["analyze", "--votes", "x.csv", "--observers", "5", "--alpha", "2"],
    );
    assert!(error.contains("0.5 is needed"), "{error}");
}
