//! `shutterlab fit`: the parameters of the papers and psychometric functions, from new answers.

mod frequencies;

use super::analyze::write_report;
use super::{UsageError, say};
use anyhow::{anyhow, bail};
use shutterlab_analysis::input::responses;
use shutterlab_analysis::maths::bootstrap::REPLICATES;
use shutterlab_analysis::psychometric;
use shutterlab_analysis::psychometric::function::{MOST_LAPSES, Model, Rate, Shape};
use shutterlab_analysis::ratings::answers::Ratings;
use shutterlab_analysis::ratings::law::{Refit, Setting, from_points, from_ratings};
use shutterlab_analysis::ratings::level_of_detail::{Rule, coarsest_levels};
use shutterlab_analysis::ratings::points::Frequencies;
use shutterlab_analysis::ratings::table;
use shutterlab_analysis::ratings::{analysis::analyze, law_section, section};
use shutterlab_analysis::report::{self, Document};
use shutterlab_data_schema::files::write_atomically;
use shutterlab_data_schema::fitted::{FittedTo, FrequencyUnit, VelocityUnit, Weight};
use shutterlab_data_schema::{FittedParameters, Response};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What the resamples of a fit follow from.
const SEED: u64 = 1;

/// Fit the parameters of simplification, or a psychometric function.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// The exponent r of the weight: with which r most images look like the original
    R(R),
    /// The law of the level of detail, ρ = 1/(σ₁v + σ₂)
    Lod(Lod),
    /// A psychometric function and its threshold
    Psychometric(Psychometric),
}

/// How results are given.
#[derive(Debug, clap::Args)]
struct Output {
    /// Write a report, its tables as CSV and its figures as SVG and PNG into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
struct R {
    /// A study folder, a responses CSV, or a table of ratings
    /// (CSV model,r,level_of_detail,speed,same,different)
    path: PathBuf,
    /// The unit of the speeds of a table of ratings
    #[arg(long, value_name = "UNIT", value_parser = parse_velocity)]
    velocity_unit: Option<VelocityUnit>,
    /// The constant ε that the rated models were simplified with, for FILE; it is not fitted
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_from_0)]
    epsilon: Option<f64>,
    /// Write r into this file, which `simplify` reads
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("input").required(true).args(["path", "points"]))]
struct Lod {
    /// A study folder, a responses CSV, or a table of ratings
    /// (CSV model,r,level_of_detail,speed,same,different, perhaps with frequency)
    path: Option<PathBuf>,
    /// The points themselves: a CSV speed,frequency, perhaps with model
    #[arg(long, value_name = "FILE", conflicts_with = "frequencies")]
    points: Option<PathBuf>,
    /// The spatial frequencies of the rated models: a CSV model,level_of_detail,frequency
    #[arg(long, value_name = "FILE")]
    frequencies: Option<PathBuf>,
    /// The rendered stimuli of the study, whose simplified models are measured for their spatial frequencies
    #[arg(long, value_name = "DIR", conflicts_with_all = ["frequencies", "points"])]
    stimuli: Option<PathBuf>,
    /// Ratings of models simplified with this r only; beside points, the r that they are of
    #[arg(long, value_name = "R", value_parser = parse_from_0)]
    r: Option<f64>,
    /// How the coarsest level is found: a function through the ratings, or the papers' rule on points
    #[arg(long, default_value = "smoothed", value_parser = parse_rule, conflicts_with = "points")]
    rule: Rule,
    /// The unit of the speeds: pixels-per-shutter, degrees-per-shutter or degrees-per-second (a
    /// study's are in degrees per second)
    #[arg(long, value_name = "UNIT", value_parser = parse_velocity)]
    velocity_unit: Option<VelocityUnit>,
    /// The unit of the frequencies: per-perimeter-pixel or per-perimeter-degree
    #[arg(long, value_name = "UNIT", value_parser = parse_frequency)]
    frequency_unit: FrequencyUnit,
    /// The constant ε that the rated models were simplified with, for FILE; it is not fitted
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_from_0)]
    epsilon: Option<f64>,
    /// Write the law into this file, which `simplify` reads
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, clap::Args)]
struct Psychometric {
    /// A CSV level,chosen,trials, with a column observer if each has rows of their own
    table: PathBuf,
    /// Form of the function
    #[arg(long, default_value = "logistic", value_parser = parse_shape)]
    shape: Shape,
    /// Guess rate: 0 for yes and no, 1/m for a choice among m
    #[arg(long, value_name = "G", default_value_t = 0.0, value_parser = parse_rate)]
    guess: f64,
    /// Lapse rate: a number, or `fit` for one from 0 to 0.06
    #[arg(long, value_name = "L", default_value = "0", value_parser = parse_lapse)]
    lapse: Rate,
    /// The chance of the answer at the threshold
    #[arg(long, value_name = "P", default_value_t = 0.8, value_parser = parse_rate)]
    threshold: f64,
    #[command(flatten)]
    output: Output,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::R(args) => fit_r(args),
        What::Lod(args) => fit_lod(args),
        What::Psychometric(args) => fit_psychometric(args),
    }
}

