//! The command line: words in, one story per verb, one error line out.
//!
//! Results go to stdout, progress and messages to stderr. Exit status: 0 done, 1 the work failed (bad
//! files included), 2 the words were wrong.
#![expect(clippy::print_stderr, reason = "the command line is what prints")]

mod analyze;
mod bench;
mod demo;
mod devices;
mod display;
mod export;
mod fit;
mod motion_args;
mod plan;
mod progress;
mod render;
mod replicate;
mod run;
#[cfg(feature = "screen")]
mod screen;
mod simplify;
mod slurm;
mod status;
mod validate;
mod withdraw;

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

/// Motion-blur psychophysics: render stimuli, run the trials, analyse the answers.
#[derive(Debug, Parser)]
#[command(name = "shutterlab", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    Demo(demo::Args),
    Render(render::Args),
    Plan(plan::Args),
    Run(Box<run::Args>),
    Status(status::Args),
    Withdraw(withdraw::Args),
    Analyze(analyze::Args),
    Replicate(replicate::Args),
    Fit(fit::Args),
    Export(export::Args),
    Simplify(Box<simplify::Args>),
    Validate(validate::Args),
    #[cfg(feature = "screen")]
    Screen(screen::Args),
    Display(display::Args),
    Bench(bench::Args),
    Devices(devices::Args),
}

/// The words were wrong: exit status 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct UsageError(String);

impl UsageError {
    /// Any error as one of words.
    fn from(error: impl std::fmt::Display) -> anyhow::Error {
        Self(error.to_string()).into()
    }
}

/// How many: `1 frame`, `2 frames`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Prints results to stdout. A reader that has heard enough, such as `head`, is no error.
fn say(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{}", text.trim_end_matches('\n')) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let done = match cli.verb {
        Verb::Demo(args) => demo::run(&args),
        Verb::Render(args) => render::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Run(args) => run::run(&args),
        Verb::Status(args) => status::run(&args),
        Verb::Withdraw(args) => withdraw::run(&args),
        Verb::Analyze(args) => analyze::run(&args),
        Verb::Replicate(args) => replicate::run(&args),
        Verb::Fit(args) => fit::run(&args),
        Verb::Export(args) => export::run(&args),
        Verb::Simplify(args) => simplify::run(&args),
        Verb::Validate(args) => validate::run(&args),
        #[cfg(feature = "screen")]
        Verb::Screen(args) => screen::run(&args),
        Verb::Display(args) => display::run(&args),
        Verb::Bench(args) => bench::run(&args),
        Verb::Devices(args) => devices::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", one_line(&error.to_string()));
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

/// Prints help and version as they are; any other answer of the parser as one line.
fn refuse(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        return match say(&error.to_string()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(_) => ExitCode::FAILURE,
        };
    }
    if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        eprint!("{error}");
        return ExitCode::from(2);
    }
    let text = error.to_string();
    let told = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let told: Vec<&str> =
        told.filter(|line| !line.is_empty() && !line.starts_with("For more")).collect();
    eprintln!("{}", told.join(" "));
    ExitCode::from(2)
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
