//! The five vote tables of Navarro's thesis (2012): the printed R_c, and the groups that the printed
//! votes give.

use crate::close;
use shutterlab_analysis::Preferences;
use shutterlab_analysis::paired::analyze;
use shutterlab_analysis::replication::published;
use shutterlab_data_schema::Votes;

/// (table, groups at the printed α, best first)
const GROUPS: [(&str, &[&[&str]]); 5] = [
    ("mono-sampling", &[&["A5", "A4", "A3"], &["A4", "A3", "A2"], &["A1"]]),
    (
        "mono-shutter-sampling",
        &[
            &["A4T3", "A3T3", "A5T3", "A5T4", "A4T4"],
            &["A5T4", "A4T4", "A3T4"],
            &["A3T4", "A5T5"],
            &["A5T5", "A4T5", "A3T5"],
        ],
    ),
    ("stereo-shutter", &[&["T4", "T3", "T2"], &["T2", "T5", "T1"]]),
    ("stereo-sampling", &[&["A3", "A4", "A5", "A2", "A1"]]),
    (
        "stereo-shutter-sampling",
        &[
            &["A4T3", "A5T4", "A5T3", "A3T4", "A3T3", "A4T4"],
            &["A3T3", "A4T4", "A4T5", "A5T5"],
            &["A4T4", "A4T5", "A5T5", "A3T5"],
        ],
    ),
];

#[test]
fn the_printed_votes_give_the_printed_critical_differences_and_these_groups() {
    assert_eq!(published::tables().len(), GROUPS.len());
    for (table, (name, groups)) in published::tables().iter().zip(GROUPS) {
        assert_eq!(table.name, name);
        let analysis = analyze(&table.preferences().unwrap(), table.alpha).unwrap();
        let grouping = analysis.grouping.unwrap();
        assert_eq!(grouping.r_c, table.r_c, "{name}");
        assert_eq!(grouping.groups, groups, "{name}");
        assert_eq!(grouping.groups.len(), table.group_count, "{name}");
        close(grouping.w, table.w, 1e-3, name);
        if let Some(printed) = table.groups {
            assert_eq!(grouping.groups, printed, "{name}");
        }
    }
}

#[test]
fn what_votes_do_not_tell_is_null_with_a_reason() {
    let votes = published::find("stereo-shutter").unwrap();
    let analysis = analyze(&votes.preferences().unwrap(), 0.01).unwrap();
    let json = serde_json::to_value(&analysis).unwrap();
    for key in ["consistency", "agreement", "pairs", "data_quality", "simulated"] {
        assert!(json[key].is_null(), "{key}");
        assert!(json[format!("{key}_reason")].is_string(), "{key}");
    }
    assert_eq!(json["items"][0], "T4");
    assert_eq!(json["votes"][0], 87);
    assert_eq!(json["grouping"]["r_c"], 30);
    assert_eq!(json["preference"][0]["trials"], 128);
    assert!(json.get("grouping_reason").is_none());
}

#[test]
fn equality_of_scores_is_that_of_the_formula_by_hand() {
    // D = 4·Σ(a − 40)²/(20·5) = 4·(361 + 121 + 64 + 36 + 1024)/100.
    let votes = published::find("mono-sampling").unwrap();
    let analysis = analyze(&votes.preferences().unwrap(), 0.01).unwrap();
    let equality = analysis.score_equality.unwrap();
    close(equality.d, 64.24, 1e-14, "D");
    assert_eq!(equality.df, 4);
}

#[test]
fn the_order_of_the_rows_does_not_matter() {
    // The fifth table has equal votes, which keep the order of the file.
    for table in &published::tables()[..4] {
        let straight = analyze(&table.preferences().unwrap(), 0.05).unwrap();
        let mut votes = Votes::parse(table.csv, table.name).unwrap();
        votes.rows.reverse();
        let reversed = Preferences::from_votes(&votes, table.observers, table.name).unwrap();
        assert_eq!(straight, analyze(&reversed, 0.05).unwrap(), "{}", table.name);
    }
}

#[test]
fn alpha_is_a_probability() {
    let preferences = published::find("mono-sampling").unwrap().preferences().unwrap();
    for alpha in [0.0, 1.0, -0.1, f64::NAN, f64::INFINITY] {
        let error = analyze(&preferences, alpha).unwrap_err().to_string();
        assert_eq!(error, format!("alpha: {alpha}: a number above 0 and below 1 is needed"));
    }
}