fn fit_r(args: &R) -> anyhow::Result<()> {
    let (ratings, _) = read_ratings(&args.path, args.velocity_unit)?;
    let analysis = analyze(&ratings, REPLICATES as usize, SEED);
    let lead = format!("The exponent r by {}", args.path.display());
    let simulated = analysis.simulated == Some(true);
    let document = Document::of(lead, simulated, vec![section::section(&analysis)]);
    give(&args.output, &document, &args.path, &analysis)?;
    let Some(out) = &args.out else { return Ok(()) };
    let r = analysis.histogram.chosen.as_ref().map_err(|reason| unwritten(out, reason))?;
    let bin = analysis.histogram.bins.iter().find(|bin| bin.r == *r);
    let images = analysis.histogram.bins.iter().map(|bin| bin.images).sum();
    write(
        out,
        FittedParameters {
            weight: Some(Weight {
                r: *r,
                share_won: bin.and_then(|bin| bin.won),
                epsilon: args.epsilon,
            }),
            ..fitted(&args.path, analysis.observers, ratings.models(), images, analysis.simulated)
        },
    )
}

fn fit_lod(args: &Lod) -> anyhow::Result<()> {
    let (path, (refit, epsilon)) = match (&args.points, &args.path) {
        (Some(points), _) => (points, (refit_of_points(args, points)?, args.epsilon)),
        (_, Some(path)) => (path, refit_of_ratings(args, path)?),
        _ => return Err(UsageError::from("fit lod: PATH or --points is needed")),
    };
    let lead = format!("The law of the level of detail by {}", path.display());
    let simulated = refit.setting.simulated == Some(true);
    let section = law_section::section(&refit);
    give(&args.output, &Document::of(lead, simulated, vec![section]), path, &refit)?;
    let Some(out) = &args.out else { return Ok(()) };
    let law = refit.law().map_err(|reason| unwritten(out, &reason))?;
    if let (Err(reason), Some(Rule::Smoothed)) = (&refit.joint, refit.setting.rule) {
        eprintln!(
            "{}: the law through points, as from all answers there is none: {reason}",
            out.display()
        );
    }
    let (models, count) = match &refit.joint {
        Ok(joint) => (joint.models.iter().map(|under| under.model.clone()).collect(), joint.images),
        Err(_) => {
            let points = refit.fit.iter().flat_map(|fit| &fit.points);
            let models: BTreeSet<String> =
                points.clone().filter_map(|p| p.point.model.clone()).collect();
            (models.into_iter().collect(), points.count())
        }
    };
    let Setting { r, observers, simulated, .. } = refit.setting;
    write(
        out,
        FittedParameters {
            weight: r.map(|r| Weight { r, share_won: None, epsilon }),
            law: Some(law),
            ..fitted(path, observers, models, count as u64, simulated)
        },
    )
}

