//! `export`: what other programs make of a study.

use crate::support::{fail, guess, read_table, skip, succeed, tree};
use crate::validators::{errors, frictionless, is_psych_ds_name, program};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A folder with a study of two simulated observers, and its export as `format` in `out`.
fn exported(format: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for code in ["S01", "S02"] {
        succeed(folder.path(), &guess("study", code));
    }
    let said = succeed(folder.path(), &["export", "study/simulated", "--to", format, "-o", "out"]);
    assert_eq!(
        said,
        "SIMULATED OBSERVERS: a check of the tool, never a finding\n\
         2 sessions with 76 answers (4 practice, 72 simulated), of which 72 count, in out\n"
    );
    folder
}

/// What `program` says, which must succeed.
fn run(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(program).args(arguments).current_dir(folder).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn tables_are_a_valid_data_package() {
    let Some(program) = frictionless() else { return };
    let folder = exported("csv");
    let out = folder.path().join("out");
    assert_eq!(errors(&program, &out, 4), BTreeSet::new());
    let file = out.join("responses.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replacen("simulated,true,", "simulated,maybe,", 1)).unwrap();
    assert_eq!(errors(&program, &out, 4), BTreeSet::from(["type-error".into()]));
}

/// pandas has every column with the type and the levels that the codebook says.
#[test]
fn pandas_loads_the_tables_with_types_and_levels() {
    let python = "SHUTTERLAB_PYTHON";
    let Some(program) = program(python, "python3", "SHUTTERLAB_REQUIRE_VALIDATORS") else { return };
    let has_pandas = Command::new(&program).args(["-c", "import pandas"]).output().unwrap();
    if !has_pandas.status.success() {
        return skip("SHUTTERLAB_REQUIRE_VALIDATORS", "python has no pandas");
    }
    let folder = exported("csv");
    let out = folder.path().join("out");
    // From another folder, as the script has to find the tables.
    let said = run(&program, &["out/load.py"], folder.path());
    assert!(said.starts_with("answers: simulated\nresponses: 76 rows, 65 columns ("), "{said}");
    assert!(said.contains("\nstimuli: 9 rows, 6 columns ("), "{said}");

    let script = "import json, load
tables = {n + '.csv': getattr(load, n) for n in ['responses', 'participants', 'stimuli']}
print(json.dumps({n: {c: [str(d), list(getattr(d, 'categories', []))] for c, d in t.dtypes.items()}
    for n, t in tables.items()}))
r = load.responses
print(json.dumps([int(r.response_time_s.gt(0).sum()), int(r.counts.sum()), str(r.answered_at.min()),
    r.attrs['units']['response_time_s'], r.attrs['levels']['answer']['first'],
    str(load.participants.seed[0])]))";
    let said = run(&program, &["-c", script], &out);
    let (types, values) = said.split_once('\n').unwrap();
    let types: BTreeMap<String, BTreeMap<String, (String, Vec<String>)>> =
        serde_json::from_str(types).unwrap();
    let codebook = read_table(&out.join("codebook.csv"));
    for about in &codebook {
        let (kind, categories) = &types[&about["file"]][&about["variable"]];
        let levels: Vec<&str> = about["levels"].lines().collect();
        assert_eq!(*categories, levels, "{about:?}");
        let expected = match (levels.is_empty(), about["type"].as_str()) {
            (false, _) => "category",
            (_, "string") => "string",
            (_, "integer") => "Int64",
            (_, "number") => "float64",
            (_, "boolean") => "boolean",
            _ => "datetime64[us, UTC]",
        };
        assert_eq!(kind, expected, "{about:?}");
    }
    let values: Value = serde_json::from_str(values).unwrap();
    let rows = read_table(&out.join("responses.csv"));
    let first = rows.iter().map(|row| &row["answered_at"]).min().unwrap();
    let first = first.replace('T', " ").replace('Z', "+00:00");
    let later = rows.iter().filter(|row| !row["response_time_s"].starts_with('-')).count();
    let label = "The sequence shown first, or the candidate on the left.";
    let seed = &read_table(&out.join("participants.csv"))[0]["seed"];
    let expected = serde_json::json!([later, 72, first, "s", label, seed]);
    assert_eq!(values, expected);
    // What Python compiled beside the tables does not stand in the way of the next export.
    succeed(folder.path(), &["export", "study/simulated", "--to", "csv", "-o", "out"]);
}

/// R has every column with the type and the levels that the codebook says.
#[test]
fn r_loads_the_tables_with_types_and_levels() {
    let Some(program) = program("SHUTTERLAB_RSCRIPT", "Rscript", "SHUTTERLAB_REQUIRE_R") else {
        return;
    };
    let folder = exported("csv");
    let out = folder.path().join("out");
    let said = run(&program, &["out/load.R"], folder.path());
    assert!(said.starts_with("answers: simulated \nresponses: 76 rows, 65 columns ("), "{said}");
    let script = "invisible(capture.output(source('out/load.R')))
for (name in c('responses', 'participants', 'stimuli')) for (column in names(get(name))) {
  x <- get(name)[[column]]
  stopifnot(nchar(attr(x, 'label')) > 0, identical(unname(attr(x, 'labels')), levels(x)))
  cat(name, '.csv|', column, '|', class(x)[1], '|', paste(levels(x), collapse = ';'), '\\n', sep = '')
}
cat(sum(responses$counts), attr(responses$response_time_s, 'unit'),
    format(min(responses$answered_at), '%Y-%m-%dT%H:%M:%S'), participants$seed[1])";
    let said = run(&program, &["-e", script], folder.path());
    let mut lines = said.lines();
    for about in &read_table(&out.join("codebook.csv")) {
        let levels = about["levels"].replace('\n', ";");
        let kind = match (levels.is_empty(), about["type"].as_str()) {
            (false, _) => "factor",
            // More digits than a number of R keeps.
            (_, "integer") if about["variable"] == "seed" => "character",
            (_, "integer") => "integer",
            (_, "number") => "numeric",
            (_, "boolean") => "logical",
            (_, "datetime") => "POSIXct",
            _ => "character",
        };
        let expected = format!("{}|{}|{kind}|{levels}", about["file"], about["variable"]);
        assert_eq!(lines.next().unwrap(), expected);
    }
    let rows = read_table(&out.join("responses.csv"));
    let first = rows.iter().map(|row| &row["answered_at"]).min().unwrap();
    let seed = &read_table(&out.join("participants.csv"))[0]["seed"];
    assert_eq!(lines.next().unwrap(), format!("72 s {} {seed}", &first[..19]));
}

/// The validator of BIDS finds no fault, and misses only what no study knows of its laboratory.
#[test]
fn bids_is_valid() {
    let (variable, name) = ("SHUTTERLAB_BIDS_VALIDATOR", "bids-validator-deno");
    let Some(program) = program(variable, name, "SHUTTERLAB_REQUIRE_VALIDATORS") else { return };
    let folder = exported("bids");
    let issues = |expect_success: bool| -> BTreeSet<(String, String)> {
        let output = Command::new(&program)
            .args(["--format", "json", "out"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.success(), expect_success);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let text = |issue: &Value, key: &str| issue[key].as_str().unwrap_or_default().to_string();
        let issues = report["issues"]["issues"].as_array().unwrap().iter();
        issues.map(|issue| (text(issue, "code"), text(issue, "subCode"))).collect()
    };
    let unknown = [
        ("JSON_KEY_RECOMMENDED", "HEDVersion"),
        ("JSON_KEY_RECOMMENDED", "License"),
        ("JSON_KEY_RECOMMENDED", "SourceDatasets"),
        ("NO_AUTHORS", "Authors"),
        ("SIDECAR_KEY_RECOMMENDED", "CogAtlasID"),
        ("SIDECAR_KEY_RECOMMENDED", "CogPOID"),
        ("SIDECAR_KEY_RECOMMENDED", "InstitutionAddress"),
        ("SIDECAR_KEY_RECOMMENDED", "InstitutionName"),
        ("SIDECAR_KEY_RECOMMENDED", "InstitutionalDepartmentName"),
        ("TOO_FEW_AUTHORS", ""),
    ];
    let unknown = unknown.map(|(code, key)| (code.to_string(), key.to_string()));
    assert_eq!(issues(true), BTreeSet::from(unknown));
    std::fs::rename(folder.path().join("out/sub-S02"), folder.path().join("out/sub-S99")).unwrap();
    assert!(issues(false).iter().any(|(code, _)| code == "PARTICIPANT_ID_MISMATCH"));
}

/// What Psych-DS asks of a dataset: its files, names of data files by keywords and values, every column
/// described, in the words of schema.org.
#[test]
fn psych_ds_has_every_column_described() {
    let folder = exported("psych-ds");
    let out = folder.path().join("out");
    for name in ["README.md", "CHANGES.md", "materials/protocol.toml"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    let text = std::fs::read_to_string(out.join("dataset_description.json")).unwrap();
    let description: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(description["@context"], "https://schema.org/");
    assert_eq!(description["@type"], "Dataset");
    let known = ["@context", "@type", "name", "description", "variableMeasured"];
    assert!(description.as_object().unwrap().keys().eq(known));
    let mut declared = BTreeSet::new();
    for variable in description["variableMeasured"].as_array().unwrap() {
        assert_eq!(variable["@type"], "PropertyValue");
        assert!(!variable["description"].as_str().unwrap().is_empty(), "{variable}");
        let known = ["@type", "name", "description", "unitText", "valueReference"];
        assert!(variable.as_object().unwrap().keys().all(|key| known.contains(&key.as_str())));
        for level in variable["valueReference"].as_array().into_iter().flatten() {
            assert_eq!(level["@type"], "PropertyValue");
            assert!(level["value"].is_string() && level["description"].is_string(), "{level}");
        }
        declared.insert(variable["name"].as_str().unwrap().to_string());
    }
    let mut data_files = 0;
    for name in tree(&out).into_keys().filter(|name| name.starts_with("data")) {
        let file_name = name.file_name().unwrap().to_str().unwrap();
        assert!(is_psych_ds_name(file_name) && file_name.contains("simulated"), "{file_name}");
        let rows = read_table(&out.join(&name));
        assert!(rows[0].keys().eq(&declared), "{file_name}");
        data_files += 1;
    }
    assert_eq!(data_files, 2);
    let Some(program) = frictionless() else { return };
    assert_eq!(errors(&program, &out, 3), BTreeSet::new());
}

#[test]
fn what_cannot_be_exported_is_refused_by_name() {
    let folder = exported("pwcmp");
    let rows = read_table(&folder.path().join("out/pwcmp.csv"));
    assert_eq!(rows.len(), 72);
    assert!(
        rows.iter().all(|row| row["scene"] == "M2-S2" && row["criterion"].contains("SIMULATED"))
    );
    let export = |study, out| ["export", study, "--to", "csv", "-o", out];
    assert_eq!(
        fail(folder.path(), 1, &export("study/simulated", "out")),
        "error: out: not empty, and no earlier export of this study in this format; choose another folder"
    );
    let error = fail(folder.path(), 1, &export("study", "new"));
    assert!(error.ends_with("no folder `data`; there is one in study/simulated"), "{error}");
    assert!(!folder.path().join("new").exists());
    let error = fail(folder.path(), 2, &["export", "study", "--to", "spss", "-o", "new"]);
    assert!(error.contains("csv, bids, psych-ds, pwcmp"), "{error}");
}
