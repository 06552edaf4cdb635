//! Responses: a made-up study is read, and bad files are refused by file, line, field and value.

use crate::close;
use crate::made_up::{STIMULI, csv_text, study};
use shutterlab_analysis::input::{matrix, responses};
use shutterlab_analysis::paired::{PairedComparison, analyze};
use shutterlab_analysis::{InputError, Preferences};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::response::{Answer, TrialKind};

fn real() -> Vec<Response> {
    study(21, &STIMULI, TrialKind::Real)
}

fn parse(rows: &[Response]) -> Result<Preferences, InputError> {
    responses::parse(&csv_text(rows), "r.csv")?.preferences()
}

fn analysis(rows: &[Response]) -> PairedComparison {
    analyze(&parse(rows).unwrap(), 0.01).unwrap()
}

#[test]
fn a_whole_study_gives_everything() {
    let rows = real();
    let analysis = analysis(&rows);
    assert_eq!((analysis.observers, analysis.trials), (21, 21 * 36));
    assert_eq!(analysis.simulated, Ok(false));
    assert_eq!(analysis.votes.iter().sum::<u64>(), 21 * 36);
    let quality = analysis.data_quality.unwrap();
    assert_eq!((quality.excluded.practice, quality.subjects), (42, 21));
    let consistency = analysis.consistency.unwrap();
    assert!(consistency.test.exact && consistency.per_observer_not_testable.is_none());
    close(consistency.zeta, consistency.zeta_mean, 1e-12, "pooled and mean ζ");
    let agreement = analysis.agreement.unwrap();
    assert!(agreement.u > 0.0 && agreement.p_exact.unwrap().value() < 1e-10);
    assert_eq!(analysis.pairs.unwrap().len(), 36);
}

#[test]
fn one_judge_who_always_chooses_the_better_has_no_triads() {
    let mut rows = study(1, &STIMULI, TrialKind::Real);
    for row in &mut rows {
        if row.selected.as_ref() != Some(&row.stimulus_a) {
            row.selected = Some(row.stimulus_a.clone());
            row.answer = match row.answer {
                Answer::First => Answer::Second,
                _ => Answer::First,
            };
        }
    }
    let analysis = analysis(&rows);
    assert_eq!(analysis.items, STIMULI);
    assert_eq!(analysis.votes, [8, 7, 6, 5, 4, 3, 2, 1, 0]);
    let consistency = analysis.consistency.unwrap();
    assert_eq!((consistency.circular_triads, consistency.zeta), (0, 1.0));
    // 362880 of 68719476736 tournaments are transitive.
    close(consistency.test.p.value(), 362880.0 / 68719476736.0, 1e-12, "p");
    assert!(analysis.agreement.unwrap_err().starts_with("agreement needs at least 2"));
}

#[test]
fn neither_the_order_of_the_rows_nor_the_names_of_the_items_matter() {
    let rows = real();
    let straight = analysis(&rows);
    let mut reversed = rows.clone();
    reversed.reverse();
    assert_eq!(analysis(&reversed), straight);

    // Renamed so that the alphabet runs the other way: the same statistics under other names.
    let rename = |id: &mut String| {
        if let Some(place) = STIMULI.iter().position(|other| other == id) {
            *id = format!("S{:02}", 99 - place);
        }
    };
    let mut renamed = rows;
    for row in &mut renamed {
        rename(&mut row.stimulus_a);
        rename(&mut row.stimulus_b);
        row.selected.iter_mut().for_each(&rename);
    }
    let renamed = analysis(&renamed);
    assert_eq!(renamed.votes, straight.votes);
    assert_eq!(renamed.agreement, straight.agreement);
    assert_eq!(renamed.consistency, straight.consistency);
}

#[test]
fn the_pooled_matrix_gives_the_same_as_the_responses() {
    let straight = analysis(&real());
    let mut text = format!("over,{}\n", straight.items.join(","));
    for (item, row) in straight.items.iter().zip(straight.matrix.as_ref().unwrap()) {
        let cells: Vec<String> = row.iter().map(ToString::to_string).collect();
        text += &format!("{item},{}\n", cells.join(","));
    }
    let pooled = analyze(&matrix::parse(&text, 21, "m.csv").unwrap(), 0.01).unwrap();
    assert_eq!(pooled.grouping, straight.grouping);
    assert_eq!(pooled.agreement, straight.agreement);
    assert_eq!(pooled.preference, straight.preference);
    assert!(pooled.consistency.unwrap_err().starts_with("a pooled matrix does not tell"));
}

