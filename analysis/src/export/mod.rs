//! A study for other tools: tables with a codebook and scripts that load them, BIDS, Psych-DS, pwcmp.
//!
//! [`Study::read`] reads and checks a study folder, [`export`] makes the files of a format from it, and
//! [`Export::write`] puts them in place, all or none. All answers are kept, of practice, catch and
//! pilot trials too, and say what they are. Exports of simulated answers say so in every file.
//! Participants are codes, as in the study.

mod bids;
mod folder;
mod psych_ds;
mod pwcmp;
mod readme;
mod stimuli;
mod study;
mod table;
mod tables;

pub use study::Study;

use crate::error::InputError;

/// What an export is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Tables as CSV, a codebook, and scripts for R and pandas.
    Csv,
    /// A dataset in the Brain Imaging Data Structure, of behaviour only.
    Bids,
    /// A Psych-DS dataset.
    PsychDs,
    /// The table of choices that pwcmp scales.
    Pwcmp,
}

impl Format {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Bids => "bids",
            Self::PsychDs => "psych-ds",
            Self::Pwcmp => "pwcmp",
        }
    }
}

/// The files of an export.
#[derive(Clone, Debug)]
pub struct Export {
    /// By path in the export, with `/` between folders.
    files: Vec<(String, Vec<u8>)>,
    /// The line of the README that tells an export of this study in this format from everything else.
    mark: String,
    /// Whose and how many answers it is made from.
    pub summary: String,
    /// What was left out, and what else the reader has to know.
    pub notes: Vec<String>,
}

/// The export of `study` in `format`.
///
/// # Errors
/// The format cannot hold the study.
pub fn export(study: &Study, format: Format) -> Result<Export, InputError> {
    let mut notes = study.notes.clone();
    let mut files = match format {
        Format::Csv => tables::files(study),
        Format::Bids => bids::files(study),
        Format::PsychDs => psych_ds::files(study),
        Format::Pwcmp => pwcmp::files(study, &mut notes)?,
    };
    files.push(("README.md".into(), readme::text(study, format, &notes).into_bytes()));
    let banner = study.kind.banner().map_or(String::new(), |banner| format!("{banner}\n"));
    let summary = banner + &readme::summary(study);
    Ok(Export { files, mark: readme::mark(study, format), summary, notes })
}

/// A file of JSON.
fn json(path: &str, value: &serde_json::Value) -> (String, Vec<u8>) {
    (path.into(), format!("{value:#}\n").into_bytes())
}
