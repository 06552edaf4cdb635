//! `shutterlab export`: a study for other tools.

use super::analyze::read_thumbnails;
use super::say;
use shutterlab_analysis::export::{Format, Study, export};
use std::path::PathBuf;

/// Export the answers of a study for other tools.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the study
    study: PathBuf,
    /// csv: tables, a codebook, and scripts for R and pandas; bids, psych-ds: datasets of these
    /// standards; pwcmp: the table of choices that pwcmp scales
    #[arg(long, value_name = "FORMAT")]
    to: To,
    /// Folder of the export; an earlier export of the same study is replaced
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum To {
    Csv,
    Bids,
    PsychDs,
    Pwcmp,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let format = match args.to {
        To::Csv => Format::Csv,
        To::Bids => Format::Bids,
        To::PsychDs => Format::PsychDs,
        To::Pwcmp => Format::Pwcmp,
    };
    let study = Study::read(&args.study, read_thumbnails(&args.study)?)?;
    let export = export(&study, format)?;
    export.write(&args.out)?;
    for note in &export.notes {
        eprintln!("note: {note}");
    }
    say(&format!("{}, in {}", export.summary, args.out.display()))
}