fn refit_of_points(args: &Lod, path: &Path) -> anyhow::Result<Refit> {
    let Some(velocity_unit) = args.velocity_unit else {
        return Err(UsageError::from(
            "fit lod: --points needs --velocity-unit: it does not say its own",
        ));
    };
    let points = table::read_points(path)?;
    let setting = Setting {
        velocity_unit,
        frequency_unit: args.frequency_unit,
        rule: None,
        r: args.r,
        observers: None,
        simulated: None,
        unnamed: 0,
    };
    Ok(from_points(&points, setting, REPLICATES as usize, SEED))
}

/// With the ε that the models are known to be simplified with.
fn refit_of_ratings(args: &Lod, path: &Path) -> anyhow::Result<(Refit, Option<f64>)> {
    let mut known_epsilon = args.epsilon;
    let (mut ratings, mut frequencies) = read_ratings(path, args.velocity_unit)?;
    if let Some(r) = args.r {
        let rs = ratings.rs();
        if !rs.contains(&r) {
            let rs: Vec<String> = rs.iter().map(f64::to_string).collect();
            bail!("{}: r: {r}: there are ratings with r = {}", path.display(), rs.join(", "));
        }
        ratings = ratings.only_r(r);
    }
    if let Some(file) = &args.frequencies {
        frequencies = Some(table::read_frequencies(file)?);
    }
    if let Some(folder) = &args.stimuli {
        let shown = shown(path)?;
        let (measured, epsilon) =
            frequencies::measured(folder, &ratings.rs(), shown.as_ref(), args.frequency_unit)?;
        if let Some(other) = args.epsilon.filter(|other| *other != epsilon) {
            return Err(UsageError::from(format!(
                "fit lod: --epsilon: {other}: the models in {} were simplified with {epsilon}",
                folder.display()
            )));
        }
        frequencies = Some(measured);
        known_epsilon = Some(epsilon);
    }
    let Some(frequencies) = frequencies else {
        bail!(
            "{}: frequency: missing: a level of detail is a share of faces and no spatial \
             frequency; a column `frequency` in a table of ratings, --frequencies FILE or \
             --stimuli DIR is needed",
            path.display()
        );
    };
    let levels = coarsest_levels(&ratings);
    let drawn = (REPLICATES as usize, SEED);
    from_ratings(&ratings, &levels, args.rule, &frequencies, args.frequency_unit, drawn)
        .map(|refit| (refit, known_epsilon))
        .map_err(|reason| anyhow!("{}: r: {reason}; choose it with --r", path.display()))
}

/// The ratings at `path`, with their frequencies if it is a table that has them.
fn read_ratings(
    path: &Path,
    unit: Option<VelocityUnit>,
) -> anyhow::Result<(Ratings, Option<Frequencies>)> {
    if path.is_file() && table::is_rating_table(path)? {
        let Some(unit) = unit else {
            return Err(UsageError::from(
                "fit: a table of ratings needs --velocity-unit: it does not say its own",
            ));
        };
        let table = table::read_ratings(path, unit)?;
        return Ok((table.ratings, table.frequencies));
    }
    if unit.is_some_and(|unit| unit != VelocityUnit::DegreesPerSecond) {
        return Err(UsageError::from("fit: the speeds of responses are in degrees-per-second"));
    }
    let responses = responses::read(&[path])?;
    let rows: Vec<_> = responses.counted().collect();
    let ratings = Ratings::from_responses(&rows);
    Ok((ratings.map_err(|reason| anyhow!("{}: {reason}", path.display()))?, None))
}

/// The hashes of the stimuli that the rows of the study or file at `path` are about; none of a table of ratings.
fn shown(path: &Path) -> anyhow::Result<Option<BTreeSet<String>>> {
    if path.is_file() && table::is_rating_table(path)? {
        return Ok(None);
    }
    let responses = responses::read(&[path])?;
    let both = |row: &Response| [row.hash_a.clone(), row.hash_b.clone()];
    Ok(Some(responses.counted().flat_map(both).collect()))
}

