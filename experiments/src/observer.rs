//! Simulated observers: they answer as a model of perception has it, so that a study can be rehearsed
//! from the first trial to the report. Their answers are marked as simulated everywhere.
//!
//! A [`SimulatedObserver`] is a sort of observer, [`Instructed`] one that knows the stimuli and the task,
//! and a [`Judge`] one of that sort in one session. The formulas are in [`model`] and [`judge`].

mod differences;
pub mod judge;
pub mod model;

pub use judge::Judge;

use crate::bradley_terry::{FitError, strengths};
use crate::design::{self, DesignError};
use crate::stimuli_set::StimulusSet;
use differences::Differences;
use indexmap::IndexMap;
use model::{Noise, Perception, Psychometric};
use shutterlab_data_schema::cohort::{Model, Observers, ResponseTime};
use shutterlab_data_schema::item_table::{self, TableError};
use shutterlab_data_schema::protocol::{Protocol, Task};
use shutterlab_data_schema::{ParticipantCode, Votes};
use shutterlab_stimuli::Stimulus;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A sort of simulated observer.
#[derive(Clone, Debug)]
pub struct SimulatedObserver {
    name: String,
    basis: Basis,
    habits: Habits,
}

/// What answers follow, whatever the stimuli are.
#[derive(Clone, Debug)]
enum Basis {
    Guess,
    Items { values: Vec<(String, f64)>, noise: Noise, false_alarm_rate: Option<f64> },
    Differences { table: Differences, function: Psychometric, best: Option<String> },
}

/// What an observer does whatever the model says; see [`Observers`].
#[derive(Clone, Copy, Debug, Default)]
struct Habits {
    lapse_rate: f64,
    fatigue: f64,
    side_bias: f64,
    not_sure_band: f64,
    response_s: ResponseTime,
    spread: f64,
}

/// A sort of simulated observer that knows the stimuli and the task.
#[derive(Clone, Debug)]
pub struct Instructed {
    perception: Perception,
    habits: Habits,
    task: Task,
    not_sure: bool,
}

/// A simulated observer cannot be made, or cannot judge the stimuli. The message begins with its name.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ObserverError {
    /// No model has these votes.
    #[error("{name}: {source}")]
    Fit {
        /// Name of the observer.
        name: String,
        /// Why.
        source: FitError,
    },
    /// A table cannot be read.
    #[error("{name}: {source}")]
    Table {
        /// Name of the observer.
        name: String,
        /// Why.
        source: TableError,
    },
    /// Not exactly one item is about a stimulus.
    #[error(
        "{name}: stimulus {stimulus}: {found} of the items {items} are about it: exactly one must be its id, or name levels of it and no others"
    )]
    Items {
        /// Name of the observer.
        name: String,
        /// Id of the stimulus.
        stimulus: String,
        /// How many items are about it.
        found: usize,
        /// The items.
        items: String,
    },
    /// The table of differences cannot be read.
    #[error("{name}: {}: {what}", file.display())]
    Differences {
        /// Name of the observer.
        name: String,
        /// The table.
        file: PathBuf,
        /// Why.
        what: String,
    },
    /// The stimuli do not make the design.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The task needs a key that is not there.
    #[error("{name}: model.{key}: none: the task {task} needs it")]
    Lacks {
        /// Name of the observer.
        name: String,
        /// The key.
        key: &'static str,
        /// The task.
        task: &'static str,
    },
    /// The best stimulus is none of the compared ones.
    #[error("{name}: model.best: {best}: none of the compared stimuli {stimuli}")]
    NoBest {
        /// Name of the observer.
        name: String,
        /// What was called the best.
        best: String,
        /// The compared stimuli.
        stimuli: String,
    },
}

impl SimulatedObserver {
    /// One who guesses: `simulated:guess`.
    pub fn guess() -> Self {
        Self { name: "guess".into(), basis: Basis::Guess, habits: Habits::default() }
    }

    /// One of `observers` people who gave `votes`, all of them alike: `simulated:NAME`. Probabilities
    /// follow the Bradley–Terry model whose expected votes are the given ones.
    ///
    /// # Errors
    /// No model has these votes; they are named.
    pub fn from_votes(name: &str, votes: &Votes, observers: u32) -> Result<Self, ObserverError> {
        let basis = of_votes(votes, observers, None)
            .map_err(|source| ObserverError::Fit { name: recorded(name), source })?;
        Ok(Self { name: name.into(), basis, habits: Habits::default() })
    }