#[test]
fn an_incomplete_matrix_keeps_what_follows_and_says_what_does_not() {
    let text = "over,A,B,C\nA,0,7,6\nB,3,0,5\nC,2,5,0\n";
    let analysis = analyze(&matrix::parse(text, 10, "m.csv").unwrap(), 0.05).unwrap();
    assert!(analysis.score_equality.is_err());
    assert!(analysis.grouping.unwrap_err().starts_with("scores can only be compared"));
    let agreement = analysis.agreement.unwrap();
    assert!(agreement.chi2.is_none() && agreement.p_exact.is_some());
    assert!(analysis.notes[0].contains("1 of 3 pairs were judged by fewer than 10"));
    assert_eq!(analysis.preference[0].proportion.trials, 18);
}

#[test]
fn a_session_under_way_is_left_out_by_name() {
    let mut rows = real();
    rows.truncate(rows.len() - 5);
    let analysis = analysis(&rows);
    assert_eq!(analysis.observers, 20);
    assert_eq!(analysis.data_quality.unwrap().excluded.incomplete_sets, 31);
    let note = "Left out of votes, groups, consistency and agreement: subject P21, session 1, \
                repetition 1, who chose in 31 of 36 pairs.";
    assert_eq!(analysis.notes[0], note);
}

#[test]
fn sets_of_one_person_are_counted_and_flagged() {
    let mut rows = study(4, &STIMULI[..5], TrialKind::Real);
    let mut again = rows.clone();
    for row in &mut again {
        row.session = 2;
    }
    rows.extend(again);
    let analysis = analysis(&rows);
    assert_eq!((analysis.observers, analysis.data_quality.unwrap().subjects), (8, 4));
    assert!(analysis.notes[0].starts_with("n = 8 complete sets come from 4 subjects."));
    let reason = analysis.consistency.unwrap().per_observer_not_testable.unwrap();
    assert!(reason.starts_with("not testable: with t = 5 "), "{reason}");
    assert!(reason.contains("p = 0.1172"), "{reason}");
}

#[test]
fn a_changed_stimulus_is_flagged() {
    let mut rows = real();
    rows[5].hash_a = "another".into();
    let expect = format!("Stimulus {}, exemplar 0, was shown in 2 versions", rows[5].stimulus_a);
    assert!(analysis(&rows).notes[0].starts_with(&expect));
}

#[test]
fn simulated_observers_are_analysed_and_named() {
    let analysis = analysis(&study(3, &STIMULI, TrialKind::Simulated));
    assert_eq!(analysis.simulated, Ok(true));
    assert_eq!(analysis.data_quality.unwrap().observers, ["simulated:made-up"]);
}

#[test]
fn a_study_folder_is_all_its_data_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let rows = real();
    for (name, of) in [("P01", true), ("others", false)] {
        let part: Vec<Response> =
            rows.iter().filter(|r| (r.subject.to_string() == "P01") == of).cloned().collect();
        let file = format!("data/study-madeUp_subject-{name}_session-1_task-2afc_data.csv");
        std::fs::write(folder.path().join(file), csv_text(&part)).unwrap();
    }
    let read =
        analyze(&responses::read(&[folder.path()]).unwrap().preferences().unwrap(), 0.01).unwrap();
    assert_eq!(read, analysis(&rows));
    let missing = responses::read(&[folder.path().join("no.csv")]).err().unwrap().to_string();
    assert!(missing.contains("no.csv: cannot be read: "), "{missing}");
    std::fs::remove_dir_all(folder.path().join("data")).unwrap();
    let no_data = responses::read(&[folder.path()]).err().unwrap().to_string();
    assert!(no_data.contains("cannot be read: "), "{no_data}");
}

/// What is wrong, how it comes about, and the start of the message.
type Bad = (&'static str, fn(&mut Vec<Response>), &'static str);

