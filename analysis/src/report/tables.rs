//! The results as CSV, with full stimulus ids and unrounded numbers.

use super::labels::letters;
use crate::analysis::Analysis;
use crate::preference::Proportion;

/// File names and texts of the tables, whose names begin with `simulated-` where the observers were
/// simulated: `stimuli.csv` always; `pairs.csv`, `matrix.csv` and
/// `observers.csv` where they are known.
pub fn tables(analysis: &Analysis) -> Vec<(String, String)> {
    let mut tables = vec![("stimuli.csv".to_string(), stimuli(analysis))];
    if let Some(pairs) = &analysis.pairs {
        let mut header = vec!["item".to_string(), "over".into()];
        header.extend(SHARE_COLUMNS.map(str::to_string));
        let rows = pairs.iter().map(|pair| {
            let mut row = vec![pair.item.clone(), pair.over.clone()];
            row.extend(share(&pair.proportion));
            row
        });
        tables.push(("pairs.csv".into(), csv_text(header, rows)));
    }
    if let Some(matrix) = &analysis.matrix {
        let mut header = vec!["chosen over".to_string()];
        header.extend(analysis.items.iter().cloned());
        let rows = analysis.items.iter().zip(matrix).map(|(item, counts)| {
            let mut row = vec![item.clone()];
            row.extend(counts.iter().map(ToString::to_string));
            row
        });
        tables.push(("matrix.csv".into(), csv_text(header, rows)));
    }
    if let Some(consistency) = &analysis.consistency {
        let header = ["subject", "session", "repetition", "circular_triads", "zeta", "p", "exact"];
        let rows = consistency.per_observer.iter().map(|observer| {
            vec![
                observer.subject.clone(),
                observer.session.to_string(),
                observer.repetition.to_string(),
                observer.circular_triads.to_string(),
                observer.zeta.to_string(),
                observer.p.csv(),
                observer.exact.to_string(),
            ]
        });
        let header = header.map(str::to_string).to_vec();
        tables.push(("observers.csv".into(), csv_text(header, rows)));
    }
    if analysis.simulated == Some(true) {
        tables.iter_mut().for_each(|(name, _)| name.insert_str(0, "simulated-"));
    }
    tables
}

fn stimuli(analysis: &Analysis) -> String {
    let mut header = vec!["item".to_string(), "groups".into()];
    header.extend(SHARE_COLUMNS.map(str::to_string));
    let rows = analysis.preference.iter().map(|preference| {
        let groups = match &analysis.grouping {
            Some(grouping) => letters(&preference.item, &grouping.groups),
            None => String::new(),
        };
        let mut row = vec![preference.item.clone(), groups];
        row.extend(share(&preference.proportion));
        row
    });
    csv_text(header, rows)
}

const SHARE_COLUMNS: [&str; 11] = [
    "chosen",
    "trials",
    "percent",
    "wilson_95_low",
    "wilson_95_high",
    "clopper_pearson_95_low",
    "clopper_pearson_95_high",
    "chi2",
    "df",
    "p_chi2",
    "p_binomial",
];

fn share(share: &Proportion) -> [String; 11] {
    [
        share.chosen.to_string(),
        share.trials.to_string(),
        share.percent.to_string(),
        share.wilson_95[0].to_string(),
        share.wilson_95[1].to_string(),
        share.clopper_pearson_95[0].to_string(),
        share.clopper_pearson_95[1].to_string(),
        share.chi2.to_string(),
        share.df.to_string(),
        share.p_chi2.csv(),
        share.p_binomial.csv(),
    ]
}

fn csv_text(header: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut bytes = Vec::new();
    {
        let mut writer = csv::Writer::from_writer(&mut bytes);
        // Writing to memory cannot fail, and every row has the fields of its header.
        let _ = writer.write_record(header);
        for row in rows {
            let _ = writer.write_record(row);
        }
        let _ = writer.flush();
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
