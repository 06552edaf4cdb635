//! The cohort: simulated observers who rehearse an experiment, in one TOML file.

use crate::definition::{self, DefinitionError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Simulated observers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cohort {
    /// Version of this format: 1.
    pub schema: u32,
    /// Seed of all answers. What is asked in which order follows from the protocol's seed alone.
    pub seed: u64,
    /// The sorts of observers, in the order in which they enter the study.
    pub observers: Vec<Observers>,
}

/// Observers of one sort.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Observers {
    /// What the sort is called: letters, digits and hyphens. The records have it as `simulated:NAME`.
    #[schemars(extend("pattern" = "^[A-Za-z0-9-]{1,64}$"))]
    pub name: String,
    /// How many there are.
    #[schemars(range(min = 1, max = MOST))]
    pub count: u32,
    /// What their codes begin with, letters and digits; a number of four digits or more follows:
    /// `S0001`, `S0002`, …
    #[schemars(extend("pattern" = "^[A-Za-z0-9]{1,20}$"))]
    pub code_prefix: String,
    /// Probability of a lapse λ in the first trial of a session: one of the two answers, by a fair coin.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lapse_rate: f64,
    /// What is added to λ until the last trial, in equal steps.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fatigue: f64,
    /// Probability of choosing the first or left one whatever it shows; if negative, of choosing the
    /// second or right one. Without effect in the task same-different.
    #[serde(default)]
    #[schemars(range(min = -1.0, max = 1.0))]
    pub side_bias: f64,
    /// Where the protocol offers it, "not sure" is the answer while the evidence, in log-odds, is no
    /// further than this from 0.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub not_sure_band: f64,
    /// How long they take to answer.
    #[serde(default)]
    pub response_s: ResponseTime,
    /// What their answers follow.
    pub model: Model,
}

/// The distribution of response times: log-normal, whatever is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ResponseTime {
    /// The median, in seconds.
    #[schemars(range(min = 0.001, max = 3600.0))]
    pub median: f64,
    /// Standard deviation of the natural logarithm.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub log_sd: f64,
}

impl Default for ResponseTime {
    /// No finding: plausible numbers, so that files look like files.
    fn default() -> Self {
        Self { median: 1.2, log_sd: 0.4 }
    }
}

/// What observers' answers follow. Files are named from the folder of the cohort's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Model {
    /// Preferences by Bradley and Terry (1952): of two stimuli with the worths π, one is chosen with
    /// the probability π₁ / (π₁ + π₂).
    BradleyTerry {
        /// Table `item,worth` of the worths, which are above 0.
        worths: Option<PathBuf>,
        /// Table `item,votes` in place of worths: those whose expected votes these are.
        votes: Option<PathBuf>,
        /// How many observers gave the votes.
        observers: Option<u32>,
        /// Standard deviation between observers of each item's ln π.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 100.0))]
        spread: f64,
        /// How often two identical stimuli are called different; the task same-different needs it.
        #[schemars(range(min = 0.0, max = 1.0))]
        false_alarm_rate: Option<f64>,
    },
    /// Preferences by Thurstone (1927), Case V: of two stimuli with the scale values s, the first is
    /// chosen with the probability Φ((s₁ − s₂) / (σ√2)).
    Thurstone {
        /// Table `item,scale_value` of the scale values.
        scale_values: PathBuf,
        /// The discriminal dispersion σ of every stimulus, in the unit of the scale values.
        #[serde(default = "one")]
        #[schemars(range(min = 1e-9, max = 1e9))]
        sd: f64,
        /// Standard deviation between observers of each item's scale value, in the unit of the scale.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 100.0))]
        spread: f64,
        /// How often two identical stimuli are called different; the task same-different needs it.
        #[schemars(range(min = 0.0, max = 1.0))]
        false_alarm_rate: Option<f64>,
    },
    /// A psychometric function of how much the two sequences differ, as `shutterlab screen` says.
    Psychometric {
        /// The `screen.csv` of the stimuli.
        differences: PathBuf,
        /// Its column.
        measure: Measure,
        /// Form F of the function.
        shape: Shape,
        /// Its threshold α, in the unit of the difference.
        #[schemars(range(min = 1e-9, max = 1e9))]
        threshold: f64,
        /// Its slope β.
        #[schemars(range(min = 1e-9, max = 1e9))]
        slope: f64,
        /// Standard deviation between observers of ln α.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 100.0))]
        spread: f64,
        /// Id of the best stimulus: the less one differs from it the better it is. The task 2afc needs it.
        best: Option<String>,
        /// In the task same-different, how often "different" is the answer if nothing is sensed.
        #[schemars(range(min = 0.0, max = 1.0))]
        false_alarm_rate: Option<f64>,
    },
    /// Each of the two answers by a fair coin, in practice and catch trials too.
    Guess {},
}

