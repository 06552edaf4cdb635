//! The report: what a page, a text and the tables must say, on made-up studies.

use crate::made_up::{STIMULI, csv_text, study};
use shutterlab_analysis::report::{ReportContext, html, tables, text};
use shutterlab_analysis::{Analysis, analyze, matrix, published, responses};
use shutterlab_data_schema::response::TrialKind;
use std::collections::BTreeMap;

fn analysis(kind: TrialKind) -> Analysis {
    let text = csv_text(&study(21, &STIMULI, kind));
    analyze(&responses::parse(&text, "r.csv").unwrap(), 0.01).unwrap()
}

fn page(analysis: &Analysis) -> String {
    let thumbnails = BTreeMap::from([(STIMULI[0].to_string(), b"\x89PNG made up".to_vec())]);
    html(
        analysis,
        &ReportContext {
            title: "Shutter & <samples>",
            thumbnails: &thumbnails,
            command: "shutterlab analyze r.csv",
            version: "0.1.0",
        },
    )
}

#[test]
fn the_page_is_whole_and_needs_nothing_from_outside() {
    let page = page(&analysis(TrialKind::Real));
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    assert!(page.contains("<title>Shutter &amp; &lt;samples&gt;</title>"));
    for outside in ["<script", "http://", "https://", "src=\"/", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for section in
        ["Question", "Design", "Data quality", "Results", "Statistics", "Method", "Notes"]
    {
        assert!(page.contains(&format!("<h2>{section}</h2>")), "{section}");
    }
    assert!(page.contains("Which of the two sequences has the higher quality?"));
    assert!(page.contains("shutterlab analyze r.csv"));
    assert!(page.contains("data:image/png;base64,iVBORyBtYWRlIHVw"));
    assert!(page.contains(">T3-A4<") && page.contains("all have M2-S2"));
    assert_eq!(page.matches("<figcaption>").count(), 4);
    assert!(!page.contains("Simulated") && !page.contains("NaN"));
}

#[test]
fn simulated_observers_are_named_in_the_title_and_under_every_figure() {
    let analysis = analysis(TrialKind::Simulated);
    let page = page(&analysis);
    assert!(page.contains("<h1>Simulated observers: Shutter"));
    assert_eq!(
        page.matches("<figcaption>").count(),
        page.matches(". </b>Simulated observers. ").count()
    );
    assert!(text(&analysis).starts_with("Simulated observers. "));
}

#[test]
fn votes_alone_make_a_page_with_reasons() {
    let votes = published::find("mono-shutter-sampling").unwrap().preferences().unwrap();
    let page = page(&analyze(&votes, 0.01).unwrap());
    assert!(page.contains("not known: votes alone do not tell"));
    assert!(page.contains("R<sub>c</sub> = 36 votes"));
    assert_eq!(page.matches("<figcaption>").count(), 1);
}

#[test]
fn the_text_ranks_groups_and_tests() {
    let votes = published::find("mono-sampling").unwrap().preferences().unwrap();
    let text = text(&analyze(&votes, 0.01).unwrap());
    for line in [
        "Paired comparison of t = 5 stimuli by n = 20 observers: 200 trials",
        "   1  A5           59     73.8   63.2 to  82.1  a",
        "   2  A4           51     63.8   52.8 to  73.4  ab",
        "   5  A1            8     10.0    5.2 to  18.5  c",
        "  R_c = 24 votes at α = 0.01 (n = 20, t = 5; W = 4.6028, ",
        "  D = 64.240, df = 4, p = ",
        "  not known: votes alone do not tell the answers to single pairs",
    ] {
        assert!(text.lines().any(|other| other.starts_with(line)), "{line}\n{text}");
    }
}

#[test]
fn every_p_of_the_text_has_n_t_and_tail_beside_it() {
    let text = text(&analysis(TrialKind::Real));
    let tests: Vec<&str> = text.lines().filter(|line| line.contains(", p ")).collect();
    assert_eq!(tests.len(), 5, "{text}");
    for line in tests {
        for part in ["n = 21, t = 9", "tail"] {
            assert!(line.contains(part), "{line}");
        }
        assert!(line.contains("exact") || line.contains("approximation"), "{line}");
    }
}

#[test]
fn tables_keep_full_ids_and_the_matrix_can_be_read_again() {
    let straight = analysis(TrialKind::Real);
    let tables: BTreeMap<String, String> = tables(&straight).into_iter().collect();
    let names: Vec<&str> = tables.keys().map(String::as_str).collect();
    assert_eq!(names, ["matrix.csv", "observers.csv", "pairs.csv", "stimuli.csv"]);
    assert_eq!(tables["stimuli.csv"].lines().count(), 10);
    assert_eq!(tables["pairs.csv"].lines().count(), 37);
    assert_eq!(tables["observers.csv"].lines().count(), 22);
    assert!(tables["stimuli.csv"].contains(&straight.items[0]));
    let again = matrix::parse(&tables["matrix.csv"], 21, "matrix.csv").unwrap();
    assert_eq!(analyze(&again, 0.01).unwrap().agreement, straight.agreement);
}