    /// One of the sort `sort` of a cohort, whose file lies in `folder`.
    ///
    /// # Errors
    /// A table cannot be read, or no model has the votes.
    pub fn from_cohort(sort: &Observers, folder: &Path) -> Result<Self, ObserverError> {
        let name = || recorded(&sort.name);
        let unreadable = |source| ObserverError::Table { name: name(), source };
        let numbers = |file: &Path, column: &str, fits: fn(f64) -> bool, needed: &str| {
            let number = |text: &str| text.parse().ok().filter(|&number| fits(number));
            item_table::read(&folder.join(file), column, number, needed).map_err(unreadable)
        };
        let (basis, spread) = match &sort.model {
            Model::Guess {} => (Basis::Guess, 0.0),
            Model::BradleyTerry { worths, votes, observers, spread, false_alarm_rate } => {
                let rate = *false_alarm_rate;
                let basis = match (worths, votes) {
                    (None, Some(file)) => {
                        let votes = Votes::read(&folder.join(file)).map_err(unreadable)?;
                        of_votes(&votes, observers.unwrap_or(0), rate)
                            .map_err(|source| ObserverError::Fit { name: name(), source })?
                    }
                    _ => {
                        let file = worths.as_deref().unwrap_or(Path::new(""));
                        let is_worth = |worth: f64| worth.is_normal() && worth > 0.0;
                        let worths = numbers(file, "worth", is_worth, "a number above 0")?;
                        of_worths(worths, rate)
                    }
                };
                (basis, *spread)
            }
            Model::Thurstone { scale_values, sd, spread, false_alarm_rate } => {
                let noise = Noise::Normal { sd: *sd };
                let values = numbers(scale_values, "scale_value", f64::is_finite, "a number")?;
                (Basis::Items { values, noise, false_alarm_rate: *false_alarm_rate }, *spread)
            }
            Model::Psychometric {
                differences,
                measure,
                shape,
                threshold,
                slope,
                spread,
                best,
                false_alarm_rate,
            } => {
                let file = folder.join(differences);
                let table = Differences::read(&file, *measure)
                    .map_err(|what| ObserverError::Differences { name: name(), file, what })?;
                let function = Psychometric {
                    shape: *shape,
                    threshold: *threshold,
                    slope: *slope,
                    false_alarm_rate: false_alarm_rate.unwrap_or(0.0),
                };
                (Basis::Differences { table, function, best: best.clone() }, *spread)
            }
        };
        let habits = Habits {
            lapse_rate: sort.lapse_rate,
            fatigue: sort.fatigue,
            side_bias: sort.side_bias,
            not_sure_band: sort.not_sure_band,
            response_s: sort.response_s,
            spread,
        };
        Ok(Self { name: sort.name.clone(), basis, habits })
    }

    /// `simulated:NAME`, as the records have it.
    pub fn name(&self) -> String {
        recorded(&self.name)
    }

    /// Shows the observer what is compared in `protocol`: the stimuli of `set`.
    ///
    /// An item of a table is about the stimulus of that id; or, like `A4T3`, about the stimuli that have
    /// both levels, A4 and T3: a level's name begins at each capital letter.
    ///
    /// # Errors
    /// A stimulus that no item is about, or several are; two stimuli whose difference is unknown;
    /// something that the task needs is not there; or the stimuli do not make the design.
    pub fn instruct(
        &self,
        set: &StimulusSet,
        protocol: &Protocol,
    ) -> Result<Instructed, ObserverError> {
        let lacks = |key| {
            let (name, task) = (self.name(), protocol.task.name());
            ObserverError::Lacks { name, key, task }
        };
        let perception = match &self.basis {
            Basis::Guess => Perception::Guess,
            Basis::Items { values, noise, false_alarm_rate } => {
                if protocol.task == Task::SameDifferent && false_alarm_rate.is_none() {
                    return Err(lacks("false_alarm_rate"));
                }
                let values = self.values(values, set)?;
                Perception::values(values, *noise, *false_alarm_rate)
            }
            Basis::Differences { table, function, best } => {
                let best = match best {
                    None if protocol.task == Task::TwoAfc => return Err(lacks("best")),
                    None => None,
                    Some(id) => Some(self.find(id, set)?),
                };
                // In the other tasks all are compared, with one another or with the best.
                let pairs = match protocol.task {
                    Task::SameDifferent => Some(asked(protocol, set)?),
                    Task::TwoAfc | Task::Matching => None,
                };
                let is_asked = |a, b| {
                    pairs
                        .as_ref()
                        .is_none_or(|pairs| pairs.contains(&[a, b]) || pairs.contains(&[b, a]))
                };
                let between = table.between(set, is_asked).map_err(|what| {
                    ObserverError::Differences { name: self.name(), file: table.file.clone(), what }
                })?;
                let function = *function;
                Perception::Differences { between: Arc::new(between), function, best }
            }
        };
        let (task, not_sure) = (protocol.task, protocol.not_sure.is_some());
        Ok(Instructed { perception, habits: self.habits, task, not_sure })
    }