fn one() -> f64 {
    1.0
}

/// A column of `screen.csv`, and the difference x that is made of it: 0 for identical sequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// ColorVideoVDP: x = 10 − JOD, in units of just objectionable difference.
    CvvdpJod,
    /// FLIP: x is its mean, 0 to 1.
    FlipMean,
    /// PSNR: x = 10^(−PSNR/20), the root mean square difference of code values as part of 255.
    PsnrDb,
}

/// The form of a psychometric function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// F(x) = 1 / (1 + exp(−β(x − α))), ½ at the threshold.
    Logistic,
    /// F(x) = Φ(β(x − α)), ½ at the threshold.
    Probit,
    /// F(x) = 1 − exp(−(x/α)^β), 1 − 1/e at the threshold.
    Weibull,
}

/// The most observers of a sort.
const MOST: u32 = 1_000_000;

impl Cohort {
    /// Reads and checks the cohort at `path`.
    ///
    /// # Errors
    /// As [`definition::read`] and [`Cohort::check`].
    pub fn read(path: &Path) -> Result<Self, DefinitionError> {
        let cohort: Self = definition::read(path)?;
        cohort.check(&path.display().to_string())?;
        Ok(cohort)
    }

    /// Parses and checks a cohort; `file` is what an error calls it.
    ///
    /// # Errors
    /// As [`definition::parse`] and [`Cohort::check`].
    pub fn parse(text: &str, file: &str) -> Result<Self, DefinitionError> {
        let cohort: Self = definition::parse(text, file)?;
        cohort.check(file)?;
        Ok(cohort)
    }

    /// Refuses values that no cohort can have.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        if self.observers.is_empty() {
            let allowed = "at least one sort of observers is needed";
            return Err(DefinitionError::value(file, "observers", "[]", allowed));
        }
        let (mut names, mut codes) = (HashSet::new(), HashSet::new());
        for observers in &self.observers {
            observers.check(file)?;
            if !names.insert(observers.name.to_lowercase()) {
                let allowed = "each name may come once";
                return Err(DefinitionError::value(
                    file,
                    "observers.name",
                    &observers.name,
                    allowed,
                ));
            }
            // Names of files, which some systems tell apart by their letters only.
            let twice = observers.codes().find(|code| !codes.insert(code.to_lowercase()));
            if let Some(code) = twice {
                let field = format!("observers.{}.code_prefix", observers.name);
                let allowed = format!("gives the code {code} a second time; choose another one");
                return Err(DefinitionError::value(file, field, &observers.code_prefix, allowed));
            }
        }
        Ok(())
    }
}

impl Observers {
    /// Their participants' codes.
    pub fn codes(&self) -> impl Iterator<Item = String> {
        (1..=self.count).map(|number| format!("{}{number:04}", self.code_prefix))
    }

