//! The report: what a page, a text and the tables must say, on made-up studies.

use crate::made_up::{STIMULI, csv_text, study};
use shutterlab_analysis::input::{matrix, responses};
use shutterlab_analysis::paired::{PairedComparison, analyze};
use shutterlab_analysis::replication::published;
use shutterlab_analysis::report::{self, ReportContext, files, html};
use shutterlab_data_schema::response::TrialKind;
use std::collections::BTreeMap;

fn analysis(kind: TrialKind) -> PairedComparison {
    let text = csv_text(&study(21, &STIMULI, kind));
    analyze(&responses::parse(&text, "r.csv").unwrap().preferences().unwrap(), 0.01).unwrap()
}

fn page(analysis: &PairedComparison) -> String {
    let thumbnails = BTreeMap::from([(STIMULI[0].to_string(), b"\x89PNG made up".to_vec())]);
    html(
        &analysis.document(),
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
    // The name of the SVG namespace is no address that anything is fetched from.
    let page_without_names = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in ["<script", "http://", "https://", "src=\"/", "@import", "<link"] {
        assert!(!page_without_names.contains(outside), "{outside}");
    }
    for section in ["Question", "Design", "Data quality", "Results", "Method", "Notes"] {
        assert!(page.contains(&format!("<h2>{section}</h2>")), "{section}");
    }
    assert!(page.contains("Which of the two sequences has the higher quality?"));
    assert!(page.contains("shutterlab analyze r.csv"));
    assert!(page.contains("data:image/png;base64,iVBORyBtYWRlIHVw"));
    assert!(page.contains(">T3-A4<") && page.contains("all M2-S2"));
    assert!(page.matches("<figcaption>").count() >= 5);
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
    assert!(report::text(&analysis.document()).starts_with("Simulated observers. "));
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
    let text = report::text(&analyze(&votes, 0.01).unwrap().document());
    for line in [
        "Paired comparison of t = 5 stimuli by n = 20 observers: 200 trials",
        "   1  A5           59     73.8   63.2 to  82.1  a",
        "   2  A4           51     63.8   52.8 to  73.4  ab",
        "   5  A1            8     10.0    5.2 to  18.5  c",
        "  R_c = 24 votes at α = 0.01 (n = 20, t = 5; W = 4.6028, ",
        "  Equality of the scores: D = 64.240, df = 4, p = ",
        "  Agreement of the observers not known: votes alone do not tell the answers to",
    ] {
        assert!(text.lines().any(|other| other.starts_with(line)), "{line}\n{text}");
    }
}

#[test]
fn every_p_of_the_text_has_n_and_tail_beside_it() {
    // Lines that are broken go on a little deeper.
    let text = report::text(&analysis(TrialKind::Real).document()).replace("\n    ", " ");
    let tests: Vec<&str> = text.lines().filter(|line| line.contains(", p ")).collect();
    assert!(tests.len() > 5, "{text}");
    for line in tests {
        let any = |words: &[&str]| words.iter().any(|word| line.contains(word));
        assert!(any(&["n = ", "df = "]), "{line}");
        assert!(any(&["tail", "two-sided"]), "{line}");
        assert!(any(&["exact", "approximat", "Monte Carlo"]), "{line}");
    }
}

#[test]
fn tables_keep_full_ids_and_the_matrix_can_be_read_again() {
    let straight = analysis(TrialKind::Real);
    let files: BTreeMap<String, Vec<u8>> = files(&straight.document()).into_iter().collect();
    let table = |name: &str| String::from_utf8(files[name].clone()).unwrap();
    assert_eq!(table("stimuli.csv").lines().count(), 10);
    assert_eq!(table("pairs.csv").lines().count(), 37);
    assert_eq!(table("observers.csv").lines().count(), 22);
    assert!(table("stimuli.csv").contains(&straight.items[0]));
    let again = matrix::parse(&table("matrix.csv"), 21, "matrix.csv").unwrap();
    assert_eq!(analyze(&again, 0.01).unwrap().agreement, straight.agreement);
}

#[test]
fn every_table_is_described_and_every_figure_is_a_picture() {
    for (kind, prefix) in [(TrialKind::Real, ""), (TrialKind::Simulated, "simulated-")] {
        let files: BTreeMap<String, Vec<u8>> =
            files(&analysis(kind).document()).into_iter().collect();
        let package: serde_json::Value =
            serde_json::from_slice(&files[&format!("{prefix}datapackage.json")]).unwrap();
        let described = package["resources"].as_array().unwrap();
        let tables = files.keys().filter(|name| name.ends_with(".csv")).count();
        assert_eq!(described.len(), tables);
        for resource in described {
            let csv = &files[resource["path"].as_str().unwrap()];
            let header = csv::Reader::from_reader(csv.as_slice()).headers().unwrap().clone();
            let fields = resource["schema"]["fields"].as_array().unwrap();
            assert!(header.iter().eq(fields.iter().map(|field| field["name"].as_str().unwrap())));
            assert!(fields.iter().all(|field| field["description"] != ""));
        }
        for figure in ["votes", "matrix", "consistency"] {
            let svg = String::from_utf8(files[&format!("figures/{prefix}{figure}.svg")].clone());
            assert_eq!(svg.unwrap().contains("Simulated observers"), !prefix.is_empty());
            assert!(files[&format!("figures/{prefix}{figure}.png")].starts_with(b"\x89PNG"));
        }
    }
}

#[test]
fn a_report_knows_its_files_and_no_others() {
    let files = files(&analysis(TrialKind::Real).document());
    let package = files.iter().find(|(name, _)| name == "datapackage.json").unwrap();
    let mut listed = report::files_of(std::str::from_utf8(&package.1).unwrap());
    let mut written: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
    written.retain(|name| name != "datapackage.json");
    listed.sort();
    written.sort();
    assert_eq!(listed, written);
    assert!(
        report::files_of("{\"name\": \"another\", \"resources\": [{\"path\": \"a\"}]}").is_empty()
    );
    let outside = "{\"name\": \"analysis\", \"figures\": [\"../x\", \"/y\", \"z.svg\"]}";
    assert_eq!(report::files_of(outside), ["z.svg"]);
}
