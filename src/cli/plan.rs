//! `shutterlab plan`: how many observers for which power.

use super::{UsageError, say};
use serde_json::json;
use shutterlab_analysis::planning::{AskedPair, Assumptions, Design, Plan, plan, sections};
use shutterlab_analysis::report::terminal;
use shutterlab_data_schema::{Protocol, item_table};
use shutterlab_experiments::design::{self, DesignReport, Part, Pool, Trial};
use shutterlab_experiments::observer::is_about;
use shutterlab_experiments::protocols;
use shutterlab_experiments::stimuli_set::StimulusSet;
use std::path::{Path, PathBuf};

/// How long a film is taken to be when none is rendered: those of the shipped grids of the thesis.
const FILM_S: f64 = 4.0;

/// Tell what a study can find, against the number of observers, before the first of them comes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A shipped protocol or a protocol file
    protocol: String,
    /// Folder of the rendered sequences, for their length and the levels that the protocol does not name;
    /// without it films of 4 s, and one level of each axis that is not named, are assumed
    #[arg(long, value_name = "DIR")]
    stimuli: Option<PathBuf>,
    /// Numbers of observers
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = Assumptions::default().observers)]
    observers: Vec<u64>,
    /// Level of significance
    #[arg(long, default_value_t = Assumptions::default().alpha)]
    alpha: f64,
    /// The true preference between two stimuli, or share of right answers, that should be found
    #[arg(long, value_name = "P", default_value_t = Assumptions::default().effect)]
    effect: f64,
    /// The preference for each stimulus over the next that simulated observers have
    #[arg(long, value_name = "P", default_value_t = Assumptions::default().step)]
    step: f64,
    /// The worths that simulated observers have instead (CSV with the columns item and worth)
    #[arg(long, value_name = "FILE", conflicts_with = "step")]
    worths: Option<PathBuf>,
    /// How much people differ: standard deviation of the logarithm of each worth
    #[arg(long, value_name = "SD", default_value_t = Assumptions::default().spread)]
    spread: f64,
    /// Number of simulated studies
    #[arg(long, value_name = "N", default_value_t = Assumptions::default().studies)]
    studies: u64,
    /// Seed of the simulation
    #[arg(long, value_name = "N", default_value_t = Assumptions::default().seed)]
    seed: u64,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let is_file = Path::new(&args.protocol).exists();
    let protocol = protocols::load(&args.protocol)
        .map_err(|error| if is_file { error.into() } else { UsageError::from(error) })?;
    let (pool, film_s) = match &args.stimuli {
        Some(folder) => {
            let set = StimulusSet::open(&protocol, folder)?;
            (set.pool(), set.sequence_s())
        }
        None => (Pool::named_by(&protocol), FILM_S),
    };
    let trials = design::plan(&protocol, &pool, protocol.seed, 1)?;
    let report = DesignReport::new(&protocol, &trials, film_s);
    let design = asked(&protocol, &pool, &trials, &report);
    let mut observers = args.observers.clone();
    observers.sort_unstable();
    observers.dedup();
    let assumptions = Assumptions {
        observers,
        alpha: args.alpha,
        effect: args.effect,
        step: args.step,
        worths: args.worths.as_deref().map(|file| log_worths(file, &design)).transpose()?,
        spread: args.spread,
        studies: args.studies,
        seed: args.seed,
    };
    let plan = plan(&design, &assumptions).map_err(UsageError::from)?;
    match args.json {
        true => {
            let (name, title) = (&protocol.name, &protocol.title);
            let json = json!({ "protocol": name, "title": title, "session": report, "plan": plan });
            say(&serde_json::to_string_pretty(&json)?)
        }
        false => say(&text(&protocol, &report, &plan, args.stimuli.is_none())),
    }
}

/// What each observer is asked.
fn asked(protocol: &Protocol, pool: &Pool, trials: &[Trial], report: &DesignReport) -> Design {
    let mut pairs: Vec<AskedPair> = Vec::new();
    for trial in trials.iter().filter(|trial| trial.part == Part::Test) {
        match pairs.iter_mut().find(|pair| (pair.a, pair.b) == (trial.a, trial.b)) {
            Some(pair) => pair.times += 1,
            None => pairs.push(AskedPair { a: trial.a, b: trial.b, times: 1 }),
        }
    }
    pairs.sort_unstable_by_key(|pair| (pair.a, pair.b));
    let fullest = pool.levels.iter().max_by_key(|levels| levels.len());
    let axes: Vec<&String> = fullest.into_iter().flat_map(|levels| levels.keys()).collect();
    let stimuli = pool.levels.iter().map(|levels| {
        // The original of a model has no r.
        let level = |axis: &String| levels.get(axis).cloned().unwrap_or("none".into());
        axes.iter().map(|&axis| (axis.clone(), level(axis))).collect()
    });
    let stimuli = stimuli.collect();
    Design { task: protocol.task, stimuli, pairs, minutes: report.seconds / 60.0 }
}

/// The logarithm of the worth of each stimulus, from a table of items as simulated observers have it.
fn log_worths(file: &Path, design: &Design) -> anyhow::Result<Vec<f64>> {
    let worth =
        |text: &str| text.parse().ok().filter(|worth: &f64| worth.is_normal() && *worth > 0.0);
    let table = item_table::read(file, "worth", worth, "a number above 0")?;
    let of = |place: usize| {
        let levels = design.stimuli[place].iter().cloned().collect();
        let name = design.name(place);
        let about: Vec<f64> = table
            .iter()
            .filter(|(item, _)| is_about(item, &name, &levels))
            .map(|(_, worth)| worth.ln())
            .collect();
        match about[..] {
            [worth] => Ok(worth),
            _ => anyhow::bail!(
                "{}: {} items are about {name}: exactly one is needed for each stimulus",
                file.display(),
                about.len()
            ),
        }
    };
    (0..design.stimuli.len()).map(of).collect()
}

fn text(protocol: &Protocol, report: &DesignReport, plan: &Plan, assumed: bool) -> String {
    let mut said =
        vec![format!("{}: {}", protocol.name, protocol.title), format!("Each session: {report}.")];
    if assumed {
        said.push(format!(
            "Nothing rendered was looked at: films of {FILM_S} s and one level of each axis that the protocol \
             does not name are assumed."
        ));
    }
    said.push(plan.advice.clone());
    let said: String = said.iter().map(|sentence| terminal::paragraph(sentence, "")).collect();
    let parts: Vec<String> = sections(plan).iter().map(terminal::section).collect();
    format!("{said}\n{}", parts.join("\n"))
}