    /// The value of each compared stimulus of `set`.
    fn values(
        &self,
        items: &[(String, f64)],
        set: &StimulusSet,
    ) -> Result<Vec<f64>, ObserverError> {
        let value = |stimulus: &Stimulus| {
            let about: Vec<f64> = items
                .iter()
                .filter(|(item, _)| is_about(item, &stimulus.id, &stimulus.levels))
                .map(|(_, value)| *value)
                .collect();
            match about[..] {
                [value] => Ok(value),
                _ => {
                    let names: Vec<&str> = items.iter().map(|(name, _)| name.as_str()).collect();
                    Err(ObserverError::Items {
                        name: self.name(),
                        stimulus: stimulus.id.clone(),
                        found: about.len(),
                        items: names.join(", "),
                    })
                }
            }
        };
        (0..set.compared).map(|index| value(set.stimulus(index))).collect()
    }

    fn find(&self, id: &str, set: &StimulusSet) -> Result<usize, ObserverError> {
        (0..set.compared).find(|&index| set.stimulus(index).id == id).ok_or_else(|| {
            let ids: Vec<&str> =
                (0..set.compared).map(|index| set.stimulus(index).id.as_str()).collect();
            let (name, best) = (self.name(), id.into());
            ObserverError::NoBest { name, best, stimuli: ids.join(", ") }
        })
    }
}

impl Instructed {
    /// One of this sort, as `subject` in session `session` of `trials` trials. `seed` decides the
    /// answers.
    pub fn judge(&self, seed: u64, subject: &ParticipantCode, session: u32, trials: u32) -> Judge {
        Judge::new(self, seed, subject, session, trials)
    }
}

fn recorded(name: &str) -> String {
    format!("simulated:{name}")
}

/// The pairs that `protocol` asks for among the stimuli of `set`, whatever the order.
fn asked(protocol: &Protocol, set: &StimulusSet) -> Result<HashSet<[usize; 2]>, DesignError> {
    let trials = design::plan(protocol, &set.pool(), protocol.seed, 1)?;
    Ok(trials.iter().map(|trial| [trial.a, trial.b]).collect())
}

fn of_votes(
    votes: &Votes,
    observers: u32,
    false_alarm_rate: Option<f64>,
) -> Result<Basis, FitError> {
    let names = votes.rows.iter().map(|row| row.item.clone());
    Ok(of_worths(names.zip(strengths(votes, observers)?).collect(), false_alarm_rate))
}

fn of_worths(worths: Vec<(String, f64)>, false_alarm_rate: Option<f64>) -> Basis {
    let values = worths.into_iter().map(|(item, worth)| (item, worth.ln())).collect();
    Basis::Items { values, noise: Noise::Logistic, false_alarm_rate }
}

/// Whether an item of a table is about the stimulus `id` with these `levels`: it is the id, or names levels
/// that the stimulus has, like `A4T3`, in which each name begins with a capital letter.
pub fn is_about(item: &str, id: &str, of: &IndexMap<String, String>) -> bool {
    let mut levels: Vec<String> = vec![];
    for letter in item.chars() {
        match levels.last_mut() {
            Some(level) if !letter.is_uppercase() => level.push(letter),
            _ => levels.push(letter.into()),
        }
    }
    let has = |level: &String| of.values().any(|name| name == level);
    item == id || levels.iter().all(has)
}

#[cfg(test)]
mod tests;
