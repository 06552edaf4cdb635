//! `shutterlab withdraw`: takes a participant out of a study.

use super::{counted, say};
use anyhow::bail;
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_experiments::record::study::Study;
use std::path::PathBuf;

/// Take a participant out of a study: remove the answers, the record and the journals. That cannot be
/// undone. What stays is the code, which is not used again, and how much was removed when.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The participant's code
    code: ParticipantCode,
    /// Folder of the study
    #[arg(long, value_name = "DIR")]
    study: PathBuf,
    /// Out of the study's pilot
    #[arg(long)]
    pilot: bool,
    /// Do not ask for the code once more
    #[arg(long)]
    yes: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let kind = if args.pilot { StudyKind::Pilot } else { StudyKind::Real };
    let study = Study::existing(&args.study, kind)?;
    let folder = study.folder().display();
    if !args.yes {
        eprintln!(
            "all answers of {} in {folder} will be removed for ever; type the code to go on:",
            args.code
        );
        let mut typed = String::new();
        std::io::stdin().read_line(&mut typed)?;
        if typed.trim() != args.code.to_string() {
            bail!(
                "withdraw: {:?} was typed, {} is needed; nothing was removed",
                typed.trim(),
                args.code
            );
        }
    }
    let gone = study.withdraw(&args.code)?;
    let answers = counted(gone.rows as usize, "answer");
    let files = counted(gone.files as usize, "file");
    say(&format!(
        "{}: withdrawn; {answers} in {files} removed, noted in {folder}/log/withdrawn.csv",
        args.code
    ))
}
