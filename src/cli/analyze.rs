//! `shutterlab analyze`: what the answers mean.

use super::{UsageError, say};
use shutterlab_analysis::report::{self, ReportContext};
use shutterlab_analysis::{Analysis, Preferences, analyze, matrix, responses};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use shutterlab_data_schema::{Protocol, Votes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Analyse the answers of a study, or a published table.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("input").required(true).args(["path", "votes", "matrix"]))]
pub struct Args {
    /// A study folder or a responses CSV
    path: Option<PathBuf>,
    /// A table of votes (CSV with the columns item and votes) in place of answers
    #[arg(long, value_name = "FILE", requires = "observers")]
    votes: Option<PathBuf>,
    /// A preference matrix (CSV: row chosen over column, with header row and column)
    #[arg(long, value_name = "FILE", requires = "observers")]
    matrix: Option<PathBuf>,
    /// How many observers judged every pair of the table
    #[arg(long, value_name = "N", conflicts_with = "path")]
    observers: Option<u64>,
    /// Level of significance of the groups
    #[arg(long, default_value_t = 0.01, value_parser = parse_alpha)]
    alpha: f64,
    /// Write report.html and the tables as CSV into this folder
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the analysis as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let preferences = match (&args.path, &args.votes, &args.matrix, args.observers) {
        (Some(path), ..) => responses::read(path)?,
        (_, Some(file), _, Some(observers)) => {
            Preferences::from_votes(&Votes::read(file)?, observers, &file.display().to_string())?
        }
        (_, _, Some(file), Some(observers)) => matrix::read(file, observers)?,
        _ => {
            return Err(UsageError::from(
                "analyze: PATH, or --votes or --matrix with --observers, is needed",
            ));
        }
    };
    let analysis = analyze(&preferences, args.alpha)?;
    if args.json {
        say(&serde_json::to_string_pretty(&analysis)?)?;
    } else {
        say(&report::text(&analysis))?;
    }
    if let Some(out) = &args.out {
        let command = std::env::args_os()
            .map(|arg| arg.to_string_lossy().into_owned())
            .collect::<Vec<_>>()
            .join(" ");
        let title = args.path.as_deref().or(args.votes.as_deref()).or(args.matrix.as_deref());
        let title = title.map_or(String::new(), |path| path.display().to_string());
        // A study has a title of its own, in the protocol that it was run with.
        let protocol = args.path.as_ref().map(|path| path.join("protocol.toml"));
        let title = match protocol.filter(|file| file.exists()) {
            Some(file) => Protocol::read(&file)?.title,
            None => title,
        };
        let thumbnails = args.path.as_deref().map_or(Ok(BTreeMap::new()), read_thumbnails)?;
        let page = write_report(&analysis, out, &title, &thumbnails, &command)?;
        eprintln!("report: {}", page.display());
    }
    Ok(())
}

/// Writes the report and its tables into `out` and returns the page's path.
pub(super) fn write_report(
    analysis: &Analysis,
    out: &Path,
    title: &str,
    thumbnails: &BTreeMap<String, Vec<u8>>,
    command: &str,
) -> anyhow::Result<PathBuf> {
    create_folder(out)?;
    for (name, text) in report::tables(analysis) {
        write_atomically(&out.join(name), text.as_bytes())?;
    }
    let context = ReportContext { title, thumbnails, command, version: env!("CARGO_PKG_VERSION") };
    let page = out.join("report.html");
    write_atomically(&page, report::html(analysis, &context).as_bytes())?;
    Ok(page)
}

/// The thumbnails of a study, by stimulus id; none, if `path` is no study.
pub(super) fn read_thumbnails(path: &Path) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let folder = path.join("thumbnails");
    let mut thumbnails = BTreeMap::new();
    if folder.is_dir() {
        for entry in std::fs::read_dir(&folder).map_err(|e| named(&folder, &e))? {
            let file = entry?.path();
            if let (Some(id), Some("png")) =
                (file.file_stem(), file.extension().and_then(|e| e.to_str()))
            {
                let png = std::fs::read(&file).map_err(|e| named(&file, &e))?;
                thumbnails.insert(id.to_string_lossy().into_owned(), png);
            }
        }
    }
    Ok(thumbnails)
}

fn parse_alpha(text: &str) -> Result<f64, String> {
    let alpha = text.parse().ok().filter(|alpha| (1e-6..=0.5).contains(alpha));
    alpha.ok_or("a number from 0.000001 to 0.5 is needed".into())
}