fn fit_psychometric(args: &Psychometric) -> anyhow::Result<()> {
    let answers = psychometric::table::read(&args.table)?;
    let model = Model { shape: args.shape, guess: Rate::Fixed(args.guess), lapse: args.lapse };
    let found =
        psychometric::analysis::analyze(&answers, model, args.threshold, REPLICATES as usize, SEED);
    let found = found.map_err(|reason| anyhow!("{}: {reason}", args.table.display()))?;
    let lead = format!("A psychometric function by {}", args.table.display());
    let document = Document::of(lead, false, vec![psychometric::section::section(&found)]);
    give(&args.output, &document, &args.table, &found)
}

/// Prints the results, and writes the report that was asked for.
fn give(
    output: &Output,
    document: &Document,
    path: &Path,
    results: &impl serde::Serialize,
) -> anyhow::Result<()> {
    match output.json {
        true => say(&serde_json::to_string_pretty(results)?)?,
        false => say(&report::text(document))?,
    }
    if let Some(folder) = &output.report {
        let command = std::env::args_os().map(|arg| arg.to_string_lossy().into_owned());
        let command = command.collect::<Vec<_>>().join(" ");
        let title = path.display().to_string();
        let page = write_report(document, folder, &title, &BTreeMap::new(), &command)?;
        eprintln!("report: {}", page.display());
    }
    Ok(())
}

/// Fitted parameters without any.
fn fitted(
    source: &Path,
    observers: Option<usize>,
    models: Vec<String>,
    points: u64,
    simulated: Option<bool>,
) -> FittedParameters {
    FittedParameters {
        schema: 1,
        program_version: env!("CARGO_PKG_VERSION").into(),
        fitted_to: FittedTo {
            source: source.display().to_string(),
            observers: observers.map(|observers| observers as u64),
            models,
            points: Some(points),
            simulated,
        },
        weight: None,
        law: None,
    }
}

fn write(out: &Path, fitted: FittedParameters) -> anyhow::Result<()> {
    fitted.check(&out.display().to_string())?;
    write_atomically(out, fitted.to_toml()?.as_bytes())?;
    eprintln!("parameters: {}", out.display());
    Ok(())
}

fn unwritten(out: &Path, reason: &str) -> anyhow::Error {
    anyhow!("{}: not written: {reason}", out.display())
}

fn parse_velocity(text: &str) -> Result<VelocityUnit, String> {
    named(text, &VelocityUnit::ALL.map(|unit| (unit.name(), unit)))
}

fn parse_frequency(text: &str) -> Result<FrequencyUnit, String> {
    named(text, &FrequencyUnit::ALL.map(|unit| (unit.name(), unit)))
}

fn parse_rule(text: &str) -> Result<Rule, String> {
    named(text, &[("smoothed", Rule::Smoothed), ("point", Rule::Point)])
}

fn parse_shape(text: &str) -> Result<Shape, String> {
    use Shape::{Logistic, Probit, Weibull};
    named(text, &[("logistic", Logistic), ("probit", Probit), ("weibull", Weibull)])
}

/// The one of `all` that is called `text`.
pub(super) fn named<T: Copy>(text: &str, all: &[(&str, T)]) -> Result<T, String> {
    let names = || all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let found = all.iter().find(|(name, _)| *name == text);
    found.map(|(_, value)| *value).ok_or_else(|| format!("one of {} is needed", names()))
}

pub(super) fn parse_from_0(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1e6).contains(number));
    number.ok_or("a number from 0 to 1000000 is needed".into())
}

fn parse_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.0..1.0).contains(rate));
    rate.ok_or("a number from 0 and below 1 is needed".into())
}

fn parse_lapse(text: &str) -> Result<Rate, String> {
    match text {
        "fit" => Ok(Rate::Fitted([0.0, MOST_LAPSES])),
        _ => parse_rate(text).map(Rate::Fixed).map_err(|needed| format!("{needed}, or fit")),
    }
}
