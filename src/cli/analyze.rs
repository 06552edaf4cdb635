//! `shutterlab analyze`: what the answers mean.

use super::{UsageError, say};
use shutterlab_analysis::input::{matrix, pwcmp, responses};
use shutterlab_analysis::paired::equivalence::DEFAULT_MARGIN;
use shutterlab_analysis::paired::{self, Options};
use shutterlab_analysis::report::{self, Document, ReportContext};
use shutterlab_analysis::{Analysis, InputError, Preferences, analyze};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use shutterlab_data_schema::{Protocol, Votes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Analyse the answers of a study, or a published table.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("input").required(true).args(["path", "votes", "matrix"]))]
pub struct Args {
    /// Study folders or responses CSVs (several are analysed together, and their observers compared), or a
    /// table of the pwcmp toolbox
    path: Vec<PathBuf>,
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
    /// Half width of the preferences around one half within which two stimuli count as equivalent
    #[arg(long, default_value_t = DEFAULT_MARGIN, value_parser = parse_margin)]
    margin: f64,
    /// Check the level of the groups by so many simulated studies of observers who guess
    #[arg(long, value_name = "STUDIES", value_parser = clap::value_parser!(u64).range(100..=1_000_000))]
    check_level: Option<u64>,
    /// Write report.html, the tables as CSV and the figures as SVG and PNG into this folder
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the analysis as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let options = Options { alpha: args.alpha, margin: args.margin, level_check: args.check_level };
    let compared = |preferences: &Preferences| {
        let analysis = paired::analyze(preferences, options)?;
        Ok::<_, InputError>(Analysis::PairedComparison(Box::new(analysis)))
    };
    let analysis = match (&args.votes, &args.matrix, args.observers, args.path.as_slice()) {
        (Some(file), _, Some(observers), _) => {
            let name = file.display().to_string();
            compared(&Preferences::from_votes(&Votes::read(file)?, observers, &name)?)?
        }
        (_, Some(file), Some(observers), _) => compared(&matrix::read(file, observers)?)?,
        (.., [file]) if is_pwcmp(file) => {
            let scenes = pwcmp::read(file)?.into_iter().map(|scene| {
                let name = [scene.name.as_str(), scene.criterion.as_str()].join(" ");
                Ok((name.trim().to_string(), compared(&scene.preferences()?)?))
            });
            return show_scenes(args, &scenes.collect::<anyhow::Result<Vec<_>>>()?);
        }
        (.., [_, ..]) => analyze(&responses::read(&args.path)?, options)?,
        _ => {
            return Err(UsageError::from(
                "analyze: PATH, or --votes or --matrix with --observers, is needed",
            ));
        }
    };
    if args.json {
        say(&serde_json::to_string_pretty(&analysis)?)?;
    } else {
        say(&report::text(&analysis.document()))?;
    }
    let Some(out) = &args.out else { return Ok(()) };
    let tables = args.votes.iter().chain(&args.matrix);
    let mut titles = Vec::new();
    let mut thumbnails = BTreeMap::new();
    for path in args.path.iter().chain(tables) {
        // A study has a title of its own, in the protocol that it was run with.
        let protocol = path.join("protocol.toml");
        titles.push(match protocol.exists() {
            true => Protocol::read(&protocol)?.title,
            false => path.display().to_string(),
        });
        thumbnails.extend(read_thumbnails(path)?);
    }
    let title = titles.join("; ");
    let page = write_report(&analysis.document(), out, &title, &thumbnails, &command())?;
    eprintln!("report: {}", page.display());
    Ok(())
}

/// Whether `file` is a table of pwcmp; a file that cannot be read is not, and is read again.
fn is_pwcmp(file: &Path) -> bool {
    std::fs::read_to_string(file).is_ok_and(|text| pwcmp::is_pwcmp(&text))
}

/// Shows one analysis per scene of a table that has several; reports lie in a folder each.
fn show_scenes(args: &Args, scenes: &[(String, Analysis)]) -> anyhow::Result<()> {
    if args.json {
        let by_name: BTreeMap<&String, &Analysis> =
            scenes.iter().map(|(name, analysis)| (name, analysis)).collect();
        say(&serde_json::to_string_pretty(&by_name)?)?;
    }
    for (name, analysis) in scenes {
        if !args.json {
            say(&format!("== {name}\n{}\n", report::text(&analysis.document())))?;
        }
        if let Some(out) = &args.out {
            let folder = name.replace(|c: char| !c.is_alphanumeric(), "-");
            let (document, none) = (analysis.document(), BTreeMap::new());
            let page = write_report(&document, &out.join(folder), name, &none, &command())?;
            eprintln!("report: {}", page.display());
        }
    }
    Ok(())
}

/// The command line, as it was given.
fn command() -> String {
    let words = std::env::args_os().map(|arg| arg.to_string_lossy().into_owned());
    words.collect::<Vec<_>>().join(" ")
}

/// Writes the report, its tables and its figures into `out` and returns the page's path.
pub(super) fn write_report(
    document: &Document,
    out: &Path,
    title: &str,
    thumbnails: &BTreeMap<String, Vec<u8>>,
    command: &str,
) -> anyhow::Result<PathBuf> {
    create_folder(&out.join("figures"))?;
    // What an earlier report left here would be taken for this one's.
    for package in ["datapackage.json", "simulated-datapackage.json"].map(|name| out.join(name)) {
        let text = std::fs::read_to_string(&package).unwrap_or_default();
        let names = report::files_of(&text);
        if !names.is_empty() {
            // What is gone already needs no removal.
            names.iter().for_each(|name| _ = std::fs::remove_file(out.join(name)));
            _ = std::fs::remove_file(package);
        }
    }
    for (name, bytes) in report::files(document) {
        write_atomically(&out.join(name), &bytes)?;
    }
    let context = ReportContext { title, thumbnails, command, version: env!("CARGO_PKG_VERSION") };
    let page = out.join("report.html");
    write_atomically(&page, report::html(document, &context).as_bytes())?;
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

fn parse_margin(text: &str) -> Result<f64, String> {
    let margin = text.parse().ok().filter(|margin| (0.001..=0.499).contains(margin));
    margin.ok_or("a number from 0.001 to 0.499 is needed".into())
}