#[test]
fn bad_rows_are_refused_by_name() {
    let bad: [Bad; 11] = [
        (
            "real and simulated",
            |rows| rows[3].kind = TrialKind::Simulated,
            "r.csv: kind: 755 real and 1 simulated rows: people and simulated observers are never",
        ),
        (
            "only pilot and practice",
            |rows| rows.iter_mut().skip(2).for_each(|row| row.kind = TrialKind::Pilot),
            "r.csv: kind: no answer counts yet: 2 practice, 0 catch and 796 pilot rows: rows that are",
        ),
        ("no rows", |rows| rows.truncate(0), "r.csv: line 1: header: an empty file: "),
        (
            "a trial twice",
            |rows| rows[4].trial = 4,
            "r.csv: line 6: trial: subject P01, session 1, trial 4: answered before in r.csv, line 5",
        ),
        (
            "a pair twice",
            |rows| {
                rows[3].stimulus_b = rows[2].stimulus_b.clone();
                rows[3].selected = Some(rows[3].stimulus_a.clone());
                rows[3].answer = match rows[3].first {
                    shutterlab_data_schema::response::Side::A => Answer::First,
                    shutterlab_data_schema::response::Side::B => Answer::Second,
                };
            },
            "r.csv: line 5: pair: `M2-S2-T3-A4` and `M2-S2-T3-A3`: once in a repetition, and answered before in r.csv, line 4",
        ),
        (
            "another protocol",
            |rows| rows[9].study = "other".into(),
            "r.csv: line 11: study: `other`: all rows are needed to be of one protocol, `madeUp`",
        ),
        (
            "a contradiction",
            |rows| rows[2].selected = Some("M2-S2-T5-A3".into()),
            "r.csv: line 4: selected: `M2-S2-T5-A3`: the answer selects `M2-S2-",
        ),
        (
            "one stimulus",
            |rows| rows[2].stimulus_b = rows[2].stimulus_a.clone(),
            "r.csv: line 4: stimulus_b: `M2-S2-T3-A4`: another stimulus than stimulus_a",
        ),
        (
            "no time",
            |rows| rows[2].response_time_s = f64::NAN,
            "r.csv: line 4: response_time_s: NaN: a finite number",
        ),
        (
            "a machine posing as a person",
            |rows| rows[2].observer = "simulated:made-up".into(),
            "r.csv: line 4: observer: `simulated:made-up`: a real answer is given by a participant",
        ),
        (
            "only one set, and all of it practice",
            |rows| {
                rows.truncate(38);
                rows.iter_mut().for_each(|row| row.kind = TrialKind::Practice);
            },
            "r.csv: kind: no answer counts yet: 38 practice, 0 catch and 0 pilot rows: ",
        ),
    ];
    for (what, spoil, expect) in bad {
        let mut rows = real();
        spoil(&mut rows);
        let error = parse(&rows).unwrap_err().to_string();
        assert!(error.starts_with(expect), "{what} gave {error}");
    }
}

#[test]
fn two_folders_of_one_protocol_are_two_studies_and_who_is_missing_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let places = ["here", "there"].map(|name| folder.path().join(name));
    for place in &places {
        std::fs::create_dir_all(place.join("data")).unwrap();
        let file = "data/study-madeUp_subject-all_session-1_task-2afc_data.csv";
        std::fs::write(place.join(file), csv_text(&real())).unwrap();
        let codes: String = (1..=22).map(|code| format!("P{code:02},x\n")).collect();
        std::fs::write(place.join("participants.csv"), format!("subject,hand\n{codes}")).unwrap();
    }
    let read = responses::read(&places).unwrap().preferences().unwrap();
    let analysis = analyze(&read, 0.01).unwrap();
    assert_eq!(analysis.observers, 42);
    let groups = analysis.observer_groups.unwrap();
    assert!(groups.iter().any(|group| group.name == "study" && group.comparison.is_ok()));
    let note = |start: &str| analysis.notes.iter().any(|note| note.starts_with(start));
    assert!(note("Entered in participants.csv, but without answers that count: P22"));
    assert!(note("The studies share the codes P01, P02,"));
}

#[test]
fn the_responses_of_an_export_are_read_as_their_study_is() {
    let text = csv_text(&real());
    let exported: String = text
        .lines()
        .enumerate()
        .map(|(i, line)| format!("{},{line}\n", if i == 0 { "study_kind" } else { "real" }))
        .collect();
    let read = |text: &str| responses::parse(text, "r.csv").and_then(|read| read.preferences());
    assert_eq!(read(&exported).unwrap(), read(&text).unwrap());
}

