//! What `shutterlab screen` says about pairs of sequences, as differences.

use super::model::Between;
use crate::stimuli_set::StimulusSet;
use shutterlab_data_schema::cohort::Measure;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The differences in one column of a `screen.csv`.
#[derive(Clone, Debug)]
pub(super) struct Differences {
    pub file: PathBuf,
    /// By the sequences' hashes, in both orders.
    by_hashes: HashMap<[String; 2], f64>,
}

impl Differences {
    /// Reads the column of `measure`.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn read(file: &Path, measure: Measure) -> Result<Self, String> {
        let text = std::fs::read_to_string(file).map_err(|e| format!("cannot be read: {e}"))?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let headers = reader.headers().map_err(|e| e.to_string())?.clone();
        let column = match measure {
            Measure::CvvdpJod => "cvvdp_jod",
            Measure::FlipMean => "flip_mean",
            Measure::PsnrDb => "psnr_db",
        };
        let place = |name: &str| {
            let found = headers.iter().position(|header| header == name);
            found.ok_or_else(|| {
                format!(
                    "column `{name}` is missing: a file that `shutterlab screen` wrote is needed"
                )
            })
        };
        let places = (place("reference_sha256")?, place("test_sha256")?, place(column)?);
        let mut by_hashes = HashMap::new();
        for record in reader.records() {
            let record = record.map_err(|e| e.to_string())?;
            let line = record.position().map_or(0, csv::Position::line);
            let (a, b, value) = (&record[places.0], &record[places.1], &record[places.2]);
            let parsed = value.parse().ok().and_then(|value| difference(measure, value));
            let difference = parsed.ok_or_else(|| {
                let allowed = match measure {
                    Measure::CvvdpJod => "a number up to 10",
                    Measure::FlipMean => "a number from 0 to 1",
                    Measure::PsnrDb => "a number from 0, or inf",
                };
                format!("line {line}: {column}: {value}: {allowed} is needed")
            })?;
            by_hashes.insert([a.to_string(), b.to_string()], difference);
            by_hashes.insert([b.to_string(), a.to_string()], difference);
        }
        Ok(Self { file: file.into(), by_hashes })
    }

    /// The differences of the compared stimuli of `set`; each differs by 0 from itself. Pairs that are not `asked` need
    /// not be in the file: nothing asks for how they differ, which is no number then.
    ///
    /// # Errors
    /// Two stimuli, as they are now, are not in the file.
    pub fn between(
        &self,
        set: &StimulusSet,
        asked: impl Fn(usize, usize) -> bool,
    ) -> Result<Between, String> {
        let count = set.compared;
        let hash = |index: usize| set.sequences[index].manifest.sha256.clone();
        let mut differences = Vec::with_capacity(count * count);
        for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
            let known = self.by_hashes.get(&[hash(a), hash(b)]).copied();
            let found = match known {
                _ if a == b => Some(0.0),
                None if !asked(a, b) => Some(f64::NAN),
                known => known,
            };
            differences.push(found.ok_or_else(|| {
                let (a, b) = (&set.stimulus(a).id, &set.stimulus(b).id);
                format!(
                    "{a}, {b}: there is no row with the hashes of these two sequences; run \
                     `shutterlab screen` on their folder"
                )
            })?);
        }
        Ok(Between { count, differences })
    }
}

/// What a value of `measure` says, if it is one.
fn difference(measure: Measure, value: f64) -> Option<f64> {
    let difference = match measure {
        Measure::CvvdpJod => 10.0 - value,
        Measure::FlipMean => value,
        Measure::PsnrDb => 10_f64.powf(-value / 20.0),
    };
    let most = if measure == Measure::CvvdpJod { f64::MAX } else { 1.0 };
    (0.0..=most).contains(&difference).then_some(difference)
}