    fn check(&self, file: &str) -> Result<(), DefinitionError> {
        let name = &self.name;
        let refuse = |key: &str, value: &dyn ToString, allowed: &str| {
            let field = format!("observers.{name}.{key}");
            Err(DefinitionError::value(file, field, value.to_string(), allowed))
        };
        let fits = |text: &str, longest: usize, extra: &str| {
            (1..=longest).contains(&text.len())
                && text.chars().all(|c| c.is_ascii_alphanumeric() || extra.contains(c))
        };
        if !fits(name, 64, "-") {
            let allowed = "1 to 64 letters, digits and hyphens are allowed";
            return Err(DefinitionError::value(
                file,
                "observers.name",
                format!("{name:?}"),
                allowed,
            ));
        }
        if !fits(&self.code_prefix, 20, "") {
            let allowed = "1 to 20 letters and digits are allowed";
            return refuse("code_prefix", &format!("{:?}", self.code_prefix), allowed);
        }
        if !(1..=MOST).contains(&self.count) {
            return refuse("count", &self.count, &format!("1 to {MOST} are allowed"));
        }
        let ResponseTime { median, log_sd } = self.response_s;
        let habits = [
            ("lapse_rate", self.lapse_rate, 0.0..=1.0),
            ("fatigue", self.fatigue, 0.0..=1.0),
            ("side_bias", self.side_bias, -1.0..=1.0),
            ("not_sure_band", self.not_sure_band, 0.0..=100.0),
            ("response_s.median", median, 0.001..=3600.0),
            ("response_s.log_sd", log_sd, 0.0..=2.0),
        ];
        for (key, value, allowed) in habits.into_iter().chain(self.model.numbers()) {
            if !allowed.contains(&value) {
                let (start, end) = allowed.into_inner();
                return refuse(key, &value, &format!("{start} to {end} is allowed"));
            }
        }
        if self.lapse_rate + self.fatigue > 1.0 {
            let allowed = format!("with lapse_rate {} at most 1 together", self.lapse_rate);
            return refuse("fatigue", &self.fatigue, &allowed);
        }
        if let Some(rate) = self.model.false_alarm_rate()
            && !(0.0 < rate && rate < 1.0)
        {
            return refuse("model.false_alarm_rate", &rate, "above 0 and below 1 is allowed");
        }
        if let Model::BradleyTerry { worths, votes, observers, .. } = &self.model {
            if worths.is_some() == votes.is_some() {
                let found = if votes.is_some() { "both" } else { "neither" };
                return refuse("model", &found, "either `worths` or `votes` is needed");
            }
            match (votes, observers) {
                (Some(_), None | Some(0)) => {
                    let found = observers.map_or("none".into(), |count| count.to_string());
                    let allowed = "how many gave the votes is needed, at least 1";
                    return refuse("model.observers", &found, allowed);
                }
                (None, Some(count)) => {
                    return refuse("model.observers", count, "belongs to `votes` only");
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Model {
    /// How often identical stimuli are called different, if that is said.
    pub fn false_alarm_rate(&self) -> Option<f64> {
        match self {
            Self::BradleyTerry { false_alarm_rate, .. }
            | Self::Thurstone { false_alarm_rate, .. }
            | Self::Psychometric { false_alarm_rate, .. } => *false_alarm_rate,
            Self::Guess {} => None,
        }
    }

    /// Its numbers, with their keys and what is allowed.
    fn numbers(&self) -> Vec<(&'static str, f64, RangeInclusive<f64>)> {
        let spread = |spread: &f64| ("model.spread", *spread, 0.0..=100.0);
        let positive = |key: &'static str, value: &f64| (key, *value, 1e-9..=1e9);
        match self {
            Self::BradleyTerry { spread: sd, .. } => vec![spread(sd)],
            Self::Thurstone { sd, spread: between, .. } => {
                vec![positive("model.sd", sd), spread(between)]
            }
            Self::Psychometric { threshold, slope, spread: between, .. } => vec![
                positive("model.threshold", threshold),
                positive("model.slope", slope),
                spread(between),
            ],
            Self::Guess {} => vec![],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "schema = 1\nseed = 1\n[[observers]]\n";

    fn error(text: &str) -> String {
        Cohort::parse(&format!("{HEAD}{text}"), "c.toml").unwrap_err().to_string()
    }

    #[test]
    fn bad_values_are_refused_by_file_and_field() {
        let sort = |changed: &str, model: &str| {
            let keys = ["name = \"a\"", "count = 2", "code_prefix = \"S\""];
            let key = changed.split(' ').next().unwrap();
            let kept = keys.iter().filter(|line| !line.starts_with(key));
            let kept: Vec<&str> = kept.copied().chain([changed]).collect();
            format!("{}\nmodel = {{ {model} }}\n", kept.join("\n"))
        };
        let guess = "kind = \"guess\"";
        for (changed, expected) in [
            ("name = \"\"", "c.toml: observers.name: \"\": 1 to 64 letters"),
            ("name = \"a b\"", "c.toml: observers.name: \"a b\""),
            ("code_prefix = \"../\"", "c.toml: observers.a.code_prefix: \"../\": 1 to 20"),
            ("count = 0", "c.toml: observers.a.count: 0: 1 to 1000000"),
            ("lapse_rate = 1.1", "c.toml: observers.a.lapse_rate: 1.1: 0 to 1 is allowed"),
            ("lapse_rate = nan", "c.toml: observers.a.lapse_rate: NaN"),
            ("fatigue = -0.1", "c.toml: observers.a.fatigue: -0.1"),
            ("side_bias = 2.0", "c.toml: observers.a.side_bias: 2: -1 to 1"),
            ("not_sure_band = -1.0", "c.toml: observers.a.not_sure_band: -1"),
            ("response_s = { median = 0.0 }", "c.toml: observers.a.response_s.median: 0"),
            ("response_s = { log_sd = inf }", "c.toml: observers.a.response_s.log_sd: inf"),
            ("lapse_rte = 0.1", "c.toml: line 7: unknown field `lapse_rte`"),
        ] {
            let error = error(&sort(changed, guess));
            assert!(error.starts_with(expected), "{changed}: {error}");
        }
        let both = sort("lapse_rate = 0.6\nfatigue = 0.6", guess);
        assert!(error(&both).starts_with("c.toml: observers.a.fatigue: 0.6: with lapse_rate 0.6"));
        for (model, expected) in [
            ("kind = \"bradley\"", "unknown variant `bradley`"),
            ("kind = \"guess\", spread = 1.0", "unknown field `spread`"),
            ("kind = \"bradley-terry\"", "observers.a.model: neither: either `worths` or `votes`"),
            (
                "kind = \"bradley-terry\", votes = \"v.csv\", worths = \"w.csv\"",
                "observers.a.model: both",
            ),
            ("kind = \"bradley-terry\", votes = \"v.csv\"", "observers.a.model.observers: none"),
            (
                "kind = \"bradley-terry\", worths = \"w.csv\", observers = 2",
                "observers.a.model.observers: 2: belongs to `votes`",
            ),
            (
                "kind = \"bradley-terry\", worths = \"w.csv\", spread = -1.0",
                "observers.a.model.spread: -1",
            ),
            (
                "kind = \"bradley-terry\", worths = \"w.csv\", false_alarm_rate = 1.0",
                "observers.a.model.false_alarm_rate: 1: above 0 and below 1",
            ),
            ("kind = \"thurstone\"", "missing field `scale_values`"),
            ("kind = \"thurstone\", scale_values = \"s.csv\", sd = 0.0", "observers.a.model.sd: 0"),
            (
                "kind = \"psychometric\", differences = \"d.csv\", measure = \"jod\", \
                 shape = \"probit\", threshold = 1.0, slope = 1.0",
                "unknown variant `jod`",
            ),
            (
                "kind = \"psychometric\", differences = \"d.csv\", measure = \"cvvdp_jod\", \
                 shape = \"probit\", threshold = 0.0, slope = 1.0",
                "observers.a.model.threshold: 0",
            ),
        ] {
            let error = error(&sort("count = 2", model));
            assert!(error.starts_with("c.toml: ") && error.contains(expected), "{model}: {error}");
        }
    }

    #[test]
    fn no_code_and_no_name_comes_twice() {
        let sort = |name: &str, prefix: &str, count: u32| {
            format!(
                "[[observers]]\nname = \"{name}\"\ncount = {count}\ncode_prefix = \"{prefix}\"\n\
                 model = {{ kind = \"guess\" }}\n"
            )
        };
        let parse = |sorts: &[String]| {
            let text = format!("schema = 1\nseed = 1\n{}", sorts.concat());
            Cohort::parse(&text, "c.toml").map_err(|error| error.to_string())
        };
        let good = parse(&[sort("a", "S", 2), sort("b", "T", 1)]).unwrap();
        assert_eq!(good.observers[0].codes().collect::<Vec<_>>(), ["S0001", "S0002"]);
        let error = parse(&[sort("a", "S", 2), sort("A", "T", 1)]).unwrap_err();
        assert_eq!(error, "c.toml: observers.name: A: each name may come once");
        // S10001 is both the 10 001st of S and the first of S1.
        let error = parse(&[sort("a", "S", 10_001), sort("b", "s1", 1)]).unwrap_err();
        assert!(error.starts_with("c.toml: observers.b.code_prefix: s1: gives the code s10001"));
        assert!(parse(&[sort("a", "S", 10_000), sort("b", "s1", 1)]).is_ok());
        let error = Cohort::parse("schema = 1\nseed = 1\nobservers = []", "c.toml").unwrap_err();
        assert!(error.to_string().starts_with("c.toml: observers: []: at least one"), "{error}");
    }
}