#[test]
fn tables_of_other_programs_have_other_line_ends_and_a_mark_before_them() {
    let rows = real();
    let text = csv_text(&rows);
    let foreign = format!("\u{feff}{}", text.replace('\n', "\r\n"));
    let read = |text: &str| responses::parse(text, "r.csv").and_then(|read| read.preferences());
    assert_eq!(read(&foreign).unwrap(), read(&text).unwrap());
    let mut spoiled = rows;
    spoiled[3].trial = 3;
    let text = csv_text(&spoiled).replace('\n', "\r\n");
    let error = read(&text).unwrap_err().to_string();
    assert!(error.starts_with("r.csv: line 5: trial: "), "{error}");
    let votes = shutterlab_data_schema::Votes::parse("item,votes\r\nA,2\r\nB,x\r\n", "v.csv");
    assert!(votes.unwrap_err().to_string().contains("line 3"));
    let matrix = matrix::parse("\u{feff},A,B\r\nA,,1\r\nB,x,\r\n", 1, "m.csv").unwrap_err();
    assert!(matrix.to_string().starts_with("m.csv: line 3: "), "{matrix}");
}

#[test]
fn without_a_complete_set_every_choice_counts_and_words_say_what_does_not_follow() {
    let mut rows = real();
    rows.truncate(2 * 38);
    rows.remove(70);
    rows.remove(30);
    let analysis = analysis(&rows);
    assert_eq!((analysis.observers, analysis.trials), (2, 70));
    assert!(analysis.notes[0].starts_with("No observer chose in all 36 pairs"));
    assert!(analysis.grouping.unwrap_err().starts_with("scores can only be compared"));
    assert!(analysis.consistency.unwrap_err().starts_with("observers who chose in every pair"));
    assert_eq!(analysis.pairs.unwrap().len(), 36);
}

#[test]
fn a_design_of_some_pairs_has_complete_sets_of_those() {
    let one_step = |row: &Response| {
        let place = |id: &String| STIMULI.iter().position(|item| item == id).unwrap();
        place(&row.stimulus_a).abs_diff(place(&row.stimulus_b)) == 1
    };
    let rows: Vec<Response> = real().into_iter().filter(one_step).collect();
    let analysis = analysis(&rows);
    assert_eq!((analysis.observers, analysis.trials), (21, 21 * 8));
    assert_eq!(analysis.notes[0], "8 of the 36 pairs of 9 stimuli were compared.");
    assert!(analysis.consistency.is_err() && analysis.grouping.is_err());
    assert!(analysis.agreement.unwrap().p_exact.is_some());
}

#[test]
fn two_studies_of_the_same_stimuli_are_two_groups_of_people() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = real();
    let mono = folder.path().join("mono.csv");
    std::fs::write(&mono, csv_text(&rows)).unwrap();
    rows.iter_mut().for_each(|row| row.study = "stereo".into());
    let stereo = folder.path().join("stereo.csv");
    std::fs::write(&stereo, csv_text(&rows)).unwrap();
    let both = responses::read(&[&mono, &stereo]).unwrap().preferences().unwrap();
    assert_eq!(both.observers(), 42);
    rows.iter_mut().for_each(|row| {
        row.stimulus_a += "x";
        row.stimulus_b += "x";
        row.selected = row.selected.as_ref().map(|id| format!("{id}x"));
    });
    std::fs::write(&stereo, csv_text(&rows)).unwrap();
    let others = responses::read(&[&mono, &stereo]).unwrap().preferences().unwrap_err();
    assert!(others.to_string().contains("compare the same stimuli"), "{others}");
}

#[test]
fn torn_and_foreign_files_are_refused_by_name() {
    let text = csv_text(&real());
    let torn = &text[..text.len() - 100];
    let line = torn.lines().count();
    let foreign = text.replacen("stimulus_a", "stimulus_one", 1);
    let mistyped = text.replacen(",practice,", ",practise,", 1);
    for (text, expect) in [
        (torn, format!("r.csv: line {line}: row: ")),
        (&foreign, "r.csv: line 1: header: `stimulus_one`: unknown field `stimulus_one`".into()),
        (&mistyped, "r.csv: line 2: kind: `practise`: unknown variant `practise`".into()),
        ("item,votes\nA,1\n", "r.csv: line 1: header: `item`: unknown field `item`".into()),
        ("", "r.csv: line 1: header: an empty file: ".into()),
    ] {
        let error = responses::parse(text, "r.csv")
            .and_then(|read| read.preferences())
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(&expect), "{error}");
    }
    let error = responses::parse(torn, "r.csv").err().unwrap().to_string();
    assert!(error.ends_with("the file ends in the middle of a line"), "{error}");
}
