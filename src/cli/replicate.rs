//! `shutterlab replicate`: what was published, and what its votes give.

use super::say;
use shutterlab_analysis::replication::{NAMES, replicate, text};

/// Print what was published of an experiment beside what its printed votes give, line by line.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The published experiment
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(NAMES))]
    name: String,
    /// Print the lines as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let replication = replicate(&args.name)?;
    match args.json {
        true => say(&serde_json::to_string_pretty(&replication)?),
        false => say(&text(&replication)),
    }
}
